//! Those who make way begin with room around them.

use crate::common;
use throng_precompute::cache::Cache;
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_precompute::trial::{self, TrialConfig};
use throng_runtime::Bundle;

#[test]
fn runners_who_cannot_stop_begin_with_more_room() {
    let folder = tempfile::tempdir().unwrap();
    let [all, runs] = ["all", "runs"].map(|name| folder.path().join(name));
    synth::write(SynthSet::Locomotion, &SynthConfig::for_set(SynthSet::Locomotion), &all).unwrap();
    std::fs::create_dir(&runs).unwrap();
    for name in ["run_neutral_v440_g00.bvh", "run_neutral_v440_gl06.bvh", "run_neutral_v440_gr06.bvh"] {
        std::fs::copy(all.join(name), runs.join(name)).unwrap();
    }
    let out = folder.path().join("runs.throng");
    common::build(&common::small_config(vec![runs]), &out, &Cache::none());
    let tables = Bundle::open(&out).unwrap();
    let config = TrialConfig { characters: 64, seconds: 1.0, recorded: None, ..TrialConfig::default() };
    let (report, _) = trial::run(&tables, &config).unwrap();
    assert_eq!((report.characters, report.character_overlaps), (64, 0));
}
