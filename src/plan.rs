//! `throng plan`: limbs of a clip that give way, reach, take and bring things.

pub mod read;
mod strip;

use crate::args::{CacheArgs, Outcome, ReadArgs, fail};
use crate::{keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::error::Error;
use std::path::{Path, PathBuf};
use throng_planner::correct::Span;
use throng_planner::task::{ActorClip, Attachment, Done, Event, Task, TaskOutcome};
use throng_precompute::{Clip, export, files};
use throng_runtime::base::limits;

/// Motions that differ by less are one variant (rad).
const SAME_RAD: f64 = 0.02;
/// Seeds that are tried for each variant.
const SEEDS_EACH: u64 = 8;

/// Change a clip so that limbs do what a task says: give way to what is around, reach for things, take, carry and drop
/// them, in time with everything that moves.
///
/// The clip is written on the database skeleton at the database rate, as `throng export --retargeted` writes it; outside of
/// what was planned it is the same. What was taken and carried stands beside it in CLIP.objects.json. Other characters that
/// moved are written as CLIP.NAME.bvh. Nothing is written unless every task is done, or with --partial what was done, and
/// a check by other means finds no fault.
#[derive(clap::Args)]
#[command(after_long_help = keys::of::<Report>())]
pub struct Args {
    /// Task, see `throng schema --of task`.
    #[arg(value_name = "TASK")]
    task: PathBuf,
    /// Clip to write.
    #[arg(long, value_name = "CLIP.bvh")]
    out: PathBuf,
    /// Number of different motions; further ones are written as CLIP-2.bvh, CLIP-3.bvh and so on.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100))]
    variants: u64,
    /// Seed in place of the task's: same seed, same motion.
    #[arg(long, allow_negative_numbers = true, value_parser = limits::number::<u64>(&limits::SEED))]
    seed: Option<u64>,
    /// Draw moments before and after, seen from two sides (PNG); of an unsolved task, too.
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Write what was done even where a task was not, or only in part: the exit code is 1 all the same.
    #[arg(long)]
    partial: bool,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What a plan came to.
#[derive(Serialize, JsonSchema)]
pub struct Report {
    /// True where every task was done.
    pub solved: bool,
    /// Every task, in the file's order.
    pub tasks: Vec<TaskReport>,
    /// Time of the searches until their first ways (s).
    pub first_solution_s: f64,
    /// Time of all plans, with smoothing (s).
    pub total_s: f64,
    /// Nodes of all trees.
    pub nodes: usize,
    /// Looks at poses: one pose at one time against everything.
    pub checks: u64,
    /// How far joints turn in all plans (rad).
    pub path_length_rad: f64,
    /// Root mean square of the joints' jerk before smoothing, the mean of all plans (rad/s^3).
    pub jerk_before: f64,
    /// The same after smoothing (rad/s^3).
    pub jerk_after: f64,
    /// Least distance of planned limbs from what they may not touch; none where nothing is around (m).
    pub clearance_min_m: Option<f64>,
    /// How far planned joints stay within their limits (rad).
    pub limit_margin_rad: Option<f64>,
    /// How deep planned limbs are in what they may not touch (m).
    pub penetration_max_m: f64,
    /// How far faces are from what they look at, at most, beyond what necks allow; none where `gaze` is off (rad).
    pub gaze_off_rad: Option<f64>,
    /// What a check by other means found wrong; anything but 0 fails.
    pub recheck_violations: usize,
    /// What was written.
    pub files: Vec<PathBuf>,
    /// Motions that were made, where several were asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub variants: Vec<Variant>,
}

/// What came of a task.
#[derive(Serialize, JsonSchema)]
pub struct TaskReport {
    /// Its name, or what it does.
    name: String,
    /// True where it was done.
    solved: bool,
    /// Why it was not done.
    why: Option<String>,
    /// How near it came where it was not done: to the target, or the two ends of the search to each other (m).
    nearest_m: Option<f64>,
    /// When it is reached, of tasks that have a time; of those who walk up to it, the one that was found (s).
    at_s: Option<f64>,
    /// Where the clip collides, of corrections.
    collisions: Vec<CollisionReport>,
}

/// A stretch in which a clip collides.
#[derive(Serialize, JsonSchema)]
struct CollisionReport {
    /// From when on (s).
    from_s: f64,
    /// Until when (s).
    to_s: f64,
    /// Part of the body, where it is deepest.
    part: String,
    /// What it is in.
    obstacle: String,
    /// How deep at most (m).
    depth_m: f64,
    /// Why it stays so; none where it was corrected.
    why: Option<String>,
}

/// One of several motions.
#[derive(Serialize, JsonSchema)]
pub struct Variant {
    /// Its seed.
    seed: u64,
    /// How different it is from the most similar other one: the mean angle of what was planned (rad).
    distance_rad: f64,
}

/// What stands beside a clip.
#[derive(Serialize)]
struct Objects<'a> {
    attachments: &'a [Attachment],
    events: &'a [Event],
}

pub fn run(args: &Args) -> Outcome {
    if !args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("bvh")) {
        return fail(format!("{}: expected a name that ends with .bvh", args.out.display()));
    }
    args.png.iter().chain([&args.out]).try_for_each(|f| files::check_target(f))?;
    let task = Task::read(&args.task)?;
    let (task, clips) = read::staged(task, &args.read.config()?, None, Some(&args.cache), args.seed)?;
    let found = outcomes(&task, &clips, args)?;
    let (_, first) = &found[0];
    let mut report = report(&task, first);
    if let Some(png) = &args.png {
        let title = args.task.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        strip::draw(&task, &clips, first, &title).save_png(png)?;
    }
    let faults = found.iter().flat_map(|(_, o)| &o.recheck.violations);
    let fault = faults.map(|v| format!("the check found at {:.3} s: {}", v.time_s, v.what)).next();
    if (report.solved || args.partial) && fault.is_none() {
        for (i, (_, outcome)) in found.iter().enumerate() {
            write(&task, &clips, outcome, &numbered(&args.out, i), &mut report.files)?;
        }
    }
    if args.variants > 1 {
        report.variants = variants(&found);
    }
    if args.json {
        output::json(&report)?
    } else {
        print(&report)?
    }
    if let Some(fault) = fault {
        return fail(format!("{fault}; nothing was written. Try another --seed, or a larger clearance_m"));
    }
    let Some(why) = report.tasks.iter().find(|t| !t.solved) else { return few(&found, args) };
    let written = if args.partial { "the rest was written" } else { "nothing was written (--partial writes the rest)" };
    fail(format!("{}: {}; {written}", why.name, why.why.as_deref().unwrap_or_default()))
}

/// One outcome, or as many different ones as were asked for.
fn outcomes(task: &Task, clips: &[ActorClip], args: &Args) -> Result<Vec<(u64, TaskOutcome)>, Box<dyn Error>> {
    let first = args.seed.unwrap_or(task.config.budget.seed);
    let mut out: Vec<(u64, TaskOutcome)> = vec![(first, task.run(clips, Some(first))?)];
    for k in 1..args.variants * SEEDS_EACH {
        if out.len() as u64 == args.variants || !out[0].1.is_solved() {
            break;
        }
        let seed = first.wrapping_add(k);
        let one = task.run(clips, Some(seed))?;
        if one.is_solved() && out.iter().all(|(_, o)| o.distance_rad(&one) > SAME_RAD) {
            out.push((seed, one));
        }
    }
    Ok(out)
}

fn few(found: &[(u64, TaskOutcome)], args: &Args) -> Outcome {
    if (found.len() as u64) < args.variants {
        let (n, tried) = (found.len(), args.variants * SEEDS_EACH);
        eprintln!("warning: {n} of {} motions: others of {tried} seeds are the same, or not solved", args.variants);
    }
    Ok(())
}

/// Sums up an outcome.
pub fn report(task: &Task, outcome: &TaskOutcome) -> Report {
    let plans: Vec<_> = outcome.done.iter().flat_map(|d| &d.plans).collect();
    // From zero, as the sum of no numbers is the negative zero.
    let sum = |of: &dyn Fn(&_) -> f64| plans.iter().map(of).fold(0.0, |sum, v| sum + v);
    let mean = |k: usize| sum(&|p| p.roughness[k].jerk_rms) / plans.len().max(1) as f64;
    let finite = |x: f64| x.is_finite().then_some(x);
    let times_s = task.times_s();
    let one = |(d, at_s): (&Done, Option<f64>)| TaskReport {
        name: d.name.clone(),
        solved: d.why.is_none(),
        why: d.why.clone(),
        nearest_m: d.nearest_m.and_then(finite),
        at_s,
        collisions: collisions(d),
    };
    Report {
        solved: outcome.is_solved(),
        tasks: outcome.done.iter().zip(times_s).map(one).collect(),
        first_solution_s: sum(&|p| p.first_solution_s),
        total_s: sum(&|p| p.total_s),
        nodes: plans.iter().map(|p| p.nodes).sum(),
        checks: plans.iter().map(|p| p.checks).sum(),
        path_length_rad: sum(&|p| p.roughness[1].length_rad),
        jerk_before: mean(0),
        jerk_after: mean(1),
        clearance_min_m: finite(outcome.recheck.clearance_min_m),
        limit_margin_rad: finite(-outcome.recheck.outside_limits_rad),
        penetration_max_m: outcome.recheck.penetration_max_m,
        gaze_off_rad: task.gaze.then_some(outcome.recheck.gaze_off_rad),
        recheck_violations: outcome.recheck.violations.len(),
        files: Vec::new(),
        variants: Vec::new(),
    }
}

/// Stretches that were corrected, and those that were not.
fn collisions(done: &Done) -> Vec<CollisionReport> {
    let left = |s: &Span| done.left.iter().find(|l| l.span == *s).map(|l| l.why.clone());
    let driven = done.left.iter().map(|l| &l.span).filter(|s| !done.spans.contains(s));
    let one = |s: &Span| CollisionReport {
        from_s: s.from_s,
        to_s: s.to_s,
        part: s.part.clone(),
        obstacle: s.with.clone(),
        depth_m: s.depth_m,
        why: left(s),
    };
    done.spans.iter().chain(driven).map(one).collect()
}

fn variants(found: &[(u64, TaskOutcome)]) -> Vec<Variant> {
    let distance = |i: usize| {
        let others = found.iter().enumerate().filter(|(k, _)| *k != i);
        others.map(|(_, (_, o))| o.distance_rad(&found[i].1)).reduce(f64::min).unwrap_or(0.0)
    };
    found.iter().enumerate().map(|(i, (seed, _))| Variant { seed: *seed, distance_rad: distance(i) }).collect()
}

/// CLIP.bvh, CLIP-2.bvh, ...
fn numbered(out: &Path, i: usize) -> PathBuf {
    match i {
        0 => out.to_path_buf(),
        _ => beside(out, &format!("-{}.bvh", i + 1)),
    }
}

/// A file beside another one: its name with another end.
fn beside(out: &Path, end: &str) -> PathBuf {
    let stem = out.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    out.with_file_name(stem + end)
}

/// Writes the clips that changed, the first one always, and what was carried.
fn write(task: &Task, clips: &[ActorClip], outcome: &TaskOutcome, out: &Path, written: &mut Vec<PathBuf>) -> Outcome {
    for (i, [before, after]) in outcome.clips.iter().enumerate() {
        if i > 0 && before == after {
            continue;
        }
        let path = if i == 0 { out.to_path_buf() } else { beside(out, &format!(".{}.bvh", task.characters[i].name)) };
        save(after, &clips[i], &path)?;
        written.push(path);
    }
    let objects = Objects { attachments: &outcome.attachments, events: &outcome.events };
    if !(objects.attachments.is_empty() && objects.events.is_empty()) {
        let path = beside(out, ".objects.json");
        files::write_atomically(&path, |w| {
            serde_json::to_writer_pretty(&mut *w, &objects)?;
            writeln!(w)
        })?;
        written.push(path);
    }
    Ok(())
}

fn save(clip: &Clip, actor: &ActorClip, path: &Path) -> Outcome {
    let raw = export::to_raw(clip, &actor.skeleton);
    Ok(files::write_atomically(path, |w| export::bvh::write(&raw, w))?)
}

fn print(r: &Report) -> Outcome {
    let mut rows: Vec<(&str, String)> = Vec::new();
    for t in &r.tasks {
        rows.push((
            if t.solved { "done" } else { "not done" },
            match &t.why {
                Some(why) => format!("{}: {why}", t.name),
                None => t.name.clone(),
            },
        ));
    }
    rows.push((
        "planned",
        format!(
            "in {:.1} ms, first ways after {:.1} ms; {} nodes, {} looks",
            1e3 * r.total_s,
            1e3 * r.first_solution_s,
            r.nodes,
            r.checks
        ),
    ));
    let number = |x: Option<f64>| x.map_or_else(|| "-".into(), |x| format!("{x:.3}"));
    rows.push((
        "motion",
        format!(
            "{:.2} rad, jerk {:.0} rad/s^3 ({:.0} before smoothing); {} m clear, {} rad within limits",
            r.path_length_rad,
            r.jerk_after,
            r.jerk_before,
            number(r.clearance_min_m),
            number(r.limit_margin_rad)
        ),
    ));
    rows.push(("check", format!("{} violations, {:.4} m deep at most", r.recheck_violations, r.penetration_max_m)));
    for v in &r.variants {
        rows.push(("variant", format!("seed {}, {:.3} rad from the most similar one", v.seed, v.distance_rad)));
    }
    rows.extend(r.files.iter().map(|f| ("written", f.display().to_string())));
    output::table(&rows)
}
