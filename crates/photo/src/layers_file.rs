//! Layers as files that a person corrects: distances as TOML, labels as a grey PNG.
//!
//! ```toml
//! [[layer]]
//! distance_m = inf      # the sky
//! color = "#c3d2e6"
//! share = 0.41
//! ```
//!
//! The layers stand in the order of their labels. In the PNG the grey value of label i of n is
//! 255 i/(n − 1), rounded; reading takes the nearest label.

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use ndarray::Array2;
use niji_radiometry::srgb_encode;
use serde::Deserialize;

use crate::error::Error;
use crate::layers::Layer;
use crate::layers::MOST_CLUSTERS;
use crate::photograph;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    layer: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    distance_m: f64,
    #[serde(default)]
    #[expect(dead_code, reason = "for people only; accepted, not used")]
    color: String,
    #[serde(default)]
    #[expect(dead_code, reason = "for people only; accepted, not used")]
    share: f64,
}

/// The layers as TOML.
#[must_use]
pub fn layers_to_toml(layers: &[Layer]) -> String {
    let mut text = String::from(
        "# Distances along the view ray in metres, inf for the sky; proposed, to be corrected.\n\
         # Layers stand in the order of their labels.\n",
    );
    for (label, layer) in layers.iter().enumerate() {
        let code = |channel: f32| {
            let encoded = srgb_encode(f64::from(channel.clamp(0.0, 1.0)));
            (255.0 * encoded).round() as u8
        };
        let [red, green, blue] = layer.color.map(code);
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "\n# label {label}\n[[layer]]\ndistance_m = {:.2}\ncolor = \"#{red:02x}{green:02x}{blue:02x}\"\n\
             share = {:.4}\n",
            layer.distance_m, layer.share
        );
    }
    text
}

/// Distances of the layers, by label.
///
/// # Errors
/// A missing file, one that is no TOML of layers, or one with no or too many layers.
pub fn read_layer_distances(path: &Path) -> Result<Vec<f64>, Error> {
    let text = std::fs::read_to_string(path)?;
    let document: Document =
        toml::from_str(&text).map_err(|error| Error::Layers(error.to_string()))?;
    let found = document.layer.len();
    if !(1..=MOST_CLUSTERS).contains(&found) {
        return Err(Error::Layers(format!(
            "found {found} layers, expected 1 to {MOST_CLUSTERS}"
        )));
    }
    Ok(document
        .layer
        .iter()
        .map(|entry| entry.distance_m)
        .collect())
}

/// Writes labels as a grey PNG.
///
/// # Errors
/// A writer that fails.
pub fn write_labels(labels: &Array2<u8>, n_layers: usize, writer: impl Write) -> Result<(), Error> {
    let failed = |error: png::EncodingError| Error::Encode(error.to_string());
    let (height, width) = labels.dim();
    let mut encoder = png::Encoder::new(writer, width as u32, height as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(failed)?;
    let last = n_layers.saturating_sub(1).max(1) as f64;
    let codes: Vec<u8> = labels
        .iter()
        .map(|label| (255.0 * f64::from(*label) / last).round() as u8)
        .collect();
    writer.write_image_data(&codes).map_err(failed)?;
    writer.finish().map_err(failed)
}

/// Reads labels.
///
/// # Errors
/// A missing or damaged file.
pub fn read_labels(path: &Path, n_layers: usize) -> Result<Array2<u8>, Error> {
    let (file, file_bytes) = photograph::opened(path)?;
    let picture = photograph::decode(file, file_bytes)?.picture;
    let size = (picture.height() as usize, picture.width() as usize);
    let last = n_layers.saturating_sub(1) as f64;
    let codes = picture.to_luma8().into_raw().into_iter();
    let labels = codes.map(|code| (last * f64::from(code) / 255.0).round() as u8);
    Array2::from_shape_vec(size, labels.collect())
        .map_err(|error| Error::Damaged(error.to_string()))
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;

    #[test]
    fn layers_and_labels_survive_their_files() {
        let folder = tempfile::tempdir().unwrap();
        let layer = |distance_m| Layer {
            color: [0.2, 0.5, 1.0],
            share: 0.25,
            distance_m,
        };
        let layers = [layer(f64::INFINITY), layer(12.5), layer(800.0)];
        let path = folder.path().join("layers.toml");
        std::fs::write(&path, layers_to_toml(&layers)).unwrap();
        let distances = read_layer_distances(&path).unwrap();
        assert_eq!(distances, vec![f64::INFINITY, 12.5, 800.0]);
        for n_layers in [1, 2, 7, 64] {
            let labels = Array2::from_shape_fn((8, 9), |(y, x)| ((9 * y + x) % n_layers) as u8);
            let path = folder.path().join("labels.png");
            write_labels(&labels, n_layers, File::create(&path).unwrap()).unwrap();
            assert_eq!(read_labels(&path, n_layers).unwrap(), labels);
        }
    }

    #[test]
    fn a_misspelt_key_and_an_empty_file_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layers.toml");
        for text in ["", "[[layer]]\ndistance = 3.0\n", "layer = []\n"] {
            std::fs::write(&path, text).unwrap();
            assert!(
                matches!(read_layer_distances(&path), Err(Error::Layers(_))),
                "{text}"
            );
        }
    }
}
