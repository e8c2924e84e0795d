//! What was seen in a picture of few pixels and wavelengths, and where in the frame.

use ndarray::Array2;
use ndarray::ArrayView1;
use niji_scene::Bound;
use niji_scene::BoundKind;
use niji_scene::Camera;
use niji_scene::Scene;
use serde::Deserialize;
use serde::Deserializer;
use serde::Serialize;
use serde::de::Error;

/// Columns of a small picture, and its wavelengths.
const WIDTH_PX: u32 = 24;
const N_WAVELENGTHS: usize = 3;

/// The same view, small.
pub(crate) fn smaller(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.camera = scene.camera.no_wider_than(WIDTH_PX);
    scene.spectrum = scene.spectrum.in_wider_bins(N_WAVELENGTHS);
    scene
}

/// Luminance of a small picture, over display white.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SmallPicture {
    /// Column and row where its first pixel begins, counted from the corner of the frame.
    pub(crate) first_px: [f64; 2],
    /// Those of the frame.
    pub(crate) frame_px: [f64; 2],
    /// By row and column; there is a pixel, and rows are equally long.
    #[serde(deserialize_with = "rows")]
    pub(crate) luminance: Vec<Vec<f32>>,
}

impl SmallPicture {
    /// Luminance over display white of all pixels of a camera.
    pub(crate) fn new(camera: &Camera, luminance: &Array2<f64>) -> Self {
        let row = |row: ArrayView1<f64>| row.iter().map(|it| *it as f32).collect();
        Self {
            first_px: [-f64::from(camera.overscan_px); 2],
            frame_px: [camera.width_px, camera.height_px].map(f64::from),
            luminance: luminance.rows().into_iter().map(row).collect(),
        }
    }

    /// Luminance over display white of equal parts of the picture of a camera, by row and column; `None` of none.
    pub(crate) fn of_parts(camera: &Camera, luminance: Vec<Vec<f32>>) -> Option<Self> {
        let n_columns = luminance.first()?.len();
        let overscan_px = f64::from(camera.overscan_px);
        let sides = [
            (camera.width_px, n_columns),
            (camera.height_px, luminance.len()),
        ];
        let of_picture = sides
            .map(|(size_px, n_parts)| n_parts as f64 / (f64::from(size_px) + 2.0 * overscan_px));
        Some(Self {
            first_px: of_picture.map(|it| -overscan_px * it),
            frame_px: [0, 1].map(|side| f64::from(sides[side].0) * of_picture[side]),
            luminance,
        })
    }

    /// What it shows at most and in the RMS.
    pub(crate) fn bound(&self) -> Bound {
        let parts = || self.luminance.iter().flatten().map(|it| f64::from(*it));
        let squares: f64 = parts().map(|part| part * part).sum();
        Bound {
            value: parts().map(f64::abs).fold(0.0, f64::max),
            rms: (squares / parts().count().max(1) as f64).sqrt(),
            kind: BoundKind::Measured,
        }
    }

    /// The same, so many times as bright.
    pub(crate) fn times(mut self, factor: f32) -> Self {
        for light in self.luminance.iter_mut().flatten() {
            *light *= factor;
        }
        self
    }

    /// The same with the light of another frame wherever that has more.
    pub(crate) fn or_more(mut self, other: &Self) -> Self {
        let ([width, height], [first_x, first_y]) = (self.frame_px, self.first_px);
        for (row, lights) in self.luminance.iter_mut().enumerate() {
            let down = (row as f64 + 0.5 + first_y) / height;
            for (column, light) in lights.iter_mut().enumerate() {
                let right = (column as f64 + 0.5 + first_x) / width;
                *light = light.max(other.at(right, down) as f32);
            }
        }
        self
    }

    /// The same with the brightest of each pixel and those around it.
    pub(crate) fn widened(&self) -> Self {
        let n_columns = self.luminance.first().map_or(0, Vec::len);
        let around = |at: usize, n: usize| at.saturating_sub(1)..(at + 2).min(n);
        let brightest = |(row, column): (usize, usize)| {
            let rows = &self.luminance[around(row, self.luminance.len())];
            let near = rows.iter().flat_map(|it| &it[around(column, n_columns)]);
            near.copied().fold(f32::NEG_INFINITY, f32::max)
        };
        let row = |row| {
            (0..n_columns)
                .map(|column| brightest((row, column)))
                .collect()
        };
        Self {
            luminance: (0..self.luminance.len()).map(row).collect(),
            ..*self
        }
    }

    /// Its light at a place in parts of the frame, linear between pixels; the nearest ones hold outside.
    pub(crate) fn at(&self, right: f64, down: f64) -> f64 {
        let ([width, height], [first_x, first_y]) = (self.frame_px, self.first_px);
        let n_columns = self.luminance.first().map_or(0, Vec::len);
        let x = between(right * width - 0.5 - first_x, n_columns);
        let y = between(down * height - 0.5 - first_y, self.luminance.len());
        let pairs = y.iter().flat_map(|y| x.iter().map(move |x| (*y, *x)));
        let light = |((row, of_row), (column, of_column)): ((usize, f64), (usize, f64))| {
            of_row * of_column * f64::from(self.luminance[row][column])
        };
        pairs.map(light).sum()
    }
}

/// Rows of a file, which anybody may have changed.
fn rows<'de, D: Deserializer<'de>>(file: D) -> Result<Vec<Vec<f32>>, D::Error> {
    let rows: Vec<Vec<f32>> = Deserialize::deserialize(file)?;
    let n_columns = rows.first().map_or(0, Vec::len);
    let is_whole = |row: &Vec<f32>| row.len() == n_columns && row.iter().all(|it| it.is_finite());
    if n_columns > 0 && rows.iter().all(is_whole) {
        return Ok(rows);
    }
    let message =
        "found rows of luminance without pixels, of several lengths or with what is no number";
    Err(D::Error::custom(message))
}

/// The two pixels around a place with their weights.
fn between(place: f64, n_px: usize) -> [(usize, f64); 2] {
    let last = n_px.saturating_sub(1);
    let place = place.clamp(0.0, last as f64);
    let (below, part) = (place as usize, place.fract());
    [(below, 1.0 - part), ((below + 1).min(last), part)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_frames_the_brighter_place_is_kept_whatever_their_sizes() {
        let camera = |width_px, luminance: Vec<Vec<f32>>| SmallPicture {
            first_px: [0.0; 2],
            frame_px: [width_px, 1.0],
            luminance,
        };
        let one = camera(2.0, vec![vec![1.0, 4.0]]);
        let other = camera(4.0, vec![vec![3.0, 3.0, 2.0, 2.0]]);
        assert_eq!(one.clone().or_more(&other).luminance, [[3.0, 4.0]]);
        let back = other.or_more(&one).luminance;
        assert_eq!(back, [[3.0, 3.0, 3.25, 4.0]]);
    }

    #[test]
    fn rows_of_several_lengths_and_none_are_no_picture() {
        let read = |rows: &str| {
            let text =
                format!(r#"{{"first_px": [0, 0], "frame_px": [2, 2], "luminance": {rows}}}"#);
            serde_json::from_str::<SmallPicture>(&text)
        };
        let sound = read("[[0.0, 1.0], [2.0, 3.0]]").unwrap();
        assert!((sound.at(0.5, 0.5) - 1.5).abs() < 1e-12);
        for rows in [
            "[]",
            "[[]]",
            "[[0.0, 1.0], [2.0]]",
            "[[0.0], [1.0, 2.0]]",
            "[[1e39]]",
        ] {
            assert!(read(rows).is_err(), "{rows}");
        }
    }
}
