//! `throng build`: motion files to a bundle.

use crate::args::{CacheArgs, Outcome, fail};
use crate::{keys, output, progress};
use std::path::PathBuf;
use throng_precompute::config::BuildConfig;
use throng_precompute::examples::BlendReport;
use throng_precompute::files;
use throng_precompute::pipeline;
use throng_precompute::policy::{AdaptiveReport, Approximation};
use throng_precompute::report::{self, BuildReport};

/// Bake motion files into a bundle.
#[derive(clap::Args)]
#[command(after_long_help = keys::of::<BuildReport>())]
pub struct Args {
    /// Config (TOML); `throng schema` prints what it may hold.
    config: PathBuf,
    /// Bundle to write; the database's name with `.throng`, in the current folder, where absent.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Motion files, folders or patterns instead of the config's.
    #[arg(long, value_name = "PATH", num_args = 1..)]
    input: Vec<PathBuf>,
    /// Stop at the first bad file instead of skipping it.
    #[arg(long)]
    strict: bool,
    /// Write the figures beside those of Lee and Lee (2004), as Markdown.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let mut config = BuildConfig::load(&args.config)?;
    config.import.strict |= args.strict;
    if !args.input.is_empty() {
        config.inputs.clone_from(&args.input);
        config.synth = None;
    }
    let out = match &args.out {
        Some(out) => out.clone(),
        None if config.name.contains(['/', '\\']) => {
            return fail(format!("the name \"{}\" is a path: name the bundle with --out", config.name));
        }
        None => PathBuf::from(format!("{}.throng", config.name)),
    };
    let report = pipeline::build(&config, &out, &args.cache.cache(), &progress::Bar::default());
    let report = report.map_err(|e| e.in_file(&args.config))?;
    output::warnings(&report.skipped, &report.warnings);
    if let Some(path) = &args.report {
        let text = report::markdown(&report);
        files::write_atomically(path, |w| w.write_all(text.as_bytes()))?;
    }
    if args.json { output::json(&report) } else { print(&report, &out.display().to_string()) }
}

/// What was built, for people.
pub fn print(r: &BuildReport, out: &str) -> Outcome {
    let g = &r.graph;
    let stages: Vec<_> = r.stage_s.iter().map(|(name, s)| format!("{name} {s:.2}")).collect();
    let cached = if r.cached.is_empty() { String::new() } else { format!(", from cache: {}", r.cached.join(", ")) };
    let mut rows = vec![
        ("clips", format!("{} ({} skipped)", r.clips, r.skipped.len())),
        ("frames", format!("{} usable, {} kept in the component", r.frames_in, r.frames_kept)),
        (
            "contacts",
            format!(
                "left {:.0} %, right {:.0} % of the frames, {:.3} m/s on average while planted",
                100.0 * r.contacts.left_share,
                100.0 * r.contacts.right_share,
                r.contacts.mean_speed_mps
            ),
        ),
        ("hits", r.hits.to_string()),
        (
            "graph",
            format!(
                "{} states ({} standing), {} actions ({:.1} a state), {} segments of {:.2} s on average",
                g.states, g.standing_states, g.actions, g.branching.mean, g.segments, g.segment_s.mean
            ),
        ),
        (
            "transitions",
            format!("error {:.3} on average, {:.3} at worst", g.transition_error.mean, g.transition_error.max),
        ),
    ];
    if r.pose_groups > 0 {
        let text = format!(
            "{} of {:.1} frames on average, {:.0} at most; largest diameter {:.3}, threshold {}",
            r.pose_groups, r.group_frames.mean, r.group_frames.max, r.max_group_diameter, r.group_threshold
        );
        rows.push(("pose groups", text));
    }
    for p in &r.patches {
        rows.push((
            "patch",
            format!(
                "{}: {} frames in {} runs, {} cells, {} links ({} pruned for a direction, {} outside the component)",
                p.name, p.frames, p.segments, p.cells, p.links, p.pruned_directions, p.pruned_component
            ),
        ));
    }
    rows.extend(r.blend_spaces.iter().flat_map(blend));
    for p in &r.policies {
        rows.push((
            "policy",
            format!(
                "{}: {} cells, {} sweeps, residual {:.1e} (measured), {}, {:.2} s",
                p.name,
                p.cells,
                p.sweeps,
                p.residual,
                output::bytes(p.bytes as u64),
                p.seconds
            ),
        ));
        rows.extend(p.adaptive.as_ref().map_or(Vec::new(), adaptive));
    }
    rows.push(("time", format!("{:.2} s ({}{cached})", r.seconds_total, stages.join(", "))));
    rows.push(("bundle", format!("{out}, {}", output::bytes(r.bundle_bytes))));
    output::table(&rows)?;
    if r.hits.count > 0 {
        output::text("\n")?;
        let lines = report::beside_paper(r);
        output::columns(["", "Lee and Lee 2004", "this build"], lines.iter().map(|l| [&*l.figure, l.paper, &*l.here]))?;
    }
    Ok(())
}

/// Rows of a blend space.
fn blend(b: &BlendReport) -> [(&'static str, String); 3] {
    let worst = b.examples.iter().max_by(|x, y| x.closing_rad.total_cmp(&y.closing_rad));
    let seam = worst.map_or(String::new(), |e| {
        let (deg, cm) = (e.closing_rad.to_degrees(), 100.0 * e.closing_m);
        format!("; the widest seam was {deg:.1} deg a joint and {cm:.1} cm at `{}`", e.name)
    });
    let knots: Vec<_> = b.knots.iter().zip(&b.axes).map(|(k, a)| format!("{k} {a}")).collect();
    let weights = format!(
        "{} knots, {}, error {:.4} of {} allowed",
        knots.join(" x "),
        output::bytes(b.weight_table_bytes),
        b.weight_table_max_error,
        b.weight_tolerance
    );
    let postures = format!(
        "{} phases, {}; joints turn up to {:.0} deg from their references",
        b.phases,
        output::bytes(b.posture_bytes),
        b.max_displacement_rad.to_degrees()
    );
    let examples = format!("{}: {} examples ({} alike left out){seam}", b.name, b.examples.len(), b.left_out);
    [("blend space", examples), ("  weights", weights), ("  postures", postures)]
}

/// What an adaptive policy loses, one row for each way to store it.
fn adaptive(r: &AdaptiveReport) -> Vec<(&'static str, String)> {
    let row = |name: &'static str, a: &Approximation| {
        let [rings, angles, heights] = a.counts;
        let text = format!(
            "{} of {} ({rings:.1} rings, {angles:.1} angles, {heights:.1} heights a state); values of {:.3} are off by \
             {:.4} on average, {:.4} at the 95th percentile, {:.3} at worst; {:.1} % other decisions lose {:.2} %",
            output::bytes(a.bytes as u64),
            output::bytes(r.finest_bytes as u64),
            r.mean_value,
            a.mean_error,
            a.p95_error,
            a.max_error,
            100.0 * a.changed_share,
            100.0 * a.mean_loss
        );
        (name, text)
    };
    vec![row("  adaptive", &r.adaptive), row("  or uniform", &r.uniform), row("  uniform, fitted", &r.uniform_fitted)]
}
