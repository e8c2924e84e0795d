//! The cells of several modes along a ray, merged.
//!
//! Each mode has its lattice, and a lattice its own coarse cells: a piece lies between two faces of any
//! of them. Its lanes are those of the cells it is a part of, as polynomials of the distance the same.

use glam::Vec4;
use niji_dropfield::Bricks;
use niji_dropfield::Interpolation;
use niji_dropfield::Segments;
use niji_geometry::Ray;

use crate::cell_cubics::cubics_through_samples;
use crate::cell_cubics::whole_cubic;
use crate::lane_cubic::LaneCubic;
use crate::lit_drops::finest_voxel_m;
use crate::piece::Piece;
use crate::stretch::ThinCell;

/// Faces this part of the smallest voxel apart are one: modes that share a lattice give its faces up to
/// rounding.
const SAME_FACE: f64 = 1e-9;

/// Pieces of a ray through several modes.
pub(crate) struct MergedCells<'a> {
    modes: Vec<ModeCells<'a>>,
    /// Where the next piece begins (m).
    from_m: f64,
    /// Distance of faces that are one (m).
    same_face_m: f64,
    /// Lanes of the modes that have drops in the piece.
    lanes: Vec<LaneCubic>,
    /// Of each mode, if it has drops in the piece.
    thin: Vec<Option<ThinCell>>,
}

/// A piece of a ray between faces of any mode.
pub(crate) struct MergedPiece<'a> {
    /// Of the modes that have drops in it.
    pub(crate) piece: Piece<'a>,
    /// What each mode, if it has drops in it, would add to a stretch.
    pub(crate) thin: &'a [Option<ThinCell>],
    /// Relative error of its moments.
    pub(crate) error: f32,
}

impl<'a> MergedCells<'a> {
    /// The pieces within a range of distances, by cells that err by no more than `relative_error` where
    /// they are coarse.
    pub(crate) fn new(
        modes: &'a [Bricks],
        ray: &Ray,
        range_m: (f64, f64),
        relative_error: f64,
    ) -> Self {
        let voxel_m = finest_voxel_m(modes);
        Self {
            modes: modes
                .iter()
                .map(|mode| ModeCells::new(mode, ray, range_m, relative_error))
                .collect(),
            from_m: range_m.0,
            same_face_m: SAME_FACE * voxel_m,
            lanes: Vec::with_capacity(modes.len()),
            thin: Vec::with_capacity(modes.len()),
        }
    }

    /// The next piece with drops; none at the end.
    pub(crate) fn next_piece(&mut self) -> Option<MergedPiece<'_>> {
        loop {
            let start_m = self.from_m;
            let reached_m = start_m + self.same_face_m;
            let mut end_m = f64::INFINITY;
            for mode in &mut self.modes {
                mode.go_on_to(reached_m);
                end_m = end_m.min(mode.next_face_m(reached_m));
            }
            if end_m == f64::INFINITY {
                return None;
            }
            self.from_m = end_m;
            let length_m = end_m - start_m;
            self.lanes.clear();
            self.thin.clear();
            let (mut depth, mut error) = (0.0, 0.0);
            for mode in &self.modes {
                let mut of_mode = None;
                if mode.enter_m <= reached_m {
                    let lanes = mode.between(start_m, end_m);
                    let thin = ThinCell::new(start_m, length_m, &lanes, mode.error);
                    if thin.depth > 0.0 {
                        depth += thin.depth;
                        error += thin.depth * f64::from(mode.error);
                        self.lanes.push(lanes);
                        of_mode = Some(thin);
                    }
                }
                self.thin.push(of_mode);
            }
            if depth > 0.0 {
                return Some(MergedPiece {
                    piece: Piece::new(start_m, length_m, &self.lanes),
                    thin: &self.thin,
                    error: (error / depth) as f32,
                });
            }
        }
    }
}

/// The cells of a mode along a ray, with the one in hand as a cubic.
struct ModeCells<'a> {
    interpolation: Interpolation,
    segments: Segments<'a>,
    /// Where the ray enters and leaves the cell or the part in hand (m); infinite at the end.
    enter_m: f64,
    leave_m: f64,
    lanes: LaneCubic,
    /// Relative error of its moments.
    error: f32,
    /// The part behind it of the same cell.
    behind: Option<LaneCubic>,
}

impl<'a> ModeCells<'a> {
    fn new(mode: &'a Bricks, ray: &Ray, range_m: (f64, f64), relative_error: f64) -> Self {
        let mut cells = Self {
            interpolation: mode.interpolation(),
            segments: mode.coarse_segments(ray.origin, ray.direction, range_m, relative_error),
            enter_m: f64::NEG_INFINITY,
            leave_m: f64::NEG_INFINITY,
            lanes: LaneCubic::new([Vec4::ZERO; 4]),
            error: 0.0,
            behind: None,
        };
        cells.advance();
        cells
    }

    /// Pass what ends before a distance.
    #[inline]
    fn go_on_to(&mut self, distance_m: f64) {
        while self.leave_m <= distance_m {
            self.advance();
        }
    }

    fn advance(&mut self) {
        if let Some(lanes) = self.behind.take() {
            let length_m = self.leave_m - self.enter_m;
            (self.enter_m, self.leave_m) = (self.leave_m, self.leave_m + length_m);
            self.lanes = lanes;
            return;
        }
        let Some(segment) = self.segments.next() else {
            (self.enter_m, self.leave_m) = (f64::INFINITY, f64::INFINITY);
            return;
        };
        (self.enter_m, self.leave_m) = (segment.t_enter, segment.t_exit);
        match self.interpolation {
            Interpolation::Moments => (self.lanes, self.error) = whole_cubic(&segment),
            Interpolation::RadiusDensity => {
                let [first, second] = cubics_through_samples(&segment);
                self.leave_m = segment.t_enter.midpoint(segment.t_exit);
                (self.lanes, self.behind) = (first, Some(second));
            }
        }
    }

    /// The face where the cell that the ray is in ends, or the next one begins (m).
    #[inline]
    fn next_face_m(&self, reached_m: f64) -> f64 {
        if self.enter_m <= reached_m {
            self.leave_m
        } else {
            self.enter_m
        }
    }

    /// The lanes between two distances inside the cell.
    #[inline]
    fn between(&self, start_m: f64, end_m: f64) -> LaneCubic {
        let per_m = 1.0 / (self.leave_m - self.enter_m);
        let start = ((start_m - self.enter_m) * per_m).max(0.0);
        let end = ((end_m - self.enter_m) * per_m).min(1.0);
        self.lanes.part(start as f32, (end - start) as f32)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use niji_dropfield::DropMode;
    use niji_dropfield::Drops;
    use niji_dropfield::GridBox;

    use super::*;

    /// A box of drops from `min` on, in voxels of 1/n of its size; more of them where x is large.
    fn mode(min: DVec3, size: f64, n: f64, interpolation: Interpolation) -> Bricks {
        let grid = GridBox {
            min,
            max: min + size,
            voxel_m: size / n,
        };
        let drops = |point: DVec3| Drops {
            number_density_m3: (1e5 * (2.0 + (0.3 * point.x).sin())) as f32,
            effective_radius_m: (1e-4 * (1.0 + 0.02 * (point.y - min.y))) as f32,
            effective_variance: 0.1,
        };
        let mode = DropMode::from_fn("", &grid, drops).unwrap();
        Bricks::build(&mode, interpolation).unwrap()
    }

    fn ray() -> Ray {
        Ray {
            origin: DVec3::new(-3.0, 1.7, 2.2),
            direction: DVec3::new(1.0, 0.31, 0.23).normalize(),
        }
    }

    /// Ends of the pieces and the depth of all of them.
    fn pieces(modes: &[Bricks], relative_error: f64) -> (Vec<(f64, f64)>, f64) {
        let mut cells = MergedCells::new(modes, &ray(), (0.0, 60.0), relative_error);
        let (mut ends, mut depth) = (Vec::new(), 0.0);
        while let Some(merged) = cells.next_piece() {
            let piece = &merged.piece;
            ends.push((piece.start_m, piece.start_m + piece.length_m));
            let of_modes: f64 = merged.thin.iter().flatten().map(|thin| thin.depth).sum();
            assert!((of_modes / piece.depth() - 1.0).abs() < 1e-6);
            depth += piece.depth();
        }
        (ends, depth)
    }

    #[test]
    fn pieces_have_the_depth_of_their_modes_and_follow_each_other() {
        let boxes = [
            (DVec3::ZERO, 16.0, 16.0),
            (DVec3::new(4.0, 1.0, 1.5), 14.0, 23.0),
            (DVec3::new(12.0, -2.0, 0.0), 20.0, 9.0),
        ];
        for interpolation in [Interpolation::Moments, Interpolation::RadiusDensity] {
            let modes = boxes.map(|(min, size, n)| mode(min, size, n, interpolation));
            for relative_error in [0.0, 1e-2, 1e-1] {
                let (ends, depth) = pieces(&modes, relative_error);
                let alone: f64 = modes
                    .iter()
                    .map(|mode| pieces(std::slice::from_ref(mode), relative_error).1)
                    .sum();
                // Lanes are f32; measured 3e-7.
                assert!((depth / alone - 1.0).abs() < 2e-6, "{depth} {alone}");
                assert!(ends.iter().all(|(start, end)| start < end));
                assert!(ends.windows(2).all(|pair| pair[0].1 <= pair[1].0 + 1e-12));
            }
        }
    }

    #[test]
    fn modes_of_one_lattice_have_its_cells() {
        let alone = [mode(DVec3::ZERO, 16.0, 16.0, Interpolation::Moments)];
        // The same voxels of 1 m, from another corner on and beside each other by rounding.
        let corner = DVec3::new(3.0, 0.0, 1.0) + 1e-13;
        let both = [
            alone[0].clone(),
            mode(corner, 12.0, 12.0, Interpolation::Moments),
        ];
        let n = |modes: &[Bricks]| {
            let ends = pieces(modes, 0.0).0;
            // A face of the smaller box is one of the larger one's too.
            assert!(ends.iter().all(|(start, end)| end - start > 1e-9));
            ends.iter().filter(|(_, end)| *end < 18.0).count()
        };
        assert_eq!(n(&both), n(&alone));
    }
}
