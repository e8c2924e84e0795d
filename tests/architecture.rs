//! The arrows between the crates are law: this test reads every manifest and fails on a forbidden
//! dependency.

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// What each crate may see, besides `radiometry`, which every crate but `vdb` may see.
const ARROWS: [(&str, &[&str]); 16] = [
    ("radiometry", &[]),
    ("vdb", &[]),
    ("geometry", &[]),
    ("exchange", &["geometry"]),
    ("sizes", &[]),
    ("airy", &[]),
    ("mie", &[]),
    ("dropfield", &["vdb", "sizes"]),
    ("droplets", &["dropfield", "sizes"]),
    ("scatter", &["airy", "mie", "sizes", "exchange"]),
    ("atmosphere", &["geometry", "exchange"]),
    ("render", &["dropfield", "geometry", "exchange", "sizes"]),
    ("photo", &["geometry", "exchange"]),
    ("ice", &["geometry"]),
    (
        "scene",
        &[
            "geometry",
            "exchange",
            "sizes",
            "dropfield",
            "droplets",
            "airy",
            "scatter",
            "atmosphere",
            "render",
            "ice",
        ],
    ),
    (
        "picture",
        &[
            "geometry",
            "vdb",
            "exchange",
            "dropfield",
            "droplets",
            "airy",
            "scatter",
            "atmosphere",
            "render",
            "photo",
            "scene",
        ],
    ),
];

/// What no library may link: argument parsing, progress bars and temporary files belong to the
/// program.
const PROGRAM_ONLY: [&str; 4] = ["clap", "indicatif", "tempfile", "ctrlc"];

fn dependencies(manifest: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(manifest).expect("every crate has a manifest");
    let manifest: toml::Table = text.parse().expect("manifests are valid TOML");
    let table = manifest.get("dependencies").and_then(toml::Value::as_table);
    table
        .map(|table| table.keys().cloned().collect())
        .unwrap_or_default()
}

fn crates() -> BTreeMap<String, BTreeSet<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let entries = fs::read_dir(folder).expect("the workspace has a folder of crates");
    entries
        .map(|entry| {
            let entry = entry.expect("the folder can be read");
            let name = entry
                .file_name()
                .into_string()
                .expect("crate names are ASCII");
            (name, dependencies(&entry.path().join("Cargo.toml")))
        })
        .collect()
}

#[test]
fn only_the_arrows_of_the_architecture_exist() {
    let allowed: BTreeMap<&str, &[&str]> = ARROWS.into_iter().collect();
    for (name, dependencies) in crates() {
        let seen = allowed.get(name.as_str()).unwrap_or_else(|| {
            panic!("crate {name} is not in the table of arrows: add it here and to ARCHITECTURE.md")
        });
        for dependency in &dependencies {
            let Some(ours) = dependency.strip_prefix("niji-") else {
                continue;
            };
            let is_radiometry = ours == "radiometry" && !["vdb", "radiometry"].contains(&&*name);
            assert!(
                is_radiometry || seen.contains(&ours),
                "crate {name} must not depend on {ours} (ARCHITECTURE.md, crates and arrows)"
            );
        }
    }
}

#[test]
fn libraries_know_nothing_of_the_program() {
    for (name, dependencies) in crates() {
        for forbidden in PROGRAM_ONLY {
            assert!(
                !dependencies.contains(forbidden),
                "crate {name} must not link {forbidden}"
            );
        }
        let source = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("crates")
            .join(&name)
            .join("src");
        for file in rust_files(&source) {
            let text = fs::read_to_string(&file).expect("sources are UTF-8");
            // Examples in comments may print.
            let code = text
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"));
            let text = code.collect::<Vec<_>>().join("\n");
            for word in [
                "println!",
                "eprintln!",
                "std::env::",
                "Instant::now",
                "SystemTime",
            ] {
                assert!(!text.contains(word), "{} uses {word}", file.display());
            }
        }
    }
}

#[test]
fn an_effect_that_the_renderer_obeys_is_named_by_its_row_and_its_bound() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = rust_files(&root.join("crates/scene/src"));
    files.extend(rust_files(&root.join("tools")));
    for effect in [
        "DropExtinction",
        "SkylitDrops",
        "SunlightThroughAir",
        "AirExtinction",
        "Sky",
    ] {
        let is_named = |file: &&std::path::PathBuf| {
            let text = fs::read_to_string(file).expect("sources are UTF-8");
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let code = code.lines().filter(|it| !it.trim_start().starts_with("//"));
            let mut words =
                code.flat_map(|it| it.split(|c: char| !c.is_alphanumeric() && c != ':'));
            words.any(|word| word == format!("Effect::{effect}"))
        };
        let named: BTreeSet<_> = files.iter().filter(is_named).collect();
        let expected =
            ["effect_rows.rs", "plan/bounds.rs"].map(|it| root.join("crates/scene/src").join(it));
        assert!(named.into_iter().eq(&expected), "{effect}");
    }
}

fn rust_files(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a crate has a source folder") {
        let path = entry.expect("the folder can be read").path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}
