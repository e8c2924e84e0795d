//! The files that a scene names: nothing else that stands in a scene is opened.

use crate::drops::DropSource;
use crate::ice_scene::IceScene;
use crate::ice_scene::IceShape;
use crate::scene::Scene;

impl Scene {
    /// Names of all files of the scene, as they stand in it: of drops, photograph, surfaces and terrain.
    pub fn files(&self) -> Vec<&str> {
        let populations = self.drops.populations().iter();
        let mut files: Vec<&String> = populations
            .filter_map(|it| match &it.source {
                DropSource::File(drops) => Some(&drops.file),
                DropSource::FromVdb(density) => Some(&density.file),
                DropSource::Shape(_) => None,
            })
            .collect();
        if let Some(photo) = &self.photo {
            files.push(&photo.picture);
            files.extend(photo.layers.iter().chain(&photo.labels));
        }
        if let Some(occluders) = &self.occluders {
            files.extend(&occluders.depth);
            files.extend(occluders.meshes.iter().map(|mesh| &mesh.file));
        }
        files.extend(self.terrain.as_ref().map(|terrain| &terrain.file));
        files.into_iter().map(String::as_str).collect()
    }
}

impl IceScene {
    /// Names of all files of the scene, as they stand in it.
    pub fn files(&self) -> Vec<&str> {
        match &self.ice.shape {
            IceShape::Mesh { file, .. } => vec![file],
            IceShape::Cube { .. } | IceShape::Box { .. } | IceShape::Iceberg(_) => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use serde_json::Value;

    use super::*;
    use crate::schema::ice_scene_schema;
    use crate::schema::scene_schema;

    /// Keys whose values are any text, and no names of files.
    const TEXTS: [&str; 4] = ["date_time", "description", "grid", "name"];
    /// Keys whose values are names of files.
    const FILES: [&str; 5] = ["depth", "file", "labels", "layers", "picture"];

    fn add_free_texts(schema: &Value, keys: &mut BTreeSet<String>) {
        let fields = schema.as_object().into_iter().flatten();
        let items = schema.as_array().into_iter().flatten();
        for (key, value) in fields {
            if value["type"] == "string" && value.get("enum").or(value.get("const")).is_none() {
                keys.insert(key.clone());
            }
            add_free_texts(value, keys);
        }
        items.for_each(|item| add_free_texts(item, keys));
    }

    #[test]
    fn every_key_that_may_name_a_file_is_known() {
        let mut keys = BTreeSet::new();
        for schema in [scene_schema(), ice_scene_schema()] {
            add_free_texts(&serde_json::to_value(schema).unwrap(), &mut keys);
        }
        // A new one that names a file belongs into `files` above, else `--sandbox` does not hold it.
        let known = TEXTS.into_iter().chain(FILES).map(str::to_owned);
        assert_eq!(keys, known.collect());
    }

    #[test]
    fn a_scene_tells_all_its_files() {
        let text = r#"
            format = 1
            name = "n"
            [sun]
            elevation_deg = 20.0
            azimuth_deg = 180.0
            [camera]
            position_m = [0.0, 1.6, 0.0]
            azimuth_deg = 0.0
            elevation_deg = 10.0
            horizontal_fov_deg = 60.0
            width_px = 16
            height_px = 12
            [[drops]]
            file = "a.vdb"
            [[drops]]
            shape = "from-vdb"
            file = "b.vdb"
            density_means = "optical-depth"
            scale = 1.0
            effective_radius_um = 100.0
            [photo]
            picture = "c.jpg"
            layers = "d.toml"
            labels = "e.png"
            [occluders]
            meshes = [{ file = "f.obj" }, { file = "g.gltf" }]
            [terrain]
            file = "h.png"
            spacing_m = 30.0
            height_m = [0.0, 900.0]
            "#;
        let scene = Scene::from_toml(text).unwrap();
        let mut names = scene.files();
        names.sort_unstable();
        let expected = [
            "a.vdb", "b.vdb", "c.jpg", "d.toml", "e.png", "f.obj", "g.gltf", "h.png",
        ];
        assert_eq!(names, expected);
    }
}
