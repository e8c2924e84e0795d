//! An order of one wavelength by rays, Airy's theory or the uniform one, for every size law.
//!
//! t_j = x^(1/3) (A_j F(z) + B_j x^(−2/3) G(z)) + rays_j,   z = argument x^(2/3)
//! What does not depend on size is computed once: the argument at the edges of the rings and the strengths A,
//! B and rays in them; [`MeanSquare`] then gives the means F and G over sizes and
//! ring. Orders without a bow, 0 and 1, are rays in every theory.

use std::ops::Range;

use niji_airy::AiryBow;
use niji_airy::AiryForm;
use niji_airy::BowDirection;
use niji_airy::GeometricOrder;
use niji_airy::PublishedGeometricBow;
use niji_airy::UniformBow;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use rayon::prelude::*;

use crate::mean_square::MeanSquare;
use crate::mean_square::Primitives;
use crate::request::TableRequest;
use crate::rings::DiscAverage;
use crate::rings::Rings;
use crate::sun_disc::AverageRow;
use niji_radiometry::size_parameter;

/// Where light is asked for.
#[derive(Clone, Debug)]
pub(crate) enum Places {
    /// Means over rings, to be averaged over the sun's disc.
    Rings(Rings),
    /// Single directions, for a sun without a disc.
    Angles(Vec<f64>),
}

/// Most rings across the sun's disc. Against a literal average over the disc, in parts of the peak: 1.7e-5
/// for single drops of 0.1 mm, 6e-4 for 1 mm and 1e-3 for 1.5 mm radius at 400 nm, 12 degrees inside.
const MOST_RINGS_PER_DISC: f64 = 20.0;
/// Fewest of them, and the tolerance below which there are no more.
const FEWEST_RINGS_PER_DISC: f64 = 6.0;
const FINEST_TOLERANCE: f64 = 1.3e-3;

/// Rings across the sun's disc for a table of a tolerance. The hardest light, of single drops of 1.5 mm radius at
/// 400 nm, errs RMS by 3.2e-4, 8.5e-4, 2.0e-3 and 3.7e-3 of its peak with 20, 14, 10 and 7 rings: a quarter of the
/// tolerance.
fn rings_per_disc(tolerance: f64) -> f64 {
    let rings = MOST_RINGS_PER_DISC * (FINEST_TOLERANCE / tolerance).powf(0.4);
    rings.clamp(FEWEST_RINGS_PER_DISC, MOST_RINGS_PER_DISC)
}

impl Places {
    /// Places where light is computed for the angles of a table.
    pub(crate) fn of_table(request: &TableRequest, theta_rad: &[f64]) -> Self {
        let radius_rad = request.disc_radius_rad();
        if radius_rad <= 0.0 {
            return Self::Angles(theta_rad.to_vec());
        }
        let step_rad = 2.0 * radius_rad / rings_per_disc(request.tolerance);
        Self::Rings(Rings::over(request.theta_range_rad, step_rad, radius_rad))
    }

    /// The average over the disc around each angle of a table, by rows of rings.
    pub(crate) fn disc_average(
        &self,
        theta_rad: &[f64],
        row: impl Fn(&Rings, f64) -> AverageRow + Sync,
    ) -> DiscAverage {
        match self {
            Self::Rings(rings) => {
                let rows = theta_rad.par_iter().map(|theta| row(rings, *theta));
                DiscAverage(rows.collect())
            }
            Self::Angles(angles) => DiscAverage::of_point(angles.len()),
        }
    }

    pub(crate) fn n(&self) -> usize {
        match self {
            Self::Rings(rings) => rings.n,
            Self::Angles(angles) => angles.len(),
        }
    }

    /// Middle of a ring, or the direction itself.
    fn middle(&self, index: usize) -> Radians {
        match self {
            Self::Rings(rings) => Radians(rings.middle_rad(index)),
            Self::Angles(angles) => Radians(angles[index]),
        }
    }
}

/// One wavelength of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bin {
    pub(crate) center: Nanometers,
    pub(crate) width: Nanometers,
    /// Refractive index of the water at the center.
    pub(crate) index: f64,
}

impl Bin {
    pub(crate) fn new(request: &TableRequest, index: usize) -> Self {
        let center = request.wavelengths.center(index);
        Self {
            center,
            width: Nanometers(request.wavelengths.step_nm()),
            index: request.water.refractive_index(center),
        }
    }
}

/// How the bows are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BowTheory {
    /// The published color scale.
    Colors,
    /// Rays alone.
    Geometric,
    /// Airy's theory.
    Airy(AiryForm),
    /// The uniform theory.
    Uniform,
}

impl BowTheory {
    /// The form of the factor that depends on size.
    pub(crate) fn form(self) -> AiryForm {
        match self {
            Self::Airy(form) => form,
            Self::Colors | Self::Geometric | Self::Uniform => AiryForm::Absolute,
        }
    }

    /// Whether its light depends on the size of drops.
    pub(crate) fn has_waves(self) -> bool {
        match self {
            Self::Airy(_) | Self::Uniform => true,
            Self::Colors | Self::Geometric => false,
        }
    }

    /// An order in this theory; `None` where it does not exist.
    pub(crate) fn order(self, bin: Bin, p: u32) -> Option<Order> {
        let waves = p >= 2;
        let index = bin.index;
        Some(match self {
            Self::Colors => Order::Colors(PublishedGeometricBow::new(bin.center, bin.width)?),
            Self::Airy(form) if waves => Order::Airy(AiryBow::new(index, p)?, form),
            Self::Uniform if waves => Order::Uniform(Box::new(UniformBow::new(index, p)?)),
            Self::Geometric | Self::Airy(_) | Self::Uniform => {
                Order::Rays(GeometricOrder::new(index, p)?)
            }
        })
    }
}

/// One order of a drop.
#[derive(Clone, Debug)]
pub(crate) enum Order {
    Colors(PublishedGeometricBow),
    Rays(GeometricOrder),
    Airy(AiryBow, AiryForm),
    Uniform(Box<UniformBow>),
}

impl Order {
    /// Leaves away what is darker than z x^(−2/3) for all drops.
    pub(crate) fn above(self, darkest: f64) -> Self {
        match self {
            Self::Uniform(bow) => Self::Uniform(Box::new(bow.above(darkest))),
            other => other,
        }
    }
}

/// One order of one wavelength.
#[derive(Clone, Debug)]
pub(crate) struct BowLight {
    /// What no size changes, in 1/sr.
    rays: Vec<[f64; 2]>,
    waves: Option<Waves>,
}

/// The part of an order that depends on size.
#[derive(Clone, Debug)]
struct Waves {
    /// Places where a strength is not zero.
    active: Range<usize>,
    /// z x^(−2/3) at the edges of the active rings, or in the active directions.
    arguments: Vec<f64>,
    /// A and B of both polarisations, for each active place.
    strengths: Vec<[[f64; 2]; 2]>,
}

/// Drops of a law.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawDrops<'a> {
    /// The size factor and the size parameter of the effective radius.
    factor: f64,
    parameter: f64,
    mean_square: &'a MeanSquare,
}

impl<'a> LawDrops<'a> {
    /// Drops of an effective radius, whose law has this mean square, in a theory.
    pub(crate) fn new(
        theory: BowTheory,
        radius: Micrometers,
        wavelength: Nanometers,
        mean_square: &'a MeanSquare,
    ) -> Self {
        Self {
            factor: theory.form().size_factor(radius, wavelength),
            parameter: size_parameter(radius, wavelength),
            mean_square,
        }
    }
}

impl BowLight {
    pub(crate) fn new(order: &Order, places: &Places) -> Self {
        let mut light = Self {
            rays: vec![[0.0; 2]; places.n()],
            waves: None,
        };
        match order {
            Order::Colors(bow) => light.add_rays(
                places,
                |from, to| bow.mean_over_ring(from, to),
                |theta| bow.normalized_cross_section(theta),
            ),
            Order::Rays(rays) => light.add_rays(
                places,
                |from, to| rays.mean_over_ring(from, to),
                |theta| rays.normalized_cross_section(theta),
            ),
            Order::Airy(bow, AiryForm::Absolute) => light.add_waves(
                places,
                |theta| bow.wave(theta),
                |theta| bow.rays_beside(theta),
            ),
            Order::Airy(bow, AiryForm::Published) => {
                light.add_waves(places, |theta| bow.published_direction(theta), |_| [0.0; 2]);
            }
            Order::Uniform(bow) => light.add_waves(
                places,
                |theta| bow.wave(theta),
                |theta| bow.rays_beside(theta),
            ),
        }
        light
    }

    fn add_rays(
        &mut self,
        places: &Places,
        mean: impl Fn(Radians, Radians) -> [f64; 2],
        value: impl Fn(Radians) -> [f64; 2],
    ) {
        for (index, sum) in self.rays.iter_mut().enumerate() {
            let light = match places {
                Places::Rings(rings) => {
                    let edge = |index| Radians(rings.edge_rad(index));
                    mean(edge(index), edge(index + 1))
                }
                Places::Angles(angles) => value(Radians(angles[index])),
            };
            add(sum, light);
        }
    }

    /// Of rings waves are known at the edges, their strengths as the mean of both.
    fn add_waves(
        &mut self,
        places: &Places,
        wave: impl Fn(Radians) -> BowDirection,
        rays: impl Fn(Radians) -> [f64; 2],
    ) {
        for (index, sum) in self.rays.iter_mut().enumerate() {
            add(sum, rays(places.middle(index)));
        }
        let at = |direction: BowDirection| {
            let strengths = [direction.strength, direction.derivative_strength];
            (direction.argument, strengths)
        };
        let (arguments, mut strengths): (Vec<f64>, Vec<[[f64; 2]; 2]>) = match places {
            Places::Rings(rings) => (0..=rings.n)
                .map(|index| at(wave(Radians(rings.edge_rad(index)))))
                .unzip(),
            Places::Angles(angles) => angles.iter().map(|&angle| at(wave(Radians(angle)))).unzip(),
        };
        let is_rings = matches!(places, Places::Rings(_));
        if is_rings {
            let means = strengths.windows(2).map(|edges| mean(edges[0], edges[1]));
            strengths = means.collect();
        }
        let is_lit = |pair: &[[f64; 2]; 2]| pair.iter().flatten().any(|strength| *strength > 0.0);
        let first = strengths.iter().position(is_lit).unwrap_or(0);
        let end = strengths
            .iter()
            .rposition(is_lit)
            .map_or(first, |last| last + 1);
        self.waves = Some(Waves {
            active: first..end,
            arguments: arguments[first..end + usize::from(is_rings)].to_vec(),
            strengths: strengths[first..end].to_vec(),
        });
    }

    /// The largest z x^(−2/3) that will be looked up.
    pub(crate) fn largest_argument(&self) -> f64 {
        let arguments = self.waves.iter().flat_map(|waves| &waves.arguments);
        arguments.copied().fold(0.0, f64::max)
    }

    /// Adds (dσ/dΩ)/(π⟨r²⟩) in 1/sr at every place.
    pub(crate) fn add_to(&self, light: &mut [[f64; 2]], drops: &LawDrops) {
        for (sum, rays) in light.iter_mut().zip(&self.rays) {
            add(sum, *rays);
        }
        let Some(waves) = &self.waves else {
            return;
        };
        let scale = (drops.parameter * drops.parameter).cbrt();
        // Of F and of G.
        let factors = [drops.factor, drops.factor / scale];
        let is_rings = waves.arguments.len() > waves.strengths.len();
        let lit = light[waves.active.clone()].iter_mut();
        let lit = lit.zip(&waves.strengths);
        if is_rings {
            let at = |argument: f64| drops.mean_square.primitives(scale * argument);
            let mut from: Primitives = at(waves.arguments[0]);
            for ((sum, strengths), &argument) in lit.zip(&waves.arguments[1..]) {
                let to = at(argument);
                add_wave(sum, strengths, factors, drops.mean_square.means(&from, &to));
                from = to;
            }
        } else {
            for ((sum, strengths), argument) in lit.zip(&waves.arguments) {
                let squares = drops.mean_square.values(scale * argument);
                add_wave(sum, strengths, factors, squares);
            }
        }
    }
}

fn add_wave(sum: &mut [f64; 2], strengths: &[[f64; 2]; 2], factors: [f64; 2], squares: [f64; 2]) {
    let waves = [factors[0] * squares[0], factors[1] * squares[1]];
    for j in 0..2 {
        sum[j] += strengths[0][j] * waves[0] + strengths[1][j] * waves[1];
    }
}

fn mean(one: [[f64; 2]; 2], other: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|factor| [0, 1].map(|j| 0.5 * (one[factor][j] + other[factor][j])))
}

fn add(sum: &mut [f64; 2], term: [f64; 2]) {
    sum[0] += term[0];
    sum[1] += term[1];
}
#[cfg(test)]
mod tests;
