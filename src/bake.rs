//! `throng bake`: one shard of a build.

use crate::args::{CacheArgs, CommandResult};
use crate::build::{BuildInputArgs, plan};
use crate::{help, keys, output, progress};
use schemars::JsonSchema;
use serde::Serialize;
use throng_precompute::memory;
use throng_precompute::pipeline::{self, Shard, ShardReport};

/// Do one of N shares of a build's work on single files, into a cache that all share.
///
/// Every file belongs to one shard, by a hash of its content. A shard reads its own files; once the files of all shards are
/// in the cache, it makes the clips of its own, so run all shards, and then run them again. They may run in any order, at
/// once, and again after a failure. `throng build` with the same arguments and the same cache does the rest.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<BakeReport>())]
pub struct Args {
    #[command(flatten)]
    what: BuildInputArgs,
    /// The share: I of N, from 0/N to N-1/N.
    #[arg(long, value_name = "I/N")]
    shard: Shard,
    #[command(flatten)]
    cache: CacheArgs,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// Printed report.
#[derive(Serialize, JsonSchema)]
struct BakeReport {
    #[serde(flatten)]
    shard: ShardReport,
    /// Peak memory of this process (bytes); absent if the system does not report it.
    peak_bytes: Option<u64>,
}

pub fn run(args: &Args) -> CommandResult {
    let fault = "a shard leaves what it does in the cache: run it without --no-cache";
    let folder = args.cache.folder().ok_or(fault)?;
    let plan = plan(&args.what)?;
    let bar = progress::BuildProgressBar::on_interrupt(Some(folder.clone()));
    let shard = pipeline::bake_shard(&plan.config, plan.parts, args.shard, &args.cache.cache()?, &bar);
    drop(bar);
    let shard = shard.map_err(|e| plan.error(e))?;
    output::warnings(&shard.skipped, &shard.warnings);
    let report = BakeReport { shard, peak_bytes: memory::peak_bytes() };
    if args.json {
        return output::json(&report);
    }
    print(&report.shard, &folder.display().to_string())?;
    let given: Vec<String> = std::env::args_os().skip(2).map(|word| word.to_string_lossy().into_owned()).collect();
    help::next_step(&next_words(&given, report.shard.missing == 0))
}

/// Command that follows a shard with these arguments: the build once all files are there, the shard again before.
fn next_words(given: &[String], is_complete: bool) -> Vec<&str> {
    let is_of_shard = |i: usize| given[i].starts_with("--shard") || i > 0 && given[i - 1] == "--shard";
    let kept = (0..given.len()).filter(|&i| !(is_complete && is_of_shard(i))).map(|i| given[i].as_str());
    std::iter::once(if is_complete { "build" } else { "bake" }).chain(kept).collect()
}

fn print(r: &ShardReport, folder: &str) -> CommandResult {
    let left = match r.missing {
        0 => "nothing: run `throng build` once all shards say so".to_owned(),
        n => format!("{n} files of other shards are not in the cache: run this one again after them, for its clips"),
    };
    output::table(&[
        ("files", format!("{} of {}; {} read, {} skipped", r.own_files, r.files, r.read, r.skipped.len())),
        ("clips", format!("made of {} files", r.made)),
        ("left", left),
        ("cache", folder.to_owned()),
    ])
}
