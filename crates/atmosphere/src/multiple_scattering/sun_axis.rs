//! The axis of the sun's zenith angle, dense where the sun sets.
//!
//! Linear interpolation in the angle itself: moments of order m rise like sin^m of it at the zenith.
//! Beyond the last node no light arrives that was scattered twice or less, and the source is 0.

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
        let cosine = zenith_rad.iter().map(|zenith: &f64| zenith.cos()).collect();
        Self { zenith_rad, cosine }
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
        if above >= self.len() {
            return None;
        }
        let low = above.saturating_sub(1);
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
