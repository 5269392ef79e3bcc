//! `throng query`: the action of a policy, and paths through a world.

mod action;
mod path;

use crate::args::CommandResult;

/// Ask a policy for an action, or plan a path through a world.
#[derive(clap::Subcommand)]
pub enum QueryCommand {
    Action(action::Args),
    Path(path::Args),
}

pub fn run(command: &QueryCommand) -> CommandResult {
    match command {
        QueryCommand::Action(a) => action::run(a),
        QueryCommand::Path(a) => path::run(a),
    }
}
