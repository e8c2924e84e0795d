//! Plates of other programs: windows, primaries, alpha, depth, damage.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs::File;
use std::path::Path;

use exr::prelude::AnyChannel;
use exr::prelude::AnyChannels;
use exr::prelude::Compression;
use exr::prelude::Encoding;
use exr::prelude::FlatSamples;
use exr::prelude::Image;
use exr::prelude::IntegerBounds;
use exr::prelude::Layer;
use exr::prelude::LayerAttributes;
use exr::prelude::Vec2;
use exr::prelude::WritableImage;
use exr::prelude::attribute::Chromaticities;
use exr::prelude::f16;
use ndarray::Array2;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_geometry::PixelRegion;
use niji_photo::Error;
use niji_photo::Frame;
use niji_photo::Photograph;
use niji_photo::Plate;
use niji_photo::PremultipliedPicture;
use niji_photo::read_depth_map;
use niji_photo::read_depth_of_frame;
use niji_radiometry::RgbPrimaries;

const SIZE: [usize; 2] = [4, 3];

/// Writes a plate as another program might: channels of one value each, in a data window of its own.
fn write_plate(path: &Path, channels: &[(&str, f32)], white: Option<Vec2<f32>>) {
    let n_pixels = SIZE[0] * SIZE[1];
    let channels = channels.iter().map(|&(name, value)| {
        // Distances lose too much as halves.
        let samples = if name.ends_with('Z') {
            FlatSamples::F32(vec![value; n_pixels])
        } else {
            FlatSamples::F16(vec![f16::from_f32(value); n_pixels])
        };
        AnyChannel::new(name, samples)
    });
    let attributes = LayerAttributes {
        layer_position: Vec2(-1, 2),
        ..LayerAttributes::default()
    };
    let channels = AnyChannels::sort(channels.collect());
    let layer = Layer::new(
        Vec2(SIZE[0], SIZE[1]),
        attributes,
        Encoding::default(),
        channels,
    );
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds {
        position: Vec2(0, 0),
        size: Vec2(8, 6),
    };
    image.attributes.chromaticities = white.map(|white| Chromaticities {
        red: Vec2(0.713, 0.293),
        green: Vec2(0.165, 0.830),
        blue: Vec2(0.128, 0.044),
        white,
    });
    image.write().to_file(path).unwrap();
}

const RGB: [(&str, f32); 3] = [("R", 0.5), ("G", 2.0), ("B", 0.25)];
const ACES_WHITE: Vec2<f32> = Vec2(0.32168, 0.33767);

#[test]
fn windows_primaries_alpha_and_depth_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    let channels = [&RGB[..], &[("A", 0.75), ("Z", 12.5)]].concat();
    write_plate(&path, &channels, Some(ACES_WHITE));
    let plate = Plate::read(&path, None).unwrap();
    assert_eq!(plate.primaries, RgbPrimaries::AcesCg);
    let data = PixelRegion {
        x_px: -1,
        y_px: 2,
        width_px: 4,
        height_px: 3,
    };
    let display = PixelRegion::frame(8, 6);
    assert_eq!(plate.windows, ImageWindows { data, display });
    assert_eq!(plate.light, Array2::from_elem((3, 4), [0.5, 2.0, 0.25]));
    assert_eq!(plate.alpha, Some(Array2::from_elem((3, 4), 0.75)));
    assert_eq!(plate.surface_m, Some(Array2::from_elem((3, 4), 12.5)));
    let named = Plate::read(&path, Some(RgbPrimaries::Rec709)).unwrap();
    assert_eq!(
        (named.primaries, &named.light),
        (RgbPrimaries::Rec709, &plate.light)
    );
}

#[test]
fn a_depth_map_stands_on_the_pixels_of_its_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("depth.exr");
    write_plate(&path, &[("Z", 12.5)], None);
    assert_eq!(read_depth_map(&path).unwrap().dim(), (3, 4));
    // Its pixels lie from column -1 and row 2 on, in a frame of 8 x 6.
    let found = read_depth_of_frame(&path).unwrap();
    let expected = Array2::from_shape_fn((6, 8), |(y, x)| {
        let is_held = (2..5).contains(&y) && x < 3;
        if is_held { 12.5 } else { f32::INFINITY }
    });
    assert_eq!(found, expected);
}

#[test]
fn the_depth_is_told_from_normals_and_other_layers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    let normals = [("N.X", 0.6), ("N.Y", 0.0), ("N.Z", 0.8)];
    let read = |more: &[(&str, f32)]| {
        write_plate(&path, &[&RGB[..], &normals, more].concat(), None);
        Plate::read(&path, None).map(|plate| plate.surface_m.map(|depth| depth[[0, 0]]))
    };
    for depth in ["Z", "depth.Z", "ViewLayer.Depth.Z", "main.Z"] {
        assert_eq!(read(&[(depth, 82.0)]).unwrap(), Some(82.0), "{depth}");
    }
    // Blender's comes with one for its denoiser.
    let blender = [
        ("ViewLayer.Denoising Depth.Z", 7.0),
        ("ViewLayer.Depth.Z", 82.0),
    ];
    assert_eq!(read(&blender).unwrap(), Some(82.0));
    assert_eq!(read(&[]).unwrap(), None);
    let several = read(&[("A.Z", 1.0), ("B.Z", 2.0)]).unwrap_err();
    assert!(
        several.to_string().contains("[\"A.Z\", \"B.Z\"]"),
        "{several}"
    );
}

#[test]
fn a_plate_without_chromaticities_alpha_or_depth_is_rec709() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    write_plate(&path, &RGB, None);
    let plate = Plate::read(&path, None).unwrap();
    assert_eq!(plate.primaries, RgbPrimaries::Rec709);
    assert_eq!((plate.alpha, plate.surface_m), (None, None));
}

#[test]
fn a_photograph_of_acescg_becomes_rec709() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    write_plate(&path, &RGB, Some(ACES_WHITE));
    let photo = Photograph::read(&path).unwrap();
    let expected = RgbPrimaries::AcesCg.to_linear_rec709([0.5, 2.0, 0.25]);
    for (found, expected) in photo.light[[0, 0]].iter().zip(expected) {
        assert!((f64::from(*found) - expected).abs() < 1e-6);
    }
}

#[test]
fn what_is_written_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("element.exr");
    let data = PixelRegion {
        x_px: 3,
        y_px: -2,
        width_px: 5,
        height_px: 2,
    };
    let display = PixelRegion::frame(7, 4);
    let frame = Frame {
        primaries: RgbPrimaries::AcesCg,
        windows: ImageWindows { data, display },
    };
    let light = Array2::from_shape_fn((2, 5), |(y, x)| [x as f32, y as f32, 0.1]);
    let file = File::create(&path).unwrap();
    let picture = PremultipliedPicture {
        light: &light,
        alpha: None,
        frame,
    };
    picture.write_exr(&Provenance::default(), file).unwrap();
    let plate = Plate::read(&path, None).unwrap();
    assert_eq!(
        (plate.primaries, plate.windows),
        (frame.primaries, frame.windows)
    );
    assert_eq!((plate.light, plate.alpha), (light, None));
}

#[test]
fn plates_that_are_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    let refused = |channels: &[(&str, f32)], white| {
        write_plate(&path, channels, white);
        Plate::read(&path, None).unwrap_err()
    };
    assert!(matches!(
        refused(&RGB[..2], None),
        Error::MissingChannel("R" | "G" | "B")
    ));
    for value in [f32::NAN, f32::INFINITY] {
        let bright = [("R", value), ("G", 1.0), ("B", 1.0)];
        let error = refused(&bright, None);
        assert!(matches!(
            error,
            Error::NotFinite {
                channel: "R",
                x: 0,
                y: 0,
                ..
            }
        ));
        let alpha = [&RGB[..], &[("A", value)]].concat();
        assert!(matches!(
            refused(&alpha, None),
            Error::NotFinite { channel: "A", .. }
        ));
    }
    let behind = [&RGB[..], &[("Z", -1.0)]].concat();
    assert!(matches!(refused(&behind, None), Error::Depth { .. }));
    // AP1 with an equal-energy white is no ACEScg.
    assert!(matches!(
        refused(&RGB, Some(Vec2(0.3333, 0.3333))),
        Error::Primaries(_)
    ));
}

/// Noise as halves of all sizes and signs.
fn noise(n_values: u32) -> Vec<f16> {
    let bits = (0..n_values).map(|index| (index.wrapping_mul(2_654_435_761) >> 16) as u16);
    // Infinity and NaN have all bits of the exponent.
    bits.map(|bits| f16::from_bits(bits & 0xbbff)).collect()
}

/// The place of a half among all of them, from the most negative.
fn rank(half: f16) -> i32 {
    let bits = i32::from(half.to_bits());
    if bits < 0x8000 { bits } else { 0x7fff - bits }
}

fn write_noise(path: &Path, compression: Compression) {
    let plane = || FlatSamples::F16(noise(64 * 48));
    let channels = ["R", "G", "B"].map(|name| AnyChannel::new(name, plane()));
    let encoding = Encoding {
        compression,
        ..Encoding::default()
    };
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let layer = Layer::new(Vec2(64, 48), LayerAttributes::default(), encoding, channels);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

const CODECS: [Compression; 8] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
];

#[test]
fn plates_of_every_codec_are_read_and_b44_counts_on_numbers_that_wrap() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    let written = noise(64 * 48);
    for codec in CODECS {
        write_noise(&path, codec);
        let light = Plate::read(&path, None).unwrap().light;
        let is_lossy = matches!(codec, Compression::B44 | Compression::B44A);
        // A block of B44 has six bits for differences of up to 2^16.
        let most = if is_lossy { 1 << 10 } else { 0 };
        for (found, written) in light.iter().zip(&written) {
            let rank_error = rank(f16::from_f32(found[0])).abs_diff(rank(*written));
            assert!(rank_error <= most, "{codec}: {} for {written}", found[0]);
        }
    }
}

#[test]
fn damage_in_any_codec_is_an_error_or_a_picture_and_never_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    for codec in CODECS {
        write_noise(&path, codec);
        let sound = std::fs::read(&path).unwrap();
        for step in 0..50_usize {
            let mut bytes = sound.clone();
            for turn in 1..=4 {
                let place = (step * 7919 * turn) % bytes.len();
                bytes[place] ^= (step * turn) as u8 | 1;
            }
            bytes.truncate(bytes.len() - step % 3);
            std::fs::write(&path, bytes).unwrap();
            // What it is depends on where the damage fell.
            let _ = Plate::read(&path, None);
            let _ = niji_exchange::contents(&path);
        }
    }
}

#[test]
fn a_window_of_more_pixels_than_the_bytes_can_hold_is_refused_before_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.exr");
    write_plate(&path, &RGB, None);
    let mut bytes = std::fs::read(&path).unwrap();
    let name = b"dataWindow\0box2i\0\x10\0\0\0";
    let mut windows = bytes.windows(name.len());
    // Behind the lower corner: the right end.
    let place = windows.position(|window| window == name).unwrap() + name.len() + 8;
    bytes[place..place + 4].copy_from_slice(&1_000_000_i32.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    assert!(matches!(
        Plate::read(&path, None),
        Err(Error::TooLarge { .. })
    ));
}
