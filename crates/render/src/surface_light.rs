//! Light of surfaces with an albedo, and what shades them and the ground.
//!
//! L = A/pi T_drops T_eye (E_sun T_sun [(n . w) S exp(-tau) + V w_y (1 + n_y)/2 (T(tau) - exp(-tau))]
//!     + V U (E(n) - D(n)) + (1 - W) D(n) + E_s)
//!
//! `A` albedo (`paint` where it is by place), `n` normal of the smooth surface, of a flat triangle its own, `w` towards
//! the sun, `T_eye` and `T_sun` what air lets pass, `S` 1 where no surface stands before the sun, `tau` of the drops before
//! it (Q = 1: what diffraction turns aside falls next to it), `T` what these
//! let pass with what they scatter downwards, `U` the same of skylight (`under_drops`),
//! `E(n)` irradiance of all diffuse light on a tilted face, as sky and ground send it to an open place of this
//! height (`air_diffuse`), `D(n) = A_g/2 (1 - n_y) E_g` what of it the ground sends, `E_g` light on the level ground,
//! `W` share of what lies below the horizon that surfaces are, `E_s` what these send, told with its error (`sent_light`),
//! `V` share of the sky that surfaces leave (`sky_view`), on terrain whose cells are wider than pixels as its nodes see
//! it (`terrain_view`).
//!
//! Where the smooth surface and its triangle disagree about the sun, S is 0: none lights a triangle that it stands behind
//! (V97, section 5.3). So the edge of night follows triangles, and is that of the smooth surface to within the angle
//! between their normals; wherever the triangle is lit it has n . w, without a hole.
//! [V97] E. Veach, Robust Monte Carlo Methods for Light Transport Simulation, dissertation, Stanford (1997).
//!
//! The sun is a point. Left out: the light that clouds send down beside their shadow,
//! and the shadow of surfaces on air and drops.

mod ground_light;

use std::collections::VecDeque;

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::CoveredSlopes;
use niji_geometry::HeightField;
use niji_geometry::Ray;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::air::Air;
use crate::air_diffuse::FaceOfAir;
use crate::ground_view::GroundView;
use crate::lit_drops::depth;
use crate::mesh_view::MeshView;
use crate::node_views::Seen;
use crate::node_views::View;
use crate::paint::Paint;
use crate::paint::SurfaceColor;
use crate::request::RenderRequest;
use crate::sent_light::LightAround;
use crate::sent_light::Sender;
use crate::sent_light::SenderColors;
use crate::sent_light::Senders;
use crate::sent_light::scattered;
use crate::sky_view::Azimuth;
use crate::sky_view::Hidden;
use crate::sky_view::Look;
use crate::sky_view::N_AZIMUTHS;
use crate::sky_view::azimuths;
use crate::sky_view::free_share;
use crate::sky_view::share_met_below;
use crate::surfaces::Face;
use crate::surfaces::Sight;
use crate::surfaces::SolidShape;
use crate::surfaces::Surfaces;
use crate::terrain_view::PlaceView;
use crate::terrain_view::TerrainView;
use crate::under_drops::SkyUnderDrops;
use crate::under_drops::sun_under;
pub(crate) use ground_light::Ground;

/// How far from a surface rays towards sun and sky begin, so that it does not shade itself (m).
const LIFT_M: f64 = 1e-5;

/// Height of the ground (m).
const GROUND_M: f64 = 0.0;

/// Within a pixel a place sees the sky as one before, of so many, that is no farther from it than this part of the
/// distance from the eye, and whose normal has at least this cosine to its own.
const N_KNOWN: usize = 8;
const NEAR: f64 = 0.02;
const ALIKE: f64 = 0.999;

/// What lies no deeper under the ground is on it (m).
const GROUND_LAYER_M: f64 = 0.01;

/// Which solid is terrain, and tangents of the horizon that it makes, by azimuth.
type Horizons = (usize, [f32; N_AZIMUTHS]);

/// Cells of terrain that are as many pixels wide have what their nodes see.
const LEAST_PIXELS_OF_CELL: f64 = 2.0;

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

/// What nodes of a solid know of what is around it.
enum SolidView<'a> {
    Mesh(MeshView<'a>),
    Terrain(TerrainView<'a>),
}

impl<'a> SolidView<'a> {
    fn new(shape: &'a SolidShape) -> Self {
        match shape {
            SolidShape::Mesh(mesh) => Self::Mesh(MeshView::new(mesh.mesh())),
            SolidShape::Heights(field) => Self::Terrain(TerrainView::new(field)),
        }
    }
}

/// Room to work in.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceRoom {
    /// What a place sends to the eye for unit sun irradiance, but for drops between [1/sr].
    pub(crate) light: Vec<f32>,
    /// The same of what surfaces may send to it and is not in its light.
    pub(crate) lacking: Vec<f32>,
    around: LightAround,
    /// Places of the pixel whose view of the sky was looked at, the last one first, and what that was.
    views: VecDeque<(Spot, View)>,
}

impl SurfaceRoom {
    /// Darkness at so many wavelengths.
    pub(crate) fn new(n_wavelengths: usize) -> Self {
        Self {
            light: vec![0.0; n_wavelengths],
            lacking: vec![0.0; n_wavelengths],
            around: LightAround::new(n_wavelengths),
            views: VecDeque::new(),
        }
    }

    /// Forget the pixel before: no pixel depends on another.
    pub(crate) fn clear(&mut self) {
        self.views.clear();
    }
}

/// What all lit surfaces of a picture share.
pub(crate) struct SurfaceLight<'a> {
    surfaces: Option<&'a Surfaces>,
    /// What the solids give back.
    colors: Vec<Reflected<'a>>,
    wavelengths: Vec<Nanometers>,
    /// What they see around them, and the ground.
    views: Vec<SolidView<'a>>,
    ground: GroundView,
    /// What a pixel is wide.
    pixel_rad: f64,
    /// What of them gives back light that they send each other.
    sender_colors: SenderColors,
    /// Whether level ground hides what lies below it.
    has_ground: bool,
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

/// Takes from light what air takes on its way to the eye from a distance along a ray.
fn dim(
    (ray, distance_m): (&Ray, f64),
    (air, transmitted): (&Air, &mut [f32]),
    lights: [&mut [f32]; 2],
) {
    let to_eye = air.to_eye(air.ray(ray.origin, ray.direction), distance_m);
    air.transmit(&to_eye, transmitted);
    for light in lights {
        for (value, transmitted) in light.iter_mut().zip(&*transmitted) {
            *value *= *transmitted;
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

impl<'a> SurfaceLight<'a> {
    /// The surfaces and drops of a picture, with what drops leave of the sky.
    pub(crate) fn new(request: &RenderRequest<'a>) -> Self {
        let of_sun = Self::of_sun(request);
        let has_shadow = request.effects.drop_shadow.is_on();
        let bounds = request.drops.bounds().filter(|_| has_shadow);
        let shapes = request.surfaces.into_iter().flat_map(Surfaces::shapes);
        let colors = request.surfaces.into_iter().flat_map(Surfaces::albedos);
        Self {
            views: shapes.map(SolidView::new).collect(),
            sender_colors: SenderColors::of(colors, &request.wavelengths),
            sky: bounds.map(|bounds| SkyUnderDrops::new(of_sun.bricks, bounds, GROUND_M)),
            ..of_sun
        }
    }

    /// The same for places where sunlight alone is asked for.
    pub(crate) fn of_sun(request: &RenderRequest<'a>) -> Self {
        let colors = request.surfaces.into_iter().flat_map(Surfaces::albedos);
        let colors = colors.map(|color| Reflected::of(color, &request.wavelengths));
        let has_shadow = request.effects.drop_shadow.is_on();
        Self {
            surfaces: request.surfaces,
            colors: colors.collect(),
            views: Vec::new(),
            ground: GroundView::new(),
            pixel_rad: request.camera.pixel_angle().0,
            wavelengths: request.wavelengths.centers().collect(),
            sender_colors: SenderColors::default(),
            has_ground: request.air.is_some(),
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

    /// Adds what surfaces send to a place with a view to the light on it, and writes what that may lack; takes the light around
    /// the place, to which drops leave sunlight.
    fn add_sent(
        &self,
        (view, through): (&View, SunThroughDrops),
        around: &mut LightAround,
        [light, lacking]: [&mut [f32]; 2],
    ) {
        let sine = self.sun_direction.y.max(0.0);
        around.spread([through.straight, through.scattered], sine);
        around.add_sent((&view.senders, &self.sender_colors), light, lacking);
    }

    /// Writes what a place at the end of a sight sends to the eye, and what that may lack.
    pub(crate) fn radiance(
        &self,
        spot: &Spot,
        (sight, air): (&Sight, Option<&Air>),
        room: &mut SurfaceRoom,
    ) {
        let SurfaceRoom {
            light,
            lacking,
            around,
            views,
        } = room;
        let Face { normal, .. } = spot.face;
        let view = self.view_in_pixel(spot, sight, views);
        let through = self.sun_through_drops(spot.point);
        let skylit = self.sky_through_drops(spot.point);
        around.look((spot.point, skylit), air);
        let sun = &around.sun;
        // What the sun adds to the light of level ground.
        let sine = self.sun_direction.y.max(0.0);
        let cos_sun = self.cos_sun(spot);
        let scattered = view.free * sine * 0.5 * (1.0 + normal.y) * through.scattered;
        let of_sun = (cos_sun * through.straight + scattered) as f32;
        for (light, sun) in light.iter_mut().zip(sun) {
            *light = of_sun * sun;
        }
        if let Some((air, diffuse)) = air.and_then(|air| Some((air, air.diffuse()?))) {
            let face = FaceOfAir {
                point: spot.point,
                normal,
                sunlight: sun,
            };
            let seen = [view.free * skylit, 1.0 - view.below];
            let of_air = diffuse.on_face(&face, (seen, air.ground_albedo()));
            for (light, of_air) in light.iter_mut().zip(of_air) {
                *light += of_air;
            }
        }
        self.add_sent((view, through), around, [light, lacking]);
        if let Some(air) = air {
            let way = (&sight.ray, sight.surface_m);
            dim(way, (air, &mut around.sun), [light, lacking]);
        }
        self.reflect(&spot.face, light);
        self.reflect(&spot.face, lacking);
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

    /// Sunlight at a point that no surface shades.
    fn sun_through_drops(&self, point: DVec3) -> SunThroughDrops {
        let depth = depth(self.bricks, point, self.sun_direction);
        let straight = (-depth).exp();
        let sine = self.sun_direction.y;
        SunThroughDrops {
            straight,
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
    fn view_in_pixel<'v>(
        &self,
        spot: &Spot,
        sight: &Sight,
        known: &'v mut VecDeque<(Spot, View)>,
    ) -> &'v View {
        let Face { normal, solid, .. } = spot.face;
        let seen = known.iter().position(|(Spot { point, face }, _)| {
            // Waves send the rays of a pixel to places that lie as far away and wide apart.
            let is_near = point.distance(spot.point) <= NEAR * sight.surface_m;
            is_near && face.solid == solid && face.normal.dot(normal) >= ALIKE
        });
        let index = seen.unwrap_or_else(|| {
            let view = self.view(spot, sight);
            known.truncate(N_KNOWN - 1);
            known.push_front((*spot, view));
            0
        });
        &known[index].1
    }

    /// What a place at the end of a sight sees around it.
    fn view(&self, spot: &Spot, sight: &Sight) -> View {
        let Face {
            side,
            normal,
            solid,
            ..
        } = spot.face;
        let place = (spot.point, side);
        let own = || self.look_around(place, (normal, None));
        let pixel_m = self.pixel_rad * sight.surface_m;
        let seen = Seen {
            pixel_m,
            cosine: side.dot(sight.ray.direction).abs(),
        };
        match &self.views[solid] {
            SolidView::Mesh(mesh) => {
                let known = mesh.at((spot.point, &spot.face), seen, |node| {
                    self.look_around((node.point, node.normal), (node.smooth_normal, None))
                });
                known.unwrap_or_else(own)
            }
            // Where several pixels lie in a cell, its nodes look for them all.
            SolidView::Terrain(terrain)
                if terrain.field.spacing_m() > LEAST_PIXELS_OF_CELL * pixel_m && side.y > 0.0 =>
            {
                let known = terrain.at(spot.point, |node| {
                    self.view_of_node((solid, terrain.field), node)
                });
                let horizons = Some((solid, known.horizons));
                View {
                    free: self.sky_share(place, (normal, horizons), |_| {}),
                    below: f64::from(known.below),
                    senders: known.senders,
                }
            }
            SolidView::Terrain(_) => own(),
        }
    }

    /// What a node of a terrain sees around it.
    fn view_of_node(&self, (solid, field): (usize, &HeightField), node: DVec3) -> PlaceView {
        let origin = node + LIFT_M * DVec3::Y;
        let mut horizons = [0.0; N_AZIMUTHS];
        for Azimuth { index, along } in azimuths() {
            horizons[index] = field.horizon(origin, along, 0.0) as f32;
        }
        let normal = field.smooth_normal(node);
        let view = self.look_around((node, normal), (normal, Some((solid, horizons))));
        PlaceView {
            horizons,
            below: view.below as f32,
            senders: view.senders,
        }
    }

    /// What a face at a point with a side sees around it; the horizons that one solid makes may be known.
    fn look_around(
        &self,
        place: (DVec3, DVec3),
        (normal, known): (DVec3, Option<Horizons>),
    ) -> View {
        let mut senders = Senders::default();
        let free = self.sky_share(place, (normal, known), |hidden| {
            for look in hidden.looks() {
                self.look_at(place, look, &mut senders);
            }
        });
        let (_, side) = place;
        let below = share_met_below(normal, |look| {
            side.dot(look.towards) > 0.0 && self.look_at(place, look, &mut senders)
        });
        View {
            free,
            below,
            senders,
        }
    }

    /// Whether a surface is met there, which sends light.
    fn look_at(&self, place: (DVec3, DVec3), look: Look, senders: &mut Senders) -> bool {
        let Some(sight) = self.sight(place, look.towards) else {
            return false;
        };
        let Some(spot) = Spot::of(&sight) else {
            return true;
        };
        let mut sender = Sender::of(&spot.face, look, self.cos_sun(&spot));
        let Face { side, normal, .. } = spot.face;
        let towards = scattered(normal, look.number);
        let met = (side.dot(towards) > 0.0)
            .then(|| self.sight((spot.point, side), towards))
            .flatten();
        if met.is_some() {
            sender = sender.less(look, towards);
        }
        senders.add(&sender, 1.0);
        if let Some(other) = met.as_ref().and_then(Spot::of) {
            let sender = Sender::of(&other.face, look, self.cos_sun(&other));
            senders.add(&sender.by(&spot.face), 1.0);
        }
        true
    }

    /// Where a ray from a side of a point ends at a surface.
    fn sight(&self, (point, side): (DVec3, DVec3), direction: DVec3) -> Option<Sight> {
        let origin = point + LIFT_M * side;
        let sight = self.surfaces?.sight(Ray { origin, direction });
        let end_m = sight.surface_m;
        if end_m.is_infinite() {
            return None;
        }
        let is_low = direction.y < 0.0 && sight.ray.at(end_m).y < GROUND_M - GROUND_LAYER_M;
        (!(self.has_ground && is_low)).then_some(sight)
    }

    /// Cosine of the sunlight at a place; 0 in the shade of surfaces.
    fn cos_sun(&self, spot: &Spot) -> f64 {
        if self.is_shaded(spot) {
            0.0
        } else {
            spot.face.normal.dot(self.sun_direction)
        }
    }

    /// Share of the sky that surfaces leave to a face at a point with a side, where `hide` is told of the rest; the
    /// horizons that one solid makes may be known.
    fn sky_share(
        &self,
        place: (DVec3, DVec3),
        (normal, known): (DVec3, Option<Horizons>),
        hide: impl FnMut(&Hidden),
    ) -> f64 {
        let Some(surfaces) = self.surfaces else {
            return 1.0;
        };
        let (point, side) = place;
        let origin = point + LIFT_M * side;
        let cover = |Azimuth { index, along }, covered: &mut CoveredSlopes| {
            let known = known.map(|(solid, horizons)| (solid, f64::from(horizons[index])));
            surfaces.cover((origin, along), known, covered);
        };
        free_share((side, normal), cover, hide)
    }

    /// Whether any surface is met from a side of a point in a direction.
    fn is_met(&self, (point, side): (DVec3, DVec3), direction: DVec3) -> bool {
        let origin = point + LIFT_M * side;
        self.surfaces
            .is_some_and(|surfaces| surfaces.are_met(&Ray { origin, direction }))
    }
}
