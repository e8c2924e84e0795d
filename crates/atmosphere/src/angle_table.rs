//! Spectra over a part of the sphere, tabulated as finely as they vary.
//!
//! compute   exact values on rows of u, refined where cubic interpolation misses, then on nodes of
//!           azimuth, refined for each row
//! tabulate  one block of values for each node, f32 (6e-8)
//! look up   4 rows of 4 nodes, Lagrange's formula
//! `phi` azimuth from the sun's, mirrored at 0 and pi; u = 0..1 stands for the cosine of the zenith
//! angle from `low` to `high`,
//!   mu = low + (high - low) sin^2(pi u/2)
//! which is dense at both ends: light varies with the square root of the distance from the horizon
//! below it, and with the sine of the zenith angle at the zenith, where u is linear in both.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use niji_exchange::Stencil;
use rayon::iter::IndexedParallelIterator;
use rayon::iter::IntoParallelRefIterator;
use rayon::iter::ParallelIterator;

use crate::refined_axis::Line;
use crate::refined_axis::Lines;
use crate::refined_axis::Refinement;

/// Intervals at the start, in u and in azimuth.
const FIRST_INTERVALS: [usize; 2] = [8, 4];
/// Most halvings of one of them.
const MAX_HALVINGS: [usize; 2] = [6, 6];

/// What is tabulated: channels of spectra, one after the other, in one unit.
pub(crate) struct Spectra<F> {
    pub(crate) n_channels: usize,
    pub(crate) n_wavelengths: usize,
    /// Brightest light elsewhere, by wavelength, which decides what counts as dark.
    pub(crate) brightest: Vec<f64>,
    /// Values of all channels for the cosine of a zenith angle and an azimuth, rad.
    pub(crate) at: F,
}

/// The table.
#[derive(Debug, Clone)]
pub(crate) struct AngleTable {
    cos_zenith_ends: [f64; 2],
    u: Vec<f64>,
    /// One for each u.
    rows: Vec<Row>,
    n_values: usize,
    brightest: Vec<f64>,
}

impl AngleTable {
    /// Tabulates spectra between two cosines of the zenith angle.
    pub(crate) fn new<F>(cos_zenith_ends: [f64; 2], spectra: &Spectra<F>, tolerance: f64) -> Self
    where
        F: Fn(f64, f64) -> Vec<f64> + Sync,
    {
        let at = |u: f64, phi: f64| (spectra.at)(cos_zenith(cos_zenith_ends, u), phi);
        let azimuths = even_steps(PI, FIRST_INTERVALS[1]);
        let rows = Refinement {
            tolerance,
            max_halvings: MAX_HALVINGS[0],
            n_channels: spectra.n_channels,
            n_wavelengths: spectra.n_wavelengths,
            brightest: &spectra.brightest,
            line: |u: f64| -> Line { azimuths.iter().flat_map(|&phi| at(u, phi)).collect() },
            stencil: |axis: &[f64], u: f64| Stencil::new(axis, u).weighted_nodes().collect(),
        };
        let Lines { axis: u, lines } = rows.refine(even_steps(1.0, FIRST_INTERVALS[0]));
        let n_values = spectra.n_channels * spectra.n_wavelengths;
        let brightest = rows.brightest_of(&lines);
        let row = |(&u, line): (&f64, &Line)| {
            let columns = Refinement {
                tolerance,
                max_halvings: MAX_HALVINGS[1],
                n_channels: spectra.n_channels,
                n_wavelengths: spectra.n_wavelengths,
                brightest: &brightest,
                line: |phi: f64| at(u, phi),
                stencil: |axis: &[f64], phi: f64| {
                    MirroredAxis::new(axis).weighted_nodes(phi).to_vec()
                },
            };
            Row::new(&columns.refine_lines(Lines {
                axis: azimuths.clone(),
                lines: line.chunks(n_values).map(<[f64]>::to_vec).collect(),
            }))
        };
        // Rows are refined side by side and gathered in order.
        let rows = u.par_iter().zip(&lines).map(row).collect();
        Self {
            cos_zenith_ends,
            u,
            rows,
            n_values,
            brightest,
        }
    }

    /// Sum of the channels at the brightest node, by wavelength.
    pub(crate) fn brightest(&self) -> &[f64] {
        &self.brightest
    }

    /// Number of values at each node.
    pub(crate) fn n_values(&self) -> usize {
        self.n_values
    }

    /// Number of nodes.
    pub(crate) fn n_nodes(&self) -> usize {
        self.rows.iter().map(|row| row.azimuth.n_nodes()).sum()
    }

    /// Writes all channels in a direction to `values`.
    pub(crate) fn look_up(&self, cos_zenith: f64, azimuth_rad: f64, values: &mut [f32]) {
        values.fill(0.0);
        let u = u_of(self.cos_zenith_ends, cos_zenith);
        for (row, weight) in Stencil::new(&self.u, u).weighted_nodes() {
            self.rows[row].add(weight, azimuth_rad, values);
        }
    }
}

/// The nodes of one u.
#[derive(Debug, Clone)]
struct Row {
    azimuth: MirroredAxis,
    /// `[azimuth, channel, wavelength]`
    values: Vec<f32>,
}

impl Row {
    fn new(lines: &Lines) -> Self {
        let values = lines.lines.iter().flatten();
        Self {
            azimuth: MirroredAxis::new(&lines.axis),
            // f32: interpolation errs by more.
            values: values.map(|&value| value as f32).collect(),
        }
    }

    /// Adds the row's values at an azimuth.
    fn add(&self, row_weight: f64, azimuth_rad: f64, values: &mut [f32]) {
        let n_values = values.len();
        let [a, b, c, d] = self
            .azimuth
            .weighted_nodes(azimuth_rad)
            .map(|(node, weight)| {
                let node_values = &self.values[node * n_values..(node + 1) * n_values];
                (node_values, (row_weight * weight) as f32)
            });
        let nodes = a.0.iter().zip(b.0).zip(c.0).zip(d.0);
        for (value, (((va, vb), vc), vd)) in values.iter_mut().zip(nodes) {
            *value += (a.1 * va + b.1 * vb) + (c.1 * vc + d.1 * vd);
        }
    }
}

/// An axis from 0 to pi of a function that is even around both ends.
#[derive(Debug, Clone)]
struct MirroredAxis {
    /// The axis with two more nodes at either end.
    extended: Vec<f64>,
    /// The node that each of these stands for.
    node: Vec<usize>,
}

impl MirroredAxis {
    /// At least three nodes from 0 to pi.
    fn new(axis: &[f64]) -> Self {
        let last = axis.len() - 1;
        let before = [2, 1].map(|node| (-axis[node], node));
        let after = [1, 2].map(|back| (2.0 * PI - axis[last - back], last - back));
        let inside = axis.iter().copied().zip(0..);
        let (extended, node) = before.into_iter().chain(inside).chain(after).unzip();
        Self { extended, node }
    }

    fn n_nodes(&self) -> usize {
        self.node.len() - 4
    }

    /// Four nodes and their weights; with two more nodes at either end there always are four.
    fn weighted_nodes(&self, azimuth_rad: f64) -> [(usize, f64); 4] {
        let mut nodes = [(0, 0.0); 4];
        let stencil = Stencil::new(&self.extended, azimuth_rad);
        for (slot, (i, weight)) in nodes.iter_mut().zip(stencil.weighted_nodes()) {
            *slot = (self.node[i], weight);
        }
        nodes
    }
}

fn cos_zenith([low, high]: [f64; 2], u: f64) -> f64 {
    let sin = (FRAC_PI_2 * u).sin();
    low + (high - low) * sin * sin
}

fn u_of([low, high]: [f64; 2], cos_zenith: f64) -> f64 {
    let share = ((cos_zenith - low) / (high - low)).clamp(0.0, 1.0);
    share.sqrt().asin() / FRAC_PI_2
}

fn even_steps(last: f64, n_steps: usize) -> Vec<f64> {
    (0..=n_steps)
        .map(|i| last * (i as f64 / n_steps as f64))
        .collect()
}
