//! Where a picture comes from, by what [`write_png`](crate::write_png) and the EXR writers of this
//! crate noted in it.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use exr::prelude::MetaData;
use niji_exchange::Provenance;

use crate::error::Error;

/// The provenance of a PNG or EXR file, from its header alone; `None` where it carries none.
///
/// # Errors
/// A missing or damaged file.
pub fn read_picture_provenance(path: &Path) -> Result<Option<Provenance>, Error> {
    let damaged = |error: &dyn std::fmt::Display| Error::Damaged(error.to_string());
    let is_png = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    if is_png {
        let decoder = png::Decoder::new(BufReader::new(File::open(path)?));
        let reader = decoder.read_info().map_err(|error| damaged(&error))?;
        let items: Vec<(String, String)> = reader
            .info()
            .utf8_text
            .iter()
            .filter_map(|item| Some((item.keyword.clone(), item.get_text().ok()?)))
            .collect();
        let items = items.iter().map(|(name, text)| (&**name, &**text));
        return Ok(Provenance::from_text_items(items));
    }
    let header = MetaData::read_from_file(path, false).map_err(|error| damaged(&error))?;
    let Some(part) = header.headers.first() else {
        return Ok(None);
    };
    let comments = part.own_attributes.comments.as_ref();
    let text = comments.map(ToString::to_string).unwrap_or_default();
    let items = text.lines().filter_map(|line| line.split_once('='));
    Ok(Provenance::from_text_items(items))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear_picture::LinearPicture;
    use crate::picture_files::write_png;
    use crate::write_depth_map;
    use ndarray::Array2;

    #[test]
    fn pictures_tell_where_they_come_from() {
        let provenance = Provenance {
            tool: "niji depth".to_owned(),
            version: "0.1.0".to_owned(),
            settings: r#"{"a":"b=c"}"#.to_owned(),
            inputs: [("photo".to_owned(), "00ff".to_owned())].into(),
        };
        let folder = tempfile::tempdir().unwrap();
        let [exr, png] = ["depth.exr", "picture.png"].map(|name| folder.path().join(name));
        let depth_m = Array2::from_elem((2, 3), 4.0);
        write_depth_map(&depth_m, &provenance, File::create(&exr).unwrap()).unwrap();
        let picture = LinearPicture::from_elem((2, 3), [0.5; 3]);
        write_png(&picture, &provenance, File::create(&png).unwrap()).unwrap();
        for path in [exr, png] {
            assert_eq!(
                read_picture_provenance(&path).unwrap().as_ref(),
                Some(&provenance)
            );
        }
        assert!(read_picture_provenance(&folder.path().join("missing.png")).is_err());
    }
}
