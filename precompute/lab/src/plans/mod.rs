//! Limb tasks from files to files: the motion that they change, variants of it, output files and reports. Shared by the
//! command line and the viewer.

mod plan_files;
mod report;
pub mod scenes;
mod sources;
#[cfg(test)]
mod tests;

pub use plan_files::write_plan;
pub use report::{CollisionReport, PlanReport, TaskReport, VariantReport, plan_report};
pub use sources::{TaskSources, file_clip, load_sources};

use std::path::Path;
use throng_base::text::TomlSource;
use throng_motion::error::BuildError;
use throng_planner::task::{ActorClip, ClipMismatch, RunOptions, Task, TaskOutcome};

/// Motions that differ by less are one variant (rad).
const SAME_MOTION_RAD: f64 = 0.02;
/// Seeds that are tried until one does all that is asked for.
const MIN_SEEDS: u64 = 4;
/// Seeds that are tried for each variant.
pub const SEEDS_PER_VARIANT: u64 = 8;

/// True for a file with tasks, which scenes do not have.
pub fn is_task(path: &Path) -> bool {
    let is_table = |line: &str| line.trim_start().starts_with("[[tasks]]");
    TomlSource::read(path, "tasks").is_ok_and(|source| source.text().lines().any(is_table))
}

/// One outcome and its seed, or as many different ones as are asked for and as seeds give. Where a seed does not lead to all
/// that is asked for, the next ones are tried.
///
/// - `watch`: its seed is the first one; others follow it.
///
/// # Errors
/// [`ClipMismatch`].
pub fn variants(
    task: &Task,
    clips: &[ActorClip],
    number: u64,
    watch: &RunOptions<'_>,
) -> Result<Vec<(u64, TaskOutcome)>, ClipMismatch> {
    let first = watch.seed.unwrap_or(task.config.budget.seed);
    let run = |seed| task.run_watched(clips, &RunOptions { seed: Some(seed), ..*watch });
    let is_cancelled = || watch.cancel.is_some_and(|c| c.load(std::sync::atomic::Ordering::Relaxed));
    let is_good = |o: &TaskOutcome| o.is_solved() && o.recheck.violations.is_empty();
    let mut out: Vec<(u64, TaskOutcome)> = vec![(first, run(first)?)];
    for seed in (1..MIN_SEEDS).map(|k| first.wrapping_add(k)) {
        if is_good(&out[0].1) || is_cancelled() {
            break;
        }
        let one = run(seed)?;
        if is_good(&one) {
            out[0] = (seed, one);
        }
    }
    let first = out[0].0;
    for k in 1..number * SEEDS_PER_VARIANT {
        if out.len() as u64 >= number || !out[0].1.is_solved() || is_cancelled() {
            break;
        }
        let seed = first.wrapping_add(k);
        let one = run(seed)?;
        if one.is_solved() && out.iter().all(|(_, o)| o.distance_rad(&one) > SAME_MOTION_RAD) {
            out.push((seed, one));
        }
    }
    Ok(out)
}

/// The error of a config with a message.
fn config_error(message: impl Into<String>) -> BuildError {
    BuildError::Config { message: message.into() }
}
