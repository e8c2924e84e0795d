//! Moments of drop sizes that add up, and therefore interpolate.
//!
//! M_k = N <r^k>, k = 2, 3, 4 [um^k/m³]
//! `N` number density [1/m³], `r` radius [um], `<>` mean over the drops.
//!
//! M2 = N r_e² (1 - v_e)(1 - 2 v_e),   M3 = r_e M2,   M4 = (1 + v_e) r_e² M2
//! and back:   r_e = M3/M2,   v_e = (M4/M3)(M2/M3) - 1
//! `r_e` effective radius, `v_e` effective variance of a gamma law.
//! [HT74] Hansen and Travis, Space Science Reviews 16, 527-610 (1974), eqs. 2.53, 2.54, 2.56.
//!
//! f32 is enough: in um^k/m³ the moments of 1 drop of 1 um and of 1e9 drops of 1.6 mm are normal
//! numbers (in metres they underflow), and v_e keeps an error below 1e-6 if moments are
//! interpolated as a (1 - t) + b t. The form a + (b - a) t loses v_e altogether between nodes that
//! differ by a factor 1e9, and M4 M2 / M3² underflows where the product of two ratios does not.

use std::f64::consts::PI;

use crate::Drops;

/// Largest effective variance that is given out; at 1/2 the gamma law has infinitely many drops.
pub const MAX_EFFECTIVE_VARIANCE: f32 = 0.49;

/// Square metres in a square micrometre.
pub(crate) const M2_PER_UM2: f64 = 1e-12;

/// Second, third and fourth moment of the radius.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AreaMoments {
    /// N <r²> (um²/m³).
    pub m2: f32,
    /// N <r³> (um³/m³).
    pub m3: f32,
    /// N <r⁴> (um⁴/m³).
    pub m4: f32,
}

impl AreaMoments {
    /// No drops.
    pub const NONE: Self = Self {
        m2: 0.0,
        m3: 0.0,
        m4: 0.0,
    };

    /// Moments of the drops of a node; zero where there are none.
    pub fn from_drops(drops: &Drops) -> Self {
        if !drops.exist() {
            return Self::NONE;
        }
        let r_e = 1e6 * f64::from(drops.effective_radius_m);
        let v_e = f64::from(drops.effective_variance);
        let m2 = f64::from(drops.number_density_m3) * r_e * r_e * (1.0 - v_e) * (1.0 - 2.0 * v_e);
        let m3 = r_e * m2;
        let m4 = (1.0 + v_e) * r_e * m3;
        Self {
            m2: m2 as f32,
            m3: m3 as f32,
            m4: m4 as f32,
        }
    }

    /// Extinction without diffraction, sigma = pi M2 (Q = 1) (1/m).
    pub fn extinction_m1_q1(&self) -> f64 {
        M2_PER_UM2 * PI * f64::from(self.m2)
    }

    /// Liquid water, (4/3) pi rho_w M3 (g/m³).
    pub fn liquid_water_g_m3(&self) -> f64 {
        niji_sizes::liquid_water_g_m3(f64::from(self.m3))
    }

    /// Effective radius r_e = M3/M2 (um); 0 where there are no drops.
    pub fn effective_radius_um(&self) -> f32 {
        if self.m2 > 0.0 {
            self.m3 / self.m2
        } else {
            0.0
        }
    }

    /// Effective variance, in 0..=0.49; 0 where there are no drops.
    pub fn effective_variance(&self) -> f32 {
        if self.m2 > 0.0 && self.m3 > 0.0 {
            ((self.m4 / self.m3) * (self.m2 / self.m3) - 1.0).clamp(0.0, MAX_EFFECTIVE_VARIANCE)
        } else {
            0.0
        }
    }
}

impl std::ops::Add for AreaMoments {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            m2: self.m2 + other.m2,
            m3: self.m3 + other.m3,
            m4: self.m4 + other.m4,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drops(number_density_m3: f32, radius_um: f32, effective_variance: f32) -> Drops {
        Drops {
            number_density_m3,
            effective_radius_m: 1e-6 * radius_um,
            effective_variance,
        }
    }

    fn mean(a: AreaMoments, b: AreaMoments) -> AreaMoments {
        let half = |moments: AreaMoments| AreaMoments {
            m2: 0.5 * moments.m2,
            m3: 0.5 * moments.m3,
            m4: 0.5 * moments.m4,
        };
        half(a) + half(b)
    }

    #[test]
    fn moments_give_back_radius_and_variance() {
        for (radius, variance) in [(1.0, 0.0), (10.0, 0.1), (1600.0, 1.0 / 3.0), (300.0, 0.48)] {
            let moments = AreaMoments::from_drops(&drops(1000.0, radius, variance));
            assert!((moments.effective_radius_um() / radius - 1.0).abs() < 3e-7);
            // Measured worst 9e-8.
            assert!(
                (moments.effective_variance() - variance).abs() < 3e-7,
                "{radius}"
            );
        }
    }

    #[test]
    fn extinction_and_water_are_those_of_marshall_palmer_rain() {
        let untruncated = niji_sizes::MarshallPalmer::untruncated(5.0);
        let (d_min_mm, d_max_mm) = (Some(0.1), Some(6.0));
        let cut = niji_sizes::MarshallPalmer {
            d_min_mm,
            d_max_mm,
            ..untruncated
        };
        for law in [untruncated, cut] {
            let rain = law.moments().bulk_properties(law.number_density_m3());
            let drops = Drops::of_law(&law.moments(), law.number_density_m3());
            let moments = AreaMoments::from_drops(&drops);
            assert!((2.0 * moments.extinction_m1_q1() / rain.extinction_m1 - 1.0).abs() < 1e-6);
            assert!((moments.liquid_water_g_m3() / rain.lwc_g_m3 - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn midway_between_two_sizes_lies_their_mixture() {
        let (large, small) = (drops(1000.0, 1000.0, 0.0), drops(1000.0, 100.0, 0.0));
        let (a, b) = (
            AreaMoments::from_drops(&large),
            AreaMoments::from_drops(&small),
        );
        let between = mean(a, b);
        // Equal numbers of 1.0 and 0.1 mm: <r²> = 505 000, <r³> = 500 500 000 um³.
        assert!((f64::from(between.m2) / (1000.0 * 505_000.0) - 1.0).abs() < 1e-6);
        assert!((f64::from(between.m3) / (1000.0 * 500_500_000.0) - 1.0).abs() < 1e-6);
        assert!((between.effective_radius_um() - 991.09).abs() < 0.01);
        // <r²><r⁴>/<r³>² - 1 = 0.00802...
        assert!((between.effective_variance() - 0.008_067).abs() < 5e-5);
        let extinction = 0.5 * (a.extinction_m1_q1() + b.extinction_m1_q1());
        assert!((between.extinction_m1_q1() / extinction - 1.0).abs() < 1e-6);
        // A drop of the mean radius, 550 um, would have 0.60 of the extinction.
        let literal = AreaMoments::from_drops(&drops(1000.0, 550.0, 0.0)).extinction_m1_q1();
        assert!((literal / extinction - 0.599).abs() < 1e-3);
    }

    #[test]
    fn no_number_or_no_size_is_no_drops() {
        for nothing in [drops(0.0, 10.0, 0.1), drops(100.0, 0.0, 0.1), Drops::NONE] {
            let moments = AreaMoments::from_drops(&nothing);
            assert_eq!(moments, AreaMoments::NONE);
            assert_eq!(
                (moments.effective_radius_um(), moments.effective_variance()),
                (0.0, 0.0)
            );
        }
    }

    #[test]
    fn variance_stays_in_its_range() {
        let wide = AreaMoments {
            m2: 1.0,
            m3: 1.0,
            m4: 9.0,
        };
        let narrow = AreaMoments {
            m2: 1.0,
            m3: 1.0,
            m4: 0.5,
        };
        assert!((wide.effective_variance() - MAX_EFFECTIVE_VARIANCE).abs() < 1e-9);
        assert!(narrow.effective_variance().abs() < 1e-9);
        // m3 has underflown: no 0/0.
        let underflown = AreaMoments {
            m2: 1e-44,
            m3: 0.0,
            m4: 0.0,
        };
        assert!(underflown.effective_variance().abs() < 1e-9);
    }
}
