//! Where the color edges of a bow lie.

use std::f64::consts::PI;

use clap::ValueEnum;
use niji_airy::rainbow_ray;
use niji_photo::BowAnglePrior;
use niji_photo::PickedEdge;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;

/// How far the edge that people pick scatters: drop size and flattening move it, degrees.
pub(crate) const EDGE_ERROR_DEG: f64 = 0.4;
/// Temperature of the water unless another is said; 10 degrees move the bow by 0.1 degree.
pub(crate) const TEMPERATURE_C: &str = "15";

/// Which bow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Bow {
    /// The inner, brighter bow.
    Primary,
    /// The outer, fainter bow.
    Secondary,
}

/// Which color edge of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Edge {
    /// Red, 650 nm.
    Red,
    /// The green middle, 550 nm.
    Middle,
    /// Violet, 410 nm.
    Violet,
}

/// A color edge of a bow in some water.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BowEdge {
    pub(crate) bow: Bow,
    pub(crate) edge: Edge,
    pub(crate) water: Water,
}

impl Bow {
    /// Order of the bow: 2 primary, 3 secondary.
    pub(crate) fn order(self) -> u32 {
        match self {
            Self::Primary => 2,
            Self::Secondary => 3,
        }
    }
}

impl Edge {
    fn wavelength(self) -> Nanometers {
        match self {
            Self::Red => Nanometers(650.0),
            Self::Middle => Nanometers(550.0),
            Self::Violet => Nanometers(410.0),
        }
    }

    /// The edge at the other side of the bow.
    fn other(self) -> Self {
        match self {
            Self::Red | Self::Middle => Self::Violet,
            Self::Violet => Self::Red,
        }
    }
}

impl BowEdge {
    /// Its angle from the antisolar point, for large drops and a point sun.
    pub(crate) fn angle(self) -> Radians {
        let index = self.water.refractive_index(self.edge.wavelength());
        let ray = rainbow_ray(index, self.bow.order());
        let ray = ray.expect("water that was checked has 1 < n < 2, so both bows exist");
        Radians(PI - ray.theta_rad())
    }

    /// What is picked, as the fit takes it; the bow angle may be given instead.
    pub(crate) fn picked(self, (angle_deg, error_deg): (Option<f64>, f64)) -> PickedEdge {
        let natural = self.angle();
        let angle = angle_deg.map_or(natural, Radians::from_degrees);
        let other = Self {
            edge: self.edge.other(),
            ..self
        };
        PickedEdge {
            order: self.bow.order(),
            expected: BowAnglePrior {
                angle,
                standard_error: Radians::from_degrees(error_deg),
            },
            other_edge: Radians(other.angle().0 - natural.0),
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
        for (bow, edge, expected_deg) in [
            (Bow::Primary, Edge::Red, 42.4),
            (Bow::Primary, Edge::Violet, 40.6),
            (Bow::Secondary, Edge::Red, 50.4),
            (Bow::Secondary, Edge::Violet, 53.5),
        ] {
            let water = Water::pure(15.0);
            let found_deg = BowEdge { bow, edge, water }.angle().to_degrees();
            assert!(
                (found_deg - expected_deg).abs() < 0.25,
                "{bow:?} {edge:?} {found_deg}"
            );
        }
    }

    #[test]
    fn the_bow_in_the_spray_of_the_sea_is_smaller() {
        // Descartes' ray for the published indices 1.3347 and 1.3413: 0.945 degrees.
        let angle_deg = |water| {
            let (bow, edge) = (Bow::Primary, Edge::Middle);
            BowEdge { bow, edge, water }.angle().to_degrees()
        };
        let smaller_deg = angle_deg(Water::pure(15.0)) - angle_deg(Water::of_the_sea(15.0));
        assert!((smaller_deg - 0.945).abs() < 0.02, "{smaller_deg}");
    }
}
