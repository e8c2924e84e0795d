//! A piece of a view ray inside one cell of each mode, and its optical depth.
//!
//! tau(x) = sum over modes of l int_0^x pi M2 dx'   at Q = 1
//! `l` length of the piece [m], `M2` second moment [m²/m³], a cubic of x = 0..1: tau is its exact
//! integral.

use std::f64::consts::PI;

use glam::DVec4;

use crate::lane_cubic::LaneCubic;

/// pi um²/m³ in 1/m: area moments to extinction at Q = 1.
pub(crate) const EXTINCTION_PER_M2: f64 = 1e-12 * PI;

/// A piece of a ray in one cell of each mode.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece<'a> {
    /// Distance of its start from the eye (m).
    pub(crate) start_m: f64,
    /// Its length (m).
    pub(crate) length_m: f64,
    /// The moments of each mode that has drops here.
    pub(crate) modes: &'a [LaneCubic],
    /// Optical depth at Q = 1 up to x: x (d0 + x d1 + x² (d2 + x d3)).
    depth: DVec4,
}

impl<'a> Piece<'a> {
    /// A piece of `length_m` that starts at a distance.
    #[inline]
    pub(crate) fn new(start_m: f64, length_m: f64, modes: &'a [LaneCubic]) -> Self {
        let m2 = match modes {
            [mode] => mode.m2_integral(),
            modes => modes.iter().map(LaneCubic::m2_integral).sum(),
        };
        Self {
            start_m,
            length_m,
            modes,
            depth: EXTINCTION_PER_M2 * length_m * m2,
        }
    }

    /// Optical depth at Q = 1 from the start to the fraction `x`.
    #[inline]
    pub(crate) fn depth_up_to(&self, x: f64) -> f64 {
        let d = self.depth;
        x * ((d.x + x * d.y) + (x * x) * (d.z + x * d.w))
    }

    /// Optical depth at Q = 1.
    #[inline]
    pub(crate) fn depth(&self) -> f64 {
        // Rounding may put next to nothing below nothing.
        self.depth.element_sum().max(0.0)
    }
}
