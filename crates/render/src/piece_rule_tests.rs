//! Pieces against closed forms.

use super::*;

fn axes() -> SizeAxes {
    SizeAxes::new(&[100.0], &[0.0])
}

/// A mode whose optical depth over a piece of 1 m is `depth`, with a linear ramp of density and
/// of the sun's optical depth.
fn mode(depth: f64, ramp: f32, tau_sun: [f32; 2]) -> LaneCubic {
    let m2 = (depth / EXTINCTION_PER_M2) as f32;
    LaneCubic::through([0.0_f32, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|x| {
        let m2 = m2 * (1.0 + ramp * (x - 0.5));
        Vec4::new(
            m2,
            100.0 * m2,
            1e4 * m2,
            tau_sun[0] * (1.0 - x) + tau_sun[1] * x,
        )
    }))
}

fn light(rule: &PieceRule, modes: &[LaneCubic], in_front: f64) -> Deposits {
    let axes = axes();
    let mut deposits = Deposits::new(&axes);
    let piece = Piece::new(10.0, 1.0, modes);
    let mut through = (-rule.view_efficiency * in_front).exp();
    rule.gather(&axes, &piece, &mut through, &mut deposits);
    deposits
}

#[test]
fn without_a_shadow_a_piece_of_any_thickness_is_exact() {
    let rule = PieceRule::new(2.0, 0.0, Integration::CellExact);
    for depth in [1e-12, 1e-6, 0.02, 0.025, 0.3, 12.0, 1e3] {
        for ramp in [0.0, 1.0, -2.0] {
            let found = light(&rule, &[mode(depth, ramp, [0.0; 2])], 0.5).light;
            let expected = (-1.0_f64).exp() * -(-2.0 * depth).exp_m1() / 2.0;
            // f32 moments; measured 2.4e-7.
            assert!((found / expected - 1.0).abs() < 1e-6, "{depth} {ramp}");
        }
    }
}

#[test]
fn a_shadow_that_grows_along_the_piece_has_its_closed_form() {
    let rule = PieceRule::new(1.0, 1.0, Integration::CellExact);
    for (depth, sun) in [(0.01, 0.02), (0.1, 0.14), (2.0, 1.0), (20.0, 10.0)] {
        let found = light(&rule, &[mode(depth, 0.0, [0.0, sun as f32])], 0.0);
        let expected = -(-depth - sun).exp_m1() * depth / (depth + sun);
        let error = (found.light / expected - 1.0).abs();
        // Measured 2.1e-6, where a piece of depth 30 would need more than 64 parts.
        assert!(error < 5e-6, "{depth} {sun}: {error}");
    }
}

#[test]
fn modes_add_their_light_and_share_their_extinction() {
    let rule = PieceRule::new(1.0, 0.0, Integration::CellExact);
    let both = light(
        &rule,
        &[mode(0.3, 0.0, [0.0; 2]), mode(0.5, 0.0, [0.0; 2])],
        0.0,
    )
    .light;
    assert!((both / -(-0.8_f64).exp_m1() - 1.0).abs() < 1e-6);
}

#[test]
fn the_adaptive_rule_keeps_to_its_error() {
    for relative_error in [1e-2, 1e-3, 1e-5] {
        let rule = PieceRule::new(1.0, 1.0, Integration::Adaptive { relative_error });
        for (depth, sun) in [(0.01, 0.02), (0.1, 0.3), (1.0, 2.0), (6.0, 1.0)] {
            let found = light(&rule, &[mode(depth, 0.0, [0.0, sun as f32])], 0.0);
            let expected = -(-depth - sun).exp_m1() * depth / (depth + sun);
            let error = (found.light / expected - 1.0).abs();
            assert!(
                error < relative_error,
                "{depth} {sun}: {error} of {relative_error}"
            );
        }
    }
}

#[test]
fn no_drops_give_no_light() {
    let rule = PieceRule::new(1.0, 1.0, Integration::CellExact);
    assert_eq!(
        light(&rule, &[LaneCubic::through([Vec4::ZERO; 4])], 0.0).light,
        0.0
    );
    assert_eq!(light(&rule, &[], 0.0).light, 0.0);
}

#[test]
fn distance_is_that_of_the_light() {
    let rule = PieceRule::new(0.0, 0.0, Integration::CellExact);
    let found = light(&rule, &[mode(0.3, 0.0, [0.0; 2])], 0.0);
    assert!((found.light_m / found.light - 10.5).abs() < 1e-6);
}
