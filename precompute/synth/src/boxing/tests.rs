//! What the set promises, measured on the finished clips.

use super::*;
use crate::checks::*;
use crate::{SynthSet, make_set};
use glam::Vec3;
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;
use throng_core::{Contacts, NUM_JOINTS};
use throng_motion::annotate::{AnnotateConfig, Sidecars, annotate};
use throng_motion::clip::ClipHit;
use throng_motion::clip::{Clip, ClipTag};

const BLOWS: [&str; 6] = ["left_jab", "right_straight", "left_hook", "right_hook", "left_uppercut", "right_uppercut"];

static SET: LazyLock<ClipSet> = LazyLock::new(|| boxing(&SynthConfig::for_set(SynthSet::Boxing)));

/// The set as a build annotates it, where swings count as hits.
static ANNOTATED: LazyLock<ClipSet> = LazyLock::new(|| {
    let mut cfg = AnnotateConfig::default();
    cfg.hits.punches.swing_speed = Some(4.5);
    annotate(&SET, &cfg, &Sidecars::default()).unwrap()
});

fn short(seed: u64, variation: f64) -> ClipSet {
    make_set(SynthSet::Boxing, &SynthConfig { seed, variation, minutes: 0.4, ..SynthConfig::default() }).unwrap()
}

/// Speed of a joint by central differences (m/s).
fn speed(positions: &[[Vec3; NUM_JOINTS]], joint: Joint, f: usize) -> f32 {
    let (a, b) = (f.saturating_sub(1), (f + 1).min(positions.len() - 1));
    positions[b][joint.index()].distance(positions[a][joint.index()]) * 30.0 / (b - a) as f32
}

/// Planted feet stand still, and one always does; joints bend the right way.
fn assert_sound(set: &ClipSet) {
    assert_planted_feet_stand_still(set, 0.03);
    for clip in &set.clips {
        assert!(clip.contacts.iter().all(|c| c.any(Contacts::LEFT) || c.any(Contacts::RIGHT)), "{}", clip.name);
        assert_knees_bend(clip, &(12.0..115.0));
        assert_elbows_bend(clip, &(10.0..152.0), 1e-5);
    }
}

#[test]
fn feet_stand_on_the_ground_joints_bend_the_right_way_and_nothing_pops() {
    assert_sound(&SET);
    assert_soles_stay_above(&SET, -0.005);
    // Captured punches reach 930 rad/s^2 at the elbow and 760 rad/s^2 at the shoulder, at speeds of 4 to 9 m/s; captured
    // boxing feet 450 rad/s^2 at the knee.
    let most = |j| match j {
        Joint::LeftUpperArm | Joint::RightUpperArm | Joint::LeftForearm | Joint::RightForearm => 1150.0,
        _ if j >= Joint::LeftThigh => 250.0,
        Joint::Hips => 190.0,
        _ => 120.0,
    };
    SET.clips.iter().for_each(|clip| assert_nothing_pops(clip, most));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn every_seed_and_variation_stands_and_bends(seed in 0u64..10_000, variation in 0.0f64..2.0) {
        let set = short(seed, variation);
        assert_sound(&set);
        for clip in &set.clips {
            prop_assert!(clip.root_positions.iter().all(|p| p.is_finite() && (0.5..1.0).contains(&p.y)));
        }
    }
}

/// Tags whose names say a blow, by clip.
fn blows(clip: &Clip) -> impl Iterator<Item = &ClipTag> {
    clip.tags.iter().filter(|t| BLOWS.contains(&t.name.as_str()))
}

fn hand(tag: &ClipTag) -> Joint {
    if tag.name.starts_with("left") { Joint::LeftHand } else { Joint::RightHand }
}

#[test]
fn every_blow_of_both_hands_and_every_defence_occur() {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for tag in SET.clips.iter().flat_map(|c| &c.tags) {
        *counts.entry(tag.name.as_str()).or_default() += 1;
    }
    for blow in BLOWS {
        assert!(counts.get(blow).is_some_and(|n| *n >= 30), "{blow}: {counts:?}");
    }
    for name in moves::Defence::ALL.map(moves::Defence::tag).iter().chain(&["advance", "retreat", "step_in"]) {
        assert!(counts.get(name).is_some_and(|n| *n >= 8), "{name}: {counts:?}");
    }
    for side in ["left", "right"] {
        for name in ["circle", "side_step", "pivot"] {
            assert!(counts.get(format!("{name}_{side}").as_str()).is_some_and(|n| *n >= 10), "{name}: {counts:?}");
        }
    }
}

#[test]
fn twenty_combinations_occur() {
    let mut different = BTreeSet::new();
    for clip in &SET.clips {
        for whole in clip.tags.iter().filter(|t| t.name == "combination") {
            let inside = |t: &&ClipTag| t.range.start >= whole.range.start && t.range.end <= whole.range.end + 8;
            let mut within: Vec<&ClipTag> = blows(clip).filter(inside).collect();
            within.sort_by_key(|t| t.range.start);
            assert!((2..=4).contains(&within.len()), "{} at {:?}", clip.name, whole.range);
            different.insert(within.iter().map(|t| t.name.as_str()).collect::<Vec<_>>());
        }
    }
    assert!(different.len() >= 20, "{}", different.len());
}

#[test]
fn fists_are_as_fast_as_real_ones() {
    let mut peaks: BTreeMap<&str, Vec<f32>> = BTreeMap::new();
    for clip in &SET.clips {
        let at = positions(&SET, clip);
        for tag in blows(clip) {
            let peak = tag.range.clone().map(|f| speed(&at, hand(tag), f)).fold(0.0, f32::max);
            // Captured punches at 30 Hz: 4.3 to 9.1 m/s, most of them near 5.
            assert!((3.2..8.0).contains(&peak), "{} {} at {:?}: {peak} m/s", clip.name, tag.name, tag.range);
            peaks.entry(&tag.name).or_default().push(peak);
        }
    }
    for (name, peaks) in peaks {
        let mean = peaks.iter().sum::<f32>() / peaks.len() as f32;
        assert!((4.2..6.5).contains(&mean), "{name}: {mean} m/s");
    }
}

#[test]
fn the_other_hand_stays_on_guard() {
    for clip in &SET.clips {
        let at = positions(&SET, clip);
        for joint in [Joint::LeftHand, Joint::RightHand] {
            let mut strikes = vec![false; clip.num_frames()];
            for tag in blows(clip).filter(|t| hand(t) == joint) {
                strikes[tag.range.start..(tag.range.end + 1).min(clip.num_frames())].fill(true);
            }
            for f in (0..clip.num_frames()).filter(|f| !strikes[*f]) {
                let from_neck = at[f][joint.index()].distance(at[f][Joint::Neck.index()]);
                assert!(from_neck < 0.42, "{} frame {f} {}: {from_neck} m", clip.name, joint.name());
            }
        }
    }
}

#[test]
fn hits_are_found_where_blows_are_and_nowhere_else() {
    let (mut found, mut all) = (0, 0);
    for clip in &ANNOTATED.clips {
        let of = |h: &ClipHit, t: &ClipTag| hand(t) == h.joint && t.range.contains(&h.frame);
        assert!(clip.hits.iter().all(|h| blows(clip).any(|t| of(h, t))), "{}", clip.name);
        all += blows(clip).count();
        found += blows(clip).filter(|t| clip.hits.iter().any(|h| of(h, t))).count();
    }
    assert!(found * 100 > all * 80, "{found} of {all}");
}

#[test]
fn hits_spread_over_heights_distances_and_angles() {
    let hits: Vec<Vec3> = ANNOTATED.clips.iter().flat_map(|c| &c.hits).map(|h| h.position).collect();
    let spread = |of: fn(&Vec3) -> f32| {
        let mut v: Vec<f32> = hits.iter().map(of).collect();
        v.sort_by(f32::total_cmp);
        (v[0], v[v.len() - 1])
    };
    let (height, distance, angle) = (spread(|p| p.y), spread(|p| p.x.hypot(p.z)), spread(|p| p.x.atan2(p.z)));
    assert!(height.0 < 1.22 && height.1 > 1.65, "{height:?}");
    assert!(distance.0 < 0.4 && distance.1 > 0.88, "{distance:?}");
    assert!(angle.0 < -0.4 && angle.1 > 1.0, "{angle:?}");
}

#[test]
fn clips_begin_and_end_on_guard() {
    let both = Contacts(Contacts::LEFT_TOE.0 | Contacts::RIGHT_TOE.0);
    for clip in &SET.clips {
        let n = clip.num_frames();
        let at = positions(&SET, clip);
        for f in (0..15).chain(n - 15..n) {
            assert!(clip.contacts[f].all(both), "{} frame {f}", clip.name);
            let neck = at[f][Joint::Neck.index()];
            for joint in [Joint::LeftHand, Joint::RightHand] {
                let wrist = at[f][joint.index()];
                assert!(wrist.distance(neck) < 0.36 && (wrist.y - neck.y).abs() < 0.12, "{} frame {f}", clip.name);
                assert!(speed(&at, joint, f) < 0.6, "{} frame {f}: {}", clip.name, speed(&at, joint, f));
            }
            assert!(at[f][Joint::LeftFoot.index()].distance(at[f][Joint::RightFoot.index()]) > 0.4);
        }
    }
}

#[test]
fn annotation_finds_the_contacts_that_are_there() {
    let (mut same, mut all) = (0, 0);
    for (made, found) in SET.clips.iter().zip(&ANNOTATED.clips) {
        for foot in [Contacts::LEFT, Contacts::RIGHT] {
            all += made.num_frames();
            same += made.contacts.iter().zip(&found.contacts).filter(|(a, b)| a.any(foot) == b.any(foot)).count();
        }
    }
    assert!(same * 1000 > all * 950, "{same} of {all}");
}
