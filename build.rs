//! What the program is built from, as part of its version: results of other sources are not its own.
//!
//! h ← (h xor byte) p mod 2^64, from h = 0xcbf29ce484222325, p = 2^40 + 0x1b3
//! FNV-1a over name and content of every source, in the order of their names. Neither folder, machine, compiler
//! nor time comes into it, so that equal sources share results.
//! [FNV] G. Fowler, L. C. Noll, K.-P. Vo, "The FNV Non-Cryptographic Hash Algorithm", IETF draft.

use std::env;
use std::fs;
use std::path::Path;

fn main() {
    let root = env::var("CARGO_MANIFEST_DIR").expect("cargo says where the sources are");
    let version = env::var("CARGO_PKG_VERSION").expect("cargo says which version it is");
    let root = Path::new(&root);
    for place in places(root) {
        println!("cargo::rerun-if-changed={place}");
    }
    let identity = identity(root);
    println!("cargo::rustc-env=NIJI_VERSION={version}+{identity:016x}");
}

/// The hash of all sources.
pub(crate) fn identity(root: &Path) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for name in sources(root) {
        let content = fs::read(root.join(&name)).expect("sources can be read");
        // Lengths keep neighbors apart.
        for part in [name.as_bytes(), &content] {
            let length = (part.len() as u64).to_le_bytes();
            for byte in length.iter().chain(part) {
                hash = (hash ^ u64::from(*byte)).wrapping_mul((1 << 40) + 0x1b3);
            }
        }
    }
    hash
}

/// Where sources stand: manifests, embedded tables, and folders of code.
fn places(root: &Path) -> Vec<String> {
    let mut places = ["Cargo.toml", "Cargo.lock", "tools"]
        .map(str::to_owned)
        .to_vec();
    let tables = names_in(root, "data").into_iter();
    places.extend(tables.filter(|name| ends_in(name, "csv")));
    for name in names_in(root, "crates") {
        places.extend([format!("{name}/Cargo.toml"), format!("{name}/src")]);
    }
    places.retain(|name| root.join(name).exists());
    places
}

/// Names of all sources, in order.
pub(crate) fn sources(root: &Path) -> Vec<String> {
    let mut names = Vec::new();
    let mut waiting = places(root);
    while let Some(name) = waiting.pop() {
        if root.join(&name).is_dir() {
            let is_code = |it: &String| ends_in(it, "rs") || root.join(it).is_dir();
            waiting.extend(names_in(root, &name).into_iter().filter(is_code));
        } else {
            names.push(name);
        }
    }
    names.sort();
    names
}

/// Names of what stands in a folder, with `/` between folders.
fn names_in(root: &Path, folder: &str) -> Vec<String> {
    let entries = fs::read_dir(root.join(folder))
        .into_iter()
        .flatten()
        .flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    names.map(|name| format!("{folder}/{name}")).collect()
}

fn ends_in(name: &str, extension: &str) -> bool {
    Path::new(name)
        .extension()
        .is_some_and(|it| it == extension)
}
