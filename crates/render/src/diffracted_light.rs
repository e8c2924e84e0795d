//! What diffraction changes in the bows along a ray.

use crate::air_slabs::AirSlabs;
use crate::air_slabs::AirWay;
use crate::angle_axis::RayPlace;
use crate::drop_orders::Diffraction;
use crate::drop_orders::DiffractionRoom;
use crate::frame::Frame;
use crate::march::Walk;
use crate::ray_settings::RayThroughDrops;
use crate::scattering_rows::ScatteringRows;

impl Frame<'_> {
    /// What diffraction changes in the light of a ray at its scattering angles, as the light of a room; air dims
    /// it as at its mean distance.
    pub(crate) fn diffracted(
        &self,
        diffraction: &Diffraction,
        way: RayThroughDrops,
        place: &RayPlace,
        room: &mut DiffractionRoom,
    ) {
        let RayThroughDrops {
            ray,
            range_m,
            settings,
        } = way;
        let DiffractionRoom {
            light,
            deposits,
            stencil,
            slab_ends_m,
            spectrum,
            transmitted,
        } = room;
        light.fill(0.0);
        diffraction.blurred.stencil(place, stencil);
        let air = settings.air.filter(|_| !self.dimmed_by.nothing());
        let way = |air| AirWay {
            air,
            dimmed_by: self.dimmed_by,
            ray,
            range_m,
        };
        let slabs = air.map(|air| AirSlabs::cut(way(air), slab_ends_m));
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
                    for (sum, ((value, transmitted), irradiance)) in light.iter_mut().zip(dimmed) {
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
