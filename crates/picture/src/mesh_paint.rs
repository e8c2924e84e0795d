//! Meshes with their own materials: base colors and textures as spectra that light meets.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use niji_geometry::MeshMaterial;
use niji_geometry::MeshTexture;
use niji_geometry::PaintedMesh;
use niji_geometry::TextureContent;
use niji_geometry::TriangleMesh;
use niji_geometry::read_painted_mesh;
use niji_photo::LinearPicture;
use niji_photo::read_texture;
use niji_radiometry::Bytes;
use niji_radiometry::Reflectance;
use niji_radiometry::memory_limit;
use niji_radiometry::open_file;
use niji_render::Material;
use niji_render::Paint;
use niji_render::Texture;

use crate::error::Error;
use crate::error::without_path;

/// Bytes that a pixel may take until it is a texel: its light, its color, and that among all colors.
const WORK_BYTES: usize = 128;

/// Reads a mesh and what its materials give back.
///
/// # Errors
/// A file that is missing or damaged, one without materials, or textures that are missing, damaged or more than memory
/// holds.
pub(crate) fn read_painted(path: &Path) -> Result<(TriangleMesh, Paint), Error> {
    let bad = |error: &dyn std::fmt::Display| {
        let message = without_path(path, &error.to_string());
        let asked = "albedo = \"materials\" asks for it, a number or red, green and blue do not";
        Error::file(path, format!("{message}; {asked}"))
    };
    let painted = read_painted_mesh(path).map_err(|error| bad(&error))?;
    let paint = paint(&painted).map_err(|message| bad(&message))?;
    Ok((painted.mesh, paint))
}

fn paint(mesh: &PaintedMesh) -> Result<Paint, String> {
    // Texture by texture, so that one picture at a time is in memory; once for all that multiply it by the same.
    let mut factors: BTreeMap<usize, Vec<[f64; 3]>> = BTreeMap::new();
    for MeshMaterial { factor, texture } in &mesh.materials {
        let Some(index) = texture else { continue };
        let of_texture = factors.entry(*index).or_default();
        if !of_texture.contains(factor) {
            of_texture.push(*factor);
        }
    }
    let (mut textures, mut numbers, mut n_bytes) = (Vec::new(), HashMap::new(), 0);
    for (index, factors) in factors {
        let from = &mesh.textures[index];
        let failed = |message| format!("texture {}: {message}", from.name);
        let light = light(from).map_err(failed)?;
        for factor in factors {
            check_memory(n_bytes + light.len() * WORK_BYTES).map_err(failed)?;
            let texture = Texture::new(&light, factor, from.wraps);
            let [a_texel, a_color] = Texture::BYTES;
            n_bytes += light.len() * a_texel + texture.n_colors() * a_color;
            numbers.insert((index, factor.map(f64::to_bits)), textures.len());
            textures.push(texture);
        }
    }
    let of_material = |MeshMaterial { factor, texture }: &MeshMaterial| {
        let key = texture.map(|index| (index, factor.map(f64::to_bits)));
        let number = key.and_then(|key| numbers.get(&key));
        number.map_or_else(
            || Material::Even(Reflectance::of_rgb(*factor)),
            |number| Material::Texture(*number),
        )
    };
    let n_triangles = mesh.mesh.triangles().len();
    let used: BTreeSet<u32> = (0..n_triangles).map(|it| mesh.mesh.painted(it).0).collect();
    // What no triangle has lights none.
    let of_used = |(number, material)| {
        if used.contains(&number) {
            of_material(material)
        } else {
            Material::Even(Reflectance::Even(0.0))
        }
    };
    Ok(Paint {
        materials: (0..).zip(&mesh.materials).map(of_used).collect(),
        textures,
    })
}

/// Linear light of a texture.
fn light(texture: &MeshTexture) -> Result<LinearPicture, String> {
    let bytes = match &texture.content {
        TextureContent::Bytes(bytes) => Cow::Borrowed(bytes),
        TextureContent::File(path) => {
            let (file, n_bytes) = open_file(path).map_err(|error| error.to_string())?;
            check_memory(n_bytes as usize)?;
            let mut bytes = Vec::new();
            let read = file.take(n_bytes).read_to_end(&mut bytes);
            read.map_err(|error| error.to_string())?;
            Cow::Owned(bytes)
        }
    };
    read_texture(&bytes).map_err(|error| error.to_string())
}

fn check_memory(n_bytes: usize) -> Result<(), String> {
    let (needed, limit) = (Bytes(n_bytes as u128), memory_limit());
    if needed > limit {
        return Err(format!(
            "found pictures that take {needed} of memory, expected at most {limit}: make them smaller"
        ));
    }
    Ok(())
}
