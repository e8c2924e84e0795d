//! Photographs as they come: depths, orientations, damage, size.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::fs::File;
use std::path::Path;
use std::path::PathBuf;

use common::exif;
use common::jpeg_with;
use ndarray::Array2;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_photo::AddedLight;
use niji_photo::Encoding;
use niji_photo::Frame;
use niji_photo::LinearPicture;
use niji_photo::Photograph;
use niji_photo::PremultipliedPicture;
use niji_photo::composite;
use niji_photo::write_png;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::srgb_decode;

fn pavilion() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/photos/pavilion.jpg")
}

/// A picture whose corners differ: red top left, green top right, blue bottom left.
fn corners() -> LinearPicture {
    let mut picture = Array2::from_elem((16, 24), [0.0; 3]);
    for ((y, x), pixel) in picture.indexed_iter_mut() {
        let channel = match (y < 8, x < 12) {
            (true, true) => 0,
            (true, false) => 1,
            (false, true) => 2,
            (false, false) => continue,
        };
        pixel[channel] = 1.0;
    }
    picture
}

/// The whole of a picture as Rec.709.
fn frame(picture: &LinearPicture) -> Frame {
    let (height, width) = picture.dim();
    Frame {
        primaries: RgbPrimaries::Rec709,
        windows: ImageWindows::whole(width, height),
    }
}

#[test]
fn the_shipped_photograph_is_read() {
    let photo = Photograph::read(&pavilion()).unwrap();
    assert_eq!((photo.width(), photo.height()), (640, 427));
    assert_eq!(photo.encoding, Encoding::Srgb8);
    assert_eq!(photo.notes.focal_length_35mm, None);
    // The sky at the top is brighter than the trees at the bottom.
    assert!(photo.light[[5, 5]][2] > 4.0 * photo.light[[420, 20]][2]);
}

#[test]
fn orientation_is_respected_and_notes_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turned.jpg");
    // Where the red corner goes: orientation 6 says that the stored right side is the scene's bottom.
    for (orientation, size, red) in [
        (1, (24, 16), [2, 2]),
        (3, (24, 16), [13, 21]),
        (6, (16, 24), [2, 13]),
        (8, (16, 24), [21, 2]),
    ] {
        fs::write(&path, jpeg_with(&exif(orientation), &corners())).unwrap();
        let photo = Photograph::read(&path).unwrap();
        assert_eq!((photo.width(), photo.height()), size, "{orientation}");
        assert_eq!(Photograph::size_in(&path).unwrap(), [size.0, size.1]);
        let [r, g, b] = photo.light[red];
        assert!(r > 0.8 && g < 0.1 && b < 0.1, "{orientation}: {r} {g} {b}");
        assert_eq!(photo.notes.focal_length_35mm, Some(28.0));
    }
}

#[test]
fn png_of_8_and_16_bit_becomes_linear_light() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.png");
    let mut encoder = png::Encoder::new(File::create(&path).unwrap(), 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Sixteen);
    let mut writer = encoder.write_header().unwrap();
    let codes: [u16; 8] = [0, 32768, 65535, 65535, 100, 200, 300, 0];
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_be_bytes()).collect();
    writer.write_image_data(&bytes).unwrap();
    writer.finish().unwrap();
    let photo = Photograph::read(&path).unwrap();
    assert_eq!(photo.encoding, Encoding::Srgb16);
    let expected = |code: u16| srgb_decode(f64::from(code) / 65535.0);
    for (pixel, codes) in photo.light.iter().zip([[0, 32768, 65535], [100, 200, 300]]) {
        for (value, code) in pixel.iter().zip(codes) {
            assert!((f64::from(*value) - expected(code)).abs() < 1e-7);
        }
    }
}

#[test]
fn every_code_value_survives_a_composite_without_a_bow() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ramp.png");
    let ramp = Array2::from_shape_fn((16, 16), |(y, x)| {
        [srgb_decode((16 * y + x) as f64 / 255.0) as f32; 3]
    });
    write_png(&ramp, &Provenance::default(), File::create(&path).unwrap()).unwrap();
    let photo = Photograph::read(&path).unwrap();
    let nothing = AddedLight {
        light: Array2::from_elem((16, 16), [0.0; 3]),
        transmittance: Array2::ones((16, 16)),
    };
    let out = composite(&photo.light, &nothing).unwrap();
    for ((y, x), pixel) in out.indexed_iter() {
        assert_eq!(*pixel, [ramp[[y, x]][0]; 3]);
    }
    let again = folder.path().join("again.png");
    write_png(&out, &Provenance::default(), File::create(&again).unwrap()).unwrap();
    assert_eq!(fs::read(&path).unwrap(), fs::read(&again).unwrap());
}

#[test]
fn a_plate_keeps_values_above_one_and_light_where_alpha_is_zero() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    let light = Array2::from_shape_fn((3, 5), |(y, x)| [x as f32 * 3.5, y as f32, 1e-4]);
    let alpha = Array2::zeros((3, 5));
    let provenance = Provenance {
        tool: "niji composite".to_owned(),
        ..Provenance::default()
    };
    let write = |path: &Path| {
        let file = File::create(path).unwrap();
        let picture = PremultipliedPicture {
            light: &light,
            alpha: Some(&alpha),
            frame: frame(&light),
        };
        picture.write_exr(&provenance, file).unwrap();
        fs::read(path).unwrap()
    };
    let bytes = write(&path);
    assert_eq!(write(&folder.path().join("again.exr")), bytes, "same bytes");
    let plate = Photograph::read(&path).unwrap();
    assert_eq!(plate.encoding, Encoding::Linear);
    assert_eq!(plate.light, light);
}

/// A PNG of three pixels of 8 bit whose header says more.
fn png_of(say: impl FnOnce(&mut png::Info<'static>)) -> Vec<u8> {
    let mut info = png::Info::with_size(3, 1);
    info.color_type = png::ColorType::Rgb;
    info.bit_depth = png::BitDepth::Eight;
    say(&mut info);
    let mut bytes = Vec::new();
    let encoder = png::Encoder::with_info(&mut bytes, info).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer
        .write_image_data(&[255, 255, 255, 128, 128, 128, 0, 128, 0])
        .unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn a_photograph_is_read_by_its_profile_or_its_exponent() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("photo.png");
    let read = |bytes: Vec<u8>| {
        fs::write(&path, bytes).unwrap();
        Photograph::read(&path).unwrap()
    };
    let plain = read(png_of(|_| ()));
    assert!(plain.profile.is_none());
    let with = |profile: moxcms::ColorProfile| {
        let bytes = profile.encode().unwrap();
        read(png_of(|info| info.icc_profile = Some(bytes.into())))
    };
    let srgb = with(moxcms::ColorProfile::new_srgb());
    assert_eq!(srgb.light, plain.light);
    let adobe = with(moxcms::ColorProfile::new_adobe_rgb());
    assert!(adobe.profile.is_some_and(|it| it.is_used));
    // Its green is outside of Rec.709 (Adobe RGB (1998): Y of green 0.62736), its grey follows the exponent 563/256.
    let grey = (128.0_f64 / 255.0).powf(563.0 / 256.0);
    for (at, expected) in [(0, 1.0), (1, grey)] {
        for channel in adobe.light[[0, at]] {
            assert!(
                (f64::from(channel) - expected).abs() < 2e-3,
                "{at} {channel}"
            );
        }
    }
    let [red, green, blue] = adobe.light[[0, 2]].map(f64::from);
    assert!(red >= 0.0 && blue >= 0.0);
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    assert!((luminance - 0.62736 * grey).abs() < 2e-3, "{luminance}");
    let linear = read(png_of(|info| {
        info.source_gamma = Some(png::ScaledFloat::new(1.0));
    }));
    assert!((linear.light[[0, 1]][0] - 128.0 / 255.0).abs() < 1e-6);
    let damaged = read(png_of(|info| info.icc_profile = Some(b"nothing".into())));
    assert_eq!(damaged.light, plain.light);
    assert!(damaged.profile.is_some_and(|it| !it.is_used));
}
