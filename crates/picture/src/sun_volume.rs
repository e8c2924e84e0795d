//! Drops lit by the sun, finely enough for a tolerance.
//!
//! Q delta <= T / 4   `delta` error of the sun's optical depth at Q = 1, `T` what the light of drops may err by
//! relatively
//!
//! The voxel of the sun's volume is halved until that holds, as long as it helps: the
//! depth is interpolated between the voxels of the drops, which set a limit of their own.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_render::Error;
use niji_render::LitDrops;
use niji_render::Progress;
use niji_render::SunPath;

/// Most halvings of the voxel.
const MOST_HALVINGS: usize = 4;

/// Part of the tolerance that the sun's depth may take.
const SHARE: f64 = 0.25;

/// What a halving must leave of the error at most, to be worth it.
const WORTH: f64 = 0.8;

/// The sun that drops are lit by.
#[derive(Clone, Copy)]
pub(crate) struct Sunlight<'a> {
    /// Towards it.
    pub direction: DVec3,
    /// How the way to it is followed.
    pub path: SunPath,
    /// Whoever waits for it.
    pub progress: Progress<'a>,
}

impl Sunlight<'_> {
    fn on(&self, bricks: Vec<Bricks>, path: SunPath) -> Result<LitDrops, Error> {
        LitDrops::watched(bricks, self.direction, path, self.progress)
    }
}

/// Largest relative error of the light of drops at an extinction efficiency.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowed {
    /// Of all levels together.
    pub relative_error: f64,
    /// Q.
    pub efficiency: f64,
}

/// Lights drops; with a tolerance the voxel of a swept volume is made as small as that asks for, and as large as fits.
///
/// # Errors
/// As [`LitDrops::watched`] for the level itself.
pub(crate) fn lit(
    bricks: Vec<Bricks>,
    sunlight: Sunlight,
    allowed: Option<Allowed>,
) -> Result<LitDrops, Error> {
    let (Some(allowed), SunPath::Volume { mut voxel_m }) = (allowed, sunlight.path) else {
        return sunlight.on(bricks, sunlight.path);
    };
    let mut best = match sunlight.on(bricks.clone(), sunlight.path) {
        // What was planned for the box of a shape; its nodes reach farther.
        Err(Error::SunVolumeTooLarge { smallest_m, .. }) => {
            voxel_m = smallest_m;
            sunlight.on(bricks.clone(), SunPath::Volume { voxel_m })?
        }
        lit => lit?,
    };
    for _ in 0..MOST_HALVINGS {
        let error = best.shadow_depth_error();
        if allowed.efficiency * error <= SHARE * allowed.relative_error {
            break;
        }
        voxel_m *= 0.5;
        let finer = match sunlight.on(bricks.clone(), SunPath::Volume { voxel_m }) {
            // A volume that would not fit leaves the one before.
            Err(Error::SunVolumeTooLarge { .. }) => break,
            finer => finer?,
        };
        if finer.shadow_depth_error() > WORTH * error {
            break;
        }
        best = finer;
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use niji_dropfield::DropMode;
    use niji_dropfield::Drops;
    use niji_dropfield::GridBox;
    use niji_dropfield::Interpolation;
    use niji_render::unwatched;

    use super::*;

    /// Node distances of the drops and of the coarsest sun volume (m).
    const DROPS_VOXEL_M: f64 = 2.0;
    const COARSE_M: f64 = 32.0;

    fn sun() -> DVec3 {
        DVec3::new(0.4, 0.8, 0.3).normalize()
    }

    /// A cloud of optical depth 2 in the middle, so that shadows bend from voxel to voxel.
    fn bricks() -> Vec<Bricks> {
        let half = DVec3::splat(32.0);
        let grid = GridBox {
            min: -half,
            max: half,
            voxel_m: DROPS_VOXEL_M,
        };
        let cloud = |point: DVec3| Drops {
            number_density_m3: (2.5e6 * (-point.length_squared() / 200.0).exp()) as f32,
            effective_radius_m: 1e-4,
            effective_variance: 0.1,
        };
        let mode = DropMode::from_fn("", &grid, cloud).expect("the cloud is sound");
        vec![Bricks::build(&mode, Interpolation::Moments).expect("the cloud is small")]
    }

    fn error_of(voxel_m: f64) -> f64 {
        let drops = LitDrops::new(bricks(), sun(), SunPath::Volume { voxel_m });
        drops.expect("the cloud is sound").shadow_depth_error()
    }

    fn sunlight(path: SunPath) -> Sunlight<'static> {
        Sunlight {
            direction: sun(),
            path,
            progress: &unwatched,
        }
    }

    /// Error of what is made from the coarsest volume for a tolerance at Q = 2.
    fn error_for(relative_error: f64) -> f64 {
        let allowed = Allowed {
            relative_error,
            efficiency: 2.0,
        };
        let coarse = SunPath::Volume { voxel_m: COARSE_M };
        let drops = lit(bricks(), sunlight(coarse), Some(allowed));
        drops.expect("the cloud is sound").shadow_depth_error()
    }

    /// The tolerance that a volume of an error just keeps.
    fn kept_by(error: f64) -> f64 {
        2.0 * error / SHARE
    }

    #[test]
    fn the_voxel_is_halved_until_the_estimate_holds_and_no_further() {
        let errors = [1.0, 0.5, 0.25].map(|part| error_of(part * COARSE_M));
        // Measured 1.5 and 1.7.
        assert!(errors[0] > 1.4 * errors[1] && errors[1] > 1.4 * errors[2]);
        for error in errors {
            // Stored values come back: the volumes are the same.
            assert_eq!(error_for(1.01 * kept_by(error)), error);
        }
        assert_eq!(error_for(0.99 * kept_by(errors[0])), errors[1]);
    }

    #[test]
    fn it_stops_after_the_last_halving_and_says_that_the_tolerance_is_missed() {
        let tolerance = 1e-9;
        let found = error_for(tolerance);
        assert_eq!(found, error_of(COARSE_M / f64::from(1 << MOST_HALVINGS)));
        // What the drops say of themselves is what the picture's error is made of.
        assert!(kept_by(found) > tolerance);
    }

    #[test]
    fn a_level_without_a_tolerance_and_a_march_stay_as_they_are() {
        let coarse = SunPath::Volume { voxel_m: COARSE_M };
        let drops = lit(bricks(), sunlight(coarse), None).expect("the cloud is sound");
        assert_eq!(drops.shadow_depth_error(), error_of(COARSE_M));
        let allowed = Some(Allowed {
            relative_error: 1e-9,
            efficiency: 2.0,
        });
        let march = SunPath::March { step_m: 20.0 };
        let marched = lit(bricks(), sunlight(march), allowed).expect("the cloud is sound");
        let plain = LitDrops::new(bricks(), sun(), march).expect("the cloud is sound");
        assert_eq!(marched.shadow_depth_error(), plain.shadow_depth_error());
    }
}
