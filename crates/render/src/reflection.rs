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
//! distances where the water lights it. Waves average the rows over a Gaussian of scattering angles.
//! Light of further orders and of the surroundings is that of the sun alone.

use glam::DVec3;
use niji_geometry::Ray;

use crate::air::Air;
use crate::air_slabs::AirSlabs;
use crate::air_slabs::AirWay;
use crate::deposits::Deposits;
use crate::flattening::axis_squares;
use crate::frame::Frame;
use crate::frame::FrameBasis;
use crate::march::March;
use crate::march::Walk;
use crate::mirrored_drops::MirroredDrops;
use crate::mirrored_table::Polarization;
use crate::polarized_rows::LitAngles;
use crate::polarized_rows::PolarizedRoom;
use crate::polarized_rows::PolarizedRows;
use crate::ray_settings::RayThroughDrops;
use crate::ray_sums::RaySums;
use crate::request::RenderRequest;
use crate::scattering_rows::ScatteringRows;
use crate::spectra::add_product;
use crate::spectra::multiply;
use crate::sun_streak::SunStreak;
use crate::water_surface::MirroredLight;
use crate::water_surface::mirrored;

/// Steps of the table's angles over the narrowest standard deviation of the streak.
const STEP: f64 = 0.5;

/// All that rays share of the light by way of water.
pub(crate) struct Reflection<'a> {
    drops: &'a MirroredDrops,
    streak: SunStreak,
    bows: PolarizedRows<'a>,
    air: Option<Air<'a>>,
    efficiency: f64,
}

/// The light of one ray, and a thread's room for it.
#[derive(Clone, Debug)]
pub(crate) struct ReflectionRoom {
    /// Light of the bows in the mirrored sun [W m^-2 sr^-1 nm^-1].
    pub(crate) light: Vec<f32>,
    deposits: Deposits,
    bows: PolarizedRoom,
    slab_ends_m: Vec<f64>,
    slab: Vec<f32>,
    transmitted: Vec<f32>,
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
        let polarizations: &[Polarization] = match mirror.light {
            MirroredLight::Natural => &[Polarization::Natural],
            MirroredLight::Polarized => &Polarization::BOTH,
        };
        let angles = (range_rad, step_rad);
        let bows = PolarizedRows::new((request, table), basis, angles, polarizations);
        let air = request.air.filter(|_| basis.air.is_some());
        let eye = request.camera.position();
        let air = air.map(|table| {
            Air::new(table, request.levels.air_path, mirror.sun_direction, eye)
                .by_way_of(&mirror.surface)
        });
        Some(Self {
            drops,
            streak,
            bows,
            air,
            efficiency: request.levels.drop_extinction_model.efficiency(),
        })
    }

    /// Take twice as many nodes on each way through the air.
    pub(crate) fn refine_air(&mut self) {
        self.air = self.air.as_ref().map(Air::finer);
    }

    /// Room to work in.
    pub(crate) fn room(&self, n_wavelengths: usize) -> ReflectionRoom {
        ReflectionRoom {
            light: vec![0.0; n_wavelengths],
            deposits: Deposits::new(self.bows.axes()),
            bows: self.bows.room(n_wavelengths),
            slab_ends_m: Vec::new(),
            slab: vec![0.0; n_wavelengths],
            transmitted: vec![0.0; n_wavelengths],
        }
    }

    /// The rows, to be checked.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &ScatteringRows<'a>> {
        self.bows.rows()
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
        let angles = LitAngles {
            theta_rad: seen.theta_rad,
            sd_rad: seen.sd_rad,
            width_rad: settings.width_rad,
            axis_squares: axis_squares(ray.direction, mirrored(sun_direction)),
        };
        self.bows.place(&angles, &mut room.bows);
        let polarized = (&self.streak.polarized[..], seen.cos_2_alpha);
        PolarizedRows::light(&self.streak.natural, polarized, &mut room.bows);
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
            bows,
            slab_ends_m,
            slab,
            transmitted,
        } = room;
        let walk = Walk {
            ray,
            range_m: lit_m,
            axes: Some(self.bows.axes()),
            slab_ends_m,
        };
        march.along(&walk, &mut [], deposits, |deposits| {
            let luminance = self.bows.shade(frame, (deposits, in_front), bows, slab);
            sums.add(&luminance, deposits);
            if let Some(slabs) = &slabs {
                slabs.transmit(deposits, transmitted);
                multiply(slab, transmitted);
            }
            add_product(light, slab, &frame.irradiance);
        });
        if let (Some(error), true) = (&self.drops.shadow_error, sums.light > 0.0) {
            sums.errors.shadow =
                self.efficiency * sums.shadow_depth(error, ray) * sums.luminance_cd_m2;
        }
        sums
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
