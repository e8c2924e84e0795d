//! The affine map from index space (voxels) to world space.
//!
//! world = linear · index + translation. Integer index coordinates are voxel centres.

use glam::DMat3;
use glam::DVec3;

use crate::Error;

/// Steps along the axes may miss those of a cube by this part of it: a matrix in f32 has 6e-8, a
/// product of a few of them some times that.
const CUBE_TOLERANCE: f64 = 1e-6;

/// An invertible affine map from index space to world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    linear: DMat3,
    inverse: DMat3,
    translation: DVec3,
}

impl Transform {
    /// Cubic voxels of that edge length, with index (0, 0, 0) at `translation` in world space.
    ///
    /// # Panics
    /// If the voxel size is not a finite number above zero, or the translation is not finite.
    pub fn uniform_scale_translate(voxel_size: f64, translation: DVec3) -> Self {
        let sound = voxel_size.is_finite() && voxel_size > 0.0 && translation.is_finite();
        assert!(
            sound,
            "a voxel size above zero and a finite translation are needed"
        );
        let linear = DMat3::from_diagonal(DVec3::splat(voxel_size));
        let inverse = DMat3::from_diagonal(DVec3::splat(1.0 / voxel_size));
        Self {
            linear,
            inverse,
            translation,
        }
    }

    /// Any invertible affine map.
    ///
    /// # Errors
    /// [`Error::SingularTransform`] if the linear part is not invertible or anything is not finite.
    pub fn affine(linear: DMat3, translation: DVec3) -> Result<Self, Error> {
        let determinant = linear.determinant();
        let scale = DVec3::new(linear.x_axis.x, linear.y_axis.y, linear.z_axis.z);
        let inverse = if linear == DMat3::from_diagonal(scale) {
            DMat3::from_diagonal(1.0 / scale)
        } else {
            linear.inverse()
        };
        let sound = determinant != 0.0 && inverse.is_finite() && translation.is_finite();
        if !(sound && determinant.is_finite()) {
            return Err(Error::SingularTransform { determinant });
        }
        Ok(Self {
            linear,
            inverse,
            translation,
        })
    }

    /// World position of a position in index space.
    pub fn index_to_world(&self, index: DVec3) -> DVec3 {
        self.linear * index + self.translation
    }

    /// Position in index space of a world position.
    pub fn world_to_index(&self, world: DVec3) -> DVec3 {
        self.inverse * (world - self.translation)
    }

    /// The linear part: its columns are the world steps of one voxel along each index axis.
    pub fn linear(&self) -> DMat3 {
        self.linear
    }

    /// World position of index (0, 0, 0).
    pub fn translation(&self) -> DVec3 {
        self.translation
    }

    /// Lengths of the world steps of one voxel along each index axis.
    pub fn voxel_size(&self) -> DVec3 {
        DVec3::from(
            self.linear
                .to_cols_array_2d()
                .map(|axis| DVec3::from(axis).length()),
        )
    }

    /// The scale along each axis, if the linear part does nothing but scale.
    pub(crate) fn diagonal(&self) -> Option<DVec3> {
        let linear = self.linear;
        let scale = DVec3::new(linear.x_axis.x, linear.y_axis.y, linear.z_axis.z);
        (linear == DMat3::from_diagonal(scale)).then_some(scale)
    }

    /// The edge length in units of the world, if voxels are axis-parallel cubes with no mirrored axis, but for the
    /// roundoff of matrices in f32.
    pub fn uniform_voxel_size(&self) -> Option<f64> {
        let size = self.linear.x_axis.x;
        let skew = self.linear - DMat3::from_diagonal(DVec3::splat(size));
        let skew = skew.to_cols_array().into_iter().map(f64::abs);
        let cubic = size > 0.0 && skew.fold(0.0, f64::max) <= CUBE_TOLERANCE * size;
        cubic.then_some(size)
    }
}
