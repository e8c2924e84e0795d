//! The light of one view ray.
//!
//! L(lambda) = E_sun sum_b W_b t_b(theta, lambda) T_air + L_air + T_drops L_beyond + (1 - T_drops) S
//!
//! `W_b` light of drops in size bin b [-], `t_b` row of the scattering table at the ray's angle and
//! flattening [1/sr], `T_air` what air on both paths lets pass, `L_air` light of the air from the eye
//! to the far side of the drops, `L_beyond` sky and ground, `T_drops = exp(-tau)` what the drops let
//! pass without diffraction, `S` mean of the surroundings.

use glam::Vec4;
use niji_geometry::Ray;

use crate::air::Air;
use crate::air_glow::Glow;
use crate::air_glow::GlowNodes;
use crate::air_glow::GlowRange;
use crate::air_slabs::AirSlabs;
use crate::deposits::Deposits;
use crate::flattening::flattening_along;
use crate::frame::Frame;
use crate::march::Walk;
use crate::scattering_angle::scattering_angle_rad;
use crate::scattering_rows::RayPlace;
use crate::scattering_rows::RowStencil;
use crate::scattering_rows::ScatteringRows;
use crate::size_axes::SizeAxes;
use crate::surfaces::Sight;
use crate::surround::skylit_radiance;

/// Spectra and figures of a ray, and room to work in.
#[derive(Clone, Debug)]
pub(crate) struct RayLight {
    /// Light of the bows [W m^-2 sr^-1 nm^-1].
    pub(crate) bow: Vec<f32>,
    /// Light of the air in front.
    pub(crate) inscatter: Vec<f32>,
    /// What shines behind, dimmed, and the light of the surroundings from the drops.
    pub(crate) background: Vec<f32>,
    /// What of the background is light of the surroundings that the drops scatter.
    pub(crate) skylit: Vec<f32>,
    /// Whether there is any light of the air in front or from behind.
    pub(crate) glows: bool,
    /// Whether the ray looks at the primary side of the split.
    pub(crate) is_primary: bool,
    /// exp(-tau) of the drops, without diffraction.
    pub(crate) transmittance: f64,
    /// Light of the drops [-], the sums over it of its distance and optical depth to the sun.
    pub(crate) light: f64,
    pub(crate) light_m: f64,
    pub(crate) light_tau_sun: f64,
    /// Estimated error of luminance from the quadrature and from the table's sizes [cd/m²].
    pub(crate) error_cd_m2: f64,
    deposits: Deposits,
    stencil: RowStencil,
    slab_ends_m: Vec<f64>,
    slab: Vec<f32>,
    transmitted: Vec<f32>,
    nodes: GlowNodes,
    glow: Glow,
}

impl RayLight {
    /// Darkness.
    pub(crate) fn new(frame: &Frame) -> Self {
        let dark = vec![0.0_f32; frame.irradiance.len()];
        let no_sizes = SizeAxes::new(&[1.0], &[0.0]);
        let axes = frame.rows.as_ref().map_or(&no_sizes, ScatteringRows::axes);
        Self {
            bow: dark.clone(),
            inscatter: dark.clone(),
            background: dark.clone(),
            skylit: dark.clone(),
            glows: false,
            is_primary: false,
            transmittance: 1.0,
            light: 0.0,
            light_m: 0.0,
            light_tau_sun: 0.0,
            error_cd_m2: 0.0,
            deposits: Deposits::new(axes),
            stencil: RowStencil::default(),
            slab_ends_m: Vec::new(),
            slab: dark.clone(),
            transmitted: dark.clone(),
            nodes: GlowNodes::default(),
            glow: Glow::dark(dark.len()),
        }
    }

    fn clear(&mut self) {
        self.bow.fill(0.0);
        // Without a glow these stay dark.
        if self.glows {
            self.inscatter.fill(0.0);
            self.background.fill(0.0);
            self.skylit.fill(0.0);
            self.glows = false;
        }
        self.slab_ends_m.clear();
        self.nodes.probes.clear();
        self.transmittance = 1.0;
        (self.light, self.light_m, self.light_tau_sun) = (0.0, 0.0, 0.0);
        self.error_cd_m2 = 0.0;
    }
}

impl Frame<'_> {
    /// Where on its way to the surface a ray may meet drops.
    pub(crate) fn range_m(&self, sight: &Sight) -> Option<(f64, f64)> {
        let (enter_m, leave_m) = self.bounds?.intersect(&sight.ray)?;
        (enter_m < sight.surface_m).then_some((enter_m, leave_m.min(sight.surface_m)))
    }

    /// Whether anything but drops sends light.
    pub(crate) fn glows_without_drops(&self) -> bool {
        self.glows.1
    }

    /// Whether a bow is wanted at a scattering angle.
    pub(crate) fn wants(&self, theta_rad: f64) -> bool {
        if theta_rad < self.split_theta_rad {
            self.sides.0
        } else {
            self.sides.1
        }
    }

    /// Follow a ray whose pixel spans `width_rad` of scattering angle (0: a point).
    pub(crate) fn trace(&self, sight: &Sight, width_rad: f64, out: &mut RayLight) {
        out.clear();
        let ray = &sight.ray;
        let drops_m = self.range_m(sight);
        let theta_rad = scattering_angle_rad(ray.direction, self.sun_direction);
        out.is_primary = theta_rad >= self.split_theta_rad;
        let glow_range = GlowRange {
            drops_m,
            surface_m: sight.surface_m,
            in_front: self.glows.0,
            beyond: self.glows.1,
        };
        let glowing = self.glows.1 || (self.glows.0 && drops_m.is_some());
        if let (Some(air), true) = (&self.air, glowing) {
            self.glow.lay_out(air, ray, &glow_range, &mut out.nodes);
        }
        if let Some(range_m) = drops_m {
            self.through_drops(ray, range_m, (theta_rad, width_rad), out);
        }
        if let (Some(air), true) = (&self.air, glowing) {
            self.add_glow(air, ray, theta_rad, out);
        }
        if let (Some(surround), Some(range_m)) = (&self.surround, drops_m) {
            self.add_surround(surround, ray, range_m, out);
        }
    }

    fn through_drops(
        &self,
        ray: &Ray,
        range_m: (f64, f64),
        (theta_rad, width_rad): (f64, f64),
        out: &mut RayLight,
    ) {
        let rows = self.rows.as_ref().filter(|_| self.wants(theta_rad));
        if rows.is_none() && !self.drops_dim {
            return;
        }
        if let Some(rows) = rows {
            let flattening = if rows.are_of_flat_drops() {
                flattening_along(ray.direction, self.sun_direction)
            } else {
                0.0
            };
            let place = RayPlace {
                theta_rad,
                width_rad,
                flattening,
            };
            rows.stencil(&place, &mut out.stencil);
        }
        let slabs = match &self.air {
            Some(air) if rows.is_some() && !self.dimmed_by.nothing() => Some(AirSlabs::cut(
                air,
                self.dimmed_by,
                ray,
                range_m,
                &mut out.slab_ends_m,
            )),
            Some(_) | None => None,
        };
        // Fields of `out` are lent apart: the march fills the deposits, shading empties them.
        let RayLight {
            deposits,
            stencil,
            slab_ends_m,
            slab,
            transmitted,
            nodes,
            bow,
            ..
        } = out;
        let mut sums = Sums::default();
        let walk = Walk {
            ray,
            range_m,
            axes: rows.map(ScatteringRows::axes),
            slab_ends_m,
        };
        let depth = self
            .march
            .along(&walk, &mut nodes.probes, deposits, |deposits| {
                let Some(rows) = rows else { return };
                sums.add(rows, stencil, deposits);
                slab.fill(0.0);
                rows.shade(&deposits.bins, stencil, slab);
                if let Some(slabs) = &slabs {
                    slabs.transmit(deposits, transmitted);
                    for (value, transmitted) in slab.iter_mut().zip(transmitted.iter()) {
                        *value *= transmitted;
                    }
                }
                for ((sum, value), irradiance) in
                    bow.iter_mut().zip(slab.iter()).zip(&self.irradiance)
                {
                    *sum += value * irradiance;
                }
            });
        if self.drops_dim {
            out.transmittance = (-depth).exp();
        }
        (out.light, out.light_m, out.light_tau_sun) =
            (sums.light, sums.light_m, sums.light_tau_sun);
        out.error_cd_m2 = sums.error_cd_m2;
    }

    fn add_glow(&self, air: &Air, ray: &Ray, theta_rad: f64, out: &mut RayLight) {
        out.glows = true;
        let RayLight {
            nodes,
            glow,
            inscatter,
            background,
            ..
        } = out;
        glow.clear();
        glow.gather(air, ray, nodes, (theta_rad, self.drops_dim));
        for (index, irradiance) in self.irradiance.iter().enumerate() {
            inscatter[index] = irradiance * glow.in_front[index];
            background[index] = irradiance * glow.beyond[index];
        }
    }

    fn add_surround(
        &self,
        surround: &[f32],
        ray: &Ray,
        (enter_m, leave_m): (f64, f64),
        out: &mut RayLight,
    ) {
        out.glows = true;
        out.transmitted.fill(1.0);
        if let (Some(air), true) = (&self.air, self.dimmed_by.view) {
            let middle_m = if out.light > 0.0 {
                out.light_m / out.light
            } else {
                0.5 * (enter_m + leave_m)
            };
            let lengths = air.to_eye(air.ray(ray.origin, ray.direction), middle_m);
            air.transmit(&lengths, &mut out.transmitted);
        }
        for (index, irradiance) in self.irradiance.iter().enumerate() {
            let skylit = skylit_radiance(out.transmittance, surround[index]);
            out.skylit[index] = irradiance * out.transmitted[index] * skylit;
            out.background[index] += out.skylit[index];
        }
    }
}

/// Sums over the slabs of a ray.
#[derive(Default)]
struct Sums {
    light: f64,
    light_m: f64,
    light_tau_sun: f64,
    error_cd_m2: f64,
}

impl Sums {
    fn add(&mut self, rows: &ScatteringRows, stencil: &RowStencil, deposits: &Deposits) {
        let (luminance, size_error) = rows.luminance(&deposits.bins, stencil);
        let quadrature_error = luminance * deposits.error.abs() / deposits.light;
        self.light += deposits.light;
        self.light_m += deposits.light_m;
        self.light_tau_sun += deposits.light_tau_sun;
        self.error_cd_m2 += quadrature_error + size_error;
    }
}

/// Weighted sum of a spectrum in three channels; the fourth lane is idle.
pub(crate) fn weighted_sum(spectrum: &[f32], weights: &[Vec4]) -> Vec4 {
    spectrum
        .iter()
        .zip(weights)
        .fold(Vec4::ZERO, |sum, (value, weight)| sum + *value * *weight)
}
