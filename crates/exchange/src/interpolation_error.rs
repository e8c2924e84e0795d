//! What linear interpolation between the nodes of a table costs, as its header states it.

use std::f64::consts::FRAC_PI_2;

use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::error::Error;
use crate::table::TablePart;

/// Stretches of angles in which a table errs by parts of another peak.
pub const N_STRETCHES: usize = 10;

/// Which stretch a scattering angle lies in: all angles behind 90 degrees, then halves, quarters and so on of those in
/// front; the last is within the sun's disc. Beside light that is diffracted forward a bow is nothing.
#[must_use]
pub fn stretch_of(theta_rad: f64) -> usize {
    let n_halvings = (FRAC_PI_2 / theta_rad).log2().floor() + 1.0;
    (n_halvings.max(0.0) as usize).min(N_STRETCHES - 1)
}

/// Error of linear interpolation half way between nodes, in parts of the peak of a row in the same stretch of angles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisError {
    /// Root of the mean square over the angles.
    pub rms: f64,
    /// Largest over the angles.
    pub max: f64,
}

/// Errors of interpolation along each axis; 0 for an axis of one node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InterpolationError {
    /// Along the scattering angle.
    pub theta: AxisError,
    /// Along the effective radius.
    pub radius: AxisError,
    /// Along the effective variance.
    pub variance: AxisError,
}

/// Attributes: error of which axis, and how it was taken.
fn name(axis: &str, measure: &str) -> String {
    format!("niji:interpolationError.{axis}.{measure}")
}

impl InterpolationError {
    /// The axes by name.
    pub fn axes(&self) -> [(&'static str, AxisError); 3] {
        [
            ("theta", self.theta),
            ("effective_radius", self.radius),
            ("effective_variance", self.variance),
        ]
    }

    pub(crate) fn attributes(&self) -> Attributes {
        let of_axis = |(axis, error): (&str, AxisError)| {
            [("rms", error.rms), ("max", error.max)]
                .map(|(measure, value)| (name(axis, measure), AttributeValue::Number(value)))
        };
        self.axes().into_iter().flat_map(of_axis).collect()
    }

    /// The statement of a header; `None` where there is none.
    pub(crate) fn read(part: &TablePart) -> Result<Option<Self>, Error> {
        if !part.attributes.contains_key(&name("theta", "rms")) {
            return Ok(None);
        }
        let of_axis = |axis: &str| -> Result<AxisError, Error> {
            Ok(AxisError {
                rms: part.number(&name(axis, "rms"))?,
                max: part.number(&name(axis, "max"))?,
            })
        };
        let [theta, radius, variance] = Self::default().axes().map(|(axis, _)| axis);
        Ok(Some(Self {
            theta: of_axis(theta)?,
            radius: of_axis(radius)?,
            variance: of_axis(variance)?,
        }))
    }
}
