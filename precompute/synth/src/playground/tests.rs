//! What the whole set promises, measured on the finished clips.

use super::*;
use crate::SynthSet;
use crate::checks::*;
use glam::{DVec2, Quat, Vec3};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::sync::LazyLock;
use throng_core::{Joint, NUM_JOINTS};

static SET: LazyLock<ClipSet> = LazyLock::new(|| playground(&SynthConfig::for_set(SynthSet::Playground)));

const HANDS: [(Joint, Contacts, f32); 2] =
    [(Joint::LeftHand, Contacts::LEFT_HAND, 1.0), (Joint::RightHand, Contacts::RIGHT_HAND, -1.0)];

/// Joints of every frame.
fn transforms(set: &ClipSet, clip: &Clip) -> Vec<[(Vec3, Quat); NUM_JOINTS]> {
    (0..clip.num_frames()).map(|f| clip.joint_transforms(&set.skeleton, f)).collect()
}

/// The middle of a palm.
fn palm(joints: &[(Vec3, Quat); NUM_JOINTS], hand: Joint, sign: f32) -> Vec3 {
    let (at, turn) = joints[hand.index()];
    at + turn * Vec3::X * (sign * 0.065)
}

/// True within a tag of one of these names.
fn tagged(clip: &Clip, frame: usize, names: &[&str]) -> bool {
    clip.tags.iter().any(|t| names.contains(&t.name.as_str()) && t.range.contains(&frame))
}

/// Planted feet and hands stand still, joints bend the right way, and soles stay above what they tread on.
fn assert_sound(set: &ClipSet) {
    assert_planted_feet_stand_still(set, 0.03);
    assert_soles_stay_above_what_they_tread_on(set);
    for clip in &set.clips {
        assert_knees_bend(clip, &(3.0..152.0));
        assert_elbows_bend(clip, &(5.0..152.0), f32::INFINITY);
        let at = transforms(set, clip);
        let planted = |f: usize, bit: Contacts| clip.contacts[f].any(bit) && clip.contacts[f - 1].any(bit);
        for f in 1..clip.num_frames() {
            for (hand, bit, sign) in HANDS {
                let moved = palm(&at[f], hand, sign).distance(palm(&at[f - 1], hand, sign));
                assert!(!planted(f, bit) || moved < 5e-3, "{} frame {f} {}: {moved} m", clip.name, hand.name());
            }
        }
    }
}

/// How deep a point is below the ground, a tread or a deck, sideways as well as down (m).
fn depth(p: Vec3) -> f64 {
    let below = |aside: DVec2| gym::ground(DVec2::new(f64::from(p.x), f64::from(p.z)) + aside) - f64::from(p.y);
    let beside = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|way| below(0.01 * way));
    beside.into_iter().fold(below(DVec2::ZERO), f64::min)
}

fn assert_soles_stay_above_what_they_tread_on(set: &ClipSet) {
    let rest = set.skeleton.rest_positions();
    for clip in &set.clips {
        let at = transforms(set, clip);
        for f in (0..clip.num_frames()).filter(|f| !tagged(clip, *f, &["climb", "sit"])) {
            for (_, foot, toe, ..) in FEET {
                let heel = Vec3::new(0.0, -rest[foot.index()].y, -0.045);
                let [ball, tip] = [0.0, 0.07].map(|z| Vec3::new(0.0, -rest[toe.index()].y, z));
                for (joint, point) in [(foot, heel), (toe, ball), (toe, tip)] {
                    let (p, turn) = at[f][joint.index()];
                    let deep = depth(p + turn * point);
                    assert!(deep < 0.01, "{} frame {f} {}: {deep} m", clip.name, joint.name());
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn every_seed_and_variation_stands_and_bends(seed in 0u64..10_000, variation in 0.0f64..2.0) {
        assert_sound(&playground(&SynthConfig { seed, variation, minutes: 0.5, ..SynthConfig::default() }));
    }
}

#[test]
fn planted_parts_stand_still_joints_bend_the_right_way_and_nothing_pops() {
    assert_sound(&SET);
    for clip in &SET.clips {
        assert_nothing_pops(clip, |j| if j >= Joint::LeftClavicle { 400.0 } else { 60.0 });
        let rate = clip.rate_hz as f32;
        for f in 2..clip.num_frames() {
            let [a, b, c] = [f - 2, f - 1, f].map(|f| clip.root_positions[f]);
            let acceleration = ((c - b) - (b - a)).length() * rate * rate;
            assert!(acceleration < 14.0, "{} frame {f}: {acceleration} m/s^2", clip.name);
        }
    }
}

/// Frames of a tag, without its first and last `rim`.
fn within<'a>(clip: &'a Clip, name: &'a str, rim: usize) -> impl Iterator<Item = usize> + 'a {
    let tags = clip.tags.iter().filter(move |t| t.name == name);
    tags.flat_map(move |t| t.range.start + rim..t.range.end.saturating_sub(rim))
}

#[test]
fn climbers_hold_rungs_and_rails_and_stay_close() {
    let offset =
        |p: Vec3| Vec3::new(p.x - gym::LADDER.x as f32, p.y, p.z - gym::LADDER.y as f32 + gym::LADDER_FRONT as f32);
    let mut held = 0;
    for clip in &SET.clips {
        let at = transforms(&SET, clip);
        for f in within(clip, "climb", 0) {
            for (hand, bit, sign) in HANDS.into_iter().filter(|h| clip.contacts[f].any(h.1)) {
                let p = offset(palm(&at[f], hand, sign));
                let rung = (p.y / gym::RUNG as f32).round().clamp(1.0, 7.0) * gym::RUNG as f32;
                let from_rung = (p.y - rung).hypot(p.z);
                let from_rail = (p.x.abs() - gym::RAIL_ASIDE as f32).hypot(p.z);
                // Half a hand and the bar are 0.046 m thick.
                let gap = from_rung.min(from_rail) - 0.046;
                assert!(gap.abs() < 0.03, "{} frame {f} {} {bit:?}: {gap} m", clip.name, hand.name());
                held += 1;
            }
        }
        for f in within(clip, "climb", 45) {
            let parts = [Contacts::LEFT, Contacts::RIGHT, Contacts::LEFT_HAND, Contacts::RIGHT_HAND];
            let num = parts.into_iter().filter(|p| clip.contacts[f].any(*p)).count();
            assert!(num >= 2, "{} frame {f}: {:?}", clip.name, clip.contacts[f]);
            let hips = offset(clip.root_positions[f]);
            assert!(hips.y > 2.5 || (-0.48..-0.28).contains(&hips.z), "{} frame {f}: {hips}", clip.name);
        }
    }
    assert!(held > 1000, "{held}");
}

#[test]
fn slides_speed_up_and_come_to_rest_on_the_seat() {
    for clip in &SET.clips {
        for tag in clip.tags.iter().filter(|t| t.name == "slide") {
            let speed = |f: usize| clip.root_positions[f].distance(clip.root_positions[f - 1]) * clip.rate_hz as f32;
            let peak = tag.range.clone().map(speed).fold(0.0, f32::max);
            assert!((1.7..3.4).contains(&peak), "{} {:?}: {peak} m/s", clip.name, tag.range);
            assert!(speed(tag.range.end) < 0.5, "{} {:?}", clip.name, tag.range);
            for f in tag.range.clone() {
                assert!(clip.contacts[f].any(Contacts::SEAT), "{} frame {f}", clip.name);
                // At the end the feet carry too, lower down.
                let on_feet = clip.contacts[f].any(Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0));
                let height = clip.root_positions[f].y - clip.support[f];
                assert!(on_feet || (0.08..0.25).contains(&height), "{} frame {f}: {height} m", clip.name);
            }
        }
    }
}

#[test]
fn stands_are_those_of_the_walk_set() {
    let walk = super::super::walk::walk(&SynthConfig { minutes: 0.1, ..SynthConfig::default() });
    let (neutral, height) = (walk.clips[0].frame_rotations(0), walk.clips[0].root_positions[0].y);
    for clip in &SET.clips {
        for tag in clip.tags.iter().filter(|t| t.name == "stand") {
            let f = (tag.range.start + tag.range.end) / 2;
            let pose = clip.frame_rotations(f);
            let apart = (1..NUM_JOINTS).map(|j| pose[j].angle_between(neutral[j])).sum::<f32>() / NUM_JOINTS as f32;
            assert!(apart < 0.12, "{} frame {f}: {apart} rad a joint", clip.name);
            let over = clip.root_positions[f].y - clip.support[f] - height;
            assert!(over.abs() < 0.03, "{} frame {f}: {over} m", clip.name);
        }
    }
}

#[test]
fn everything_occurs_several_times() {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for clip in &SET.clips {
        for tag in &clip.tags {
            let [a, b] = [tag.range.start, tag.range.end - 1].map(|f| clip.support[f]);
            let way = match b - a {
                rise if rise > 1.0 => " up",
                rise if rise < -1.0 => " down",
                _ => "",
            };
            *counts.entry(format!("{}{way}", tag.name)).or_default() += 1;
        }
    }
    for (name, least) in
        [("stairs up", 4), ("stairs down", 2), ("climb up", 3), ("climb down", 1), ("sit down", 5), ("stand", 40)]
    {
        assert!(counts.get(name).is_some_and(|n| *n >= least), "{name}: {counts:?}");
    }
}

#[test]
fn the_units_are_as_large_as_the_rig_believes() {
    let set: UnitFile = data("units/playground.toml");
    let unit = |name: &str| set.units.iter().find(|u| u.name == name).expect("a unit of that name");
    let near = |a: f32, b: f64| assert!((f64::from(a) - b).abs() < 1e-3, "{a} {b}");
    for (k, shape) in unit("stairs").shapes.iter().enumerate() {
        let CheckShape::Box { at, size, .. } = shape else { panic!("a step is a box") };
        near(at[1] + 0.5 * size[1], gym::RISE * (k + 1) as f64);
        near(at[2] - 0.5 * size[2], gym::GOING * k as f64);
    }
    let bars = unit("ladder").shapes.iter().map(|s| match s {
        CheckShape::Bar { from, to, radius } => (*from, *to, *radius),
        _ => panic!("a ladder is made of bars"),
    });
    let (rungs, rails): (Vec<_>, Vec<_>) = bars.partition(|(from, to, _)| from[1] == to[1]);
    for (k, (from, to, radius)) in rungs.iter().enumerate() {
        near(from[1], gym::RUNG * (k + 1) as f64);
        near(from[2], -gym::LADDER_FRONT);
        near(to[0], gym::RAIL_ASIDE);
        near(*radius, gym::RUNG_RADIUS);
    }
    assert_eq!((rungs.len(), rails.len()), (7, 2));
    rails.iter().for_each(|(_, to, _)| near(to[1], gym::RAIL_TOP));
    for (name, course, drop) in [
        ("slide_top", course::SlideCourse::straight(gym::SLIDE_A, gym::LEVEL), 0.0),
        ("slide_mid", course::SlideCourse::straight(gym::SLIDE_A, gym::LEVEL), 0.7),
        ("slide_bottom", course::SlideCourse::straight(gym::SLIDE_A, gym::LEVEL), 1.4),
        ("slide_curved", course::SlideCourse::curved(footsteps::FeetStance::default(), gym::LEVEL), 0.0),
    ] {
        // The bed comes first of every three boxes; the middle of its upper side is on the course.
        for shape in unit(name).shapes.iter().step_by(3) {
            let CheckShape::Box { at, size, heading_deg, pitch_deg } = shape else { panic!("a bed is a box") };
            let turn = Quat::from_rotation_y(heading_deg.to_radians()) * Quat::from_rotation_x(pitch_deg.to_radians());
            let top = Vec3::from(*at) + turn * Vec3::Y * (0.5 * size[1]);
            let before = drop / 0.75;
            let nearest = (0..800).map(|k| 0.005 * f64::from(k)).min_by(|a, b| {
                let far = |s: f64| {
                    let p = course.ground_stance(s).at - course.start.at;
                    (p - DVec2::new(f64::from(top.x), f64::from(top.z) + before)).length()
                };
                far(*a).total_cmp(&far(*b))
            });
            let s = nearest.expect("a place on the course");
            let height = course.height(s) - gym::LEVEL + drop;
            assert!((height - f64::from(top.y)).abs() < 0.02, "{name}: {top} at {s}, expected {height}");
        }
    }
}

#[test]
fn the_environment_stands_where_the_rig_believes() {
    let file: CheckEnvironmentFile = data("environments/playground.toml");
    let at = |unit: &str, k: usize| {
        let place = file.place.iter().filter(|p| p.unit == unit).nth(k).expect("a unit of that name");
        (DVec2::new(f64::from(place.at[0]), f64::from(place.at[2])), f64::from(place.at[1]), place)
    };
    let near = |a: DVec2, b: DVec2| assert!((a - b).length() < 1e-3, "{a} {b}");
    for (k, deck) in [gym::DECK_A, gym::DECK_B].into_iter().enumerate() {
        let (first, level, place) = at("ground", k + 1);
        near(first - 1.4, deck.min);
        near(deck.min + 2.8 * DVec2::new(f64::from(place.repeat[0]), f64::from(place.repeat[2])), deck.max);
        assert!((level - deck.level).abs() < 1e-3);
    }
    for (k, stairs) in [gym::STAIRS_A, gym::STAIRS_B].into_iter().enumerate() {
        let (foot, _, place) = at("stairs", k);
        near(foot, stairs.foot);
        assert_eq!(4 * place.repeat[2] as usize, stairs.num_steps);
    }
    near(at("ladder", 0).0, gym::LADDER);
    for (k, slide) in [gym::SLIDE_A, gym::SLIDE_B].into_iter().enumerate() {
        near(at("slide_top", k).0, slide.at);
    }
    let (edge, _, place) = at("slide_curved", 0);
    near(edge, gym::SLIDE_CURVED.at);
    assert!((f64::from(place.heading_deg).to_radians() - gym::SLIDE_CURVED.heading).abs() < 1e-6);
}
