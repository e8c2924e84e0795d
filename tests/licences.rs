//! Crates of others: their licences and sources are those that `deny.toml` allows, no version was taken back, and
//! `THIRD_PARTY.md` lists what the program is built from.
//!
//! The list that it should be is written to `target/THIRD_PARTY.md`.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;
use support::repository;

/// The platform of the package; other platforms have a few crates more.
const PLATFORM: &str = "x86_64-unknown-linux-gnu";
const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";
const HEAD: &str = "# Crates of others\n\n\
    What the program for Linux is built from, beside the crates of this repository, which are MIT or Apache-2.0.\n\
    `cargo test --test licences` writes this list to `target/THIRD_PARTY.md` and holds it to this file.\n\n\
    | crate | version | licence |\n|---|---|---|\n";

/// What cargo says of all crates that are built here.
fn metadata() -> Value {
    let cargo = std::env::var_os("CARGO").unwrap_or("cargo".into());
    let arguments = [
        "metadata",
        "--locked",
        "--format-version=1",
        "--filter-platform",
        PLATFORM,
    ];
    let output = Command::new(cargo)
        .current_dir(repository(""))
        .args(arguments)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The crates of others by their identity.
fn foreign(metadata: &Value) -> BTreeMap<&str, &Value> {
    let packages = metadata["packages"].as_array().unwrap().iter();
    let foreign = packages.filter(|package| !package["source"].is_null());
    foreign
        .map(|package| (text(&package["id"]), package))
        .collect()
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Whether an SPDX expression holds with the licences that are allowed.
fn is_allowed(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let expression = expression.trim();
    for (word, is_enough) in [(" AND ", false), (" OR ", true), ("/", true)] {
        let parts = split_outside(expression, word);
        if parts.len() > 1 {
            let mut parts = parts.into_iter();
            return if is_enough {
                parts.any(|part| is_allowed(part, allowed))
            } else {
                parts.all(|part| is_allowed(part, allowed))
            };
        }
    }
    let inner = expression
        .strip_prefix('(')
        .and_then(|it| it.strip_suffix(')'));
    inner.map_or_else(
        || allowed.contains(expression),
        |inner| is_allowed(inner, allowed),
    )
}

/// The parts of an expression between a word, where it stands in no parentheses.
fn split_outside<'a>(expression: &'a str, word: &str) -> Vec<&'a str> {
    let (mut parts, mut start) = (Vec::new(), 0);
    for (at, found) in expression.match_indices(word) {
        let before = &expression[..at];
        if before.matches('(').count() == before.matches(')').count() {
            parts.push(&expression[start..at]);
            start = at + found.len();
        }
    }
    parts.push(&expression[start..]);
    parts
}

fn allowed() -> BTreeSet<String> {
    let deny: toml::Table = fs::read_to_string(repository("deny.toml"))
        .unwrap()
        .parse()
        .unwrap();
    let allowed = deny["licenses"]["allow"].as_array().unwrap().iter();
    allowed
        .map(|licence| licence.as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn expressions_of_licences_hold_where_enough_of_them_is_allowed() {
    let allowed = ["MIT", "Zlib"].map(str::to_owned).into();
    for (expression, expected) in [
        ("MIT", true),
        ("GPL-3.0", false),
        ("GPL-3.0 OR MIT", true),
        ("GPL-3.0/MIT", true),
        ("MIT AND GPL-3.0", false),
        ("(GPL-3.0 OR MIT) AND Zlib", true),
        ("(GPL-3.0 OR MIT) AND (GPL-3.0)", false),
        ("GPL-3.0 OR (MIT AND Zlib)", true),
        ("MIT WITH LLVM-exception", false),
        ("", false),
    ] {
        assert_eq!(is_allowed(expression, &allowed), expected, "{expression}");
    }
}

#[test]
fn every_crate_of_others_has_an_allowed_licence() {
    let (metadata, allowed) = (metadata(), allowed());
    let foreign = foreign(&metadata);
    assert!(foreign.len() > 50, "{}", foreign.len());
    for (id, package) in foreign {
        let licence = text(&package["license"]);
        assert!(
            is_allowed(licence, &allowed),
            "{id} has the licence {licence:?}"
        );
    }
}

#[test]
fn every_crate_of_others_comes_from_the_registry_and_was_not_taken_back() {
    let lock: toml::Table = fs::read_to_string(repository("Cargo.lock"))
        .unwrap()
        .parse()
        .unwrap();
    let mut n_known = 0;
    for package in lock["package"].as_array().unwrap() {
        let Some(source) = package.get("source").and_then(toml::Value::as_str) else {
            continue;
        };
        let [name, version] = ["name", "version"].map(|key| package[key].as_str().unwrap());
        assert_eq!(source, REGISTRY, "{name}");
        assert!(package.get("checksum").is_some(), "{name}");
        let is_yanked = is_yanked(name, version);
        assert_ne!(is_yanked, Some(true), "{name} {version} was taken back");
        n_known += u32::from(is_yanked.is_some());
    }
    // What cargo has looked up itself; nothing is where it keeps an index of another kind.
    println!("known of {n_known} crates");
}

/// Whether a version was taken back, by what cargo keeps of the registry's index.
fn is_yanked(name: &str, version: &str) -> Option<bool> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")))?;
    let folder = match name.len() {
        1 => "1".to_owned(),
        2 => "2".to_owned(),
        3 => format!("3/{}", &name[..1]),
        _ => format!("{}/{}", &name[..2], &name[2..4]),
    };
    let indices = fs::read_dir(home.join("registry/index")).ok()?;
    let files = indices.map(|index| {
        index
            .unwrap()
            .path()
            .join(".cache")
            .join(&folder)
            .join(name)
    });
    let found = files.filter_map(|file| fs::read(file).ok());
    let versions = found.flat_map(|bytes| {
        let lines = bytes.split(|byte| *byte == 0);
        lines
            .filter_map(|line| serde_json::from_slice(line).ok())
            .collect::<Vec<Value>>()
    });
    let mut versions = versions.filter(|it| text(&it["vers"]) == version);
    versions.next()?["yanked"].as_bool()
}

#[test]
fn the_list_of_crates_of_others_is_up_to_date() {
    let metadata = metadata();
    let foreign = foreign(&metadata);
    let nodes = metadata["resolve"]["nodes"].as_array().unwrap().iter();
    let nodes: BTreeMap<&str, &Value> = nodes.map(|node| (text(&node["id"]), node)).collect();
    // What the program needs, but not its tests.
    let (mut needed, mut next) = (BTreeSet::new(), Vec::new());
    next.extend(nodes.keys().find(|id| id.contains("#niji@")));
    while let Some(id) = next.pop() {
        if !needed.insert(id) {
            continue;
        }
        let is_needed = |link: &&Value| {
            let kinds = link["dep_kinds"].as_array().unwrap();
            kinds.iter().any(|kind| text(&kind["kind"]) != "dev")
        };
        let links = nodes[id]["deps"].as_array().unwrap().iter();
        next.extend(links.filter(is_needed).map(|link| text(&link["pkg"])));
    }
    let mut list = HEAD.to_owned();
    let packages = needed.iter().filter_map(|id| foreign.get(id));
    let mut rows: Vec<_> = packages
        .map(|package| ["name", "version", "license"].map(|key| text(&package[key])))
        .collect();
    rows.sort_unstable();
    for [name, version, licence] in rows {
        writeln!(
            list,
            "| [{name}](https://crates.io/crates/{name}) | {version} | {licence} |"
        )
        .unwrap();
    }
    let made = repository("target/THIRD_PARTY.md");
    fs::write(made, &list).unwrap();
    let found = fs::read_to_string(repository("THIRD_PARTY.md")).unwrap_or_default();
    assert!(found == list, "cp target/THIRD_PARTY.md THIRD_PARTY.md");
}
