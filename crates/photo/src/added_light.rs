//! The light of a rendered spectral image, as compositing takes it.
//!
//! X, Y, Z of the AOVs of drops and air [cd/m²] over the white luminance of the image become linear RGB;
//! what lies outside the gamut is mixed with grey. Sky and lit surfaces behind the drops, if the image has them, are
//! left out: in a photograph they are there already, and what drops scatter of them is its own light too.
//! Images whose light ends at surfaces say where, in the AOV `surface` [m].

use ndarray::Array2;
use ndarray::Zip;
use niji_exchange::Aov;
use niji_exchange::SpectralImage;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::into_gamut;
use niji_radiometry::xyz_to_linear_rec709;

use crate::compositing::AddedLight;
use crate::error::Error;
use crate::linear_picture::LinearPicture;
use crate::picture_files::to_f32;

/// AOVs whose light is added, and whether an image must have them.
const LIGHTS: [(&str, bool); 5] = [
    ("bow_primary", true),
    ("bow_secondary", true),
    ("bow_multiple", false),
    ("bow_reflected", false),
    ("air", false),
];

impl AddedLight {
    /// Bow, veil and transmittance of a rendered image, in these primaries.
    ///
    /// # Errors
    /// An AOV that is missing.
    pub fn of_image(image: &SpectralImage, primaries: RgbPrimaries) -> Result<Self, Error> {
        let (_, height, width) = image.radiance.dim();
        let white = image.white_luminance_cd_m2;
        let mut light = LinearPicture::from_elem((height, width), [0.0; 3]);
        for (name, is_needed) in LIGHTS {
            let aov = image.aovs.iter().find(|aov| aov.name == name);
            match aov {
                Some(aov) => add_xyz(&mut light, aov)?,
                None if is_needed => return Err(Error::MissingAov(name)),
                None => (),
            }
        }
        light.par_mapv_inplace(|xyz| {
            let relative = xyz.map(|value| f64::from(value) / white);
            let rgb = primaries.of_linear_rec709(xyz_to_linear_rec709(relative));
            to_f32(into_gamut(rgb, primaries, GamutPolicy::Desaturate))
        });
        Ok(Self {
            light,
            transmittance: plane(image, "transmittance")?.clone(),
        })
    }
}

/// Mean distance of the drops' light from the eye in a rendered image, m; 0 where there is none.
///
/// # Errors
/// If the image has no such AOV.
pub fn distance_of_light(image: &SpectralImage) -> Result<&Array2<f32>, Error> {
    plane(image, "depth")
}

/// Distances of the surfaces at which the light of a rendered image ends, m; `None` if it was
/// integrated without surfaces.
#[must_use]
pub fn surface_of_light(image: &SpectralImage) -> Option<&Array2<f32>> {
    plane(image, "surface").ok()
}

fn plane<'a>(image: &'a SpectralImage, name: &'static str) -> Result<&'a Array2<f32>, Error> {
    let aov = image.aovs.iter().find(|aov| aov.name == name);
    let channel = aov.and_then(|aov| aov.channels.first());
    channel
        .map(|(_, values)| values)
        .ok_or(Error::MissingAov(name))
}

fn add_xyz(light: &mut LinearPicture, aov: &Aov) -> Result<(), Error> {
    for (channel, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        let values = aov.channels.iter().find(|(found, _)| found == name);
        let (_, values) = values.ok_or(Error::MissingChannel(name))?;
        Zip::from(&mut *light)
            .and(values)
            .par_for_each(|pixel, value| pixel[channel] += value);
    }
    Ok(())
}
