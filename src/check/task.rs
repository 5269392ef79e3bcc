//! What is known of a task of `throng plan` before any search.

use crate::args::{Outcome, fail};
use crate::output;
use schemars::JsonSchema;
use serde::Serialize;
use throng_planner::task::{Ahead, Task};
use throng_precompute::config::BuildConfig;
use throng_precompute::plans;

/// What is printed.
#[derive(Serialize, JsonSchema)]
pub struct Report {
    /// Every task, in the file's order.
    tasks: Vec<TaskReport>,
    /// Meshes of obstacles and objects.
    meshes: Vec<MeshReport>,
    /// Faults of all tasks; anything but 0 fails.
    faults: usize,
}

#[derive(Serialize, JsonSchema)]
struct TaskReport {
    /// Its name, or what it does.
    name: String,
    /// What no search can mend, and the way out.
    faults: Vec<String>,
    /// When it is reached; none of corrections (s).
    at_s: Option<f64>,
    /// Least time that joints need there and back at their speed limits (s).
    least_s: Option<[f64; 2]>,
    /// Time that there is (s).
    given_s: Option<[f64; 2]>,
    /// Hands within reach, within limits and free, and how many grips and turns allow.
    reached: Option<[usize; 2]>,
    /// Stretches in which the limb of a correction collides by the clip itself.
    collisions: usize,
}

#[derive(Serialize, JsonSchema)]
struct MeshReport {
    /// Whose it is.
    object: String,
    /// Number of triangles.
    triangles: usize,
    /// Edges of one triangle only: where there are any, it has no inside.
    open_edges: usize,
}

pub fn run(args: &super::Args) -> Outcome {
    let task = Task::read(&args.scene)?;
    let config = BuildConfig::of_motion("", Vec::new())?;
    let sources = crate::run::with(&args.cache, |with| plans::sources(&task, &config, None, with))??;
    let (task, clips) = sources.staged(task, None)?;
    let ahead = task.ahead(&clips)?;
    let one = |a: &Ahead| TaskReport {
        name: a.name.clone(),
        faults: a.faults.clone(),
        at_s: a.at_s,
        least_s: a.least_s,
        given_s: a.given_s,
        reached: a.reached,
        collisions: a.collisions.len(),
    };
    let meshes = task.meshes().into_iter();
    let report = Report {
        tasks: ahead.iter().map(one).collect(),
        meshes: meshes
            .map(|m| MeshReport { object: m.thing, triangles: m.triangles, open_edges: m.open_edges })
            .collect(),
        faults: ahead.iter().map(|a| a.faults.len()).sum(),
    };
    if args.json {
        output::json(&report)?;
    } else {
        print(&report)?;
    }
    let first = report.tasks.iter().find_map(|t| Some((&t.name, t.faults.first()?)));
    first.map_or(Ok(()), |(name, fault)| fail(format!("{name}: {fault}")))
}

fn print(report: &Report) -> Outcome {
    let mut rows: Vec<(&str, String)> = Vec::new();
    for t in &report.tasks {
        let mut text = Vec::new();
        if let Some([hands, all]) = t.reached {
            text.push(format!("{hands} of {all} hands reach"));
        }
        if let (Some(least), Some(given)) = (t.least_s, t.given_s) {
            let pair = |k: usize| format!("{:.2} of {:.2} s", least[k], given[k]);
            text.push(format!("at least {} there, {} back", pair(0), pair(1)));
        }
        if t.at_s.is_none() {
            text.push(format!("{} collisions to mend", t.collisions));
        }
        rows.push((if t.faults.is_empty() { "task" } else { "fault" }, format!("{}: {}", t.name, text.join(", "))));
        rows.extend(t.faults.iter().map(|f| ("", f.clone())));
    }
    for m in &report.meshes {
        let holes = if m.open_edges > 0 { format!(", {} open edges: no inside", m.open_edges) } else { String::new() };
        rows.push(("mesh", format!("{}: {} triangles{holes}", m.object, m.triangles)));
    }
    output::table(&rows)
}
