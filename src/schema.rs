//! `throng schema`: what a config may hold.

use crate::args::Outcome;
use crate::output;
use throng_precompute::config::BuildConfig;

/// Print the JSON schema of config files.
#[derive(clap::Args)]
pub struct Args {}

pub fn run(_: &Args) -> Outcome {
    output::json(&BuildConfig::json_schema())
}
