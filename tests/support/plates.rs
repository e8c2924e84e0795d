//! Plates by seed whose sky is known: terrain, skies, clouds, trees, buildings, lakes, and pictures without a sky.
//!
//! Five skies take turns: clear, with clouds, overcast, the dark ones of showers before which the ground lies in the sun, and
//! those of a low sun. Seeds that end in 3 have white buildings before an overcast sky, in 5 a lake that mirrors the sky,
//! in 7 dark trees with holes in front, in 9 a branch that hangs in from above.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "each target uses its own part, and may panic"
)]

#[path = "plate_noise.rs"]
mod noise;
#[path = "plate_rooms.rs"]
mod rooms;

use std::path::Path;

use ndarray::Array2;
use niji_photo::LinearPicture;
use niji_photo::Photograph;
use niji_photo::write_jpeg;
use noise::Color;
use noise::Random;
use noise::mix;
use noise::smooth;
use noise::times;
use rooms::room;
use rooms::thicket;

/// Samples along each side of a pixel.
const N_SUB: usize = 3;

/// A picture and the truth about it.
pub struct Plate {
    /// Linear light, with the noise of a sensor.
    pub light: LinearPicture,
    /// Part of each pixel that is sky.
    pub sky: Array2<f32>,
}

impl Plate {
    /// Writes it as a camera does and reads it back.
    pub fn through_jpeg(&self, path: &Path) -> Photograph {
        write_jpeg(&self.light, std::fs::File::create(path).unwrap()).unwrap();
        Photograph::read(path).unwrap()
    }
}

/// Part of the pixels at which a mask says what is true.
pub fn agreement(found: &Array2<bool>, truth: &Array2<f32>) -> f64 {
    let right = found
        .iter()
        .zip(truth)
        .filter(|(found, truth)| **found == (**truth > 0.5));
    right.count() as f64 / truth.len() as f64
}

/// The plate of a seed.
pub fn plate(seed: u64, size: [usize; 2]) -> Plate {
    let world = World::new(seed);
    drawn(size, seed, |x, y| world.at(x, y))
}

/// Where its horizon lies, from 0 at the top to 1.
pub fn horizon(seed: u64) -> f64 {
    World::new(seed).horizon
}

/// A room under a white ceiling, or a thicket that fills the picture: no sky in either.
pub fn without_sky(seed: u64, size: [usize; 2]) -> Plate {
    let random = Random(seed);
    drawn(size, seed, |x, y| {
        let shade = if seed.is_multiple_of(2) {
            room(random, x, y)
        } else {
            thicket(random, x, y)
        };
        (shade, false)
    })
}

/// x runs from 0 to 1.5 for a picture of 3 to 2, y from 0 at the top to 1.
fn drawn([width, height]: [usize; 2], seed: u64, at: impl Fn(f64, f64) -> (Color, bool)) -> Plate {
    let mut sky = Array2::zeros((height, width));
    let noise = Random(seed ^ 0xfeed);
    let light = Array2::from_shape_fn((height, width), |(row, column)| {
        let mut sum = [0.0; 3];
        let mut n_sky = 0;
        for index in 0..N_SUB * N_SUB {
            let place = |pixel: usize, sub: usize| {
                (pixel as f64 + (sub as f64 + 0.5) / N_SUB as f64) / height as f64
            };
            let (color, is_sky) = at(place(column, index % N_SUB), place(row, index / N_SUB));
            sum = std::array::from_fn(|channel| sum[channel] + color[channel]);
            n_sky += usize::from(is_sky);
        }
        let n = (N_SUB * N_SUB) as f64;
        sky[[row, column]] = n_sky as f32 / n as f32;
        std::array::from_fn(|channel| {
            let value = sum[channel] / n;
            let pixel = 3 * (row * width + column) as i64 + channel as i64;
            let grain: f64 = (0..4).map(|it| noise.at(pixel, it) - 0.5).sum();
            (value + grain * (0.003 + 0.02 * value.max(0.0).sqrt())).clamp(0.0, 1.0) as f32
        })
    });
    Plate { light, sky }
}

struct Tree {
    x: f64,
    foot: f64,
    size: f64,
    random: Random,
    holes: f64,
}

struct Building {
    left: f64,
    right: f64,
    top: f64,
    gable: f64,
    wall: Color,
}

struct World {
    random: Random,
    kind: u64,
    horizon: f64,
    zenith: Color,
    low_sky: Color,
    ridges: Vec<(f64, f64, f64)>,
    ground: Color,
    lake: Option<[f64; 2]>,
    trees: Vec<Tree>,
    buildings: Vec<Building>,
    has_branch: bool,
}

impl World {
    fn new(seed: u64) -> Self {
        let random = Random(seed);
        let last = seed % 10;
        let kind = if last == 3 { 2 } else { seed % 5 };
        let (zenith, low_sky) = match kind {
            0 => ([0.10, 0.22, 0.55], [0.45, 0.62, 0.85]),
            1 => ([0.13, 0.27, 0.62], [0.40, 0.55, 0.80]),
            2 => ([0.50, 0.53, 0.58], [0.80, 0.82, 0.84]),
            3 => ([0.10, 0.12, 0.16], [0.22, 0.25, 0.30]),
            _ => ([0.16, 0.22, 0.42], [0.90, 0.55, 0.30]),
        };
        let horizon = random.within(1, 0.55, 0.78);
        let n_ridges = (random.within(2, 1.0, 4.0)) as i64;
        let ridges = (0..n_ridges).map(|index| {
            let near = (index + 1) as f64 / n_ridges as f64;
            let height = random.within(10 + index, 0.05, 0.28) * (1.2 - 0.7 * near);
            (
                height,
                random.within(20 + index, 1.0, 3.0) + 2.0 * near,
                near,
            )
        });
        let ridges = ridges.collect();
        let light = if kind == 3 { 1.6 } else { 0.8 };
        let greens = [[0.10, 0.16, 0.04], [0.20, 0.17, 0.08], [0.07, 0.12, 0.05]];
        let ground = times(greens[(seed % 3) as usize], light);
        let lake = (last == 5 || last == 8).then_some([horizon + 0.015, horizon + 0.18]);
        let trees = (0..if last == 7 {
            9
        } else {
            random.within(3, 0.0, 5.0) as i64
        })
            .map(|it| {
                let is_near = last == 7 && it < 4;
                Tree {
                    x: random.within(30 + it, 0.0, 1.5),
                    foot: horizon
                        + random.within(50 + it, 0.01, 0.12)
                        + if is_near { 0.3 } else { 0.0 },
                    size: random.within(70 + it, 0.08, 0.2) + if is_near { 0.25 } else { 0.0 },
                    random: Random(seed * 101 + it as u64),
                    holes: if is_near { 0.43 } else { 0.33 },
                }
            });
        let trees = trees.collect();
        let n_buildings = if last == 3 {
            4
        } else {
            random.within(4, 0.0, 3.6) as i64
        };
        let buildings = (0..n_buildings).map(|it| {
            let left = random.within(90 + it, -0.05, 1.35);
            let wall = if last == 3 || it == 2 {
                times([0.62, 0.62, 0.60], random.within(130 + it, 0.75, 1.2))
            } else {
                let red = random.within(130 + it, 0.2, 0.5);
                [red, 0.6 * red, 0.4 * red]
            };
            Building {
                left,
                right: left + random.within(110 + it, 0.1, 0.3),
                top: horizon - random.within(150 + it, 0.08, 0.35),
                gable: random.within(170 + it, -0.08, 0.1).max(0.0),
                wall,
            }
        });
        Self {
            kind,
            horizon,
            zenith,
            low_sky,
            ridges,
            ground,
            lake,
            trees,
            buildings: buildings.collect(),
            has_branch: last == 9,
            random,
        }
    }

    fn at(&self, x: f64, y: f64) -> (Color, bool) {
        if self.has_branch && self.is_branch(x, y) {
            return (self.leaves(x, y, 0.5), false);
        }
        for tree in self.trees.iter().rev() {
            if let Some(shade) = tree.shade(x, y) {
                return (self.leaves(x, y, shade), false);
            }
        }
        for building in self.buildings.iter().rev() {
            if let Some(color) = building.color(x, y, self.horizon) {
                return (color, false);
            }
        }
        if y >= self.horizon {
            return (self.land(x, y), false);
        }
        for (index, (height, scale, near)) in self.ridges.iter().enumerate().rev() {
            let line = Random(self.random.0 + 31 * index as u64).fractal(scale * x, 0.5, 5);
            if y > self.horizon - height * (0.3 + 1.1 * line) {
                let rough = 0.75 + 0.5 * self.random.fractal(60.0 * x, 60.0 * y, 3);
                let haze = 0.65 * (1.0 - near);
                let color = times(mix(self.ground, [0.05, 0.07, 0.08], 0.4), rough);
                return (mix(color, self.sky(x, self.horizon), haze), false);
            }
        }
        (self.sky(x, y), true)
    }

    fn sky(&self, x: f64, y: f64) -> Color {
        let down = (y / self.horizon).clamp(0.0, 1.0);
        let clear = mix(self.zenith, self.low_sky, down.powf(1.5));
        let far = 1.0 / (1.15 - 0.8 * down);
        let clouds = Random(self.random.0 + 7).fractal(2.0 * x * far, 5.0 * y * far, 6);
        match self.kind {
            0 => clear,
            1 => mix(
                clear,
                times([0.85, 0.86, 0.88], 0.7 + 0.5 * clouds),
                smooth(0.48, 0.62, clouds),
            ),
            2 => times(clear, 0.85 + 0.3 * clouds),
            3 => times(clear, 0.5 + 1.1 * clouds),
            _ => mix(clear, [0.55, 0.38, 0.36], smooth(0.5, 0.75, clouds)),
        }
    }

    fn land(&self, x: f64, y: f64) -> Color {
        if let Some([top, bottom]) = self.lake
            && (top..bottom).contains(&y)
        {
            let ripple = 0.02 * (self.random.cells(20.0 * x, 300.0 * y) - 0.5);
            let mirrored = self.sky(x, (2.0 * top - y + ripple).max(0.0));
            return mix(times(mirrored, 0.85), [0.05, 0.07, 0.08], 0.1);
        }
        let near = 1.0 / (y - self.horizon + 0.03);
        let rough = self.random.fractal(4.0 * x * near, 30.0 * near, 4);
        let patches = self.random.fractal(5.0 * x, 8.0 * y, 3);
        times(self.ground, 0.3 + 0.9 * rough + 0.8 * patches)
    }

    fn leaves(&self, x: f64, y: f64, shade: f64) -> Color {
        let rough = self.random.fractal(90.0 * x, 90.0 * y, 2);
        times([0.05, 0.08, 0.025], (0.3 + 1.4 * rough) * (0.5 + shade))
    }

    /// Twigs and leaves from the upper left corner.
    fn is_branch(&self, x: f64, y: f64) -> bool {
        let reach = 1.0 - (x / 0.6).powi(2) - (y / 0.25).powi(2);
        reach > 0.0 && self.random.fractal(30.0 * x, 30.0 * y, 3) < 0.35 + 0.35 * reach
    }
}

impl Tree {
    /// How bright its leaves are at a place, where it has any there.
    fn shade(&self, x: f64, y: f64) -> Option<f64> {
        let (dx, up) = ((x - self.x) / self.size, (self.foot - y) / self.size);
        if dx.abs() < 0.05 && (0.0..0.8).contains(&up) {
            return Some(0.1);
        }
        let crown = dx.hypot((up - 1.0) / 1.1);
        let ragged = 0.55 + 0.35 * self.random.fractal(3.0 * dx, 3.0 * up, 4);
        let is_leaf = self.random.fractal(9.0 * dx, 9.0 * up, 3) > self.holes;
        (crown < ragged && is_leaf).then_some(0.5 + 0.5 * (up - 1.0) - 0.3 * dx)
    }
}

impl Building {
    fn color(&self, x: f64, y: f64, horizon: f64) -> Option<Color> {
        let middle = 0.5 * (self.left + self.right);
        let across = (x - middle).abs() / (self.right - middle);
        if across > 1.0 || y > horizon + 0.03 || y < self.top - self.gable * (1.0 - across) {
            return None;
        }
        if y < self.top {
            return Some([0.16, 0.07, 0.05]);
        }
        let cell = |value: f64, size: f64| (value / size).rem_euclid(1.0);
        let (u, v) = (cell(x - self.left, 0.045), cell(y - self.top, 0.06));
        let is_window = (0.3..0.7).contains(&u) && (0.3..0.75).contains(&v);
        let shade = if x < middle { 1.0 } else { 0.85 };
        Some(if is_window {
            [0.06, 0.07, 0.09]
        } else {
            times(self.wall, shade)
        })
    }
}
