//! Rows of the scattering table for light whose polarization counts: that water mirrors before or after the drops.
//!
//! t = q_s t_s + q_p t_p,   q_s, q_p = [N +- P cos 2 alpha]/2
//! `t_s`, `t_p` rows of light polarized across and along the plane of scattering [1/sr], `N` what the water mirrors of
//! natural light, (R_s + R_p)/2, `P` = (R_s - R_p)/2, `alpha` angle between the planes of incidence and scattering.
//! Which of both comes first does not matter (Stokes' reversion): of spheres in sunlight a mirror shows as
//! much as they show of the mirrored sun.
//!
//! Waves average the rows over a Gaussian of scattering angles; light of flattened drops, whose bows they blur with all
//! else that does, over a tent of the same variance (`moved_angles`).

use std::borrow::Cow;

use niji_exchange::ScatteringTable;

use crate::angle_axis::RayPlace;
use crate::deposits::Deposits;
use crate::frame::Frame;
use crate::frame::FrameBasis;
use crate::mirrored_table::Polarization;
use crate::mirrored_table::added_variance;
use crate::mirrored_table::mirrored_table;
use crate::moved_rows::Blur;
use crate::moved_rows::MovedPlace;
use crate::moved_rows::MovedRows;
use crate::moved_rows::MovedStencil;
use crate::request::RenderRequest;
use crate::scattering_rows::RowStencil;
use crate::scattering_rows::ScatteringRows;
use crate::scattering_rows::SunlitLuminance;
use crate::size_axes::SizeAxes;
use crate::size_nodes::SizeNodes;

/// Rows of natural light, or of each polarization.
pub(crate) struct PolarizedRows<'a> {
    /// By polarization, of one grid of angles and sizes.
    rows: Vec<ScatteringRows<'a>>,
    moved: Option<MovedRows>,
    /// Variance that the table's coarser angles add to that of waves.
    angles_variance: f64,
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
    stencil: RowStencil,
    moved: MovedStencil,
    part: Vec<f32>,
    /// By polarization and wavelength, over the sun's.
    irradiance: Vec<Vec<f32>>,
}

impl<'a> PolarizedRows<'a> {
    /// Rows of a table for a range of scattering angles, on angles no finer than `step_rad`, which is 0 in still water.
    pub(crate) fn new(
        (request, table): (&RenderRequest<'a>, &'a ScatteringTable),
        basis: &FrameBasis,
        (range_rad, step_rad): ((f64, f64), f64),
        polarizations: &[Polarization],
    ) -> Self {
        let nodes = || SizeNodes::of_drops(table, request.drops.size_range());
        let of_polarization =
            |polarization: &Polarization| mirrored_table(table, *polarization, step_rad);
        let tables: Vec<ScatteringTable> = polarizations.iter().map(of_polarization).collect();
        let blur = if step_rad > 0.0 {
            Blur::Waves {
                apart_rad: step_rad,
            }
        } else {
            Blur::Pixel
        };
        let moved = MovedRows::new(&tables, &nodes(), &basis.luminance_weights, blur);
        let rows = |table| {
            let source = (Cow::Owned(table), nodes());
            ScatteringRows::new(source, range_rad, &basis.luminance_weights)
        };
        Self {
            rows: tables.into_iter().map(rows).collect(),
            moved,
            angles_variance: added_variance(&table.theta_rad, step_rad),
        }
    }

    /// Room to work in.
    pub(crate) fn room(&self, n_wavelengths: usize) -> PolarizedRoom {
        PolarizedRoom {
            stencil: RowStencil::default(),
            moved: MovedStencil::default(),
            part: vec![0.0; n_wavelengths],
            irradiance: vec![vec![0.0; n_wavelengths]; self.rows.len()],
        }
    }

    /// The rows, to be checked.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &ScatteringRows<'a>> {
        self.rows.iter()
    }

    /// Their sizes.
    pub(crate) fn axes(&self) -> &SizeAxes {
        self.rows[0].axes()
    }

    /// Take note of where a ray stands.
    pub(crate) fn place(&self, seen: &LitAngles, room: &mut PolarizedRoom) {
        let variance = seen.sd_rad * seen.sd_rad;
        let of_pixel = seen.width_rad * seen.width_rad / 12.0;
        let rows = &self.rows[0];
        if variance > 0.0 {
            let sd_rad = (variance + of_pixel - self.angles_variance).max(0.0).sqrt();
            rows.gaussian_stencil((seen.theta_rad, sd_rad), &mut room.stencil);
        } else {
            let place = RayPlace {
                theta_rad: seen.theta_rad,
                width_rad: seen.width_rad,
            };
            rows.stencil(&place, &mut room.stencil);
        }
        if let Some(rows) = &self.moved {
            let place = MovedPlace {
                theta_rad: seen.theta_rad,
                width_rad: (12.0 * (variance + of_pixel)).sqrt(),
                axis_squares: seen.axis_squares,
            };
            rows.place(&place, &mut room.moved);
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
            stencil,
            moved,
            part,
            irradiance,
        } = room;
        stencil.set_light(&deposits.bins);
        if let Some(rows) = &self.moved {
            rows.shade(stencil.light(), moved);
        }
        // None where nothing moves.
        let mut moved = moved.lights().iter();
        for (rows, irradiance) in self.rows.iter().zip(irradiance.iter()) {
            let share = in_front * f64::from(irradiance[frame.brightest]);
            luminance.add(share, &rows.luminance(stencil));
            rows.shade(stencil, part);
            if let Some(moved) = moved.next() {
                moved.add_to(part);
                luminance.add(share, &frame.moved_luminance(moved));
            }
            for (index, sum) in slab.iter_mut().enumerate() {
                *sum += in_front as f32 * irradiance[index] * part[index];
            }
        }
        luminance
    }
}
