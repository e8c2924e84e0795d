//! Hard cases of the ray integral. No picture may hold NaN, infinities or negative light: the case that
//! makes one panics.

pub(crate) mod pictures;
pub(crate) mod rays;

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_dropfield::GridBox;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::SunPath;

#[allow(
    clippy::unwrap_used,
    reason = "the scenes of the library's tests; a panic fails the case"
)]
#[path = "../../../crates/render/tests/common/mod.rs"]
pub(crate) mod scenes;

use scenes::bricks;
use scenes::sun_in_the_south;

pub(crate) const INTEGRATIONS: [Integration; 3] = [
    Integration::CellExact,
    Integration::Adaptive {
        relative_error: 1e-4,
    },
    Integration::FixedStep { step_m: 0.05 },
];

/// A cube of 4 m, 20 m to the north of the origin.
pub(crate) fn cube(offset: DVec3) -> GridBox {
    GridBox {
        min: offset + DVec3::new(-2.0, -2.0, -22.0),
        max: offset + DVec3::new(2.0, 2.0, -18.0),
        voxel_m: 0.5,
    }
}

/// A sun 25 degrees high behind the camera.
pub(crate) fn sun() -> DVec3 {
    sun_in_the_south(25.0)
}

pub(crate) fn lit_by(volume: Bricks, sun: DVec3, path: SunPath) -> LitDrops {
    LitDrops::new(vec![volume], sun, path).expect("the cases light sound drops")
}

pub(crate) fn lit(grid: &GridBox, extinction_m1: f64) -> LitDrops {
    let path = SunPath::Volume { voxel_m: 0.25 };
    lit_by(bricks(grid, |_| extinction_m1), sun(), path)
}
