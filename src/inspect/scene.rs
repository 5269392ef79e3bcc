//! Where a clip collides with the scene of a task.

use crate::args::{Outcome, fail};
use crate::output;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use throng_planner::task::Task;
use throng_precompute::cache::Cache;
use throng_precompute::plans;
use throng_precompute::progress::Silent;
use throng_precompute::run::{Cached, News};

/// What is printed.
#[derive(Serialize, JsonSchema)]
pub struct Report {
    /// Stretches in which a limb is in something, limb by limb.
    collisions: Vec<Collision>,
}

#[derive(Serialize, JsonSchema)]
struct Collision {
    /// The limb.
    limb: String,
    /// Part of the limb, or what it holds, where it is deepest.
    part: String,
    /// What it is in.
    obstacle: String,
    /// From when on (s).
    from_s: f64,
    /// Until when (s).
    to_s: f64,
    /// How deep at most (m).
    depth_m: f64,
}

/// Puts a clip in the place of a task's first one, and finds where its limbs collide.
pub fn run(args: &super::Args, task: &Path) -> Outcome {
    let [file] = &args.files[..] else { return fail("--scene is for one motion file") };
    if crate::args::is_bundle(file) {
        return fail(format!("{}: expected a motion file: --scene is for clips", file.display()));
    }
    let task = Task::read(task)?;
    let config = args.read.config()?;
    let tell = |news: News| output::tell(news);
    let clip = plans::file_clip(file, &config, &tell)?;
    let with = Cached { cache: &Cache::none(), progress: &Silent, tell: &tell };
    let (task, clips) = plans::sources(&task, &config, Some(clip), &with)?.staged(task, None)?;
    let found = task.collisions(&clips, 0)?;
    let collision = |(limb, s): (throng_planner::linkage::Limb, throng_planner::correct::Span)| Collision {
        limb: limb.name().into(),
        part: s.part,
        obstacle: s.with,
        from_s: s.from_s,
        to_s: s.to_s,
        depth_m: s.depth_m,
    };
    let report = Report { collisions: found.into_iter().map(collision).collect() };
    if args.json {
        return output::json(&report);
    }
    if report.collisions.is_empty() {
        return output::text("no limb collides\n");
    }
    let rows = report.collisions.iter().map(|c| {
        let text = format!("in {} from {:.2} s to {:.2} s, {:.3} m deep", c.obstacle, c.from_s, c.to_s, c.depth_m);
        (c.part.as_str(), text)
    });
    output::table(&rows.collect::<Vec<_>>())
}
