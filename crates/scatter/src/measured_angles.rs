//! The angles of an exact table without a sun's disc: where linear interpolation is measured to miss, halved.
//!
//! error = |linear − computed| / peak of the computed row on the same side of 90 degrees, natural light
//! The ray theory that chooses the first angles knows neither corona nor glory nor the ripple of interfering
//! orders, of period 5.2/x, which no disc blurs. So each interval between them is measured in even parts, four at
//! least and four to a period of the smallest drops, whose ripple is left in a law. Intervals that fit stay: they
//! get no angle that they do not need. Of single sizes, which no ray sees alone, laws as narrow as they are for are
//! measured.

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use niji_radiometry::Micrometers;
use niji_radiometry::size_parameter;
use niji_sizes::law_weights;

use crate::builder::values_at;
use crate::error::Error;
use crate::progress::Progress;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::theta_axis::NumberOfAngles;
use crate::theta_axis::TableAngles;
use crate::theta_axis::some_of;

/// Period of the ripple of interfering orders, times x.
const RIPPLE_TIMES_X: f64 = 5.2;
/// Parts in which an interval is measured, at least, and a period of the ripple.
const N_PARTS: usize = 4;
/// Parts of the widest interval.
const MOST_PARTS: usize = 1 << 16;
/// Angles at most: a table that needs more, as of single drops of a millimeter, misses its tolerance.
const MOST_ANGLES: usize = 250_000;
/// Narrower intervals fit: light that jumps has no angles that interpolate it.
const NARROWEST_RAD: f64 = 1e-8;
/// Angles that are computed at once.
const N_AT_ONCE: usize = 4096;
/// Laws that are measured, at most.
const N_LAWS: usize = 7;

/// These angles, with those between them that keep the tolerance of the request.
pub(crate) fn measured_angles(
    request: &TableRequest,
    theta_rad: &[f64],
    progress: Progress,
) -> Result<Vec<f64>, Error> {
    let mut light = MeasuredLight::new(request, progress)?;
    let mut angles = theta_rad.to_vec();
    let widest_part_rad = ripple_period_rad(request) / N_PARTS as f64;
    let mut open: Vec<Vec<f64>> = theta_rad
        .windows(2)
        .map(|ends| in_parts(ends, widest_part_rad))
        .collect();
    loop {
        light.compute(&open)?;
        open.retain(|points| !light.fits(points));
        if open.is_empty() || angles.len() + open.len() > MOST_ANGLES {
            break;
        }
        angles.extend(open.iter().map(|points| points[points.len() / 2]));
        request.check_size(&NumberOfAngles {
            all: angles.len(),
            of_orders: Vec::new(),
        })?;
        open = open.iter().flat_map(|points| halves(points)).collect();
        light.keep(&open);
    }
    angles.sort_by(f64::total_cmp);
    Ok(angles)
}

/// Of the smallest drops at the longest wavelength, the widest of the table.
fn ripple_period_rad(request: &TableRequest) -> f64 {
    let smallest_um = request.effective_radius_um[0];
    let longest = request.wavelengths.center(request.wavelengths.len() - 1);
    RIPPLE_TIMES_X / size_parameter(Micrometers(smallest_um), longest)
}

/// Even points from one end to the other, of a number of parts that can be halved to the last.
fn in_parts(ends: &[f64], widest_rad: f64) -> Vec<f64> {
    let width_rad = ends[1] - ends[0];
    let n_parts = (width_rad / widest_rad).ceil().min(MOST_PARTS as f64) as usize;
    let n_parts = n_parts.next_power_of_two().max(N_PARTS);
    let inner = (1..n_parts).map(|index| ends[0] + width_rad * index as f64 / n_parts as f64);
    [ends[0]]
        .into_iter()
        .chain(inner)
        .chain([ends[1]])
        .collect()
}

/// Both halves of an interval, each in parts enough.
fn halves(points: &[f64]) -> [Vec<f64>; 2] {
    let middle = points.len() / 2;
    [&points[..=middle], &points[middle..]].map(|half| {
        if half.len() > N_PARTS {
            return half.to_vec();
        }
        let pairs = half.windows(2);
        let mut finer: Vec<f64> = pairs
            .flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])])
            .collect();
        finer.extend(half.last());
        finer
    })
}

/// Natural light of what is seen of a table, at the angles that are measured.
struct MeasuredLight<'a> {
    /// Of spheres: all light of flattened drops is theirs.
    request: TableRequest<'a>,
    progress: Progress<'a>,
    /// Rows and their weights in each curve.
    curves: Vec<Vec<(usize, f64)>>,
    /// By angle, as [`f64::to_bits`], which ascends as it does: all curves at each wavelength, f32 as in the table.
    at: BTreeMap<u64, Vec<f32>>,
    /// The largest of each so far, in front of 90 degrees and behind.
    peaks: [Vec<f32>; 2],
}

impl<'a> MeasuredLight<'a> {
    fn new(request: &TableRequest<'a>, progress: Progress<'a>) -> Result<Self, Error> {
        let radii = &request.effective_radius_um;
        let curves: Vec<Vec<(usize, f64)>> = match request.rows {
            SizeRows::Laws => (0..request.n_rows()).map(|row| vec![(row, 1.0)]).collect(),
            SizeRows::Bins {
                narrowest_variance, ..
            } => some_of(radii, N_LAWS)
                .into_iter()
                .map(|um| law_weights(radii, Micrometers(um), narrowest_variance))
                .collect::<Result<_, _>>()?,
        };
        let n_curves = curves.len() * request.wavelengths.len();
        Ok(Self {
            request: TableRequest {
                motion: None,
                ..request.clone()
            },
            progress,
            curves,
            at: BTreeMap::new(),
            peaks: [vec![0.0; n_curves], vec![0.0; n_curves]],
        })
    }

    /// Computes what is not known yet of the points of intervals.
    fn compute(&mut self, intervals: &[Vec<f64>]) -> Result<(), Error> {
        let missing: Vec<f64> = points_of(intervals)
            .into_iter()
            .filter(|bits| !self.at.contains_key(bits))
            .map(f64::from_bits)
            .collect();
        for theta_rad in missing.chunks(N_AT_ONCE) {
            for (theta, light) in theta_rad.iter().zip(self.computed(theta_rad)?) {
                let peaks = &mut self.peaks[side(*theta)];
                for (peak, light) in peaks.iter_mut().zip(&light) {
                    *peak = peak.max(*light);
                }
                self.at.insert(theta.to_bits(), light);
            }
        }
        Ok(())
    }

    /// All curves at each of some angles.
    fn computed(&self, theta_rad: &[f64]) -> Result<Vec<Vec<f32>>, Error> {
        let angles = TableAngles {
            theta_rad: theta_rad.to_vec(),
            of_orders: Vec::new(),
        };
        // Nothing of the table itself is done yet.
        let values = values_at(&self.request, &angles, None, &|_| (self.progress)(0.0))?.all;
        let n_variances = self.request.effective_variance.len();
        let of_row = |row: usize, wavelength: usize, angle: usize| {
            let at = |j| values[[j, row / n_variances, row % n_variances, wavelength, angle]];
            f64::from(0.5 * (at(0) + at(1)))
        };
        let of_angle = |angle: usize| {
            let wavelengths = 0..self.request.wavelengths.len();
            let of_wavelength = |wavelength| {
                let terms = move |rows: &Vec<(usize, f64)>| {
                    let terms = rows
                        .iter()
                        .map(|(row, weight)| weight * of_row(*row, wavelength, angle));
                    terms.sum::<f64>() as f32
                };
                self.curves.iter().map(terms)
            };
            wavelengths.flat_map(of_wavelength).collect()
        };
        Ok((0..theta_rad.len()).map(of_angle).collect())
    }

    /// Is every curve within the tolerance of the line between the ends?
    fn fits(&self, points: &[f64]) -> bool {
        let width_rad = points[points.len() - 1] - points[0];
        width_rad < NARROWEST_RAD || self.worst(points) <= self.request.tolerance as f32
    }

    /// How far any curve is from the line between the ends, in parts of its peak.
    fn worst(&self, points: &[f64]) -> f32 {
        let (first, last) = (points[0], points[points.len() - 1]);
        let [low, high] = [first, last].map(|theta| &self.at[&theta.to_bits()]);
        let peaks = &self.peaks[side(first)];
        let error = |theta: &f64| {
            let part = ((theta - first) / (last - first)) as f32;
            let computed = &self.at[&theta.to_bits()];
            let curves = low.iter().zip(high).zip(computed.iter().zip(peaks));
            let off = curves.map(|((low, high), (computed, peak))| {
                let off = (low * (1.0 - part) + high * part - computed).abs();
                // A curve without light is no division by 0.
                if off > 0.0 { off / peak } else { 0.0 }
            });
            off.fold(0.0, f32::max)
        };
        points.iter().map(error).fold(0.0, f32::max)
    }

    /// Forgets all points but those of intervals.
    fn keep(&mut self, intervals: &[Vec<f64>]) {
        let points = points_of(intervals);
        self.at.retain(|bits, _| points.contains(bits));
    }
}

/// All points of intervals, ascending, as [`f64::to_bits`].
fn points_of(intervals: &[Vec<f64>]) -> BTreeSet<u64> {
    intervals.iter().flatten().map(|it| it.to_bits()).collect()
}

/// In front of 90 degrees, or behind.
fn side(theta_rad: f64) -> usize {
    usize::from(theta_rad >= FRAC_PI_2)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use niji_radiometry::Water;
    use niji_radiometry::WavelengthGrid;
    use niji_sizes::bins;

    use super::*;
    use crate::progress::unwatched;
    use crate::theory::Theory;
    use crate::theta_axis::chosen_angles;

    fn request(theory: Theory, radii_um: Vec<f64>, variance: f64) -> TableRequest<'static> {
        TableRequest {
            theory,
            orders: (0..8).collect(),
            theta_range_rad: (0.0, PI),
            tolerance: 5e-3,
            wavelengths: WavelengthGrid::new(450.0, 100.0, 3).unwrap(),
            effective_radius_um: radii_um,
            effective_variance: vec![variance],
            rows: SizeRows::Laws,
            motion: None,
            sun_disc_diameter_rad: 0.0,
            water: Water::pure(15.0),
            airy_table: None,
        }
    }

    /// The largest error of all curves between the angles, in parts of the tolerance, and how many angles there are.
    fn worst_between(request: &TableRequest) -> (f32, usize) {
        let theta_rad = chosen_angles(request, &unwatched).unwrap().angles.theta_rad;
        let mut light = MeasuredLight::new(request, &unwatched).unwrap();
        // Places that halving does not come to.
        let between = |ends: &[f64]| {
            [0.0, 0.17, 0.41, 0.69, 1.0].map(|place| ends[0] * (1.0 - place) + ends[1] * place)
        };
        let intervals: Vec<Vec<f64>> = theta_rad
            .windows(2)
            .map(|ends| between(ends).to_vec())
            .collect();
        light.compute(&intervals).unwrap();
        let worst = intervals
            .iter()
            .map(|points| light.worst(points))
            .fold(0.0, f32::max);
        (worst / request.tolerance as f32, theta_rad.len())
    }

    /// Errors over the tolerance, which holds at five points of an interval; measured worst 1.21.
    const WORST: f32 = 1.25;

    #[test]
    fn laws_and_sums_of_sizes_are_near_the_line_between_their_angles() {
        let cells = (0..12)
            .map(|step| 4.0 * (0.1 * f64::from(step)).exp())
            .collect();
        let ln_step = 0.05;
        let of_bins = |theory, range_um, narrowest_variance| TableRequest {
            rows: SizeRows::Bins {
                ln_step,
                narrowest_variance,
            },
            ..request(theory, bins(range_um, ln_step), 0.0)
        };
        let fine = TableRequest {
            tolerance: 1e-3,
            ..request(Theory::Mie, vec![5.0], 0.1)
        };
        for request in [
            fine,
            request(Theory::Mie, vec![17.0, 40.0], 0.02),
            request(Theory::Mie, cells, 0.0),
            request(Theory::BySize, vec![8.0], 0.3),
            request(Theory::Debye { max_order: 5 }, vec![60.0], 0.05),
            of_bins(Theory::BySize, (9.0, 60.0), 0.1),
            of_bins(Theory::Mie, (3.0, 12.0), 0.03),
        ] {
            let (worst, n) = worst_between(&request);
            let (theory, radii, rows) =
                (request.theory, &request.effective_radius_um, request.rows);
            assert!(
                worst < WORST,
                "{theory:?} {rows:?} from {} um: {worst} with {n}",
                radii[0]
            );
        }
    }

    #[test]
    fn a_table_that_is_right_gets_no_angle() {
        // Large drops of a broad law in the bow: rays and fringes, no ripple.
        let bow = TableRequest {
            theta_range_rad: (2.3, 2.6),
            tolerance: 2e-2,
            ..request(Theory::BySize, vec![400.0], 0.1)
        };
        let angles = chosen_angles(&bow, &unwatched).unwrap().angles.theta_rad;
        assert_eq!(measured_angles(&bow, &angles, &unwatched).unwrap(), angles);
        let of_bows = TableRequest {
            theory: Theory::Uniform,
            ..bow
        };
        let of_bows = chosen_angles(&of_bows, &unwatched)
            .unwrap()
            .angles
            .theta_rad;
        assert_eq!(of_bows, angles);
    }

    #[test]
    fn intervals_are_measured_in_four_parts_and_halved() {
        assert_eq!(in_parts(&[0.0, 1.0], 9.0), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(in_parts(&[0.0, 1.0], 0.2).len(), 9);
        let [low, high] = halves(&[0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(low, [0.0, 0.125, 0.25, 0.375, 0.5]);
        assert_eq!((high[0], high.len()), (0.5, 5));
        assert_eq!(
            halves(&in_parts(&[0.0, 1.0], 0.2))[0],
            [0.0, 0.125, 0.25, 0.375, 0.5]
        );
    }
}
