//! Tiles and overscan: images of a part of the frame, or of more.

use super::*;

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
