//! Pictures without a sky.

use super::noise::Color;
use super::noise::Random;
use super::noise::times;

/// A corner of two walls under a white ceiling, with a lamp, a picture and a floor.
pub fn room(random: Random, x: f64, y: f64) -> Color {
    let corner = random.within(1, 0.4, 1.1);
    let ceiling = 0.22 - 0.25 * (x - corner).abs();
    let floor = 0.72 + 0.2 * (x - corner).abs();
    let light = 0.5 + 0.6 * (-2.0 * (x - 0.9).hypot(y - 0.3)).exp();
    let color = if y < ceiling {
        [0.50, 0.46, 0.40]
    } else if y > floor {
        times(
            [0.22, 0.13, 0.07],
            0.6 + 0.8 * random.fractal(4.0 * x, 40.0 * y, 3),
        )
    } else if x < corner {
        [0.48, 0.44, 0.36]
    } else {
        [0.42, 0.38, 0.31]
    };
    let is_picture = (0.15..0.35).contains(&x) && (0.3..0.5).contains(&y);
    let is_lamp = (x - 0.9).hypot(y - 0.3) < 0.04;
    if is_lamp {
        [1.0, 0.95, 0.8]
    } else if is_picture {
        times([0.5, 0.2, 0.3], random.fractal(20.0 * x, 20.0 * y, 3))
    } else {
        times(color, light)
    }
}

/// Leaves before leaves.
pub fn thicket(random: Random, x: f64, y: f64) -> Color {
    let rough = random.fractal(12.0 * x, 12.0 * y, 6);
    let deep = random.fractal(3.0 * x, 3.0 * y, 3);
    times(
        [0.12, 0.2, 0.05],
        (2.5 * rough - 0.6).max(0.05) * (0.4 + deep),
    )
}
