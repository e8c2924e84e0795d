//! What diffraction changes in the bows along a ray.

use niji_geometry::Ray;

use crate::air_slabs::AirSlabs;
use crate::angle_axis::RayPlace;
use crate::drop_orders::Diffraction;
use crate::drop_orders::DiffractionRoom;
use crate::frame::Frame;
use crate::march::Walk;
use crate::scattering_rows::ScatteringRows;

impl Frame<'_> {
    /// Add to `out` what diffraction changes in the light of a ray; air dims it as at its mean
    /// distance.
    pub(crate) fn add_diffracted(
        &self,
        diffraction: &Diffraction,
        (ray, range_m): (&Ray, (f64, f64)),
        place: &RayPlace,
        (room, out): (&mut DiffractionRoom, &mut [f32]),
    ) {
        let DiffractionRoom {
            deposits,
            stencil,
            slab_ends_m,
            spectrum,
            transmitted,
        } = room;
        diffraction.blurred.stencil(place, stencil);
        let air = self.air.as_ref().filter(|_| !self.dimmed_by.nothing());
        let slabs = air.map(|air| AirSlabs::cut(air, self.dimmed_by, ray, range_m, slab_ends_m));
        let walk = Walk {
            ray,
            range_m,
            axes: Some(diffraction.blurred.axes()),
            slab_ends_m: &[],
        };
        for (march, sign) in &diffraction.marches {
            march.along(&walk, &mut [], deposits, |deposits| {
                stencil.set_light(&deposits.bins);
                transmitted.fill(1.0);
                if let Some(slabs) = &slabs {
                    slabs.transmit(deposits, transmitted);
                }
                let mut add = |rows: &ScatteringRows, sign: f32| {
                    rows.shade(stencil, spectrum);
                    let dimmed = spectrum.iter().zip(&*transmitted).zip(&self.irradiance);
                    for (sum, ((value, transmitted), irradiance)) in out.iter_mut().zip(dimmed) {
                        *sum += sign * value * transmitted * irradiance;
                    }
                };
                add(&diffraction.blurred, *sign);
                if let Some(sharp) = &diffraction.sharp {
                    add(sharp, -sign);
                }
            });
        }
    }
}
