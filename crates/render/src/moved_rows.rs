//! The light of flattened drops, moved and widened radius by radius while it is shaded.
//!
//! L = Σ_a u_a Σ_p <t_p(θ − Δθ_p(a); a)>,   u_a = Σ_b W_b w_ba
//! `W_b` light deposited at a node b of sizes, `w_ba` share of the radius a in its law, `t_p` the light of
//! order p of single drops, <> the mean over a stretch of angles as wide as the pixel, and as the spread of
//! tilted and trembling drops, together: of the variance w²/12 = footprint²/12 + sd². It is never narrower
//! than the step of the table there. The mean is a difference of the integral over θ, linear between the
//! table's angles, so that it costs the same for any width.
//!
//! The bow of a large drop moves by more than the sun is wide from one radius of the table to the next.
//! There a row is used several times, each at the shift of its own radius. Wavelengths move by different
//! amounts; those that differ by less than a 25th of the sun's diameter go together, eight always do.
//!
//! Where the moved light of a radius comes from beyond the angles of the table, it is dark; at 0 and 180
//! degrees it comes from the mirrored angle.

use std::f64::consts::PI;

use niji_exchange::BowShift;
use niji_exchange::FARTHEST_SHIFT_RAD;
use niji_exchange::FallingDrops;
use niji_exchange::MovedBows;
use niji_exchange::MovedOrder;
use niji_exchange::ScatteringTable;
use niji_exchange::SeenShift;
use pulp::Arch;
use pulp::Simd;
use pulp::WithSimd;
use rayon::prelude::*;

use crate::size_nodes::SizeNodes;

/// How far a bow may move from one shaded radius to the next: half of the sun's diameter, or the standard
/// deviation of trembling drops.
const SHIFT_STEP_RAD: f64 = 0.25 * PI / 180.0;
/// How far the bows of wavelengths that go together may lie apart: a 25th of the sun's diameter, or this
/// part of the width over which they are taken.
const APART_RAD: f64 = 0.02 * PI / 180.0;
const APART_OF_WIDTH: f64 = 0.1;
/// Wavelengths are shaded in lanes of so many.
const LANES: usize = 8;
/// Entries of the guide to the angles for each of them.
const GUIDE_DENSITY: usize = 4;

/// Rows of the orders that move.
#[derive(Debug)]
pub(crate) struct MovedRows {
    angles: Angles,
    orders: Vec<OrderRows>,
    radii: Vec<ShadedRadius>,
    /// How many of them do not move.
    n_still: usize,
    /// By node of sizes: shaded radii and their weights.
    laws: Vec<Vec<(u32, f32)>>,
    n_padded: usize,
}

/// A radius at which light is moved.
#[derive(Clone, Copy, Debug)]
struct ShadedRadius {
    /// Row of the table, the nearest one.
    row: usize,
    drops: FallingDrops,
}

/// One order.
#[derive(Debug)]
struct OrderRows {
    /// By wavelength.
    shifts: Vec<BowShift>,
    /// Integral over the angle by [row, angle, wavelength], lanes of 0 behind the last wavelength.
    integrals: Vec<f32>,
    /// Largest luminance of each row, in sunlight [cd/m² per unit of light].
    peaks: Vec<f64>,
}

/// Ascending angles with a guide to them.
#[derive(Debug)]
struct Angles {
    theta_rad: Vec<f64>,
    guide: Vec<u32>,
    guide_per_rad: f64,
}

/// Where a ray finds the rows of all shaded radii.
#[derive(Clone, Debug, Default)]
pub(crate) struct MovedStencil {
    terms: Vec<Term>,
    /// Weight of each shaded radius.
    weights: Vec<f32>,
    /// Room for shifts by wavelength, and for light.
    seen: Vec<SeenShift>,
    sums: Vec<f32>,
}

/// Some wavelengths of one order at one shaded radius.
#[derive(Clone, Debug)]
struct Term {
    order: u32,
    radius: u32,
    /// From the first to behind the last.
    lanes: [u32; 2],
    /// Where the stretch of angles begins and ends in the integrals of the order.
    ends: [usize; 2],
    /// Weights of the integral there and at the next angle, begin and end.
    shares: [[f32; 2]; 2],
}

/// Where a ray stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovedPlace {
    pub(crate) theta_rad: f64,
    /// Scattering angles that its pixel spans.
    pub(crate) width_rad: f64,
    /// T² and B² of upright drops.
    pub(crate) axis_squares: [f64; 2],
}

impl MovedRows {
    /// The moved light of a table for light at the nodes of sizes; `luminance_weights` turn a spectrum of
    /// the table's unit into luminance. `None` if nothing moves.
    pub(crate) fn new(
        table: &ScatteringTable,
        nodes: &SizeNodes,
        luminance_weights: &[f64],
    ) -> Option<Self> {
        let moved = table.moved.as_ref()?;
        let (radii_um, radii) = shaded_radii(&table.effective_radius_um, moved);
        let angles = Angles::mirrored(&table.theta_rad);
        let n_bins = nodes.radius_um.len() * nodes.variance.len();
        let first = first_moved_row(moved);
        let law = |bin: usize| {
            let weights = nodes.weights(bin, &radii_um).into_iter();
            let moving = weights.filter(|(radius, _)| radii[*radius].row >= first);
            moving
                .map(|(radius, weight)| (radius as u32, weight as f32))
                .collect()
        };
        let n_padded = table.wavelengths.len().next_multiple_of(LANES);
        let order = |order: &MovedOrder| OrderRows::new(order, (table, &angles), luminance_weights);
        Some(Self {
            orders: moved.orders.iter().map(order).collect(),
            n_still: radii.partition_point(|radius| radius.row < first),
            laws: (0..n_bins).into_par_iter().map(law).collect(),
            angles,
            radii,
            n_padded,
        })
    }

    /// Take note of where a ray stands.
    pub(crate) fn place(&self, place: &MovedPlace, stencil: &mut MovedStencil) {
        stencil.terms.clear();
        let Some(first) = self.radii.first() else {
            return;
        };
        // All drops tilt alike.
        let attitude = first
            .drops
            .attitude(place.axis_squares[0], place.axis_squares[1]);
        let [t2, b2] = attitude.mean_squares;
        let stride = self.angles.theta_rad.len() * self.n_padded;
        for (order_index, order) in self.orders.iter().enumerate() {
            stencil.seen.clear();
            stencil
                .seen
                .extend(order.shifts.iter().map(|shift| shift.seen(t2, b2)));
            let (seen, last) = (&stencil.seen, order.shifts.len() - 1);
            for (index, radius) in self.radii.iter().enumerate().skip(self.n_still) {
                let shift =
                    |wavelength: usize| seen[wavelength].shift_rad(radius.drops.eccentricity);
                let sd_rad = radius.drops.sd_rad(&seen[last / 2], &attitude);
                let width_rad = (12.0 * sd_rad * sd_rad + place.width_rad.powi(2)).sqrt();
                let apart_rad = (shift(0) - shift(last)).abs();
                let alike_rad = APART_RAD.max(APART_OF_WIDTH * width_rad);
                let n_chunks = self.n_padded / LANES;
                let n_groups = ((apart_rad / alike_rad).ceil().max(1.0) as usize).min(n_chunks);
                for group in 0..n_groups {
                    let ends = [group, group + 1].map(|edge| edge * n_chunks / n_groups * LANES);
                    let of_group = usize::midpoint(ends[0], ends[1].min(last + 1) - 1);
                    let moved_rad = shift(of_group).clamp(-FARTHEST_SHIFT_RAD, FARTHEST_SHIFT_RAD);
                    let mean = self.angles.mean(place.theta_rad - moved_rad, width_rad);
                    let Some((angles, shares)) = mean else {
                        continue;
                    };
                    let row = radius.row * stride;
                    stencil.terms.push(Term {
                        order: order_index as u32,
                        radius: index as u32,
                        lanes: ends.map(|end| end as u32),
                        ends: angles.map(|angle| row + angle * self.n_padded),
                        shares,
                    });
                }
            }
        }
    }

    /// Add the moved rows of the light at some nodes to a spectrum; what their peaks add up to in
    /// luminance [cd/m²].
    pub(crate) fn add(
        &self,
        light: &[(usize, f32)],
        stencil: &mut MovedStencil,
        spectrum: &mut [f32],
    ) -> f64 {
        stencil.weights.clear();
        stencil.weights.resize(self.radii.len(), 0.0);
        for (bin, light) in light {
            for (radius, weight) in &self.laws[*bin] {
                stencil.weights[*radius as usize] += light * weight;
            }
        }
        stencil.sums.clear();
        stencil.sums.resize(self.n_padded, 0.0);
        let MovedStencil {
            terms,
            weights,
            sums,
            ..
        } = stencil;
        Arch::new().dispatch(Adding {
            rows: self,
            terms,
            weights,
            sums,
        });
        // What rounding leaves of the difference of two equal integrals may lie below 0.
        for (value, sum) in spectrum.iter_mut().zip(sums) {
            *value += sum.max(0.0);
        }
        let of_order = |order: &OrderRows| {
            let radii = self.radii.iter().zip(&*weights);
            let peaks = radii.map(|(radius, weight)| f64::from(*weight) * order.peaks[radius.row]);
            peaks.sum::<f64>()
        };
        self.orders.iter().map(of_order).sum()
    }
}

/// Terms to be added up, wavelength by wavelength in one order: the same bits for vectors of any width.
struct Adding<'a> {
    rows: &'a MovedRows,
    terms: &'a [Term],
    weights: &'a [f32],
    sums: &'a mut [f32],
}

#[allow(
    clippy::inline_always,
    reason = "a function of its own would have the narrowest vectors"
)]
impl WithSimd for Adding<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let n_padded = self.rows.n_padded;
        for term in self.terms {
            let weight = self.weights[term.radius as usize];
            if weight <= 0.0 {
                continue;
            }
            let [first, end] = term.lanes.map(|lane| lane as usize);
            let integrals = &self.rows.orders[term.order as usize].integrals;
            let [low, high] = term
                .ends
                .map(|start| &integrals[start..start + 2 * n_padded]);
            let [[a, b], [c, d]] = term.shares.map(|pair| pair.map(|share| weight * share));
            let (here, next) = (first..end, n_padded + first..n_padded + end);
            let low = (&low[here.clone()], &low[next.clone()]);
            let high = (&high[here], &high[next]);
            let sums = &mut self.sums[first..end];
            for (lane, sum) in sums.iter_mut().enumerate() {
                let begin = a * low.0[lane] + b * low.1[lane];
                let end = c * high.0[lane] + d * high.1[lane];
                *sum += end - begin;
            }
        }
    }
}

impl OrderRows {
    fn new(
        order: &MovedOrder,
        (table, angles): (&ScatteringTable, &Angles),
        luminance_weights: &[f64],
    ) -> Self {
        let (_, n_rows, n_wavelengths, n_theta) = order.values.dim();
        let n_padded = n_wavelengths.next_multiple_of(LANES);
        let n_angles = angles.theta_rad.len();
        let mut integrals = vec![0.0; n_rows * n_angles * n_padded];
        let natural = |row: usize, wavelength: usize, angle: usize| {
            let [s, p] = [0, 1].map(|j| f64::from(order.values[[j, row, wavelength, angle]]));
            0.5 * (s + p)
        };
        let before = angles
            .theta_rad
            .partition_point(|theta| *theta < table.theta_rad[0]);
        // The angle of the table that a mirrored one is.
        let source = |angle: usize| {
            let place = angle as i64 - before as i64;
            let last = n_theta as i64 - 1;
            (last - (last - place.abs()).abs()).clamp(0, last) as usize
        };
        integrals
            .par_chunks_mut(n_angles * n_padded)
            .enumerate()
            .for_each(|(row, integrals)| {
                for wavelength in 0..n_wavelengths {
                    let mut sum = 0.0;
                    let mut last = natural(row, wavelength, source(0));
                    for angle in 1..n_angles {
                        let value = natural(row, wavelength, source(angle));
                        let step = angles.theta_rad[angle] - angles.theta_rad[angle - 1];
                        sum += 0.5 * step * (last + value);
                        last = value;
                        // f32: 1e-7 of the whole integral, 1e-4 of the peak over the narrowest step.
                        integrals[angle * n_padded + wavelength] = sum as f32;
                    }
                }
            });
        let peak = |row: usize| {
            let luminance = |angle: usize| {
                let weights = luminance_weights.iter().enumerate();
                weights
                    .map(|(wavelength, weight)| weight * natural(row, wavelength, angle))
                    .sum()
            };
            (0..n_theta).map(luminance).fold(0.0, f64::max)
        };
        Self {
            shifts: order.shifts.clone(),
            integrals,
            peaks: (0..n_rows).into_par_iter().map(peak).collect(),
        }
    }
}

impl Angles {
    /// The angles of a table, continued by mirrored ones beyond 0 and 180 degrees where it reaches there.
    fn mirrored(theta_rad: &[f64]) -> Self {
        let (first, last) = (theta_rad[0], theta_rad[theta_rad.len() - 1]);
        let end = 1e-6;
        let inner = &theta_rad[1..theta_rad.len().max(2) - 1];
        let mut all = Vec::with_capacity(3 * theta_rad.len());
        if first < end {
            let mirrored = inner
                .iter()
                .take_while(|theta| **theta < FARTHEST_SHIFT_RAD);
            all.extend(mirrored.map(|theta| 2.0 * first - theta));
            all.reverse();
        }
        all.extend(theta_rad);
        if last > PI - end {
            let mirrored = inner
                .iter()
                .rev()
                .take_while(|theta| last - **theta < FARTHEST_SHIFT_RAD);
            all.extend(mirrored.map(|theta| 2.0 * last - theta));
        }
        let n_guides = GUIDE_DENSITY * all.len();
        let (first, last) = (all[0], all[all.len() - 1]);
        let step = (last - first) / n_guides as f64;
        let lower = |entry: usize| {
            // One step back, so that rounding does not put the guide above its place.
            let theta = first + (entry as f64 - 1.0) * step;
            let above = all.partition_point(|node| *node <= theta);
            above.saturating_sub(1).min(all.len().saturating_sub(2)) as u32
        };
        Self {
            guide: (0..=n_guides).map(lower).collect(),
            guide_per_rad: if step > 0.0 { 1.0 / step } else { 0.0 },
            theta_rad: all,
        }
    }

    /// The last angle but one that is not above an angle.
    fn lower(&self, theta_rad: f64) -> usize {
        let entry = ((theta_rad - self.theta_rad[0]) * self.guide_per_rad) as usize;
        let mut lower = self.guide[entry.min(self.guide.len() - 1)] as usize;
        while lower + 2 < self.theta_rad.len() && self.theta_rad[lower + 1] <= theta_rad {
            lower += 1;
        }
        lower
    }

    /// Angles and shares of the integral whose difference is the mean over a stretch around an angle, no
    /// narrower than a step; `None` beyond the angles.
    fn mean(&self, theta_rad: f64, width_rad: f64) -> Option<([usize; 2], [[f32; 2]; 2])> {
        let theta = &self.theta_rad;
        let (first, last) = (theta[0], *theta.last()?);
        if theta.len() < 2 || theta_rad < first || theta_rad > last {
            return None;
        }
        let middle = self.lower(theta_rad);
        let half = 0.5 * width_rad.max(theta[middle + 1] - theta[middle]);
        let ends_rad = [(theta_rad - half).max(first), (theta_rad + half).min(last)];
        let per_rad = 1.0 / (ends_rad[1] - ends_rad[0]);
        let ends = ends_rad.map(|end| self.lower(end));
        let share = |end: usize| {
            let lower = ends[end];
            let fraction = (ends_rad[end] - theta[lower]) / (theta[lower + 1] - theta[lower]);
            [
                ((1.0 - fraction) * per_rad) as f32,
                (fraction * per_rad) as f32,
            ]
        };
        Some((ends, [share(0), share(1)]))
    }
}

/// The first row whose bows move by what anybody could see: half of what wavelengths lie apart.
pub(crate) fn first_moved_row(moved: &MovedBows) -> usize {
    let k_rad = largest_k_rad(moved);
    let is_still = |drops: &FallingDrops| k_rad * drops.eccentricity < 0.5 * APART_RAD;
    moved.drops.partition_point(is_still)
}

/// The largest factor of the first order in the shift.
fn largest_k_rad(moved: &MovedBows) -> f64 {
    let shifts = moved.orders.iter().flat_map(|order| &order.shifts);
    let k_rad = shifts.map(|shift| shift.coefficients_rad[0].abs());
    k_rad.fold(0.0, f64::max)
}

/// Radii in micrometres at which light is moved, and what moves it: those of the table, and more between
/// them where bows lie far apart.
fn shaded_radii(radii_um: &[f64], moved: &MovedBows) -> (Vec<f64>, Vec<ShadedRadius>) {
    let (k_rad, first) = (largest_k_rad(moved), first_moved_row(moved));
    let mut shaded = (Vec::new(), Vec::new());
    for (row, radius_um) in radii_um.iter().enumerate() {
        let here = moved.drops[row];
        let Some(next_um) = radii_um.get(row + 1) else {
            shaded.0.push(*radius_um);
            shaded.1.push(ShadedRadius { row, drops: here });
            break;
        };
        let next = moved.drops[row + 1];
        let apart_rad = k_rad * (next.eccentricity - here.eccentricity).abs();
        let step_rad = SHIFT_STEP_RAD.max(k_rad * here.eccentricity_sd);
        // Rows that stay are not used several times: what they leave out is what moves.
        let n = if row < first {
            1.0
        } else {
            (apart_rad / step_rad).ceil().clamp(1.0, 64.0)
        };
        for index in 0..n as usize {
            let part = index as f64 / n;
            let mixed = |a: f64, b: f64| a * (1.0 - part) + b * part;
            shaded.0.push(radius_um * (next_um / radius_um).powf(part));
            shaded.1.push(ShadedRadius {
                row: if part < 0.5 { row } else { row + 1 },
                drops: FallingDrops {
                    eccentricity: mixed(here.eccentricity, next.eccentricity),
                    eccentricity_sd: mixed(here.eccentricity_sd, next.eccentricity_sd),
                    ..here
                },
            });
        }
    }
    shaded
}

#[cfg(test)]
#[path = "moved_rows_tests.rs"]
mod tests;
