//! The stages, as `niji run` and the stage commands share them.
//!
//! A stage is a function from settings and input files to output files. What it makes depends on
//! nothing else, so a chain by hand gives the bytes of a run, and a file that was made for this request and is
//! unchanged is kept.

pub(crate) mod accuracy;
pub(crate) mod airy;
pub(crate) mod assembly;
pub(crate) mod atmosphere;
pub(crate) mod drops;
pub(crate) mod given_table;
pub(crate) mod other_scene;
pub(crate) mod photo;
pub(crate) mod render;
pub(crate) mod saved_rows;
pub(crate) mod scatter;
pub(crate) mod shown;
pub(crate) mod sky;
pub(crate) mod tile;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Instant;

use niji_exchange::Provenance;
use niji_exchange::read_provenance;
use niji_geometry::files_beside_mesh;
use niji_render::Spent;
use niji_vdb::VdbHeader;
use serde::Deserialize;
use serde::Serialize;

use crate::checksums;
use crate::checksums::hash_once;
use crate::failure::Failure;
use crate::output;
use crate::output::Existing;
use crate::progress::Verbosity;
use crate::version;

/// How a stage is run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StageOptions {
    /// What to do with outputs that exist.
    pub existing: Existing,
    /// Whether outputs that look unchanged are read all the same.
    pub verifies: bool,
    /// How much to say.
    pub verbosity: Verbosity,
}

/// What a stage did.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Done {
    /// Name of the stage.
    pub stage: &'static str,
    /// The files it stands for, the main one first.
    pub files: Vec<String>,
    /// Did its files fit already?
    pub up_to_date: bool,
    /// Time it took in seconds.
    pub seconds: f64,
    /// Of these, those for the light that drops scatter more than once, where it is no picture.
    #[serde(skip)]
    pub further_orders_s: f64,
    /// What went into a picture that was made in one go.
    #[serde(skip)]
    pub spent: Option<Spent>,
    /// Stops by which a camera would show a picture brighter, where its preview was made and nobody said an exposure.
    #[serde(skip)]
    pub usual_stops: Option<f64>,
}

/// Seconds of stages together.
pub(crate) fn seconds_of(done: &[Done]) -> f64 {
    done.iter().map(|it| it.seconds).sum()
}

/// What a stage is asked for.
pub(crate) struct Request<'a> {
    pub(crate) stage: &'static str,
    /// Effective settings as canonical JSON.
    pub(crate) settings: String,
    /// Input files by role.
    pub(crate) inputs: Vec<(&'a str, &'a Path)>,
    /// Output files; the first carries the provenance and is written last.
    pub(crate) outputs: Vec<&'a Path>,
}

/// Runs `make` with the provenance of its request, unless the outputs fit the request already.
///
/// # Errors
/// A missing input, an output that exists and is another one, or whatever `make` reports.
pub(crate) fn perform(
    request: &Request,
    options: StageOptions,
    make: impl FnOnce(Provenance) -> Result<(), Failure>,
) -> Result<Done, Failure> {
    let start = Instant::now();
    // Before they are opened: that alone would wait for the other end of a pipe.
    (request.outputs.iter()).try_for_each(|path| output::check_regular(path))?;
    let (made_for, up_to_date) = checked(request, options)?;
    let hash = made_for.request_hash();
    if !up_to_date {
        make(made_for.clone())?;
        // Of inputs that changed meanwhile nobody knows what it was made from.
        if provenance(request)? == made_for {
            (request.outputs.iter()).try_for_each(|path| checksums::note(path, &hash))?;
        }
    }
    let files = request
        .outputs
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let seconds = start.elapsed().as_secs_f64();
    if up_to_date {
        say_up_to_date(request.stage, request.outputs[0], options.verbosity);
    }
    Ok(Done {
        stage: request.stage,
        files,
        up_to_date,
        seconds,
        further_orders_s: 0.0,
        spent: None,
        usual_stops: None,
    })
}

/// Refuses outputs that are taken, before anything is made.
///
/// # Errors
/// As [`perform`].
pub(crate) fn check_free_to_make(request: &Request, options: StageOptions) -> Result<(), Failure> {
    checked(request, options).map(|_| ())
}

/// What outputs are made for, and whether they are up to date; others that are taken are refused.
fn checked(request: &Request, options: StageOptions) -> Result<(Provenance, bool), Failure> {
    let inputs: Vec<&Path> = request.inputs.iter().map(|(_, path)| *path).collect();
    output::check_no_input(&request.outputs, &inputs)?;
    let made_for = provenance(request)?;
    let hash = made_for.request_hash();
    let fits = |path: &&Path| checksums::fits(path, &hash, options.verifies);
    let up_to_date = request.outputs.iter().all(fits);
    if !up_to_date {
        check_free_for(&made_for, &request.outputs, options.existing)?;
    }
    Ok((made_for, up_to_date))
}

/// Says that a stage has nothing to do.
pub(crate) fn say_up_to_date(stage: &str, main: &Path, verbosity: Verbosity) {
    let main = main.display();
    verbosity.say(format_args!("{stage:>11}  {main} is up to date"));
}

/// Refuses outputs that are taken, but by what an interrupted or damaged result of `made_for` left: that is made again.
///
/// # Errors
/// A name for two outputs; a file of something else that may not be replaced.
pub(crate) fn check_free_for(
    made_for: &Provenance,
    outputs: &[&Path],
    existing: Existing,
) -> Result<(), Failure> {
    output::check_distinct(outputs)?;
    let request = made_for.request_hash();
    for path in outputs {
        let is_of_it = || checksums::fits(path, &request, true);
        if stored_provenance(path).as_ref() != Some(made_for) && !is_of_it() {
            check_readable(path, existing)?;
            output::check_free(path, existing)?;
        }
    }
    Ok(())
}

/// What outputs are made for.
///
/// # Errors
/// An input that is missing or cannot be read.
pub(crate) fn provenance(request: &Request) -> Result<Provenance, Failure> {
    let mut inputs = BTreeMap::new();
    for (role, path) in &request.inputs {
        inputs.extend(hashed(role, path)?);
    }
    Ok(Provenance {
        tool: format!("niji {}", request.stage),
        version: version().to_owned(),
        settings: request.settings.clone(),
        inputs,
    })
}

/// Content hashes of an input file and of the files that it names, by role.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn hashed(role: &str, path: &Path) -> Result<Vec<(String, String)>, Failure> {
    let hash = |path: &Path| hash_once(path).map_err(|error| Failure::bad_input(path, error));
    let mut hashes = vec![(role.to_owned(), hash(path)?)];
    let beside = files_beside_mesh(path).map_err(|error| Failure::bad_input(path, error))?;
    for (index, file) in beside.iter().enumerate() {
        hashes.push((format!("{role}.buffer.{index}"), hash(file)?));
    }
    Ok(hashes)
}

/// Is it a drawing or a text, which have no place for a provenance?
fn is_plain(path: &Path) -> bool {
    path.extension().is_some_and(|extension| {
        ["svg", "toml"]
            .iter()
            .any(|plain| extension.eq_ignore_ascii_case(plain))
    })
}

/// Refuses a file that is to be kept and is none: what a copy or a full disk left of one, say.
fn check_readable(path: &Path, existing: Existing) -> Result<(), Failure> {
    if existing == Existing::Replace || !path.is_file() || is_plain(path) {
        return Ok(());
    }
    let Err(message) = provenance_within(path) else {
        return Ok(());
    };
    Err(Failure::Usage(format!(
        "{} exists already, but cannot be read: {message}; remove it if it was cut short or is no \
         result, or replace it with --force",
        path.display()
    )))
}

/// The provenance of a VDB, EXR, PNG or JSON file; `None` where it has none or cannot be read.
pub(crate) fn stored_provenance(path: &Path) -> Option<Provenance> {
    provenance_within(path).ok().flatten()
}

/// As [`stored_provenance`], or why the file cannot be read.
fn provenance_within(path: &Path) -> Result<Option<Provenance>, String> {
    if is_vdb(path) {
        // Without the voxels: a few kilobytes, however large the file is.
        let header = VdbHeader::read(path).map_err(|error| error.to_string())?;
        let texts = header
            .metadata
            .iter()
            .filter_map(|(name, value)| match value {
                niji_vdb::MetaValue::String(text) => Some((name, text.as_str())),
                _ => None,
            });
        return Ok(Provenance::from_text_items(texts));
    }
    if path.extension().is_some_and(|end| end == "json") {
        let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
        let file: Result<JsonFile<serde::de::IgnoredAny>, _> = serde_json::from_str(&text);
        let file = file.map_err(|error| error.to_string())?;
        let items = file.provenance.iter();
        return Ok(Provenance::from_text_items(
            items.map(|(name, text)| (&**name, &**text)),
        ));
    }
    let is_png = path
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("png"));
    if !is_png && let Some(own) = read_provenance(path).map_err(|error| error.to_string())? {
        return Ok(Some(own));
    }
    let foreign = niji_photo::read_picture_provenance(path);
    foreign.map_err(|error| error.to_string())
}

/// A report on disk.
#[derive(Serialize, Deserialize)]
struct JsonFile<T> {
    provenance: BTreeMap<String, String>,
    report: T,
}

/// A report with its provenance, as it stands on disk.
///
/// # Errors
/// [`Failure::Failed`] for a number that JSON cannot hold.
pub(crate) fn json_text(
    provenance: &Provenance,
    report: impl Serialize,
) -> Result<String, Failure> {
    let provenance = provenance.to_text_items().into_iter().collect();
    let text = serde_json::to_string_pretty(&JsonFile { provenance, report });
    let text = text.map_err(|error| Failure::Failed(format!("no JSON: {error}")))?;
    Ok(text + "\n")
}

/// Is it a VDB file by its name?
pub(crate) fn is_vdb(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("vdb"))
}
