//! `throng synth`: synthetic motion as ordinary files.

use crate::args::Outcome;
use crate::{keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_runtime::base::limits;

/// Write synthetic motion as BVH files, with what happens in it as tags in sidecars.
#[derive(clap::Args)]
#[command(after_long_help = keys::of::<Report>())]
pub struct Args {
    /// Which set: `walk` (wandering with turns, stops and starts), `boxing` (shadow-boxing with footwork, combinations
    /// and defences), `playground` (stairs, a ladder, slides), `office` (standing, talking, sitting, working) or
    /// `locomotion` (steady gaits: walk, jog, run, turn, side and back steps, standing; each in three manners).
    #[arg(long, default_value = "walk")]
    set: String,
    /// Folder to write to; made if it is not there.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Length of the set in minutes; the default depends on the set. The locomotion set is a list of clips of 4 s: below
    /// 15 minutes it is cut short, above it holds further takes.
    #[arg(long, allow_negative_numbers = true, value_parser = limits::number::<f64>(&limits::SYNTH_MINUTES))]
    minutes: Option<f64>,
    /// Same seed, same motion.
    #[arg(long, default_value_t = SynthConfig::default().seed, allow_negative_numbers = true, value_parser = limits::number::<u64>(&limits::SEED))]
    seed: u64,
    /// Frames a second.
    #[arg(long, default_value_t = SynthConfig::default().rate_hz, value_name = "HZ", allow_negative_numbers = true, value_parser = limits::number::<f64>(&limits::RATE_HZ))]
    rate_hz: f64,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize, JsonSchema)]
struct Report {
    /// Name of the set.
    set: String,
    /// Clips written.
    clips: usize,
    /// Frames of all clips.
    frames: usize,
    /// Length of all clips (s).
    seconds: f64,
    /// Folder they were written to.
    out: PathBuf,
}

pub fn run(args: &Args) -> Outcome {
    let which = SynthSet::from_name(&args.set)?;
    let usual = SynthConfig::for_set(which);
    let minutes = args.minutes.unwrap_or(usual.minutes);
    let config = SynthConfig { minutes, seed: args.seed, rate_hz: args.rate_hz, ..usual };
    let set = synth::write(which, &config, &args.out)?;
    let frames = set.num_frames();
    let report = Report {
        set: args.set.clone(),
        clips: set.clips.len(),
        frames,
        seconds: frames as f64 / args.rate_hz,
        out: args.out.clone(),
    };
    if args.json {
        return output::json(&report);
    }
    output::table(&[(
        "written",
        format!("{} clips, {} frames, {:.0} s, to {}", report.clips, frames, report.seconds, args.out.display()),
    )])
}
