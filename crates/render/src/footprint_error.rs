//! What the rays of a pixel miss of its mean, from the pixels around it.
//!
//! With second and fourth differences d2, d4 of luminance over five pixels in a row the mean over a
//! pixel of side 1 exceeds the value in its middle by d2/24 where luminance is smooth, by up to d4/6
//! next to a step or on a line thinner than a pixel, by d4/16 at a kink. The estimate is the sum over
//! both directions of
//! 1.5 |d2| / (24 n²) + (2/9) d4² / (|d2| + |d4|) / n^1.5
//! `n` rays along a side: the midpoint rule errs with 1/n², at a step askew to the pixels
//! with 1/n^1.5. The second term is
//! half of a step, d4 = 3 d2, and of higher order than the first where luminance is smooth. The
//! largest of three neighboring d2 stands for the one in the middle, whose sign may just change; a half
//! is added for what d2 leaves out where luminance bends unevenly.
//!
//! The corner of a surface that hides a diagonal neighbor and none beside the pixel covers up to a quarter of it: half
//! of the sum along a diagonal stands for it where that is more.
//!
//! Of a horizon within a pixel n rays along a side show most, and its neighbors little: it looks like any slope from one
//! to the other. In the mean over the rows and over the columns of rays
//! [s - |L_+1 - L_-1| / (2n)] / (2n - 1)
//! is added, `s` the largest difference between neighboring rays: that of a slope is what is taken away, that of a step
//! along a row of rays makes them err by s/(2n) at most.
//!
//! Where distances are those of whole pixels, a pixel beside an edge of surfaces has the light of its own: on
//! another surface the last pixel before it stands for the next.
//!
//! A prefiltered pixel has the mean of the table's row, so that its light L = W t errs only by what
//! the row knows nothing of: the light W that reaches drops, t d2(W)/24 and so on, the product of
//! both slopes, W' t'/12, and a part of what the ray in the middle would miss: drops of other sizes
//! across the pixel, and the shape of a pixel that lies askew to the bow, for which an interval of
//! equal variance stands. The scattering angle bends, too: its mean over a pixel w wide exceeds that in
//! its middle by w²/24 cot theta, and more where a flat picture stretches the view, so that the row is that
//! of a place w/8 pixels away at most, but near the shadow of the head, where no bow stands.

use ndarray::Array2;

use crate::footprint::REACH_PX;
use crate::footprint_cuts::is_one_surface;
use crate::levels::PixelFootprint;

/// Over what even bends miss. Without it 97 to 99.7 % of the pixels of smooth pictures were covered, with ratios
/// from 0.8 on.
const SAFETY: f64 = 1.5;

/// Makes half of a step out of d4² / (d2 + d4) = 9/4 of it.
const STEP: f64 = 2.0 / 9.0;

/// What a corner covers that hides a diagonal neighbor and none beside the pixel, over what a step does.
const CORNER: f64 = 0.5;

/// Part of a ray's error that prefiltering leaves: 0.02 to 0.08 on the scenes of the tests.
const UNFILTERED: f64 = 0.1;

/// Pixels by which the row is displaced, for each radian that a pixel is wide.
const DISPLACED: f64 = 1.0 / 8.0;

/// What an estimate knows of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PixelLight {
    /// Luminance of the bows [cd/m²].
    pub(crate) bow: f32,
    /// All other luminance [cd/m²].
    pub(crate) beside: f32,
    /// Light that drops get and send on [-].
    pub(crate) light: f32,
    /// Distance of the surface that all of it has (m); 0 where there may be several in it.
    pub(crate) surface_m: f32,
    /// As of [`ray_steps`]; 0 of a single ray.
    pub(crate) ray_steps: [f32; 2],
}

impl PixelLight {
    /// Of all light [cd/m²].
    fn luminance(&self) -> f64 {
        f64::from(self.bow + self.beside)
    }
}

/// Largest difference between neighbors among n x n rays of a pixel, row by row, along a row and along a column [cd/m²]: means
/// over the rows and the columns.
pub(crate) fn ray_steps(luminances: &[f64], n: usize) -> [f32; 2] {
    let mean = |at: &dyn Fn(usize, usize) -> f64| {
        let step = |line, place| (at(line, place) - at(line, place - 1)).abs();
        let largest = |line| (1..n).map(|place| step(line, place)).fold(0.0, f64::max);
        ((0..n).map(largest).sum::<f64>() / n as f64) as f32
    };
    [
        mean(&|row, column| luminances[row * n + column]),
        mean(&|column, row| luminances[row * n + column]),
    ]
}

/// A pixel, two before it and two behind it.
type Five = [f64; 5];

/// Largest second and the fourth difference.
#[derive(Clone, Copy)]
struct Bend {
    second: f64,
    fourth: f64,
}

impl Bend {
    fn of(values: &Five) -> Self {
        let second = |at: usize| values[at - 1] - 2.0 * values[at] + values[at + 1];
        let [before, here, behind] = [1, 2, 3].map(second);
        Self {
            second: before.abs().max(here.abs()).max(behind.abs()),
            fourth: (before - 2.0 * here + behind).abs(),
        }
    }

    /// What n rays along a side miss.
    fn missed_by(self, n: u32) -> f64 {
        let n = f64::from(n);
        let smooth = SAFETY * self.second / (24.0 * n * n);
        let both = self.second + self.fourth;
        if both <= 0.0 {
            return 0.0;
        }
        smooth + STEP * self.fourth * self.fourth / (both * n * n.sqrt())
    }
}

/// Lines of five pixels through one: across, down, and both diagonals.
pub(crate) type Lines = [[PixelLight; 5]; 4];

/// Columns and rows from a pixel of each line to the next.
const STEPS: [[i32; 2]; 4] = [[1, 0], [0, 1], [1, 1], [-1, 1]];

/// Columns and rows from the middle of a line to its pixels.
fn places([across, down]: [i32; 2]) -> [[i32; 2]; 5] {
    [-2, -1, 0, 1, 2].map(|at| [at * across, at * down])
}

/// The lines through a pixel; `lights_around` reach [`REACH_PX`] beyond the pixels that are counted.
pub(crate) fn lines_through(lights_around: &Array2<PixelLight>, x: usize, y: usize) -> Lines {
    let reach = REACH_PX as usize;
    let at = |from: usize, steps: i32| (from + reach).saturating_add_signed(steps as isize);
    let light = |[across, down]: [i32; 2]| lights_around[[at(y, down), at(x, across)]];
    let lines = STEPS.map(|step| places(step).map(light));
    lines.map(on_one_surface)
}

/// A line on the surface of its middle.
fn on_one_surface(five: [PixelLight; 5]) -> [PixelLight; 5] {
    inwards(five, |five, at, inwards| {
        let [here, before] = [at, inwards].map(|it: usize| f64::from(five[it].surface_m));
        is_one_surface(here, before)
    })
}

/// The lines through a pixel whose rays all meet the same, by those of its neighbors that meet it too: what lies beyond
/// an edge is nothing that it misses. `is_alike` is asked by columns and rows from the pixel.
pub(crate) fn on_this_side(lines: &Lines, is_alike: impl Fn([i32; 2]) -> bool) -> Lines {
    std::array::from_fn(|line| {
        let places = places(STEPS[line]);
        inwards(lines[line], |_, at, _| is_alike(places[at]))
    })
}

/// A line in which each pixel that is not kept, by its index and that of the next one inwards, is as the latter.
fn inwards(
    mut five: [PixelLight; 5],
    is_kept: impl Fn(&[PixelLight; 5], usize, usize) -> bool,
) -> [PixelLight; 5] {
    for (at, inwards) in [(1, 2), (0, 1), (3, 2), (4, 3)] {
        if !is_kept(&five, at, inwards) {
            five[at] = five[inwards];
        }
    }
    five
}

/// Estimated error of a pixel's luminance [cd/m²], from lines of pixels through it, which are `width_rad` wide.
pub(crate) fn footprint_error(lines: &Lines, footprint: PixelFootprint, width_rad: f64) -> f64 {
    let of_line = |five: &[PixelLight; 5]| match footprint {
        PixelFootprint::Center => all(five).missed_by(1),
        PixelFootprint::Grid { n } => all(five).missed_by(n),
        PixelFootprint::Prefiltered => prefiltered(five, width_rad),
    };
    let [across, down, falling, rising] = lines.each_ref().map(of_line);
    let both = (across + down).max(CORNER * falling.max(rising));
    match footprint {
        PixelFootprint::Grid { n } => both + between_rays(lines, n),
        PixelFootprint::Center | PixelFootprint::Prefiltered => both,
    }
}

/// What an edge between n rays along a side of a pixel makes them err by.
fn between_rays(lines: &Lines, n: u32) -> f64 {
    let n_halves = 2.0 * f64::from(n);
    let along = |axis: usize| {
        let five = &lines[axis];
        let [before, behind] = [1, 3].map(|at| five[at].luminance());
        let of_slope = (behind - before).abs() / n_halves;
        (f64::from(five[2].ray_steps[axis]) - of_slope).max(0.0) / (n_halves - 1.0)
    };
    along(0) + along(1)
}

/// Half of the largest difference of luminance between a pixel and its eight neighbors [cd/m²].
pub(crate) fn half_step(lines: &Lines) -> f64 {
    let near = lines.iter().flat_map(|five| &five[1..4]);
    let luminances = near.map(PixelLight::luminance);
    let (darkest, brightest) = luminances.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    0.5 * (brightest - darkest)
}

fn all(five: &[PixelLight; 5]) -> Bend {
    Bend::of(&five.each_ref().map(PixelLight::luminance))
}

fn prefiltered(five: &[PixelLight; 5], width_rad: f64) -> f64 {
    let beside = Bend::of(&five.map(|pixel| f64::from(pixel.beside)));
    let light = five.map(|pixel| f64::from(pixel.light));
    let bow = five.map(|pixel| f64::from(pixel.bow));
    let row = |at: usize| {
        if light[at] > 0.0 {
            bow[at] / light[at]
        } else {
            0.0
        }
    };
    let brightest = row(1).max(row(2)).max(row(3));
    let slopes = if light[1] > 0.0 && light[3] > 0.0 {
        0.25 * (light[3] - light[1]) * (row(3) - row(1))
    } else {
        0.0
    };
    let displaced = DISPLACED * width_rad * 0.5 * (bow[3] - bow[1]);
    beside.missed_by(1)
        + brightest * Bend::of(&light).missed_by(1)
        + slopes.abs() / 12.0
        + displaced.abs()
        + UNFILTERED * Bend::of(&bow).missed_by(1)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use niji_geometry::Camera;
    use niji_geometry::PinholeCamera;
    use niji_geometry::PinholeRequest;
    use niji_radiometry::Radians;

    use super::*;
    use crate::scattering_angle::scattering_angle_rad;

    #[test]
    fn an_edge_of_whole_pixels_is_no_error_and_one_inside_of_them_is() {
        let lights = |surface_m: fn(usize) -> f32| {
            Array2::from_shape_fn((5, 5), |(_, x)| PixelLight {
                beside: if x < 2 { 0.0 } else { 100.0 },
                surface_m: surface_m(x),
                ..PixelLight::default()
            })
        };
        let missed = |lights: &Array2<PixelLight>| {
            let lines = lines_through(lights, 0, 0);
            (
                footprint_error(&lines, PixelFootprint::Prefiltered, 1e-3),
                half_step(&lines),
            )
        };
        let far = |x: usize| if x < 2 { 200.0 } else { f32::INFINITY };
        assert_eq!(missed(&lights(far)), (0.0, 0.0));
        let (error, step) = missed(&lights(|_| 0.0));
        assert!(error > 30.0 && step >= 50.0, "{error} {step}");
    }

    #[test]
    fn an_edge_between_the_rays_of_a_pixel_is_told_and_a_slope_is_not() {
        // A pixel a side wide about the origin, and its neighbors.
        let told = |n: usize, luminance: &dyn Fn(f64) -> f64| {
            let rays = |middle: f64| {
                let place = move |index: usize| middle + (index as f64 + 0.5) / n as f64 - 0.5;
                (0..n).flat_map(move |row| (0..n).map(move |_| place(row)))
            };
            let light = |middle: f64| {
                let luminances: Vec<f64> = rays(middle).map(luminance).collect();
                PixelLight {
                    beside: (luminances.iter().sum::<f64>() / (n * n) as f64) as f32,
                    ray_steps: ray_steps(&luminances, n),
                    ..PixelLight::default()
                }
            };
            let down = [-2.0, -1.0, 0.0, 1.0, 2.0].map(light);
            let lines = [[down[2]; 5], down, down, down];
            let n = n as u32;
            let error = footprint_error(&lines, PixelFootprint::Grid { n }, 1e-3);
            (f64::from(down[2].beside), error)
        };
        for n in [2, 4, 8] {
            // Beyond the outermost rays only the neighbors show it.
            for edge in [-0.24, -0.1, -0.07, 0.0, 0.2, 0.249] {
                let (found, error) = told(n, &|y| if y < edge { 1.0 } else { 0.2 });
                let off = (found - (0.2 + 0.8 * (edge + 0.5))).abs();
                assert!(
                    off <= 1.01 * error && error < 0.6 / n as f64,
                    "{n} {edge}: {off} {error}"
                );
            }
            let (_, of_slope) = told(n, &|y| 1.0 + 0.3 * y);
            assert!(of_slope < 1e-6, "{n}: {of_slope}");
        }
    }

    #[test]
    fn what_lies_beyond_an_edge_beside_a_pixel_is_none_of_its_errors() {
        // Sky above the third row of five, twice as bright ground that gets brighter downwards below it.
        let lights = Array2::from_shape_fn((5, 5), |(y, _)| PixelLight {
            beside: [50.0, 50.0, 100.0, 101.0, 102.0][y],
            ..PixelLight::default()
        });
        let lines = lines_through(&lights, 0, 0);
        let missed = |lines: &Lines| footprint_error(lines, PixelFootprint::Prefiltered, 1e-3);
        let on_ground = on_this_side(&lines, |[_, down]| down >= 0);
        assert!(missed(&lines) > 5.0 && missed(&on_ground) < 0.5);
        // All four lines keep what is met, and nothing of what is not.
        let values = |line: usize| on_ground[line].map(|pixel| pixel.beside);
        assert_eq!(values(0), [100.0; 5]);
        for line in 1..4 {
            assert_eq!(values(line), [100.0, 100.0, 100.0, 101.0, 102.0]);
        }
    }

    #[test]
    fn a_prefiltered_straight_row_errs_by_the_bend_of_the_scattering_angle() {
        // Even light and a row that is linear in the angle: in the middle of a pixel its mean.
        let sun_direction = DVec3::new(0.1, 0.3, 1.0).normalize();
        for horizontal_fov_deg in [2.0, 20.0, 90.0] {
            let camera: Camera = PinholeCamera::new(PinholeRequest {
                position: DVec3::ZERO,
                azimuth: Radians(0.0),
                elevation: Radians(0.45),
                roll: Radians(0.0),
                horizontal_fov: Radians::from_degrees(horizontal_fov_deg),
                width_px: 80,
                height_px: 50,
            })
            .unwrap()
            .into();
            let angle =
                |x, y| scattering_angle_rad(camera.ray(x, y).unwrap().direction, sun_direction);
            let seen_light = |x: u32, y: u32| PixelLight {
                bow: angle(f64::from(x) + 0.5, f64::from(y) + 0.5) as f32,
                light: 1.0,
                ..PixelLight::default()
            };
            let (mut n, mut n_covered) = (0, 0);
            for (x, y) in (2..48).flat_map(|y| (2..78).map(move |x| (x, y))) {
                let steps = [0_u32, 1, 2, 3, 4];
                let lines = [
                    steps.map(|step| seen_light(x + step - 2, y)),
                    steps.map(|step| seen_light(x, y + step - 2)),
                    steps.map(|step| seen_light(x + step - 2, y + step - 2)),
                    steps.map(|step| seen_light(x + 2 - step, y + step - 2)),
                ];
                let missed =
                    footprint_error(&lines, PixelFootprint::Prefiltered, camera.pixel_angle().0);
                let [x, y] = [x, y].map(f64::from);
                let place = |step: i32| (f64::from(step) + 0.5) / 8.0;
                let inside = (0..64).map(|step| angle(x + place(step / 8), y + place(step % 8)));
                let middle = angle(x + 0.5, y + 0.5);
                let error = inside.sum::<f64>() / 64.0 - middle;
                // Where bows stand.
                if !(2.1..2.6).contains(&middle) {
                    continue;
                }
                n += 1;
                n_covered += i32::from(missed >= error.abs());
            }
            assert!(
                n > 500 && f64::from(n_covered) >= 0.99 * f64::from(n),
                "{horizontal_fov_deg}: {n_covered} of {n}"
            );
        }
    }
}
