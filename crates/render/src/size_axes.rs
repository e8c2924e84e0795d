//! Places on the (effective radius, effective variance) axes of a scattering table, and light
//! deposited there.
//!
//! A table is interpolated linearly in ln r_e and in v_e:
//! t(r_e, v_e) = sum_b phi_b(r_e, v_e) t_b, with weights phi_b >= 0 that sum to 1.
//! A sum over samples i of light w_i is therefore
//! sum_i w_i t(r_i, v_i) = sum_b W_b t_b,  W_b = sum_i w_i phi_b(r_i, v_i):
//! depositing with the transpose of the interpolation is exact, and spectra are touched once per bin
//! instead of once per sample.
//!
//! f32: W_b sums some hundred terms of one sign; the relative error stays near 1e-6.

use std::ops::Range;

/// A place between the nodes of both axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SizePlace {
    /// Bin of the lower node on both axes.
    bin: usize,
    radius_fraction: f32,
    variance_fraction: f32,
}

/// The two size axes of a table.
#[derive(Clone, Debug)]
pub(crate) struct SizeAxes {
    ln_radius: Vec<f32>,
    /// One over the step from each node of the radius axis to the next.
    per_step: Vec<f32>,
    variance: Vec<f32>,
    /// Lower node at equal steps of ln r_e, so that a search takes a step or two.
    guide: Vec<u32>,
    guide_per_ln: f32,
    /// Whether the nodes of the radius axis stand at equal ratios.
    even: bool,
}

/// Part of a step that a node of an evenly divided axis may be off; f32 rounding alone makes 1e-4.
const EVEN_WITHIN: f32 = 2e-3;

/// Guide entries for each node of the radius axis.
const GUIDE_DENSITY: usize = 4;

impl SizeAxes {
    /// Axes through ascending nodes; at least one each.
    pub(crate) fn new(effective_radius_um: &[f64], effective_variance: &[f64]) -> Self {
        let ln_radius: Vec<f32> = effective_radius_um.iter().map(|r| r.ln() as f32).collect();
        let variance: Vec<f32> = effective_variance.iter().map(|v| *v as f32).collect();
        let (first, last) = (ln_radius[0], ln_radius[ln_radius.len() - 1]);
        let n_guides = GUIDE_DENSITY * ln_radius.len();
        let guide_per_ln = if last > first {
            n_guides as f32 / (last - first)
        } else {
            0.0
        };
        let guide = (0..=n_guides)
            .map(|step| {
                // One step back: rounding must not put the guide above its place.
                let ln = first + (step as f32 - 1.0) * (last - first) / n_guides as f32;
                let above = ln_radius.partition_point(|node| *node <= ln);
                above
                    .saturating_sub(1)
                    .min(ln_radius.len().saturating_sub(2)) as u32
            })
            .collect();
        let step = (last - first) / (ln_radius.len().max(2) - 1) as f32;
        let off = |(index, ln): (usize, &f32)| (ln - first - index as f32 * step).abs();
        let even = ln_radius
            .iter()
            .enumerate()
            .map(off)
            .all(|off| off < EVEN_WITHIN * step);
        let per_step = ln_radius
            .windows(2)
            .map(|ends| 1.0 / if even { step } else { ends[1] - ends[0] })
            .collect();
        Self {
            ln_radius,
            per_step,
            variance,
            guide,
            guide_per_ln,
            even,
        }
    }

    /// Number of bins, radius by variance.
    pub(crate) fn n_bins(&self) -> usize {
        self.ln_radius.len() * self.variance.len()
    }

    /// Number of nodes on the radius axis.
    #[inline]
    pub(crate) fn n_radii(&self) -> usize {
        self.ln_radius.len()
    }

    /// Nodes of the radius axis for a factor e, on the mean.
    #[inline]
    pub(crate) fn radii_per_ln(&self) -> f32 {
        self.guide_per_ln / GUIDE_DENSITY as f32
    }

    /// Number of nodes on the variance axis.
    #[inline]
    pub(crate) fn n_variances(&self) -> usize {
        self.variance.len()
    }

    /// Where drops of these moments lie; the ends of the axes hold beyond them.
    #[inline]
    pub(crate) fn place(&self, m2: f32, m3: f32, m4: f32) -> SizePlace {
        let n_variances = self.variance.len();
        let (radius_index, radius_fraction) = if self.ln_radius.len() > 1 {
            self.radius_place(m3 / m2)
        } else {
            (0, 0.0)
        };
        // Ratios before products: M4 M2 underflows where the ratios do not.
        let (variance_index, variance_fraction) = if n_variances > 1 {
            linear_place(&self.variance, (m4 / m3) * (m2 / m3) - 1.0)
        } else {
            (0, 0.0)
        };
        let bin = radius_index * n_variances + variance_index;
        SizePlace {
            bin,
            radius_fraction,
            variance_fraction,
        }
    }

    #[inline]
    fn radius_place(&self, radius_um: f32) -> (usize, f32) {
        let nodes = &self.ln_radius;
        let ln = natural_logarithm(radius_um);
        if self.even {
            // Nodes at equal ratios, the usual axis: no search. A NaN (no drops) converts to 0.
            let place = (ln - nodes[0]) * self.per_step[0];
            let index = (place as usize).min(nodes.len() - 2);
            return (index, unit_fraction(place - index as f32));
        }
        // A NaN (no drops) converts to 0.
        let step = ((ln - nodes[0]) * self.guide_per_ln) as usize;
        let mut index = self.guide[step.min(self.guide.len() - 1)] as usize;
        while index + 2 < nodes.len() && ln >= nodes[index + 1] {
            index += 1;
        }
        let fraction = (ln - nodes[index]) * self.per_step[index];
        (index, unit_fraction(fraction))
    }
}

/// ln x for normal positive x, to 3e-7: the exponent's bits, and atanh for the mantissa,
/// ln m = 2 (z + z³/3 + z⁵/5 + z⁷/7), z = (m - 1)/(m + 1), m in sqrt(1/2)..sqrt(2).
/// Zero, NaN and denormals give something finite; they stand for no drops.
#[inline]
fn natural_logarithm(x: f32) -> f32 {
    // Bits of sqrt(1/2): mantissas below it count to the exponent before.
    const HALF_ROOT: u32 = 0x3f35_04f3;
    let bits = x.to_bits().wrapping_sub(HALF_ROOT);
    let exponent = (bits as i32) >> 23;
    let mantissa = f32::from_bits((bits & 0x007f_ffff).wrapping_add(HALF_ROOT));
    let z = (mantissa - 1.0) / (mantissa + 1.0);
    let w = z * z;
    let ln_mantissa = 2.0 * z * ((1.0 + w * (1.0 / 3.0)) + w * w * (0.2 + w * (1.0 / 7.0)));
    exponent as f32 * std::f32::consts::LN_2 + ln_mantissa
}

/// Index of the lower node and the fraction above it, by a walk over the few nodes there are.
fn linear_place(nodes: &[f32], value: f32) -> (usize, f32) {
    let mut index = 0;
    while index + 2 < nodes.len() && value >= nodes[index + 1] {
        index += 1;
    }
    (
        index,
        unit_fraction((value - nodes[index]) / (nodes[index + 1] - nodes[index])),
    )
}

/// A fraction held in 0..=1; 0 for NaN.
#[inline]
fn unit_fraction(fraction: f32) -> f32 {
    if fraction > 0.0 {
        fraction.min(1.0)
    } else {
        0.0
    }
}

/// Light by size bin, W_b.
#[derive(Clone, Debug)]
pub(crate) struct SizeBins {
    /// With room for the zero weights beyond the last node of both axes.
    weights: Vec<f32>,
    n_bins: usize,
    n_variances: usize,
    low: usize,
    high: usize,
}

impl SizeBins {
    /// Empty bins.
    pub(crate) fn new(axes: &SizeAxes) -> Self {
        let (n_bins, n_variances) = (axes.n_bins(), axes.n_variances());
        let weights = vec![0.0; n_bins + n_variances + 1];
        Self {
            weights,
            n_bins,
            n_variances,
            low: usize::MAX,
            high: 0,
        }
    }

    /// Deposit light.
    #[inline]
    pub(crate) fn add(&mut self, place: SizePlace, light: f32) {
        let upper_radius = light * place.radius_fraction;
        let lower_radius = light - upper_radius;
        let (bin, next) = (place.bin, place.bin + self.n_variances);
        if self.n_variances > 1 {
            let fraction = place.variance_fraction;
            self.weights[bin] += lower_radius * (1.0 - fraction);
            self.weights[bin + 1] += lower_radius * fraction;
            self.weights[next] += upper_radius * (1.0 - fraction);
            self.weights[next + 1] += upper_radius * fraction;
        } else {
            self.weights[bin] += lower_radius;
            self.weights[next] += upper_radius;
        }
        self.low = self.low.min(bin);
        self.high = self.high.max(next + 2);
    }

    /// From the first to behind the last bin that was touched.
    #[inline]
    fn touched(&self) -> Range<usize> {
        let high = self.high.min(self.n_bins);
        self.low.min(high)..high
    }

    /// The touched bins that hold light, in ascending order.
    #[inline]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, f32)> {
        self.touched()
            .map(|bin| (bin, self.weights[bin]))
            .filter(|(_, weight)| *weight > 0.0)
    }

    /// Empty the touched bins.
    pub(crate) fn clear(&mut self) {
        let high = self.high.min(self.weights.len());
        self.weights[self.low.min(high)..high].fill(0.0);
        (self.low, self.high) = (usize::MAX, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of unit M2.
    fn moments(radius: f32, variance: f32) -> (f32, f32, f32) {
        (1.0, radius, (1.0 + variance) * radius * radius)
    }

    fn deposited(axes: &SizeAxes, sizes: &[(f32, f32, f32)]) -> Vec<f32> {
        let mut bins = SizeBins::new(axes);
        for (radius, variance, light) in sizes {
            let (m2, m3, m4) = moments(*radius, *variance);
            bins.add(axes.place(m2, m3, m4), *light);
        }
        let mut dense = vec![0.0; axes.n_bins()];
        for (bin, weight) in bins.iter() {
            dense[bin] = weight;
        }
        bins.clear();
        assert_eq!(bins.iter().count(), 0);
        dense
    }

    #[test]
    fn a_node_gets_all_of_its_own_light() {
        let radii: Vec<f64> = (0..40).map(|step| 10.0 * 1.1_f64.powi(step)).collect();
        let axes = SizeAxes::new(&radii, &[0.0, 0.1, 0.3]);
        for (index, radius) in radii.iter().enumerate() {
            let dense = deposited(&axes, &[(*radius as f32, 0.1, 2.0)]);
            // The rounding of ln r over the step ln 1.1; measured 5e-6.
            assert!((dense[3 * index + 1] - 2.0).abs() < 4e-5, "{index}");
            assert!((dense.iter().sum::<f32>() - 2.0).abs() < 1e-5);
        }
    }

    #[test]
    fn deposit_then_sum_is_interpolate_then_sum() {
        let radii = [5.0, 7.0, 20.0, 21.0, 300.0];
        let axes = SizeAxes::new(&radii, &[0.0, 0.05, 0.3]);
        let sizes = [
            (6.0, 0.01, 1.0),
            (19.0, 0.2, 0.5),
            (20.5, 0.3, 0.25),
            (299.0, 0.0, 2.0),
        ];
        let dense = deposited(&axes, &sizes);
        // A row that is linear in ln r and in v is reproduced exactly by linear interpolation.
        let row = |radius: f64, variance: f64| 3.0 + 2.0 * radius.ln() + 4.0 * variance;
        let mut shaded = 0.0;
        for (bin, weight) in dense.iter().enumerate() {
            shaded += f64::from(*weight) * row(radii[bin / 3], [0.0, 0.05, 0.3][bin % 3]);
        }
        let literal: f64 = sizes
            .iter()
            .map(|(r, v, w)| f64::from(*w) * row(f64::from(*r), f64::from(*v)))
            .sum();
        assert!((shaded / literal - 1.0).abs() < 2e-6, "{shaded} {literal}");
    }

    #[test]
    fn the_ends_hold_beyond_the_axes_and_nan_is_harmless() {
        let axes = SizeAxes::new(&[10.0, 100.0], &[0.0, 0.3]);
        assert_eq!(deposited(&axes, &[(1.0, 0.0, 1.0)]), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(deposited(&axes, &[(1e4, 0.45, 1.0)]), [0.0, 0.0, 0.0, 1.0]);
        let place = axes.place(0.0, 0.0, 0.0);
        let mut bins = SizeBins::new(&axes);
        bins.add(place, 0.0);
        assert_eq!(bins.iter().count(), 0);
    }

    #[test]
    fn the_logarithm_is_that_of_the_library() {
        let mut radius = 0.01_f32;
        while radius < 1e5 {
            let error = natural_logarithm(radius) - radius.ln();
            // Measured 9e-7 at ln r = 11.
            assert!(error.abs() < 2e-6, "{radius}: {error}");
            radius *= 1.0007;
        }
        for nothing in [0.0, f32::NAN, -1.0] {
            assert!(natural_logarithm(nothing).is_finite());
        }
    }

    #[test]
    fn one_size_needs_one_bin() {
        let axes = SizeAxes::new(&[100.0], &[0.0]);
        assert_eq!(
            deposited(&axes, &[(100.0, 0.0, 1.5), (100.0, 0.0, 0.5)]),
            [2.0]
        );
    }
}
