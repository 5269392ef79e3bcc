//! Pose groups keep their promises: diameters against all pairs, contacts, counts against exact complete linkage.

use glam::Vec2;
use proptest::prelude::*;
use throng_core::base::SingleRank;
use throng_core::{NUM_JOINTS, Planar};
use throng_precompute::clip::{Exclusion, ExclusionReason, FrameId};
use throng_precompute::cluster::{ClusterConfig, PoseGroups, group};
use throng_precompute::features::{Features, FeaturesConfig, extract};
use throng_precompute::progress::Silent;
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_precompute::{BuildError, ClipSet};

fn walk(seed: u64, minutes: f64) -> ClipSet {
    let config = SynthConfig { seed, minutes, clip_seconds: 10.0, ..SynthConfig::default() };
    synth::make_set(SynthSet::Walk, &config).expect("a valid config")
}

fn features_of(clips: &ClipSet) -> Features {
    extract(clips, &FeaturesConfig::default()).expect("valid weights")
}

fn grouped(clips: &ClipSet, threshold: f64) -> Result<PoseGroups, BuildError> {
    group(clips, &features_of(clips), &ClusterConfig { threshold }, &Silent, &SingleRank)
}

fn on_threads<T: Send>(num_threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(num_threads).build().expect("a thread pool").install(work)
}

/// Frames of each group.
fn members(groups: &PoseGroups) -> Vec<Vec<FrameId>> {
    let mut out = vec![Vec::new(); groups.num_groups()];
    for f in (0..groups.groups.len() as u32).map(FrameId) {
        if let Some(g) = groups.group_of(f) {
            out[g as usize].push(f);
        }
    }
    out
}

/// Contacts of a frame and its neighbours in its run of usable frames, none for frames that are not usable.
fn contact_states(clips: &ClipSet) -> Vec<Option<[u8; 3]>> {
    let mut out = Vec::new();
    for clip in &clips.clips {
        for f in 0..clip.num_frames() {
            let beside = |g: Option<usize>| g.filter(|&g| g < clip.num_frames() && clip.is_usable(g)).unwrap_or(f);
            let near = [beside(f.checked_sub(1)), f, beside(Some(f + 1))];
            out.push(clip.is_usable(f).then(|| near.map(|g| clip.contacts[g].0)));
        }
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn groups_are_narrow_whole_and_of_one_contact_state(
        seed in any::<u64>(),
        threshold in 0.05f64..1.5,
        hands in any::<u64>(),
        (start, length) in (0usize..200, 0usize..80),
    ) {
        let mut clips = walk(seed, 0.17);
        let clip = &mut clips.clips[0];
        let range = start..(start + length).min(clip.num_frames());
        clip.excluded.push(Exclusion { range, reason: ExclusionReason::Sidecar });
        // Hands and seat that touch something now and then count as feet do.
        for (f, c) in clip.contacts.iter_mut().enumerate() {
            c.0 |= ((hands >> (f / 10 % 61)) as u8 & 7) << 4;
        }
        let features = features_of(&clips);
        let groups = group(&clips, &features, &ClusterConfig { threshold }, &Silent, &SingleRank).expect("groups");
        let states = contact_states(&clips);
        let mut widest = 0.0f32;
        for (g, frames) in members(&groups).iter().enumerate() {
            prop_assert!(frames.contains(&groups.medoids[g]), "the medoid is one of them");
            let sum = |a: FrameId| frames.iter().map(|&b| f64::from(features.distance(a, b))).sum::<f64>();
            prop_assert!(frames.iter().all(|&a| sum(groups.medoids[g]) <= sum(a) + 1e-9));
            for (k, &a) in frames.iter().enumerate() {
                for &b in &frames[..k] {
                    prop_assert!(f64::from(features.distance(a, b)) < threshold);
                    prop_assert_eq!(states[a.0 as usize], states[b.0 as usize]);
                    widest = widest.max(features.distance(a, b));
                }
            }
        }
        prop_assert_eq!(widest, groups.max_diameter);
        prop_assert!(groups.max_diameter < groups.threshold);
        prop_assert_eq!(groups.groups.len(), clips.num_frames());
        for (f, state) in states.iter().enumerate() {
            prop_assert_eq!(state.is_some(), groups.group_of(FrameId(f as u32)).is_some(), "frame {}", f);
        }
        let firsts: Vec<FrameId> = members(&groups).iter().map(|frames| frames[0]).collect();
        prop_assert!(firsts.is_sorted(), "groups are numbered in order of their first frame");
    }
}

#[test]
fn same_groups_at_any_number_of_threads_and_twice() {
    let clips = walk(5, 0.6);
    let first = on_threads(1, || grouped(&clips, 0.3)).expect("groups");
    for num_threads in [1, 2, 8] {
        assert!(on_threads(num_threads, || grouped(&clips, 0.3)).expect("groups") == first, "{num_threads} threads");
    }
}

#[test]
fn moving_clips_on_the_ground_changes_next_to_nothing() {
    let clips = walk(7, 0.5);
    let mut moved = clips.clone();
    for (k, clip) in moved.clips.iter_mut().enumerate() {
        let by = Planar::new(3.0 + k as f32, -2.0, 0.8 + 1.9 * k as f32);
        for f in 0..clip.num_frames() {
            let p = clip.root_positions[f];
            let g = by.transform_point(Vec2::new(p.x, p.z));
            (clip.root_positions[f].x, clip.root_positions[f].z) = (g.x, g.y);
            clip.rotations[f * NUM_JOINTS] = by.rotation() * clip.rotations[f * NUM_JOINTS];
        }
    }
    let (before, after) = (grouped(&clips, 0.3).expect("groups"), grouped(&moved, 0.3).expect("groups"));
    // Rounding may change which of two equally near frames comes first.
    let after_sets = members(&after);
    let same = members(&before).iter().filter(|frames| after_sets.contains(frames)).count();
    assert!(same * 100 > before.num_groups() * 95, "{same} of {} groups are the same", before.num_groups());
    let ratio = after.num_groups() as f64 / before.num_groups() as f64;
    assert!((ratio - 1.0).abs() < 0.02, "{ratio} of the groups");
}

#[test]
fn a_pose_on_a_deck_is_in_the_group_of_the_same_pose_on_the_ground() {
    let mut clips = walk(9, 0.1);
    clips.clips.truncate(1);
    let mut raised = clips.clips[0].clone();
    raised.name.push_str(" on a deck");
    raised.root_positions.iter_mut().for_each(|p| p.y += 2.0);
    raised.support = vec![2.0; raised.num_frames()];
    let n = raised.num_frames();
    clips.clips.push(raised);
    let groups = grouped(&clips, 0.1).expect("groups");
    let apart = (0..n).filter(|&f| groups.groups[f] != groups.groups[n + f]).count();
    assert_eq!(apart, 0, "of {n} frames");
}

#[test]
fn refuses_what_does_not_fit_together_and_says_why() {
    let clips = walk(1, 0.1);
    let error = grouped(&clips, -0.3).expect_err("a negative threshold").to_string();
    assert!(error.contains("cluster.threshold") && error.contains("-0.3"), "{error}");
    let mut bare = clips.clone();
    bare.clips[0].contacts.clear();
    let error = grouped(&bare, 0.3).expect_err("no contacts").to_string();
    assert!(error.contains(&clips.clips[0].name) && error.contains("Annotate"), "{error}");
    let others = features_of(&walk(2, 0.3));
    let error =
        group(&clips, &others, &ClusterConfig::default(), &Silent, &SingleRank).expect_err("others").to_string();
    assert!(error.contains("expected features of"), "{error}");
}

#[test]
fn nothing_in_nothing_out() {
    let none = ClipSet { clips: Vec::new(), ..walk(1, 0.1) };
    let groups = grouped(&none, 0.3).expect("no groups");
    assert_eq!((groups.num_groups(), groups.groups.len(), groups.max_diameter), (0, 0, 0.0));
}
