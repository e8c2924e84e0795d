//! Rows of the scattering table for light whose polarization counts: that water mirrors before or after the drops.
//!
//! t = q_s t_s + q_p t_p,   q_s, q_p = [N +- P cos 2 alpha]/2
//! `t_s`, `t_p` rows of light polarized across and along the plane of scattering [1/sr], `N` what the water mirrors of
//! natural light, (R_s + R_p)/2, `P` = (R_s - R_p)/2, `alpha` angle between the planes of incidence and scattering.
//! Which of both comes first does not matter (Stokes' reversion): of spheres in sunlight a mirror shows as
//! much as they show of the mirrored sun.
//!
//! Waves average the rows over a Gaussian of scattering angles; where drops are flattened, over five even stretches,
//! of the weights of a Gaussian, of which each has the 1/12 of the square of its width as its own part of the
//! variance.

use std::borrow::Cow;

use niji_exchange::ScatteringTable;

use crate::angle_axis::RayPlace;
use crate::deposits::Deposits;
use crate::frame::Frame;
use crate::frame::FrameBasis;
use crate::mirrored_table::Polarization;
use crate::mirrored_table::added_variance;
use crate::mirrored_table::mirrored_table;
use crate::moved_rows::MovedPlace;
use crate::moved_rows::MovedRows;
use crate::moved_rows::MovedStencil;
use crate::request::RenderRequest;
use crate::scattering_rows::RowStencil;
use crate::scattering_rows::ScatteringRows;
use crate::scattering_rows::SunlitLuminance;
use crate::size_axes::SizeAxes;
use crate::size_nodes::SizeNodes;

/// Stretches that stand for a Gaussian where drops are flattened, on either side of its middle, and how wide
/// they are in standard deviations.
const N_STRETCHES: i32 = 2;
const STRETCH: f64 = 1.25;

/// Rows of natural light, or of each polarization.
pub(crate) struct PolarizedRows<'a> {
    parts: Vec<Part<'a>>,
    /// Variance that the table's coarser angles add to that of waves.
    angles_variance: f64,
}

/// Rows of one polarization.
struct Part<'a> {
    rows: ScatteringRows<'a>,
    moved: Option<MovedRows>,
}

/// Where a ray sees them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LitAngles {
    /// Mean scattering angle, and its standard deviation because of waves.
    pub(crate) theta_rad: f64,
    pub(crate) sd_rad: f64,
    /// What the pixel spans.
    pub(crate) width_rad: f64,
    pub(crate) axis_squares: [f64; 2],
}

/// A thread's room for the light of one ray.
#[derive(Clone, Debug)]
pub(crate) struct PolarizedRoom {
    stencils: Vec<RowStencil>,
    /// With the weights of their stretches.
    moved: Vec<(f32, MovedStencil)>,
    part: Vec<f32>,
    stretch: Vec<f32>,
    /// By polarization and wavelength, over the sun's.
    irradiance: Vec<Vec<f32>>,
}

impl<'a> PolarizedRows<'a> {
    /// Rows of a table for a range of scattering angles, on angles no finer than `step_rad`.
    pub(crate) fn new(
        (request, table): (&RenderRequest<'a>, &'a ScatteringTable),
        basis: &FrameBasis,
        (range_rad, step_rad): ((f64, f64), f64),
        polarizations: &[Polarization],
    ) -> Self {
        let nodes = || SizeNodes::of_drops(table, request.drops.size_range());
        let part = |polarization: &Polarization| {
            let table = mirrored_table(table, *polarization, step_rad);
            let moved = MovedRows::new(&table, &nodes(), &basis.luminance_weights, step_rad);
            let source = (Cow::Owned(table), nodes());
            Part {
                rows: ScatteringRows::new(source, range_rad, &basis.luminance_weights),
                moved,
            }
        };
        Self {
            parts: polarizations.iter().map(part).collect(),
            angles_variance: added_variance(&table.theta_rad, step_rad),
        }
    }

    /// Room to work in; waves may spread the light of a ray.
    pub(crate) fn room(&self, n_wavelengths: usize, is_spread: bool) -> PolarizedRoom {
        let n_moved = match (&self.parts[0].moved, is_spread) {
            (None, _) => 0,
            (Some(_), true) => 2 * N_STRETCHES as usize + 1,
            (Some(_), false) => 1,
        };
        PolarizedRoom {
            stencils: vec![RowStencil::default(); self.parts.len()],
            moved: vec![(0.0, MovedStencil::default()); n_moved],
            part: vec![0.0; n_wavelengths],
            stretch: vec![0.0; n_wavelengths],
            irradiance: vec![vec![0.0; n_wavelengths]; self.parts.len()],
        }
    }

    /// The rows, to be checked.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &ScatteringRows<'a>> {
        self.parts.iter().map(|part| &part.rows)
    }

    /// Their sizes.
    pub(crate) fn axes(&self) -> &SizeAxes {
        self.parts[0].rows.axes()
    }

    /// Take note of where a ray stands.
    pub(crate) fn place(&self, seen: &LitAngles, room: &mut PolarizedRoom) {
        let variance = seen.sd_rad * seen.sd_rad;
        let of_pixel = seen.width_rad * seen.width_rad / 12.0;
        for (part, stencil) in self.parts.iter().zip(&mut room.stencils) {
            if variance > 0.0 {
                let sd_rad = (variance + of_pixel - self.angles_variance).max(0.0).sqrt();
                part.rows
                    .gaussian_stencil((seen.theta_rad, sd_rad), stencil);
            } else {
                let place = RayPlace {
                    theta_rad: seen.theta_rad,
                    width_rad: seen.width_rad,
                };
                part.rows.stencil(&place, stencil);
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
            seen.width_rad
        };
        let places = (-stretches..=stretches).map(|index| STRETCH * f64::from(index));
        let density = |place: f64| (-0.5 * place * place / (1.0 - STRETCH * STRETCH / 12.0)).exp();
        let all: f64 = places.clone().map(density).sum();
        for (place, (weight, stencil)) in places.zip(&mut room.moved) {
            *weight = (density(place) / all) as f32;
            let place = MovedPlace {
                theta_rad: seen.theta_rad + place * sd_rad,
                width_rad,
                axis_squares: seen.axis_squares,
            };
            rows.place(&place, stencil);
        }
    }

    /// Take note of `N` and `P` by wavelength, and of cos 2 alpha.
    pub(crate) fn light(
        natural: &[f32],
        (polarized, cos_2_alpha): (&[f32], f64),
        room: &mut PolarizedRoom,
    ) {
        let signs: &[f32] = match room.irradiance.len() {
            1 => &[0.0],
            _ => &[1.0, -1.0],
        };
        let turned = cos_2_alpha as f32;
        let share = 1.0 / signs.len() as f32;
        for (irradiance, sign) in room.irradiance.iter_mut().zip(signs) {
            let light = natural.iter().zip(polarized);
            for (value, (natural, polarized)) in irradiance.iter_mut().zip(light) {
                *value = share * (natural + sign * turned * polarized);
            }
        }
    }

    /// Set a slab to the light of deposits, of which a share is seen.
    pub(crate) fn shade(
        &self,
        frame: &Frame,
        (deposits, in_front): (&Deposits, f64),
        room: &mut PolarizedRoom,
        slab: &mut [f32],
    ) -> SunlitLuminance {
        slab.fill(0.0);
        let mut luminance = SunlitLuminance::default();
        let PolarizedRoom {
            stencils,
            moved,
            part,
            stretch,
            irradiance,
        } = room;
        let places = stencils.iter_mut().zip(irradiance.iter());
        for (of_part, (stencil, irradiance)) in self.parts.iter().zip(places) {
            stencil.set_light(&deposits.bins);
            let share = in_front * f64::from(irradiance[frame.brightest]);
            luminance.add(share, &of_part.rows.luminance(stencil));
            of_part.rows.shade(stencil, part);
            if let Some(rows) = &of_part.moved {
                let still = frame.luminance(part);
                for (weight, place) in moved.iter_mut() {
                    stretch.fill(0.0);
                    let peaks = rows.add(stencil.light(), place, stretch);
                    luminance.off_lines += share * f64::from(*weight) * frame.table_error * peaks;
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
        luminance
    }
}
