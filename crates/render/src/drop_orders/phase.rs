//! The phase function of orders beyond the first: the scattering table without its forward lobe.
//!
//! P(theta) = t(theta) / N  outside the lobe, t(theta_c) / N within theta_c,  int P domega = 1
//!
//! `t` scattering table [1/sr], `N` its integral over the sphere so cut. Half of what a large drop
//! scatters is diffraction into a lobe of 1.22 lambda/(2 r); that light goes on as if nothing had
//! been met, and with the extinction at Q = 1 it is not counted at all. The theories of bows leave
//! the lobe out, and their orders 0 to 7 sum to N = 1 within a few percent: what water does not
//! absorb. A table that holds the lobe, of Mie's theory, is truncated at the angle theta_c at which
//! the rest and a plateau sum to 1 [P70]. Light is not polarized here, drops are spheres: orders
//! beyond the first mix what would tell.
//!
//! [P70] J. F. Potter, "The delta function approximation in radiative transfer theory", J. Atmos.
//! Sci. 27, 943-949 (1970).

use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_exchange::ScatteringTable;

use crate::error::Error;

/// Cells of the scattering angle, a quarter of a degree each: light that was scattered before comes
/// from all around and blurs a bow by tens of degrees.
pub(crate) const N_CELLS: usize = 720;

/// Points of the table averaged over a cell.
const POINTS_PER_CELL: usize = 8;

/// Radii that are kept of the table's; between them one of both neighbors is drawn.
const MAX_RADII: usize = 24;

/// Even parts of the light of a size at a wavelength, of each of which the cells are known.
const N_GUIDES: usize = 64;

/// Rounding of an angle in a file.
const ANGLE_SLACK_RAD: f64 = 1e-6;

/// Phase functions by size and wavelength, constant in each cell of the scattering angle.
#[derive(Clone, Debug)]
pub(crate) struct PhaseRows {
    ln_radius: Vec<f64>,
    variance: Vec<f64>,
    n_wavelengths: usize,
    /// [size, cell, wavelength] 1/sr. f32 as in the file.
    values_sr1: Vec<f32>,
    /// Share of the light below the end of each cell, [size, wavelength, cell].
    cumulative: Vec<f32>,
    /// The first cell that an even part of the light may end in, and the last, [size, wavelength, part].
    guides: Vec<u16>,
    /// Cosines of the edges of the cells.
    edge_cosines: Vec<f64>,
}

/// A cell of the scattering angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AngleCell(usize);

impl AngleCell {
    /// That of an angle.
    pub(crate) fn at(cosine: f64) -> Self {
        let cell = (cosine.clamp(-1.0, 1.0).acos() * (N_CELLS as f64 / PI)) as usize;
        Self(cell.min(N_CELLS - 1))
    }
}

/// One size of drops among those kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SizeClass(usize);

impl PhaseRows {
    /// The phase functions of a table.
    ///
    /// # Errors
    /// [`Error::AngleRange`] if the table does not reach from 0 to 180 degrees.
    pub(crate) fn new(table: &ScatteringTable) -> Result<Self, Error> {
        let ends = (
            table.theta_rad[0],
            table.theta_rad[table.theta_rad.len() - 1],
        );
        if ends.0 > ANGLE_SLACK_RAD || ends.1 < PI - ANGLE_SLACK_RAD {
            return Err(Error::AngleRange {
                found_deg: (ends.0.to_degrees(), ends.1.to_degrees()),
                expected_deg: (0.0, 180.0),
            });
        }
        let kept = kept_radii(table.effective_radius_um.len());
        let n_wavelengths = table.wavelengths.len();
        let n_classes = kept.len() * table.effective_variance.len();
        let mut rows = Self {
            ln_radius: kept
                .iter()
                .map(|radius| table.effective_radius_um[*radius].ln())
                .collect(),
            variance: table.effective_variance.clone(),
            n_wavelengths,
            values_sr1: vec![0.0; n_classes * N_CELLS * n_wavelengths],
            cumulative: vec![0.0; n_classes * N_CELLS * n_wavelengths],
            guides: vec![0; n_classes * n_wavelengths * (N_GUIDES + 1)],
            edge_cosines: (0..=N_CELLS)
                .map(|edge| cell_edge_rad(edge).cos())
                .collect(),
        };
        let points = CellPoints::of(&table.theta_rad);
        for (radius_class, radius) in kept.into_iter().enumerate() {
            for variance in 0..table.effective_variance.len() {
                let class = radius_class * table.effective_variance.len() + variance;
                for wavelength in 0..n_wavelengths {
                    let cells = points.means(&natural(table, radius, variance, wavelength));
                    rows.store(class, wavelength, cells);
                }
            }
        }
        Ok(rows)
    }

    /// Store a row, cut and normalized; a dark one stays dark.
    fn store(&mut self, class: usize, wavelength: usize, mut cells: Vec<f64>) {
        let norm = truncate_lobe(&mut cells);
        if norm <= 0.0 {
            return;
        }
        let mut below = 0.0;
        let class_row = class * self.n_wavelengths + wavelength;
        let row = class_row * N_CELLS;
        for (cell, value) in cells.iter().enumerate() {
            below += value * solid_angle_sr(cell) / norm;
            self.cumulative[row + cell] = below as f32;
            self.values_sr1[(class * N_CELLS + cell) * self.n_wavelengths + wavelength] =
                (value / norm) as f32;
        }
        let cumulative = &self.cumulative[row..row + N_CELLS];
        let whole = f64::from(cumulative[N_CELLS - 1]);
        let first = class_row * (N_GUIDES + 1);
        for (part, guide) in self.guides[first..=first + N_GUIDES].iter_mut().enumerate() {
            let sought = part as f64 / N_GUIDES as f64 * whole;
            let cell = cumulative.partition_point(|below| f64::from(*below) <= sought);
            *guide = cell.min(N_CELLS - 1) as u16;
        }
    }

    /// Draw the size class of drops with this effective radius and variance by two random numbers;
    /// the mean over them is linear interpolation in ln r_e and v_e.
    pub(crate) fn class(&self, radius_um: f64, variance: f64, random: [f64; 2]) -> SizeClass {
        let radius = drawn_node(&self.ln_radius, radius_um.ln(), random[0]);
        let variance = drawn_node(&self.variance, variance, random[1]);
        SizeClass(radius * self.variance.len() + variance)
    }

    /// The phase function by wavelength in a cell [1/sr].
    pub(crate) fn of(&self, class: SizeClass, cell: AngleCell) -> &[f32] {
        let start = (class.0 * N_CELLS + cell.0) * self.n_wavelengths;
        &self.values_sr1[start..start + self.n_wavelengths]
    }

    /// Draw a scattering angle from the phase function at one wavelength: its cosine and cell.
    pub(crate) fn draw(
        &self,
        (class, wavelength): (SizeClass, usize),
        random: f64,
    ) -> (f64, AngleCell) {
        let row = class.0 * self.n_wavelengths + wavelength;
        let cumulative = &self.cumulative[row * N_CELLS..][..N_CELLS];
        // f32 sums may end a little off 1.
        let sought = random * f64::from(cumulative[N_CELLS - 1]);
        let guide = &self.guides[row * (N_GUIDES + 1)..][(random * N_GUIDES as f64) as usize..];
        let [first, last] = [guide[0], guide[1]].map(usize::from);
        let among = &cumulative[first..last];
        let cell = first + among.partition_point(|below| f64::from(*below) <= sought);
        let from = if cell > 0 {
            f64::from(cumulative[cell - 1])
        } else {
            0.0
        };
        let share = f64::from(cumulative[cell]) - from;
        let part = if share > 0.0 {
            (sought - from) / share
        } else {
            0.5
        };
        let [near, far] = [cell, cell + 1].map(|edge| self.edge_cosines[edge]);
        let cosine = near + (far - near) * part.clamp(0.0, 1.0);
        (cosine, AngleCell(cell))
    }

    /// Number of wavelengths.
    pub(crate) fn n_wavelengths(&self) -> usize {
        self.n_wavelengths
    }
}

/// Nodes of the radius axis that are kept: all, or evenly spread ones with both ends.
pub(crate) fn kept_radii(n_radii: usize) -> Vec<usize> {
    if n_radii <= MAX_RADII {
        return (0..n_radii).collect();
    }
    let last = (n_radii - 1) as f64 / (MAX_RADII - 1) as f64;
    (0..MAX_RADII)
        .map(|index| (index as f64 * last).round() as usize)
        .collect()
}

/// Natural light of one size and wavelength by angle, of spheres.
fn natural(table: &ScatteringTable, radius: usize, variance: usize, wavelength: usize) -> Vec<f64> {
    (0..table.theta_rad.len())
        .map(|angle| {
            let [s, p] =
                [0, 1].map(|j| f64::from(table.values[[j, radius, variance, wavelength, angle]]));
            0.5 * (s + p)
        })
        .collect()
}

/// One of the two nodes around a value, the upper one with the probability of its weight.
fn drawn_node(nodes: &[f64], value: f64, random: f64) -> usize {
    let above = nodes.partition_point(|node| *node <= value);
    if above == 0 || above == nodes.len() {
        return above.min(nodes.len() - 1);
    }
    let fraction = (value - nodes[above - 1]) / (nodes[above] - nodes[above - 1]);
    if random < fraction { above } else { above - 1 }
}

fn cell_edge_rad(edge: usize) -> f64 {
    edge as f64 * PI / N_CELLS as f64
}

fn solid_angle_sr(cell: usize) -> f64 {
    TAU * (cell_edge_rad(cell).cos() - cell_edge_rad(cell + 1).cos())
}

/// Cut the forward lobe as far as the rest and a plateau hold more than 1, and return the integral
/// of what is left.
fn truncate_lobe(cells: &mut [f64]) -> f64 {
    let mut outside: f64 = (0..N_CELLS)
        .map(|cell| cells[cell] * solid_angle_sr(cell))
        .sum();
    if outside <= 1.0 {
        return outside;
    }
    let mut inside_sr = 0.0;
    for cell in 0..N_CELLS {
        let whole = inside_sr * cells[cell] + outside;
        if whole <= 1.0 || cell + 1 == N_CELLS {
            let plateau = cells[cell];
            cells[..cell].fill(plateau);
            return whole;
        }
        inside_sr += solid_angle_sr(cell);
        outside -= cells[cell] * solid_angle_sr(cell);
    }
    outside
}

/// Where the points of all cells lie on the axis of a table.
struct CellPoints {
    /// Lower node and fraction above it, cell by cell.
    places: Vec<(usize, f64)>,
}

impl CellPoints {
    fn of(theta_rad: &[f64]) -> Self {
        let places = (0..N_CELLS * POINTS_PER_CELL)
            .map(|point| {
                let theta = (point as f64 + 0.5) * PI / (N_CELLS * POINTS_PER_CELL) as f64;
                let above = theta_rad.partition_point(|node| *node <= theta);
                let lower = above.clamp(1, theta_rad.len() - 1) - 1;
                let step = theta_rad[lower + 1] - theta_rad[lower];
                (lower, ((theta - theta_rad[lower]) / step).clamp(0.0, 1.0))
            })
            .collect();
        Self { places }
    }

    /// Means over the solid angle of each cell.
    fn means(&self, values: &[f64]) -> Vec<f64> {
        let n_points = (N_CELLS * POINTS_PER_CELL) as f64;
        let point = |index: usize| {
            let (lower, fraction) = self.places[index];
            let sine = ((index as f64 + 0.5) * PI / n_points).sin();
            let value = values[lower] * (1.0 - fraction) + values[lower + 1] * fraction;
            (sine * value, sine)
        };
        (0..N_CELLS)
            .map(|cell| {
                let points = cell * POINTS_PER_CELL..(cell + 1) * POINTS_PER_CELL;
                let (sum, weight) = points
                    .map(point)
                    .fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
                sum / weight
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array5;
    use niji_radiometry::Water;
    use niji_radiometry::WavelengthGrid;

    use niji_exchange::RowUse;

    use super::*;

    /// A table of two radii by a function of radius index and angle.
    fn table(value: impl Fn(usize, f64) -> f64) -> ScatteringTable {
        let theta_rad: Vec<f64> = (0..=3600)
            .map(|step| f64::from(step) * PI / 3600.0)
            .collect();
        let values = Array5::from_shape_fn((2, 2, 1, 1, 3601), |(_, r, _, _, a)| {
            value(r, theta_rad[a]) as f32
        });
        ScatteringTable {
            theory: "test".into(),
            orders: "all".into(),
            wavelengths: WavelengthGrid::new(550.0, 10.0, 1).unwrap(),
            theta_rad,
            effective_radius_um: vec![10.0, 40.0],
            effective_variance: vec![0.0],
            values,
            moved: None,
            row_use: RowUse::Laws,
            relative_error: 5e-3,
            sun_disc_diameter_rad: 0.0,
            split_theta_rad: 2.2,
            forward_fraction_left_out: 0.5,
            water: Water::pure(20.0),
            phase_functions: None,
            interpolation_error: None,
        }
    }

    /// The phase function of Henyey and Greenstein, whose mean cosine is `g`.
    fn henyey_greenstein(g: f64, theta: f64) -> f64 {
        (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * theta.cos()).powf(1.5))
    }

    fn class(rows: &PhaseRows, radius_um: f64) -> SizeClass {
        rows.class(radius_um, 0.0, [0.5, 0.5])
    }

    #[test]
    fn a_phase_function_of_any_scale_is_normalized() {
        for scale in [1e-3, 0.9, 1.0] {
            let rows = PhaseRows::new(&table(|_, theta| scale * henyey_greenstein(0.6, theta)));
            let rows = rows.unwrap();
            let at = |cosine: f64| f64::from(rows.of(class(&rows, 10.0), AngleCell::at(cosine))[0]);
            for degrees in [0.125_f64, 30.125, 90.125, 179.875] {
                let theta = degrees.to_radians();
                // The middle of a cell against its mean.
                let error = at(theta.cos()) / henyey_greenstein(0.6, theta) - 1.0;
                assert!(error.abs() < 5e-3, "{scale} {degrees}: {error}");
            }
        }
    }

    #[test]
    fn drawn_cosines_have_the_mean_that_is_known() {
        for g in [0.0, 0.6, 0.9] {
            let rows = PhaseRows::new(&table(|_, theta| henyey_greenstein(g, theta))).unwrap();
            let n = 20_000;
            let mean: f64 = (0..n)
                .map(|index| (f64::from(index) + 0.5) / f64::from(n))
                .map(|random| rows.draw((class(&rows, 10.0), 0), random).0)
                .sum::<f64>()
                / f64::from(n);
            // Measured 2e-4 at g = 0.9, whose light is a little above 1.
            assert!((mean - g).abs() < 2e-3, "{g}: {mean}");
        }
    }

    #[test]
    fn the_guide_leads_to_the_cell_that_a_search_of_all_finds() {
        let lobe = |theta: f64| (-0.5 * (theta / 0.01).powi(2)).exp();
        let dark_behind = |theta: f64| if theta < 1.0 { 1.0 } else { 0.0 };
        for row in [
            table(|_, theta| henyey_greenstein(0.6, theta)),
            table(|_, theta| lobe(theta)),
            table(|_, theta| dark_behind(theta)),
        ] {
            let rows = PhaseRows::new(&row).unwrap();
            let cumulative = &rows.cumulative[..N_CELLS];
            let whole = f64::from(cumulative[N_CELLS - 1]);
            let parts = (0..64).map(|part| f64::from(part) / 64.0);
            let beside = |part: f64| [part, part.next_up(), part.next_down().max(0.0)];
            let ends = [0.0, 1.0_f64.next_down()];
            for random in parts.flat_map(beside).chain(ends) {
                let found = cumulative.partition_point(|it| f64::from(*it) <= random * whole);
                let (cosine, cell) = rows.draw((class(&rows, 10.0), 0), random);
                assert_eq!(cell, AngleCell(found.min(N_CELLS - 1)), "{random}");
                let [near, far] = [cell.0, cell.0 + 1].map(|edge| cell_edge_rad(edge).cos());
                assert!((far..=near).contains(&cosine), "{random} {cosine}");
            }
        }
    }

    #[test]
    fn what_exceeds_one_is_cut_from_the_forward_lobe_alone() {
        let width = 0.01;
        let lobe = |theta: f64| (-0.5 * (theta / width).powi(2)).exp() / (TAU * width * width);
        let whole = table(|_, theta| henyey_greenstein(0.5, theta) + lobe(theta));
        let rows = PhaseRows::new(&whole).unwrap();
        for degrees in [5.0_f64, 40.0, 140.0] {
            let theta = degrees.to_radians();
            let found = f64::from(rows.of(class(&rows, 10.0), AngleCell::at(theta.cos()))[0]);
            let error = found / henyey_greenstein(0.5, theta) - 1.0;
            assert!(error.abs() < 0.01, "{degrees}: {error}");
        }
        // The lobe is 1600/sr high; what stays is a plateau of ordinary height.
        assert!(rows.of(class(&rows, 10.0), AngleCell::at(1.0))[0] < 2.0);
    }

    #[test]
    fn between_two_radii_both_are_drawn_as_linear_interpolation_weighs_them() {
        let rows = PhaseRows::new(&table(|_, _| 0.05)).unwrap();
        // Halfway between ln 10 and ln 40.
        let [low, high] = [0.51, 0.49].map(|random| rows.class(20.0, 0.0, [random, 0.0]));
        assert_eq!((low, high), (SizeClass(0), SizeClass(1)));
        for (radius_um, index) in [(1.0, 0), (10.0, 0), (40.0, 1), (1e4, 1)] {
            assert_eq!(rows.class(radius_um, 0.3, [0.5, 0.5]), SizeClass(index));
        }
    }

    #[test]
    fn a_dark_table_is_dark_and_one_of_some_angles_is_refused() {
        let rows = PhaseRows::new(&table(|_, _| 0.0)).unwrap();
        assert_eq!(rows.of(class(&rows, 10.0), AngleCell::at(0.3)), [0.0]);
        assert!(rows.draw((class(&rows, 10.0), 0), 0.5).0.abs() <= 1.0);
        let mut part = table(|_, _| 0.05);
        part.theta_rad[3600] = 3.1413;
        assert!(matches!(
            PhaseRows::new(&part),
            Err(Error::AngleRange { .. })
        ));
    }
}
