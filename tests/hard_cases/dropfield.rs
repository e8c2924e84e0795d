//! Hard cases of drop volumes: voxels without drops or without size, mixtures, contrasts of 1e9,
//! places that are none, values in files that cannot be.

use glam::DVec3;
use niji_dropfield::AreaMoments;
use niji_dropfield::Bricks;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::Error;
use niji_dropfield::GridBox;
use niji_dropfield::Interpolation;
use niji_dropfield::Sample;
use niji_dropfield::Warning;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Leaf;
use niji_vdb::Tile;
use niji_vdb::TileLevel;
use niji_vdb::Transform;
use niji_vdb::VdbFile;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "halfway between drops of 1.0 mm and of 0.1 mm lies their mixture",
        measure: "relative error of extinction, water and r_e, error of v_e",
        allowed: 1e-6,
        error: mixed_voxels,
    },
    HardCase {
        claim: "variance survives a contrast of 1e9 in number from node to node",
        measure: "error of v_e",
        // Of f32 moments; measured 3.9e-7.
        allowed: 1e-6,
        error: contrast,
    },
    HardCase {
        claim: "voxels without a number or a size of drops divide nothing by zero",
        measure: "samples that are not finite, or negative",
        allowed: 0.0,
        error: nothing_next_to_drops,
    },
    HardCase {
        claim: "one drop of 1 um and 1e15 of 10 cm have moments in the range of f32",
        measure: "relative error of r_e",
        allowed: 1e-6,
        error: range_of_moments,
    },
    HardCase {
        claim: "NaN, infinities and places 1e300 m away are outside of every volume",
        measure: "samples with drops",
        allowed: 0.0,
        error: places_that_are_none,
    },
    HardCase {
        claim: "NaN, infinite and negative voxels of a file are refused",
        measure: "accepted files",
        allowed: 0.0,
        error: impossible_voxels,
    },
    HardCase {
        claim: "a few bytes of tiles cannot ask for all memory",
        measure: "files without the error",
        allowed: 0.0,
        error: tiles_without_end,
    },
    HardCase {
        claim: "boxes of no size, of 1e30 voxels and inside out are refused",
        measure: "accepted boxes",
        allowed: 0.0,
        error: impossible_boxes,
    },
    HardCase {
        claim: "along edges, in faces and through corners of cells a ray has the column of its nodes",
        measure: "relative error of the column",
        // Of f32 moments.
        allowed: 2e-6,
        error: along_edges,
    },
    HardCase {
        claim: "one voxel of a micrometre and of 10000 km is the same tent",
        measure: "relative error of M2 and of the column",
        allowed: 2e-6,
        error: smallest_and_largest_voxel,
    },
    HardCase {
        claim: "beside 1e9 drops in a cubic metre the 1e-30 of the next node keep their digits",
        measure: "relative error of the moments at the node and halfway",
        allowed: 1e-6,
        error: nearly_nothing_next_to_much,
    },
    HardCase {
        claim: "a file of zeros is a volume without drops that says so",
        measure: "files that are not",
        allowed: 0.0,
        error: file_of_zeros,
    },
];

const INTERPOLATIONS: [Interpolation; 2] = [Interpolation::Moments, Interpolation::RadiusDensity];

fn drops(number_density_m3: f32, effective_radius_m: f32, effective_variance: f32) -> Drops {
    Drops {
        number_density_m3,
        effective_radius_m,
        effective_variance,
    }
}

/// Two voxels of 1 m in a row, with nodes at x = 0.5 and 1.5.
fn two_voxels(left: Drops, right: Drops) -> DropMode {
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::new(2.0, 1.0, 1.0),
        voxel_m: 1.0,
    };
    DropMode::from_fn("", &grid, |at| if at.x < 1.0 { left } else { right })
        .expect("the cases lay out possible drops")
}

fn bricks(mode: &DropMode, interpolation: Interpolation) -> Bricks {
    Bricks::build(mode, interpolation).expect("the cases lay out a few voxels")
}

/// At `x` between two nodes.
fn between(bricks: &Bricks, x: f64) -> AreaMoments {
    bricks.sample(DVec3::new(x, 0.5, 0.5)).moments()
}

fn mixed_voxels() -> f64 {
    let mode = two_voxels(drops(1000.0, 1e-3, 0.0), drops(1000.0, 1e-4, 0.0));
    let found = between(&bricks(&mode, Interpolation::Moments), 1.0);
    // 500 drops of either size: pi r^2 is 3.1416e-6 and 3.1416e-8 m^2, 4/3 pi r^3 is 4.18879e-3 and
    // 4.18879e-6 g; r_e = (1 + 1e-3)/(1 + 1e-2) mm, v_e = (1 + 1e-4)(1 + 1e-2)/(1 + 1e-3)^2 - 1.
    let variance = 1.0001 * 1.01 / 1.001_f64.powi(2) - 1.0;
    let extinction_m1 = 500.0 * (3.141_592_65e-6 + 3.141_592_65e-8);
    let water_g_m3 = 500.0 * (4.188_790_20e-3 + 4.188_790_20e-6);
    worst([
        relative(found.extinction_m1_q1(), extinction_m1),
        relative(found.liquid_water_g_m3(), water_g_m3),
        relative(f64::from(found.effective_radius_um()), 1001.0 / 1.01),
        (f64::from(found.effective_variance()) - variance).abs(),
    ])
}

fn contrast() -> f64 {
    let laws = [0.0, 0.02, 1.0 / 3.0]
        .into_iter()
        .flat_map(|variance| [1e-6, 3.3e-5, 1.6e-3].map(|radius_m| (radius_m, variance)));
    worst(laws.flat_map(|(radius_m, variance)| {
        let mode = two_voxels(
            drops(1.0, radius_m, variance),
            drops(1e9, radius_m, variance),
        );
        let bricks = bricks(&mode, Interpolation::Moments);
        let places = (0..=1000).map(|step| 0.5 + f64::from(step) / 1000.0);
        let errors = places.map(|x| between(&bricks, x).effective_variance() - variance);
        errors
            .map(|error| f64::from(error.abs()))
            .collect::<Vec<_>>()
    }))
}

fn nothing_next_to_drops() -> f64 {
    let kinds = [
        drops(1000.0, 1e-3, 0.1),
        drops(0.0, 1e-3, 0.1),
        drops(1000.0, 0.0, 0.0),
        Drops::NONE,
    ];
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::splat(12.0),
        voxel_m: 1.0,
    };
    let field = |at: DVec3| kinds[(at.x + 3.0 * at.y + 5.0 * at.z) as usize % kinds.len()];
    let mode = DropMode::from_fn("", &grid, field).expect("the cases lay out possible drops");
    let n_violations = INTERPOLATIONS.map(|interpolation| {
        let bricks = bricks(&mode, interpolation);
        violations((0..20_000).map(|step| {
            let step = f64::from(step);
            let fractions = DVec3::new(0.7548, 0.5698, 0.3247) * step;
            let moments = bricks.sample(14.0 * fractions.fract() - 1.0).moments();
            let radius = moments.effective_radius_um();
            [moments.m2, moments.m3, moments.m4, radius]
                .into_iter()
                .all(|value| value.is_finite() && value >= 0.0)
        }))
    });
    n_violations.into_iter().sum()
}

fn range_of_moments() -> f64 {
    worst(
        [(1.0, 1e-6), (1e9, 1.6e-3), (1e15, 0.1)].map(|(number, radius_m)| {
            let moments = AreaMoments::from_drops(&drops(number, radius_m, 0.0));
            let normal = [moments.m2, moments.m3, moments.m4].map(f32::is_normal);
            let radius_um = f64::from(moments.effective_radius_um());
            relative(radius_um, 1e6 * f64::from(radius_m)) + violations(normal)
        }),
    )
}

fn places_that_are_none() -> f64 {
    let mode = two_voxels(drops(1e3, 1e-3, 0.0), drops(1e3, 1e-3, 0.0));
    let bricks = bricks(&mode, Interpolation::Moments);
    let inside = DVec3::new(1.0, 0.5, 0.5);
    let none = [DVec3::NAN, DVec3::INFINITY, DVec3::NEG_INFINITY];
    // Powers of two that could come round to the volume again.
    let far = (6..=1023).flat_map(|power| {
        let far = 2_f64.powi(power);
        [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .flat_map(move |axis| [inside + far * axis, inside - far * axis])
    });
    let outside = none.into_iter().chain(far);
    violations(outside.map(|place| bricks.sample(place) == Sample::default()))
        + violations([bricks.m2(inside) > 0.0])
}

/// Grids as another program writes them: numbers in a tree, one radius as a background.
fn foreign(number: FloatTree, radius_m: f32) -> VdbFile {
    let transform = Transform::uniform_scale_translate(0.5, DVec3::ZERO);
    let radius = FloatTree::new(radius_m);
    VdbFile::new(vec![
        Grid::new("number_density", FOG_VOLUME, transform, number),
        Grid::new("effective_radius", FOG_VOLUME, transform, radius),
    ])
}

fn impossible_voxels() -> f64 {
    let file = |number: f32, radius_m: f32| {
        let mut leaf = Leaf::new([0, 8, 16], 0.0);
        leaf.set([3, 9, 17], number);
        let tree = FloatTree::from_leaves(0.0, vec![leaf]).expect("one leaf");
        foreign(tree, radius_m)
    };
    let bad = [
        (-1.0, 1e-4),
        (f32::NAN, 1e-4),
        // What 16 bits overflow to.
        (f32::INFINITY, 1e-4),
        (1e3, -1e-4),
        (1e3, f32::NAN),
        (1e3, 100.0),
    ];
    let refused =
        bad.map(|(number, radius_m)| DropVolume::from_vdb(&file(number, radius_m)).is_err());
    violations(refused) + violations([DropVolume::from_vdb(&file(1e3, 1e-4)).is_ok()])
}

fn tiles_without_end() -> f64 {
    let tile = Tile {
        origin: [0; 3],
        level: TileLevel::Upper,
        active: true,
        value: 1.0,
    };
    let far = Leaf::new([i32::MAX - 7, 0, 0], 0.0);
    let trees = [
        FloatTree::from_parts(0.0, vec![], vec![tile]).expect("one tile"),
        FloatTree::new(1.0),
        FloatTree::from_leaves(0.0, vec![far]).expect("one leaf"),
    ];
    let [tile, background, far] = trees.map(|tree| DropVolume::from_vdb(&foreign(tree, 1e-4)));
    violations([
        matches!(tile, Err(Error::TooManyNodes { .. })),
        matches!(background, Err(Error::Background { .. })),
        matches!(far, Err(Error::TooFar { .. })),
    ])
}

fn impossible_boxes() -> f64 {
    let boxes = [
        (DVec3::ONE, 1e-10),
        (DVec3::ONE, 0.0),
        (DVec3::ONE, f64::NAN),
        (DVec3::ZERO, 1.0),
        (DVec3::NEG_ONE, 1.0),
        (DVec3::INFINITY, 1.0),
        (DVec3::NAN, 1.0),
    ];
    violations(boxes.map(|(max, voxel_m)| {
        let min = DVec3::ZERO;
        let grid = GridBox { min, max, voxel_m };
        DropMode::from_fn("", &grid, |_| Drops::NONE).is_err()
    }))
}

/// M2 integrated along a ray from outside to outside of all drops.
fn column(bricks: &Bricks, origin: DVec3, direction: DVec3) -> f64 {
    // Simpson's rule is exact for a cubic.
    let segments = bricks.segments(origin, direction, (0.0, 1e9));
    let of_segment = |cell: niji_dropfield::Segment<'_>| {
        let [enter, middle, leave] = [0.0, 0.5, 1.0].map(|part| f64::from(cell.sample(part).m2));
        (cell.t_exit - cell.t_enter) * (enter + 4.0 * middle + leave) / 6.0
    };
    segments.map(of_segment).sum()
}

/// A cube of `n` voxels a side of the same drops.
fn even_cube(n: f64, voxel_m: f64) -> Bricks {
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::splat(n * voxel_m),
        voxel_m,
    };
    let mode = DropMode::from_fn("", &grid, |_| drops(1000.0, 1e-4, 0.0));
    bricks(&mode.expect("a few voxels"), Interpolation::Moments)
}

/// M2 of 1000 drops of 0.1 mm in a cubic metre, um²/m³.
const EVEN_M2: f64 = 1e7;

fn along_edges() -> f64 {
    let bricks = even_cube(20.0, 0.5);
    // Nodes stand at 0.25, 0.75, … 9.75. Along an edge of cells or in a face of theirs: 20 nodes of
    // 0.5 m. Through their corners: 19 cells and at both ends the tent's cube, 1/4 of one.
    let corners = (19.0 + 0.5) * 0.5 * 3_f64.sqrt();
    let rays = [
        (DVec3::new(-3.0, 5.25, 5.25), DVec3::X, 10.0),
        (DVec3::new(5.25, -3.0, 5.1), DVec3::Y, 10.0),
        (DVec3::new(5.0, 5.0, 13.0), DVec3::NEG_Z, 10.0),
        (DVec3::splat(-2.75), DVec3::ONE.normalize(), corners),
        (DVec3::splat(12.75), DVec3::NEG_ONE.normalize(), corners),
        // Along the outermost edge of nodes.
        (DVec3::new(-3.0, 0.25, 9.75), DVec3::X, 10.0),
    ];
    worst(rays.map(|(origin, direction, length_m)| {
        relative(column(&bricks, origin, direction), EVEN_M2 * length_m)
    }))
}

fn smallest_and_largest_voxel() -> f64 {
    worst([1e-6, 1.0, 1e7].map(|voxel_m| {
        let tent = even_cube(1.0, voxel_m);
        let node = DVec3::splat(0.5 * voxel_m);
        let from = DVec3::new(-voxel_m, 0.5 * voxel_m, 0.5 * voxel_m);
        // A tent of base 2 has the column of its voxel; off the node by a quarter 3/4, by a half of
        // two axes 1/4.
        let at = |off: DVec3| f64::from(tent.m2(node + voxel_m * off));
        worst([
            relative(column(&tent, from, DVec3::X), EVEN_M2 * voxel_m),
            relative(at(DVec3::ZERO), EVEN_M2),
            relative(at(DVec3::new(0.25, 0.0, 0.0)), 0.75 * EVEN_M2),
            relative(at(DVec3::new(0.5, 0.0, -0.5)), 0.25 * EVEN_M2),
            at(DVec3::new(1.001, 0.0, 0.0)),
        ])
    }))
}

fn nearly_nothing_next_to_much() -> f64 {
    let mode = two_voxels(drops(1e9, 1e-3, 0.0), drops(1e-30, 1e-3, 0.0));
    let bricks = bricks(&mode, Interpolation::Moments);
    // N r^k at the node, and half of the many halfway.
    let [at_node, halfway] = [1.5, 1.0].map(|x| between(&bricks, x));
    worst([
        relative(f64::from(at_node.m2) / 1e6, 1e-30),
        relative(f64::from(at_node.effective_radius_um()), 1000.0),
        relative(f64::from(halfway.m2) / 1e6, 5e8),
        relative(f64::from(halfway.effective_radius_um()), 1000.0),
    ])
}

fn file_of_zeros() -> f64 {
    let mut leaf = Leaf::new([0, 8, 16], 0.0);
    leaf.set([3, 9, 17], 0.0);
    let trees = [
        FloatTree::from_leaves(0.0, vec![leaf]).expect("one leaf"),
        FloatTree::new(0.0),
    ];
    violations(trees.map(|tree| {
        let volume = DropVolume::from_vdb(&foreign(tree, 1e-4));
        volume.is_ok_and(|volume| {
            let is_said = volume.summary().warnings == [Warning::Empty];
            let bricks = volume
                .modes
                .iter()
                .map(|mode| bricks(mode, Interpolation::Moments));
            is_said
                && bricks
                    .into_iter()
                    .all(|bricks| bricks.world_bounds().is_none())
        })
    }))
}
