//! Drops lit by the sun, finely enough for a tolerance.
//!
//! Q delta <= T / 4   `delta` error of the sun's optical depth at Q = 1, `T` tolerance for levels
//!
//! Light of drops errs relatively by Q delta and is seldom brighter than the gray card that tolerances
//! are relative to. The voxel of the sun's volume is halved until that holds, as long as it helps: the
//! depth is interpolated between the voxels of the drops, which set a limit of their own.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_render::Error;
use niji_render::LitDrops;
use niji_render::SunPath;

/// Most halvings of the voxel.
const MOST_HALVINGS: usize = 4;

/// Part of the tolerance that the sun's depth may take.
const SHARE: f64 = 0.25;

/// What a halving must leave of the error at most, to be worth it.
const WORTH: f64 = 0.8;

/// Largest relative error of the light of drops at an extinction efficiency.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowed {
    /// Tolerance for levels, relative to the gray card.
    pub tolerance: f64,
    /// Q.
    pub efficiency: f64,
}

/// Lights drops; with a tolerance the voxel of a swept volume is made as small as that asks for.
///
/// # Errors
/// As [`LitDrops::new`] for the level itself.
pub(crate) fn lit(
    bricks: Vec<Bricks>,
    sun_direction: DVec3,
    sun_path: SunPath,
    allowed: Option<Allowed>,
) -> Result<LitDrops, Error> {
    let (Some(allowed), SunPath::Volume { mut voxel_m }) = (allowed, sun_path) else {
        return LitDrops::new(bricks, sun_direction, sun_path);
    };
    let mut best = LitDrops::new(bricks.clone(), sun_direction, sun_path)?;
    for _ in 0..MOST_HALVINGS {
        let error = best.shadow_depth_error();
        if allowed.efficiency * error <= SHARE * allowed.tolerance {
            break;
        }
        voxel_m *= 0.5;
        // A volume that would not fit leaves the one before.
        let Ok(finer) = LitDrops::new(bricks.clone(), sun_direction, SunPath::Volume { voxel_m })
        else {
            break;
        };
        if finer.shadow_depth_error() > WORTH * error {
            break;
        }
        best = finer;
    }
    Ok(best)
}
