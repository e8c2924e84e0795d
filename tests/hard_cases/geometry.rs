//! Hard cases of rays, the planet and meshes: heights of millimetres over a planet, rays along faces
//! and through corners, bodies 1000 km away, open and degenerate meshes.

use glam::DVec3;
use niji_geometry::Aabb;
use niji_geometry::Camera;
use niji_geometry::EARTH;
use niji_geometry::MeshBvh;
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
