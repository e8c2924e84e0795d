//! The section `[water_surface]`: water that mirrors the sun into the drops, and is seen.

use glam::DVec2;
use niji_radiometry::Water;
use niji_render::wave_slope;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::check::Check;
use crate::error::SceneError;

/// Steepest waves, rms along an axis.
const STEEPEST: f64 = 0.35;
/// The wind that makes them, m/s.
const STRONGEST_M_S: f64 = 47.0;

/// The section `[water_surface]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaterSurface {
    /// Height of the water, y, m: 0 where it is left out.
    #[serde(default)]
    #[schemars(range(min = -1e7, max = 1e7))]
    pub height_m: f64,
    /// Smallest x and z of the water, m; with `extent_max_m`. It reaches the horizon where both are left
    /// out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extent_min_m: Option<[f64; 2]>,
    /// Largest x and z of the water, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extent_max_m: Option<[f64; 2]>,
    /// Slope of the waves, rms along each of two axes: 0 is a mirror. Where it is left out it follows from
    /// the wind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 0.35))]
    pub slope: Option<f64>,
    /// Wind speed 12.5 m above the water, m/s, that makes the waves: 0 where it is left out, with a slope of
    /// 0.039.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 47.0))]
    pub wind_speed_m_s: Option<f64>,
    /// Temperature of the water, degrees Celsius: 15 where it is left out.
    #[serde(default = "temperate_c")]
    #[schemars(range(min = -20.0, max = 100.0))]
    pub temperature_c: f64,
    /// Its salinity, per mille: 0 where it is left out.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 40.0))]
    pub salinity_per_mille: f64,
}

fn temperate_c() -> f64 {
    15.0
}

impl WaterSurface {
    /// The water as the renderer takes it.
    pub fn surface(&self) -> niji_render::WaterSurface {
        let corner = |corner: Option<[f64; 2]>, open: DVec2| corner.map_or(open, DVec2::from);
        niji_render::WaterSurface {
            height_m: self.height_m,
            extent_m: [
                corner(self.extent_min_m, DVec2::NEG_INFINITY),
                corner(self.extent_max_m, DVec2::INFINITY),
            ],
            slope: self
                .slope
                .unwrap_or_else(|| wave_slope(self.wind_speed_m_s.unwrap_or(0.0))),
            water: Water {
                temperature_c: self.temperature_c,
                salinity_per_mille: self.salinity_per_mille,
            },
        }
    }

    /// Ranges, and settings that contradict each other.
    pub(crate) fn check(&self, check: &Check<'_>) -> Result<(), SceneError> {
        let key = |key: &str| format!("water_surface.{key}");
        check.coordinate(&key("height_m"), self.height_m)?;
        if let Some(slope) = self.slope {
            check.number(&key("slope"), slope, (0.0, STEEPEST))?;
            if let Some(wind_m_s) = self.wind_speed_m_s {
                let (key, found) = (key("wind_speed_m_s"), wind_m_s.to_string());
                return Err(check.out_of_range(&key, found, "either a slope or a wind speed"));
            }
        }
        if let Some(wind_m_s) = self.wind_speed_m_s {
            check.number(&key("wind_speed_m_s"), wind_m_s, (0.0, STRONGEST_M_S))?;
        }
        match (self.extent_min_m, self.extent_max_m) {
            (None, None) => (),
            (Some(min), Some(max)) => {
                for (name, corner) in [("extent_min_m", min), ("extent_max_m", max)] {
                    for place in corner {
                        check.coordinate(&key(name), place)?;
                    }
                }
                if min[0] > max[0] || min[1] > max[1] {
                    let expected = format!("at least extent_min_m, {min:?}");
                    return Err(check.out_of_range(
                        &key("extent_max_m"),
                        format!("{max:?}"),
                        &expected,
                    ));
                }
            }
            (Some(_), None) | (None, Some(_)) => {
                let expected = "both extent_min_m and extent_max_m, or neither";
                let found = "one of them".to_string();
                return Err(check.out_of_range("water_surface", found, expected));
            }
        }
        let water = self.surface().water.check();
        water.map_err(|error| check.refused("water_surface", &error))
    }
}
