//! Scattering angles, folded into mirrored pairs.
//!
//! theta' = min(theta, 180 deg - theta),  w = 2 sin^2(theta'/2) = 1 - cos(theta')
//! S(theta) and S(180 deg - theta) are sum and difference of the same two partial sums, so a
//! mirrored pair costs as much as one angle. Both poles get the good argument: at 180 deg, w is 0
//! exactly, while the cosine of an angle near a pole has lost half of its digits.

use std::f64::consts::PI;

use niji_radiometry::Radians;

use crate::error::Error;

/// Folded angles that differ by less are one; roundoff of 180 deg - theta is 4e-16.
const PAIR_TOLERANCE_RAD: f64 = 1e-15;

/// The side of the sphere of directions that an angle lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// 0 to 90 degrees.
    Forward,
    /// Above 90 degrees.
    Backward,
}

/// Where the amplitudes of one angle come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) pair_index: usize,
    pub(crate) side: Side,
}

/// Scattering angles from 0 (forward) to 180 degrees, in any order, prepared once for many spheres.
///
/// ```
/// use niji_mie::ScatteringAngles;
///
/// let degrees: Vec<f64> = (0..=1800).map(|i| f64::from(i) / 10.0).collect();
/// let angles = ScatteringAngles::from_degrees(&degrees)?;
/// assert_eq!((angles.len(), angles.n_pairs()), (1801, 901));
/// # Ok::<(), niji_mie::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ScatteringAngles {
    theta_rad: Vec<f64>,
    places: Vec<Place>,
    w: Vec<f64>,
}

impl ScatteringAngles {
    /// Prepares angles.
    ///
    /// # Errors
    /// If an angle is not between 0 and pi.
    pub fn new(angles: &[Radians]) -> Result<Self, Error> {
        let theta_rad: Vec<f64> = angles.iter().map(|angle| angle.0).collect();
        check(&theta_rad, PI, f64::to_degrees)?;
        let folded_rad: Vec<f64> = theta_rad
            .iter()
            .map(|theta| theta.min(PI - theta))
            .collect();
        Ok(Self::from_folded(theta_rad, &folded_rad))
    }

    /// Prepares angles in degrees, which fold without roundoff.
    ///
    /// # Errors
    /// If an angle is not between 0 and 180.
    pub fn from_degrees(angles_deg: &[f64]) -> Result<Self, Error> {
        check(angles_deg, 180.0, |theta| theta)?;
        let radians = |angle_deg: f64| angle_deg.to_radians();
        let theta_rad = angles_deg.iter().copied().map(radians).collect();
        let folded_rad: Vec<f64> = angles_deg
            .iter()
            .map(|deg| radians(deg.min(180.0 - deg)))
            .collect();
        Ok(Self::from_folded(theta_rad, &folded_rad))
    }

    /// Number of angles.
    pub fn len(&self) -> usize {
        self.theta_rad.len()
    }

    /// Whether there are no angles.
    pub fn is_empty(&self) -> bool {
        self.theta_rad.is_empty()
    }

    /// Number of mirrored pairs, which decides the time of a sum; an angle alone counts as a pair.
    pub fn n_pairs(&self) -> usize {
        self.w.len()
    }

    /// The angles, in the order they were given.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Radians> {
        self.theta_rad.iter().copied().map(Radians)
    }

    /// Where each angle's amplitudes come from.
    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }

    /// Whether the first pair is that of the poles, whose w is stored as exactly 0.
    pub(crate) fn has_pole(&self) -> bool {
        self.w.first().is_some_and(|w| *w <= 0.0)
    }

    /// w of each pair, ascending.
    pub(crate) fn w(&self) -> &[f64] {
        &self.w
    }

    fn from_folded(theta_rad: Vec<f64>, folded_rad: &[f64]) -> Self {
        let mut by_fold: Vec<usize> = (0..folded_rad.len()).collect();
        by_fold.sort_by(|a, b| folded_rad[*a].total_cmp(&folded_rad[*b]));
        let mut places = vec![
            Place {
                pair_index: 0,
                side: Side::Forward
            };
            folded_rad.len()
        ];
        let mut pairs_rad: Vec<f64> = Vec::new();
        for index in by_fold {
            let folded = folded_rad[index];
            if pairs_rad
                .last()
                .is_none_or(|last| folded - last > PAIR_TOLERANCE_RAD)
            {
                pairs_rad.push(folded);
            }
            let is_forward = theta_rad[index] <= 0.5 * PI;
            let side = if is_forward {
                Side::Forward
            } else {
                Side::Backward
            };
            places[index] = Place {
                pair_index: pairs_rad.len() - 1,
                side,
            };
        }
        let w = pairs_rad
            .iter()
            .map(|folded| 2.0 * (0.5 * folded).sin().powi(2))
            .collect();
        Self {
            theta_rad,
            places,
            w,
        }
    }
}

fn check(angles: &[f64], max: f64, to_degrees: impl Fn(f64) -> f64) -> Result<(), Error> {
    let is_bad = |theta: &f64| !(0.0..=max).contains(theta);
    match angles.iter().position(is_bad) {
        Some(index) => Err(Error::Angle {
            index,
            found_deg: to_degrees(angles[index]),
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_grid_folds_into_half_as_many_pairs_in_degrees_and_radians() {
        let degrees: Vec<f64> = (0..=1800).map(|i| f64::from(i) / 10.0).collect();
        let radians: Vec<Radians> = degrees
            .iter()
            .map(|deg| Radians::from_degrees(*deg))
            .collect();
        for angles in [
            ScatteringAngles::from_degrees(&degrees).unwrap(),
            ScatteringAngles::new(&radians).unwrap(),
        ] {
            assert_eq!(angles.n_pairs(), 901);
            assert_eq!(
                angles.places()[0],
                Place {
                    pair_index: 0,
                    side: Side::Forward
                }
            );
            assert_eq!(
                angles.places()[1800],
                Place {
                    pair_index: 0,
                    side: Side::Backward
                }
            );
            assert_eq!(
                angles.places()[900],
                Place {
                    pair_index: 900,
                    side: Side::Forward
                }
            );
        }
    }

    #[test]
    fn both_poles_have_an_argument_of_exactly_zero() {
        let angles = ScatteringAngles::new(&[Radians(PI), Radians(0.0)]).unwrap();
        assert_eq!(angles.w(), [0.0]);
    }

    #[test]
    fn angles_that_repeat_share_a_pair_and_keep_their_order() {
        let angles = ScatteringAngles::from_degrees(&[150.0, 10.0, 30.0, 150.0]).unwrap();
        assert_eq!(angles.n_pairs(), 2);
        assert_eq!(angles.places()[0], angles.places()[3]);
        assert_eq!(angles.places()[2].pair_index, angles.places()[0].pair_index);
        assert_eq!(angles.iter().next(), Some(Radians(150.0_f64.to_radians())));
    }

    #[test]
    fn angles_outside_0_to_180_degrees_are_errors() {
        for bad in [-0.1, 180.1, f64::NAN, f64::INFINITY] {
            let found = ScatteringAngles::from_degrees(&[90.0, bad]);
            assert!(matches!(found, Err(Error::Angle { index: 1, .. })), "{bad}");
            let found = ScatteringAngles::new(&[Radians(bad.to_radians())]);
            assert!(matches!(found, Err(Error::Angle { index: 0, .. })), "{bad}");
        }
        assert!(ScatteringAngles::from_degrees(&[]).unwrap().is_empty());
    }
}
