//! What the whole set promises, measured on the finished clips.

use super::*;
use crate::checks::*;
use glam::Vec2;
use throng_core::planar::{twist_about_y, wrap_angle};
use throng_core::{Contacts, Joint};
use throng_motion::clip::Clip;

fn set() -> ClipSet {
    walk(&SynthConfig::default())
}

/// A stay of a flat foot on the ground.
struct Stand {
    side: usize,
    frames: std::ops::Range<usize>,
    ankle: Vec2,
    heading: f32,
}

/// Stays of both feet, in the order in which they begin.
fn stands(clip: &Clip, set: &ClipSet) -> Vec<Stand> {
    let mut out = Vec::new();
    for (side, (_, foot, _, heel, _)) in FEET.into_iter().enumerate() {
        let mut start = None;
        for f in 0..=clip.num_frames() {
            let down = f < clip.num_frames() && clip.contacts[f].any(heel);
            match (down, start) {
                (true, None) => start = Some(f),
                (false, Some(s)) => {
                    let (p, q) = clip.joint_transforms(&set.skeleton, s)[foot.index()];
                    let ankle = Vec2::new(p.x, p.z);
                    out.push(Stand { side, frames: s..f, ankle, heading: twist_about_y(q) });
                    start = None;
                }
                _ => {}
            }
        }
    }
    out.sort_by_key(|s| s.frames.start);
    out
}

#[test]
fn what_carries_stands_still_knees_never_lock_and_nothing_pops() {
    let set = set();
    assert_planted_feet_stand_still(&set, 0.02);
    // Captured walking up to 1.5 m/s reaches 200 to 320 rad/s^2 in the knee as it stops before heel strike; brisker steps
    // are in this set.
    let most = |j| if j >= Joint::LeftThigh { 380.0 } else { 60.0 };
    for clip in &set.clips {
        assert_knees_bend(clip, &(3.0..86.0));
        assert_nothing_pops(clip, most);
    }
}

#[test]
fn one_foot_always_carries_or_is_about_to() {
    for clip in &set().clips {
        let mut airborne = 0;
        for c in &clip.contacts {
            airborne = if *c == Contacts::NONE { airborne + 1 } else { 0 };
            // The heel rocker of a quick step counts as no contact yet.
            assert!(airborne <= 4, "{}", clip.name);
        }
    }
}

#[test]
fn soles_stay_above_the_ground() {
    let set = set();
    assert_soles_stay_above(&set, -0.005);
    let rest = set.skeleton.rest_positions();
    for clip in &set.clips {
        for at in positions(&set, clip) {
            let is_above = |toe: Joint| at[toe.index()].y > rest[toe.index()].y - 0.005;
            assert!(FEET.iter().all(|(_, _, toe, ..)| is_above(*toe)), "{}", clip.name);
        }
    }
}

#[test]
fn rotations_are_unit_and_do_not_flip() {
    for clip in &set().clips {
        for f in 0..clip.num_frames() {
            for (j, q) in clip.frame_rotations(f).iter().enumerate() {
                assert!((q.length() - 1.0).abs() < 1e-5);
                assert!(f == 0 || q.dot(clip.frame_rotations(f - 1)[j]) > 0.0);
            }
        }
    }
}

#[test]
fn clips_begin_and_end_standing_on_both_feet() {
    for clip in &set().clips {
        let all = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);
        let n = clip.num_frames();
        assert!(clip.contacts[..25].iter().chain(&clip.contacts[n - 25..]).all(|c| c.all(all)));
        for f in (1..10).chain(n - 10..n) {
            assert!((clip.root_positions[f] - clip.root_positions[f - 1]).length() * 30.0 < 0.15);
        }
    }
}

/// Of every step: heading change, length, and speed from the landing before to this one.
fn steps(set: &ClipSet) -> Vec<(f32, f32, f32)> {
    let mut out = Vec::new();
    for clip in &set.clips {
        for w in stands(clip, set).windows(3) {
            let alternate = w[0].side != w[1].side && w[1].side != w[2].side;
            let quick = w[2].frames.start - w[1].frames.start < 30 && w[1].frames.start - w[0].frames.start < 30;
            if alternate && quick {
                let turn = 0.5 * wrap_angle(w[2].heading - w[0].heading);
                let length = 0.5 * (w[2].ankle - w[0].ankle).length();
                let time = (w[2].frames.start - w[0].frames.start) as f32 / 60.0;
                out.push((turn.to_degrees(), length, length / time));
            }
        }
    }
    out
}

#[test]
fn steps_grow_with_speed_as_peoples_do() {
    // Slower ones are starts and stops, whose steps are short for their speed.
    let straight: Vec<_> = steps(&set()).into_iter().filter(|s| s.0.abs() < 1.0 && s.2 > 0.62).collect();
    assert!(straight.len() > 60);
    for (_, length, speed) in &straight {
        let expected = gait::step_at(f64::from(*speed)).length as f32;
        assert!((length / expected - 1.0).abs() < 0.25, "{length} m at {speed} m/s, expected {expected}");
    }
    let mean = straight.iter().map(|(_, l, v)| l / gait::step_at(f64::from(*v)).length as f32).sum::<f32>();
    assert!((mean / straight.len() as f32 - 1.0).abs() < 0.07);
}

#[test]
fn turns_and_speeds_of_every_kind_occur() {
    let steps = steps(&set());
    let count = |turn: std::ops::Range<f32>, speed: std::ops::Range<f32>| {
        steps.iter().filter(|s| turn.contains(&s.0) && speed.contains(&s.2)).count()
    };
    for (turn, least) in [(3.0..12.0, 20), (12.0..25.0, 30), (25.0..50.0, 20)] {
        let mirrored = -turn.end..-turn.start;
        let (left, right) = (count(turn.clone(), 0.2..2.0), count(mirrored, 0.2..2.0));
        assert!(left >= least && right >= least, "{turn:?} degrees: {left} left, {right} right");
    }
    let (left, right) = (count(15.0..90.0, 0.0..0.2), count(-90.0..-15.0, 0.0..0.2));
    assert!(left >= 10 && right >= 10, "on the spot: {left} left, {right} right");
    for speed in [0.5, 0.8, 1.1, 1.4] {
        let n = count(-90.0..90.0, speed..speed + 0.3);
        assert!(n >= 25, "{speed} m/s: {n} steps");
    }
}
