//! `throng synth`: synthetic motion as ordinary files.

use crate::{args::CommandResult, help, keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use throng_core::base::{Hash128, limits};
use throng_precompute::import;
use throng_precompute::synth::{self, SynthConfig, SynthSet};

/// Write synthetic motion as BVH files, with its events as tags in sidecars.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<SynthReport>())]
pub struct Args {
    /// Name of the set: `walk` (wandering with turns, stops and starts), `boxing` (shadow-boxing with footwork, combinations
    /// and defences), `playground` (stairs, a ladder, slides), `office` (standing, talking, sitting, working), `people`
    /// (what people do when they stand: greet, shake hands, buy, chat, sit down, take things and put them down) or `locomotion` (steady gaits: walk, jog, run,
    /// turn, side and back steps, standing; each in three manners).
    #[arg(long, default_value = "walk")]
    set: String,
    /// Folder to write to; made if it is missing.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Length of the set in minutes; the default depends on the set. The locomotion set is a list of clips of 4 s: below
    /// 15 minutes it is cut short, above it holds further takes.
    #[arg(long, value_parser = limits::number_parser::<f64>(&limits::SYNTH_MINUTES))]
    minutes: Option<f64>,
    /// Hours of motion in place of `--minutes`, for large databases: a folder such as `hour_0001` for every hour, each with
    /// its own seed, derived from `--seed`. Memory is that of one hour.
    #[arg(long, conflicts_with = "minutes", value_parser = limits::number_parser::<f64>(&limits::SYNTH_HOURS))]
    hours: Option<f64>,
    /// Same seed, same motion.
    #[arg(long, default_value_t = SynthConfig::default().seed, value_parser = limits::number_parser::<u64>(&limits::SEED))]
    seed: u64,
    /// Frames a second.
    #[arg(long, default_value_t = SynthConfig::default().rate_hz, value_name = "HZ", value_parser = limits::number_parser::<f64>(&limits::RATE_HZ))]
    rate_hz: f64,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize, JsonSchema)]
struct SynthReport {
    /// Name of the set.
    set: String,
    /// Clips written.
    clips: usize,
    /// Frames of all clips.
    frames: usize,
    /// Length of all clips (s).
    seconds: f64,
    /// Folder that they were written to.
    out: PathBuf,
}

pub fn run(args: &Args) -> CommandResult {
    let which = SynthSet::from_name(&args.set)?;
    let usual = SynthConfig::for_set(which);
    let sets = match args.hours {
        Some(hours) => hourly_sets(args, hours),
        None => vec![(args.out.clone(), args.minutes.unwrap_or(usual.minutes), args.seed)],
    };
    let (mut clips, mut frames) = (0, 0);
    for (folder, minutes, seed) in sets {
        let config = SynthConfig { minutes, seed, rate_hz: args.rate_hz, ..usual };
        let set = synth::write_set(which, &config, &folder)?;
        (clips, frames) = (clips + set.clips.len(), frames + set.num_frames());
    }
    let there = import::expand(std::slice::from_ref(&args.out))?.len();
    if there > clips {
        let others = format!("{} other motion file(s) are there", there - clips);
        let folder = args.out.display();
        output::print_to_stderr(format_args!("{folder}: {others}, and a build of the folder takes them, too"));
    }
    let seconds = frames as f64 / args.rate_hz;
    let report = SynthReport { set: args.set.clone(), clips, frames, seconds, out: args.out.clone() };
    if args.json {
        return output::json(&report);
    }
    let written = format!("{clips} clips, {frames} frames, {seconds:.0} s, to {}", args.out.display());
    output::table(&[("written", written)])?;
    help::next_step(&["build", &args.out.to_string_lossy()])
}

/// Folder, length and seed of every hour; the last one may be shorter.
fn hourly_sets(args: &Args, hours: f64) -> Vec<(PathBuf, f64, u64)> {
    let hour = |k: u64| {
        let minutes = (60.0 * (hours - k as f64)).clamp(limits::SYNTH_MINUTES.least, 60.0);
        let seed = Hash128::hash_bytes(&[args.seed.to_le_bytes(), k.to_le_bytes()].concat()) as u64;
        (args.out.join(format!("hour_{:04}", k + 1)), minutes, seed)
    };
    (0..hours.ceil() as u64).map(hour).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use std::collections::BTreeSet;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    #[test]
    fn every_hour_has_a_folder_and_a_seed_of_its_own() {
        let of = |seed: &str, hours: &str| {
            hourly_sets(
                &Line::parse_from(["synth", "--out", "x", "--seed", seed]).args,
                hours.parse().expect("a number"),
            )
        };
        let sets = of("1", "2.5");
        let minutes: Vec<f64> = sets.iter().map(|s| s.1).collect();
        assert_eq!(minutes, [60.0, 60.0, 30.0]);
        assert_eq!(sets[2].0, PathBuf::from("x/hour_0003"));
        let all = ["0", "1", "2", "3"].iter().flat_map(|seed| of(seed, "100")).map(|s| s.2);
        assert_eq!(all.collect::<BTreeSet<_>>().len(), 400);
        assert_eq!(of("1", "0.001")[0].1, 0.06);
    }
}
