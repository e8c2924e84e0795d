//! Which orders besides the two bows are worth their time at the angles that are seen.
//!
//! p = 0 is light reflected outside a drop, at all angles; p = 1 goes through and ends at
//! pi - 2 asin(1/n), 83 degrees, where it grazes; p = 4 and 5 make bows 43 degrees from the sun, p = 6
//! and 7 near 130 and 117 degrees, most of it inside Alexander's band. Away from its bow an order above 3 is
//! weaker than 1 % of the reflected light, and left out.

use niji_airy::GeometricOrder;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;

/// All of them.
const ORDERS: [u32; 6] = [0, 1, 4, 5, 6, 7];

/// The wavelength that stands for all.
const WAVELENGTH: Nanometers = Nanometers(560.0);

/// Beyond the angles in view: the sun's disc, colors, and the dark side of a bow, rad.
const REACH_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Step between angles, rad; the light of a caustic is wider.
const STEP_RAD: f64 = 0.25 * std::f64::consts::PI / 180.0;

/// Share of the light of all these orders below which one is left out.
const NEGLIGIBLE: f64 = 0.01;

/// The orders that matter somewhere between two scattering angles.
pub(super) fn orders_seen((low_rad, high_rad): (f64, f64), water: Water) -> Vec<u32> {
    let index = water.refractive_index(WAVELENGTH);
    let orders: Vec<(u32, GeometricOrder)> = ORDERS
        .into_iter()
        .filter_map(|order| Some((order, GeometricOrder::new(index, order)?)))
        .collect();
    let mut seen = vec![false; orders.len()];
    let first_rad = (low_rad - REACH_RAD).max(0.0);
    let last_rad = (high_rad + REACH_RAD).min(std::f64::consts::PI);
    let n_steps = ((last_rad - first_rad).max(0.0) / STEP_RAD).ceil() as usize;
    for step in 0..=n_steps {
        let theta = Radians((first_rad + STEP_RAD * step as f64).min(last_rad));
        let light = |(_, rays): &(u32, GeometricOrder)| {
            let [s, p] = rays.normalized_cross_section(theta);
            s + p
        };
        let lights: Vec<f64> = orders.iter().map(light).collect();
        let total: f64 = lights.iter().sum();
        for (seen, light) in seen.iter_mut().zip(&lights) {
            *seen |= *light > NEGLIGIBLE * total;
        }
    }
    let kept = orders.iter().zip(seen).filter(|(_, seen)| *seen);
    kept.map(|((order, _), _)| *order).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WATER: Water = Water::pure(15.0);

    fn seen(low_deg: f64, high_deg: f64) -> Vec<u32> {
        orders_seen((low_deg.to_radians(), high_deg.to_radians()), WATER)
    }

    #[test]
    fn reflection_is_everywhere_and_light_goes_through_below_83_degrees() {
        for low_deg in [0.0, 30.0, 60.0, 78.0, 90.0, 120.0, 170.0] {
            let orders = seen(low_deg, low_deg + 5.0);
            assert!(orders.contains(&0), "{low_deg}: {orders:?}");
            assert_eq!(orders.contains(&1), low_deg < 85.0, "{low_deg}: {orders:?}");
        }
    }

    #[test]
    fn each_order_is_seen_at_its_bow() {
        let index = WATER.refractive_index(WAVELENGTH);
        for order in [6, 7] {
            let bow = niji_airy::rainbow_ray(index, order).unwrap();
            let bow_deg = bow.theta_rad().to_degrees();
            assert!(seen(bow_deg - 1.0, bow_deg + 1.0).contains(&order));
        }
        // The bows of p = 4 and 5 stand in the far brighter light that goes through.
        assert_eq!(seen(50.0, 60.0), [0, 1]);
    }
}
