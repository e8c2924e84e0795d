//! Moments of any smooth size law between two radii, in logarithms.
//!
//! I_j = integral g(v) e^(j v) dv over ln(r1/c) <= v <= ln(r2/c),   v = ln(r/c)
//! `c` a radius near the bulk of the law [um], g(v) proportional to r² n(r) r, the cross-section
//! per unit of ln r, given as its logarithm.
//! <r²> = c² I_0/I_-2,   r_e = c I_1/I_0,   v_e = (integral g (r/r_e - 1)² dv)/I_0
//!
//! The textbook way, differences of incomplete gamma or error functions, loses all digits for a
//! narrow cut, for one far out in a tail and for a law 1e-6 wide, and fails for the negative orders
//! that a Rosin-Rammler law needs. Here every term is positive, r/r_e - 1 is never a difference of
//! large numbers, and only logarithms are compared. Each integrand has a single maximum; a
//! composite Gauss-Legendre rule covers it down to e^-40 of that maximum.

use niji_radiometry::gauss_legendre;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_not_negative;
use crate::error::require_positive;

/// What is left out beyond the brackets is below e^-40 of the maximum per unit of width.
const LN_NEGLECTED: f64 = 40.0;

/// Widest range of ln r: e^±300 covers every f64 moment.
const WIDEST: f64 = 300.0;

/// Halvings of a bracket: 600 becomes 1e-15.
const N_HALVINGS: usize = 64;

/// Narrowings of the search for a maximum by a third each: 600 becomes 1e-13.
const N_THIRDS: usize = 90;

/// Panels of the composite rule: half a unit of ln r each for the widest integrand, e^v.
const N_PANELS: usize = 96;

/// Nodes in a panel.
const N_NODES: usize = 16;

/// Radii (um) of a range of diameters (mm), 0 and infinity where an end is missing.
pub(crate) fn radius_range_um(d_min_mm: Option<f64>, d_max_mm: Option<f64>) -> (f64, f64) {
    let radius = |diameter_mm: f64| 500.0 * diameter_mm;
    (
        d_min_mm.map_or(0.0, radius),
        d_max_mm.map_or(f64::INFINITY, radius),
    )
}

/// Check a range of diameters.
///
/// # Errors
/// [`Error::Parameter`] if an end is not finite or has the wrong sign, [`Error::EmptyRange`] if the
/// upper end is not above the lower one.
pub(crate) fn check_range_mm(d_min_mm: Option<f64>, d_max_mm: Option<f64>) -> Result<(), Error> {
    let min = d_min_mm.unwrap_or(0.0);
    require_not_negative("d_min_mm", min)?;
    let Some(max) = d_max_mm else {
        return Ok(());
    };
    require_positive("d_max_mm", max)?;
    if max > min {
        return Ok(());
    }
    Err(Error::EmptyRange {
        parameter: "d_mm",
        min,
        max,
    })
}

/// Moments per drop of the law between two radii (um).
///
/// `ln_area_weight(v)` is ln g(v) up to a constant; it must have a single maximum, also after the
/// addition of j v for j = -2..=1.
pub(crate) fn truncated_moments(
    reference_um: f64,
    range_um: (f64, f64),
    ln_area_weight: impl Fn(f64) -> f64,
) -> SizeMoments {
    let rule = gauss_legendre(N_NODES);
    let end = |radius_um: f64| (radius_um / reference_um).ln().clamp(-WIDEST, WIDEST);
    let range = (end(range_um.0), end(range_um.1));
    let sum = |power: f64| Hump::find(range, |v| ln_area_weight(v) + power * v);
    let (i_m2, i_m1, i_0, i_1) = (sum(-2.0), sum(-1.0), sum(0.0), sum(1.0));
    let ln_integral = |hump: &Hump, power: f64| {
        let relative = |v| (ln_area_weight(v) + power * v - hump.ln_peak).exp();
        hump.ln_peak + hump.integral(&rule, relative).ln()
    };
    let ln_number = ln_integral(&i_m2, -2.0);
    let ln_area = ln_integral(&i_0, 0.0);
    let ln_r_e = ln_integral(&i_1, 1.0) - ln_area;
    let spread = |v: f64| {
        let off = (v - ln_r_e).exp_m1();
        off * off * (ln_area_weight(v) - i_0.ln_peak).exp()
    };
    let mean_r2_um2 = reference_um.powi(2) * (ln_area - ln_number).exp();
    SizeMoments {
        mean_r_um: reference_um * (ln_integral(&i_m1, -1.0) - ln_number).exp(),
        mean_r2_um2,
        mean_r3_um3: reference_um * ln_r_e.exp() * mean_r2_um2,
        effective_variance: i_0.integral(&rule, spread) / (ln_area - i_0.ln_peak).exp(),
    }
}

/// Where an integrand with one maximum is not negligible.
struct Hump {
    low: f64,
    high: f64,
    ln_peak: f64,
}

impl Hump {
    fn find((low, high): (f64, f64), ln_integrand: impl Fn(f64) -> f64) -> Self {
        let peak = maximum((low, high), &ln_integrand);
        let ln_peak = ln_integrand(peak);
        let edge = |outside: f64| {
            let is_small = |v: f64| ln_integrand(v) < ln_peak - LN_NEGLECTED;
            if !is_small(outside) {
                return outside;
            }
            let (mut small, mut large) = (outside, peak);
            for _ in 0..N_HALVINGS {
                let middle = 0.5 * (small + large);
                if is_small(middle) {
                    small = middle;
                } else {
                    large = middle;
                }
            }
            small
        };
        Self {
            low: edge(low),
            high: edge(high),
            ln_peak,
        }
    }

    /// Sum over the panels from low to high.
    fn integral(&self, rule: &[(f64, f64)], integrand: impl Fn(f64) -> f64) -> f64 {
        let panel = (self.high - self.low) / N_PANELS as f64;
        (0..N_PANELS)
            .map(|index| {
                let middle = self.low + (index as f64 + 0.5) * panel;
                let value = |(x, weight): &(f64, f64)| weight * integrand(middle + 0.5 * panel * x);
                0.5 * panel * rule.iter().map(value).sum::<f64>()
            })
            .sum()
    }
}

/// Place of the only maximum, by thirds. Plateaus of minus infinity lie above it only.
fn maximum((mut low, mut high): (f64, f64), f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..N_THIRDS {
        let third = (high - low) / 3.0;
        if f(low + third) < f(high - third) {
            low += third;
        } else {
            high -= third;
        }
    }
    0.5 * (low + high)
}

/// e^y - 1 - y without cancellation.
pub(crate) fn exp_minus_linear(y: f64) -> f64 {
    if y.abs() > 0.5 {
        return y.exp_m1() - y;
    }
    // y²/2! + y³/3! + ...: the 15th term is below 1e-17 of the first.
    (3..=16)
        .rev()
        .fold(1.0, |sum, n| 1.0 + y / f64::from(n) * sum)
        * 0.5
        * y
        * y
}

#[cfg(test)]
mod tests {
    use super::*;
    use spec_math::Gamma;

    #[test]
    fn an_exponential_law_has_the_incomplete_gamma_functions_of_its_cut() {
        // n(r) = e^-r between 0.3 and 2: integral r^k = Gamma(k+1) [P(k+1, 2) - P(k+1, 0.3)].
        let moments = truncated_moments(1.0, (0.3, 2.0), |v| 3.0 * v - v.exp());
        let exact =
            |k: f64| (k + 1.0).lgamma().exp() * ((k + 1.0).igamma(2.0) - (k + 1.0).igamma(0.3));
        let per_drop = |k: f64| exact(k) / exact(0.0);
        // Measured worst 2e-15.
        assert!((moments.mean_r_um / per_drop(1.0) - 1.0).abs() < 1e-13);
        assert!((moments.mean_r2_um2 / per_drop(2.0) - 1.0).abs() < 1e-13);
        assert!((moments.mean_r3_um3 / per_drop(3.0) - 1.0).abs() < 1e-13);
        assert!((moments.mean_r4_um4() / per_drop(4.0) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn a_cut_far_out_in_a_tail_is_an_exponential_of_its_own() {
        // e^-r beyond r = 1000: r - 1000 is exponential with mean 1, v_e = (1/1000)² at first order.
        let moments = truncated_moments(1.0, (1000.0, f64::INFINITY), |v| 3.0 * v - v.exp());
        assert!((moments.mean_r_um - 1001.0).abs() < 1e-9, "{moments:?}");
        assert!((moments.effective_variance * 1e6 - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_range_of_nearly_one_size_keeps_its_variance() {
        // A constant law over a relative width w has v_e = w²/12.
        let moments = truncated_moments(1.0, (1.0, 1.0 + 1e-9), |v| 3.0 * v);
        let ratio = moments.effective_variance / (1e-18 / 12.0);
        // The ends hold 1e-9 to 1e-16.
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    }

    #[test]
    fn the_series_of_the_exponential_joins_its_closed_form() {
        for y in [0.5_f64, -0.5] {
            let series = exp_minus_linear(y * (1.0 - 1e-12));
            assert!((series / (y.exp_m1() - y) - 1.0).abs() < 1e-11);
        }
        assert!((exp_minus_linear(1e-9) / 5e-19 - 1.0).abs() < 1e-8);
    }
}
