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

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;
use niji_sizes::gamma_area_quadrature;

use crate::error::Error;
use crate::request::SizeRow;
use crate::request::TableRequest;
use crate::size_average::is_cell_row;
use crate::theory::Theory;
use niji_radiometry::size_parameter;

/// ε x in the bow, and x1 times the tolerance.
const BOW_ERROR_TIMES_X: f64 = 4.8;
const FIRST_X_TIMES_TOLERANCE: f64 = 5.0;
/// Share of the cross-section of a law in large drops that are left to the exact solution.
const LEFT_OUT: f64 = 1e-4;
/// Nodes of a law.
const N_SIZES: usize = 64;

/// Of what each row of a table is made: bows, single drops or both, in a table by size.
#[derive(Clone, Debug)]
pub(crate) struct Blend {
    tolerance: f64,
    rows: Vec<Makers>,
}

/// What makes the light of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Makers {
    /// Bows alone, as of a law of large drops.
    Bows,
    /// Single drops alone, as of a law of small ones.
    Drops,
    /// Both of one size, or of a bin around it.
    OneSize(Micrometers),
    /// Both, of a law with small drops and large ones.
    MixedLaw,
}

impl Blend {
    pub(crate) fn new(request: &TableRequest) -> Result<Self, Error> {
        let of_theory = |theory: Theory| {
            let method = theory.method();
            match (method.bows, method.drops) {
                (Some(_), Some(_)) => Makers::MixedLaw,
                (Some(_), None) => Makers::Bows,
                (None, _) => Makers::Drops,
            }
        };
        let radii = &request.effective_radius_um;
        let makers = |row: SizeRow| {
            let is_one = row.variance <= 0.0 || is_cell_row(radii, row.radius_index, row.variance);
            match of_theory(request.theory) {
                Makers::MixedLaw if is_one => Ok(Makers::OneSize(row.radius)),
                Makers::MixedLaw => {
                    let law = SizeLaw {
                        radius: row.radius,
                        variance: row.variance,
                        share: 1.0,
                    };
                    theory_for_laws([law], request.wavelengths, request.tolerance).map(of_theory)
                }
                alone => Ok(alone),
            }
        };
        let rows = request.size_rows().map(makers);
        Ok(Self {
            tolerance: request.tolerance,
            rows: rows.collect::<Result<_, Error>>()?,
        })
    }

    /// What the weight of a drop in a row is multiplied by.
    pub(crate) fn share_of_drop(
        &self,
        row: usize,
        drop: Micrometers,
        wavelength: Nanometers,
    ) -> f64 {
        match self.rows[row] {
            Makers::Bows => 0.0,
            Makers::Drops => 1.0,
            Makers::OneSize(radius) => exact_share(radius, wavelength, self.tolerance),
            Makers::MixedLaw => exact_share(drop, wavelength, self.tolerance),
        }
    }

    /// What the bows of a row are multiplied by; out of those of a mixed law the bows of single drops are taken.
    pub(crate) fn share_of_bows(&self, row: usize, wavelength: Nanometers) -> f64 {
        match self.rows[row] {
            Makers::Bows | Makers::MixedLaw => 1.0,
            Makers::Drops => 0.0,
            Makers::OneSize(radius) => 1.0 - exact_share(radius, wavelength, self.tolerance),
        }
    }

    /// Whether a row is a law with small drops and large ones.
    pub(crate) fn is_mixed_law(&self, row: usize) -> bool {
        self.rows[row] == Makers::MixedLaw
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

/// A gamma law of sizes in a mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeLaw {
    /// Effective radius.
    pub radius: Micrometers,
    /// Effective variance.
    pub variance: f64,
    /// Share of the cross-section.
    pub share: f64,
}

/// The theory that [`Theory::BySize`] comes to for a mixture of laws: itself, or the one of the two that makes all
/// of its light.
///
/// # Errors
/// [`Error::Drop`] for a law that does not exist.
///
/// ```
/// use niji_radiometry::{Micrometers, WavelengthGrid};
/// use niji_scatter::{SizeLaw, Theory, theory_for_laws};
///
/// let wavelengths = WavelengthGrid::new(380.0, 10.0, 41)?;
/// let theory = |radius_um, variance| {
///     let law = SizeLaw { radius: Micrometers(radius_um), variance, share: 1.0 };
///     theory_for_laws([law], wavelengths, 5e-3)
/// };
/// assert_eq!(theory(10.0, 0.1)?, Theory::Mie);
/// assert_eq!(theory(60.0, 0.1)?, Theory::BySize);
/// assert_eq!(theory(500.0, 1.0 / 3.0)?, Theory::Uniform);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn theory_for_laws(
    laws: impl IntoIterator<Item = SizeLaw>,
    wavelengths: WavelengthGrid,
    tolerance: f64,
) -> Result<Theory, Error> {
    let [small_drops, large_drops] = Theory::SMALL_AND_LARGE;
    let mut sizes: Vec<(f64, f64)> = Vec::new();
    for law in laws {
        let of_law = gamma_area_quadrature(law.radius, law.variance, N_SIZES)?.into_iter();
        sizes.extend(of_law.map(|(radius_um, weight)| (radius_um, law.share * weight)));
    }
    let [shortest, middle] = [0, wavelengths.len() / 2].map(|index| wavelengths.center(index));
    let uniform_weight = |(radius_um, weight): &(f64, f64)| {
        weight * (1.0 - exact_share(Micrometers(*radius_um), shortest, tolerance))
    };
    if sizes.iter().map(uniform_weight).sum::<f64>() <= LEFT_OUT {
        return Ok(small_drops);
    }
    let error = |(radius_um, weight): &(f64, f64)| {
        let radius = Micrometers(*radius_um);
        let of_uniform = (BOW_ERROR_TIMES_X / size_parameter(radius, middle)).min(1.0);
        weight * exact_share(radius, middle, tolerance) * of_uniform
    };
    if sizes.iter().map(error).sum::<f64>() <= tolerance {
        return Ok(large_drops);
    }
    Ok(Theory::BySize)
}
