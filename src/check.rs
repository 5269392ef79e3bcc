//! `throng check`: checks a scene before it runs, and a task before any search.

mod expectations;
mod task;

use crate::args::{CacheArgs, CommandResult, load_scene};
use crate::{keys, output};
use serde::Serialize;
use std::path::PathBuf;
use throng_core::base::limits;
use throng_precompute::run::ExpectationReport;
use throng_simulation::Simulation;

/// Check a scene: every name, number, rule and state, and actions that its bundles have no motion for. Or check a task of
/// `throng plan`: which targets limbs reach, how long joints need at least, where clips collide, which meshes have holes.
#[derive(clap::Args)]
#[command(after_long_help = help())]
pub struct Args {
    /// Scene, or task.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Also run the scene, and check its expectations (`[[expect]]`); the exit status is 1 where one is broken.
    #[arg(long)]
    run: bool,
    /// Number of runs, each with the next seed.
    #[arg(long, value_name = "N", requires = "run", default_value_t = 1,
        value_parser = limits::number_parser::<u64>(&limits::REPEATS))]
    seeds: u64,
    /// For scenes of strangers: read only files in the folder of the scene and below, and build nothing.
    #[arg(long)]
    untrusted: bool,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Printed report. A faulty scene is refused with file, line and column instead.
#[derive(Serialize, schemars::JsonSchema)]
struct SceneCheckReport {
    /// The scene's name.
    scene: String,
    /// Number of characters and agents.
    characters: usize,
    /// Sizes of the tables that it is compiled to.
    tables: Vec<TableSize>,
    /// Motion that actions ask for and that a bundle lacks: people stand meanwhile.
    missing_motion: Vec<String>,
    /// Outcomes of the scene's expectations, with `--run`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    expectations: Vec<ExpectationReport>,
}

#[derive(Serialize, schemars::JsonSchema)]
struct TableSize {
    /// Name of the table.
    name: String,
    /// Number of rows.
    rows: usize,
}

/// Help on the JSON keys, for each kind of input.
fn help() -> String {
    let scene = keys::json_keys_under::<SceneCheckReport>("JSON keys (of a scene)");
    let task = keys::json_keys_under::<task::TaskCheckReport>("JSON keys (of a task)");
    [scene, task].join("\n")
}

pub fn run(args: &Args) -> CommandResult {
    if throng_precompute::plans::is_task(&args.scene) {
        return task::run(args);
    }
    let mut scene = load_scene(&args.scene, args.untrusted)?;
    if !args.run {
        // Who checks a scene does not know yet what it does.
        scene.forget_configs();
    }
    crate::run::ensure_scene(&scene, &args.cache)?;
    let compiled = scene.open()?;
    // Starts and goals are checked when the characters are placed.
    let sim = Simulation::new(&compiled)?;
    let sizes = compiled.scenario().map_or_else(Vec::new, |s| s.table_sizes().to_vec());
    let checked = SceneCheckReport {
        scene: scene.name.clone(),
        characters: sim.num_characters(),
        tables: sizes.into_iter().map(|(name, rows)| TableSize { name: name.into(), rows }).collect(),
        missing_motion: compiled.missing_motion(),
        expectations: expectations::run(&scene, args)?,
    };
    if args.json {
        output::json(&checked)?;
        return expectations::verdict(&checked.expectations);
    }
    let tables = checked.tables.iter().map(|table| format!(", {} {}", table.rows, table.name));
    let missing = checked.missing_motion.iter().map(|missing| format!("no motion: {missing}\n"));
    let (tables, missing): (String, String) = (tables.collect(), missing.collect());
    output::text(format!("{}: {} characters{tables}\n{missing}", checked.scene, checked.characters))?;
    output::text(expectations::describe(&checked.expectations, args.seeds))?;
    expectations::verdict(&checked.expectations)
}
