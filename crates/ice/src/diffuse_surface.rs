//! The surface of paper and plaster: light goes on in any direction, by the cosine law.
//!
//! Outside a share `outer_reflectance` is thrown back, the rest goes in; inside a share
//! `inner_reflectance` is thrown back, the rest gets out. Whatever it does, it has density
//! cos(theta)/pi about the normal on that side.
//!
//! A body that is white in a uniform surround stays so for every pair of reflectances, if what goes in
//! and out is counted as reduced radiance L/kappa inside,
//!   kappa = (1 - inner)/(1 - outer),
//! which for a smooth dielectric is 1/n². Patches with another outer reflectance on the same body must
//! share its kappa: theirs inside follows.

use std::f64::consts::PI;

use glam::DVec3;

use crate::directions::cosine_about;
use crate::surface::Scattered;
use crate::surface::Side;

/// Shares that are thrown back, 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiffuseSurface {
    pub(crate) outer_reflectance: f64,
    pub(crate) inner_reflectance: f64,
}

impl DiffuseSurface {
    /// How light inside counts against light outside.
    pub(crate) fn kappa(&self) -> f64 {
        (1.0 - self.inner_reflectance) / (1.0 - self.outer_reflectance)
    }

    /// A patch of `reflectance` outside on a body with `kappa`.
    pub(crate) fn patch(reflectance: f64, kappa: f64) -> Self {
        Self {
            outer_reflectance: reflectance,
            inner_reflectance: (1.0 - kappa * (1.0 - reflectance)).clamp(0.0, 1.0),
        }
    }

    fn reflectance(&self, side: Side) -> f64 {
        match side {
            Side::Outside => self.outer_reflectance,
            Side::Inside => self.inner_reflectance,
        }
    }

    /// How a path that arrives on `side` goes on; `choice` picks between back and through.
    pub(crate) fn sample(&self, normal: DVec3, side: Side, [choice, u, v]: [f64; 3]) -> Scattered {
        let side = if choice < self.reflectance(side) {
            side
        } else {
            side.other()
        };
        let axis = match side {
            Side::Outside => normal,
            Side::Inside => -normal,
        };
        Scattered::all(cosine_about(axis, [u, v]), side)
    }

    /// Share of the irradiance on a plane across `light` that goes to a path which arrived on `side`,
    /// 1/sr; `light` is outside.
    pub(crate) fn towards_light(&self, normal: DVec3, side: Side, light: DVec3) -> f64 {
        let share = match side {
            Side::Outside => self.outer_reflectance,
            Side::Inside => 1.0 - self.inner_reflectance,
        };
        share * normal.dot(light).max(0.0) / PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::pseudo_random;

    #[test]
    fn shares_are_those_asked_for() {
        let surface = DiffuseSurface {
            outer_reflectance: 0.3,
            inner_reflectance: 0.7,
        };
        for (side, back) in [(Side::Outside, 0.3), (Side::Inside, 0.7)] {
            let stays = |index| surface.sample(DVec3::Y, side, pseudo_random(index)).side == side;
            let share = (0..10_000).filter(|&index| stays(index)).count() as f64 / 10_000.0;
            // Standard error 0.0046.
            assert!((share - back).abs() < 0.015, "{share}");
        }
    }

    #[test]
    fn a_patch_has_the_kappa_of_its_body() {
        let ice = DiffuseSurface {
            outer_reflectance: 0.06,
            inner_reflectance: 0.0,
        };
        let snow = DiffuseSurface::patch(0.9, ice.kappa());
        assert!((snow.kappa() - ice.kappa()).abs() < 1e-14);
        assert!((snow.inner_reflectance - 0.8936).abs() < 1e-4);
    }

    #[test]
    fn light_behind_the_surface_gives_nothing() {
        let surface = DiffuseSurface {
            outer_reflectance: 0.5,
            inner_reflectance: 0.5,
        };
        assert_eq!(
            surface.towards_light(DVec3::Y, Side::Inside, DVec3::NEG_Y),
            0.0
        );
        assert_eq!(
            surface.towards_light(DVec3::Y, Side::Outside, DVec3::Y),
            0.5 / PI
        );
    }
}
