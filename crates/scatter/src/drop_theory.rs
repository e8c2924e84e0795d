//! One drop after the other by an exact theory, at one wavelength, on one grid of angles.

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
}

/// An exact theory, ready for drops of any size at one wavelength.
pub(crate) struct DropTheory<'a> {
    setting: Setting<'a>,
    angles: ScatteringAngles,
}

impl<'a> DropTheory<'a> {
    pub(crate) fn new(setting: Setting<'a>) -> Result<Self, Error> {
        let angles: Vec<Radians> = setting.angles_rad.iter().copied().map(Radians).collect();
        let angles = ScatteringAngles::new(&angles);
        let angles = angles.map_err(|error| Error::Drop(error.to_string()))?;
        Ok(Self { setting, angles })
    }

    /// (dσ/dΩ)/(π a²) of one drop in 1/sr at every angle, for both polarisations.
    pub(crate) fn drop(&self, radius: Micrometers) -> Result<Vec<[f64; 2]>, Error> {
        let index = RefractiveIndex {
            n: self.setting.index,
            k: 0.0,
        };
        let sphere = Sphere::from_radius(radius, self.setting.wavelength, index);
        let sphere = sphere.map_err(|error| Error::Drop(error.to_string()))?;
        let Theory::Debye { max_order } = self.setting.theory else {
            return Ok(sphere.waves().normalized_cross_sections(&self.angles));
        };
        let series = sphere.debye_series();
        let mut values = vec![[0.0; 2]; self.angles.len()];
        // Ascending orders, so that the sum is the same on every run.
        for order in 0..=max_order {
            if BOW_ORDERS.contains(&order) && !self.setting.orders.contains(&order) {
                continue;
            }
            let terms = series.order(order).normalized_cross_sections(&self.angles);
            for (value, term) in values.iter_mut().zip(terms) {
                value[0] += term[0];
                value[1] += term[1];
            }
        }
        Ok(values)
    }
}
