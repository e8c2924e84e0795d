//! Gauss-Kronrod quadrature of 15 nodes on 0..1: seven of them are Gauss's, so that one set of samples
//! gives an integral and, by the difference of both, an estimate of its error.
//!
//! Exact for polynomials up to degree 22, Gauss's up to 13: the error that remains is far smaller than
//! the difference.
//! [P83] Piessens, de Doncker-Kapenga, Ueberhuber and Kahaner, QUADPACK, Springer (1983), QK15.

use crate::gauss_legendre::Rule;

/// Positive nodes on -1..1 and their weights, then those of Gauss, 0 where he has no node.
const HALF_RULE: [[f64; 3]; 7] = [
    [0.991_455_371_120_812_6, 0.022_935_322_010_529_225, 0.0],
    [
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_55,
        0.129_484_966_168_869_69,
    ],
    [0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0],
    [
        0.741_531_185_599_394_4,
        0.140_653_259_715_525_92,
        0.279_705_391_489_276_67,
    ],
    [0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0],
    [
        0.405_845_151_377_397_17,
        0.190_350_578_064_785_41,
        0.381_830_050_505_118_94,
    ],
    [0.207_784_955_007_898_47, 0.204_432_940_075_298_89, 0.0],
];
/// Weights of the node in the middle.
const MIDDLE: [f64; 2] = [0.209_482_141_084_727_83, 0.417_959_183_673_469_39];

/// The rule, and by how much its weights exceed those of Gauss.
pub(crate) fn rule_and_excess() -> (Rule, Vec<f64>) {
    let below = HALF_RULE.map(|[x, kronrod, gauss]| [-x, kronrod, gauss]);
    let above = HALF_RULE.into_iter().rev();
    let [kronrod, gauss] = MIDDLE;
    let rows: Vec<[f64; 3]> = below
        .into_iter()
        .chain([[0.0, kronrod, gauss]])
        .chain(above)
        .collect();
    let nodes = rows.iter().map(|[x, ..]| 0.5 * (1.0 + x)).collect();
    let weights = rows.iter().map(|[_, kronrod, _]| 0.5 * kronrod).collect();
    let excess = rows
        .iter()
        .map(|[_, kronrod, gauss]| 0.5 * (kronrod - gauss))
        .collect();
    (Rule::through(nodes, weights), excess)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integrals(degree: i32) -> (f64, f64) {
        let (rule, excess) = rule_and_excess();
        let terms = rule.pairs().zip(excess);
        terms.fold((0.0, 0.0), |(sum, difference), ((x, weight), excess)| {
            let power = x.powi(degree);
            (sum + weight * power, difference + excess * power)
        })
    }

    #[test]
    fn polynomials_are_exact_to_degree_22_and_by_gauss_to_13() {
        for degree in 0..=22 {
            let exact = 1.0 / f64::from(degree + 1);
            let (sum, difference) = integrals(degree);
            assert!((sum - exact).abs() < 1e-15, "{degree}: {sum}");
            assert!(degree > 13 || difference.abs() < 1e-15, "{degree}");
        }
        let (_, difference) = integrals(14);
        assert!(difference.abs() > 1e-10, "{difference:e}");
    }

    #[test]
    fn running_integrals_are_those_of_a_polynomial() {
        let (rule, _) = rule_and_excess();
        let samples: Vec<f64> = rule.pairs().map(|(x, _)| x.powi(14)).collect();
        for (i, (x, _)) in rule.pairs().enumerate() {
            let error = rule.running(i, &samples) - x.powi(15) / 15.0;
            assert!(error.abs() < 1e-14, "{error:e}");
        }
    }

    #[test]
    fn the_difference_is_far_larger_than_the_error_that_remains() {
        let (rule, excess) = rule_and_excess();
        let f = |x: f64| (-20.0 * x * x).exp();
        // sqrt(pi/20)/2 erf(sqrt 20), erf = 1 - 2.5e-10.
        let exact = 0.5 * (std::f64::consts::PI / 20.0).sqrt();
        let found: f64 = rule.pairs().map(|(x, weight)| weight * f(x)).sum();
        let pairs = rule.pairs().zip(excess);
        let difference: f64 = pairs.map(|((x, _), excess)| excess * f(x)).sum();
        let error = (found - exact).abs();
        assert!(error < 1e-2 * difference.abs(), "{error:e} {difference:e}");
    }
}
