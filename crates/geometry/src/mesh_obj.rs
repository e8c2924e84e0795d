//! Triangles from Wavefront OBJ files.
//!
//! All objects of the file together, polygons as fans, corners counted from 1 or backwards from −1. Of
//! the lines only `v` (corner), `vn` (normal; counted where none are asked for), `vt` (counted, because faces name
//! them) and `f` (face) count.

use std::io::BufRead;

use glam::DVec3;
use glam::Vec3;

use crate::mesh_files::MeshDetail;
use crate::mesh_files::Soup;

/// Reads the triangles of a file.
pub(crate) fn read_obj(source: impl BufRead, detail: MeshDetail) -> Result<Soup, String> {
    let mut reading = Reading {
        detail,
        soup: Soup::default(),
        n_named: [0; 3],
        normals: Vec::new(),
    };
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
        let read = reading.add_statement(&statement);
        read.map_err(|message| format!("line {}: {message}", index + 1))?;
        statement.clear();
    }
    Ok(reading.soup)
}

/// What was read so far.
struct Reading {
    detail: MeshDetail,
    soup: Soup,
    /// How many corners, texture coordinates and normals there are: what a face may name.
    n_named: [usize; 3],
    normals: Vec<Vec3>,
}

/// What a face says of a corner: numbers from 0.
#[derive(Clone, Copy)]
struct FaceCorner {
    at: u32,
    normal: Option<usize>,
}

impl Reading {
    fn add_statement(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                self.soup.corners.push(numbers(words, "a corner")?);
                self.n_named[0] += 1;
            }
            Some("vt") => self.n_named[1] += 1,
            Some("vn") => {
                if self.detail >= MeshDetail::Normals {
                    self.normals.push(numbers(words, "a normal")?.as_vec3());
                }
                self.n_named[2] += 1;
            }
            Some("f") => {
                let corners = words.map(|word| self.face_corner(word));
                let corners = corners.collect::<Result<Vec<_>, _>>()?;
                self.add_face(&corners)?;
            }
            _ => (),
        }
        Ok(())
    }

    fn add_face(&mut self, corners: &[FaceCorner]) -> Result<(), String> {
        let [first, rest @ ..] = corners else {
            return Err("found a face without corners".to_owned());
        };
        if rest.len() < 2 {
            let found = corners.len();
            return Err(format!(
                "found a face of {found} corners, expected at least 3"
            ));
        }
        for pair in rest.windows(2) {
            let triangle = [*first, pair[0], pair[1]];
            if !self.normals.is_empty() {
                let normal = |corner: FaceCorner| {
                    corner
                        .normal
                        .map_or(Vec3::ZERO, |index| self.normals[index])
                };
                self.soup.add_normals(triangle.map(normal));
            }
            self.soup.triangles.push(triangle.map(|corner| corner.at));
        }
        Ok(())
    }

    /// What a word like `5`, `5/2`, `5//3`, `5/2/3` or `-1` names.
    fn face_corner(&self, word: &str) -> Result<FaceCorner, String> {
        let mut parts = word.split('/');
        let at = named(parts.next().unwrap_or_default(), self.n_named[0])?;
        let mut further = [None; 2];
        for ((part, n), index) in parts.zip(&self.n_named[1..]).zip(&mut further) {
            if !part.is_empty() {
                *index = Some(named(part, *n)?);
            }
        }
        let at = u32::try_from(at).map_err(|_| format!("found more than {} corners", u32::MAX))?;
        // Those that are not asked for are only counted.
        let normal = further[1].filter(|_| self.detail >= MeshDetail::Normals);
        Ok(FaceCorner { at, normal })
    }
}

fn numbers<'a>(mut words: impl Iterator<Item = &'a str>, what: &str) -> Result<DVec3, String> {
    let mut number = || {
        let word = words.next().unwrap_or_default();
        let expected = |_| format!("found {word:?} in {what}, expected three numbers");
        word.parse::<f64>().map_err(expected)
    };
    Ok(DVec3::new(number()?, number()?, number()?))
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
