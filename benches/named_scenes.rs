//! Whole pictures of named scenes: error beside time, and what the time depends on.
//!
//! `homogeneous`: 640 x 480 pixels, 90 degrees across, drops of 0.1 mm, 24000 in a cubic metre of a
//! box of 400 x 150 x 200 m. `gradient_64`: the same view of 64^3 nodes, radius 1.5 to 0.01 mm upwards,
//! density varied; `gradient_128`: the same on twice as many along each axis. `sparse_512`: 1920 x 1080
//! pixels, 60 degrees across, eleven rain cells that fill a twentieth of 512^3 nodes of 4 m, r_e 0.3 to
//! 0.9 mm, v_e = 1/3. The sun stands 20 degrees high behind the camera; drops dim and shadow each
//! other; tables are Airy's with the sun's disc.
//!
//! Errors are RMS of radiance over that of the reference, over tiles spread across the picture: the
//! reference has 8 x 8 rays a pixel, pieces to 1e-8 and a table to 1e-4, so that the errors of pixel,
//! integral, angles and sizes are in them. Those of the sun's volume are not; the closed forms of the
//! render crate's tests hold them.
//!
//! Times are those of the round with the least processor time, which is printed beside them.
//!
//!     cargo bench --bench named_scenes [SCENE]

#[path = "support/processor_time.rs"]
mod processor_time;

use std::hint::black_box;
use std::time::Duration;
use std::time::Instant;

use glam::DVec3;
use niji_airy::AiryTable;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_exchange::ScatteringTable;
use niji_geometry::Camera;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_geometry::PixelRegion;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_render::AirPath;
use niji_render::DropExtinctionModel;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::RenderLevels;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::SkyModel;
use niji_render::SunPath;
use niji_render::Toggle;
use niji_render::render;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;
use niji_sizes::radius_axis;
use niji_sizes::variance_axis;
use nix::sys::resource::UsageWho;
use nix::sys::resource::getrusage;
use processor_time::processor_time;

const ROUNDS: usize = 5;
/// Wavelengths at which errors are measured.
const FEW: usize = 5;

/// A scene and what its pictures need.
#[derive(Clone)]
struct Scene {
    camera: Camera,
    fov_deg: f64,
    bricks: Vec<Bricks>,
    /// Distance of the nodes of the sun's volume (m).
    sun_voxel_m: f64,
    radii_um: (f64, f64),
    variances: (f64, f64),
}

/// What a picture is made with.
#[derive(Clone, Copy)]
struct Level {
    name: &'static str,
    /// Error of the table, relative to the bow's peak.
    table_error: f64,
    integration: Integration,
    footprint: PixelFootprint,
}

const DRAFT: Level = Level {
    name: "draft: 2e-2, center",
    table_error: 2e-2,
    integration: Integration::Adaptive {
        relative_error: 2e-2,
    },
    footprint: PixelFootprint::Center,
};
const STANDARD: Level = Level {
    name: "standard: 5e-3, prefiltered",
    table_error: 5e-3,
    integration: Integration::CellExact,
    footprint: PixelFootprint::Prefiltered,
};
/// About as much error as a thousandth.
const CLOSE: Level = Level {
    name: "close: 1e-3, prefiltered",
    table_error: 1e-3,
    ..STANDARD
};
const FINE: Level = Level {
    name: "fine: 5e-4, prefiltered",
    table_error: 5e-4,
    ..STANDARD
};
const RAYS: Level = Level {
    name: "fine: 5e-4, 2 x 2 rays",
    footprint: PixelFootprint::Grid { n: 2 },
    ..FINE
};
const LEVELS: [Level; 5] = [DRAFT, STANDARD, CLOSE, FINE, RAYS];

const REFERENCE: Level = Level {
    name: "reference",
    table_error: 1e-4,
    integration: Integration::Adaptive {
        relative_error: 1e-8,
    },
    footprint: PixelFootprint::Grid { n: 8 },
};

/// Lays a scene out.
type MakeScene = fn() -> Scene;

fn main() {
    let wanted = std::env::args().skip(1).find(|name| !name.starts_with('-'));
    let scenes: [(&str, MakeScene); 4] = [
        ("homogeneous", homogeneous),
        ("gradient_64", || gradient(64)),
        ("gradient_128", || gradient(128)),
        ("sparse_512", sparse_512),
    ];
    for (name, make) in scenes {
        if wanted.as_deref().is_none_or(|wanted| wanted == name) {
            println!("\n{name}");
            measure(&make());
        }
    }
}

fn measure(scene: &Scene) {
    let bytes: usize = scene.bricks.iter().map(Bricks::memory_bytes).sum();
    println!("  bricks {:.1} MB", bytes as f64 / 1e6);
    let copy = || scene.bricks.clone();
    print_time("sun volume", &least_of(copy, |bricks| scene.lit(bricks)));
    let drops = scene.lit(copy());
    let whole = scene.frame();
    print_errors(scene, &drops);
    for level in LEVELS {
        let table = scene.table(41, level);
        let draw = || scene.picture(&drops, &table, level, whole);
        print_time(&format!("41 wavelengths, {}", level.name), &least(draw));
    }
    for n_wavelengths in [1, 41, 81] {
        let table = scene.table(n_wavelengths, STANDARD);
        let draw = || scene.picture(&drops, &table, STANDARD, whole);
        print_time(
            &format!("{n_wavelengths} wavelengths, standard"),
            &least(draw),
        );
    }
    print_dependence(scene, &drops);
}

/// One thread against all, a quarter of the pixels and bands of rows against the whole.
fn print_dependence(scene: &Scene, drops: &LitDrops) {
    let table = scene.table(41, STANDARD);
    let whole = scene.frame();
    let draw = |region| scene.picture(drops, &table, STANDARD, region);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one = one.expect("a thread can be started");
    let (all, alone) = (least(|| draw(whole)), least(|| one.install(|| draw(whole))));
    print_time("41 wavelengths, standard, one thread", &alone);
    let ratio = alone.wall.as_secs_f64() / all.wall.as_secs_f64();
    println!("  one thread takes {ratio:.2} times as long");
    let (width, height) = (scene.camera.width_px(), scene.camera.height_px());
    let small = Scene {
        camera: camera(scene.fov_deg, [width / 2, height / 2]),
        ..scene.clone()
    };
    let quarter = least(|| small.picture(drops, &table, STANDARD, small.frame()));
    let ratio = quarter.wall.as_secs_f64() / all.wall.as_secs_f64();
    println!("  a quarter of the pixels takes {ratio:.2} of the time");
    let bands = whole.bands(8).expect("the picture has more rows");
    let parts = bands
        .into_iter()
        .map(|band| least(|| draw(band)).wall.as_secs_f64());
    let ratio = parts.sum::<f64>() / all.wall.as_secs_f64();
    println!("  its eight bands one after the other take {ratio:.2} times as long");
}

/// Error of each level, one line each.
fn print_errors(scene: &Scene, drops: &LitDrops) {
    let fine = scene.table(FEW, REFERENCE);
    let tiles = scene.tiles();
    let references: Vec<Rendered> = tiles
        .iter()
        .map(|tile| scene.picture(drops, &fine, REFERENCE, *tile))
        .collect();
    for level in LEVELS {
        let table = scene.table(FEW, level);
        let (mut error, mut norm) = (0.0, 0.0);
        for (tile, reference) in tiles.iter().zip(&references) {
            let found = scene.picture(drops, &table, level, *tile);
            for (a, b) in found.radiance.iter().zip(&reference.radiance) {
                error += f64::from(a - b).powi(2);
                norm += f64::from(*b).powi(2);
            }
        }
        let error = (error / norm).sqrt();
        println!("  {:44} relative RMSE {error:.1e}", level.name);
    }
}

impl Scene {
    fn lit(&self, bricks: Vec<Bricks>) -> LitDrops {
        let voxel_m = self.sun_voxel_m;
        LitDrops::new(bricks, sun(), SunPath::Volume { voxel_m }).expect("the drops are sound")
    }

    fn frame(&self) -> PixelRegion {
        PixelRegion::frame(self.camera.width_px(), self.camera.height_px())
    }

    /// Tiles of 32 x 24 pixels, eight across and six down.
    fn tiles(&self) -> Vec<PixelRegion> {
        let (width, height) = (
            self.camera.width_px() as i32,
            self.camera.height_px() as i32,
        );
        let places = (0..48).map(|index| (index % 8, index / 8));
        let tile = |(column, row)| PixelRegion {
            x_px: (2 * column + 1) * width / 16 - 16,
            y_px: (2 * row + 1) * height / 12 - 12,
            width_px: 32,
            height_px: 24,
        };
        places.map(tile).collect()
    }

    fn table(&self, n_wavelengths: usize, level: Level) -> ScatteringTable {
        let airy = AiryTable::compute();
        let step_nm = 400.0 / n_wavelengths as f64;
        let wavelengths = WavelengthGrid::new(380.0 + step_nm / 2.0, step_nm, n_wavelengths);
        let radii = radius_axis(self.radii_um, self.variances.0, level.table_error);
        let request = TableRequest {
            theory: Theory::Airy,
            orders: vec![2, 3],
            theta_range_rad: (90_f64.to_radians(), 180_f64.to_radians()),
            tolerance: level.table_error,
            wavelengths: wavelengths.expect("the wavelengths are sound"),
            effective_radius_um: radii.expect("the radii are sound"),
            effective_variance: variance_axis(self.variances).expect("the variances are sound"),
            rows: SizeRows::Laws,
            motion: None,
            sun_disc_diameter_rad: 0.533_f64.to_radians(),
            water: Water::pure(15.0),
            airy_table: Some(&airy),
        };
        scattering_table(&request, &unwatched).expect("the request is sound")
    }

    fn picture(
        &self,
        drops: &LitDrops,
        table: &ScatteringTable,
        level: Level,
        region: PixelRegion,
    ) -> Rendered {
        let request = RenderRequest {
            camera: &self.camera,
            region,
            sun_direction: sun(),
            wavelengths: table.wavelengths,
            sun_irradiance: &solar_irradiance(&table.wavelengths),
            drops,
            table: Some(table),
            surfaces: None,
            water: None,
            air: None,
            effects: RenderEffects {
                drop_extinction: Toggle::On,
                drop_shadow: Toggle::On,
                ..RenderEffects::BOWS_ONLY
            },
            tolerance_cd_m2: None,
            orders_error_cd_m2: None,
            coarser_rays: 1.0,
            levels: RenderLevels {
                integration: level.integration,
                drop_extinction_model: DropExtinctionModel::WithoutDiffraction,
                drop_orders: DropOrders::SingleScattering,
                air_path: AirPath::Table,
                sky_model: SkyModel::None,
                pixel_footprint: level.footprint,
            },
        };
        render(&request, &|_| ()).expect("the request is sound")
    }
}

fn sun() -> DVec3 {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    DVec3::new(0.0, sin, cos)
}

fn camera(fov_deg: f64, [width_px, height_px]: [u32; 2]) -> Camera {
    let camera = PinholeCamera::new(PinholeRequest {
        position: DVec3::new(0.0, 2.0, 0.0),
        azimuth: Radians(0.0),
        elevation: Radians::from_degrees(8.0),
        roll: Radians(0.0),
        horizontal_fov: Radians::from_degrees(fov_deg),
        width_px,
        height_px,
    });
    camera.expect("the camera is sound").into()
}

fn bricks(grid: &GridBox, drops: impl Fn(DVec3) -> Drops + Sync) -> Vec<Bricks> {
    let mode = DropMode::from_fn("", grid, drops).expect("the field is sound");
    vec![Bricks::build(&mode, Interpolation::Moments).expect("the volume is small")]
}

fn homogeneous() -> Scene {
    let grid = GridBox {
        min: DVec3::new(-200.0, 0.0, -260.0),
        max: DVec3::new(200.0, 150.0, -60.0),
        voxel_m: 50.0,
    };
    let drops = Drops {
        number_density_m3: 24000.0,
        effective_radius_m: 1e-4,
        effective_variance: 0.0,
    };
    Scene {
        camera: camera(90.0, [640, 480]),
        fov_deg: 90.0,
        bricks: bricks(&grid, |_| drops),
        sun_voxel_m: 12.5,
        radii_um: (100.0, 100.0),
        variances: (0.0, 0.0),
    }
}

fn gradient(n: u32) -> Scene {
    let voxel_m = 200.0 / f64::from(n);
    let grid = GridBox {
        min: DVec3::new(-100.0, 0.0, -260.0),
        max: DVec3::new(100.0, 200.0, -60.0),
        voxel_m,
    };
    let drops = |point: DVec3| {
        let up = (point.y / 200.0).clamp(0.0, 1.0);
        let radius_m = 1.5e-3 * (1.0 - up) + 1e-5 * up;
        let wave = 1.0 + 0.8 * (point.x / 23.0).sin() * (point.z / 31.0).cos();
        // Extinction of 0.7/km at Q = 1 in the mean, whatever the radius.
        let number_density_m3 = (7e-4 * wave / (std::f64::consts::PI * radius_m * radius_m)) as f32;
        Drops {
            number_density_m3,
            effective_radius_m: radius_m as f32,
            effective_variance: 0.0,
        }
    };
    Scene {
        camera: camera(90.0, [640, 480]),
        fov_deg: 90.0,
        bricks: bricks(&grid, drops),
        sun_voxel_m: voxel_m,
        radii_um: (9.9, 1501.0),
        // What the mixture of two sizes between two nodes reaches.
        variances: (0.0, 0.05),
    }
}

fn sparse_512() -> Scene {
    let voxel_m = 4.0;
    let size_m = 512.0 * voxel_m;
    let min = DVec3::new(-size_m / 2.0, 0.0, -1000.0 - size_m);
    let grid = GridBox {
        min,
        max: min + DVec3::splat(size_m - voxel_m),
        voxel_m,
    };
    // Golden ratios spread the cells.
    let cells: [(DVec3, f64); 11] = std::array::from_fn(|index| {
        let at = |ratio: f64| 0.15 + 0.7 * (ratio * (index + 1) as f64).fract();
        let share = DVec3::new(at(0.819_172_5), at(0.671_043_6), at(0.549_700_5));
        (min + size_m * share, 40.0 + 3.0 * index as f64)
    });
    let drops = |point: DVec3| {
        let depth = |(middle, width): &(DVec3, f64)| {
            (-0.5 * point.distance_squared(*middle) / (width * width)).exp()
        };
        let wet: f64 = cells.iter().map(depth).sum();
        // Below a hundredth there is nothing: the cells stay apart.
        let wet = (wet - 0.01).max(0.0);
        Drops {
            number_density_m3: (800.0 * wet) as f32,
            effective_radius_m: (3e-4 + 6e-4 * wet.min(1.0)) as f32,
            effective_variance: if wet > 0.0 { 1.0 / 3.0 } else { 0.0 },
        }
    };
    Scene {
        camera: camera(60.0, [1920, 1080]),
        fov_deg: 60.0,
        bricks: bricks(&grid, drops),
        sun_voxel_m: voxel_m,
        radii_um: (295.0, 905.0),
        variances: (0.33, 0.36),
    }
}

/// Time of a piece of work.
struct Time {
    wall: Duration,
    /// Of all processors together.
    processors: Duration,
}

/// The round of least processor time.
fn least<T>(mut work: impl FnMut() -> T) -> Time {
    least_of(|| (), |()| work())
}

/// The same of work on what is made ready before its time is taken.
fn least_of<P, T>(mut prepare: impl FnMut() -> P, mut work: impl FnMut(P) -> T) -> Time {
    let round = |_| {
        let prepared = black_box(prepare());
        let (started, before) = (Instant::now(), own_time());
        let made = black_box(work(prepared));
        let (wall, after) = (started.elapsed(), own_time());
        drop(made);
        let processors = after.saturating_sub(before);
        Time { wall, processors }
    };
    let least = (0..ROUNDS).map(round).min_by_key(|time| time.processors);
    least.expect("there is more than one round")
}

/// Processor time of all threads so far.
fn own_time() -> Duration {
    let usage = getrusage(UsageWho::RUSAGE_SELF).expect("a process knows its own use");
    processor_time(&usage)
}

fn print_time(name: &str, time: &Time) {
    let (wall, processors) = (time.wall.as_secs_f64(), time.processors.as_secs_f64());
    let busy = processors / wall;
    println!("  {name:44} {wall:7.3} s, {processors:7.3} s of {busy:.2} processors");
}
