//! How the curtain of a waterfall falls apart, into strands and these into clumps, without making or losing water.
//!
//! W' = W (1 + c (g - m)/(1 + |m|)),   c = C min(1, h/L),   m = mean of g over the width at a height
//! g = x/sqrt(1 + x²),   x = k (n(s/l, v t0/l) + n'(s/(4 l)))/sqrt(2),   t0 = t - sqrt(2 h/g)
//! L = 6 q^0.32 m,   v = sqrt(2 g L)
//! `W` water of a parcel, `h` its depth below the lip, `s` its place across, `t` time, `t0` when it left the lip, `C`
//! strength, `l` width of a strand, `n` and `n'` noise of unit variance (`turbulence.rs`); `L` the depth at which a
//! sheet of the flow `q` per width [m²/s] has broken up [Hor56]. As much water passes every height.
//!
//! The pattern falls with the water: what left the lip together stays together. Clumps are as tall as wide where
//! the sheet breaks up and sqrt(h/L) times as tall further down, because water that is ahead is faster. n' is the relief
//! of the lip, which stands still. Sharpness k is chosen. Noise on a lattice of cubes shows its axes where it is cut
//! along them; it is cut along the diagonal plane between them.
//! [Hor56] Horeni (1956), quoted by Castillo, Carrillo and Blazquez, J. Hydraulic Research 53, 101-118 (2015).

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec2;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::Turbulence;
use crate::drag::GRAVITY_M_S2;
use crate::error::require_finite;
use crate::error::require_in;
use crate::error::require_positive;
use crate::parcels::Parcel;
use crate::turbulence::Noise;
use crate::turbulence::squeezed;
use crate::waterfall_frame::Frame;

/// Depth at which a sheet of 1 m²/s has broken up (m), and how it grows with the flow.
const BREAK_UP_M: f64 = 6.0;
const BREAK_UP_POWER: f64 = 0.32;

/// Sharpness of strands, k.
const SHARPNESS: f64 = 4.0;

/// Strands between two crests of the lip.
const OF_RELIEF: f64 = 4.0;

/// Directions in the noise of what is across and of what left the lip earlier: both normal to (1, 1, 1).
const ACROSS: DVec3 = DVec3::new(FRAC_1_SQRT_2, -FRAC_1_SQRT_2, 0.0);
const EARLIER: DVec3 = DVec3::new(INV_SQRT_6, INV_SQRT_6, -2.0 * INV_SQRT_6);
const INV_SQRT_6: f64 = 0.408_248_290_463_863;

/// Strands and clumps in the curtain of a waterfall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Strands {
    /// Largest relative change of the water, 0..=1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub strength: f64,
    /// Width of the largest strands (m): a few voxels at least, or they are smoothed away.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub width_m: f64,
    /// Number that chooses the pattern.
    #[serde(default)]
    pub seed: u32,
    /// Time (s): clumps fall with the water.
    #[serde(default)]
    pub time_s: f64,
}

/// The strands of a curtain.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FallingStrands {
    strands: Strands,
    clumps: Noise,
    relief: Noise,
    break_up_m: f64,
}

impl Strands {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        let strength = "strands.strength";
        require_in(0.0..=1.0, strength, self.strength, "a number in 0..=1")?;
        require_positive("strands.width_m", self.width_m)?;
        require_finite("strands.time_s", self.time_s)
    }

    /// Largest factor by which a number density can rise.
    pub(crate) fn max_factor(&self) -> f64 {
        1.0 + self.strength
    }

    /// In a sheet of so much flow of volume per width (m²/s).
    pub(crate) fn falling(self, unit_discharge_m2_s: f64) -> FallingStrands {
        let noise = |eddy_m: f64, seed: u32| {
            let still = Turbulence {
                strength: self.strength,
                eddy_m,
                seed,
                time_s: 0.0,
                wind_m_s: [0.0; 3],
            };
            still.noise()
        };
        FallingStrands {
            strands: self,
            clumps: noise(self.width_m, self.seed),
            relief: noise(OF_RELIEF * self.width_m, !self.seed),
            break_up_m: BREAK_UP_M * unit_discharge_m2_s.powf(BREAK_UP_POWER),
        }
    }
}

impl FallingStrands {
    /// Moves the water of a row at a depth about, whose middle is `foot_xz` but for its way from the rock.
    pub(crate) fn gather(&self, row: &mut [Parcel], frame: &Frame, depth_m: f64) {
        let across = frame.forward.perp();
        let left_s = self.strands.time_s - Frame::fall_s(depth_m);
        let noise = |middle: DVec2| self.noise((middle - frame.foot_xz()).dot(across), left_s);
        let noises: Vec<f64> = row.iter().map(|parcel| noise(parcel.middle)).collect();
        let mean = noises.iter().sum::<f64>() / noises.len() as f64;
        let contrast = self.strands.strength * (depth_m / self.break_up_m).min(1.0);
        for (parcel, noise) in row.iter_mut().zip(&noises) {
            parcel.share *= 1.0 + contrast * (noise - mean) / (1.0 + mean.abs());
        }
    }

    /// g of water that left the lip at a time, within -1..1.
    fn noise(&self, across_m: f64, left_s: f64) -> f64 {
        let break_up_m_s = (2.0 * GRAVITY_M_S2 * self.break_up_m).sqrt();
        let across = across_m * ACROSS;
        let clumps = across + break_up_m_s * left_s * EARLIER;
        let both = self.clumps.sum(clumps) + self.relief.sum(across);
        squeezed(SHARPNESS * FRAC_1_SQRT_2 * both)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRANDS: Strands = Strands {
        strength: 0.8,
        width_m: 2.0,
        seed: 3,
        time_s: 5.0,
    };

    fn frame() -> Frame {
        Frame {
            foot: DVec3::new(3.0, 1.0, -40.0),
            forward: DVec2::new(0.6, 0.8),
            height_m: 30.0,
            width_m: 50.0,
            voxel_m: 1.0,
        }
    }

    fn shares(strands: Strands, depth_m: f64) -> Vec<f64> {
        let (frame, n) = (frame(), 400);
        let parcel = |index: u32| Parcel {
            middle: frame.foot_xz()
                + frame.forward.perp() * (frame.width_m * (f64::from(index) / 400.0 - 0.5)),
            share: 1.0 / f64::from(n),
        };
        let mut row: Vec<Parcel> = (0..n).map(parcel).collect();
        strands.falling(1.0).gather(&mut row, &frame, depth_m);
        row.iter().map(|parcel| parcel.share).collect()
    }

    #[test]
    fn as_much_water_passes_every_height_and_no_part_of_it_is_below_0_or_above_the_bound() {
        for depth_m in [0.0, 0.5, 6.0, 30.0] {
            let shares = shares(STRANDS, depth_m);
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let most = STRANDS.max_factor() / shares.len() as f64;
            assert!(shares.iter().all(|share| (0.0..=most).contains(share)));
        }
    }

    #[test]
    fn a_sheet_is_whole_at_the_lip_and_falls_apart_where_it_has_been_seen_to() {
        let spread = |depth_m: f64| {
            let shares = shares(STRANDS, depth_m);
            let mean = 1.0 / shares.len() as f64;
            let squares = shares.iter().map(|it| (it / mean - 1.0).powi(2));
            (squares.sum::<f64>() * mean).sqrt()
        };
        assert_eq!(spread(0.0), 0.0);
        // 6 m at 1 m²/s.
        assert!(spread(3.0) > 0.1 && spread(6.0) > 1.3 * spread(3.0));
        assert!(spread(12.0) > 0.3);
    }

    #[test]
    fn what_left_the_lip_together_stays_together() {
        let (upper_m, lower_m) = (8.0, 25.0);
        let later_s = Frame::fall_s(lower_m) - Frame::fall_s(upper_m);
        let later = Strands {
            time_s: STRANDS.time_s + later_s,
            ..STRANDS
        };
        let (above, below) = (shares(STRANDS, upper_m), shares(later, lower_m));
        let off = above.iter().zip(&below).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12);
        assert_ne!(shares(STRANDS, lower_m), below);
    }

    #[test]
    fn another_seed_is_another_pattern_and_strength_0_is_none() {
        let other = Strands { seed: 4, ..STRANDS };
        assert_ne!(shares(other, 10.0), shares(STRANDS, 10.0));
        let none = Strands {
            strength: 0.0,
            ..STRANDS
        };
        assert!(shares(none, 10.0).iter().all(|share| *share == 1.0 / 400.0));
    }

    #[test]
    fn strands_far_from_ordinary_keep_their_water_too() {
        for (width_m, time_s) in [(1e-6, 0.0), (1e9, -5.0), (2.0, 1e12), (1e-300, 1e300)] {
            let strands = Strands {
                strength: 1.0,
                width_m,
                time_s,
                ..STRANDS
            };
            let shares = shares(strands, 20.0);
            let sum: f64 = shares.iter().sum();
            assert!((sum - 1.0).abs() < 1e-12, "{width_m} m, {time_s} s: {sum}");
            assert!(shares.iter().all(|share| *share >= 0.0));
        }
    }

    #[test]
    fn impossible_strands_are_refused() {
        let refused = |strands: Strands| strands.validate().unwrap_err().to_string();
        let strong = Strands {
            strength: 1.5,
            ..STRANDS
        };
        assert!(refused(strong).contains("strands.strength"));
        let narrow = Strands {
            width_m: 0.0,
            ..STRANDS
        };
        assert!(refused(narrow).contains("strands.width_m"));
        let never = Strands {
            time_s: f64::NAN,
            ..STRANDS
        };
        assert!(refused(never).contains("strands.time_s"));
    }
}
