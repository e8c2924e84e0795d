//! The axis of the sun's zenith angle, dense where the sun sets.
//!
//! Linear interpolation in the angle itself: moments of order m rise like sin^m of it at the zenith.
//! Beyond the last node no light arrives that was scattered twice or less, and the source is 0; beyond those of an axis
//! around one sun it is that of the last.

use niji_radiometry::Radians;

/// First zenith angle of a stretch and its step, degrees.
const STRETCHES_DEG: [[f64; 2]; 5] = [
    [0.0, 5.0],
    [70.0, 2.5],
    [80.0, 1.0],
    [100.0, 2.0],
    [110.0, 0.0],
];

/// Zenith angles, rising, rad.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SunAxis {
    zenith_rad: Vec<f64>,
    /// Cosines, falling.
    cosine: Vec<f64>,
    /// Whether the sun stands lower than at the last node elsewhere.
    goes_on: bool,
}

impl SunAxis {
    /// The axis with every interval cut into so many.
    pub(crate) fn new(n_cuts: usize) -> Self {
        let mut zenith_rad = Vec::new();
        for pair in STRETCHES_DEG.windows(2) {
            let ([from, step], [to, _]) = (pair[0], pair[1]);
            let step = step / n_cuts as f64;
            let n = ((to - from) / step).round() as usize;
            zenith_rad.extend((0..n).map(|i| (from + step * i as f64).to_radians()));
        }
        zenith_rad.push(STRETCHES_DEG[STRETCHES_DEG.len() - 1][0].to_radians());
        Self::of(zenith_rad, false)
    }

    /// Its nodes within an angle of a sun, and one beyond at either end.
    pub(crate) fn around(&self, sun_zenith: Radians, reach: Radians) -> Self {
        let last = self.len() - 1;
        let beyond = self
            .zenith_rad
            .partition_point(|node| *node <= sun_zenith.0 + reach.0)
            .clamp(1, last);
        let before = self
            .zenith_rad
            .partition_point(|node| *node < sun_zenith.0 - reach.0)
            .clamp(1, beyond)
            - 1;
        Self::of(self.zenith_rad[before..=beyond].to_vec(), beyond < last)
    }

    fn of(zenith_rad: Vec<f64>, goes_on: bool) -> Self {
        let cosine = zenith_rad.iter().map(|zenith: &f64| zenith.cos()).collect();
        Self {
            zenith_rad,
            cosine,
            goes_on,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.zenith_rad.len()
    }

    pub(crate) fn zenith_rad(&self) -> &[f64] {
        &self.zenith_rad
    }

    pub(crate) fn cosines(&self) -> &[f64] {
        &self.cosine
    }

    /// Lower node and share of the one above it; `None` beyond the axis.
    pub(crate) fn place(&self, cos_zenith: f64) -> Option<(usize, f32)> {
        let above = self.cosine.partition_point(|&node| node >= cos_zenith);
        if above >= self.len() && !self.goes_on {
            return None;
        }
        let low = above.saturating_sub(1).min(self.len() - 2);
        let (from, to) = (self.zenith_rad[low], self.zenith_rad[low + 1]);
        let share = (cos_zenith.clamp(-1.0, 1.0).acos() - from) / (to - from);
        // f32: as the weights it is multiplied with.
        Some((low, share.clamp(0.0, 1.0) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_around_a_sun_is_the_same_within_its_reach_and_goes_on_as_it_ends() {
        let whole = SunAxis::new(4);
        let reach = Radians::from_degrees(12.0);
        for zenith_deg in [0.0, 3.0, 49.0, 70.0, 88.0, 92.0, 109.0, 130.0] {
            let zenith = Radians::from_degrees(zenith_deg);
            let around = whole.around(zenith, reach);
            assert!(around.len() >= 2 && around.len() < whole.len());
            for tenth in -119..120 {
                let here_rad = (zenith_deg + 0.1 * f64::from(tenth)).to_radians();
                if !(0.0..109.9_f64.to_radians()).contains(&here_rad) {
                    continue;
                }
                let sun_at = |axis: &SunAxis| {
                    let (low, share) = axis.place(here_rad.cos()).unwrap();
                    let [from, to] = [low, low + 1].map(|node| axis.zenith_rad[node]);
                    from + f64::from(share) * (to - from)
                };
                assert!(
                    (sun_at(&around) - sun_at(&whole)).abs() < 1e-7,
                    "{zenith_deg}"
                );
            }
        }
        // Lower suns than all light comes from still are dark; others are as the last.
        let low = whole.around(Radians::from_degrees(105.0), reach);
        assert_eq!(low.place(-0.9), None);
        let high = whole.around(Radians::from_degrees(20.0), reach);
        assert_eq!(high.place(-0.9), Some((high.len() - 2, 1.0)));
    }

    #[test]
    fn every_zenith_angle_lies_between_its_nodes() {
        for n_cuts in [1, 4] {
            let axis = SunAxis::new(n_cuts);
            for tenth in 0..1100 {
                let zenith = (0.1 * f64::from(tenth)).to_radians();
                let (low, share) = axis.place(zenith.cos()).unwrap();
                let (from, to) = (axis.zenith_rad[low], axis.zenith_rad[low + 1]);
                let found = from + f64::from(share) * (to - from);
                assert!((found - zenith).abs() < 1e-7, "{tenth}");
            }
            assert_eq!(axis.place(-0.9), None);
            assert_eq!(
                axis.len(),
                14 * n_cuts + 4 * n_cuts + 20 * n_cuts + 5 * n_cuts + 1
            );
        }
    }
}
