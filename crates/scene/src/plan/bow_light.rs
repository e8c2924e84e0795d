//! How bright a unit of optical depth can look: luminance by scattering angle and order.
//!
//! P_p(theta) = (pi/0.18) sum_l y_l E_l t_p,l(theta) / sum_l y_l E_l
//! is the luminance that drops of optical depth 1 (Q = 1, thin) add, over that of a gray card of
//! albedo 0.18 facing the sun above the air. `t_p` = (dsigma/dOmega)/(pi <r^2>) (1/sr) of order `p`
//! in natural light, averaged over sizes and the sun's disc; `E_l` irradiance, `y_l` the observer.
//!
//! The stage that makes tables resolves fringes and lines that no bound needs: here sizes,
//! wavelengths and angles are coarse, and a margin on every maximum covers the difference.

use niji_airy::AiryBow;
use niji_airy::AiryTable;
use niji_airy::BowDirection;
use niji_airy::GeometricOrder;
use niji_airy::PublishedGeometricBow;
use niji_airy::UniformBow;
use niji_airy::rainbow_ray;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_scatter::Theory;

use super::curve::Curve;
use super::curve::STEP_RAD;
use super::size_mean::SizeMean;

/// Steps across the sun's disc that replace an average.
const MIN_STEPS_PER_DISC: f64 = 2.0;

/// A wavelength with its weight: what one unit of t at it adds to the relative luminance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// Index of the bin in the scene's spectrum.
    pub(super) index: usize,
    /// Center of the bin.
    pub(super) wavelength: Nanometers,
    /// Width of the bins that it stands for.
    pub(super) width: Nanometers,
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
    pub(super) water: Water,
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
    /// Computes the light of one order; the exact theories are those of its uniform form.
    pub(super) fn new(request: &LightRequest<'_>) -> Self {
        let angles: Vec<Radians> = angles_rad(request.theta_rad).map(Radians).collect();
        let power = match request.theory {
            Theory::AiryPublished => -2.0 / 3.0,
            Theory::GeometricPublished
            | Theory::Geometric
            | Theory::Airy
            | Theory::Uniform
            | Theory::Debye { .. }
            | Theory::Mie
            | Theory::BySize => 1.0 / 3.0,
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
            let rows = rows(request, &laws, line, &angles);
            for (values, row) in values.iter_mut().zip(rows) {
                values.push(row);
            }
        }
        Self {
            first_rad: request.theta_rad.0,
            values,
        }
    }

    /// Light of which a row, t of one size and line at all angles, is known.
    pub(super) fn of_rows(
        theta_rad: (f64, f64),
        (sizes, lines): (&[(f64, f64)], &[Line]),
        row: impl Fn((f64, f64), &Line, &[f64]) -> Vec<f64>,
    ) -> Self {
        let angles: Vec<f64> = angles_rad(theta_rad).collect();
        let of_size = |size: &(f64, f64)| {
            let rows = lines.iter().map(|line| row(*size, line, &angles));
            rows.collect()
        };
        Self {
            first_rad: theta_rad.0,
            values: sizes.iter().map(of_size).collect(),
        }
    }

    /// Whether it is no light of any size.
    pub(super) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// No light at any angle.
    pub(super) fn empty() -> Self {
        Self {
            first_rad: 0.0,
            values: Vec::new(),
        }
    }

    /// The light of both together.
    pub(super) fn plus(mut self, other: &Self) -> Self {
        let mine = self.values.iter_mut().flatten().flatten();
        for (sum, value) in mine.zip(other.values.iter().flatten().flatten()) {
            *sum += value;
        }
        self
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

    /// Relative luminance of every size by angle, with a factor for each line.
    pub(super) fn luminance_by_size(&self, lines: &[Line], factor: &[f64]) -> Vec<Vec<f64>> {
        let rows = self.values.iter();
        rows.map(|size| weighted(size, lines, factor)).collect()
    }

    /// Relative luminance by angle, with a factor for each line: largest over the sizes.
    pub(super) fn luminance(&self, lines: &[Line], factor: &[f64]) -> Curve {
        self.largest(self.luminance_by_size(lines, factor))
    }

    /// Largest difference of relative luminance to `other` by angle, over the sizes.
    pub(super) fn difference(&self, other: &Self, lines: &[Line], factor: &[f64]) -> Curve {
        let mine = self.luminance_by_size(lines, factor);
        let others = other.luminance_by_size(lines, factor);
        let rows = mine.iter().zip(&others);
        self.largest(rows.map(|(mine, others)| pointwise(mine, others, |a, b| (a - b).abs())))
    }

    /// The light with every row of a size, one for each line, replaced.
    pub(super) fn map_rows(&self, change: impl Fn(usize, &[f64]) -> Vec<f64>) -> Self {
        let of_size = |(size, lines): (usize, &Vec<Vec<f64>>)| {
            lines.iter().map(|row| change(size, row)).collect()
        };
        Self {
            first_rad: self.first_rad,
            values: self.values.iter().enumerate().map(of_size).collect(),
        }
    }

    /// The largest of rows over this light's angles.
    pub(super) fn largest(&self, rows: impl IntoIterator<Item = Vec<f64>>) -> Curve {
        let largest = rows.into_iter().reduce(|a, b| pointwise(&a, &b, f64::max));
        Curve {
            first_rad: self.first_rad,
            values: largest.unwrap_or_default(),
        }
    }
}

/// Angles of a range at even steps, its end included.
fn angles_rad((low, high): (f64, f64)) -> impl Iterator<Item = f64> {
    let n_steps = ((high - low).max(0.0) / STEP_RAD).ceil() as usize + 1;
    (0..=n_steps).map(move |index| low + STEP_RAD * index as f64)
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
    line: &Line,
    angles: &[Radians],
) -> Vec<Vec<f64>> {
    let wavelength = line.wavelength;
    let index = request.water.refractive_index(wavelength);
    let Some(light) = OrderLight::new(request, line, index) else {
        return vec![vec![0.0; angles.len()]; laws.len()];
    };
    let mut rows = vec![Vec::with_capacity(angles.len()); laws.len()];
    for theta in angles {
        let mut extend = |one: &LightOfLaw<'_>| {
            for (row, (radius, mean)) in rows.iter_mut().zip(laws) {
                row.push(natural(one(*radius, &|z| mean.squares(z, request.airy))));
            }
        };
        match &light {
            OrderLight::Rays(rays, caustic_rad) => {
                let light = near_caustic(rays, *caustic_rad, *theta);
                extend(&|_, _| light);
            }
            OrderLight::Colors(bow) => {
                let light = bow.normalized_cross_section(*theta);
                extend(&|_, _| light);
            }
            OrderLight::Published(bow) => {
                extend(&|radius, squares| bow.published(radius, wavelength, *theta, squares));
            }
            OrderLight::Airy(bow) => extend(&of_direction(&bow.direction(*theta), wavelength)),
            OrderLight::Uniform(bow) => extend(&of_direction(&bow.direction(*theta), wavelength)),
        }
    }
    rows
}

/// One order at one wavelength.
enum OrderLight {
    /// Rays, and where their light is not bounded.
    Rays(GeometricOrder, Option<f64>),
    /// The published color scale.
    Colors(PublishedGeometricBow),
    Published(AiryBow),
    Airy(AiryBow),
    Uniform(Box<UniformBow>),
}

impl OrderLight {
    /// An order that has no bow is rays in every theory; `None` if it does not exist.
    fn new(request: &LightRequest<'_>, line: &Line, index: f64) -> Option<Self> {
        let (theory, order) = (request.theory, request.order);
        let rays = || {
            let caustic_rad = rainbow_ray(index, order).map(|ray| ray.theta_rad());
            GeometricOrder::new(index, order).map(|rays| Self::Rays(rays, caustic_rad))
        };
        if theory == Theory::GeometricPublished {
            let bow = PublishedGeometricBow::new(line.wavelength, line.width).map(Self::Colors);
            // It knows the primary alone.
            return bow.filter(|_| order == FIRST_BOW);
        }
        if order < FIRST_BOW {
            return rays();
        }
        match theory {
            Theory::GeometricPublished | Theory::Geometric => rays(),
            Theory::AiryPublished => AiryBow::new(index, order).map(Self::Published),
            Theory::Airy => AiryBow::new(index, order).map(Self::Airy),
            Theory::Uniform | Theory::Debye { .. } | Theory::Mie | Theory::BySize => {
                let bow = UniformBow::new(index, order)?;
                Some(Self::Uniform(Box::new(bow)))
            }
        }
    }
}

/// The lowest order with a rainbow ray, the primary's.
const FIRST_BOW: u32 = 2;

/// Light of a direction for any law.
fn of_direction(
    direction: &BowDirection,
    wavelength: Nanometers,
) -> impl Fn(Micrometers, &dyn Fn(f64) -> [f64; 2]) -> [f64; 2] {
    move |radius, squares| direction.normalized_cross_section(radius, wavelength, squares)
}

/// Half of the narrowest ring over which tables average the light of rays, 0.005 degrees.
const HALF_RING_RAD: f64 = 0.005 * std::f64::consts::PI / 180.0;

/// Light of rays; within steps of the caustic, where it is not bounded, the largest mean over a ring
/// as narrow as in a table.
fn near_caustic(rays: &GeometricOrder, caustic_rad: Option<f64>, theta: Radians) -> [f64; 2] {
    let is_near = |caustic_rad: f64| (theta.0 - caustic_rad).abs() <= 3.0 * STEP_RAD;
    if !caustic_rad.is_some_and(is_near) {
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
