//! What was rendered, as an image with its layers.

use ndarray::Array3;
use ndarray::Axis;
use niji_exchange::Aov;
use niji_exchange::AttributeValue;
use niji_exchange::Attributes;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_exchange::WINDOW_WIDTH;
use niji_geometry::Camera;
use niji_geometry::FisheyeMapping;
use niji_geometry::PixelRegion;
use niji_radiometry::Colorimetry;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_render::PictureLayer;
use niji_render::Rendered;
use niji_scene::Projection;

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

/// What a reader of a picture needs to know of its projection beside `worldToCamera`; of a pinhole, which every reader
/// takes for granted, how wide it looks.
fn projection_attributes(camera: &Camera) -> Attributes {
    let named = |name: &str| {
        let projection = AttributeValue::Text(name.to_owned());
        ("niji:projection".to_owned(), projection)
    };
    match camera {
        Camera::Pinhole(pinhole) => {
            // f32 is what the attribute holds.
            let width = AttributeValue::Number(f64::from(pinhole.window_width() as f32));
            Attributes::from([(WINDOW_WIDTH.to_owned(), width)])
        }
        Camera::Fisheye(fisheye) => {
            let name = match fisheye.mapping() {
                FisheyeMapping::Equidistant => Projection::FisheyeEquidistant.name(),
                FisheyeMapping::Equisolid => Projection::FisheyeEquisolid.name(),
            };
            let focal_px = AttributeValue::Number(fisheye.focal_length_px());
            Attributes::from([named(name), ("niji:focalLengthPx".to_owned(), focal_px)])
        }
        Camera::Panorama(_) => Attributes::from([named(Projection::Panorama.name())]),
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
