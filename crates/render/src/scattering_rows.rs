//! The scattering table, laid out for rays.
//!
//! With the sun in one direction the scattering angle theta is the same all along a ray, so a ray
//! needs one row of the table, t(lambda; r_e, v_e) at its theta, and of that only the sizes it meets.
//! The table comes as [polarization, r_e, v_e, wavelength, theta]; here it is
//! [theta, r_e x v_e, wavelength], natural light (half the sum of both polarizations), and only the
//! angles that the picture sees. f32 as in the file.

use niji_exchange::ScatteringTable;
use rayon::prelude::*;

use crate::error::Error;
use crate::size_axes::SizeAxes;
use crate::size_axes::SizeBins;

/// Angles that are copied at a time: a cache line of the table.
const BLOCK: usize = 16;

/// Rows by angle and size.
#[derive(Clone, Debug)]
pub(crate) struct ScatteringRows {
    axes: SizeAxes,
    theta_rad: Vec<f64>,
    n_wavelengths: usize,
    /// [1/sr], wavelength fastest.
    values_sr1: Vec<f32>,
    /// Luminance of a row in sunlight, by angle and bin [cd/m² per unit of light].
    luminance: Vec<f32>,
}

/// The table's angles that a ray takes part in, with weights that sum to 1.
#[derive(Clone, Debug, Default)]
pub(crate) struct AngleStencil {
    first: usize,
    weights: Vec<f32>,
}

impl ScatteringRows {
    /// The rows between two angles, one node beyond each; `luminance_weights` turn a spectrum of
    /// the table's unit into luminance.
    ///
    /// # Errors
    /// [`Error::BadTable`] if a value is negative or not finite.
    pub(crate) fn new(
        table: &ScatteringTable,
        theta_range_rad: (f64, f64),
        luminance_weights: &[f64],
    ) -> Result<Self, Error> {
        let angles = &table.theta_rad;
        let first = angles
            .partition_point(|theta| *theta <= theta_range_rad.0)
            .saturating_sub(1);
        let end =
            (angles.partition_point(|theta| *theta < theta_range_rad.1) + 1).min(angles.len());
        let axes = SizeAxes::new(&table.effective_radius_um, &table.effective_variance);
        let n_wavelengths = table.wavelengths.len();
        let n_bins = axes.n_bins();
        let n_angles = end - first;
        let angle_size = n_bins * n_wavelengths;
        let mut values_sr1 = vec![0.0; n_angles * angle_size];
        let mut luminance = vec![0.0; n_angles * n_bins];
        let standard = table.values.as_standard_layout();
        let flat = standard
            .as_slice()
            .expect("an array in standard layout is a slice");
        let blocks = values_sr1.par_chunks_mut(BLOCK * angle_size);
        let sound = blocks
            .zip(luminance.par_chunks_mut(BLOCK * n_bins))
            .enumerate()
            .map(|(block, (values, luminance))| {
                let from = first + block * BLOCK;
                copy_block(flat, angles.len(), from..(from + BLOCK).min(end), values);
                for (row, sum) in values.chunks_exact(n_wavelengths).zip(luminance) {
                    let terms = row.iter().zip(luminance_weights);
                    *sum = terms.map(|(t, y)| f64::from(*t) * y).sum::<f64>() as f32;
                }
                // Bits of numbers from 0 up to infinity are ordered; those of negative numbers and
                // NaN lie above. Without a branch this is a few vector instructions.
                values.iter().fold(true, |sound, value| {
                    sound & ((value + 0.0).to_bits() < f32::INFINITY.to_bits())
                })
            })
            .reduce(|| true, |a, b| a && b);
        if !sound {
            let reason = "a value is negative or not finite";
            return Err(Error::BadTable {
                input: "scattering table",
                reason,
            });
        }
        let theta_rad = angles[first..end].to_vec();
        Ok(Self {
            axes,
            theta_rad,
            n_wavelengths,
            values_sr1,
            luminance,
        })
    }

    /// The size axes.
    pub(crate) fn axes(&self) -> &SizeAxes {
        &self.axes
    }

    /// Linear interpolation at an angle.
    pub(crate) fn stencil_at(&self, theta_rad: f64, stencil: &mut AngleStencil) {
        stencil.weights.clear();
        let nodes = &self.theta_rad;
        if nodes.len() == 1 {
            stencil.first = 0;
            stencil.weights.push(1.0);
            return;
        }
        let above = nodes.partition_point(|node| *node <= theta_rad);
        let lower = above.saturating_sub(1).min(nodes.len() - 2);
        let fraction = (theta_rad - nodes[lower]) / (nodes[lower + 1] - nodes[lower]);
        let fraction = fraction.clamp(0.0, 1.0) as f32;
        stencil.first = lower;
        stencil.weights.extend([1.0 - fraction, fraction]);
    }

    /// The mean of the linear interpolant over an interval of angles around `theta_rad`, which ends
    /// where the rows end.
    pub(crate) fn stencil_over(&self, theta_rad: f64, width_rad: f64, stencil: &mut AngleStencil) {
        let nodes = &self.theta_rad;
        let low = (theta_rad - 0.5 * width_rad).max(nodes[0]);
        let high = (theta_rad + 0.5 * width_rad).min(nodes[nodes.len() - 1]);
        // Too narrow for a mean in f64, or one node only.
        if high - low <= 1e-12 {
            self.stencil_at(theta_rad, stencil);
            return;
        }
        let first = nodes.partition_point(|node| *node <= low).saturating_sub(1);
        let end = (nodes.partition_point(|node| *node < high) + 1).min(nodes.len());
        stencil.first = first;
        stencil.weights.clear();
        stencil.weights.resize(end - first, 0.0);
        for lower in first..end - 1 {
            let step = nodes[lower + 1] - nodes[lower];
            let from = ((low - nodes[lower]) / step).clamp(0.0, 1.0);
            let to = ((high - nodes[lower]) / step).clamp(0.0, 1.0);
            // Integrals of the two hat functions of a step over its covered part.
            let upper_part = 0.5 * (to * to - from * from) * step / (high - low);
            let lower_part = (to - from) * step / (high - low) - upper_part;
            stencil.weights[lower - first] += lower_part as f32;
            stencil.weights[lower - first + 1] += upper_part as f32;
        }
    }

    /// Add to `spectrum` [1/sr] the rows of the light in `bins`.
    pub(crate) fn shade(&self, bins: &SizeBins, stencil: &AngleStencil, spectrum: &mut [f32]) {
        for (bin, light) in bins.iter() {
            for (offset, weight) in stencil.weights.iter().enumerate() {
                let scale = light * weight;
                let row = self.row(stencil.first + offset, bin);
                for (sum, value) in spectrum.iter_mut().zip(row) {
                    *sum += scale * value;
                }
            }
        }
    }

    /// Luminance in sunlight of the light in `bins`, and its estimated error from the linear
    /// interpolation between sizes: h²/12 times the second derivative is its mean over a step.
    pub(crate) fn luminance(&self, bins: &SizeBins, stencil: &AngleStencil) -> (f64, f64) {
        let stride = self.axes.n_variances();
        let n_bins = self.axes.n_bins();
        let (mut sum, mut bend) = (0.0, 0.0);
        // With one variance the touched bins are neighbours, and each is looked up once.
        let mut known = (usize::MAX, 0.0, 0.0);
        for (bin, light) in bins.iter() {
            let light = f64::from(light);
            let (before, here) = if known.0 == bin {
                (known.1, known.2)
            } else {
                let before = bin
                    .checked_sub(stride)
                    .map(|bin| self.luminance_of(bin, stencil));
                (before.unwrap_or(0.0), self.luminance_of(bin, stencil))
            };
            sum += light * here;
            if bin + stride < n_bins {
                let after = self.luminance_of(bin + stride, stencil);
                if bin >= stride {
                    bend += light * (before - 2.0 * here + after);
                }
                known = (bin + stride, here, after);
            }
        }
        (sum, bend.abs() / 12.0)
    }

    #[inline]
    fn luminance_of(&self, bin: usize, stencil: &AngleStencil) -> f64 {
        let n_bins = self.axes.n_bins();
        let terms = stencil.weights.iter().enumerate().map(|(offset, weight)| {
            f64::from(*weight) * f64::from(self.luminance[(stencil.first + offset) * n_bins + bin])
        });
        terms.sum()
    }

    #[inline]
    fn row(&self, angle: usize, bin: usize) -> &[f32] {
        let start = (angle * self.axes.n_bins() + bin) * self.n_wavelengths;
        &self.values_sr1[start..start + self.n_wavelengths]
    }
}

/// Natural light at some angles, from [polarization, radius x variance x wavelength, angle] to
/// [angle, radius x variance x wavelength].
fn copy_block(table: &[f32], n_theta: usize, angles: std::ops::Range<usize>, values: &mut [f32]) {
    let angle_size = values.len() / angles.len();
    let (s_part, p_part) = table.split_at(table.len() / 2);
    let lanes = s_part
        .chunks_exact(n_theta)
        .zip(p_part.chunks_exact(n_theta));
    for (place, (s_lane, p_lane)) in lanes.enumerate() {
        let natural = s_lane[angles.clone()].iter().zip(&p_lane[angles.clone()]);
        for (angle, (s, p)) in natural.enumerate() {
            values[angle * angle_size + place] = 0.5 * (s + p);
        }
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array6;
    use niji_radiometry::WavelengthGrid;

    use super::*;

    /// t = theta (1 + bin) (1 + wavelength), s and p apart by a factor 3.
    fn table() -> ScatteringTable {
        let wavelengths = WavelengthGrid::new(500.0, 50.0, 3).unwrap();
        let theta_rad: Vec<f64> = (0..=20).map(|step| 2.0 + 0.05 * f64::from(step)).collect();
        let values = Array6::from_shape_fn((2, 4, 1, 1, 3, 21), |(j, r, _, _, w, a)| {
            ([0.5, 1.5][j] * theta_rad[a] * (1 + r) as f64 * (1 + w) as f64) as f32
        });
        ScatteringTable {
            theory: "test".into(),
            orders: "all".into(),
            wavelengths,
            theta_rad,
            effective_radius_um: vec![10.0, 20.0, 40.0, 80.0],
            effective_variance: vec![0.0],
            flattening: vec![0.0],
            values,
            sun_disc_diameter_rad: 0.0,
            split_theta_rad: 2.2,
            forward_fraction_left_out: 0.0,
            temperature_c: 20.0,
        }
    }

    fn rows() -> ScatteringRows {
        ScatteringRows::new(&table(), (2.3, 2.61), &[0.0, 1.0, 0.0]).unwrap()
    }

    fn shaded(stencil: &AngleStencil) -> Vec<f32> {
        let rows = rows();
        let mut bins = SizeBins::new(rows.axes());
        bins.add(rows.axes().place(1.0, 40.0, 1600.0), 2.0);
        let mut spectrum = vec![0.0; 3];
        rows.shade(&bins, stencil, &mut spectrum);
        assert!((rows.luminance(&bins, stencil).0 - f64::from(spectrum[1])).abs() < 1e-4);
        spectrum
    }

    #[test]
    fn natural_light_of_a_linear_table_is_reproduced() {
        let mut stencil = AngleStencil::default();
        for theta in [2.3, 2.33, 2.5, 2.61] {
            rows().stencil_at(theta, &mut stencil);
            for (wavelength, value) in shaded(&stencil).into_iter().enumerate() {
                let expected = 2.0 * theta * 3.0 * (1 + wavelength) as f64;
                assert!((f64::from(value) / expected - 1.0).abs() < 1e-5, "{theta}");
            }
        }
    }

    #[test]
    fn the_mean_of_a_linear_table_over_an_interval_is_its_middle() {
        let mut stencil = AngleStencil::default();
        for width in [1e-4, 0.02, 0.2] {
            rows().stencil_over(2.45, width, &mut stencil);
            assert!((stencil.weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            assert!(
                (shaded(&stencil)[0] / (2.0 * 2.45 * 3.0) - 1.0).abs() < 1e-5,
                "{width}"
            );
        }
        rows().stencil_over(2.45, 0.0, &mut stencil);
        assert!((shaded(&stencil)[0] / (2.0 * 2.45 * 3.0) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_table_with_nan_is_refused() {
        let mut table = table();
        table.values[[1, 2, 0, 0, 1, 8]] = f32::NAN;
        let refused = ScatteringRows::new(&table, (2.3, 2.61), &[0.0, 1.0, 0.0]);
        assert!(matches!(refused, Err(Error::BadTable { .. })));
    }
}
