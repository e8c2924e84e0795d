//! Effective radii and variances between which the light of drops is interpolated linearly.
//!
//! Even steps of ln r_e, 46 for a factor e at an error of 0.45 % of the bow's peak; fewer for broad laws, down to
//! a quarter. Steps of v_e from a list. Both are measured, not derived: for theories of bows and Debye
//! orders the error half way between radii is a fifth to a hundredth of the tolerance from 5 µm to 3 mm,
//! and the exact solution keeps it from v_e = 0.05 on.

use crate::Error;

/// Steps of the effective radius for each factor e at which a single size is interpolated half way
/// between two nodes to 0.45 % of the bow's peak (rms over 136 to 145 degrees and 10 µm to 1.5 mm,
/// after the sun's disc).
const STEPS_PER_EFOLD: f64 = 46.0;
/// The error at these steps; it falls with the square of the step.
const ERROR_AT_STEPS: f64 = 4.5e-3;
/// Broader laws change more slowly with the radius: their nodes may lie apart by this part of their width,
/// up to four steps of a single size.
const STEP_OF_WIDTH: f64 = 0.46;
const MOST_SINGLE_STEPS: f64 = 4.0;
/// Step of ln r between bins, the error it is for, and its largest part of the width of a law.
const BIN_STEP: f64 = 0.07;
const BIN_ERROR: f64 = 5e-3;
const BIN_OF_WIDTH: f64 = 0.5;
/// Of steps of a file.
const ROUNDOFF: f64 = 1e-6;
/// Nodes of the effective variance. Half way between them the uniform theory is off by at most 1.2e-3
/// rms of the peak, measured for 20, 50, 150 and 500 µm radius.
const VARIANCES: [f64; 13] = [
    0.0,
    0.002,
    0.005,
    0.01,
    0.02,
    0.033,
    0.05,
    0.07,
    0.1,
    0.14,
    0.2,
    0.26,
    1.0 / 3.0,
];

/// Effective radii from `min_um` to `max_um`, even in their logarithm.
///
/// # Errors
/// If the range is empty or not positive, or the tolerance not within 1e-5 to 1.
pub fn radius_axis(
    (min_um, max_um): (f64, f64),
    smallest_variance: f64,
    tolerance: f64,
) -> Result<Vec<f64>, Error> {
    if !(min_um > 0.0 && max_um >= min_um && max_um.is_finite()) {
        return Err(Error::Range {
            parameter: "effective radius in um",
            min: min_um,
            max: max_um,
            expected: "an ascending range above 0",
        });
    }
    if !(1e-5..=1.0).contains(&tolerance) {
        return Err(Error::Parameter {
            parameter: "tolerance",
            found: tolerance,
            expected: "a number from 1e-5 to 1",
        });
    }
    let efolds = (max_um / min_um).ln();
    if efolds < 1e-6 {
        return Ok(vec![min_um]);
    }
    let single_step = single_size_step(tolerance);
    let of_width = STEP_OF_WIDTH * smallest_variance.sqrt() * (tolerance / BIN_ERROR).sqrt();
    let widest = of_width.clamp(single_step, MOST_SINGLE_STEPS * single_step);
    let n_steps = (efolds / widest).ceil().max(1.0) as usize;
    let step = efolds / n_steps as f64;
    let mut axis: Vec<f64> = (0..=n_steps)
        .map(|i| min_um * (step * i as f64).exp())
        .collect();
    axis[n_steps] = max_um;
    Ok(axis)
}

/// Step of ln r of single sizes whose sum is any law no narrower than `narrowest_variance`, to an error of the
/// bow's peak: 7 % at an error of 0.5 %, where Marshall-Palmer rain of 25 mm/h, flat and moved, errs by 0.25 % of
/// the peak (rms), and by 0.04 % at an error of 0.05 %; never more than half of the narrowest law's width.
/// `None` where single sizes serve as laws of their own: narrower bins than [`radius_axis`] has for a single size.
pub fn bin_step(narrowest_variance: f64, tolerance: f64) -> Option<f64> {
    let root = tolerance.sqrt();
    let of_peak = BIN_STEP * root / BIN_ERROR.sqrt();
    let of_single_size = single_size_step(tolerance);
    let step = of_peak.min(BIN_OF_WIDTH * narrowest_variance.sqrt());
    (step > of_single_size).then_some(step)
}

/// Step of ln r at which single sizes serve as laws of their own.
fn single_size_step(tolerance: f64) -> f64 {
    (tolerance / ERROR_AT_STEPS).sqrt() / STEPS_PER_EFOLD
}

/// Effective variance of the narrowest law that is a sum of single sizes at this step of ln r, to an error
/// of the bow's peak; 0 where single sizes serve as laws of their own. What [`bin_step`] undoes.
pub fn narrowest_variance(ln_step: f64, tolerance: f64) -> f64 {
    let of_single_size = single_size_step(tolerance);
    // Steps of an axis that was divided evenly are a little shorter.
    if ln_step > (1.0 + ROUNDOFF) * of_single_size {
        (ln_step / BIN_OF_WIDTH).powi(2)
    } else {
        0.0
    }
}

/// Radii at whole steps of ln r in micrometres that hold a range, so that ranges share theirs.
pub fn bins((min_um, max_um): (f64, f64), step: f64) -> Vec<f64> {
    let (low, high) = ((min_um.ln() / step).floor(), (max_um.ln() / step).ceil());
    (low as i64..=high as i64)
        .map(|index| (index as f64 * step).exp())
        .collect()
}

/// Effective variances from `min` to `max`.
///
/// # Errors
/// If the range is empty or not within 0 to below 1/2.
pub fn variance_axis((min, max): (f64, f64)) -> Result<Vec<f64>, Error> {
    if !(min >= 0.0 && max >= min && max < 0.5) {
        return Err(Error::Range {
            parameter: "effective variance",
            min,
            max,
            expected: "an ascending range from 0 to below 0.5",
        });
    }
    let inside = VARIANCES
        .into_iter()
        .filter(|&variance| variance > min && variance < max);
    let mut axis: Vec<f64> = [min].into_iter().chain(inside).collect();
    if max > min {
        axis.push(max);
    }
    Ok(axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_their_range_at_whole_steps_and_narrow_laws_have_none() {
        let step = bin_step(1.0 / 3.0, 5e-3).unwrap();
        assert!((step - 0.07).abs() < 1e-12);
        assert!((bin_step(0.01, 5e-3).unwrap() - 0.05).abs() < 1e-12);
        assert!(bin_step(0.0, 5e-3).is_none() && bin_step(1e-3, 5e-3).is_none());
        for variance in [3e-3, 0.01, 0.015] {
            let narrowest = narrowest_variance(bin_step(variance, 5e-3).unwrap(), 5e-3);
            assert!((narrowest - variance).abs() < 1e-12);
        }
        assert!(narrowest_variance(step, 5e-3) <= 1.0 / 3.0);
        assert_eq!(narrowest_variance(1.0 / 46.0, 5e-3), 0.0);
        let radii = bins((20.0, 3000.0), step);
        assert!(radii[0] <= 20.0 && radii[1] > 20.0);
        assert!(radii[radii.len() - 1] >= 3000.0 && radii[radii.len() - 2] < 3000.0);
        let more = bins((15.0, 2000.0), step);
        let shared = radii.iter().filter(|radius| **radius < 2000.0);
        assert!(shared.into_iter().all(|radius| more.contains(radius)));
        assert_eq!(bins((1.0, 1.0), step), [1.0]);
    }

    #[test]
    fn axes_hold_their_ends_and_ascend() {
        let radii = radius_axis((10.0, 1500.0), 0.0, 2e-3).unwrap();
        assert_eq!((radii[0], radii[radii.len() - 1]), (10.0, 1500.0));
        assert!(radii.windows(2).all(|pair| pair[1] > pair[0]));
        assert_eq!(radius_axis((100.0, 100.0), 0.0, 2e-3).unwrap(), [100.0]);
        assert_eq!(variance_axis((0.0, 0.0)).unwrap(), [0.0]);
        assert_eq!(variance_axis((0.0, 0.005)).unwrap(), [0.0, 0.002, 0.005]);
        assert_eq!(variance_axis((1.0 / 3.0, 1.0 / 3.0)).unwrap(), [1.0 / 3.0]);
    }

    #[test]
    fn impossible_ranges_are_refused() {
        for range in [
            (0.0, 1.0),
            (-1.0, 2.0),
            (5.0, 4.0),
            (f64::NAN, 1.0),
            (1.0, f64::INFINITY),
        ] {
            assert!(radius_axis(range, 0.0, 1e-3).is_err());
        }
        assert!(radius_axis((1.0, 2.0), 0.0, 0.0).is_err());
        for range in [(-0.1, 0.2), (0.0, 0.5), (0.3, 0.2), (f64::NAN, 0.1)] {
            assert!(variance_axis(range).is_err());
        }
    }
}
