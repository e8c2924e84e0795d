//! Light of surfaces with an albedo, and what shades them and the ground.
//!
//! L = A/pi T_drops T_eye (E_sun T_sun [(n . w) S exp(-tau) + V w_y (1 + n_y)/2 (T(tau) - exp(-tau))]
//!     + V U (E(n) - D(n)) + D(n))
//!
//! `A` albedo (`paint` where it is by place), `n` normal of the smooth surface, of a flat triangle its own, `w` towards
//! the sun, `T_eye` and `T_sun` what air lets pass, `S` 1 where no surface stands before the sun, `tau` of the drops before
//! it (Q = 1: what diffraction turns aside falls next to it), `T` what these
//! let pass with what they scatter downwards, `U` the same of skylight (`under_drops`),
//! `E(n)` irradiance of all diffuse light on a tilted face, as sky and ground send it to an open place of this
//! height (`air_diffuse`), `D(n) = A_g/2 (1 - n_y) E_g` what of it the ground sends, `E_g` light on the level ground,
//! `V` share of the sky that surfaces leave (`sky_view`), on terrain whose cells are wider than pixels as its nodes see
//! it (`terrain_view`).
//!
//! What surfaces send to each other is not followed. It is told as error, as if all surfaces that the place sees were of
//! the brightest albedo `B`, across the sun under an open sky, and saw as much of each other:
//!
//! dL = A/pi T_drops T_eye F B E/(1 - B F),   F = (1 - V) (1 + n_y)/2 + W (1 - n_y)/2
//!
//! `E` irradiance there, `W` share of what lies below the horizon that surfaces are; what the ground sends in
//! place of these is part of the light.
//!
//! Where the smooth surface and its triangle disagree about the sun, S is 0: none lights a triangle that it stands behind
//! (V97, section 5.3). So the edge of night follows triangles, and is that of the smooth surface to within the angle
//! between their normals; wherever the triangle is lit it has n . w, without a hole.
//! [V97] E. Veach, Robust Monte Carlo Methods for Light Transport Simulation, dissertation, Stanford (1997).
//!
//! The sun is a point. Left out: the light that clouds send down beside their shadow,
//! and the shadow of surfaces on air and drops.

use std::collections::VecDeque;

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::HeightField;
use niji_geometry::Ray;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::air::Air;
use crate::air_diffuse::FaceOfAir;
use crate::air_glow::both_ways;
use crate::lit_drops::depth;
use crate::paint::Paint;
use crate::paint::SurfaceColor;
use crate::request::RenderRequest;
use crate::sky_view::Azimuth;
use crate::sky_view::N_AZIMUTHS;
use crate::sky_view::azimuths;
use crate::sky_view::free_share;
use crate::sky_view::share_met_below;
use crate::surfaces::Face;
use crate::surfaces::Sight;
use crate::surfaces::Surfaces;
use crate::terrain_view::PlaceView;
use crate::terrain_view::TerrainView;
use crate::under_drops::SkyUnderDrops;
use crate::under_drops::sun_under;

/// How far from a surface rays towards sun and sky begin, so that it does not shade itself (m).
const LIFT_M: f64 = 1e-5;

/// Height of the ground (m).
const GROUND_M: f64 = 0.0;

/// Within a pixel a place sees the sky as one before, of so many, that is no farther from it than this part of the
/// distance from the eye, and whose normal has at least this cosine to its own.
const N_KNOWN: usize = 8;
const NEAR: f64 = 0.02;
const ALIKE: f64 = 0.999;

/// Cells of terrain that are as many pixels wide have what their nodes see.
const PIXELS_OF_CELL: f64 = 2.0;

/// Shares of the light of the sun and of the sky that reach a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shade {
    pub(crate) sun: f64,
    pub(crate) sky: f64,
}

impl Shade {
    /// All of both.
    pub(crate) const NONE: Self = Self { sun: 1.0, sky: 1.0 };
}

/// A lit place at the end of a sight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    point: DVec3,
    pub(crate) face: Face,
}

impl Spot {
    /// The place where a sight ends; `None` where that is not lit.
    pub(crate) fn of(sight: &Sight) -> Option<Self> {
        let face = sight.face?;
        let point = sight.ray.at(sight.surface_m);
        Some(Self { point, face })
    }
}

/// What a face sees around it.
#[derive(Clone, Copy, Debug)]
struct SkyView {
    /// Share of the sky that surfaces leave.
    free: f64,
    /// Of all that lights it, what surfaces are: their form factor.
    hidden: f64,
}

/// Room to work in.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceRoom {
    /// What a place sends to the eye for unit sun irradiance, but for drops between [1/sr].
    pub(crate) light: Vec<f32>,
    /// The same of what surfaces may send to it and is not in its light.
    pub(crate) unfollowed: Vec<f32>,
    /// Places of the pixel whose view of the sky was looked at, the last one first, and what that was.
    sky: VecDeque<(Spot, SkyView)>,
}

impl SurfaceRoom {
    /// Darkness at so many wavelengths.
    pub(crate) fn new(n_wavelengths: usize) -> Self {
        Self {
            light: vec![0.0; n_wavelengths],
            unfollowed: vec![0.0; n_wavelengths],
            sky: VecDeque::new(),
        }
    }

    /// Forget the pixel before: no pixel depends on another.
    pub(crate) fn clear(&mut self) {
        self.sky.clear();
    }
}

/// What all lit surfaces of a picture share.
pub(crate) struct SurfaceLight<'a> {
    surfaces: Option<&'a Surfaces>,
    /// What the solids give back.
    colors: Vec<Reflected<'a>>,
    wavelengths: Vec<Nanometers>,
    /// What those of them that are terrain see around them.
    terrains: Vec<Option<TerrainView<'a>>>,
    /// What a pixel is wide.
    pixel_rad: f64,
    /// The largest albedo by wavelength.
    brightest: Vec<f64>,
    sun_direction: DVec3,
    /// Drops that shade.
    bricks: &'a [Bricks],
    /// What they leave of the sky.
    sky: Option<SkyUnderDrops>,
}

/// What a solid gives back.
enum Reflected<'a> {
    /// Albedos over pi by wavelength; none of a black one.
    // f32: spectra leave in f32.
    Evenly(Vec<f32>),
    /// By place.
    Painted(&'a Paint),
}

impl<'a> Reflected<'a> {
    fn of(color: Option<&'a SurfaceColor>, grid: &WavelengthGrid) -> Self {
        match color {
            None => Self::Evenly(Vec::new()),
            Some(SurfaceColor::Plain(reflectance)) => {
                Self::Evenly(reflectance.on(grid).into_iter().map(over_pi).collect())
            }
            Some(SurfaceColor::Painted(paint)) => Self::Painted(paint),
        }
    }
}

fn over_pi(albedo: f64) -> f32 {
    (albedo * std::f64::consts::FRAC_1_PI) as f32
}

/// Sunlight through drops, over that in front of them.
#[derive(Clone, Copy, Debug)]
struct SunThroughDrops {
    /// On a face across it.
    straight: f64,
    /// On a level one, over that of the sun there.
    scattered: f64,
}

/// What surfaces send to a place, over what they get straight from the sun across them and from all of the sky, where
/// they hide a share `h` of it from the place and from each other and give back `a`.
///
/// Between faces that are lit alike the reflections are the series of (a h)^n. But by reciprocity such surfaces, in the
/// mean of their areas, have straight light of only 1 - h of what comes in to them; in a corner, where h is 1/2, both
/// faces may have all of it: twice the mean.
fn sent_each_other(h: f64, a: f64) -> f64 {
    // Of white that hides all the limit, from surfaces that let a little out.
    let leaving = (1.0 - h * a).max(1.0 - h).max(f64::MIN_POSITIVE);
    h * a / leaving * (2.0 * (1.0 - h)).min(1.0)
}

impl<'a> SurfaceLight<'a> {
    /// The surfaces and drops of a picture, with what drops leave of the sky.
    pub(crate) fn new(request: &RenderRequest<'a>) -> Self {
        let of_sun = Self::of_sun(request);
        let has_shadow = request.effects.drop_shadow.is_on();
        let bounds = request.drops.bounds().filter(|_| has_shadow);
        let terrains = request.surfaces.into_iter().flat_map(Surfaces::terrains);
        Self {
            terrains: terrains.map(|it| it.map(TerrainView::new)).collect(),
            sky: bounds.map(|bounds| SkyUnderDrops::new(of_sun.bricks, bounds, GROUND_M)),
            ..of_sun
        }
    }

    /// The same for places where sunlight alone is asked for.
    pub(crate) fn of_sun(request: &RenderRequest<'a>) -> Self {
        let colors = || request.surfaces.into_iter().flat_map(Surfaces::albedos);
        let mut brightest = vec![0.0; request.wavelengths.len()];
        for color in colors().flatten() {
            let most = match color {
                SurfaceColor::Plain(reflectance) => vec![*reflectance],
                SurfaceColor::Painted(paint) => paint.brightest(),
            };
            for most in most {
                for (brightest, value) in brightest.iter_mut().zip(most.on(&request.wavelengths)) {
                    *brightest = value.max(*brightest);
                }
            }
        }
        let colors = colors().map(|color| Reflected::of(color, &request.wavelengths));
        let has_shadow = request.effects.drop_shadow.is_on();
        Self {
            surfaces: request.surfaces,
            colors: colors.collect(),
            terrains: Vec::new(),
            pixel_rad: request.camera.pixel_angle().0,
            wavelengths: request.wavelengths.centers().collect(),
            brightest,
            sun_direction: request.sun_direction,
            bricks: if has_shadow {
                request.drops.bricks()
            } else {
                &[]
            },
            sky: None,
        }
    }

    /// Whether the ground may have shadows of surfaces, beside that of drops.
    pub(crate) fn has_shadows_of_surfaces(&self) -> bool {
        !self.colors.is_empty()
    }

    /// Whether a surface stands between a place and the sun, or the place turns away from it.
    pub(crate) fn is_shaded(&self, spot: &Spot) -> bool {
        let sun = self.sun_direction;
        let Face { side, normal, .. } = spot.face;
        side.dot(sun) <= 0.0 || normal.dot(sun) <= 0.0 || self.is_met((spot.point, side), sun)
    }

    /// The same of the ground at a point.
    pub(crate) fn is_ground_shaded(&self, point: DVec3) -> bool {
        self.is_met((point, DVec3::Y), self.sun_direction)
    }

    /// Share of sunlight that reaches the ground at a point straight.
    pub(crate) fn sun_on_ground(&self, point: DVec3) -> f64 {
        if self.is_ground_shaded(point) {
            return 0.0;
        }
        (-depth(self.bricks, point, self.sun_direction)).exp()
    }

    /// What reaches the ground at a point.
    pub(crate) fn shade_of_ground(&self, point: DVec3) -> Shade {
        let sun = self.sun_through_drops(self.is_ground_shaded(point), point);
        let free = self.sky_share((point, DVec3::Y), DVec3::Y, None);
        Shade {
            sun: sun.straight + free * sun.scattered,
            sky: free * self.sky_through_drops(point),
        }
    }

    /// Writes what a place at the end of a sight sends to the eye.
    pub(crate) fn radiance(
        &self,
        spot: &Spot,
        (sight, air): (&Sight, Option<&Air>),
        room: &mut SurfaceRoom,
    ) {
        let Face { normal, .. } = spot.face;
        let view = self.sky_view_of_pixel(spot, sight.surface_m, &mut room.sky);
        self.write_unfollowed((spot, view.hidden), (sight, air), &mut room.unfollowed);
        let (share, out) = (view.free, &mut room.light);
        let sunlit = {
            let sun = self.sun_through_drops(self.is_shaded(spot), spot.point);
            let cos_sun = normal.dot(self.sun_direction).max(0.0);
            let on_face = share * self.sun_direction.y.max(0.0) * 0.5 * (1.0 + normal.y);
            cos_sun * sun.straight + on_face * sun.scattered
        };
        let Some(air) = air else {
            out.fill(sunlit as f32);
            return self.reflect(&spot.face, out);
        };
        let to_eye = air.to_eye(
            air.ray(sight.ray.origin, sight.ray.direction),
            sight.surface_m,
        );
        let to_sun = air.to_sun(spot.point);
        out.fill(0.0);
        if let (Some(to_sun), true) = (&to_sun, sunlit > 0.0) {
            air.transmit(&both_ways(to_sun, &to_eye), out);
            for value in out.iter_mut() {
                *value *= sunlit as f32;
            }
        }
        if let Some(diffuse) = air.diffuse() {
            let mut transmitted = vec![0.0; out.len()];
            // What the sun adds to the light of level ground.
            if let Some(to_sun) = &to_sun {
                air.transmit(to_sun, &mut transmitted);
            }
            let face = FaceOfAir {
                point: spot.point,
                normal,
                sunlight: &transmitted,
            };
            let share = share * self.sky_through_drops(spot.point);
            let light = diffuse.on_face(&face, (share, air.ground_albedo()));
            air.transmit(&to_eye, &mut transmitted);
            for ((sum, light), transmitted) in out.iter_mut().zip(light).zip(&transmitted) {
                *sum += light * transmitted;
            }
        }
        self.reflect(&spot.face, out);
    }

    /// Writes what surfaces that hide a share of what lights a place may send to the eye by way of it.
    fn write_unfollowed(
        &self,
        (spot, hidden): (&Spot, f64),
        (sight, air): (&Sight, Option<&Air>),
        out: &mut [f32],
    ) {
        out.fill(0.0);
        if hidden <= 0.0 {
            return;
        }
        let sun = self.sun_through_drops(false, spot.point);
        let sunlit = (sun.straight + sun.scattered * self.sun_direction.y.max(0.0)) as f32;
        if let Some(air) = air {
            if let Some(to_sun) = air.to_sun(spot.point) {
                air.transmit(&to_sun, out);
            }
            let skylit = self.sky_through_drops(spot.point) as f32;
            let of_sky = air.diffuse().map(|diffuse| diffuse.on_level(spot.point));
            for (index, irradiance) in out.iter_mut().enumerate() {
                let of_sky = of_sky.as_ref().map_or(0.0, |light| skylit * light[index]);
                *irradiance = sunlit * *irradiance + of_sky;
            }
        } else {
            out.fill(sunlit);
        }
        for (light, brightest) in out.iter_mut().zip(&self.brightest) {
            *light *= sent_each_other(hidden, *brightest) as f32;
        }
        if let Some(air) = air {
            let Ray { origin, direction } = sight.ray;
            let to_eye = air.to_eye(air.ray(origin, direction), sight.surface_m);
            let mut transmitted = vec![0.0; out.len()];
            air.transmit(&to_eye, &mut transmitted);
            for (light, transmitted) in out.iter_mut().zip(transmitted) {
                *light *= transmitted;
            }
        }
        self.reflect(&spot.face, out);
    }

    fn reflect(&self, face: &Face, light: &mut [f32]) {
        match &self.colors[face.solid] {
            Reflected::Evenly(reflected) => {
                for (light, reflected) in light.iter_mut().zip(reflected) {
                    *light *= reflected;
                }
            }
            Reflected::Painted(paint) => {
                let mix = paint.at(face.painted);
                for (light, wavelength) in light.iter_mut().zip(&self.wavelengths) {
                    *light *= over_pi(mix.at(*wavelength));
                }
            }
        }
    }

    /// Sunlight at a point that a surface shades or not.
    fn sun_through_drops(&self, is_shaded: bool, point: DVec3) -> SunThroughDrops {
        let depth = depth(self.bricks, point, self.sun_direction);
        let straight = (-depth).exp();
        let sine = self.sun_direction.y;
        SunThroughDrops {
            straight: if is_shaded { 0.0 } else { straight },
            scattered: if depth > 0.0 && sine > 0.0 {
                sun_under(depth, sine) - straight
            } else {
                0.0
            },
        }
    }

    /// Share of the sky's light that drops leave to a place.
    fn sky_through_drops(&self, point: DVec3) -> f64 {
        self.sky.as_ref().map_or(1.0, |sky| sky.at(point))
    }

    /// What a place sees around it, which is that of a place before if one is near and alike.
    fn sky_view_of_pixel(
        &self,
        spot: &Spot,
        surface_m: f64,
        known: &mut VecDeque<(Spot, SkyView)>,
    ) -> SkyView {
        let Face { normal, solid, .. } = spot.face;
        let seen = known.iter().find(|(Spot { point, face }, _)| {
            // Waves send the rays of a pixel to places that lie as far away and wide apart.
            let is_near = point.distance(spot.point) <= NEAR * surface_m;
            is_near && face.solid == solid && face.normal.dot(normal) >= ALIKE
        });
        if let Some((_, view)) = seen {
            return *view;
        }
        let view = self.sky_view(spot, surface_m);
        known.truncate(N_KNOWN - 1);
        known.push_front((*spot, view));
        view
    }

    /// What a place so far from the eye sees around it.
    fn sky_view(&self, spot: &Spot, surface_m: f64) -> SkyView {
        let Face {
            side,
            normal,
            solid,
            ..
        } = spot.face;
        let place = (spot.point, side);
        // Where several pixels lie in a cell, its nodes look for them all.
        let terrain = self.terrains[solid].as_ref();
        let are_wide = |it: &&TerrainView| {
            it.field.spacing_m() > PIXELS_OF_CELL * self.pixel_rad * surface_m && side.y > 0.0
        };
        let known = (terrain.filter(are_wide))
            .map(|it| it.at(spot.point, |node| self.view_of_node(it.field, node)));
        let horizons = known.map(|it| (solid, it.horizons));
        let free = self.sky_share(place, normal, horizons);
        let below = known.map_or_else(
            || self.share_met_below(place, normal),
            |it| f64::from(it.below),
        );
        let above = 0.5 * (1.0 + normal.y);
        SkyView {
            free,
            hidden: (1.0 - free) * above + below * (1.0 - above),
        }
    }

    /// What a node of a terrain sees around it.
    fn view_of_node(&self, field: &HeightField, node: DVec3) -> PlaceView {
        let origin = node + LIFT_M * DVec3::Y;
        let mut horizons = [0.0; N_AZIMUTHS];
        for Azimuth { index, along } in azimuths() {
            horizons[index] = field.horizon(origin, along, 0.0) as f32;
        }
        let normal = field.smooth_normal(node);
        PlaceView {
            horizons,
            below: self.share_met_below((node, normal), normal) as f32,
        }
    }

    /// Share of what lies below the horizon of a place that surfaces are.
    fn share_met_below(&self, place: (DVec3, DVec3), normal: DVec3) -> f64 {
        let (_, side) = place;
        share_met_below(normal, |towards| {
            side.dot(towards) > 0.0 && self.is_met(place, towards)
        })
    }

    /// Share of the sky that surfaces leave to a face at a point with a side; the horizons that one solid makes may
    /// be known.
    fn sky_share(
        &self,
        place: (DVec3, DVec3),
        normal: DVec3,
        known: Option<(usize, [f32; N_AZIMUTHS])>,
    ) -> f64 {
        let Some(surfaces) = self.surfaces else {
            return 1.0;
        };
        let (point, side) = place;
        let origin = point + LIFT_M * side;
        free_share((side, normal), |Azimuth { index, along }, covered| {
            let known = known.map(|(solid, horizons)| (solid, f64::from(horizons[index])));
            surfaces.cover((origin, along), known, covered);
        })
    }

    /// Whether any surface is met from a side of a point in a direction.
    fn is_met(&self, (point, side): (DVec3, DVec3), direction: DVec3) -> bool {
        let origin = point + LIFT_M * side;
        self.surfaces
            .is_some_and(|surfaces| surfaces.are_met(&Ray { origin, direction }))
    }
}
