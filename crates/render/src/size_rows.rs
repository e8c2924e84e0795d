//! A size of the scattering table, turned so that the spectrum at an angle is one stretch of memory.
//!
//! [polarization, size, wavelength, angle], as the file holds it, becomes
//! [angle, wavelength] of natural light, half the sum of both polarizations. Where sizes are laws and the
//! table holds single sizes, it is their weighted sum; the light of orders that move is left out.
//!
//! Turned when the first ray meets drops of the size: a picture meets some of the sizes, 450 of
//! 1547 in a rain of all radii whose variance is nearly one (November 2026), and tables of laws fill
//! gigabytes. Of a table of single sizes natural light is kept at once, for all laws to be summed from.
//! A size's angles of all wavelengths lie together in the table, fit into a core's cache and are read
//! from front to back; they leave it four wavelengths of four angles at a time.

use std::borrow::Cow;
use std::ops::Range;

use niji_exchange::ScatteringTable;
use rayon::prelude::*;

use crate::angle_axis::linear_place;
use crate::moved_radii::first_moved_row;
use crate::size_nodes::SizeNodes;
use crate::turned::turn;

/// Values behind the last row, so that vectors that start in it may end behind it: as many as four
/// of the widest vectors hold.
const BEHIND: usize = 64;

/// Rows of natural light of a size.
pub(crate) struct SizeRows {
    /// [angle, wavelength] [1/sr], and [`BEHIND`] zeros.
    pub(crate) values_sr1: Vec<f32>,
    /// By angle, luminance in sunlight [cd/m² per unit of light].
    pub(crate) luminance: Vec<NodeLuminance>,
    /// Whether all values are 0 or more, and finite.
    pub(crate) is_sound: bool,
}

/// Luminance at an angle, and behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeLuminance {
    pub(crate) value: f32,
    /// Second derivatives here and at the next angle, signs left out, times the square of that step.
    pub(crate) bend: f32,
}

/// What sizes are made from.
#[derive(Clone, Debug)]
pub(crate) struct RowSource<'a> {
    table: Cow<'a, ScatteringTable>,
    /// The laws of the nodes, where sizes are not rows of the table itself.
    laws: Option<Laws>,
    /// The angles that are wanted.
    angles: Range<usize>,
    /// Where they lie between the angles of each order that moves.
    places: Vec<Vec<(usize, f32)>>,
    /// From a spectrum of the table's unit to luminance.
    luminance_weights: Vec<f64>,
}

/// Size laws and the rows of which they are sums.
#[derive(Clone, Debug)]
struct Laws {
    nodes: SizeNodes,
    /// By row of the table.
    rows: Vec<SizeSpectrum>,
}

impl<'a> RowSource<'a> {
    /// A table at some of its angles, for nodes of sizes.
    pub(crate) fn new(
        (table, nodes): (Cow<'a, ScatteringTable>, SizeNodes),
        angles: Range<usize>,
        luminance_weights: &[f64],
    ) -> Self {
        let moved = |table: &ScatteringTable| {
            let orders = table.moved.iter().flat_map(|moved| &moved.orders);
            orders
                .into_iter()
                .all(|order| order.values.is_standard_layout())
        };
        let table = if table.values.is_standard_layout() && moved(&table) {
            table
        } else {
            let mut table = table.into_owned();
            table.values = table.values.as_standard_layout().into_owned();
            for order in table.moved.iter_mut().flat_map(|moved| &mut moved.orders) {
                order.values = order.values.as_standard_layout().into_owned();
            }
            Cow::Owned(table)
        };
        let wanted_rad = &table.theta_rad[angles.clone()];
        let moved = table.moved.iter().flat_map(|moved| &moved.orders);
        let mut source = Self {
            places: moved
                .map(|order| linear_places(&order.theta_rad, wanted_rad))
                .collect(),
            table,
            laws: None,
            angles,
            luminance_weights: luminance_weights.to_vec(),
        };
        if nodes.are_laws {
            let rows = 0..source.table.effective_radius_um.len();
            let rows = rows
                .into_par_iter()
                .map(|row| source.spectrum(row))
                .collect();
            source.laws = Some(Laws { nodes, rows });
        }
        source
    }

    /// The rows of a size.
    pub(crate) fn rows(&self, size: usize) -> SizeRows {
        let (n_angles, n_wavelengths) = (self.angles.len(), self.table.wavelengths.len());
        let spectrum = match &self.laws {
            Some(laws) => laws.spectrum(size, &self.table.effective_radius_um),
            None => self.spectrum(size),
        };
        let mut luminance = vec![0.0; n_angles];
        let of_wavelengths = spectrum.values_sr1.chunks_exact(n_angles);
        for (values, weight) in of_wavelengths.zip(&self.luminance_weights) {
            for (sum, value) in luminance.iter_mut().zip(values) {
                *sum += f64::from(*value) * weight;
            }
        }
        let mut values_sr1 = vec![0.0; n_angles * n_wavelengths + BEHIND];
        let spectra = values_sr1[..n_angles * n_wavelengths].chunks_exact_mut(n_wavelengths);
        turn(&spectrum.values_sr1, n_angles, spectra);
        let angles = &self.table.theta_rad[self.angles.clone()];
        let nodes = luminance.iter().zip(bends(angles, &luminance));
        let luminance = nodes.map(|(value, bend)| NodeLuminance {
            value: *value as f32,
            bend: bend as f32,
        });
        SizeRows {
            luminance: luminance.collect(),
            values_sr1,
            is_sound: spectrum.is_sound,
        }
    }

    /// A row of the table without the light that moves.
    fn spectrum(&self, row: usize) -> SizeSpectrum {
        let mut spectrum = SizeSpectrum {
            values_sr1: vec![0.0; self.table.wavelengths.len() * self.angles.len()],
            is_sound: true,
        };
        let n_wavelengths = self.table.wavelengths.len();
        let size = [n_wavelengths, self.table.theta_rad.len()];
        spectrum.add(lanes(self.table.values.as_slice(), row, size), &self.angles);
        if let Some(moved) = &self.table.moved
            && let Some(row) = row.checked_sub(first_moved_row(&self.table, moved))
        {
            for (order, places) in moved.orders.iter().zip(&self.places) {
                let size = [n_wavelengths, order.theta_rad.len()];
                spectrum.subtract(lanes(order.values.as_slice(), row, size), places);
            }
            // 0 but for rounding, and for the error of straight lines, where what moves is all there is.
            for value in &mut spectrum.values_sr1 {
                *value = if *value < 0.0 { 0.0 } else { *value };
            }
        }
        spectrum
    }
}

/// Values of both polarizations in a row, wavelength by wavelength.
fn lanes(
    values: Option<&[f32]>,
    row: usize,
    [n_wavelengths, n_theta]: [usize; 2],
) -> impl Iterator<Item = [&[f32]; 2]> {
    let values = values.expect("an array in standard layout is a slice");
    let length = n_wavelengths * n_theta;
    let (s_part, p_part) = values.split_at(values.len() / 2);
    let [s, p] =
        [s_part, p_part].map(|part| part[row * length..(row + 1) * length].chunks_exact(n_theta));
    s.zip(p).map(|(s, p)| [s, p])
}

/// Where angles lie between others, of which there are two at least: the lower and the part of the way to the next.
fn linear_places(theta_rad: &[f64], wanted_rad: &[f64]) -> Vec<(usize, f32)> {
    let place = |wanted: &f64| {
        let above = theta_rad.partition_point(|theta| theta <= wanted);
        linear_place(theta_rad, above, *wanted)
    };
    wanted_rad.iter().map(place).collect()
}

impl Laws {
    /// The light of a law.
    fn spectrum(&self, node: usize, radii_um: &[f64]) -> SizeSpectrum {
        let mut sum = SizeSpectrum {
            values_sr1: vec![0.0; self.rows[0].values_sr1.len()],
            is_sound: true,
        };
        for (row, weight) in self.nodes.weights(node, radii_um) {
            let (row, weight) = (&self.rows[row], weight as f32);
            sum.is_sound &= row.is_sound;
            for (sum, value) in sum.values_sr1.iter_mut().zip(&row.values_sr1) {
                *sum += weight * value;
            }
        }
        sum
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

/// Natural light of one size.
#[derive(Clone, Debug)]
struct SizeSpectrum {
    /// [wavelength, angle] [1/sr].
    values_sr1: Vec<f32>,
    /// Whether all that it was made of is 0 or more, and finite.
    is_sound: bool,
}

impl SizeSpectrum {
    /// Add half the sum of both polarizations at some angles.
    fn add<'a>(&mut self, lanes: impl Iterator<Item = [&'a [f32]; 2]>, angles: &Range<usize>) {
        let mut is_sound = self.is_sound;
        for (values, lanes) in self.values_sr1.chunks_exact_mut(angles.len()).zip(lanes) {
            let [s, p] = lanes.map(|lane| &lane[angles.clone()]);
            for ((value, s), p) in values.iter_mut().zip(s).zip(p) {
                let both = s + p;
                is_sound &= is_light(both);
                *value += 0.5 * both;
            }
        }
        self.is_sound = is_sound;
    }

    /// Subtract half the sum of both polarizations between angles of their own.
    fn subtract<'a>(
        &mut self,
        lanes: impl Iterator<Item = [&'a [f32]; 2]>,
        places: &[(usize, f32)],
    ) {
        let mut is_sound = self.is_sound;
        for (values, [s, p]) in self.values_sr1.chunks_exact_mut(places.len()).zip(lanes) {
            for (value, (lower, fraction)) in values.iter_mut().zip(places) {
                let of_lane =
                    |lane: &[f32]| lane[*lower] + fraction * (lane[lower + 1] - lane[*lower]);
                let both = of_lane(s) + of_lane(p);
                is_sound &= is_light(both);
                *value -= 0.5 * both;
            }
        }
        self.is_sound = is_sound;
    }
}

/// Whether a value is 0 or more, and finite. Bits of numbers from 0 up to infinity are ordered; those of negative
/// numbers and NaN lie above. Without a branch this is a few vector instructions.
#[inline]
fn is_light(value: f32) -> bool {
    (value + 0.0).to_bits() < f32::INFINITY.to_bits()
}

#[cfg(test)]
mod tests {
    use ndarray::Array5;
    use niji_radiometry::Water;
    use niji_radiometry::WavelengthGrid;

    use niji_exchange::RowUse;

    use super::*;

    /// More wavelengths and angles than a quad, none a multiple of four.
    const SHAPE: (usize, usize, usize, usize, usize) = (2, 5, 7, 6, 11);

    /// A whole number for every place, the second polarization 2 above the first.
    fn table() -> ScatteringTable {
        let (_, n_radii, n_variances, n_wavelengths, n_theta) = SHAPE;
        let values = Array5::from_shape_fn(SHAPE, |(j, r, v, w, a)| {
            let place = ((r * n_variances + v) * n_wavelengths + w) * n_theta;
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
            values,
            moved: None,
            row_use: RowUse::Laws,
            relative_error: 5e-3,
            sun_disc_diameter_rad: 0.0,
            split_theta_rad: 2.2,
            forward_fraction_left_out: 0.0,
            water: Water::pure(20.0),
            phase_functions: None,
            interpolation_error: None,
        }
    }

    /// A table at some of its angles, at its own sizes.
    fn source(table: &ScatteringTable, angles: Range<usize>) -> RowSource<'_> {
        let weights = vec![1.0; table.wavelengths.len()];
        let nodes = SizeNodes::of_table(table);
        RowSource::new((Cow::Borrowed(table), nodes), angles, &weights)
    }

    #[test]
    fn every_value_stands_at_its_angle_size_and_wavelength() {
        let (_, n_radii, n_variances, n_wavelengths, _) = SHAPE;
        let in_order = table();
        let mut turned_over = table();
        // The same values in another order in memory.
        turned_over.values = in_order.values.t().as_standard_layout().into_owned();
        turned_over.values.swap_axes(0, 4);
        turned_over.values.swap_axes(1, 3);
        assert_eq!(turned_over.values, in_order.values);
        for table in [&in_order, &turned_over] {
            // None, one and several quads of angles.
            for angles in [2..3, 1..9, 0..11] {
                let source = source(table, angles.clone());
                for size in 0..n_radii * n_variances {
                    let rows = source.rows(size);
                    assert!(rows.is_sound);
                    let (r, v) = (size / n_variances, size % n_variances);
                    for (node, a) in angles.clone().enumerate() {
                        let expected = (0..n_wavelengths)
                            .map(|w| table.values[[0, r, v, w, a]] + 1.0)
                            .collect::<Vec<_>>();
                        // Whole numbers: exact.
                        let start = node * n_wavelengths;
                        let found = &rows.values_sr1[start..start + n_wavelengths];
                        assert_eq!(found, expected);
                        let sum: f32 = expected.iter().sum();
                        let of_node = rows.luminance[node];
                        assert_eq!((of_node.value, of_node.bend), (sum, 0.0));
                    }
                    let n_nodes = angles.len();
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
        let (_, n_radii, n_variances, n_wavelengths, n_theta) = SHAPE;
        for bad in [f32::NAN, f32::INFINITY, -1e6] {
            for last in [false, true] {
                let mut table = table();
                let at = |n: usize| if last { n - 1 } else { 0 };
                let (r, v) = (at(n_radii), at(n_variances));
                table.values[[1, r, v, at(n_wavelengths), at(n_theta)]] = bad;
                let is_sound = |angles: Range<usize>, size: usize| {
                    let source = source(&table, angles);
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
