//! The `niji` program as a library: arguments, files and printing around the library crates.
//!
//! One folder or file for each subcommand; `stages` holds what `niji run` and the stage commands
//! share, so that a chain by hand gives the same bytes as a run.

mod airy;
mod atmosphere;
mod bow_curves;
mod bow_place;
mod calibrate;
mod check;
mod checksums;
mod choice_file;
mod cli;
mod composite;
mod depth;
mod diff;
mod drops;
mod eval;
mod failure;
mod farm;
mod flags;
mod frame_list;
mod ice;
mod info;
mod kept_choices;
mod lee;
mod measure_effects;
mod merge;
mod output;
mod peak_memory;
mod photo;
mod photo_source;
mod plan;
mod plan_preview;
mod plan_seconds;
mod plot;
mod progress;
mod render;
mod run;
mod scatter;
mod scene_file;
mod schema;
mod schema_flags;
mod selftest;
mod sequence_file;
mod sequence_frames;
mod shell;
mod shell_word;
mod stages;
mod sun;
mod sweep;
mod text_file;
mod theory_name;
mod timed_run;
mod view;
mod water_flags;

use std::ffi::OsString;
use std::io::Write;
use std::panic::Location;
use std::process::ExitCode;

use clap::Parser;
use niji_radiometry::set_memory_limit;

use crate::cli::Arguments;
use crate::cli::Command;
use crate::failure::Failure;

/// Version of the program, and what it was built from.
pub(crate) fn version() -> &'static str {
    // In one piece: a test changes it in the program as other sources would.
    std::hint::black_box(env!("NIJI_VERSION"))
}

/// Runs the program with a command line (its own name first) and returns its exit code.
pub fn main_with(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    output::remove_unfinished_on_interrupt();
    hush_decoders();
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            let printed = error.print().and_then(|()| std::io::stdout().flush());
            // Help is a result, a message about usage is not.
            if let (Err(lost), false) = (output::printed(printed), error.use_stderr()) {
                output::say(format_args!("error: {lost}"));
                return lost.exit_code();
            }
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    match dispatch(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::say(format_args!("error: {failure}"));
            failure.exit_code()
        }
    }
}

/// Says nothing where a foreign decoder panics: that is damage of its file, which is said by the reader.
fn hush_decoders() {
    const DECODERS: [&str; 5] = ["/exr-", "/image-", "/png-", "/zune-", "/half-"];
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        let file = info.location().map_or("", Location::file);
        if !DECODERS.iter().any(|name| file.contains(name)) {
            usual(info);
        }
    }));
}

fn dispatch(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    if let Some(n_threads) = common.threads {
        // A pool that exists already (in tests) has taken its size; results do not depend on it.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads)
            .build_global();
    }
    if let Some(limit) = common.memory {
        // One that was set already (in tests) stays.
        let _ = set_memory_limit(limit);
    }
    match &arguments.command {
        Command::Run(command) => run::execute(command, common),
        Command::View(command) => view::execute(command, common),
        Command::Plan(command) => plan::execute(command, common),
        Command::Farm(command) => farm::execute(command, common),
        Command::Sweep(command) => sweep::execute(command, common),
        Command::Calibrate(command) => calibrate::execute(command, common),
        Command::Drops(command) => drops::execute(command, common),
        Command::Airy(command) => airy::execute(command, common),
        Command::Scatter(command) => scatter::execute(command, common),
        Command::Atmosphere(command) => atmosphere::execute(command, common),
        Command::Render(command) => render::execute(command, common),
        Command::Merge(command) => merge::execute(command, common),
        Command::Photo(command) => photo::execute(command, common),
        Command::Depth(command) => depth::execute(command, common),
        Command::Sun(command) => sun::execute(command, common),
        Command::Check(command) => check::execute(command, common),
        Command::Composite(command) => composite::execute(command, common),
        Command::Ice(command) => ice::execute(command, common),
        Command::Diff(command) => diff::execute(command, common),
        Command::Info(command) => info::execute(command, common),
        Command::Lee(command) => lee::execute(command, common),
        Command::Eval(command) => eval::execute(command, common),
        Command::Selftest(command) => selftest::execute(command, common),
        Command::Completions(command) => shell::completions(command),
        Command::Man(command) => shell::man(command),
        Command::Schema(command) => schema::execute(command),
    }
}
