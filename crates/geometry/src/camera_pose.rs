//! Where a camera stands and how it is turned.
//!
//! world = R camera + position,  R = R_y(-azimuth) R_x(elevation) R_z(-roll)
//!
//! The columns of `R` are the camera's right, up and backwards in the world (y up, north -z): every
//! camera looks along its -z. From a program's camera-to-world matrix `M` (column vectors, position in
//! the last column): R and position are M's where y is up there; where z is up (x east, y north, z up),
//! (x, y, z) there is (x, z, -y) here.

use glam::DMat3;
use glam::DMat4;
use glam::DQuat;
use glam::DVec3;
use niji_radiometry::Radians;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::error::Error;

/// How far the axes of a matrix may be from perpendicular unit vectors: programs print f32 with few
/// digits. What is nearer is made exact.
const AXES_TOLERANCE: f64 = 1e-3;

/// An optical axis nearer to the vertical than this is vertical.
const ROUNDING: f64 = 1e-14;

/// Which axis points up in a file or a program's world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Up {
    /// y, and north is -z: as in glTF, Houdini, Nuke and Maya.
    #[default]
    Y,
    /// z, and north is y: as in Blender and most STL files.
    Z,
}

impl Up {
    /// The matrix that takes such a world to one with y up and −z north.
    #[must_use]
    pub fn to_y_up(self) -> DMat3 {
        match self {
            Self::Y => DMat3::IDENTITY,
            Self::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        }
    }
}

/// Where a camera stands and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    position: DVec3,
    /// Columns: right, up, backwards.
    axes: DMat3,
}

impl CameraPose {
    /// A camera at `position` (m) whose optical axis has an azimuth (clockwise from north) and an
    /// elevation above the horizon, rolled about it, positive where its right side goes down.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn looking(
        position: DVec3,
        [azimuth, elevation, roll]: [Radians; 3],
    ) -> Result<Self, Error> {
        let angles = [azimuth.0, elevation.0, roll.0];
        if !position.is_finite() || angles.iter().any(|angle| !angle.is_finite()) {
            return Err(Error::NotFinite);
        }
        let axes = DMat3::from_rotation_y(-azimuth.0)
            * DMat3::from_rotation_x(elevation.0)
            * DMat3::from_rotation_z(-roll.0);
        Ok(Self { position, axes })
    }

    /// The pose in a camera-to-world matrix for column vectors, in metres: Blender's
    /// `matrix_world`, for example.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::MatrixIsTransposed`] for a position in the last row;
    /// [`Error::MatrixIsProjective`] for a last row other than 0, 0, 0, 1; [`Error::MatrixScales`] and
    /// [`Error::MatrixMirrors`] for axes that are not those of a rotation.
    pub fn from_matrix(camera_to_world: DMat4, up: Up) -> Result<Self, Error> {
        if !camera_to_world.is_finite() {
            return Err(Error::NotFinite);
        }
        let last_row = camera_to_world.row(3);
        if last_row.truncate().length() > 0.0 && camera_to_world.w_axis.truncate() == DVec3::ZERO {
            return Err(Error::MatrixIsTransposed);
        }
        if last_row.to_array() != [0.0, 0.0, 0.0, 1.0] {
            let found = last_row.to_array();
            return Err(Error::MatrixIsProjective { found });
        }
        let axes = DMat3::from_mat4(camera_to_world);
        check_rotation(axes)?;
        let to_here = up.to_y_up();
        let axes = DMat3::from_quat(DQuat::from_mat3(&(to_here * axes)).normalize());
        let position = to_here * camera_to_world.w_axis.truncate();
        Ok(Self { position, axes })
    }

    /// Azimuth, elevation and roll of [`CameraPose::looking`]; straight up or down, where only their
    /// sum or difference counts, the roll is 0.
    #[must_use]
    pub fn angles(&self) -> [Radians; 3] {
        let (right, forward) = (self.axes.x_axis, self.forward());
        let level = forward.x.hypot(forward.z);
        let elevation_rad = forward.y.atan2(level);
        if level < ROUNDING {
            return [right.z.atan2(right.x), elevation_rad, 0.0].map(Radians);
        }
        let azimuth_rad = forward.x.atan2(-forward.z);
        let unrolled_right = DVec3::new(azimuth_rad.cos(), 0.0, azimuth_rad.sin());
        let unrolled_up = unrolled_right.cross(forward);
        let roll_rad = (-right.dot(unrolled_up)).atan2(right.dot(unrolled_right));
        [azimuth_rad, elevation_rad, roll_rad].map(Radians)
    }

    /// Position of the eye in metres.
    #[must_use]
    #[inline]
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Unit vector along the optical axis.
    #[must_use]
    pub fn forward(&self) -> DVec3 {
        -self.axes.z_axis
    }

    /// A direction of the camera's frame (x right, y up, z backwards) in the world.
    #[inline]
    pub(crate) fn to_world(self, in_camera: DVec3) -> DVec3 {
        self.axes * in_camera
    }

    /// A direction of the world in the camera's frame.
    pub(crate) fn to_camera(self, in_world: DVec3) -> DVec3 {
        self.axes.transpose() * in_world
    }

    /// The matrix that takes points of the world to the camera's frame.
    #[must_use]
    pub fn world_to_camera(&self) -> DMat4 {
        let rotation = self.axes.transpose();
        DMat4::from_mat3(rotation) * DMat4::from_translation(-self.position)
    }
}

fn check_rotation(axes: DMat3) -> Result<(), Error> {
    let product = axes.transpose() * axes;
    if !product.abs_diff_eq(DMat3::IDENTITY, AXES_TOLERANCE) {
        let lengths = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length);
        return Err(Error::MatrixScales { lengths });
    }
    if axes.determinant() < 0.0 {
        return Err(Error::MatrixMirrors);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looking(azimuth_deg: f64, elevation_deg: f64, roll_deg: f64) -> CameraPose {
        let angles = [azimuth_deg, elevation_deg, roll_deg].map(Radians::from_degrees);
        CameraPose::looking(DVec3::new(1.0, 2.0, 3.0), angles).unwrap()
    }

    fn distance(a: &CameraPose, b: &CameraPose) -> f64 {
        let axes = a.axes - b.axes;
        let columns = [
            axes.x_axis,
            axes.y_axis,
            axes.z_axis,
            a.position - b.position,
        ];
        columns.map(DVec3::length).into_iter().fold(0.0, f64::max)
    }

    #[test]
    fn the_inverse_of_world_to_camera_gives_the_pose_back() {
        let pose = looking(123.0, 45.0, -30.0);
        let back = CameraPose::from_matrix(pose.world_to_camera().inverse(), Up::Y).unwrap();
        assert!(distance(&pose, &back) < 1e-14);
    }

    /// A camera of Blender at (1, -3, 2) with rotation X = 90°, Z = -70° looks level at azimuth 70°;
    /// `matrix_world` as Blender prints it.
    #[test]
    fn a_camera_of_blender_looks_where_it_looks_there() {
        let rows = [
            [0.3420, 0.0, -0.9397, 1.0],
            [-0.9397, 0.0, -0.3420, -3.0],
            [0.0, 1.0, 0.0, 2.0],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let matrix = DMat4::from_cols_array_2d(&rows).transpose();
        let pose = CameraPose::from_matrix(matrix, Up::Z).unwrap();
        // The four digits of the matrix, 2e-5.
        assert!(distance(&pose, &looking(70.0, 0.0, 0.0)) < 1e-4);
        assert!((pose.axes.determinant() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn angles_give_the_pose_back() {
        for azimuth_deg in [-170.0, 0.0, 45.0, 123.0] {
            for elevation_deg in [-90.0, -89.999, -30.0, 0.0, 60.0, 90.0] {
                for roll_deg in [-160.0, 0.0, 17.0] {
                    let pose = looking(azimuth_deg, elevation_deg, roll_deg);
                    let back = CameraPose::looking(pose.position, pose.angles()).unwrap();
                    // Near the vertical azimuth and roll err together, not the pose; measured 3e-16.
                    assert!(distance(&pose, &back) < 1e-14, "{pose:?}");
                }
            }
        }
    }

    #[test]
    fn matrices_that_are_no_pose_are_refused_and_told_why() {
        let sound = looking(10.0, 20.0, 30.0).world_to_camera().inverse();
        let from = |matrix: DMat4| CameraPose::from_matrix(matrix, Up::Y).unwrap_err();
        assert_eq!(from(sound.transpose()), Error::MatrixIsTransposed);
        let scaled = sound * DMat4::from_scale(DVec3::new(1.0, 2.0, 1.0));
        assert!(matches!(from(scaled), Error::MatrixScales { lengths } if lengths[1] > 1.99));
        let mirrored = sound * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert_eq!(from(mirrored), Error::MatrixMirrors);
        let mut projective = sound;
        projective.z_axis.w = -1.0;
        assert!(matches!(from(projective), Error::MatrixIsProjective { .. }));
        let mut unfinished = sound;
        unfinished.w_axis.x = f64::NAN;
        assert_eq!(from(unfinished), Error::NotFinite);
        assert!(matches!(
            from(DMat4::ZERO),
            Error::MatrixIsProjective { .. }
        ));
    }
}
