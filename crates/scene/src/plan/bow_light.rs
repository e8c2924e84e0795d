//! How bright a unit of optical depth can look: luminance by scattering angle and order.
//!
//! P_p(theta) = (pi/0.18) sum_l y_l E_l t_p,l(theta) / sum_l y_l E_l
//! is the luminance that drops of optical depth 1 (Q = 1, thin) add, over that of a gray card of
//! albedo 0.18 facing the sun above the air. `t_p` = (dsigma/dOmega)/(pi <r^2>) (1/sr) of order `p`
//! in natural light, averaged over sizes and the sun's disc; `E_l` irradiance, `y_l` the observer.
//!
//! The stage that makes tables resolves fringes and lines that no bound needs: here sizes,
//! wavelengths and angles are coarse, and [`MARGIN`] covers the difference.

use niji_airy::AiryBow;
use niji_airy::AiryTable;
use niji_airy::GeometricOrder;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::water_refractive_index;
use niji_scatter::Theory;

use super::size_mean::SizeMean;

/// Factor on every maximum, for the coarseness of this table.
pub(super) const MARGIN: f64 = 1.15;

/// Step of the angles, 0.05 degrees.
const STEP_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;

/// Steps across the sun's disc that replace an average.
const MIN_STEPS_PER_DISC: f64 = 2.0;

/// A wavelength with its weight: what one unit of t at it adds to the relative luminance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// Index of the bin in the scene's spectrum.
    pub(super) index: usize,
    /// Center of the bin.
    pub(super) wavelength: Nanometers,
    /// Share of the sun's luminance times pi/0.18.
    pub(super) weight: f64,
}

/// What a table of light is made from.
pub(super) struct LightRequest<'a> {
    pub(super) theory: Theory,
    pub(super) order: u32,
    pub(super) lines: &'a [Line],
    /// (effective radius (um), effective variance) of each row.
    pub(super) sizes: &'a [(f64, f64)],
    pub(super) theta_rad: (f64, f64),
    pub(super) temperature_c: f64,
    pub(super) airy: &'a AiryTable,
}

/// t of one order for a point sun, by size, wavelength and angle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BowLight {
    first_rad: f64,
    /// By size, line and angle.
    values: Vec<Vec<Vec<f64>>>,
}

impl BowLight {
    /// Computes the light of one order in Airy's theory, or of rays.
    pub(super) fn new(request: &LightRequest<'_>) -> Self {
        let (low, high) = request.theta_rad;
        let n_steps = ((high - low).max(0.0) / STEP_RAD).ceil() as usize + 1;
        let angles: Vec<Radians> = (0..=n_steps)
            .map(|index| Radians(low + STEP_RAD * index as f64))
            .collect();
        let power = match request.theory {
            Theory::AiryPublished => -2.0 / 3.0,
            Theory::GeometricPublished
            | Theory::Geometric
            | Theory::Airy
            | Theory::Uniform
            | Theory::Debye { .. }
            | Theory::Mie => 1.0 / 3.0,
        };
        let mean = |(radius_um, variance): &(f64, f64)| {
            (
                Micrometers(*radius_um),
                SizeMean::new(*variance, power, request.airy),
            )
        };
        let laws: Vec<(Micrometers, SizeMean)> = request.sizes.iter().map(mean).collect();
        let mut values = vec![Vec::with_capacity(request.lines.len()); laws.len()];
        for line in request.lines {
            let rows = rows(request, &laws, line.wavelength, &angles);
            for (values, row) in values.iter_mut().zip(rows) {
                values.push(row);
            }
        }
        Self {
            first_rad: low,
            values,
        }
    }

    /// The same light from a sun of `diameter_rad`: the mean over the disc, which across the bow is
    /// a mean weighted by the chords of the disc.
    pub(super) fn seen_from_disc(&self, diameter_rad: f64) -> Self {
        let reach = 0.5 * diameter_rad / STEP_RAD;
        if reach < MIN_STEPS_PER_DISC {
            return self.clone();
        }
        let n_side = reach.ceil() as i64;
        let chord = |offset: i64| (1.0 - (offset as f64 / reach).powi(2)).max(0.0).sqrt();
        let average = |row: &Vec<f64>| {
            (0..row.len() as i64)
                .map(|center| {
                    let (mut sum, mut norm) = (0.0, 0.0);
                    for offset in -n_side..=n_side {
                        let index = (center + offset).clamp(0, row.len() as i64 - 1) as usize;
                        sum += chord(offset) * row[index];
                        norm += chord(offset);
                    }
                    sum / norm
                })
                .collect()
        };
        let values = self
            .values
            .iter()
            .map(|lines| lines.iter().map(average).collect())
            .collect();
        Self {
            first_rad: self.first_rad,
            values,
        }
    }

    /// Relative luminance by angle, with a factor for each line: largest over the sizes.
    pub(super) fn luminance(&self, lines: &[Line], factor: &[f64]) -> Curve {
        let rows = self.values.iter().map(|size| weighted(size, lines, factor));
        self.curve(rows.reduce(|a, b| pointwise(&a, &b, f64::max)))
    }

    /// Largest difference of relative luminance to `other` by angle, over the sizes.
    pub(super) fn difference(&self, other: &Self, lines: &[Line], factor: &[f64]) -> Curve {
        let rows = self.values.iter().zip(&other.values).map(|(mine, others)| {
            let others = weighted(others, lines, factor);
            pointwise(&weighted(mine, lines, factor), &others, |a, b| {
                (a - b).abs()
            })
        });
        self.curve(rows.reduce(|a, b| pointwise(&a, &b, f64::max)))
    }

    fn curve(&self, values: Option<Vec<f64>>) -> Curve {
        Curve {
            first_rad: self.first_rad,
            values: values.unwrap_or_default(),
        }
    }
}

fn weighted(size: &[Vec<f64>], lines: &[Line], factor: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; size.first().map_or(0, Vec::len)];
    for ((row, line), factor) in size.iter().zip(lines).zip(factor) {
        for (sum, value) in sum.iter_mut().zip(row) {
            *sum += line.weight * factor * value;
        }
    }
    sum
}

fn pointwise(a: &[f64], b: &[f64], combine: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| combine(*a, *b)).collect()
}

/// Light by effective radius and what stands for f(z), both polarizations.
type LightOfLaw<'a> = dyn Fn(Micrometers, &dyn Fn(f64) -> [f64; 2]) -> [f64; 2] + 'a;

/// t of every law at one wavelength for all angles, natural light, 1/sr.
fn rows(
    request: &LightRequest<'_>,
    laws: &[(Micrometers, SizeMean)],
    wavelength: Nanometers,
    angles: &[Radians],
) -> Vec<Vec<f64>> {
    let index = water_refractive_index(wavelength, request.temperature_c);
    let (Some(rays), Some(bow)) = (
        GeometricOrder::new(index, request.order),
        AiryBow::new(index, request.order),
    ) else {
        return vec![vec![0.0; angles.len()]; laws.len()];
    };
    let mut rows = vec![Vec::with_capacity(angles.len()); laws.len()];
    let mut extend = |one: &LightOfLaw<'_>| {
        for (row, (radius, mean)) in rows.iter_mut().zip(laws) {
            row.push(natural(one(*radius, &|z| mean.squares(z, request.airy))));
        }
    };
    for theta in angles {
        match request.theory {
            Theory::GeometricPublished | Theory::Geometric => {
                let light = near_caustic(&rays, bow.ray().theta_rad(), *theta);
                extend(&|_, _| light);
            }
            Theory::AiryPublished => {
                extend(&|radius, squares| bow.published(radius, wavelength, *theta, squares));
            }
            Theory::Airy | Theory::Uniform | Theory::Debye { .. } | Theory::Mie => {
                let direction = bow.direction(*theta);
                extend(&|radius, squares| {
                    direction.normalized_cross_section(radius, wavelength, squares)
                });
            }
        }
    }
    rows
}

/// Half of the narrowest ring over which tables average the light of rays, 0.005 degrees.
const HALF_RING_RAD: f64 = 0.005 * std::f64::consts::PI / 180.0;

/// Light of rays; within steps of the caustic, where it is not bounded, the largest mean over a ring
/// as narrow as in a table.
fn near_caustic(rays: &GeometricOrder, caustic_rad: f64, theta: Radians) -> [f64; 2] {
    if (theta.0 - caustic_rad).abs() > 3.0 * STEP_RAD {
        return rays.normalized_cross_section(theta);
    }
    let ring = |center_rad: f64| {
        let (from, to) = (center_rad - HALF_RING_RAD, center_rad + HALF_RING_RAD);
        rays.mean_over_ring(Radians(from), Radians(to))
    };
    let offsets = (-5..=5).map(|offset| f64::from(offset) * HALF_RING_RAD);
    let larger = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
    offsets
        .map(|offset| ring(theta.0 + offset))
        .fold([0.0; 2], larger)
}

/// Unpolarized light of both polarizations.
fn natural([s, p]: [f64; 2]) -> f64 {
    0.5 * (s + p)
}

/// A quantity by scattering angle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    first_rad: f64,
    values: Vec<f64>,
}

impl Curve {
    /// No light at any angle.
    pub(super) fn empty() -> Self {
        Self {
            first_rad: 0.0,
            values: Vec::new(),
        }
    }

    /// Largest value within a range of angles, the neighbors of its ends included, times
    /// [`MARGIN`]; 0 beyond the curve.
    pub(super) fn max_within(&self, (low_rad, high_rad): (f64, f64)) -> f64 {
        let place = |theta_rad: f64| (theta_rad - self.first_rad) / STEP_RAD;
        if self.values.is_empty() || place(high_rad) < 0.0 {
            return 0.0;
        }
        let first = place(low_rad).floor().max(0.0) as usize;
        let last = (place(high_rad).ceil() as usize).min(self.values.len() - 1);
        let range = self.values.get(first..=last).unwrap_or_default();
        MARGIN * range.iter().fold(0.0, |max: f64, value| max.max(*value))
    }

    /// Pointwise sum of curves over the same angles.
    pub(super) fn plus(&self, other: &Self) -> Self {
        if self.values.is_empty() {
            return other.clone();
        }
        let mut sum = self.clone();
        for (sum, value) in sum.values.iter_mut().zip(&other.values) {
            *sum += value;
        }
        sum
    }

    /// Pointwise larger of two curves over the same angles.
    pub(super) fn or_larger(&self, other: &Self) -> Self {
        if self.values.is_empty() {
            return other.clone();
        }
        let mut larger = self.clone();
        for (larger, value) in larger.values.iter_mut().zip(&other.values) {
            *larger = larger.max(*value);
        }
        larger
    }

    /// The curve with zeros where `keep` does not hold.
    pub(super) fn only(&self, keep: impl Fn(f64) -> bool) -> Self {
        let angle = |index: usize| self.first_rad + STEP_RAD * index as f64;
        let values = self.values.iter().enumerate();
        let values = values
            .map(|(i, value)| if keep(angle(i)) { *value } else { 0.0 })
            .collect();
        Self {
            first_rad: self.first_rad,
            values,
        }
    }
}
