//! `throng query`: what would a character do, and which way would it go?

mod action;
mod path;

use crate::args::Outcome;
use crate::renamed;
use std::ffi::OsString;

/// Ask a policy for an action, or plan a path through a world.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Action(action::Args),
    Path(path::Args),
    /// What once was a file.
    #[command(external_subcommand)]
    Other(Vec<OsString>),
}

pub fn run(args: &Args) -> Outcome {
    match &args.what {
        What::Action(a) => action::run(a),
        What::Path(a) => path::run(a),
        What::Other(words) => {
            let new = [(".throng", "action"), (".toml", "path")];
            renamed::refuse_form("query", words, &new, "action BUNDLE and path WORLD")
        }
    }
}
