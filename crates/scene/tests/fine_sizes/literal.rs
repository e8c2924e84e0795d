//! The literal sum over thousands of radii: each sphere's own light, moved by its own shift.
//!
//! t(θ) = Σ_j w_j Σ_p t_p(θ − Δθ_p(a_j); a_j)
//! `w_j` share of the radius `a_j` in the cross-section of the drops, `t_p` light of order p in a table for
//! spheres of just these radii, `Δθ_p` shift of the bow. Beyond 180 degrees light comes from the mirrored
//! angle.

use std::f64::consts::PI;

use niji_exchange::BowShift;
use niji_exchange::ScatteringTable;
use niji_radiometry::Micrometers;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_scatter::bow_shift;
use niji_scatter::eccentricity;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;
use niji_sizes::gamma_area_quadrature;

use crate::profile::Sight;
use crate::rain::ORDERS;
use crate::rain::Rain;
use crate::rain::WATER;
use crate::rain::green;
use crate::rain::index_of_water;

/// Radii of a law; 6000 change no figure.
const N_RADII: usize = 2200;
/// Radii of a smaller share of the cross-section, of a hundredth of a micrometre say, are left out.
const LEAST_SHARE: f64 = 1e-11;
/// Angles of each order (degrees): where spheres of more than some micrometres send its light, and none from
/// farther away than a bow is followed.
const THETA_DEG: [(f64, f64); 2] = [(125.0, 180.0), (84.0, 135.0)];
/// Of straight lines between the angles, in parts of the peak of a single size.
const TOLERANCE: f64 = 1e-4;
/// As plans have it.
const SUN_DISC_RAD: f64 = 0.533 * PI / 180.0;

/// Light of single spheres, ready to be summed.
pub(crate) struct Literal {
    /// Radii [µm] and their shares.
    pub(crate) radii: Vec<(f64, f64)>,
    /// By order.
    tables: [ScatteringTable; 2],
}

impl Literal {
    /// That of the gamma laws of rain.
    pub(crate) fn gamma(rain: &Rain) -> Self {
        let n_laws = rain.0.len() as f64;
        let of_law = |(radius_um, variance): &(f64, f64)| {
            let radii = gamma_area_quadrature(Micrometers(*radius_um), *variance, N_RADII);
            let shares = radii.unwrap().into_iter();
            shares.map(move |(radius_um, share)| (radius_um, share / n_laws))
        };
        Self::of(rain.0.iter().flat_map(of_law).collect())
    }

    /// That of radii [µm] and their shares.
    pub(crate) fn of(mut radii: Vec<(f64, f64)>) -> Self {
        radii.retain(|(_, share)| *share > LEAST_SHARE);
        radii.sort_by(|one, other| one.0.total_cmp(&other.0));
        let table = |order: usize| {
            let (first_deg, last_deg) = THETA_DEG[order];
            let request = TableRequest {
                theory: Theory::Uniform,
                orders: vec![ORDERS[order]],
                theta_range_rad: (first_deg.to_radians(), last_deg.to_radians()),
                tolerance: TOLERANCE,
                wavelengths: green(),
                effective_radius_um: radii.iter().map(|(radius_um, _)| *radius_um).collect(),
                effective_variance: vec![0.0],
                rows: SizeRows::Laws,
                motion: None,
                sun_disc_diameter_rad: SUN_DISC_RAD,
                water: WATER,
                airy_table: None,
            };
            scattering_table(&request, &unwatched).unwrap()
        };
        Self {
            tables: [0, 1].map(table),
            radii,
        }
    }

    /// Light of spheres [1/sr].
    pub(crate) fn of_spheres(&self, sights: &[Sight]) -> Vec<f64> {
        let light = |sight: &Sight| [0, 1].map(|order| self.light(order, sight, |_| 0.0));
        sights
            .iter()
            .map(|sight| light(sight).iter().sum())
            .collect()
    }

    /// Light of flat drops at rest [1/sr], by the form of second order at every radius and direction.
    pub(crate) fn of_flat_drops(&self, sights: &[Sight]) -> Vec<f64> {
        let shifts: [BowShift; 2] = ORDERS.map(|p| bow_shift(index_of_water(), p).unwrap());
        let radii = self.radii.iter();
        let flat: Vec<f64> = radii.map(|it| eccentricity(Micrometers(it.0))).collect();
        let light = |sight: &Sight| {
            let of_order = |order: usize| {
                let seen = shifts[order].seen(sight.t2, sight.b2);
                self.light(order, sight, |radius| seen.shift_rad(flat[radius]))
            };
            of_order(0) + of_order(1)
        };
        sights.iter().map(light).collect()
    }

    /// Light of the primary alone [1/sr], moved by the same everywhere, by radius.
    pub(crate) fn of_primary(&self, sights: &[Sight], shifts_rad: &[f64]) -> Vec<f64> {
        let light = |sight| self.light(0, sight, |radius| shifts_rad[radius]);
        sights.iter().map(light).collect()
    }

    fn light(&self, order: usize, sight: &Sight, shift_rad: impl Fn(usize) -> f64) -> f64 {
        let of_radius = |(radius, (_, share)): (usize, &(f64, f64))| {
            let from_rad = sight.theta_rad - shift_rad(radius);
            share * natural(&self.tables[order], radius, PI - (PI - from_rad).abs())
        };
        self.radii.iter().enumerate().map(of_radius).sum()
    }
}

/// Natural light of a row, linear between the angles and dark beyond them.
fn natural(table: &ScatteringTable, row: usize, theta_rad: f64) -> f64 {
    let angles = &table.theta_rad;
    let above = angles.partition_point(|angle| *angle <= theta_rad);
    if above == 0 || above == angles.len() {
        return 0.0;
    }
    let part = (theta_rad - angles[above - 1]) / (angles[above] - angles[above - 1]);
    let at = |angle| {
        let [s, p] = [0, 1].map(|j| f64::from(table.values[[j, row, 0, 0, angle]]));
        0.5 * (s + p)
    };
    at(above - 1) * (1.0 - part) + at(above) * part
}
