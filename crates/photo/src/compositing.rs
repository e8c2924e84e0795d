//! Setting a bow into a photograph.
//!
//! out = photo T + (1 − T) S + g (bow + veil)
//! All in linear RGB of the same primaries: `photo` with 1 for its white, `T` what drops (and air in front of the
//! surface) let pass, without diffraction, `S` what drops scatter of the photograph's own light
//! ([`Surroundings`](crate::Surroundings)), `bow` the light of the drops in the sun and `veil` that of the air
//! relative to a sunlit white card, `g` the value which such a card has in the photograph. For compositors the same
//! is premultiplied: RGB = (1 − T) S + g (bow + veil), A = 1 − T, so that `over` gives `out`.

use ndarray::Array2;
use ndarray::Zip;
use niji_geometry::PixelRegion;

use crate::error::Error;
use crate::linear_picture::LinearPicture;
use crate::resample::mix_colors;
use crate::resample::mix_numbers;
use crate::resample::nearest;
use crate::resample::resample;
use crate::resample::same_shape;

/// Light to be added, and what it lets pass.
#[derive(Clone, Debug, PartialEq)]
pub struct AddedLight {
    /// Bow and veil, linear RGB without negative channels, relative to a sunlit white card; once that is
    /// [in a photograph](Self::in_photograph) in the values of it.
    pub light: LinearPicture,
    /// Transmittance T in 0..1.
    pub transmittance: Array2<f32>,
}

impl AddedLight {
    /// The same light at another resolution: a bow is smooth, so that one rendered at a quarter of a
    /// photograph's size will do. Edges of occluders are not smooth; apply them afterwards.
    ///
    /// # Errors
    /// A size of another shape.
    pub fn resized(self, (height, width): (usize, usize)) -> Result<Self, Error> {
        let found = self.light.dim();
        if found == (height, width) {
            return Ok(self);
        }
        if !same_shape(found, (height, width)) {
            return check_size("the light", (height, width), found).map(|()| self);
        }
        Ok(Self {
            light: resample(&self.light, (height, width), mix_colors)?,
            transmittance: resample(&self.transmittance, (height, width), mix_numbers)?,
        })
    }

    /// The same light on other pixels of its frame: nothing is added where there was no light.
    #[must_use]
    pub fn on_region(self, from: PixelRegion, to: PixelRegion) -> Self {
        Self {
            light: on_region(&self.light, from, to, [0.0; 3]),
            transmittance: on_region(&self.transmittance, from, to, 1.0),
        }
    }

    /// The light in the values of a photograph, in which a sunlit white card has the value `gain`, with what the drops
    /// scatter of its own.
    ///
    /// # Errors
    /// A gain that is not a finite number of at least 0, surroundings of another size.
    pub fn in_photograph(mut self, gain: f64, surroundings: &LinearPicture) -> Result<Self, Error> {
        check_gain(gain)?;
        check_size("the surroundings", self.light.dim(), surroundings.dim())?;
        // f32: a code value of 16 bit is 1.5e-5.
        let gain = gain as f32;
        Zip::from(&mut self.light)
            .and(&mut self.transmittance)
            .and(surroundings)
            .par_for_each(|light, transmittance, own| {
                // What is mixed from its neighbors may be rounded above 1.
                *transmittance = transmittance.min(1.0);
                for (light, own) in light.iter_mut().zip(own) {
                    *light = gain * *light + (1.0 - *transmittance) * own;
                }
            });
        Ok(self)
    }

    /// Keeps the light only where the photographed surface lies behind the drops.
    ///
    /// An approximation for light that was integrated without knowing the surface: all light of a
    /// pixel is taken to come from its mean distance `light_m`, so a surface within the drops hides
    /// all of it or none. Distances are along the view ray in metres, infinity for the sky; 0 in
    /// `light_m` is no light. `light_m` may have another resolution: its nearest pixel counts.
    ///
    /// # Errors
    /// Pictures of other sizes or shapes.
    pub fn hide_behind(
        &mut self,
        surface_m: &Array2<f32>,
        light_m: &Array2<f32>,
    ) -> Result<(), Error> {
        check_size("the depth map", self.light.dim(), surface_m.dim())?;
        let size = self.light.dim();
        if !same_shape(size, light_m.dim()) {
            check_size("the distance of the light", size, light_m.dim())?;
        }
        let light_m = resample(light_m, size, nearest)?;
        Zip::from(&mut self.light)
            .and(&mut self.transmittance)
            .and(surface_m)
            .and(&light_m)
            .par_for_each(|light, transmittance, surface_m, light_m| {
                if *light_m > *surface_m || *light_m <= 0.0 {
                    *light = [0.0; 3];
                    *transmittance = 1.0;
                }
            });
        Ok(())
    }
}

/// The photograph with the light in it, which is in its values.
///
/// # Errors
/// Pictures of other sizes.
pub fn composite(photo: &LinearPicture, added: &AddedLight) -> Result<LinearPicture, Error> {
    check_size("the light", photo.dim(), added.light.dim())?;
    check_size("the transmittance", photo.dim(), added.transmittance.dim())?;
    Ok(Zip::from(photo)
        .and(&added.light)
        .and(&added.transmittance)
        .par_map_collect(|photo, light, transmittance| {
            [0, 1, 2].map(|channel: usize| photo[channel] * transmittance + light[channel])
        }))
}

/// The alpha of a plate with the light in it: 1 - T over what the plate covers.
///
///   a = A + (1 - A) a_plate,   A = 1 - T
///
/// # Errors
/// Pictures of other sizes.
pub fn alpha_over(plate: &Array2<f32>, added: &AddedLight) -> Result<Array2<f32>, Error> {
    check_size("the alpha", added.transmittance.dim(), plate.dim())?;
    let pairs = Zip::from(plate).and(&added.transmittance);
    Ok(pairs.par_map_collect(|plate, transmittance| 1.0 - transmittance * (1.0 - plate)))
}

/// The published rule for what is too bright: where a channel exceeds white, all three are scaled so
/// that the largest is white.
///
///   c -> c / max(1, max(c))
pub fn scale_to_white(picture: &mut LinearPicture) {
    picture.par_mapv_inplace(|pixel| {
        let largest = pixel[0].max(pixel[1]).max(pixel[2]).max(1.0);
        pixel.map(|channel| channel / largest)
    });
}

/// The pixels `to` of a frame from a picture of its pixels `from`; `fill` where it has none.
pub fn on_region<T: Copy>(
    picture: &Array2<T>,
    from: PixelRegion,
    to: PixelRegion,
    fill: T,
) -> Array2<T> {
    if from == to {
        return picture.clone();
    }
    let size = (to.height_px as usize, to.width_px as usize);
    // Both are within 2^24 of the frame's corner.
    let offset = [to.y_px - from.y_px, to.x_px - from.x_px];
    Array2::from_shape_fn(size, |(y, x)| {
        let at = [(y, offset[0]), (x, offset[1])]
            .map(|(index, offset)| usize::try_from(index as i64 + i64::from(offset)).ok());
        let pixel = match at {
            [Some(y), Some(x)] => picture.get([y, x]),
            [None, _] | [_, None] => None,
        };
        pixel.copied().unwrap_or(fill)
    })
}

pub(crate) fn check_gain(gain: f64) -> Result<(), Error> {
    if gain >= 0.0 && gain.is_finite() {
        return Ok(());
    }
    Err(Error::Range {
        what: "the value of a sunlit white card in the photograph",
        found: gain,
        expected: "a finite number of at least 0",
    })
}

/// Compares sizes of arrays, rows first.
pub(crate) fn check_size(
    what: &'static str,
    expected: (usize, usize),
    found: (usize, usize),
) -> Result<(), Error> {
    if expected == found {
        return Ok(());
    }
    let (height, width) = expected;
    let (found_height, found_width) = found;
    Err(Error::Size {
        what,
        found_width,
        found_height,
        width,
        height,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn added(light: [f32; 3], transmittance: f32) -> AddedLight {
        AddedLight {
            light: Array2::from_elem((2, 3), light),
            transmittance: Array2::from_elem((2, 3), transmittance),
        }
    }

    #[test]
    fn nothing_added_changes_nothing() {
        let photo = Array2::from_elem((2, 3), [0.1, 0.5, 0.9]);
        assert_eq!(composite(&photo, &added([0.0; 3], 1.0)).unwrap(), photo);
    }

    #[test]
    fn light_is_added_to_what_passes() {
        let photo = Array2::from_elem((2, 3), [0.5, 0.5, 0.0]);
        let black = Array2::from_elem((2, 3), [0.0; 3]);
        let bow = added([0.25, 0.0, 0.5], 0.5).in_photograph(2.0, &black);
        let out = composite(&photo, &bow.unwrap()).unwrap();
        assert_eq!(out[[1, 2]], [0.75, 0.25, 1.0]);
    }

    #[test]
    fn drops_before_one_color_are_not_seen() {
        let photo = Array2::from_elem((2, 3), [0.25, 0.5, 1.5]);
        for transmittance in [0.0, 0.25, 0.5, 1.0] {
            let drops = added([0.0; 3], transmittance).in_photograph(7.0, &photo);
            assert_eq!(composite(&photo, &drops.unwrap()).unwrap(), photo);
        }
    }

    #[test]
    fn premultiplied_over_is_the_same_sum() {
        let (photo, light, t, gain) = (0.4_f32, 0.3_f32, 0.8_f32, 1.5_f32);
        let light = AddedLight {
            light: Array2::from_elem((1, 1), [gain * light; 3]),
            transmittance: Array2::from_elem((1, 1), t),
        };
        let out = composite(&Array2::from_elem((1, 1), [photo; 3]), &light).unwrap();
        let (rgb, alpha) = (light.light[[0, 0]][0], 1.0 - t);
        let over = rgb + (1.0 - alpha) * photo;
        assert!((out[[0, 0]][0] - over).abs() < 1e-6);
    }

    #[test]
    fn light_stays_on_the_pixels_of_its_frame() {
        let light = AddedLight {
            light: Array2::from_shape_fn((2, 3), |(y, x)| [y as f32, x as f32, 7.0]),
            transmittance: Array2::from_elem((2, 3), 0.5),
        };
        let frame = PixelRegion::frame(3, 2);
        let larger = PixelRegion {
            x_px: -1,
            y_px: 1,
            width_px: 5,
            height_px: 2,
        };
        let moved = light.clone().on_region(frame, larger);
        assert_eq!(moved.light[[0, 3]], [1.0, 2.0, 7.0]);
        assert_eq!(
            moved.transmittance.row(0).to_vec(),
            [1.0, 0.5, 0.5, 0.5, 1.0]
        );
        assert_eq!(moved.transmittance.row(1).to_vec(), [1.0; 5]);
        assert_eq!(light.clone().on_region(frame, frame), light);
    }

    #[test]
    fn alpha_of_a_plate_only_grows() {
        let plate = ndarray::array![[0.0, 0.4, 1.0]];
        let added = AddedLight {
            light: Array2::from_elem((1, 3), [0.0; 3]),
            transmittance: Array2::from_elem((1, 3), 0.75),
        };
        let alpha = alpha_over(&plate, &added).unwrap();
        for (found, expected) in alpha.iter().zip([0.25_f32, 0.55, 1.0]) {
            assert!((found - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn the_published_rule_keeps_the_ratio_of_channels() {
        let mut picture = Array2::from_elem((1, 2), [3.0, 1.5, 0.0]);
        picture[[0, 1]] = [0.2, 1.0, 0.4];
        scale_to_white(&mut picture);
        assert_eq!(picture[[0, 0]], [1.0, 0.5, 0.0]);
        assert_eq!(picture[[0, 1]], [0.2, 1.0, 0.4]);
    }

    #[test]
    fn no_light_lands_on_what_is_nearer_than_the_drops() {
        let mut added = added([1.0; 3], 0.5);
        let surface_m = ndarray::array![[10.0, 99.0, f32::INFINITY], [101.0, 0.0, 100.0]];
        let light_m = Array2::from_elem((2, 3), 100.0);
        added.hide_behind(&surface_m, &light_m).unwrap();
        let shown = added.light.mapv(|light| light[0]);
        assert_eq!(shown, ndarray::array![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]);
        assert_eq!(
            added.transmittance,
            ndarray::array![[1.0, 1.0, 0.5], [0.5, 1.0, 0.5]]
        );
        assert!(
            added
                .hide_behind(&surface_m, &Array2::zeros((3, 2)))
                .is_err()
        );
    }

    #[test]
    fn other_sizes_and_gains_are_refused() {
        let photo = Array2::from_elem((3, 2), [0.5; 3]);
        assert!(matches!(
            composite(&photo, &added([0.0; 3], 1.0)),
            Err(Error::Size { .. })
        ));
        let photo = Array2::from_elem((2, 3), [0.5; 3]);
        for gain in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(added([0.0; 3], 1.0).in_photograph(gain, &photo).is_err());
        }
    }
}
