//! Where the color edges of a bow lie.

use std::f64::consts::PI;

use niji_airy::rainbow_ray;
use niji_photo::BowAnglePrior;
use niji_photo::PickedEdge;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_scene::PickedBow;
use niji_scene::PickedColor;

/// How far the edge that people pick scatters (rad), 0.4 degrees: drop size and flattening move it.
pub const EDGE_ERROR: Radians = Radians(0.4 * (PI / 180.0));

/// A color edge of a bow in some water.
#[derive(Clone, Copy, Debug)]
pub struct BowEdge {
    /// Which bow.
    pub bow: PickedBow,
    /// Which color of it.
    pub color: PickedColor,
    /// What the drops are made of, checked.
    pub water: Water,
}

impl BowEdge {
    /// Its angle from the antisolar point, for large drops and a point sun.
    ///
    /// # Panics
    /// For water that was not checked.
    pub fn angle(self) -> Radians {
        let wavelength = match self.color {
            PickedColor::Red => Nanometers(650.0),
            PickedColor::Middle => Nanometers(550.0),
            PickedColor::Violet => Nanometers(410.0),
        };
        let ray = rainbow_ray(self.water.refractive_index(wavelength), self.order());
        let ray = ray.expect("water that was checked has 1 < n < 2, so both bows exist");
        Radians(PI - ray.theta_rad())
    }

    /// What is picked, as the fit takes it, where the edge is expected at an angle with a standard error.
    ///
    /// # Panics
    /// As [`Self::angle`].
    pub fn picked(self, angle: Radians, standard_error: Radians) -> PickedEdge {
        let color = match self.color {
            PickedColor::Red | PickedColor::Middle => PickedColor::Violet,
            PickedColor::Violet => PickedColor::Red,
        };
        let other = Self { color, ..self };
        PickedEdge {
            order: self.order(),
            expected: BowAnglePrior {
                angle,
                standard_error,
            },
            other_edge: Radians(other.angle().0 - self.angle().0),
        }
    }

    /// 2 of the primary bow, 3 of the secondary.
    fn order(self) -> u32 {
        match self.bow {
            PickedBow::Primary => 2,
            PickedBow::Secondary => 3,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_lie_where_textbooks_put_them() {
        // Lee and Fraser, The Rainbow Bridge (2001): primary 42.4 red to 40.5 violet, secondary 50.4
        // red to 53.6 violet, for slightly wider ranges of color.
        for (bow, color, expected_deg) in [
            (PickedBow::Primary, PickedColor::Red, 42.4),
            (PickedBow::Primary, PickedColor::Violet, 40.6),
            (PickedBow::Secondary, PickedColor::Red, 50.4),
            (PickedBow::Secondary, PickedColor::Violet, 53.5),
        ] {
            let water = Water::pure(15.0);
            let found_deg = BowEdge { bow, color, water }.angle().to_degrees();
            assert!(
                (found_deg - expected_deg).abs() < 0.25,
                "{bow:?} {color:?} {found_deg}"
            );
        }
    }

    #[test]
    fn the_bow_in_the_spray_of_the_sea_is_smaller() {
        // Descartes' ray for the published indices 1.3347 and 1.3413: 0.945 degrees.
        let angle_deg = |water| {
            let (bow, color) = (PickedBow::Primary, PickedColor::Middle);
            BowEdge { bow, color, water }.angle().to_degrees()
        };
        let smaller_deg = angle_deg(Water::pure(15.0)) - angle_deg(Water::of_the_sea(15.0));
        assert!((smaller_deg - 0.945).abs() < 0.02, "{smaller_deg}");
    }
}
