//! Smooth random functions of space.
//!
//! Gradient noise: at every point of the integer lattice a random gradient; between them the values
//! of the eight planes around, blended with  6t^5 - 15t^4 + 10t^3. Zero at the lattice points, within
//! about ±1, the same for the same seed.
//! [P02] K. Perlin, Improving noise, ACM Trans. Graphics 21, 681-682 (2002).

use glam::DVec3;

use crate::sampler::hash;

/// Noise at a point, -1..1.
pub(crate) fn gradient_noise(point: DVec3, seed: u32) -> f64 {
    let cell = point.floor();
    let within = point - cell;
    let fade = within * within * within * (within * (6.0 * within - 15.0) + 10.0);
    let mut sum = 0.0;
    for corner in 0..8 {
        let offset = DVec3::new(
            f64::from(corner & 1),
            f64::from(corner >> 1 & 1),
            f64::from(corner >> 2 & 1),
        );
        let share = fade * offset + (1.0 - fade) * (1.0 - offset);
        let value = gradient(cell + offset, seed).dot(within - offset);
        sum += share.x * share.y * share.z * value;
    }
    sum
}

/// Octaves of noise, each half as strong and twice as fine; within ±1.
pub(crate) fn fractal_noise(point: DVec3, n_octaves: u32, seed: u32) -> f64 {
    let octave = |k: u32| {
        let scale = f64::from(1_u32 << k);
        gradient_noise(point * scale, hash(seed ^ k)) / scale
    };
    0.5 * (0..n_octaves).map(octave).sum::<f64>()
}

fn gradient(lattice: DVec3, seed: u32) -> DVec3 {
    let words = lattice.to_array().map(|x| x as i64 as u32);
    let mixed = words
        .iter()
        .fold(seed, |state, word| hash(state ^ hash(*word)));
    // Bits 0 to 9, 10 to 19 and 20 to 29 as coordinates.
    let part = |shift: u32| f64::from(mixed >> shift & 1023) / 511.5 - 1.0;
    DVec3::new(part(0), part(10), part(20)).normalize_or(DVec3::Y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_bounded_and_zero_on_the_lattice() {
        assert_eq!(gradient_noise(DVec3::new(3.0, -2.0, 5.0), 1), 0.0);
        let at = |step: i32| {
            let along = -5.0 + 1e-3 * f64::from(step);
            gradient_noise(DVec3::new(along, 0.7 * along, 0.3 - along), 1)
        };
        for step in 0..10_000 {
            // Slopes stay below 4 along this line; worst found 3.
            assert!(at(step).abs() <= 1.0 && (at(step + 1) - at(step)).abs() < 5e-3);
        }
    }

    #[test]
    fn seeds_make_different_noise() {
        let point = DVec3::new(0.3, 0.4, 0.5);
        assert_ne!(gradient_noise(point, 1), gradient_noise(point, 2));
        assert!(fractal_noise(point, 5, 1).abs() <= 1.0);
    }
}
