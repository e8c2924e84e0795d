//! The shapes by name.

use niji_dropfield::DropVolume;
use niji_dropfield::GridBox;
use niji_sizes::SizeLaw;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Cloud;
use crate::Error;
use crate::FogBank;
use crate::Fountain;
use crate::Gradient;
use crate::RainCell;
use crate::RainShaft;
use crate::SeaSpray;
use crate::Uniform;
use crate::Waterfall;

/// A region of air with drops, described by a few numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// A box of the same drops everywhere.
    Uniform(Uniform),
    /// A box with a linear run of radius and number density.
    Gradient(Gradient),
    /// A shaft of rain below a cloud.
    RainShaft(RainShaft),
    /// A bank of fog whose water changes with height.
    FogBank(FogBank),
    /// A shower, heaviest in its middle.
    RainCell(RainCell),
    /// Jets of drops.
    Fountain(Fountain),
    /// Falling water, its splash and its mist.
    Waterfall(Waterfall),
    /// Spray above a rough sea.
    SeaSpray(SeaSpray),
    /// A cloud with a flat base.
    Cloud(Cloud),
}

/// Evaluate an expression for the shape inside, whichever it is.
macro_rules! for_each_shape {
    ($shape:expr, $inner:ident => $value:expr) => {
        match $shape {
            Shape::Uniform($inner) => $value,
            Shape::Gradient($inner) => $value,
            Shape::RainShaft($inner) => $value,
            Shape::FogBank($inner) => $value,
            Shape::RainCell($inner) => $value,
            Shape::Fountain($inner) => $value,
            Shape::Waterfall($inner) => $value,
            Shape::SeaSpray($inner) => $value,
            Shape::Cloud($inner) => $value,
        }
    };
}

impl Shape {
    /// The name by which scene files and the program call the shape.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Uniform(_) => "uniform",
            Self::Gradient(_) => "gradient",
            Self::RainShaft(_) => "rain-shaft",
            Self::FogBank(_) => "fog-bank",
            Self::RainCell(_) => "rain-cell",
            Self::Fountain(_) => "fountain",
            Self::Waterfall(_) => "waterfall",
            Self::SeaSpray(_) => "sea-spray",
            Self::Cloud(_) => "cloud",
        }
    }

    /// What is written into a file about the sizes of the drops.
    pub fn law_name(&self) -> &'static str {
        match self {
            Self::Uniform(shape) => shape.law.name(),
            Self::Gradient(_)
            | Self::FogBank(_)
            | Self::Fountain(_)
            | Self::Waterfall(_)
            | Self::Cloud(_) => "gamma",
            Self::RainShaft(_) | Self::RainCell(_) => "marshall-palmer",
            Self::SeaSpray(_) => "lognormal",
        }
    }

    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        for_each_shape!(self, shape => shape.validate())
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`Shape::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        for_each_shape!(self, shape => shape.volume())
    }

    /// The box around the shape and its voxels.
    pub fn grid(&self) -> GridBox {
        for_each_shape!(self, shape => shape.grid())
    }

    /// Edge of its voxels (m).
    pub fn voxel_m(&self) -> f64 {
        for_each_shape!(self, shape => shape.voxel_m)
    }

    /// The same shape on voxels of another edge length (m).
    #[must_use]
    pub fn with_voxel_m(mut self, voxel_m: f64) -> Self {
        for_each_shape!(&mut self, shape => shape.voxel_m = voxel_m);
        self
    }

    /// Whether its water is thrown or falls as a body, and not held by the air.
    pub fn is_thrown(&self) -> bool {
        matches!(self, Self::Fountain(_) | Self::Waterfall(_))
    }

    /// Smallest and largest effective radius (um).
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        for_each_shape!(self, shape => shape.effective_radius_range_um())
    }

    /// Smallest and largest effective variance.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        for_each_shape!(self, shape => shape.effective_variance_range())
    }

    /// Largest extinction without diffraction, sigma = pi N <r²> (1/m).
    pub fn max_extinction_m1_q1(&self) -> f64 {
        for_each_shape!(self, shape => shape.max_extinction_m1_q1())
    }

    /// Upper bound on the optical depth without diffraction along any straight line.
    pub fn max_optical_depth_q1(&self) -> f64 {
        let grid = self.grid();
        // The trilinear field reaches half a voxel beyond the box on every side.
        let size = grid.max - grid.min + grid.voxel_m;
        self.max_extinction_m1_q1() * size.length()
    }

    /// The heaviest rain in it (mm/h), and the key that says so; `None` where it is no rain.
    pub fn rain_rate(&self) -> Option<(&'static str, f64)> {
        match self {
            Self::RainShaft(shape) => {
                let by_radar = shape.rain_rate_mm_h.is_none();
                let key = if by_radar {
                    "reflectivity_dbz"
                } else {
                    "rain_rate_mm_h"
                };
                Some((key, shape.law().rain_rate_mm_h))
            }
            Self::RainCell(shape) => Some(("max_rain_rate_mm_h", shape.max_rain_rate_mm_h)),
            Self::Uniform(shape) => match shape.law {
                SizeLaw::MarshallPalmer(law) => {
                    Some(("law.marshall-palmer.rain_rate_mm_h", law.rain_rate_mm_h))
                }
                _ => None,
            },
            Self::Gradient(_)
            | Self::FogBank(_)
            | Self::Fountain(_)
            | Self::Waterfall(_)
            | Self::SeaSpray(_)
            | Self::Cloud(_) => None,
        }
    }

    /// Drops in the whole shape, in closed form.
    pub fn total_drops(&self) -> f64 {
        for_each_shape!(self, shape => shape.total_drops())
    }

    /// Water in the whole shape (g), in closed form.
    pub fn total_water_g(&self) -> f64 {
        for_each_shape!(self, shape => shape.total_water_g())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAIN: &str = r#"{"rain-shaft":{"rain_rate_mm_h":5.0,
        "footprint":{"column":{"radius_m":40.0}},"center_xz_m":[0.0,-300.0],
        "base_y_m":0.0,"top_y_m":100.0,"voxel_m":5.0}}"#;
    const FOG: &str = r#"{"uniform":{"box_min_m":[0,0,0],"box_max_m":[8,8,8],"voxel_m":1,
        "law":{"monodisperse":{"radius_um":10}},"number_density_m3":1e8}}"#;
    const GRADIENT: &str = r#"{"gradient":{"box_min_m":[0,0,0],"box_max_m":[8,8,8],"voxel_m":1,
        "axis":"y","radius_at_min_um":1500,"radius_at_max_um":10,
        "number_density_at_min_m3":0,"number_density_at_max_m3":1000}}"#;

    const RADAR: &str = r#"{"rain-shaft":{"reflectivity_dbz":35.0,
        "footprint":{"column":{"radius_m":40.0}},"center_xz_m":[0.0,-300.0],
        "base_y_m":0.0,"top_y_m":100.0,"voxel_m":5.0}}"#;
    const CLOUD: &str = r#"{"fog-bank":{"box_min_m":[0,0,0],"box_max_m":[8,8,8],"voxel_m":1,
        "profile":"ground-based","preset":"stratus-maritime"}}"#;
    const CELL: &str = r#"{"rain-cell":{"max_rain_rate_mm_h":25.0,"radius_m":100.0,
        "center_xz_m":[0.0,-3000.0],"base_y_m":0.0,"top_y_m":200.0,"voxel_m":20.0,
        "turbulence":{"strength":0.5,"eddy_m":60.0}}}"#;
    const FALL: &str = r#"{"waterfall":{"foot_m":[0,0,-80],"azimuth_deg":180,"height_m":10,
        "width_m":4,"flow_kg_s":20,"splash_fraction":0.1,"mist_fraction":0.001,
        "curtain_effective_radius_um":1000,"splash_effective_radius_um":300,
        "mist_effective_radius_um":30,"wind_xz_m_s":[1,0],"voxel_m":1}}"#;
    const SPRAY: &str = r#"{"sea-spray":{"box_min_m":[0,0,0],"box_max_m":[8,8,8],
        "surface_lwc_g_m3":0.05,"scale_height_m":2,"median_radius_um":50,
        "geometric_standard_deviation":2,"voxel_m":1}}"#;

    const CUMULUS: &str = r#"{"cloud":{"form":"cumulus","center_xz_m":[0,0],"width_x_m":60,"width_z_m":60,
        "base_y_m":100,"top_y_m":130,"number_density_m3":2e8,"voxel_m":3}}"#;

    #[test]
    fn shapes_are_read_by_name_and_written_back() {
        for (text, name, law) in [
            (RAIN, "rain-shaft", "marshall-palmer"),
            (FOG, "uniform", "monodisperse"),
            (GRADIENT, "gradient", "gamma"),
            (RADAR, "rain-shaft", "marshall-palmer"),
            (CLOUD, "fog-bank", "gamma"),
            (CELL, "rain-cell", "marshall-palmer"),
            (FALL, "waterfall", "gamma"),
            (SPRAY, "sea-spray", "lognormal"),
            (CUMULUS, "cloud", "gamma"),
        ] {
            let shape: Shape = serde_json::from_str(text).unwrap();
            assert_eq!((shape.name(), shape.law_name()), (name, law));
            shape.validate().unwrap();
            let again = serde_json::to_string(&shape).unwrap();
            assert_eq!(serde_json::from_str::<Shape>(&again).unwrap(), shape);
        }
    }

    #[test]
    fn misspelt_keys_are_refused_at_every_depth() {
        for (text, right, wrong) in [
            (RAIN, "radius_m\"", "radius_km\""),
            (RAIN, "top_y_m", "top_m"),
            (RAIN, "column", "pillar"),
            (FOG, "radius_um", "radius_mm"),
            (GRADIENT, "axis", "axes"),
            (RADAR, "reflectivity_dbz", "reflectivity_db"),
            (CLOUD, "preset", "cloud"),
            (CLOUD, "stratus-maritime", "stratus-marine"),
            (CELL, "eddy_m", "eddies_m"),
            (FALL, "mist_fraction", "fog_fraction"),
            (SPRAY, "scale_height_m", "scale_m"),
            (CUMULUS, "cumulus", "cumulonimbus"),
        ] {
            let misspelt = text.replace(right, wrong);
            let error = serde_json::from_str::<Shape>(&misspelt)
                .unwrap_err()
                .to_string();
            assert!(error.contains(wrong.trim_matches('"')), "{error}");
        }
    }

    #[test]
    fn gusts_keep_the_water_of_every_shape() {
        let gusts = r#""turbulence":{"strength":0.9,"eddy_m":5,"seed":1},"voxel_m""#;
        for text in [RAIN, CLOUD, FALL, SPRAY] {
            let calm: Shape = serde_json::from_str(text).unwrap();
            let gusty = text.replace("\"voxel_m\"", gusts);
            let gusty: Shape = serde_json::from_str(&gusty).unwrap();
            let (calm, stirred) = (calm.volume().unwrap(), gusty.volume().unwrap());
            assert_ne!(calm, stirred);
            let (calm, stirred) = (calm.summary(), stirred.summary());
            assert!((stirred.total_water_g / calm.total_water_g - 1.0).abs() < 1e-6);
            assert!(stirred.max_extinction_m1_q1 <= gusty.max_extinction_m1_q1() * (1.0 + 1e-6));
        }
    }

    #[test]
    fn bounds_hold_for_the_volume() {
        for text in [
            RAIN, FOG, GRADIENT, RADAR, CLOUD, CELL, FALL, SPRAY, CUMULUS,
        ] {
            let shape: Shape = serde_json::from_str(text).unwrap();
            let found = shape.volume().unwrap().summary();
            let roundoff = 1.0 + 1e-6;
            assert!(found.max_extinction_m1_q1 <= shape.max_extinction_m1_q1() * roundoff);
            let (low, high) = shape.effective_radius_range_um();
            assert!(found.effective_radius_um.0 * roundoff >= low && low > 0.0);
            assert!(found.effective_radius_um.1 <= high * roundoff);
            let (low, high) = shape.effective_variance_range();
            assert!(found.effective_variance.0 * roundoff >= low);
            assert!(found.effective_variance.1 <= high * roundoff);
            let deepest = found.optical_depth_q1.into_iter().fold(0.0, f64::max);
            assert!(deepest <= shape.max_optical_depth_q1() * roundoff);
        }
    }
}
