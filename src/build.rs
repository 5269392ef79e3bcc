//! `throng build`: motion files to a bundle.

use crate::args::{CacheArgs, CommandResult, SelectArgs, UnitArgs, fail, is_toml};
use crate::{help, keys, output, progress};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use throng_core::base::error::ensure;
use throng_precompute::policy::{AdaptiveReport, Approximation};
use throng_precompute::verdict::{self, Verdict};
use throng_precompute::{activities::ActivityReport, examples::BlendReport, parts::RequiredParts, report::BuildReport};
use throng_precompute::{config::BuildConfig, error::BuildError, patch::Freedom, pipeline, trial::TrialReport};

/// Bake motion files into a bundle.
///
/// From motion alone, everything that it allows is made: policies if there is walking, blows if there are some, a blend
/// space if there are steady gaits; parts that cannot be made are reported. A config names its parts, and all of them must
/// be made.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<BuildCommandReport>())]
pub struct Args {
    #[command(flatten)]
    what: BuildInputArgs,
    /// Bundle to write; the database's name with `.throng`, in the current folder, where absent.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Options that name what to build.
#[derive(clap::Args)]
pub struct BuildInputArgs {
    /// Motion: files, folders and `.zip` archives, searched to any depth, and patterns, in which `**` stands for any
    /// number of folders; or one config (`.toml`), whose schema `throng schema` prints.
    #[arg(required = true, value_name = "MOTION_OR_CONFIG")]
    what: Vec<PathBuf>,
    /// Motion in place of the config's: settings for clips that it lacks are left out, as are parts that it does not
    /// allow.
    #[arg(long, value_name = "PATH", num_args = 1..)]
    input: Vec<PathBuf>,
    /// Stop at the first bad file instead of skipping it.
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    select: SelectArgs,
    #[command(flatten)]
    units: UnitArgs,
}

/// Printed report.
#[derive(Serialize, JsonSchema)]
struct BuildCommandReport {
    #[serde(flatten)]
    build: BuildReport,
    /// Settings of the config that do not apply to the motion given in place of its own.
    replaced: Vec<String>,
    /// A short trial of the first behaviour, if it goes to a target.
    trial: Option<TrialReport>,
    /// Verdict on the trial.
    verdict: Option<Verdict>,
}

/// A build: its config, its parts, and messages on replaced motion.
pub struct BuildPlan<'a> {
    pub config: BuildConfig,
    pub parts: RequiredParts,
    /// File of the config, if there is one.
    file: Option<&'a Path>,
    /// Settings that do not apply to the motion.
    replaced: Vec<String>,
}

impl BuildPlan<'_> {
    /// Adds the file of the config to an error of the build.
    pub fn error(&self, e: BuildError) -> BuildError {
        if let Some(file) = self.file { e.in_file(file) } else { e }
    }
}

/// The build that the options name; settings that do not apply to replaced motion are reported.
pub fn plan(args: &BuildInputArgs) -> CommandResult<BuildPlan<'_>> {
    let mut plan = match (args.what.as_slice(), args.input.as_slice()) {
        ([file], input) if is_toml(file) => {
            let mut config = BuildConfig::load(file)?;
            let replaced = if input.is_empty() { Vec::new() } else { config.replace_motion(input.to_vec())? };
            let parts = if input.is_empty() || args.strict { RequiredParts::All } else { RequiredParts::Possible };
            BuildPlan { config, parts, file: Some(file), replaced }
        }
        (all, _) if all.iter().any(|p| is_toml(p)) => {
            return fail("expected motion alone or one config alone; `throng build CONFIG --input MOTION...` has both");
        }
        (_, [_, ..]) => return fail("--input is for a config: name motion without it"),
        (motion, []) => {
            let config = args.units.motion_config(motion)?;
            BuildPlan { config, parts: RequiredParts::Possible, file: None, replaced: Vec::new() }
        }
    };
    plan.config.import.strict |= args.strict;
    args.select.add_to(&mut plan.config);
    args.units.apply(&mut plan.config.import);
    plan.replaced.iter().for_each(|r| output::print_to_stderr(format_args!("config: {r}")));
    Ok(plan)
}

pub fn run(args: &Args) -> CommandResult {
    let plan = plan(&args.what)?;
    let config = &plan.config;
    let is_name = args.out.is_some() || !config.name.contains(['/', '\\']);
    ensure(is_name, || format!("the name \"{}\" is a path: name the bundle with --out", config.name))?;
    let out = args.out.clone().unwrap_or_else(|| format!("{}.throng", config.name).into());
    let bar = progress::BuildProgressBar::on_interrupt(args.cache.folder());
    let build = match plan.parts {
        RequiredParts::All => pipeline::build,
        RequiredParts::Possible => pipeline::build_possible,
    };
    let report = build(config, &out, &args.cache.cache()?, &bar);
    drop(bar);
    let report = report.map_err(|e| plan.error(e))?;
    output::warnings(&report.skipped, &report.warnings);
    let bundle = crate::args::open_bundle(&out)?;
    let (trial, verdict) = verdict::try_out(&bundle, &report.blend_spaces)?.unzip();
    if args.json {
        return output::json(&BuildCommandReport { build: report, replaced: plan.replaced, trial, verdict });
    }
    print(&report, trial.as_ref(), &out.display().to_string())?;
    if let Some(verdict) = verdict {
        output::text(format!("\n{}", verdict_text(&verdict)))?;
    }
    if bundle.policies().is_empty() && report.blend_spaces.is_empty() {
        return help::next_step(&["view", &out.to_string_lossy()]);
    }
    help::next_step(&["run", &out.to_string_lossy(), "--png", &out.with_extension("png").to_string_lossy()])
}

/// Prints the report of a build as text.
///
/// - `trial`: trial of the bundle, which shows how much of the made motion plays.
pub fn print(r: &BuildReport, trial: Option<&TrialReport>, out: &str) -> CommandResult {
    let g = &r.graph;
    let stages: Vec<_> = r.stage_s.iter().map(|(name, s)| format!("{name} {s:.2}")).collect();
    let cached = if r.cached.is_empty() { String::new() } else { format!(", from cache: {}", r.cached.join(", ")) };
    let files: usize = r.performers.iter().map(|p| p.clips.len()).sum();
    let [left, right] = [r.contacts.left_share, r.contacts.right_share].map(|share| 100.0 * share);
    let planted = format!("{:.3} m/s on average while planted", r.contacts.mean_speed_mps);
    let states = format!("{} states ({} standing)", g.states, g.standing_states);
    let actions = format!("{} actions ({:.1} a state)", g.actions, g.branching.mean);
    let segments = format!("{} segments of {:.2} s on average", g.segments, g.segment_s.mean);
    let [mean, worst] = [g.transition_error.mean, g.transition_error.max];
    let mut rows = vec![("made", r.summary())];
    rows.extend(r.not_made.iter().map(|n| ("not made", format!("{}: {}", n.part, n.why))));
    if r.made.clips > 0 {
        let plays = trial
            .and_then(|t| t.made)
            .map_or(String::new(), |m| format!("; {:.0} % of what plays on the way", 100.0 * m.share_of_moving));
        let from: Vec<&str> = r.made.gaits.iter().chain(&r.made.stances).map(String::as_str).collect();
        rows.push(("made motion", format!("{}{plays} (of {})", r.made.summary(), from.join(", "))));
    }
    rows.extend([
        ("performers", format!("{}, in {files} files", r.performers.len())),
        ("clips", format!("{} ({} skipped)", r.clips, r.skipped.len())),
        ("frames", format!("{} usable, {} kept in the component", r.frames_in, r.frames_kept)),
        ("contacts", format!("left {left:.0} %, right {right:.0} % of the frames, {planted}")),
        ("feet", format!("stand up to {}", r.contacts.stance)),
        ("hits", r.hits.to_string()),
        ("graph", format!("{states}, {actions}, {segments}")),
        ("transitions", format!("error {mean:.3} on average, {worst:.3} at worst")),
    ]);
    rows.extend(g.left_out.iter().map(|l| ("left out", l.to_string())));
    rows.extend(g.apart.iter().map(|a| ("stays out", a.to_string())));
    let plain = |m: &String| if m.is_empty() { "plain".to_owned() } else { m.clone() };
    rows.extend(g.joined.iter().map(|(manner, error)| {
        let text = format!("{} is joined by transitions of up to {error:.2} rad (`graph.join_error`)", plain(manner));
        ("manners", format!("{text}: nothing nearer leads there and back"))
    }));
    if !g.thin_manners.is_empty() {
        let thin = g.thin_manners.iter().map(plain).collect::<Vec<_>>().join(", ");
        let text = format!("{thin} change unasked: too little motion to go and stand in them alone");
        rows.push(("manners", text));
    }
    if let Some([neutral, all]) = g.scarce_neutral_s {
        let text = format!(
            "too, as only {neutral:.0} of {all:.0} s of standing are neutral: add clips of people who just stand"
        );
        rows.push(("gestures", text));
    }
    if let Some([carrying, all]) = g.mostly_carrying_s {
        rows.push(("carrying", format!("too, as {carrying:.0} of {all:.0} s of upright walking carry a load")));
    }
    if r.pose_groups > 0 {
        let frames = format!("{:.1} frames on average, {:.0} at most", r.group_frames.mean, r.group_frames.max);
        let diameters = format!("largest diameter {:.3}, threshold {}", r.max_group_diameter, r.group_threshold);
        rows.push(("pose groups", format!("{} of {frames}; {diameters}", r.pose_groups)));
    }
    for p in &r.patches {
        let content = format!("{} frames in {} runs, {} cells, {} links", p.frames, p.segments, p.cells, p.links);
        let (astray, outside) = (p.pruned_directions, p.pruned_component);
        let freedom = match p.freedom {
            Freedom::EachTile => "",
            Freedom::FurtherTiles => {
                "; no entry leads to all sides and to rest within it, but all through further tiles"
            }
        };
        let pruned = format!("({astray} pruned for a direction, {outside} outside the component)");
        rows.push(("patch", format!("{}: {content} {pruned}{freedom}", p.name)));
    }
    for p in r.patches.iter().flat_map(|p| &p.pairs) {
        let [a, b] = &p.clips;
        let what = if p.tag.is_empty() { String::new() } else { format!(" ({})", p.tag) };
        let found = match &p.refused {
            Some(why) => format!("left out: {why}"),
            None => format!("across {} edges", p.edges),
        };
        rows.push(("pair", format!("{a} and {b}{what}: {found}")));
    }
    rows.extend(r.blend_spaces.iter().flat_map(blend));
    rows.extend(activities(&r.activities));
    for p in &r.policies {
        let sweeps = format!("{} cells, {} sweeps, residual {:.1e} (measured)", p.cells, p.sweeps, p.residual);
        let bytes = output::bytes(p.bytes as u64);
        rows.push(("policy", format!("{}: {sweeps}, {bytes}, {:.2} s", p.name, p.seconds)));
        if let (Some(kept), Some(p05)) = (p.promise.kept, p.promise.kept_p05) {
            let text = format!("{:.0} % of what is promised; 5th percentile {:.0} %", 100.0 * kept, 100.0 * p05);
            rows.push(("  collects", text));
        }
        rows.extend(p.adaptive.as_ref().map_or(Vec::new(), adaptive));
    }
    rows.push(("time", format!("{:.2} s ({}{cached})", r.seconds_total, stages.join(", "))));
    let (bytes, off_mm) = (output::bytes(r.bundle_bytes), r.joint_error_worst_mm);
    rows.push(("bundle", format!("{out}, {bytes}; poses are off by at most {off_mm:.2} mm at a joint")));
    output::table(&rows)
}

/// Rows of the activities that bodies can be asked for.
pub fn activities(all: &[ActivityReport]) -> Vec<(&'static str, String)> {
    let row = |same: &[ActivityReport]| {
        let longest = same.iter().map(|a| a.duration_s).fold(0.0, f64::max);
        let looped = same.iter().filter_map(|a| a.looped_s).fold(0.0, f64::max);
        let s = if same.len() == 1 { "" } else { "s" };
        let clips = format!("{}: {} clip{s} of up to {longest:.1} s", same[0].tag, same.len());
        if looped > 0.0 { format!("{clips}, of which {looped:.1} s go on") } else { clips }
    };
    all.chunk_by(|a, b| a.tag == b.tag).map(|same| ("activity", row(same))).collect()
}

/// Rows of a blend space.
fn blend(b: &BlendReport) -> Vec<(&'static str, String)> {
    let worst = b.examples.iter().max_by(|x, y| x.closing_rad.total_cmp(&y.closing_rad));
    let seam = worst.map_or(String::new(), |e| {
        let (deg, cm) = (e.closing_rad.to_degrees(), 100.0 * e.closing_m);
        format!("; the widest seam was {deg:.1} deg a joint and {cm:.1} cm at `{}`", e.name)
    });
    let knots: Vec<_> = b.knots.iter().zip(&b.axes).map(|(k, a)| format!("{k} {a}")).collect();
    let [weight_bytes, posture_bytes] = [b.weight_table_bytes, b.posture_bytes].map(output::bytes);
    let error = format!("error {:.4} of {} allowed", b.weight_table_max_error, b.weight_tolerance);
    let weights = format!("{} knots, {weight_bytes}, {error}", knots.join(" x "));
    let turn = format!("joints turn up to {:.0} deg from their references", b.max_displacement_rad.to_degrees());
    let postures = format!("{} phases, {posture_bytes}; {turn}{seam}", b.phases);
    let mut rows = blend_summary(b);
    if !b.refused.is_empty() {
        let some: Vec<_> = b.refused.iter().take(3).map(|(clip, why)| format!("`{clip}`: {why}")).collect();
        let more = if b.refused.len() > 3 { "; ..." } else { "" };
        rows.push(("  without", format!("{} clips: {}{more}", b.refused.len(), some.join("; "))));
    }
    rows.extend([("  weights", weights), ("  postures", postures)]);
    rows
}

/// Rows of a blend space that say how good it is and which clips it was made from.
pub fn blend_summary(b: &BlendReport) -> Vec<(&'static str, String)> {
    let q = &b.quality;
    let reason = if q.reason.is_empty() { String::new() } else { format!(" ({})", q.reason) };
    let [slip, own] = [q.slip_p95_mps, q.example_slip_p95_mps].map(|mps| 1000.0 * mps);
    let (num, alike, clips) = (b.examples.len(), b.left_out, b.clips());
    let some = clips.iter().take(8).copied().collect::<Vec<_>>().join(", ");
    let more = if clips.len() > 8 { ", ..." } else { "" };
    let alike = if alike > 0 { format!(" ({alike} alike left out)") } else { String::new() };
    let made = format!("{num} examples{alike} of {} clips: {some}{more}", clips.len());
    let quality = format!(
        "soles slip {slip:.0} mm/s before feet are locked ({own:.0} in the examples), joints are {:.0} deg beyond their limits, \
         blends within {:.0} deg a joint of an example, {:.0} % of the parameters lie between examples",
        q.beyond_limits_deg,
        q.unlike_deg,
        100.0 * q.reached
    );
    vec![("blend space", format!("{}: {}{reason}; {made}", b.name, q.word)), ("  quality", quality)]
}

/// Rows of the loss of an adaptive policy, one for each method of storage.
fn adaptive(r: &AdaptiveReport) -> Vec<(&'static str, String)> {
    let row = |name: &'static str, a: &Approximation| {
        let [rings, angles, heights] = a.counts;
        let [own, finest] = [a.bytes, r.finest_bytes].map(|n| output::bytes(n as u64));
        let grids = format!("{rings:.1} rings, {angles:.1} angles, {heights:.1} heights a state");
        let (value, mean, p95, worst) = (r.mean_value, a.mean_error, a.p95_error, a.max_error);
        let off = format!("{mean:.4} on average, {p95:.4} at the 95th percentile, {worst:.3} at worst");
        let [others, loss] = [a.changed_share, a.mean_loss].map(|share| 100.0 * share);
        let lost = format!("{others:.1} % other decisions lose {loss:.2} %");
        (name, format!("{own} of {finest} ({grids}); values of {value:.3} are off by {off}; {lost}"))
    };
    vec![row("  adaptive", &r.adaptive), row("  or uniform", &r.uniform), row("  uniform, fitted", &r.uniform_fitted)]
}

/// A verdict as text.
pub fn verdict_text(verdict: &Verdict) -> String {
    let mut text = format!("verdict  {}.\n", verdict.sentences.join(";\n         "));
    verdict.advice.iter().for_each(|advice| _ = writeln!(text, "advice   {advice}."));
    text
}
