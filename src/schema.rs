//! `throng schema`: schemas of input files.

use crate::args::Outcome;
use crate::output;
use throng_planner::task::Task;
use throng_precompute::config::BuildConfig;
use throng_precompute::run::scene_schema;

/// Print a JSON schema of config, scene or task files.
#[derive(clap::Args)]
pub struct Args {
    /// Kind of files.
    #[arg(long, value_enum, default_value_t = Of::Config)]
    of: Of,
}

/// Files with a schema.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Of {
    /// Configs of bundles, see `throng build`.
    Config,
    /// Scenes, see `throng run`.
    Scene,
    /// Tasks of limbs, see `throng plan`.
    Task,
}

pub fn run(args: &Args) -> Outcome {
    match args.of {
        Of::Config => output::json(&BuildConfig::json_schema()),
        Of::Scene => output::json(&scene_schema()),
        Of::Task => output::json(&Task::json_schema()),
    }
}
