//! Distances of the photographed surfaces.
//!
//! Along the view ray in metres, infinity for the sky. Maps from elsewhere are converted, never
//! guessed: the user says which kind it is.
//!
//! Metres:   z = v
//! Inverse:  1/z = a v + b     disparity of stereo and of single-picture networks, near = large
//! Relative: z = a v + b
//! `a`, `b` follow from two anchor points (pixel, metres), by least squares from more. Planar depth
//! is measured along the optical axis: distance = z/cos(angle from the axis). 0, infinity and NaN are
//! the sky where v is in metres; where a v + b is not above 0, an inverse map shows the sky.

use std::io::Seek;
use std::io::Write;
use std::path::Path;

use glam::DVec3;
use ndarray::Array2;
use ndarray::Zip;
use niji_exchange::Provenance;
use niji_geometry::PinholeCamera;

use crate::compositing::check_size;
use crate::error::Error;
use crate::photograph;
use crate::picture_files::NO_DEPTH_M;
use crate::picture_files::write_depth;
use crate::plate;

/// What the values of a depth map from elsewhere mean.
#[derive(Clone, Debug, PartialEq)]
pub enum DepthKind {
    /// Metres; 0 and infinity are the sky.
    Metres,
    /// Inverse depth of unknown scale and shift, near = large.
    Inverse(Vec<Anchor>),
    /// Depth of unknown scale and shift, near = small.
    Relative(Vec<Anchor>),
}

/// A pixel whose distance is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Column and row.
    pub pixel: [usize; 2],
    /// Its distance, m.
    pub distance_m: f64,
}

/// How distance is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthAlong {
    /// The view ray.
    Ray,
    /// The optical axis.
    Axis,
}

/// Reads a depth map that `niji depth` wrote, or any EXR with a channel Z in metres along the ray:
/// 0, NaN and values from 1e10 on become infinity.
///
/// # Errors
/// A missing or damaged file, several channels without a Z, one in another unit, a value that is
/// negative, or a map that is NaN everywhere.
pub fn read_depth_map(path: &Path) -> Result<Array2<f32>, Error> {
    let values = plate::read_depth(path)?;
    metres(&values)
}

/// Reads a depth map on the pixels of its frame, the display window: overscan is left out, and where the map holds
/// nothing is the sky.
///
/// # Errors
/// As [`read_depth_map`], and a frame that does not fit into memory.
pub fn read_depth_of_frame(path: &Path) -> Result<Array2<f32>, Error> {
    let values = plate::read_depth_of_frame(path)?;
    metres(&values)
}

/// Reads the values of a depth map from elsewhere: an EXR, or the grey values of a PNG in 0..1.
///
/// # Errors
/// A missing or damaged file, one of another kind, or several channels without a Z in an EXR.
pub fn read_depth_values(path: &Path) -> Result<Array2<f32>, Error> {
    let is_exr = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
    if is_exr {
        return plate::read_depth(path);
    }
    let (file, file_bytes) = photograph::opened(path)?;
    let picture = photograph::decode(file, file_bytes)?.picture;
    let size = (picture.height() as usize, picture.width() as usize);
    let values = picture.to_luma16().into_raw().into_iter();
    let values = values.map(|code| f32::from(code) / f32::from(u16::MAX));
    Array2::from_shape_vec(size, values.collect())
        .map_err(|error| Error::Damaged(error.to_string()))
}

/// Distances along the view ray from the values of a depth map.
///
/// # Errors
/// A value that no depth has, anchors that give no scale, or a camera of another size.
pub fn depth_from_values(
    values: &Array2<f32>,
    kind: &DepthKind,
    along: DepthAlong,
    camera: &PinholeCamera,
) -> Result<Array2<f32>, Error> {
    let size = (camera.height_px() as usize, camera.width_px() as usize);
    check_size("the depth map", size, values.dim())?;
    // Anchors are distances as the map measures them only along the ray.
    let per_axis = |pixel: [usize; 2]| match along {
        DepthAlong::Ray => 1.0,
        DepthAlong::Axis => cos_from_axis(camera, pixel),
    };
    let mut depth_m = match kind {
        DepthKind::Metres => metres(values)?,
        DepthKind::Inverse(anchors) => {
            let [a, b] = line(values, anchors, |anchor| {
                1.0 / (anchor.distance_m * per_axis(anchor.pixel))
            })?;
            finite(values)?;
            values.mapv(|value| {
                let inverse = a * f64::from(value) + b;
                // f32: what files hold.
                if inverse > 1.0 / f64::from(NO_DEPTH_M) {
                    (1.0 / inverse) as f32
                } else {
                    f32::INFINITY
                }
            })
        }
        DepthKind::Relative(anchors) => {
            let [a, b] = line(values, anchors, |anchor| {
                anchor.distance_m * per_axis(anchor.pixel)
            })?;
            let scaled = values.mapv(|value| (a * f64::from(value) + b) as f32);
            nonnegative(&scaled)?;
            scaled
        }
    };
    if along == DepthAlong::Axis {
        Zip::indexed(&mut depth_m).par_for_each(|(y, x), depth| {
            *depth /= cos_from_axis(camera, [x, y]) as f32;
        });
    }
    Ok(depth_m)
}

/// Writes a depth map: channel Z in metres along the ray, 1e10 for the sky.
///
/// # Errors
/// A value that is negative or NaN, or a writer that fails.
pub fn write_depth_map(
    depth_m: &Array2<f32>,
    provenance: &Provenance,
    writer: impl Write + Seek,
) -> Result<(), Error> {
    nonnegative(depth_m)?;
    write_depth(depth_m, provenance, writer)
}

fn cos_from_axis(camera: &PinholeCamera, [x, y]: [usize; 2]) -> f64 {
    let view: DVec3 = camera.ray(x as f64 + 0.5, y as f64 + 0.5).direction;
    view.dot(camera.forward())
}

pub(crate) fn metres(values: &Array2<f32>) -> Result<Array2<f32>, Error> {
    if values.iter().all(|value| value.is_nan()) {
        return nonnegative(values).map(|()| values.clone());
    }
    refuse(values, |value| value < 0.0)?;
    Ok(values.mapv(|value| {
        // False for NaN, which is the sky as well.
        if value > 0.0 && value < NO_DEPTH_M {
            value
        } else {
            f32::INFINITY
        }
    }))
}

fn nonnegative(values: &Array2<f32>) -> Result<(), Error> {
    refuse(values, |value| value < 0.0 || value.is_nan())
}

fn finite(values: &Array2<f32>) -> Result<(), Error> {
    refuse(values, |value| !value.is_finite())
}

fn refuse(values: &Array2<f32>, is_wrong: impl Fn(f32) -> bool) -> Result<(), Error> {
    match values.indexed_iter().find(|(_, value)| is_wrong(**value)) {
        Some(((y, x), &value)) => Err(Error::Depth { x, y, value }),
        None => Ok(()),
    }
}

/// The line [a, b] through the values at the anchors, by least squares.
fn line(
    values: &Array2<f32>,
    anchors: &[Anchor],
    target: impl Fn(&Anchor) -> f64,
) -> Result<[f64; 2], Error> {
    let mut points = Vec::with_capacity(anchors.len());
    for anchor in anchors {
        let [x, y] = anchor.pixel;
        let Some(value) = values.get([y, x]) else {
            return Err(Error::Anchors(format!("pixel {x},{y} is outside the map")));
        };
        let is_distance = anchor.distance_m > 0.0 && anchor.distance_m.is_finite();
        if !is_distance {
            let found = anchor.distance_m;
            return Err(Error::Anchors(format!("found a distance of {found} m")));
        }
        points.push((f64::from(*value), target(anchor)));
    }
    let n = points.len() as f64;
    let mean_v = points.iter().map(|point| point.0).sum::<f64>() / n;
    let mean_t = points.iter().map(|point| point.1).sum::<f64>() / n;
    let spread: f64 = points.iter().map(|(v, _)| (v - mean_v).powi(2)).sum();
    // False for NaN, that is for no anchors, too.
    let is_determined = spread > 1e-12 * (mean_v * mean_v).max(f64::MIN_POSITIVE);
    if !is_determined {
        return Err(Error::Anchors(
            "expected two or more pixels with different values".to_owned(),
        ));
    }
    let product: f64 = points
        .iter()
        .map(|(v, t)| (v - mean_v) * (t - mean_t))
        .sum();
    let slope = product / spread;
    if slope <= 0.0 {
        return Err(Error::Anchors(
            "they make near things far: is the map of the other kind (inverse, relative)?"
                .to_owned(),
        ));
    }
    Ok([slope, mean_t - slope * mean_v])
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;
    use niji_geometry::PinholeRequest;
    use niji_radiometry::Radians;

    /// A few roundings in f32.
    const F32: f32 = 5e-6;

    fn camera() -> PinholeCamera {
        PinholeCamera::new(PinholeRequest {
            position: DVec3::ZERO,
            azimuth: Radians(0.3),
            elevation: Radians(0.1),
            roll: Radians(0.0),
            horizontal_fov: Radians::from_degrees(90.0),
            width_px: 9,
            height_px: 3,
        })
        .unwrap()
    }

    fn scene() -> Array2<f32> {
        Array2::from_shape_fn((3, 9), |(y, x)| 5.0 + 10.0 * x as f32 + 3.0 * y as f32)
    }

    fn anchors(values: &Array2<f32>) -> Vec<Anchor> {
        [[0, 0], [8, 2], [4, 1]]
            .map(|pixel: [usize; 2]| Anchor {
                pixel,
                distance_m: f64::from(values[[pixel[1], pixel[0]]]),
            })
            .to_vec()
    }

    #[test]
    fn any_scale_and_shift_of_inverse_and_relative_depth_is_undone() {
        let distances = scene();
        for (scale, shift) in [(1.0, 0.0), (37.0, 0.4), (0.02, -3.0)] {
            let inverse = distances.mapv(|z| scale / z + shift);
            let kind = DepthKind::Inverse(anchors(&distances));
            let found = depth_from_values(&inverse, &kind, DepthAlong::Ray, &camera()).unwrap();
            for (found, expected) in found.iter().zip(&distances) {
                // Inverse depth shifted by 3 loses digits.
                assert!((found / expected - 1.0).abs() < 1e-2);
            }
            let relative = distances.mapv(|z| scale * z + shift);
            let kind = DepthKind::Relative(anchors(&distances));
            let found = depth_from_values(&relative, &kind, DepthAlong::Ray, &camera()).unwrap();
            for (found, expected) in found.iter().zip(&distances) {
                assert!((found / expected - 1.0).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_wall_across_the_axis_is_farther_at_its_edges() {
        let wall = Array2::from_elem((3, 9), 10.0);
        let found = depth_from_values(&wall, &DepthKind::Metres, DepthAlong::Axis, &camera());
        let found = found.unwrap();
        assert!((found[[1, 4]] - 10.0).abs() < F32 * 10.0);
        // Pixel 8 lies 4 of 4.5 half widths off the axis, whose tangent is 1.
        let expected = 10.0 * (1.0 + (4.0_f32 / 4.5).powi(2)).sqrt();
        assert!((found[[1, 8]] / expected - 1.0).abs() < F32);
    }

    #[test]
    fn sky_is_infinite_and_survives_a_file() {
        let sky = f32::INFINITY;
        let values = ndarray::array![[0.0, 12.5, sky, f32::NAN, 1e10]];
        let depth = metres(&values).unwrap();
        assert_eq!(depth, ndarray::array![[sky, 12.5, sky, sky, sky]]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("depth.exr");
        let file = File::create(&path).unwrap();
        write_depth_map(&depth, &Provenance::default(), file).unwrap();
        assert_eq!(read_depth_map(&path).unwrap(), depth);
    }

    #[test]
    fn a_z_that_is_no_length_is_refused() {
        let plane = |unit: &str, channels: &[&str]| niji_exchange::Aov {
            name: format!("part of {unit}"),
            unit: unit.to_owned(),
            channels: channels
                .iter()
                .map(|name| ((*name).to_owned(), Array2::from_elem((2, 3), 7.0)))
                .collect(),
        };
        let image = |aovs| niji_exchange::SpectralImage {
            wavelengths: niji_radiometry::WavelengthGrid::new(500.0, 50.0, 2).unwrap(),
            radiance: ndarray::Array3::zeros((2, 2, 3)),
            spectra: niji_exchange::Spectra::Full,
            windows: niji_exchange::ImageWindows::whole(3, 2),
            aovs,
            white_luminance_cd_m2: 1.0,
            world_to_camera: None,
            attributes: niji_exchange::Attributes::new(),
            provenance: Provenance::default(),
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.exr");
        let read = |aovs| {
            image(aovs)
                .write_spectral(File::create(&path).unwrap())
                .unwrap();
            read_depth_map(&path)
        };
        let depth = read(vec![plane("m", &["Z"])]).unwrap();
        assert_eq!(depth, Array2::from_elem((2, 3), 7.0));
        let refused = read(vec![plane("cd/m^2", &["Z"])]);
        assert!(matches!(refused, Err(Error::DepthUnit(unit)) if unit == "cd/m^2"));
        // CIE Z comes first in a rendered image.
        let color = plane("cd/m^2", &["X", "Y", "Z"]);
        let refused = read(vec![color, plane("m", &["Z"])]);
        assert!(matches!(refused, Err(Error::DepthUnit(unit)) if unit == "cd/m^2"));
    }

    #[test]
    fn impossible_maps_and_anchors_are_refused() {
        let camera = camera();
        let refuse = |values: &Array2<f32>, kind| {
            assert!(depth_from_values(values, &kind, DepthAlong::Ray, &camera).is_err());
        };
        let values = scene();
        refuse(&Array2::from_elem((3, 9), -1.0), DepthKind::Metres);
        refuse(&Array2::from_elem((3, 9), f32::NAN), DepthKind::Metres);
        refuse(&Array2::zeros((2, 2)), DepthKind::Metres);
        refuse(&values, DepthKind::Inverse(Vec::new()));
        refuse(&values, DepthKind::Relative(anchors(&values)[..1].to_vec()));
        refuse(&Array2::ones((3, 9)), DepthKind::Relative(anchors(&values)));
        // Near = small is no inverse depth.
        refuse(&values, DepthKind::Inverse(anchors(&values)));
        let outside = Anchor {
            pixel: [9, 0],
            distance_m: 3.0,
        };
        refuse(&values, DepthKind::Relative(vec![outside; 2]));
    }
}
