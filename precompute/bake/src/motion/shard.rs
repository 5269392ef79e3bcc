//! Shards: the share of a build's files that one of several processes reads and converts to clips. The processes share
//! only the folder of the cache.

use super::{MotionStages, ReadMotion};
use crate::cache::{Cache, CacheKey};
use crate::{config::BuildConfig, parts::RequiredParts, provenance, stages::Stages};
use rayon::prelude::*;
use serde::Serialize;
use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};
use throng_base::SingleRank;
use throng_motion::import::{self, ClipsResult, MotionFile};
use throng_motion::{BuildError, ImportError, Progress, Result};

/// One of several processes: number `index` of `count`, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

impl Shard {
    /// True if the file or clip of a key belongs to this shard.
    fn owns(self, key: CacheKey) -> bool {
        key.0 % u128::from(self.count) == u128::from(self.index)
    }
}

impl FromStr for Shard {
    type Err = String;

    /// Parses I/N.
    fn from_str(text: &str) -> Result<Self, String> {
        let both = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match both {
            Some((index, count)) if index < count => Ok(Self { index, count }),
            _ => Err(format!("expected I/N with I from 0 to N - 1, such as 0/8, found `{text}`")),
        }
    }
}

/// Progress of a shard.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ShardReport {
    /// Files of the whole build.
    pub files: usize,
    /// Files of this shard.
    pub own_files: usize,
    /// Files of this shard read by this run; not those in the cache or unreadable.
    pub read: usize,
    /// Unreadable files of this shard, with the reason.
    pub skipped: Vec<String>,
    /// Files of other shards that are not in the cache yet. Clips are made only once there are none, as files determine
    /// skeleton and floors together.
    pub missing: usize,
    /// Files of this shard converted to clips by this run.
    pub made: usize,
    /// True if the cache holds the complete output of this shard.
    pub done: bool,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Cache name for the reason why a file cannot be read, so that other shards do not wait for it.
const REFUSED: &str = "refused";

/// Reads the files of a shard into the cache and, once those of all shards are there, makes its clips. In whatever
/// order and however often shards run, the cache holds the same bytes in the end, and [`crate::pipeline::build`] finds
/// them. `parts` must be that of the build that will use them.
///
/// # Errors
/// [`BuildError::Key`] for synthetic motion and for values out of their range; the first output that the cache cannot
/// store; the first bad file if `import.strict` is set; those of the stages from import to annotate.
pub fn bake_shard(
    cfg: &BuildConfig,
    parts: RequiredParts,
    shard: Shard,
    cache: &Cache,
    progress: &dyn Progress,
) -> Result<ShardReport> {
    cfg.check()?;
    if cfg.synth.is_some() {
        let why = "shards share the work on files; write this motion to files first, with `throng synth`, and name them as \
                   inputs";
        return Err(BuildError::key("synth", why));
    }
    let s = Stages::new(cache, progress, &SingleRank);
    let from = s.run("hash", |_| provenance::collect_provenance(cfg))?;
    let report = MotionStages { cfg, parts, from: &from, s: &s }.bake_files(shard)?;
    // The cache is the only output of a shard.
    cache.take_fault().map_or(Ok(report), Err)
}

impl MotionStages<'_> {
    /// Lets each rank of a build do a share of its work on single files, if there is a cache to store it in.
    ///
    /// # Errors
    /// As [`bake_shard`].
    pub(super) fn bake_together(&self) -> Result<()> {
        let comm = self.s.comm;
        if comm.num_ranks() == 1 || self.cfg.synth.is_some() || !self.s.cache.is_on() {
            return Ok(());
        }
        // Files first, then clips, which need the files of all.
        for _ in 0..2 {
            self.bake_files(Shard { index: comm.rank() as u32, count: comm.num_ranks() as u32 })?;
            comm.barrier()?;
        }
        Ok(())
    }

    /// Bakes files with known hashes; see [`bake_shard`].
    fn bake_files(&self, shard: Shard) -> Result<ShardReport> {
        let mut report = self.s.run("import", |p| self.read_shard(shard, p))?;
        if report.missing == 0 && report.own_files > report.skipped.len() {
            let ReadMotion { raw, maker, warnings, .. } = self.read_all(true)?;
            let own: Vec<usize> =
                (0..raw.len()).filter(|&i| maker.keys[i].is_some_and(|key| shard.owns(key))).collect();
            report.made = self.s.run("clips", |p| {
                p.begin("clips", own.len() as u64, "files");
                let made = own.par_iter().map(|&i| {
                    p.check()?;
                    let (_, kept) = maker.clips_of_file(i, &raw[i])?;
                    p.advance(1);
                    Ok(usize::from(!kept))
                });
                let made = made.sum::<Result<usize>>();
                p.end();
                made
            })?;
            report.warnings = warnings.messages;
        }
        self.s.cache.finish_batch();
        report.done = report.missing == 0;
        Ok(report)
    }

    /// Reads the files of a shard that are missing in the cache.
    fn read_shard(&self, shard: Shard, p: &dyn Progress) -> Result<ShardReport> {
        let (keys, cache) = (self.from.file_keys(&self.cfg.import), self.s.cache);
        let [files, own_files, read, missing] = [const { AtomicUsize::new(0) }; 4];
        let count = |n: &AtomicUsize, is_one: bool| _ = n.fetch_add(usize::from(is_one), Ordering::Relaxed);
        // Only one file is held in memory at a time.
        let reader = |file: &MotionFile, import: &dyn Fn() -> ClipsResult| -> ClipsResult {
            count(&files, true);
            let Ok(key) = keys.key_of(&file.path) else { return Ok(Vec::new()) };
            if !shard.owns(key) {
                count(&missing, !cache.has_entry("import", key) && !cache.has_entry(REFUSED, key));
                return Ok(Vec::new());
            }
            count(&own_files, true);
            let made = cache.load_or_make("import", key, || keys.read_file(&file.path, import));
            if let Err(e) = &made
                && !e.is_passing()
            {
                _ = cache.load_or_make::<String, ImportError>(REFUSED, key, || Ok(e.to_string()));
            }
            count(&read, !made?.1);
            Ok(Vec::new())
        };
        let set = import::read_by(&reader, &self.cfg.inputs, &self.cfg.import, p)?;
        let [files, own_files, read, missing] = [files, own_files, read, missing].map(AtomicUsize::into_inner);
        let skipped = set.skipped.iter().map(ToString::to_string).collect();
        Ok(ShardReport { files, own_files, read, skipped, missing, ..ShardReport::default() })
    }
}
