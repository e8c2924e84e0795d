//! A rendered bow set into a photograph or a plate, in linear light.

use std::path::Path;

use ndarray::Array2;
use niji_exchange::SpectralImage;
use niji_photo::AddedLight;
use niji_photo::Exposure;
use niji_photo::LinearPicture;
use niji_photo::card_value;
use niji_photo::composite;
use niji_photo::scale_to_white;
use niji_radiometry::RgbPrimaries;
use niji_scene::Photo;
use niji_scene::PhotoExposure;

use crate::background::Background;
use crate::error::Error;
use crate::photographed_light::photographed_light;

/// How bright a sunlit white card is in the photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CardExposure {
    /// The mean of the picture is grey.
    Match,
    /// As f-number, time and speed in EXIF say.
    Camera,
    /// This value, linear.
    Value(f64),
}

impl From<&Photo> for CardExposure {
    fn from(section: &Photo) -> Self {
        match (section.white_card, section.exposure) {
            (Some(value), _) => Self::Value(value),
            (None, PhotoExposure::Match) => Self::Match,
            (None, PhotoExposure::Camera) => Self::Camera,
        }
    }
}

/// What a bow is set into, and how.
#[derive(Clone, Debug)]
pub struct CompositeRequest<'a> {
    /// The photograph (PNG, JPEG) or plate (EXR).
    pub photo: &'a Path,
    /// Distances of its surfaces along the view rays (m): a plate's own where they are left out.
    pub depth_m: Option<Array2<f32>>,
    /// What red, green and blue of a plate are, whatever its file says.
    pub plate_primaries: Option<RgbPrimaries>,
    /// What they are in the result: those of the plate where it is left out.
    pub primaries: Option<RgbPrimaries>,
    /// The exposure.
    pub exposure: CardExposure,
    /// Whether what is too bright is scaled until the largest channel is white, as published.
    pub scales_to_white: bool,
}

/// The picture and what it is made of.
pub struct Composite {
    /// What the bow was set into.
    pub background: Background,
    /// The bow in it.
    pub bow: SetBow,
}

/// A bow in its background.
pub struct SetBow {
    /// Both together, in the primaries of the result.
    pub picture: LinearPicture,
    /// What is added to it in its values, and the transmittance.
    pub added: AddedLight,
    /// Value of a sunlit white card in the photograph.
    pub gain: f64,
}

impl CompositeRequest<'_> {
    /// Sets the bow of an image into it.
    ///
    /// # Errors
    /// A photograph that is missing or damaged, surfaces or an image of another shape, an exposure that cannot
    /// be told.
    pub fn with_bow(self, image: &SpectralImage) -> Result<Composite, Error> {
        let mut background = Background::read(self.photo, self.plate_primaries, self.primaries)?;
        if let Some(surface_m) = self.depth_m {
            background.set_surfaces(surface_m)?;
        }
        let mut bow = background.with_bow(image, self.exposure)?;
        if self.scales_to_white {
            scale_to_white(&mut bow.picture);
        }
        Ok(Composite { background, bow })
    }
}

impl Background {
    /// Sets the bow of an image into it.
    ///
    /// # Errors
    /// An image of another shape, an exposure that cannot be told.
    pub fn with_bow(&self, image: &SpectralImage, exposure: CardExposure) -> Result<SetBow, Error> {
        let added = self.added(image)?;
        let exposure = match exposure {
            CardExposure::Match => Exposure::GreyWorld,
            CardExposure::Camera => Exposure::Camera {
                card_cd_m2: image.white_luminance_cd_m2,
            },
            CardExposure::Value(value) => Exposure::Card(value),
        };
        let of_photo = |error: niji_photo::Error| Error::file(&self.path, error);
        let rec709 = self.rec709(&self.light);
        let gain = card_value(exposure, &rec709, &self.notes).map_err(of_photo)?;
        let own = photographed_light(self, (image, &added))?;
        let added = added.in_photograph(gain, &own).map_err(of_photo)?;
        let picture = composite(&self.light, &added).map_err(of_photo)?;
        Ok(SetBow {
            picture,
            added,
            gain,
        })
    }
}
