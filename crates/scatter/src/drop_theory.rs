//! One drop after the other at one wavelength, on one grid of angles.
//!
//! What does not depend on the size (the rays, the strength of the bow in each direction) is computed
//! once and serves every drop.

use niji_airy::AiryBow;
use niji_airy::AiryDirection;
use niji_airy::AiryTable;
use niji_airy::GeometricOrder;
use niji_airy::airy_integral;
use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;

use crate::error::Error;
use crate::theory::Theory;

/// Debye orders that make a bow one can switch off.
const BOW_ORDERS: [u32; 2] = [2, 3];

/// What all drops share at one wavelength.
pub(crate) struct Setting<'a> {
    pub(crate) theory: Theory,
    pub(crate) orders: &'a [u32],
    pub(crate) wavelength: Nanometers,
    pub(crate) index: f64,
    pub(crate) angles_rad: &'a [f64],
    pub(crate) airy_table: Option<&'a AiryTable>,
}

/// A theory, ready for drops of any size at one wavelength.
pub(crate) enum DropTheory<'a> {
    /// The same for every drop.
    Rays(Vec<[f64; 2]>),
    /// Every order in every direction.
    Airy {
        setting: Setting<'a>,
        directions: Vec<Vec<AiryDirection>>,
    },
    Published {
        setting: Setting<'a>,
        bows: Vec<AiryBow>,
    },
    Exact {
        setting: Setting<'a>,
        angles: ScatteringAngles,
    },
}

impl<'a> DropTheory<'a> {
    pub(crate) fn new(setting: Setting<'a>) -> Result<Self, Error> {
        let no_bow = || Error::Orders {
            found: setting.orders.to_vec(),
        };
        let bows = || {
            let bows = setting
                .orders
                .iter()
                .map(|&p| AiryBow::new(setting.index, p));
            bows.collect::<Option<Vec<_>>>().ok_or_else(no_bow)
        };
        match setting.theory {
            Theory::Geometric => {
                let orders = setting
                    .orders
                    .iter()
                    .map(|&p| GeometricOrder::new(setting.index, p));
                let orders: Vec<_> = orders.collect::<Option<_>>().ok_or_else(no_bow)?;
                let at = |angle: &f64| {
                    sum(orders
                        .iter()
                        .map(|order| order.normalized_cross_section(Radians(*angle))))
                };
                Ok(Self::Rays(setting.angles_rad.iter().map(at).collect()))
            }
            Theory::Airy => {
                let directions = |bow: AiryBow| {
                    let angles = setting.angles_rad.iter();
                    angles.map(|&angle| bow.direction(Radians(angle))).collect()
                };
                let directions = bows()?.into_iter().map(directions).collect();
                Ok(Self::Airy {
                    setting,
                    directions,
                })
            }
            Theory::AiryPublished => {
                let bows = bows()?;
                Ok(Self::Published { setting, bows })
            }
            Theory::Debye { .. } | Theory::Mie => {
                let angles: Vec<Radians> =
                    setting.angles_rad.iter().copied().map(Radians).collect();
                let angles = ScatteringAngles::new(&angles);
                let angles = angles.map_err(|error| Error::Drop(error.to_string()))?;
                Ok(Self::Exact { setting, angles })
            }
        }
    }

    /// (dσ/dΩ)/(π a²) of one drop in 1/sr at every angle, for both polarisations.
    pub(crate) fn drop(&self, radius: Micrometers) -> Result<Vec<[f64; 2]>, Error> {
        match self {
            Self::Rays(values) => Ok(values.clone()),
            Self::Airy {
                setting,
                directions,
            } => {
                let mut values = vec![[0.0; 2]; setting.angles_rad.len()];
                for order in directions {
                    for (value, direction) in values.iter_mut().zip(order) {
                        let t =
                            direction.normalized_cross_section(radius, setting.wavelength, |z| {
                                setting.integral(z)
                            });
                        value[0] += t[0];
                        value[1] += t[1];
                    }
                }
                Ok(values)
            }
            Self::Published { setting, bows } => {
                let at = |&angle: &f64| {
                    sum(bows.iter().map(|bow| {
                        bow.published(radius, setting.wavelength, Radians(angle), |z| {
                            setting.integral(z)
                        })
                    }))
                };
                Ok(setting.angles_rad.iter().map(at).collect())
            }
            Self::Exact { setting, angles } => setting.exact(radius, angles),
        }
    }
}

impl Setting<'_> {
    fn integral(&self, z: f64) -> f64 {
        self.airy_table
            .map_or_else(|| airy_integral(z), |table| table.value(z))
    }

    fn exact(
        &self,
        radius: Micrometers,
        angles: &ScatteringAngles,
    ) -> Result<Vec<[f64; 2]>, Error> {
        let index = RefractiveIndex {
            n: self.index,
            k: 0.0,
        };
        let sphere = Sphere::from_radius(radius, self.wavelength, index);
        let sphere = sphere.map_err(|error| Error::Drop(error.to_string()))?;
        let Theory::Debye { max_order } = self.theory else {
            return Ok(sphere.waves().normalized_cross_sections(angles));
        };
        let series = sphere.debye_series();
        let mut values = vec![[0.0; 2]; angles.len()];
        // Ascending orders, so that the sum is the same on every run.
        for order in 0..=max_order {
            if BOW_ORDERS.contains(&order) && !self.orders.contains(&order) {
                continue;
            }
            let terms = series.order(order).normalized_cross_sections(angles);
            for (value, term) in values.iter_mut().zip(terms) {
                value[0] += term[0];
                value[1] += term[1];
            }
        }
        Ok(values)
    }
}

fn sum(terms: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    terms.fold([0.0; 2], |sum, term| [sum[0] + term[0], sum[1] + term[1]])
}
