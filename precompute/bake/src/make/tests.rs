use super::*;
use crate::features::FeaturesConfig;
use crate::graph;
use glam::Vec3;
use throng_base::SingleRank;
use throng_core::{Contacts, Joint, NUM_JOINTS};
use throng_motion::annotate::contacts::FOOT_PARTS;
use throng_motion::progress::Silent;
use throng_synth::{SynthConfig, SynthSet, make_set};

/// Synthetic gaits and stands whose names begin so, with mirrored copies.
fn library(names: &[&str]) -> ClipSet {
    let mut set = make_set(SynthSet::Locomotion, &SynthConfig::for_set(SynthSet::Locomotion)).unwrap();
    set.clips.retain(|c| names.iter().any(|n| c.name.starts_with(n)));
    set.clips = set.clips.into_iter().flat_map(|c| [c.clone(), mirror::mirror_clip(&c)]).collect();
    set
}

fn made_of(set: &ClipSet) -> MadeMotion {
    make_missing(set, Lacks::ALL, &MotionGraphConfig::default(), true, &SingleRank).unwrap()
}

/// 95th percentile of the speed of planted feet, largest acceleration of a joint, lowest part of a foot (m, s).
fn figures(set: &ClipSet, clips: &[Clip]) -> [f32; 3] {
    let (mut slip, mut most, mut low) = (Vec::new(), 0.0f32, 0.0f32);
    for clip in clips {
        let rate = clip.rate_hz as f32;
        let at: Vec<[Vec3; NUM_JOINTS]> =
            (0..clip.num_frames()).map(|f| clip.joint_positions(&set.skeleton, f)).collect();
        for f in 1..at.len() - 1 {
            for (joint, part) in FOOT_PARTS {
                let j = joint.index();
                if clip.contacts[f].any(part) && clip.contacts[f - 1].any(part) {
                    slip.push(at[f][j].distance(at[f - 1][j]) * rate);
                }
                low = low.min(at[f][j].y);
            }
            let bends = (0..NUM_JOINTS).map(|j| (at[f + 1][j] - 2.0 * at[f][j] + at[f - 1][j]).length() * rate * rate);
            most = bends.fold(most, f32::max);
        }
    }
    slip.sort_by(f32::total_cmp);
    [slip[slip.len() * 95 / 100], most, low]
}

#[test]
fn made_walks_slip_and_jolt_no_more_than_captured_ones() {
    for names in [&["walk_", "idle_"][..], &["walk_"]] {
        let set = library(names);
        let made = made_of(&set);
        assert!(
            made.report.starts > 2 && made.report.stops > 0 && made.report.turns > 2,
            "{names:?}: {:?}",
            made.report
        );
        let [captured, made] = [&set.clips, &made.clips].map(|clips| figures(&set, clips));
        assert!(made[0] < 1.2 * captured[0] + 0.01, "{names:?}: planted feet slip {} m/s of {}", made[0], captured[0]);
        assert!(made[1] < 1.2 * captured[1], "{names:?}: joints jolt by {} m/s2 of {}", made[1], captured[1]);
        assert!(made[2] > captured[2] - 0.02, "{names:?}: feet go {} m into the ground of {}", made[2], captured[2]);
    }
}

#[test]
fn stands_begin_and_end_with_all_of_both_feet_on_the_ground() {
    let set = library(&["walk_", "idle_"]);
    let both = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);
    for clip in made_of(&set).clips.iter().filter(|c| c.name.starts_with("made/turn")) {
        let last = clip.num_frames() - 1;
        assert!(clip.contacts[0].all(both) && clip.contacts[last].all(both), "{}", clip.name);
        let turned = throng_core::planar::wrap_angle(clip.planar(last).heading - clip.planar(0).heading).abs();
        let named: f32 = clip.name.split('-').rev().nth(1).and_then(|n| n.parse().ok()).unwrap_or(0.0);
        assert!((turned - named.abs().to_radians()).abs() < 0.1, "{} turns by {turned} rad", clip.name);
    }
}

#[test]
fn walks_alone_give_people_who_set_off_and_stand() {
    let mut set = library(&["walk_neutral"]);
    let graph = |set: &ClipSet| {
        graph::connect(set, &FeaturesConfig::default(), &MotionGraphConfig::default(), &Silent, &SingleRank).unwrap().0
    };
    let before = graph(&set);
    let lacks = Lacks::of_graph(&set, &before);
    assert!(lacks.starts && lacks.turns && !before.standing.contains(&true));
    let made = made_of(&set);
    assert!(made.report.stance.is_empty() && made.report.stands == 1);
    set.clips.extend(made.clips);
    let after = graph(&set);
    assert!(after.standing.iter().filter(|s| **s).count() > 4);
    let starts = set.frame_starts();
    let played = graph::played_frames(&after, &set);
    for name in ["made/start-0-0", "made/stop-0", "walk_neutral"] {
        let c = set.clips.iter().position(|c| c.name.starts_with(name)).unwrap();
        assert!(played[starts[c] as usize..starts[c + 1] as usize].contains(&true), "{name} is not played");
    }
}

#[test]
fn a_foot_at_its_place_is_where_it_was() {
    let set = library(&["walk_neutral"]);
    let clip = &set.clips[0];
    for (frame, foot) in [(10, 0), (25, 1)] {
        let at = feet::foot_point(clip, &set.skeleton, frame, foot);
        let place = throng_core::Planar::new(0.4, -1.2, 2.0);
        let back = at.seen_from(place).laid_at(place);
        assert!(back.toe.distance(at.toe) < 1e-5 && back.turn.angle_between(at.turn) < 1e-3);
        let toe = [Joint::LeftToe, Joint::RightToe][foot];
        assert!(at.toe.distance(clip.joint_positions(&set.skeleton, frame)[toe.index()]) < 1e-6);
    }
}

#[test]
fn what_was_made_is_told_in_a_sentence() {
    let report = MadeReport { clips: 12, starts: 4, stops: 4, turns: 3, stands: 1, ..MadeReport::default() };
    assert_eq!(report.summary(), "12 clips made: 4 starts, 4 stops, 3 turns, 1 stand");
    assert_eq!(MadeReport::default().summary(), "");
}
