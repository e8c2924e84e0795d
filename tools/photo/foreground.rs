//! The layers of a photograph whose sky is known: the sky, what stands before it, and level ground.
//!
//! d = h/sin(delta), `h` the height of the eye, `delta` how far a view ray points down, gives the ground its
//! distances, in bands of a factor of 2, each as near as its nearest pixel, so that no band lies below the ground. All of
//! them end before the rain, so that its light falls on nothing but the sky until somebody says that hills lie farther
//! away.

use ndarray::Array2;
use niji_geometry::PinholeCamera;
use niji_photo::Layer;
use niji_photo::Layers;
use niji_photo::LinearPicture;
use niji_picture::EYE_HEIGHT;

/// Distance of what stands before the sky, m.
const STANDING_M: f64 = 200.0;
/// Where the nearest band of the ground begins, m.
const NEAREST_M: f64 = 2.0;
/// Bands of the ground; the last ends before what stands.
const N_BANDS: usize = 6;
/// Labels of the sky and of what stands; then come the bands, the nearest first.
const SKY: u8 = 0;
const STANDING: u8 = 1;

/// The layers, with the mean colors of their pixels.
pub(super) fn foreground(
    photo: &LinearPicture,
    is_sky: &Array2<bool>,
    camera: &PinholeCamera,
) -> Layers {
    let labels = Array2::from_shape_fn(photo.dim(), |(y, x)| {
        let down = -camera.ray(x as f64 + 0.5, y as f64 + 0.5).direction.y;
        if is_sky[[y, x]] {
            return SKY;
        }
        let ground_m = EYE_HEIGHT.0 / down.max(1e-9);
        let band = (ground_m / NEAREST_M).log2().max(0.0) as usize;
        if band < N_BANDS {
            STANDING + 1 + band as u8
        } else {
            STANDING
        }
    });
    let mut sums = vec![([0.0_f64; 3], 0.0_f64); N_BANDS + 2];
    for (label, pixel) in labels.iter().zip(photo) {
        let (sum, n) = &mut sums[usize::from(*label)];
        *n += 1.0;
        for (sum, channel) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(*channel);
        }
    }
    let layers = sums.into_iter().enumerate().map(|(label, (sum, n))| Layer {
        // f32: pixels are f32.
        color: sum.map(|sum| (sum / n.max(1.0)) as f32),
        share: n / photo.len() as f64,
        distance_m: match label {
            0 => f64::INFINITY,
            1 => STANDING_M,
            // The ground under the eye is nearer than the first band.
            2 => EYE_HEIGHT.0,
            _ => NEAREST_M * 2_f64.powi(label as i32 - 2),
        },
    });
    Layers {
        layers: layers.collect(),
        labels,
    }
}
