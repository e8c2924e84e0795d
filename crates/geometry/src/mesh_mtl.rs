//! Colors of Wavefront MTL files.
//!
//! Of the lines only `newmtl`, `Kd` and `map_Kd` count; Kd is linear, as 3D programs write it, and white where it is left
//! out. A texture is multiplied by it.
//! Alias|Wavefront, Advanced Visualizer Manual, appendix B2 (1995): the format.

use std::collections::HashMap;
use std::io::BufRead;
use std::io::BufReader;
use std::path::Path;

use crate::mesh_files::opened;
use crate::mesh_materials::check_count;
use crate::mesh_materials::checked_factor;
use crate::mesh_obj::said;

/// A material: its color, and the name of its texture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mtl {
    pub(crate) factor: [f64; 3],
    pub(crate) texture: Option<String>,
}

/// Adds the materials of a file, by name.
pub(crate) fn read_mtl(path: &Path, materials: &mut HashMap<String, Mtl>) -> Result<(), String> {
    let file = opened(path).map_err(|error| error.to_string())?;
    let mut current = None;
    for (index, line) in BufReader::new(file).split(b'\n').enumerate() {
        let line = line.map_err(|error| format!("{}: {error}", path.display()))?;
        let line = String::from_utf8_lossy(&line);
        let line = said(&line);
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        if word == "newmtl" {
            let white = Mtl {
                factor: [1.0; 3],
                texture: None,
            };
            check_count(materials.len())?;
            materials.insert(rest.to_owned(), white);
            current = Some(rest.to_owned());
            continue;
        }
        let Some(material) = current.as_ref().and_then(|name| materials.get_mut(name)) else {
            continue;
        };
        let read = match word {
            "Kd" => color(rest).map(|factor| material.factor = factor),
            "map_Kd" => texture(rest).map(|name| material.texture = Some(name)),
            _ => Ok(()),
        };
        read.map_err(|message| format!("{}: line {}: {message}", path.display(), index + 1))?;
    }
    Ok(())
}

/// `0.8`, or `0.8 0.7 0.6`.
fn color(words: &str) -> Result<[f64; 3], String> {
    let numbers = words.split_whitespace().map(str::parse::<f64>);
    let numbers: Vec<f64> = numbers
        .collect::<Result<_, _>>()
        .map_err(|_| format!("found the Kd {words:?}, expected red, green and blue"))?;
    match numbers[..] {
        [gray] => checked_factor([gray; 3]),
        [red, green, blue] => checked_factor([red, green, blue]),
        _ => Err(format!(
            "found the Kd {words:?}, expected red, green and blue"
        )),
    }
}

/// The name of a file, with `/` between folders.
fn texture(words: &str) -> Result<String, String> {
    if words.is_empty() || words.starts_with('-') {
        return Err(format!(
            "found the map_Kd {words:?}, expected the name of a file without options"
        ));
    }
    Ok(words.replace('\\', "/"))
}
