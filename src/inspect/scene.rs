//! Collisions of a clip with the scene of a task.

use crate::args::{CommandResult, fail};
use crate::output;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use throng_core::base::error::ensure;
use throng_planner::{correct::CollisionStretch, task::Task};
use throng_precompute::run::{BuildContext, News};
use throng_precompute::{cache::Cache, plans, progress::Silent};

/// Printed report.
#[derive(Serialize, JsonSchema)]
pub struct SceneCollisionReport {
    /// Time spans in which a limb collides with something, limb by limb.
    collisions: Vec<LimbCollision>,
}

#[derive(Serialize, JsonSchema)]
struct LimbCollision {
    /// The limb.
    limb: String,
    #[serde(flatten)]
    span: CollisionStretch,
}

/// Replaces a task's first clip by another one, and finds the collisions of its limbs.
pub fn run(args: &super::Args, task: &Path) -> CommandResult {
    let [file] = &args.files[..] else { return fail("--scene is for one motion file") };
    let fault = || format!("{}: expected a motion file: --scene is for clips", file.display());
    ensure(!crate::args::is_bundle(file), fault)?;
    let task = Task::read(task)?;
    let config = args.read.config_for(&args.files)?;
    let tell = |news: News| output::print_to_stderr(news);
    let clip = plans::file_clip(file, &config, &tell)?;
    let with = BuildContext { cache: &Cache::disabled(), progress: &Silent, report_news: &tell };
    let (task, clips) = plans::load_sources(&task, &config, Some(clip), &with)?.stage_task(task, None)?;
    let found = task.collisions(&clips, 0)?;
    let collisions = found.into_iter().map(|(limb, span)| LimbCollision { limb: limb.name().into(), span });
    let report = SceneCollisionReport { collisions: collisions.collect() };
    if args.json {
        return output::json(&report);
    }
    if report.collisions.is_empty() {
        return output::text("no limb collides\n");
    }
    let text = |s: &CollisionStretch| {
        format!("in {} from {:.2} s to {:.2} s, {:.3} m deep", s.with, s.from_s, s.to_s, s.depth_m)
    };
    let rows = report.collisions.iter().map(|c| (c.span.part.as_str(), text(&c.span)));
    output::table(&rows.collect::<Vec<_>>())
}
