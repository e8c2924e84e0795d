//! A picture put together from its parts.

use std::collections::BTreeSet;

use ndarray::Array2;
use ndarray::Array3;
use ndarray::ArrayView2;
use ndarray::ArrayViewMut2;
use ndarray::Axis;
use ndarray::s;
use niji_exchange::Aov;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_geometry::PixelRegion;

/// A picture some parts of which are there.
pub(crate) struct Assembly {
    image: SpectralImage,
    /// Which pixels are there.
    covered: Array2<bool>,
}

/// Why a part does not belong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Misfit {
    /// Other wavelengths, layers, camera or white.
    Kind(&'static str),
    /// Another value where both parts are.
    Overlap {
        /// Column in the frame.
        x_px: i64,
        /// Row in the frame.
        y_px: i64,
    },
}

impl Assembly {
    /// Nothing yet of the picture `whole` with a provenance, of the kind of one of its parts.
    #[must_use]
    pub(crate) fn new(part: &SpectralImage, whole: PixelRegion, provenance: Provenance) -> Self {
        let size = (whole.height_px as usize, whole.width_px as usize);
        let empty = |aov: &Aov| Aov {
            name: aov.name.clone(),
            unit: aov.unit.clone(),
            channels: {
                let channels = aov.channels.iter();
                channels
                    .map(|(name, _)| (name.clone(), Array2::zeros(size)))
                    .collect()
            },
        };
        let mut windows = part.windows;
        windows.data = whole;
        Self {
            image: SpectralImage {
                wavelengths: part.wavelengths,
                radiance: Array3::zeros((part.radiance.dim().0, size.0, size.1)),
                spectra: part.spectra,
                windows,
                aovs: part.aovs.iter().map(empty).collect(),
                white_luminance_cd_m2: part.white_luminance_cd_m2,
                world_to_camera: part.world_to_camera,
                attributes: part.attributes.clone(),
                provenance,
            },
            covered: Array2::from_elem(size, false),
        }
    }

    /// Puts a part in its place.
    ///
    /// # Errors
    /// A part of another kind, or one that differs from what is there already.
    pub(crate) fn add(&mut self, part: &SpectralImage) -> Result<(), Misfit> {
        check_kind(&self.image, part)?;
        let (whole, region) = (self.image.windows.data, part.windows.data);
        let row = region.y_px.abs_diff(whole.y_px) as usize;
        let column = region.x_px.abs_diff(whole.x_px) as usize;
        let rows = row..row + region.height_px as usize;
        let columns = column..column + region.width_px as usize;
        let place = s![rows, columns];
        let mut covered = self.covered.slice_mut(place);
        let overlaps = covered.iter().any(|covered| *covered);
        let planes = planes_mut(&mut self.image).zip(planes(part));
        for (mut whole, part) in planes {
            let mut whole = whole.slice_mut(place);
            if overlaps {
                check_overlap(&whole, &part, &covered.view(), region)?;
            }
            whole.assign(&part);
        }
        covered.fill(true);
        Ok(())
    }

    /// The picture. What no part covered is black.
    #[must_use]
    pub(crate) fn finish(self) -> SpectralImage {
        self.image
    }
}

/// Whether an image may be a part of another, of which its rows do not count.
///
/// # Errors
/// What is not as it is there.
pub(crate) fn check_kind(image: &SpectralImage, part: &SpectralImage) -> Result<(), Misfit> {
    let layout = |image: &SpectralImage| -> Vec<(String, String, BTreeSet<String>)> {
        let names = |aov: &Aov| aov.channels.iter().map(|(name, _)| name.clone()).collect();
        let aovs = image.aovs.iter();
        aovs.map(|aov| (aov.name.clone(), aov.unit.clone(), names(aov)))
            .collect()
    };
    let bits = |matrix: Option<[f32; 16]>| matrix.map(|matrix| matrix.map(f32::to_bits));
    for (same, what) in [
        (image.wavelengths == part.wavelengths, "wavelengths"),
        (image.spectra == part.spectra, "spectra"),
        (layout(image) == layout(part), "layers"),
        (image.windows.display == part.windows.display, "frame"),
        (image.windows.data.contains(part.windows.data), "picture"),
        (
            bits(image.world_to_camera) == bits(part.world_to_camera),
            "camera",
        ),
        (
            image.white_luminance_cd_m2.to_bits() == part.white_luminance_cd_m2.to_bits(),
            "white",
        ),
        (image.attributes == part.attributes, "attributes"),
    ] {
        if !same {
            return Err(Misfit::Kind(what));
        }
    }
    Ok(())
}

/// The planes in the order that files have: channels of a layer by name.
fn planes(image: &SpectralImage) -> impl Iterator<Item = ArrayView2<'_, f32>> {
    let channels = image.aovs.iter().flat_map(|aov| {
        let mut channels: Vec<_> = aov.channels.iter().collect();
        channels.sort_by(|a, b| a.0.cmp(&b.0));
        channels
    });
    let radiance = image.radiance.axis_iter(Axis(0));
    radiance.chain(channels.map(|(_, values)| values.view()))
}

/// As [`planes`].
fn planes_mut(image: &mut SpectralImage) -> impl Iterator<Item = ArrayViewMut2<'_, f32>> {
    let channels = image.aovs.iter_mut().flat_map(|aov| {
        let mut channels: Vec<_> = aov.channels.iter_mut().collect();
        channels.sort_by(|a, b| a.0.cmp(&b.0));
        channels
    });
    let radiance = image.radiance.axis_iter_mut(Axis(0));
    radiance.chain(channels.map(|(_, values)| values.view_mut()))
}

fn check_overlap(
    whole: &ArrayViewMut2<f32>,
    part: &ArrayView2<f32>,
    covered: &ArrayView2<bool>,
    region: PixelRegion,
) -> Result<(), Misfit> {
    let pairs = whole.indexed_iter().zip(part).zip(covered);
    for (((place, there), here), covered) in pairs {
        if *covered && there.to_bits() != here.to_bits() {
            return Err(Misfit::Overlap {
                x_px: i64::from(region.x_px) + place.1 as i64,
                y_px: i64::from(region.y_px) + place.0 as i64,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use niji_exchange::Attributes;
    use niji_exchange::ImageWindows;
    use niji_exchange::Spectra;
    use niji_radiometry::WavelengthGrid;

    /// Rows of a picture of 5 x 6 pixels whose values are their places.
    fn part(region: PixelRegion) -> SpectralImage {
        let value = |plane: usize, y: usize, x: usize| {
            let (y, x) = (y as i32 + region.y_px, x as i32 + region.x_px);
            (100 * plane as i32 + 10 * y + x) as f32
        };
        let size = (region.height_px as usize, region.width_px as usize);
        let frame = PixelRegion::frame(5, 6);
        SpectralImage {
            wavelengths: WavelengthGrid::new(500.0, 10.0, 2).unwrap(),
            radiance: Array3::from_shape_fn((2, size.0, size.1), |(l, y, x)| value(l, y, x)),
            spectra: Spectra::Full,
            windows: ImageWindows {
                data: region,
                display: frame,
            },
            aovs: vec![Aov {
                name: "depth".to_owned(),
                unit: "m".to_owned(),
                channels: vec![(
                    "Z".to_owned(),
                    Array2::from_shape_fn(size, |(y, x)| value(7, y, x)),
                )],
            }],
            white_luminance_cd_m2: 2.0,
            world_to_camera: None,
            attributes: Attributes::new(),
            provenance: Provenance::default(),
        }
    }

    #[test]
    fn parts_in_any_order_make_the_whole() {
        let whole = PixelRegion::frame(5, 6).grown(1).unwrap();
        let mut parts = whole.bands(3).unwrap();
        parts.reverse();
        // And once more the middle of it.
        parts.push(PixelRegion::frame(5, 6));
        let mut assembly = Assembly::new(&part(parts[0]), whole, Provenance::default());
        for region in parts {
            assembly.add(&part(region)).unwrap();
        }
        assert_eq!(assembly.finish(), part(whole));
    }

    #[test]
    fn another_value_where_two_parts_are_is_named() {
        let whole = PixelRegion::frame(5, 6);
        let mut assembly = Assembly::new(&part(whole), whole, Provenance::default());
        let bands = whole.bands(2).unwrap();
        assembly.add(&part(bands[0])).unwrap();
        let mut changed = part(whole);
        changed.aovs[0].channels[0].1[[2, 4]] += 1.0;
        let (x_px, y_px) = (4, 2);
        assert_eq!(assembly.add(&changed), Err(Misfit::Overlap { x_px, y_px }));
        let mut other = part(bands[1]);
        other.aovs.clear();
        assert_eq!(assembly.add(&other), Err(Misfit::Kind("layers")));
    }
}
