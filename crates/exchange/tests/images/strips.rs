//! Files of pictures whose rows come some at a time.

use std::fs;
use std::io::Cursor;

use ndarray::Array2;
use ndarray::Array3;
use niji_exchange::Aov;
use niji_exchange::BeyondHalf;
use niji_exchange::Error;
use niji_exchange::Held;
use niji_exchange::ImageWindows;
use niji_exchange::PictureFile;
use niji_exchange::PictureHead;
use niji_exchange::Preview;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_exchange::StripReader;
use niji_exchange::StripWriter;
use niji_geometry::PixelRegion;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::WavelengthGrid;

use super::HEIGHT;
use super::WIDTH;
use super::image;
use super::layers::image_of_two_lights;

/// Its rows in pieces of these lengths, over and over.
fn pieces(image: &SpectralImage, lengths: &[usize]) -> Vec<SpectralImage> {
    let (mut top, mut pieces) = (0, Vec::new());
    for length in lengths.iter().cycle() {
        let height = image.radiance.dim().1;
        if top == height {
            break;
        }
        let bottom = height.min(top + length);
        pieces.push(image.rows(top..bottom));
        top = bottom;
    }
    pieces
}

fn head(file: PictureFile, image: &SpectralImage, floats: BeyondHalf) -> PictureHead {
    PictureHead {
        floats,
        ..PictureHead::new(file, image.windows.data, image.provenance.clone())
    }
}

fn written(
    file: PictureFile,
    (image, lengths): (&SpectralImage, &[usize]),
    floats: BeyondHalf,
) -> (Vec<u8>, BeyondHalf) {
    let mut bytes = Cursor::new(Vec::new());
    let mut rows = StripWriter::new(head(file, image, floats), &mut bytes);
    for piece in pieces(image, lengths) {
        rows.add(&piece).unwrap();
    }
    let beyond = rows.finish().unwrap();
    (bytes.into_inner(), beyond)
}

#[test]
fn the_bytes_are_the_same_whatever_number_of_rows_comes_at_a_time() {
    let layers = PictureFile::Layers(RgbPrimaries::Rec709);
    let half = image_of_two_lights().keeping(Spectra::Half);
    let cases = [
        (image(), PictureFile::Spectral),
        (image(), layers),
        (half.clone(), PictureFile::Spectral),
        (half, layers),
    ];
    for (image, file) in &cases {
        let mut whole = Cursor::new(Vec::new());
        image.write(*file, &mut whole).unwrap();
        for lengths in [&[1][..], &[7, 64], &[32], &[33, 2], &[HEIGHT]] {
            let (bytes, beyond) = written(*file, (image, lengths), BeyondHalf::default());
            assert!(beyond.is_empty(), "{lengths:?}");
            assert!(bytes == whole.get_ref()[..], "{file:?} {lengths:?}");
        }
    }
}

#[test]
fn what_half_cannot_hold_is_told_at_the_end_and_float_when_it_is_written_again() {
    let mut image = image_of_two_lights();
    image.white_luminance_cd_m2 = 1e-6;
    let file = PictureFile::Layers(RgbPrimaries::AcesCg);
    let (_, beyond) = written(file, (&image, &[13]), BeyondHalf::default());
    assert!(!beyond.is_empty());
    let (bytes, none) = written(file, (&image, &[13]), beyond);
    assert!(none.is_empty());
    let mut whole = Cursor::new(Vec::new());
    image.write(file, &mut whole).unwrap();
    assert!(bytes == whole.into_inner());
}

#[test]
fn a_preview_shows_the_frame_whichever_rows_come_with_overscan() {
    let mut image = image();
    let data = image.windows.data;
    let (width, height) = (WIDTH as u32 - 8, HEIGHT as u32 - 12);
    let frame = PixelRegion::frame(width, height);
    image.windows = ImageWindows {
        data: PixelRegion {
            x_px: -3,
            y_px: -5,
            ..data
        },
        display: frame,
    };
    let mut whole = Vec::new();
    image.write_png(&mut whole, 0.5).unwrap();
    let decoder = png::Decoder::new(Cursor::new(&whole));
    let info = decoder.read_info().unwrap().info().clone();
    assert_eq!((info.width, info.height), (width, height));
    for lengths in [&[1][..], &[4, 40]] {
        let mut preview = Preview::new(image.windows, 0.5, image.provenance.clone());
        for piece in pieces(&image, lengths) {
            preview.add(&piece).unwrap();
        }
        let mut bytes = Vec::new();
        preview.write(&mut bytes).unwrap();
        assert!(bytes == whole, "{lengths:?}");
    }
    // Its plain image is enough for it.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.layers.exr");
    let plain = fs::File::create(&path).unwrap();
    image.write_layers(RgbPrimaries::Rec709, plain).unwrap();
    let of_plain = Preview::of_plain_image(&path, 0.5, image.provenance.clone()).unwrap();
    let mut bytes = Vec::new();
    of_plain.write(&mut bytes).unwrap();
    assert!(bytes == whole);
}

#[test]
fn rows_that_are_missing_too_many_or_of_another_picture_are_refused() {
    let image = image();
    let of_pixels = |pixels| {
        let head = head(PictureFile::Spectral, &image, BeyondHalf::default());
        StripWriter::new(PictureHead { pixels, ..head }, Cursor::new(Vec::new()))
    };
    let begin = |pixels| {
        let mut rows = of_pixels(pixels);
        (rows.add(&image.rows(0..10)), rows)
    };
    let whole = image.windows.data;
    let (added, rows) = begin(whole);
    added.unwrap();
    assert!(matches!(
        rows.finish(),
        Err(Error::Shape {
            found: 10,
            expected: HEIGHT,
            ..
        })
    ));
    let (added, mut rows) = begin(whole);
    added.unwrap();
    assert!(matches!(rows.add(&image), Err(Error::Shape { .. })));
    let (added, _) = begin(PixelRegion {
        width_px: 44,
        ..whole
    });
    assert!(matches!(added, Err(Error::Shape { .. })));
    let (added, mut rows) = begin(whole);
    added.unwrap();
    let mut other = image.rows(10..20);
    other.aovs[0].channels.pop();
    assert!(matches!(rows.add(&other), Err(Error::Unwritable(_))));
    let none = of_pixels(whole);
    assert!(matches!(none.finish(), Err(Error::Shape { found: 0, .. })));
}

#[test]
fn a_file_is_read_strip_by_strip_or_its_light_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let small = image_of_two_lights();
    let cases = [
        (small.clone().keeping(Spectra::Half), 1),
        (small.keeping(Spectra::Left), 1),
        (tall_image(), 2),
    ];
    for (image, n_strips) in cases {
        let kept = image.spectra;
        let mut file = Cursor::new(Vec::new());
        image.write_spectral(&mut file).unwrap();
        fs::write(&path, file.get_ref()).unwrap();
        let whole = SpectralImage::read_picture(&path).unwrap();
        for (held, n_aovs) in [(Held::All, whole.aovs.len()), (Held::Light, 0)] {
            let (rows, none) = StripReader::open(&path, held).unwrap();
            assert_eq!(none.windows, whole.windows);
            assert_eq!(none.provenance, whole.provenance);
            let strips: Vec<SpectralImage> = rows.map(Result::unwrap).collect();
            let expected = if held == Held::All { n_strips } else { 1 };
            assert_eq!(strips.len(), expected, "{kept:?}");
            let mut top = 0;
            for strip in strips {
                let bottom = top + strip.radiance.dim().1;
                let mut expected = whole.rows(top..bottom);
                expected.aovs.truncate(n_aovs);
                assert!(strip == expected, "{kept:?}, {held:?}, {top}");
                top = bottom;
            }
            assert_eq!(top, whole.radiance.dim().1);
        }
    }
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 100]).unwrap();
    let (mut rows, _) = StripReader::open(&path, Held::All).unwrap();
    assert!(rows.any(|it| it.is_err()) && rows.next().is_none());
}

/// Three wavelengths and five layers, and a strip has fewer rows.
fn tall_image() -> SpectralImage {
    let (height, width) = (48, 32_000);
    let value = |l: usize, y: usize, x: usize| ((7 * l + 3 * y + x) % 1000) as f32;
    let plane = |l: usize| Array2::from_shape_fn((height, width), |(y, x)| value(l, y, x));
    let image = image();
    let aov = |l: usize| Aov {
        name: format!("light_{l}"),
        unit: "cd/m^2".to_owned(),
        channels: vec![("X", l), ("Y", l + 1), ("Z", l + 2)]
            .into_iter()
            .map(|(name, l)| (name.to_owned(), plane(l)))
            .collect(),
    };
    SpectralImage {
        wavelengths: WavelengthGrid::new(500.0, 50.0, 3).unwrap(),
        radiance: Array3::from_shape_fn((3, height, width), |(l, y, x)| value(l, y, x)),
        aovs: (1..6).map(aov).collect(),
        windows: ImageWindows::whole(width, height),
        ..image
    }
}
