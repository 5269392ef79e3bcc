//! `throng schema`: schemas of input files.

use crate::{args::CommandResult, output};
use throng_planner::task::Task;
use throng_precompute::{config::BuildConfig, run::scene_schema};

/// Print a JSON schema of config, scene or task files.
#[derive(clap::Args)]
pub struct Args {
    /// Kind of files.
    #[arg(long, value_enum, default_value_t = SchemaKind::Config)]
    of: SchemaKind,
}

/// Files with a schema.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum SchemaKind {
    /// Configs of bundles, see `throng build`.
    Config,
    /// Scenes, see `throng run`.
    Scene,
    /// Tasks of limbs, see `throng plan`.
    Task,
}

pub fn run(args: &Args) -> CommandResult {
    match args.of {
        SchemaKind::Config => output::json(&BuildConfig::json_schema()),
        SchemaKind::Scene => output::json(&scene_schema()),
        SchemaKind::Task => output::json(&Task::json_schema()),
    }
}
