//! What the set promises, measured on the finished clips.

use super::*;
use crate::checks::*;
use crate::{SynthSet, make_set};
use glam::{Quat, Vec3};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::sync::LazyLock;
use throng_core::{Contacts, Joint, NUM_JOINTS};
use throng_motion::clip::{Clip, ClipTag};

const HANDS: [(Joint, Contacts); 2] =
    [(Joint::LeftHand, Contacts::LEFT_HAND), (Joint::RightHand, Contacts::RIGHT_HAND)];
const STANDING: [&str; 4] = ["idle", "chat", "dispute", "present"];
const AT_DESK: [&str; 4] = ["sit_down", "work", "desk_chat", "stand_up"];

static SET: LazyLock<ClipSet> = LazyLock::new(|| office(&SynthConfig::for_set(SynthSet::Office)));
static WALK: LazyLock<ClipSet> = LazyLock::new(|| make_set(SynthSet::Walk, &SynthConfig::default()).unwrap());

fn short(seed: u64, variation: f64) -> ClipSet {
    office(&SynthConfig { seed, variation, minutes: 1.2, clip_seconds: 30.0, ..SynthConfig::default() })
}

fn desk_clips(set: &ClipSet) -> impl Iterator<Item = &Clip> {
    set.clips.iter().filter(|c| c.name.starts_with("office_desk"))
}

fn tagged<'a>(clip: &'a Clip, name: &'a str) -> impl Iterator<Item = &'a ClipTag> {
    clip.tags.iter().filter(move |t| t.name == name)
}

/// Distance of what touches the seat from where it sits (m).
fn off_the_seat(clip: &Clip, frame: usize) -> f32 {
    let buttocks = assemble::BUTTOCKS.as_vec3();
    let at = clip.root_positions[frame] + clip.frame_rotations(frame)[0] * buttocks;
    at.distance(desk::SEAT.as_vec3())
}

/// Planted feet stand still, joints bend the right way, and who sits stays on the chair.
fn assert_sound(set: &ClipSet) {
    assert_planted_feet_stand_still(set, 0.02);
    for clip in &set.clips {
        assert_knees_bend(clip, &(1.0..115.0));
        assert_elbows_bend(clip, &(5.0..150.0), f32::INFINITY);
        for f in 0..clip.num_frames() {
            if clip.contacts[f].any(Contacts::SEAT) {
                assert!(off_the_seat(clip, f) < 2e-3, "{} frame {f}: {} m", clip.name, off_the_seat(clip, f));
            }
        }
    }
}

#[test]
fn characters_stand_sit_on_the_chair_and_nowhere_else_and_bend_the_right_way() {
    assert_sound(&SET);
    for clip in &SET.clips {
        for f in 0..clip.num_frames() {
            let low = clip.root_positions[f].y < 0.62;
            assert!(!low || clip.contacts[f].any(Contacts::SEAT) || off_the_seat(clip, f) < 0.12, "{} {f}", clip.name);
        }
        let seats = throng_motion::clip::runs_where(0..clip.num_frames(), |f| clip.contacts[f].any(Contacts::SEAT));
        assert_eq!(seats.len(), tagged(clip, "sit_down").count(), "{}", clip.name);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]
    #[test]
    fn every_seed_and_variation_stands_sits_and_bends(seed in 0u64..10_000, variation in 0.0f64..2.0) {
        let set = short(seed, variation);
        assert_sound(&set);
        for clip in &set.clips {
            prop_assert!(clip.root_positions.iter().all(|p| p.is_finite() && (0.5..1.0).contains(&p.y)));
        }
    }
}

/// Boxes of the desk as the unit file has them: centre and half the edge lengths.
fn furniture() -> Vec<(Vec3, Vec3)> {
    let file: UnitFile = data("units/office.toml");
    let desk = file.units.into_iter().find(|u| u.name == "desk").unwrap();
    let of_shape = |shape: &CheckShape| match *shape {
        CheckShape::Box { at, size, .. } => (Vec3::from(at), 0.5 * Vec3::from(size)),
        CheckShape::Bar { from, to, radius } => {
            let (a, b) = (Vec3::from(from), Vec3::from(to));
            (0.5 * (a + b), 0.5 * (a - b).abs() + Vec3::new(radius, 0.0, radius))
        }
    };
    let boxes: Vec<_> = desk.shapes.iter().map(of_shape).collect();
    assert!(boxes.len() > 10);
    boxes
}

#[test]
fn bodies_do_not_pass_through_desk_or_chair() {
    // Half the thickness of a limb, less the 2 cm by which flesh and cloth may be in the way.
    const CORE: f32 = 0.02;
    let boxes = furniture();
    for clip in desk_clips(&SET) {
        for (f, at) in positions(&SET, clip).iter().enumerate() {
            for joint in &Joint::ALL[1..] {
                let Some(parent) = joint.parent() else { continue };
                for u in [0.0, 0.25, 0.5, 0.75, 1.0] {
                    let p = at[parent.index()].lerp(at[joint.index()], u);
                    for (centre, half) in &boxes {
                        let outside = ((p - centre).abs() - half).max(Vec3::ZERO).length();
                        let free = outside > if *joint >= Joint::LeftThigh { CORE } else { 0.5 * CORE };
                        assert!(free, "{} frame {f} {}: {p} in the box at {centre}", clip.name, joint.name());
                    }
                }
            }
        }
    }
}

#[test]
fn hands_rest_on_the_desk() {
    let mut rested = [0, 0];
    for clip in desk_clips(&SET) {
        let at = positions(&SET, clip);
        for (side, (hand, bit)) in HANDS.into_iter().enumerate() {
            for f in (0..clip.num_frames()).filter(|f| clip.contacts[*f].any(bit)) {
                let p = at[f][hand.index()];
                let over = p.y - desk::TOP as f32;
                assert!((0.02..0.075).contains(&over), "{} frame {f} {}: {over} m", clip.name, hand.name());
                assert!((0.48..0.7).contains(&p.z) && p.x.abs() < 0.6, "{} frame {f}: {p}", clip.name);
                rested[side] += 1;
            }
        }
    }
    assert!(rested.iter().all(|n| *n > 1000), "{rested:?}");
}

#[test]
fn nothing_pops() {
    let most = |j| match j {
        _ if j >= Joint::LeftThigh => 380.0,
        Joint::LeftUpperArm | Joint::RightUpperArm | Joint::LeftForearm | Joint::RightForearm => 240.0,
        Joint::LeftHand | Joint::RightHand => 150.0,
        _ => 60.0,
    };
    SET.clips.iter().for_each(|clip| assert_nothing_pops(clip, most));
}

/// Largest acceleration of the hips (m/s^2).
fn peak_of_hips(set: &ClipSet) -> f32 {
    let of = |c: &Clip| c.root_positions.windows(3).map(|p| (p[0] - 2.0 * p[1] + p[2]).length()).fold(0.0, f32::max);
    set.clips.iter().map(of).fold(0.0, f32::max) * 900.0
}

#[test]
fn hips_are_as_smooth_as_in_walking() {
    assert!(peak_of_hips(&SET) < 1.1 * peak_of_hips(&WALK), "{} {}", peak_of_hips(&SET), peak_of_hips(&WALK));
}

/// How far a pose is from another one, joint by joint (rad).
fn apart(a: &[Quat], b: &[Quat]) -> [f32; NUM_JOINTS] {
    std::array::from_fn(|j| a[j].angle_between(b[j]))
}

#[test]
fn behaviours_begin_and_end_in_the_neutral_stand() {
    for clip in SET.clips.iter().filter(|c| c.name.starts_with("office_stand")) {
        let home = clip.root_positions[5];
        for tag in clip.tags.iter().filter(|t| STANDING.contains(&t.name.as_str())) {
            for f in [tag.range.start, tag.range.end + 2] {
                let moved = clip.root_positions[f].distance(home);
                assert!(moved < 0.08, "{} {} frame {f}: {moved} m", clip.name, tag.name);
                let apart = apart(clip.frame_rotations(f), clip.frame_rotations(5));
                for (j, apart) in Joint::ALL.into_iter().zip(apart) {
                    // The walker's own drift of gaze and arms goes on in the stand.
                    let most = if j == Joint::Head || j == Joint::Neck { 0.45 } else { 0.16 };
                    assert!(apart < most, "{} {} frame {f} {}: {apart} rad", clip.name, tag.name, j.name());
                }
            }
        }
    }
}

#[test]
fn the_neutral_stand_is_the_walk_sets() {
    let calm = |set| make_set(set, &SynthConfig { minutes: 0.05, variation: 0.0, ..SynthConfig::default() }).unwrap();
    let (office, walk) = (calm(SynthSet::Office), calm(SynthSet::Walk));
    let stand = office.clips.iter().find(|c| c.name == "office_stand_00").unwrap();
    for f in 0..15 {
        let apart = apart(stand.frame_rotations(f), walk.clips[0].frame_rotations(f));
        for (j, apart) in Joint::ALL.into_iter().zip(apart) {
            assert!(apart < 0.06, "frame {f} {}: {apart} rad", j.name());
        }
        assert!((stand.root_positions[f].y - walk.clips[0].root_positions[f].y).abs() < 5e-3);
    }
}

#[test]
fn everything_occurs_often_and_long_enough() {
    let mut counts: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for tag in SET.clips.iter().flat_map(|c| &c.tags) {
        let entry = counts.entry(tag.name.as_str()).or_default();
        *entry = (entry.0 + 1, entry.1 + tag.range.len());
    }
    for name in STANDING {
        let (times, frames) = counts[name];
        assert!(times >= 6 && (150..360).contains(&(frames / times)), "{counts:?}");
    }
    for name in AT_DESK {
        assert!(counts.get(name).is_some_and(|(times, _)| *times >= 6), "{counts:?}");
    }
    assert!(counts["work"].1 > 60 * 30 && counts["walk"].0 >= 16 && counts["stand"].0 >= 40, "{counts:?}");
}

#[test]
fn people_come_from_all_sides_and_leave_to_all_sides() {
    let mut sectors = [[0; 3]; 2];
    for clip in desk_clips(&SET) {
        let sector = |f: usize| {
            let p = clip.root_positions[f];
            assert!((1.2..2.9).contains(&p.x.hypot(p.z)), "{} frame {f}: {p}", clip.name);
            match p.x {
                x if x.abs() < 0.8 => 1,
                x if x > 0.0 => 0,
                _ => 2,
            }
        };
        let stands: Vec<usize> = tagged(clip, "stand").map(|t| t.range.start + t.range.len() / 2).collect();
        for (come, leave) in stands.iter().zip(&stands[1..]) {
            sectors[0][sector(*come)] += 1;
            sectors[1][sector(*leave)] += 1;
        }
    }
    assert!(sectors.iter().all(|s| s.iter().all(|n| *n >= 2)), "{sectors:?}");
}

/// The angles between where heads of two look and the middles of each other's heads, over what a tag names (rad).
fn off_faces(set: &ClipSet, pair: [&Clip; 2], range: std::ops::Range<usize>) -> Vec<f32> {
    let head = |clip: &Clip, f: usize| {
        let chain = [Joint::Hips, Joint::Spine, Joint::Chest, Joint::UpperChest, Joint::Neck, Joint::Head];
        let turn = chain.iter().fold(Quat::IDENTITY, |q, j| q * clip.frame_rotations(f)[j.index()]);
        let at = clip.joint_positions(&set.skeleton, f)[Joint::Head.index()];
        (at + turn * (0.5 * set.skeleton.tips[0]), turn * Vec3::Z)
    };
    let of = |f: usize| {
        let [(a, looks_a), (b, looks_b)] = pair.map(|clip| head(clip, f));
        [looks_a.angle_between(b - a), looks_b.angle_between(a - b)]
    };
    range.flat_map(of).collect()
}

#[test]
fn partners_look_each_other_in_the_face() {
    for clip in SET.clips.iter().filter(|c| c.name.starts_with("office_pair") && c.name.ends_with("_a")) {
        let name = clip.name.replace("_a", "_b");
        let other = SET.clips.iter().find(|c| c.name == name).unwrap();
        for tag in &clip.tags {
            let mut off = off_faces(&SET, [clip, other], tag.range.clone());
            off.sort_by(f32::total_cmp);
            let at = |share: f32| off[((off.len() - 1) as f32 * share) as usize].to_degrees();
            // What is handed over is looked at, and who talks looks about.
            let most = match tag.name.as_str() {
                "handshake" => [6.5, 13.0],
                "dance" | "dispute" => [9.0, 13.0],
                _ => [13.0, 32.0],
            };
            let found = [at(0.5), at(0.9)];
            assert!(found[0] < most[0] && found[1] < most[1], "{} {}: {found:?} deg", clip.name, tag.name);
        }
    }
}
