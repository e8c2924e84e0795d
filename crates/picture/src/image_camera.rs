//! The camera in the header of an image.

use glam::DMat3;
use glam::DMat4;
use glam::DVec3;
use niji_exchange::AttributeValue;
use niji_exchange::Attributes;
use niji_exchange::SpectralImage;
use niji_exchange::WINDOW_WIDTH;
use niji_geometry::Camera;
use niji_geometry::CameraPose;
use niji_geometry::FisheyeCamera;
use niji_geometry::FisheyeMapping;
use niji_geometry::FisheyeRequest;
use niji_geometry::FocalLength;
use niji_geometry::Lens;
use niji_geometry::PanoramaCamera;
use niji_geometry::PinholeCamera;
use niji_geometry::Up;
use niji_radiometry::Radians;
use niji_scene::Projection;

use crate::error::Error;

/// Attributes of a projection that is no pinhole's.
const PROJECTION: &str = "niji:projection";
const FOCAL_LENGTH_PX: &str = "niji:focalLengthPx";

/// What a reader of a picture needs to know of its projection beside `worldToCamera`; of a pinhole, which every reader
/// takes for granted, how wide it looks.
pub(crate) fn projection_attributes(camera: &Camera) -> Attributes {
    let named = |name: &str| {
        let projection = AttributeValue::Text(name.to_owned());
        (PROJECTION.to_owned(), projection)
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
            Attributes::from([named(name), (FOCAL_LENGTH_PX.to_owned(), focal_px)])
        }
        Camera::Panorama(_) => Attributes::from([named(Projection::Panorama.name())]),
    }
}

/// The camera of an image, from what [`projection_attributes`] and `worldToCamera` say; level and north where there
/// is no matrix.
///
/// # Errors
/// A camera that cannot be.
pub(crate) fn camera_of(image: &SpectralImage) -> Result<Camera, Error> {
    let pose = match image.world_to_camera {
        Some(matrix) => {
            // Rotation and shift: the inverse is the transpose, without what an inverse would round.
            let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
            let axes = DMat3::from_mat4(matrix).transpose();
            let position = -(axes * matrix.w_axis.truncate());
            let to_world = DMat4::from_translation(position) * DMat4::from_mat3(axes);
            CameraPose::from_matrix(to_world, Up::Y)
        }
        None => CameraPose::looking(DVec3::ZERO, [Radians(0.0); 3]),
    };
    let pose = pose.map_err(of_camera)?;
    let size_px = [
        image.windows.display.width_px,
        image.windows.display.height_px,
    ];
    let number = |name: &str| match image.attributes.get(name) {
        Some(AttributeValue::Number(value)) => Some(*value),
        Some(AttributeValue::Text(_)) | None => None,
    };
    let lens = |widths: f64| {
        Lens::FocalLength(FocalLength {
            focal_length_mm: widths,
            sensor_width_mm: 1.0,
        })
    };
    let fisheye = |mapping: FisheyeMapping| {
        let focal_px = number(FOCAL_LENGTH_PX).unwrap_or(f64::NAN);
        let fisheye = FisheyeCamera::new(FisheyeRequest {
            pose,
            mapping,
            lens: lens(focal_px / f64::from(size_px[0])),
            image_circle: None,
            width_px: size_px[0],
            height_px: size_px[1],
        });
        fisheye.map(Camera::from)
    };
    let is = |projection: Projection| match image.attributes.get(PROJECTION) {
        Some(AttributeValue::Text(name)) => name == projection.name(),
        Some(AttributeValue::Number(_)) | None => false,
    };
    let camera = if is(Projection::FisheyeEquidistant) {
        fisheye(FisheyeMapping::Equidistant)
    } else if is(Projection::FisheyeEquisolid) {
        fisheye(FisheyeMapping::Equisolid)
    } else if is(Projection::Panorama) {
        PanoramaCamera::new(pose, size_px).map(Camera::from)
    } else {
        // OpenEXR leaves out what is 1.
        let width = number(WINDOW_WIDTH).unwrap_or(1.0);
        PinholeCamera::with_lens(pose, lens(1.0 / width), size_px).map(Camera::from)
    };
    camera.map_err(of_camera)
}

fn of_camera(error: niji_geometry::Error) -> Error {
    Error::Photo(error.into())
}

#[cfg(test)]
mod tests {
    use niji_exchange::ImageWindows;
    use niji_exchange::Provenance;
    use niji_exchange::Spectra;
    use niji_geometry::PixelRegion;
    use niji_radiometry::WavelengthGrid;

    use super::*;

    fn image(camera: &Camera) -> SpectralImage {
        let frame = PixelRegion::frame(camera.width_px(), camera.height_px());
        let matrix = camera.world_to_camera().to_cols_array();
        SpectralImage {
            wavelengths: WavelengthGrid::visible(),
            radiance: ndarray::Array3::zeros((3, 1, 1)),
            spectra: Spectra::Full,
            windows: ImageWindows {
                data: frame,
                display: frame,
            },
            aovs: Vec::new(),
            white_luminance_cd_m2: 1.0,
            world_to_camera: Some(matrix.map(|value| value as f32)),
            attributes: projection_attributes(camera),
            provenance: Provenance::default(),
        }
    }

    fn check_cameras(pose: CameraPose) {
        let fov = |degrees| Lens::HorizontalFov(Radians::from_degrees(degrees));
        let fisheye = |mapping| {
            let request = FisheyeRequest {
                pose,
                mapping,
                lens: fov(140.0),
                image_circle: None,
                width_px: 120,
                height_px: 80,
            };
            Camera::from(FisheyeCamera::new(request).unwrap())
        };
        let cameras = [
            PinholeCamera::with_lens(pose, fov(70.0), [120, 80])
                .unwrap()
                .into(),
            fisheye(FisheyeMapping::Equidistant),
            fisheye(FisheyeMapping::Equisolid),
            PanoramaCamera::new(pose, [120, 60]).unwrap().into(),
        ];
        for camera in cameras {
            let back = camera_of(&image(&camera)).unwrap();
            for at in [(60.0, 40.0), (1.5, 30.5), (70.25, 58.0)] {
                let ray = |camera: &Camera| camera.ray(at.0, at.1).unwrap().direction;
                assert!(
                    ray(&camera).distance(ray(&back)) < 1e-6,
                    "{camera:?} {at:?}"
                );
            }
        }
    }

    #[test]
    fn every_camera_comes_back_from_the_header() {
        for turn in 0..40 {
            let turn = f64::from(turn);
            let angles = [31.7 * turn, 4.1 * turn - 85.0, -7.3 * turn];
            let position = DVec3::new(3.0 * turn, 2.0, 500.0 - 25.0 * turn);
            check_cameras(
                CameraPose::looking(position, angles.map(Radians::from_degrees)).unwrap(),
            );
        }
    }
}
