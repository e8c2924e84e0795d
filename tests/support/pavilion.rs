//! The shipped photograph cropped, turned by 3 degrees and darkened, with the sky that is known of it.

use ndarray::Array2;
use ndarray::s;
use niji_photo::LinearPicture;

/// A photograph whose sky is known.
pub struct Changed {
    pub name: &'static str,
    pub light: LinearPicture,
    /// 1 where there is sky.
    pub sky: Array2<f32>,
    /// Where a point of the shipped photograph is found in it.
    pub moved: fn([f64; 2]) -> [f64; 2],
    /// How far its right side went down, degrees.
    pub roll_deg: f64,
}

const TURN_DEG: f64 = 3.0;
/// Size of the turned picture, and the middles of both.
const SIZE: (usize, usize) = (387, 600);
const MIDDLE: [f64; 2] = [300.0, 193.5];
const OLD_MIDDLE: [f64; 2] = [320.0, 213.5];
/// First column and row of the cropped one.
const FIRST: [usize; 2] = [60, 30];

/// The three of it.
pub fn changed(light: &LinearPicture, sky: &Array2<f32>) -> [Changed; 3] {
    let part = s![FIRST[1]..390, FIRST[0]..600];
    let turned = |(y, x): (usize, usize)| {
        let (sin, cos) = TURN_DEG.to_radians().sin_cos();
        let (dx, dy) = (x as f64 - MIDDLE[0], y as f64 - MIDDLE[1]);
        let at = |value: f64, n: usize| (value.round() as usize).min(n - 1);
        [
            at(OLD_MIDDLE[1] + cos * dy - sin * dx, light.nrows()),
            at(OLD_MIDDLE[0] + cos * dx + sin * dy, light.ncols()),
        ]
    };
    let cropped = Changed {
        name: "cropped",
        light: light.slice(part).to_owned(),
        sky: sky.slice(part).to_owned(),
        moved: |[x, y]| [x - FIRST[0] as f64, y - FIRST[1] as f64],
        roll_deg: 0.0,
    };
    let turned = Changed {
        name: "turned",
        light: Array2::from_shape_fn(SIZE, |at| light[turned(at)]),
        sky: Array2::from_shape_fn(SIZE, |at| sky[turned(at)]),
        moved: |[x, y]| {
            let (sin, cos) = TURN_DEG.to_radians().sin_cos();
            let (dx, dy) = (x - OLD_MIDDLE[0], y - OLD_MIDDLE[1]);
            [
                MIDDLE[0] + cos * dx - sin * dy,
                MIDDLE[1] + sin * dx + cos * dy,
            ]
        },
        roll_deg: -TURN_DEG,
    };
    let darkened = Changed {
        name: "darkened",
        light: light.mapv(|pixel| pixel.map(|it| 0.25 * it)),
        sky: sky.clone(),
        moved: |point| point,
        roll_deg: 0.0,
    };
    [cropped, turned, darkened]
}
