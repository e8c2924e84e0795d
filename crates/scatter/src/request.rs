//! What a scattering table is made from, and what can be wrong with it.

use std::f64::consts::PI;

use niji_airy::AiryTable;
use niji_radiometry::WavelengthGrid;

use crate::error::Error;
use crate::theory::Theory;

/// What a scattering table is made from.
#[derive(Clone, Debug)]
pub struct TableRequest<'a> {
    /// How a drop scatters.
    pub theory: Theory,
    /// Orders with a bow that take part, 2 primary, 3 secondary; ignored by [`Theory::Mie`].
    pub orders: Vec<u32>,
    /// Smallest and largest scattering angle in radians.
    pub theta_range_rad: (f64, f64),
    /// Error of linear interpolation in θ over the peak of the bow.
    pub theta_tolerance: f64,
    /// Wavelength bins.
    pub wavelengths: WavelengthGrid,
    /// Effective radii in micrometres, see [`crate::radius_axis`].
    pub effective_radius_um: Vec<f64>,
    /// Effective variances, see [`crate::variance_axis`].
    pub effective_variance: Vec<f64>,
    /// How far the flattening of large drops moves the bow, ascending within -1 to 1; `[0.0]` for
    /// spheres.
    pub flattening: Vec<f64>,
    /// Diameter of the sun's disc in radians; 0 for a point.
    pub sun_disc_diameter_rad: f64,
    /// Temperature of the water in degrees Celsius.
    pub temperature_c: f64,
    /// Airy's integral in advance; `None` computes every value.
    pub airy_table: Option<&'a AiryTable>,
}

impl TableRequest<'_> {
    pub(crate) fn check(&self) -> Result<(), Error> {
        let radii = &self.effective_radius_um;
        let sound_radius = |radius: &f64| *radius > 0.0 && radius.is_finite();
        if !(is_ascending(radii) && radii.iter().all(sound_radius)) {
            let expected = "ascending radii above 0 um";
            return Err(axis("effective radius", format!("{radii:?}"), expected));
        }
        let variances = &self.effective_variance;
        let sound_variance = |variance: &f64| (0.0..0.5).contains(variance);
        if !(is_ascending(variances) && variances.iter().all(sound_variance)) {
            let expected = "ascending values from 0 to below 0.5";
            return Err(axis(
                "effective variance",
                format!("{variances:?}"),
                expected,
            ));
        }
        let (low, high) = self.theta_range_rad;
        if !(low >= 0.0 && high > low && high <= PI + 1e-12) {
            let found = format!("{} to {} degrees", low.to_degrees(), high.to_degrees());
            return Err(axis("theta", found, "a range within 0 to 180 degrees"));
        }
        let tolerance = self.theta_tolerance;
        if !(tolerance > 0.0 && tolerance <= 1.0) {
            return Err(axis(
                "theta tolerance",
                tolerance.to_string(),
                "above 0 and at most 1",
            ));
        }
        if !(0.0..0.1).contains(&self.sun_disc_diameter_rad) {
            let found = format!("{} rad", self.sun_disc_diameter_rad);
            return Err(axis("sun disc", found, "0 to 0.1 rad"));
        }
        let sound_orders =
            !self.orders.is_empty() && self.orders.iter().all(|p| (2..8).contains(p));
        if self.theory != Theory::Mie && !sound_orders {
            return Err(Error::Orders {
                found: self.orders.clone(),
            });
        }
        Ok(())
    }
}

/// Not empty, and every value above the one before; a NaN is above none.
fn is_ascending(values: &[f64]) -> bool {
    !values.is_empty() && values.windows(2).all(|pair| pair[1] > pair[0])
}

fn axis(axis: &'static str, found: String, expected: &'static str) -> Error {
    Error::Axis {
        axis,
        found,
        expected,
    }
}
