//! `throng run` of a scene of walkers.

use super::{Args, make_bundle};
use crate::args::{Outcome, fail};
use crate::output;
use throng_precompute::picture;
use throng_precompute::scene::RunConfig;
use throng_precompute::scene::walkers::{self, WalkersReport, WalkersScene};
use throng_runtime::blend::walkers::WalkersConfig;

/// Length of the path that styles are shown on, and how far figures on it stand apart. [Unit: m]
const PATH_M: f32 = 16.0;
const APART_M: f32 = 0.9;

/// Runs a scene of walkers, whose bundle is built where it is not there.
pub fn run(args: &Args) -> Outcome {
    let mut scene = WalkersScene::load(&args.file)?;
    if !args.without.is_empty() {
        return fail("--without is for scenes with behaviours");
    }
    args.crowd.change_living(&mut scene.characters, &mut scene.seed)?;
    scene.check(&args.file)?;
    if let Some(bundle) = &args.bundle {
        (scene.bundle, scene.config) = (bundle.clone(), None);
    }
    make_bundle(&scene.bundle, scene.config.as_deref(), &args.cache)?;
    let tables = crate::args::open(&scene.bundle)?;
    let config = RunConfig { recorded: args.png.is_some(), ..args.crowd.scene_run() };
    let (report, record) = walkers::run(&scene, &tables, WalkersConfig::default(), &config)?;
    if let Some(png) = &args.png {
        let styles = walkers::walk_styles(&scene, &tables, PATH_M, APART_M)?;
        picture::walkers_sheet(&report, &record, &styles, PATH_M).save_png(png)?;
    }
    if args.json { output::json(&report) } else { print(&report) }
}

fn print(r: &WalkersReport) -> Outcome {
    output::table(&[
        ("scene", format!("{}: {} character(s), {:.0} s", r.scene, r.characters, r.simulated_s)),
        ("paths", format!("{:.2} m/s on average, {:.2} at most", r.speed_mean_mps, r.speed_max_mps)),
        (
            "foot slip",
            format!(
                "{:.3} m/s mean, {:.3} m/s 95th percentile, while planted; {:.3} m below the ground at most",
                r.foot_slip_mean_mps, r.foot_slip_p95_mps, r.below_ground_max_m
            ),
        ),
        ("knees", format!("{:.1} rad/s at most", r.knee_rate_max_radps)),
        ("speed", format!("{:.0} steps a second of everybody, on one thread", r.steps_per_second)),
    ])
}
