//! The Debye series: Lorenz-Mie scattering by the number of passages through the surface.
//!
//! a_n or b_n = 1/2 [1 - R22 - T sum_{p>=1} R11^(p-1)] = 1/2 [1 - R22 - T/(1 - R11)]
//!   R22 = -(v(x)/u(x)) (alpha B - beta C)/Delta    reflection outside
//!   R11 = -(u(y)/v(y)) (alpha D - beta A)/Delta    reflection inside
//!   T = -4m/(u(x) v(y) Delta)^2                    into the sphere and out again
//!   Delta = alpha B - beta A,  y = m x,  (alpha, beta) = (1, m) for a_n, (m, 1) for b_n
//! with outgoing u = psi - i chi, incoming v = psi + i chi, and A = u'/u, C = v'/v at x, D = u'/u,
//! B = v'/v at y. T comes from the Wronskian v u' - v' u = 2i without a subtraction. Each of the
//! four is w_{n-1}/w_n - n/z, and n/z is subtracted by hand: in magnetic waves it drops out, in
//! electric ones n/x (m - 1/m) is left. Where m = 1 there is no surface.
//! Order 0 is (1 - R22)/2, diffraction and outer reflection; order p >= 1 is -T R11^(p-1)/2.
//! u and v dominate beyond the turning point and are recurred upwards; in an absorbing sphere v is
//! recessive below it (the error grows as exp(2 Im y)) and is taken as 2 psi - u instead. Phases
//! exp(-+iy) are taken out, so nothing overflows; behind exp(-2 Im y) = 1e-304 the sphere is
//! opaque. Coefficients have an absolute accuracy of some 1e-16 sqrt(x): amplitudes on the dark
//! side of a bow end in a floor at 1e-12 of its peak, and for x << 1 the small remainder of 1 - R22
//! is lost.
//! [HL92] Hovenac and Lock, J. Opt. Soc. Am. A 9, 781-795 (1992). [G03] Gouesbet, Part. Part. Syst.
//! Charact. 20, 382-386 (2003).

use num_complex::Complex64;

use crate::angles::ScatteringAngles;
use crate::lorenz_mie::n_partial_waves;
use crate::partial_waves::PartialWaves;
use crate::partial_waves::incoherent_cross_sections;
use crate::riccati_bessel::chi;
use crate::riccati_bessel::neighbors;
use crate::riccati_bessel::psi;
use crate::riccati_bessel::psi_ratios;

/// Im y above which v is no longer recurred itself; its error there is a factor e^2.
const MAX_ABSORPTION_OF_RECURRENCE: f64 = 1.0;
/// Im y above which no light comes through: T < 1e-304.
const OPAQUE_ABSORPTION: f64 = 350.0;
/// Modulus above which u and v inside are scaled down.
const LARGE: f64 = 1e100;

/// Reflection and transmission of one partial wave of one polarization.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Surface {
    /// R22: reflection outside.
    outer_reflection: Complex64,
    /// R11: reflection inside.
    inner_reflection: Complex64,
    /// T21 T12: in and out.
    transmission: Complex64,
}

/// The Debye series of a sphere, from which any order can be taken.
///
/// ```
/// use niji_mie::{RefractiveIndex, ScatteringAngles, Sphere};
///
/// // A drop of 0.1 mm in yellow light: two internal reflections make a bow 51 degrees from the
/// // antisolar point, and Alexander's dark band lies between it and the primary.
/// let sphere = Sphere::new(1000.0, RefractiveIndex::from(1.333))?;
/// let angles = ScatteringAngles::from_degrees(&[126.5, 134.0])?;
/// let secondary = sphere.debye(3).amplitudes(&angles);
/// assert!(secondary.s1[0].norm_sqr() > 10.0 * secondary.s1[1].norm_sqr());
/// # Ok::<(), niji_mie::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct DebyeSeries {
    size_parameter: f64,
    /// Of a_n and of b_n, n from 1.
    surfaces: Vec<[Surface; 2]>,
}

impl DebyeSeries {
    /// The series of a sphere of size `x` and index `m`, already checked.
    pub(crate) fn new(x: f64, m: Complex64) -> Self {
        let n_waves = n_partial_waves(x);
        let mut inside = Inside::new(m * x, n_waves);
        let outside = neighbors(psi(x, n_waves)).zip(neighbors(chi(x, n_waves)));
        let surfaces = (1..).zip(outside).map(|(n, (psi, chi))| {
            let u = |i: usize| Complex64::new(psi[i], -chi[i]);
            let inverse = u(1).inv();
            let outer = Outer {
                inverse_outgoing: inverse,
                incoming_over_outgoing: u(1).conj() * inverse,
                a: u(0) * inverse,
            };
            let inner = inside.next_wave(n);
            let electric = Weights {
                alpha: Complex64::ONE,
                beta: m,
                left: n as f64 / x * ((m - 1.0) * (m + 1.0) / m),
            };
            let magnetic = Weights {
                alpha: m,
                beta: Complex64::ONE,
                left: Complex64::ZERO,
            };
            [electric, magnetic].map(|weights| surface(m, &weights, &outer, &inner))
        });
        Self {
            size_parameter: x,
            surfaces: surfaces.collect(),
        }
    }

    /// Order p: 0 diffraction and reflection, 1 transmission, 2 the primary bow, 3 the secondary
    /// bow.
    pub fn order(&self, order: u32) -> PartialWaves {
        self.waves(|surface| match order.checked_sub(1) {
            None => 0.5 * (1.0 - surface.outer_reflection),
            Some(n_reflections) => {
                -0.5 * surface.transmission * surface.inner_reflection.powu(n_reflections)
            }
        })
    }

    /// Sum over `orders` of (dsigma/dOmega)/(pi a^2) at each angle, 1/sr, for light polarized
    /// perpendicular and parallel to the scattering plane.
    ///
    /// Intensities add, not amplitudes: that is the mean over drop sizes, whose interference
    /// between orders has every phase. Orders are added as they stand in the list. They share the
    /// recurrence over n: eight take the time of five sums of all orders together.
    pub fn incoherent_cross_sections(
        &self,
        orders: &[u32],
        angles: &ScatteringAngles,
    ) -> Vec<[f64; 2]> {
        let series: Vec<PartialWaves> = orders.iter().map(|order| self.order(*order)).collect();
        incoherent_cross_sections(&series, angles)
    }

    fn waves(&self, coefficient: impl Fn(&Surface) -> Complex64) -> PartialWaves {
        let [a, b] = [0, 1].map(|polarization: usize| {
            self.surfaces
                .iter()
                .map(|pair| coefficient(&pair[polarization]))
                .collect()
        });
        PartialWaves {
            size_parameter: self.size_parameter,
            a,
            b,
        }
    }
}

/// The wave outside; the incoming one is its conjugate.
struct Outer {
    /// 1/u.
    inverse_outgoing: Complex64,
    /// v/u, where v is the conjugate of u.
    incoming_over_outgoing: Complex64,
    /// u_{n-1}/u_n.
    a: Complex64,
}

/// The waves inside, as far as a surface needs them.
struct Inner {
    /// v_{n-1}/v_n.
    b: Complex64,
    /// u_{n-1}/u_n.
    d: Complex64,
    /// u/v.
    outgoing_over_incoming: Complex64,
    /// 1/v.
    inverse_incoming: Complex64,
}

/// What distinguishes electric and magnetic waves.
struct Weights {
    alpha: Complex64,
    beta: Complex64,
    /// What is left of n/z: beta n/x - alpha n/y.
    left: Complex64,
}

fn surface(m: Complex64, weights: &Weights, outer: &Outer, inner: &Inner) -> Surface {
    // Exactly, as the user gave it.
    if m == Complex64::ONE {
        return Surface {
            outer_reflection: Complex64::ZERO,
            inner_reflection: Complex64::ZERO,
            transmission: Complex64::ONE,
        };
    }
    let Weights { alpha, beta, left } = weights;
    let mismatch = |inside: Complex64, outside: Complex64| alpha * inside - beta * outside + left;
    let inverse_delta = mismatch(inner.b, outer.a).inv();
    let outer_reflection =
        -outer.incoming_over_outgoing * mismatch(inner.b, outer.a.conj()) * inverse_delta;
    let inner_reflection =
        -inner.outgoing_over_incoming * mismatch(inner.d, outer.a) * inverse_delta;
    let passage = 2.0 * inner.inverse_incoming * outer.inverse_outgoing * inverse_delta;
    Surface {
        outer_reflection,
        inner_reflection,
        transmission: -m * passage * passage,
    }
}

/// Recurs u exp(-iy) and v exp(iy) of the inside argument y.
struct Inside {
    y: Complex64,
    /// exp(iy), 0 for an opaque sphere.
    phase: Complex64,
    /// psi_n/psi_{n-1} from n = 1 where there is absorption; empty without.
    ratios: Vec<Complex64>,
    u: [Complex64; 2],
    v: [Complex64; 2],
    /// psi_n exp(iy), where there is absorption.
    psi: Complex64,
    /// Scale taken out of u, v and psi.
    scale: f64,
}

impl Inside {
    fn new(y: Complex64, n_waves: usize) -> Self {
        let i = Complex64::I;
        let phase = if y.im > OPAQUE_ABSORPTION {
            Complex64::ZERO
        } else {
            (i * y).exp()
        };
        let is_absorbing = y.im > MAX_ABSORPTION_OF_RECURRENCE;
        let ratios = if is_absorbing {
            psi_ratios(y, 1, n_waves)
        } else {
            Vec::new()
        };
        let psi = (phase * phase - 1.0) / (2.0 * i);
        // u_{-1} = exp(iy), u_0 = -i exp(iy), v_{-1} = exp(-iy), v_0 = i exp(-iy).
        let (u, v) = ([Complex64::ONE, -i], [Complex64::ONE, i]);
        Self {
            y,
            phase,
            ratios,
            u,
            v,
            psi,
            scale: 1.0,
        }
    }

    /// Steps from n - 1 to n.
    fn next_wave(&mut self, n: usize) -> Inner {
        if self.y.im > OPAQUE_ABSORPTION {
            return self.opaque(n);
        }
        let factor = (2 * n - 1) as f64 / self.y;
        self.u = [self.u[1], factor * self.u[1] - self.u[0]];
        let v = match self.ratios.get(n - 1) {
            None => factor * self.v[1] - self.v[0],
            Some(ratio) => {
                self.psi *= ratio;
                2.0 * self.psi - self.u[1] * self.phase * self.phase
            }
        };
        self.v = [self.v[1], v];
        let inverse_v = self.v[1].inv();
        let inner = Inner {
            b: self.v[0] * inverse_v,
            d: self.u[0] / self.u[1],
            outgoing_over_incoming: self.u[1] * self.phase * inverse_v * self.phase,
            inverse_incoming: self.phase * inverse_v * self.scale,
        };
        self.scale_down();
        inner
    }

    /// v = 2 psi to the last digit, and nothing comes back.
    fn opaque(&self, n: usize) -> Inner {
        Inner {
            b: 1.0 / self.ratios[n - 1],
            d: Complex64::ZERO,
            outgoing_over_incoming: Complex64::ZERO,
            inverse_incoming: Complex64::ZERO,
        }
    }

    fn scale_down(&mut self) {
        if self.u[1].l1_norm() > LARGE {
            let factor = 1.0 / LARGE;
            self.u = self.u.map(|u| u * factor);
            self.v = self.v.map(|v| v * factor);
            self.psi *= factor;
            self.scale *= factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lorenz_mie::partial_waves;

    /// All orders in closed form. Only a check: in tunnelling waves (n > |m| x) 1 - R11 cancels.
    fn all_orders(series: &DebyeSeries) -> PartialWaves {
        series.waves(|surface| {
            let through = surface.transmission / (1.0 - surface.inner_reflection);
            0.5 * (1.0 - surface.outer_reflection - through)
        })
    }

    #[test]
    fn the_closed_form_of_all_orders_is_lorenz_mie() {
        for (x, n, k) in [
            (1.0, 1.333, 0.0),
            (10.0, 1.333, 1e-5),
            (100.0, 1.5, 0.0),
            (100.0, 1.333, 9.9e-3),
            (100.0, 1.333, 1.01e-2),
            (1000.0, 1.333, 0.0),
            (100.0, 1.333, 3.49),
            (100.0, 1.333, 3.51),
            (100.0, 10.0, 10.0),
            (10000.0, 1.333, 1e-5),
            (10000.0, 1.5, 1.0),
            (20000.0, 1.333, 0.0),
        ] {
            let m = Complex64::new(n, k);
            let (mie, sum) = (partial_waves(x, m), all_orders(&DebyeSeries::new(x, m)));
            for (a, b) in mie.a.iter().zip(&sum.a).chain(mie.b.iter().zip(&sum.b)) {
                // Worst found 2.6e-12, next to a resonance.
                assert!((a - b).norm() <= 1e-11, "x = {x}, m = {m}: {a} {b}");
            }
        }
    }

    #[test]
    fn an_opaque_sphere_has_order_0_only() {
        for absorption in [349.0, 351.0] {
            let m = Complex64::new(1.4, absorption / 1000.0);
            let series = DebyeSeries::new(1000.0, m);
            let mie = partial_waves(1000.0, m);
            for (a, b) in mie.a.iter().zip(&series.order(0).a) {
                assert!((a - b).norm() <= 2e-14, "{a} {b}");
            }
            assert!(series.order(1).a.iter().all(|a| a.norm() < 1e-200));
        }
    }

    #[test]
    fn in_a_bubble_nothing_overflows() {
        for x in [10.0, 1000.0, 10000.0] {
            let series = DebyeSeries::new(x, Complex64::new(0.75, 0.0));
            for order in 0..4 {
                let waves = series.order(order);
                assert!(
                    waves.a.iter().chain(&waves.b).all(|c| c.is_finite()),
                    "{x} {order}"
                );
            }
        }
    }
}
