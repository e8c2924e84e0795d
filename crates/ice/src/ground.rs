//! What ice stands on or floats in: the plane y = 0, without end.
//!
//! Land throws back a share of the light by the cosine law. The sea does so with what gets into it,
//! and mirrors the rest on waves of mean square slope
//!   s² = 0.003 + 0.00512 w,   facets of the same spread have GGX width a = s
//! `w` wind speed [m/s]. Below the plane the sea glows alike in all directions, with what it gives
//! back of the daylight at its surface: that is what ice under water sees.
//! [CM54] C. Cox and W. Munk, J. Optical Society of America 44, 838-850 (1954).

use std::f64::consts::PI;

use glam::DVec3;
use serde::Deserialize;
use serde::Serialize;

use crate::directions::cosine_about;
use crate::error::Error;
use crate::error::check_range;
use crate::rough_dielectric::RoughDielectric;
use crate::rough_dielectric::fresnel_reflectance;
use crate::surface::Scattered;
use crate::surface::Side;

/// Refractive index of sea water over air at 550 nm (Quan and Fry 1995, 35 per mille at 0 C).
const SEA_INDEX: f64 = 1.342;

/// What is below the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Ground {
    /// A diffuse plane.
    Land {
        /// Share of the light that it throws back: 0.2 grass, 0.85 snow.
        albedo: f64,
    },
    /// Water with waves.
    Sea {
        /// Share of the light in the water that comes back out of it: 0.02 to 0.08.
        #[serde(default = "usual_sea_albedo")]
        albedo: f64,
        /// Wind speed, m/s, which makes the waves.
        #[serde(default = "usual_wind_m_s")]
        wind_m_s: f64,
    },
}

fn usual_sea_albedo() -> f64 {
    0.05
}

fn usual_wind_m_s() -> f64 {
    3.0
}

impl Ground {
    /// Checks the ranges.
    ///
    /// # Errors
    /// An albedo outside 0..1 or a wind outside 0..30 m/s.
    pub fn check(&self) -> Result<(), Error> {
        check_range("albedo", self.albedo(), [0.0, 1.0], "0 to 1")?;
        match *self {
            Self::Land { .. } => Ok(()),
            Self::Sea { wind_m_s, .. } => check_range("wind_m_s", wind_m_s, [0.0, 30.0], "0 to 30"),
        }
    }

    /// Share of the light that is thrown back diffusely.
    pub(crate) fn albedo(&self) -> f64 {
        match *self {
            Self::Land { albedo } | Self::Sea { albedo, .. } => albedo,
        }
    }

    fn waves(&self) -> Option<RoughDielectric> {
        match *self {
            Self::Land { .. } => None,
            Self::Sea { wind_m_s, .. } => Some(RoughDielectric {
                roughness: (0.003 + 0.00512 * wind_m_s).sqrt(),
                refractive_index: SEA_INDEX,
            }),
        }
    }

    /// How a path goes on that came down from `back`; `None` where a wave throws it against others.
    pub(crate) fn sample(&self, back: DVec3, [choice, u, v]: [f64; 3]) -> Option<Scattered> {
        let diffuse = Scattered {
            direction: cosine_about(DVec3::Y, [u, v]),
            side: Side::Outside,
            weight: self.albedo(),
        };
        let Some(waves) = self.waves() else {
            return Some(diffuse);
        };
        let mirrored = fresnel_reflectance(back.y, SEA_INDEX);
        if choice >= mirrored {
            return Some(diffuse);
        }
        // A choice of 0 always reflects; the facet's own share is made up for by the weight.
        let scattered = waves.sample(DVec3::Y, (Side::Outside, back), [0.0, u, v])?;
        let facet = (back + scattered.direction).normalize_or(DVec3::Y);
        let share = fresnel_reflectance(back.dot(facet), SEA_INDEX);
        Some(Scattered {
            weight: scattered.weight * share / mirrored,
            ..scattered
        })
    }

    /// Share of the irradiance on a plane across `light` that goes to `back`, 1/sr.
    pub(crate) fn towards_light(&self, back: DVec3, light: DVec3) -> f64 {
        if light.y <= 0.0 || back.y <= 0.0 {
            return 0.0;
        }
        let diffuse = self.albedo() * light.y / PI;
        match self.waves() {
            None => diffuse,
            Some(waves) => {
                let into = 1.0 - fresnel_reflectance(back.y, SEA_INDEX);
                into * diffuse + waves.towards_light(DVec3::Y, (Side::Outside, back), light)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::pseudo_random;

    fn mean_weight(ground: Ground, back: DVec3) -> f64 {
        let weight = |index| {
            let drawn = ground.sample(back, pseudo_random(index));
            drawn.map_or(0.0, |scattered| scattered.weight)
        };
        (0..20_000).map(weight).sum::<f64>() / 20_000.0
    }

    #[test]
    fn snow_gives_back_its_albedo_and_a_white_sea_all_but_what_waves_lose() {
        let snow = Ground::Land { albedo: 0.85 };
        assert!((mean_weight(snow, DVec3::Y) - 0.85).abs() < 1e-12);
        let sea = Ground::Sea {
            albedo: 1.0,
            wind_m_s: 5.0,
        };
        let slanted = mean_weight(sea, DVec3::new(0.8, 0.6, 0.0));
        assert!((slanted - 1.0).abs() < 0.01, "{slanted}");
    }

    #[test]
    fn what_is_drawn_and_what_the_sun_gets_are_the_same_surface() {
        // The whole upper half as the light: the mean weight is the integral of the share.
        let sea = Ground::Sea {
            albedo: 0.3,
            wind_m_s: 10.0,
        };
        let back = DVec3::new(0.8, 0.6, 0.0);
        let n = 400;
        let mut sum = 0.0;
        for ring in 0..n {
            let y = (f64::from(ring) + 0.5) / f64::from(n);
            let level = (1.0 - y * y).sqrt();
            for sector in 0..n {
                let (sin, cos) =
                    (std::f64::consts::TAU * f64::from(sector) / f64::from(n)).sin_cos();
                sum += sea.towards_light(back, DVec3::new(level * cos, y, level * sin));
            }
        }
        let integral = sum * 2.0 * PI / f64::from(n * n);
        let drawn = mean_weight(sea, back);
        // Statistical, 2e-3.
        assert!((integral - drawn).abs() < 6e-3, "{integral} {drawn}");
    }

    #[test]
    fn light_from_below_gives_nothing() {
        let land = Ground::Land { albedo: 0.5 };
        assert_eq!(land.towards_light(DVec3::Y, DVec3::NEG_Y), 0.0);
        assert!(Ground::Land { albedo: 1.1 }.check().is_err());
        let storm = Ground::Sea {
            albedo: 0.05,
            wind_m_s: f64::NAN,
        };
        assert!(storm.check().is_err());
    }
}
