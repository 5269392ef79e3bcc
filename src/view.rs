//! `throng view`: starts the viewer, an executable of its own beside this one.

use crate::args::{CommandResult, fail};
use crate::output;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{ffi::OsString, io::Write};
use throng_core::base::error::ensure;

/// Command that builds the viewer beside this executable, in the same profile.
const HOW_TO_BUILD: &str = if cfg!(debug_assertions) {
    "`cargo build -p throng-viewer` builds it"
} else {
    "`cargo build --release -p throng-viewer` builds it"
};

/// Open the viewer: on its start page, or on a bundle, a scene, a motion file, or a folder or archive of motion, which is
/// built first, into the cache: `throng view FILE`.
///
/// The viewer is an executable of its own beside this one; `cargo build --release -p throng-viewer` builds it. All
/// arguments are handed on to it. Where it is built, `throng view --help` prints its own help.
#[derive(clap::Args)]
#[command(disable_help_flag = true)]
pub struct Args {
    /// Arguments of the viewer.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    rest: Vec<OsString>,
}

/// Starts the viewer; returns its exit code.
pub fn run(args: &Args) -> CommandResult<ExitCode> {
    let viewer = executable();
    if viewer.is_err() && args.rest.iter().any(|a| a == "--help" || a == "-h") {
        let help = format!(
            "Open the viewer on a bundle or a motion file\n\nUsage: throng view [FILE] [OPTIONS]\n\n\
             The viewer, which knows the options, is not built; {HOW_TO_BUILD}.\n"
        );
        std::io::stdout().write_all(help.as_bytes())?;
        return Ok(ExitCode::SUCCESS);
    }
    start(&viewer?, args)
}

/// Prints the JSON keys of the viewer, which stand in its own help.
pub fn print_json_keys() -> CommandResult {
    let viewer = executable()?;
    let out = Command::new(&viewer).arg("--help").output().map_err(|e| format!("{}: {e}", viewer.display()))?;
    ensure(out.status.success(), || format!("the viewer ended unexpectedly: {}", out.status))?;
    let help = String::from_utf8_lossy(&out.stdout);
    let keys = help.split("\n\n").find(|part| part.starts_with("JSON keys")).unwrap_or(&help);
    output::text(format!("{keys}\n"))
}

/// Path of the viewer, which lies beside this executable.
fn executable() -> CommandResult<PathBuf> {
    let viewer = std::env::current_exe()?.with_file_name(format!("throng-viewer{}", std::env::consts::EXE_SUFFIX));
    if viewer.is_file() { Ok(viewer) } else { fail(format!("the viewer is not built; {HOW_TO_BUILD}")) }
}

fn start(viewer: &Path, args: &Args) -> CommandResult<ExitCode> {
    let status = Command::new(viewer).args(&args.rest).status().map_err(|e| format!("{}: {e}", viewer.display()))?;
    match status.code() {
        Some(code) => Ok(ExitCode::from(u8::try_from(code).unwrap_or(1))),
        None => Err(format!("the viewer ended unexpectedly: {status}").into()),
    }
}
