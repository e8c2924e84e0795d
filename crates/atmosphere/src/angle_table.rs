//! Spectra over a part of the sphere, tabulated as finely as they vary.
//!
//! compute   exact values on rows of u, refined where interpolation through six nodes misses, then on
//!           nodes of azimuth, refined for each row
//! tabulate  the same, interpolated, on as many more nodes as interpolation through four needs; one
//!           block of values for each, f32 (6e-8)
//! look up   4 rows of 4 nodes, Lagrange's formula
//! Exact values cost a hundred look-ups through six nodes, which need a quarter of what four need; but
//! a picture looks up more often than there are nodes, and through four it is twice as quick.
//!
//! `phi` azimuth from the sun's, mirrored at 0 and pi; u = 0..1 is dense at the horizon:
//!   elevation = low + (high - low) u^2  above, where haze and the edge of the shadow lie low;
//!   mu = -1 + (1 + horizon) sin^2(pi u/2)  below, where light varies with the square root of the
//! distance from the horizon. At zenith and nadir u is linear in the sine of the zenith angle, in
//! which light is smooth.

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
const MAX_HALVINGS: [usize; 2] = [5, 6];
/// Share of the tolerance for the table of interpolated values, and more halvings of its intervals.
const RESAMPLED_SHARE: f64 = 0.5;
const RESAMPLED_HALVINGS: usize = 1;

/// Which part of the sphere is tabulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Band {
    /// Above a horizon: between two cosines of the zenith angle.
    Sky([f64; 2]),
    /// From the nadir up to a horizon.
    Ground {
        /// Cosine of the horizon's zenith angle.
        horizon: f64,
    },
}

impl Band {
    fn cos_zenith(self, u: f64) -> f64 {
        match self {
            Self::Sky([low, high]) => {
                let [low_rad, high_rad] = [low.asin(), high.asin()];
                (low_rad + (high_rad - low_rad) * u * u)
                    .sin()
                    .clamp(low, high)
            }
            Self::Ground { horizon } => {
                let sin = (FRAC_PI_2 * u).sin();
                (1.0 + horizon) * sin * sin - 1.0
            }
        }
    }

    fn u(self, cos_zenith: f64) -> f64 {
        match self {
            Self::Sky([low, high]) => {
                let [low_rad, high_rad] = [low.asin(), high.asin()];
                let share = (cos_zenith.clamp(low, high).asin() - low_rad) / (high_rad - low_rad);
                share.max(0.0).sqrt()
            }
            Self::Ground { horizon } => {
                let share = ((1.0 + cos_zenith) / (1.0 + horizon)).clamp(0.0, 1.0);
                share.sqrt().asin() / FRAC_PI_2
            }
        }
    }
}

/// What is tabulated: channels of spectra, one after the other, in one unit.
pub(crate) struct Spectra<F> {
    pub(crate) n_channels: usize,
    pub(crate) n_wavelengths: usize,
    /// Brightest light elsewhere, by wavelength, which decides what counts as dark.
    pub(crate) brightest: Vec<f64>,
    /// Values of all channels for the cosine of a zenith angle and an azimuth, rad.
    pub(crate) at: F,
}

/// How finely a table is made.
#[derive(Debug, Clone, Copy)]
struct Fineness {
    tolerance: f64,
    /// In u and in azimuth.
    max_halvings: [usize; 2],
}

/// Tabulates spectra that are dear; says how many were asked for.
pub(crate) fn tabulate<F>(
    band: Band,
    spectra: &Spectra<F>,
    tolerance: f64,
) -> (AngleTable<4>, usize)
where
    F: Fn(f64, f64) -> Vec<f64> + Sync,
{
    let exact = Fineness {
        tolerance,
        max_halvings: MAX_HALVINGS,
    };
    let interpolated = Fineness {
        tolerance: RESAMPLED_SHARE * tolerance,
        max_halvings: MAX_HALVINGS.map(|halvings| halvings + RESAMPLED_HALVINGS),
    };
    let few = AngleTable::<6>::new(band, spectra, exact);
    let resampled = Spectra {
        n_channels: spectra.n_channels,
        n_wavelengths: spectra.n_wavelengths,
        brightest: few.brightest.clone(),
        at: |cos_zenith: f64, azimuth_rad: f64| {
            let mut values = vec![0.0; few.n_values];
            few.look_up(cos_zenith, azimuth_rad, &mut values);
            values.into_iter().map(f64::from).collect()
        },
    };
    (
        AngleTable::new(band, &resampled, interpolated),
        few.n_nodes(),
    )
}

/// The table, interpolated through `N` nodes in either direction.
#[derive(Debug, Clone)]
pub(crate) struct AngleTable<const N: usize> {
    band: Band,
    u: Vec<f64>,
    /// One for each u.
    rows: Vec<Row<N>>,
    n_values: usize,
    brightest: Vec<f64>,
}

impl<const N: usize> AngleTable<N> {
    /// Tabulates spectra over a part of the sphere.
    fn new<F>(band: Band, spectra: &Spectra<F>, fineness: Fineness) -> Self
    where
        F: Fn(f64, f64) -> Vec<f64> + Sync,
    {
        let Fineness {
            tolerance,
            max_halvings,
        } = fineness;
        let at = |u: f64, phi: f64| (spectra.at)(band.cos_zenith(u), phi);
        let azimuths = even_steps(PI, FIRST_INTERVALS[1]);
        let rows = Refinement {
            tolerance,
            max_halvings: max_halvings[0],
            n_channels: spectra.n_channels,
            n_wavelengths: spectra.n_wavelengths,
            brightest: &spectra.brightest,
            line: |u: f64| -> Line { azimuths.iter().flat_map(|&phi| at(u, phi)).collect() },
            stencil: |axis: &[f64], u: f64| Stencil::<N>::new(axis, u).weighted_nodes().collect(),
        };
        let Lines { axis: u, lines } = rows.refine(even_steps(1.0, FIRST_INTERVALS[0]));
        let n_values = spectra.n_channels * spectra.n_wavelengths;
        let brightest = rows.brightest_of(&lines);
        let row = |(&u, line): (&f64, &Line)| {
            let columns = Refinement {
                tolerance,
                max_halvings: max_halvings[1],
                n_channels: spectra.n_channels,
                n_wavelengths: spectra.n_wavelengths,
                brightest: &brightest,
                line: |phi: f64| at(u, phi),
                stencil: |axis: &[f64], phi: f64| {
                    MirroredAxis::<N>::new(axis).weighted_nodes(phi).to_vec()
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
            band,
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
    fn n_nodes(&self) -> usize {
        self.rows.iter().map(|row| row.azimuth.n_nodes()).sum()
    }

    /// Writes all channels in a direction to `values`.
    pub(crate) fn look_up(&self, cos_zenith: f64, azimuth_rad: f64, values: &mut [f32]) {
        values.fill(0.0);
        let u = self.band.u(cos_zenith);
        for (row, weight) in Stencil::<N>::new(&self.u, u).weighted_nodes() {
            self.rows[row].add(weight, azimuth_rad, values);
        }
    }
}

/// The nodes of one u.
#[derive(Debug, Clone)]
struct Row<const N: usize> {
    azimuth: MirroredAxis<N>,
    /// `[azimuth, channel, wavelength]`
    values: Vec<f32>,
}

impl<const N: usize> Row<N> {
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
        let nodes = self.azimuth.weighted_nodes(azimuth_rad);
        // Pairs of nodes: fewer passes over `values`.
        for pair in nodes.chunks_exact(2) {
            let [a, b] = [pair[0], pair[1]].map(|(node, weight)| {
                let node_values = &self.values[node * n_values..(node + 1) * n_values];
                (node_values, (row_weight * weight) as f32)
            });
            for (value, (va, vb)) in values.iter_mut().zip(a.0.iter().zip(b.0)) {
                *value += a.1 * va + b.1 * vb;
            }
        }
    }
}

/// An axis from 0 to pi of a function that is even around both ends.
#[derive(Debug, Clone)]
struct MirroredAxis<const N: usize> {
    /// The axis with N/2 more nodes at either end.
    extended: Vec<f64>,
    /// The node that each of these stands for.
    node: Vec<usize>,
}

impl<const N: usize> MirroredAxis<N> {
    /// At least N/2 + 1 nodes from 0 to pi.
    fn new(axis: &[f64]) -> Self {
        let last = axis.len() - 1;
        let before = (1..=N / 2).rev().map(|node| (-axis[node], node));
        let after = (1..=N / 2).map(|back| (2.0 * PI - axis[last - back], last - back));
        let inside = axis.iter().copied().zip(0..);
        let (extended, node) = before.chain(inside).chain(after).unzip();
        Self { extended, node }
    }

    fn n_nodes(&self) -> usize {
        self.node.len() - N / 2 * 2
    }

    /// N nodes and their weights; with N/2 more nodes at either end there always are as many.
    fn weighted_nodes(&self, azimuth_rad: f64) -> [(usize, f64); N] {
        let mut nodes = [(0, 0.0); N];
        let stencil = Stencil::<N>::new(&self.extended, azimuth_rad);
        for (slot, (i, weight)) in nodes.iter_mut().zip(stencil.weighted_nodes()) {
            *slot = (self.node[i], weight);
        }
        nodes
    }
}

fn even_steps(last: f64, n_steps: usize) -> Vec<f64> {
    (0..=n_steps)
        .map(|i| last * (i as f64 / n_steps as f64))
        .collect()
}
