//! The light of drops of one size over the scattering angle, and how far two such curves are apart.
//!
//! relative RMSE = sqrt(Σ (t − t_ref)² / Σ t_ref²) over angles and wavelengths
//! `t` natural light of a scattering table [1/sr]. Colors are those of the drops in sunlight above
//! the air, adapted to the sun's own color, the reference's brightest direction at L* = 100: what an
//! eye sees that looks at the bow. Their difference is CIEDE2000, of which 1 is just seen side by side.

use ndarray::Array2;
use niji_exchange::ScatteringTable;
use niji_radiometry::Colorimetry;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use palette::Lab;
use palette::Xyz;
use palette::color_difference::Ciede2000;
use palette::convert::FromColorUnclamped;
use palette::white_point::D65;
use palette::white_point::WhitePoint;

/// Natural light over angle and wavelength.
#[derive(Clone, Debug)]
pub(crate) struct BowCurves {
    /// Scattering angles, ascending.
    pub(crate) angles_rad: Vec<f64>,
    /// Wavelength bins.
    pub(crate) wavelengths: WavelengthGrid,
    /// By angle and wavelength [1/sr].
    pub(crate) values_sr1: Array2<f64>,
}

/// How far curves are from their reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Distance {
    /// RMSE over the RMS of the reference.
    pub(crate) relative_rmse: f64,
    /// Largest difference over the reference's peak.
    pub(crate) max_over_peak: f64,
    /// CIEDE2000, mean over the angles.
    pub(crate) mean_color_difference: f64,
    /// CIEDE2000, largest.
    pub(crate) max_color_difference: f64,
    /// Brightest direction less that of the reference, in degrees.
    pub(crate) peak_shift_deg: f64,
}

impl BowCurves {
    /// Even angles from `low_rad` to `high_rad`, at most `step_rad` apart.
    pub(crate) fn even_angles((low_rad, high_rad): (f64, f64), step_rad: f64) -> Vec<f64> {
        let n_steps = ((high_rad - low_rad) / step_rad).ceil().max(1.0) as usize;
        Self::even_angles_between((low_rad, high_rad), n_steps + 1)
    }

    /// `n` even angles, both ends among them.
    pub(crate) fn even_angles_between((low_rad, high_rad): (f64, f64), n: usize) -> Vec<f64> {
        let step_rad = (high_rad - low_rad) / (n - 1) as f64;
        (0..n)
            .map(|index| low_rad + step_rad * index as f64)
            .collect()
    }

    /// One size of a table of spheres, linear between its angles.
    pub(crate) fn of(table: &ScatteringTable, size: [usize; 2], angles_rad: Vec<f64>) -> Self {
        let n_wavelengths = table.wavelengths.len();
        let mut values_sr1 = Array2::zeros((angles_rad.len(), n_wavelengths));
        for (&angle, mut row) in angles_rad.iter().zip(values_sr1.rows_mut()) {
            let nodes = &table.theta_rad;
            let upper = nodes
                .partition_point(|&node| node <= angle)
                .clamp(1, nodes.len() - 1);
            let (low, high) = (nodes[upper - 1], nodes[upper]);
            let part = ((angle - low) / (high - low)).clamp(0.0, 1.0);
            for (wavelength, value) in row.iter_mut().enumerate() {
                let natural = |node: usize| {
                    let polarized =
                        |j| f64::from(table.values[[j, size[0], size[1], wavelength, node]]);
                    0.5 * (polarized(0) + polarized(1))
                };
                *value = natural(upper - 1) * (1.0 - part) + natural(upper) * part;
            }
        }
        Self {
            angles_rad,
            wavelengths: table.wavelengths,
            values_sr1,
        }
    }

    /// The curve of the wavelength bin that is nearest, in degrees and 1/sr.
    pub(crate) fn curve_near(&self, wavelength_nm: f64) -> Vec<(f64, f64)> {
        let distance = |index: usize| (self.wavelengths.center(index).0 - wavelength_nm).abs();
        let nearest =
            (0..self.wavelengths.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        let column = self.values_sr1.column(nearest.unwrap_or(0));
        let degrees = self.angles_rad.iter().map(|angle| angle.to_degrees());
        degrees.zip(column.iter().copied()).collect()
    }

    /// How far these curves are from a reference on the same angles.
    pub(crate) fn distance(&self, reference: &Self) -> Distance {
        let pairs = || self.values_sr1.iter().zip(&reference.values_sr1);
        let squares: f64 = pairs()
            .map(|(value, expected)| (value - expected).powi(2))
            .sum();
        let total: f64 = reference.values_sr1.iter().map(|value| value * value).sum();
        let largest = pairs()
            .map(|(value, expected)| (value - expected).abs())
            .fold(0.0, f64::max);
        let peak = reference.values_sr1.iter().copied().fold(0.0, f64::max);
        let (own, expected) = (self.xyz(), reference.xyz());
        let white = self.white();
        let brightest = expected.iter().map(|xyz| xyz[1]).fold(0.0, f64::max);
        let differences: Vec<f64> = own
            .iter()
            .zip(&expected)
            .map(|(own, expected)| {
                lab(*own, white, brightest).difference(lab(*expected, white, brightest))
            })
            .collect();
        let over = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { 0.0 };
        Distance {
            relative_rmse: over(squares, total).sqrt(),
            max_over_peak: over(largest, peak),
            mean_color_difference: differences.iter().sum::<f64>() / differences.len() as f64,
            max_color_difference: differences.iter().copied().fold(0.0, f64::max),
            peak_shift_deg: (self.angles_rad[brightest_index(&own)]
                - self.angles_rad[brightest_index(&expected)])
            .to_degrees(),
        }
    }

    /// CIE XYZ by angle, in sunlight of 1 AU above the air: cd/m² for each W/(m² nm) taken as 1/sr.
    pub(crate) fn xyz(&self) -> Vec<[f64; 3]> {
        let observer = Colorimetry::new(&self.wavelengths);
        let sun = solar_irradiance(&self.wavelengths);
        let seen = |row: ndarray::ArrayView1<f64>| {
            let radiance: Vec<f64> = row.iter().zip(&sun).map(|(t, sun)| t * sun).collect();
            observer.xyz(&radiance)
        };
        self.values_sr1.rows().into_iter().map(seen).collect()
    }

    fn white(&self) -> [f64; 3] {
        let xyz = Colorimetry::new(&self.wavelengths).xyz(&solar_irradiance(&self.wavelengths));
        xyz.map(|value| value / xyz[1])
    }
}

fn brightest_index(xyz: &[[f64; 3]]) -> usize {
    let indices = 0..xyz.len();
    indices
        .max_by(|&a, &b| xyz[a][1].total_cmp(&xyz[b][1]))
        .unwrap_or(0)
}

/// CIELAB relative to a white of luminance `brightest`; the crate knows fixed whites only, so the
/// color is scaled to one of them, as CIELAB itself does.
fn lab(xyz: [f64; 3], white: [f64; 3], brightest: f64) -> Lab<D65, f64> {
    let known: Xyz<palette::white_point::Any, f64> = D65::get_xyz();
    let scale = if brightest > 0.0 {
        brightest.recip()
    } else {
        0.0
    };
    let relative = |channel: usize, known: f64| scale * xyz[channel] / white[channel] * known;
    Lab::from_color_unclamped(Xyz::<D65, f64>::new(
        relative(0, known.x),
        relative(1, known.y),
        relative(2, known.z),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curves(scale: f64, shift: f64) -> BowCurves {
        let wavelengths = WavelengthGrid::visible();
        let angles_rad = BowCurves::even_angles((2.3, 2.5), 0.001);
        let values_sr1 = Array2::from_shape_fn((angles_rad.len(), 41), |(angle, wavelength)| {
            let place = angles_rad[angle] - 2.4 - shift - 1e-3 * wavelength as f64;
            scale * (-(place / 0.02).powi(2)).exp()
        });
        BowCurves {
            angles_rad,
            wavelengths,
            values_sr1,
        }
    }

    #[test]
    fn equal_curves_are_no_distance_apart() {
        let distance = curves(0.1, 0.0).distance(&curves(0.1, 0.0));
        assert_eq!((distance.relative_rmse, distance.max_over_peak), (0.0, 0.0));
        assert_eq!(distance.max_color_difference, 0.0);
    }

    #[test]
    fn twice_the_light_is_an_error_of_one_and_a_shift_is_seen() {
        let twice = curves(0.2, 0.0).distance(&curves(0.1, 0.0));
        assert!((twice.relative_rmse - 1.0).abs() < 1e-12);
        assert!(twice.max_color_difference > 5.0);
        let shifted = curves(0.1, 0.01).distance(&curves(0.1, 0.0));
        assert!((shifted.peak_shift_deg - 0.01_f64.to_degrees()).abs() < 0.06);
    }

    #[test]
    fn sunlight_has_no_color() {
        let grey = BowCurves {
            values_sr1: Array2::from_elem((2, 41), 0.1),
            angles_rad: vec![2.0, 2.1],
            wavelengths: WavelengthGrid::visible(),
        };
        let found = lab(grey.xyz()[0], grey.white(), grey.xyz()[0][1]);
        assert!((found.l - 100.0).abs() < 1e-6 && found.a.abs() < 1e-6 && found.b.abs() < 1e-6);
    }
}
