//! Meshes from OBJ, glTF and STL files.
//!
//! STL: text or binary. OBJ and STL say nothing about units or about which way is up; glTF is in metres by
//! that format's definition.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::path::PathBuf;

use glam::DVec3;
use glam::Vec3;
use niji_radiometry::Bytes;
use niji_radiometry::memory_limit;
use niji_radiometry::open_file;

use crate::error::Error;
use crate::mesh::TriangleAttributes;
use crate::mesh::TriangleMesh;
use crate::mesh_gltf;
use crate::mesh_gltf::read_gltf;
use crate::mesh_materials::MeshMaterial;
use crate::mesh_materials::MeshTexture;
use crate::mesh_materials::PaintedMesh;
use crate::mesh_obj;
use crate::mesh_obj::read_obj;

/// What is read of a mesh; of the rest of its file nothing is believed and nothing refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum MeshDetail {
    /// Where it is.
    #[default]
    Shape,
    /// That, and the normals at its corners where its file has them.
    Normals,
    /// That, and its own colors.
    Materials,
}

impl MeshDetail {
    /// Memory that a triangle takes until it stands in its tree: three corners before and after equal ones are found,
    /// their names, boxes and nodes; and of the file, of the mesh and of the mesh in its place three normals, then
    /// three texture coordinates and a material.
    fn triangle_bytes(self) -> u128 {
        match self {
            Self::Shape => 400,
            Self::Normals => 400 + 4 * 36,
            Self::Materials => 400 + 4 * (36 + 24 + 4),
        }
    }
}

/// Bytes of corners that a byte of a file can become, `v 0 0 0` say.
const CORNER_EXPANSION: u128 = 4;

/// Reads the mesh in a file, by its name: `*.obj`, `*.gltf`, `*.glb` or `*.stl`.
///
/// # Errors
/// A file that is missing or damaged, a name of another kind, more than fits into memory, or as
/// [`TriangleMesh::with_attributes`].
pub fn read_mesh(path: &Path, detail: MeshDetail) -> Result<TriangleMesh, Error> {
    Ok(read(path, detail)?.mesh)
}

/// Reads the mesh in a file as [`read_mesh`], with the materials that its file has.
///
/// # Errors
/// As there, a file without materials, and what is wrong with them, pictures but for their names.
pub fn read_painted_mesh(path: &Path) -> Result<PaintedMesh, Error> {
    let painted = read(path, MeshDetail::Materials)?;
    // The first is that of triangles without one.
    if painted.materials.len() < 2 {
        let message = "found no materials, expected those of an OBJ (mtllib, usemtl) or a glTF";
        return Err(damaged(path, message.to_owned()));
    }
    Ok(painted)
}

fn read(path: &Path, detail: MeshDetail) -> Result<PaintedMesh, Error> {
    let format = Format::of(path)?;
    let opened = opened(path)?;
    let (name, soup) = match format {
        Format::Obj => ("OBJ", read_obj(BufReader::new(opened), path, detail)),
        Format::Gltf => ("glTF", read_gltf(opened, path, detail)),
        Format::Stl => ("STL", read_stl(opened)),
    };
    let checked = soup.and_then(|soup| {
        Soup::check_memory(soup.triangles.len() as u128, detail)?;
        Ok(soup)
    });
    let soup = checked.map_err(|message| unreadable(path, name, &message))?;
    let mesh = TriangleMesh::with_attributes(&soup.corners, &soup.triangles, soup.attributes)?;
    Ok(PaintedMesh {
        mesh,
        materials: soup.materials,
        textures: soup.textures,
    })
}

/// The other files that a mesh file names: buffers of glTF, and those of materials that are there.
///
/// # Errors
/// As [`read_mesh`], as far as names of buffers show it.
pub fn files_beside_mesh(path: &Path) -> Result<Vec<PathBuf>, Error> {
    match Format::of(path) {
        Ok(Format::Gltf) => mesh_gltf::files_beside(opened(path)?, path)
            .map_err(|message| unreadable(path, "glTF", &message)),
        Ok(Format::Obj) => mesh_obj::files_beside(BufReader::new(opened(path)?), path)
            .map_err(|message| unreadable(path, "OBJ", &message)),
        Ok(Format::Stl) | Err(_) => Ok(Vec::new()),
    }
}

#[derive(Clone, Copy)]
enum Format {
    Obj,
    Gltf,
    Stl,
}

impl Format {
    fn of(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        match extension.to_ascii_lowercase().as_str() {
            "obj" => Ok(Self::Obj),
            "gltf" | "glb" => Ok(Self::Gltf),
            "stl" => Ok(Self::Stl),
            _ => Err(Error::MeshFormat {
                path: path.to_owned(),
            }),
        }
    }
}

fn damaged(path: &Path, message: String) -> Error {
    Error::MeshFile {
        path: path.to_owned(),
        message,
    }
}

fn unreadable(path: &Path, format: &str, message: &str) -> Error {
    damaged(path, format!("cannot be read as {format}: {message}"))
}

/// A file that ends, and whose bytes fit into memory.
pub(crate) fn opened(path: &Path) -> Result<File, Error> {
    let failed = |error: std::io::Error| damaged(path, error.to_string());
    let (file, file_bytes) = open_file(path).map_err(failed)?;
    let found = Bytes(file_bytes.into());
    let limit = Bytes(memory_limit().0 / CORNER_EXPANSION);
    if found > limit {
        let message = format!("found a file of {found}, expected at most {limit}");
        return Err(damaged(path, message));
    }
    Ok(file)
}

/// Triangles as they come from a file, before their equal corners are found.
#[derive(Default)]
pub(crate) struct Soup {
    pub(crate) corners: Vec<DVec3>,
    /// Triples of indices of corners.
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) attributes: TriangleAttributes,
    /// What the attributes name; the first is of triangles without one. Empty where nobody asked.
    pub(crate) materials: Vec<MeshMaterial>,
    pub(crate) textures: Vec<MeshTexture>,
}

impl Soup {
    /// Refuses more triangles than fit into memory.
    pub(crate) fn check_memory(n_triangles: u128, detail: MeshDetail) -> Result<(), String> {
        let needed = Bytes(n_triangles * detail.triangle_bytes());
        let limit = memory_limit();
        if needed > limit {
            return Err(format!(
                "found {n_triangles} triangles, which take {needed} of memory, expected at most {limit}"
            ));
        }
        Ok(())
    }

    /// Refuses more bytes of something than fit into memory.
    pub(crate) fn check_bytes(n_bytes: u128, what: &str) -> Result<(), String> {
        let (found, limit) = (Bytes(n_bytes), memory_limit());
        if found > limit {
            return Err(format!("found {what} of {found}, expected at most {limit}"));
        }
        Ok(())
    }

    /// Values of the triangles from one on by their corners, which are the last that were added.
    pub(crate) fn by_corner<T: Copy>(&self, first: usize, values: &[T]) -> Vec<[T; 3]> {
        let n_before = self.corners.len() - values.len();
        let of = |triangle: &[u32; 3]| triangle.map(|index| values[index as usize - n_before]);
        self.triangles[first..].iter().map(of).collect()
    }

    /// Adds a part with corners of its own.
    pub(crate) fn add(
        &mut self,
        corners: &[DVec3],
        triangles: impl Iterator<Item = [u32; 3]>,
    ) -> Result<(), String> {
        let (first, n_own) = (self.corners.len(), corners.len() as u32);
        if u32::try_from(first + corners.len()).is_err() {
            return Err(format!("found more than {} corners", u32::MAX));
        }
        self.corners.extend_from_slice(corners);
        for triangle in triangles {
            if let Some(index) = triangle.into_iter().find(|index| *index >= n_own) {
                let n_vertices = corners.len();
                return Err(Error::VertexIndex { index, n_vertices }.to_string());
            }
            self.triangles
                .push(triangle.map(|index| first as u32 + index));
        }
        Ok(())
    }
}

fn read_stl(file: File) -> Result<Soup, String> {
    let mut reader = BufReader::new(file);
    let facets = stl_io::create_stl_reader(&mut reader).map_err(|error| error.to_string())?;
    let mut soup = Soup::default();
    for facet in facets {
        let facet = facet.map_err(|error| error.to_string())?;
        let corners = facet.vertices.map(|vertex| Vec3::from(vertex.0).as_dvec3());
        soup.add(&corners, std::iter::once([0, 1, 2]))?;
    }
    Ok(soup)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::aabb::Aabb;

    fn in_folder<T>(files: &[(&str, &[u8])], look: impl Fn(&Path) -> T) -> T {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        look(&folder.path().join(files[0].0))
    }

    fn read_shape(path: &Path) -> Result<TriangleMesh, Error> {
        read_mesh(path, MeshDetail::Shape)
    }

    fn cube() -> TriangleMesh {
        TriangleMesh::of_box(Aabb {
            min: DVec3::ZERO,
            max: DVec3::ONE,
        })
    }

    fn obj() -> Vec<u8> {
        let corners = cube();
        let corners = corners.vertices().iter();
        let corners = corners.map(|at| format!("v {} {} {}\n", at.x, at.y, at.z));
        // Quadrilaterals, in both ways of counting.
        let faces =
            "usemtl ice\nf 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf -8 -6 -5 -7\nf 5 6 8 7\n";
        let text = "mtllib missing.mtl\n".to_owned() + &corners.collect::<String>() + faces;
        text.into_bytes()
    }

    fn stl() -> Vec<u8> {
        let cube = cube();
        let facets = (0..12).map(|index| stl_io::Triangle {
            normal: stl_io::Normal::new([0.0; 3]),
            vertices: cube
                .corners(index)
                .map(|at| stl_io::Vertex::new(at.as_vec3().to_array())),
        });
        let facets: Vec<_> = facets.collect();
        let mut bytes = Vec::new();
        stl_io::write_stl(&mut bytes, facets.iter()).unwrap();
        bytes
    }

    /// A cube of 2 m in a node that stretches and mirrors.
    fn gltf() -> (String, Vec<u8>) {
        let cube = cube();
        let mut bytes: Vec<u8> = Vec::new();
        for corner in cube.vertices() {
            let numbers = corner.as_vec3().to_array();
            bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        }
        for index in cube.triangles().iter().flatten() {
            bytes.extend((*index as u16).to_le_bytes());
        }
        let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
            "nodes":[{"scale":[-2,2,2],"children":[1]},{"mesh":0,"translation":[1,0,0]}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3",
            "min":[0,0,0],"max":[1,1,1]},
            {"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}],
            "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":96},
            {"buffer":0,"byteOffset":96,"byteLength":72}],
            "buffers":[{"uri":"cube.bin","byteLength":168}]}"#;
        (json.to_owned(), bytes)
    }

    #[test]
    fn every_format_gives_the_cube_that_was_written() {
        let (json, bytes) = gltf();
        let in_obj = in_folder(&[("cube.OBJ", &obj())], read_shape).unwrap();
        let in_stl = in_folder(&[("cube.stl", &stl())], read_shape).unwrap();
        let files: [(&str, &[u8]); 2] = [("cube.gltf", json.as_bytes()), ("cube.bin", &bytes)];
        let in_gltf = in_folder(&files, read_shape).unwrap();
        for (mesh, volume_m3) in [(in_obj, 1.0), (in_stl, 1.0), (in_gltf.clone(), 8.0)] {
            assert!(mesh.check_closed().is_ok());
            assert_eq!((mesh.volume_m3(), mesh.vertices().len()), (volume_m3, 8));
        }
        // Moved by 1 m, then stretched and mirrored.
        assert_eq!(in_gltf.bounds().min, DVec3::new(-4.0, 0.0, 0.0));
    }

    #[test]
    fn normals_are_those_of_the_surface_in_every_format_and_none_cost_nothing() {
        // One face of two triangles, tilted by 45 degrees and leaning at one corner.
        let corners = "v 0 0 0\nv 2 0 0\nv 2 1 1\nv 0 1 1\n";
        let obj = corners.to_owned() + "vn 0 -3 3\nvn 3 -3 3\nf 1//1 2//2 3//1 4\n";
        let in_obj = |detail| {
            in_folder(&[("a.obj", obj.as_bytes())], |path| {
                read_mesh(path, detail).unwrap()
            })
        };
        assert_eq!(in_obj(MeshDetail::Shape).normals(0), None);
        let plain = corners.to_owned() + "f 1 2 3 4\n";
        let plain = in_folder(&[("a.obj", plain.as_bytes())], |path| {
            read_mesh(path, MeshDetail::Normals)
        });
        assert_eq!(plain.unwrap().normals(0), None);
        let smooth = in_obj(MeshDetail::Normals);
        let own = Vec3::new(0.0, -1.0, 1.0).normalize();
        let lean = Vec3::new(1.0, -1.0, 1.0).normalize();
        for (triangle, expected) in [[own, lean, own], [own, own, own]].into_iter().enumerate() {
            let found = smooth.normals(triangle).unwrap();
            let pairs = found.into_iter().zip(expected);
            assert!(
                pairs.into_iter().all(|(a, b)| (a - b).length() < 1e-6),
                "{found:?}"
            );
        }
        // The same by a node that mirrors and stretches what was written: x by -2, y by 0.5.
        let (corners, normals) = (
            [[0.0_f32, 0.0, 0.0], [-1.0, 2.0, 1.0], [-1.0, 0.0, 0.0]],
            [[0.0_f32, -0.5, 1.0], [0.0, -0.5, 1.0], [-2.0, -0.5, 1.0]],
        );
        let numbers = corners.iter().chain(&normals).flatten();
        let bytes: Vec<u8> = numbers.flat_map(|it| it.to_le_bytes()).collect();
        let json = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":[-2,0.5,1]}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
            {"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC3"}],
            "bufferViews":[{"buffer":0,"byteLength":72}],"buffers":[{"uri":"a.bin","byteLength":72}]}"#;
        let read = |json: &str| {
            let files: [(&str, &[u8]); 2] = [("a.gltf", json.as_bytes()), ("a.bin", &bytes)];
            in_folder(&files, |path| read_mesh(path, MeshDetail::Normals))
        };
        let in_gltf = read(json).unwrap();
        // Mirrored, its triangle runs from the first corner to the third.
        let found = in_gltf.normals(0).unwrap();
        let pairs = found.into_iter().zip([own, lean, own]);
        assert!(
            pairs.into_iter().all(|(a, b)| (a - b).length() < 1e-6),
            "{found:?}"
        );
        let fewer = json.replace(
            "36,\"componentType\":5126,\"count\":3",
            "36,\"componentType\":5126,\"count\":2",
        );
        let refused = read(&fewer).unwrap_err().to_string();
        assert!(
            refused.contains("found 2 normals of 3 corners"),
            "{refused}"
        );
    }

    #[test]
    fn damaged_files_are_errors() {
        let (json, bytes) = gltf();
        let mut nan = stl();
        nan[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
        let broken: [&[(&str, &[u8])]; 10] = [
            &[("a.obj", b"v 1 2\n")],
            &[("a.obj", b"v 0 0 0\nf 1 2 3\n")],
            &[("a.obj", b"")],
            &[("a.obj", b"v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n")],
            &[("a.stl", &stl()[..300])],
            &[("a.stl", &nan)],
            &[("a.stl", b"solid\n facet")],
            &[("a.gltf", &json.as_bytes()[..400])],
            &[("a.gltf", json.as_bytes())],
            &[("a.gltf", json.as_bytes()), ("cube.bin", &bytes[..100])],
        ];
        for files in broken {
            assert!(in_folder(files, read_shape).is_err(), "{}", files[0].0);
        }
        let index = json.replace("\"count\":8", "\"count\":7");
        let files: [(&str, &[u8]); 2] = [("a.gltf", index.as_bytes()), ("cube.bin", &bytes)];
        let beyond = in_folder(&files, read_shape).unwrap_err().to_string();
        assert!(
            beyond.contains("corner 7, expected less than 7"),
            "{beyond}"
        );
        let cut = in_folder(&[("a.stl", &stl()[..300])], read_shape).unwrap_err();
        assert!(cut.to_string().contains("cannot be read as STL"), "{cut}");
        let missing = read_shape(&PathBuf::from("no-such-file.obj"));
        assert!(matches!(missing, Err(Error::MeshFile { .. })));
        let other = read_shape(&PathBuf::from("cube.ply")).unwrap_err();
        assert_eq!(
            other.to_string(),
            "cube.ply: expected a mesh named *.obj, *.gltf, *.glb or *.stl"
        );
    }
}
