//! `niji completions` and `niji man`: what a shell wants to know about the program.

use std::path::PathBuf;

use clap::Args;
use clap::CommandFactory;
use clap_complete::Shell;

use crate::cli::Arguments;
use crate::failure::Failure;
use crate::output;
use crate::output::Existing;

/// Completions for a shell, on standard output.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  niji completions bash > ~/.local/share/bash-completion/completions/niji"
)]
pub(crate) struct CompletionsCommand {
    /// The shell.
    shell: Shell,
}

/// Manual pages, one for each subcommand and each of theirs, into a folder.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  niji man -o man1 && man -l man1/niji-run.1")]
pub(crate) struct ManCommand {
    /// The folder to write to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Prints completions.
///
/// # Errors
/// As [`output::print`].
pub(crate) fn completions(command: &CompletionsCommand) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(command.shell, &mut Arguments::command(), "niji", &mut text);
    output::print(&String::from_utf8_lossy(&text))
}

/// Writes manual pages.
///
/// # Errors
/// [`Failure::Failed`] if the folder cannot be written.
pub(crate) fn man(command: &ManCommand) -> Result<(), Failure> {
    let mut program = Arguments::command();
    program.build();
    write_pages(command, &program, "niji")
}

/// The page of a command, and those of its subcommands.
fn write_pages(command: &ManCommand, page: &clap::Command, name: &str) -> Result<(), Failure> {
    let path = command.output.join(format!("{name}.1"));
    output::check_free(&path, Existing::Replace)?;
    output::write_file(&path, |writer| {
        clap_mangen::Man::new(page.clone()).render(writer)
    })?;
    page.get_subcommands().try_for_each(|subcommand| {
        let name = format!("{name}-{}", subcommand.get_name());
        write_pages(command, subcommand, &name)
    })
}
