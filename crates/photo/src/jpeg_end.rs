//! Is a JPEG file whole?
//!
//! Decoders fill what is missing with grey, so a truncated photograph would pass unseen. A whole one
//! has the marker EOI (FF D9) after the marker SOS (FF DA) of its scan; in a scan every FF byte of
//! the data is followed by 00, so that FF D9 can be nothing else. Segments before the scan, which
//! may hold a thumbnail with markers of its own, are skipped by their length.
//! [T.81] ITU-T Recommendation T.81, annex B (1992).

use std::io::BufRead;
use std::io::ErrorKind;
use std::io::Read;

/// First byte of every marker.
const MARKER: u8 = 0xff;
/// Start of image.
const SOI: u8 = 0xd8;
/// End of image.
const EOI: u8 = 0xd9;
/// Start of scan.
const SOS: u8 = 0xda;

/// Does an end of the image follow the first scan?
///
/// # Errors
/// A reader that fails; the end of the file is no error.
pub(crate) fn has_end_of_image(source: impl BufRead) -> std::io::Result<bool> {
    match search(source) {
        Ok(found) => Ok(found),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}

fn search(mut source: impl BufRead) -> std::io::Result<bool> {
    if byte(&mut source)? != MARKER || byte(&mut source)? != SOI {
        return Ok(false);
    }
    loop {
        while byte(&mut source)? != MARKER {}
        let mut code = MARKER;
        while code == MARKER {
            code = byte(&mut source)?;
        }
        let length = usize::from(byte(&mut source)?) << 8 | usize::from(byte(&mut source)?);
        let mut segment = (&mut source).take(length.saturating_sub(2) as u64);
        std::io::copy(&mut segment, &mut std::io::sink())?;
        if code == SOS {
            break;
        }
    }
    let mut last = 0;
    for next in source.bytes() {
        let next = next?;
        if last == MARKER && next == EOI {
            return Ok(true);
        }
        last = next;
    }
    Ok(false)
}

fn byte(source: &mut impl Read) -> std::io::Result<u8> {
    let mut byte = [0];
    source.read_exact(&mut byte)?;
    Ok(byte[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_inside_a_thumbnail_does_not_count() {
        let thumbnail = [0xff, 0xe1, 0, 6, 0xff, 0xda, 0xff, 0xd9];
        let scan = [0xff, 0xda, 0, 2, 1, 2, 0xff, 0, 3];
        let mut bytes = vec![0xff, 0xd8];
        bytes.extend(thumbnail);
        bytes.extend(scan);
        assert!(!has_end_of_image(bytes.as_slice()).unwrap());
        bytes.extend([0xff, 0xd9, 7, 7]);
        assert!(has_end_of_image(bytes.as_slice()).unwrap());
        for n_bytes in 0..bytes.len() - 2 {
            assert!(!has_end_of_image(&bytes[..n_bytes]).unwrap());
        }
    }
}
