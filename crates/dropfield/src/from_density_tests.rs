//! Claims about drops out of other programs' density grids.

use std::f64::consts::PI;

use glam::DMat3;
use glam::DVec3;
use half::f16;
use niji_vdb::FOG_VOLUME;
use niji_vdb::TileLevel;
use niji_vdb::Transform;

use super::*;

/// f32 numbers and moments: half a unit in the last place of each; measured worst 9e-8.
const F32_TOLERANCE: f64 = 2e-7;

const VOXEL_M: f64 = 0.5;

fn import(density_means: DensityMeans, scale: f64) -> DensityImport {
    DensityImport::in_metres((density_means, scale), EffectiveRadius::Um(12.0), 0.15)
}

/// `<r²>` (m²) and `<r³>` (m³) of the law of [`import`], from its gamma integrals.
fn mean_squares() -> (f64, f64) {
    let r_e = 12e-6_f64;
    let mean_r2 = r_e * r_e * 0.85 * 0.70;
    (mean_r2, r_e * mean_r2)
}

fn transform() -> Transform {
    Transform::uniform_scale_translate(VOXEL_M, DVec3::new(10.0, -3.0, 1.0))
}

fn file(trees: Vec<(&str, Tree)>) -> VdbFile {
    let grid = |(name, tree)| Grid::new(name, FOG_VOLUME, transform(), tree);
    VdbFile::new(trees.into_iter().map(grid).collect())
}

/// Two voxels on a line along z, a third beside them, in two leaves.
fn three_voxels() -> FloatTree {
    let (mut low, mut high) = (Leaf::new([0; 3], 0.0), Leaf::new([0, 0, 8], 0.0));
    low.set([1, 2, 3], 0.25);
    low.set([4, 4, 4], 0.875);
    high.set([1, 2, 9], 0.75);
    FloatTree::from_leaves(0.0, vec![low, high]).unwrap()
}

fn volume(tree: impl Into<Tree>, import: &DensityImport) -> Result<DropVolume, Error> {
    DropVolume::from_density(&file(vec![("density", tree.into())]), "density", import)
}

fn assert_close(found: f64, expected: f64) {
    let error = found / expected - 1.0;
    assert!(error.abs() < F32_TOLERANCE, "{found} against {expected}");
}

#[test]
fn each_meaning_is_its_closed_form() {
    let (mean_r2, mean_r3) = mean_squares();
    let water_per_drop_g = 4.0 / 3.0 * PI * 1e6 * mean_r3;
    let extinction_per_drop_m2 = 2.0 * PI * mean_r2;
    // The line along z sums to 1, more than the lone voxel.
    let cases = [
        (DensityMeans::Number, 3e8, 3e8),
        (DensityMeans::Water, 0.3, 0.3 / water_per_drop_g),
        (
            DensityMeans::Extinction,
            0.02,
            0.02 / extinction_per_drop_m2,
        ),
        (
            DensityMeans::OpticalDepth,
            4.0,
            4.0 / (extinction_per_drop_m2 * 1.0 * VOXEL_M),
        ),
    ];
    for (means, scale, number_per_value) in cases {
        let volume = volume(three_voxels(), &import(means, scale)).unwrap();
        let mode = &volume.modes[0];
        for (voxel, value) in [([1, 2, 3], 0.25), ([4, 4, 4], 0.875), ([1, 2, 9], 0.75)] {
            let drops = mode.drops(voxel);
            assert_close(f64::from(drops.number_density_m3), number_per_value * value);
            assert_eq!(
                (drops.effective_radius_m, drops.effective_variance),
                (12e-6, 0.15)
            );
        }
        assert_eq!(mode.nodes().count(), 3);
        assert_close(
            mode.total_drops(),
            number_per_value * 1.875 * VOXEL_M.powi(3),
        );
        assert_eq!(mode.node_position([0; 3]), DVec3::new(10.0, -3.0, 1.0));
    }
}

#[test]
fn water_extinction_and_optical_depth_come_back_in_the_summary() {
    let summary = |means, scale| {
        volume(three_voxels(), &import(means, scale))
            .unwrap()
            .summary()
    };
    assert_close(summary(DensityMeans::Water, 0.8).max_liquid_water_g_m3, 0.7);
    let extinction_q1 = summary(DensityMeans::Extinction, 0.08).max_extinction_m1_q1;
    assert_close(2.0 * extinction_q1, 0.07);
    let depths = summary(DensityMeans::OpticalDepth, 3.0).optical_depth_q1;
    // The lone voxel is the largest along the other axes.
    for (depth_q1, expected) in depths.into_iter().zip([0.875 * 3.0, 0.875 * 3.0, 3.0]) {
        assert_close(2.0 * depth_q1, expected);
    }
}

#[test]
fn totals_scale_with_the_scale() {
    for means in [
        DensityMeans::Number,
        DensityMeans::Water,
        DensityMeans::Extinction,
        DensityMeans::OpticalDepth,
    ] {
        let water = |scale| {
            let volume = volume(three_voxels(), &import(means, scale)).unwrap();
            volume.modes[0].total_water_g()
        };
        assert_close(water(0.7), 7.0 * water(0.1));
    }
}

#[test]
fn a_written_volume_comes_back_from_its_display_density() {
    let drops = volume(three_voxels(), &import(DensityMeans::Water, 0.5)).unwrap();
    let file = drops.to_vdb(&[]).unwrap();
    let display = import(DensityMeans::Extinction, 1.0);
    let again = DropVolume::from_density(&file, "density", &display).unwrap();
    for (node, drops) in drops.modes[0].nodes() {
        let number = again.modes[0].drops(node).number_density_m3;
        assert_close(f64::from(number), f64::from(drops.number_density_m3));
    }
}

/// A tree of one voxel.
fn one<T: Value>(background: T, value: T) -> Tree
where
    Tree: From<SparseTree<T>>,
{
    let mut leaf = Leaf::new([0; 3], background);
    leaf.set([1, 2, 3], value);
    Tree::from(SparseTree::from_leaves(background, vec![leaf]).unwrap())
}

#[test]
fn every_scalar_type_is_read() {
    let import = import(DensityMeans::Number, 2.0);
    let number = |tree: Tree| {
        let volume = volume(tree, &import).unwrap();
        volume.modes[0].drops([1, 2, 3]).number_density_m3
    };
    assert_eq!(number(one(0.0_f32, 1.5)), 3.0);
    assert_eq!(number(one(0.0_f64, 1.5)), 3.0);
    assert_eq!(number(one(f16::ZERO, f16::from_f32(1.5))), 3.0);
    assert_eq!(number(one(0_i32, 7)), 14.0);
    assert_eq!(number(one(false, true)), 2.0);
    let error = volume(one([0.0_f32; 3], [1.0; 3]), &import).unwrap_err();
    assert!(matches!(error, Error::NotScalar { .. }), "{error}");
    // A double beyond the range of f32 is no density either.
    let error = volume(one(0.0_f64, 1e300), &import).unwrap_err();
    assert!(matches!(error, Error::BadVoxel { .. }), "{error}");
}

#[test]
fn tiles_are_filled_out_and_inactive_voxels_left_out() {
    let tile = |origin, active| Tile {
        origin,
        level: TileLevel::Leaf,
        active,
        value: 0.5,
    };
    let mut leaf = Leaf::new([16, 0, 0], 0.0);
    // A value that is not active: the mask decides.
    leaf.values[0] = 9.0;
    leaf.set([17, 0, 0], 1.0);
    let tiles = vec![tile([0; 3], true), tile([8, 0, 0], false)];
    let tree = FloatTree::from_parts(0.0, vec![leaf], tiles).unwrap();
    let found = volume(tree, &import(DensityMeans::OpticalDepth, 2.0)).unwrap();
    let mode = &found.modes[0];
    assert_eq!(mode.nodes().count(), 512 + 1);
    // Eight voxels of 0.5 and the one of 1 on the line through y = z = 0.
    assert_close(2.0 * found.summary().optical_depth_q1[0], 2.0);
    let whole = Tile {
        level: TileLevel::Upper,
        ..tile([0; 3], true)
    };
    let tree = FloatTree::from_parts(0.0, vec![], vec![whole]).unwrap();
    let error = volume(tree, &import(DensityMeans::Number, 1.0)).unwrap_err();
    assert!(matches!(error, Error::TooManyNodes { .. }), "{error}");
}

#[test]
fn a_missing_grid_is_answered_with_those_there_are() {
    let file = file(vec![
        ("density", three_voxels().into()),
        ("heat", three_voxels().into()),
    ]);
    let import = import(DensityMeans::Number, 1.0);
    let error = DropVolume::from_density(&file, "smoke", &import).unwrap_err();
    let text = error.to_string();
    assert_eq!(
        text,
        r#"grid `smoke` is missing; the file holds ["density", "heat"]"#
    );
}

#[test]
fn grids_of_one_name_are_told_apart_by_their_place() {
    let mut second = Leaf::new([0; 3], 0.0);
    second.set([0; 3], 5.0);
    let second = FloatTree::from_leaves(0.0, vec![second]).unwrap();
    let file = file(vec![
        ("density", three_voxels().into()),
        ("heat", FloatTree::new(0.0).into()),
        ("density", second.into()),
    ]);
    let count = |name: &str| {
        let import = import(DensityMeans::Number, 1.0);
        DropVolume::from_density(&file, name, &import).map(|volume| volume.modes[0].nodes().count())
    };
    assert_eq!(count("density").unwrap(), 3);
    assert_eq!(count("density[0]").unwrap(), 3);
    assert_eq!(count("density[1]").unwrap(), 1);
    assert_eq!(count("heat").unwrap(), 0);
    assert!(matches!(
        count("density[2]"),
        Err(Error::MissingGrid { .. })
    ));
    assert!(matches!(count("density[x"), Err(Error::MissingGrid { .. })));
}

#[test]
fn what_is_no_density_is_refused_with_the_reason() {
    let refused = |change: &dyn Fn(&mut Grid)| {
        let mut file = file(vec![("density", three_voxels().into())]);
        change(&mut file.grids[0]);
        let import = import(DensityMeans::Water, 1.0);
        DropVolume::from_density(&file, "density", &import)
            .unwrap_err()
            .to_string()
    };
    let with_value = |value: f32| {
        move |grid: &mut Grid| {
            let mut leaf = Leaf::new([0; 3], 0.0);
            leaf.set([5, 0, 0], value);
            grid.tree = FloatTree::from_leaves(0.0, vec![leaf]).unwrap().into();
        }
    };
    for value in [-1e-3, f32::NAN, f32::INFINITY] {
        let text = refused(&with_value(value));
        assert!(text.contains("at voxel [5, 0, 0]"), "{text}");
        assert!(text.contains("a finite density not below 0"), "{text}");
    }
    let text = refused(&|grid| grid.tree = FloatTree::new(1.0).into());
    assert!(text.contains("background 1, expected 0"), "{text}");
    let text = refused(&|grid| grid.class = LEVEL_SET.into());
    assert!(text.contains("sdfToFogVolume"), "{text}");
}

/// A file of a density and an age, on its own lattice that lies half a voxel beside.
fn with_age() -> VdbFile {
    let mut age = Leaf::new([0; 3], 0.0);
    for x in 0..8 {
        age.set([x, 2, 3], x as f32);
    }
    let age = FloatTree::from_leaves(0.0, vec![age]).unwrap();
    let mut density = Leaf::new([0; 3], 0.0);
    density.set([1, 2, 3], 0.5);
    density.set([5, 2, 3], 0.25);
    let density = FloatTree::from_leaves(0.0, vec![density]).unwrap();
    let mut file = file(vec![("density", density.into()), ("drop age", age.into())]);
    let beside = transform().translation() + DVec3::new(0.5 * VOXEL_M, 0.0, 0.0);
    file.grids[1].transform = Transform::uniform_scale_translate(VOXEL_M, beside);
    file
}

#[test]
fn a_radius_by_a_formula_of_another_grid_keeps_what_the_numbers_mean() {
    let formula = |text: &str| EffectiveRadius::Formula(text.to_owned());
    let made = |means, text: &str| {
        let import = DensityImport::in_metres((means, 0.8), formula(text), 0.15);
        DropVolume::from_density(&with_age(), "density", &import)
    };
    let volume = made(DensityMeans::Water, "10 + 4*{drop age}").unwrap();
    for (voxel, age, value) in [([1, 2, 3], 0.5, 0.5), ([5, 2, 3], 4.5, 0.25)] {
        let drops = volume.modes[0].drops(voxel);
        let radius_um = 1e6 * f64::from(drops.effective_radius_m);
        assert_close(radius_um, 10.0 + 4.0 * age);
        let water = crate::AreaMoments::from_drops(&drops).liquid_water_g_m3();
        assert_close(water, 0.8 * value);
    }
    // One line of voxels has both.
    let volume = made(DensityMeans::OpticalDepth, "10 + 4*{drop age}").unwrap();
    assert_close(2.0 * volume.summary().optical_depth_q1[0], 0.8);
    let error = made(DensityMeans::Water, "10 - 4*{drop age}").unwrap_err();
    assert!(
        matches!(
            error,
            Error::BadVoxel {
                voxel: [5, 2, 3],
                ..
            }
        ),
        "{error}"
    );
    let error = made(DensityMeans::Water, "10 + heat")
        .unwrap_err()
        .to_string();
    let expected = r#"the formula `10 + heat` names `heat` at column 6; the file holds the grids ["density", "drop age"]"#;
    assert_eq!(error, expected);
    let error = made(DensityMeans::Water, "10 + * 3")
        .unwrap_err()
        .to_string();
    assert!(error.contains("has '*' at column 6"), "{error}");
}

#[test]
fn a_file_in_centimetres_with_z_up_is_the_same_cloud_in_metres() {
    let water = import(DensityMeans::Water, 0.5);
    let expected = volume(three_voxels(), &water).unwrap();
    let mut file = file(vec![("density", three_voxels().into())]);
    let z_up = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);
    let (linear, origin) = (transform().linear(), transform().translation());
    file.grids[0].transform =
        Transform::affine(100.0 * z_up * linear, 100.0 * z_up * origin).unwrap();
    let import = DensityImport {
        to_metres: (0.01 * z_up.transpose()).to_cols_array_2d(),
        ..water
    };
    let found = DropVolume::from_density(&file, "density", &import).unwrap();
    for (node, drops) in expected.modes[0].nodes() {
        assert_eq!(found.modes[0].drops(node), drops);
    }
    let off = found.modes[0].origin_m() - expected.modes[0].origin_m();
    assert!(off.length() < 1e-12, "{off}");
}

#[test]
fn turned_and_stretched_grids_keep_their_water() {
    let water = import(DensityMeans::Water, 0.5);
    for linear in [
        DMat3::from_rotation_y(0.3) * VOXEL_M,
        DMat3::from_diagonal(DVec3::new(1.0, 1.0, 2.0)),
    ] {
        let mut file = file(vec![("density", three_voxels().into())]);
        file.grids[0].transform = Transform::affine(linear, DVec3::ZERO).unwrap();
        let volume = DropVolume::from_density(&file, "density", &water).unwrap();
        // Half a gram in a cubic metre where the value is 1.
        let expected = 0.5 * 1.875 * linear.determinant();
        let error = volume.modes[0].total_water_g() / expected - 1.0;
        assert!(error.abs() < 5e-7, "{error}");
    }
}

#[test]
fn a_map_that_is_cubic_but_for_f32_is_accepted() {
    let mut file = file(vec![("density", three_voxels().into())]);
    // Turned forth and back in f32, as scene graphs do.
    let turned = glam::Mat3::from_rotation_y(0.3) * glam::Mat3::from_rotation_y(-0.3);
    let linear = (turned * 0.1).as_dmat3();
    assert!(linear != DMat3::from_diagonal(DVec3::splat(linear.x_axis.x)));
    file.grids[0].transform = Transform::affine(linear, DVec3::ZERO).unwrap();
    let import = import(DensityMeans::Number, 1.0);
    let volume = DropVolume::from_density(&file, "density", &import).unwrap();
    assert_close(volume.modes[0].voxel_m(), 0.1);
}

#[test]
fn settings_that_make_no_drops_are_refused_by_name() {
    let sound = import(DensityMeans::Water, 1.0);
    let refused = [
        (
            "scale",
            DensityImport {
                scale: 0.0,
                ..sound.clone()
            },
        ),
        (
            "scale",
            DensityImport {
                scale: f64::NAN,
                ..sound.clone()
            },
        ),
        (
            "effective_radius_um",
            DensityImport {
                effective_radius_um: EffectiveRadius::Um(0.0),
                ..sound.clone()
            },
        ),
        (
            "effective_radius_um",
            DensityImport {
                effective_radius_um: EffectiveRadius::Um(1.1e5),
                ..sound.clone()
            },
        ),
        (
            "effective_variance",
            DensityImport {
                effective_variance: 0.5,
                ..sound.clone()
            },
        ),
    ];
    for (name, import) in refused {
        let error = volume(three_voxels(), &import).unwrap_err();
        assert!(
            matches!(error, Error::BadSetting { parameter, .. } if parameter == name),
            "{error}"
        );
    }
    // Sound settings that ask for more drops than a cubic metre holds.
    let flood = import(DensityMeans::Number, 1e20);
    let error = volume(three_voxels(), &flood).unwrap_err();
    assert!(matches!(error, Error::BadDrops { .. }), "{error}");
}

#[test]
fn an_import_is_written_with_its_units_and_knows_its_keys() {
    let text = r#"{"density_means":"optical-depth","scale":3.0,"effective_radius_um":10.0,"effective_variance":0.1}"#;
    let import: DensityImport = serde_json::from_str(text).unwrap();
    assert_eq!(import.density_means, DensityMeans::OpticalDepth);
    assert_eq!(serde_json::to_string(&import).unwrap(), text);
    let unknown = text.replace("scale", "scales");
    assert!(serde_json::from_str::<DensityImport>(&unknown).is_err());
}
