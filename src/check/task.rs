//! Checks a task of `throng plan` before any search.

use crate::args::{CommandResult, fail};
use crate::output;
use schemars::JsonSchema;
use serde::Serialize;
use throng_planner::task::{MeshPreview, StepPreview, Task};
use throng_precompute::{config::BuildConfig, plans};

/// Printed report.
#[derive(Serialize, JsonSchema)]
pub struct TaskCheckReport {
    /// Findings on every task, in the file's order.
    tasks: Vec<StepPreview>,
    /// Findings on the meshes of obstacles and objects.
    meshes: Vec<MeshPreview>,
    /// Number of faults of all tasks; the check fails unless it is 0.
    faults: usize,
}

pub fn run(args: &super::Args) -> CommandResult {
    let task = Task::read(&args.scene)?;
    let config = BuildConfig::of_motion("", Vec::new())?;
    let sources = crate::run::with_build_context(&args.cache, |with| plans::load_sources(&task, &config, None, with))??;
    let (task, clips) = sources.stage_task(task, None)?;
    let ahead = task.preview_steps(&clips)?;
    let faults = ahead.iter().map(|a| a.faults.len()).sum();
    let report = TaskCheckReport { tasks: ahead, meshes: task.preview_meshes(), faults };
    output::report(&report, args.json, print)?;
    let first = report.tasks.iter().find_map(|t| Some((&t.name, t.faults.first()?)));
    first.map_or(Ok(()), |(name, fault)| fail(format!("{name}: {fault}")))
}

fn print(report: &TaskCheckReport) -> CommandResult {
    let mut rows: Vec<(&str, String)> = Vec::new();
    for t in &report.tasks {
        let mut text = Vec::new();
        text.extend(t.reached.map(|[hands, all]| format!("{hands} of {all} hands reach")));
        if let (Some(least), Some(given)) = (t.least_s, t.given_s) {
            let pair = |k: usize| format!("{:.2} of {:.2} s", least[k], given[k]);
            text.push(format!("at least {} there, {} back", pair(0), pair(1)));
        }
        if t.at_s.is_none() {
            text.push(format!("{} collisions to mend", t.collisions.len()));
        }
        rows.push((if t.faults.is_empty() { "task" } else { "fault" }, format!("{}: {}", t.name, text.join(", "))));
        rows.extend(t.faults.iter().map(|f| ("", f.clone())));
    }
    for m in &report.meshes {
        let holes = if m.open_edges > 0 { format!(", {} open edges: no inside", m.open_edges) } else { String::new() };
        rows.push(("mesh", format!("{}: {} triangles{holes}", m.thing, m.triangles)));
    }
    output::table(&rows)
}
