//! Tests of the tree over a mesh.

use super::*;
use crate::covered_slopes::CoveredSlopes;

/// A bumpy ball of 8 x 4^5 triangles.
fn ball() -> MeshBvh {
    let mut corners = vec![
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ];
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    for _ in 0..5 {
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let middles = [(a, b), (b, c), (c, a)].map(|(from, to)| {
                let middle = corners[from as usize] + corners[to as usize];
                corners.push(middle.normalize());
                corners.len() as u32 - 1
            });
            let [ab, bc, ca] = middles;
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let bumpy = |corner: &DVec3| *corner * (1.0 + 0.1 * (9.0 * corner.x).sin());
    let corners: Vec<DVec3> = corners.iter().map(bumpy).collect();
    MeshBvh::new(
        TriangleMesh::new(&corners, &triangles)
            .unwrap()
            .into_body()
            .unwrap(),
    )
}

/// Directions and offsets without a pattern.
fn rays(n: u32) -> impl Iterator<Item = Ray> {
    (0..n).map(|index| {
        let fraction = |step: f64| (f64::from(index) * step).fract() * 2.0 - 1.0;
        let towards = 0.7 * DVec3::new(fraction(0.7548), fraction(0.5698), fraction(0.3247));
        let origin = 3.0 * DVec3::new(fraction(0.6180), fraction(0.4142), 1.1);
        let direction = (towards - origin).normalize();
        Ray { origin, direction }
    })
}

#[test]
fn the_tree_finds_what_a_search_through_all_triangles_finds() {
    let ball = ball();
    for ray in rays(300) {
        let sheared = ShearedRay::new(&ray).unwrap();
        let all = (0..ball.mesh().triangles().len())
            .filter_map(|index| Some((sheared.meet(ball.mesh().corners(index))?.0, index)))
            .filter(|(distance_m, _)| *distance_m > 0.0)
            .min_by(|a, b| a.partial_cmp(b).unwrap());
        let found = ball.nearest(&ray, 0.0);
        assert_eq!(found.map(|hit| (hit.distance_m, hit.triangle_index)), all);
    }
}

#[test]
fn rays_from_inside_always_get_out_even_through_corners_and_edges() {
    let ball = ball();
    let corners = ball.mesh().vertices().iter().copied();
    let [a, b] = [0, 1].map(|corner| {
        let triangles = ball.mesh().triangles().iter();
        triangles.map(move |triangle| triangle[corner])
    });
    let edges = a.zip(b).map(|(a, b)| {
        let vertices = ball.mesh().vertices();
        0.5 * (vertices[a as usize] + vertices[b as usize])
    });
    for target in corners.chain(edges) {
        for origin in [DVec3::ZERO, DVec3::new(0.1, 0.2, -0.3)] {
            let direction = target - origin;
            let hit = ball.nearest(&Ray { origin, direction }, 0.0).unwrap();
            assert!(hit.is_from_inside && hit.normal.dot(direction) > 0.0);
            // Worst found 4e-16.
            assert!((hit.distance_m - 1.0).abs() < 2e-15 || hit.distance_m < 1.0);
        }
    }
}

#[test]
fn a_ray_enters_and_leaves_in_turns() {
    let ball = ball();
    for ray in rays(300) {
        let (mut after_m, mut is_inside) = (0.0, false);
        while let Some(hit) = ball.nearest(&ray, after_m) {
            assert_eq!(hit.is_from_inside, is_inside);
            is_inside = !is_inside;
            after_m = hit.distance_m;
        }
        assert!(!is_inside);
    }
}

#[test]
fn rays_within_a_face_are_settled() {
    let cube = MeshBvh::new(TriangleMesh::of_box(Aabb {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    }));
    let ray = |origin, direction| Ray { origin, direction };
    // Within the top face: it meets the side faces only, where the slabs multiply 0 by infinity.
    let within = cube.nearest(&ray(DVec3::new(-1.0, 1.0, 0.3), DVec3::X), 0.0);
    assert_eq!(
        within.map(|hit| (hit.distance_m, hit.normal)),
        Some((1.0, -DVec3::X))
    );
    let denormal = DVec3::new(5e-324, -5e-324, 1.0);
    let hit = cube.nearest(&ray(DVec3::new(0.5, 0.4, -1.0), denormal), 0.0);
    assert_eq!(hit.map(|hit| hit.distance_m), Some(1.0));
}

#[test]
fn slivers_and_bodies_far_from_the_origin_are_met() {
    let cube = TriangleMesh::of_box(Aabb {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    });
    let far = MeshBvh::new(cube.moved(|corner| corner + 1e6).unwrap());
    let origin = DVec3::new(-1e6, 1e6 + 0.25, 1e6 + 0.5);
    let ray = Ray {
        origin,
        direction: DVec3::X,
    };
    assert_eq!(far.nearest(&ray, 0.0).map(|hit| hit.distance_m), Some(2e6));
    let flat = cube
        .moved(|corner| corner * DVec3::new(1.0, 1e-14, 1.0))
        .unwrap();
    let ray = Ray {
        origin: DVec3::new(0.3, 1.0, 0.4),
        direction: DVec3::NEG_Y,
    };
    let hit = MeshBvh::new(flat).nearest(&ray, 0.0).unwrap();
    assert!(hit.distance_m < 1.0 && !hit.is_from_inside);
}

#[test]
fn what_a_mesh_covers_is_where_rays_meet_it() {
    let ball = ball();
    let (mut n_met, mut n_missed) = (0, 0);
    for (index, ray) in (0..).zip(rays(100)) {
        // Above the ball, beside it and in it.
        let from = ray.origin * (f64::from(index) / 70.0);
        for eighth in 0..8 {
            let turn = std::f64::consts::FRAC_PI_4 * f64::from(eighth) + f64::from(index);
            let along = DVec3::new(turn.cos(), 0.0, turn.sin());
            let range = -2.0..3.0 + 0.1 * f64::from(index);
            let mut covered = CoveredSlopes::all_but(range.clone());
            ball.cover(from, along, &mut covered);
            let gaps: Vec<_> = covered.gaps().collect();
            for step in -24..60 {
                let slope = 0.1 * f64::from(step) + 0.0123;
                let direction = (along + slope * DVec3::Y).normalize();
                let ray = Ray {
                    origin: from,
                    direction,
                };
                let is_free = range.contains(&slope) && !ball.is_met(&ray, 0.0);
                let found = gaps.iter().any(|gap| gap.contains(&slope));
                assert_eq!(found, is_free, "{from} {along} {slope} {gaps:?}");
                n_met += usize::from(range.contains(&slope) && !is_free);
                n_missed += usize::from(is_free);
            }
        }
    }
    assert!(n_met > 1000 && n_missed > 1000, "{n_met} {n_missed}");
}

#[test]
fn a_convex_body_covers_nothing_in_front_of_its_faces() {
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 0.7, -0.3);
    let cube = TriangleMesh::of_box(Aabb {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    });
    let cube = MeshBvh::new(cube.moved(|corner| turn * corner).unwrap());
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for end in [0.0, 1.0] {
            let outwards = turn * (axis * (2.0 * end - 1.0));
            for (a, b) in [(0.2, 0.3), (0.5, 0.5), (0.9, 0.1)] {
                let aside = DVec3::new(axis.z, axis.x, axis.y) * a;
                let inside = axis * end + aside + DVec3::new(axis.y, axis.z, axis.x) * b;
                let from = turn * inside + 1e-5 * outwards;
                for sixteenth in 0..16 {
                    let angle = std::f64::consts::FRAC_PI_8 * f64::from(sixteenth) + 0.1;
                    let along = DVec3::new(angle.cos(), 0.0, angle.sin());
                    let own = -outwards.dot(along) / outwards.y;
                    let slopes = if outwards.y > 0.0 {
                        own.max(0.0)..f64::INFINITY
                    } else {
                        0.0..own.max(0.0)
                    };
                    let mut covered = CoveredSlopes::all_but(slopes);
                    let before = covered.clone();
                    cube.cover(from, along, &mut covered);
                    assert_eq!(covered.gaps().count(), before.gaps().count());
                    for (found, expected) in covered.gaps().zip(before.gaps()) {
                        assert!((found.start.atan() - expected.start.atan()).abs() < 1e-12);
                        assert!((found.end.atan() - expected.end.atan()).abs() < 1e-12);
                    }
                }
            }
        }
    }
}
