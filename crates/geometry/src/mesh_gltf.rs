//! Triangles from glTF 2.0 files.
//!
//! The default scene with the transforms of its nodes:
//!   element i of an accessor = bytes offset + i stride .. offset + i stride + size of its view
//! Nothing in the file is believed: every index must name something, every element must lie in its view and
//! every view in its buffer, nodes must be a tree, and buffers must be files beside the mesh or below its folder.
//! Khronos Group, glTF 2.0 Specification (2021), sections 3.5 to 3.7 and 4.

mod appearance;
mod nodes;

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::path::PathBuf;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::DMat3;
use glam::DMat4;
use glam::DVec3;
use glam::Vec3;
use niji_radiometry::Bytes;
use niji_radiometry::memory_limit;
use serde::Deserialize;

use crate::mesh_files::MeshDetail;
use crate::mesh_files::Soup;
use crate::mesh_materials::beside;

use appearance::Appearance;
use nodes::Node;
use nodes::Roots;

/// First bytes of a file with its buffer inside (GLB).
const GLB_MAGIC: &[u8] = b"glTF";
/// Names of the chunks of such a file.
const JSON_CHUNK: &[u8] = b"JSON";
const BINARY_CHUNK: &[u8] = b"BIN\0";
/// Longest description: each `{},` of it becomes some tens of bytes.
const MOST_JSON_BYTES: usize = 128 << 20;
/// Starts of the names of extensions that say nothing about shape.
const APPEARANCE: [&str; 4] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
];

const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;
const TRIANGLES: u32 = 4;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Document {
    asset: Asset,
    scene: Option<usize>,
    #[serde(default)]
    scenes: Vec<Roots>,
    #[serde(default)]
    nodes: Vec<Node>,
    #[serde(default)]
    meshes: Vec<Mesh>,
    #[serde(default)]
    accessors: Vec<Accessor>,
    #[serde(default)]
    buffer_views: Vec<View>,
    #[serde(default)]
    buffers: Vec<Buffer>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

#[derive(Deserialize)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: MeshAttributes,
    indices: Option<usize>,
    material: Option<usize>,
    #[serde(default = "triangles")]
    mode: u32,
}

#[derive(Deserialize)]
struct MeshAttributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
    #[serde(rename = "NORMAL")]
    normal: Option<usize>,
    #[serde(rename = "TEXCOORD_0")]
    uv: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    #[serde(flatten)]
    at: Place,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
    sparse: Option<Sparse>,
}

/// Where elements stand, and what their numbers are.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Place {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    #[serde(default)]
    component_type: u32,
}

/// Elements that replace some of those of an accessor.
#[derive(Deserialize)]
struct Sparse {
    count: usize,
    indices: Place,
    values: Place,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Buffer {
    uri: Option<String>,
    byte_length: usize,
}

fn triangles() -> u32 {
    TRIANGLES
}

/// Reads the triangles of a file, opened from `path`.
pub(crate) fn read_gltf(file: File, path: &Path, detail: MeshDetail) -> Result<Soup, String> {
    let bytes = all_bytes(file)?;
    let (json, binary) = parts(&bytes)?;
    let document = Document::parsed(json)?;
    let shapes = document.shapes()?;
    document.check_memory(&shapes, detail)?;
    let mut content = Content {
        detail,
        buffers: document.read_buffers(binary, path)?,
        document: &document,
        appearance: Appearance::default(),
    };
    if detail == MeshDetail::Materials {
        content.appearance = Appearance::parsed(json)?;
    }
    let mut soup = Soup::default();
    for (primitive, placed) in shapes {
        content.add_primitive(primitive, placed, &mut soup)?;
    }
    content.add_materials(path, &mut soup)?;
    Ok(soup)
}

/// The files beside a file of this name that it names: its buffers, and those of its pictures that are there.
pub(crate) fn files_beside(file: File, path: &Path) -> Result<Vec<PathBuf>, String> {
    let bytes = all_bytes(file)?;
    let (json, _) = parts(&bytes)?;
    let document = Document::parsed(json)?;
    let uris = document.buffers.iter().filter_map(|it| it.uri.as_ref());
    let outside = uris.filter(|uri| !uri.starts_with("data:"));
    let mut files = outside
        .map(|uri| beside(path, &percent_decoded(uri)))
        .collect::<Result<Vec<_>, _>>()?;
    // They count only where a mesh has its own materials, and are refused there.
    let appearance = Appearance::parsed(json).unwrap_or_default();
    files.extend(appearance.picture_files(path));
    Ok(files)
}

fn all_bytes(mut file: File) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let read = file.read_to_end(&mut bytes);
    read.map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// The description in a file, as JSON, and the buffer that stands behind it in a GLB.
fn parts(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let (json, binary) = if bytes.starts_with(GLB_MAGIC) {
        let (json, rest) = chunk(bytes.get(12..).unwrap_or_default(), JSON_CHUNK)?;
        let binary = (!rest.is_empty()).then(|| chunk(rest, BINARY_CHUNK));
        (json, binary.transpose()?.map(|(binary, _)| binary))
    } else {
        (bytes, None)
    };
    if json.len() > MOST_JSON_BYTES {
        let (found, most) = (Bytes(json.len() as u128), Bytes(MOST_JSON_BYTES as u128));
        return Err(format!(
            "found a description of {found}, expected at most {most}: keep buffers in files of their own"
        ));
    }
    Ok((json, binary))
}

/// The content of the chunk that bytes begin with, and what follows it.
fn chunk<'a>(bytes: &'a [u8], name: &[u8]) -> Result<(&'a [u8], &'a [u8]), String> {
    let missing = || format!("found no whole chunk {:?}", String::from_utf8_lossy(name));
    let (length, rest) = bytes.split_first_chunk::<4>().ok_or_else(missing)?;
    let rest = rest.strip_prefix(name).ok_or_else(missing)?;
    let length = u32::from_le_bytes(*length) as usize;
    rest.split_at_checked(length).ok_or_else(missing)
}

/// A thing of a list by its index in the file.
fn item<'a, T>(list: &'a [T], index: usize, what: &str) -> Result<&'a T, String> {
    let n = list.len();
    list.get(index)
        .ok_or_else(|| format!("found {what} {index}, expected one of the {n} from 0"))
}

impl Document {
    fn parsed(json: &[u8]) -> Result<Self, String> {
        let document: Self = serde_json::from_slice(json).map_err(|error| error.to_string())?;
        let version = &document.asset.version;
        if !version.starts_with("2.") {
            return Err(format!("found version {version:?}, expected 2.0"));
        }
        let is_shape = |name: &&String| !APPEARANCE.iter().any(|start| name.starts_with(start));
        if let Some(name) = document.extensions_required.iter().find(is_shape) {
            return Err(format!(
                "found the required extension {name}, expected none: export the mesh without it"
            ));
        }
        Ok(document)
    }

    /// Refuses more triangles than fit into memory: a mesh can stand in many places.
    fn check_memory(
        &self,
        shapes: &[(&Primitive, DMat4)],
        detail: MeshDetail,
    ) -> Result<(), String> {
        let mut n_triangles = 0;
        for (primitive, _) in shapes {
            let corners = primitive.indices.or(primitive.attributes.position);
            let corners = corners.map(|index| item(&self.accessors, index, "accessor"));
            n_triangles += corners.transpose()?.map_or(0, |it| it.count as u128 / 3);
        }
        Soup::check_memory(n_triangles, detail)
    }

    fn read_buffers(&self, binary: Option<&[u8]>, path: &Path) -> Result<Vec<Vec<u8>>, String> {
        let needed: u128 = self.buffers.iter().map(|it| it.byte_length as u128).sum();
        let (needed, limit) = (Bytes(needed), memory_limit());
        if needed > limit {
            return Err(format!(
                "found buffers of {needed}, expected at most {limit}"
            ));
        }
        let buffers = self.buffers.iter().enumerate();
        let buffers = buffers.map(|(index, buffer)| {
            let mut bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => buffer.read(uri, path)?,
                (None, Some(binary)) if index == 0 => binary.to_vec(),
                (None, _) => return Err(format!("found no content of buffer {index}")),
            };
            let (found, expected) = (bytes.len(), buffer.byte_length);
            if found < expected {
                return Err(format!(
                    "found {found} bytes of buffer {index}, expected {expected}: the file was cut short"
                ));
            }
            bytes.truncate(expected);
            Ok(bytes)
        });
        buffers.collect()
    }
}

impl Buffer {
    /// Its bytes, or as many of them as it says.
    fn read(&self, uri: &str, path: &Path) -> Result<Vec<u8>, String> {
        if let Some(bytes) = of_data_uri(uri) {
            return bytes;
        }
        let file = beside(path, &percent_decoded(uri))?;
        let failed = |error: std::io::Error| format!("{}: {error}", file.display());
        let mut bytes = Vec::new();
        let source = File::open(&file).map_err(failed)?;
        let mut source = source.take(self.byte_length as u64);
        source.read_to_end(&mut bytes).map_err(failed)?;
        Ok(bytes)
    }
}

/// The bytes that a URI itself is; `None` if it names a file.
fn of_data_uri(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let data = uri.strip_prefix("data:")?;
    let text = data.split_once(";base64,");
    let text = text.ok_or_else(|| "found a data URI that is not base64".to_owned());
    Some(text.and_then(|(_, text)| BASE64.decode(text).map_err(|error| error.to_string())))
}

/// A text with its `%20` as spaces and so on.
fn percent_decoded(text: &str) -> String {
    let mut parts = text.split('%');
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        let code = part
            .get(..2)
            .and_then(|code| u8::from_str_radix(code, 16).ok());
        bytes.push(code.unwrap_or(b'%'));
        bytes.extend(part.bytes().skip(if code.is_some() { 2 } else { 0 }));
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A file with its buffers.
struct Content<'a> {
    detail: MeshDetail,
    appearance: Appearance,
    document: &'a Document,
    buffers: Vec<Vec<u8>>,
}

impl Content<'_> {
    /// Adds the triangles of a part, `placed` by the transforms of its nodes.
    fn add_primitive(
        &self,
        primitive: &Primitive,
        placed: DMat4,
        soup: &mut Soup,
    ) -> Result<(), String> {
        let mode = primitive.mode;
        if mode != TRIANGLES {
            return Err(format!(
                "found a mesh of mode {mode}, expected {TRIANGLES}: triangles"
            ));
        }
        let position = primitive.attributes.position;
        let position = position.ok_or("found a mesh without positions")?;
        let corners: Vec<DVec3> = self
            .vectors(position, "positions")?
            .map(|corner| placed.transform_point3(corner))
            .collect();
        let n = corners.len();
        let wanted = (self.detail >= MeshDetail::Normals).then_some(primitive.attributes.normal);
        let normals = wanted.flatten().map(|index| self.normals(index, placed));
        let normals = normals.map(|it| as_many(it?, n, "normals")).transpose()?;
        let (material, uv) = self.paint(primitive)?;
        let uv = uv
            .map(|it| as_many(it, n, "texture coordinates"))
            .transpose()?;
        let indices = match primitive.indices {
            Some(index) => self.indices(index)?,
            None => (0..corners.len() as u32).collect(),
        };
        // A mirroring transform turns the triangles over.
        let is_mirrored = placed.determinant() < 0.0;
        let (triangles, rest) = indices.as_chunks::<3>();
        if !rest.is_empty() {
            let n = indices.len();
            return Err(format!(
                "found {n} corners of triangles, expected three each"
            ));
        }
        let triangles = triangles
            .iter()
            .map(|&[a, b, c]| if is_mirrored { [a, c, b] } else { [a, b, c] });
        let first = soup.triangles.len();
        soup.add(&corners, triangles)?;
        if let Some(normals) = normals {
            let of_corners = soup.by_corner(first, &normals);
            soup.attributes.normals.resize(first, Default::default());
            soup.attributes.normals.extend(of_corners);
        }
        if let Some(uv) = uv {
            let of_corners = soup.by_corner(first, &uv);
            soup.attributes.uv.resize(first, Default::default());
            soup.attributes.uv.extend(of_corners);
        }
        if material > 0 {
            let materials = &mut soup.attributes.materials;
            materials.resize(first, 0);
            materials.resize(soup.triangles.len(), material);
        }
        Ok(())
    }

    /// Normals across the surface that the transforms make.
    fn normals(&self, index: usize, placed: DMat4) -> Result<Vec<Vec3>, String> {
        let across = DMat3::from_mat4(placed).inverse().transpose();
        let normals = self.vectors(index, "normals")?.enumerate();
        let turned = normals.map(|(index, normal)| {
            // A transform without an inverse flattens all triangles.
            let turned = (across * normal).normalize_or_zero().as_vec3();
            let odd = || format!("found a normal, number {index} from 0, that is not finite");
            normal.is_finite().then_some(turned).ok_or_else(odd)
        });
        turned.collect()
    }

    fn vectors(&self, index: usize, what: &str) -> Result<impl Iterator<Item = DVec3>, String> {
        let accessor = item(&self.document.accessors, index, "accessor")?;
        let (kind, of) = (&*accessor.kind, accessor.at.component_type);
        if (kind, of) != ("VEC3", F32) {
            return Err(format!(
                "found {what} of {kind}, component type {of}, expected VEC3, component type {F32}"
            ));
        }
        let elements = self.elements::<12>(accessor)?.into_iter();
        Ok(elements.map(|bytes| {
            let numbers = [0, 4, 8].map(|at| [0, 1, 2, 3].map(|byte| bytes[at + byte]));
            Vec3::from(numbers.map(f32::from_le_bytes)).as_dvec3()
        }))
    }

    fn indices(&self, index: usize) -> Result<Vec<u32>, String> {
        let accessor = item(&self.document.accessors, index, "accessor")?;
        if accessor.kind != "SCALAR" {
            let found = &accessor.kind;
            return Err(format!("found indices of {found}, expected SCALAR"));
        }
        self.numbers(accessor)
    }

    /// Whole numbers.
    fn numbers(&self, accessor: &Accessor) -> Result<Vec<u32>, String> {
        Ok(match accessor.at.component_type {
            U8 => of_bytes(self.elements(accessor)?, |it: [u8; 1]| u32::from(it[0])),
            U16 => of_bytes(self.elements(accessor)?, |it| u16::from_le_bytes(it).into()),
            U32 => of_bytes(self.elements(accessor)?, u32::from_le_bytes),
            found => {
                return Err(format!(
                    "found indices of component type {found}, expected {U8}, {U16} or {U32}"
                ));
            }
        })
    }

    /// Elements of `N` bytes.
    fn elements<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[u8; N]>, String> {
        let count = accessor.count;
        let mut elements = match (accessor.at.buffer_view, &accessor.sparse) {
            (Some(view), _) => self.in_view(view, accessor.at.byte_offset, count)?,
            // Zeros that are replaced in part.
            (None, Some(_)) if count <= self.buffers.iter().map(Vec::len).sum() => {
                vec![[0; N]; count]
            }
            (None, _) => return Err(format!("found {count} elements without a buffer view")),
        };
        let Some(sparse) = &accessor.sparse else {
            return Ok(elements);
        };
        let places = Accessor {
            at: sparse.indices,
            count: sparse.count,
            kind: String::new(),
            sparse: None,
        };
        let values = sparse
            .values
            .buffer_view
            .ok_or("found no values of a sparse accessor")?;
        let values = self.in_view(values, sparse.values.byte_offset, sparse.count)?;
        for (index, value) in self.numbers(&places)?.into_iter().zip(values) {
            let element = elements.get_mut(index as usize);
            *element.ok_or_else(|| {
                format!("found sparse index {index}, expected less than {count}")
            })? = value;
        }
        Ok(elements)
    }

    /// Elements of `N` bytes in a view.
    fn in_view<const N: usize>(
        &self,
        view: usize,
        byte_offset: usize,
        count: usize,
    ) -> Result<Vec<[u8; N]>, String> {
        let outside =
            || format!("found {count} elements of {N} bytes beyond their buffer view {view}");
        let (bytes, stride) = self.view(view)?;
        let stride = stride.unwrap_or(N);
        if stride < N {
            return Err(format!(
                "found a stride of {stride} bytes, expected at least {N}"
            ));
        }
        let bytes = bytes.get(byte_offset..).ok_or_else(outside)?;
        // The last element has no gap behind it.
        let found = bytes
            .chunks(stride)
            .map_while(|chunk| chunk.first_chunk::<N>());
        let found: Vec<[u8; N]> = found.take(count).copied().collect();
        (found.len() == count).then_some(found).ok_or_else(outside)
    }

    /// The bytes of a view, and from how many to how many its elements stand.
    fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), String> {
        let outside = || format!("found the buffer view {index} beyond its buffer");
        let view = item(&self.document.buffer_views, index, "buffer view")?;
        let buffer = item(&self.buffers, view.buffer, "buffer")?;
        let bytes = buffer.get(view.byte_offset..).ok_or_else(outside)?;
        let bytes = bytes.get(..view.byte_length).ok_or_else(outside)?;
        Ok((bytes, view.byte_stride))
    }
}

/// Values of corners, if there are as many.
fn as_many<T>(values: Vec<T>, n: usize, what: &str) -> Result<Vec<T>, String> {
    let found = values.len();
    let wrong = || format!("found {found} {what} of {n} corners, expected as many");
    (found == n).then_some(values).ok_or_else(wrong)
}

fn of_bytes<const N: usize, T>(elements: Vec<[u8; N]>, value: impl Fn([u8; N]) -> T) -> Vec<T> {
    elements.into_iter().map(value).collect()
}
