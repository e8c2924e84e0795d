//! Plain images and layers for compositors, and spectra in half floats or left out.

use super::*;
use niji_exchange::PartContents;

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

/// What a file of its layers holds.
fn parts_of_layers(image: &SpectralImage) -> Vec<PartContents> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.layers.exr");
    let mut cursor = Cursor::new(Vec::new());
    image
        .write_layers(RgbPrimaries::Rec709, &mut cursor)
        .unwrap();
    fs::write(&path, cursor.into_inner()).unwrap();
    contents(&path).unwrap()
}

#[test]
fn light_where_nothing_covers_survives_in_the_plain_image() {
    let mut image = image();
    image.aovs.retain(|aov| aov.name != "transmittance");
    let parts = parts_of_layers(&image);
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
    let channels = &parts_of_layers(&image)[0].channels;
    assert_eq!((channels[0].min, channels[0].max), (0.75, 0.75));
    let deepest = image.aovs[2].channels[0]
        .1
        .iter()
        .copied()
        .fold(0.0, f32::max);
    assert_eq!(channels[4].max, deepest);
}

/// Colors with two lights that add up to them, one of them outside the gamut of displays at every pixel.
pub(super) fn image_of_two_lights() -> SpectralImage {
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
