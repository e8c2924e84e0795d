//! Hard cases of rays, the planet and meshes: heights of millimetres over a planet, rays along faces
//! and through corners, bodies 1000 km away, open and degenerate meshes.

use glam::DVec3;
use niji_geometry::Aabb;
use niji_geometry::Camera;
use niji_geometry::CameraPose;
use niji_geometry::EARTH;
use niji_geometry::FisheyeCamera;
use niji_geometry::FisheyeMapping;
use niji_geometry::FisheyeRequest;
use niji_geometry::Lens;
use niji_geometry::MeshBvh;
use niji_geometry::PanoramaCamera;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_geometry::Ray;
use niji_geometry::TriangleMesh;
use niji_radiometry::Radians;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "heights along rays of 1 m to 1000 km agree with 60 digits",
        measure: "error over the larger of height and climb",
        allowed: 1e-15,
        error: heights_along_rays,
    },
    HardCase {
        claim: "the horizon of an eye a micrometre high dips as geometry says",
        measure: "relative error of the dip, 1e-6 m to 400 km",
        allowed: 5e-16,
        error: horizon_dip,
    },
    HardCase {
        claim: "an eye at or below sea level stands on the ground",
        measure: "heights at which it does not",
        allowed: 0.0,
        error: below_sea_level,
    },
    HardCase {
        claim: "a box 1000 km away is still one metre thick",
        measure: "error of the chord, m",
        allowed: 0.0,
        error: box_far_away,
    },
    HardCase {
        claim: "rays with components of 0 or 5e-324, along faces and edges have chords",
        measure: "error of the chord, m",
        allowed: 0.0,
        error: axis_parallel_rays,
    },
    HardCase {
        claim: "rays through corners and edges never slip through a mesh",
        measure: "rays of 26 that leave the cube unseen",
        allowed: 0.0,
        error: corners_and_edges,
    },
    HardCase {
        claim: "rays without a direction or a place meet nothing",
        measure: "hits",
        allowed: 0.0,
        error: rays_that_are_none,
    },
    HardCase {
        claim: "degenerate triangles of a mesh vanish and leave it closed",
        measure: "relative error of its volume",
        allowed: 1e-15,
        error: degenerate_triangles,
    },
    HardCase {
        claim: "open meshes, and meshes of NaN or of missing corners are refused",
        measure: "accepted meshes",
        allowed: 0.0,
        error: impossible_meshes,
    },
    HardCase {
        claim: "cameras without pixels, without a field of view or with NaN are refused",
        measure: "accepted cameras",
        allowed: 0.0,
        error: impossible_cameras,
    },
    HardCase {
        claim: "a fisheye's rim of 360 degrees is the direction straight back, and ends there",
        measure: "error of the direction, and rays beyond the rim",
        // The equisolid radius is flat there: half of the digits of f64.
        allowed: 1e-7,
        error: rim_of_a_fisheye,
    },
    HardCase {
        claim: "every column of a panorama meets at the poles",
        measure: "error of the direction",
        allowed: 1e-15,
        error: poles_of_a_panorama,
    },
    HardCase {
        claim: "one pixel as wide as a millionth and as 179.999 degrees ends where its field does",
        measure: "relative error of the angle from the axis, or of what is left to 90 degrees",
        allowed: 1e-9,
        error: one_pixel,
    },
    HardCase {
        claim: "a box of no thickness has no depth, but for who looks along it",
        measure: "error of the chord, m",
        allowed: 0.0,
        error: box_of_no_thickness,
    },
    HardCase {
        claim: "through both corners of a box leads its diagonal, whatever its size",
        measure: "relative error of the chord, boxes of 1e-6 to 1e7 m",
        allowed: 1e-15,
        error: through_corners,
    },
];

/// Height, cosine of the zenith angle, distance; height there in 60-digit arithmetic.
const ALONG_RAY: [(f64, f64, f64, f64); 7] = [
    (0.0, 0.0, 1.0, 7.8480615288023374729e-8),
    (1.7, -1e-6, 20.0, 1.7000113922377386357),
    (0.25, 1e-12, 5e5, 19590.284590808713149),
    (8848.0, -0.05, 5e5, 3438.6500384486783233),
    (99999.0, -0.1758, 1e6, 705.0158965300178225),
    (-400.0, 0.001, 2e4, -348.60599012214322983),
    (3.5e5, -0.9, 3e5, 81325.239787591481549),
];

fn heights_along_rays() -> f64 {
    worst(
        ALONG_RAY.map(|(height_m, cos_zenith, distance_m, expected)| {
            let found = EARTH.height_along_ray(height_m, cos_zenith, distance_m);
            let scale = height_m.abs().max((expected - height_m).abs());
            (found - expected).abs() / scale
        }),
    )
}

fn horizon_dip() -> f64 {
    // acos(R/(R + h)) in 60-digit arithmetic.
    let dips = [
        (1e-6, 5.6028783776917231674e-7),
        (1.7, 0.00073052588269766424766),
        (8848.0, 0.052672337756786863801),
        (4e5, 0.34544597698727430441),
    ];
    worst(dips.map(|(height_m, dip_rad)| relative(EARTH.horizon_dip(height_m).0, dip_rad)))
}

fn below_sea_level() -> f64 {
    violations([0.0, -5.0, -400.0].map(|height_m| {
        EARTH.distance_to_ground(height_m, -1e-12) == Some(0.0)
            && EARTH.distance_to_ground(height_m, 0.0).is_none()
            && EARTH.distance_to_ground(height_m, 0.3).is_none()
            && EARTH.shell_chord(height_m, -1.0, 1e5).is_some()
    }))
}

fn unit_cube(min: DVec3) -> Aabb {
    Aabb {
        min,
        max: min + 1.0,
    }
}

fn box_far_away() -> f64 {
    worst([1e3, 1e6].map(|far| {
        let ray = Ray {
            origin: DVec3::new(0.0, far + 0.5, far + 0.5),
            direction: DVec3::X,
        };
        let chord = unit_cube(DVec3::splat(far)).intersect(&ray);
        chord.map_or(f64::NAN, |(enter, leave)| (leave - enter - 1.0).abs())
    }))
}

fn axis_parallel_rays() -> f64 {
    let cube = unit_cube(DVec3::ZERO);
    let south = |x, y| DVec3::new(x, y, -1.0);
    let west = |y, z| DVec3::new(-1.0, y, z);
    let rays = [
        (south(0.5, 0.5), DVec3::Z, 1.0),
        (south(0.5, 1.5), DVec3::Z, 0.0),
        (south(0.5, 0.5), DVec3::new(0.0, -0.0, 1.0), 1.0),
        // In a face and along an edge of the box; touching edges only.
        (west(1.0, 0.5), DVec3::X, 1.0),
        (west(0.0, 0.0), DVec3::X, 1.0),
        (west(0.0, 0.5), DVec3::new(1.0, -1.0, 0.0), 0.0),
        (DVec3::new(0.0, 1.0, 0.5), DVec3::new(1.0, 1.0, 0.0), 0.0),
        (south(0.5, 0.5), DVec3::new(5e-324, -5e-324, 1.0), 1.0),
        (south(0.0, 0.0), DVec3::new(5e-324, 0.0, 1.0), 1.0),
    ];
    worst(rays.map(|(origin, direction, expected)| {
        let chord = cube.intersect(&Ray { origin, direction });
        (chord.map_or(0.0, |(enter, leave)| leave - enter) - expected).abs()
    }))
}

fn corners_and_edges() -> f64 {
    let cube = MeshBvh::new(TriangleMesh::of_box(unit_cube(DVec3::splat(-0.5))));
    // Towards all corners and the middles of all edges and faces.
    let parts = || [-1.0, 0.0, 1.0].into_iter();
    let directions =
        parts().flat_map(|x| parts().flat_map(move |y| parts().map(move |z| DVec3::new(x, y, z))));
    let directions = directions.filter(|direction| *direction != DVec3::ZERO);
    violations(directions.map(|direction| {
        let ray = Ray {
            origin: DVec3::ZERO,
            direction: direction.normalize(),
        };
        let hit = cube.nearest(&ray, 0.0);
        hit.is_some_and(|hit| hit.is_from_inside && (0.49..0.88).contains(&hit.distance_m))
    }))
}

fn rays_that_are_none() -> f64 {
    let cube = MeshBvh::new(TriangleMesh::of_box(unit_cube(DVec3::ZERO)));
    let inside = DVec3::splat(0.5);
    let rays = [
        (inside, DVec3::ZERO),
        (inside, DVec3::NAN),
        (inside, DVec3::INFINITY),
        (DVec3::NAN, DVec3::X),
        (DVec3::splat(f64::NEG_INFINITY), DVec3::X),
    ];
    violations(
        rays.map(|(origin, direction)| cube.nearest(&Ray { origin, direction }, 0.0).is_none()),
    )
}

fn degenerate_triangles() -> f64 {
    let cube = TriangleMesh::of_box(unit_cube(DVec3::ZERO));
    let mut corners = cube.vertices().to_vec();
    let mut triangles = cube.triangles().to_vec();
    // A point, a needle, and a needle whose corners coincide without being the same.
    corners.push(corners[1]);
    let again = corners.len() as u32 - 1;
    triangles.extend([[0, 0, 0], [0, 1, 0], [1, again, 3]]);
    let mesh = TriangleMesh::new(&corners, &triangles).and_then(TriangleMesh::into_body);
    mesh.map_or(f64::NAN, |mesh| relative(mesh.volume_m3(), 1.0))
}

fn impossible_meshes() -> f64 {
    let cube = TriangleMesh::of_box(unit_cube(DVec3::ZERO));
    let (corners, triangles) = (cube.vertices(), cube.triangles());
    let mut not_a_number = corners.to_vec();
    not_a_number[3].y = f64::NAN;
    let mut missing = triangles.to_vec();
    missing[5][2] = 1000;
    let mut turned = triangles.to_vec();
    turned[0].swap(0, 1);
    let meshes = [
        TriangleMesh::new(corners, &triangles[1..]),
        TriangleMesh::new(corners, &turned),
        TriangleMesh::new(corners, &missing),
        TriangleMesh::new(&not_a_number, triangles),
        TriangleMesh::new(&[], &[]),
    ];
    violations(meshes.map(|mesh| mesh.and_then(TriangleMesh::into_body).is_err()))
}

fn impossible_cameras() -> f64 {
    let good = || PinholeRequest {
        position: DVec3::ZERO,
        azimuth: Radians(0.0),
        elevation: Radians(0.0),
        roll: Radians(0.0),
        horizontal_fov: Radians::from_degrees(60.0),
        width_px: 10,
        height_px: 10,
    };
    let mut requests = [(); 6].map(|()| good());
    requests[0].width_px = 0;
    requests[1].horizontal_fov = Radians(0.0);
    requests[2].horizontal_fov = Radians::from_degrees(180.0);
    requests[3].horizontal_fov = Radians(f64::NAN);
    requests[4].azimuth = Radians(f64::INFINITY);
    requests[5].position = DVec3::NAN;
    let is_refused = |request| PinholeCamera::new(request).map(Camera::from).is_err();
    violations(requests.map(is_refused))
}

/// A camera at the origin that looks towards an azimuth and an elevation, degrees.
fn pose(azimuth_deg: f64, elevation_deg: f64) -> CameraPose {
    let angles = [azimuth_deg, elevation_deg, 0.0].map(Radians::from_degrees);
    CameraPose::looking(DVec3::ZERO, angles).expect("finite angles")
}

fn rim_of_a_fisheye() -> f64 {
    let mappings = [FisheyeMapping::Equidistant, FisheyeMapping::Equisolid];
    worst(mappings.map(|mapping| {
        let camera = FisheyeCamera::new(FisheyeRequest {
            pose: pose(0.0, 0.0),
            mapping,
            lens: Lens::HorizontalFov(Radians::from_degrees(360.0)),
            image_circle: None,
            width_px: 64,
            height_px: 64,
        });
        let camera = camera.expect("all directions");
        let rim = [(0.0, 32.0), (64.0, 32.0), (32.0, 0.0), (32.0, 64.0)];
        let backwards = rim.map(|(x, y)| {
            let ray = camera.ray(x, y);
            ray.map_or(f64::NAN, |ray| ray.direction.distance(DVec3::Z))
        });
        let beyond = [(-1e-3, 32.0), (64.001, 32.0), (1.0, 1.0)];
        let is_dark = violations(beyond.map(|(x, y)| camera.ray(x, y).is_none()));
        // The middle of the way to the rim: 90 degrees, or 2 asin(1/2) = 60.
        let halfway = camera.ray(48.0, 32.0).expect("within the circle");
        let expected = match mapping {
            FisheyeMapping::Equidistant => 0.0,
            FisheyeMapping::Equisolid => 0.5,
        };
        worst(backwards) + is_dark + (-halfway.direction.z - expected).abs()
    }))
}

fn poles_of_a_panorama() -> f64 {
    let camera = PanoramaCamera::new(pose(77.0, 0.0), [64, 32]).expect("twice as wide as high");
    worst((0..=64).flat_map(|column| {
        [(0.0, DVec3::Y), (32.0, DVec3::NEG_Y)]
            .map(|(y, pole)| camera.ray(f64::from(column), y).direction.distance(pole))
    }))
}

fn one_pixel() -> f64 {
    let edge = |fov_deg: f64| {
        let camera = PinholeCamera::new(PinholeRequest {
            position: DVec3::ZERO,
            azimuth: Radians(0.0),
            elevation: Radians(0.0),
            roll: Radians(0.0),
            horizontal_fov: Radians::from_degrees(fov_deg),
            width_px: 1,
            height_px: 1,
        });
        let camera = camera.expect("a field of view below 180 degrees");
        let middle = camera.ray(0.5, 0.5).direction;
        let is_axis = violations([middle == DVec3::NEG_Z]);
        (camera.ray(0.0, 0.5).direction, is_axis)
    };
    let (narrow, on_axis) = edge(1e-6);
    let (wide, on_wide_axis) = edge(179.999);
    worst([
        relative((-narrow.x).atan2(-narrow.z).to_degrees(), 5e-7) + on_axis,
        relative((-wide.z).atan2(-wide.x).to_degrees(), 5e-4) + on_wide_axis,
    ])
}

fn box_of_no_thickness() -> f64 {
    let sheet = Aabb {
        min: DVec3::ZERO,
        max: DVec3::new(3.0, 0.0, 3.0),
    };
    let through = DVec3::new(1.0, 2.0, 1.0);
    let rays = [
        (through, DVec3::NEG_Y, 0.0),
        (through, DVec3::new(0.3, -1.0, 0.2), 0.0),
        (DVec3::new(-1.0, 0.0, 1.0), DVec3::X, 3.0),
        (DVec3::new(-1.0, 1e-300, 1.0), DVec3::X, 0.0),
    ];
    worst(rays.map(|(origin, direction, expected)| {
        let chord = sheet.intersect(&Ray { origin, direction });
        (chord.map_or(0.0, |(enter, leave)| leave - enter) - expected).abs()
    }))
}

fn through_corners() -> f64 {
    worst([1e-6, 1.0, 3.7, 1e7].map(|size_m| {
        let cube = Aabb {
            min: DVec3::ZERO,
            max: DVec3::splat(size_m),
        };
        let ray = Ray {
            origin: DVec3::splat(-size_m),
            direction: DVec3::ONE.normalize(),
        };
        let chord = cube.intersect(&ray);
        chord.map_or(f64::NAN, |(enter, leave)| {
            relative(leave - enter, size_m * 3_f64.sqrt())
        })
    }))
}
