//! Where the edge between two surfaces runs through a pixel of a map of distances, which tells one distance a pixel.
//!
//! own side: n·q >= d,   n = g/|g|,   g = sum_w q_w,   F(d) = N/25
//! `q` a place from the middle of the pixel [px], `w` those of the 5 x 5 pixels around it whose surface is its own, N of
//! them, `F(d)` the part of the 5 x 5 on the own side of a line with normal n at d: so the line has as much of the
//! surroundings on either side as the map, and turns with what it has of both. The middle of a pixel keeps its distance:
//! d <= 0. Where g is 0, as of a wire, there is no line, and all of the pixel is its own. An edge along the borders of
//! pixels stays where it is. Over straight edges of all directions the part of a pixel that is covered errs by 0.09 (RMS;
//! by 0.25 where pixels are one surface each), at a disc of 20 pixels' radius by 0.12 (0.22). Lines in pixels as fractions
//! of a fluid give them: D. L. Youngs, in Numerical Methods for Fluid Dynamics, Academic Press, 273-285 (1982).

use ndarray::Array2;

use crate::footprint_cuts::is_one_surface;

/// Pixels around the one in the middle that are looked at, on each side.
const REACH: i64 = 2;
const SIDE: f64 = 2.0 * REACH as f64 + 1.0;

/// Distance (m) at a place of a map, in its pixels from the corner top left.
pub(crate) fn distance_m(map: &Array2<f32>, (x_px, y_px): (f64, f64)) -> f64 {
    let (height, width) = map.dim();
    let index = |place: f64, n: usize| (place as usize).min(n - 1);
    let (column, row) = (index(x_px, width), index(y_px, height));
    let beside = |down: i64, across: i64| {
        let at = |index: usize, step: i64, n: usize| {
            index.saturating_add_signed(step as isize).min(n - 1)
        };
        f64::from(map[[at(row, down, height), at(column, across, width)]])
    };
    let own_m = beside(0, 0);
    let near = around(1);
    let is_own = |(down, across): (i64, i64)| is_one_surface(own_m, beside(down, across));
    if near.clone().all(is_own) {
        return own_m;
    }
    let (mut n, mut towards) = (0.0, [0.0, 0.0]);
    for (down, across) in around(REACH).filter(|it| is_own(*it)) {
        n += 1.0;
        towards[0] += across as f64;
        towards[1] += down as f64;
    }
    let length = f64::hypot(towards[0], towards[1]);
    if length == 0.0 {
        return own_m;
    }
    let normal = towards.map(|it| it / length);
    let from_middle = [x_px - column as f64 - 0.5, y_px - row as f64 - 0.5];
    let along = normal[0] * from_middle[0] + normal[1] * from_middle[1];
    if along >= line(normal, n / (SIDE * SIDE)).min(0.0) {
        return own_m;
    }
    // The nearest pixel of another surface.
    let square = |(down, across): &(i64, i64)| {
        (*across as f64 - from_middle[0]).powi(2) + (*down as f64 - from_middle[1]).powi(2)
    };
    let others = near.filter(|it| !is_own(*it));
    let nearest = others.min_by(|a, b| square(a).total_cmp(&square(b)));
    nearest.map_or(own_m, |(down, across)| beside(down, across))
}

/// Steps down and across to the pixels around one, itself among them.
fn around(reach: i64) -> impl Iterator<Item = (i64, i64)> + Clone {
    (-reach..=reach).flat_map(move |down| (-reach..=reach).map(move |across| (down, across)))
}

/// Where a line with this normal has a part of the square of [`SIDE`] on its side, from the middle.
fn line(normal: [f64; 2], part: f64) -> f64 {
    let [a, b] = normal.map(|it| it.abs() * SIDE);
    let (long, short) = (a.max(b), a.min(b));
    let less = part.min(1.0 - part);
    let from_corner = if less <= short / (2.0 * long) {
        (2.0 * long * short * less).sqrt()
    } else {
        less * long + 0.5 * short
    };
    let distance = 0.5 * (long + short) - from_corner;
    if part > 0.5 { -distance } else { distance }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const SIZE: usize = 60;
    const N_PLACES: usize = 16;

    /// RMS of the part of pixels that is covered, near an edge, by the rule and by whole pixels.
    fn errors(is_near: impl Fn(f64, f64) -> bool) -> [f64; 2] {
        let map = Array2::from_shape_fn((SIZE, SIZE), |(y, x)| {
            if is_near(x as f64 + 0.5, y as f64 + 0.5) {
                20.0
            } else {
                f32::INFINITY
            }
        });
        let (mut squares, mut n_pixels) = ([0.0, 0.0], 0.0);
        let inside = 5..SIZE - 5;
        for (y, x) in inside
            .clone()
            .flat_map(|y| inside.clone().map(move |x| (y, x)))
        {
            let mut covered = [0.0; 2];
            for place in 0..N_PLACES * N_PLACES {
                let at = |index: usize, part: usize| {
                    index as f64 + (part as f64 + 0.5) / N_PLACES as f64
                };
                let point = (at(x, place % N_PLACES), at(y, place / N_PLACES));
                covered[0] += f64::from(u8::from(is_near(point.0, point.1)));
                covered[1] += f64::from(u8::from(distance_m(&map, point) < 100.0));
            }
            let [true_part, found] = covered.map(|n| n / (N_PLACES * N_PLACES) as f64);
            let whole = f64::from(u8::from(map[[y, x]] < 100.0));
            if (true_part - whole).abs() > 0.0 || (found - whole).abs() > 0.0 {
                squares[0] += (found - true_part).powi(2);
                squares[1] += (whole - true_part).powi(2);
                n_pixels += 1.0;
            }
        }
        squares.map(|sum: f64| (sum / f64::max(n_pixels, 1.0)).sqrt())
    }

    #[test]
    fn edges_of_all_directions_are_where_they_are_to_a_tenth_of_a_pixel() {
        let mut sums = [0.0, 0.0];
        let n = 40;
        for index in 0..n {
            let turn = TAU * (f64::from(index) + 0.37) / f64::from(n);
            let shift = 0.61 * f64::from(index % 5) - 1.2;
            let line = |x: f64, y: f64| (x - 30.0) * turn.cos() + (y - 30.0) * turn.sin() > shift;
            for (sum, error) in sums.iter_mut().zip(errors(line)) {
                *sum += error * error / f64::from(n);
            }
        }
        let [rule, whole] = sums.map(f64::sqrt);
        assert!(rule < 0.12 && whole > 2.0 * rule, "{rule} {whole}");
        let [rule, whole] = errors(|x, y| (x - 30.0).hypot(y - 30.0) < 20.3);
        assert!(rule < 0.15 && whole > 1.5 * rule, "{rule} {whole}");
    }

    #[test]
    fn edges_along_borders_wires_and_middles_stay() {
        for is_near in [|x: f64, _: f64| x > 30.0, |_: f64, y: f64| y > 17.0] {
            assert!(errors(is_near)[0] < 1e-12);
        }
        // A wire of a pixel.
        assert!(errors(|x, _| (30.0..31.0).contains(&x))[0] < 1e-12);
        let spots = Array2::from_shape_fn((SIZE, SIZE), |(y, x)| {
            if (x * 7 + y * 13) % 5 < 2 { 20.0 } else { 90.0 }
        });
        for ((y, x), own) in spots.indexed_iter() {
            let found = distance_m(&spots, (x as f64 + 0.5, y as f64 + 0.5));
            assert!((found - f64::from(*own)).abs() < 1e-12, "{x} {y}");
        }
    }
}
