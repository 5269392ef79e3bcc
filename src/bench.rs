//! `throng bench`: costs on this machine.

mod blend;
mod bundle;
pub mod crowd;
mod motion;
mod people;
mod plan;
mod scenario;
mod steering;
mod world;

use crate::args::Outcome;
use crate::renamed;
use std::ffi::OsString;

/// Measure what a bundle, a world, blending, a crowd or plans of limbs cost on this machine.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Bundle(bundle::Args),
    World(world::Args),
    Blend(blend::Args),
    Motion(motion::Args),
    Crowd(crowd::Args),
    Steering(steering::Args),
    People(people::Args),
    Plan(plan::Args),
    Scenario(scenario::Args),
    /// Any other word, such as a file in the former syntax.
    #[command(external_subcommand)]
    Other(Vec<OsString>),
}

pub fn run(args: &Args) -> Outcome {
    match &args.what {
        What::Bundle(a) => bundle::run(a),
        What::World(a) => world::run(a),
        What::Blend(a) => blend::run(a),
        What::Motion(a) => motion::run(a),
        What::Crowd(a) => crowd::run(a),
        What::Steering(a) => steering::run(a),
        What::People(a) => people::run(a),
        What::Plan(a) => plan::run(a),
        What::Scenario(a) => scenario::run(a),
        What::Other(words) => {
            let new = [(".throng", "bundle"), (".toml", "world")];
            renamed::refuse_form("bench", words, &new, "bundle FILE, world FILE, blend [FILE] and crowd")
        }
    }
}
