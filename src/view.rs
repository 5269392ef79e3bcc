//! `throng view`: starts the viewer, an executable of its own beside this one.

use crate::args::{Outcome, fail};
use std::process::Command;

/// Start the viewer.
#[derive(clap::Args)]
pub struct Args {
    /// What the viewer is to show.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    rest: Vec<String>,
}

pub fn run(args: &Args) -> Outcome {
    let here = std::env::current_exe()?;
    let viewer = here.with_file_name(format!("throng-viewer{}", std::env::consts::EXE_SUFFIX));
    if !viewer.is_file() {
        return fail("the viewer is not built; `cargo build --release -p throng-viewer` builds it");
    }
    match Command::new(&viewer).args(&args.rest).status()? {
        s if s.success() => Ok(()),
        s => fail(format!("the viewer ended with {s}")),
    }
}
