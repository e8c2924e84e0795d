//! The drops of one cubic metre, for people and files.
//!
//! Sizes follow a gamma law of which only the effective radius and the effective variance are kept
//! (`niji_sizes::GammaSizes`); for Marshall-Palmer rain (v_e = 1/3) and for a single size (v_e = 0)
//! that is exact. Any other law is replaced by the gamma law with the same second, third and fourth
//! moment, so that extinction, water, r_e and v_e are kept, and the number of drops is that of the
//! gamma law. Moments for interpolation: [`crate::AreaMoments`].

use niji_sizes::SizeMoments;

/// The drops at one node of a volume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drops {
    /// Drops per cubic metre of air, N, of the gamma law (1/m³).
    pub number_density_m3: f32,
    /// Effective radius r_e = <r³>/<r²> (m).
    pub effective_radius_m: f32,
    /// Effective variance v_e of the radius, 0 for a single size, below 1/2.
    pub effective_variance: f32,
}

impl Drops {
    /// Air without drops.
    pub const NONE: Self = Self {
        number_density_m3: 0.0,
        effective_radius_m: 0.0,
        effective_variance: 0.0,
    };

    /// So many drops per cubic metre of a law, as drops of the gamma law that has the same area
    /// moments.
    pub fn of_law(moments: &SizeMoments, number_density_m3: f64) -> Self {
        Self {
            number_density_m3: (number_density_m3 * moments.equivalent_gamma_drops()) as f32,
            effective_radius_m: (1e-6 * moments.effective_radius().0) as f32,
            effective_variance: moments.effective_variance as f32,
        }
    }

    /// Whether there are drops here that scatter: both a number and a size above zero.
    pub fn exist(&self) -> bool {
        self.number_density_m3 > 0.0 && self.effective_radius_m > 0.0
    }
}
