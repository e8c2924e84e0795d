//! Spectral images, their plain companions and previews.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

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
fn layers_are_read_alone_and_damage_elsewhere_is_not_met() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let mut bytes = spectral_bytes(&image());
    fs::write(&path, &bytes).unwrap();
    let names = ["depth", "transmittance", "none of these"];
    let expected = image().aovs[1..].to_vec();
    assert_eq!(SpectralImage::read_aovs(&path, &names).unwrap(), expected);
    // The spectra come first after the headers, the layers last.
    let middle = bytes.len() / 3;
    bytes[middle..middle + 64].fill(0x5a);
    fs::write(&path, &bytes).unwrap();
    assert!(SpectralImage::read_spectral(&path).is_err());
    assert_eq!(SpectralImage::read_aovs(&path, &names).unwrap(), expected);
    let cut = bytes.len() - 10;
    fs::write(&path, &bytes[..cut]).unwrap();
    assert!(SpectralImage::read_aovs(&path, &names).is_err());
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
fn rgb_times_white_is_the_luminance_of_the_spectrum() {
    let image = image();
    let rgb = image.rgb(RgbPrimaries::Rec709, GamutPolicy::Desaturate);
    let spectrum: Vec<f64> = (0..10)
        .map(|l| f64::from(image.radiance[[l, 33, 21]]))
        .collect();
    let luminance = Colorimetry::new(&image.wavelengths).xyz(&spectrum)[1];
    let pixel = [0, 1, 2].map(|channel| f64::from(rgb[[channel, 33, 21]]));
    let found = linear_rec709_to_xyz(pixel)[1] * image.white_luminance_cd_m2;
    // f32 in R, G, B; worst found 3e-8.
    assert!(
        (found / luminance - 1.0).abs() < 2e-7,
        "{found} against {luminance}"
    );
    assert!(rgb.iter().all(|value| *value >= 0.0));
}

#[test]
fn light_where_nothing_covers_survives_in_the_plain_image() {
    let mut image = image();
    image.aovs.retain(|aov| aov.name != "transmittance");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.layers.exr");
    let mut cursor = Cursor::new(Vec::new());
    image
        .write_layers(RgbPrimaries::Rec709, &mut cursor)
        .unwrap();
    fs::write(&path, cursor.into_inner()).unwrap();
    let parts = contents(&path).unwrap();
    let names: Vec<&str> = parts[0].channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!((parts.len(), names), (1, vec!["A", "B", "G", "R", "Z"]));
    assert_eq!(
        (parts[0].channels[0].min, parts[0].channels[0].max),
        (0.0, 0.0)
    );
    let expected = image.rgb(RgbPrimaries::Rec709, GamutPolicy::Desaturate);
    let brightest = expected.iter().copied().fold(0.0, f32::max);
    let found = parts[0].channels[1..4]
        .iter()
        .map(|c| c.max)
        .fold(0.0, f32::max);
    // Half a unit in the last place of a half float.
    assert!((found / brightest - 1.0).abs() <= f32::powi(2.0, -11));
    assert!(brightest > 0.0);
}

#[test]
fn alpha_is_what_the_drops_cover_and_z_the_depth() {
    let image = image();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.layers.exr");
    let mut cursor = Cursor::new(Vec::new());
    image
        .write_layers(RgbPrimaries::Rec709, &mut cursor)
        .unwrap();
    fs::write(&path, cursor.into_inner()).unwrap();
    let channels = &contents(&path).unwrap()[0].channels;
    assert_eq!((channels[0].min, channels[0].max), (0.75, 0.75));
    let deepest = image.aovs[2].channels[0]
        .1
        .iter()
        .copied()
        .fold(0.0, f32::max);
    assert_eq!(channels[4].max, deepest);
}

/// Colors with two lights that add up to them, one of them outside the gamut of displays at every pixel.
fn image_of_two_lights() -> SpectralImage {
    let mut image = image();
    let observer = Colorimetry::new(&image.wavelengths);
    let xyz = image.radiance.map_axis(Axis(0), |spectrum| {
        let spectrum: Vec<f64> = spectrum.iter().map(|value| f64::from(*value)).collect();
        observer.xyz(&spectrum)
    });
    let share = |channel: usize, (y, x): (usize, usize)| {
        0.1 + 0.8 * f64::from(noise(channel + 3 * (WIDTH * y + x)))
    };
    let light = |name: &str, part: &dyn Fn(f64) -> f64| Aov {
        name: name.to_owned(),
        unit: "cd/m^2".to_owned(),
        channels: ["X", "Y", "Z"]
            .iter()
            .enumerate()
            .map(|(channel, name)| {
                let values = Array2::from_shape_fn((HEIGHT, WIDTH), |place| {
                    (part(share(channel, place)) * xyz[place][channel]) as f32
                });
                ((*name).to_owned(), values)
            })
            .collect(),
    };
    image.aovs[0] = light("bow_primary", &|share| share);
    image.aovs.push(light("sky", &|share| 1.0 - share));
    image
}

#[test]
fn layers_for_compositors_add_up_to_the_picture_as_another_reader_has_them() {
    let image = image_of_two_lights();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.layers.exr");
    for primaries in RgbPrimaries::ALL {
        let mut cursor = Cursor::new(Vec::new());
        image.write_layers(primaries, &mut cursor).unwrap();
        fs::write(&path, cursor.into_inner()).unwrap();
        let file = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
        let [part] = file.layer_data.as_slice() else {
            panic!("expected one part");
        };
        let channels = &part.channel_data.list;
        let names: Vec<String> = channels.iter().map(|it| it.name.to_string()).collect();
        let layers = ["bow_primary.B", "bow_primary.G", "bow_primary.R"];
        assert_eq!(
            names[5..],
            [&layers[..], &["sky.B", "sky.G", "sky.R"]].concat()
        );
        let values = |name: &str| -> Vec<f32> {
            let channel = channels.iter().find(|it| it.name == *name).unwrap();
            let is_half = matches!(channel.sample_data, FlatSamples::F16(_));
            assert_eq!(is_half, name != "Z", "{name}");
            channel.sample_data.values_as_f32().collect()
        };
        let mut any_negative = false;
        for channel in ["R", "G", "B"] {
            let [whole, bow, sky] =
                ["", "bow_primary.", "sky."].map(|layer| values(&format!("{layer}{channel}")));
            for ((whole, bow), sky) in whole.iter().zip(&bow).zip(&sky) {
                let rounding = (whole.abs() + bow.abs() + sky.abs()) * f32::powi(2.0, -11);
                assert!((bow + sky - whole).abs() <= rounding + 1e-7);
                assert!(*whole >= 0.0);
                any_negative |= *bow < 0.0;
            }
        }
        assert!(any_negative);
        let expected = image.rgb(primaries, GamutPolicy::Desaturate);
        for (channel, name) in ["R", "G", "B"].iter().enumerate() {
            let expected = expected.index_axis(Axis(0), channel);
            for (found, expected) in values(name).iter().zip(expected) {
                assert!((found - expected).abs() <= expected * f32::powi(2.0, -11) + 3e-8);
            }
        }
    }
}

#[test]
fn spectra_in_half_floats_err_by_their_last_place_and_come_back_as_they_were_written() {
    let full = image_of_two_lights();
    let half = full.clone().keeping(Spectra::Half);
    let light = |image: &SpectralImage| image.aovs[0].channels[1].1.clone();
    for (kept, value) in light(&half).iter().zip(&light(&full)) {
        assert!((kept - value).abs() <= value * f32::powi(2.0, -11) + 3e-8);
    }
    // Shares and distances stay.
    assert_eq!(half.aovs[1..3], full.aovs[1..3]);
    for (kept, value) in half.radiance.iter().zip(&full.radiance) {
        let most = (value * f32::powi(2.0, -11)).max(f32::powi(2.0, -25));
        assert!((kept - value).abs() <= most, "{kept} {value}");
    }
    assert!(half.radiance != full.radiance);
    let bytes = spectral_bytes(&half);
    assert_eq!(read(&bytes).unwrap(), half);
    // Noise is packed to nothing less than its digits.
    assert!(bytes.len() * 10 < spectral_bytes(&full).len() * 7);
    // What was rounded once stays.
    assert_eq!(half.clone().keeping(Spectra::Half), half);
}

#[test]
fn an_image_without_spectra_has_its_colors_and_says_so_to_whom_needs_more() {
    let full = image();
    let colors = full.clone().keeping(Spectra::Left);
    let bytes = spectral_bytes(&colors);
    let refused = read(&bytes).unwrap_err();
    assert!(matches!(refused, Error::NoSpectra));
    assert!(refused.to_string().contains("picture.spectral"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    fs::write(&path, &bytes).unwrap();
    let again = SpectralImage::read_picture(&path).unwrap();
    assert_eq!(again, colors);
    assert_eq!(again.clone().keeping(Spectra::Full), colors);
    for primaries in RgbPrimaries::ALL {
        let [found, expected] =
            [&again, &full].map(|image| image.rgb(primaries, GamutPolicy::Desaturate));
        let brightest = expected.iter().copied().fold(0.0, f32::max);
        for (found, expected) in found.iter().zip(&expected) {
            // f32 in X, Y, Z; worst found 1e-7.
            assert!((found - expected).abs() <= 5e-7 * brightest);
        }
    }
    let names: Vec<String> = contents(&path)
        .unwrap()
        .into_iter()
        .map(|part| part.name)
        .collect();
    assert_eq!(names, ["color", "bow_primary", "transmittance", "depth"]);
}

#[test]
fn what_half_cannot_hold_is_float() {
    let mut image = image_of_two_lights();
    image.white_luminance_cd_m2 = 1e-6;
    let mut cursor = Cursor::new(Vec::new());
    image
        .write_layers(RgbPrimaries::Rec709, &mut cursor)
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.layers.exr");
    fs::write(&path, cursor.into_inner()).unwrap();
    let parts = niji_exchange::read_plain(&path).unwrap();
    let green = parts[0].channels.iter().find(|it| it.name == "G").unwrap();
    let expected = image.rgb(RgbPrimaries::Rec709, GamutPolicy::Desaturate);
    for (found, expected) in green.values.iter().zip(expected.index_axis(Axis(0), 1)) {
        assert!((found - expected).abs() <= expected * f32::powi(2.0, -11) + 1e-3);
    }
    assert!(green.values.iter().any(|value| *value > 65504.0));
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

/// Rows and columns of an image, in the pixels of its frame.
fn cut(image: &SpectralImage, region: PixelRegion) -> SpectralImage {
    let origin = image.windows.data;
    let range = |start: i32, origin: i32, n: u32| {
        let first = start.abs_diff(origin) as usize;
        first..first + n as usize
    };
    let rows = range(region.y_px, origin.y_px, region.height_px);
    let columns = range(region.x_px, origin.x_px, region.width_px);
    let plane = |values: &Array2<f32>| values.slice(s![rows.clone(), columns.clone()]).to_owned();
    let mut cut = image.clone();
    cut.windows.data = region;
    let radiance = image.radiance.slice(s![.., rows.clone(), columns.clone()]);
    cut.radiance = radiance.to_owned();
    for channel in cut.aovs.iter_mut().flat_map(|aov| &mut aov.channels) {
        channel.1 = plane(&channel.1);
    }
    cut
}

/// The image as one with a frame of 35 x 60 pixels and overscan around it.
fn with_overscan() -> SpectralImage {
    let display = PixelRegion::frame(WIDTH as u32 - 10, HEIGHT as u32 - 10);
    SpectralImage {
        spectra: Spectra::Full,
        windows: ImageWindows {
            data: display.grown(5).unwrap(),
            display,
        },
        ..image()
    }
}

#[test]
fn tiles_and_overscan_come_back_where_they_were() {
    let whole = with_overscan();
    for region in [
        whole.windows.data,
        PixelRegion {
            x_px: -5,
            y_px: 3,
            width_px: 9,
            height_px: 33,
        },
        // A single block of rows that begins in the middle of another image's.
        PixelRegion {
            x_px: 30,
            y_px: 64,
            width_px: 1,
            height_px: 1,
        },
    ] {
        let image = cut(&whole, region);
        let bytes = spectral_bytes(&image);
        assert_eq!(read(&bytes).unwrap(), image);
        assert_eq!(spectral_bytes(&read(&bytes).unwrap()), bytes);
    }
}

#[test]
fn a_data_window_of_another_size_is_refused() {
    let mut image = image();
    image.windows.data.height_px += 1;
    let refusal = image.write_spectral(Cursor::new(Vec::new())).unwrap_err();
    assert!(matches!(refusal, Error::Shape { .. }), "{refusal}");
}

#[test]
fn a_preview_shows_the_frame_and_of_a_tile_what_is_there() {
    let size = |image: &SpectralImage| {
        let mut png = Vec::new();
        image.write_png(&mut png, 0.0).unwrap();
        let reader = png::Decoder::new(Cursor::new(png)).read_info().unwrap();
        (reader.info().width, reader.info().height)
    };
    let whole = with_overscan();
    assert_eq!(size(&whole), (35, 60));
    let shown = |region| size(&cut(&whole, region));
    assert_eq!(
        shown(PixelRegion {
            y_px: -5,
            height_px: 15,
            ..whole.windows.data
        }),
        (35, 10)
    );
    // All of it lies in the overscan.
    assert_eq!(
        shown(PixelRegion {
            y_px: -5,
            height_px: 3,
            ..whole.windows.data
        }),
        (45, 3)
    );
}

#[test]
fn a_tile_that_was_moved_does_not_fit_its_checksum() {
    let region = PixelRegion {
        x_px: 7,
        y_px: 3,
        width_px: 9,
        height_px: 33,
    };
    let bytes = spectral_bytes(&cut(&with_overscan(), region));
    let name = b"dataWindow\0box2i\0";
    let at = bytes
        .windows(name.len())
        .position(|part| part == name)
        .unwrap();
    let first = at + name.len() + 4;
    let mut moved = bytes.clone();
    // Both columns of the window of the first part, one to the right.
    for column in [first, first + 8] {
        moved[column] += 1;
    }
    assert!(matches!(read(&moved), Err(Error::Checksum { .. })));
}
