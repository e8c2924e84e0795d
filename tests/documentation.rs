//! The documentation is true: what it says to type runs, what it links to is there.
//!
//! Blocks marked `sh` in README.md and docs/tutorial.md are the scripts that a reader would type. They
//! run here as they stand, one after the other, in a folder with a copy of the repository's data in
//! which the pictures are smaller. Examples of `--help` must be commands that their own subcommand
//! understands.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;

use support::niji;
use support::niji_ends_with;
use support::repository;

/// Lines that take too long, need the network, or are run by another test: how they begin, and why.
const NOT_RUN: [(&str, &str); 4] = [
    ("cargo run", "what this test runs was built by cargo"),
    ("cargo test", "this is a test"),
    ("niji calibrate", "minutes on purpose"),
    (
        "niji sweep",
        "dozens of pictures; tests/sweep.rs sweeps a small one",
    ),
];

/// What takes time without saying more about a command: text of the documentation, and what runs
/// instead.
const SMALLER: [(&str, &str); 5] = [
    ("width_px = 300\n", "width_px = 60\n"),
    ("height_px = 200\n", "height_px = 40\n"),
    (
        "[picture]\n",
        "[spectrum]\nfirst_nm = 420.0\nstep_nm = 70.0\nn_wavelengths = 5\n[picture]\n",
    ),
    // Lorenz-Mie is the dearest theory.
    (
        "--compare airy,uniform,mie",
        "--compare airy,debye --theta-deg 135,145",
    ),
    ("niji lee", "niji lee --size-px 48,32"),
];

/// Width of the pictures of the shipped scenes here, pixels.
const WIDTH_PX: i64 = 64;

/// Pages whose links are followed.
const PAGES: [&str; 15] = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "data/README.md",
    "data/photos/README.md",
    "docs/tutorial.md",
    "docs/blender.md",
    "docs/farm.md",
    "docs/houdini.md",
    "docs/nuke.md",
    "docs/photo.md",
    "docs/speed.md",
    "docs/upstream/README.md",
    "docs/view.md",
    "fuzz/README.md",
];

/// Subcommands that have subcommands of their own.
const NESTED: [&str; 2] = ["drops", "eval"];

fn page(name: &str) -> String {
    fs::read_to_string(repository(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The fenced blocks of a page that are marked as `language`.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let parts = page.split(&fence).skip(1);
    parts
        .map(|rest| rest.split("```").next().unwrap().to_owned())
        .collect()
}

/// Lines of a script with those joined that end in a backslash.
fn joined(script: &str) -> String {
    script.replace("\\\n", " ")
}

/// A script without the lines of [`NOT_RUN`], smaller by [`SMALLER`].
fn quick(script: &str) -> String {
    let smaller = |script: String, (from, to): &(&str, &str)| script.replace(from, to);
    let script = SMALLER.iter().fold(joined(script), smaller);
    let is_run = |line: &&str| !NOT_RUN.iter().any(|(start, _)| line.starts_with(start));
    let lines: Vec<&str> = script.lines().filter(is_run).collect();
    format!("set -eu\n{}\n", lines.join("\n"))
}

/// A folder like the root of the repository: the program on its path, the data in it, small.
struct Workplace {
    folder: tempfile::TempDir,
}

impl Workplace {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        fs::create_dir_all(root.join("data/scenes")).unwrap();
        fs::create_dir(root.join("bin")).unwrap();
        symlink(env!("CARGO_BIN_EXE_niji"), root.join("bin/niji")).unwrap();
        for beside in ["data/photos", "data/heights", "data/meshes"] {
            symlink(repository(beside), root.join(beside)).unwrap();
        }
        for entry in fs::read_dir(repository("data/scenes")).unwrap() {
            let path = entry.unwrap().path();
            let scene = small_scene(&fs::read_to_string(&path).unwrap());
            fs::write(
                root.join("data/scenes").join(path.file_name().unwrap()),
                scene,
            )
            .unwrap();
        }
        Self { folder }
    }

    fn run(&self, page: &str, script: &str) {
        let path = std::env::var("PATH").unwrap();
        let bin = self.folder.path().join("bin");
        let output = Command::new("sh")
            .args(["-c", script])
            .current_dir(self.folder.path())
            .env("PATH", format!("{}:{path}", bin.display()))
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{page}:\n{script}\n{message}");
    }
}

/// A shipped scene with a small picture of few wavelengths at the cheapest levels.
fn small_scene(text: &str) -> String {
    let mut scene: toml::Table = text.parse().unwrap();
    let camera = scene["camera"].as_table_mut().unwrap();
    let [width, height] = ["width_px", "height_px"].map(|key| camera[key].as_integer().unwrap());
    let small_height = (height * WIDTH_PX + width / 2) / width;
    camera.insert("width_px".to_owned(), WIDTH_PX.into());
    camera.insert("height_px".to_owned(), small_height.into());
    let section = |scene: &mut toml::Table, name: &str, text: &str| {
        let keys: toml::Table = text.parse().unwrap();
        let entry = scene
            .entry(name)
            .or_insert_with(|| toml::Table::new().into());
        entry.as_table_mut().unwrap().extend(keys);
    };
    if scene.contains_key("ice") {
        let paths =
            "transport = { level = 'path-traced', paths_per_pixel = 2, wavelengths = 'all' }";
        section(&mut scene, "accuracy", paths);
    } else {
        section(
            &mut scene,
            "accuracy",
            "preset = 'draft'\ntable_relative_error = 0.02",
        );
        let spectrum = "first_nm = 420.0\nstep_nm = 70.0\nn_wavelengths = 5";
        section(&mut scene, "spectrum", spectrum);
    }
    scene.to_string()
}

#[test]
fn every_command_of_the_tutorial_runs_in_order() {
    let script = blocks(&page("docs/tutorial.md"), "sh").concat();
    assert!(
        script.lines().count() > 40,
        "the tutorial has lost its blocks"
    );
    Workplace::new().run("docs/tutorial.md", &quick(&script));
}

#[test]
fn every_command_of_the_readme_runs_in_order() {
    let script = blocks(&page("README.md"), "sh").concat();
    assert!(
        script.contains("niji run"),
        "the README has lost its blocks"
    );
    Workplace::new().run("README.md", &quick(&script));
}

#[test]
fn a_line_that_is_not_run_is_still_a_command_that_is_understood() {
    for name in ["README.md", "docs/tutorial.md"] {
        for block in blocks(&page(name), "sh") {
            for line in joined(&block)
                .lines()
                .filter(|line| line.starts_with("niji"))
            {
                understood(name, line);
            }
        }
    }
}

#[test]
fn recipes_for_other_programs_use_commands_that_are_understood() {
    for name in [
        "docs/blender.md",
        "docs/farm.md",
        "docs/houdini.md",
        "docs/nuke.md",
        "docs/photo.md",
        "docs/view.md",
    ] {
        let texts = blocks(&page(name), "text").concat();
        let script = joined(&texts);
        let lines = script.lines().filter(|line| line.starts_with("niji"));
        assert!(
            lines.map(|line| understood(name, line)).count() > 0,
            "{name}"
        );
    }
}

/// Those of README.md cannot be compiled: what they leave out is hidden in the documentation of the crate.
#[test]
fn lines_of_rust_in_the_readme_are_run_in_the_documentation_of_the_library() {
    let run = page("crates/picture/src/lib.rs");
    let run: BTreeSet<&str> = run
        .lines()
        .filter_map(|line| line.strip_prefix("//! "))
        .collect();
    let blocks = blocks(&page("README.md"), "rust");
    assert!(!blocks.is_empty());
    for line in blocks.iter().flat_map(|block| block.lines()) {
        let code = line.split(" // ").next().unwrap_or(line);
        assert!(run.contains(code), "{line}");
    }
}

#[test]
fn scenes_in_the_documentation_are_toml() {
    for name in PAGES {
        for block in blocks(&page(name), "toml") {
            let parsed: Result<toml::Table, _> = block.parse();
            assert!(parsed.is_ok(), "{name}:\n{block}\n{parsed:?}");
        }
    }
}

#[test]
fn every_subcommand_has_an_example_that_it_understands() {
    let nested = NESTED.iter().flat_map(|&parent| {
        let children = subcommands(&[parent]);
        children
            .into_iter()
            .map(move |child| vec![parent.to_owned(), child])
    });
    let top = subcommands(&[]).into_iter().map(|name| vec![name]);
    for command in top.chain(nested) {
        let words: Vec<&str> = command.iter().map(String::as_str).collect();
        let help = help(&words);
        let (_, examples) = help
            .split_once("\nExample")
            .unwrap_or_else(|| panic!("niji {} --help has no example", words.join(" ")));
        let examples = joined(examples);
        let start = format!("niji {}", words.join(" "));
        let lines = examples.lines().map(str::trim);
        let own: Vec<&str> = lines
            .clone()
            .filter(|line| line.starts_with("niji "))
            .collect();
        assert!(
            own.iter().any(|line| line.starts_with(&start)),
            "the examples of {start} are of other commands: {own:?}"
        );
        for line in own {
            understood(&start, line);
        }
    }
}

#[test]
fn every_manual_page_that_is_referred_to_is_written() {
    let folder = tempfile::tempdir().unwrap();
    niji_ends_with(0, &["man", "-o", folder.path().to_str().unwrap()]);
    let pages = fs::read_dir(folder.path()).unwrap();
    let pages: Vec<PathBuf> = pages.map(|entry| entry.unwrap().path()).collect();
    assert!(pages.len() > 30, "{} pages", pages.len());
    for path in pages {
        let text = fs::read_to_string(&path).unwrap().replace('\\', "");
        let references = text.lines().filter_map(|line| line.strip_suffix("(1)"));
        for name in references.filter(|name| name.starts_with("niji-")) {
            let referred = folder.path().join(format!("{name}.1"));
            assert!(referred.exists(), "{} refers to {name}", path.display());
        }
    }
}

#[test]
fn every_shell_has_completions_that_know_every_subcommand() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = niji_ends_with(0, &["completions", shell]);
        let script = String::from_utf8(output.stdout).unwrap();
        for name in subcommands(&[]) {
            assert!(script.contains(&name), "{shell} does not know {name}");
        }
    }
}

/// The help of a subcommand, on lines long enough that no example is broken.
fn help(words: &[&str]) -> String {
    let arguments = [words, &["--help"]].concat();
    String::from_utf8(niji_ends_with(0, &arguments).stdout).unwrap()
}

/// The subcommands that a help lists: lines of two words' indentation under a heading.
fn subcommands(of: &[&str]) -> Vec<String> {
    let help = help(of);
    let (list, _) = help.split_once("Options:").unwrap();
    let lines = list.lines().filter(|line| {
        let indented = line.strip_prefix("  ");
        indented.is_some_and(|rest| rest.starts_with(|first: char| first.is_ascii_lowercase()))
    });
    let names: Vec<String> = lines
        .map(|line| line.split_whitespace().next().unwrap().to_owned())
        .collect();
    assert!(!names.is_empty(), "{of:?} lists no subcommands");
    names
}

/// Fails unless every subcommand and flag of a line is one of the program's.
fn understood(place: &str, line: &str) {
    let line = line.split(['>', '|', ';']).next().unwrap();
    let line = line.split(" && ").next().unwrap();
    let words: Vec<&str> = line.split_whitespace().skip(1).collect();
    let depth = match words.first() {
        Some(first) if first.starts_with('-') => 0,
        Some(first) if NESTED.contains(first) && !words[1].starts_with('-') => 2,
        _ => 1,
    };
    let command = &words[..depth];
    let printed = niji(&[command, &["--help"]].concat());
    assert!(printed.status.success(), "{place}: {line}: no such command");
    let help = String::from_utf8(printed.stdout).unwrap();
    let known: BTreeSet<&str> = help
        .split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'))
        .filter(|word| word.starts_with('-'))
        .collect();
    for word in &words[depth..] {
        let flag = word.split('=').next().unwrap();
        let is_flag = flag.starts_with("--") || (flag.len() == 2 && flag.starts_with('-'));
        let is_number = flag[1.min(flag.len())..].starts_with(|c: char| c.is_ascii_digit());
        if is_flag && !is_number {
            assert!(known.contains(flag), "{place}: {line}: no flag {flag}");
        }
    }
}

/// Targets of the links and pictures of a page that are files.
fn linked_files(page: &str) -> Vec<String> {
    let targets = page.split("](").skip(1);
    let targets = targets.filter_map(|rest| rest.split([')', '#', ' ']).next());
    let in_html = page
        .split("src=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next());
    targets
        .chain(in_html)
        .filter(|target| !target.is_empty() && !target.contains("://"))
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_link_leads_to_a_file() {
    for name in PAGES {
        let folder = Path::new(name).parent().unwrap();
        for target in linked_files(&page(name)) {
            let path: PathBuf = repository("").join(folder).join(&target);
            assert!(
                path.exists(),
                "{name} links to {target}, which is not there"
            );
        }
    }
}

#[test]
fn every_page_of_the_docs_is_checked_and_every_picture_is_shown() {
    let texts: String = PAGES.iter().map(|name| page(name)).collect();
    for entry in fs::read_dir(repository("docs")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let is_page = path.extension().is_some_and(|extension| extension == "md");
        let is_known = if is_page {
            PAGES.contains(&format!("docs/{name}").as_str())
        } else {
            texts.contains(name)
        };
        assert!(is_known, "docs/{name} is linked from no page");
    }
}
