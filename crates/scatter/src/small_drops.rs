//! What small drops and diffraction make of the uniform light of a table by size, one wavelength at a time.
//!
//! A bin or single size:   t = (1 − W) t_u + [W t_exact + (1 − W) t_d]
//! A law:                  t = t_u + [t_d + Σ_i w_i W_i (t_exact,i − t_u,i − t_d,i)]
//! `t_u` uniform light, `t_d` diffracted light, `W` the share of [`crate::by_size`], `w_i` weights of single
//! drops in the law. What stands in brackets is added here.

use std::f64::consts::PI;
use std::f64::consts::TAU;

use crate::bow_light::Bin;
use crate::bow_light::Places;
use crate::bow_rows::BowRows;
use crate::bow_rows::SizeRow;
use crate::bow_rows::bin_variance;
use crate::bow_rows::places;
use crate::by_size::Blend;
use crate::diffraction::Diffraction;
use crate::drop_rows::DropRows;
use crate::error::Error;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::size_average::SizeNode;
use crate::sun_disc::AverageRow;
use crate::theory::Theory;

/// A table that starts at larger angles has next to nothing of the diffracted light, 2e-4/sr at most.
const DIFFRACTION_ENDS_RAD: f64 = PI / 3.0;

/// All that takes the place of uniform light.
pub(crate) struct SmallDrops<'a> {
    request: &'a TableRequest<'a>,
    drops: DropRows<'a>,
    blend: Blend,
    diffracted: Option<DiffractedLight>,
    n_angles: usize,
}

/// A row of a table by size.
pub(crate) struct RowLight {
    /// What is left of its uniform light.
    pub(crate) uniform_share: f64,
    /// What is added to it, by angle and polarization, 1/sr.
    pub(crate) added: Vec<[f64; 2]>,
}

impl<'a> SmallDrops<'a> {
    pub(crate) fn new(request: &'a TableRequest<'a>, theta_rad: &[f64]) -> Result<Self, Error> {
        let diffracts = theta_rad[0] < DIFFRACTION_ENDS_RAD;
        let diffracted = diffracts.then(|| DiffractedLight::new(request, theta_rad));
        Ok(Self {
            request,
            drops: DropRows::new(request, theta_rad)?,
            blend: Blend::new(request)?,
            diffracted: diffracted.transpose()?,
            n_angles: theta_rad.len(),
        })
    }

    pub(crate) fn n_drops(&self) -> usize {
        self.drops.nodes().len()
    }

    /// Single drops that are in laws, whose uniform light is taken out of these; `None` without any.
    pub(crate) fn in_laws(&self) -> Option<TableRequest<'a>> {
        let nodes = self.nodes_in_laws();
        let radii: Vec<f64> = nodes.map(|node| node.radius.0).collect();
        (!radii.is_empty()).then(|| TableRequest {
            theory: Theory::Uniform,
            effective_radius_um: radii,
            effective_variance: vec![0.0],
            rows: SizeRows::Laws,
            motion: None,
            ..self.request.clone()
        })
    }

    /// Every row at a wavelength, of all light and then of each order that is kept apart; `uniform` are the
    /// rows of [`Self::in_laws`].
    pub(crate) fn at(
        &self,
        wavelength_index: usize,
        uniform: Option<&BowRows>,
        count: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<RowLight>, Error> {
        let bin = Bin::new(self.request, wavelength_index);
        let mut exact = self.drops.at(bin, count)?;
        let n_variances = self.request.effective_variance.len();
        let n_rows = self.request.effective_radius_um.len() * n_variances;
        let n_parts = 1 + self.request.moved_orders().len();
        // None where there is no drop.
        exact.resize_with(n_parts * n_rows, || vec![[0.0; 2]; self.n_angles]);
        if let Some(uniform) = uniform {
            self.take_out_of_laws((&mut exact, wavelength_index), uniform);
        }
        let row = |(index, mut added): (usize, Vec<[f64; 2]>)| {
            let row = index % n_rows;
            let share = self.blend.share(row, bin.center);
            // The share of a drop in a law is in its weight.
            let (of_exact, of_uniform) = if self.blend.is_mixed_law(row) {
                (1.0, 1.0)
            } else {
                (share, 1.0 - share)
            };
            for light in added.iter_mut().flatten() {
                *light *= of_exact;
            }
            let is_diffracted = index < n_rows && of_uniform > 0.0;
            if let Some(diffracted) = self.diffracted.as_ref().filter(|_| is_diffracted) {
                let radius_um = self.request.effective_radius_um[row / n_variances];
                let x = TAU * 1e3 * radius_um / bin.center.0;
                let light = diffracted.light(row % n_variances, x);
                for (sum, light) in added.iter_mut().zip(light) {
                    *sum = sum.map(|sum| sum + of_uniform * light);
                }
            }
            RowLight {
                uniform_share: of_uniform,
                added,
            }
        };
        Ok(exact.into_iter().enumerate().map(row).collect())
    }

    /// Takes the light that the uniform theory has of single drops out of the rows of laws.
    fn take_out_of_laws(
        &self,
        (rows, wavelength_index): (&mut [Vec<[f64; 2]>], usize),
        uniform: &BowRows,
    ) {
        let wavelength = self.request.wavelengths.center(wavelength_index);
        for (index, node) in self.nodes_in_laws().enumerate() {
            let size = SizeRow {
                radius_index: index,
                variance_index: 0,
            };
            let mut light = uniform.row(wavelength_index, &size);
            if let Some(diffracted) = &self.diffracted {
                let x = TAU * 1e3 * node.radius.0 / wavelength.0;
                let single = diffracted.of_one_size(x);
                for (sum, light) in light.iter_mut().zip(single) {
                    *sum = sum.map(|sum| sum + light);
                }
            }
            let laws = node
                .uses
                .iter()
                .filter(|(row, _)| self.blend.is_mixed_law(*row));
            for &(row, weight) in laws {
                let weight = weight * self.blend.weight(row, node.radius, wavelength);
                for (sum, light) in rows[row].iter_mut().zip(&light) {
                    *sum = [sum[0] - weight * light[0], sum[1] - weight * light[1]];
                }
            }
        }
    }

    fn nodes_in_laws(&self) -> impl Iterator<Item = &SizeNode> {
        let is_in_law = |(row, _): &(usize, f64)| self.blend.is_mixed_law(*row);
        let nodes = self.drops.nodes().iter();
        nodes.filter(move |node| node.uses.iter().any(is_in_law))
    }
}

/// Diffracted light at the angles of a table.
struct DiffractedLight {
    places: Places,
    averages: Option<Vec<AverageRow>>,
    /// By effective variance.
    laws: Vec<Diffraction>,
    one_size: Diffraction,
}

impl DiffractedLight {
    fn new(request: &TableRequest, theta_rad: &[f64]) -> Result<Self, Error> {
        let places = places(request, theta_rad);
        let radius_rad = 0.5 * request.sun_disc_diameter_rad;
        let averages = match &places {
            // The lobe of large drops lies within a ring.
            Places::Rings(rings) => Some(
                theta_rad
                    .iter()
                    .map(|&theta| rings.even_disc_row(theta, radius_rad))
                    .collect(),
            ),
            Places::Angles(_) => None,
        };
        let law = |variance: &f64| {
            let variance = variance.max(bin_variance(request));
            Diffraction::new(variance)
        };
        Ok(Self {
            laws: (request.effective_variance.iter())
                .map(law)
                .collect::<Result<_, _>>()?,
            one_size: Diffraction::new(0.0)?,
            places,
            averages,
        })
    }

    fn light(&self, variance_index: usize, x: f64) -> Vec<f64> {
        self.averaged(self.laws[variance_index].light(&self.places, x))
    }

    fn of_one_size(&self, x: f64) -> Vec<f64> {
        self.averaged(self.one_size.light(&self.places, x))
    }

    fn averaged(&self, light: Vec<f64>) -> Vec<f64> {
        let Some(averages) = &self.averages else {
            return light;
        };
        let pairs: Vec<[f64; 2]> = light.into_iter().map(|light| [light; 2]).collect();
        averages.iter().map(|row| row.apply(&pairs)[0]).collect()
    }
}
