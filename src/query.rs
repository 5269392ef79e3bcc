//! `throng query`: the action of a policy, and paths through a world.

mod action;
mod path;

use crate::args::Outcome;

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
}

pub fn run(args: &Args) -> Outcome {
    match &args.what {
        What::Action(a) => action::run(a),
        What::Path(a) => path::run(a),
    }
}
