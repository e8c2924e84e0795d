//! Small scenes for the tests of the ray integral.
#![allow(dead_code, reason = "each test target uses a part of it")]

use std::ops::Range;

use glam::DVec2;
use glam::DVec3;
use ndarray::Array2;
use ndarray::Array5;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::DensityLaw;
use niji_exchange::DiffuseLight;
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
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::RenderLevels;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::SkyModel;
use niji_render::Toggle;
use niji_render::WaterSurface;
use niji_render::render;

/// Radius of all drops of homogeneous volumes [m].
pub(crate) const RADIUS_M: f64 = 1e-4;

/// Three wavelengths.
pub(crate) fn wavelengths() -> WavelengthGrid {
    WavelengthGrid::new(450.0, 100.0, 3).unwrap()
}

/// Irradiance of the sun in every test [W m^-2 nm^-1].
pub(crate) const SUN: [f64; 3] = [2.0, 1.5, 1.0];

/// Number density with an extinction of 1/m at Q = 1.
pub(crate) fn number_density_m3(extinction_m1_q1: f64) -> f32 {
    (extinction_m1_q1 / (std::f64::consts::PI * RADIUS_M * RADIUS_M)) as f32
}

/// Drops of one size.
pub(crate) fn drops(extinction_m1_q1: f64) -> Drops {
    let number_density_m3 = number_density_m3(extinction_m1_q1);
    Drops {
        number_density_m3,
        effective_radius_m: RADIUS_M as f32,
        effective_variance: 0.0,
    }
}

/// Drops in a box, by their extinction at Q = 1 at a point.
pub(crate) fn bricks(grid: &GridBox, extinction_m1_q1: impl Fn(DVec3) -> f64 + Sync) -> Bricks {
    let mode = DropMode::from_fn("", grid, |point| drops(extinction_m1_q1(point))).unwrap();
    Bricks::build(&mode, Interpolation::Moments).unwrap()
}

/// A slab of depth 1 over `n` voxels up to y = 1, so wide towards a sun in the south that all its light comes
/// in through the top.
pub(crate) fn flat_topped_slab(zenith_deg: f64, n: u32) -> GridBox {
    let voxel_m = 1.0 / f64::from(n);
    let reach_m = zenith_deg.to_radians().tan() + 1.0;
    GridBox {
        min: DVec3::new(-2.0 * voxel_m, 0.0, -2.0 * voxel_m),
        max: DVec3::new(2.0 * voxel_m, 1.0, reach_m),
        voxel_m,
    }
}

/// One ray straight down on it.
pub(crate) fn from_above(slab: &GridBox) -> Camera {
    let eye = DVec3::new(0.3 * slab.voxel_m, 5.0, 0.2 * slab.voxel_m);
    camera(eye, (0.0, -90.0), 1e-3, (1, 1))
}

/// A camera at `position` that looks towards `azimuth`, `elevation` [deg].
pub(crate) fn camera(
    position: DVec3,
    look_deg: (f64, f64),
    fov_deg: f64,
    size: (u32, u32),
) -> Camera {
    let camera = PinholeCamera::new(PinholeRequest {
        position,
        azimuth: Radians::from_degrees(look_deg.0),
        elevation: Radians::from_degrees(look_deg.1),
        roll: Radians(0.0),
        horizontal_fov: Radians::from_degrees(fov_deg),
        width_px: size.0,
        height_px: size.1,
    });
    camera.unwrap().into()
}

/// One ray to the north.
pub(crate) fn one_ray(position: DVec3) -> Camera {
    camera(position, (0.0, 0.0), 1e-3, (1, 1))
}

/// Towards a sun in the south at `elevation_deg`.
pub(crate) fn sun_in_the_south(elevation_deg: f64) -> DVec3 {
    let (sin, cos) = elevation_deg.to_radians().sin_cos();
    DVec3::new(0.0, sin, cos)
}

/// A table of one size by a function of wavelength and angle [1/sr].
pub(crate) fn table(value: impl Fn(usize, f64) -> f64) -> ScatteringTable {
    sized_table(&[1e6 * RADIUS_M], |_, wavelength, theta| {
        value(wavelength, theta)
    })
}

/// A table by a function of radius [um], wavelength index and angle, of ten nodes a degree.
pub(crate) fn sized_table(
    radii_um: &[f64],
    value: impl Fn(f64, usize, f64) -> f64,
) -> ScatteringTable {
    table_of(radii_um, 10.0, value)
}

/// The same of as many nodes a degree.
pub(crate) fn table_of(
    radii_um: &[f64],
    nodes_per_deg: f64,
    value: impl Fn(f64, usize, f64) -> f64,
) -> ScatteringTable {
    let n_steps = (180.0 * nodes_per_deg).round() as i32;
    let theta_rad: Vec<f64> = (0..=n_steps)
        .map(|step| (f64::from(step) / nodes_per_deg).to_radians())
        .collect();
    let values = Array5::from_shape_fn(
        (2, radii_um.len(), 1, 3, theta_rad.len()),
        |(j, r, _, w, a)| ([0.5, 1.5][j] * value(radii_um[r], w, theta_rad[a])) as f32,
    );
    ScatteringTable {
        theory: "test".into(),
        orders: "all".into(),
        wavelengths: wavelengths(),
        theta_rad,
        effective_radius_um: radii_um.to_vec(),
        effective_variance: vec![0.0],
        moved: None,
        row_use: RowUse::Laws,
        relative_error: 5e-3,
        values,
        sun_disc_diameter_rad: 0.0,
        split_theta_rad: 130_f64.to_radians(),
        forward_fraction_left_out: 0.0,
        water: Water::pure(20.0),
        phase_functions: None,
        interpolation_error: None,
    }
}

/// The same in all directions and at all wavelengths [1/sr].
pub(crate) fn isotropic(value_sr1: f64) -> ScatteringTable {
    table(|_, _| value_sr1)
}

/// A part of a picture of 40 x 27 pixels or more that touches none of its sides.
pub(crate) const OFF_CENTER: PixelRegion = PixelRegion {
    x_px: 11,
    y_px: 9,
    width_px: 17,
    height_px: 7,
};

/// Its rows and columns in the whole picture.
pub(crate) fn off_center() -> (Range<i32>, Range<i32>) {
    let range = |first: i32, n: u32| first..first + n as i32;
    (
        range(OFF_CENTER.y_px, OFF_CENTER.height_px),
        range(OFF_CENTER.x_px, OFF_CENTER.width_px),
    )
}

/// Air of constant density up to 100 km over a planet like the Earth.
pub(crate) fn air(extinction_m1: [f64; 3], scattering_m1: [f64; 3]) -> AtmosphereTable {
    AtmosphereTable {
        planet_radius_m: 6_371_000.0,
        top_height_m: 100_000.0,
        wavelengths: wavelengths(),
        sun_irradiance: SUN.to_vec(),
        ground_albedo: vec![0.3; 3],
        constituents: vec![AirConstituent {
            name: "even".into(),
            extinction_m1: extinction_m1.to_vec(),
            scattering_m1: scattering_m1.to_vec(),
            law: DensityLaw::Linear,
            height_m: vec![0.0, 100_000.0],
            density: vec![1.0, 1.0],
            reach_height_m: Vec::new(),
            reach_mu: Vec::new(),
            reach_m: Array2::zeros((0, 0)),
            phase_angle_rad: vec![0.0, std::f64::consts::PI],
            phase_sr1: Array2::from_elem((3, 2), 0.25 * std::f64::consts::FRAC_1_PI),
        }],
        diffuse: None,
    }
}

/// Diffuse light of radiance `radiance` from all directions, everywhere.
pub(crate) fn uniform_light(radiance: f32) -> DiffuseLight {
    let pi = std::f32::consts::PI;
    // X_00 = 4 pi L, all others 0 up to degree 1; at each of 2 heights and 2 suns.
    let node = [4.0 * pi * radiance, 0.0, 0.0].map(|moment| [moment; 3]);
    let moments = [node; 4].into_iter().flatten().flatten().collect();
    DiffuseLight {
        height_m: vec![0.0, 1e5],
        sun_zenith_rad: vec![0.0, std::f64::consts::PI],
        max_degree: 1,
        moments,
        on_ground: vec![pi * radiance; 6],
        phase_moments: [[1.0_f32; 3], [0.0; 3]].concat(),
    }
}

/// Cell-exact, no air to speak of, pixel centers.
pub(crate) fn levels() -> RenderLevels {
    RenderLevels {
        integration: Integration::CellExact,
        drop_extinction_model: DropExtinctionModel::WithoutDiffraction,
        drop_orders: DropOrders::SingleScattering,
        air_path: AirPath::Table,
        sky_model: SkyModel::SingleScattering,
        pixel_footprint: PixelFootprint::Center,
    }
}

/// Bows and drop extinction.
pub(crate) fn with_extinction() -> RenderEffects {
    RenderEffects {
        drop_extinction: Toggle::On,
        ..RenderEffects::BOWS_ONLY
    }
}

/// Bows, drop extinction and shadow.
pub(crate) fn with_shadow() -> RenderEffects {
    RenderEffects {
        drop_shadow: Toggle::On,
        ..with_extinction()
    }
}

/// Light of sky and air, and what the air takes, without bows.
pub(crate) fn with_air_light() -> RenderEffects {
    RenderEffects {
        primary_bow: Toggle::Off,
        secondary_bow: Toggle::Off,
        sky: Toggle::On,
        air_extinction: Toggle::On,
        air_inscatter: Toggle::On,
        ..with_extinction()
    }
}

/// Phase function of isotropic drops in pictures of shadows [1/sr].
pub(crate) const SHADED_SR1: f64 = 0.05;

/// A picture of isotropic drops in which nothing but the sun's path errs.
pub(crate) fn shaded(drops: &LitDrops, sun: DVec3, camera: &Camera) -> Rendered {
    let table = isotropic(SHADED_SR1);
    let mut request = request(camera, sun, drops, &table);
    request.effects = with_shadow();
    request.levels.integration = Integration::Adaptive {
        relative_error: 1e-6,
    };
    rendered(&request)
}

/// A request of bows in a vacuum.
pub(crate) fn request<'a>(
    camera: &'a Camera,
    sun_direction: DVec3,
    drops: &'a LitDrops,
    table: &'a ScatteringTable,
) -> RenderRequest<'a> {
    RenderRequest {
        camera,
        region: PixelRegion::frame(camera.width_px(), camera.height_px()),
        sun_direction,
        wavelengths: wavelengths(),
        sun_irradiance: &SUN,
        drops,
        table: Some(table),
        air: None,
        surfaces: None,
        water: None,
        effects: RenderEffects::BOWS_ONLY,
        tolerance_cd_m2: None,
        orders_error_cd_m2: None,
        coarser_rays: 1.0,
        levels: levels(),
    }
}

/// The picture, which never holds NaN, infinities or negative light.
pub(crate) fn rendered(request: &RenderRequest) -> Rendered {
    let picture = render(request, &|_| ()).unwrap();
    let planes = [
        &picture[PictureLayer::BowPrimary],
        &picture[PictureLayer::BowSecondary],
        &picture[PictureLayer::Inscatter],
    ];
    for value in picture.radiance.iter().chain(planes.into_iter().flatten()) {
        assert!(value.is_finite() && *value >= -1e-30, "{value}");
    }
    for layer in [
        PictureLayer::Transmittance,
        PictureLayer::TauSun,
        PictureLayer::Depth,
        PictureLayer::Error,
    ] {
        let plane = &picture[layer];
        assert!(plane.iter().all(|value| value.is_finite() && *value >= 0.0));
    }
    picture
}

/// Relative difference.
pub(crate) fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

/// Water without a shore.
pub(crate) fn endless(slope: f64) -> WaterSurface {
    WaterSurface {
        height_m: 0.0,
        extent_m: [DVec2::NEG_INFINITY, DVec2::INFINITY],
        slope,
        water: Water::pure(15.0),
    }
}
