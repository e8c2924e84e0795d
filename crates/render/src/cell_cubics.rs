//! The lanes along the run of a ray through a cell, as cubics.

use glam::Vec4;
use niji_dropfield::Sample;
use niji_dropfield::Segment;

use crate::lane_cubic::LaneCubic;
use crate::lane_cubic::SAMPLE_POSITIONS;

/// Radius and number density are each trilinear, so M2 = N r² is of degree 9 on a ray; cubics on
/// halves of a cell follow it to 1e-3 where the radius doubles across a cell.
pub(crate) const RADIUS_DENSITY_PIECES: usize = 2;

/// A ray through the middle of a coarse cell errs by more than the RMS over the cell that is told: by
/// 2^(1/2) where the field is a parabola along one axis.
const COARSE_SAFETY: f32 = 1.5;

/// The cubic of a cell whose lanes are cubics, and their relative error.
#[inline]
pub(crate) fn whole_cubic(segment: &Segment) -> (LaneCubic, f32) {
    let error = COARSE_SAFETY * segment.relative_error();
    (LaneCubic::new(segment.cubic()), error)
}

/// The cubics through samples on parts of a cell in which moments are none. A part starts with the sample
/// at which the one before it ended.
pub(crate) fn cubics_through_samples(segment: &Segment) -> [LaneCubic; RADIUS_DENSITY_PIECES] {
    const STEPS: usize = SAMPLE_POSITIONS.len() - 1;
    const N_STEPS: usize = RADIUS_DENSITY_PIECES * STEPS;
    let samples: [Vec4; N_STEPS + 1] = std::array::from_fn(|index| {
        let fraction = index as f32 / N_STEPS as f32;
        lanes(segment.sample(fraction))
    });
    std::array::from_fn(|index| {
        LaneCubic::through(std::array::from_fn(|step| samples[index * STEPS + step]))
    })
}

/// A sample as a vector.
pub(crate) fn lanes(sample: Sample) -> Vec4 {
    Vec4::new(sample.m2, sample.m3, sample.m4, sample.tau_sun)
}
