//! Merging within little memory, against complete linkage from the whole matrix.

#[path = "../../../../research/src/complete_linkage.rs"]
mod complete_linkage;

use super::agglomerate::agglomerate;
use super::*;
use crate::features::{self, FeaturesConfig};
use complete_linkage::complete_linkage;
use throng_synth::{self as synth, SynthConfig, SynthSet};

fn walk(minutes: f64) -> (ClipSet, Features) {
    let clips = synth::make_set(SynthSet::Walk, &SynthConfig { minutes, ..SynthConfig::default() }).unwrap();
    let features = features::extract(&clips, &FeaturesConfig::default()).unwrap();
    (clips, features)
}

/// Groups of all classes with a bound on the pairs known at a time.
fn bounded(clips: &ClipSet, features: &Features, max_pairs: usize, limit: f32) -> Vec<Vec<FrameId>> {
    let space = FrameSpace::new(features);
    let classes = classes_of_contacts(clips);
    let items = classes.values().flat_map(|frames| agglomerate(&space, frames, limit, max_pairs));
    let mut groups: Vec<Vec<FrameId>> = items.map(|i| i.frames.into_iter().map(FrameId).collect()).collect();
    groups.iter_mut().for_each(|g| g.sort());
    groups.sort();
    groups
}

#[test]
fn nearer_pairs_first_are_nearly_the_groups_of_complete_linkage() {
    let (clips, features) = walk(0.5);
    for (threshold, max_pairs) in [(0.2, 1_000_000), (0.3, 4_000), (0.4, 1_000_000), (0.4, 4_000), (0.45, 4_000)] {
        let exact = complete_linkage(&clips, &features, threshold as f32);
        let groups = bounded(&clips, &features, max_pairs, threshold as f32);
        let ratio = groups.len() as f64 / exact.len() as f64;
        assert!((ratio - 1.0).abs() < 0.05, "{ratio} of the groups with {max_pairs} pairs at a time");
        let same = groups.iter().filter(|g| exact.binary_search(g).is_ok()).count();
        assert!(same * 2 > exact.len(), "{same} groups of {} are the same", exact.len());
    }
}

#[test]
fn splitting_keeps_the_promise_and_costs_few_groups() {
    let (clips, features) = walk(0.5);
    let exact = complete_linkage(&clips, &features, 0.4);
    let split = bounded(&clips, &features, 60, 0.4);
    assert!(split != exact, "so few pairs cannot do without splits");
    assert_eq!(split.iter().map(Vec::len).sum::<usize>(), clips.num_frames());
    for group in &split {
        for &a in group {
            assert!(group.iter().all(|&b| features.distance(a, b) < 0.4));
        }
    }
    assert!((split.len() as f64) < 1.2 * exact.len() as f64, "{} groups, {}", split.len(), exact.len());
}

#[test]
fn frames_that_are_all_the_same_are_one_group() {
    let (mut clips, _) = walk(0.1);
    let clip = &mut clips.clips[0];
    let (pose, place) = (clip.frame_rotations(5).to_vec(), clip.root_positions[5]);
    let n = clip.num_frames();
    clip.rotations = pose.repeat(n);
    clip.root_positions = vec![place; n];
    clip.contacts = vec![clip.contacts[5]; n];
    clips.clips.truncate(1);
    let features = features::extract(&clips, &FeaturesConfig::default()).unwrap();
    assert_eq!(bounded(&clips, &features, 20, 0.1), [(0..n as u32).map(FrameId).collect::<Vec<_>>()]);
}

#[test]
fn several_ranks_find_the_groups_of_one() {
    use throng_base::{LocalComm, SingleRank};
    use throng_motion::progress::Silent;
    let (clips, features) = walk(0.5);
    let group =
        |comm: &dyn Comm| super::group(&clips, &features, &ClusterConfig { threshold: 0.4 }, &Silent, comm).unwrap();
    let alone = group(&SingleRank);
    assert!(alone.num_groups() > 10);
    for num_ranks in [2, 3, 8] {
        assert!(
            LocalComm::run(num_ranks, |comm| group(comm)).iter().all(|groups| *groups == alone),
            "{num_ranks} ranks"
        );
    }
}

#[test]
fn refuses_thresholds_that_are_not_above_zero() {
    for threshold in [0.0, -0.3, f64::NAN, f64::INFINITY, 1e30, 1e-30] {
        let error = ClusterConfig { threshold }.check().unwrap_err().to_string();
        assert!(error.starts_with("cluster.threshold: expected 0.000001 to 1000, found"), "{error}");
    }
    assert_eq!(ClusterConfig::default().check().unwrap(), 0.3);
}
