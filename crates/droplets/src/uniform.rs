//! A box of the same drops everywhere.
//!
//! total drops = N V,   total water = (4/3) pi rho_w <r³> N V
//! `N` number density, `V` volume of the box, rho_w density of water.
//!
//! The volume holds the gamma law with the same extinction, water, effective radius and effective
//! variance: the size law itself for a single size and for untruncated Marshall-Palmer rain. For
//! the others its number of drops differs (see [`niji_dropfield::Drops`]).

use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_sizes::BulkProperties;
use niji_sizes::SizeLaw;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::error::require_number_density;

/// A box of air with one size law and one number density.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Uniform {
    /// Lowest corner (m).
    pub box_min_m: [f64; 3],
    /// Highest corner (m).
    pub box_max_m: [f64; 3],
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
    /// Sizes of the drops.
    pub law: SizeLaw,
    /// Drops per cubic metre (1/m³); left out where the size law says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub number_density_m3: Option<f64>,
}

impl Uniform {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        self.law.validate()?;
        let law = self.law.name();
        match (self.law.natural_number_density_m3(), self.number_density_m3) {
            (None, None) => return Err(Error::NumberDensityMissing { law }),
            (Some(_), Some(_)) => return Err(Error::NumberDensityFixed { law }),
            (None, Some(density)) => require_number_density("number_density_m3", density)?,
            (Some(_), None) => {}
        }
        self.grid().n_nodes()?;
        Ok(())
    }

    /// The box and its voxels.
    pub fn grid(&self) -> GridBox {
        let (min, max) = (DVec3::from(self.box_min_m), DVec3::from(self.box_max_m));
        GridBox {
            min,
            max,
            voxel_m: self.voxel_m,
        }
    }

    /// What a cubic metre holds.
    pub fn bulk_properties(&self) -> BulkProperties {
        let natural = self.law.natural_number_density_m3();
        let density = natural.or(self.number_density_m3).unwrap_or(0.0);
        self.law.moments().bulk_properties(density)
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`Uniform::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let drops = Drops::of_law(
            &self.law.moments(),
            self.bulk_properties().number_density_m3,
        );
        let mode = DropMode::from_fn("", &self.grid(), |_| drops)?;
        Ok(DropVolume { modes: vec![mode] })
    }

    /// Smallest and largest effective radius (um).
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let radius = self.law.moments().effective_radius().0;
        (radius, radius)
    }

    /// Smallest and largest effective variance.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        let variance = self.law.moments().effective_variance;
        (variance, variance)
    }

    /// Largest extinction without diffraction (1/m).
    pub fn max_extinction_m1_q1(&self) -> f64 {
        0.5 * self.bulk_properties().extinction_m1
    }

    /// Drops in the whole box, by the size law.
    pub fn total_drops(&self) -> f64 {
        self.bulk_properties().number_density_m3 * self.grid().volume_m3()
    }

    /// Water in the whole box (g).
    pub fn total_water_g(&self) -> f64 {
        self.bulk_properties().lwc_g_m3 * self.grid().volume_m3()
    }
}

#[cfg(test)]
mod tests {
    use niji_sizes::MarshallPalmer;
    use niji_sizes::Monodisperse;
    use niji_sizes::Normal;

    use super::*;

    fn fog() -> Uniform {
        Uniform {
            box_min_m: [-10.0, 0.0, -30.0],
            box_max_m: [10.0, 7.0, -10.0],
            voxel_m: 2.0,
            law: SizeLaw::Monodisperse(Monodisperse { radius_um: 100.0 }),
            number_density_m3: Some(1000.0),
        }
    }

    #[test]
    fn totals_of_the_volume_equal_the_closed_forms() {
        // 7 m are three and a half voxels.
        let normal = SizeLaw::Normal(Normal {
            radius_mean_um: 200.0,
            radius_standard_deviation_um: 60.0,
        });
        let rain = SizeLaw::MarshallPalmer(MarshallPalmer::untruncated(5.0));
        for shape in [
            fog(),
            Uniform {
                law: normal,
                ..fog()
            },
            Uniform {
                law: rain,
                number_density_m3: None,
                ..fog()
            },
        ] {
            let volume = shape.volume().unwrap().summary();
            let gamma_drops = shape.total_drops() * shape.law.moments().equivalent_gamma_drops();
            // Measured worst 1.0e-7.
            assert!((volume.total_drops / gamma_drops - 1.0).abs() < 2e-7);
            assert!((volume.total_water_g / shape.total_water_g() - 1.0).abs() < 2e-7);
            let ratio = volume.max_extinction_m1_q1 / shape.max_extinction_m1_q1();
            assert!((ratio - 1.0).abs() < 2e-7);
        }
    }

    #[test]
    fn a_known_box_holds_known_drops_and_water() {
        // 2800 m³ with 1000 drops of 0.1 mm each: (4/3) pi 1e-6 g a drop.
        assert!((fog().total_drops() - 2.8e6).abs() < 1e-6);
        assert!((fog().total_water_g() - 2.8 * 4.188_790_204_786).abs() < 1e-9);
        assert!((fog().max_extinction_m1_q1() - 3.141_592_653_6e-5).abs() < 1e-14);
        assert_eq!(fog().effective_radius_range_um(), (100.0, 100.0));
    }

    #[test]
    fn the_number_density_is_given_exactly_once() {
        let missing = Uniform {
            number_density_m3: None,
            ..fog()
        };
        assert!(matches!(
            missing.validate(),
            Err(Error::NumberDensityMissing { .. })
        ));
        let rain = SizeLaw::MarshallPalmer(MarshallPalmer::untruncated(5.0));
        let doubled = Uniform { law: rain, ..fog() };
        assert!(matches!(
            doubled.validate(),
            Err(Error::NumberDensityFixed { .. })
        ));
    }

    #[test]
    fn unsound_boxes_and_laws_are_refused() {
        let negative = SizeLaw::Monodisperse(Monodisperse { radius_um: -1.0 });
        assert!(matches!(
            Uniform {
                law: negative,
                ..fog()
            }
            .volume(),
            Err(Error::Size(_))
        ));
        let thin = Uniform {
            box_max_m: [10.0, 0.0, -10.0],
            ..fog()
        };
        assert!(matches!(thin.volume(), Err(Error::Volume(_))));
        let fine = Uniform {
            voxel_m: 1e-3,
            ..fog()
        };
        assert!(
            fine.validate()
                .is_err_and(|error| matches!(error, Error::Volume(_)))
        );
        for density in [-1.0, f64::NAN] {
            let shape = Uniform {
                number_density_m3: Some(density),
                ..fog()
            };
            assert!(matches!(shape.validate(), Err(Error::Parameter { .. })));
        }
    }

    #[test]
    fn without_drops_there_is_an_empty_volume() {
        let none = Uniform {
            number_density_m3: Some(0.0),
            ..fog()
        };
        assert_eq!(none.volume().unwrap().summary().n_nodes, 0);
    }
}
