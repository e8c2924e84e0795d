//! What a bow is set into, and the light of a rendered image on its pixels.

use std::path::Path;
use std::path::PathBuf;

use ndarray::Array2;
use ndarray::s;
use niji_exchange::ImageWindows;
use niji_exchange::SpectralImage;
use niji_exchange::tone_curve;
use niji_geometry::PixelRegion;
use niji_photo::AddedLight;
use niji_photo::Encoding;
use niji_photo::ExifNotes;
use niji_photo::Frame;
use niji_photo::LinearPicture;
use niji_photo::Photograph;
use niji_photo::Plate;
use niji_photo::distance_of_light;
use niji_photo::on_region;
use niji_photo::square_means;
use niji_photo::surface_of_light;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::into_gamut;

use crate::error::Error;

/// What an error calls distances from elsewhere.
pub const DEPTH_MAP: &str = "the depth map";

/// A photograph or a plate, in the primaries of the output.
#[derive(Clone, Debug)]
pub struct Background {
    /// Its linear light.
    pub light: LinearPicture,
    /// What hides what is behind it, of a plate that says so.
    pub alpha: Option<Array2<f32>>,
    /// Distances of its surfaces along the view ray, m.
    pub surface_m: Option<Array2<f32>>,
    /// Its place in the frame, and what its red, green and blue are.
    pub frame: Frame,
    /// What the camera noted.
    pub notes: ExifNotes,
    encoding: Encoding,
    /// Its file.
    pub(crate) path: PathBuf,
}

impl Background {
    /// Reads it. `named` are the primaries of a plate that names others or none, `wanted` those of the
    /// output: its own where there are none.
    ///
    /// # Errors
    /// A file that is missing, damaged or holds what light cannot be.
    pub(crate) fn read(
        path: &Path,
        named: Option<RgbPrimaries>,
        wanted: Option<RgbPrimaries>,
    ) -> Result<Self, Error> {
        let bad = |error: niji_photo::Error| Error::file(path, error);
        let is_plate = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        let mut own = if is_plate {
            let plate = Plate::read(path, named).map_err(bad)?;
            Self {
                light: plate.light,
                alpha: plate.alpha,
                surface_m: plate.surface_m,
                frame: Frame {
                    primaries: plate.primaries,
                    windows: plate.windows,
                },
                notes: ExifNotes::default(),
                encoding: Encoding::Linear,
                path: path.to_owned(),
            }
        } else {
            let photo = Photograph::read(path).map_err(bad)?;
            let (height, width) = photo.light.dim();
            Self {
                light: photo.light,
                alpha: None,
                surface_m: None,
                frame: Frame {
                    primaries: RgbPrimaries::Rec709,
                    windows: ImageWindows::whole(width, height),
                },
                notes: photo.notes,
                encoding: photo.encoding,
                path: path.to_owned(),
            }
        };
        let wanted = wanted.unwrap_or(own.frame.primaries);
        own.light = converted(own.light, own.frame.primaries, wanted);
        own.frame.primaries = wanted;
        Ok(own)
    }

    /// The same with fewer pixels, means of squares of `n` x `n`; a plate of part of a frame as it is.
    #[must_use]
    pub(crate) fn in_squares(self, n: usize) -> Self {
        let (height, width) = self.light.dim();
        let whole = ImageWindows::whole(width, height);
        if n < 2 || self.frame.windows != whole || n > width.min(height) {
            return self;
        }
        // What is left over at the right and below is no square.
        let size = (height / n, width / n);
        let squares = s![..n * size.0, ..n * size.1];
        let mean = |values: &Array2<f32>| {
            let each = values.slice(squares).mapv(|value| [value; 1]);
            square_means(&each.view(), n).mapv(|[mean]| mean)
        };
        Self {
            light: square_means(&self.light.slice(squares), n),
            alpha: self.alpha.as_ref().map(mean),
            // Surfaces are not mixed.
            surface_m: (self.surface_m.as_ref()).map(|surface_m| {
                Array2::from_shape_fn(size, |(row, column)| {
                    surface_m[[n * row + n / 2, n * column + n / 2]]
                })
            }),
            frame: Frame {
                windows: ImageWindows::whole(size.1, size.0),
                ..self.frame
            },
            ..self
        }
    }

    /// Takes the distances of its surfaces from elsewhere.
    ///
    /// # Errors
    /// Distances of another size.
    pub(crate) fn set_surfaces(&mut self, surface_m: Array2<f32>) -> Result<(), niji_photo::Error> {
        let (height, width) = self.light.dim();
        let (found_height, found_width) = surface_m.dim();
        if (found_height, found_width) != (height, width) {
            return Err(niji_photo::Error::Size {
                what: DEPTH_MAP,
                found_width,
                found_height,
                width,
                height,
            });
        }
        self.surface_m = Some(surface_m);
        Ok(())
    }

    /// Bow and veil of a rendered image on its pixels, in front of its surfaces.
    ///
    /// # Errors
    /// An image of another shape, or without what compositing needs.
    pub(crate) fn added(&self, image: &SpectralImage) -> Result<AddedLight, Error> {
        let data = self.frame.windows.data;
        let Grid { from, to, work } = self.grid(image)?;
        let light = AddedLight::of_image(image, self.frame.primaries)?;
        let light = light.on_region(from, to);
        let size = (work.height_px as usize, work.width_px as usize);
        let Some(surface_m) = &self.surface_m else {
            let light = light.resized(size)?;
            return Ok(light.on_region(work, data));
        };
        let surface_m = on_region(surface_m, data, work, f32::INFINITY);
        let light = if let Some(ends_m) = surface_of_light(image) {
            let ends_m = on_region(ends_m, from, to, f32::INFINITY);
            light.at_surfaces(&ends_m, &surface_m)?
        } else {
            let light_m = distance_of_light(image)?;
            let light_m = on_region(light_m, from, to, 0.0);
            let mut light = light.resized(size)?;
            light.hide_behind(&surface_m, &light_m)?;
            light
        };
        Ok(light.on_region(work, data))
    }

    fn grid(&self, image: &SpectralImage) -> Result<Grid, Error> {
        let ImageWindows { data, display } = self.frame.windows;
        let own = image.windows;
        let size = |region: PixelRegion| [region.width_px, region.height_px];
        if size(own.display) == size(display) {
            let from = PixelRegion {
                x_px: own.data.x_px - own.display.x_px + display.x_px,
                y_px: own.data.y_px - own.display.y_px + display.y_px,
                ..own.data
            };
            return Ok(Grid {
                from,
                to: data,
                work: data,
            });
        }
        if own.data != own.display {
            return Err(Error::PartOfFrame);
        }
        Ok(Grid {
            from: own.data,
            to: own.data,
            work: display,
        })
    }

    /// A picture of it as a display shows it, in Rec.709: a photograph as it is, scene-linear light by
    /// the tone curve of previews.
    pub fn shown(&self, picture: &LinearPicture, exposure_ev: f64) -> LinearPicture {
        let mut rec709 = self.rec709(picture);
        let scale = exposure_ev.exp2();
        rec709.par_mapv_inplace(|rgb| {
            let rgb = rgb.map(|channel| scale * f64::from(channel));
            let rgb = match self.encoding {
                Encoding::Linear => {
                    into_gamut(rgb, RgbPrimaries::Rec709, GamutPolicy::Desaturate).map(tone_curve)
                }
                Encoding::Srgb8 | Encoding::Srgb16 => rgb,
            };
            // f32: code values have 8 bit.
            rgb.map(|channel| channel as f32)
        });
        rec709
    }

    /// The picture in Rec.709, for displays and for its luminance.
    pub fn rec709(&self, picture: &LinearPicture) -> LinearPicture {
        converted(picture.clone(), self.frame.primaries, RgbPrimaries::Rec709)
    }
}

/// How the pixels of a rendered image come to those of the picture.
struct Grid {
    /// Pixels of the image, in the frame of the picture if both have one size.
    from: PixelRegion,
    /// Those of them that count.
    to: PixelRegion,
    /// Pixels of the picture that they become.
    work: PixelRegion,
}

fn converted(mut picture: LinearPicture, from: RgbPrimaries, to: RgbPrimaries) -> LinearPicture {
    if from != to {
        picture.par_mapv_inplace(|rgb| {
            let rec709 = from.to_linear_rec709(rgb.map(f64::from));
            // f32: what files hold.
            to.of_linear_rec709(rec709).map(|channel| channel as f32)
        });
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_have_the_mean_of_their_light_and_the_distance_in_their_middle() {
        let own = Background {
            light: Array2::from_shape_fn((7, 9), |(row, column)| [row as f32, column as f32, 1.0]),
            alpha: Some(Array2::from_shape_fn((7, 9), |(row, _)| row as f32 / 8.0)),
            surface_m: Some(Array2::from_shape_fn((7, 9), |(row, column)| {
                if row == column {
                    f32::INFINITY
                } else {
                    (10 * row + column) as f32
                }
            })),
            frame: Frame {
                primaries: RgbPrimaries::Rec709,
                windows: ImageWindows::whole(9, 7),
            },
            notes: ExifNotes::default(),
            encoding: Encoding::Linear,
            path: PathBuf::new(),
        };
        let half = own.clone().in_squares(2);
        assert_eq!(half.frame.windows, ImageWindows::whole(4, 3));
        assert_eq!(half.light.dim(), (3, 4));
        assert_eq!(half.light[[1, 3]], [2.5, 6.5, 1.0]);
        assert_eq!(half.alpha.unwrap()[[1, 3]], 2.5 / 8.0);
        let surface_m = half.surface_m.unwrap();
        assert_eq!(
            (surface_m[[1, 3]], surface_m[[1, 1]]),
            (37.0, f32::INFINITY)
        );
        for n in [0, 1, 8] {
            assert_eq!(own.clone().in_squares(n).light, own.light, "{n}");
        }
        // A plate of part of a frame.
        let mut part = own.clone();
        part.frame.windows.display.width_px = 20;
        assert_eq!(part.clone().in_squares(3).light, part.light);
    }
}
