//! Base colors of glTF 2.0 files: materials, and the pictures that they name.
//!
//! Read beside the shape and only where it is asked for, so that what is wrong here is nothing to a mesh of one albedo.
//! Alpha, metalness, vertex colors and all other textures are no part of it.
//! Khronos Group, glTF 2.0 Specification (2021), sections 3.8 and 3.9.

use std::collections::BTreeSet;
use std::collections::HashMap;
use std::path::Path;
use std::path::PathBuf;

use glam::Vec2;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::Content;
use super::F32;
use super::Primitive;
use super::U8;
use super::U16;
use super::item;
use super::of_bytes;
use super::of_data_uri;
use super::percent_decoded;
use crate::mesh_files::MeshDetail;
use crate::mesh_files::Soup;
use crate::mesh_materials::MeshMaterial;
use crate::mesh_materials::MeshTexture;
use crate::mesh_materials::TextureContent;
use crate::mesh_materials::TextureWrap;
use crate::mesh_materials::beside;
use crate::mesh_materials::checked_factor;

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
    extensions: TextureExtensions,
}

#[derive(Default, Deserialize)]
struct TextureExtensions {
    /// It moves textures, which nothing here does.
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<IgnoredAny>,
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
struct TextureKey {
    image: usize,
    wraps: [TextureWrap; 2],
}

impl Appearance {
    pub(super) fn parsed(json: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(json).map_err(|error| error.to_string())
    }

    /// Whether a material has a texture.
    fn has_texture(&self, material: usize) -> Result<bool, String> {
        let base = item(&self.materials, material, "material")?.base.as_ref();
        Ok(base.is_some_and(|base| base.base_color_texture.is_some()))
    }

    /// Factors and textures of the materials.
    fn materials(&self) -> impl Iterator<Item = Result<([f64; 3], Option<TextureKey>), String>> {
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
        if info.extensions.transform.is_some() {
            return Err("found a texture moved by KHR_texture_transform, expected none".to_owned());
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
    fn image(&self, index: usize) -> Result<(Option<&str>, Option<usize>), String> {
        let image = item(&self.images, index, "image")?;
        Ok((image.uri.as_deref(), image.buffer_view))
    }

    /// Those of its pictures that are files, and are there.
    pub(super) fn picture_files(&self, path: &Path) -> impl Iterator<Item = PathBuf> {
        let uris = self.images.iter().filter_map(|image| image.uri.as_ref());
        uris.filter_map(move |uri| beside(path, &percent_decoded(uri)).ok())
    }
}

impl Content<'_> {
    /// Number of the material of a part, the first being that of parts without one, and texture coordinates where it
    /// has a texture.
    pub(super) fn paint(&self, primitive: &Primitive) -> Result<(u32, Option<Vec<Vec2>>), String> {
        let wanted = (self.detail == MeshDetail::Materials).then_some(primitive.material);
        let Some(index) = wanted.flatten() else {
            return Ok((0, None));
        };
        let uv = if self.appearance.has_texture(index)? {
            let uv = primitive.attributes.uv.ok_or_else(|| {
                format!("found no TEXCOORD_0 of a part whose material {index} has a texture")
            })?;
            Some(self.uv(uv)?)
        } else {
            None
        };
        Ok((index as u32 + 1, uv))
    }

    /// Texture coordinates: floats, or whole numbers of which the largest is 1.
    fn uv(&self, index: usize) -> Result<Vec<Vec2>, String> {
        let accessor = item(&self.document.accessors, index, "accessor")?;
        let (kind, of) = (&*accessor.kind, accessor.at.component_type);
        Ok(match (kind, of) {
            ("VEC2", F32) => of_bytes(self.elements(accessor)?, |it: [u8; 8]| {
                let [u, v] = [0, 4].map(|at| [0, 1, 2, 3].map(|byte| it[at + byte]));
                Vec2::new(f32::from_le_bytes(u), f32::from_le_bytes(v))
            }),
            ("VEC2", U16) => of_bytes(self.elements(accessor)?, |[a, b, c, d]| {
                let [u, v] = [[a, b], [c, d]].map(|it| f32::from(u16::from_le_bytes(it)));
                Vec2::new(u, v) / f32::from(u16::MAX)
            }),
            ("VEC2", U8) => of_bytes(self.elements(accessor)?, |[u, v]| {
                Vec2::new(f32::from(u), f32::from(v)) / f32::from(u8::MAX)
            }),
            _ => {
                return Err(format!(
                    "found texture coordinates of {kind}, component type {of}, expected VEC2, component type {F32}, \
                     {U8} or {U16}"
                ));
            }
        })
    }

    /// Adds the materials, with the pictures that triangles need.
    pub(super) fn add_materials(&self, path: &Path, soup: &mut Soup) -> Result<(), String> {
        if self.detail != MeshDetail::Materials {
            return Ok(());
        }
        let used: BTreeSet<u32> = soup.attributes.materials.iter().copied().collect();
        let mut wanted = HashMap::new();
        let mut n_bytes = 0;
        soup.materials = vec![MeshMaterial::WHITE];
        for (index, material) in self.appearance.materials().enumerate() {
            let (factor, texture) = material?;
            // Of one that no triangle has nothing is opened.
            let texture = texture.filter(|_| used.contains(&(index as u32 + 1)));
            let texture = match texture {
                Some(key) if !wanted.contains_key(&key) => {
                    let texture = self.texture(&key, path)?;
                    if let TextureContent::Bytes(bytes) = &texture.content {
                        n_bytes += bytes.len() as u128;
                    }
                    Soup::check_bytes(n_bytes, "pictures")?;
                    soup.textures.push(texture);
                    wanted.insert(key, soup.textures.len() - 1);
                    Some(soup.textures.len() - 1)
                }
                Some(key) => wanted.get(&key).copied(),
                None => None,
            };
            soup.materials.push(MeshMaterial { factor, texture });
        }
        Ok(())
    }

    /// A picture that a material names.
    fn texture(&self, key: &TextureKey, path: &Path) -> Result<MeshTexture, String> {
        let name = format!("image {}", key.image);
        let (uri, view) = self.appearance.image(key.image)?;
        let content = match (uri, view) {
            (Some(uri), _) => match of_data_uri(uri) {
                Some(bytes) => TextureContent::Bytes(bytes?),
                None => TextureContent::File(beside(path, &percent_decoded(uri))?),
            },
            (None, Some(view)) => TextureContent::Bytes(self.view(view)?.0.to_vec()),
            (None, None) => return Err(format!("found no content of {name}")),
        };
        Ok(MeshTexture {
            name,
            content,
            wraps: key.wraps,
        })
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
