//! Tests of fields of heights.

use super::*;
use crate::mesh::TriangleMesh;
use crate::mesh_bvh::MeshBvh;

const SPACING_M: f64 = 5.0;

fn field(size: (usize, usize), height_m: impl Fn(DVec3) -> f64) -> HeightField {
    let corner = DVec3::new(-200.0, 30.0, -450.0);
    let places = (0..size.1).flat_map(|z| (0..size.0).map(move |x| (x, z)));
    let at = |(x, z): (usize, usize)| corner + SPACING_M * DVec3::new(x as f64, 0.0, z as f64);
    HeightField::new(HeightMap {
        size,
        height_m: places.map(|place| height_m(at(place)) as f32).collect(),
        spacing_m: SPACING_M,
        corner,
    })
    .unwrap()
}

fn hills(point: DVec3) -> f64 {
    25.0 * (0.031 * point.x).sin() * (0.043 * point.z + 0.01 * point.x).cos() + 0.01 * point.z
}

/// The same triangles as a mesh.
fn mesh_of(field: &HeightField) -> MeshBvh {
    let (n_x, n_z) = field.map.size;
    let places = (0..n_z).flat_map(|z| (0..n_x).map(move |x| (x, z)));
    let corners: Vec<DVec3> = places.map(|(x, z)| field.node(x, z)).collect();
    let cells = (0..n_z - 1).flat_map(|z| (0..n_x - 1).map(move |x| z * n_x + x));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|a| [[a, a + n_x, a + n_x + 1], [a, a + n_x + 1, a + 1]])
        .map(|triangle| triangle.map(|corner| corner as u32))
        .collect();
    MeshBvh::new(TriangleMesh::new(&corners, &triangles).unwrap())
}

/// Rays from around the field, above and below, most of which meet it, and some along the axes.
fn rays(bounds: Aabb, n: u32) -> impl Iterator<Item = Ray> {
    let fraction = |index: u32, step: f64| (f64::from(index) * step).fract();
    let axes = [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y, DVec3::Y];
    (0..n).map(move |index| {
        let f = |step| fraction(index, step);
        let target = bounds.min + bounds.size() * DVec3::new(f(0.7548), f(0.5698), f(0.3247));
        let away = DVec3::new(f(0.6180) - 0.5, f(0.4142) - 0.3, f(0.7320) - 0.5);
        let direction = if index % 16 < 4 {
            axes[index as usize % 16]
        } else {
            -away.normalize()
        };
        let origin = target - 300.0 * f(0.2360) * direction;
        Ray { origin, direction }
    })
}

/// Rays to every node: some from places that have its column, its row or both, so that they go through nodes.
fn rays_to_nodes(field: &HeightField) -> impl Iterator<Item = Ray> {
    let (n_x, n_z) = field.map.size;
    let nodes = (0..n_z).flat_map(move |z| (0..n_x).map(move |x| field.node(x, z)));
    let cell = DVec3::new(SPACING_M, 0.0, SPACING_M);
    let along_nodes = [
        300.0 * DVec3::Y,
        300.0 * DVec3::Y + 40.0 * cell * DVec3::X,
        300.0 * DVec3::Y - 12.0 * cell * DVec3::Z,
        90.0 * DVec3::Y + 30.0 * cell,
        30.0 * DVec3::Y + 30.0 * cell * DVec3::new(-1.0, 0.0, 2.0),
    ];
    nodes.enumerate().flat_map(move |(index, node)| {
        let is_inner = |place: usize, n: usize| place > 0 && place + 1 < n;
        // Whether a ray to the border meets it is up to rounding.
        let n_others = if is_inner(index % n_x, n_x) && is_inner(index / n_x, n_z) {
            20
        } else {
            0
        };
        let others = (0..n_others).map(move |turn| {
            let angle = (20 * index + turn) as f64;
            let way = DVec3::new(angle.cos(), 0.1 + (0.618 * angle).fract(), angle.sin());
            200.0 * way
        });
        let ways = along_nodes.into_iter().chain(others);
        ways.map(move |way| Ray {
            origin: node + way,
            direction: -way.normalize(),
        })
    })
}

/// Whether a point lies between triangles, to within rounding.
fn is_on_edge(field: &HeightField, point: DVec3) -> bool {
    let cells = (point - field.map.corner) / SPACING_M;
    let off = |it: f64| (it - it.round()).abs();
    off(cells.x).min(off(cells.z)).min(off(cells.x - cells.z)) < 1e-9
}

/// Checks rays against a mesh of the same triangles; how many meet it.
fn check_against_mesh(field: &HeightField, rays: impl Iterator<Item = Ray>) -> u32 {
    let mesh = mesh_of(field);
    let mut n_met = 0;
    for ray in rays {
        for after_m in [0.0, 40.0] {
            let found = field.nearest(&ray, after_m);
            let expected = mesh.nearest(&ray, after_m);
            assert_eq!(
                found.is_some(),
                expected.is_some(),
                "{:?} {ray:?}",
                field.map.size
            );
            assert_eq!(field.is_met(&ray, after_m), expected.is_some());
            assert_eq!(mesh.is_met(&ray, after_m), expected.is_some());
            let Some((found, expected)) = found.zip(expected) else {
                continue;
            };
            n_met += 1;
            if is_on_edge(field, ray.at(found.distance_m)) {
                // Of either triangle.
                let off_m = (found.distance_m - expected.distance_m).abs();
                assert!(off_m <= 1e-12 * expected.distance_m, "{ray:?} {off_m}");
            } else {
                // Stored corners are the same, so that distances are too.
                assert_eq!(found.distance_m, expected.distance_m, "{ray:?}");
                assert!(found.normal.distance(expected.normal) < 1e-9);
                assert_eq!(found.is_from_below, expected.is_from_inside);
            }
        }
    }
    n_met
}

#[test]
fn a_field_is_met_where_its_triangles_are_met_as_a_mesh() {
    for size in [(2, 2), (5, 2), (64, 97), (65, 33)] {
        let field = field(size, hills);
        let n_met = check_against_mesh(&field, rays(field.bounds(), 4000));
        assert!(n_met > 1000, "{size:?}: {n_met}");
    }
}

#[test]
fn no_ray_slips_between_cells_at_nodes_and_borders() {
    for size in [(2, 2), (5, 2), (41, 30), (33, 65)] {
        let field = field(size, hills);
        let n_met = check_against_mesh(&field, rays_to_nodes(&field));
        assert!(n_met > 0, "{size:?}: {n_met}");
    }
}

#[test]
fn a_tilted_plane_is_met_where_algebra_says() {
    let slope = |point: DVec3| 0.3 * point.x - 0.2 * point.z;
    let plane = field((80, 90), slope);
    let normal = DVec3::new(-0.3, 1.0, 0.2).normalize();
    for ray in rays(plane.bounds(), 2000) {
        let Some(hit) = plane.nearest(&ray, 0.0) else {
            continue;
        };
        let point = ray.origin + hit.distance_m * ray.direction;
        // Heights in f32: 1e-5 m.
        let off_m = (point.y - 30.0 - slope(point)).abs();
        assert!(off_m < 2e-5, "{off_m}");
        // Worst found 5e-6, of heights in f32.
        assert!(hit.normal.distance(normal) < 2e-5);
        assert!(hit.smooth_normal.distance(normal) < 2e-5);
    }
}

#[test]
fn a_paraboloid_errs_by_the_sagitta_of_its_cells() {
    let bowl = |point: DVec3| 1e-3 * (point.x * point.x + point.z * point.z);
    let field = field((80, 90), bowl);
    let mut n_met = 0;
    for ray in rays(field.bounds(), 2000) {
        let Some(hit) = field.nearest(&ray, 0.0) else {
            continue;
        };
        n_met += 1;
        let point = ray.origin + hit.distance_m * ray.direction;
        // A chord lies s²/8 times the second derivative above, along the diagonal twice that.
        let above_m = point.y - 30.0 - bowl(point);
        assert!(
            (-2e-5..=2e-3 * SPACING_M * SPACING_M / 4.0).contains(&above_m),
            "{above_m}"
        );
        let inside = |value: f64, low: f64, n: usize| {
            let cells = (value - low) / SPACING_M;
            (1.0..n as f64 - 2.0).contains(&cells)
        };
        if inside(point.x, -200.0, 80) && inside(point.z, -450.0, 90) {
            // Central differences are exact for it, and linear between nodes.
            let normal = DVec3::new(-2e-3 * point.x, 1.0, -2e-3 * point.z).normalize();
            assert!(hit.smooth_normal.distance(normal) < 2e-5);
        }
    }
    assert!(n_met > 500, "{n_met}");
}

#[test]
fn heights_that_make_no_surface_are_refused() {
    let map = |size, height_m| HeightMap {
        size,
        height_m,
        spacing_m: 1.0,
        corner: DVec3::ZERO,
    };
    for (size, n) in [((1, 5), 5), ((5, 1), 5), ((2, 2), 3), ((usize::MAX, 2), 4)] {
        let found = HeightField::new(map(size, vec![0.0; n]));
        assert!(matches!(found, Err(Error::HeightCount { .. })), "{size:?}");
    }
    let nan = vec![0.0, 1.0, 2.0, 3.0, f32::NAN, 5.0];
    let found = HeightField::new(map((3, 2), nan));
    assert_eq!(found, Err(Error::HeightNotFinite { x: 1, z: 1 }));
}

/// Horizontal directions, those along the axes and the diagonals of cells among them.
fn around(n: u32) -> impl Iterator<Item = DVec3> {
    let eighths = (0..8).map(f64::from);
    let others = (0..n).map(|index| 8.0 * (f64::from(index) * 0.618).fract());
    let angle = |eighth: f64| std::f64::consts::FRAC_PI_4 * eighth;
    let exact = [DVec3::X, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Z];
    let angles = eighths.chain(others).map(angle);
    let directions = angles.map(|it| DVec3::new(it.cos(), 0.0, it.sin()));
    exact.into_iter().chain(directions)
}

#[test]
fn the_horizon_stands_where_rays_begin_to_miss_the_surface() {
    for size in [(2, 2), (5, 2), (64, 97), (65, 33)] {
        let field = field(size, hills);
        let bounds = field.bounds();
        for index in 0..40 {
            let fraction = |step: f64| (f64::from(index) * step).fract();
            let place = bounds.size() * DVec3::new(fraction(0.7548), 0.0, fraction(0.5698));
            let mut from = bounds.min + place;
            // Some stand on the highest ground, where nothing rises above them.
            from.y = bounds.max.y + 1.0;
            let below = Ray {
                origin: from,
                direction: DVec3::NEG_Y,
            };
            let to_ground_m = field.nearest(&below, 0.0).unwrap().distance_m;
            from.y -= (to_ground_m - 1e-4).max(0.0) * fraction(0.3247).max(0.2);
            for along in around(20) {
                let horizon = field.horizon(from, along, 0.0);
                let is_met = |tangent: f64| {
                    let direction = (along + tangent * DVec3::Y).normalize();
                    let ray = Ray {
                        origin: from,
                        direction,
                    };
                    field.is_met(&ray, 0.0)
                };
                assert!(horizon >= 0.0 && horizon.is_finite());
                for least in [0.5 * horizon, horizon + 0.1] {
                    assert_eq!(field.horizon(from, along, least), horizon.max(least));
                }
                assert!(!is_met(horizon + 1e-7), "{size:?} {from} {along} {horizon}");
                if horizon > 0.0 {
                    assert!(is_met(horizon - 1e-7), "{size:?} {from} {along} {horizon}");
                }
            }
        }
    }
}

#[test]
fn on_a_tilted_plane_the_horizon_is_its_own_rise() {
    let field = field((40, 50), |point| 0.3 * point.x - 0.2 * point.z);
    let middle = 0.5 * (field.bounds().min + field.bounds().max);
    let below = Ray {
        origin: middle + 1e3 * DVec3::Y,
        direction: DVec3::NEG_Y,
    };
    let from = middle + (1e3 - field.nearest(&below, 0.0).unwrap().distance_m) * DVec3::Y;
    for along in around(20) {
        let expected = (0.3 * along.x - 0.2 * along.z).max(0.0);
        // Heights are f32.
        let found = field.horizon(from, along, 0.0);
        assert!(
            (found - expected).abs() < 2e-5,
            "{along}: {found} {expected}"
        );
    }
    // Beside the field and turned from it there is nothing.
    let outside = field.bounds().max + DVec3::new(1.0, -40.0, 1.0);
    assert_eq!(field.horizon(outside, DVec3::X, 0.0), 0.0);
    assert!(field.horizon(outside, DVec3::new(-0.28, 0.0, -0.96), 0.0) > 0.0);
}
