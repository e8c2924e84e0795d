//! Materials of mesh files, as far as they are colors: what a surface gives back, as much in all directions.

use std::path::Component;
use std::path::Path;
use std::path::PathBuf;

use crate::mesh::TriangleMesh;

/// Most materials that a file of lines may name: each line becomes some hundred bytes.
pub(crate) const MOST_MATERIALS: usize = 1 << 16;

/// A mesh with the materials that its triangles name.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintedMesh {
    /// Its triangles.
    pub mesh: TriangleMesh,
    /// By the number that triangles have.
    pub materials: Vec<MeshMaterial>,
    /// By the number that materials have.
    pub textures: Vec<MeshTexture>,
}

/// A color: `pbrMetallicRoughness.baseColorFactor` and `baseColorTexture` of glTF, `Kd` and `map_Kd` of OBJ.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshMaterial {
    /// Red, green and blue of linear Rec.709, 0..1, by which a texture is multiplied.
    pub factor: [f64; 3],
    /// Which of the textures.
    pub texture: Option<usize>,
}

impl MeshMaterial {
    /// What a triangle without a material has, in both formats.
    pub(crate) const WHITE: Self = Self {
        factor: [1.0; 3],
        texture: None,
    };
}

/// A picture in the code values of sRGB, PNG or JPEG, that nobody has opened yet.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshTexture {
    /// What the file calls it.
    pub name: String,
    /// Its bytes, or where they are.
    pub content: TextureContent,
    /// How it goes on to the right and down beyond its sides.
    pub wraps: [TextureWrap; 2],
}

/// Where the bytes of a texture are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextureContent {
    /// Here.
    Bytes(Vec<u8>),
    /// In a file in the folder of the mesh or below.
    File(PathBuf),
}

/// How a texture goes on beyond its sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureWrap {
    /// From the other side.
    Repeat,
    /// As its last texels.
    Clamp,
    /// Back again.
    Mirror,
}

impl TextureWrap {
    /// Which of `n` texels stands at a place along a side, in texels from the first.
    ///
    /// ```
    /// use niji_geometry::TextureWrap;
    /// let found = [TextureWrap::Repeat, TextureWrap::Clamp, TextureWrap::Mirror].map(|it| it.texel(-2, 8));
    /// assert_eq!(found, [6, 0, 1]);
    /// ```
    pub fn texel(self, place: i64, n: u32) -> u32 {
        let n = i64::from(n);
        let inside = match self {
            Self::Repeat => place.rem_euclid(n),
            Self::Clamp => place.clamp(0, n - 1),
            Self::Mirror => {
                let there = place.rem_euclid(2 * n);
                there.min(2 * n - 1 - there)
            }
        };
        inside as u32
    }
}

/// The file that a mesh names, which lies in its folder or below, whatever links say.
pub(crate) fn beside(path: &Path, uri: &str) -> Result<PathBuf, String> {
    let foreign = || {
        format!(
            "found the file {uri:?}, expected the name of one in the folder of the mesh or below"
        )
    };
    let is_name = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    let name = Path::new(uri);
    if uri.contains([':', '\\']) || !name.components().all(is_name) {
        return Err(foreign());
    }
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let folder = folder.unwrap_or(Path::new("."));
    let failed = |error| format!("{uri}: {error}");
    let file = folder.join(name).canonicalize().map_err(failed)?;
    let is_inside = file.starts_with(folder.canonicalize().map_err(failed)?);
    if !is_inside || !file.is_file() {
        return Err(foreign());
    }
    Ok(file)
}

/// Refuses one more material than a file may name.
pub(crate) fn check_count(n_materials: usize) -> Result<(), String> {
    let most = MOST_MATERIALS;
    if n_materials >= most {
        return Err(format!("found more than {most} materials, expected fewer"));
    }
    Ok(())
}

/// A color, if its channels are shares.
pub(crate) fn checked_factor(factor: [f64; 3]) -> Result<[f64; 3], String> {
    let is_share = factor.iter().all(|channel| (0.0..=1.0).contains(channel));
    is_share.then_some(factor).ok_or_else(|| {
        format!("found the color {factor:?}, expected red, green and blue of 0 to 1")
    })
}
