//! Error and time of every method for a sky of 640 x 480 directions and 41 wavelengths, one thread.
//!
//! Air: Rayleigh (Bodhaine), 300 DU of ozone, rural aerosol; ground of albedo 0.2; observer at 2 m.
//! Errors are over 24 x 24 directions of the whole sphere, against adaptive quadrature at 1e-7.

use std::time::Instant;

use divan::Bencher;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::AirModel;
use niji_atmosphere::BodhaineAir;
use niji_atmosphere::OzoneLayer;
use niji_atmosphere::PreparedSky;
use niji_atmosphere::ReferenceSky;
use niji_atmosphere::STANDARD_PRESSURE_PA;
use niji_atmosphere::SkyMethod;
use niji_atmosphere::SkyMethodCost;
use niji_atmosphere::SkyObserver;
use niji_atmosphere::USUAL_TOP_M;
use niji_atmosphere::spread_directions;
use niji_exchange::AtmosphereTable;
use niji_geometry::EARTH;
use niji_radiometry::Radians;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;

const N_DIRECTIONS: usize = 640 * 480;
const SUN_ELEVATIONS_DEG: [f64; 7] = [60.0, 20.0, 10.0, 5.0, 2.0, 0.0, -4.0];

fn main() {
    // A filter on the command line asks for single times.
    if std::env::args()
        .skip(1)
        .all(|argument| argument.starts_with("--"))
    {
        one_thread(print_errors);
    }
    divan::main();
}

fn one_thread(f: impl FnOnce() + Send) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("one thread can be had").install(f);
}

fn air() -> AtmosphereTable {
    let wavelengths = WavelengthGrid::new(380.0, 10.0, 41).expect("within the tables");
    let constituents = [
        BodhaineAir::at_pressure(STANDARD_PRESSURE_PA).constituent(&wavelengths),
        OzoneLayer::of_column(300.0).constituent(&wavelengths),
        AerosolKind::Rural.aerosol().constituent(&wavelengths),
    ];
    let model = AirModel {
        planet: EARTH,
        top_height_m: USUAL_TOP_M,
        wavelengths,
        sun_scale: 1.0,
        ground: Reflectance::Even(0.2),
        constituents: constituents
            .map(|constituent| constituent.expect("usual air"))
            .to_vec(),
    };
    model.tabulate().expect("usual air")
}

fn observer(sun_elevation_deg: f64) -> SkyObserver {
    SkyObserver::from_elevation(2.0, Radians::from_degrees(sun_elevation_deg))
}

/// Shortest time that is measured, s: the system's account of a thread is kept by the tick.
const LONG_ENOUGH_S: f64 = 0.1;

/// Mean time of as many runs as are long enough.
fn seconds(run: &mut dyn FnMut()) -> f64 {
    let start = Instant::now();
    let mut n_runs = 1;
    loop {
        let before = clock_s(start);
        for _ in 0..n_runs {
            run();
        }
        let spent_s = clock_s(start) - before;
        if spent_s > LONG_ENOUGH_S {
            return spent_s / f64::from(n_runs);
        }
        n_runs *= 4;
    }
}

/// What this thread spent on the processor, where the system says so; other programs then do not
/// count. The clock on the wall elsewhere.
fn clock_s(start: Instant) -> f64 {
    let on_processor = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = on_processor.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(
        || start.elapsed().as_secs_f64(),
        |nanoseconds| 1e-9 * nanoseconds,
    )
}

fn print_errors() {
    let air = air();
    let directions = spread_directions(Radians::from_degrees(-90.0), 24);
    println!("sun [deg]  method           setup [ms]  direction [us]  640 x 480 [s]  worst    rms");
    for sun_deg in SUN_ELEVATIONS_DEG {
        let observer = observer(sun_deg);
        let reference = ReferenceSky::new(&air, observer, &directions);
        for method in SkyMethod::ALL {
            let row = reference.cost(method, &mut seconds);
            print_row(sun_deg, &row);
        }
    }
}

fn print_row(sun_deg: f64, row: &SkyMethodCost) {
    println!(
        "{sun_deg:9}  {:16} {:10.2}  {:14.3}  {:13.3}  {:.1e}  {:.1e}",
        row.method.label(),
        row.setup_s * 1e3,
        row.direction_s * 1e6,
        row.picture_s(N_DIRECTIONS),
        row.worst_error,
        row.rms_error,
    );
}

#[divan::bench(args = ["gauss 16 x table", "dome 1e-4"])]
fn sky_directions(bencher: Bencher, label: &str) {
    let air = air();
    let method = SkyMethod::ALL
        .into_iter()
        .find(|method| method.label() == label);
    let method = method.expect("it is one of all");
    let sky = PreparedSky::new(&air, observer(20.0), method);
    let directions = spread_directions(Radians::from_degrees(-90.0), 24);
    let mut radiance = vec![0.0; air.wavelengths.len()];
    bencher.bench_local(|| {
        for &direction in &directions {
            sky.write_radiance(direction, &mut radiance);
        }
    });
}
