//! Triangles from Wavefront OBJ files.
//!
//! All objects of the file together, polygons as fans, corners counted from 1 or backwards from −1. Of
//! the lines only `v` (corner), `vt`, `vn` (counted, because faces name them) and `f` (face) count.

use std::io::BufRead;

use glam::DVec3;

use crate::mesh_files::Soup;

/// Reads the triangles of a file.
pub(crate) fn read_obj(source: impl BufRead) -> Result<Soup, String> {
    let mut soup = Soup::default();
    // Corners, texture coordinates and normals so far: what a face may name.
    let mut n_named = [0_usize; 3];
    let mut statement = String::new();
    for (index, line) in source.split(b'\n').enumerate() {
        let line = line.map_err(|error| error.to_string())?;
        let line = String::from_utf8_lossy(&line);
        let line = line.split('#').next().unwrap_or_default().trim();
        // A line that ends so goes on in the next one.
        if let Some(part) = line.strip_suffix('\\') {
            statement += part;
            statement.push(' ');
            continue;
        }
        statement += line;
        let read = add_statement(&statement, &mut soup, &mut n_named);
        read.map_err(|message| format!("line {}: {message}", index + 1))?;
        statement.clear();
    }
    Ok(soup)
}

fn add_statement(line: &str, soup: &mut Soup, n_named: &mut [usize; 3]) -> Result<(), String> {
    let mut words = line.split_whitespace();
    match words.next() {
        Some("v") => {
            soup.corners.push(corner(words)?);
            n_named[0] += 1;
        }
        Some("vt") => n_named[1] += 1,
        Some("vn") => n_named[2] += 1,
        Some("f") => {
            let corners = words.map(|word| face_corner(word, n_named));
            let corners = corners.collect::<Result<Vec<u32>, _>>()?;
            let [first, rest @ ..] = &corners[..] else {
                return Err("found a face without corners".to_owned());
            };
            if rest.len() < 2 {
                let found = corners.len();
                return Err(format!(
                    "found a face of {found} corners, expected at least 3"
                ));
            }
            let fan = rest.windows(2).map(|pair| [*first, pair[0], pair[1]]);
            soup.triangles.extend(fan);
        }
        _ => (),
    }
    Ok(())
}

fn corner<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    let mut number = || {
        let word = words.next().unwrap_or_default();
        let expected = |_| format!("found {word:?} in a corner, expected three numbers");
        word.parse::<f64>().map_err(expected)
    };
    Ok(DVec3::new(number()?, number()?, number()?))
}

/// The number of the corner from 0 in a word like `5`, `5/2`, `5//3`, `5/2/3` or `-1`.
fn face_corner(word: &str, n_named: &[usize; 3]) -> Result<u32, String> {
    let mut parts = word.split('/');
    let corner = named(parts.next().unwrap_or_default(), n_named[0])?;
    for (part, n) in parts.zip(&n_named[1..]) {
        if !part.is_empty() {
            named(part, *n)?;
        }
    }
    u32::try_from(corner).map_err(|_| format!("found more than {} corners", u32::MAX))
}

/// The index from 0 that a text means among `n` things.
fn named(text: &str, n: usize) -> Result<usize, String> {
    let index = match text.parse::<i64>() {
        Ok(number) if number < 0 => n.checked_sub(number.unsigned_abs() as usize),
        Ok(number) => (number as usize).checked_sub(1).filter(|index| *index < n),
        Err(_) => None,
    };
    index.ok_or_else(|| format!("found index {text:?} in a face, expected 1 to {n} or -{n} to -1"))
}
