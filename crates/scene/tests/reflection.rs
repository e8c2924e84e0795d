//! Water that mirrors the sun, in scenes and plans.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod support;

use std::f64::consts::PI;

use glam::DVec3;
use ndarray::Array2;
use ndarray::Axis;
use niji_airy::AiryTable;
use niji_dropfield::Bricks;
use niji_exchange::ScatteringTable;
use niji_geometry::Aabb;
use niji_geometry::Camera;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_geometry::PixelRegion;
use niji_geometry::Ray;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_radiometry::solar_irradiance;
use niji_render::LitDrops;
use niji_render::MirroredLight;
use niji_render::RenderRequest;
use niji_render::render;
use niji_scatter::scattering_table;
use niji_scatter::unwatched;
use niji_scene::BoundKind;
use niji_scene::Effect;
use niji_scene::Plan;
use niji_scene::Scene;
use niji_scene::Switch;
use support::planned;

const LAKE: &str = include_str!("../../../data/scenes/reflection-bow.toml");

/// The section of the scene, and the scene without it.
fn without_water() -> (String, String) {
    let start = LAKE.find("[water_surface]").unwrap();
    let end = LAKE.find("[air]").unwrap();
    (
        LAKE[start..end].to_string(),
        format!("{}{}", &LAKE[..start], &LAKE[end..]),
    )
}

fn with_water(section: &str) -> String {
    without_water().1 + "\n[water_surface]\n" + section + "\n"
}

#[test]
fn the_bow_of_the_lake_is_simulated_and_its_angles_are_in_the_table() {
    let mut scene = Scene::from_toml(LAKE).unwrap();
    // Where the lake is seen the same light comes by two ways, whose sum nothing proves.
    let seen = planned(&scene).bound(Effect::ReflectionBow).unwrap().kind;
    assert_eq!(seen, BoundKind::Estimated);
    scene.effects.set(Effect::SeenWater, Switch::Off);
    let plan = planned(&scene);
    let bound = plan.bound(Effect::ReflectionBow).unwrap();
    assert!(plan.is_on(Effect::ReflectionBow) && bound.kind == BoundKind::Proved);
    assert_eq!(plan.mirrored_light(), Some(MirroredLight::Polarized));
    // No more than Fresnel's reflectance of horizontal light, 0.40 at 12 degrees and the waves' 2 % more.
    let primary = plan.bound(Effect::PrimaryBow).unwrap();
    let share = bound.value / primary.value;
    assert!((0.1..0.45).contains(&share), "{share}");
    let angles = plan.scattering.unwrap().theta_range_rad;
    let dry = planned(&Scene::from_toml(&without_water().1).unwrap());
    let of_sun = dry.scattering.as_ref().unwrap().theta_range_rad;
    // Below the point opposite the sun in the water there is more of its light than of the sun's.
    assert!(
        angles.1 > of_sun.1 && angles.0 <= of_sun.0,
        "{angles:?} {of_sun:?}"
    );
    assert!(!dry.is_on(Effect::ReflectionBow) && dry.mirrored_light().is_none());
    assert_eq!(dry.bound(Effect::ReflectionBow).unwrap().value, 0.0);
}

#[test]
fn water_that_shows_no_sun_adds_nothing() {
    for sun in ["elevation_deg = -3.0", "elevation_deg = 0.0"] {
        let text = LAKE.replace("elevation_deg = 12.0", sun);
        let plan = planned(&Scene::from_toml(&text).unwrap());
        assert!(!plan.is_on(Effect::ReflectionBow), "{sun}");
        assert_eq!(plan.bound(Effect::ReflectionBow).unwrap().value, 0.0);
    }
    let mut scene = Scene::from_toml(LAKE).unwrap();
    scene.effects.set(Effect::ReflectionBow, Switch::Off);
    assert!(planned(&scene).mirrored_light().is_none());
}

#[test]
fn a_scene_may_leave_out_the_polarization() {
    let text = LAKE.replace("[accuracy]", "[accuracy]\nmirrored_light = \"natural\"");
    let plan = planned(&Scene::from_toml(&text).unwrap());
    assert_eq!(plan.mirrored_light(), Some(MirroredLight::Natural));
    let names = plan.levels.named();
    let said = ("mirrored_light".to_string(), "natural".to_string());
    assert!(names.contains(&said), "{names:?}");
}

#[test]
fn waves_follow_from_the_wind_where_no_slope_is_given() {
    let slope = |section: &str| {
        let scene = Scene::from_toml(&with_water(section)).unwrap();
        scene.water_surface.unwrap().surface().slope
    };
    // Cox and Munk: half of 0.003 + 0.00512 U along each axis.
    assert!((slope("") - 0.0015_f64.sqrt()).abs() < 1e-12);
    assert!((slope("wind_speed_m_s = 5.0") - 0.0143_f64.sqrt()).abs() < 1e-12);
    assert_eq!(slope("slope = 0.0"), 0.0);
}

#[test]
fn bad_water_is_refused_with_the_key_to_change() {
    let (section, _) = without_water();
    let line = |key: &str| section.lines().position(|line| line.contains(key));
    assert!(line("extent_min_m").is_some());
    for (section, expected) in [
        (
            "slope = 0.5",
            "`water_surface.slope` is 0.5, expected 0 to 0.35",
        ),
        (
            "slope = 0.1\nwind_speed_m_s = 3.0",
            "`water_surface.wind_speed_m_s` is 3, expected either a slope or a wind speed",
        ),
        (
            "extent_min_m = [0.0, 0.0]",
            "`water_surface` is one of them, expected both extent_min_m and extent_max_m, or neither",
        ),
        (
            "extent_min_m = [0.0, 5.0]\nextent_max_m = [9.0, 4.0]",
            "expected at least extent_min_m, [0.0, 5.0]",
        ),
        ("salinity_per_mille = 35.0\ntemperature_c = 80.0", "water"),
        ("depth_m = 3.0", "unknown key `depth_m`"),
    ] {
        let error = Scene::from_toml(&with_water(section)).unwrap_err();
        let error = error.to_string();
        assert!(error.contains(expected), "{error}");
    }
    let dry = without_water()
        .1
        .replace("[effects]", "[effects]\nreflection_bow = \"on\"");
    let error = Scene::from_toml(&dry).unwrap_err().to_string();
    assert!(
        error.contains("without a [water_surface] section"),
        "{error}"
    );
}

/// Spheres of 0.4 mm around the eye, half of them above still water; neither air nor shade.
const SPHERES: &str = r#"format = 1
name = "spheres"
[sun]
elevation_deg = SUN
azimuth_deg = 180.0
[camera]
position_m = [0.0, 2.0, 0.0]
azimuth_deg = 0.0
elevation_deg = 20.0
horizontal_fov_deg = 120.0
width_px = 40
height_px = 40
[spectrum]
first_nm = 450
step_nm = 50
n_wavelengths = 5
[drops]
shape = "uniform"
box_min_m = [-700.0, -300.0, -500.0]
box_max_m = [700.0, 900.0, -100.0]
voxel_m = 50.0
law = { hansen-travis = { effective_radius_um = 400.0, effective_variance = 0.01 } }
number_density_m3 = 100.0
[water_surface]
slope = 0.0
[effects]
drop_flattening = "off"
drop_extinction = "off"
drop_shadow = "off"
secondary_bow = "off"
higher_orders = "off"
"#;

/// What is rendered of the spheres.
struct Spheres {
    scene: Scene,
    plan: Plan,
    table: ScatteringTable,
    drops: [LitDrops; 2],
}

impl Spheres {
    fn new(sun_deg: f64) -> Self {
        Self::of(&SPHERES.replace("SUN", &sun_deg.to_string()))
    }

    /// The drops of a scene.
    fn of(text: &str) -> Self {
        let mut scene = Scene::from_toml(text).unwrap();
        scene.effects.set(Effect::ReflectionBow, Switch::On);
        let plan = planned(&scene);
        let grid = scene.spectrum;
        let need = plan.scattering.as_ref().unwrap();
        let airy = AiryTable::compute();
        let table = scattering_table(&need.request(grid, Some(&airy)), &unwatched).unwrap();
        let volume = scene.drops.shape().unwrap().volume().unwrap();
        let build = |mode| Bricks::build(mode, plan.levels.interpolation).unwrap();
        let bricks = volume.modes.iter().map(build).collect();
        let sun = scene.sun.direction();
        let dry = LitDrops::new(bricks, sun, plan.sun_path()).unwrap();
        let water = scene.water_surface.unwrap().surface();
        let light = plan.mirrored_light().unwrap();
        let wet = dry.clone().beside_water(water, light, sun).unwrap();
        Self {
            drops: [dry, wet],
            scene,
            plan,
            table,
        }
    }

    /// Green radiance of both bows around a direction, which is in the middle.
    fn seen(&self, direction: DVec3, size: (f64, u32)) -> [Array2<f32>; 2] {
        let sun = self.scene.sun.direction();
        let picture = |drops: &LitDrops| self.picture((drops, sun), (direction, size));
        let [dry, wet] = self.drops.each_ref().map(picture);
        let mirrored = &wet - &dry;
        [dry, mirrored]
    }

    /// Green radiance under a sun.
    fn picture(
        &self,
        (drops, sun_direction): (&LitDrops, DVec3),
        (direction, (fov_deg, n_px)): (DVec3, (f64, u32)),
    ) -> Array2<f32> {
        let grid = self.scene.spectrum;
        let request = RenderRequest {
            camera: &camera(direction, (fov_deg, n_px)),
            region: PixelRegion::frame(n_px, n_px),
            sun_direction,
            wavelengths: grid,
            sun_irradiance: &solar_irradiance(&grid),
            drops,
            table: Some(&self.table),
            surfaces: None,
            water: None,
            air: None,
            effects: self.plan.render_effects(),
            tolerance_cd_m2: None,
            orders_error_cd_m2: None,
            coarser_rays: 1.0,
            levels: self.plan.levels.render_levels(),
        };
        let rendered = render(&request, &|_| ()).unwrap();
        rendered.radiance.index_axis(Axis(0), GREEN).to_owned()
    }

    /// Way of a ray through the drops, m.
    fn chord_m(&self, direction: DVec3) -> f64 {
        let grid = self.scene.drops.shape().unwrap().grid();
        let bounds = Aabb {
            min: grid.min,
            max: grid.max,
        };
        let ray = Ray {
            origin: EYE,
            direction,
        };
        let (enter_m, leave_m) = bounds.intersect(&ray).unwrap();
        leave_m - enter_m
    }

    /// Peak of the green bow: scattering angle, and degree of polarization there.
    fn peak(&self) -> (f64, f64) {
        let light = |angle: usize| {
            let [s, p] = [0, 1].map(|j| self.table.values[[j, 0, 0, GREEN, angle]]);
            (f64::from(s + p), f64::from((s - p) / (s + p)))
        };
        let angles = 0..self.table.theta_rad.len();
        let brightest = angles.max_by(|a, b| light(*a).0.total_cmp(&light(*b).0));
        let brightest = brightest.unwrap();
        (self.table.theta_rad[brightest], light(brightest).1)
    }
}

const EYE: DVec3 = DVec3::new(0.0, 2.0, 0.0);

/// Place of 550 nm among the wavelengths.
const GREEN: usize = 2;

fn camera(direction: DVec3, (fov_deg, n_px): (f64, u32)) -> Camera {
    let camera = PinholeCamera::new(PinholeRequest {
        position: EYE,
        azimuth: Radians(direction.x.atan2(-direction.z)),
        elevation: Radians(direction.y.asin()),
        roll: Radians(0.0),
        horizontal_fov: Radians::from_degrees(fov_deg),
        width_px: n_px,
        height_px: n_px,
    });
    camera.unwrap().into()
}

/// A direction around an axis: angle from it and clock angle from the top, rad.
fn around(axis: DVec3, from_axis_rad: f64, clock_rad: f64) -> DVec3 {
    let right = axis.cross(DVec3::Y).normalize();
    let up = right.cross(axis);
    axis * from_axis_rad.cos()
        + (right * clock_rad.sin() + up * clock_rad.cos()) * from_axis_rad.sin()
}

#[test]
fn the_bow_stands_as_high_as_the_sun_and_is_as_bright_as_the_water_makes_it() {
    for sun_deg in [6.0, 15.0_f64] {
        let spheres = Spheres::new(sun_deg);
        let sun = spheres.scene.sun.direction();
        let opposite = [-sun, DVec3::new(-sun.x, sun.y, -sun.z)];
        let (theta_rad, degree) = spheres.peak();
        let bow_rad = PI - theta_rad;
        // Fresnel's sine and tangent laws.
        let index = Water::pure(15.0).refractive_index(Nanometers(550.0));
        let incidence = (90.0 - sun_deg).to_radians();
        let refraction = (incidence.sin() / index).asin();
        let (difference, sum) = (incidence - refraction, incidence + refraction);
        let s = (difference.sin() / sum.sin()).powi(2);
        let p = (difference.tan() / sum.tan()).powi(2);
        for clock_deg in [0.0, 45.0, 80.0_f64] {
            let clock_rad = clock_deg.to_radians();
            // Where the sun's own bow is above the ground as well.
            let per_meter = [0, 1].map(|which| {
                let direction = around(opposite[which], bow_rad, clock_rad);
                let seen = spheres.seen(direction, (1e-3, 1));
                f64::from(seen[which][[0, 0]]) / spheres.chord_m(direction)
            });
            let found = per_meter[1] / per_meter[0];
            let turned = degree * (2.0 * clock_rad).cos();
            let expected = 0.5 * (s * (1.0 + turned) + p * (1.0 - turned));
            let off = found / expected - 1.0;
            // The table's own interpolation and the edges of the drops.
            assert!(
                off.abs() < 0.02,
                "{sun_deg} {clock_deg}: {found} {expected}"
            );

            let direction = around(opposite[1], bow_rad, clock_rad);
            let (fov_deg, n_px) = (2.0, 101);
            let camera = camera(direction, (fov_deg, n_px));
            let seen = spheres.seen(direction, (fov_deg, n_px));
            let places = seen[1].indexed_iter();
            let brightest = places.max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
            let (y, x) = brightest.0;
            let ray = camera.ray(x as f64 + 0.5, y as f64 + 0.5).unwrap();
            let radius_rad = ray.direction.dot(opposite[1]).acos();
            let off_deg = (radius_rad - bow_rad).to_degrees();
            assert!(off_deg.abs() < 0.1, "{sun_deg} {clock_deg}: {off_deg}");
        }
    }
}

#[test]
fn flattened_drops_make_the_bow_of_a_sun_below_the_horizon() {
    let sun_deg = 15.0_f64;
    let text = SPHERES
        .replace("SUN", &sun_deg.to_string())
        .replace("drop_flattening = \"off\"", "drop_flattening = \"on\"")
        .replace("[effects]", "[accuracy]\npreset = \"draft\"\n[effects]");
    let drops = Spheres::of(&text);
    let sun = drops.scene.sun.direction();
    let water = drops.scene.water_surface.unwrap().surface();
    let [dry, _] = &drops.drops;
    let wet = dry.clone();
    let wet = wet
        .beside_water(water, MirroredLight::Natural, sun)
        .unwrap();
    let below = DVec3::new(sun.x, -sun.y, sun.z);
    // Around the top of the bow: above the water on all rays.
    let view = (around(-below, 40_f64.to_radians(), 0.2), (6.0, 24));
    let mirrored = &drops.picture((&wet, sun), view) - &drops.picture((dry, sun), view);
    let direct = drops.picture((dry, below), view);
    let index = Water::pure(15.0).refractive_index(Nanometers(550.0));
    let sine = sun_deg.to_radians().sin();
    let root = (index * index - 1.0 + sine * sine).sqrt();
    let s = ((sine - root) / (sine + root)).powi(2);
    let p = ((index * index * sine - root) / (index * index * sine + root)).powi(2);
    let brightest = direct.iter().copied().fold(0.0, f32::max);
    assert!(brightest > 0.0);
    for (mirrored, direct) in mirrored.iter().zip(&direct) {
        let expected = 0.5 * (s + p) * f64::from(*direct);
        // Differences of sums in f32.
        let off = (f64::from(*mirrored) - expected) / f64::from(brightest);
        assert!(off.abs() < 1e-5, "{mirrored} {expected}");
    }
}
