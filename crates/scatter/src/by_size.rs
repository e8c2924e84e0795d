//! Theory by size: Lorenz and Mie's for small drops, the uniform theory with diffracted light for large ones.
//!
//! t = W t_exact + (1 − W) (t_uniform + t_diffracted),   W = 1 − p² (3 − 2 p),   p = log2(x/x1) in 0..1
//! ε(x) = 9.6/x,   x1 = 5/tolerance
//! `x` = 2π r/λ; `W` share of the exact solution, 1 up to x1 and 0 from 2 x1 on; `ε` what the uniform theory
//! errs by in parts of the peak of the bow. Of the rest, (1 − W) ε is largest near 2 x1, 0.52 ε(x1): the
//! tolerance. Bins and single sizes have the share of their own radius, laws of each radius in them.
//!
//! ε is measured: uniform theory with orders 0 to 7 against the exact solution, gamma laws of v_e = 0.1, rms
//! over bow angles of 15 to 80 degrees: ε x = 10.1, 9.8, 9.7 and 9.6 at 450 nm (30, 60, 90 and 180 µm),
//! 10.4, 10.1, 10.0, 9.6 at 650. In the bow alone, 30 to 45 degrees, it is half of that; within 15 degrees
//! of the antisolar point it has no glory.
//!
//! A law, or a mixture of laws, whose small drops the uniform theory makes to the tolerance in the bow, ε/2
//! weighed with W, has no drop computed; one with next to no large drops has no uniform light.

use std::f64::consts::TAU;

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;
use niji_sizes::gamma_area_quadrature;

use crate::error::Error;
use crate::request::TableRequest;
use crate::size_average::is_cell_row;
use crate::theory::Theory;

/// ε x in the bow, and x1 times the tolerance.
const BOW_ERROR_TIMES_X: f64 = 4.8;
const FIRST_X_TIMES_TOLERANCE: f64 = 5.0;
/// Share of the cross-section of a law in large drops that are left to the exact solution.
const LEFT_OUT: f64 = 1e-4;
/// Nodes of a law.
const N_SIZES: usize = 64;

/// Which drops are computed exactly.
#[derive(Clone, Debug)]
pub(crate) struct Blend {
    tolerance: f64,
    /// By row, the variance fastest.
    rows: Vec<RowSizes>,
}

/// The sizes of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RowSizes {
    /// One, or a bin around it (µm).
    One(f64),
    /// A law with small drops and large ones.
    Law,
    /// A law of exact light alone.
    SmallLaw,
    /// A law of the uniform theory alone.
    LargeLaw,
}

impl Blend {
    pub(crate) fn new(request: &TableRequest) -> Result<Self, Error> {
        let radii = &request.effective_radius_um;
        let mut rows = Vec::with_capacity(radii.len() * request.effective_variance.len());
        for (index, &radius_um) in radii.iter().enumerate() {
            for &variance in &request.effective_variance {
                let law = (Micrometers(radius_um), variance);
                let is_one = variance <= 0.0 || is_cell_row(radii, index, variance);
                let theory = theory_for_law(law, request.wavelengths, request.tolerance)?;
                rows.push(if is_one {
                    RowSizes::One(radius_um)
                } else if theory == Theory::Uniform {
                    RowSizes::LargeLaw
                } else if theory == Theory::Mie {
                    RowSizes::SmallLaw
                } else {
                    RowSizes::Law
                });
            }
        }
        Ok(Self {
            tolerance: request.tolerance,
            rows,
        })
    }

    /// What the weight of a drop in a row is multiplied by.
    pub(crate) fn weight(&self, row: usize, drop: Micrometers, wavelength: Nanometers) -> f64 {
        match self.rows[row] {
            RowSizes::One(_) => f64::from(u8::from(self.share(row, wavelength) > 0.0)),
            RowSizes::Law => exact_share(drop, wavelength, self.tolerance),
            RowSizes::SmallLaw => 1.0,
            RowSizes::LargeLaw => 0.0,
        }
    }

    /// Share of the exact light of a row; that of a law is in its weights.
    pub(crate) fn share(&self, row: usize, wavelength: Nanometers) -> f64 {
        match self.rows[row] {
            RowSizes::One(radius_um) => {
                exact_share(Micrometers(radius_um), wavelength, self.tolerance)
            }
            RowSizes::Law | RowSizes::SmallLaw => 1.0,
            RowSizes::LargeLaw => 0.0,
        }
    }

    /// Whether a row is a law with small drops and large ones.
    pub(crate) fn is_mixed_law(&self, row: usize) -> bool {
        self.rows[row] == RowSizes::Law
    }
}

/// W.
pub(crate) fn exact_share(radius: Micrometers, wavelength: Nanometers, tolerance: f64) -> f64 {
    let first_x = FIRST_X_TIMES_TOLERANCE / tolerance;
    let p = (size_parameter(radius, wavelength) / first_x)
        .log2()
        .clamp(0.0, 1.0);
    1.0 - p * p * (3.0 - 2.0 * p)
}

/// The theory that [`Theory::BySize`] comes to for a gamma law of an effective radius and variance.
fn theory_for_law(
    (radius, effective_variance): (Micrometers, f64),
    wavelengths: WavelengthGrid,
    tolerance: f64,
) -> Result<Theory, Error> {
    theory_for_laws([(radius, effective_variance, 1.0)], wavelengths, tolerance)
}

/// The theory that [`Theory::BySize`] comes to for a mixture of gamma laws of an effective radius, an effective
/// variance and a share of the cross-section each: itself, or the one of the two that makes all of its light.
///
/// # Errors
/// [`Error::Drop`] for a law that does not exist.
///
/// ```
/// use niji_radiometry::{Micrometers, WavelengthGrid};
/// use niji_scatter::{Theory, theory_for_laws};
///
/// let wavelengths = WavelengthGrid::new(380.0, 10.0, 41)?;
/// let theory = |radius_um, variance| {
///     theory_for_laws([(Micrometers(radius_um), variance, 1.0)], wavelengths, 5e-3)
/// };
/// assert_eq!(theory(10.0, 0.1)?, Theory::Mie);
/// assert_eq!(theory(60.0, 0.1)?, Theory::BySize);
/// assert_eq!(theory(500.0, 1.0 / 3.0)?, Theory::Uniform);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn theory_for_laws(
    laws: impl IntoIterator<Item = (Micrometers, f64, f64)>,
    wavelengths: WavelengthGrid,
    tolerance: f64,
) -> Result<Theory, Error> {
    let mut sizes: Vec<(f64, f64)> = Vec::new();
    for (radius, variance, share) in laws {
        let of_law = gamma_area_quadrature(radius, variance, N_SIZES)?;
        sizes.extend(
            of_law
                .into_iter()
                .map(|(radius_um, weight)| (radius_um, share * weight)),
        );
    }
    let [shortest, middle] = [0, wavelengths.len() / 2].map(|index| wavelengths.center(index));
    let uniform_weight = |(radius_um, weight): &(f64, f64)| {
        weight * (1.0 - exact_share(Micrometers(*radius_um), shortest, tolerance))
    };
    if sizes.iter().map(uniform_weight).sum::<f64>() <= LEFT_OUT {
        return Ok(Theory::Mie);
    }
    let error = |(radius_um, weight): &(f64, f64)| {
        let radius = Micrometers(*radius_um);
        let of_uniform = (BOW_ERROR_TIMES_X / size_parameter(radius, middle)).min(1.0);
        weight * exact_share(radius, middle, tolerance) * of_uniform
    };
    if sizes.iter().map(error).sum::<f64>() <= tolerance {
        return Ok(Theory::Uniform);
    }
    Ok(Theory::BySize)
}

fn size_parameter(radius: Micrometers, wavelength: Nanometers) -> f64 {
    TAU * 1e3 * radius.0 / wavelength.0
}
