//! Claims about flights.

use super::*;

/// A drop thrown at 10 m/s, 80 degrees above the horizon.
fn throw(radius_m: f64, wind_x_m_s: f64) -> Launch {
    let (sin, cos) = 80.0_f64.to_radians().sin_cos();
    Launch {
        radius_m,
        position: DVec3::ZERO,
        velocity: 10.0 * DVec3::new(cos, sin, 0.0),
        wind: DVec3::new(wind_x_m_s, 0.0, 0.0),
        basin_y_m: 0.0,
    }
}

/// Apex (m), range (m) and time (s) of a flight.
fn flight(launch: &Launch) -> [f64; 3] {
    let (mut apex, mut range, mut time) = (0.0_f64, 0.0, 0.0);
    launch.fly(|step| {
        for part in 0..=16 {
            apex = apex.max(step.place(f64::from(part) / 16.0).y);
        }
        range = step.end.0.x;
        time += step.time_s;
    });
    [apex, range, time]
}

/// A radius so large that drag is nothing (m).
const NO_DRAG_RADIUS_M: f64 = 1e5;

#[test]
fn without_drag_flights_are_parabolas() {
    for basin_y_m in [0.0, -3.0] {
        let launch = Launch {
            basin_y_m,
            ..throw(NO_DRAG_RADIUS_M, 0.0)
        };
        let [apex, range, time] = flight(&launch);
        let (up, along) = (launch.velocity.y, launch.velocity.x);
        let seconds = (up + (up * up - 2.0 * 9.80665 * basin_y_m).sqrt()) / 9.80665;
        // Measured worst below 1e-7: what is left of drag, and roundoff, since V is 5e8 m/s.
        assert!((time / seconds - 1.0).abs() < 1e-7, "{time}");
        assert!((range / (along * seconds) - 1.0).abs() < 1e-7, "{range}");
        // Sixteen looks a step find the top to 1e-4.
        assert!(
            (apex / (up * up / (2.0 * 9.80665)) - 1.0).abs() < 2e-4,
            "{apex}"
        );
    }
}

#[test]
fn flights_with_drag_are_those_of_an_adaptive_integrator() {
    // Diameter (mm), apex (m), range in calm air and in a wind of 3 m/s (m), computed once with an
    // adaptive Runge-Kutta method and printed to 0.01 m.
    for (diameter_mm, apex, calm, windy) in [
        (0.1, 0.11, 0.02, 1.65),
        (0.2, 0.30, 0.07, 1.85),
        (0.5, 0.88, 0.29, 2.52),
        (1.0, 1.66, 0.68, 3.08),
        (2.0, 2.64, 1.33, 3.46),
        (4.0, 3.42, 1.99, 3.56),
    ] {
        let found = flight(&throw(0.5e-3 * diameter_mm, 0.0));
        let blown = flight(&throw(0.5e-3 * diameter_mm, 3.0));
        for (found, printed) in [(found[0], apex), (found[1], calm), (blown[1], windy)] {
            // Half a unit of the last digit, and 0.15 % of the steps.
            let off: f64 = found - printed;
            assert!(
                off.abs() < 0.005 + 1.5e-3 * printed,
                "{diameter_mm}: {found} {printed}"
            );
        }
    }
}

#[test]
fn falling_drops_settle_at_measured_speeds() {
    // Gunn and Kinzer, J. Meteorology 6, 243-248 (1949): diameter (mm), speed (m/s). A sphere is 8 %
    // slow at 0.1 mm and, for want of flattening, 7 % fast at 2 mm.
    for (diameter_mm, measured) in [(0.1, 0.27), (0.5, 2.06), (1.0, 4.03), (2.0, 6.49)] {
        let launch = Launch {
            basin_y_m: -50.0,
            ..throw(0.5e-3 * diameter_mm, 2.0)
        };
        let mut velocity = DVec3::ZERO;
        launch.fly(|step| velocity = step.end.1);
        assert!((-velocity.y / measured - 1.0).abs() < 0.09, "{velocity}");
        assert!((velocity.x - 2.0).abs() < 1e-3, "{velocity}");
    }
}

#[test]
fn steps_far_longer_than_the_response_time_are_stable() {
    // A drop of 0.02 mm responds within 1.2 ms; the last steps on its way take seconds.
    let launch = Launch {
        basin_y_m: -1.0,
        ..throw(1e-5, 3.0)
    };
    let tau = response_time_s(1e-5, 0.0);
    let mut late: Vec<DVec3> = Vec::new();
    let mut longest = 0.0_f64;
    launch.fly(|step| {
        longest = longest.max(step.time_s);
        if step.start.0.y < 0.0 {
            late.push(step.end.1);
        }
    });
    assert!(longest > 1000.0 * tau, "{longest} {tau}");
    for velocity in late {
        // Stokes' speed less 0.15 Re^0.687 = 0.9 %, and the wind.
        assert!(
            (-velocity.y / (9.80665 * tau) - 0.991).abs() < 2e-3,
            "{velocity}"
        );
        assert!((velocity.x - 3.0).abs() < 1e-6);
    }
}

#[test]
fn a_step_is_the_cubic_of_its_ends() {
    // x = t³ has the velocity 3 t².
    let step = Step {
        start: (DVec3::ONE, DVec3::splat(3.0)),
        end: (DVec3::splat(8.0), DVec3::splat(12.0)),
        time_s: 1.0,
    };
    for share in [0.0, 0.25, 0.5, 0.9, 1.0] {
        let cubic = (1.0_f64 + share).powi(3);
        assert!((step.place(share).x - cubic).abs() < 1e-14);
    }
}

#[test]
fn a_drop_that_leaves_downwards_at_the_basin_is_lost_at_once() {
    let launch = Launch {
        velocity: DVec3::new(1.0, -2.0, 0.0),
        ..throw(1e-3, 0.0)
    };
    assert!(flight(&launch)[2] < 1e-9);
    let unsound = Launch {
        velocity: DVec3::NAN,
        ..throw(1e-3, 0.0)
    };
    let mut n_steps = 0;
    unsound.fly(|_| n_steps += 1);
    assert_eq!(n_steps, 1);
}
