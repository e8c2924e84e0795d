//! An axis that is refined where interpolation between its nodes misses.
//!
//! An interval is tested at its middle: miss = |interpolated - exact| over the exact. The line of
//! values that tested it becomes a node, so nothing is computed in vain. Halving betters interpolation
//! through four nodes 16 times at best, through six 64 times, but by less where light has just emerged
//! from the dark; so an interval is halved once more where the miss exceeds 8 times the tolerance.

use rayon::iter::IntoParallelRefIterator;
use rayon::iter::ParallelIterator;

/// By how much halving an interval betters interpolation at least.
const GAIN: f64 = 8.0;
/// Light below this share of the brightest counts as dark: its error is taken relative to the share.
const DARK: f64 = 1e-3;
/// A channel below this share of the sum of all is a minor one: its error is taken relative to the
/// share. Phase functions differ by about its inverse, so a minor channel may become a main one.
const MINOR: f64 = 0.1;

/// All values of all nodes across one node of an axis: `[across, channel, wavelength]`.
pub(crate) type Line = Vec<f64>;

/// An axis, and the line of values at each of its nodes.
pub(crate) struct Lines {
    pub(crate) axis: Vec<f64>,
    pub(crate) lines: Vec<Line>,
}

/// How an axis is refined.
pub(crate) struct Refinement<'a, L, S> {
    /// Largest relative error that is asked for.
    pub(crate) tolerance: f64,
    /// Most halvings of an interval: beyond stands an edge, not a curve.
    pub(crate) max_halvings: usize,
    /// Channels and wavelengths of a line.
    pub(crate) n_channels: usize,
    pub(crate) n_wavelengths: usize,
    /// Brightest light that is known from elsewhere, by wavelength.
    pub(crate) brightest: &'a [f64],
    /// The exact line at a place on the axis.
    pub(crate) line: L,
    /// Nodes and weights of the interpolation on an axis at a place.
    pub(crate) stencil: S,
}

impl<L, S> Refinement<'_, L, S>
where
    L: Fn(f64) -> Line + Sync,
    S: Fn(&[f64], f64) -> Vec<(usize, f64)> + Sync,
{
    /// Refines from the nodes `axis`.
    pub(crate) fn refine(&self, axis: Vec<f64>) -> Lines {
        let lines = self.solve(&axis);
        self.refine_lines(Lines { axis, lines })
    }

    /// Refines from lines that are known.
    pub(crate) fn refine_lines(&self, mut known: Lines) -> Lines {
        let mut pending: Vec<[f64; 2]> = known.axis.windows(2).map(|x| [x[0], x[1]]).collect();
        for _ in 0..self.max_halvings {
            let middles: Vec<f64> = pending.iter().map(|[a, b]| 0.5 * (a + b)).collect();
            let lines = self.solve(&middles);
            let dark = self.darkest_that_counts(&known.lines);
            let mut coarse = Vec::new();
            for ((&[low, high], &middle), line) in pending.iter().zip(&middles).zip(&lines) {
                if self.miss(&known, middle, line, &dark) > GAIN * self.tolerance {
                    coarse.extend([[low, middle], [middle, high]]);
                }
            }
            known = merged(
                known,
                Lines {
                    axis: middles,
                    lines,
                },
            );
            if coarse.is_empty() {
                break;
            }
            pending = coarse;
        }
        known
    }

    /// The exact lines, side by side and gathered in order.
    fn solve(&self, places: &[f64]) -> Vec<Line> {
        places.par_iter().map(|&place| (self.line)(place)).collect()
    }

    /// The largest relative miss of interpolation at a place.
    fn miss(&self, known: &Lines, place: f64, exact: &Line, dark: &[f64]) -> f64 {
        let mut interpolated = vec![0.0; exact.len()];
        for (node, weight) in (self.stencil)(&known.axis, place) {
            for (value, node_value) in interpolated.iter_mut().zip(&known.lines[node]) {
                *value += weight * node_value;
            }
        }
        let n_values = self.n_channels * self.n_wavelengths;
        let mut largest = 0.0_f64;
        let cells = exact.chunks(n_values).zip(interpolated.chunks(n_values));
        for (exact, interpolated) in cells {
            let sums = self.sums(exact);
            for (i, (exact, interpolated)) in exact.iter().zip(interpolated).enumerate() {
                let wavelength = i % self.n_wavelengths;
                let scale = exact.max(MINOR * sums[wavelength]).max(dark[wavelength]);
                if scale > 0.0 {
                    largest = largest.max((interpolated - exact).abs() / scale);
                }
            }
        }
        largest
    }

    /// By wavelength, the share `DARK` of the brightest cell.
    fn darkest_that_counts(&self, lines: &[Line]) -> Vec<f64> {
        let brightest = self.brightest_of(lines);
        brightest.into_iter().map(|light| DARK * light).collect()
    }

    /// Sum of the channels of the brightest cell, here or elsewhere, by wavelength.
    pub(crate) fn brightest_of(&self, lines: &[Line]) -> Vec<f64> {
        let mut brightest = self.brightest.to_vec();
        let cells = lines
            .iter()
            .flat_map(|line| line.chunks(self.n_channels * self.n_wavelengths));
        for cell in cells {
            for (brightest, sum) in brightest.iter_mut().zip(self.sums(cell)) {
                *brightest = brightest.max(sum);
            }
        }
        brightest
    }

    /// Sum of the channels of one cell, by wavelength.
    fn sums(&self, cell: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.n_wavelengths];
        for channel in cell.chunks(self.n_wavelengths) {
            for (sum, value) in sums.iter_mut().zip(channel) {
                *sum += value;
            }
        }
        sums
    }
}

/// Both sets of lines in the order of their axis.
fn merged(known: Lines, new: Lines) -> Lines {
    let axes = known.axis.into_iter().chain(new.axis);
    let lines = known.lines.into_iter().chain(new.lines);
    let mut pairs: Vec<(f64, Line)> = axes.zip(lines).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (axis, lines) = pairs.into_iter().unzip();
    Lines { axis, lines }
}

#[cfg(test)]
mod tests {
    use niji_exchange::Stencil;

    use super::*;

    fn refined(tolerance: f64, f: impl Fn(f64) -> f64 + Sync) -> Lines {
        let refinement = Refinement {
            tolerance,
            max_halvings: 8,
            n_channels: 1,
            n_wavelengths: 1,
            brightest: &[0.0],
            line: |x: f64| vec![f(x)],
            stencil: |axis: &[f64], x: f64| Stencil::<4>::new(axis, x).weighted_nodes().collect(),
        };
        refinement.refine(vec![0.0, 0.25, 0.5, 0.75, 1.0])
    }

    #[test]
    fn nodes_gather_where_a_function_bends_and_errors_stay_below_twice_the_tolerance() {
        let peak = |x: f64| 1.0 + 1.0 / (1.0 + (30.0 * (x - 0.2)).powi(2));
        let found = refined(1e-4, peak);
        let near = found.axis.iter().filter(|x| (*x - 0.2).abs() < 0.1).count();
        let far = found.axis.iter().filter(|x| (*x - 0.8).abs() < 0.1).count();
        assert!(near > 3 * far, "{near} {far}");
        for i in 0..=1000 {
            let x = f64::from(i) / 1000.0;
            let nodes = Stencil::<4>::new(&found.axis, x).weighted_nodes();
            let value: f64 = nodes.map(|(i, weight)| weight * found.lines[i][0]).sum();
            let error = (value / peak(x) - 1.0).abs();
            // Worst 1.6e-4, where the spacing changes and the stencil is not even.
            assert!(error < 2e-4, "{x}: {error:e}");
        }
    }

    #[test]
    fn a_cubic_needs_no_more_than_one_test_of_each_interval() {
        assert_eq!(refined(1e-9, |x| 1.0 + x * x * x).axis.len(), 9);
    }

    #[test]
    fn darkness_needs_no_nodes_and_no_division_by_0() {
        assert_eq!(refined(1e-9, |_| 0.0).axis.len(), 9);
    }

    #[test]
    fn an_edge_does_not_ask_for_nodes_without_end() {
        let found = refined(1e-6, |x| if x < 0.3 { 1.0 } else { 2.0 });
        assert!(found.axis.len() < 100, "{}", found.axis.len());
    }
}
