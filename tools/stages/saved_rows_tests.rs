//! A render that was interrupted, at any row, goes on to the picture of one that was not.

use std::io::Cursor;
use std::ops::ControlFlow;
use std::sync::Mutex;

use glam::DVec3;
use ndarray::Array5;
use ndarray::Axis;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_exchange::Aov;
use niji_exchange::Attributes;
use niji_exchange::ImageWindows;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use niji_exchange::Spectra;
use niji_geometry::Camera;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_render::AirPath;
use niji_render::Deadline;
use niji_render::DropExtinctionModel;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::RenderLevels;
use niji_render::SkyModel;
use niji_render::SunPath;

use super::*;

const WIDTH: u32 = 3;
const HEIGHT: u32 = 140;

/// Save whenever rows are finished.
const ALWAYS: Saving = Saving {
    every_s: 0.0,
    most_cost: f64::INFINITY,
};
const NEVER: Saving = Saving {
    every_s: f64::INFINITY,
    most_cost: 0.0,
};

/// A bright cloud of drops before the camera.
struct World {
    folder: tempfile::TempDir,
    camera: Camera,
    drops: LitDrops,
    table: ScatteringTable,
}

impl World {
    fn new() -> Self {
        let grid = GridBox {
            min: DVec3::new(-20.0, -60.0, -60.0),
            max: DVec3::new(20.0, 60.0, -40.0),
            voxel_m: 5.0,
        };
        let mode = DropMode::from_fn("", &grid, |point| Drops {
            number_density_m3: (1e5 * (2.0 + (0.3 * point.y).sin())) as f32,
            effective_radius_m: 1e-4,
            effective_variance: 0.0,
        });
        let bricks = Bricks::build(&mode.unwrap(), Interpolation::Moments).unwrap();
        let camera = PinholeCamera::new(PinholeRequest {
            position: DVec3::ZERO,
            azimuth: Radians(0.0),
            elevation: Radians(0.0),
            roll: Radians(0.0),
            horizontal_fov: Radians::from_degrees(1.0),
            width_px: WIDTH,
            height_px: HEIGHT,
        });
        let theta_rad: Vec<f64> = (0..=180).map(|deg| f64::from(deg).to_radians()).collect();
        let values = |(_, _, _, wavelength, angle): (usize, usize, usize, usize, usize)| {
            (1.0 + wavelength as f32) * (1.0 + angle as f32)
        };
        Self {
            folder: tempfile::tempdir().unwrap(),
            camera: camera.unwrap().into(),
            drops: LitDrops::new(vec![bricks], DVec3::Z, SunPath::Ignore).unwrap(),
            table: ScatteringTable {
                theory: "test".into(),
                orders: "all".into(),
                wavelengths: WavelengthGrid::new(500.0, 50.0, 2).unwrap(),
                values: Array5::from_shape_fn((2, 1, 1, 2, theta_rad.len()), values),
                theta_rad,
                effective_radius_um: vec![100.0],
                effective_variance: vec![0.0],
                moved: None,
                row_use: RowUse::Laws,
                relative_error: 5e-3,
                sun_disc_diameter_rad: 0.0,
                split_theta_rad: 2.0,
                forward_fraction_left_out: 0.0,
                water: Water::pure(20.0),
                phase_functions: None,
                interpolation_error: None,
            },
        }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("image.exr")
    }

    /// Renders with one thread; the bytes of the image, and how many pixels were not rendered again.
    fn render(&self, settings: &str, saving: Saving) -> (Vec<u8>, u64) {
        self.render_to(&self.path(), (settings, saving))
    }

    fn render_to(&self, to: &Path, (settings, saving): (&str, Saving)) -> (Vec<u8>, u64) {
        let done = Mutex::new(Vec::new());
        let work = Work {
            request: RenderRequest {
                camera: &self.camera,
                region: PixelRegion::frame(WIDTH, HEIGHT),
                sun_direction: DVec3::Z,
                wavelengths: self.table.wavelengths,
                sun_irradiance: &[1.0, 2.0],
                drops: &self.drops,
                table: Some(&self.table),
                air: None,
                surfaces: None,
                water: None,
                effects: RenderEffects::BOWS_ONLY,
                levels: RenderLevels {
                    integration: Integration::CellExact,
                    drop_extinction_model: DropExtinctionModel::WithoutDiffraction,
                    drop_orders: DropOrders::SingleScattering,
                    air_path: AirPath::Table,
                    sky_model: SkyModel::None,
                    pixel_footprint: PixelFootprint::Center,
                },
                tolerance_cd_m2: None,
                orders_error_cd_m2: None,
                coarser_rays: 1.0,
            },
            provenance: Provenance {
                tool: "niji render".to_owned(),
                settings: settings.to_owned(),
                ..Provenance::default()
            },
            image: &image,
            progress: &|n_pixels| {
                done.lock().unwrap().push(n_pixels);
                ControlFlow::Continue(())
            },
            deadline: Deadline::NEVER,
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let mut bytes = Cursor::new(Vec::new());
        let region = work.request.region;
        let head = PictureHead::new(PictureFile::Spectral, region, work.provenance.clone());
        let mut file = StripWriter::new(head, &mut bytes);
        let mut take = |rows: &SpectralImage| {
            assert!(rows.radiance.iter().all(|value| *value > 0.0));
            file.add(rows).unwrap();
            ControlFlow::Continue(())
        };
        let pool = pool.unwrap();
        let spent = pool.install(|| render(&work, to, (saving, &mut take)));
        let done = done.into_inner().unwrap();
        assert_eq!(done.iter().sum::<u64>(), u64::from(WIDTH * HEIGHT));
        assert_eq!(spent.unwrap().is_some(), done[0] == 0, "nothing was found");
        file.finish().unwrap();
        (bytes.into_inner(), done[0])
    }

    fn saved(&self) -> Vec<PathBuf> {
        files(&folder(&self.path()))
    }
}

fn image(rendered: Rendered, region: PixelRegion, provenance: Provenance) -> SpectralImage {
    // Files hold channels in another order.
    let layer = |name: &str, layers: [PictureLayer; 2]| Aov {
        name: name.to_owned(),
        unit: "-".to_owned(),
        channels: ["Y", "A"]
            .map(str::to_owned)
            .into_iter()
            .zip(layers.map(|layer| rendered[layer].index_axis(Axis(0), 0).to_owned()))
            .collect(),
    };
    SpectralImage {
        wavelengths: WavelengthGrid::new(500.0, 50.0, 2).unwrap(),
        aovs: vec![
            layer("depth", [PictureLayer::Depth, PictureLayer::Transmittance]),
            layer("error", [PictureLayer::Error, PictureLayer::TauSun]),
        ],
        radiance: rendered.radiance,
        spectra: Spectra::Full,
        windows: ImageWindows {
            data: region,
            display: PixelRegion::frame(WIDTH, HEIGHT),
        },
        white_luminance_cd_m2: 1.0,
        world_to_camera: None,
        attributes: Attributes::new(),
        provenance,
    }
}

#[test]
fn an_interrupted_render_goes_on_to_the_picture_of_an_uninterrupted_one() {
    let world = World::new();
    let (expected, _) = world.render("{}", NEVER);
    assert!(world.saved().is_empty());
    let (while_saving, n_kept) = world.render("{}", ALWAYS);
    assert!(while_saving == expected && n_kept == 0);
    let all = world.saved();
    assert!(all.len() >= 3, "{all:?}");
    // As if it had been killed after each of them.
    for n_saved in (1..=all.len()).rev() {
        for later in &all[n_saved..] {
            let _ = fs::remove_file(later);
        }
        let (resumed, n_kept) = world.render("{}", NEVER);
        assert!(resumed == expected, "{n_saved} files");
        assert!(n_kept > 0 && n_kept < u64::from(WIDTH * HEIGHT));
    }
    clear(&world.path());
    assert!(!folder(&world.path()).exists());
}

#[test]
fn rows_of_each_instant_of_a_mean_are_found_again_and_go_with_the_image() {
    let world = World::new();
    let (expected, _) = world.render("{}", NEVER);
    let instants = [0, 12].map(|place| at_instant(&world.path(), place));
    for instant in &instants {
        world.render_to(instant, ("{}", ALWAYS));
    }
    fs::remove_file(files(&folder(&instants[1])).pop().unwrap()).unwrap();
    let (resumed, n_kept) = world.render_to(&instants[1], ("{}", NEVER));
    assert!(resumed == expected && n_kept > 0);
    clear(&world.path());
    assert!(!folder(&world.path()).exists());
}

#[test]
fn rows_are_saved_below_those_that_were_found() {
    let world = World::new();
    let (expected, _) = world.render("{}", ALWAYS);
    let all = world.saved();
    for later in &all[1..] {
        fs::remove_file(later).unwrap();
    }
    let (resumed, kept) = world.render("{}", ALWAYS);
    assert!(resumed == expected && kept > 0);
    let (again, kept_then) = world.render("{}", NEVER);
    assert!(again == expected && kept_then > kept);
}

#[test]
fn damaged_missing_and_foreign_rows_are_rendered_again() {
    let world = World::new();
    let (expected, _) = world.render("{}", ALWAYS);
    let all = world.saved();
    let (_, kept) = world.render("{\"other\":1}", NEVER);
    assert_eq!(kept, 0, "rows of another picture were taken");
    let bytes = fs::read(&all[1]).unwrap();
    fs::write(&all[1], &bytes[..bytes.len() - 9]).unwrap();
    let (resumed, kept_before) = world.render("{}", NEVER);
    assert!(resumed == expected && kept_before > 0);
    fs::remove_file(&all[0]).unwrap();
    let (resumed, kept) = world.render("{}", NEVER);
    assert!(resumed == expected && kept == 0);
}

#[test]
fn saving_waits_until_it_is_worth_its_price() {
    let world = World::new();
    world.render("{}", Saving::STANDARD);
    assert!(world.saved().is_empty());
    let dear = Saving {
        every_s: 0.0,
        most_cost: 0.0,
    };
    world.render("{}", dear);
    assert!(world.saved().is_empty());
}
