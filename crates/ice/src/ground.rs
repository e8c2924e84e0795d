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
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::directions::cosine_about;
use crate::error::Error;
use crate::error::check_range;
use crate::facets::Facets;
use crate::rough_dielectric::RoughDielectric;
use crate::sampler::VertexNumbers;
use crate::surface::Arrival;
use crate::surface::Scattered;
use crate::surface::Side;

/// Refractive index of sea water over air at 550 nm (Quan and Fry 1995, 35 per mille at 0 C).
const SEA_INDEX: f64 = 1.342;

/// What is below the horizon.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Ground {
    /// A diffuse plane.
    Land {
        /// Share of the light that it throws back: 0.2 grass, 0.85 snow.
        #[schemars(range(min = 0.0, max = 1.0))]
        albedo: f64,
    },
    /// Water with waves.
    Sea {
        /// Share of the light in the water that comes back out of it: 0.02 to 0.08.
        #[serde(default = "usual_sea_albedo")]
        #[schemars(range(min = 0.0, max = 1.0))]
        albedo: f64,
        /// Wind speed, m/s, which makes the waves.
        #[serde(default = "usual_wind_m_s")]
        #[schemars(range(min = 0.0, max = 30.0))]
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
                facets: Facets {
                    roughness: (0.003 + 0.00512 * wind_m_s).sqrt(),
                },
                refractive_index: SEA_INDEX,
            }),
        }
    }

    /// What it does with a path that came down from `back`: the share of the irradiance on a plane
    /// across `light` that goes to it, 1/sr, and how it goes on.
    pub(crate) fn scatter(
        &self,
        back: DVec3,
        light: DVec3,
        mut random: VertexNumbers,
    ) -> (f64, Option<Scattered>) {
        let cos_light = light.y.max(0.0);
        let Some(waves) = self.waves() else {
            let [_, u, v] = random.choice_and_direction();
            return (self.albedo() * cos_light / PI, Some(self.diffuse([u, v])));
        };
        let arrival = Arrival {
            side: Side::Outside,
            back,
        };
        let (lit_per_sr, onwards) = waves.scatter(DVec3::Y, arrival, light, &mut random);
        let mirrored = if cos_light > 0.0 { lit_per_sr } else { 0.0 };
        match onwards.map(|onwards| onwards.side) {
            Some(Side::Inside) => {
                let uv = [random.next(), random.next()];
                let diffuse = self.albedo() * cos_light / PI;
                (mirrored + diffuse, Some(self.diffuse(uv)))
            }
            Some(Side::Outside) | None => (mirrored, onwards),
        }
    }

    fn diffuse(&self, uv: [f64; 2]) -> Scattered {
        Scattered {
            direction: cosine_about(DVec3::Y, uv),
            side: Side::Outside,
            weight: self.albedo(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::Chi2;
    use crate::chi_square::pseudo_random;
    use crate::chi_square::sphere_bin;
    use crate::chi_square::sphere_estimates;
    use crate::sampler::Sampler;

    fn numbers(index: u64) -> VertexNumbers {
        let stream = Sampler::new(5, index as u32).stream(0);
        VertexNumbers::new(pseudo_random(index), stream)
    }

    #[test]
    fn snow_gives_back_its_albedo_and_a_white_sea_everything() {
        let sea = |wind_m_s| Ground::Sea {
            albedo: 1.0,
            wind_m_s,
        };
        let snow = Ground::Land { albedo: 0.85 };
        for (ground, albedo) in [
            (snow, 0.85),
            (sea(0.0), 1.0),
            (sea(5.0), 1.0),
            (sea(30.0), 1.0),
        ] {
            for back in [
                DVec3::Y,
                DVec3::new(0.8, 0.6, 0.0),
                DVec3::new(1.0, 1e-3, 0.0),
            ] {
                for index in 0..1_000 {
                    let (_, on) = ground.scatter(back.normalize(), DVec3::Y, numbers(index));
                    assert_eq!(on.unwrap().weight, albedo);
                }
            }
        }
    }

    #[test]
    fn the_sea_sends_paths_where_it_says_that_light_comes_from() {
        let n_draws = 400_000;
        for (wind_m_s, albedo, back) in [
            (5.0, 1.0, DVec3::new(0.8, 0.6, 0.0)),
            (10.0, 1.0, DVec3::new(0.995, 0.1, 0.0)),
            (20.0, 1.0, DVec3::Y),
        ] {
            let sea = Ground::Sea { albedo, wind_m_s };
            let mut chi2 = Chi2::new(256);
            // The bins have z upwards.
            let z_up = |direction: DVec3| DVec3::new(direction.x, direction.z, direction.y);
            for index in 0..n_draws {
                let (_, on) = sea.scatter(back.normalize(), DVec3::Y, numbers(index));
                chi2.count(sphere_bin(z_up(on.unwrap().direction)));
            }
            chi2.assert_fits_estimates(&sphere_estimates(|light, number| {
                let random = numbers(n_draws + number);
                sea.scatter(back.normalize(), z_up(light), random).0
            }));
        }
    }

    #[test]
    fn light_from_below_gives_nothing() {
        let land = Ground::Land { albedo: 0.5 };
        let sea = Ground::Sea {
            albedo: 0.5,
            wind_m_s: 5.0,
        };
        for ground in [land, sea] {
            let (lit, _) = ground.scatter(DVec3::Y, DVec3::NEG_Y, numbers(1));
            assert_eq!(lit, 0.0);
        }
        assert!(Ground::Land { albedo: 1.1 }.check().is_err());
        let storm = Ground::Sea {
            albedo: 0.05,
            wind_m_s: f64::NAN,
        };
        assert!(storm.check().is_err());
    }
}
