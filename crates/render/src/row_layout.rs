//! The scattering table turned so that the spectrum of a size at an angle is one stretch of memory.
//!
//! [polarization, size, flattening, wavelength, angle], as the file holds it, becomes
//! [flattening, angle, size, wavelength] of natural light, half the sum of both polarizations.
//!
//! Turned size by size: a size's angles of all wavelengths lie together in the table, fit into a
//! core's cache and are read from front to back; they leave it four wavelengths of four angles at a
//! time. Angle by angle every line of the table would be fetched by itself, and once more for the
//! next angles: with a table of 2 GB a picture took 9.3 s of processor time that way and takes 5.4 s
//! this way (November 2026). What is left is the reading of the table and the first touch of fresh
//! memory.

use std::ops::Range;

use niji_exchange::ScatteringTable;
use rayon::prelude::*;

use crate::turned::turn;

/// Sizes that are turned by one thread at a time: their spectra at an angle fill some pages.
const SIZES: usize = 32;

/// Values behind the last row, so that vectors that start in it may end behind it: as many as four
/// of the widest vectors hold.
pub(crate) const BEHIND: usize = 64;

/// Rows of natural light.
#[derive(Clone, Debug)]
pub(crate) struct RowLayout {
    /// [flattening, angle, size, wavelength] [1/sr], and [`BEHIND`] zeros.
    pub(crate) values_sr1: Vec<f32>,
    /// [flattening, angle, size], luminance in sunlight [cd/m² per unit of light].
    pub(crate) luminance: Vec<f32>,
    /// Whether all values are 0 or more, and finite.
    pub(crate) is_sound: bool,
}

impl RowLayout {
    /// The rows of a table at some of its angles; `luminance_weights` turn a spectrum of the table's
    /// unit into luminance.
    pub(crate) fn of(
        table: &ScatteringTable,
        angles: Range<usize>,
        luminance_weights: &[f64],
    ) -> Self {
        let n_sizes = table.effective_radius_um.len() * table.effective_variance.len();
        let (n_flattenings, n_wavelengths) = (table.flattening.len(), table.wavelengths.len());
        let n_rows = n_flattenings * angles.len();
        let mut layout = Self {
            values_sr1: vec![0.0; n_rows * n_sizes * n_wavelengths + BEHIND],
            luminance: vec![0.0; n_rows * n_sizes],
            is_sound: true,
        };
        let standard = table.values.as_standard_layout();
        let source = Source {
            values: standard
                .as_slice()
                .expect("an array in standard layout is a slice"),
            n_flattenings,
            n_wavelengths,
            n_theta: table.theta_rad.len(),
            angles,
            luminance_weights,
        };
        let n_angles = source.angles.len();
        let spectra = layout
            .values_sr1
            .chunks_exact_mut(n_angles * n_sizes * n_wavelengths);
        let luminance = layout.luminance.chunks_exact_mut(n_angles * n_sizes);
        for (flattening, (spectra, luminance)) in spectra.zip(luminance).enumerate() {
            let places = places(spectra, luminance, (n_sizes, n_wavelengths));
            let turned = places.into_par_iter().enumerate().map_init(
                || Panel::new(&source),
                |panel, (block, mut places)| {
                    let first = block * SIZES;
                    let mut is_sound = true;
                    for size in first..(first + SIZES).min(n_sizes) {
                        is_sound &= panel.read(&source, (size, flattening));
                        panel.write(size - first, &mut places);
                    }
                    is_sound
                },
            );
            layout.is_sound &= turned.reduce(|| true, |a, b| a && b);
        }
        layout
    }
}

/// Where the spectra of a block of sizes at an angle go, and their luminance.
type Place<'a> = (&'a mut [f32], &'a mut [f32]);

/// The places of each block of sizes, angle by angle.
fn places<'a>(
    spectra: &'a mut [f32],
    luminance: &'a mut [f32],
    (n_sizes, n_wavelengths): (usize, usize),
) -> Vec<Vec<Place<'a>>> {
    let mut blocks: Vec<Vec<Place>> = Vec::new();
    blocks.resize_with(n_sizes.div_ceil(SIZES), Vec::new);
    let angles = spectra
        .chunks_exact_mut(n_sizes * n_wavelengths)
        .zip(luminance.chunks_exact_mut(n_sizes));
    for (spectra, luminance) in angles {
        let parts = spectra.chunks_mut(SIZES * n_wavelengths);
        let parts = parts.zip(luminance.chunks_mut(SIZES));
        for (block, part) in blocks.iter_mut().zip(parts) {
            block.push(part);
        }
    }
    blocks
}

/// The values of a table, [polarization, size, flattening, wavelength, angle].
struct Source<'a> {
    values: &'a [f32],
    n_flattenings: usize,
    n_wavelengths: usize,
    n_theta: usize,
    /// The angles that are wanted.
    angles: Range<usize>,
    luminance_weights: &'a [f64],
}

impl Source<'_> {
    /// Values of both polarizations at the wanted angles, wavelength by wavelength.
    fn lanes(&self, (size, flattening): (usize, usize)) -> impl Iterator<Item = (&[f32], &[f32])> {
        let length = self.n_wavelengths * self.n_theta;
        let start = (size * self.n_flattenings + flattening) * length;
        let (s_part, p_part) = self.values.split_at(self.values.len() / 2);
        let s_lanes = s_part[start..start + length].chunks_exact(self.n_theta);
        let p_lanes = p_part[start..start + length].chunks_exact(self.n_theta);
        s_lanes
            .zip(p_lanes)
            .map(|(s, p)| (&s[self.angles.clone()], &p[self.angles.clone()]))
    }
}

/// Natural light of one size.
struct Panel {
    n_angles: usize,
    /// [wavelength, angle] [1/sr].
    values_sr1: Vec<f32>,
    /// By angle, in f64 while it is summed.
    luminance: Vec<f64>,
}

impl Panel {
    fn new(source: &Source) -> Self {
        let n_angles = source.angles.len();
        Self {
            n_angles,
            values_sr1: vec![0.0; source.n_wavelengths * n_angles],
            luminance: vec![0.0; n_angles],
        }
    }

    /// Take a size at a flattening; false if a value is negative or not finite.
    fn read(&mut self, source: &Source, at: (usize, usize)) -> bool {
        self.luminance.fill(0.0);
        let mut is_sound = true;
        let lanes = source.lanes(at).zip(source.luminance_weights);
        for (((s, p), weight), natural) in
            lanes.zip(self.values_sr1.chunks_exact_mut(self.n_angles))
        {
            for ((value, s), p) in natural.iter_mut().zip(s).zip(p) {
                *value = 0.5 * (s + p);
            }
            // Bits of numbers from 0 up to infinity are ordered; those of negative numbers and NaN
            // lie above. Without a branch this is a few vector instructions.
            is_sound = natural.iter().fold(is_sound, |sound, value| {
                sound & ((value + 0.0).to_bits() < f32::INFINITY.to_bits())
            });
            for (sum, value) in self.luminance.iter_mut().zip(natural.iter()) {
                *sum += f64::from(*value) * weight;
            }
        }
        is_sound
    }

    /// Put the spectra of the size to its place in a block.
    fn write(&self, size: usize, places: &mut [Place]) {
        let n_wavelengths = self.values_sr1.len() / self.n_angles;
        let own = size * n_wavelengths..(size + 1) * n_wavelengths;
        let to = places.iter_mut().zip(&self.luminance);
        let to = to.map(|((spectra, luminance), sum)| {
            luminance[size] = *sum as f32;
            &mut spectra[own.clone()]
        });
        turn(&self.values_sr1, self.n_angles, to);
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array6;
    use niji_radiometry::WavelengthGrid;

    use super::*;

    /// More sizes than a block and more wavelengths and angles than a quad, none a multiple of four.
    const SHAPE: (usize, usize, usize, usize, usize, usize) = (2, 5, 7, 2, 6, 11);

    /// A whole number for every place, the second polarization 2 above the first.
    fn table() -> ScatteringTable {
        let (_, n_radii, n_variances, n_flattenings, n_wavelengths, n_theta) = SHAPE;
        let values = Array6::from_shape_fn(SHAPE, |(j, r, v, m, w, a)| {
            let place = (((r * n_variances + v) * n_flattenings + m) * n_wavelengths + w) * n_theta;
            (place + a + 2 * j) as f32
        });
        let upwards = |n: usize| (1..=n).map(|step| step as f64).collect::<Vec<_>>();
        ScatteringTable {
            theory: "test".into(),
            orders: "all".into(),
            wavelengths: WavelengthGrid::new(500.0, 50.0, n_wavelengths).unwrap(),
            theta_rad: upwards(n_theta),
            effective_radius_um: upwards(n_radii),
            effective_variance: upwards(n_variances),
            flattening: upwards(n_flattenings),
            values,
            sun_disc_diameter_rad: 0.0,
            split_theta_rad: 2.2,
            forward_fraction_left_out: 0.0,
            temperature_c: 20.0,
            interpolation_error: None,
        }
    }

    #[test]
    fn every_value_stands_at_its_angle_size_and_wavelength() {
        let (_, n_radii, n_variances, n_flattenings, n_wavelengths, _) = SHAPE;
        let n_sizes = n_radii * n_variances;
        let table = table();
        // None, one and several quads of angles.
        for angles in [2..3, 1..9, 0..11] {
            let weights = vec![1.0; n_wavelengths];
            let layout = RowLayout::of(&table, angles.clone(), &weights);
            assert!(layout.is_sound);
            let (values, behind) = layout.values_sr1.split_at(layout.values_sr1.len() - BEHIND);
            assert_eq!(behind, [0.0; BEHIND]);
            let mut spectra = values.chunks_exact(n_wavelengths);
            let mut luminance = layout.luminance.iter();
            for m in 0..n_flattenings {
                for a in angles.clone() {
                    for size in 0..n_sizes {
                        let (r, v) = (size / n_variances, size % n_variances);
                        let expected = (0..n_wavelengths)
                            .map(|w| table.values[[0, r, v, m, w, a]] + 1.0)
                            .collect::<Vec<_>>();
                        // Whole numbers: exact.
                        assert_eq!(spectra.next().unwrap(), expected);
                        assert_eq!(*luminance.next().unwrap(), expected.iter().sum::<f32>());
                    }
                }
            }
            assert!(spectra.next().is_none() && luminance.next().is_none());
        }
    }

    #[test]
    fn a_bad_value_is_found_wherever_it_stands() {
        let (_, n_radii, n_variances, n_flattenings, n_wavelengths, n_theta) = SHAPE;
        for bad in [f32::NAN, f32::INFINITY, -1e6] {
            for last in [false, true] {
                let mut table = table();
                let at = |n: usize| if last { n - 1 } else { 0 };
                let place = [1, at(n_radii), at(n_variances), at(n_flattenings)];
                let [j, r, v, m] = place;
                table.values[[j, r, v, m, at(n_wavelengths), at(n_theta)]] = bad;
                let weights = vec![1.0; n_wavelengths];
                assert!(!RowLayout::of(&table, 0..n_theta, &weights).is_sound);
                // Angles that nobody sees are not asked.
                assert!(RowLayout::of(&table, 2..9, &weights).is_sound);
            }
        }
    }
}
