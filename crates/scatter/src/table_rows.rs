//! The rows of a table, one wavelength at a time: light of bows, of single drops, or of both.
//!
//! A bin or single size:   t = (1 − W) (t_b + t_d) + Σ_i w_i W t_i
//! A law:                  t = t_b + t_d + Σ_i w_i W_i (t_i − t_b,i − t_d,i)
//! `t_b` bows; `t_d` diffracted light, which a table by size adds to them; `t_i` single drops, `w_i` their weights
//! in the row; `W` their share by [`crate::by_size`], 0 or 1 where a theory has one kind of light alone.

use crate::bow_light::Bin;
use crate::bow_rows::BowLights;
use crate::bow_rows::BowRows;
use crate::bow_rows::Drops;
use crate::by_size::Blend;
use crate::diffraction::DiffractedLight;
use crate::drop_rows::DropRows;
use crate::drop_rows::Rows;
use crate::error::Error;
use crate::moved_orders::MovedOrders;
use crate::progress::Count;
use crate::request::SizeRow;
use crate::request::TableRequest;

/// Light of both polarizations by angle, 1/sr.
pub(crate) type RowLight = Vec<[f64; 2]>;

/// A table to be made, with what follows from its request.
#[derive(Clone, Copy)]
pub(crate) struct Task<'a> {
    pub(crate) request: &'a TableRequest<'a>,
    pub(crate) theta_rad: &'a [f64],
    pub(crate) blend: &'a Blend,
    pub(crate) moved: &'a MovedOrders,
}

/// All that makes its rows.
pub(crate) struct TableRows<'a> {
    task: Task<'a>,
    bows: Option<BowRows<'a>>,
    drops: Option<DropRows<'a>>,
    diffracted: Option<DiffractedLight>,
}

impl<'a> TableRows<'a> {
    /// `lights` is what is known of the bows already.
    pub(crate) fn new(task: Task<'a>, lights: Option<BowLights>) -> Result<Self, Error> {
        let Task {
            request, theta_rad, ..
        } = task;
        let method = request.theory.method();
        let bows = || -> Result<BowRows<'a>, Error> {
            let lights = lights.map_or_else(|| BowLights::new(request, theta_rad), Ok)?;
            Ok(BowRows::new(request, lights, theta_rad))
        };
        let drops = |method| DropRows::new(task, method);
        let diffracted = || DiffractedLight::of_request(request, theta_rad);
        Ok(Self {
            task,
            // Single drops have their own.
            diffracted: method.bows.map_or(Ok(None), |_| diffracted())?,
            bows: method.bows.map(|_| bows()).transpose()?,
            drops: method.drops.map(drops).transpose()?,
        })
    }

    /// How many drops are computed for a wavelength.
    pub(crate) fn n_drops(&self) -> usize {
        self.drops.as_ref().map_or(0, |drops| drops.nodes.len())
    }

    /// What single drops add to the rows at a wavelength; out of laws with bows the bows of these drops are taken.
    pub(crate) fn of_drops(&self, wavelength_index: usize, count: Count) -> Result<Rows, Error> {
        let Some(drops) = &self.drops else {
            return Ok(Rows::new());
        };
        let Task { request, blend, .. } = self.task;
        let bin = Bin::new(request, wavelength_index);
        let mut rows = drops.at(bin, count)?;
        let Some(bows) = &self.bows else {
            return Ok(rows);
        };
        let orders = request.orders_in();
        for node in &drops.nodes {
            let mut laws = node.uses.clone();
            laws.retain(|(row, _)| blend.is_mixed_law(*row));
            if laws.is_empty() {
                continue;
            }
            let drops = Drops {
                radius: node.radius,
                variance_index: None,
            };
            let mut light = bows.light(wavelength_index, drops, &orders);
            if let Some(diffracted) = &self.diffracted {
                add(&mut light, 1.0, &diffracted.light(drops, bin.center));
            }
            for (row, weight) in laws {
                let share = blend.share_of_drop(row, node.radius, bin.center);
                add(&mut rows[row], -weight * share, &light);
            }
        }
        Ok(rows)
    }

    /// A row: all of its light, and then that of each order that is kept apart. `of_drops` is what
    /// [`Self::of_drops`] has for all rows.
    pub(crate) fn row(&self, wavelength_index: usize, row: &SizeRow, of_drops: &Rows) -> Rows {
        let Task { request, moved, .. } = self.task;
        let moved = moved.of_radius(row.radius_index);
        let part = |part: usize| {
            let of_drops = of_drops.get(part * request.n_rows() + row.index);
            let none = || vec![[0.0; 2]; self.task.theta_rad.len()];
            of_drops.cloned().unwrap_or_else(none)
        };
        let mut parts: Rows = (0..=moved.len()).map(part).collect();
        let wavelength = request.wavelengths.center(wavelength_index);
        let share = self.task.blend.share_of_bows(row.index, wavelength);
        let Some(bows) = self.bows.as_ref().filter(|_| share > 0.0) else {
            return parts;
        };
        let drops = Drops::of_row(row);
        let mut still = request.orders_in();
        still.retain(|p| !moved.contains(p));
        // Orders that move are one part each; those that stay have none beside all light.
        let groups = moved.iter().map(|p| vec![*p]).chain([still]);
        for (index, orders) in groups.enumerate().filter(|(_, orders)| !orders.is_empty()) {
            let mut light = bows.light(wavelength_index, drops, &orders);
            // The sun's disc is averaged over parabolas through the means of neighboring rings, which undershoot
            // zero by up to 1e-5 of the peak where the dark side falls steeply.
            for both in &mut light {
                *both = both.map(|value| value.max(0.0));
            }
            add(&mut parts[0], share, &light);
            if let Some(of_order) = parts.get_mut(1 + index) {
                add(of_order, share, &light);
            }
        }
        if let Some(diffracted) = &self.diffracted {
            add(&mut parts[0], share, &diffracted.light(drops, wavelength));
        }
        parts
    }
}

/// Adds light times a weight.
pub(crate) fn add(sum: &mut RowLight, weight: f64, light: &RowLight) {
    for (sum, light) in sum.iter_mut().zip(light) {
        *sum = [sum[0] + weight * light[0], sum[1] + weight * light[1]];
    }
}
