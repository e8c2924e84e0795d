//! Stretches against closed forms and against the pieces that they stand for.

use std::slice::from_mut;

use super::*;
use crate::deposits::Deposits;
use crate::levels::Integration;
use crate::piece::Piece;

fn axes() -> SizeAxes {
    let radii: Vec<f64> = (0..60).map(|step| 20.0 * 1.05_f64.powi(step)).collect();
    SizeAxes::new(&radii, &[0.0])
}

/// A cell of 1 m with depth and optical depth to the sun at its ends, of drops of one radius.
fn cell(depths: [f64; 2], tau_sun: [f64; 2], radius_um: f32) -> LaneCubic {
    let lanes = |end: usize| {
        let m2 = (depths[end] / EXTINCTION_PER_M2) as f32;
        Vec4::new(
            m2,
            radius_um * m2,
            radius_um * radius_um * m2,
            tau_sun[end] as f32,
        )
    };
    let zero = Vec4::ZERO;
    LaneCubic::new([lanes(0), lanes(1) - lanes(0), zero, zero])
}

#[test]
fn drops_too_few_for_the_inverse_of_their_moment_are_none() {
    // 1/x of the smallest f32 is infinite, and 0 times that no number.
    for m2 in [1e-45, 1e-42, 2e-39] {
        let lanes = Vec4::new(m2, 0.0, 0.0, 1.0);
        let lanes = LaneCubic::new([lanes, Vec4::ZERO, Vec4::ZERO, Vec4::ZERO]);
        assert_eq!(ThinCell::new(100.0, 1.0, &lanes, 0.0).depth, 0.0, "{m2}");
    }
    assert!(ThinCell::new(100.0, 1.0, &cell([1e-9; 2], [1.0; 2], 100.0), 0.0).depth > 0.0);
}

/// Light of cells one behind the other from 100 m on, and in how many gatherings it was taken.
fn gathered(cells: &[LaneCubic], rule: &PieceRule) -> (Deposits, usize) {
    let axes = axes();
    let (mut deposits, mut through, mut n) = (Deposits::new(&axes), 1.0, 0);
    let mut stretch = Stretch::default();
    for (start_m, lanes) in (100..).map(f64::from).zip(cells) {
        let thin = ThinCell::new(start_m, 1.0, lanes, 0.0);
        if stretch.join(&thin, rule, &axes) {
            continue;
        }
        n += 1;
        if !stretch.is_empty() {
            rule.gather_stretches(&axes, from_mut(&mut stretch), &mut through, &mut deposits);
        }
        assert!(stretch.join(&thin, rule, &axes), "the cells are thin");
    }
    rule.gather_stretches(&axes, from_mut(&mut stretch), &mut through, &mut deposits);
    (deposits, n + 1)
}

/// The same by a piece for each cell.
fn by_pieces(cells: &[LaneCubic], rule: &PieceRule) -> Deposits {
    let axes = axes();
    let (mut deposits, mut through) = (Deposits::new(&axes), 1.0);
    for (start_m, lanes) in (100..).map(f64::from).zip(cells) {
        let piece = Piece::new(start_m, 1.0, std::slice::from_ref(lanes));
        rule.gather(&axes, &piece, &mut through, &mut deposits);
    }
    deposits
}

fn rule(relative_error: f64) -> PieceRule {
    PieceRule::new(1.0, 1.0, Integration::Adaptive { relative_error })
}

/// A slab of cells whose depth to the sun grows evenly.
fn slab(n: usize, depth: f64, tau_sun: f64) -> Vec<LaneCubic> {
    let at = |index: usize| 0.3 + tau_sun * index as f64 / n as f64;
    let cell = |index| cell([depth / n as f64; 2], [at(index), at(index + 1)], 100.0);
    (0..n).map(cell).collect()
}

#[test]
fn an_even_slab_has_its_closed_form_within_the_error_that_is_told() {
    for (depth, tau_sun) in [(0.01, 0.02), (0.3, 0.4), (2.0, 1.5), (6.0, 9.0)] {
        let light = (-0.3_f64).exp() * -f64::exp_m1(-depth - tau_sun) * depth / (depth + tau_sun);
        let mut n_before = 0;
        for relative_error in [1e-2, 1e-4, 1e-6] {
            let (found, n) = gathered(&slab(4000, depth, tau_sun), &rule(relative_error));
            let error = (found.light / light - 1.0).abs();
            // f32 leaves 5e-7; measured at most 1.1e-2 of the level.
            assert!(error < 0.03 * relative_error + 5e-7, "{depth} {n}: {error}");
            let told = found.error / found.light;
            assert!(error < told + 5e-7, "{depth} {n}: {error} of {told}");
            // Finer levels take less together, all of them more than a cell.
            assert!(n_before <= n && n < 4000, "{n_before} {n}");
            n_before = n;
        }
    }
}

#[test]
fn distances_and_depths_to_the_sun_are_those_of_the_pieces() {
    let cells = slab(100, 0.4, 0.3);
    let (found, n) = gathered(&cells, &rule(1e-2));
    let expected = by_pieces(&cells, &rule(1e-8));
    assert_eq!(n, 1);
    let moments = |light: &Deposits| {
        let mean_m = light.light_m / light.light;
        let variance_m2 = light.light_m2 / light.light - mean_m * mean_m;
        (mean_m, variance_m2, light.light_tau_sun / light.light)
    };
    let ((mean, variance, tau_sun), wanted) = (moments(&found), moments(&expected));
    // The stretch's weights leave the sun's factor out, here of exp(-0.3): measured 2.5 m of 100 m.
    assert!((mean - wanted.0).abs() < 3.0, "{mean} {}", wanted.0);
    assert!((variance / wanted.1 - 1.0).abs() < 0.02, "{variance}");
    assert!((tau_sun - wanted.2).abs() < 0.01, "{tau_sun} {}", wanted.2);
}

#[test]
fn two_points_have_the_largest_error_and_it_is_told() {
    // Light at two depths to the sun only, in the ratio of the largest third moment.
    let part = 0.5 * (1.0 - 1.0 / 3.0_f64.sqrt());
    for span in [0.1, 0.3, 0.6] {
        for part in [part, 1.0 - part, 0.5] {
            let depth = 1e-6;
            let cells = [
                cell([part * depth; 2], [0.0; 2], 100.0),
                cell([(1.0 - part) * depth; 2], [span; 2], 100.0),
            ];
            let (found, n) = gathered(&cells, &rule(1e-2));
            let light = depth * (part + (1.0 - part) * (-span).exp());
            let error = (found.light / light - 1.0).abs();
            assert_eq!(n, 1);
            // f32 leaves 1e-6.
            let most = span.powi(3) / 62.0 * (1.0 + span);
            assert!(error < most + 1e-6, "{span}: {error}");
            assert!(
                error < 1.1 * found.error / found.light + 1e-6,
                "{span}: {error}"
            );
        }
    }
}

#[test]
fn sizes_part_where_the_table_does() {
    let grown = |ratio: f32| [1.0, ratio].map(|r| cell([0.01; 2], [0.0; 2], 100.0 * r));
    for (relative_error, nodes) in [(1e-2, 0.83), (1e-6, 0.083)] {
        // Half of the span on either side of the first cell; a node is a step of ln 1.05.
        let ratio = |nodes: f64| (0.05_f64.ln_1p() * nodes) as f32;
        let rule = rule(relative_error);
        assert_eq!(gathered(&grown(1.0 + 0.9 * ratio(nodes)), &rule).1, 1);
        assert_eq!(gathered(&grown(1.0 - 0.9 * ratio(nodes)), &rule).1, 1);
        // The slack for rounding is a thousandth, here of a radius.
        assert_eq!(gathered(&grown(1.002 + ratio(nodes)), &rule).1, 2);
        assert_eq!(gathered(&grown(0.998 - ratio(nodes)), &rule).1, 2);
    }
}

#[test]
fn what_a_kink_of_the_table_makes_of_sizes_is_told() {
    // Rows |b - 20| of bins b bend at one node only, by 2.
    const NODE: usize = 20;
    let of_rows = |deposits: &Deposits, row: &dyn Fn(usize) -> f64| -> f64 {
        let lit = deposits.bins.iter();
        lit.map(|(bin, light)| f64::from(light) * row(bin)).sum()
    };
    let row = |bin: usize| bin.abs_diff(NODE) as f64;
    let bend = |bin: usize| if bin == NODE { 2.0 } else { 0.0 };
    let radius_um = |node: f64| (20.0 * 1.05_f64.powf(node)) as f32;
    for span in [0.1, 0.4, 0.8, 2.0] {
        // A cell by itself, in one stretch; as a piece with one, two and three points.
        let ways: [fn(&[LaneCubic]) -> Deposits; 4] = [
            |cells| gathered(cells, &rule(0.5)).0,
            |cells| by_pieces(cells, &rule(0.5)),
            |cells| by_pieces(cells, &rule(1e-3)),
            |cells| by_pieces(cells, &rule(1e-6)),
        ];
        for way in ways {
            let (mut errors, mut told) = (0.0, 0.0);
            // All places of the cell around the node, one as likely as the other.
            for step in 0..100 {
                let start = NODE as f64 - 1.0 - span + (2.0 + span) * f64::from(step) / 100.0;
                let m2 = (1e-3 / EXTINCTION_PER_M2) as f32;
                let [first, last] = [start, start + span].map(|node| radius_um(node) * m2);
                let at = |m2, m3| Vec4::new(m2, m3, 0.0, 0.0);
                let slope = at(0.0, last - first);
                let cell = LaneCubic::new([at(m2, first), slope, Vec4::ZERO, Vec4::ZERO]);
                let (found, expected) = (way(&[cell]), by_pieces(&[cell], &rule(1e-13)));
                let rows = [&found, &expected].map(|light| of_rows(light, &row) / light.light);
                errors += (rows[0] - rows[1]).abs();
                let kinks = of_rows(&found, &bend) / found.light;
                told += 0.5 * kinks * found.size_variance / found.light;
            }
            // Measured 2.3 to 4.0 times the mean error.
            assert!(
                errors < told && told < 5.0 * errors,
                "{span}: {errors} {told}"
            );
        }
    }
}

#[test]
fn sizes_count_as_much_as_their_light() {
    // Larger drops stand further from the sun: the mean size is nearer to that of the small ones.
    let cells: Vec<LaneCubic> = (0..20)
        .map(|index| {
            let far = |index: i32| 0.7 * f64::from(index) / 20.0;
            let radius_um = 100.0 * 1.03_f32.powf((f64::from(index) as f32 + 0.5) / 20.0);
            cell([1e-3; 2], [far(index), far(index + 1)], radius_um)
        })
        .collect();
    let (found, n) = gathered(&cells, &rule(2e-2));
    let expected = by_pieces(&cells, &rule(1e-9));
    assert_eq!(n, 1);
    let mean_node = |deposits: &Deposits| {
        let sum: f64 = (deposits.bins.iter())
            .map(|(bin, light)| bin as f64 * f64::from(light))
            .sum();
        sum / deposits.light
    };
    // Measured 4e-4; were all cells to count alike 3.6e-2.
    let error = mean_node(&found) - mean_node(&expected);
    assert!(error.abs() < 2e-3, "{error}");
}

#[test]
fn a_cell_that_fades_out_fits_and_leans_to_its_dense_end() {
    let rule = rule(1e-2);
    for tau_sun in [0.0, 1e-3, 0.05] {
        let cells = [
            cell([0.0, 0.02], [0.2, 0.2 + tau_sun], 100.0),
            cell([0.02, 0.0], [0.2 + tau_sun, 0.2 + 2.0 * tau_sun], 100.0),
        ];
        let (found, n) = gathered(&cells, &rule);
        let expected = by_pieces(&cells, &self::rule(1e-9));
        assert_eq!(n, 1);
        let error = (found.light / expected.light - 1.0).abs();
        // Measured 3e-6: M2 and the fading of the view path are products in a cell.
        assert!(error < 1e-5, "{tau_sun}: {error}");
        let means = [&found, &expected].map(|light| light.light_m / light.light);
        assert!((means[0] - means[1]).abs() < 0.02, "{means:?}");
    }
}

#[test]
fn bends_of_drops_and_sunlight_meet_in_a_cell() {
    // Through the edge of a box: no drops at both ends, and most of them where the sun's way is longest.
    for (bend, slope) in [(-0.2, 0.2), (-0.02, 0.05), (0.1, -0.1), (-0.2, 0.0)] {
        let of = |coefficient: f64, tau_sun: f64| {
            let m2 = (coefficient * 0.01 / EXTINCTION_PER_M2) as f32;
            Vec4::new(m2, 100.0 * m2, 1e4 * m2, tau_sun as f32)
        };
        let lanes = [of(0.0, 0.4), of(1.0, slope), of(-1.0, bend), Vec4::ZERO];
        let cells = [LaneCubic::new(lanes)];
        let (found, n) = gathered(&cells, &rule(1e-2));
        let expected = by_pieces(&cells, &rule(1e-9));
        assert_eq!(n, 1);
        let error = (found.light / expected.light - 1.0).abs();
        // Measured 1.8e-5 at most; with all light in the mean of the cell up to 7e-3.
        assert!(error < 4e-5, "{bend} {slope}: {error}");
        let spread = |light: &Deposits| {
            let mean_m = light.light_m / light.light;
            light.light_m2 / light.light - mean_m * mean_m
        };
        // A parabola's twentieth, a twelfth if it were even.
        assert!((spread(&found) - 0.05).abs() < 1e-3, "{}", spread(&found));
    }
}

#[test]
fn modes_share_the_light_by_their_depths() {
    let axes = axes();
    let rule = rule(1e-2);
    let lanes = [
        cell([0.01; 2], [0.0; 2], 30.0),
        cell([0.03; 2], [0.0; 2], 100.0),
    ];
    // The second mode has no drops in every other cell.
    let mut stretches = [Stretch::default(); 2];
    let (mut deposits, mut through) = (Deposits::new(&axes), 1.0);
    let mut depth_of_all = 0.0;
    let crossing = Crossing {
        rule: &rule,
        axes: &axes,
    };
    for index in 0..10 {
        let thin = lanes
            .each_ref()
            .map(|lanes| ThinCell::new(100.0 + f64::from(index), 1.0, lanes, 0.0));
        let both = index % 2 == 0;
        let depth = thin[0].depth + if both { thin[1].depth } else { 0.0 };
        let [first, second] = thin;
        let cells = [Some(first), both.then_some(second)];
        assert!(join_all(&mut stretches, &cells, depth, crossing));
        depth_of_all += depth;
    }
    rule.gather_stretches(&axes, &mut stretches, &mut through, &mut deposits);
    assert!((deposits.light - -(-depth_of_all).exp_m1()).abs() < 1e-7);
    // Cell by cell; the drops of 30 um have the lower bins.
    let (mut in_front, mut of_first) = (0.0_f64, 0.0);
    for index in 0..10 {
        let depth: f64 = if index % 2 == 0 { 0.04 } else { 0.01 };
        of_first += (-in_front).exp() * -(-depth).exp_m1() * 0.01 / depth;
        in_front += depth;
    }
    let found: f64 = (deposits.bins.iter())
        .filter(|(bin, _)| *bin < axes.n_radii() / 3)
        .map(|(_, light)| f64::from(light))
        .sum();
    assert!((found / of_first - 1.0).abs() < 1e-4, "{found} {of_first}");
}

#[test]
fn thick_and_faint_cells_are_taken_as_they_are() {
    let axes = axes();
    let mut stretch = Stretch::default();
    let thin = |depth: f64, tau_sun| {
        let lanes = cell([depth; 2], tau_sun, 100.0);
        ThinCell::new(100.0, 1.0, &lanes, 0.0)
    };
    for rule in [rule(1e-2), rule(1e-6)] {
        assert!(!stretch.join(&thin(0.6, [0.0; 2]), &rule, &axes));
        assert!(!stretch.join(&thin(12.0, [0.0, 12.0]), &rule, &axes));
        assert!(!stretch.join(&thin(1e-3, [0.0, 2.0]), &rule, &axes));
        assert!(stretch.is_empty());
    }
    // 1e-12 has no digits in 1 - exp(-tau).
    let (found, n) = gathered(&slab(10, 1e-12, 1e-12), &rule(1e-6));
    assert!((found.light / (1e-12 * (-0.3_f64).exp()) - 1.0).abs() < 1e-6);
    assert_eq!(n, 1);
}
