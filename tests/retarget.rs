//! Real clips on their own proportions keep their joints where they were, T-poses are found, feet stand.

use crate::common::mocap::recording;
use std::path::PathBuf;
use throng_core::Joint;
use throng_precompute::Warnings;
use throng_precompute::annotate::{AnnotateConfig, Sidecars, annotate, contact_sanity};
use throng_precompute::clip::ExclusionReason;
use throng_precompute::import::{ImportConfig, ImportedClip, read};
use throng_precompute::progress::Silent;
use throng_precompute::resample::{ResampleConfig, resample};
use throng_precompute::retarget::{Proportions, RetargetConfig, retarget_clips};

/// Clips of the recordings, where there are any.
fn clips(patterns: &[&str]) -> Option<Vec<ImportedClip>> {
    let root = recording("")?;
    let paths: Vec<PathBuf> = patterns.iter().map(|p| root.join(p)).collect();
    let config = ImportConfig { loops: false, ..ImportConfig::default() };
    Some(read(&paths, &config, &Silent).expect("the recordings can be read").clips)
}

#[test]
fn own_proportions_reproduce_the_joints_of_real_clips() {
    let patterns = ["snu/single/walk_*.amc", "cmu-asfamc/02/02_0*.amc", "bandai-1/*walk_*.bvh"];
    let Some(clips) = clips(&patterns) else { return };
    let cfg = RetargetConfig { proportions: Proportions::Clip, align_ground: false };
    for clip in &clips {
        let set = retarget_clips(std::slice::from_ref(clip), &cfg, &mut Warnings::default()).expect("a body");
        for f in 0..clip.clip.num_frames {
            let (world, retargeted) = (clip.clip.world(f), set.clips[0].joint_positions(&set.skeleton, f));
            for j in Joint::ALL {
                let Some(source) = clip.roles.get(j) else { continue };
                let distance = (world[source].0 - retargeted[j.index()]).length();
                // CMU's neck has two joints and so no fixed length; its direction must still be right.
                let stretch = match j {
                    Joint::Head => clip.roles.get(Joint::Neck).map_or(0.0, |neck| {
                        let length = (world[source].0 - world[neck].0).length();
                        (length - set.skeleton.offsets[j.index()].length()).abs()
                    }),
                    _ => 0.0,
                };
                let limit = stretch + 1e-4;
                assert!(distance < limit, "{} frame {f} {}: {distance} m", clip.clip.name, j.name());
            }
        }
    }
}

#[test]
fn walking_stands_on_each_foot_a_bit_more_than_half_the_time() {
    let patterns =
        ["snu/single/walk_straight_*.amc", "snu/single/walk_*_90degree*.amc", "bandai-1/*_walk_normal_*.bvh"];
    let Some(clips) = clips(&patterns) else { return };
    let set = retarget_clips(&clips, &RetargetConfig::default(), &mut Warnings::default()).expect("bodies");
    let set = resample(&set, &ResampleConfig { rate_hz: 30.0, mirror: true }).unwrap();
    let set = annotate(&set, &AnnotateConfig::default(), &Sidecars::default()).expect("annotated");
    // Of a clip of a single step the share says little.
    for clip in set.clips.iter().filter(|c| c.num_frames() >= 60) {
        let s = contact_sanity(clip, &set.skeleton);
        // On their own proportions, the shortest contacts of these clips have a share of 0.431.
        for share in [s.left_share, s.right_share] {
            assert!((0.42..0.76).contains(&share), "{}: {s:?}", clip.name);
        }
        assert!(s.mean_speed_mps < 0.15 && s.p95_speed_mps < 0.4, "{}: {s:?}", clip.name);
    }
}

#[test]
fn t_poses_of_real_clips_are_left_out_and_motion_is_kept() {
    let Some(clips) = clips(&["snu/single/walk_straight*.amc", "snu/single/run_straight*.amc"]) else { return };
    let set = retarget_clips(&clips, &RetargetConfig::default(), &mut Warnings::default()).expect("bodies");
    let set = resample(&set, &ResampleConfig { rate_hz: 30.0, mirror: false }).unwrap();
    let set = annotate(&set, &AnnotateConfig::default(), &Sidecars::default()).expect("annotated");
    for clip in &set.clips {
        let (first, last) = (&clip.excluded[0], &clip.excluded[clip.excluded.len() - 1]);
        assert_eq!((first.reason, last.reason), (ExclusionReason::TPose, ExclusionReason::TPose), "{}", clip.name);
        assert_eq!((first.range.start, last.range.end), (0, clip.num_frames()), "{}", clip.name);
        let usable: usize = clip.usable_ranges().iter().map(|r| r.len()).sum();
        assert!(usable >= 60, "{}: {usable} usable frames", clip.name);
        for f in clip.usable_ranges().into_iter().flatten() {
            let p = clip.joint_positions(&set.skeleton, f);
            let raised = |shoulder: Joint, hand: Joint| p[hand.index()].y > p[shoulder.index()].y - 0.1;
            let both = raised(Joint::LeftUpperArm, Joint::LeftHand) && raised(Joint::RightUpperArm, Joint::RightHand);
            assert!(!both, "{}: arms still up at frame {f}", clip.name);
        }
    }
}
