//! The light of one view ray.
//!
//! L(lambda) = E_sun sum_b W_b t_b(theta, lambda) T_air + L_air + T_drops L_beyond + (1 - T_drops) S
//!
//! `W_b` light of drops in size bin b [-], `t_b` row of the scattering table at the ray's angle and
//! flattening [1/sr], `T_air` what air on both paths lets pass, `L_air` light of the air from the eye
//! to the far side of the drops, `L_beyond` sky and ground, `T_drops = exp(-tau)` what the drops let
//! pass without diffraction, `S` mean of the surroundings.

mod ray_end;

use niji_geometry::Ray;

use crate::air_glow::Glow;
use crate::air_glow::GlowNodes;
use crate::air_glow::GlowRange;
use crate::air_glow::GlowRay;
use crate::air_slabs::AirSlabs;
use crate::air_slabs::AirWay;
use crate::angle_axis::RayPlace;
use crate::deposits::Deposits;
use crate::drop_orders::DiffractionRoom;
use crate::error_parts::RayErrors;
use crate::flattening::axis_squares;
use crate::frame::Frame;
use crate::march::Walk;
use crate::moved_rows::MovedLight;
use crate::moved_rows::MovedPlace;
use crate::moved_rows::MovedStencil;
use crate::polarized_rows::PolarizedRoom;
use crate::ray_settings::RaySettings;
use crate::ray_settings::RayThroughDrops;
use crate::ray_sums::RaySums;
use crate::reflection::ReflectionRoom;
use crate::scattering_angle::scattering_angle_rad;
use crate::scattering_rows::RowStencil;
use crate::scattering_rows::ScatteringRows;
use crate::scattering_rows::SunlitLuminance;
use crate::seen_water::SeenWater;
use crate::seen_water::WaterRoom;
use crate::size_axes::SizeAxes;
use crate::spectra::add_product;
use crate::spectra::multiply;
use crate::surface_light::Shade;
use crate::surface_light::SurfaceRoom;
use crate::surfaces::Sight;
use crate::surround::skylit_radiance;

/// Spectra and figures of a ray, and room to work in.
#[derive(Clone, Debug)]
pub(crate) struct RayLight {
    /// Light of the bows [W m^-2 sr^-1 nm^-1].
    pub(crate) bow: Vec<f32>,
    /// Light that drops scattered more than once; empty where it is not wanted.
    pub(crate) multiple: Vec<f32>,
    /// Light of the air in front.
    pub(crate) inscatter: Vec<f32>,
    /// Sky, air and ground behind the drops, dimmed.
    pub(crate) sky: Vec<f32>,
    /// Light of the surroundings that the drops scatter.
    pub(crate) skylit: Vec<f32>,
    /// The lit surface that ends the ray, dimmed; empty where none is lit.
    pub(crate) lit_surface: Vec<f32>,
    /// Estimated relative error of the light of the air in front, of the drops between it and the eye.
    pub(crate) front_error: f64,
    /// Whether there is any light of the air in front or from behind.
    pub(crate) glows: bool,
    /// Whether the ray looks at the primary side of the split.
    pub(crate) is_primary: bool,
    /// exp(-tau) of the drops, without diffraction, whether they dim what is behind them or not.
    pub(crate) transmittance: f64,
    /// Light of the drops [-], the sums over it of its distance and optical depth to the sun.
    pub(crate) light: f64,
    pub(crate) light_m: f64,
    pub(crate) light_tau_sun: f64,
    /// Luminance of the bows as if there were no air [cd/m²].
    pub(crate) sunlit_cd_m2: f64,
    /// Estimated errors of luminance [cd/m²], those of the bows as if there were no air.
    pub(crate) errors: RayErrors,
    scratch: Scratch,
}

/// Room to work in.
#[derive(Clone, Debug)]
struct Scratch {
    diffraction: Option<DiffractionRoom>,
    /// Of a ray that may meet water.
    water: Option<Box<WaterRoom>>,
    /// Of a ray that comes from water.
    in_water: Option<PolarizedRoom>,
    reflection: Option<ReflectionRoom>,
    deposits: Deposits,
    stencil: RowStencil,
    moved: MovedStencil,
    slab_ends_m: Vec<f64>,
    slab: Vec<f32>,
    transmitted: Vec<f32>,
    nodes: GlowNodes,
    glow: Glow,
    surface: SurfaceRoom,
}

impl RayLight {
    /// Darkness.
    pub(crate) fn new(frame: &Frame) -> Self {
        let mut light = Self::beyond_water(frame);
        light.scratch.in_water = None;
        light.scratch.water = (frame.water.as_ref()).map(|_| Box::new(WaterRoom::new(frame)));
        light
    }

    /// Darkness on a ray that comes from water.
    pub(crate) fn beyond_water(frame: &Frame) -> Self {
        let dark = vec![0.0_f32; frame.irradiance.len()];
        let no_sizes = SizeAxes::new(&[1.0], &[0.0]);
        let axes = frame.rows.as_ref().map_or(&no_sizes, ScatteringRows::axes);
        Self {
            bow: dark.clone(),
            multiple: frame.multiple.as_ref().map_or(Vec::new(), |_| dark.clone()),
            inscatter: dark.clone(),
            sky: dark.clone(),
            skylit: dark.clone(),
            lit_surface: frame.lit.as_ref().map_or(Vec::new(), |_| dark.clone()),
            front_error: 0.0,
            glows: false,
            is_primary: false,
            transmittance: 1.0,
            light: 0.0,
            light_m: 0.0,
            light_tau_sun: 0.0,
            sunlit_cd_m2: 0.0,
            errors: RayErrors::default(),
            scratch: Scratch {
                diffraction: frame
                    .diffraction
                    .as_ref()
                    .map(|diffraction| diffraction.room(dark.len())),
                water: None,
                in_water: (frame.water.as_ref()).and_then(|water| water.room(dark.len())),
                reflection: (frame.reflection.as_ref()).map(|light| light.room(dark.len())),
                deposits: Deposits::new(axes),
                stencil: RowStencil::default(),
                moved: MovedStencil::default(),
                slab_ends_m: Vec::new(),
                slab: dark.clone(),
                transmitted: dark.clone(),
                nodes: GlowNodes::default(),
                glow: Glow::dark(dark.len(), frame.brightest),
                surface: SurfaceRoom::new(dark.len()),
            },
        }
    }

    /// Light of the bows in the sun that water mirrors; empty where it is not wanted.
    pub(crate) fn reflected(&self) -> &[f32] {
        let light = self.scratch.reflection.as_ref().map(|room| &room.light[..]);
        light.unwrap_or_default()
    }

    /// What is no light of the drops in the sun: that of the air in front, of the sky, of the surroundings by the drops,
    /// of a lit surface, and by way of water.
    pub(crate) fn beside(&self) -> [&[f32]; 5] {
        [
            &self.inscatter,
            &self.sky,
            &self.skylit,
            &self.lit_surface,
            self.water(),
        ]
    }

    /// Light by way of water that is seen; empty where there is none.
    pub(crate) fn water(&self) -> &[f32] {
        let light = self.scratch.water.as_ref().map(|room| &room.light[..]);
        light.unwrap_or_default()
    }

    /// Room for the light of water that ends the ray.
    pub(crate) fn water_room(&mut self) -> &mut Option<Box<WaterRoom>> {
        &mut self.scratch.water
    }

    /// Room for the bows in the water that it comes from.
    pub(crate) fn bows_room(&mut self) -> Option<&mut PolarizedRoom> {
        self.scratch.in_water.as_mut()
    }

    /// Forget the pixel before.
    pub(crate) fn begin_pixel(&mut self) {
        self.scratch.surface.clear();
        if let Some(room) = &mut self.scratch.water {
            room.begin_pixel();
        }
    }

    fn clear(&mut self) {
        self.bow.fill(0.0);
        self.multiple.fill(0.0);
        if let Some(reflection) = &mut self.scratch.reflection {
            reflection.light.fill(0.0);
        }
        // Without a glow these stay dark.
        if self.glows {
            self.inscatter.fill(0.0);
            self.sky.fill(0.0);
            self.skylit.fill(0.0);
            self.lit_surface.fill(0.0);
            self.front_error = 0.0;
            self.glows = false;
        }
        if let Some(room) = &mut self.scratch.water {
            room.light.fill(0.0);
        }
        self.scratch.slab_ends_m.clear();
        self.scratch.nodes.probes.clear();
        self.transmittance = 1.0;
        (self.light, self.light_m, self.light_tau_sun) = (0.0, 0.0, 0.0);
        self.sunlit_cd_m2 = 0.0;
        self.errors = RayErrors::default();
    }
}

/// Where a ray meets the ground, and how steeply.
#[derive(Clone, Copy)]
pub(crate) struct OnGround {
    pub(crate) distance_m: f64,
    /// Of the angle between the ray and the ground.
    pub(crate) sine: f64,
}

impl Frame<'_> {
    /// Distance along a ray to the ground (m).
    pub(crate) fn ground_m(&self, ray: &Ray) -> Option<f64> {
        let air = self.air.as_ref()?;
        let air_ray = air.ray(ray.origin, ray.direction);
        air.planet()
            .distance_to_ground(air_ray.height_m, air_ray.cos_zenith)
    }

    /// Where a ray meets ground on which the shadow of drops may lie.
    pub(crate) fn shadow_of_drops(&self, ray: &Ray) -> Option<OnGround> {
        self.lit.as_ref()?;
        let distance_m = self.ground_m(ray)?;
        let planet = self.air.as_ref()?.planet();
        Some(OnGround {
            distance_m,
            sine: -planet.cos_zenith(ray.at(distance_m), ray.direction),
        })
    }

    /// Where on its way to the surface a ray may meet drops.
    pub(crate) fn range_m(&self, sight: &Sight) -> Option<(f64, f64)> {
        let (enter_m, leave_m) = self.bounds?.intersect(&sight.ray)?;
        (enter_m < sight.surface_m).then_some((enter_m, leave_m.min(sight.surface_m)))
    }

    /// Whether anything but drops sends light.
    pub(crate) fn glows_without_drops(&self) -> bool {
        self.glows.1
    }

    /// Whether the end of a sight is lit.
    pub(crate) fn lights(&self, sight: &Sight) -> bool {
        self.lit.is_some() && sight.face.is_some()
    }

    /// How rays are followed at the level of the picture, in pixels that span an angle.
    pub(crate) fn settings(&self, width_rad: f64) -> RaySettings<'_> {
        RaySettings {
            march: &self.march,
            air: self.air.as_ref(),
            glow: &self.glow,
            width_rad,
        }
    }

    /// Follow a ray, which may meet drops between two distances ([`Frame::range_m`]).
    pub(crate) fn trace(
        &self,
        (sight, drops_m): (&Sight, Option<(f64, f64)>),
        settings: RaySettings,
        out: &mut RayLight,
    ) {
        out.clear();
        let ray = &sight.ray;
        let theta_rad = scattering_angle_rad(ray.direction, self.sun_direction);
        out.is_primary = self.sides.is_primary(theta_rad);
        let glow_range = GlowRange {
            drops_m,
            surface_m: self.air_ends_m(sight),
            in_front: self.glows.0,
            beyond: self.glows.1,
            lost: self.surround.is_some(),
        };
        let glowing = self.glows.1 || (self.glows.0 && drops_m.is_some());
        if let (Some(air), true) = (settings.air, glowing) {
            settings
                .glow
                .lay_out(air, ray, &glow_range, &mut out.scratch.nodes);
        }
        let way = drops_m.map(|range_m| RayThroughDrops {
            ray,
            range_m,
            settings,
        });
        if let Some(way) = way {
            self.through_drops(way, theta_rad, out);
        }
        if let (Some(reflection), Some(room), Some(way)) =
            (&self.reflection, &mut out.scratch.reflection, way)
        {
            let sums = reflection.add(self, way, room);
            out.errors.add(1.0, 1.0, &sums.errors);
        }
        if let (Some(light), Some(way)) = (&self.multiple, way) {
            if let (Some(diffraction), Some(room), true) = (
                &self.diffraction,
                &mut out.scratch.diffraction,
                self.sides.wants(theta_rad),
            ) {
                let place = RayPlace {
                    theta_rad,
                    width_rad: settings.width_rad,
                };
                let most = diffraction.most_changed(&place, out.light);
                if let Some(unseen) = most.filter(|it| *it <= self.unseen_cd_m2) {
                    out.errors.orders = unseen;
                } else {
                    self.diffracted(diffraction, way, &place, room);
                    out.multiple.copy_from_slice(&room.light);
                }
            }
            let orders = light.add(
                ray.direction,
                self.left_behind(out),
                &self.irradiance,
                &mut out.multiple,
            );
            out.errors.orders = orders.hypot(out.errors.orders);
        }
        if let (Some(air), true) = (settings.air, glowing) {
            let ground_m = out.scratch.nodes.ground_m();
            let ground = self.lit.as_ref().zip(ground_m);
            let ground =
                ground.map(|(lit, ground_m)| (lit, lit.ground(ray, ground_m, air.planet())));
            let glow_ray = GlowRay {
                air,
                rules: settings.glow,
                ray,
                theta_rad,
                dimmed_by_drops: self.drops_dim.then_some(out.transmittance),
                ground_shade: ground
                    .as_ref()
                    .map_or(Shade::NONE, |(lit, ground)| lit.shade_of_ground(ground)),
            };
            self.add_glow(&glow_ray, out);
            if let Some((lit, ground)) = &ground {
                self.add_sent_to_ground((lit, ground), (ray, air), out);
            }
        }
        if let (Some(surround), Some(way)) = (&self.surround, way) {
            self.add_surround(surround, way, out);
        }
        if let Some(lit) = &self.lit {
            self.add_surface(lit, (sight, settings.air), out);
        }
        if let (Some(water), Some(foot)) = (&self.water, &sight.foot) {
            self.add_water(water, (sight, foot), settings, out);
        }
    }

    fn through_drops(&self, way: RayThroughDrops, theta_rad: f64, out: &mut RayLight) {
        let RayThroughDrops {
            ray,
            range_m,
            settings,
        } = way;
        let width_rad = settings.width_rad;
        let rows = self.rows.as_ref().filter(|_| self.sides.wants(theta_rad));
        // Bows in water have their places.
        let natural = rows.filter(|_| out.scratch.in_water.is_none());
        if let Some(rows) = natural {
            let place = RayPlace {
                theta_rad,
                width_rad,
            };
            rows.stencil(&place, &mut out.scratch.stencil);
        }
        if let Some(moved) = self.moved.as_ref().filter(|_| natural.is_some()) {
            let place = MovedPlace {
                theta_rad,
                width_rad,
                axis_squares: axis_squares(ray.direction, self.sun_direction),
            };
            moved.place(&place, &mut out.scratch.moved);
        }
        let slabs = match settings.air {
            Some(air) if rows.is_some() && !self.dimmed_by.nothing() => {
                let way = AirWay {
                    air,
                    dimmed_by: self.dimmed_by,
                    ray,
                    range_m,
                };
                Some(AirSlabs::cut(way, &mut out.scratch.slab_ends_m))
            }
            Some(_) | None => None,
        };
        // Fields of `out` are lent apart: the march fills the deposits, shading empties them.
        let RayLight { bow, scratch, .. } = out;
        let Scratch {
            deposits,
            stencil,
            moved: moved_stencil,
            slab_ends_m,
            slab,
            transmitted,
            nodes,
            in_water,
            ..
        } = scratch;
        let in_water = in_water.as_mut();
        let mut in_water = in_water.zip(self.water.as_ref().and_then(SeenWater::bows));
        let mut sums = RaySums::default();
        let walk = Walk {
            ray,
            range_m,
            axes: rows.map(ScatteringRows::axes),
            slab_ends_m,
        };
        let depth = settings
            .march
            .along(&walk, &mut nodes.probes, deposits, |deposits| {
                let Some(rows) = rows else { return };
                let luminance = if let Some((room, bows)) = &mut in_water {
                    bows.shade(self, (deposits, 1.0), room, slab)
                } else {
                    stencil.set_light(&deposits.bins);
                    self.shade(rows, (stencil, moved_stencil), slab)
                };
                sums.add(&luminance, deposits);
                if let Some(slabs) = &slabs {
                    slabs.transmit(deposits, transmitted);
                    multiply(slab, transmitted);
                }
                add_product(bow, slab, &self.irradiance);
            });
        out.transmittance = (-depth).exp();
        (out.light, out.light_m, out.light_tau_sun) =
            (sums.light, sums.light_m, sums.light_tau_sun);
        out.sunlit_cd_m2 = sums.luminance_cd_m2;
        out.errors = sums.errors;
        out.errors.shadow = self.shadow_error(ray, &sums);
    }

    /// Share of the light behind the drops that is seen.
    fn left_behind(&self, out: &RayLight) -> f64 {
        if self.drops_dim {
            out.transmittance
        } else {
            1.0
        }
    }

    /// Set a slab to the light of a stencil.
    fn shade(
        &self,
        rows: &ScatteringRows,
        (stencil, moved_stencil): (&mut RowStencil, &mut MovedStencil),
        slab: &mut [f32],
    ) -> SunlitLuminance {
        let mut luminance = rows.luminance(stencil);
        rows.shade(stencil, slab);
        if let Some(moved) = &self.moved {
            moved.shade(stencil.light(), moved_stencil);
            for moved in moved_stencil.lights() {
                moved.add_to(slab);
                luminance.add(1.0, &self.moved_luminance(moved));
            }
        }
        luminance
    }

    /// Luminance of moved light, and what its table errs by.
    pub(crate) fn moved_luminance(&self, moved: &MovedLight) -> SunlitLuminance {
        SunlitLuminance {
            value: self.luminance(&moved.spectrum),
            off_lines: moved.error_cd_m2,
            ..SunlitLuminance::default()
        }
    }

    /// Luminance in sunlight of a spectrum of the table's unit.
    fn luminance(&self, spectrum: &[f32]) -> f64 {
        let weights = self.luminance_weights.iter().zip(spectrum);
        weights
            .map(|(weight, value)| weight * f64::from(*value))
            .sum()
    }

    /// The light of a ray errs relatively by Q times the error of the sun's optical depth.
    fn shadow_error(&self, ray: &Ray, sums: &RaySums) -> f64 {
        let Some((error, efficiency)) = self.shadow_error.filter(|_| sums.light > 0.0) else {
            return 0.0;
        };
        efficiency * sums.shadow_depth(error, ray) * sums.luminance_cd_m2
    }

    fn add_glow(&self, glow_ray: &GlowRay, out: &mut RayLight) {
        out.glows = true;
        let RayLight {
            inscatter,
            sky,
            scratch,
            ..
        } = out;
        let Scratch { nodes, glow, .. } = scratch;
        glow.clear();
        glow.gather(glow_ray, nodes);
        out.front_error = glow.front_error();
        for (index, irradiance) in self.irradiance.iter().enumerate() {
            inscatter[index] = irradiance * glow.in_front[index];
            sky[index] = irradiance * glow.beyond[index];
        }
    }

    fn add_surround(&self, surround: &[f32], way: RayThroughDrops, out: &mut RayLight) {
        let (ray, (enter_m, leave_m)) = (way.ray, way.range_m);
        out.glows = true;
        out.scratch.transmitted.fill(1.0);
        if let (Some(air), true) = (way.settings.air, self.dimmed_by.view) {
            // Light that comes from where the view ends, whether the sun shines there or not.
            let middle_m = out
                .scratch
                .nodes
                .lost_at_m()
                .unwrap_or(0.5 * (enter_m + leave_m));
            let lengths = air.to_eye(air.ray(ray.origin, ray.direction), middle_m);
            air.transmit(&lengths, &mut out.scratch.transmitted);
        }
        let through = self.left_behind(out);
        for (index, irradiance) in self.irradiance.iter().enumerate() {
            let skylit = skylit_radiance(through, surround[index]);
            out.skylit[index] = irradiance * out.scratch.transmitted[index] * skylit;
        }
    }
}
