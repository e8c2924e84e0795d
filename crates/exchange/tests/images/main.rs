//! Spectral images, their plain companions and previews.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod layers;
mod strips;
mod windows;

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;

use exr::prelude::FlatSamples;
use ndarray::Array2;
use ndarray::Array3;
use ndarray::Axis;
use ndarray::s;
use niji_exchange::Aov;
use niji_exchange::AttributeValue;
use niji_exchange::Attributes;
use niji_exchange::Error;
use niji_exchange::ImageWindows;
use niji_exchange::LayerRms;
use niji_exchange::Provenance;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_exchange::contents;
use niji_exchange::read_provenance;
use niji_geometry::PixelRegion;
use niji_radiometry::Colorimetry;
use niji_radiometry::GamutPolicy;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::linear_rec709_to_xyz;
use niji_radiometry::srgb_encode;

const HEIGHT: usize = 70;
const WIDTH: usize = 45;

/// Noise without a pattern, 0 to 1.
fn noise(index: usize) -> f32 {
    let bits = (index as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((bits ^ (bits >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f32 / (1 << 24) as f32
}

fn plane(seed: usize) -> Array2<f32> {
    Array2::from_shape_fn((HEIGHT, WIDTH), |(y, x)| noise(seed + WIDTH * y + x))
}

fn image() -> SpectralImage {
    let wavelengths = WavelengthGrid::new(400.0, 100.0 / 3.0, 10).unwrap();
    SpectralImage {
        wavelengths,
        radiance: Array3::from_shape_fn((10, HEIGHT, WIDTH), |(l, y, x)| {
            1e-2 * noise(77_777 * l + WIDTH * y + x)
        }),
        spectra: Spectra::Full,
        windows: ImageWindows::whole(WIDTH, HEIGHT),
        aovs: vec![
            Aov {
                name: "bow_primary".to_owned(),
                unit: "W.m^-2.sr^-1.nm^-1".to_owned(),
                channels: vec![
                    ("550nm".to_owned(), plane(1)),
                    ("600nm".to_owned(), plane(2)),
                ],
            },
            Aov {
                name: "transmittance".to_owned(),
                unit: "-".to_owned(),
                channels: vec![("Y".to_owned(), Array2::from_elem((HEIGHT, WIDTH), 0.25))],
            },
            Aov {
                name: "depth".to_owned(),
                unit: "m".to_owned(),
                channels: vec![("Z".to_owned(), plane(3) * 100.0)],
            },
        ],
        white_luminance_cd_m2: 1234.567890123,
        world_to_camera: Some(std::array::from_fn(|i| i as f32 + 0.1)),
        attributes: Attributes::from([(
            "niji:sunElevationDeg".to_owned(),
            AttributeValue::Number(20.1),
        )]),
        provenance: Provenance {
            tool: "niji render".to_owned(),
            version: "0.1.0".to_owned(),
            settings: "{}".to_owned(),
            inputs: BTreeMap::new(),
        },
    }
}

fn spectral_bytes(image: &SpectralImage) -> Vec<u8> {
    let mut cursor = Cursor::new(Vec::new());
    image.write_spectral(&mut cursor).unwrap();
    cursor.into_inner()
}

fn read(bytes: &[u8]) -> Result<SpectralImage, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    fs::write(&path, bytes).unwrap();
    SpectralImage::read_spectral(&path)
}

#[test]
fn an_image_comes_back_bit_for_bit_with_wavelengths_aovs_and_camera() {
    let image = image();
    let bytes = spectral_bytes(&image);
    let found = read(&bytes).unwrap();
    assert_eq!(found, image);
    assert_eq!(
        spectral_bytes(&found),
        bytes,
        "writing again gives the same bytes"
    );
}

#[test]
fn headers_tell_the_rms_of_light_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let mut image = image();
    let unit = "cd/m^2".to_owned();
    let mut values = Array2::zeros((HEIGHT, WIDTH));
    values[[0, 0]] = 3.0;
    values[[HEIGHT - 1, WIDTH - 1]] = -4.0;
    image.aovs.push(Aov {
        name: "error".to_owned(),
        unit,
        channels: vec![("Y".to_owned(), values), ("sizes".to_owned(), plane(4))],
    });
    for spectra in [Spectra::Full, Spectra::Half] {
        image.spectra = spectra;
        fs::write(&path, spectral_bytes(&image)).unwrap();
        let told = LayerRms::read(&path).unwrap();
        let written = SpectralImage::read_picture(&path).unwrap();
        let layer = written.aovs.iter().find(|it| it.name == "error").unwrap();
        assert_eq!(
            told,
            [LayerRms::of(layer)],
            "distances and shares have none"
        );
        let rms = told[0].of_channel("Y");
        let expected = 5.0 / ((HEIGHT * WIDTH) as f64).sqrt();
        assert!((rms / expected - 1.0).abs() < 1e-12, "{rms}");
        assert_eq!(told[0].of_channel("air"), 0.0);
    }
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 10]).unwrap();
    assert!(LayerRms::read(&path).is_err());
}

#[test]
fn an_image_that_was_cut_short_has_no_provenance() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let bytes = spectral_bytes(&image());
    fs::write(&path, &bytes).unwrap();
    assert_eq!(read_provenance(&path).unwrap(), Some(image().provenance));
    // Compressed pixels: their number tells nothing about how long the file has to be.
    for lost in [1, 100, bytes.len() / 2] {
        fs::write(&path, &bytes[..bytes.len() - lost]).unwrap();
        assert!(
            matches!(read_provenance(&path), Err(Error::Damaged(_))),
            "{lost}"
        );
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let image = image();
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .unwrap();
        pool.install(|| {
            let mut rgb = Cursor::new(Vec::new());
            image.write_layers(RgbPrimaries::Rec709, &mut rgb).unwrap();
            let mut png = Vec::new();
            image.write_png(&mut png, 0.0).unwrap();
            (spectral_bytes(&image), rgb.into_inner(), png)
        })
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(2));
    assert_eq!(one, with_threads(7));
}

#[test]
fn channels_and_attributes_follow_the_spectral_layout() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    fs::write(&path, spectral_bytes(&image())).unwrap();
    let parts = contents(&path).unwrap();
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["spectral", "bow_primary", "transmittance", "depth"]);
    let channels: Vec<&str> = parts[0].channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(
        channels[..5],
        ["B", "G", "R", "S0.400,000000nm", "S0.433,333333nm"]
    );
    let text = |name: &str| parts[0].attributes[name].clone();
    let is = |text: &str| AttributeValue::Text(text.to_owned());
    assert_eq!(text("spectralLayoutVersion"), is("1.0"));
    assert_eq!(text("emissiveUnits"), is("W.m^-2.sr^-1"));
    assert_eq!(text("niji:spectralUnit"), is("W.m^-2.sr^-1.nm^-1"));
}

#[test]
fn values_that_are_not_finite_name_the_wavelength_and_the_pixel() {
    let mut broken = image();
    broken.radiance[[3, 12, 34]] = f32::NAN;
    let error = broken.write_spectral(Cursor::new(Vec::new())).unwrap_err();
    let expected = "found NaN in part \"spectral\", channel \"S0.500,000000nm\", pixel (34, 12), \
                    expected a finite number";
    assert_eq!(error.to_string(), expected);
    assert!(matches!(
        broken.write_layers(RgbPrimaries::Rec709, Cursor::new(Vec::new())),
        Err(Error::NotFinite { x: 34, y: 12, .. })
    ));
    assert!(matches!(
        broken.write_png(Vec::new(), 0.0),
        Err(Error::NotFinite { x: 34, y: 12, .. })
    ));
    let mut broken = image();
    broken.aovs[0].channels[1].1[[0, 1]] = f32::INFINITY;
    let error = broken.write_spectral(Cursor::new(Vec::new())).unwrap_err();
    assert!(
        matches!(error, Error::NotFinite { x: 1, y: 0, .. }),
        "{error}"
    );
}

#[test]
fn numbers_beside_the_pixels_that_are_not_finite_are_refused() {
    for exposure_ev in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1024.0] {
        let error = image().write_png(Vec::new(), exposure_ev).unwrap_err();
        assert!(matches!(error, Error::Exposure { .. }), "{error}");
    }
    image().write_png(Vec::new(), -40.0).unwrap();
    let mut broken = image();
    broken.world_to_camera = Some([f32::NAN; 16]);
    let error = broken.write_spectral(Cursor::new(Vec::new())).unwrap_err();
    assert!(
        error.to_string().contains("attribute \"worldToCamera\""),
        "{error}"
    );
}

#[test]
fn aovs_of_another_size_and_images_without_pixels_are_refused() {
    let mut broken = image();
    broken.aovs[1].channels[0].1 = Array2::zeros((HEIGHT, WIDTH + 1));
    let error = broken.write_spectral(Cursor::new(Vec::new())).unwrap_err();
    assert!(matches!(error, Error::Shape { .. }), "{error}");
    let mut empty = image();
    empty.aovs.clear();
    empty.radiance = Array3::zeros((10, 0, 0));
    empty.windows = ImageWindows::whole(0, 0);
    let error = empty.write_spectral(Cursor::new(Vec::new())).unwrap_err();
    assert!(matches!(error, Error::Empty { .. }), "{error}");
    assert!(
        empty
            .write_layers(RgbPrimaries::Rec709, Cursor::new(Vec::new()))
            .is_err()
    );
    assert!(empty.write_png(Vec::new(), 0.0).is_err());
}

#[test]
fn a_plain_image_is_no_spectral_one() {
    let mut cursor = Cursor::new(Vec::new());
    image()
        .write_layers(RgbPrimaries::Rec709, &mut cursor)
        .unwrap();
    let error = read(&cursor.into_inner()).unwrap_err();
    assert!(
        matches!(
            error,
            Error::Missing {
                kind: "channel",
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn the_preview_shows_the_tone_curve_in_srgb() {
    let mut grey = image();
    // An equal-energy spectrum whose green channel is 0.18 of the white.
    grey.radiance.fill(1e-3);
    let green = f64::from(grey.rgb(RgbPrimaries::Rec709, GamutPolicy::Desaturate)[[1, 0, 0]]);
    grey.white_luminance_cd_m2 *= green / 0.18;
    for (exposure_ev, expected) in [(0.0, 0.18), (1.0, 0.36), (-2.0, 0.045)] {
        let mut png = Vec::new();
        grey.write_png(&mut png, exposure_ev).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(png)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let info = reader.info();
        assert_eq!((info.width, info.height), (WIDTH as u32, HEIGHT as u32));
        assert!(info.srgb.is_some());
        let names: Vec<&str> = info
            .utf8_text
            .iter()
            .map(|text| text.keyword.as_str())
            .collect();
        assert!(names.contains(&"niji:requestHash"));
        assert_eq!(
            f64::from(pixels[1]),
            (255.0 * srgb_encode(expected)).round()
        );
    }
}
