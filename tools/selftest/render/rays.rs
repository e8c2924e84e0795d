//! Rays inside the drops, along faces and edges of the field, towards the sun and away from it;
//! empty, thin and enormous fields, denormals.

use std::f64::consts::PI;

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::SunPath;

use crate::selftest::hard_case::HardCase;
use crate::selftest::hard_case::relative;
use crate::selftest::hard_case::violations;
use crate::selftest::hard_case::worst;
use crate::selftest::render::INTEGRATIONS;
use crate::selftest::render::cube;
use crate::selftest::render::lit;
use crate::selftest::render::lit_by;
use crate::selftest::render::scenes::RADIUS_M;
use crate::selftest::render::scenes::SUN;
use crate::selftest::render::scenes::bricks;
use crate::selftest::render::scenes::camera;
use crate::selftest::render::scenes::drops;
use crate::selftest::render::scenes::isotropic;
use crate::selftest::render::scenes::one_ray;
use crate::selftest::render::scenes::rendered;
use crate::selftest::render::scenes::request;
use crate::selftest::render::scenes::table;
use crate::selftest::render::scenes::with_extinction;
use crate::selftest::render::scenes::with_shadow;
use crate::selftest::render::sun;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "an empty volume is black and transparent",
        measure: "largest radiance or loss",
        allowed: 0.0,
        error: empty_volume,
    },
    HardCase {
        claim: "one voxel shines as its column",
        measure: "relative error of the light",
        allowed: 1e-3,
        error: one_voxel,
    },
    HardCase {
        claim: "a ray from inside the field sees what lies ahead",
        measure: "relative error of the light",
        allowed: 1e-3,
        error: ray_from_inside,
    },
    HardCase {
        claim: "a direction component of exactly 0 is the limit of small ones",
        measure: "relative error of the light, on faces, edges and between",
        allowed: 1e-6,
        error: zero_component,
    },
    HardCase {
        claim: "a ray that grazes a face of the field sees next to nothing",
        measure: "light over that of a unit of depth",
        allowed: 1e-6,
        error: grazing_ray,
    },
    HardCase {
        claim: "a thin shell between two samples is not missed",
        measure: "relative error of the light",
        allowed: 1e-6,
        error: thin_shell,
    },
    HardCase {
        claim: "the antisolar point and the sun itself are ordinary directions",
        measure: "error of the light over that of a unit of depth",
        allowed: 1e-5,
        error: exact_poles,
    },
    HardCase {
        claim: "optical depths from 1e-12 to 1e3 give finite and ordered light",
        measure: "violations",
        allowed: 0.0,
        error: optical_depths,
    },
    HardCase {
        claim: "an optical depth of 1e-12 shines in proportion",
        measure: "relative error of the light",
        allowed: 1e-6,
        error: thin_field,
    },
    HardCase {
        claim: "denormal densities are next to nothing",
        measure: "light over that of a unit of depth",
        allowed: 1e-36,
        error: denormals,
    },
    HardCase {
        claim: "behind a depth of 86 the smallest normal number of light is left",
        measure: "fields that are too dark or too bright",
        allowed: 0.0,
        error: smallest_light,
    },
    HardCase {
        claim: "NaN drops never reach the renderer",
        measure: "accepted fields",
        allowed: 0.0,
        error: nan_drops,
    },
];

/// Light of one ray through drops in an isotropic table of 1/sr and sun of 2.
fn light_along(drops: &LitDrops, eye: DVec3, effects: RenderEffects, level: Integration) -> f64 {
    let camera = one_ray(eye);
    let table = isotropic(1.0);
    let mut request = request(&camera, sun(), drops, &table);
    request.effects = effects;
    request.levels.integration = level;
    f64::from(rendered(&request).radiance[[0, 0, 0]]) / SUN[0]
}

/// The worst error of the light of a ray over all levels.
fn worst_light(drops: &LitDrops, eye: DVec3, effects: RenderEffects, expected: f64) -> f64 {
    worst(INTEGRATIONS.map(|level| relative(light_along(drops, eye, effects, level), expected)))
}

fn empty_volume() -> f64 {
    let path = SunPath::Volume { voxel_m: 1.0 };
    let empty = lit_by(bricks(&cube(DVec3::ZERO), |_| 0.0), sun(), path);
    worst([empty, LitDrops::none()].map(|drops| {
        let camera = camera(DVec3::ZERO, (0.0, 0.0), 40.0, (8, 6));
        let table = isotropic(1.0);
        let mut request = request(&camera, sun(), &drops, &table);
        request.effects = with_shadow();
        let picture = rendered(&request);
        let losses = picture[PictureLayer::Transmittance].iter();
        let losses = losses.map(|share| (1.0 - share).abs());
        let light = picture.radiance.iter().copied();
        worst(losses.chain(light).map(f64::from))
    }))
}

fn one_voxel() -> f64 {
    let grid = GridBox {
        min: DVec3::new(-0.5, -0.5, -20.5),
        max: DVec3::new(0.5, 0.5, -19.5),
        voxel_m: 1.0,
    };
    // A tent of height 0.3 and base 2.
    worst_light(&lit(&grid, 0.3), DVec3::ZERO, RenderEffects::BOWS_ONLY, 0.3)
}

fn ray_from_inside() -> f64 {
    let drops = lit(&cube(DVec3::ZERO), 0.3);
    let eye = DVec3::new(0.0, 0.0, -20.0);
    worst_light(&drops, eye, with_extinction(), -(-0.6_f64).exp_m1())
}

fn zero_component() -> f64 {
    let drops = lit(&cube(DVec3::ZERO), 0.3);
    // On a face between cells, in the middle of a cell, and along an edge of the lattice.
    let eyes = [
        DVec3::ZERO,
        DVec3::new(0.25, 0.25, 0.0),
        DVec3::new(0.25, 0.0, 0.0),
    ];
    worst(eyes.map(|eye| {
        let ray = one_ray(eye).ray(0.5, 0.5);
        let is_exact = ray.is_some_and(|ray| ray.direction.x == 0.0 && ray.direction.y == 0.0);
        let found = light_along(&drops, eye, with_extinction(), Integration::CellExact);
        relative(found, -(-1.2_f64).exp_m1()) + violations([is_exact])
    }))
}

fn grazing_ray() -> f64 {
    let drops = lit(&cube(DVec3::ZERO), 0.3);
    let bounds = drops.bounds().expect("the field is not empty");
    let places = [bounds.max.x, bounds.min.x, bounds.max.x - 1e-9].into_iter();
    worst(places.flat_map(|x| {
        let eye = DVec3::new(x, 0.0, 0.0);
        INTEGRATIONS.map(|level| light_along(&drops, eye, RenderEffects::BOWS_ONLY, level).abs())
    }))
}

fn thin_shell() -> f64 {
    // Drops at one layer of nodes only; a march of 3 m sees it by luck, cells see it always.
    let grid = GridBox {
        min: DVec3::new(-2.0, -2.0, -40.0),
        max: DVec3::new(2.0, 2.0, -20.0),
        voxel_m: 0.25,
    };
    let is_shell = |z: f64| (z + 30.0).abs() < 0.2 && z < -30.0;
    let volume = bricks(&grid, |point| f64::from(u8::from(is_shell(point.z))));
    let drops = lit_by(volume, sun(), SunPath::Ignore);
    let (effects, level) = (RenderEffects::BOWS_ONLY, Integration::CellExact);
    relative(light_along(&drops, DVec3::ZERO, effects, level), 0.25)
}

fn exact_poles() -> f64 {
    let sun = DVec3::Z;
    let volume = bricks(&cube(DVec3::ZERO), |_| 0.1);
    let drops = lit_by(volume, sun, SunPath::March { step_m: 0.1 });
    let table = table(|_, theta| theta);
    let views = [
        (DVec3::ZERO, 0.0, PI),
        (DVec3::new(0.0, 0.0, -40.0), 180.0, 0.0),
    ];
    worst(views.into_iter().flat_map(|(eye, azimuth_deg, theta)| {
        let camera = camera(eye, (azimuth_deg, 0.0), 1e-4, (1, 1));
        let mut request = request(&camera, sun, &drops, &table);
        let footprints = [
            PixelFootprint::Center,
            PixelFootprint::Prefiltered,
            PixelFootprint::Grid { n: 2 },
        ];
        footprints.map(|footprint| {
            request.levels.pixel_footprint = footprint;
            let found = f64::from(rendered(&request).radiance[[0, 0, 0]]);
            (found - SUN[0] * 0.4 * theta).abs()
        })
    }))
}

fn optical_depths() -> f64 {
    let light = |depth: f64, level| {
        let drops = lit(&cube(DVec3::ZERO), depth / 4.0);
        light_along(&drops, DVec3::ZERO, with_shadow(), level)
    };
    let depths = [1e-12, 1e-6, 1e-2, 1.0, 30.0, 1e3];
    let in_range = depths.into_iter().flat_map(|depth| {
        INTEGRATIONS.map(|level| {
            let found = light(depth, level);
            found > 0.0 && found <= 1.0
        })
    });
    // Beyond a depth of 1 shadow takes what more drops add.
    let exact: Vec<f64> = depths[..4]
        .iter()
        .map(|depth| light(*depth, Integration::CellExact))
        .collect();
    let ordered = exact.windows(2).map(|pair| pair[0] < pair[1]);
    violations(in_range.chain(ordered))
}

fn thin_field() -> f64 {
    let drops = lit(&cube(DVec3::ZERO), 1e-12 / 4.0);
    worst_light(&drops, DVec3::ZERO, with_shadow(), 1e-12)
}

fn denormals() -> f64 {
    worst(
        [f32::from_bits(1), 1e-42, f32::MIN_POSITIVE].map(|number_density_m3| {
            let drops = Drops {
                number_density_m3,
                effective_radius_m: RADIUS_M as f32,
                effective_variance: 0.0,
            };
            let mode =
                DropMode::from_fn("", &cube(DVec3::ZERO), |_| drops).expect("possible drops");
            let interpolations = [Interpolation::Moments, Interpolation::RadiusDensity];
            worst(interpolations.into_iter().flat_map(|interpolation| {
                let volume = Bricks::build(&mode, interpolation).expect("a few voxels");
                let drops = lit_by(volume, sun(), SunPath::Volume { voxel_m: 0.5 });
                INTEGRATIONS
                    .map(|level| light_along(&drops, DVec3::ZERO, with_shadow(), level).abs())
            }))
        }),
    )
}

fn smallest_light() -> f64 {
    let drops = lit(&cube(DVec3::ZERO), 86.0 / 4.0);
    violations(INTEGRATIONS.map(|level| {
        let found = light_along(&drops, DVec3::ZERO, with_shadow(), level);
        found > 0.1 && found < 1.0
    }))
}

fn nan_drops() -> f64 {
    let fields = [
        Drops {
            number_density_m3: f32::NAN,
            ..drops(0.1)
        },
        Drops {
            effective_radius_m: f32::NAN,
            ..drops(0.1)
        },
    ];
    violations(fields.map(|field| DropMode::from_fn("", &cube(DVec3::ZERO), |_| field).is_err()))
}
