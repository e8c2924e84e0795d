//! Rain around the eye, and the tables that a plan asks for it.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_exchange::ScatteringTable;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_render::LitDrops;
use niji_render::SunPath;
use niji_scatter::DropMotion;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;
use niji_scene::Effect;
use niji_scene::Switch;
use niji_sizes::SizeMoments;

use crate::support;

/// Axis ratio and tilt of drops at rest.
pub(crate) const STILL: DropMotion = DropMotion {
    tilt_sd_deg: 0.0,
    axis_ratio_sd: 0.0,
};

/// What a plan says drops are made of.
pub(crate) const WATER: Water = Water::pure(15.0);
/// Orders of the tables.
pub(crate) const ORDERS: [u32; 2] = [2, 3];
/// Scattering angles of the tables (degrees): every one from which a bow comes.
pub(crate) const THETA_DEG: (f64, f64) = (85.0, 180.0);

/// A camera that sees the bow of drops.
const SCENE: &str = r#"format = 1
name = "rain"
[sun]
elevation_deg = 20.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 18.0
horizontal_fov_deg = 80.0
width_px = 32
height_px = 24
[spectrum]
first_nm = 550
step_nm = 10
n_wavelengths = 1
DROPS
[accuracy]
preset = "PRESET"
theory = "uniform"
"#;

/// One population.
const POPULATION: &str = r#"[[drops]]
name = "of_INDEX"
shape = "uniform"
box_min_m = [-300.0, 0.0, -400.0]
box_max_m = [300.0, 300.0, -100.0]
voxel_m = 30.0
law = { hansen-travis = { effective_radius_um = RADIUS, effective_variance = VARIANCE } }
number_density_m3 = 100.0
"#;

/// One wavelength, 550 nm.
pub(crate) fn green() -> WavelengthGrid {
    WavelengthGrid::new(550.0, 10.0, 1).unwrap()
}

/// Its refractive index there.
pub(crate) fn index_of_water() -> f64 {
    WATER.refractive_index(green().center(0))
}

/// Effective radius [µm] and variance of each population; all have the same cross-section.
#[derive(Clone, Debug)]
pub(crate) struct Rain(pub(crate) Vec<(f64, f64)>);

impl Rain {
    /// A law as a drop volume knows it.
    pub(crate) fn of(moments: &SizeMoments) -> Self {
        Self(vec![(
            moments.effective_radius().0,
            moments.effective_variance,
        )])
    }

    /// The table that a plan asks for at a preset, in green light; of spheres without a motion. Its theory is
    /// that of the reference.
    pub(crate) fn table(&self, preset: &str, motion: Option<DropMotion>) -> ScatteringTable {
        let population = |(index, (radius_um, variance)): (usize, &(f64, f64))| {
            POPULATION
                .replace("INDEX", &index.to_string())
                .replace("RADIUS", &format!("{radius_um:?}"))
                .replace("VARIANCE", &format!("{variance:?}"))
        };
        let drops: String = self.0.iter().enumerate().map(population).collect();
        let text = SCENE.replace("DROPS", &drops).replace("PRESET", preset);
        let mut scene = support::all_auto(&text);
        let flattening = motion.map_or(Switch::Off, |_| Switch::On);
        for (effect, switch) in [
            (Effect::DropFlattening, flattening),
            (Effect::PrimaryBow, Switch::On),
            (Effect::SecondaryBow, Switch::On),
            (Effect::SunDisc, Switch::On),
            (Effect::SizeSpread, Switch::On),
            (Effect::Supernumeraries, Switch::On),
        ] {
            scene.effects.set(effect, switch);
        }
        scene.drop_motion = motion.unwrap_or_default();
        let mut need = support::planned(&scene).scattering.unwrap();
        need.orders = ORDERS.into();
        need.theta_range_rad = (THETA_DEG.0.to_radians(), THETA_DEG.1.to_radians());
        assert_eq!(need.water, WATER);
        scattering_table(&need.request(green(), None), &unwatched).unwrap()
    }

    /// Drops all around the eye.
    pub(crate) fn around(&self, sun: DVec3) -> LitDrops {
        let grid = GridBox {
            min: DVec3::splat(-100.0),
            max: DVec3::splat(100.0),
            voxel_m: 50.0,
        };
        let bricks = |(radius_um, variance): &(f64, f64)| {
            let cross_section_um2 =
                radius_um * radius_um * (1.0 - variance) * (1.0 - 2.0 * variance);
            let drops = Drops {
                number_density_m3: (1e7 / cross_section_um2) as f32,
                effective_radius_m: (1e-6 * radius_um) as f32,
                effective_variance: *variance as f32,
            };
            let mode = DropMode::from_fn("", &grid, |_| drops).unwrap();
            Bricks::build(&mode, Interpolation::Moments).unwrap()
        };
        let bricks = self.0.iter().map(bricks).collect();
        LitDrops::new(bricks, sun, SunPath::Ignore).unwrap()
    }
}
