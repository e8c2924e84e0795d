//! A rough boundary between air and a transparent body.
//!
//! Light that comes to the boundary meets facets ([`Facets`]), each of which reflects the share F(w·m)
//! of it (Fresnel, unpolarised) and refracts the rest, until it escapes on either side: a random walk,
//! which loses nothing and counts what several facets in turn do. In the body facets and heights are
//! those outside, turned over. What a walk sends of sunlight is the sum over its facets
//!   sum F D_v(h)/(4 w·h) C^Lambda(sun)   or   (1 - F) D_v(h) n² (w'·h)/(w·h + n w'·h)² C^Lambda(sun)
//! for a sun on the same or on the other side (W07, eq. 13 and 16). `D_v` density of the facets that are
//! seen, `n` index on the far side over that on the near side. Inside, radiance counts as L/n².
//! [W07] B. Walter et al., Microfacet models for refraction through rough surfaces, Eurographics
//! Symposium on Rendering, 195-206 (2007); the walk is that of [H16], see `facets`.

use glam::DVec3;

use crate::directions::frame;
use crate::facets::Facets;
use crate::sampler::VertexNumbers;
use crate::surface::Arrival;
use crate::surface::Scattered;
use crate::surface::Side;

/// No walk meets so many facets: of 800000 on the roughest surface none met more than 18.
const MOST_FACETS: u32 = 256;

/// A rough boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RoughDielectric {
    /// Its facets.
    pub(crate) facets: Facets,
    /// Refractive index of the body over that outside.
    pub(crate) refractive_index: f64,
}

impl RoughDielectric {
    /// Walks among the facets on behalf of a path that arrives.
    ///
    /// The first value is the share of the irradiance on a plane across `light` that goes to the path,
    /// 1/sr: its mean over walks is right. The second is how the path goes on.
    pub(crate) fn scatter(
        &self,
        normal: DVec3,
        Arrival { side, back }: Arrival,
        light: DVec3,
        random: &mut VertexNumbers,
    ) -> (f64, Option<Scattered>) {
        let up = match side {
            Side::Outside => normal,
            Side::Inside => -normal,
        };
        let to_world = frame(up);
        let local = to_world.transpose() * back;
        if local.z <= 0.0 {
            return (0.0, None);
        }
        let mut walk = Walk {
            from: local,
            light: to_world.transpose() * light,
            side,
            turn: 1.0,
            height: 1.0,
        };
        let mut lit_per_sr = 0.0;
        for _ in 0..MOST_FACETS {
            let onwards = -walk.from;
            let escape = self.facets.escape(onwards, walk.height);
            // Where light goes almost straight up, it hardly ever meets a facet, but then one that hardly
            // any other light meets: the facet counts with its chance, whether it is met or not.
            let among_met = escape + (1.0 - escape) * random.next();
            walk.height = self.facets.next_height(onwards, walk.height, among_met);
            lit_per_sr += (1.0 - escape) * self.towards_light(&walk);
            if random.next() < escape {
                let direction = (to_world * (walk.turn * onwards)).normalize();
                return (lit_per_sr, Some(Scattered::all(direction, walk.side)));
            }
            self.bounce(&mut walk, random.choice_and_direction());
        }
        (lit_per_sr, None)
    }

    /// Share of the light that the facet of a walk sends into it, 1/sr.
    fn towards_light(&self, walk: &Walk) -> f64 {
        if walk.light.z > 0.0 {
            let escape = self.facets.escape(walk.light, walk.height);
            return escape * self.reflected_density(walk.side, walk.from, walk.light);
        }
        let escape = self.facets.escape(-walk.light, 1.0 - walk.height);
        escape * self.refracted_density(walk.side, walk.from, walk.light)
    }

    /// Draws a facet and goes on from it.
    fn bounce(&self, walk: &mut Walk, [choice, u, v]: [f64; 3]) {
        let n = self.relative_index(walk.side);
        let facet = self.facets.visible(walk.from, [u, v]);
        let cos_facet = walk.from.dot(facet).clamp(0.0, 1.0);
        if choice < fresnel_reflectance(cos_facet, n) {
            walk.from = (walk.from - 2.0 * cos_facet * facet).normalize();
            return;
        }
        let sin2_behind = (1.0 - cos_facet * cos_facet) / (n * n);
        let cos_behind = (1.0 - sin2_behind).max(0.0).sqrt();
        let onwards = (cos_facet / n - cos_behind) * facet - walk.from / n;
        // On the far side everything is turned over: `from` is minus minus what goes on.
        walk.from = onwards.normalize();
        walk.light = -walk.light;
        walk.turn = -walk.turn;
        walk.side = walk.side.other();
        walk.height = 1.0 - walk.height;
    }

    /// Density with which a facet reflects a walk that came from `from` along `to`, 1/sr.
    fn reflected_density(&self, side: Side, from: DVec3, to: DVec3) -> f64 {
        let facet = (from + to).normalize_or_zero();
        let cos_facet = from.dot(facet);
        if facet.z <= 0.0 || cos_facet <= 0.0 {
            return 0.0;
        }
        let share = fresnel_reflectance(cos_facet, self.relative_index(side));
        share * self.facets.visible_density(from, facet) / (4.0 * cos_facet)
    }

    /// Density with which a facet refracts it along `to`, 1/sr.
    fn refracted_density(&self, side: Side, from: DVec3, to: DVec3) -> f64 {
        let n = self.relative_index(side);
        // The facet that refracts one into the other, on the side of `from`.
        let towards = from + n * to;
        let facet = (towards * 1.0_f64.copysign(towards.z)).normalize_or_zero();
        let (cos_from, cos_to) = (from.dot(facet), to.dot(facet));
        if cos_from <= 0.0 || cos_to >= 0.0 {
            return 0.0;
        }
        let share = 1.0 - fresnel_reflectance(cos_from, n);
        let below = cos_from + n * cos_to;
        share * self.facets.visible_density(from, facet) * n * n * -cos_to / (below * below)
    }

    fn relative_index(&self, side: Side) -> f64 {
        match side {
            Side::Outside => self.refractive_index,
            Side::Inside => 1.0 / self.refractive_index,
        }
    }
}

/// A walk among facets, in the frame of the side where it is: up is away from the body outside, into it
/// inside.
struct Walk {
    /// Where it came from; it goes along minus this.
    from: DVec3,
    /// Where the light is, on this side if it is above.
    light: DVec3,
    side: Side,
    /// -1 where the frame is turned over against that of the start.
    turn: f64,
    /// Share of all heights that is below.
    height: f64,
}

/// Share of unpolarised light that a smooth boundary reflects: half the sum of both polarisations.
///
/// `n` index behind the boundary over that before it; 1 beyond the critical angle.
pub(crate) fn fresnel_reflectance(cos_incidence: f64, n: f64) -> f64 {
    let c = cos_incidence.clamp(0.0, 1.0);
    let cos2_behind = 1.0 - (1.0 - c * c) / (n * n);
    if cos2_behind <= 0.0 {
        return 1.0;
    }
    let t = cos2_behind.sqrt();
    let across = (c - n * t) / (c + n * t);
    let along = (n * c - t) / (n * c + t);
    0.5 * (across * across + along * along)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::Chi2;
    use crate::chi_square::pseudo_random;
    use crate::chi_square::sphere_bin;
    use crate::chi_square::sphere_estimates;
    use crate::chi_square::sphere_shares;
    use crate::sampler::Sampler;

    const ICE: f64 = 1.31;

    fn surface(roughness: f64) -> RoughDielectric {
        RoughDielectric {
            facets: Facets { roughness },
            refractive_index: ICE,
        }
    }

    /// A direction on a side of the surface whose normal is z.
    fn on(side: Side, cos: f64) -> DVec3 {
        let z = if side == Side::Outside { cos } else { -cos };
        DVec3::new((1.0 - cos * cos).sqrt(), 0.0, z)
    }

    fn outside(back: DVec3) -> Arrival {
        let side = Side::Outside;
        Arrival { side, back }
    }

    fn numbers(index: u64) -> VertexNumbers {
        VertexNumbers::new(
            pseudo_random(index),
            Sampler::new(1, index as u32).stream(0),
        )
    }

    #[test]
    fn fresnel_has_its_limits() {
        let normal: f64 = ((ICE - 1.0) / (ICE + 1.0)).powi(2);
        assert!((fresnel_reflectance(1.0, ICE) - normal).abs() < 1e-15);
        assert!((fresnel_reflectance(1.0, 1.0 / ICE) - normal).abs() < 1e-15);
        assert_eq!(fresnel_reflectance(0.0, ICE), 1.0);
        // The critical angle, 49.76 degrees.
        assert_eq!(fresnel_reflectance(0.645, 1.0 / ICE), 1.0);
        assert!(fresnel_reflectance(0.647, 1.0 / ICE) < 0.9);
        // Reversed light: the same share at the refracted angle.
        let behind = (1.0 - (1.0 - 0.25) / (ICE * ICE)).sqrt();
        let (there, back) = (
            fresnel_reflectance(0.5, ICE),
            fresnel_reflectance(behind, 1.0 / ICE),
        );
        assert!((there - back).abs() < 1e-15);
    }

    #[test]
    fn diffuse_light_on_ice_is_reflected_by_six_percent() {
        let n = 20_000;
        let mean = |n_rel: f64| -> f64 {
            let at = |i| ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
            (0..n)
                .map(|i| fresnel_reflectance(at(i), n_rel))
                .sum::<f64>()
                / f64::from(n)
        };
        // 0.0627 and 0.4538 for n = 1.31: the reflectances that a diffuse surface would have.
        let (outer, inner) = (mean(ICE), mean(1.0 / ICE));
        assert!(((1.0 - inner) * ICE * ICE - (1.0 - outer)).abs() < 1e-4);
        assert!((outer - 0.0627).abs() < 1e-4, "{outer}");
    }

    #[test]
    fn one_facet_sends_light_where_its_density_says() {
        let surface = surface(0.3);
        for side in [Side::Outside, Side::Inside] {
            // From below: light that other facets have thrown back.
            for cos_from in [0.95, 0.4, -0.2] {
                let from = on(Side::Outside, cos_from);
                let mut chi2 = Chi2::new(512);
                let n_draws = 200_000;
                for index in 0..n_draws {
                    let mut walk = Walk {
                        from,
                        light: DVec3::Z,
                        side,
                        turn: 1.0,
                        height: 0.5,
                    };
                    surface.bounce(&mut walk, pseudo_random(index));
                    let onwards = -walk.turn * walk.from;
                    let first = if walk.side == side { 0 } else { 256 };
                    chi2.count(first + sphere_bin(onwards));
                }
                let mut shares = sphere_shares(|to| surface.reflected_density(side, from, to));
                shares.extend(sphere_shares(|to| {
                    surface.refracted_density(side, from, to)
                }));
                chi2.assert_fits_of(&shares, n_draws as f64);
            }
        }
    }

    #[test]
    fn walks_end_where_they_say_that_light_comes_from() {
        let n_draws = 200_000;
        for (roughness, side, cos_back) in [
            (0.2, Side::Outside, 0.6),
            (0.5, Side::Inside, 0.8),
            (1.0, Side::Outside, 0.1),
        ] {
            let surface = surface(roughness);
            let back = on(side, cos_back);
            let mut chi2 = Chi2::new(256);
            for index in 0..n_draws {
                let at = Arrival { side, back };
                let (_, on) = surface.scatter(DVec3::Z, at, DVec3::Z, &mut numbers(index));
                chi2.count(sphere_bin(on.unwrap().direction));
            }
            chi2.assert_fits_estimates(&sphere_estimates(|light, number| {
                let mut random = numbers(n_draws + number);
                surface
                    .scatter(DVec3::Z, Arrival { side, back }, light, &mut random)
                    .0
            }));
        }
    }

    #[test]
    fn no_light_is_lost_among_facets() {
        for roughness in [0.02, 0.2, 0.5, 1.0] {
            for side in [Side::Outside, Side::Inside] {
                for cos_back in [1e-6, 0.1, 0.8, 1.0] {
                    let lost = (0..5_000).filter(|&index| {
                        let back = on(side, cos_back);
                        let at = Arrival { side, back };
                        let (_, on) =
                            surface(roughness).scatter(DVec3::Z, at, DVec3::Z, &mut numbers(index));
                        on.is_none_or(|on| on.weight != 1.0 || !on.direction.is_normalized())
                    });
                    assert_eq!(lost.count(), 0, "{roughness} {side:?} {cos_back}");
                }
            }
        }
    }

    #[test]
    fn reversed_light_finds_the_same_surface() {
        // cos_from f(from -> to) is the same both ways; between the sides as reduced radiance, that is
        // with the index of the side of the light squared.
        let surface = surface(0.4);
        let mean = |side, back, light| -> f64 {
            let lit = |index| {
                surface
                    .scatter(DVec3::Z, Arrival { side, back }, light, &mut numbers(index))
                    .0
            };
            (0..200_000).map(lit).sum::<f64>() / 200_000.0
        };
        let (above, slanted) = (on(Side::Outside, 0.9), on(Side::Outside, 0.3));
        let there = mean(Side::Outside, above, slanted) * above.z;
        let back = mean(Side::Outside, slanted, above) * slanted.z;
        // Found 0.2 % and 0.4 %.
        assert!((there / back - 1.0).abs() < 0.02, "{there} {back}");
        let within = DVec3::new(-0.5, 0.0, -f64::sqrt(0.75));
        let there = mean(Side::Outside, above, within) * above.z;
        let back = mean(Side::Inside, within, above) * -within.z * ICE * ICE;
        assert!((there / back - 1.0).abs() < 0.02, "{there} {back}");
    }

    #[test]
    fn a_nearly_smooth_surface_obeys_snell() {
        let back = DVec3::new(0.6, 0.0, 0.8);
        let mut numbers = VertexNumbers::new([0.999, 0.3, 0.4], Sampler::new(1, 1).stream(0));
        let (_, through) = surface(1e-4).scatter(DVec3::Z, outside(back), DVec3::Z, &mut numbers);
        let through = through.unwrap();
        assert_eq!(through.side, Side::Inside);
        assert!((through.direction.x + 0.6 / ICE).abs() < 1e-3);
    }

    #[test]
    fn directions_within_and_behind_the_surface_give_nothing() {
        for back in [DVec3::X, DVec3::NEG_Z] {
            let at = outside(back);
            let (lit, on) = surface(0.2).scatter(DVec3::Z, at, DVec3::Z, &mut numbers(1));
            assert_eq!((lit, on), (0.0, None));
        }
        let grazing = DVec3::new(1.0, 0.0, 1e-12).normalize();
        let at = outside(grazing);
        let (lit, on) = surface(0.2).scatter(DVec3::Z, at, DVec3::X, &mut numbers(2));
        assert!(lit.is_finite() && on.unwrap().direction.is_finite());
    }
}
