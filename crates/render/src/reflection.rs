//! The reflection bow: light of the drops in the sun that water mirrors.
//!
//! L(lambda) = E_sun int pi M2 (q_s t_s + q_p t_p)(theta', lambda) T_view T_mirror ds
//! q_s, q_p = [N +- P <cos 2 alpha>]/2
//! `theta'` scattering angle from the mirrored sun, `t_s`, `t_p` rows of the table of light polarized
//! across and along the plane of scattering [1/sr], `N`, `P`, `alpha` irradiance and polarization of the
//! mirrored light (see `sun_streak`), `T_mirror` what drops and air leave on its way from the sun to the
//! water and up to the drop. In still water the bow is R (1 + P_w P_b cos 2 chi) times the direct one at
//! the same distance from the point opposite the mirrored sun.
//!
//! A second march follows the same ray through drops with another optical depth to the sun, between the two
//! distances where the water lights it. Waves average the rows over a Gaussian of scattering angles; where
//! drops are flattened, over five even stretches, of the weights of a Gaussian, of which each has the
//! 1/12 of the square of its width as its own part of the variance.
//! Light of further orders and of the surroundings is that of the sun alone.

use std::borrow::Cow;

use glam::DVec3;
use niji_geometry::Ray;

use crate::air::Air;
use crate::air_slabs::AirSlabs;
use crate::air_slabs::AirWay;
use crate::angle_axis::RayPlace;
use crate::deposits::Deposits;
use crate::flattening::axis_squares;
use crate::frame::Frame;
use crate::frame::FrameBasis;
use crate::march::March;
use crate::march::Walk;
use crate::mirrored_drops::MirroredDrops;
use crate::mirrored_table::Polarization;
use crate::mirrored_table::added_variance;
use crate::mirrored_table::mirrored_table;
use crate::moved_rows::MovedPlace;
use crate::moved_rows::MovedRows;
use crate::moved_rows::MovedStencil;
use crate::ray_settings::RayThroughDrops;
use crate::ray_sums::RaySums;
use crate::request::RenderRequest;
use crate::scattering_rows::RowStencil;
use crate::scattering_rows::ScatteringRows;
use crate::scattering_rows::SunlitLuminance;
use crate::size_nodes::SizeNodes;
use crate::spectra::add_product;
use crate::spectra::multiply;
use crate::sun_streak::SeenStreak;
use crate::sun_streak::SunStreak;
use crate::water_surface::MirroredLight;
use crate::water_surface::mirrored;

/// Steps of the table's angles over the narrowest standard deviation of the streak.
const STEP: f64 = 0.5;

/// Stretches that stand for a Gaussian where drops are flattened, on either side of its middle, and how wide
/// they are in standard deviations.
const N_STRETCHES: i32 = 2;
const STRETCH: f64 = 1.25;

/// All that rays share of the light by way of water.
pub(crate) struct Reflection<'a> {
    drops: &'a MirroredDrops,
    streak: SunStreak,
    /// One of natural light, or one of each polarization.
    parts: Vec<Part<'a>>,
    air: Option<Air<'a>>,
    /// Variance that the table's coarser angles add to the streak's.
    angles_variance: f64,
    efficiency: f64,
    brightest: usize,
}

/// Rows of one polarization.
struct Part<'a> {
    rows: ScatteringRows<'a>,
    moved: Option<MovedRows>,
}

/// The light of one ray, and a thread's room for it.
#[derive(Clone, Debug)]
pub(crate) struct ReflectionRoom {
    /// Light of the bows in the mirrored sun [W m^-2 sr^-1 nm^-1].
    pub(crate) light: Vec<f32>,
    deposits: Deposits,
    stencils: Vec<RowStencil>,
    /// With the weights of their stretches.
    moved: Vec<(f32, MovedStencil)>,
    slab_ends_m: Vec<f64>,
    slab: Vec<f32>,
    part: Vec<f32>,
    stretch: Vec<f32>,
    /// Irradiance by polarization and wavelength, over the sun's.
    irradiance: Vec<Vec<f32>>,
}

/// Direction towards the sun in still water, where the picture has its light.
pub(crate) fn mirrored_sun(request: &RenderRequest) -> Option<DVec3> {
    let drops = request.drops.mirrored().filter(|_| request.wants_bow())?;
    Some(mirrored(drops.mirror.sun_direction))
}

impl<'a> Reflection<'a> {
    /// The light by way of water for rays that see scattering angles of a range from the sun in still water.
    pub(crate) fn new(
        request: &RenderRequest<'a>,
        basis: &FrameBasis,
        range_rad: (f64, f64),
    ) -> Option<Self> {
        let drops = request.drops.mirrored()?;
        let mirror = &drops.mirror;
        let table = request.table?;
        let streak = SunStreak::new(&mirror.surface, mirror.sun_direction, &request.wavelengths)?;
        let step_rad = STEP * SunStreak::narrowest_rad(&mirror.surface, mirror.sun_direction);
        let reach_rad = mirror.surface.streak_reach().0;
        let range_rad = (range_rad.0 - reach_rad, range_rad.1 + reach_rad);
        let nodes = || SizeNodes::of_drops(table, request.drops.size_range());
        let part = |polarization: Polarization| {
            let table = mirrored_table(table, polarization, step_rad);
            let moved = MovedRows::new(&table, &nodes(), &basis.luminance_weights);
            let source = (Cow::Owned(table), nodes());
            Part {
                rows: ScatteringRows::new(source, range_rad, &basis.luminance_weights),
                moved,
            }
        };
        let polarizations: &[Polarization] = match mirror.light {
            MirroredLight::Natural => &[Polarization::Natural],
            MirroredLight::Polarized => &[Polarization::Perpendicular, Polarization::Parallel],
        };
        let parts: Vec<Part> = polarizations.iter().map(|it| part(*it)).collect();
        let air = request.air.filter(|_| basis.air.is_some());
        let eye = request.camera.position();
        let air = air.map(|table| {
            Air::new(table, request.levels.air_path, mirror.sun_direction, eye)
                .by_way_of(&mirror.surface)
        });
        Some(Self {
            drops,
            streak,
            parts,
            air,
            angles_variance: added_variance(&table.theta_rad, step_rad),
            efficiency: request.levels.drop_extinction_model.efficiency(),
            brightest: basis.brightest,
        })
    }

    /// Take twice as many nodes on each way through the air.
    pub(crate) fn refine_air(&mut self) {
        self.air = self.air.as_ref().map(Air::finer);
    }

    /// Room to work in.
    pub(crate) fn room(&self, n_wavelengths: usize) -> ReflectionRoom {
        let n_moved = if self.parts[0].moved.is_none() {
            0
        } else if self.drops.mirror.surface.slope > 0.0 {
            2 * N_STRETCHES as usize + 1
        } else {
            1
        };
        ReflectionRoom {
            light: vec![0.0; n_wavelengths],
            deposits: Deposits::new(self.parts[0].rows.axes()),
            stencils: vec![RowStencil::default(); self.parts.len()],
            moved: vec![(0.0, MovedStencil::default()); n_moved],
            slab_ends_m: Vec::new(),
            slab: vec![0.0; n_wavelengths],
            part: vec![0.0; n_wavelengths],
            stretch: vec![0.0; n_wavelengths],
            irradiance: vec![vec![0.0; n_wavelengths]; self.parts.len()],
        }
    }

    /// The rows, to be checked.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &ScatteringRows<'a>> {
        self.parts.iter().map(|part| &part.rows)
    }

    /// Add the light along a ray; what it sums up to.
    pub(crate) fn add(
        &self,
        frame: &Frame,
        way: RayThroughDrops,
        room: &mut ReflectionRoom,
    ) -> RaySums {
        let RayThroughDrops {
            ray,
            range_m,
            settings,
        } = way;
        let mut sums = RaySums::default();
        let sun_direction = self.drops.mirror.sun_direction;
        let seen = self.streak.seen(ray.direction);
        let lit = self
            .drops
            .mirror
            .surface
            .lit_range_m(ray, sun_direction, range_m);
        let Some(lit_m) = lit.filter(|_| frame.sides.wants(seen.theta_rad)) else {
            return sums;
        };
        let march = March {
            bricks: &self.drops.bricks,
            ..*settings.march
        };
        let in_front = transmitted_before(&march, ray, (range_m.0, lit_m.0));
        self.place(ray.direction, &seen, settings.width_rad, room);
        let slabs = match &self.air {
            Some(air) if !frame.dimmed_by.nothing() => {
                let way = AirWay {
                    air,
                    dimmed_by: frame.dimmed_by,
                    ray,
                    range_m: lit_m,
                };
                Some(AirSlabs::cut(way, &mut room.slab_ends_m))
            }
            Some(_) | None => {
                room.slab_ends_m.clear();
                None
            }
        };
        let ReflectionRoom {
            light,
            deposits,
            stencils,
            moved,
            slab_ends_m,
            slab,
            part,
            stretch,
            irradiance,
        } = room;
        let walk = Walk {
            ray,
            range_m: lit_m,
            axes: Some(self.parts[0].rows.axes()),
            slab_ends_m,
        };
        march.along(&walk, &mut [], deposits, |deposits| {
            slab.fill(0.0);
            let mut luminance = SunlitLuminance::default();
            let places = stencils.iter_mut().zip(irradiance.iter_mut());
            for (of_part, (stencil, irradiance)) in self.parts.iter().zip(places) {
                stencil.set_light(&deposits.bins);
                let share = in_front * f64::from(irradiance[self.brightest]);
                luminance.add(share, &of_part.rows.luminance(stencil));
                of_part.rows.shade(stencil, part);
                if let Some(rows) = &of_part.moved {
                    let still = frame.luminance(part);
                    for (weight, place) in moved.iter_mut() {
                        stretch.fill(0.0);
                        let peaks = rows.add(stencil.light(), place, stretch);
                        luminance.off_lines +=
                            share * f64::from(*weight) * frame.table_error * peaks;
                        for (sum, value) in part.iter_mut().zip(stretch.iter()) {
                            *sum += *weight * value;
                        }
                    }
                    luminance.value += share * (frame.luminance(part) - still);
                }
                for (index, sum) in slab.iter_mut().enumerate() {
                    *sum += in_front as f32 * irradiance[index] * part[index];
                }
            }
            sums.add(&luminance, deposits);
            if let Some(slabs) = &slabs {
                slabs.transmit(deposits, part);
                multiply(slab, part);
            }
            add_product(light, slab, &frame.irradiance);
        });
        if let (Some(error), true) = (&self.drops.shadow_error, sums.light > 0.0) {
            sums.errors.shadow =
                self.efficiency * sums.shadow_depth(error, ray) * sums.luminance_cd_m2;
        }
        sums
    }

    /// Take note of where a ray stands.
    fn place(
        &self,
        direction: DVec3,
        seen: &SeenStreak,
        width_rad: f64,
        room: &mut ReflectionRoom,
    ) {
        let variance = seen.sd_rad * seen.sd_rad;
        let of_pixel = width_rad * width_rad / 12.0;
        for (part, stencil) in self.parts.iter().zip(&mut room.stencils) {
            if variance > 0.0 {
                let sd_rad = (variance + of_pixel - self.angles_variance).max(0.0).sqrt();
                part.rows
                    .gaussian_stencil((seen.theta_rad, sd_rad), stencil);
            } else {
                let place = RayPlace {
                    theta_rad: seen.theta_rad,
                    width_rad,
                };
                part.rows.stencil(&place, stencil);
            }
        }
        let signs: &[f32] = match self.drops.mirror.light {
            MirroredLight::Natural => &[0.0],
            MirroredLight::Polarized => &[1.0, -1.0],
        };
        let turned = seen.cos_2_alpha as f32;
        let share = 1.0 / signs.len() as f32;
        for (irradiance, sign) in room.irradiance.iter_mut().zip(signs) {
            let light = self.streak.natural.iter().zip(&self.streak.polarized);
            for (value, (natural, polarized)) in irradiance.iter_mut().zip(light) {
                *value = share * (natural + sign * turned * polarized);
            }
        }
        let Some(rows) = &self.parts[0].moved else {
            return;
        };
        let stretches = if variance > 0.0 { N_STRETCHES } else { 0 };
        let sd_rad = (variance + of_pixel).sqrt();
        let width_rad = if variance > 0.0 {
            STRETCH * sd_rad
        } else {
            width_rad
        };
        let places = (-stretches..=stretches).map(|index| STRETCH * f64::from(index));
        let density = |place: f64| (-0.5 * place * place / (1.0 - STRETCH * STRETCH / 12.0)).exp();
        let all: f64 = places.clone().map(density).sum();
        for (place, (weight, stencil)) in places.zip(&mut room.moved) {
            *weight = (density(place) / all) as f32;
            let place = MovedPlace {
                theta_rad: seen.theta_rad + place * sd_rad,
                width_rad,
                axis_squares: axis_squares(direction, mirrored(self.drops.mirror.sun_direction)),
            };
            rows.place(&place, stencil);
        }
    }
}

/// What drops let pass that stand in front of the lit part of a ray.
fn transmitted_before(march: &March, ray: &Ray, (from_m, to_m): (f64, f64)) -> f64 {
    let efficiency = march.rule.view_efficiency;
    if efficiency <= 0.0 || from_m >= to_m {
        return 1.0;
    }
    (-efficiency * march.depth(ray, (from_m, to_m))).exp()
}
