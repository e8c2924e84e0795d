//! How much light a surface gives back, by wavelength: as much of all, a smooth spectrum of a color, or as measured.
//!
//! R(lambda) = 1/2 + x/(2 sqrt(1 + x^2)),   x = c0 + c1 t + c2 t^2,   t = (lambda - 595 nm)/235 nm
//! is between 0 and 1 for any c. The three follow from a linear Rec.709 color, by Gauss-Newton with damping, so that
//! rgb_k = int R E rbar_k dlambda / int E rbar_k dlambda
//! `E` sunlight above the air, `rbar_k` observer of a primary: the color that the surface has beside a white one,
//! both in the sun. Where no such spectrum has the color the nearest is taken, which errs by 0.003 at most.
//! [JH19] W. Jakob and J. Hanika, Computer Graphics Forum 38, 147-155 (2019).

use std::sync::LazyLock;

use crate::color_space::xyz_to_linear_rec709;
use crate::colorimetry::Colorimetry;
use crate::ground_reflectance::GroundCover;
use crate::solar_irradiance::solar_irradiance;
use crate::units::Nanometers;
use crate::wavelength_grid::WavelengthGrid;

/// Where t is 0, and where it is 1.
const MIDDLE_NM: f64 = 595.0;
const HALF_WIDTH_NM: f64 = 235.0;

/// Steps at most, and a squared error that needs no more.
const MOST_STEPS: usize = 300;
const ENOUGH: f64 = 1e-18;

/// A spectrum of reflectance, 0..1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reflectance {
    /// As much of every wavelength.
    Even(f64),
    /// c0, c1, c2.
    Smooth([f64; 3]),
    /// That of a ground, as measured.
    Measured(GroundCover),
}

impl Reflectance {
    /// A smooth spectrum with a color of linear Rec.709, whose channels count as 0..1.
    ///
    /// ```
    /// use niji_radiometry::{Nanometers, Reflectance};
    ///
    /// let grass = Reflectance::of_rgb([0.05, 0.12, 0.03]);
    /// assert!(grass.at(Nanometers(550.0)) > 1.5 * grass.at(Nanometers(450.0)));
    /// assert_eq!(Reflectance::of_rgb([0.3; 3]), Reflectance::Even(0.3));
    /// ```
    pub fn of_rgb(rgb: [f64; 3]) -> Self {
        let rgb = rgb.map(|channel| channel.clamp(0.0, 1.0));
        let [red, green, blue] = rgb;
        // Stored values: a gray is as even as it was written.
        if red == green && green == blue {
            return Self::Even(red);
        }
        let mean = (rgb.iter().sum::<f64>() / 3.0).clamp(0.01, 0.99);
        let x = (mean - 0.5) / (mean - mean * mean).sqrt();
        let mut found = Fit::new([x, 0.0, 0.0], rgb);
        let mut damping = 1e-3;
        for _ in 0..MOST_STEPS {
            if found.square < ENOUGH {
                break;
            }
            let tried = found.step(damping).map(|c| Fit::new(c, rgb));
            match tried.filter(|it| it.square < found.square) {
                Some(better) => {
                    found = better;
                    damping = (0.3 * damping).max(1e-12);
                }
                None => damping *= 4.0,
            }
        }
        Self::Smooth(found.c)
    }

    /// Its value at a wavelength.
    pub fn at(self, wavelength: Nanometers) -> f64 {
        match self {
            Self::Even(value) => value,
            Self::Smooth(c) => sigmoid(polynomial(c, wavelength)).0,
            Self::Measured(cover) => cover.spectrum().at(wavelength),
        }
    }

    /// Its value in the middle of every bin, or the mean over it of what was measured.
    pub fn on(self, grid: &WavelengthGrid) -> Vec<f64> {
        match self {
            Self::Measured(cover) => cover.spectrum().on(grid),
            Self::Even(_) | Self::Smooth(_) => {
                grid.centers().map(|center| self.at(center)).collect()
            }
        }
    }

    /// Its color in the sun beside a white surface, red, green and blue of linear Rec.709.
    pub fn rgb(self) -> [f64; 3] {
        let lit = |k: usize| {
            let weights = WEIGHTS.iter();
            weights.map(|(nm, weight)| weight[k] * self.at(*nm)).sum()
        };
        [0, 1, 2].map(lit)
    }
}

/// Sunlight times the observer of each primary, 1 for a white surface, by wavelength.
static WEIGHTS: LazyLock<Vec<(Nanometers, [f64; 3])>> = LazyLock::new(|| {
    let grid = WavelengthGrid::visible();
    let sun = solar_irradiance(&grid);
    let observer = Colorimetry::new(&grid);
    let weights = observer.weights().iter().zip(&sun);
    let weights: Vec<[f64; 3]> = weights
        .map(|(xyz, sun)| xyz_to_linear_rec709(xyz.map(|value| value * sun)))
        .collect();
    let white = [0, 1, 2].map(|k| weights.iter().map(|weight| weight[k]).sum::<f64>());
    let over_white = weights
        .iter()
        .map(|weight| [0, 1, 2].map(|k| weight[k] / white[k]));
    grid.centers().zip(over_white).collect()
});

/// t of a wavelength.
fn place(wavelength: Nanometers) -> f64 {
    (wavelength.0 - MIDDLE_NM) / HALF_WIDTH_NM
}

fn polynomial([c0, c1, c2]: [f64; 3], wavelength: Nanometers) -> f64 {
    let t = place(wavelength);
    c0 + t * (c1 + t * c2)
}

/// R and dR/dx.
fn sigmoid(x: f64) -> (f64, f64) {
    let root = (1.0 + x * x).sqrt();
    (0.5 + 0.5 * x / root, 0.5 / (root * root * root))
}

/// A spectrum beside the color that it should have.
struct Fit {
    c: [f64; 3],
    /// Found less wanted, by channel, and their derivatives by c.
    off: [f64; 3],
    slopes: [[f64; 3]; 3],
    square: f64,
}

impl Fit {
    fn new(c: [f64; 3], rgb: [f64; 3]) -> Self {
        let mut off = rgb.map(|channel| -channel);
        let mut slopes = [[0.0; 3]; 3];
        for (wavelength, weights) in WEIGHTS.iter() {
            let (value, slope) = sigmoid(polynomial(c, *wavelength));
            let t = place(*wavelength);
            for (k, weight) in weights.iter().enumerate() {
                off[k] += weight * value;
                for (by, power) in slopes[k].iter_mut().zip([1.0, t, t * t]) {
                    *by += weight * slope * power;
                }
            }
        }
        let square = off.iter().map(|off| off * off).sum();
        Self {
            c,
            off,
            slopes,
            square,
        }
    }

    /// c after a step of (J^T J + d diag(J^T J)) s = -J^T r; `None` where that has no answer.
    fn step(&self, damping: f64) -> Option<[f64; 3]> {
        let product = |i: usize, j: usize| {
            (0..3)
                .map(|k| self.slopes[k][i] * self.slopes[k][j])
                .sum::<f64>()
        };
        let matrix = [0, 1, 2]
            .map(|i| [0, 1, 2].map(|j| product(i, j) * if i == j { 1.0 + damping } else { 1.0 }));
        let down = [0, 1, 2].map(|i| -(0..3).map(|k| self.slopes[k][i] * self.off[k]).sum::<f64>());
        let all = determinant(matrix);
        let step = [0, 1, 2].map(|column| {
            let mut replaced = matrix;
            for (row, value) in replaced.iter_mut().zip(down) {
                row[column] = value;
            }
            determinant(replaced) / all
        });
        let to = [0, 1, 2].map(|i| self.c[i] + step[i]);
        to.iter().all(|value| value.is_finite()).then_some(to)
    }
}

fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The color of a spectrum beside white in the sun, on a grid of its own.
    fn color(reflectance: Reflectance) -> [f64; 3] {
        let grid = WavelengthGrid::new(360.0, 2.0, 236).unwrap();
        let observer = Colorimetry::new(&grid);
        let sun = solar_irradiance(&grid);
        let lit = reflectance.on(&grid);
        let lit: Vec<f64> = lit.iter().zip(&sun).map(|(r, e)| r * e).collect();
        let [rgb, white] = [&lit, &sun].map(|light| xyz_to_linear_rec709(observer.xyz(light)));
        [0, 1, 2].map(|k| rgb[k] / white[k])
    }

    fn error(rgb: [f64; 3]) -> f64 {
        let found = color(Reflectance::of_rgb(rgb));
        (0..3)
            .map(|k| (found[k] - rgb[k]).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_color_comes_back_from_its_spectrum() {
        let steps = [0.0, 0.02, 0.06, 0.2, 0.5, 0.8, 0.95, 1.0];
        let mut worst = (0.0, [0.0; 3]);
        for red in steps {
            for green in steps {
                for blue in steps {
                    let rgb = [red, green, blue];
                    let error = error(rgb);
                    if error > worst.0 {
                        worst = (error, rgb);
                    }
                }
            }
        }
        // Worst found 0.0022, of channels of 0 and 1.
        assert!(worst.0 < 3e-3, "{worst:?}");
        for rgb in [[0.05, 0.12, 0.03], [0.45, 0.3, 0.2], [0.1, 0.3, 0.7]] {
            assert!(error(rgb) < 3e-4, "{rgb:?}: {}", error(rgb));
        }
    }

    #[test]
    fn the_color_of_what_was_measured_is_that_of_its_spectrum_in_the_sun() {
        for cover in GroundCover::ALL {
            let measured = Reflectance::Measured(cover);
            let (told, found) = (measured.rgb(), color(measured));
            for k in 0..3 {
                assert!(
                    (told[k] - found[k]).abs() < 1e-3,
                    "{cover:?}: {told:?} {found:?}"
                );
            }
        }
        // A bin has the mean over it, which at the edge of red leaves is not the value in its middle.
        let grass = Reflectance::Measured(GroundCover::Grass);
        let wide = grass.on(&WavelengthGrid::new(700.0, 40.0, 1).unwrap())[0];
        let fine = grass.on(&WavelengthGrid::new(680.5, 1.0, 40).unwrap());
        assert!((wide - fine.iter().sum::<f64>() / 40.0).abs() < 1e-12);
        assert!(wide > 1.1 * grass.at(Nanometers(700.0)));
    }

    #[test]
    fn spectra_stay_between_0_and_1_and_gray_is_even() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.9, 0.9, 0.1], [0.3; 3]] {
            let reflectance = Reflectance::of_rgb(rgb);
            let values = reflectance.on(&WavelengthGrid::new(305.0, 10.0, 50).unwrap());
            assert!(
                values.iter().all(|value| (0.0..=1.0).contains(value)),
                "{rgb:?}"
            );
        }
        assert_eq!(Reflectance::of_rgb([0.3; 3]), Reflectance::Even(0.3));
    }
}
