//! The reflection bow against closed forms: where it stands, how bright it is, what shades it.
#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::SUN;
use common::bricks;
use common::camera;
use common::endless;
use common::relative;
use common::rendered;
use common::request;
use common::sun_in_the_south;
use common::table;
use common::with_extinction;
use common::with_shadow;
use glam::DVec2;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_exchange::ScatteringTable;
use niji_geometry::Aabb;
use niji_geometry::Ray;
use niji_radiometry::Nanometers;
use niji_radiometry::Water;
use niji_render::AirPath;
use niji_render::Error;
use niji_render::LitDrops;
use niji_render::MirroredLight;
use niji_render::PictureLayer;
use niji_render::RenderEffects;
use niji_render::SunPath;
use niji_render::Toggle;
use niji_render::WaterSurface;
use niji_render::render;

/// Where the bow of the tests has its peak, scattering angle [deg], and how wide it is.
const BOW_DEG: f64 = 138.0;
const WIDTH_DEG: f64 = 0.5;

/// Degree of polarization of the bow, across the plane of scattering.
const DEGREE: f64 = 0.91;

fn bow_sr1(theta_rad: f64) -> f64 {
    0.1 * (-0.5 * ((theta_rad.to_degrees() - BOW_DEG) / WIDTH_DEG).powi(2)).exp()
}

/// A polarized bow.
fn bow_table() -> ScatteringTable {
    let mut table = table(|_, theta| bow_sr1(theta));
    for (index, sign) in [1.0, -1.0].into_iter().enumerate() {
        for ((_, _, _, angle), value) in table
            .values
            .index_axis_mut(ndarray::Axis(0), index)
            .indexed_iter_mut()
        {
            let theta_rad = (0.1 * angle as f64).to_radians();
            *value = ((1.0 + sign * DEGREE) * bow_sr1(theta_rad)) as f32;
        }
    }
    table
}

/// Drops of an extinction in a box around the surface of the water, in front of the eye.
const EXTINCTION_M1: f64 = 1e-4;

fn curtain() -> GridBox {
    GridBox {
        min: DVec3::new(-900.0, -100.0, -600.0),
        max: DVec3::new(900.0, 900.0, -100.0),
        voxel_m: 50.0,
    }
}

fn eye() -> DVec3 {
    DVec3::new(0.0, 2.0, 0.0)
}

fn beside(surface: WaterSurface, light: MirroredLight, elevation_deg: f64) -> LitDrops {
    let sun = sun_in_the_south(elevation_deg);
    let drops = LitDrops::new(
        vec![bricks(&curtain(), |_| EXTINCTION_M1)],
        sun,
        SunPath::Ignore,
    );
    let drops = drops.unwrap().beside_water(surface, light, sun);
    drops.unwrap()
}

/// A direction a bow angle from the point opposite the mirrored sun, a clock angle from the top [deg].
fn on_bow(elevation_deg: f64, bow_deg: f64, clock_deg: f64) -> DVec3 {
    let sun = sun_in_the_south(elevation_deg);
    let axis = -DVec3::new(sun.x, -sun.y, sun.z);
    let right = axis.cross(DVec3::Y).normalize();
    let up = right.cross(axis);
    let (bow, clock) = (bow_deg.to_radians(), clock_deg.to_radians());
    axis * bow.cos() + (right * clock.sin() + up * clock.cos()) * bow.sin()
}

/// Azimuth and elevation of a direction [deg].
fn look(direction: DVec3) -> (f64, f64) {
    let azimuth = direction.x.atan2(-direction.z);
    (azimuth.to_degrees(), direction.y.asin().to_degrees())
}

/// Reflected radiance along a direction at the middle wavelength.
fn reflected(drops: &LitDrops, (sun, effects): (DVec3, RenderEffects), direction: DVec3) -> f64 {
    let camera = camera(eye(), look(direction), 1e-4, (1, 1));
    let table = bow_table();
    let all = render_one(&camera, (sun, effects), (drops, &table));
    let dry = LitDrops::new(
        vec![bricks(&curtain(), |_| EXTINCTION_M1)],
        sun,
        SunPath::Ignore,
    );
    let dry = dry.unwrap();
    all - render_one(&camera, (sun, effects), (&dry, &table))
}

fn render_one(
    camera: &niji_geometry::Camera,
    (sun, effects): (DVec3, RenderEffects),
    (drops, table): (&LitDrops, &ScatteringTable),
) -> f64 {
    let mut request = request(camera, sun, drops, table);
    request.effects = effects;
    f64::from(rendered(&request).radiance[[1, 0, 0]])
}

/// R and P_w of green light at a sun, by Fresnel's sine and tangent laws.
fn mirror(elevation_deg: f64) -> (f64, f64) {
    let index = Water::pure(15.0).refractive_index(Nanometers(550.0));
    let incidence = (90.0 - elevation_deg).to_radians();
    let refraction = (incidence.sin() / index).asin();
    let s = ((incidence - refraction).sin() / (incidence + refraction).sin()).powi(2);
    let p = ((incidence - refraction).tan() / (incidence + refraction).tan()).powi(2);
    (0.5 * (s + p), (s - p) / (s + p))
}

/// Way of a ray through the drops [m].
fn chord_m(direction: DVec3) -> f64 {
    let curtain = curtain();
    let bounds = Aabb {
        min: curtain.min,
        max: curtain.max,
    };
    let ray = Ray {
        origin: eye(),
        direction,
    };
    let (enter_m, leave_m) = bounds.intersect(&ray).unwrap();
    leave_m - enter_m
}

#[test]
fn the_bow_in_mirrored_light_is_as_bright_as_fresnel_and_the_clock_angle_say() {
    for elevation_deg in [3.0, 10.0, 20.0] {
        let sun = sun_in_the_south(elevation_deg);
        let (reflectance, polarization) = mirror(elevation_deg);
        let [polarized, natural] = [MirroredLight::Polarized, MirroredLight::Natural]
            .map(|light| beside(endless(0.0), light, elevation_deg));
        for clock_deg in [0.0, 45.0, 85.0, 90.0_f64] {
            let direction = on_bow(elevation_deg, 180.0 - BOW_DEG, clock_deg);
            let at_peak = SUN[1] * EXTINCTION_M1 * chord_m(direction) * 0.1;
            let found = reflected(&polarized, (sun, RenderEffects::BOWS_ONLY), direction);
            let turned = (2.0 * clock_deg.to_radians()).cos();
            let expected = at_peak * reflectance * (1.0 + polarization * DEGREE * turned);
            // The drops' edges reach half a voxel beyond their box.
            assert!(
                relative(found, expected) < 0.02,
                "{clock_deg}: {found} {expected}"
            );
            let found = reflected(&natural, (sun, RenderEffects::BOWS_ONLY), direction);
            let expected = at_peak * reflectance;
            assert!(
                relative(found, expected) < 0.02,
                "{clock_deg}: {found} {expected}"
            );
        }
    }
}

#[test]
fn it_stands_around_the_point_as_high_as_the_sun_with_the_radius_of_the_primary() {
    for elevation_deg in [5.0, 12.0] {
        let sun = sun_in_the_south(elevation_deg);
        let drops = beside(endless(0.0), MirroredLight::Polarized, elevation_deg);
        let table = bow_table();
        let radius_deg = 180.0 - BOW_DEG;
        // A row of 2 degrees across the bow at the top and at both feet.
        for clock_deg in [0.0, 60.0, 90.0, -90.0] {
            let direction = on_bow(elevation_deg, radius_deg, clock_deg);
            let camera = camera(eye(), look(direction), 2.0, (101, 101));
            let request = request(&camera, sun, &drops, &table);
            let picture = rendered(&request);
            let light = &picture[PictureLayer::BowReflected];
            let mut brightest = (0.0, 0.0);
            for y in 0..101 {
                for x in 0..101 {
                    let ray = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5).unwrap();
                    let towards = on_bow(elevation_deg, 0.0, 0.0);
                    let off_deg = ray.direction.dot(towards).acos().to_degrees();
                    let value = light[[1, y as usize, x as usize]];
                    if value > brightest.0 {
                        brightest = (value, off_deg);
                    }
                }
            }
            assert!(
                (brightest.1 - radius_deg).abs() < 0.1,
                "{clock_deg} {brightest:?}"
            );
        }
    }
}

#[test]
fn drops_on_both_ways_of_the_light_shade_it() {
    // A slab of drops over the water, wider than all ways through it.
    let (top_m, height_m, elevation_deg, extinction_m1) = (40.0, 14.0, 30.0_f64, 0.01);
    let slab = GridBox {
        min: DVec3::new(-300.0, 0.0, -300.0),
        max: DVec3::new(300.0, top_m, 300.0),
        voxel_m: 4.0,
    };
    let sun = sun_in_the_south(elevation_deg);
    let (reflectance, _) = mirror(elevation_deg);
    // Evenly scattering drops.
    let table = table(|_, _| 0.1);
    let camera = camera(DVec3::new(-50.0, height_m, 0.0), (90.0, 0.0), 1e-4, (1, 1));
    for sun_path in [
        SunPath::Volume { voxel_m: 2.0 },
        SunPath::March { step_m: 1.0 },
    ] {
        let drops = LitDrops::new(vec![bricks(&slab, |_| extinction_m1)], sun, sun_path);
        let drops = drops.unwrap();
        let wet = drops.clone();
        let wet = wet.beside_water(endless(0.0), MirroredLight::Natural, sun);
        let shadow_only = RenderEffects {
            drop_extinction: Toggle::Off,
            ..with_shadow()
        };
        let [dry, wet] = [&drops, &wet.unwrap()]
            .map(|drops| render_one(&camera, (sun, shadow_only), (drops, &table)));
        let sine = elevation_deg.to_radians().sin();
        let direct = (-extinction_m1 * (top_m - height_m) / sine).exp();
        let by_water = (-extinction_m1 * (top_m + height_m) / sine).exp();
        let found = (wet - dry) / dry;
        let expected = reflectance * by_water / direct;
        // The edges of the slab are spread over a voxel.
        assert!(
            relative(found, expected) < 0.03,
            "{sun_path:?} {found} {expected}"
        );
    }
}

#[test]
fn drops_in_front_of_the_lit_part_dim_it() {
    let extinction_m1 = 0.01;
    let grid = GridBox {
        min: DVec3::new(-20.0, 0.0, -20.0),
        max: DVec3::new(200.0, 40.0, 20.0),
        voxel_m: 4.0,
    };
    let elevation_deg = 30.0_f64;
    let sun = sun_in_the_south(elevation_deg);
    let table = table(|_, _| 0.1);
    let height_m = 10.0;
    let camera = camera(DVec3::new(0.0, height_m, 0.0), (90.0, 0.0), 1e-4, (1, 1));
    let light = |extent_m: [DVec2; 2]| {
        let dry = LitDrops::new(vec![bricks(&grid, |_| extinction_m1)], sun, SunPath::Ignore);
        let dry = dry.unwrap();
        let surface = WaterSurface {
            extent_m,
            ..endless(0.0)
        };
        let wet = dry.clone();
        let wet = wet.beside_water(surface, MirroredLight::Natural, sun);
        let [dry, wet] = [&dry, &wet.unwrap()]
            .map(|drops| render_one(&camera, (sun, with_extinction()), (drops, &table)));
        wet - dry
    };
    let (reflectance, _) = mirror(elevation_deg);
    // The sun is in the south: feet lie as far east as their drops.
    let far = 1e4;
    for (from_m, to_m) in [(0.0, 100.0), (37.0, 101.5), (90.0, 91.0)] {
        let found = light([DVec2::new(from_m, -far), DVec2::new(to_m, far)]);
        let through = |distance_m: f64| (-extinction_m1 * distance_m).exp();
        let expected = SUN[1] * 0.1 * reflectance * (through(from_m) - through(to_m));
        assert!(relative(found, expected) < 1e-4, "{found} {expected}");
    }
    // Water that ends before the feet.
    let way_m = height_m / elevation_deg.to_radians().tan();
    for (low, high, is_lit) in [(0.0, way_m + 1.0, true), (0.0, way_m - 1.0, false)] {
        let found = light([DVec2::new(-far, low), DVec2::new(far, high)]);
        assert_eq!(found > 0.0, is_lit);
    }
}

#[test]
fn without_light_or_water_the_picture_has_the_very_same_bits() {
    let direction = on_bow(10.0, 42.0, 20.0);
    let view = look(direction);
    let camera = camera(eye(), view, 20.0, (12, 9));
    let table = bow_table();
    let deep = WaterSurface {
        height_m: 1000.0,
        ..endless(0.02)
    };
    let none = WaterSurface {
        extent_m: [DVec2::ZERO; 2],
        ..endless(0.0)
    };
    for (elevation_deg, surface) in [(10.0, deep), (10.0, none), (-2.0, endless(0.0))] {
        let sun = sun_in_the_south(elevation_deg);
        let wet = beside(surface, MirroredLight::Polarized, elevation_deg);
        let dry = LitDrops::new(
            vec![bricks(&curtain(), |_| EXTINCTION_M1)],
            sun,
            SunPath::Ignore,
        );
        let [wet, dry] =
            [&wet, &dry.unwrap()].map(|drops| rendered(&request(&camera, sun, drops, &table)));
        assert_eq!(wet.radiance, dry.radiance);
        let reflected = wet.layer(PictureLayer::BowReflected).into_iter();
        assert!(reflected.flatten().all(|value| *value == 0.0));
    }
}

#[test]
fn a_sun_at_the_horizon_is_mirrored_whole_and_its_bow_is_the_other() {
    let elevation_deg = 0.01;
    let sun = sun_in_the_south(elevation_deg);
    let drops = beside(endless(0.0), MirroredLight::Polarized, elevation_deg);
    let direction = on_bow(elevation_deg, 42.0, 30.0);
    let camera = camera(eye(), look(direction), 1e-4, (1, 1));
    let table = bow_table();
    let picture = rendered(&request(&camera, sun, &drops, &table));
    let direct = picture[PictureLayer::BowPrimary][[1, 0, 0]];
    let mirrored = picture[PictureLayer::BowReflected][[1, 0, 0]];
    assert!(
        (mirrored / direct - 1.0).abs() < 0.01,
        "{mirrored} {direct}"
    );
}

#[test]
fn waves_blur_the_top_and_leave_the_feet() {
    let (elevation_deg, slope) = (10.0, 0.02);
    let sun = sun_in_the_south(elevation_deg);
    let [still, rough] =
        [0.0, slope].map(|slope| beside(endless(slope), MirroredLight::Natural, elevation_deg));
    for (clock_deg, spread_deg) in [
        (0.0, 2.0 * slope.to_degrees()),
        (
            90.0,
            2.0 * slope.to_degrees() * elevation_deg.to_radians().sin(),
        ),
    ] {
        let direction = on_bow(elevation_deg, 180.0 - BOW_DEG, clock_deg);
        let light = |drops| reflected(drops, (sun, RenderEffects::BOWS_ONLY), direction);
        let found = light(&rough) / light(&still);
        // Peak of a Gaussian that is widened by another.
        let expected = WIDTH_DEG / WIDTH_DEG.hypot(spread_deg);
        // Mean reflectance and second orders of the waves' slopes.
        assert!(
            relative(found, expected) < 0.1,
            "{clock_deg}: {found} {expected}"
        );
    }
}

#[test]
fn it_does_not_depend_on_the_region_or_on_threads() {
    let elevation_deg = 10.0;
    let sun = sun_in_the_south(elevation_deg);
    let drops = beside(endless(0.01), MirroredLight::Polarized, elevation_deg);
    let direction = on_bow(elevation_deg, 42.0, 10.0);
    let camera = camera(eye(), look(direction), 30.0, (40, 27));
    let table = bow_table();
    let mut request = request(&camera, sun, &drops, &table);
    let whole = rendered(&request);
    request.region = common::OFF_CENTER;
    let part = rendered(&request);
    let (rows, columns) = common::off_center();
    let of_whole = &whole[PictureLayer::BowReflected];
    for ((channel, y, x), value) in part[PictureLayer::BowReflected].indexed_iter() {
        let place = [channel, y + rows.start as usize, x + columns.start as usize];
        assert_eq!(*value, of_whole[place]);
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(pool.install(|| rendered(&request)), part);
}

#[test]
fn another_sun_than_that_of_the_water_is_refused() {
    let drops = beside(endless(0.0), MirroredLight::Polarized, 10.0);
    let camera = camera(eye(), (0.0, 10.0), 10.0, (2, 2));
    let table = bow_table();
    let request = request(&camera, sun_in_the_south(11.0), &drops, &table);
    let refused = render(&request, &|_| ());
    assert!(matches!(refused, Err(Error::ShadowOfAnotherSun { .. })));
    let sun = sun_in_the_south(10.0);
    let bad = WaterSurface {
        slope: 0.5,
        ..endless(0.0)
    };
    let drops = LitDrops::new(vec![bricks(&curtain(), |_| 1.0)], sun, SunPath::Ignore).unwrap();
    let refused = drops.beside_water(bad, MirroredLight::Natural, sun);
    let message = refused.map(|_| ()).unwrap_err().to_string();
    assert_eq!(message, "water surface: slope = 0.5, expected 0 to 0.35");
}

#[test]
fn light_by_way_of_the_water_has_the_air_below_the_drops_twice() {
    let (height_m, elevation_deg, extinction_m1) = (200.0, 30.0_f64, 2e-4);
    let grid = GridBox {
        min: DVec3::new(-100.0, 150.0, -100.0),
        max: DVec3::new(100.0, 250.0, 100.0),
        voxel_m: 10.0,
    };
    let sun = sun_in_the_south(elevation_deg);
    let table = table(|_, _| 0.1);
    let mut air = common::air([extinction_m1; 3], [0.0; 3]);
    // One kilometre of it.
    air.top_height_m = 1000.0;
    air.constituents[0].height_m = vec![0.0, 1000.0];
    let dry = LitDrops::new(vec![bricks(&grid, |_| 1e-4)], sun, SunPath::Ignore).unwrap();
    let wet = dry.clone();
    let wet = wet.beside_water(endless(0.0), MirroredLight::Natural, sun);
    let camera = camera(DVec3::new(-100.0, height_m, 0.0), (90.0, 0.0), 1e-4, (1, 1));
    let (reflectance, _) = mirror(elevation_deg);
    for air_path in [AirPath::Table, AirPath::Quadrature { n_nodes: 8 }] {
        let light = |drops: &LitDrops| {
            let mut request = request(&camera, sun, drops, &table);
            request.air = Some(&air);
            request.effects.sunlight_through_air = Toggle::On;
            request.levels.air_path = air_path;
            f64::from(rendered(&request).radiance[[1, 0, 0]])
        };
        let [dry, wet] = [&dry, wet.as_ref().unwrap()].map(light);
        let more_m = 2.0 * height_m / elevation_deg.to_radians().sin();
        let expected = reflectance * (-extinction_m1 * more_m).exp();
        let found = (wet - dry) / dry;
        // The planet's curvature over 2 km.
        assert!(relative(found, expected) < 1e-3, "{found} {expected}");
    }
}
