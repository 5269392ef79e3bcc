//! `throng plan`: limbs of a clip avoid obstacles, reach for, take and carry things.

mod strip;

use crate::args::{CacheArgs, CommandResult, ReadArgs, fail};
use crate::{help, keys, output};
use std::path::PathBuf;
use throng_core::{base::error::ensure, base::limits};
use throng_planner::task::{RunOptions, Task};
use throng_precompute::files;
use throng_precompute::plans::{self, PlanReport};

/// Change a clip so that limbs perform a task: avoid obstacles, reach for things, take, carry and drop them, in time with
/// everything that moves.
///
/// The clip is written on the database skeleton at the database rate, as by `throng export --retargeted`; outside of the
/// planned parts it is unchanged. Taken and carried objects are written beside it to CLIP.objects.json, other characters that
/// changed to CLIP.NAME.bvh. Nothing is written unless every task is solved, or --partial is given, and an independent check
/// finds no fault.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<PlanReport>())]
pub struct Args {
    /// Task file, see `throng schema --of task`.
    #[arg(value_name = "TASK")]
    task: PathBuf,
    /// Clip to write.
    #[arg(long, value_name = "CLIP.bvh")]
    out: PathBuf,
    /// Number of different motions; further ones are written as CLIP-2.bvh, CLIP-3.bvh and so on.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100))]
    variants: u64,
    /// Seed in place of the task's: same seed, same motion.
    #[arg(long, value_parser = limits::number_parser::<u64>(&limits::SEED))]
    seed: Option<u64>,
    /// Draw moments before and after, seen from two sides (PNG); of an unsolved task, too.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Write the solved tasks even if others are unsolved, or solved only in part; the exit code is still 1.
    #[arg(long)]
    partial: bool,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> CommandResult {
    let is_bvh = args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("bvh"));
    ensure(is_bvh, || format!("{}: expected a name that ends with .bvh", args.out.display()))?;
    files::check_targets(args.png.iter().chain([&args.out]), [&args.task])?;
    let task = Task::read(&args.task)?;
    let config = args.read.config()?;
    let sources = crate::run::with_build_context(&args.cache, |with| plans::load_sources(&task, &config, None, with))??;
    let (task, clips) = sources.stage_task(task, args.seed)?;
    let options = RunOptions { seed: args.seed, ..RunOptions::default() };
    let found = plans::variants(&task, &clips, args.variants, &options)?;
    let Some(mut report) = plans::plan_report(&task, &found) else { return fail("no motion was made") };
    if let Some(png) = &args.png {
        let title = args.task.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        strip::draw(&task, &clips, &found[0].1, &title).save_png(png)?;
    }
    let faults = found.iter().flat_map(|(_, o)| &o.recheck.violations);
    let fault = faults.map(|v| format!("the check found at {:.3} s: {}", v.time_s, v.what)).next();
    if (report.solved || args.partial) && fault.is_none() {
        for (i, (_, outcome)) in found.iter().enumerate() {
            report.files.extend(plans::write_plan(&task, &clips, outcome, &args.out, i)?);
        }
    }
    output::report(&report, args.json, print)?;
    if let Some(fault) = fault {
        return fail(format!("{fault}; nothing was written. Try another --seed, or a larger clearance_m"));
    }
    let Some(why) = report.tasks.iter().find(|t| !t.solved) else {
        warn_of_few(found.len(), args);
        let (clip, task) = (args.out.to_string_lossy(), args.task.to_string_lossy());
        return if args.json { Ok(()) } else { help::next_step(&["inspect", &clip, "--scene", &task]) };
    };
    let written = if args.partial { "the rest was written" } else { "nothing was written (--partial writes the rest)" };
    fail(format!("{}: {}; {written}", why.name, why.why.as_deref().unwrap_or_default()))
}

fn warn_of_few(found: usize, args: &Args) {
    if (found as u64) < args.variants {
        let (n, tried) = (args.variants, args.variants * plans::SEEDS_PER_VARIANT);
        eprintln!("warning: {found} of {n} motions: others of {tried} seeds are the same, or not solved");
    }
}

fn print(r: &PlanReport) -> CommandResult {
    let mut rows: Vec<(&str, String)> = Vec::new();
    for t in &r.tasks {
        let why = t.why.as_ref().map_or(String::new(), |why| format!(": {why}"));
        rows.push((if t.solved { "done" } else { "not done" }, format!("{}{why}", t.name)));
    }
    let [all_ms, first_ms] = [r.total_s, r.first_solution_s].map(|s| 1e3 * s);
    let counts = format!("{} nodes, {} looks", r.nodes, r.checks);
    rows.push(("planned", format!("in {all_ms:.1} ms, first ways after {first_ms:.1} ms; {counts}")));
    let clear_m = r.clearance_min_m.map_or_else(|| "-".into(), |m| format!("{m:.3}"));
    let jerk = format!("jerk {:.0} rad/s^3 ({:.0} before smoothing)", r.jerk_after, r.jerk_before);
    rows.push(("motion", format!("{:.2} rad, {jerk}; {clear_m} m clear, {}", r.path_length_rad, r.limits())));
    rows.push(("check", format!("{} violations, {:.4} m deep at most", r.recheck_violations, r.penetration_max_m)));
    for v in &r.variants {
        rows.push(("variant", format!("seed {}, {:.3} rad from the most similar one", v.seed, v.distance_rad)));
    }
    rows.extend(r.files.iter().map(|f| ("written", f.display().to_string())));
    output::table(&rows)
}
