//! Builds by several ranks, here threads, against builds by one.

use proptest::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::TempDir;
use throng_bake::cache::Cache;
use throng_bake::config::BuildConfig;
use throng_bake::parts::RequiredParts;
use throng_bake::pipeline::{bake_shard, build, build_shared};
use throng_bake::policy::GridConfig;
use throng_bake::report::BuildReport;
use throng_base::{Comm, LocalComm};
use throng_motion::error::BuildError;
use throng_motion::progress::{Progress, Silent};
use throng_synth::{self as synth, SynthConfig, SynthSet};

/// Some clips in files, and a config with small grids.
fn motion(set: SynthSet, seed: u64, minutes: f64, text: &str) -> (TempDir, BuildConfig) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let clips = folder.path().join("clips");
    let settings = SynthConfig { seed, minutes, clip_seconds: 8.0, ..SynthConfig::for_set(set) };
    synth::write_set(set, &settings, &clips).expect("synthetic clips can be written");
    let text = format!("name = \"small\"\ninputs = [\"clips\"]\n{text}");
    let mut config = BuildConfig::parse(&text, Path::new("small.toml")).expect("a config");
    config.inputs = vec![clips];
    config.policy.compare_samples = 50;
    (folder, config)
}

/// What each of some ranks tells of a build, and the bundle.
fn shared(config: &BuildConfig, cache: &Cache, num_ranks: usize, out: &Path) -> (Vec<BuildReport>, Vec<u8>) {
    let one = |comm: &LocalComm| {
        build_shared(config, RequiredParts::All, out, cache, &Silent, comm)
            .unwrap_or_else(|e| panic!("rank {}: {e}", comm.rank()))
    };
    let reports = LocalComm::run(num_ranks, one);
    (reports, std::fs::read(out).expect("the bundle"))
}

fn alone(config: &BuildConfig, out: &Path) -> Vec<u8> {
    build(config, out, &Cache::disabled(), &Silent).expect("the config builds");
    std::fs::read(out).expect("the bundle")
}

const BOXING: &str = include_str!("../../../fuzz/checks/src/soak/boxing.toml");

#[test]
fn any_number_of_ranks_writes_the_bytes_of_one_process() {
    let (folder, config) = motion(SynthSet::Boxing, 1, 0.4, BOXING);
    let out = folder.path().join("small.throng");
    let want = alone(&config, &out);
    for num_ranks in [1, 2, 3, 4, 8] {
        assert!(shared(&config, &Cache::disabled(), num_ranks, &out).1 == want, "{num_ranks} ranks");
    }
    // With a cache, each rank has poses of its own clips alone: blows, hits that are evaded and stops need those of all.
    for num_ranks in [2, 3, 8] {
        let cache = Cache::in_folder(folder.path().join(format!("cache-{num_ranks}")));
        let (reports, bytes) = shared(&config, &cache, num_ranks, &out);
        assert!(bytes == want, "{num_ranks} ranks with a cache");
        assert!(reports[0].warnings.is_empty(), "{:?}", reports[0].warnings);
    }
}

#[test]
fn ranks_share_a_cache_and_find_what_they_left() {
    let (folder, config) = motion(SynthSet::Walk, 3, 0.5, "");
    let (out, cache) = (folder.path().join("small.throng"), Cache::in_folder(folder.path().join("cache")));
    let want = alone(&config, &out);
    let (first, bytes) = shared(&config, &cache, 3, &out);
    assert!(bytes == want, "filling the cache");
    assert!(first.iter().all(|r| r.cached.is_empty()));
    let single = build(&config, &folder.path().join("single.throng"), &Cache::disabled(), &Silent).expect("it builds");
    let figures = |r: &BuildReport| (r.contacts, r.joint_error_p95_mm, r.joint_error_worst_mm, r.stops);
    assert_eq!(figures(&first[0]), figures(&single), "what is told does not depend on who has which poses");
    assert!(first.iter().all(|r| r.spent.values().map(|s| s.bytes_moved).sum::<u64>() > 0));
    let (second, bytes) = shared(&config, &cache, 2, &out);
    assert!(bytes == want, "using the cache");
    assert!(second.iter().all(|r| r.cached == ["graph", "make", "graph", "policy"]), "{:?}", second[0].cached);
    assert!(second.iter().all(|r| r.clips_kept > 1), "clips are kept file by file");
    assert!(second[0].bundle_bytes == bytes.len() as u64 && second[1].bundle_bytes == 0);
}

#[test]
fn shard_whose_cache_is_full_fails() {
    let (folder, config) = motion(SynthSet::Walk, 6, 0.3, "");
    let cache = Cache::in_folder(folder.path().join("cache")).limited(1000);
    let told = bake_shard(&config, RequiredParts::All, "0/1".parse().expect("a shard"), &cache, &Silent);
    let told = told.expect_err("nothing is kept").to_string();
    assert!(told.contains("the cache keeps 1000 at most"), "{told}");
    // A build goes on without, and says so.
    let report = build(&config, &folder.path().join("small.throng"), &cache, &Silent).expect("it builds");
    assert!(report.warnings.iter().any(|w| w.contains("not all is cached")), "{:?}", report.warnings);
}

#[test]
fn ranks_and_shards_see_motion_that_is_there_twice() {
    let (folder, config) = motion(SynthSet::Walk, 5, 0.5, "");
    let clips = &config.inputs[0];
    std::fs::copy(clips.join("walk_00.bvh"), clips.join("walk_again.bvh")).expect("a copy");
    let (out, cache) = (folder.path().join("small.throng"), Cache::in_folder(folder.path().join("cache")));
    let want = alone(&config, &out);
    for shard in ["0/2", "1/2", "0/2", "1/2"] {
        let told = bake_shard(&config, RequiredParts::All, shard.parse().expect("a shard"), &cache, &Silent)
            .expect("it bakes");
        let twice = |w: &String| w.contains("walk_again.bvh: the same motion as");
        assert!(!told.done || told.own_files == 0 || told.warnings.iter().any(twice), "{told:?}");
    }
    let (reports, bytes) = shared(&config, &cache, 2, &out);
    assert!(bytes == want);
    assert!(reports.iter().all(|r| r.warnings.iter().any(|w| w.contains("the same motion as"))));
}

/// Stops its rank in a stage, as if it were killed there.
struct EndsIn(&'static str, AtomicBool);

impl Progress for EndsIn {
    fn begin(&self, _: &'static str, _: u64, _: &'static str) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
    fn enter_stage(&self, stage: &'static str) {
        self.1.store(stage == self.0, Ordering::Relaxed);
    }
    fn is_stopped(&self) -> bool {
        self.1.load(Ordering::Relaxed)
    }
}

#[test]
fn rank_that_ends_ends_all_and_leaves_what_was_done() {
    let (folder, config) = motion(SynthSet::Walk, 4, 0.5, "");
    let (out, cache) = (folder.path().join("small.throng"), Cache::in_folder(folder.path().join("cache")));
    let want = alone(&config, &folder.path().join("alone.throng"));
    for (stage, before) in [("clips", &["import"][..]), ("graph", &["clips"]), ("policy", &["clips", "graph"])] {
        let ended = LocalComm::run(3, |comm| {
            let stops = EndsIn(if comm.rank() == 1 { stage } else { "" }, AtomicBool::new(false));
            build_shared(&config, RequiredParts::All, &out, &cache, &stops, comm).map(drop)
        });
        assert!(matches!(ended[1], Err(BuildError::Stopped(_))), "{stage}: {:?}", ended[1]);
        for rank in [0, 2] {
            let told = ended[rank].as_ref().expect_err("a rank has ended").to_string();
            assert!(told.contains("rank") && told.contains("has ended"), "{stage}: {told}");
        }
        assert!(!out.exists(), "no bundle is half written");
        let kept: Vec<String> = cache.entries().expect("a cache").into_iter().map(|e| e.stage).collect();
        assert!(before.iter().all(|s| kept.iter().any(|k| k == s)), "{stage}: {kept:?}");
    }
    let (reports, bytes) = shared(&config, &cache, 3, &out);
    assert!(bytes == want);
    assert!(reports.iter().all(|r| r.cached == ["graph", "make", "graph"]), "{:?}", reports[0].cached);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(6) })]

    #[test]
    fn any_config_gives_the_bytes_of_one_process(
        seed in 0u64..100, minutes in 0.3f64..0.8, mirror in any::<bool>(), rings in 2u32..8, angles in 3u32..12,
        discount in 0.9f64..0.98, num_ranks in 2usize..9, is_cached in any::<bool>(),
    ) {
        let (folder, mut config) = motion(SynthSet::Walk, seed, minutes, "");
        config.resample.mirror = mirror;
        config.behaviours[0].grid = GridConfig::polar(rings, angles, 6.0, 0.5, 2.0);
        config.behaviours[0].discount = Some(discount);
        let out = folder.path().join("small.throng");
        let built = build(&config, &out, &Cache::disabled(), &Silent);
        // Too little motion for a graph is refused by all.
        prop_assume!(built.is_ok());
        let want = std::fs::read(&out).expect("the bundle");
        let cache = if is_cached { Cache::in_folder(folder.path().join("cache")) } else { Cache::disabled() };
        prop_assert!(shared(&config, &cache, num_ranks, &out).1 == want);
    }
}
