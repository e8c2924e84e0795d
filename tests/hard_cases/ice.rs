//! Hard cases of ice: clear and black ice, an eye inside it, 1000 km from the origin, meshes that are
//! no bodies.

use glam::DVec3;
use niji_geometry::Aabb;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_geometry::TriangleMesh;
use niji_ice::Body;
use niji_ice::Bubbles;
use niji_ice::Ground;
use niji_ice::Ice;
use niji_ice::IcePicture;
use niji_ice::IceRequest;
use niji_ice::IceSurface;
use niji_ice::IceTransport;
use niji_ice::Light;
use niji_ice::PathWavelengths;
use niji_ice::Sky;
use niji_ice::Snow;
use niji_ice::one_crossing;
use niji_ice::render_ice;
use niji_radiometry::Radians;
use niji_radiometry::WavelengthGrid;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "clear ice conserves energy and vanishes in a uniform surround",
        measure: "relative error of the mean radiance",
        // Statistical, by the roulette.
        allowed: 1e-3,
        error: clear_ice,
    },
    HardCase {
        claim: "so does a rough dielectric, from nearly smooth to wholly rough",
        measure: "relative error of the mean radiance",
        allowed: 1e-6,
        error: rough_dielectric,
    },
    HardCase {
        claim: "so do snow, bubbles and bodies that overlap",
        measure: "relative error of the mean radiance",
        allowed: 3e-3,
        error: snow_and_bubbles,
    },
    HardCase {
        claim: "an absorption of 0 passes all of the light, of 1.8e308 nothing",
        measure: "error of the transmittance",
        allowed: 0.0,
        error: clear_and_black,
    },
    HardCase {
        claim: "ice of an optical depth of 1e-6 absorbs along its mean chord",
        measure: "relative error of the chord of a cube, 2/3 of its edge",
        // Statistical 1e-4.
        allowed: 5e-4,
        error: thin_ice,
    },
    HardCase {
        claim: "a thousand optical depths leave what the surface throws back",
        measure: "error of the reflectance 0.063",
        // Of the surround that the black cube darkens, and of what crosses at the edges.
        allowed: 0.015,
        error: thousand_depths,
    },
    HardCase {
        claim: "an eye inside clear ice sees out of it, inside black ice nothing",
        measure: "error of the mean radiance",
        allowed: 1e-3,
        error: eye_inside,
    },
    HardCase {
        claim: "1000 km from the origin a cube of ice is the same cube",
        measure: "difference of depths, relative",
        allowed: 0.01,
        error: far_from_the_origin,
    },
    HardCase {
        claim: "open meshes, sheets and bodies of no volume are refused",
        measure: "accepted bodies",
        allowed: 0.0,
        error: no_bodies,
    },
    HardCase {
        claim: "a degenerate triangle changes nothing",
        measure: "difference of the transmittances",
        allowed: 0.0,
        error: degenerate_triangle,
    },
    HardCase {
        claim: "spectra of NaN or of wrong length, and albedos below 0 are refused",
        measure: "accepted requests",
        allowed: 0.0,
        error: impossible_requests,
    },
];

const N_WAVELENGTHS: usize = 3;

/// A cube in a uniform surround of radiance 1, on ground that gives back all.
struct Scene {
    camera: PinholeCamera,
    body: Body,
    ice: Ice,
    light: Light,
    ground: Ground,
    transport: IceTransport,
}

fn view(position: DVec3, [azimuth, elevation, fov]: [f64; 3], side_px: u32) -> PinholeCamera {
    PinholeCamera::new(PinholeRequest {
        position,
        azimuth: Radians::from_degrees(azimuth),
        elevation: Radians::from_degrees(elevation),
        roll: Radians(0.0),
        horizontal_fov: Radians::from_degrees(fov),
        width_px: side_px,
        height_px: side_px,
    })
    .expect("a camera like others")
}

/// Looks at the cube from the south, from 8 m away and above.
fn from_the_south(shift: DVec3) -> PinholeCamera {
    view(DVec3::new(3.0, 2.0, 7.0) + shift, [-23.2, -11.0, 16.0], 16)
}

fn cube() -> Aabb {
    Aabb {
        min: DVec3::new(-0.5, 0.0, -0.5),
        max: DVec3::new(0.5, 1.0, 0.5),
    }
}

fn cube_body() -> Body {
    Body::of_box(cube()).expect("a cube")
}

fn furnace() -> Scene {
    Scene {
        camera: from_the_south(DVec3::ZERO),
        body: cube_body(),
        ice: Ice {
            absorption_per_m: vec![0.0; N_WAVELENGTHS],
            surface: IceSurface::PUBLISHED,
            bubbles: None,
            snow: None,
        },
        light: Light {
            sun_direction: DVec3::new(0.48, 0.6, 0.64),
            sun_radius: Radians(0.0),
            sun_irradiance: vec![0.0; N_WAVELENGTHS],
            sky: Sky::Uniform(vec![1.0; N_WAVELENGTHS]),
        },
        ground: Ground::Land { albedo: 1.0 },
        transport: IceTransport::PathTraced {
            paths_per_pixel: 64,
            wavelengths: PathWavelengths::All,
        },
    }
}

fn render(scene: &Scene) -> Result<IcePicture, niji_ice::Error> {
    let wavelengths = WavelengthGrid::new(450.0, 100.0, N_WAVELENGTHS);
    let request = IceRequest {
        camera: &scene.camera,
        wavelengths: wavelengths.expect("three wavelengths of light"),
        body: &scene.body,
        ice: &scene.ice,
        light: &scene.light,
        ground: scene.ground,
        transport: scene.transport,
        tolerance_cd_m2: None,
        seed: 7,
    };
    render_ice(&request, &|_| ())
}

fn picture(scene: &Scene) -> IcePicture {
    render(scene).expect("the cases ask for sound pictures")
}

fn mean_radiance(scene: &Scene) -> f64 {
    let radiance = picture(scene).radiance;
    let sum: f64 = radiance.iter().map(|value| f64::from(*value)).sum();
    sum / radiance.len() as f64
}

fn clear_ice() -> f64 {
    worst(
        [(0.063, 0.0), (0.063, 0.45), (0.5, 0.5)].map(|(outer, inner)| {
            let mut scene = furnace();
            scene.ice.surface = IceSurface::Diffuse {
                outer_reflectance: outer,
                inner_reflectance: inner,
            };
            relative(mean_radiance(&scene), 1.0)
        }),
    )
}

fn rough_dielectric() -> f64 {
    worst([0.02, 0.2, 1.0].map(|roughness| {
        let mut scene = furnace();
        scene.ice.surface = IceSurface::RoughDielectric { roughness };
        relative(mean_radiance(&scene), 1.0)
    }))
}

const BUBBLES: Bubbles = Bubbles {
    scattering_per_m: 3.0,
    asymmetry: 0.86,
};

fn snow(albedo: f64) -> Snow {
    Snow {
        albedo,
        steepest_deg: 30.0,
    }
}

fn snow_and_bubbles() -> f64 {
    let mut scene = furnace();
    scene.ice.snow = Some(snow(0.9));
    scene.ice.bubbles = Some(BUBBLES);
    scene.body = overlapping_boxes();
    relative(mean_radiance(&scene), 1.0)
}

/// Two boxes of one mesh that share a part of their volume.
fn overlapping_boxes() -> Body {
    let (min, max) = (DVec3::new(-0.5, 0.0, -0.5), DVec3::new(0.3, 0.8, 0.3));
    let first = TriangleMesh::of_box(Aabb { min, max });
    let second = TriangleMesh::of_box(Aabb {
        min: min + 0.3,
        max: max + 0.4,
    });
    let corners = [first.vertices(), second.vertices()].concat();
    let moved = second.triangles().iter().map(|t| t.map(|index| index + 8));
    let triangles: Vec<_> = first.triangles().iter().copied().chain(moved).collect();
    let mesh = TriangleMesh::new(&corners, &triangles).expect("corners are there");
    Body::of_mesh(mesh).expect("two closed boxes")
}

/// Transmittance of one crossing of a body.
fn transmittances(body: &Body, absorption_per_m: &[f64], n_chords: u32) -> Vec<f64> {
    let crossings = one_crossing(body, absorption_per_m, n_chords, 5);
    crossings
        .into_iter()
        .map(|crossing| crossing.transmittance)
        .collect()
}

fn clear_and_black() -> f64 {
    let found = transmittances(&cube_body(), &[0.0, f64::MAX], 4096);
    worst([1.0 - found[0], found[1]].map(f64::abs))
}

fn thin_ice() -> f64 {
    let absorbed = 1.0 - transmittances(&cube_body(), &[1e-6], 1 << 16)[0];
    // The mean chord of a convex body is 4 V/S.
    relative(absorbed / 1e-6, 2.0 / 3.0)
}

fn thousand_depths() -> f64 {
    let mut scene = furnace();
    scene.ice.absorption_per_m = vec![1e3; N_WAVELENGTHS];
    scene.camera = view(DVec3::new(0.0, 0.5, 1000.0), [0.0, 0.0, 0.05], 8);
    (mean_radiance(&scene) - 0.063).abs()
}

fn eye_inside() -> f64 {
    let mut scene = furnace();
    scene.camera = view(DVec3::new(0.0, 0.5, 0.0), [10.0, 5.0, 60.0], 8);
    let clear = relative(mean_radiance(&scene), 1.0);
    scene.ice.absorption_per_m = vec![1e3; N_WAVELENGTHS];
    clear.max(mean_radiance(&scene))
}

fn far_from_the_origin() -> f64 {
    let near = furnace();
    let shift = DVec3::new(1e6, 0.0, -1e6);
    let mesh = TriangleMesh::of_box(cube()).moved(|corner| corner + shift);
    let far = Scene {
        camera: from_the_south(shift),
        body: mesh
            .map_err(niji_ice::Error::from)
            .and_then(Body::of_mesh)
            .expect("a cube"),
        ..furnace()
    };
    let (near, far) = (picture(&near).depth, picture(&far).depth);
    let light = near.iter().zip(&far).filter(|(near, _)| near.is_finite());
    worst(light.map(|(near, far)| relative(f64::from(*far), f64::from(*near))))
}

fn no_bodies() -> f64 {
    let whole = TriangleMesh::of_box(cube());
    let (corners, triangles) = (whole.vertices(), whole.triangles());
    let sheet = [[0, 1, 2], [2, 1, 0]];
    let meshes = [&triangles[1..], &triangles[..2], &sheet[..]];
    let meshes = meshes.map(|triangles| {
        let mesh = TriangleMesh::new(corners, triangles);
        mesh.map_or(true, |mesh| Body::of_mesh(mesh).is_err())
    });
    let boxes = [DVec3::ZERO, DVec3::NEG_ONE, DVec3::NAN, DVec3::INFINITY];
    let boxes = boxes.map(|max| {
        let min = DVec3::ZERO;
        Body::of_box(Aabb { min, max }).is_err()
    });
    violations(meshes) + violations(boxes)
}

fn degenerate_triangle() -> f64 {
    let whole = TriangleMesh::of_box(cube());
    let mut triangles = whole.triangles().to_vec();
    triangles.extend([[0, 0, 0], [0, 1, 0]]);
    let transmittances = |triangles: &[[u32; 3]]| {
        let mesh = TriangleMesh::new(whole.vertices(), triangles).expect("corners are there");
        transmittances(
            &Body::of_mesh(mesh).expect("a closed mesh"),
            &[0.1, 1.0],
            1024,
        )
    };
    let (with, without) = (
        transmittances(&triangles),
        transmittances(whole.triangles()),
    );
    worst(
        with.iter()
            .zip(&without)
            .map(|(with, without)| (with - without).abs()),
    )
}

fn impossible_requests() -> f64 {
    let changes: [fn(&mut Scene); 7] = [
        |scene| scene.ice.absorption_per_m[2] = f64::NAN,
        |scene| scene.light.sun_irradiance.truncate(2),
        |scene| scene.ground = Ground::Land { albedo: -0.1 },
        |scene| scene.light.sky = Sky::Uniform(vec![f64::INFINITY; N_WAVELENGTHS]),
        |scene| scene.transport = IceTransport::MeanChord { paths_per_pixel: 0 },
        |scene| scene.ice.snow = Some(snow(0.01)),
        |scene| {
            scene.transport = IceTransport::MeanChord { paths_per_pixel: 1 };
            scene.ice.bubbles = Some(BUBBLES);
        },
    ];
    violations(changes.map(|change| {
        let mut scene = furnace();
        change(&mut scene);
        render(&scene).is_err()
    }))
}
