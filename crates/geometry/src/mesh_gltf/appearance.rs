//! Base colors of glTF 2.0 files: materials, and the pictures that they name.
//!
//! Read beside the shape and only where it is asked for, so that what is wrong here is nothing to a mesh of one albedo.
//! Alpha, metalness, vertex colors and all other textures are no part of it.
//! Khronos Group, glTF 2.0 Specification (2021), sections 3.8 and 3.9.

use std::collections::BTreeMap;
use std::path::Path;
use std::path::PathBuf;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::item;
use super::percent_decoded;
use crate::mesh_materials::TextureWrap;
use crate::mesh_materials::beside;
use crate::mesh_materials::checked_factor;

/// An extension that moves textures, which nothing here does.
const TRANSFORM: &str = "KHR_texture_transform";

/// Materials and what they name.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Appearance {
    materials: Vec<Material>,
    textures: Vec<Texture>,
    images: Vec<Image>,
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct Material {
    #[serde(rename = "pbrMetallicRoughness")]
    base: Option<Base>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Base {
    base_color_factor: Option<[f64; 4]>,
    base_color_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TextureInfo {
    index: usize,
    #[serde(default)]
    tex_coord: usize,
    #[serde(default)]
    extensions: BTreeMap<String, IgnoredAny>,
}

#[derive(Deserialize)]
struct Texture {
    sampler: Option<usize>,
    source: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Image {
    uri: Option<String>,
    buffer_view: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Sampler {
    wrap_s: Option<u32>,
    wrap_t: Option<u32>,
}

/// A picture and how it goes on beyond its sides.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(super) struct TextureKey {
    pub(super) image: usize,
    pub(super) wraps: [TextureWrap; 2],
}

impl Appearance {
    pub(super) fn parsed(json: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(json).map_err(|error| error.to_string())
    }

    /// Whether a material has a texture.
    pub(super) fn has_texture(&self, material: usize) -> Result<bool, String> {
        let base = item(&self.materials, material, "material")?.base.as_ref();
        Ok(base.is_some_and(|base| base.base_color_texture.is_some()))
    }

    /// Factors and textures of the materials.
    pub(super) fn materials(
        &self,
    ) -> impl Iterator<Item = Result<([f64; 3], Option<TextureKey>), String>> {
        self.materials.iter().enumerate().map(|(index, material)| {
            let Some(base) = &material.base else {
                return Ok(([1.0; 3], None));
            };
            let [red, green, blue, _] = base.base_color_factor.unwrap_or([1.0; 4]);
            let factor = checked_factor([red, green, blue]);
            let texture = base.base_color_texture.as_ref();
            let texture = texture.map(|it| self.texture(it)).transpose();
            let both = factor.and_then(|factor| Ok((factor, texture?)));
            both.map_err(|message| format!("material {index}: {message}"))
        })
    }

    fn texture(&self, info: &TextureInfo) -> Result<TextureKey, String> {
        if info.tex_coord != 0 {
            let found = info.tex_coord;
            return Err(format!(
                "found a texture by TEXCOORD_{found}, expected TEXCOORD_0"
            ));
        }
        if info.extensions.contains_key(TRANSFORM) {
            return Err(format!(
                "found a texture moved by {TRANSFORM}, expected none"
            ));
        }
        let texture = item(&self.textures, info.index, "texture")?;
        let image = texture
            .source
            .ok_or_else(|| format!("found no PNG or JPEG of texture {}", info.index))?;
        let sampler = texture
            .sampler
            .map(|index| item(&self.samplers, index, "sampler"));
        let wraps = sampler
            .transpose()?
            .map_or([None; 2], |it| [it.wrap_s, it.wrap_t]);
        let [right, down] = wraps.map(wrap);
        Ok(TextureKey {
            image,
            wraps: [right?, down?],
        })
    }

    /// Where a picture is: its URI, or the view of a buffer.
    pub(super) fn image(&self, index: usize) -> Result<(Option<&str>, Option<usize>), String> {
        let image = item(&self.images, index, "image")?;
        Ok((image.uri.as_deref(), image.buffer_view))
    }

    /// Those of its pictures that are files, and are there.
    pub(super) fn picture_files(&self, path: &Path) -> impl Iterator<Item = PathBuf> {
        let uris = self.images.iter().filter_map(|image| image.uri.as_ref());
        uris.filter_map(move |uri| beside(path, &percent_decoded(uri)).ok())
    }
}

fn wrap(code: Option<u32>) -> Result<TextureWrap, String> {
    match code {
        None | Some(10497) => Ok(TextureWrap::Repeat),
        Some(33071) => Ok(TextureWrap::Clamp),
        Some(33648) => Ok(TextureWrap::Mirror),
        Some(found) => Err(format!(
            "found a texture that goes on by {found}, expected 10497, 33071 or 33648"
        )),
    }
}
