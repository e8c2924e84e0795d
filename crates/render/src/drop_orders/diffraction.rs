//! Light of a bow that was diffracted forward, once or more, on its way.
//!
//! L = L_Full(P) + [L_WithoutDiffraction - L_Full](P * lobe)
//!
//! `L_Full`, `L_WithoutDiffraction` the first order with the extinction at Q = 2 and at Q = 1, `P` its
//! scattering table, `P * lobe` the table blurred by the pattern of a round hole as large as the drop,
//! (2 J1(x)/x)², x = k r psi. What Q = 2 takes and Q = 1 does not is light that some drop turned by
//! less than a degree or so: it still makes a bow, a little less sharp. With the first order at Q = 1
//! this adds [L_WithoutDiffraction - L_Full](P * lobe - P), which dims bow and fringes by some percent
//! and lights the dark side next to them; with Q = 2 it adds what is missing, so that all orders are
//! the same whichever first order they are added to.
//!
//! Around a bow the pattern counts by its projection on the scattering angle, the line-spread
//! function, whose transform is that of the round hole (the lobe itself, that a table of Mie's theory holds, is not
//! blurred once more: within the outermost quantile of 0 it counts as even and stays what it is):
//!
//! lsf(u) = 1/pi int_0^2 m(v/2) cos(u v) dv,   m(q) = 2/pi (acos q - q sqrt(1 - q²))
//!
//! `u = k r (theta' - theta)`. The blur is the mean of the table over quantiles of lsf. Repeated
//! diffraction widens the lobe further, which is left out, as is the spread of sizes in it; tables of
//! many radii are blurred at 24 of them.
//!
//! With the first order at Q = 1 the change is at most max |P * lobe - P| over the sizes times its light: far from bow
//! and fringes, where that is nothing to be seen, nobody marches for it.
//! [G05] J. W. Goodman, "Introduction to Fourier Optics", 3rd ed. (2005), eq. 6-31: m(q).

use std::borrow::Cow;
use std::f64::consts::PI;
use std::f64::consts::TAU;

use ndarray::Array5;
use ndarray::ArrayView1;
use ndarray::Axis;
use niji_exchange::ScatteringTable;
use rayon::prelude::*;

use super::phase::kept_radii;
use crate::angle_axis::RayPlace;
use crate::angle_axis::node_above;
use crate::deposits::Deposits;
use crate::levels::DropExtinctionModel;
use crate::march::March;
use crate::piece_rule::PieceRule;
use crate::scattering_rows::RowStencil;
use crate::scattering_rows::ScatteringRows;
use crate::size_nodes::SizeNodes;

/// Quantiles of the line-spread function on each side; the outermost lies at u = 13.
const N_QUANTILES: usize = 16;

/// Points of the integral over spatial frequencies: 2 u / 400 rad apart.
const N_FREQUENCIES: usize = 400;

/// Beyond the outermost quantile.
const LARGEST_U: f64 = 64.0;

/// The change of the first order by diffraction.
pub(crate) struct Diffraction<'a> {
    pub(crate) blurred: ScatteringRows<'a>,
    /// Taken off where the first order holds it already.
    pub(crate) sharp: Option<ScatteringRows<'a>>,
    /// Both extinctions, and whether their light is added or taken off.
    pub(crate) marches: [(March<'a>, f32); 2],
    /// What it changes at most, where the first order has the extinction without diffraction.
    most: Option<MostChanged>,
}

/// The first order that diffraction changes.
pub(crate) struct FirstOrder<'a> {
    pub(crate) march: March<'a>,
    pub(crate) extinction: DropExtinctionModel,
    /// Luminance of a spectrum of the table's unit, by wavelength [cd/m²].
    pub(crate) luminance_weights: Vec<f64>,
}

/// Luminance that differs at most between a table and the same blurred, of a unit of light, by scattering angle.
struct MostChanged {
    theta_rad: Vec<f64>,
    cd_m2: Vec<f64>,
}

impl MostChanged {
    /// The largest over all sizes, natural light.
    fn of(blurred: &ScatteringTable, sharp: &ScatteringTable, luminance_weights: &[f64]) -> Self {
        let (_, n_radii, n_variances, ..) = sharp.values.dim();
        let change = |[radius, variance, angle]: [usize; 3]| -> f64 {
            let of = |wavelength: usize| {
                let at = |table: &ScatteringTable| {
                    let value = |polarization| {
                        table.values[[polarization, radius, variance, wavelength, angle]]
                    };
                    0.5 * f64::from(value(0) + value(1))
                };
                (at(blurred) - at(sharp)).abs()
            };
            let weights = luminance_weights.iter().enumerate();
            weights.map(|(index, weight)| weight * of(index)).sum()
        };
        let most = |angle: usize| {
            let radii = 0..n_radii;
            let sizes =
                radii.flat_map(|radius| (0..n_variances).map(move |it| [radius, it, angle]));
            sizes.map(change).fold(0.0, f64::max)
        };
        let angles = 0..sharp.theta_rad.len();
        Self {
            theta_rad: sharp.theta_rad.clone(),
            cd_m2: angles.into_par_iter().map(most).collect(),
        }
    }

    /// The largest within the angles of a ray.
    fn at(&self, place: &RayPlace) -> f64 {
        let half_rad = 0.5 * place.width_rad;
        let below = |theta_rad: f64| self.theta_rad.partition_point(|node| *node <= theta_rad);
        let first = below(place.theta_rad - half_rad).saturating_sub(1);
        let end = (below(place.theta_rad + half_rad) + 1).min(self.cd_m2.len());
        self.cd_m2[first..end].iter().copied().fold(0.0, f64::max)
    }
}

/// Room to work in.
#[derive(Clone, Debug)]
pub(crate) struct DiffractionRoom {
    /// What diffraction changes [W m^-2 sr^-1 nm^-1].
    pub(crate) light: Vec<f32>,
    pub(crate) deposits: Deposits,
    pub(crate) stencil: RowStencil,
    pub(crate) slab_ends_m: Vec<f64>,
    pub(crate) spectrum: Vec<f32>,
    pub(crate) transmitted: Vec<f32>,
}

impl<'a> Diffraction<'a> {
    /// For rays between two scattering angles, of drops in `march`.
    pub(crate) fn new(
        table: &ScatteringTable,
        theta_range_rad: (f64, f64),
        first_order: &FirstOrder<'a>,
    ) -> Self {
        let march = first_order.march;
        let sharp = with_few_radii(table);
        // Nobody asks these rows for luminance.
        let dark = vec![0.0; table.wavelengths.len()];
        let rows = |table: ScatteringTable| {
            let nodes = SizeNodes::of_table(&table);
            ScatteringRows::new((Cow::Owned(table), nodes), theta_range_rad, &dark)
        };
        let of = |model: DropExtinctionModel| {
            let efficiency = model.efficiency();
            let rule = PieceRule::new(efficiency, efficiency, march.integration);
            March { rule, ..march }
        };
        let blurred = blurred(&sharp, theta_range_rad);
        let has_sharp = match first_order.extinction {
            DropExtinctionModel::WithoutDiffraction => true,
            DropExtinctionModel::Full => false,
        };
        let most = || MostChanged::of(&blurred, &sharp, &first_order.luminance_weights);
        Self {
            most: has_sharp.then(most),
            blurred: rows(blurred),
            sharp: has_sharp.then(|| rows(sharp)),
            marches: [
                (of(DropExtinctionModel::WithoutDiffraction), 1.0),
                (of(DropExtinctionModel::Full), -1.0),
            ],
        }
    }

    /// What it changes at most in the luminance of a ray whose first order has so much light [cd/m²]; `None` where
    /// that is not known.
    pub(crate) fn most_changed(&self, place: &RayPlace, light: f64) -> Option<f64> {
        Some(light * self.most.as_ref()?.at(place))
    }

    /// Its tables.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &ScatteringRows<'a>> {
        std::iter::once(&self.blurred).chain(&self.sharp)
    }

    /// Room for a ray.
    pub(crate) fn room(&self, n_wavelengths: usize) -> DiffractionRoom {
        DiffractionRoom {
            light: vec![0.0; n_wavelengths],
            deposits: Deposits::new(self.blurred.axes()),
            stencil: RowStencil::default(),
            slab_ends_m: Vec::new(),
            spectrum: vec![0.0; n_wavelengths],
            transmitted: vec![1.0; n_wavelengths],
        }
    }
}

/// The table with as many radii as are blurred.
fn with_few_radii(table: &ScatteringTable) -> ScatteringTable {
    let kept = kept_radii(table.effective_radius_um.len());
    let radii = kept.iter().map(|index| table.effective_radius_um[*index]);
    with(table, radii.collect(), table.values.select(Axis(1), &kept))
}

/// A table like another one, without copying what is not kept.
fn with(table: &ScatteringTable, radii_um: Vec<f64>, values: Array5<f32>) -> ScatteringTable {
    ScatteringTable {
        theory: table.theory.clone(),
        orders: table.orders.clone(),
        wavelengths: table.wavelengths,
        theta_rad: table.theta_rad.clone(),
        effective_radius_um: radii_um,
        effective_variance: table.effective_variance.clone(),
        values,
        moved: None,
        row_use: table.row_use,
        relative_error: table.relative_error,
        sun_disc_diameter_rad: table.sun_disc_diameter_rad,
        split_theta_rad: table.split_theta_rad,
        forward_fraction_left_out: table.forward_fraction_left_out,
        water: table.water,
        phase_functions: None,
        interpolation_error: None,
    }
}

/// The table blurred between two angles by the pattern of each radius and wavelength.
fn blurred(table: &ScatteringTable, theta_range_rad: (f64, f64)) -> ScatteringTable {
    let quantiles = line_spread_quantiles();
    let angles = &table.theta_rad;
    // One node beyond each end: what rows between these angles are made of.
    let first = angles.partition_point(|theta| *theta <= theta_range_rad.0);
    let end = angles.partition_point(|theta| *theta < theta_range_rad.1);
    let wanted = first.saturating_sub(1)..(end + 1).min(angles.len());
    let mut values = table.values.clone();
    let wavelengths_um: Vec<f64> = table
        .wavelengths
        .centers()
        .map(|wavelength| 1e-3 * wavelength.0)
        .collect();
    values
        .axis_iter_mut(Axis(1))
        .into_par_iter()
        .enumerate()
        .for_each(|(radius, mut of_radius)| {
            for (wavelength, wavelength_um) in wavelengths_um.iter().enumerate() {
                let per_rad = TAU * table.effective_radius_um[radius] / wavelength_um;
                let turns = quantiles.map(|u| u / per_rad);
                let lobe_rad = turns[N_QUANTILES - 1];
                let of_table = table.values.index_axis(Axis(1), radius);
                let sharp = of_table.index_axis(Axis(2), wavelength);
                let mut blurred = of_radius.index_axis_mut(Axis(2), wavelength);
                // All polarizations and variances are blurred alike.
                let mut places = turns.map(|_| BetweenAngles::default());
                for angle in wanted.clone() {
                    let theta_rad = angles[angle];
                    if theta_rad < lobe_rad {
                        continue;
                    }
                    for (place, turn) in places.iter_mut().zip(&turns) {
                        place.move_to((theta_rad + turn).max(lobe_rad), angles);
                    }
                    for (mut blurred, sharp) in blurred
                        .lanes_mut(Axis(2))
                        .into_iter()
                        .zip(sharp.lanes(Axis(2)))
                    {
                        let sum: f64 = places.iter().map(|place| place.value(&sharp)).sum();
                        // f32 as in the table.
                        blurred[angle] = (sum / turns.len() as f64) as f32;
                    }
                }
            }
        });
    with(table, table.effective_radius_um.clone(), values)
}

/// A scattering angle between two nodes of a table, for linear interpolation.
#[derive(Clone, Copy, Debug, Default)]
struct BetweenAngles {
    lower: usize,
    /// From 0 at the lower node to 1 at the upper one.
    fraction: f64,
}

impl BetweenAngles {
    /// Goes to an angle, which is folded back at 0 and 180 degrees, from one that is near.
    fn move_to(&mut self, theta_rad: f64, angles: &[f64]) {
        let folded = theta_rad.abs();
        let folded = if folded > PI { TAU - folded } else { folded };
        let above = node_above(angles, folded, &mut (self.lower + 1));
        self.lower = above.clamp(1, angles.len() - 1) - 1;
        let (low, high) = (angles[self.lower], angles[self.lower + 1]);
        self.fraction = ((folded - low) / (high - low)).clamp(0.0, 1.0);
    }

    fn value(&self, values: &ArrayView1<f32>) -> f64 {
        let (low, high) = (values[self.lower], values[self.lower + 1]);
        f64::from(low) * (1.0 - self.fraction) + f64::from(high) * self.fraction
    }
}

/// Share of the light of the line-spread function below u: 1/2 + 1/pi int_0^2 m(v/2) sin(u v)/v dv.
fn line_spread_below(u: f64) -> f64 {
    let step = 2.0 / N_FREQUENCIES as f64;
    let sum: f64 = (0..N_FREQUENCIES)
        .map(|index| (index as f64 + 0.5) * step)
        .map(|v| {
            let q = 0.5 * v;
            let transfer = 2.0 / PI * (q.acos() - q * (1.0 - q * q).sqrt());
            transfer * (u * v).sin() / v
        })
        .sum();
    0.5 + sum * step / PI
}

/// The middles of equal shares of the line-spread function, by bisection.
fn line_spread_quantiles() -> [f64; 2 * N_QUANTILES] {
    std::array::from_fn(|index| {
        let side = index % N_QUANTILES;
        let share = 0.5 + (side as f64 + 0.5) / (2 * N_QUANTILES) as f64;
        let (mut low, mut high) = (0.0, LARGEST_U);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if line_spread_below(middle) < share {
                low = middle;
            } else {
                high = middle;
            }
        }
        if index < N_QUANTILES { low } else { -low }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_lines_light_lies_on_each_side_and_all_of_it_somewhere() {
        assert!((line_spread_below(0.0) - 0.5).abs() < 1e-15);
        // The tail: 2/(pi² u) on each side, from the 2/(pi x) of light beyond x (Goodman 2005).
        for u in [10.0, 20.0, 40.0] {
            let expected = 2.0 / (PI * PI * u);
            let found = 1.0 - line_spread_below(u);
            // Measured 3 %: the rings.
            assert!(
                (found / expected - 1.0).abs() < 0.06,
                "{u}: {found} {expected}"
            );
        }
    }

    #[test]
    fn the_line_spread_is_the_projection_of_the_pattern() {
        // Encircled light 1 - J0² - J1² seen along a line: its mean over azimuths of the strip.
        let j = |order: f64, x: f64| {
            let n = 400;
            (0..n)
                .map(|index| PI * (f64::from(index) + 0.5) / f64::from(n))
                .map(|t| (order * t - x * t.sin()).cos())
                .sum::<f64>()
                / f64::from(n)
        };
        let beyond = |x: f64| j(0.0, x).powi(2) + j(1.0, x).powi(2);
        for u in [0.5, 1.5, 3.0, 6.0] {
            let n = 2000;
            let outside: f64 = (0..n)
                .map(|index| 0.5 * PI * (f64::from(index) + 0.5) / f64::from(n))
                .map(|azimuth| beyond(u / azimuth.cos()))
                .sum::<f64>()
                / f64::from(n);
            let found = 1.0 - line_spread_below(u);
            // Half of all azimuths look to each side. Measured 2e-4.
            assert!(
                (found - 0.5 * outside).abs() < 1e-3,
                "{u}: {found} {outside}"
            );
        }
    }

    #[test]
    fn places_between_angles_are_found_from_wherever_they_were() {
        let angles = [0.0, 0.5, 0.6, 2.0, PI];
        let squares = ndarray::arr1(&[0.0, 1.0, 4.0, 9.0, 16.0_f32]);
        let mut place = BetweenAngles::default();
        for (theta_rad, value) in [
            (0.55, 2.5),
            (3.0 + 1e-9, 9.0 + 7.0 * (1.0 + 1e-9) / (PI - 2.0)),
            (PI, 16.0),
            (TAU - 2.0, 9.0),
            (-0.25, 0.5),
            (0.5, 1.0),
            (0.0, 0.0),
            (TAU, 0.0),
        ] {
            place.move_to(theta_rad, &angles);
            let found = place.value(&squares.view());
            assert!((found - value).abs() < 1e-12, "{theta_rad}: {found}");
        }
    }

    #[test]
    fn quantiles_are_symmetric_and_ascend() {
        let quantiles = line_spread_quantiles();
        for index in 0..N_QUANTILES {
            assert!((quantiles[index] + quantiles[N_QUANTILES + index]).abs() < 1e-12);
        }
        assert!(
            quantiles[..N_QUANTILES]
                .windows(2)
                .all(|pair| pair[0] < pair[1])
        );
        assert!((10.0..20.0).contains(&quantiles[N_QUANTILES - 1]));
    }
}
