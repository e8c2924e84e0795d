//! Light at every node, and what air and ground make of it.

use std::f64::consts::PI;

use niji_exchange::AtmosphereTable;
use niji_exchange::expansion_weights;
use niji_exchange::moment_index;
use niji_exchange::n_moments;

/// Moments of one order of scattering, or of the sum of all.
#[derive(Debug, Clone)]
pub(crate) struct Light {
    pub(crate) max_degree: usize,
    /// Largest order m that is not 0.
    pub(crate) max_order: usize,
    pub(crate) n_suns: usize,
    pub(crate) n_wavelengths: usize,
    /// `[shell][sun][moment][wavelength]`
    // f32: the solution is good to 1e-3.
    pub(crate) moments: Vec<f32>,
    /// Irradiance on the ground: `[sun][wavelength]`.
    pub(crate) on_ground: Vec<f32>,
}

impl Light {
    /// Values of one shell and sun.
    pub(crate) fn block(&self) -> usize {
        n_moments(self.max_degree) * self.n_wavelengths
    }

    /// Moments at one shell: `[sun][moment][wavelength]`.
    pub(crate) fn at_shell(&self, shell: usize) -> &[f32] {
        let n = self.n_suns * self.block();
        &self.moments[shell * n..(shell + 1) * n]
    }

    pub(crate) fn is_dark(&self) -> bool {
        // Stored zeros.
        self.moments
            .iter()
            .chain(&self.on_ground)
            .all(|value| *value == 0.0)
    }

    /// Adds another light of the same size.
    pub(crate) fn add(&mut self, more: &Self) {
        for (value, more) in self.moments.iter_mut().zip(&more.moments) {
            *value += more;
        }
        for (value, more) in self.on_ground.iter_mut().zip(&more.on_ground) {
            *value += more;
        }
    }

    /// Light times what air and ground make of it: the source that the next order gathers, up to an
    /// order m. `ratios` are q_l at every shell.
    pub(crate) fn to_source(
        &self,
        air: &AtmosphereTable,
        ratios: &[Vec<f64>],
        max_order: usize,
    ) -> Self {
        let n = self.n_wavelengths;
        let expansion = expansion_weights(self.max_degree);
        let block = self.block();
        let mut moments = Vec::with_capacity(self.moments.len());
        for (shell, ratios) in self.moments.chunks(self.n_suns * block).zip(ratios) {
            for node in shell.chunks(block) {
                for l in 0..=self.max_degree {
                    let ratios = &ratios[l * n..(l + 1) * n];
                    for m in 0..=l {
                        let pair = moment_index(l, m);
                        let row = node[pair * n..(pair + 1) * n].iter().zip(ratios);
                        moments.extend(
                            row.map(|(value, ratio)| value * (expansion[pair] * ratio) as f32),
                        );
                    }
                }
            }
        }
        let reflected = |row: &[f32]| {
            let row = row.iter().zip(&air.ground_albedo);
            row.map(|(value, albedo)| value * (albedo / PI) as f32)
                .collect::<Vec<_>>()
        };
        let on_ground = self.on_ground.chunks(n.max(1)).flat_map(reflected);
        Self {
            max_order: max_order.min(self.max_order),
            moments,
            on_ground: on_ground.collect(),
            ..*self
        }
    }
}

/// target += factor * values.
pub(crate) fn add_scaled(target: &mut [f32], factor: f32, values: &[f32]) {
    for (target, value) in target.iter_mut().zip(values) {
        *target += factor * value;
    }
}
