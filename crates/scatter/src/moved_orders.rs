//! Which drops of a table are so flat that their bows move, and how.
//!
//! Bows of smaller drops stay where spheres make them, and their light is not kept apart: e |k| < 0.01 degrees,
//! half of a 25th of the sun's diameter, with e and k of [`niji_exchange::BowShift`].

use std::f64::consts::PI;

use ndarray::Array4;
use niji_exchange::BowShift;
use niji_exchange::FallingDrops;
use niji_exchange::MovedBows;
use niji_exchange::MovedOrder;
use niji_radiometry::Micrometers;

use crate::bow_shift::bow_shift;
use crate::request::TableRequest;

/// Bows that move by less stay.
const STILL_RAD: f64 = 0.01 * PI / 180.0;

/// The orders whose light is kept apart, and the drops that move it.
#[derive(Clone, Debug)]
pub(crate) struct MovedOrders {
    pub(crate) orders: Vec<u32>,
    /// How many radii of the table stay; those of all drops where nothing is kept apart.
    pub(crate) n_still: usize,
    drops: Vec<FallingDrops>,
    /// By order and wavelength.
    shifts: Vec<Vec<BowShift>>,
}

impl TableRequest<'_> {
    /// Does the table keep light apart that flattening moves? Not where all drops are too small.
    #[must_use]
    pub fn moves(&self) -> bool {
        !MovedOrders::new(self).orders.is_empty()
    }
}

impl MovedOrders {
    pub(crate) fn new(request: &TableRequest) -> Self {
        let of_order = |&order: &u32| {
            let at = |wavelength| {
                // An order without a bow stays.
                bow_shift(request.water.refractive_index(wavelength), order).unwrap_or_default()
            };
            request.wavelengths.centers().map(at).collect()
        };
        let mut orders = request.moved_orders();
        let shifts: Vec<Vec<BowShift>> = orders.iter().map(of_order).collect();
        let largest = shifts.iter().flatten();
        let k_rad = largest.fold(0.0_f64, |k, shift| k.max(shift.coefficients_rad[0].abs()));
        let radii = request.effective_radius_um.iter().copied().map(Micrometers);
        let mut drops: Vec<FallingDrops> = request.motion.map_or(Vec::new(), |motion| {
            radii.map(|radius| motion.drops(radius)).collect()
        });
        let n_still = drops.partition_point(|drops| k_rad * drops.eccentricity < STILL_RAD);
        drops.drain(..n_still);
        if drops.is_empty() {
            orders.clear();
        }
        Self {
            orders,
            n_still: request.effective_radius_um.len() - drops.len(),
            drops,
            shifts,
        }
    }

    /// The orders of a radius whose light is kept apart.
    pub(crate) fn of_radius(&self, radius_index: usize) -> &[u32] {
        if radius_index < self.n_still {
            &[]
        } else {
            &self.orders
        }
    }

    /// How many radii move.
    pub(crate) fn n_moved(&self) -> usize {
        self.drops.len()
    }

    /// What the table holds of them, with the angles and the light of each; `None` where nothing moves.
    pub(crate) fn bows(
        self,
        light: impl Iterator<Item = (Vec<f64>, Array4<f32>)>,
    ) -> Option<MovedBows> {
        let orders = self.orders.into_iter().zip(self.shifts).zip(light);
        let orders: Vec<MovedOrder> = orders
            .map(|((order, shifts), (theta_rad, values))| MovedOrder {
                order,
                shifts,
                theta_rad,
                values,
            })
            .collect();
        (!orders.is_empty()).then_some(MovedBows {
            drops: self.drops,
            orders,
        })
    }
}
