//! `throng-mpi build`: one bundle by several processes.

use crate::progress::{ProgressLines, RankStatuses};
use crate::{MpiResult, print_json};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::{collections::BTreeMap, sync::Arc, time::Instant};
use throng_core::base::text::escape_for_terminal;
use throng_core::base::{Comm, limits, unexpected_message};
use throng_precompute::report::{BuildReport, StageCost};
use throng_precompute::{cache::Cache, config::BuildConfig, memory, parts::RequiredParts, pipeline};

/// Bake the motion of a config into a bundle in several processes.
///
/// The bundle is that of `throng build`, byte by byte. Processes share the work on single files, where there is a cache, the
/// search for frames that are alike, pose groups and policies. JSON keys: those of `throng build`, of the first process, and
/// ranks, bytes_moved, seconds, of_ranks[] (busy_s, ran_s, bytes_moved, peak_bytes, stages{} (wall_s, waited_s, ran_s, peak_bytes,
/// bytes_moved)).
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
    /// Greatest size of the folder, in GB; the least recently used entries are removed first.
    #[arg(
        long,
        value_name = "GB",
        default_value_t = Cache::LIMIT_BYTES as f64 / 1e9,
        allow_negative_numbers = true,
        value_parser = limits::number_parser::<f64>(&limits::CACHE_GB)
    )]
    cache_limit: f64,
    /// Run every stage, and keep nothing: every process reads all files then.
    #[arg(long)]
    no_cache: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Printed report.
#[derive(Serialize)]
struct MpiBuildReport {
    #[serde(flatten)]
    build: BuildReport,
    ranks: usize,
    seconds: f64,
    bytes_moved: u64,
    of_ranks: Vec<RankReport>,
}

/// Cost of one process.
#[derive(Serialize, Deserialize)]
struct RankReport {
    /// Time without waiting for others (s).
    busy_s: f64,
    /// Processor time without waiting (s).
    ran_s: Option<f64>,
    bytes_moved: u64,
    peak_bytes: u64,
    stages: BTreeMap<String, StageCost>,
}

pub fn run(args: &Args, comm: &dyn Comm, statuses: &Arc<dyn RankStatuses>) -> MpiResult {
    let begin = Instant::now();
    let config = BuildConfig::load(&args.config)?;
    let cache = match args.no_cache {
        true => Cache::disabled(),
        false => Cache::at_address(&args.cache, (args.cache_limit * 1e9) as u64)?,
    };
    let progress = ProgressLines::new(args.json, comm.rank(), statuses);
    let build = pipeline::build_shared(&config, RequiredParts::All, &args.out, &cache, &progress, comm);
    let build = build.map_err(|e| e.in_file(&args.config))?;
    drop(progress);
    let (seconds, traffic) = (begin.elapsed().as_secs_f64(), comm.traffic());
    let own = RankReport {
        busy_s: seconds - traffic.waited_s,
        ran_s: comm.cpu_s(),
        bytes_moved: traffic.bytes_moved,
        peak_bytes: memory::peak_bytes().unwrap_or(0),
        stages: build.spent.iter().map(|(stage, spent)| ((*stage).to_owned(), *spent)).collect(),
    };
    let all = comm.all_gather(&serde_json::to_vec(&own)?)?;
    if comm.rank() > 0 {
        return Ok(());
    }
    let read = |(rank, bytes): (usize, &Vec<u8>)| serde_json::from_slice(bytes).map_err(|_| unexpected_message(rank));
    let of_ranks: Vec<RankReport> = all.iter().enumerate().map(read).collect::<Result<_, _>>()?;
    let bytes_moved = of_ranks.iter().map(|r| r.bytes_moved).sum();
    let report = MpiBuildReport { build, ranks: comm.num_ranks(), seconds, bytes_moved, of_ranks };
    if args.json { print_json(&report) } else { print(&report, &args.out) }
}

fn print(report: &MpiBuildReport, out: &Path) -> MpiResult {
    for message in report.build.skipped.iter().chain(&report.build.warnings) {
        eprintln!("warning: {}", escape_for_terminal(message));
    }
    println!("made      {}", report.build.summary());
    println!("bundle    {}, {} bytes", out.display(), report.build.bundle_bytes);
    println!("time      {:.2} s in {} processes", report.seconds, report.ranks);
    if !report.build.cached.is_empty() {
        println!("cached    {}", report.build.cached.join(", "));
    }
    println!("{:<10}{:>9}{:>9}{:>9}{:>12}{:>12}  slowest", "stage", "time", "busiest", "idlest", "moved", "memory");
    for stage in report.build.stage_s.keys() {
        let of = |r: &RankReport| r.stages.get(*stage).copied().unwrap_or_default();
        let busy_s = |s: StageCost| s.ran_s.unwrap_or(s.wall_s - s.waited_s);
        let all: Vec<StageCost> = report.of_ranks.iter().map(of).collect();
        let (most, least) = all.iter().map(|&s| busy_s(s)).fold((0.0, f64::INFINITY), |(m, l), s| (s.max(m), s.min(l)));
        let rank = all.iter().position(|&s| busy_s(s) == most);
        let wall_s = all.iter().map(|s| s.wall_s).fold(0.0, f64::max);
        let moved = all.iter().map(|s| s.bytes_moved).sum::<u64>() as f64 / 1e6;
        let peak = all.iter().map(|s| s.peak_bytes).max().unwrap_or(0) as f64 / 1e6;
        let rank = rank.map_or(String::new(), |r| format!("rank {r}"));
        println!("{stage:<10}{wall_s:>7.2} s{most:>7.2} s{least:>7.2} s{moved:>9.1} MB{peak:>9.0} MB  {rank}");
    }
    let slowest_s = report.of_ranks.iter().map(|r| r.busy_s).fold(0.0, f64::max);
    for (rank, of) in report.of_ranks.iter().enumerate() {
        let (moved, peak) = (of.bytes_moved as f64 / 1e6, of.peak_bytes as f64 / 1e6);
        let mark = if of.busy_s == slowest_s && report.ranks > 1 { ", the slowest" } else { "" };
        let busy_s = of.busy_s;
        println!("rank {rank:<4} busy for {busy_s:.2} s{mark}, sent {moved:.1} MB, at most {peak:.0} MB of memory");
    }
    Ok(())
}
