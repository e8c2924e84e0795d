//! Numbers and noise by seed, and the colors of plates.

pub type Color = [f64; 3];

pub fn mix(a: Color, b: Color, part: f64) -> Color {
    std::array::from_fn(|index| a[index] + part * (b[index] - a[index]))
}

pub fn times(color: Color, factor: f64) -> Color {
    color.map(|channel| channel * factor)
}

pub fn smooth(from: f64, to: f64, value: f64) -> f64 {
    let part = ((value - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

/// Numbers from 0 to 1 by two indices.
#[derive(Clone, Copy)]
pub struct Random(pub u64);

impl Random {
    pub fn at(self, a: i64, b: i64) -> f64 {
        // SplitMix64 of seed and indices.
        let mut z = (self.0.wrapping_mul(0x9e37_79b9_7f4a_7c15))
            .wrapping_add((a as u64).wrapping_mul(0xd1b5_4a32_d192_ed03))
            .wrapping_add((b as u64).wrapping_mul(0x8cb9_2ba7_2f3d_8dd7));
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn within(self, name: i64, low: f64, high: f64) -> f64 {
        low + (high - low) * self.at(name, 1 << 40)
    }

    /// Noise of cells of size 1.
    pub fn cells(self, x: f64, y: f64) -> f64 {
        let (left, top) = (x.floor(), y.floor());
        let [s, t] = [x - left, y - top].map(|it| it * it * (3.0 - 2.0 * it));
        let corner = |dx: i64, dy: i64| self.at(left as i64 + dx, top as i64 + dy);
        let across = |dy: i64| corner(0, dy) + s * (corner(1, dy) - corner(0, dy));
        across(0) + t * (across(1) - across(0))
    }

    /// Fractal noise about 0.5.
    pub fn fractal(self, x: f64, y: f64, n_octaves: u32) -> f64 {
        let (mut sum, mut total) = (0.0, 0.0);
        for octave in 0..n_octaves {
            let scale = f64::from(1 << octave);
            sum += self.cells(scale * x + 17.3 * scale, scale * y) / scale;
            total += 1.0 / scale;
        }
        sum / total
    }
}
