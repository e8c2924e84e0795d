//! Facets of a rough surface: their slopes, their heights, and which of them light meets next.
//!
//! Normals m have the distribution of Trowbridge and Reitz (GGX),
//!   D(m) = 1/(pi a² cos⁴ (1 + tan²/a²)²)
//! and heights and slopes of neighbors have nothing to do with each other (Smith), so that
//!   Lambda(w) = (-1 + sqrt(1 + a² tan²))/2  for w upwards, with -sqrt for w downwards;
//! light that leaves a height with the share C of all heights below it escapes along w with the chance
//! C^Lambda, and meets the next facet at  C' = C U^(-1/Lambda),  outside where C' is 1 or more. That facet
//! is drawn among those that `from` sees, with density  (from·m) D(m)/sigma,
//!   sigma = (cos + sqrt(cos² + a² sin²))/2.
//! `a` width of the distribution, `C` 0 at the bottom and 1 at the top, `U` random number in 0..1.
//! [H16] E. Heitz et al., Multiple-scattering microfacet BSDFs with the Smith model, ACM Trans. Graphics
//! 35(4), 58 (2016); [H18] E. Heitz, J. Computer Graphics Techniques 7(4), 1-13 (2018).

use std::f64::consts::PI;

use glam::DVec3;

use crate::directions::unit_disc;

/// A surface of facets, level in the mean; z is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Facets {
    /// Width `a` of the distribution.
    pub(crate) roughness: f64,
}

impl Facets {
    /// A facet that `from` sees, from above or, between facets, from below (H18, listing 1).
    pub(crate) fn visible(self, from: DVec3, uv: [f64; 2]) -> DVec3 {
        let a = self.roughness;
        let stretched = DVec3::new(a * from.x, a * from.y, from.z).normalize();
        let [x, y] = unit_disc(uv);
        let s = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * y;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let [across, along] = across_and_along(stretched);
        let facet = x * across + y * along + z * stretched;
        DVec3::new(a * facet.x, a * facet.y, facet.z.max(0.0)).normalize()
    }

    /// Density of [`Self::visible`], 1/sr (H18, eq. 3).
    pub(crate) fn visible_density(self, from: DVec3, facet: DVec3) -> f64 {
        if facet.z <= 0.0 {
            return 0.0;
        }
        let a2 = self.roughness * self.roughness;
        let below = facet.z * facet.z * (a2 - 1.0) + 1.0;
        let distribution = a2 / (PI * below * below);
        distribution * from.dot(facet).max(0.0) / self.projected_area(from)
    }

    /// Height of the next facet on the way along `towards`; 1 or more where there is none.
    pub(crate) fn next_height(self, towards: DVec3, height: f64, random: f64) -> f64 {
        let (z, root) = (towards.z, self.root(towards));
        // The exponent -1/Lambda; minus infinity straight up.
        let exponent = if z > 0.0 {
            -2.0 * z / (root - z)
        } else {
            2.0 * -z / (root - z)
        };
        height * random.powf(exponent)
    }

    /// Chance that light at a height gets away along `towards`.
    pub(crate) fn escape(self, towards: DVec3, height: f64) -> f64 {
        if towards.z <= 0.0 {
            return 0.0;
        }
        let lambda = 0.5 * (self.root(towards) - towards.z) / towards.z;
        height.powf(lambda)
    }

    /// Area of the facets that a direction sees, over that of the surface.
    fn projected_area(self, from: DVec3) -> f64 {
        let root = self.root(from);
        if from.z >= 0.0 {
            return 0.5 * (from.z + root);
        }
        // z + root would subtract nearly equal numbers.
        let level2 = from.x * from.x + from.y * from.y;
        let area = 0.5 * self.roughness * self.roughness * level2 / (root - from.z);
        area.max(f64::MIN_POSITIVE)
    }

    /// sqrt(cos² + a² sin²) of a unit vector.
    fn root(self, direction: DVec3) -> f64 {
        let level2 = direction.x * direction.x + direction.y * direction.y;
        (direction.z * direction.z + self.roughness * self.roughness * level2).sqrt()
    }
}

fn across_and_along(axis: DVec3) -> [DVec3; 2] {
    let level = axis.x.hypot(axis.y);
    let across = if level > 0.0 {
        DVec3::new(-axis.y, axis.x, 0.0) / level
    } else {
        DVec3::X
    };
    [across, axis.cross(across)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::Chi2;
    use crate::chi_square::pseudo_random;
    use crate::chi_square::sphere_bin;
    use crate::chi_square::sphere_shares;

    #[test]
    fn facets_have_the_density_of_those_that_are_seen() {
        for (roughness, cos_from) in [(0.3, 0.9), (0.3, 0.1), (0.5, -0.2), (1.0, -0.6)] {
            let facets = Facets { roughness };
            let sin_from = f64::sqrt(1.0 - cos_from * cos_from);
            let from = DVec3::new(sin_from, 0.0, cos_from);
            let mut chi2 = Chi2::new(256);
            for index in 0..100_000 {
                let facet = facets.visible(from, pseudo_random(index));
                assert!(facet.z >= 0.0 && facet.dot(from) > -1e-9);
                chi2.count(sphere_bin(facet));
            }
            chi2.assert_fits(&sphere_shares(|facet| facets.visible_density(from, facet)));
        }
    }

    #[test]
    fn the_seen_facets_fill_the_surface() {
        // int (from·m) D(m) over the facets that face `from`: the projected area.
        let facets = Facets { roughness: 0.4 };
        for cos_from in [1.0, 0.6, -0.3] {
            let from = DVec3::new(f64::sqrt(1.0 - cos_from * cos_from), 0.0, cos_from);
            let seen: f64 = sphere_shares(|facet| facets.visible_density(from, facet))
                .iter()
                .sum();
            assert!((seen - 1.0).abs() < 2e-3, "{cos_from} {seen}");
        }
        assert!((facets.projected_area(DVec3::Z) - 1.0).abs() < 1e-15);
        assert!((facets.projected_area(DVec3::X) - 0.2).abs() < 1e-15);
    }

    #[test]
    fn as_many_rays_escape_as_meet_no_facet() {
        let facets = Facets { roughness: 0.7 };
        for (cos, height) in [(1.0, 0.3), (0.6, 0.5), (0.05, 0.9)] {
            let towards = DVec3::new(f64::sqrt(1.0 - cos * cos), 0.0, cos);
            let escapes = |index| {
                let [random] = pseudo_random(index);
                facets.next_height(towards, height, random) >= 1.0
            };
            let share = (0..50_000).filter(|&index| escapes(index)).count() as f64 / 50_000.0;
            // Standard error below 0.0023.
            let expected = facets.escape(towards, height);
            assert!((share - expected).abs() < 8e-3, "{share} {expected}");
        }
    }

    #[test]
    fn downwards_and_level_no_ray_escapes() {
        let facets = Facets { roughness: 0.2 };
        for towards in [DVec3::NEG_Z, DVec3::X, DVec3::new(0.6, 0.0, -0.8)] {
            assert_eq!(facets.escape(towards, 0.9), 0.0);
            for random in [1e-300, 0.5, 1.0 - 1e-16] {
                assert!(facets.next_height(towards, 0.9, random) <= 0.9);
            }
        }
    }
}
