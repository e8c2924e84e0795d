//! Triangles from Wavefront OBJ files.
//!
//! All objects of the file together, polygons as fans, corners counted from 1 or backwards from −1. Of
//! the lines only `v` (corner), `f` (face), `vn` (normal), `vt` (texture coordinates), `mtllib` and `usemtl` (materials,
//! white where there is none) count. What nobody asks for of the last four is counted, because faces name it.

use std::collections::BTreeSet;
use std::collections::HashMap;
use std::io::BufRead;
use std::path::Path;
use std::path::PathBuf;

use glam::DVec2;
use glam::DVec3;
use glam::Vec2;
use glam::Vec3;

use crate::mesh_files::MeshDetail;
use crate::mesh_files::Soup;
use crate::mesh_materials::MeshMaterial;
use crate::mesh_materials::MeshTexture;
use crate::mesh_materials::TextureContent;
use crate::mesh_materials::TextureWrap;
use crate::mesh_materials::beside;
use crate::mesh_materials::check_count;
use crate::mesh_mtl::Mtl;
use crate::mesh_mtl::read_mtl;
use crate::polygon::triangles_of_polygon;

/// Reads the triangles of a file.
pub(crate) fn read_obj(
    source: impl BufRead,
    path: &Path,
    detail: MeshDetail,
) -> Result<Soup, String> {
    let mut reading = Reading {
        detail,
        ..Reading::default()
    };
    each_statement(source, |statement| reading.add_statement(statement))?;
    if detail == MeshDetail::Materials {
        reading.add_materials(path)?;
    }
    Ok(reading.soup)
}

/// The files of materials beside a file of this name that are there, and those of their textures.
pub(crate) fn files_beside(source: impl BufRead, path: &Path) -> Result<Vec<PathBuf>, String> {
    let mut libraries = Vec::new();
    each_statement(source, |statement| {
        if let Some(("mtllib", names)) = statement.split_once(char::is_whitespace) {
            check_count(libraries.len())?;
            libraries.push(names.trim().to_owned());
        }
        Ok(())
    })?;
    // They count only where a mesh has its own materials, and are refused there.
    let mut files = Vec::new();
    let mut materials = HashMap::new();
    for file in libraries
        .iter()
        .flat_map(|names| library_files(path, names).unwrap_or_default())
    {
        let _ = read_mtl(&file, &mut materials);
        files.push(file);
    }
    let textures = materials.into_values().filter_map(|it| it.texture);
    let textures: BTreeSet<_> = textures
        .filter_map(|name| beside(path, &name).ok())
        .collect();
    files.extend(textures);
    Ok(files)
}

/// The files that a line names, which are separated by spaces or have some in their one name.
fn library_files(path: &Path, names: &str) -> Result<Vec<PathBuf>, String> {
    if let Ok(file) = beside(path, names) {
        return Ok(vec![file]);
    }
    names
        .split_whitespace()
        .map(|name| beside(path, name))
        .collect()
}

/// Calls with each statement of a file; errors tell the line.
fn each_statement(
    source: impl BufRead,
    mut add: impl FnMut(&str) -> Result<(), String>,
) -> Result<(), String> {
    let mut statement = String::new();
    for (index, line) in source.split(b'\n').enumerate() {
        let line = line.map_err(|error| error.to_string())?;
        let line = String::from_utf8_lossy(&line);
        let line = said(&line);
        // A line that ends so goes on in the next one.
        if let Some(part) = line.strip_suffix('\\') {
            statement += part;
            statement.push(' ');
            continue;
        }
        statement += line;
        let read = add(&statement);
        read.map_err(|message| format!("line {}: {message}", index + 1))?;
        statement.clear();
    }
    Ok(())
}

/// What a line says, without the mark of its encoding with which some programs begin a text, and without its comment.
pub(crate) fn said(line: &str) -> &str {
    without_comment(line.trim_start_matches('\u{feff}')).trim()
}

/// A line up to a comment, which stands alone or behind a blank: names have `#` inside.
fn without_comment(line: &str) -> &str {
    let begins = |(at, _): &(usize, &str)| {
        line[..*at]
            .chars()
            .next_back()
            .is_none_or(char::is_whitespace)
    };
    let comment = line.match_indices('#').find(begins);
    comment.map_or(line, |(at, _)| &line[..at])
}

/// What was read so far.
#[derive(Default)]
struct Reading {
    detail: MeshDetail,
    soup: Soup,
    /// How many corners, texture coordinates and normals there are: what a face may name.
    n_named: [usize; 3],
    normals: Vec<Vec3>,
    uv: Vec<Vec2>,
    libraries: Vec<String>,
    /// Names of materials by their numbers from 1; and that of the faces that come, 0 for none.
    names: Vec<String>,
    numbers: HashMap<String, u32>,
    material: u32,
    /// Materials of faces without texture coordinates.
    bare: BTreeSet<u32>,
}

/// What a face says of a corner: numbers from 0.
#[derive(Clone, Copy)]
struct FaceCorner {
    at: u32,
    uv: Option<usize>,
    normal: Option<usize>,
}

impl Reading {
    fn add_statement(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let [x, y, z] = numbers(words, "a corner")?;
                self.soup.corners.push(DVec3::new(x, y, z));
                self.n_named[0] += 1;
            }
            Some("vt") => {
                if self.detail == MeshDetail::Materials {
                    // v goes up, and may be left out.
                    let [u, v] = numbers(words.chain(["0"]), "texture coordinates")?;
                    self.uv.push(DVec2::new(u, 1.0 - v).as_vec2());
                }
                self.n_named[1] += 1;
            }
            Some("vn") => {
                if self.detail >= MeshDetail::Normals {
                    let normal = DVec3::from(numbers(words, "a normal")?);
                    self.normals.push(normal.as_vec3());
                }
                self.n_named[2] += 1;
            }
            Some(word @ ("mtllib" | "usemtl")) if self.detail == MeshDetail::Materials => {
                let name = line.trim_start_matches(word).trim();
                if word == "mtllib" {
                    check_count(self.libraries.len())?;
                    self.libraries.push(name.to_owned());
                } else {
                    check_count(self.names.len())?;
                    self.use_material(name);
                }
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
        if corners.len() < 3 {
            let found = corners.len();
            return Err(format!(
                "found a face of {found} corners, expected at least 3"
            ));
        }
        let places: Vec<DVec3> = corners
            .iter()
            .map(|corner| self.soup.corners[corner.at as usize])
            .collect();
        for numbers in triangles_of_polygon(&places) {
            let triangle = numbers.map(|number| corners[number as usize]);
            if !self.normals.is_empty() {
                let normal = |corner: FaceCorner| match corner.normal {
                    Some(index) => self.normals[index],
                    None => Vec3::ZERO,
                };
                // Triangles before them have none.
                let normals = &mut self.soup.attributes.normals;
                normals.resize(self.soup.triangles.len(), [Vec3::ZERO; 3]);
                normals.push(triangle.map(normal));
            }
            if self.detail == MeshDetail::Materials {
                self.add_paint(triangle);
            }
            self.soup.triangles.push(triangle.map(|corner| corner.at));
        }
        Ok(())
    }

    /// Takes a material for the faces that come.
    fn use_material(&mut self, name: &str) {
        let next = self.names.len() as u32 + 1;
        self.material = *self.numbers.entry(name.to_owned()).or_insert(next);
        if self.material == next {
            self.names.push(name.to_owned());
        }
    }

    /// Adds what is known of the triangle that is added next, as far as it is.
    fn add_paint(&mut self, triangle: [FaceCorner; 3]) {
        let n_before = self.soup.triangles.len();
        let attributes = &mut self.soup.attributes;
        if self.material > 0 {
            attributes.materials.resize(n_before, 0);
            attributes.materials.push(self.material);
        }
        if triangle.iter().any(|corner| corner.uv.is_none()) {
            self.bare.insert(self.material);
        } else {
            attributes.uv.resize(n_before, [Vec2::ZERO; 3]);
            let uv = triangle.map(|corner| corner.uv.map_or(Vec2::ZERO, |index| self.uv[index]));
            attributes.uv.push(uv);
        }
    }

    /// Finds the materials that faces name, and the files of their textures.
    fn add_materials(&mut self, path: &Path) -> Result<(), String> {
        let mut known = HashMap::new();
        for names in &self.libraries {
            for file in library_files(path, names)? {
                read_mtl(&file, &mut known)?;
            }
        }
        let soup = &mut self.soup;
        soup.materials.push(MeshMaterial::WHITE);
        let mut textures = HashMap::new();
        for (name, number) in self.names.iter().zip(1..) {
            let Mtl { factor, texture } = known
                .get(name)
                .ok_or_else(|| format!("found no material {name:?} in {:?}", self.libraries))?;
            if texture.is_some() && self.bare.contains(&number) {
                return Err(format!(
                    "found faces without texture coordinates of the material {name:?}, which has a map_Kd"
                ));
            }
            let texture = texture.as_ref().map(|texture| {
                if let Some(known) = textures.get(texture) {
                    return Ok(*known);
                }
                textures.insert(texture.clone(), soup.textures.len());
                soup.textures.push(MeshTexture {
                    name: format!("{texture:?}"),
                    content: TextureContent::File(beside(path, texture)?),
                    wraps: [TextureWrap::Repeat; 2],
                });
                Ok::<_, String>(soup.textures.len() - 1)
            });
            let texture = texture
                .transpose()
                .map_err(|error| format!("material {name:?}: {error}"))?;
            soup.materials.push(MeshMaterial {
                factor: *factor,
                texture,
            });
        }
        if soup.textures.is_empty() {
            soup.attributes.uv = Vec::new();
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
        let uv = further[0].filter(|_| self.detail == MeshDetail::Materials);
        let normal = further[1].filter(|_| self.detail >= MeshDetail::Normals);
        Ok(FaceCorner { at, uv, normal })
    }
}

fn numbers<'a, const N: usize>(
    mut words: impl Iterator<Item = &'a str>,
    what: &str,
) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        let word = words.next().unwrap_or_default();
        let expected = |_| format!("found {word:?} in {what}, expected {N} numbers");
        *number = word.parse::<f64>().map_err(expected)?;
    }
    Ok(numbers)
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

#[cfg(test)]
mod tests {
    use super::without_comment;

    #[test]
    fn a_comment_stands_behind_a_blank() {
        assert_eq!(without_comment("# made by hand"), "");
        assert_eq!(without_comment("v 0 1 2 # top"), "v 0 1 2 ");
        assert_eq!(without_comment("usemtl red#1"), "usemtl red#1");
        assert_eq!(without_comment("usemtl red#1\t#2"), "usemtl red#1\t");
    }
}
