//! A size of the scattering table, turned so that the spectrum at an angle is one stretch of memory.
//!
//! [polarization, size, flattening, wavelength, angle], as the file holds it, becomes
//! [flattening, angle, wavelength] of natural light, half the sum of both polarizations.
//!
//! Turned when the first ray meets drops of the size: a picture meets some of a table's sizes, 450 of
//! 1547 in a rain of all radii whose variance is nearly one (November 2026), and tables fill gigabytes.
//! A size's angles of all wavelengths lie together in the table, fit into a core's cache and are read
//! from front to back; they leave it four wavelengths of four angles at a time.

use std::borrow::Cow;
use std::ops::Range;

use niji_exchange::ScatteringTable;

use crate::turned::turn;

/// Values behind the last row, so that vectors that start in it may end behind it: as many as four
/// of the widest vectors hold.
const BEHIND: usize = 64;

/// Rows of natural light of a size.
pub(crate) struct SizeRows {
    /// [flattening, angle, wavelength] [1/sr], and [`BEHIND`] zeros.
    pub(crate) values_sr1: Vec<f32>,
    /// [flattening, angle], luminance in sunlight [cd/m² per unit of light].
    pub(crate) luminance: Vec<NodeLuminance>,
    /// Whether all values are 0 or more, and finite.
    pub(crate) is_sound: bool,
}

/// Luminance at an angle and flattening, and behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeLuminance {
    pub(crate) value: f32,
    /// Second derivatives here and at the next angle, signs left out, times the square of that step.
    pub(crate) bend: f32,
    /// The same of the next flattening.
    pub(crate) flattening_bend: f32,
}

/// What sizes are made from.
#[derive(Clone, Debug)]
pub(crate) struct RowSource<'a> {
    table: Cow<'a, ScatteringTable>,
    /// The angles that are wanted.
    angles: Range<usize>,
    /// From a spectrum of the table's unit to luminance.
    luminance_weights: Vec<f64>,
}

impl<'a> RowSource<'a> {
    /// A table at some of its angles.
    pub(crate) fn new(
        table: Cow<'a, ScatteringTable>,
        angles: Range<usize>,
        luminance_weights: &[f64],
    ) -> Self {
        let table = if table.values.is_standard_layout() {
            table
        } else {
            let mut table = table.into_owned();
            table.values = table.values.as_standard_layout().into_owned();
            Cow::Owned(table)
        };
        Self {
            table,
            angles,
            luminance_weights: luminance_weights.to_vec(),
        }
    }

    /// The rows of a size.
    pub(crate) fn rows(&self, size: usize) -> SizeRows {
        let (n_flattenings, n_wavelengths) =
            (self.table.flattening.len(), self.table.wavelengths.len());
        let n_angles = self.angles.len();
        let n_nodes = n_flattenings * n_angles;
        let mut rows = SizeRows {
            values_sr1: vec![0.0; n_nodes * n_wavelengths + BEHIND],
            luminance: Vec::new(),
            is_sound: true,
        };
        let mut luminance = Vec::with_capacity(n_nodes);
        let mut panel = Panel {
            values_sr1: vec![0.0; n_wavelengths * n_angles],
            luminance: vec![0.0; n_angles],
        };
        let spectra = rows.values_sr1.chunks_exact_mut(n_angles * n_wavelengths);
        for (flattening, spectra) in spectra.take(n_flattenings).enumerate() {
            rows.is_sound &= panel.read(self, (size, flattening));
            let spectra = spectra.chunks_exact_mut(n_wavelengths);
            turn(&panel.values_sr1, n_angles, spectra);
            luminance.extend_from_slice(&panel.luminance);
        }
        rows.luminance = self.nodes(&luminance);
        rows
    }

    /// How luminance bends at the nodes of flattening and angle.
    fn nodes(&self, luminance: &[f64]) -> Vec<NodeLuminance> {
        let (angles, n_angles) = (
            &self.table.theta_rad[self.angles.clone()],
            self.angles.len(),
        );
        let mut nodes: Vec<_> = luminance
            .chunks(n_angles)
            .flat_map(|of_angles| of_angles.iter().zip(bends(angles, of_angles)))
            .map(|(value, bend)| NodeLuminance {
                value: *value as f32,
                bend: bend as f32,
                flattening_bend: 0.0,
            })
            .collect();
        for angle in 0..n_angles {
            let of_flattenings: Vec<f64> =
                (luminance.iter().skip(angle).step_by(n_angles).copied()).collect();
            let nodes = nodes.iter_mut().skip(angle).step_by(n_angles);
            for (node, bend) in nodes.zip(bends(&self.table.flattening, &of_flattenings)) {
                node.flattening_bend = bend as f32;
            }
        }
        nodes
    }

    /// Values of both polarizations at the wanted angles, wavelength by wavelength.
    fn lanes(&self, (size, flattening): (usize, usize)) -> impl Iterator<Item = (&[f32], &[f32])> {
        let n_theta = self.table.theta_rad.len();
        let length = self.table.wavelengths.len() * n_theta;
        let start = (size * self.table.flattening.len() + flattening) * length;
        let values =
            (self.table.values.as_slice()).expect("an array in standard layout is a slice");
        let (s_part, p_part) = values.split_at(values.len() / 2);
        let s_lanes = s_part[start..start + length].chunks_exact(n_theta);
        let p_lanes = p_part[start..start + length].chunks_exact(n_theta);
        s_lanes
            .zip(p_lanes)
            .map(|(s, p)| (&s[self.angles.clone()], &p[self.angles.clone()]))
    }
}

/// Second derivatives of a function at each node and at the next, signs left out, times the square of the
/// step between: divided differences over three nodes, exact for parabolas; the outermost nodes have
/// those of their neighbors. 0 behind the last node.
fn bends<'a>(nodes: &'a [f64], values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    let slope =
        |upper: usize| (values[upper] - values[upper - 1]) / (nodes[upper] - nodes[upper - 1]);
    let second_derivative = move |middle: usize| {
        if nodes.len() < 3 {
            return 0.0;
        }
        let middle = middle.clamp(1, nodes.len() - 2);
        2.0 * (slope(middle + 1) - slope(middle)) / (nodes[middle + 1] - nodes[middle - 1])
    };
    (0..nodes.len()).map(move |lower| {
        let Some(upper) = nodes.get(lower + 1) else {
            return 0.0;
        };
        let sum = second_derivative(lower).abs() + second_derivative(lower + 1).abs();
        sum * (upper - nodes[lower]).powi(2)
    })
}

/// Natural light of one size at one flattening.
struct Panel {
    /// [wavelength, angle] [1/sr].
    values_sr1: Vec<f32>,
    /// By angle, in f64 while it is summed.
    luminance: Vec<f64>,
}

impl Panel {
    /// Take a size at a flattening; false if a value is negative or not finite.
    fn read(&mut self, source: &RowSource, at: (usize, usize)) -> bool {
        self.luminance.fill(0.0);
        let mut is_sound = true;
        let lanes = source.lanes(at).zip(&source.luminance_weights);
        let n_angles = self.luminance.len();
        for (((s, p), weight), natural) in lanes.zip(self.values_sr1.chunks_exact_mut(n_angles)) {
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
}

#[cfg(test)]
mod tests {
    use ndarray::Array6;
    use niji_radiometry::Water;
    use niji_radiometry::WavelengthGrid;

    use super::*;

    /// More wavelengths and angles than a quad, none a multiple of four.
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
            water: Water::pure(20.0),
            interpolation_error: None,
        }
    }

    #[test]
    fn every_value_stands_at_its_angle_size_and_wavelength() {
        let (_, n_radii, n_variances, n_flattenings, n_wavelengths, _) = SHAPE;
        let in_order = table();
        let mut turned_over = table();
        // The same values in another order in memory.
        turned_over.values = in_order.values.t().as_standard_layout().into_owned();
        turned_over.values.swap_axes(0, 5);
        turned_over.values.swap_axes(1, 4);
        turned_over.values.swap_axes(2, 3);
        assert_eq!(turned_over.values, in_order.values);
        for table in [&in_order, &turned_over] {
            // None, one and several quads of angles.
            for angles in [2..3, 1..9, 0..11] {
                let weights = vec![1.0; n_wavelengths];
                let source = RowSource::new(Cow::Borrowed(table), angles.clone(), &weights);
                for size in 0..n_radii * n_variances {
                    let rows = source.rows(size);
                    assert!(rows.is_sound);
                    let (r, v) = (size / n_variances, size % n_variances);
                    let places =
                        (0..n_flattenings).flat_map(|m| angles.clone().map(move |a| (m, a)));
                    for (node, (m, a)) in places.enumerate() {
                        let expected = (0..n_wavelengths)
                            .map(|w| table.values[[0, r, v, m, w, a]] + 1.0)
                            .collect::<Vec<_>>();
                        // Whole numbers: exact.
                        let start = node * n_wavelengths;
                        let found = &rows.values_sr1[start..start + n_wavelengths];
                        assert_eq!(found, expected);
                        let sum: f32 = expected.iter().sum();
                        let of_node = rows.luminance[node];
                        assert_eq!((of_node.value, of_node.bend), (sum, 0.0));
                    }
                    let n_nodes = n_flattenings * angles.len();
                    assert_eq!(rows.luminance.len(), n_nodes);
                    assert_eq!(rows.values_sr1[n_nodes * n_wavelengths..], [0.0; BEHIND]);
                }
            }
        }
    }

    #[test]
    fn parabolas_are_bent_evenly_between_uneven_nodes() {
        let nodes = [2.0, 2.5, 2.75, 3.75, 4.0];
        let values = nodes.map(|x| 3.0 * x * x - 7.0 * x);
        // Twice 2 * 3 h².
        let expected = [3.0, 0.75, 12.0, 0.75, 0.0];
        assert_eq!(bends(&nodes, &values).collect::<Vec<_>>(), expected);
        let downwards = values.map(|value| -value);
        assert_eq!(bends(&nodes, &downwards).collect::<Vec<_>>(), expected);
        for n in 0..3 {
            assert!(bends(&nodes[..n], &values[..n]).all(|bend| bend == 0.0));
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
                let is_sound = |angles: Range<usize>, size: usize| {
                    let source = RowSource::new(Cow::Borrowed(&table), angles, &weights);
                    source.rows(size).is_sound
                };
                let size = r * n_variances + v;
                assert!(!is_sound(0..n_theta, size));
                // Angles and sizes that nobody sees are not asked.
                assert!(is_sound(2..9, size));
                assert!(is_sound(0..n_theta, 1));
            }
        }
    }
}
