//! `throng cache`: stage outputs of earlier builds, for reuse.

use crate::{args::CommandResult, keys, output};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::{collections::BTreeMap, time::SystemTime};
use throng_precompute::cache::Cache;

/// List what the cache keeps, or clear it. Builds keep the outputs of their stages there, up to `--cache-limit`.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<CacheReport<'static>>())]
pub struct Args {
    #[command(subcommand)]
    what: Option<CacheCommand>,
    /// Folder that keeps the outputs of stages between builds, or s3://BUCKET/PREFIX in programs built for it.
    #[arg(long, value_name = "DIR", default_value = Cache::FOLDER, global = true)]
    cache: PathBuf,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(clap::Subcommand)]
enum CacheCommand {
    /// Remove every entry; files that are none stay.
    Clear,
}

/// Printed report.
#[derive(Serialize, JsonSchema)]
struct CacheReport<'a> {
    /// The folder.
    folder: &'a Path,
    /// Number of entries; with `clear`, of the removed ones.
    entries: usize,
    /// Length of all entries (bytes).
    bytes: u64,
    /// Entries of each stage.
    stages: BTreeMap<String, StageEntries>,
    /// True if they were removed.
    cleared: bool,
}

/// The entries of a stage.
#[derive(Default, Serialize, JsonSchema)]
struct StageEntries {
    /// Number of entries.
    entries: usize,
    /// Length of the entries (bytes).
    bytes: u64,
    /// Time since an entry was last used, or in an object store written; 0 if the clock was set back (s).
    last_use_s: u64,
}

pub fn run(args: &Args) -> CommandResult {
    let (cache, now) = (Cache::at_address(&args.cache, Cache::LIMIT_BYTES)?, SystemTime::now());
    let listed = cache.entries()?;
    let mut stages = BTreeMap::<String, StageEntries>::new();
    // The most recently used entry comes last.
    for entry in &listed {
        let of = stages.entry(entry.stage.clone()).or_default();
        of.entries += 1;
        of.bytes += entry.bytes;
        of.last_use_s = now.duration_since(entry.used).map_or(0, |d| d.as_secs());
    }
    let (mut entries, mut bytes) = (listed.len(), listed.iter().map(|e| e.bytes).sum());
    let cleared = matches!(args.what, Some(CacheCommand::Clear));
    if cleared {
        (entries, bytes) = cache.clear()?;
    }
    let report = CacheReport { folder: &args.cache, entries, bytes, stages, cleared };
    output::report(&report, args.json, print)
}

fn print(r: &CacheReport<'_>) -> CommandResult {
    let sum = format!("{} entries, {}", r.entries, output::bytes(r.bytes));
    let what = if r.cleared { "removed" } else { "kept" };
    output::table(&[("cache", r.folder.display().to_string()), (what, sum)])?;
    if r.cleared || r.stages.is_empty() {
        return Ok(());
    }
    let row = |(stage, of): (&String, &StageEntries)| {
        let last = match of.last_use_s {
            s @ 0..120 => format!("used {s} s ago"),
            s @ 120..7200 => format!("used {} min ago", s / 60),
            s @ 7200..172_800 => format!("used {} h ago", s / 3600),
            s => format!("used {} days ago", s / 86400),
        };
        [format!("{} {stage}", of.entries), output::bytes(of.bytes), last]
    };
    let rows: Vec<[String; 3]> = r.stages.iter().map(row).collect();
    let rows = rows.iter().map(|row| row.each_ref().map(String::as_str));
    output::columns([["entries", "bytes", "last use"]].into_iter().chain(rows))
}
