//! What the set promises, measured on the finished clips.

use super::*;
use crate::SynthSet;
use crate::checks::*;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::sync::LazyLock;
use throng_core::{Contacts, Joint};
use throng_motion::clip::Clip;

static SET: LazyLock<ClipSet> = LazyLock::new(|| people(&SynthConfig::for_set(SynthSet::People)));

/// The tag of a clip that says what it shows, and its looped part, if any.
fn tags(clip: &Clip) -> (&str, std::ops::Range<usize>, Option<std::ops::Range<usize>>) {
    let shown = clip.tags.iter().find(|t| t.name != "loop" && !t.name.ends_with("_hand")).unwrap();
    let looped = clip.tags.iter().find(|t| t.name == "loop").map(|t| t.range.clone());
    (&shown.name, shown.range.clone(), looped)
}

fn assert_sound(set: &ClipSet) {
    assert_planted_feet_stand_still(set, 0.02);
    for clip in &set.clips {
        assert_knees_bend(clip, &(1.0..115.0));
        assert_elbows_bend(clip, &(5.0..150.0), f32::INFINITY);
    }
}

#[test]
fn every_act_is_there_and_goes_on_where_it_may() {
    let shown: BTreeSet<&str> = SET.clips.iter().map(|c| tags(c).0).collect();
    let all = ["buy", "chat", "cheer", "greet", "handshake", "look", "put", "queue", "sit", "take"];
    assert_eq!(shown.into_iter().collect::<Vec<_>>(), all);
    for clip in &SET.clips {
        let (tag, range, looped) = tags(clip);
        let goes_on = !matches!(tag, "greet" | "handshake" | "buy" | "take" | "put");
        assert_eq!(looped.is_some(), goes_on, "{}", clip.name);
        assert!(looped.is_none_or(|l| l.start > range.start && l.end < range.end && l.len() > 40), "{}", clip.name);
    }
}

#[test]
fn acts_begin_and_end_standing_at_the_same_place() {
    for clip in &SET.clips {
        let (tag, range, _) = tags(clip);
        for frame in [range.start, range.end - 1] {
            let stands = [Contacts::LEFT, Contacts::RIGHT].map(|foot| clip.contacts[frame].any(foot));
            assert_eq!(stands, [true; 2], "{} frame {frame}", clip.name);
        }
        let [a, b] = [range.start, range.end - 1].map(|f| clip.root_positions[f]);
        // Who stands sways by two centimetres to each side.
        let apart = if tag == "sit" { 0.1 } else { 0.05 };
        assert!(a.distance(b) < apart, "{}: {a} and {b}", clip.name);
    }
}

#[test]
fn feet_stand_and_joints_bend_the_right_way() {
    assert_sound(&SET);
}

#[test]
fn hands_meet_at_the_height_of_the_belly_and_rise_over_the_head_in_joy() {
    let hand = |tag: &str, joint: Joint| {
        let clip = SET.clips.iter().find(|c| tags(c).0 == tag).unwrap();
        let at = |f: usize| clip.joint_positions(&SET.skeleton, f);
        (0..clip.num_frames()).map(|f| (at(f)[joint.index()], at(f)[Joint::Head.index()])).collect::<Vec<_>>()
    };
    let given =
        hand("handshake", Joint::RightHand).into_iter().map(|h| h.0).max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
    assert!((0.95..1.25).contains(&given.y) && (0.4..0.7).contains(&given.z) && given.x.abs() < 0.12, "{given}");
    let farthest =
        |hands: Vec<(glam::Vec3, glam::Vec3)>| hands.into_iter().map(|h| h.0).max_by(|a, b| a.z.total_cmp(&b.z));
    let taken = farthest(hand("take", Joint::RightHand)).unwrap();
    assert!((0.7..1.05).contains(&taken.y) && (0.35..0.75).contains(&taken.z), "{taken}");
    assert!(hand("cheer", Joint::LeftHand).iter().any(|(hand, head)| hand.y > head.y + 0.15));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn every_seed_and_variation_is_sound(seed in 0u64..10_000, variation in 0.0f64..2.0) {
        assert_sound(&people(&SynthConfig { seed, variation, ..SynthConfig::for_set(SynthSet::People) }));
    }
}
