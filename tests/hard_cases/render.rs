//! Hard cases of the ray integral that every machine does alike: eyes in faces and corners of the drops, the
//! antisolar point and the zenith's sun, fields of 1e-30 and of 1e8, rims of fisheyes, one pixel.

use std::f64::consts::PI;

use glam::DVec3;
use niji_dropfield::GridBox;
use niji_geometry::Camera;
use niji_geometry::CameraPose;
use niji_geometry::FisheyeCamera;
use niji_geometry::FisheyeMapping;
use niji_geometry::FisheyeRequest;
use niji_geometry::Lens;
use niji_radiometry::Radians;
use niji_render::LitDrops;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::SkyModel;
use niji_render::SunPath;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;
use crate::scenes::SUN;
use crate::scenes::air;
use crate::scenes::bricks;
use crate::scenes::camera;
use crate::scenes::isotropic;
use crate::scenes::one_ray;
use crate::scenes::rendered;
use crate::scenes::request;
use crate::scenes::sun_in_the_south;
use crate::scenes::table;
use crate::scenes::uniform_light;
use crate::scenes::with_air_light;
use crate::scenes::with_extinction;
use crate::scenes::with_shadow;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "an eye in a face, on an edge and in a corner of the drops sees all that lies ahead",
        measure: "relative error of the light",
        allowed: 1e-6,
        error: eye_on_the_boundary,
    },
    HardCase {
        claim: "with the antisolar point in view light goes the same way in and out",
        measure: "relative error of the light, depths 0.01 to 12",
        // Shadows linear between nodes; measured 4e-3 at a depth of 12.
        allowed: 2e-2,
        error: antisolar_point,
    },
    HardCase {
        claim: "the shadow of a slab under a sun in the zenith is its depth from above",
        measure: "relative error of the light of a level ray",
        // Next to the faces there is less above: a fortieth of a voxel of 6 cm over 4 m.
        allowed: 3e-3,
        error: sun_in_the_zenith,
    },
    HardCase {
        claim: "fields of a depth of 1e-30 and of 1e8 shine as thin and as black ones",
        measure: "relative error of the light",
        allowed: 1e-5,
        error: faintest_and_densest,
    },
    HardCase {
        claim: "one pixel is the middle one of three by three",
        measure: "relative difference, centers and means of pixels",
        allowed: 1e-5,
        error: one_pixel,
    },
    HardCase {
        claim: "a sun in the plane of symmetry makes a picture of two equal halves",
        measure: "relative difference of pixels and their mirror images",
        allowed: 2e-5,
        error: mirror_images,
    },
    HardCase {
        claim: "an all-round fisheye in an even surround is even to its rim, and black beyond",
        measure: "relative error of the light",
        allowed: 1e-3,
        error: rim_of_a_fisheye,
    },
];

/// A cube of 4 m, 20 m to the north.
fn cube() -> GridBox {
    GridBox {
        min: DVec3::new(-2.0, -2.0, -22.0),
        max: DVec3::new(2.0, 2.0, -18.0),
        voxel_m: 0.5,
    }
}

/// Even drops in a box, lit by a sun.
fn lit(grid: &GridBox, extinction_m1: f64, (sun, path): (DVec3, SunPath)) -> LitDrops {
    let volume = bricks(grid, |_| extinction_m1);
    LitDrops::new(vec![volume], sun, path).expect("the cases light sound drops")
}

/// Without shadows, the sun 25 degrees high in the south.
fn unshadowed() -> (DVec3, SunPath) {
    (sun_in_the_south(25.0), SunPath::Ignore)
}

/// Light of one ray to the north through drops of 1/sr, for unit sun.
fn light_from(eye: DVec3, drops: &LitDrops, (sun, effects): (DVec3, RenderEffects)) -> f64 {
    let (camera, table) = (one_ray(eye), isotropic(1.0));
    let mut request = request(&camera, sun, drops, &table);
    request.effects = effects;
    f64::from(rendered(&request).radiance[[0, 0, 0]]) / SUN[0]
}

fn eye_on_the_boundary() -> f64 {
    let (sun, path) = unshadowed();
    let drops = lit(&cube(), 0.3, (sun, path));
    // Nodes from -1.75 on, and tents of half a metre around them: beside the outermost nodes 1, in the
    // faces of the field 0, halfway 1/2.
    let places = [
        (DVec3::new(0.0, 0.0, -17.75), 1.0, 4.0),
        (DVec3::new(1.75, 0.0, -17.75), 1.0, 4.0),
        (DVec3::new(1.75, 1.75, -17.75), 1.0, 4.0),
        (DVec3::new(2.0, 0.0, -17.75), 0.5, 4.0),
        (DVec3::new(2.0, 2.0, -17.75), 0.25, 4.0),
        // In the middle, and on the far face, with nothing ahead.
        (DVec3::new(0.0, 0.0, -20.0), 1.0, 2.0),
        (DVec3::new(0.0, 0.0, -18.25), 1.0, 3.75),
    ];
    let errors = places.map(|(eye, share, length_m)| {
        let found = light_from(eye, &drops, (sun, with_extinction()));
        let depth: f64 = 0.3 * share * length_m;
        relative(found, -(-depth).exp_m1())
    });
    let behind = [-22.25, -30.0].map(|z| {
        let eye = DVec3::new(0.0, 0.0, z);
        light_from(eye, &drops, (sun, with_extinction())) == 0.0
    });
    worst(errors) + violations(behind)
}

fn antisolar_point() -> f64 {
    // The sun stands exactly behind the eye.
    let sun = DVec3::Z;
    let slab = GridBox {
        voxel_m: 0.125,
        ..cube()
    };
    worst([0.01, 1.0, 12.0].map(|depth| {
        let drops = lit(&slab, depth / 4.0, (sun, SunPath::March { step_m: 0.03 }));
        let found = light_from(DVec3::ZERO, &drops, (sun, with_shadow()));
        relative(found, 0.5 * -(-2.0 * depth).exp_m1())
    }))
}

fn sun_in_the_zenith() -> f64 {
    let slab = GridBox {
        min: DVec3::new(-1.0, 0.0, -22.0),
        max: DVec3::new(1.0, 8.0, -18.0),
        voxel_m: 0.0625,
    };
    let extinction_m1 = 0.05;
    let drops = lit(
        &slab,
        extinction_m1,
        (DVec3::Y, SunPath::March { step_m: 0.02 }),
    );
    // 6 m of drops and, at the top, half of the tent above the last node: all of its column.
    worst([2.0, 5.0].map(|y| {
        let found = light_from(DVec3::new(0.0, y, 0.0), &drops, (DVec3::Y, with_shadow()));
        let through = -(-4.0 * extinction_m1).exp_m1();
        relative(found, through * (-extinction_m1 * (8.0 - y)).exp())
    }))
}

fn faintest_and_densest() -> f64 {
    let (sun, path) = unshadowed();
    let thin = lit(&cube(), 2.5e-31, (sun, path));
    let of_thin = light_from(DVec3::ZERO, &thin, (sun, with_extinction()));
    let dense = lit(&cube(), 2.5e7, (sun, path));
    let of_dense = light_from(DVec3::ZERO, &dense, (sun, with_extinction()));
    worst([relative(of_thin, 1e-30), relative(of_dense, 1.0)])
}

fn one_pixel() -> f64 {
    let (sun, path) = unshadowed();
    let drops = lit(&cube(), 0.3, (sun, path));
    let table = table(|w, theta| 0.1 * (1.0 + w as f64) * (1.0 + (9.0 * theta).cos()));
    let footprints = [PixelFootprint::Center, PixelFootprint::Grid { n: 4 }];
    worst(footprints.into_iter().flat_map(|footprint| {
        let middle = |n: u32, half_width: f64| {
            let fov_deg = 2.0 * half_width.atan().to_degrees();
            let camera = camera(DVec3::ZERO, (3.0, 2.0), fov_deg, (n, n));
            let mut request = request(&camera, sun, &drops, &table);
            request.levels.pixel_footprint = footprint;
            let radiance = rendered(&request).radiance;
            [0, 1, 2].map(|w| f64::from(radiance[[w, n as usize / 2, n as usize / 2]]))
        };
        let (alone, among) = (middle(1, 0.01), middle(3, 0.03));
        [0, 1, 2].map(|w| relative(alone[w], among[w]))
    }))
}

fn mirror_images() -> f64 {
    let sun = sun_in_the_south(25.0);
    let volume = bricks(&cube(), |point| {
        0.2 + 0.1 * point.x.abs().cos() * point.y.sin()
    });
    let path = SunPath::Volume { voxel_m: 0.25 };
    let drops = LitDrops::new(vec![volume], sun, path).expect("sound drops");
    let table = table(|w, theta| 0.1 * (1.0 + w as f64) * (1.0 + (9.0 * theta).cos()));
    worst([7, 8].map(|width| {
        let camera = camera(DVec3::ZERO, (0.0, 1.0), 16.0, (width, 5));
        let mut request = request(&camera, sun, &drops, &table);
        request.effects = with_shadow();
        let radiance = rendered(&request).radiance;
        let peak = f64::from(radiance.iter().copied().fold(0.0, f32::max));
        let last = width as usize - 1;
        worst(radiance.indexed_iter().map(|((w, y, x), light)| {
            let mirrored = radiance[[w, y, last - x]];
            f64::from((light - mirrored).abs()) / peak
        }))
    }))
}

fn rim_of_a_fisheye() -> f64 {
    let pose = CameraPose::looking(
        DVec3::new(0.0, 100.0, 0.0),
        [20.0, 35.0, 0.0].map(Radians::from_degrees),
    );
    let size_px = 24;
    let camera = FisheyeCamera::new(FisheyeRequest {
        pose: pose.expect("finite angles"),
        mapping: FisheyeMapping::Equidistant,
        lens: Lens::HorizontalFov(Radians(2.0 * PI)),
        image_circle: None,
        width_px: size_px,
        height_px: size_px,
    });
    let camera = Camera::from(camera.expect("all directions"));
    // Air and white ground that shine evenly, and a sun far below the horizon.
    let sun = sun_in_the_south(-30.0);
    let mut air = air([1e-4; 3], [1e-4; 3]);
    air.ground_albedo = vec![1.0; 3];
    air.diffuse = Some(uniform_light(0.25));
    let (drops, table) = (LitDrops::none(), isotropic(1.0));
    let mut request = request(&camera, sun, &drops, &table);
    request.air = Some(&air);
    request.levels.sky_model = SkyModel::MultipleScattering;
    request.effects = with_air_light();
    let radiance = rendered(&request).radiance;
    let half = 0.5 * f64::from(size_px);
    worst(radiance.indexed_iter().map(|((w, y, x), light)| {
        let light = f64::from(*light);
        let off_axis = (x as f64 + 0.5 - half).hypot(y as f64 + 0.5 - half);
        if off_axis <= half {
            relative(light, 0.25 * SUN[w])
        } else {
            light
        }
    }))
}
