//! `throng bench`: costs on this machine.

mod bundle;
pub mod crowd;
mod motion;
mod plan;
mod scenario;

use crate::args::Outcome;

/// Measure what a bundle, a crowd, a scenario, or plans of limbs cost on this machine, and how motion looks.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Bundle(bundle::Args),
    Motion(motion::Args),
    Crowd(crowd::Args),
    Plan(plan::Args),
    Scenario(scenario::Args),
}

pub fn run(args: &Args) -> Outcome {
    match &args.what {
        What::Bundle(a) => bundle::run(a),
        What::Motion(a) => motion::run(a),
        What::Crowd(a) => crowd::run(a),
        What::Plan(a) => plan::run(a),
        What::Scenario(a) => scenario::run(a),
    }
}
