//! How sure it is that a part of a picture is its sky.
//!
//! ln p/(1 − p) = v0 + sum_i v_i f_i,   f = (a, a − a', ln (s + s0)/(s' + s0), faint, edge, solid)
//! `a`, `a'` how like any sky it and the rest look in the mean ([`sky_prior`](crate::sky_prior)); `s`, `s'` the median
//! [`sharpness`](crate::sky_border) in it and in the rest, `s0` [`LEAST_SHARP`]; `faint` the part of its edge across which
//! colors differ by less than [`FAINT`]; `edge` the length of that edge in widths of the picture; `solid` the mean over
//! the columns of which part of what lies above its lowest pixel it is.
//!
//! The weights are a logistic regression (ridge of 1 on standardized values) on what the guesses of a sky became in the
//! pictures that the weights of that prior are from: 1 where 98 % of the pixels are right, 0 where 88 % are or where there
//! is no sky, between these in proportion; each picture counts once.

use ndarray::Array2;

use crate::perceptual::square_apart;
use crate::sky_colors::Colors;
use crate::sky_mask::quantile;
use crate::sky_prior::LEAST_SHARP;

/// v0, and v of the signs in their order.
const NONE: f64 = -5.46;
const WEIGHTS: [f64; 6] = [0.313, 0.387, -0.831, -3.80, -0.32, 4.23];
/// Difference of color (Oklab) from pixel to pixel.
const FAINT: f32 = 0.03;

/// How sure it is that a part of a picture is its sky, 0..1, and why in words.
pub(crate) fn sky_score(
    sky: &Array2<bool>,
    colors: &Colors,
    sharpness: &Array2<f32>,
) -> (f64, Vec<String>) {
    let width = sky.ncols() as f64;
    if sky.row(0).iter().all(|is_sky| !is_sky) {
        return (0.0, vec!["nothing at the top edge is like one".to_owned()]);
    }
    let of = |wanted: bool, map: &Array2<f32>| -> Vec<f32> {
        let pixels = sky.iter().zip(map).filter(|(is_sky, _)| **is_sky == wanted);
        pixels.map(|(_, value)| *value).collect()
    };
    let [like, ground_like] = [true, false].map(|wanted| {
        let values = of(wanted, &colors.prior);
        f64::from(values.iter().sum::<f32>()) / values.len().max(1) as f64
    });
    let [sharp, ground_sharp] =
        [true, false].map(|wanted| quantile(of(wanted, sharpness), 0.5) + LEAST_SHARP);
    let rougher = f64::from(sharp / ground_sharp);
    let steps = steps_across(sky, &colors.lab);
    let n_faint = steps.iter().filter(|step| **step < FAINT).count();
    let faint = n_faint as f64 / steps.len().max(1) as f64;
    let edge = steps.len() as f64 / width;
    let solid = solid(sky);
    let signs = [like, like - ground_like, rougher.ln(), faint, edge, solid];
    let terms = signs.iter().zip(WEIGHTS);
    let score = NONE + terms.map(|(sign, weight)| sign * weight).sum::<f64>();
    let percent = |part: f64| format!("{:.0} %", 100.0 * part);
    let reasons = vec![
        format!(
            "its edge is sharp on {} of its length",
            percent(1.0 - faint)
        ),
        format!("that is {edge:.1} widths of the picture long"),
        format!("it takes {} of what is above its lowest", percent(solid)),
        format!("it has {} of the roughness of the rest", percent(rougher)),
        format!(
            "by color, light, place and roughness it is {} like a sky, the rest {}",
            in_words(like),
            in_words(ground_like)
        ),
    ];
    ((1.0 + (-score).exp()).recip(), reasons)
}

/// The mean over the columns of which part of what lies above its lowest pixel a part is.
fn solid(sky: &Array2<bool>) -> f64 {
    let parts = sky.columns().into_iter().map(|column| {
        let n_sky = column.iter().filter(|is_sky| **is_sky).count() as f64;
        let last = column.iter().rposition(|is_sky| *is_sky);
        last.map_or(0.0, |row| n_sky / (row as f64 + 1.0))
    });
    parts.sum::<f64>() / sky.ncols() as f64
}

/// A log ratio.
fn in_words(ratio: f64) -> &'static str {
    match ratio {
        ratio if ratio > 2.0 => "much",
        ratio if ratio > 0.5 => "rather",
        ratio if ratio > -0.5 => "somewhat",
        ratio if ratio > -2.0 => "little",
        _ => "not",
    }
}

/// Differences of color from pixel to pixel across the edge of a part.
fn steps_across(sky: &Array2<bool>, lab: &Array2<[f32; 3]>) -> Vec<f32> {
    let mut steps = Vec::new();
    for ((y, x), is_sky) in sky.indexed_iter() {
        for beside in [(y + 1, x), (y, x + 1)] {
            if sky.get(beside).is_some_and(|other| other != is_sky) {
                steps.push(square_apart(lab[[y, x]], lab[beside]).sqrt());
            }
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sky_border::sharpness;
    use crate::sky_prior::sky_prior;

    #[test]
    fn what_is_blue_above_land_is_surer_than_any_other_part_and_a_part_without_top_edge_is_none() {
        let lab = Array2::from_shape_fn((60, 80), |(y, x)| {
            let grain = 0.1 * ((x * x * 7 + y * 13 + x * y) % 97) as f32 / 97.0;
            if y < 30 {
                [0.8, -0.02, -0.07]
            } else {
                [0.45 + grain, -0.05, 0.06]
            }
        });
        let sharp = sharpness(&lab);
        let colors = Colors::new(lab.clone(), sky_prior(&lab, &sharp));
        let score = |is_sky: &dyn Fn(usize, usize) -> bool| {
            let sky = Array2::from_shape_fn(lab.dim(), |(y, x)| is_sky(y, x));
            sky_score(&sky, &colors, &sharp).0
        };
        let right = score(&|y, _| y < 30);
        assert!(right > 0.9, "{right}");
        let land = score(&|y, _| y >= 30);
        assert!(land <= 0.0, "{land}");
        let wrong: [&dyn Fn(usize, usize) -> bool; 4] =
            [&|y, _| y < 15, &|y, _| y < 50, &|_, x| x < 40, &|y, x| {
                y == 0 || (x * 7 + y * 5) % 11 < 5
            }];
        for (index, is_sky) in wrong.into_iter().enumerate() {
            let other = score(is_sky);
            assert!(other < 0.8 * right, "{index}: {other} {right}");
        }
    }
}
