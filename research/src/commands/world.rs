//! `world`: what stitching, editing, planning and living in a world cost.

use super::with;
use crate::args::{CacheArgs, CommandResult};
use crate::{keys, output};
use std::path::PathBuf;
use throng_precompute::run;
use throng_precompute::stitch::WorldSource;
use throng_research::measure::{self, EditFigures, PlannedPathFigures, WorldFigures};

/// Measure a world: stitching, moving a unit of every kind, planning paths, steps of its people.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<WorldFigures>())]
pub struct Args {
    /// World file (`.toml`). Its bundle is built from its config where it is not there.
    #[arg(value_name = "WORLD")]
    file: PathBuf,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> CommandResult {
    let source = WorldSource::load(&args.file)?;
    with(&args.cache, |with| run::ensure_bundle(&source.bundle, source.config.as_deref(), with))??;
    let tables = crate::args::open_bundle(&source.bundle)?;
    let figures = measure::world(&tables, &source, &args.file)?;
    if args.json { output::json(&figures) } else { print(&figures) }
}

fn print(w: &WorldFigures) -> CommandResult {
    let mut rows = vec![
        ("world", format!("{}: {} instances, {} cells, {} transitions", w.world, w.instances, w.cells, w.transitions)),
        ("stitching", format!("{:.3} s, {} at most", w.stitch_seconds, output::bytes(w.peak_bytes))),
    ];
    rows.extend(w.edits.iter().map(|e| ("  moving", edit(e))));
    rows.extend([
        ("first planner", format!("{:.3} s", w.paths.first_seconds)),
        ("paths", paths(&w.paths)),
        ("paths soon", paths(&w.paths_soon)),
        ("crowd", format!("{} characters, {:.0} steps a second on one thread", w.characters, w.steps_per_second)),
    ]);
    output::table(&rows)
}

fn edit(e: &EditFigures) -> String {
    let what = format!("{} (place {}, one of {})", e.unit, e.place, e.placed);
    match (e.seconds, e.over_stitch) {
        (Some(s), Some(share)) => {
            format!("{what} by {:.2} m: {:.1} ms, {share:.4} of stitching anew", e.step_m, 1e3 * s)
        }
        _ => format!("{what}: every move was refused"),
    }
}

/// What planning paths costs.
fn paths(p: &PlannedPathFigures) -> String {
    let dijkstra = match (p.over_dijkstra_mean, p.over_dijkstra_max, p.worst) {
        (Some(mean), Some(most), Some([from, to])) => format!(
            "; {mean:.3} times the time of Dijkstra's on average, {most:.3} at most (from instance {from} to {to}), of {}",
            p.compared
        ),
        _ => String::new(),
    };
    let [from, to] = p.slowest;
    format!(
        "{:.2} ms on average, {:.2} at most (from instance {from} to {to}), for {:.0} m ({:.0} s), {:.0} at most; {:.0} ways of the upper layer and {:.0} nodes opened; {:.3} times what is proved to be needed at most{dijkstra}",
        1e3 * p.seconds_mean,
        1e3 * p.seconds_max,
        p.length_mean_m,
        p.duration_mean_s,
        p.length_max_m,
        p.opened_instances_mean,
        p.opened_nodes_mean,
        p.over_bound_max,
    )
}
