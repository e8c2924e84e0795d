//! Photographs with the notes of a camera, for tests.

use niji_photo::LinearPicture;
use niji_photo::write_jpeg;

/// EXIF with an orientation and a focal length of 28 mm on film.
pub(crate) fn exif(orientation: u16) -> Vec<u8> {
    let mut block = b"Exif\0\0II\x2a\0\x08\0\0\0".to_vec();
    let entry = |tag: u16, kind: u16, value: u32| {
        let mut bytes = tag.to_le_bytes().to_vec();
        bytes.extend(kind.to_le_bytes());
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
        bytes
    };
    block.extend(2_u16.to_le_bytes());
    block.extend(entry(0x0112, 3, u32::from(orientation)));
    // The EXIF directory lies behind this one: 8 + 2 + 2 * 12 + 4 = 38.
    block.extend(entry(0x8769, 4, 38));
    block.extend(0_u32.to_le_bytes());
    block.extend(1_u16.to_le_bytes());
    block.extend(entry(0xa405, 3, 28));
    block.extend(0_u32.to_le_bytes());
    block
}

pub(crate) fn jpeg_with(segment: &[u8], picture: &LinearPicture) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_jpeg(picture, &mut bytes).expect("memory takes everything");
    let mut with = bytes[..2].to_vec();
    with.extend([0xff, 0xe1]);
    with.extend((segment.len() as u16 + 2).to_be_bytes());
    with.extend(segment);
    with.extend(&bytes[2..]);
    with
}
