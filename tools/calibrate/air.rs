//! Error against time of the methods of the air.
//!
//! Three quantities, each in clear air (molecules and ozone) and in haze (rural besides):
//! `optical-length` to the top of the air for zenith angles 0 to 90 degrees at 0, 2 and 10 km;
//! `segment`, light scattered into 20 m to 200 km of a ray; `sky`, all directions above the horizon
//! for the sun at 2, 10, 30 and 60 degrees; `sky-all-orders`, the same with light of all orders of
//! scattering. References: the same by nested quadrature, 64 nodes on either ray, and for all orders
//! their finest level. Times are those of one ray on one thread, what is done once for a sky stands apart;
//! those of `gauss` lengths include finding the nodes.

use std::hint::black_box;
use std::time::Instant;

use niji_atmosphere::AerosolKind;
use niji_atmosphere::AirModel;
use niji_atmosphere::BodhaineAir;
use niji_atmosphere::DiffuseSky;
use niji_atmosphere::InScattering;
use niji_atmosphere::OpticalLength;
use niji_atmosphere::OzoneLayer;
use niji_atmosphere::ReferenceSky;
use niji_atmosphere::STANDARD_PRESSURE_PA;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::SkyMethod;
use niji_atmosphere::SkyObserver;
use niji_atmosphere::USUAL_TOP_M;
use niji_atmosphere::ViewRay;
use niji_atmosphere::optical_length_m;
use niji_atmosphere::spread_directions;
use niji_atmosphere::with_diffuse_light;
use niji_exchange::AtmosphereTable;
use niji_geometry::EARTH;
use niji_radiometry::Radians;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;
use serde::Serialize;

use crate::failure::Failure;
use crate::progress;
use crate::progress::Verbosity;
use crate::timed_run::N_REPEATS;
use crate::timed_run::rounded;

/// Shortest time that is measured: below it the loop is repeated.
const SHORTEST_S: f64 = 0.02;
/// Observers, m.
const HEIGHTS_M: [f64; 3] = [0.0, 2e3, 10e3];
/// Elevations of the sun.
const SUNS_DEG: [f64; 4] = [2.0, 10.0, 30.0, 60.0];
/// Directions over the sky: as many elevations as azimuths.
const N_SKY: usize = 8;

const LENGTHS: [(&str, OpticalLength); 7] = [
    ("midpoint 50", OpticalLength::Midpoint { n_steps: 50 }),
    ("midpoint 500", OpticalLength::Midpoint { n_steps: 500 }),
    ("gauss 8", OpticalLength::GaussLegendre { n_nodes: 8 }),
    ("gauss 16", OpticalLength::GaussLegendre { n_nodes: 16 }),
    ("gauss 32", OpticalLength::GaussLegendre { n_nodes: 32 }),
    ("chapman", OpticalLength::Chapman),
    ("table", OpticalLength::Table),
];

/// One method for one quantity.
#[derive(Debug, Serialize)]
pub(super) struct AirRow {
    quantity: &'static str,
    air: &'static str,
    method: String,
    worst_relative_error: f64,
    rms_relative_error: f64,
    setup_milliseconds: f64,
    microseconds_per_ray: f64,
    date: String,
}

/// Measures all methods.
pub(super) fn rows(date: &str, verbosity: Verbosity) -> Result<Vec<AirRow>, Failure> {
    let n_steps = 2 * (LENGTHS.len() + 2 * SkyMethod::ALL.len() + 1);
    let bar = progress::bar("calibrate", n_steps as u64, verbosity);
    let mut rows = Vec::new();
    for (name, air) in [("clear", air(false)?), ("haze", air(true)?)] {
        for (label, method) in LENGTHS {
            rows.push(lengths(&air, method).row("optical-length", name, label, date));
            bar.inc(1);
        }
        for method in SkyMethod::ALL {
            if let SkyMethod::Rays(rays) = method {
                rows.push(segments(&air, rays).row("segment", name, &method.label(), date));
            }
            bar.inc(1);
        }
        for method in SkyMethod::ALL {
            rows.push(skies(&air, method).row("sky", name, &method.label(), date));
            bar.inc(1);
        }
        for (label, cost) in all_orders(&air)? {
            rows.push(cost.row("sky-all-orders", name, label, date));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// Air at 41 wavelengths.
fn air(is_hazy: bool) -> Result<AtmosphereTable, Failure> {
    let wavelengths = WavelengthGrid::visible();
    let mut constituents = vec![
        BodhaineAir::at_pressure(STANDARD_PRESSURE_PA).constituent(&wavelengths),
        OzoneLayer::of_column(300.0).constituent(&wavelengths),
    ];
    if is_hazy {
        constituents.push(AerosolKind::Rural.aerosol().constituent(&wavelengths));
    }
    let failed = |error: niji_atmosphere::Error| Failure::Failed(error.to_string());
    let model = AirModel {
        planet: EARTH,
        top_height_m: USUAL_TOP_M,
        wavelengths,
        sun_scale: 1.0,
        ground: Reflectance::Even(0.2),
        constituents: constituents
            .into_iter()
            .collect::<Result<_, _>>()
            .map_err(failed)?,
    };
    model.tabulate().map_err(failed)
}

/// Errors and times of one method.
#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    worst: f64,
    squares: f64,
    n_values: f64,
    setup_s: f64,
    ray_s: f64,
}

impl Cost {
    fn compare(&mut self, found: f64, exact: f64) {
        if exact > 0.0 {
            let error = (found / exact - 1.0).abs();
            self.worst = self.worst.max(error);
            self.squares += error * error;
            self.n_values += 1.0;
        }
    }

    fn compare_all(&mut self, found: &[Vec<f64>], exact: &[Vec<f64>]) {
        for (found, exact) in found.iter().flatten().zip(exact.iter().flatten()) {
            self.compare(*found, *exact);
        }
    }

    fn row(self, quantity: &'static str, air: &'static str, method: &str, date: &str) -> AirRow {
        AirRow {
            quantity,
            air,
            method: method.to_owned(),
            worst_relative_error: rounded(self.worst),
            rms_relative_error: rounded((self.squares / self.n_values.max(1.0)).sqrt()),
            setup_milliseconds: rounded(1e3 * self.setup_s),
            microseconds_per_ray: rounded(1e6 * self.ray_s),
            date: date.to_owned(),
        }
    }
}

/// Time of one call, the fastest of several measurements.
fn seconds(run: &mut dyn FnMut()) -> f64 {
    let mut fastest = f64::INFINITY;
    for _ in 0..N_REPEATS {
        let start = Instant::now();
        let mut n_runs = 0.0;
        while n_runs < 1.0 || start.elapsed().as_secs_f64() < SHORTEST_S {
            run();
            n_runs += 1.0;
        }
        fastest = fastest.min(start.elapsed().as_secs_f64() / n_runs);
    }
    fastest
}

fn lengths(air: &AtmosphereTable, method: OpticalLength) -> Cost {
    let exact = OpticalLength::GaussLegendre { n_nodes: 64 };
    let mut places = Vec::new();
    for height_m in HEIGHTS_M {
        for zenith_deg in 0..=90 {
            places.push([height_m, f64::from(90 - zenith_deg).to_radians().sin()]);
        }
    }
    let mut cost = Cost::default();
    let n_constituents = air.constituents.len();
    for &place in &places {
        for index in 0..n_constituents {
            let length = |method| optical_length_m(air, index, method, place);
            cost.compare(length(method), length(exact));
        }
    }
    let all_s = seconds(&mut || {
        for &place in &places {
            for index in 0..n_constituents {
                black_box(optical_length_m(air, index, method, black_box(place)));
            }
        }
    });
    cost.ray_s = all_s / (places.len() * n_constituents) as f64;
    cost
}

fn segments(air: &AtmosphereTable, method: InScattering) -> Cost {
    let mut rays = Vec::new();
    for sun_deg in SUNS_DEG {
        for view_deg in [0.5, 5.0, 30.0] {
            for length_m in [20.0, 1e3, 10e3, 50e3, 200e3] {
                let angles = [view_deg, sun_deg, 138.0].map(f64::to_radians);
                rays.push(ViewRay::from_angles(2.0, angles, length_m));
            }
        }
    }
    let exact = InScattering::Nested {
        n_nodes: 64,
        n_sun_nodes: 64,
    };
    let (exact, solver) = (
        SingleScattering::new(air, exact),
        SingleScattering::new(air, method),
    );
    let mut cost = Cost::default();
    for ray in &rays {
        let (found, exact) = (solver.solve(ray), exact.solve(ray));
        for (found, exact) in found.radiance.iter().zip(&exact.radiance) {
            cost.compare(*found, *exact);
        }
    }
    let all_s = seconds(&mut || {
        for ray in &rays {
            black_box(solver.solve(black_box(ray)));
        }
    });
    cost.ray_s = all_s / rays.len() as f64;
    cost
}

fn skies(air: &AtmosphereTable, method: SkyMethod) -> Cost {
    let directions = spread_directions(Radians(0.0), N_SKY);
    let n_values = (directions.len() * air.wavelengths.len()) as f64;
    let mut cost = Cost::default();
    for sun_deg in SUNS_DEG {
        let observer = SkyObserver::from_elevation(2.0, Radians::from_degrees(sun_deg));
        let reference = ReferenceSky::new(air, observer, &directions);
        let found = reference.cost(method, &mut seconds);
        cost.worst = cost.worst.max(found.worst_error);
        cost.squares += n_values * found.rms_error.powi(2);
        cost.n_values += n_values;
        cost.setup_s += found.setup_s / SUNS_DEG.len() as f64;
        cost.ray_s += found.direction_s / SUNS_DEG.len() as f64;
    }
    cost
}

/// Levels of multiple scattering against the finest, the first order alone among them.
fn all_orders(air: &AtmosphereTable) -> Result<Vec<(&'static str, Cost)>, Failure> {
    let rays: Vec<ViewRay> = SUNS_DEG
        .into_iter()
        .flat_map(|sun_deg| {
            let observer = SkyObserver::from_elevation(2.0, Radians::from_degrees(sun_deg));
            let directions = spread_directions(Radians(0.0), N_SKY);
            directions
                .into_iter()
                .map(move |direction| observer.ray(direction))
        })
        .collect();
    let single = SingleScattering::new(air, InScattering::STANDARD);
    let once: Vec<Vec<f64>> = rays.iter().map(|ray| single.sky_radiance(ray)).collect();
    let fine = with_diffuse_light(air.clone(), ScatteringOrders::FINE);
    let exact = with_more(&fine, &rays, &once)?;
    let mut costs = vec![("one order", Cost::default())];
    costs[0].1.compare_all(&once, &exact);
    for (label, level) in [
        ("all orders, draft", ScatteringOrders::DRAFT),
        ("all orders, quick", ScatteringOrders::QUICK),
        ("all orders, standard", ScatteringOrders::STANDARD),
    ] {
        let mut solved = air.clone();
        let mut cost = Cost {
            setup_s: seconds(&mut || solved = with_diffuse_light(air.clone(), level)),
            ..Cost::default()
        };
        let mut found = with_more(&solved, &rays, &once)?;
        let all_s = seconds(&mut || {
            if let Ok(more) = with_more(black_box(&solved), &rays, &once) {
                found = more;
            }
        });
        cost.ray_s = all_s / rays.len() as f64;
        cost.compare_all(&found, &exact);
        costs.push((label, cost));
    }
    Ok(costs)
}

/// Light of one order and of all others along rays.
fn with_more(
    air: &AtmosphereTable,
    rays: &[ViewRay],
    once: &[Vec<f64>],
) -> Result<Vec<Vec<f64>>, Failure> {
    let sky = DiffuseSky::new(air).map_err(|error| Failure::Failed(error.to_string()))?;
    let all = |(ray, once): (&ViewRay, &Vec<f64>)| {
        let more = sky
            .radiance_per_sun(ray)
            .into_iter()
            .zip(&air.sun_irradiance);
        let both = once.iter().zip(more);
        both.map(|(once, (more, sun))| once + more * sun).collect()
    };
    Ok(rays.iter().zip(once).map(all).collect())
}
