//! What was rendered, as an image with its layers.

use ndarray::Array3;
use ndarray::Axis;
use niji_exchange::Aov;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_geometry::Camera;
use niji_geometry::PixelRegion;
use niji_radiometry::Colorimetry;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_render::PictureLayer;
use niji_render::Rendered;

use crate::image_camera::projection_attributes;

/// What files hold for the distance of the sky (m).
const NO_SURFACE_M: f32 = 1e10;

/// An image of the whole frame, without a provenance.
pub(crate) fn of_rendered(
    rendered: Rendered,
    camera: &Camera,
    wavelengths: WavelengthGrid,
) -> SpectralImage {
    let world_to_camera = camera.world_to_camera().to_cols_array();
    let frame = PixelRegion::frame(camera.width_px(), camera.height_px());
    SpectralImage {
        wavelengths,
        aovs: layers(&rendered),
        radiance: rendered.radiance,
        spectra: Spectra::Full,
        windows: ImageWindows {
            data: frame,
            display: frame,
        },
        white_luminance_cd_m2: white_luminance_cd_m2(&wavelengths),
        // f32 is what the attribute holds.
        world_to_camera: Some(world_to_camera.map(|value| value as f32)),
        attributes: projection_attributes(camera),
        provenance: Provenance::default(),
    }
}

/// Luminance of a white card that faces the sun above the air.
pub fn white_luminance_cd_m2(wavelengths: &WavelengthGrid) -> f64 {
    let radiance: Vec<f64> = solar_irradiance(wavelengths)
        .iter()
        .map(|value| value / std::f64::consts::PI)
        .collect();
    Colorimetry::new(wavelengths).xyz(&radiance)[1]
}

fn layers(rendered: &Rendered) -> Vec<Aov> {
    let layer = |(layer, values): (PictureLayer, &Array3<f32>)| {
        let planes = values.axis_iter(Axis(0)).map(|plane| match layer {
            PictureLayer::Surface => plane.mapv(|distance| distance.min(NO_SURFACE_M)),
            _ => plane.to_owned(),
        });
        let names = layer.channels().iter().map(|name| (*name).to_owned());
        Aov {
            name: layer.name().to_owned(),
            unit: layer.unit().to_owned(),
            channels: names.zip(planes).collect(),
        }
    };
    rendered.layers().map(layer).collect()
}
