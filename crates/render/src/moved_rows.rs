//! The light of flattened drops, moved and widened radius by radius while it is shaded.
//!
//! L = Σ_a u_a Σ_p <t_p(θ − Δθ_p(a); a)>,   u_a = Σ_b W_b w_ba
//! `W_b` light deposited at a node b of sizes, `w_ba` share of the radius a in its law, `t_p` the light of
//! order p of single drops, <> the mean over a stretch of angles as wide as the pixel and waves, and as the spread of
//! tilted and trembling drops and of all that a radius stands for, together: of the variance
//! w²/12 = footprint²/12 + sd² + (∂Δθ/∂e δe)²/12, `δe` step of eccentricity around it. It is never narrower
//! than the step of the order's angles there. The mean is a difference of integrals over θ, linear between
//! them, so that it costs the same for any width (`moved_angles`).
//!
//! Light of which polarization counts moves alike in both: what it takes to find its angles is done once.
//!
//! Wavelengths move by different amounts; those that differ by less than a 25th of the sun's diameter go
//! together, eight always do.
//!
//! Where the moved light of a radius comes from beyond the angles of the table, it is dark; at 0 and 180
//! degrees it comes from the mirrored angle.

use std::f64::consts::PI;
use std::ops::Range;

use ndarray::Array1;
use ndarray::Array2;
use ndarray::ArrayView1;
use ndarray::Axis;
use ndarray::s;
use niji_exchange::Attitude;
use niji_exchange::BowShift;
use niji_exchange::FARTHEST_SHIFT_RAD;
use niji_exchange::MovedOrder;
use niji_exchange::N_STRETCHES;
use niji_exchange::ScatteringTable;
use niji_exchange::SeenShift;
use niji_exchange::stretch_of;
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
const DARK: f64 = 1e-6;
/// Share of the light of a ray below which that of a row is left out: the tails of laws.
const FEW: f32 = 1e-6;
/// What means miss between angles, in parts of what an angle lies off the line between its neighbors, h² t″/2:
/// integrals over trapezoids h² t″/12 at most, and h² t″/8 where they are taken between angles.
const OF_BEND: f64 = 5.0 / 12.0;
/// Wavelengths are shaded in lanes of so many.
const LANES: usize = 8;

/// Over what light is blurred besides its drops.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Blur {
    /// The angles of a pixel: an even mean.
    Pixel,
    /// Those of waves and a pixel: a mean over a tent. Bows may be one that lie no farther apart.
    Waves { apart_rad: f64 },
}

/// Rows of the orders that move, of natural light or of each polarization.
#[derive(Debug)]
pub(crate) struct MovedRows {
    blur: Blur,
    orders: Vec<OrderRows>,
    drops: Vec<DropsAround>,
    /// By node of sizes.
    laws: Vec<RowWeights>,
    n_polarizations: usize,
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
    /// Integral over the angle by [row, angle, polarization, wavelength], lanes of 0 behind the last wavelength.
    integrals: Vec<f32>,
    rows: Vec<RowBounds>,
}

/// Where a row of an order is light, and how much.
#[derive(Debug)]
struct RowBounds {
    /// What luminance in sunlight errs by, by polarization and stretch of angles [cd/m² per unit of light].
    errors: Vec<[f64; N_STRETCHES]>,
    /// Angles between which all but a millionth of its light lies, of every polarization and wavelength.
    lit_rad: [f64; 2],
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
    /// By polarization.
    lights: Vec<MovedLight>,
}

/// Moved light of natural light, or of a polarization.
#[derive(Clone, Debug, Default)]
pub(crate) struct MovedLight {
    /// Padded behind the last wavelength.
    pub(crate) spectrum: Vec<f32>,
    /// What the table errs by in it, rms [cd/m²].
    pub(crate) error_cd_m2: f64,
}

/// Where a ray stands.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MovedPlace {
    pub(crate) theta_rad: f64,
    /// Even stretch of scattering angles with the variance of its pixel and of waves.
    pub(crate) width_rad: f64,
    /// T² and B² of upright drops.
    pub(crate) axis_squares: [f64; 2],
}

impl MovedRows {
    /// The moved light of tables, one a polarization, for light at the nodes of sizes; `luminance_weights` turn a
    /// spectrum of the table's unit into luminance. `None` if nothing moves.
    pub(crate) fn new(
        tables: &[ScatteringTable],
        nodes: &SizeNodes,
        luminance_weights: &[f64],
        blur: Blur,
    ) -> Option<Self> {
        let table = tables.first()?;
        let moved = table.moved.as_ref()?;
        let (n_integrals, apart_rad) = match blur {
            Blur::Pixel => (1, 0.0),
            Blur::Waves { apart_rad } => (2, apart_rad),
        };
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
        let order = |index: usize| {
            let of_tables = tables.iter().filter_map(|table| table.moved.as_ref());
            let source = OrderSource {
                polarizations: of_tables.map(|moved| &moved.orders[index]).collect(),
                luminance_weights,
                relative_error: table.relative_error,
            };
            source.rows(&radii.rows, n_integrals)
        };
        Some(Self {
            blur,
            orders: (0..moved.orders.len()).map(order).collect(),
            laws: (0..n_bins).into_par_iter().map(law).collect(),
            n_polarizations: tables.len(),
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

    /// Move the light at some nodes.
    pub(crate) fn shade(&self, light: &[(usize, f32)], stencil: &mut MovedStencil) {
        let MovedStencil {
            weights, lights, ..
        } = stencil;
        weights.clear();
        weights.resize(self.drops.len(), 0.0);
        for (bin, light) in light {
            let law = &self.laws[*bin];
            for (sum, weight) in weights[law.first..].iter_mut().zip(&law.weights) {
                *sum += light * weight;
            }
        }
        lights.resize(self.n_polarizations, MovedLight::default());
        for light in lights.iter_mut() {
            light.error_cd_m2 = 0.0;
            light.spectrum.clear();
            light.spectrum.resize(self.n_padded, 0.0);
        }
        match self.blur {
            Blur::Pixel => Arch::new().dispatch(Shading::<2>::of(self, stencil)),
            Blur::Waves { .. } => Arch::new().dispatch(Shading::<3>::of(self, stencil)),
        }
        // What rounding leaves of the difference of equal integrals may lie below 0.
        let lights = stencil.lights.iter_mut();
        for value in lights.flat_map(|light| &mut light.spectrum) {
            *value = value.max(0.0);
        }
    }
}

impl MovedStencil {
    /// The light that was moved last, by polarization.
    pub(crate) fn lights(&self) -> &[MovedLight] {
        &self.lights
    }
}

impl MovedLight {
    /// Add it to a spectrum.
    pub(crate) fn add_to(&self, spectrum: &mut [f32]) {
        for (sum, value) in spectrum.iter_mut().zip(&self.spectrum) {
            *sum += value;
        }
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
/// width. A mean is made of integrals at so many places.
struct Shading<'a, const PLACES: usize> {
    rows: &'a MovedRows,
    place: &'a MovedPlace,
    attitude: &'a Attitude,
    seen: &'a [SeenShift],
    weights: &'a [f32],
    lights: &'a mut [MovedLight],
}

#[allow(
    clippy::inline_always,
    reason = "a function of its own would have the narrowest vectors"
)]
impl<const PLACES: usize> WithSimd for Shading<'_, PLACES> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        let n_lanes = self.rows.n_padded / LANES;
        let stretch = stretch_of(self.place.theta_rad);
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
                for (light, errors) in self.lights.iter_mut().zip(&order.rows[row].errors) {
                    light.error_cd_m2 += f64::from(*weight) * errors[stretch];
                }
                self.add_order((order, seen), row, *weight);
            }
        }
    }
}

#[allow(clippy::inline_always, reason = "as above")]
impl<'a, const PLACES: usize> Shading<'a, PLACES> {
    fn of(rows: &'a MovedRows, stencil: &'a mut MovedStencil) -> Self {
        Self {
            rows,
            place: &stencil.place,
            attitude: &stencil.attitude,
            seen: &stencil.seen,
            weights: &stencil.weights,
            lights: &mut stencil.lights,
        }
    }

    /// Add one order of one row: lanes whose bows lie close together at one shift.
    #[inline(always)]
    fn add_order(&mut self, (order, seen): (&OrderRows, &[SeenShift]), row: usize, weight: f32) {
        let (n_lanes, around) = (seen.len() / 2, &self.rows.drops[row]);
        let shift_rad = |half: usize| {
            let shift_rad = seen[half].shift_rad(around.drops.eccentricity);
            shift_rad.clamp(-FARTHEST_SHIFT_RAD, FARTHEST_SHIFT_RAD)
        };
        let variance = around.variance_rad2(&seen[n_lanes], self.attitude);
        let width_rad = (12.0 * variance + self.place.width_rad.powi(2)).sqrt();
        let (first_rad, last_rad) = (shift_rad(0), shift_rad(2 * n_lanes));
        // From secondary to primary one of them is dark, and so is the other beyond.
        let reach_rad =
            (first_rad - last_rad).abs() + order.angles.farthest_rad::<PLACES>(width_rad);
        let [lit_from, lit_to] = order.rows[row].lit_rad;
        let seen_rad = self.place.theta_rad - first_rad;
        if seen_rad + reach_rad < lit_from || seen_rad - reach_rad > lit_to {
            return;
        }
        let alike_rad = APART_RAD.max(APART_OF_WIDTH * width_rad);
        let n_apart = ((first_rad - last_rad).abs() / alike_rad).ceil().max(1.0) as usize;
        let n_groups = n_apart.min(n_lanes);
        for group in 0..n_groups {
            let [from, to] = [group, group + 1].map(|edge| edge * n_lanes / n_groups);
            let moved_rad = shift_rad(from + to);
            let mean = (order.angles).mean::<PLACES>(self.place.theta_rad - moved_rad, width_rad);
            if let Some(mean) = mean {
                let AngleMean { places, shares } = mean;
                let shares = shares.map(|pair| pair.map(|share| weight * share));
                let mean = AngleMean { places, shares };
                self.add_lanes((order, row), &mean, from * LANES..to * LANES);
            }
        }
    }

    /// Add some lanes of one order of one row.
    #[inline(always)]
    fn add_lanes(
        &mut self,
        (order, row): (&OrderRows, usize),
        mean: &AngleMean<PLACES>,
        lanes: Range<usize>,
    ) {
        let n_of_angle = self.rows.n_polarizations * self.rows.n_padded;
        let row = row * order.angles.theta_rad.len() * n_of_angle;
        for (polarization, light) in self.lights.iter_mut().enumerate() {
            let integrals = mean.places.map(|angle| {
                let start = row + angle * n_of_angle + polarization * self.rows.n_padded;
                [start, start + n_of_angle].map(|start| {
                    let values = &order.integrals[start + lanes.start..start + lanes.end];
                    values.as_chunks::<LANES>().0
                })
            });
            let sums = light.spectrum[lanes.clone()].as_chunks_mut::<LANES>().0;
            for (index, sums) in sums.iter_mut().enumerate() {
                // Copies: what is stored could otherwise be what is read next.
                let pairs = integrals.map(|pair| pair.map(|lanes| lanes[index]));
                let mut sum = *sums;
                for lane in 0..LANES {
                    let mut difference = 0.0;
                    for ([low, high], [a, b]) in pairs.iter().zip(mean.shares) {
                        difference += a * low[lane] + b * high[lane];
                    }
                    sum[lane] += difference;
                }
                *sums = sum;
            }
        }
    }
}

/// What the rows of an order are made from.
struct OrderSource<'a> {
    /// The order of each polarization.
    polarizations: Vec<&'a MovedOrder>,
    luminance_weights: &'a [f64],
    /// What its table was made for, in parts of a peak.
    relative_error: f64,
}

impl OrderSource<'_> {
    /// Rows that are means of the table's, integrated so many times.
    fn rows(&self, means: &[RowMean], n_integrals: u32) -> OrderRows {
        let order = self.polarizations[0];
        let (_, _, n_wavelengths, _) = order.values.dim();
        let n_padded = n_wavelengths.next_multiple_of(LANES);
        let angles = MovedAngles::mirrored(&order.theta_rad);
        let n_of_angle = self.polarizations.len() * n_padded;
        let n_of_row = angles.theta_rad.len() * n_of_angle;
        let mut integrals = vec![0.0; means.len() * n_of_row];
        let of_rows = integrals.par_chunks_mut(n_of_row).zip(means);
        let rows = of_rows.map(|(row, mean)| {
            let mut bounds = RowBounds {
                errors: Vec::new(),
                lit_rad: [f64::INFINITY, f64::NEG_INFINITY],
            };
            for (polarization, order) in self.polarizations.iter().enumerate() {
                let light = natural_light(order, mean);
                bounds.errors.push(self.errors(&light));
                let light = continued((&light, &order.theta_rad), &angles.theta_rad);
                let mut integral = integral_of(&light, &angles.theta_rad);
                let [from, to] = lit_rad(&integral, &angles.theta_rad);
                let [lit_from, lit_to] = bounds.lit_rad;
                bounds.lit_rad = [lit_from.min(from), lit_to.max(to)];
                for _ in 1..n_integrals {
                    count_from_peak(&mut integral, &light);
                    integral = integral_of(&integral, &angles.theta_rad);
                    count_from_peak(&mut integral, &light);
                }
                let places = row[polarization * n_padded..].chunks_mut(n_of_angle);
                for (place, values) in places.zip(integral.outer_iter()) {
                    // f32: 1e-7 of the whole integral, 1e-4 of the peak over the narrowest step.
                    for (place, value) in place.iter_mut().zip(values) {
                        *place = *value as f32;
                    }
                }
            }
            bounds
        });
        let rows = rows.collect();
        let half = |index: usize| order.shifts[(index * LANES / 2).min(n_wavelengths - 1)];
        OrderRows {
            shifts: (0..=2 * n_padded / LANES).map(half).collect(),
            angles,
            integrals,
            rows,
        }
    }

    /// What the table errs by in each stretch: what sums of its radii keep (single radii err many times more between
    /// those of the table, and none is taken alone), or what means miss between its angles, where that is more.
    fn errors(&self, light: &Array2<f64>) -> [f64; N_STRETCHES] {
        let weights = Array1::from(self.luminance_weights.to_vec());
        let luminance = weights.dot(light);
        let theta_rad = &self.polarizations[0].theta_rad;
        let mut errors = [0.0_f64; N_STRETCHES];
        let mut tell = |theta_rad: f64, error: f64| {
            let known = &mut errors[stretch_of(theta_rad)];
            *known = known.max(error);
        };
        for (theta_rad, luminance) in theta_rad.iter().zip(&luminance) {
            tell(*theta_rad, self.relative_error * luminance);
        }
        for index in 1..theta_rad.len().saturating_sub(1) {
            let [before, here, after] = [index - 1, index, index + 1].map(|at| theta_rad[at]);
            let part = (here - before) / (after - before);
            let line = luminance[index - 1] * (1.0 - part) + luminance[index + 1] * part;
            let error = OF_BEND * (luminance[index] - line).abs();
            // Of the steps on both sides.
            for theta_rad in [before, here, after] {
                tell(theta_rad, error);
            }
        }
        errors
    }
}

/// Natural light of a row by [wavelength, angle of the table].
fn natural_light(order: &MovedOrder, mean: &RowMean) -> Array2<f64> {
    let (_, _, n_wavelengths, n_theta) = order.values.dim();
    let mut light = Array2::zeros((n_wavelengths, n_theta));
    for (row, share) in mean {
        for polarization in [0, 1] {
            let values = order.values.slice(s![polarization, *row, .., ..]);
            let scale = 0.5 * share;
            light.zip_mut_with(&values, |sum, value| *sum += scale * f64::from(*value));
        }
    }
    light
}

/// Light by [angle, wavelength], over angles that go on where those of the order are mirrored.
fn continued((light, own_rad): (&Array2<f64>, &[f64]), theta_rad: &[f64]) -> Array2<f64> {
    let before = theta_rad.partition_point(|theta| *theta < own_rad[0]);
    // The angle of the order that a mirrored one is.
    let source = |angle: usize| {
        let place = angle as i64 - before as i64;
        let last = own_rad.len() as i64 - 1;
        (last - (last - place.abs()).abs()).clamp(0, last) as usize
    };
    let sources: Vec<usize> = (0..theta_rad.len()).map(source).collect();
    light.select(Axis(1), &sources).reversed_axes()
}

/// The integral over the angle of what is linear between angles.
fn integral_of(values: &Array2<f64>, theta_rad: &[f64]) -> Array2<f64> {
    let mut integrals = Array2::zeros(values.dim());
    for (values, mut integral) in values.columns().into_iter().zip(integrals.columns_mut()) {
        let mut sum = 0.0;
        for angle in 1..theta_rad.len() {
            let step = theta_rad[angle] - theta_rad[angle - 1];
            sum += 0.5 * step * (values[angle - 1] + values[angle]);
            integral[angle] = sum;
        }
    }
    integrals
}

/// Have integrals begin where a wavelength has its peak: differences do not change, and the f32 of what is integrated
/// twice, which grows with the square of the way, round least there.
fn count_from_peak(integrals: &mut Array2<f64>, light: &Array2<f64>) {
    for (mut integral, light) in integrals.columns_mut().into_iter().zip(light.columns()) {
        let brighter = |peak: usize, (angle, value): (usize, &f64)| {
            if *value > light[peak] { angle } else { peak }
        };
        let peak = light.iter().enumerate().fold(0, brighter);
        let there = integral[peak];
        integral -= there;
    }
}

/// The angles between which each wavelength has all but a millionth of its integral.
fn lit_rad(integral: &Array2<f64>, theta_rad: &[f64]) -> [f64; 2] {
    let last = theta_rad.len() - 1;
    let all = integral.row(last);
    let n_while = |holds: &dyn Fn(ArrayView1<f64>) -> bool| {
        let angles = (0..=last).take_while(|angle| holds(integral.row(*angle)));
        angles.count()
    };
    let n_dark = n_while(&|sums| sums.iter().zip(all).all(|(sum, all)| *sum <= DARK * all));
    // Where it lacks more than that.
    let lacks_some = |(sum, all): (&f64, &f64)| *sum < (1.0 - DARK) * all;
    let n_lacking = n_while(&|sums| sums.iter().zip(all).any(lacks_some));
    [n_dark.saturating_sub(1), n_lacking.min(last)].map(|angle| theta_rad[angle])
}

#[cfg(test)]
#[path = "moved_rows_tests.rs"]
mod tests;
