//! A picture as a page takes it, and what is known of a place in it.

use std::error::Error;
use std::time::Duration;

use ndarray::Axis;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_photo::LinearPicture;
use niji_photo::write_png;
use niji_picture::Lines;
use niji_picture::Scene;
use niji_picture::SeenDrops;
use niji_picture::bow_angle;
use niji_radiometry::Colorimetry;
use niji_radiometry::Radians;
use serde_json::Value;
use serde_json::json;

/// A picture.
pub(super) struct Picture {
    pub(super) number: u64,
    /// Number of the scene that it shows.
    pub(super) revision: u64,
    pub(super) level: &'static str,
    pub(super) is_finished: bool,
    /// From the change to this picture.
    pub(super) time: Duration,
    /// The scene, with the pixels of this picture.
    pub(super) scene: Scene,
    pub(super) display_white_cd_m2: f64,
    /// What a finished picture errs by, over display white, as `niji run` tells it.
    pub(super) error_of_white: Option<f64>,
    pub(super) image: SpectralImage,
    /// Its bow in the photograph of its scene, linear as a display shows it.
    pub(super) in_photograph: Option<LinearPicture>,
    pub(super) drops: SeenDrops,
}

impl Picture {
    /// Number, size and origin.
    pub(super) fn about(&self) -> Value {
        json!({
            "number": self.number,
            "revision": self.revision,
            "level": self.level,
            "is_finished": self.is_finished,
            "seconds": self.time.as_secs_f64(),
            "size": self.shown_size(),
            "is_photograph": self.in_photograph.is_some(),
            "error_of_white": self.error_of_white,
            "drops": self.box_lines(),
        })
    }

    /// Columns and rows of what is shown.
    fn shown_size(&self) -> [usize; 2] {
        let camera = &self.scene.camera;
        let own = [camera.width_px, camera.height_px].map(|n| n as usize);
        (self.in_photograph.as_ref()).map_or(own, |it| [it.ncols(), it.nrows()])
    }

    /// Edges of the boxes that the drops are in, in parts of the frame.
    fn box_lines(&self) -> Lines {
        let camera = &self.scene.camera;
        let size = [camera.width_px, camera.height_px].map(f64::from);
        let part = |[x, y]: [f64; 2]| [x / size[0], y / size[1]];
        let lines = (camera.camera()).map_or_else(|_| Lines::new(), |it| self.drops.box_lines(&it));
        let in_parts = |line: Vec<_>| line.into_iter().map(part).collect();
        lines.into_iter().map(in_parts).collect()
    }

    /// Effective radius of the drops on the ray through a place of the frame, up to the surface there.
    fn effective_radius_um(&self, place: [f64; 2], surface_m: Option<f32>) -> Option<f64> {
        let ray = (self.scene.camera.camera().ok()?).ray(place[0], place[1])?;
        let end_m = surface_m.map_or(f64::INFINITY, f64::from);
        self.drops.effective_radius_um(&ray, end_m)
    }

    /// Red, green and blue of each pixel of the frame by rows, linear, 1 is a white card in the sun: as in the
    /// program's PNG before exposure and tone curve. Of a photograph 1 is its own white.
    pub(super) fn pixels(&self) -> Vec<u8> {
        if let Some(photograph) = &self.in_photograph {
            let light = photograph.iter().flatten();
            return light.flat_map(|light| light.to_le_bytes()).collect();
        }
        let by_pixel = self.image.shown().permuted_axes([1, 2, 0]);
        let bytes = by_pixel.iter().flat_map(|light| light.to_le_bytes());
        bytes.collect()
    }

    /// The picture as the program writes it.
    pub(super) fn png(&self, exposure_ev: f64) -> Result<Vec<u8>, Box<dyn Error>> {
        let mut bytes = Vec::new();
        match &self.in_photograph {
            Some(photograph) => write_png(photograph, &Provenance::default(), &mut bytes)?,
            None => self.image.write_png(&mut bytes, exposure_ev)?,
        }
        Ok(bytes)
    }

    fn layer(&self, name: &str, channel: &str) -> Option<&ndarray::Array2<f32>> {
        let layer = self.image.aovs.iter().find(|layer| layer.name == name)?;
        let mut channels = layer.channels.iter();
        channels
            .find(|(name, _)| name == channel)
            .map(|(_, values)| values)
    }

    /// What is known of a place, in parts of the frame from its top left corner; `None` outside of it.
    pub(super) fn at(&self, [right, down]: [f64; 2]) -> Option<Value> {
        let camera = &self.scene.camera;
        let place = [
            right * f64::from(camera.width_px),
            down * f64::from(camera.height_px),
        ];
        let is_inside = |(place, size): (f64, u32)| (0.0..f64::from(size)).contains(&place);
        if !is_inside((place[0], camera.width_px)) || !is_inside((place[1], camera.height_px)) {
            return None;
        }
        let first = self.image.windows.data;
        let [column, row] = [(place[0], first.x_px), (place[1], first.y_px)]
            .map(|(place, first)| (place as i64 - i64::from(first)) as usize);
        let spectrum = self.image.radiance.index_axis(Axis(1), row);
        let spectrum = spectrum.index_axis(Axis(1), column).to_vec();
        let value = |name, channel| self.layer(name, channel).map(|it| it[[row, column]]);
        let wavelengths = self.image.wavelengths;
        let weights = Colorimetry::new(&wavelengths);
        let terms = spectrum.iter().zip(weights.weights());
        let luminance: f64 = terms.map(|(light, [_, y, _])| f64::from(*light) * y).sum();
        let nm = (0..wavelengths.len())
            .map(|index| wavelengths.first_nm() + index as f64 * wavelengths.step_nm());
        let angle = bow_angle(&self.scene, place).ok().flatten();
        Some(json!({
            "bow_angle_deg": angle.map(Radians::to_degrees),
            "luminance_cd_m2": luminance,
            "of_white": luminance / self.display_white_cd_m2,
            "error_of_white": value("error", "Y").map(|it| f64::from(it) / self.display_white_cd_m2),
            "passes": value("transmittance", "Y"),
            "effective_radius_um": self.effective_radius_um(place, value("surface", "Z")),
            "distance_m": value("depth", "Z"),
            "wavelength_nm": nm.collect::<Vec<f64>>(),
            "radiance": spectrum,
        }))
    }
}
