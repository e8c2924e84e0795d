//! Files of pictures whose rows come some at a time.

use std::io::Cursor;

use niji_exchange::BeyondHalf;
use niji_exchange::Error;
use niji_exchange::ImageWindows;
use niji_exchange::PictureFile;
use niji_exchange::Preview;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_exchange::StripWriter;
use niji_geometry::PixelRegion;
use niji_radiometry::RgbPrimaries;

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

fn written(
    file: PictureFile,
    (image, lengths): (&SpectralImage, &[usize]),
    floats: BeyondHalf,
) -> (Vec<u8>, BeyondHalf) {
    let mut bytes = Cursor::new(Vec::new());
    let mut rows = StripWriter::new(file, (image.windows.data, floats), &mut bytes);
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
        let mut preview = Preview::new(image.windows, 0.5);
        for piece in pieces(&image, lengths) {
            preview.add(&piece).unwrap();
        }
        let mut bytes = Vec::new();
        preview.write(&mut bytes).unwrap();
        assert!(bytes == whole, "{lengths:?}");
    }
}

#[test]
fn rows_that_are_missing_too_many_or_of_another_width_are_refused() {
    let image = image();
    let begin = |whole| {
        let mut rows = StripWriter::new(
            PictureFile::Spectral,
            (whole, BeyondHalf::default()),
            Cursor::new(Vec::new()),
        );
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
    let none = StripWriter::new(
        PictureFile::Spectral,
        (whole, BeyondHalf::default()),
        Cursor::new(Vec::new()),
    );
    assert!(matches!(none.finish(), Err(Error::Shape { found: 0, .. })));
}
