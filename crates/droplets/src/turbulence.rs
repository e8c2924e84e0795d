//! Gusts: a seeded noise field that moves drops about without making or losing any.
//!
//! N'(x) = N(x) (1 + s (g(x, t) - m)/(1 + |m|)),   m = sum W g / sum W
//! `s` strength 0..=1; `g` noise within -1..=1; `W` water of a node. Sizes stay, so that a node's
//! water follows its number, and sum W (g - m) = 0 keeps the water; since |g - m| <= 1 + |m|, no node
//! falls below 0 or rises above 1 + s times what it was. Weighting with the number instead would
//! lose water wherever large and small drops lie apart.
//!
//! g is gradient noise of four dimensions in octaves k = 0..3, squeezed to -1..1:
//! x = sum a_k n(q_k) / (S sqrt(sum a_k²)),   g = x/sqrt(1 + x²),   a_k = 2^(-k/3)
//! q_k = ((p - w t) 2^k/l, (t/T) 2^(2k/3)),   T = l/u
//! `n` noise of one octave, `S` its root mean square, `p` position, `w` wind, `l` largest eddy,
//! `t` time, `T` turnover time and `u` speed of the largest eddies. Amplitudes follow the 2/3 law of
//! a passive scalar, turnover times the same similarity [Kol41, Obu49]; eddies ride on the wind
//! [Tay38]. Squeezing lets the noise, whose extremes are rare, use its range.
//!
//! n(q) = sum over the 16 corners c of fade(q - c) G_c . (q - c),   fade(d) = 1 - 10 d³ + 15 d⁴ - 6 d⁵
//! per axis, d = |q - c| [Per02]. With unit gradients G, |n| <= 1: by Jensen |n|² is at most the sum
//! over the axes of f (1-d)² + (1-f) d² <= 1/4. n has two continuous derivatives, |grad n| <= 8.5.
//!
//! [Kol41] Kolmogorov, Dokl. Akad. Nauk SSSR 30, 301-305 (1941);
//! [Obu49] Obukhov, Izv. Akad. Nauk SSSR, Ser. Geogr. Geofiz. 13, 58-69 (1949);
//! [Tay38] Taylor, Proc. R. Soc. A 164, 476-490 (1938);
//! [Per02] Perlin, ACM Trans. Graphics 21, 681-682 (2002).

use glam::DVec3;
use glam::DVec4;
use niji_dropfield::AreaMoments;
use niji_dropfield::DropLeaf;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::LEAF_DIM;
use niji_dropfield::LEAF_NODES;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::error::require_finite;
use crate::error::require_in;
use crate::error::require_positive;

/// Octaves of noise: eddies down to an eighth of the largest.
const N_OCTAVES: u32 = 4;

/// Root mean square of one octave of noise. With f the fade and unit gradients of which every
/// component has a mean square of 1/4: S² = (2 ∫ f² t² dt) (2 ∫ f² dt)³.
const NOISE_RMS: f64 = 0.169_020_04;

/// Speed of the largest eddies as a part of the wind: the usual intensity of turbulence near the
/// ground in neutral air (Stull, Boundary Layer Meteorology, Kluwer (1988), section 9.4).
const TURBULENCE_INTENSITY: f64 = 0.2;

/// Speed of the largest eddies without wind (m/s); chosen, so that calm air too stirs.
const CALM_EDDY_M_S: f64 = 0.5;

/// Lattice cells between octaves' origins, so that no two of them have a corner in common.
const OCTAVE_SHIFT: f64 = 57.3;

/// Keeps the seed 0 from hashing to 0: the golden ratio in 32 bits.
const SEED_SALT: u32 = 0x9e37_79b9;

/// A seeded noise field, animated by its time.
///
/// ```
/// use niji_droplets::Turbulence;
///
/// let gusts =
///     Turbulence { strength: 0.5, eddy_m: 20.0, seed: 1, time_s: 0.0, wind_m_s: [5.0, 0.0, 0.0] };
/// gusts.validate()?;
/// assert_eq!(gusts.max_factor(), 1.5);
/// # Ok::<(), niji_droplets::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Turbulence {
    /// Largest relative change of the number density, 0..=1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub strength: f64,
    /// Size of the largest eddies (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub eddy_m: f64,
    /// Number that chooses the pattern.
    #[serde(default)]
    pub seed: u32,
    /// Time (s): eddies drift with the wind and change within a few turnovers.
    #[serde(default)]
    pub time_s: f64,
    /// Wind that carries the eddies, x, y, z (m/s).
    #[serde(default)]
    pub wind_m_s: [f64; 3],
}

impl Turbulence {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        let strength = "turbulence.strength";
        require_in(0.0..=1.0, strength, self.strength, "a number in 0..=1")?;
        require_positive("turbulence.eddy_m", self.eddy_m)?;
        require_finite("turbulence.time_s", self.time_s)?;
        let mut components = self.wind_m_s.into_iter();
        components.try_for_each(|wind| require_finite("turbulence.wind_m_s", wind))
    }

    /// Largest factor by which a number density can rise.
    pub fn max_factor(&self) -> f64 {
        1.0 + self.strength
    }

    /// Time in which the largest eddies change, T (s).
    pub fn turnover_s(&self) -> f64 {
        let wind_m_s = DVec3::from(self.wind_m_s).length();
        self.eddy_m / CALM_EDDY_M_S.hypot(TURBULENCE_INTENSITY * wind_m_s)
    }

    /// The noise with all that does not depend on the place worked out.
    pub(crate) fn noise(&self) -> Noise {
        let finer = |octave: u32| f64::from(1_u32 << octave);
        let amplitude = |octave| finer(octave).cbrt().recip();
        let variance: f64 = (0..N_OCTAVES).map(|octave| amplitude(octave).powi(2)).sum();
        let turnovers = self.time_s / self.turnover_s();
        let drift_m = DVec3::from(self.wind_m_s) * self.time_s;
        let octaves = std::array::from_fn(|index| {
            let octave = index as u32;
            let cells_m1 = finer(octave) / self.eddy_m;
            let shift = OCTAVE_SHIFT * (f64::from(octave) + 1.0);
            Octave {
                amplitude: amplitude(octave) / (NOISE_RMS * variance.sqrt()),
                cells_m1,
                origin: (-drift_m * cells_m1).extend(turnovers * finer(octave).powf(2.0 / 3.0))
                    + shift,
                seed: mix(self.seed ^ SEED_SALT) ^ octave,
            }
        });
        Noise { octaves }
    }

    /// The same drops and the same water, moved about. The result does not depend on the number of
    /// threads.
    ///
    /// # Errors
    /// As [`Turbulence::validate`].
    pub(crate) fn stir(&self, mode: DropMode) -> Result<DropMode, Error> {
        self.validate()?;
        let noise = self.noise();
        let leaves = mode.leaves().par_iter();
        let noises: Vec<LeafNoise> = leaves.map(|leaf| noise.of_leaf(&mode, leaf)).collect();
        let Some(mean) = water_weighted_mean(&mode, &noises) else {
            return Ok(mode);
        };
        let scale = self.strength / (1.0 + mean.abs());
        let factor = |leaf: usize, place: usize| 1.0 + scale * (noises[leaf][place] - mean);
        Ok(mode.with_numbers_scaled(factor)?)
    }
}

/// Nodes of a leaf along z, which are next to each other in it.
const ROW: usize = LEAF_DIM as usize;

/// The noise at the nodes of a leaf, by their places; any where there are no drops.
type LeafNoise = [f64; LEAF_NODES];

/// The mean of the noise over the water, m; `None` without drops. Leaves are added up in their order.
fn water_weighted_mean(mode: &DropMode, noises: &[LeafNoise]) -> Option<f64> {
    let of_leaf = |(leaf, noises): (&DropLeaf, &LeafNoise)| {
        let (mut water, mut noise) = (0.0, 0.0);
        for (drops, here) in leaf.drops.iter().zip(noises) {
            if drops.exist() {
                let of_node = f64::from(AreaMoments::from_drops(drops).m3);
                water += of_node;
                noise += of_node * here;
            }
        }
        (water, noise)
    };
    let leaves = mode.leaves().par_iter().zip(noises);
    let sums: Vec<(f64, f64)> = leaves.map(of_leaf).collect();
    let (water, noise) = sums
        .into_iter()
        .fold((0.0, 0.0), |sum, leaf| (sum.0 + leaf.0, sum.1 + leaf.1));
    (water > 0.0).then(|| noise / water)
}

/// One octave of a noise at one time.
#[derive(Debug, Clone, Copy)]
struct Octave {
    /// a_k/(S sqrt(sum a²)).
    amplitude: f64,
    /// Cells of the lattice per metre.
    cells_m1: f64,
    /// Place and time of the world's origin in cells.
    origin: DVec4,
    seed: u32,
}

/// A noise at one time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Noise {
    octaves: [Octave; N_OCTAVES as usize],
}

impl Noise {
    /// The noise g at the nodes of a leaf, within -1..1: row by row along z, whose nodes share corners of cells.
    fn of_leaf(&self, mode: &DropMode, leaf: &DropLeaf) -> LeafNoise {
        let mut noises = [0.0; LEAF_NODES];
        let rows = noises
            .chunks_exact_mut(ROW)
            .zip(leaf.drops.chunks_exact(ROW));
        for (row, (noises, drops)) in rows.enumerate() {
            if !drops.iter().any(Drops::exist) {
                continue;
            }
            let position = |index| mode.node_position(leaf.node(ROW * row + index));
            for octave in &self.octaves {
                let mut along_z = AlongZ::new(octave.place(position(0)), octave.seed);
                for (index, sum) in noises.iter_mut().enumerate() {
                    *sum += octave.amplitude * along_z.at(octave.place(position(index)).z);
                }
            }
            for sum in noises {
                *sum = squeezed(*sum);
            }
        }
        noises
    }

    /// The sum of its octaves at a point (m), x, of unit root mean square.
    pub(crate) fn sum(&self, position: DVec3) -> f64 {
        let octaves = self.octaves.iter();
        octaves
            .map(|octave| octave.amplitude * gradient_noise(octave.place(position), octave.seed))
            .sum()
    }
}

impl Octave {
    /// q of a point (m).
    fn place(&self, position: DVec3) -> DVec4 {
        (position * self.cells_m1).extend(0.0) + self.origin
    }
}

/// x/sqrt(1 + x²).
pub(crate) fn squeezed(x: f64) -> f64 {
    x / (1.0 + x * x).sqrt()
}

/// Noise of one octave, n(q), within -1..=1.
fn gradient_noise(q: DVec4, seed: u32) -> f64 {
    AlongZ::new(q, seed).at(q.z)
}

/// A corner of a cell along an axis: index, offset from it and weight.
type Side = (u32, f64, f64);

/// The corners of the cell of a place along an axis, the lower one first.
fn sides(place: f64) -> [Side; 2] {
    let floor = place.floor();
    let low = place - floor;
    // Wrapping casts: the pattern repeats after 2^32 cells.
    let index = floor as i64 as u32;
    let near = fade(low);
    [
        (index, low, near),
        (index.wrapping_add(1), low - 1.0, 1.0 - near),
    ]
}

/// Noise of one octave along z. A corner there has, of the eight that share its z, the share  a dz + b.
struct AlongZ {
    /// Along x, y and t; `None` farther away, in cells, than numbers reach.
    sides: Option<[[Side; 2]; 3]>,
    seed: u32,
    /// Index of the cell that was looked at last, and `[a, b]` of its corners.
    known: Option<(u32, [[f64; 2]; 2])>,
}

impl AlongZ {
    /// At the x, y and t of a place.
    fn new(q: DVec4, seed: u32) -> Self {
        Self {
            sides: q.is_finite().then(|| [q.x, q.y, q.w].map(sides)),
            seed,
            known: None,
        }
    }

    /// n at a z.
    fn at(&mut self, z: f64) -> f64 {
        let (Some(across), true) = (self.sides, z.is_finite()) else {
            return 0.0;
        };
        let [low, high] = sides(z);
        let corner = |index| corner_along_z(across, index, self.seed);
        let corners = match self.known {
            Some((cell, corners)) if cell == low.0 => corners,
            Some((cell, [_, next])) if cell.wrapping_add(1) == low.0 => [next, corner(high.0)],
            _ => [corner(low.0), corner(high.0)],
        };
        self.known = Some((low.0, corners));
        let share = |(_, dz, weight): Side, [a, b]: [f64; 2]| weight * (a * dz + b);
        share(low, corners[0]) + share(high, corners[1])
    }
}

/// `[a, b]` of a corner along z.
fn corner_along_z([along_x, along_y, along_t]: [[Side; 2]; 3], z: u32, seed: u32) -> [f64; 2] {
    let [mut a, mut b] = [0.0; 2];
    for (t, dt, weight_t) in along_t {
        let hash_z = mix(mix(seed ^ t) ^ z);
        for (y, dy, weight_y) in along_y {
            let hash_y = mix(hash_z ^ y);
            for (x, dx, weight_x) in along_x {
                let weight = weight_t * weight_y * weight_x;
                let [of_z, of_others] = along_gradient(mix(hash_y ^ x), [dx, dy, dt]);
                a += weight * of_z;
                b += weight * of_others;
            }
        }
    }
    [a, b]
}

/// Weight of a corner at a distance 0..1 along an axis.
fn fade(d: f64) -> f64 {
    1.0 - d * d * d * (10.0 - d * (15.0 - 6.0 * d))
}

/// 1/sqrt(3).
const INV_SQRT_3: f64 = 0.577_350_269_189_625_8;

/// Product of an offset along x, y and t, and 1 along z, with one of the 32 unit vectors (0, ±1, ±1, ±1)/sqrt(3) and their
/// permutations, the part of z first: the component without a part is the one that bits 4 and 5 name.
fn along_gradient(hash: u32, [dx, dy, dt]: [f64; 3]) -> [f64; 2] {
    // The sign bit is flipped, since a branch on a random bit is taken wrongly half of the time.
    let offset = [dx, dy, 1.0, dt];
    let mut signed: [f64; 4] = std::array::from_fn(|axis| {
        let sign = u64::from(hash >> axis & 1) << 63;
        f64::from_bits(offset[axis].to_bits() ^ sign)
    });
    signed[(hash >> 4 & 3) as usize] = 0.0;
    let [x, y, z, t] = signed;
    [z * INV_SQRT_3, (x + y + t) * INV_SQRT_3]
}

/// Scatter the bits of a number: the finalizer of MurmurHash3 (Appleby, public domain). Nested over
/// the axes it has no visible pattern (Jarzynski and Olano, J. Computer Graphics Techniques 9(3),
/// 20-38, 2020).
fn mix(value: u32) -> u32 {
    let value = (value ^ value >> 16).wrapping_mul(0x85eb_ca6b);
    let value = (value ^ value >> 13).wrapping_mul(0xc2b2_ae35);
    value ^ value >> 16
}

#[cfg(test)]
#[path = "turbulence_tests.rs"]
mod tests;
