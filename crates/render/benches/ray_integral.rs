//! Time of the ray integral on two named scenes, with its error beside it.
//!
//! Camera 640 x 480, 90 degrees across, sun 20 degrees high behind it, box 400 x 150 x 200 m of
//! which the eye stands 60 m away. `homogeneous`: drops of 0.1 mm, 24000 in a cubic metre.
//! `gradient_64`: 64^3 nodes, radius 1.5 to 0.01 mm upwards, density varied, 512 sizes.
//! The table is a smooth synthetic bow; its values do not matter for time.

use std::hint::black_box;
use std::sync::LazyLock;

use divan::Bencher;
use glam::DVec3;
use ndarray::Array5;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use niji_geometry::Camera;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_geometry::PixelRegion;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
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

fn main() {
    // A filter on the command line asks for single times.
    if std::env::args()
        .skip(1)
        .all(|argument| argument.starts_with("--"))
    {
        print_errors();
    }
    divan::main();
}

const SIZES: usize = 512;

fn sun() -> DVec3 {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    DVec3::new(0.0, sin, cos)
}

fn camera() -> Camera {
    PinholeCamera::new(PinholeRequest {
        position: DVec3::new(0.0, 2.0, 0.0),
        azimuth: Radians(0.0),
        elevation: Radians::from_degrees(8.0),
        roll: Radians(0.0),
        horizontal_fov: Radians::from_degrees(90.0),
        width_px: 640,
        height_px: 480,
    })
    .expect("the camera is sound")
    .into()
}

fn table(n_sizes: usize, n_wavelengths: usize) -> ScatteringTable {
    let wavelengths = WavelengthGrid::new(420.0, 300.0 / (n_wavelengths + 1) as f64, n_wavelengths)
        .expect("the wavelengths are sound");
    let theta_rad: Vec<f64> = (0..=900)
        .map(|step| (90.0 + f64::from(step) / 10.0).to_radians())
        .collect();
    let largest_over_smallest = 1500.0 / 9.9_f64;
    let radii: Vec<f64> = match n_sizes {
        1 => vec![100.0],
        n => (0..n)
            .map(|index| 9.9 * largest_over_smallest.powf(1.001 * index as f64 / (n - 1) as f64))
            .collect(),
    };
    let shape = (2, n_sizes, 1, n_wavelengths, theta_rad.len());
    let values = Array5::from_shape_fn(shape, |(_, r, _, w, a)| {
        let off = (180.0 - theta_rad[a].to_degrees() - 41.0 - 0.02 * w as f64) / 1.5;
        let fringe = 1.0 + (off * (1.0 + radii[r] / 300.0)).cos();
        (0.01 + 0.2 * (-off * off).exp() * fringe) as f32
    });
    ScatteringTable {
        theory: "synthetic".into(),
        orders: "2,3".into(),
        wavelengths,
        theta_rad,
        effective_radius_um: radii,
        effective_variance: vec![0.0],
        moved: None,
        row_use: RowUse::Laws,
        relative_error: 5e-3,
        values,
        sun_disc_diameter_rad: 0.0093,
        split_theta_rad: 130_f64.to_radians(),
        forward_fraction_left_out: 0.5,
        water: Water::pure(20.0),
        phase_functions: None,
        interpolation_error: None,
    }
}

fn bricks(n: u32, drops: impl Fn(DVec3) -> Drops + Sync) -> Bricks {
    // A cube of n nodes a side in a box of these proportions would need anisotropic voxels; the
    // cube of the same depth is crossed by as many cells.
    let voxel_m = 200.0 / f64::from(n);
    let half = 100.0;
    let grid = GridBox {
        min: DVec3::new(-half, 0.0, -260.0),
        max: DVec3::new(half, 200.0, -60.0),
        voxel_m,
    };
    let mode = DropMode::from_fn("", &grid, drops).expect("the field is sound");
    Bricks::build(&mode, Interpolation::Moments).expect("the volume is small")
}

fn homogeneous() -> LitDrops {
    let drops = Drops {
        number_density_m3: 24000.0,
        effective_radius_m: 1e-4,
        effective_variance: 0.0,
    };
    let grid = GridBox {
        min: DVec3::new(-200.0, 0.0, -260.0),
        max: DVec3::new(200.0, 150.0, -60.0),
        voxel_m: 50.0,
    };
    let mode = DropMode::from_fn("", &grid, |_| drops).expect("the field is sound");
    let bricks = Bricks::build(&mode, Interpolation::Moments).expect("the volume is small");
    LitDrops::new(vec![bricks], sun(), SunPath::Volume { voxel_m: 12.5 }).expect("sound")
}

fn gradient_bricks(n: u32) -> Bricks {
    bricks(n, |point| {
        let up = (point.y / 200.0).clamp(0.0, 1.0);
        let radius_m = 1.5e-3 * (1.0 - up) + 1e-5 * up;
        let wave = 1.0 + 0.8 * (point.x / 23.0).sin() * (point.z / 31.0).cos();
        // Extinction of 0.7/km at Q = 1 in the mean, whatever the radius.
        let number_density_m3 = (7e-4 * wave / (std::f64::consts::PI * radius_m * radius_m)) as f32;
        let effective_radius_m = radius_m as f32;
        Drops {
            number_density_m3,
            effective_radius_m,
            effective_variance: 0.0,
        }
    })
}

fn gradient() -> LitDrops {
    let sun_path = SunPath::Volume {
        voxel_m: 200.0 / 64.0,
    };
    LitDrops::new(vec![gradient_bricks(64)], sun(), sun_path).expect("sound")
}

fn effects() -> RenderEffects {
    RenderEffects {
        drop_extinction: Toggle::On,
        drop_shadow: Toggle::On,
        ..RenderEffects::BOWS_ONLY
    }
}

fn picture(drops: &LitDrops, table: &ScatteringTable, integration: Integration) -> Rendered {
    let camera = camera();
    let irradiance = vec![1.5; table.wavelengths.len()];
    let request = RenderRequest {
        camera: &camera,
        region: PixelRegion::frame(camera.width_px(), camera.height_px()),
        sun_direction: sun(),
        wavelengths: table.wavelengths,
        sun_irradiance: &irradiance,
        drops,
        table: Some(table),
        surfaces: None,
        water: None,
        air: None,
        effects: effects(),
        tolerance_cd_m2: None,
        orders_error_cd_m2: None,
        coarser_rays: 1.0,
        levels: RenderLevels {
            integration,
            drop_extinction_model: DropExtinctionModel::WithoutDiffraction,
            drop_orders: DropOrders::SingleScattering,
            air_path: AirPath::Table,
            sky_model: SkyModel::None,
            pixel_footprint: PixelFootprint::Center,
        },
    };
    render(&request, &|_| ()).expect("the request is sound")
}

/// Relative RMSE of radiance of a level against a tight adaptive one.
fn print_errors() {
    for (name, drops, sizes) in [
        ("homogeneous", &*HOMOGENEOUS, 1_usize),
        ("gradient_64", &*GRADIENT, SIZES),
    ] {
        let table = table(sizes, 5);
        let reference = picture(
            drops,
            &table,
            Integration::Adaptive {
                relative_error: 1e-10,
            },
        );
        for integration in LEVELS {
            let found = picture(drops, &table, integration);
            let (mut error, mut norm) = (0.0, 0.0);
            for (a, b) in found.radiance.iter().zip(&reference.radiance) {
                error += f64::from(a - b).powi(2);
                norm += f64::from(*b).powi(2);
            }
            println!(
                "{name} {integration:?}: relative RMSE {:.1e}",
                (error / norm).sqrt()
            );
        }
    }
}

const LEVELS: [Integration; 4] = [
    Integration::CellExact,
    Integration::Adaptive {
        relative_error: 1e-4,
    },
    Integration::Adaptive {
        relative_error: 1e-2,
    },
    Integration::FixedStep { step_m: 3.0 },
];

static HOMOGENEOUS: LazyLock<LitDrops> = LazyLock::new(homogeneous);
static GRADIENT: LazyLock<LitDrops> = LazyLock::new(gradient);

#[divan::bench(args = [0, 1, 2, 3], sample_count = 5, sample_size = 1)]
fn homogeneous_640x480x41(bencher: Bencher, level: usize) {
    let table = table(1, 41);
    bencher.bench(|| picture(black_box(&HOMOGENEOUS), black_box(&table), LEVELS[level]));
}

#[divan::bench(args = [0, 1, 2, 3], sample_count = 3, sample_size = 1)]
fn gradient_64_640x480x41(bencher: Bencher, level: usize) {
    let table = table(SIZES, 41);
    bencher.bench(|| picture(black_box(&GRADIENT), black_box(&table), LEVELS[level]));
}

#[divan::bench(args = [1, 41, 81], sample_count = 3, sample_size = 1)]
fn gradient_64_by_wavelengths(bencher: Bencher, n_wavelengths: usize) {
    let table = table(SIZES, n_wavelengths);
    bencher.bench(|| {
        picture(
            black_box(&GRADIENT),
            black_box(&table),
            Integration::CellExact,
        )
    });
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn sun_volume_64(bencher: Bencher) {
    let sun_path = SunPath::Volume {
        voxel_m: 200.0 / 64.0,
    };
    bencher
        .with_inputs(|| vec![gradient_bricks(64)])
        .bench_values(|bricks| LitDrops::new(black_box(bricks), sun(), sun_path).expect("sound"));
}
