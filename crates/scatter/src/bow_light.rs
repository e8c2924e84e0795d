//! The bows of one wavelength by geometric optics or Airy's theory, for every size law.
//!
//! What does not depend on size is computed once: for each order the argument of f at the edges of the
//! rings and the strengths and rays in them; [`MeanSquare`] then gives the mean over sizes and ring.

use std::ops::Range;

use niji_airy::AiryBow;
use niji_airy::AiryForm;
use niji_airy::GeometricOrder;
use niji_radiometry::Radians;

use crate::error::Error;
use crate::mean_square::MeanSquare;
use crate::rings::Rings;

/// Where light is asked for.
#[derive(Clone, Debug)]
pub(crate) enum Places {
    /// Means over rings, to be averaged over the sun's disc.
    Rings(Rings),
    /// Single directions, for a sun without a disc.
    Angles(Vec<f64>),
}

impl Places {
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

/// How the bows are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BowTheory {
    /// Rays alone.
    Geometric,
    /// Airy's theory.
    Airy(AiryForm),
}

/// The bows of one wavelength.
#[derive(Clone, Debug)]
pub(crate) struct BowLight {
    /// What no size changes, in 1/sr.
    rays: Vec<[f64; 2]>,
    orders: Vec<WaveOrder>,
}

/// The part of an order that depends on size.
#[derive(Clone, Debug)]
struct WaveOrder {
    /// Places where the strength is not zero.
    active: Range<usize>,
    /// z x^(−2/3) at the edges of the active rings, or in the active directions.
    arguments: Vec<f64>,
    /// Factor of the mean square, for each active place.
    strength: Vec<[f64; 2]>,
}

impl BowLight {
    pub(crate) fn new(
        theory: BowTheory,
        index: f64,
        orders: &[u32],
        places: &Places,
    ) -> Result<Self, Error> {
        let no_bow = || Error::Orders {
            found: orders.to_vec(),
        };
        let mut light = Self {
            rays: vec![[0.0; 2]; places.n()],
            orders: Vec::new(),
        };
        for &p in orders {
            match theory {
                BowTheory::Geometric => {
                    let order = GeometricOrder::new(index, p).ok_or_else(no_bow)?;
                    light.add_rays(&order, places);
                }
                BowTheory::Airy(form) => {
                    let bow = AiryBow::new(index, p).ok_or_else(no_bow)?;
                    light.add_bow(&bow, form, places);
                }
            }
        }
        Ok(light)
    }

    fn add_rays(&mut self, order: &GeometricOrder, places: &Places) {
        for (index, sum) in self.rays.iter_mut().enumerate() {
            let light = match places {
                Places::Rings(rings) => {
                    let edge = |index| Radians(rings.edge_rad(index));
                    order.mean_over_ring(edge(index), edge(index + 1))
                }
                Places::Angles(angles) => order.normalized_cross_section(Radians(angles[index])),
            };
            add(sum, light);
        }
    }

    fn add_bow(&mut self, bow: &AiryBow, form: AiryForm, places: &Places) {
        let mut strength = Vec::with_capacity(places.n());
        for (index, sum) in self.rays.iter_mut().enumerate() {
            let direction = match form {
                AiryForm::Absolute => bow.direction(places.middle(index)),
                AiryForm::Published => bow.published_direction(places.middle(index)),
            };
            strength.push(direction.strength);
            add(sum, direction.rays);
        }
        let is_lit = |strength: &[f64; 2]| strength[0] > 0.0 || strength[1] > 0.0;
        let first = strength.iter().position(is_lit).unwrap_or(0);
        let end = strength
            .iter()
            .rposition(is_lit)
            .map_or(first, |last| last + 1);
        let arguments = match places {
            Places::Rings(rings) => (first..=end)
                .map(|index| bow.argument(Radians(rings.edge_rad(index))))
                .collect(),
            Places::Angles(angles) => angles[first..end]
                .iter()
                .map(|&angle| bow.argument(Radians(angle)))
                .collect(),
        };
        self.orders.push(WaveOrder {
            active: first..end,
            arguments,
            strength: strength[first..end].to_vec(),
        });
    }

    /// The largest z x^(−2/3) that will be looked up.
    pub(crate) fn largest_argument(&self) -> f64 {
        let arguments = self.orders.iter().flat_map(|order| &order.arguments);
        arguments.copied().fold(0.0, f64::max)
    }

    /// (dσ/dΩ)/(π⟨r²⟩) in 1/sr at every place, for drops with the size factor and the size parameter
    /// of their effective radius.
    pub(crate) fn evaluate(
        &self,
        size_factor: f64,
        size_parameter: f64,
        mean_square: &MeanSquare,
    ) -> Vec<[f64; 2]> {
        let scale = (size_parameter * size_parameter).cbrt();
        let mut light = self.rays.clone();
        for order in &self.orders {
            let is_rings = order.arguments.len() > order.strength.len();
            let lit = light[order.active.clone()].iter_mut().zip(&order.strength);
            if is_rings {
                let at =
                    |argument: f64| (scale * argument, mean_square.primitive(scale * argument));
                let mut from = at(order.arguments[0]);
                for ((sum, strength), &argument) in lit.zip(&order.arguments[1..]) {
                    let to = at(argument);
                    let square = size_factor * mean_square.mean(from, to);
                    add(sum, strength.map(|strength| strength * square));
                    from = to;
                }
            } else {
                for ((sum, strength), argument) in lit.zip(&order.arguments) {
                    let square = size_factor * mean_square.value(scale * argument);
                    add(sum, strength.map(|strength| strength * square));
                }
            }
        }
        light
    }
}

fn add(sum: &mut [f64; 2], term: [f64; 2]) {
    sum[0] += term[0];
    sum[1] += term[1];
}
