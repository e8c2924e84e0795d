//! The `niji` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    niji::main_with(std::env::args_os())
}
