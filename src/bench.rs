//! `throng bench`: costs on this machine.

mod bundle;
pub mod crowd;
mod motion;
mod plan;
mod scenario;

use crate::args::CommandResult;

/// Measure what a bundle, a crowd, a scenario, or plans of limbs cost on this machine, and how motion looks.
#[derive(clap::Subcommand)]
pub enum BenchCommand {
    Bundle(bundle::Args),
    Motion(motion::Args),
    Crowd(crowd::Args),
    Plan(plan::Args),
    Scenario(scenario::Args),
}

pub fn run(command: &BenchCommand) -> CommandResult {
    match command {
        BenchCommand::Bundle(a) => bundle::run(a),
        BenchCommand::Motion(a) => motion::run(a),
        BenchCommand::Crowd(a) => crowd::run(a).map(drop),
        BenchCommand::Plan(a) => plan::run(a),
        BenchCommand::Scenario(a) => scenario::run(a),
    }
}
