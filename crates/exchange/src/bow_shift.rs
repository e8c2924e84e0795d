//! How far flattened drops move a bow, to second order of their eccentricity: its evaluation.
//!
//! Δθ = e k (T² − B²) + e² [ a (T⁴ + B⁴) + c T² B² + f T² N² + g B² N² ],   N² = 1 − T² − B²
//! `Δθ` shift of the scattering angle of the bow in radians, e = (1 − q)/(1 + q) with the axis ratio `q`;
//! `T`, `B`, `N` components of the drop's short axis, for falling drops of the vertical, along
//! (s + d)/|s + d|, (s − d)/|s − d| and the normal of both; `s` towards the sun, `d` from the eye into the
//! view; `k`, `a`, `c`, `f`, `g` numbers of order and index alone, which `niji-scatter` traces.

/// No bow is followed farther (rad): beyond, nothing is left of it.
pub const FARTHEST_SHIFT_RAD: f64 = 0.8;

/// Steps of T² and of B² by which the largest shift is found.
const N_SQUARES: u32 = 8;

/// The shift of one order's bow at one refractive index.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BowShift {
    /// k, a, c, f and g in radians.
    pub coefficients_rad: [f64; 5],
}

/// A shift seen along one direction: what is left of it is a parabola of the eccentricity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeenShift {
    /// Factors of e and e² in Δθ, in radians.
    shift_rad: [f64; 2],
    /// Factors of e and e² in ∂Δθ/∂T² and in ∂Δθ/∂B², where N² gives way.
    slopes_rad: [[f64; 2]; 2],
}

impl BowShift {
    /// The shift where the squares T² and B² are `t2` and `b2`.
    pub fn seen(&self, t2: f64, b2: f64) -> SeenShift {
        let n2 = 1.0 - t2 - b2;
        let [k, a, c, f, g] = self.coefficients_rad;
        let by_n2 = f * t2 + g * b2;
        let by_t2 = 2.0 * a * t2 + c * b2 + f * n2 - by_n2;
        let by_b2 = 2.0 * a * b2 + c * t2 + g * n2 - by_n2;
        let second = a * (t2 * t2 + b2 * b2) + c * t2 * b2 + n2 * by_n2;
        SeenShift {
            shift_rad: [k * (t2 - b2), second],
            slopes_rad: [[k, by_t2], [-k, by_b2]],
        }
    }

    /// Δθ in radians of drops of an eccentricity e, where the squares T² and B² are `t2` and `b2`.
    pub fn shift_rad(&self, eccentricity: f64, t2: f64, b2: f64) -> f64 {
        self.seen(t2, b2).shift_rad(eccentricity)
    }

    /// Largest |Δθ| in radians of drops of an eccentricity over all directions of their axis, within a few
    /// percent and at most [`FARTHEST_SHIFT_RAD`].
    pub fn largest_rad(&self, eccentricity: f64) -> f64 {
        let square = |step: u32| f64::from(step) / f64::from(N_SQUARES);
        let shifts = (0..=N_SQUARES).flat_map(|t2| {
            (0..=N_SQUARES - t2).map(move |b2| self.shift_rad(eccentricity, square(t2), square(b2)))
        });
        let largest = shifts.map(f64::abs).fold(0.0, f64::max);
        largest.min(FARTHEST_SHIFT_RAD)
    }
}

impl SeenShift {
    /// Δθ in radians of drops of an eccentricity.
    #[inline]
    pub fn shift_rad(&self, eccentricity: f64) -> f64 {
        parabola(self.shift_rad, eccentricity)
    }

    /// ∂Δθ/∂T² and ∂Δθ/∂B², where N² gives way.
    #[inline]
    pub(crate) fn slopes(&self, eccentricity: f64) -> [f64; 2] {
        self.slopes_rad.map(|slope| parabola(slope, eccentricity))
    }

    /// ∂Δθ/∂e.
    #[inline]
    pub fn eccentricity_slope(&self, eccentricity: f64) -> f64 {
        self.shift_rad[0] + 2.0 * eccentricity * self.shift_rad[1]
    }
}

/// a x + b x².
#[inline]
fn parabola([a, b]: [f64; 2], x: f64) -> f64 {
    x * (a + x * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHIFT: BowShift = BowShift {
        coefficients_rad: [1.7, -0.6, 3.1, 0.9, -2.3],
    };
    /// T² and B²: along T, B and N, none of them, no first order.
    const SQUARES: [[f64; 2]; 5] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [0.3, 0.6], [0.4, 0.4]];
    /// Measured worst 6e-17.
    const ROUNDING: f64 = 1e-15;

    #[test]
    fn spheres_and_orders_without_a_bow_stay() {
        for [t2, b2] in SQUARES {
            assert_eq!(SHIFT.shift_rad(0.0, t2, b2), 0.0);
            assert_eq!(BowShift::default().shift_rad(0.3, t2, b2), 0.0);
        }
    }

    #[test]
    fn the_shift_is_the_form_of_the_header() {
        let [k, a, c, f, g] = SHIFT.coefficients_rad;
        for [t2, b2] in SQUARES {
            let (e, n2) = (0.2, 1.0 - t2 - b2);
            let second = a * (t2 * t2 + b2 * b2) + c * t2 * b2 + f * t2 * n2 + g * b2 * n2;
            let expected = e * k * (t2 - b2) + e * e * second;
            assert!((SHIFT.shift_rad(e, t2, b2) - expected).abs() < ROUNDING);
        }
    }

    #[test]
    fn an_axis_across_the_plane_leaves_the_bow_and_long_drops_are_flat_ones_turned() {
        assert_eq!(SHIFT.shift_rad(0.3, 0.0, 0.0), 0.0);
        // In the plane alone: e is -e with T and B exchanged.
        let difference = SHIFT.shift_rad(0.3, 0.36, 0.64) - SHIFT.shift_rad(-0.3, 0.64, 0.36);
        assert!(difference.abs() < ROUNDING);
    }

    #[test]
    fn the_largest_shift_is_that_of_an_axis_in_the_plane_to_first_order() {
        let first = BowShift {
            coefficients_rad: [1.7, 0.0, 0.0, 0.0, 0.0],
        };
        assert_eq!(first.largest_rad(0.2), first.shift_rad(0.2, 1.0, 0.0));
        assert_eq!(first.largest_rad(0.0), 0.0);
        assert_eq!(first.largest_rad(0.9), FARTHEST_SHIFT_RAD);
        for [t2, b2] in SQUARES {
            // The second order has its extremes between the steps.
            let shift = SHIFT.shift_rad(0.2, t2, b2).abs();
            assert!(shift <= 1.02 * SHIFT.largest_rad(0.2));
        }
    }

    #[test]
    fn slopes_are_those_of_differences() {
        // Central differences of parabolas are exact; measured worst 4e-15.
        let (step, tolerance) = (0.01, 1e-13);
        for [t2, b2] in SQUARES {
            let e = 0.2;
            let slope = |shift: &dyn Fn(f64) -> f64| (shift(step) - shift(-step)) / (2.0 * step);
            let seen = SHIFT.seen(t2, b2);
            let [by_t2, by_b2] = seen.slopes(e);
            let of_t2 = slope(&|step| SHIFT.shift_rad(e, t2 + step, b2));
            let of_b2 = slope(&|step| SHIFT.shift_rad(e, t2, b2 + step));
            let of_e = slope(&|step| SHIFT.shift_rad(e + step, t2, b2));
            assert!((by_t2 - of_t2).abs() < tolerance);
            assert!((by_b2 - of_b2).abs() < tolerance);
            assert!((seen.eccentricity_slope(e) - of_e).abs() < tolerance);
        }
    }
}
