//! Effective hits: none in walking and running, the right ones in synthetic and real blows.

use crate::common;
use std::collections::BTreeMap;
use std::path::Path;
use throng_core::{Joint, Skeleton};
use throng_precompute::Warnings;
use throng_precompute::annotate::HitConfig;
use throng_precompute::clip::{Clip, ClipSet, HitKind};
use throng_precompute::config::BuildConfig;
use throng_precompute::import::{ImportConfig, ImportedClip, expand, read_clip};
use throng_precompute::pipeline;

/// Processes one clip as a build with default settings does.
fn process(raw: &ImportedClip) -> ClipSet {
    let clips = pipeline::clips_of(std::slice::from_ref(raw), &BuildConfig::default(), &mut Warnings::default());
    clips.expect("a clip is annotated")
}

/// A clip as a build with default settings annotates it.
fn annotated(path: &Path) -> ClipSet {
    let imported = read_clip(&expand(&[path.to_path_buf()]).expect("a clip")[0], &ImportConfig::default());
    process(&imported.expect("a clip reads"))
}

/// Number of hits by the joint that strikes.
fn by_joint(set: &ClipSet) -> BTreeMap<&'static str, usize> {
    let mut out = BTreeMap::new();
    for h in set.clips.iter().flat_map(|c| &c.hits) {
        *out.entry(h.joint.name()).or_insert(0) += 1;
    }
    out
}

/// Distance from shoulder to wrist at a frame, as a share of the arm's length.
fn extension(clip: &Clip, skeleton: &Skeleton, frame: usize, hand: Joint) -> f32 {
    let fore = hand.parent().expect("a forearm");
    let upper = fore.parent().expect("an upper arm");
    let p = clip.joint_positions(skeleton, frame);
    let length = skeleton.offsets[hand.index()].length() + skeleton.offsets[fore.index()].length();
    p[hand.index()].distance(p[upper.index()]) / length
}

#[test]
fn synthetic_walking_has_no_hits() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    common::write_clips(folder.path(), 1.0);
    let files = expand(&[folder.path().to_path_buf()]).expect("clips");
    let mut frames = 0;
    for file in files {
        let imported = read_clip(&file, &ImportConfig::default()).expect("a clip reads");
        let set = process(&imported);
        assert!(set.clips[0].hits.is_empty(), "{:?}", set.clips[0].hits);
        frames += set.clips[0].num_frames();
    }
    assert!(frames >= 1700, "a minute of walking, not {frames} frames");
}

#[test]
fn recorded_punches_and_kicks_are_found() {
    let Some(root) = common::mocap::recording("") else { return };
    type Counts<'a> = &'a [(&'a str, std::ops::RangeInclusive<usize>)];
    let expected: [(&str, Counts<'_>); 7] = [
        ("snu/single/punch.amc", &[("right_hand", 1..=1)]),
        ("snu/single/slap.amc", &[("right_hand", 1..=1)]),
        ("cmu-asfamc/02/02_05.amc", &[("right_hand", 9..=9)]),
        ("bandai-1/dataset-1_punch_normal_001.bvh", &[("left_hand", 4..=5)]),
        ("bandai-1/dataset-1_punch_normal_002.bvh", &[("right_hand", 5..=5)]),
        ("snu/single/flying_kick_1.amc", &[("right_foot", 1..=1)]),
        ("snu/session23/Take05.amc", &[("left_hand", 15..=22), ("right_hand", 22..=30)]),
    ];
    for (file, joints) in expected {
        let found = by_joint(&annotated(&root.join(file)));
        println!("{file}: {found:?}");
        assert_eq!(found.len(), joints.len(), "{file}: {found:?}");
        for (joint, range) in joints {
            assert!(found.get(joint).is_some_and(|n| range.contains(n)), "{file}: {found:?}");
        }
    }
    let kicks = annotated(&root.join("bandai-1/dataset-1_kick_normal_001.bvh"));
    let kicks: Vec<_> = kicks.clips[0].hits.iter().filter(|h| h.kind == HitKind::Kick).collect();
    assert!(kicks.len() == 3 && kicks.iter().all(|h| h.joint == Joint::RightFoot && h.speed_mps > 6.0), "{kicks:?}");
}

#[test]
fn recorded_punches_land_with_the_arm_nearly_straight() {
    let Some(root) = common::mocap::recording("") else { return };
    for take in ["Take03", "Take05", "Take06"] {
        let set = annotated(&root.join(format!("snu/session23/{take}.amc")));
        let clip = &set.clips[0];
        let mut shares: Vec<f32> = clip.hits.iter().map(|h| extension(clip, &set.skeleton, h.frame, h.joint)).collect();
        shares.sort_by(f32::total_cmp);
        let (low, middle) = (shares[shares.len() / 10], shares[shares.len() / 2]);
        println!("{take}: {} hits, arms {low:.2} (10 %) and {middle:.2} (median) of their length", shares.len());
        assert!(shares.len() >= 40 && low > 0.7 && middle > 0.85, "{take}: {shares:?}");
    }
}

#[test]
fn recorded_walks_and_runs_have_next_to_no_hits() {
    let Some(root) = common::mocap::recording("") else { return };
    let patterns = [
        "snu/single/walk_*.amc",
        "snu/single/run_*.amc",
        "cmu-asfamc/02/02_01.amc",
        "cmu-asfamc/02/02_02.amc",
        "cmu-asfamc/02/02_03.amc",
        "cmu-asfamc/03/*.amc",
        "bandai-1/dataset-1_walk*.bvh",
        "bandai-1/dataset-1_run_*.bvh",
        "bandai-1/dataset-1_dash_*.bvh",
    ];
    let (mut seconds, mut hits, mut clips) = (0.0, 0, 0);
    for file in expand(&patterns.map(|p| root.join(p))).expect("clips") {
        let imported = read_clip(&file, &ImportConfig::default()).expect("a clip reads");
        let set = process(&imported);
        let clip = &set.clips[0];
        clips += 1;
        seconds += clip.num_frames() as f64 / clip.rate_hz;
        hits += clip.hits.len();
        if !clip.hits.is_empty() {
            println!("{}: {:?}", clip.name, by_joint(&set));
        }
    }
    println!("{hits} hits in {clips} clips of walking and running, {seconds:.0} s");
    assert!(clips >= 100 && hits <= 3, "{hits} hits in {clips} clips");
}

#[test]
fn settings_outside_their_limits_stop_a_build() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    common::write_clips(folder.path(), 0.25);
    let mut config = common::small_config(vec![folder.path().to_path_buf()]);
    config.annotate.hits = HitConfig { landing_share: 2.0, ..HitConfig::default() };
    let cache = throng_precompute::cache::Cache::disabled();
    let out = folder.path().join("a.throng");
    let e = pipeline::build(&config, &out, &cache, &throng_precompute::progress::Silent).expect_err("refused");
    assert!(e.to_string().contains("annotate.hits.landing_share: expected 0.01 to 1, found 2"), "{e}");
    assert!(!out.exists());
}
