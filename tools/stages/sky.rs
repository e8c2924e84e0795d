//! The panorama of a scene's sky: every direction around a point, without drops.
//!
//! Equirectangular: columns are azimuths, the middle is north, east to its right, the edges south;
//! rows are elevations, from the zenith down. Pixels hold the radiance of their center's direction.
//! Below the horizon stands the sunlit ground. The sun's disc itself is left out.

use std::f64::consts::PI;
use std::path::Path;

use ndarray::Array3;
use niji_atmosphere::DiffuseDome;
use niji_atmosphere::PreparedSky;
use niji_atmosphere::SkyDirection;
use niji_atmosphere::SkyMethod;
use niji_atmosphere::SkyObserver;
use niji_exchange::AtmosphereTable;
use niji_exchange::Attributes;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_picture::unwatched;
use niji_radiometry::Radians;
use niji_scene::Scene;
use niji_scene::SkyLevel;
use niji_scene::canonical_json;
use rayon::iter::IndexedParallelIterator;
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSliceMut;

use crate::failure::Failure;
use crate::output;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;

/// What a panorama depends on besides the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panorama {
    /// Width, pixels, even; twice the height.
    pub width_px: usize,
    /// Height of the eye above sea level, m.
    pub height_m: f64,
}

/// Writes the sky of a scene and a preview beside it.
///
/// # Errors
/// A scene in a vacuum, an output that exists, or a file that cannot be written.
pub(crate) fn make(
    scene: &Scene,
    panorama: Panorama,
    to: &Path,
    options: StageOptions,
) -> Result<Done, Failure> {
    let settings = canonical_json(&(
        (&scene.air, scene.ground, scene.spectrum),
        scene.sky_level(),
        (scene.sun, scene.picture),
        (panorama.width_px, panorama.height_m),
    ));
    let preview = to.with_extension("png");
    let request = Request {
        stage: "sky",
        settings,
        inputs: Vec::new(),
        outputs: vec![to, &preview],
    };
    perform(&request, options, |provenance| {
        let vacuum =
            || Failure::Usage("the scene has no section [air]: its sky is black".to_owned());
        let orders = scene.sky_level().map(SkyLevel::orders);
        let air = niji_picture::air::table(scene, orders, &unwatched)?.ok_or_else(vacuum)?;
        let image = picture(scene, &air, panorama, provenance);
        let exposure_ev = scene.picture.exposure_ev;
        output::write_file(&preview, |writer| image.write_png(writer, exposure_ev))?;
        output::write_file(to, |writer| image.write_spectral(writer))
    })
}

fn picture(
    scene: &Scene,
    air: &AtmosphereTable,
    panorama: Panorama,
    provenance: Provenance,
) -> SpectralImage {
    let (width, height) = (panorama.width_px, panorama.width_px / 2);
    let n_wavelengths = air.wavelengths.len();
    let observer = SkyObserver::from_elevation(
        panorama.height_m,
        Radians::from_degrees(scene.sun.elevation_deg),
    );
    let sky = PreparedSky::new(air, observer, SkyMethod::STANDARD_DOME);
    // Without light of higher orders in the table one is enough.
    let diffuse = DiffuseDome::new(air, observer).ok();
    let sun_azimuth_rad = scene.sun.azimuth_deg.to_radians();
    // Pixel by pixel, wavelengths together; the planes of the file are cut from it.
    let mut pixels = vec![0.0_f32; height * width * n_wavelengths];
    pixels
        .par_chunks_mut(width * n_wavelengths)
        .enumerate()
        .for_each(|(row, line)| {
            let elevation = Radians(PI * (0.5 - (row as f64 + 0.5) / height as f64));
            for (column, radiance) in line.chunks_mut(n_wavelengths).enumerate() {
                let azimuth_rad = PI * (2.0 * (column as f64 + 0.5) / width as f64 - 1.0);
                let azimuth = Radians(azimuth_rad - sun_azimuth_rad);
                let direction = SkyDirection::from_elevation(elevation, azimuth);
                sky.write_radiance(direction, radiance);
                if let Some(diffuse) = &diffuse {
                    diffuse.add_radiance(direction, radiance);
                }
                radiance.iter_mut().for_each(no_less_than_dark);
            }
        });
    SpectralImage {
        wavelengths: air.wavelengths,
        radiance: Array3::from_shape_fn((n_wavelengths, height, width), |(plane, row, column)| {
            pixels[(row * width + column) * n_wavelengths + plane]
        }),
        spectra: Spectra::Full,
        windows: ImageWindows::whole(width, height),
        aovs: Vec::new(),
        white_luminance_cd_m2: niji_picture::white_luminance_cd_m2(&air.wavelengths),
        world_to_camera: None,
        attributes: Attributes::new(),
        provenance,
    }
}

/// Interpolation undershoots by 1e-10 of the brightest where the light goes out; a NaN would stay.
pub(crate) fn no_less_than_dark(radiance: &mut f32) {
    if *radiance < 0.0 {
        *radiance = 0.0;
    }
}
