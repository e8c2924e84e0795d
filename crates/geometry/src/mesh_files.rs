//! Meshes from OBJ, glTF and STL files.
//!
//! OBJ: all objects of the file together, polygons as fans. glTF: the default scene (the first where
//! none is named) with the transforms of its nodes; metres by that format's definition. STL: text or
//! binary. OBJ and STL say nothing about units or about which way is up.

use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::DMat4;
use glam::DVec3;
use glam::Vec3;

use crate::error::Error;
use crate::mesh::TriangleMesh;

/// Reads the mesh in a file, by its name: `*.obj`, `*.gltf`, `*.glb` or `*.stl`.
///
/// # Errors
/// A file that is missing or damaged, a name of another kind, or as [`TriangleMesh::new`].
pub fn read_mesh(path: &Path) -> Result<TriangleMesh, Error> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    let damaged = |message: String| Error::MeshFile {
        path: path.to_owned(),
        message,
    };
    let opened = || File::open(path).map_err(|error| damaged(error.to_string()));
    let (format, soup) = match extension.to_ascii_lowercase().as_str() {
        "obj" => ("OBJ", read_obj(opened()?)),
        "gltf" | "glb" => ("glTF", opened().map(|_| read_gltf(path))?),
        "stl" => ("STL", read_stl(opened()?)),
        _ => {
            let path = path.to_owned();
            return Err(Error::MeshFormat { path });
        }
    };
    let soup = soup.map_err(|message| damaged(format!("cannot be read as {format}: {message}")))?;
    TriangleMesh::new(&soup.corners, &soup.triangles)
}

/// Triangles as they come from a file, before their equal corners are found.
#[derive(Default)]
struct Soup {
    corners: Vec<DVec3>,
    /// Triples of indices of corners.
    triangles: Vec<[u32; 3]>,
}

fn read_obj(file: File) -> Result<Soup, String> {
    let mut reader = BufReader::new(file);
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: false,
        ..tobj::LoadOptions::default()
    };
    // Materials say nothing about shape: their files are not opened.
    let no_materials = |_: &Path| Ok((Vec::new(), HashMap::default()));
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, no_materials)
        .map_err(|error| error.to_string())?;
    let mut soup = Soup::default();
    for model in models {
        let first = soup.corners.len() as u32;
        let positions = model.mesh.positions.chunks_exact(3);
        soup.corners.extend(positions.map(DVec3::from_slice));
        let indices = model.mesh.indices.chunks_exact(3);
        soup.triangles.extend(indices.map(|i| shifted(i, first)));
    }
    Ok(soup)
}

/// Corner numbers of a part of a file as those of the whole; no number of a damaged file wraps around.
fn shifted(indices: &[u32], first: u32) -> [u32; 3] {
    [0, 1, 2].map(|corner| first.saturating_add(indices[corner]))
}

fn read_stl(file: File) -> Result<Soup, String> {
    let mut reader = BufReader::new(file);
    let facets = stl_io::create_stl_reader(&mut reader).map_err(|error| error.to_string())?;
    let mut corners = Vec::new();
    for facet in facets {
        let facet = facet.map_err(|error| error.to_string())?;
        corners.extend(facet.vertices.map(|vertex| Vec3::from(vertex.0).as_dvec3()));
    }
    let n_triangles = corners.len() as u32 / 3;
    let triangles = (0..n_triangles).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]);
    Ok(Soup {
        corners,
        triangles: triangles.collect(),
    })
}

fn read_gltf(path: &Path) -> Result<Soup, String> {
    let document = gltf::Gltf::open(path).map_err(|error| error.to_string())?;
    let gltf::Gltf { document, blob } = document;
    let buffers = gltf::import_buffers(&document, path.parent(), blob);
    let buffers = buffers.map_err(|error| error.to_string())?;
    let mut soup = Soup::default();
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next());
    let roots = scene.iter().flat_map(gltf::Scene::nodes);
    let mut waiting: Vec<_> = roots.map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((node, parent)) = waiting.pop() {
        let placed = parent * matrix_of(&node);
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            soup.add_primitive(&primitive, &buffers, placed)?;
        }
        waiting.extend(node.children().map(|child| (child, placed)));
    }
    Ok(soup)
}

fn matrix_of(node: &gltf::Node) -> DMat4 {
    let columns = node.transform().matrix();
    DMat4::from_cols_array_2d(&columns.map(|column| column.map(f64::from)))
}

impl Soup {
    /// Adds the triangles of a part of a file, `placed` by the transforms of its nodes.
    fn add_primitive(
        &mut self,
        primitive: &gltf::Primitive,
        buffers: &[gltf::buffer::Data],
        placed: DMat4,
    ) -> Result<(), String> {
        let mode = primitive.mode();
        if mode != gltf::mesh::Mode::Triangles {
            return Err(format!("found a mesh of {mode:?}, expected triangles"));
        }
        let first = self.corners.len() as u32;
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|data| &data.0[..]));
        let positions = reader.read_positions();
        let positions = positions.ok_or("found a mesh without positions".to_owned())?;
        self.corners
            .extend(positions.map(|at| placed.transform_point3(Vec3::from(at).as_dvec3())));
        let n_own = self.corners.len() as u32 - first;
        let indices: Vec<u32> = match reader.read_indices() {
            Some(indices) => indices.into_u32().collect(),
            None => (0..n_own).collect(),
        };
        // A mirroring transform turns the triangles over.
        let is_mirrored = placed.determinant() < 0.0;
        self.triangles.extend(indices.chunks_exact(3).map(|i| {
            let [a, b, c] = shifted(i, first);
            if is_mirrored { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use super::*;
    use crate::aabb::Aabb;

    fn in_folder<T>(files: &[(&str, &[u8])], look: impl Fn(&Path) -> T) -> T {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        look(&folder.path().join(files[0].0))
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
        let in_obj = in_folder(&[("cube.OBJ", &obj())], read_mesh).unwrap();
        let in_stl = in_folder(&[("cube.stl", &stl())], read_mesh).unwrap();
        let files: [(&str, &[u8]); 2] = [("cube.gltf", json.as_bytes()), ("cube.bin", &bytes)];
        let in_gltf = in_folder(&files, read_mesh).unwrap();
        for (mesh, volume_m3) in [(in_obj, 1.0), (in_stl, 1.0), (in_gltf.clone(), 8.0)] {
            assert!(mesh.check_closed().is_ok());
            assert_eq!((mesh.volume_m3(), mesh.vertices().len()), (volume_m3, 8));
        }
        // Moved by 1 m, then stretched and mirrored.
        assert_eq!(in_gltf.bounds().min, DVec3::new(-4.0, 0.0, 0.0));
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
            assert!(in_folder(files, read_mesh).is_err(), "{}", files[0].0);
        }
        let index = json.replace("\"count\":8", "\"count\":7");
        let files: [(&str, &[u8]); 2] = [("a.gltf", index.as_bytes()), ("cube.bin", &bytes)];
        assert!(matches!(
            in_folder(&files, read_mesh),
            Err(Error::VertexIndex { index: 7, .. })
        ));
        let cut = in_folder(&[("a.stl", &stl()[..300])], read_mesh).unwrap_err();
        assert!(cut.to_string().contains("cannot be read as STL"), "{cut}");
        let missing = read_mesh(&PathBuf::from("no-such-file.obj"));
        assert!(matches!(missing, Err(Error::MeshFile { .. })));
        let other = read_mesh(&PathBuf::from("cube.ply")).unwrap_err();
        assert_eq!(
            other.to_string(),
            "cube.ply: expected a mesh named *.obj, *.gltf, *.glb or *.stl"
        );
    }
}
