//! Takes of scenes, recordings, bundles and clips, written in the formats of other programs.

use super::{Args, Format, holds_motion, retargeted_clip, write};
use crate::args::{CacheArgs, CommandResult, fail, given_flags, is_bundle, is_toml, load_scene, open_bundle};
use crate::{output, progress};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use throng_core::{base::error::ensure, base::limits};
use throng_precompute::export::{Glb, Take, bvh, take_csv, usda, write_amass, write_each_actor, write_npz};
use throng_precompute::perform::{self, PerformConfig, PerformSource, perform};
use throng_precompute::{files, run::RunRecording, trial::TrialConfig, wearer::Wearer};

/// Options of takes.
#[derive(clap::Args)]
pub struct TakeArgs {
    /// Numbers of characters, or of clips with --clips: 7, 0..99 (both included), or a list such as 0,4,7..9; all with
    /// bodies by default.
    #[arg(long, value_name = "N..N", value_parser = parse_range, value_delimiter = ',')]
    characters: Vec<RangeInclusive<usize>>,
    /// First moment (s); the start by default.
    #[arg(long, value_name = "S", value_parser = limits::number_parser::<f64>(&limits::MOMENT_S))]
    from: Option<f64>,
    /// Last moment (s); by default the end of the scene or the recording, or 20 s of a bundle.
    #[arg(long, value_name = "S", value_parser = limits::number_parser::<f64>(&limits::MOMENT_S))]
    to: Option<f64>,
    /// Frames a second, 1 to 1000; 30 by default.
    #[arg(long, help_heading = "Takes", value_name = "N", value_parser = limits::number_parser::<f64>(&limits::EXPORT_HZ))]
    fps: Option<f64>,
    /// For a bundle, write its clips instead of characters that run on it.
    #[arg(long, help_heading = "Takes")]
    clips: bool,
    /// With `usda`, write characters as instances of one model, as crowd renderers prefer (still in Blender).
    #[arg(long, help_heading = "Takes")]
    usd_instances: bool,
    /// With `glb`, your own character (.glb with a skin) to wear the motion: its joints are found as those of motion
    /// files, and its size follows from the motion's legs.
    #[arg(long, help_heading = "Takes", value_name = "CHARACTER.glb")]
    onto: Option<PathBuf>,
    /// Read only files beside a stranger's scene or below, and build nothing.
    #[arg(long, help_heading = "Takes", hide_short_help = true)]
    untrusted: bool,
    #[command(flatten)]
    cache: CacheArgs,
}

/// Reads a range of numbers, both ends included.
fn parse_range(text: &str) -> Result<RangeInclusive<usize>, String> {
    let number = |t: &str| t.trim().parse::<usize>().ok();
    let range = match text.split_once("..") {
        Some((a, b)) => number(a).zip(number(b.trim_start_matches('='))).map(|(a, b)| a..=b),
        None => number(text).map(|n| n..=n),
    };
    let fault = "expected a number, or two such as 0..99, the smaller one first";
    range.filter(|r| !r.is_empty()).ok_or_else(|| fault.into())
}

/// Flags that only apply to takes; the last one, to those of clips as well.
pub const FLAGS: [&str; 7] = ["--characters", "--from", "--to", "--fps", "--clips", "--usd-instances", "--onto"];

impl TakeArgs {
    fn config(&self) -> PerformConfig {
        let characters = self.characters.clone();
        PerformConfig { characters, from_s: self.from, to_s: self.to, rate_hz: self.fps }
    }
}

/// Writes a take.
pub fn run(args: &Args) -> CommandResult {
    let (takes, file) = (&args.take, args.file.display());
    let [is_usda, is_glb] = [matches!(args.format, Format::Usda), matches!(args.format, Format::Glb)];
    ensure(is_usda || !takes.usd_instances, || "--usd-instances is for --format usda")?;
    let fault = "--onto is for --format glb; Blender and other programs turn such a file into USD";
    ensure(is_glb || takes.onto.is_none(), || fault)?;
    ensure(!takes.clips || is_bundle(&args.file), || format!("{file}: --clips is for bundles (.throng)"))?;
    let has_place = args.out.is_some() || matches!(args.format, Format::Csv);
    let fault = "name a file to write with --out; of what runs, only csv goes to standard output";
    ensure(has_place, || format!("{file}: {fault}"))?;
    files::check_targets(&args.out, [&args.file].into_iter().chain(&takes.onto))?;
    let out = args.out.as_deref();
    // Beside the output, where there is room and no memory file system.
    let temporary = std::env::temp_dir();
    let folder = out.map_or(temporary.as_path(), files::folder_of);
    // Read before long work, as it may not be a character.
    let wear = |character: &PathBuf| CommandResult::Ok(Wearer::open(character, &args.read.config()?.import)?);
    let wearer = takes.onto.as_ref().map(wear).transpose()?;
    if let (Format::Instances, Some(out)) = (args.format, out) {
        return instances(args, folder, out);
    }
    let take = record_take(args, folder)?;
    save(args, &take, out, wearer.as_ref(), folder)
}

/// Runs the input and records the take.
fn record_take(args: &Args, folder: &Path) -> CommandResult<Take> {
    let (file, config, bar) = (&args.file, args.take.config(), progress::BuildProgressBar::default());
    let show =
        |show: PerformSource<'_>| perform(show, &config, folder, &bar).map_err(|e| format!("{}: {e}", file.display()));
    if is_toml(file) {
        let scene = load_scene(file, args.take.untrusted)?;
        crate::run::ensure_scene(&scene, &args.take.cache)?;
        return Ok(show(PerformSource::Scene(&scene.open()?))?);
    }
    if is_bundle(file) {
        let (bundle, trial) = (open_bundle(file)?, TrialConfig::default());
        let clips = args.take.clips;
        return Ok(show(if clips { PerformSource::Clips(&bundle) } else { PerformSource::Trial(&bundle, &trial) })?);
    }
    if holds_motion(file) {
        return clip(args, folder);
    }
    let recording = RunRecording::load(file)?;
    let scene = recording.scene()?;
    crate::run::ensure_scene(&scene, &args.take.cache)?;
    Ok(show(PerformSource::Recording(&recording, &scene.open()?))?)
}

/// Writes the clips that play on characters of a bundle.
fn instances(args: &Args, folder: &Path, out: &Path) -> CommandResult {
    let file = args.file.display();
    let fault = "instances are of bundles (.throng): which of their clips play on characters who run on them";
    ensure(is_bundle(&args.file) && !args.take.clips, || format!("{file}: {fault}"))?;
    let bundle = open_bundle(&args.file)?;
    let (trial, bar) = (TrialConfig::default(), progress::BuildProgressBar::default());
    let played = perform::record_instances(&bundle, &trial, &args.take.config(), folder, &bar);
    let played = played.map_err(|e| format!("{file}: {e}"))?;
    files::write_atomically(out, |w| played.npz(w))?;
    let (who, frames, hz) = (played.num_characters(), played.num_frames(), played.rate_hz());
    let bytes = output::bytes(std::fs::metadata(out).map_or(0, |m| m.len()));
    output::text(format!("{}: {who} character(s), {frames} frames at {hz} Hz, {bytes}\n", out.display()))
}

/// The clip of a motion file on the database skeleton, as a build would use it.
fn clip(args: &Args, folder: &Path) -> CommandResult<Take> {
    if let Some(flag) = given_flags(&FLAGS[..FLAGS.len() - 1]).first() {
        return fail(format!("{}: {flag} is for scenes, recordings and bundles", args.file.display()));
    }
    let set = retargeted_clip(args)?;
    Ok(Take::from_clips(folder, &set.clips[..1], &set.skeleton)?)
}

/// Writes a take in a format, and prints the files.
fn save(args: &Args, take: &Take, out: Option<&Path>, wearer: Option<&Wearer>, folder: &Path) -> CommandResult {
    let mut written = Vec::new();
    match (args.format, out) {
        (Format::Csv, _) => write(out, |w| take_csv(take, w))?,
        (_, None) => {}
        (Format::Glb, Some(out)) => {
            wearer.map_or(Ok(()), |wearer| check_worn(args, wearer, take))?;
            let outfit = wearer.map(|w| w.dress(take, folder, &progress::BuildProgressBar::default())).transpose()?;
            let glb = outfit.as_ref().map_or_else(|| Glb::new(take), |o| o.glb(take))?;
            files::write_atomically(out, |w| glb.write(w))?;
        }
        (Format::Usda, Some(out)) => {
            files::write_atomically(out, |w| usda(take, args.take.usd_instances, w))?;
        }
        (Format::Npz, Some(out)) => files::write_atomically(out, |w| write_npz(take, w))?,
        (Format::Bvh, Some(out)) => written = write_each_actor(take, out, |a, w| bvh::write_actor(take, a, w))?,
        (Format::Amass, Some(out)) => written = write_each_actor(take, out, |a, w| write_amass(take, a, w))?,
        // Written by other modules.
        (Format::Instances | Format::PositionsCsv | Format::GraphJson | Format::PolicyCsv | Format::HitsCsv, _) => {}
    }
    let Some(out) = out else { return Ok(()) };
    wearer.map_or(Ok(()), print_worn_joints)?;
    if written.is_empty() {
        written.push(out.to_path_buf());
    }
    let bytes = written.iter().filter_map(|f| std::fs::metadata(f).ok()).map(|m| m.len()).sum();
    let what = if take.is_library() { "clip(s)" } else { "character(s)" };
    let (who, frames, hz) = (take.actors().len(), take.longest(), take.rate_hz());
    let files = match written.as_slice() {
        [first, .., last] => format!("{} to {}", first.display(), last.display()),
        _ => out.display().to_string(),
    };
    output::text(format!("{files}: {who} {what}, {frames} frames at {hz} Hz, {}\n", output::bytes(bytes)))
}

/// Measures how a character wears a take, prints it, and refuses what is torn or sunk.
fn check_worn(args: &Args, wearer: &Wearer, take: &Take) -> CommandResult {
    let Some(fit) = wearer.measure(take)? else {
        return output::text("its triangles cannot be read here: stretch and soles are not measured\n");
    };
    if let (Some(fault), Some(character)) = (fit.fault(), &args.take.onto) {
        return fail(format!("{}: {fault}", character.display()));
    }
    let cm = |m: f32| 100.0 * m;
    output::text(format!(
        "worn {:.2} m tall: skin stretched by {:.1} cm at most; soles {:.1} cm over the ground where feet stand, {:.1} cm \
         off at worst (95 %)\n",
        fit.height_m,
        cm(fit.stretch_m),
        cm(fit.soles_m),
        cm(fit.soles_off_m)
    ))
}

/// Prints which joints of a character wear the motion.
fn print_worn_joints(wearer: &Wearer) -> CommandResult {
    let pairs: Vec<String> = wearer.pairs().map(|(role, joint)| format!("{}={joint}", role.name())).collect();
    let twists: Vec<&str> = wearer.twists().collect();
    let twists = if twists.is_empty() { "none".into() } else { twists.join(" ") };
    let (all, moved) = (wearer.num_joints(), pairs.len());
    output::text(format!("{moved} of {all} joints wear the motion: {}\ntwist joints: {twists}\n", pairs.join(" ")))
}
