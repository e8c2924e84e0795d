//! The light of flattened drops, moved and widened radius by radius while it is shaded.
//!
//! L = Σ_a u_a Σ_p <t_p(θ − Δθ_p(a); a)>,   u_a = Σ_b W_b w_ba
//! `W_b` light deposited at a node b of sizes, `w_ba` share of the radius a in its law, `t_p` the light of
//! order p of single drops, <> the mean over a stretch of angles as wide as the pixel, and as the spread of
//! tilted and trembling drops and of all that a radius stands for, together: of the variance
//! w²/12 = footprint²/12 + sd² + (∂Δθ/∂e δe)²/12, `δe` step of eccentricity around it. It is never narrower
//! than the step of the order's angles there. The mean is a difference of the integral over θ, linear between
//! them, so that it costs the same for any width.
//!
//! Wavelengths move by different amounts; those that differ by less than a 25th of the sun's diameter go
//! together, eight always do.
//!
//! Where the moved light of a radius comes from beyond the angles of the table, it is dark; at 0 and 180
//! degrees it comes from the mirrored angle.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use ndarray::Array1;
use ndarray::Array2;
use ndarray::s;
use niji_exchange::Attitude;
use niji_exchange::BowShift;
use niji_exchange::FARTHEST_SHIFT_RAD;
use niji_exchange::MovedOrder;
use niji_exchange::ScatteringTable;
use niji_exchange::SeenShift;
use pulp::Arch;
use pulp::Simd;
use pulp::WithSimd;
use rayon::prelude::*;

use crate::moved_angles::AngleMean;
use crate::moved_angles::MovedAngles;
use crate::moved_radii::DropsAround;
use crate::moved_radii::MovedRadii;
use crate::moved_radii::RowMean;
use crate::size_nodes::SizeNodes;

/// How far the bows of wavelengths that go together may lie apart: a 25th of the sun's diameter, or this
/// part of the width over which they are taken.
const APART_RAD: f64 = 0.02 * PI / 180.0;
const APART_OF_WIDTH: f64 = 0.1;
/// Share of the light of a row that is left out on either side of where it is lit.
const DARK: f32 = 1e-6;
/// Share of the light of a ray below which that of a row is left out: the tails of laws.
const FEW: f32 = 1e-6;
/// Wavelengths are shaded in lanes of so many.
const LANES: usize = 8;

/// Rows of the orders that move.
#[derive(Debug)]
pub(crate) struct MovedRows {
    orders: Vec<OrderRows>,
    drops: Vec<DropsAround>,
    /// By node of sizes.
    laws: Vec<RowWeights>,
    n_padded: usize,
}

/// The rows of a law, which lie side by side.
#[derive(Debug, Default)]
struct RowWeights {
    first: usize,
    weights: Vec<f32>,
}

/// One order.
#[derive(Debug)]
struct OrderRows {
    angles: MovedAngles,
    /// Where each half of a lane of wavelengths begins, and at the last wavelength.
    shifts: Vec<BowShift>,
    /// Integral over the angle by [row, angle, wavelength], lanes of 0 behind the last wavelength.
    integrals: Vec<f32>,
    /// Largest luminance of each row in front of 90 degrees and behind, in sunlight [cd/m² per unit of light].
    peaks: Vec<[f64; 2]>,
    /// Angles between which all but a millionth of the light of each row lies, of every wavelength.
    lit_rad: Vec<[f64; 2]>,
}

/// Where a ray stands, and what it adds up.
#[derive(Clone, Debug, Default)]
pub(crate) struct MovedStencil {
    place: MovedPlace,
    attitude: Attitude,
    /// By order and half of a lane.
    seen: Vec<SeenShift>,
    /// Weight of each row.
    weights: Vec<f32>,
    sums: Vec<f32>,
}

/// Where a ray stands.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MovedPlace {
    pub(crate) theta_rad: f64,
    /// Scattering angles that its pixel spans.
    pub(crate) width_rad: f64,
    /// T² and B² of upright drops.
    pub(crate) axis_squares: [f64; 2],
}

impl MovedRows {
    /// The moved light of a table for light at the nodes of sizes, of which bows may be one that lie no farther apart
    /// than `apart_rad`; `luminance_weights` turn a spectrum of the table's unit into luminance. `None` if nothing moves.
    pub(crate) fn new(
        table: &ScatteringTable,
        nodes: &SizeNodes,
        luminance_weights: &[f64],
        apart_rad: f64,
    ) -> Option<Self> {
        let moved = table.moved.as_ref()?;
        let radii = MovedRadii::new(table, moved, nodes, apart_rad);
        let n_bins = nodes.radius_um.len() * nodes.variance.len();
        let law = |bin: usize| {
            let weights = nodes.weights(bin, &radii.radii_um).into_iter();
            let moving = weights.filter_map(|(radius, weight)| {
                let row = radius.checked_sub(radii.n_still)?;
                Some((row, weight as f32))
            });
            RowWeights::new(moving.collect())
        };
        let order = |order: &MovedOrder| {
            let source = OrderSource {
                order,
                luminance_weights,
            };
            source.rows(&radii.rows)
        };
        Some(Self {
            orders: moved.orders.iter().map(order).collect(),
            laws: (0..n_bins).into_par_iter().map(law).collect(),
            n_padded: table.wavelengths.len().next_multiple_of(LANES),
            drops: radii.drops,
        })
    }

    /// Take note of where a ray stands.
    pub(crate) fn place(&self, place: &MovedPlace, stencil: &mut MovedStencil) {
        stencil.place = *place;
        stencil.seen.clear();
        let Some(first) = self.drops.first() else {
            return;
        };
        // All drops tilt alike.
        let [t2, b2] = place.axis_squares;
        stencil.attitude = first.drops.attitude(t2, b2);
        let [t2, b2] = stencil.attitude.mean_squares;
        let shifts = self.orders.iter().flat_map(|order| &order.shifts);
        stencil.seen.extend(shifts.map(|shift| shift.seen(t2, b2)));
    }

    /// Add the moved rows of the light at some nodes to a spectrum; what their peaks add up to in
    /// luminance [cd/m²].
    pub(crate) fn add(
        &self,
        light: &[(usize, f32)],
        stencil: &mut MovedStencil,
        spectrum: &mut [f32],
    ) -> f64 {
        let MovedStencil {
            place,
            attitude,
            seen,
            weights,
            sums,
        } = stencil;
        weights.clear();
        weights.resize(self.drops.len(), 0.0);
        for (bin, light) in light {
            let law = &self.laws[*bin];
            for (sum, weight) in weights[law.first..].iter_mut().zip(&law.weights) {
                *sum += light * weight;
            }
        }
        sums.clear();
        sums.resize(self.n_padded, 0.0);
        let peaks = Arch::new().dispatch(Adding {
            rows: self,
            place,
            attitude,
            seen,
            weights,
            sums,
        });
        // What rounding leaves of the difference of two equal integrals may lie below 0.
        for (value, sum) in spectrum.iter_mut().zip(sums) {
            *value += sum.max(0.0);
        }
        peaks
    }
}

impl RowWeights {
    /// Of ascending rows.
    fn new(rows: Vec<(usize, f32)>) -> Self {
        let (Some((first, _)), Some((last, _))) = (rows.first(), rows.last()) else {
            return Self::default();
        };
        let (first, mut weights) = (*first, vec![0.0; last + 1 - first]);
        for (row, weight) in rows {
            weights[row - first] = weight;
        }
        Self { first, weights }
    }
}

/// Moved rows to be added up, wavelength by wavelength in one order: the same bits for vectors of any
/// width.
struct Adding<'a> {
    rows: &'a MovedRows,
    place: &'a MovedPlace,
    attitude: &'a Attitude,
    seen: &'a [SeenShift],
    weights: &'a [f32],
    sums: &'a mut [f32],
}

#[allow(
    clippy::inline_always,
    reason = "a function of its own would have the narrowest vectors"
)]
impl WithSimd for Adding<'_> {
    /// What the peaks of the rows add up to.
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) -> f64 {
        let n_lanes = self.rows.n_padded / LANES;
        let (mut peaks, side) = (0.0, side_of(self.place.theta_rad));
        let least = FEW * self.weights.iter().sum::<f32>();
        for (row, weight) in self.weights.iter().enumerate() {
            if *weight <= least {
                continue;
            }
            let of_orders = self
                .rows
                .orders
                .iter()
                .zip(self.seen.chunks_exact(2 * n_lanes + 1));
            for (order, seen) in of_orders {
                peaks += f64::from(*weight) * order.peaks[row][side];
                self.add_order((order, seen), row, *weight);
            }
        }
        peaks
    }
}

#[allow(clippy::inline_always, reason = "as above")]
impl Adding<'_> {
    /// Add one order of one row: lanes whose bows lie close together at one shift.
    #[inline(always)]
    fn add_order(&mut self, (order, seen): (&OrderRows, &[SeenShift]), row: usize, weight: f32) {
        let (angles, n_padded) = (&order.angles, self.rows.n_padded);
        let (n_lanes, around) = (seen.len() / 2, &self.rows.drops[row]);
        let shift_rad = |half: usize| {
            let shift_rad = seen[half].shift_rad(around.drops.eccentricity);
            shift_rad.clamp(-FARTHEST_SHIFT_RAD, FARTHEST_SHIFT_RAD)
        };
        let variance = around.variance_rad2(&seen[n_lanes], self.attitude);
        let width_rad = (12.0 * variance + self.place.width_rad.powi(2)).sqrt();
        let (first_rad, last_rad) = (shift_rad(0), shift_rad(2 * n_lanes));
        // From secondary to primary one of them is dark, and so is the other beyond.
        let reach_rad = (first_rad - last_rad).abs() + 0.5 * width_rad.max(angles.widest_step_rad);
        let [lit_from, lit_to] = order.lit_rad[row];
        let seen_rad = self.place.theta_rad - first_rad;
        if seen_rad + reach_rad < lit_from || seen_rad - reach_rad > lit_to {
            return;
        }
        let alike_rad = APART_RAD.max(APART_OF_WIDTH * width_rad);
        let n_apart = ((first_rad - last_rad).abs() / alike_rad).ceil().max(1.0) as usize;
        let n_groups = n_apart.min(n_lanes);
        let row = row * angles.theta_rad.len() * n_padded;
        for group in 0..n_groups {
            let [from, to] = [group, group + 1].map(|edge| edge * n_lanes / n_groups);
            let moved_rad = shift_rad(from + to);
            let mean = angles.mean(self.place.theta_rad - moved_rad, width_rad);
            let Some(AngleMean { ends, shares }) = mean else {
                continue;
            };
            let [begin, end] = ends.map(|angle| {
                let start = row + angle * n_padded;
                let (here, next) = order.integrals[start..start + 2 * n_padded].split_at(n_padded);
                (here, next)
            });
            let [[a, b], [c, d]] = shares.map(|pair| pair.map(|share| weight * share));
            let lanes = from * LANES..to * LANES;
            let sums = self.sums[lanes.clone()].as_chunks_mut::<LANES>().0;
            let [begin, end] = [begin, end].map(|(here, next)| {
                [here, next].map(|values| values[lanes.clone()].as_chunks::<LANES>().0)
            });
            for (index, sums) in sums.iter_mut().enumerate() {
                // Copies: what is stored could otherwise be what is read next.
                let ([low, below], [high, above]) = (begin.map(at(index)), end.map(at(index)));
                let mut sum = *sums;
                for lane in 0..LANES {
                    let begin = a * low[lane] + b * below[lane];
                    let end = c * high[lane] + d * above[lane];
                    sum[lane] += end - begin;
                }
                *sums = sum;
            }
        }
    }
}

/// In front of 90 degrees or behind: errors of a table are parts of the peak on their side, and that of light
/// that is diffracted forward is thousands of times a bow's.
fn side_of(theta_rad: f64) -> usize {
    usize::from(theta_rad >= FRAC_PI_2)
}

/// A copy of one lane of wavelengths.
fn at(index: usize) -> impl Fn(&[[f32; LANES]]) -> [f32; LANES] {
    move |lanes| lanes[index]
}

/// What the rows of an order are made from.
struct OrderSource<'a> {
    order: &'a MovedOrder,
    luminance_weights: &'a [f64],
}

impl OrderSource<'_> {
    /// Rows that are means of the table's.
    fn rows(&self, means: &[RowMean]) -> OrderRows {
        let (_, _, n_wavelengths, _) = self.order.values.dim();
        let n_padded = n_wavelengths.next_multiple_of(LANES);
        let angles = MovedAngles::mirrored(&self.order.theta_rad);
        let n_of_row = angles.theta_rad.len() * n_padded;
        let mut integrals = vec![0.0; means.len() * n_of_row];
        let of_rows = integrals.par_chunks_mut(n_of_row);
        let (peaks, lit_rad) = (of_rows.zip(means))
            .map(|(integrals, mean)| {
                let light = self.natural_light(mean);
                self.integrate((&light, &angles.theta_rad), integrals);
                let lit_rad = lit_rad((integrals, n_padded), &angles.theta_rad);
                (self.peaks(&light), lit_rad)
            })
            .unzip();
        let half = |index: usize| self.order.shifts[(index * LANES / 2).min(n_wavelengths - 1)];
        OrderRows {
            shifts: (0..=2 * n_padded / LANES).map(half).collect(),
            angles,
            integrals,
            peaks,
            lit_rad,
        }
    }

    /// [wavelength, angle of the table].
    fn natural_light(&self, mean: &RowMean) -> Array2<f64> {
        let (_, _, n_wavelengths, n_theta) = self.order.values.dim();
        let mut light = Array2::zeros((n_wavelengths, n_theta));
        for (row, share) in mean {
            for polarization in [0, 1] {
                let values = self.order.values.slice(s![polarization, *row, .., ..]);
                let scale = 0.5 * share;
                light.zip_mut_with(&values, |sum, value| *sum += scale * f64::from(*value));
            }
        }
        light
    }

    /// Integrals by [angle, wavelength], over angles that go on where those of the order are mirrored.
    fn integrate(&self, (light, theta_rad): (&Array2<f64>, &[f64]), integrals: &mut [f32]) {
        let own_rad = &self.order.theta_rad;
        let n_theta = own_rad.len();
        let n_padded = integrals.len() / theta_rad.len();
        let before = theta_rad.partition_point(|theta| *theta < own_rad[0]);
        // The angle of the order that a mirrored one is.
        let source = |angle: usize| {
            let place = angle as i64 - before as i64;
            let last = n_theta as i64 - 1;
            (last - (last - place.abs()).abs()).clamp(0, last) as usize
        };
        for (wavelength, light) in light.outer_iter().enumerate() {
            let (mut sum, mut last) = (0.0, light[source(0)]);
            for angle in 1..theta_rad.len() {
                let value = light[source(angle)];
                sum += 0.5 * (theta_rad[angle] - theta_rad[angle - 1]) * (last + value);
                last = value;
                // f32: 1e-7 of the whole integral, 1e-4 of the peak over the narrowest step.
                integrals[angle * n_padded + wavelength] = sum as f32;
            }
        }
    }

    /// Largest luminance in sunlight on either side.
    fn peaks(&self, light: &Array2<f64>) -> [f64; 2] {
        let weights = Array1::from(self.luminance_weights.to_vec());
        let mut peaks = [0.0_f64; 2];
        for (theta_rad, luminance) in self.order.theta_rad.iter().zip(weights.dot(light)) {
            let peak = &mut peaks[side_of(*theta_rad)];
            *peak = peak.max(luminance);
        }
        peaks
    }
}

/// The angles between which each wavelength has all but a millionth of its integral.
fn lit_rad((integrals, n_padded): (&[f32], usize), theta_rad: &[f64]) -> [f64; 2] {
    let all = &integrals[integrals.len() - n_padded..];
    let of_angles: Vec<&[f32]> = integrals.chunks_exact(n_padded).collect();
    let is_dark = |values: &&[f32]| {
        let mut both = values.iter().zip(all);
        both.all(|(value, all)| *value <= DARK * all)
    };
    // Where some wavelength lacks more than that.
    let lacks_some = |values: &&[f32]| {
        let mut both = values.iter().zip(all);
        both.any(|(value, all)| *value < (1.0 - DARK) * all)
    };
    let last_lit = of_angles.partition_point(lacks_some);
    let first_lit = of_angles.partition_point(is_dark);
    [
        first_lit.saturating_sub(1),
        last_lit.min(of_angles.len() - 1),
    ]
    .map(|angle| theta_rad[angle])
}

#[cfg(test)]
#[path = "moved_rows_tests.rs"]
mod tests;
