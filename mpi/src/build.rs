//! `throng-mpi build`: one bundle by several processes.

use crate::progress::Lines;
use crate::{Outcome, print_json};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::memory;
use throng_precompute::parts::Parts;
use throng_precompute::pipeline;
use throng_precompute::progress::{Progress, Silent};
use throng_precompute::report::BuildReport;
use throng_runtime::base::Comm;

/// Bake the motion of a config into a bundle in several processes.
///
/// The bundle is that of `throng build`, byte by byte. Processes share the work on single files, where there is a cache, the
/// search for frames that are alike, pose groups and policies. JSON keys: those of `throng build`, of the first process, and
/// ranks, bytes_moved, seconds, of_ranks[] (busy_s, bytes_moved, peak_bytes).
#[derive(clap::Args)]
pub struct Args {
    /// Config (`.toml`), as `throng build` takes it.
    #[arg(value_name = "CONFIG")]
    config: PathBuf,
    /// Bundle to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Folder that keeps the outputs of stages, the same one for all processes, or s3://BUCKET/PREFIX in programs built for it.
    #[arg(long, value_name = "DIR", default_value = Cache::FOLDER)]
    cache: PathBuf,
    /// Most that a folder may keep, in GB; what was not used for longest makes room.
    #[arg(long, value_name = "GB", default_value_t = Cache::LIMIT_BYTES as f64 / 1e9, value_parser = Cache::parse_gb)]
    cache_limit: f64,
    /// Run every stage, and keep nothing: every process reads all files then.
    #[arg(long)]
    no_cache: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What is printed.
#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    build: BuildReport,
    ranks: usize,
    seconds: f64,
    bytes_moved: u64,
    of_ranks: Vec<RankReport>,
}

/// What one process did.
#[derive(Serialize)]
struct RankReport {
    busy_s: f64,
    bytes_moved: u64,
    peak_bytes: u64,
}

pub fn run(args: &Args, comm: &dyn Comm) -> Outcome {
    let begin = Instant::now();
    let config = BuildConfig::load(&args.config)?;
    let cache = match args.no_cache {
        true => Cache::none(),
        false => Cache::at(&args.cache, (args.cache_limit * 1e9) as u64)?,
    };
    let progress: Box<dyn Progress> = if comm.rank() == 0 { Box::new(Lines::new(args.json)) } else { Box::new(Silent) };
    let build = pipeline::build_shared(&config, Parts::All, &args.out, &cache, &*progress, comm);
    let build = build.map_err(|e| e.in_file(&args.config))?;
    let (seconds, traffic) = (begin.elapsed().as_secs_f64(), comm.traffic());
    let busy_s = comm.all_numbers(seconds - traffic.waited_s)?;
    let moved = comm.all_numbers(traffic.bytes_moved as f64)?;
    let peaks = comm.all_numbers(memory::peak_bytes().unwrap_or(0) as f64)?;
    if comm.rank() > 0 {
        return Ok(());
    }
    let of_rank = |rank: usize| RankReport {
        busy_s: busy_s[rank],
        bytes_moved: moved[rank] as u64,
        peak_bytes: peaks[rank] as u64,
    };
    let of_ranks: Vec<RankReport> = (0..comm.num_ranks()).map(of_rank).collect();
    let bytes_moved = of_ranks.iter().map(|r| r.bytes_moved).sum();
    let report = Report { build, ranks: comm.num_ranks(), seconds, bytes_moved, of_ranks };
    if args.json {
        return print_json(&report);
    }
    for told in report.build.skipped.iter().chain(&report.build.warnings) {
        eprintln!("warning: {told}");
    }
    println!("made      {}", report.build.made());
    println!("bundle    {}, {} bytes", args.out.display(), report.build.bundle_bytes);
    let stages: Vec<_> = report.build.stage_s.iter().map(|(name, s)| format!("{name} {s:.2}")).collect();
    println!("time      {seconds:.2} s in {} processes ({})", report.ranks, stages.join(", "));
    if !report.build.cached.is_empty() {
        println!("cached    {}", report.build.cached.join(", "));
    }
    let slowest = report.of_ranks.iter().map(|r| r.busy_s).fold(0.0, f64::max);
    for (rank, of) in report.of_ranks.iter().enumerate() {
        let (moved, peak) = (of.bytes_moved as f64 / 1e6, of.peak_bytes as f64 / 1e6);
        let mark = if of.busy_s == slowest && report.ranks > 1 { ", the slowest" } else { "" };
        println!(
            "rank {rank:<4} busy for {:.2} s{mark}, sent {moved:.1} MB, at most {peak:.0} MB of memory",
            of.busy_s
        );
    }
    Ok(())
}
