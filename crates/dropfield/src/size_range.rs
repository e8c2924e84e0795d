//! Which drops a field has, between its nodes as well.
//!
//! v_e <= (1 + v) (a + b)²/(4 a b) - 1
//! the largest effective variance of a mixture of drops whose effective radii lie between `a` and `b` and
//! whose own effective variance is at most `v`. Area moments interpolate linearly, so that this is what lies
//! between nodes of different drops; the effective radius of a mixture lies between theirs.

/// Smallest and largest effective radius and variance of a field of drops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeRange {
    /// Effective radius (um).
    pub effective_radius_um: (f64, f64),
    /// Effective variance, mixtures between nodes included.
    pub effective_variance: (f64, f64),
}

impl SizeRange {
    /// One drop.
    pub(crate) fn of(effective_radius_um: f64, effective_variance: f64) -> Self {
        Self {
            effective_radius_um: (effective_radius_um, effective_radius_um),
            effective_variance: (effective_variance, effective_variance),
        }
    }

    /// The drops of two fields.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        let wider = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        Self {
            effective_radius_um: wider(self.effective_radius_um, other.effective_radius_um),
            effective_variance: wider(self.effective_variance, other.effective_variance),
        }
    }

    /// The same nodes with what lies between them.
    pub(crate) fn with_mixtures(self) -> Self {
        let (narrowest, broadest) = self.effective_variance;
        let mixed = mixture_variance(self.effective_radius_um, broadest);
        Self {
            effective_variance: (narrowest, mixed.max(narrowest)),
            ..self
        }
    }
}

/// Largest effective variance of a mixture of drops whose effective radii lie between `a` and `b`
/// and whose own effective variance is at most `v`, as far as a gamma law can have it.
pub fn mixture_variance((a, b): (f64, f64), v: f64) -> f64 {
    let largest = (1.0 + v) * (a + b).powi(2) / (4.0 * a * b) - 1.0;
    // Of equal radii `v` itself, without the roundoff of the line above.
    let mixed = if a < b { largest.max(v) } else { v };
    mixed.min(f64::from(crate::MAX_EFFECTIVE_VARIANCE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_mixture_of_two_sizes_is_wider_than_the_bound() {
        let (a, b, v) = (100.0_f64, 250.0_f64, 0.05);
        let bound = mixture_variance((a, b), v);
        let mut widest = 0.0_f64;
        for step in 0..=1000 {
            // Shares of the cross-section.
            let t = f64::from(step) / 1000.0;
            let m3 = a * (1.0 - t) + b * t;
            let m4 = (1.0 + v) * (a * a * (1.0 - t) + b * b * t);
            widest = widest.max(m4 / (m3 * m3) - 1.0);
        }
        assert!(
            widest <= bound && widest > bound - 1e-5,
            "{widest}, {bound}"
        );
        assert_eq!(mixture_variance((a, a), v), v);
        assert!(mixture_variance((0.0, b), v) < 0.5);
    }

    #[test]
    fn a_union_holds_both_and_a_field_its_mixtures() {
        let both = SizeRange::of(100.0, 0.1).union(SizeRange::of(400.0, 0.0));
        assert_eq!(both.effective_radius_um, (100.0, 400.0));
        assert_eq!(both.effective_variance, (0.0, 0.1));
        // 1.1 times 500²/(4 times 100 times 400), less 1.
        let mixed = both.with_mixtures().effective_variance;
        assert!(mixed.0 == 0.0 && mixed.1 == f64::from(crate::MAX_EFFECTIVE_VARIANCE));
        assert_eq!(
            SizeRange::of(7.0, 0.2).with_mixtures(),
            SizeRange::of(7.0, 0.2)
        );
    }
}
