//! The orders that are left out, as a geometric series.
//!
//! L_n+1 + L_n+2 + … = L_n r/(1 - r),  r = |L_n|/|L_n-1|
//! for each sun and wavelength; `|L|` is the light from all directions, summed over the heights. From
//! some order on every order has the form of the one before, so that r no longer changes; by how much
//! it still does says how far the sum may be off.

use crate::multiple_scattering::light::Light;

/// Largest ratio of two orders: that of the last two may reach 1 by rounding. Clouds and fogs that take nothing have
/// 0.99 and more; a ratio that is cut tells no error.
const LARGEST_RATIO: f64 = 0.9999;

/// Ratios of an order to the one before, by sun and wavelength.
pub(crate) struct Series {
    n_wavelengths: usize,
    ratios: Vec<f64>,
}

impl Series {
    pub(crate) fn new(n_suns: usize, n_wavelengths: usize) -> Self {
        Self {
            n_wavelengths,
            ratios: vec![0.0; n_suns * n_wavelengths],
        }
    }

    /// Takes the ratio of two orders, and says how far the sum that follows from it may be off.
    pub(crate) fn follow(&mut self, last: &Light, next: &Light, sum: &Light) -> f64 {
        let [last, next, sum] = [last, next, sum].map(|light| self.brightness(light));
        let mut worst = 0.0_f64;
        for (i, ratio) in self.ratios.iter_mut().enumerate() {
            if sum[i] <= 0.0 || last[i] <= 0.0 {
                *ratio = 0.0;
                continue;
            }
            let before = *ratio;
            *ratio = (next[i] / last[i]).clamp(0.0, LARGEST_RATIO);
            let tail = next[i] * *ratio / (1.0 - *ratio) / sum[i];
            // Both ratios 0 would mean that nothing is known yet, but then the tail is 0 too.
            worst = worst.max(tail * (*ratio - before).abs() / (1.0 - *ratio));
        }
        worst
    }

    /// Sum over shells of the light from all directions, by sun and wavelength.
    fn brightness(&self, light: &Light) -> Vec<f64> {
        let mut sum = vec![0.0; self.ratios.len()];
        let n_suns = self.ratios.len() / self.n_wavelengths;
        for (node, moments) in light.moments.chunks(light.block()).enumerate() {
            let row = &mut sum[node % n_suns * self.n_wavelengths..];
            for (sum, value) in row.iter_mut().zip(&moments[..self.n_wavelengths]) {
                *sum += f64::from(*value);
            }
        }
        sum
    }

    /// Adds the orders that follow the last.
    pub(crate) fn add_tail(&self, last: &Light, sum: &mut Light) {
        // f32: as the light.
        let factors = self
            .ratios
            .iter()
            .map(|ratio| (ratio / (1.0 - ratio)) as f32);
        let factors: Vec<f32> = factors.collect();
        let n_suns = self.ratios.len() / self.n_wavelengths;
        let mut tail = last.clone();
        let block = tail.block();
        for (node, moments) in tail.moments.chunks_mut(block).enumerate() {
            let factors = &factors[node % n_suns * self.n_wavelengths..];
            for row in moments.chunks_mut(self.n_wavelengths) {
                for (value, factor) in row.iter_mut().zip(factors) {
                    *value *= factor;
                }
            }
        }
        for (value, factor) in tail.on_ground.iter_mut().zip(&factors) {
            *value *= factor;
        }
        sum.add(&tail);
    }
}
