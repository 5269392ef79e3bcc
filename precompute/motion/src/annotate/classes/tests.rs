use super::*;
use glam::{Quat, Vec3};
use throng_core::{Joint, NUM_JOINTS};

/// A body with hanging arms that goes at these velocities, for two seconds each (m/s, as seen from the body: left, ahead).
fn clip(name: &str, ways: &[[f32; 2]], turned: f32) -> Clip {
    let (s, heading) = (Skeleton::default(), Quat::from_rotation_y(turned));
    let (mut at, mut roots) = (s.offsets[0], Vec::new());
    for [left, ahead] in ways {
        for _ in 0..60 {
            at += heading * Vec3::new(*left, 0.0, *ahead) / 30.0;
            roots.push(at);
        }
    }
    let mut rotations = vec![Quat::IDENTITY; roots.len() * NUM_JOINTS];
    for pose in rotations.chunks_mut(NUM_JOINTS) {
        pose[0] = heading;
        pose[Joint::LeftUpperArm.index()] = Quat::from_rotation_z(-1.4);
        pose[Joint::RightUpperArm.index()] = Quat::from_rotation_z(1.4);
    }
    Clip::new(name, 30.0, roots, rotations)
}

fn classes(clip: &Clip) -> Vec<ClassSpan> {
    classify(clip, &Skeleton::default(), &NameHints::new(&clip.name, ""))
}

#[test]
fn spans_follow_what_a_clip_does_one_after_the_other() {
    let ways = [[0.0, 0.0], [0.0, 1.2], [0.0, -0.8], [0.9, 0.0], [0.0, 4.0], [0.0, 0.0]];
    for turned in [0.0, 2.5] {
        let clip = clip("a", &ways, turned);
        let spans = classes(&clip);
        let gaits: Vec<Gait> = spans.iter().map(|s| s.class.gait).collect();
        let mut once = gaits.clone();
        once.dedup();
        let expected = [Gait::Stand, Gait::Walk, Gait::Backwards, Gait::Strafe, Gait::Run, Gait::Stand];
        assert!(expected.iter().all(|g| once.contains(g)), "{once:?}");
        assert_eq!((once.first(), once.last()), (Some(&Gait::Stand), Some(&Gait::Stand)));
        assert!(spans[0].class.neutral && spans.iter().all(|s| s.class.posture == Posture::Upright), "{spans:?}");
        let side = spans.iter().find(|s| s.class.gait == Gait::Strafe).unwrap();
        assert!((45.0..130.0).contains(&side.travel_deg), "left is positive: {side:?}");
        let ends: Vec<u32> = spans.iter().map(|s| s.frames.start).chain([clip.num_frames() as u32]).collect();
        assert!(spans.iter().zip(&ends[1..]).all(|(s, end)| s.frames.end == *end) && ends[0] == 0, "no gaps");
    }
}

#[test]
fn raised_arms_are_a_gesture_and_not_neutral() {
    let mut waves = clip("bye", &[[0.0, 0.0]; 3], 0.0);
    for f in 60..120 {
        waves.rotations[f * NUM_JOINTS + Joint::RightUpperArm.index()] = Quat::from_rotation_z(-0.8);
    }
    let neutral: Vec<bool> = classes(&waves).iter().map(|s| s.class.neutral).collect();
    assert_eq!(neutral, [true, false, true]);
}

#[test]
fn bows_are_gestures_and_who_stands_bent_all_the_time_is_neutral() {
    // Bends for a second at the end, and for less than half a second before.
    let bends_named = |name: &str, deg: [f32; 3]| {
        let mut clip = clip(name, &[[0.0, 0.0]; 3], 0.0);
        for f in 0..180 {
            let deg = deg[if (130..160).contains(&f) { 2 } else { usize::from((80..92).contains(&f)) }];
            clip.rotations[f * NUM_JOINTS + Joint::Spine.index()] = Quat::from_rotation_x(deg.to_radians());
        }
        classes(&clip).iter().map(|s| s.class.neutral).collect::<Vec<_>>()
    };
    let bends = |deg: [f32; 3]| bends_named("a", deg);
    assert_eq!(bends_named("idle_03", [0.0, 28.0, 28.0]), [true]);
    assert_eq!(bends([0.0, 28.0, 28.0]), [true, false, true, false, true]);
    assert_eq!(bends([22.0, 22.0, 22.0]), [true]);
    assert_eq!(bends([15.0, 22.0, 8.0]), [true]);
}

#[test]
fn names_of_gestures_leave_less_standing_neutral() {
    let raised = |name| {
        let mut clip = clip(name, &[[0.0, 0.0]; 3], 0.0);
        for f in 60..120 {
            clip.rotations[f * NUM_JOINTS + Joint::RightUpperArm.index()] = Quat::from_rotation_z(0.95);
        }
        classes(&clip).iter().map(|s| s.class.neutral).collect::<Vec<_>>()
    };
    assert_eq!((raised("a"), raised("bye-bye_03")), (vec![true], vec![true, false, true]));
}

#[test]
fn names_give_the_manner_and_tip_the_balance() {
    assert_eq!(classes(&clip("walk_sad", &[[0.0, 1.0]; 2], 0.0))[0].class.manner, "sad");
    let sways = [[0.0, 0.5]; 2];
    assert_eq!(classes(&clip("idle_03", &sways, 0.0))[0].class.gait, Gait::Stand);
    assert_eq!(classes(&clip("03", &sways, 0.0))[0].class.gait, Gait::Walk);
    assert_eq!(classes(&clip("sneak", &sways, 0.0))[0].class.gait, Gait::Sneak);
    let stays = |name| classes(&clip(name, &[[0.0, 0.0]; 2], 0.0))[0].class.neutral;
    assert_eq!(["03", "walk_idle", "walk"].map(stays), [true, true, false]);
}

#[test]
fn parts_of_a_class_that_people_name_hold_for_the_whole_clip_and_the_rest_is_found() {
    let clip = clip("walk_sad", &[[0.0, 0.0], [0.0, 1.2], [0.0, 0.0]], 0.0);
    let named = |named: NamedClass| {
        let spans = classify(&clip, &Skeleton::default(), &NameHints { named, ..NameHints::new(&clip.name, "") });
        spans.into_iter().map(|s| s.class.to_string()).collect::<Vec<_>>()
    };
    let none = NamedClass::default();
    assert_eq!(named(none.clone()), ["neutral stand, sad", "walk, sad", "neutral stand, sad"]);
    assert_eq!(named(NamedClass { gait: Some(Gait::Backwards), ..none.clone() }), ["backwards, sad"]);
    let crouched = NamedClass { posture: Some(Posture::Crouched), manner: Some("shy".into()), ..none.clone() };
    assert_eq!(named(crouched), ["crouched stand, shy", "crouched sneak, shy", "crouched stand, shy"]);
    let gestures = NamedClass { neutral: Some(false), ..none.clone() };
    assert_eq!(named(gestures), ["stand, sad", "walk, sad", "stand, sad"]);
    let load = NamedClass { carrying: Some(true), manner: Some(String::new()), ..none };
    assert_eq!(named(load), ["stand carrying", "walk carrying", "stand carrying"]);
}

#[test]
fn a_clip_of_one_frame_has_one_span() {
    let mut one = clip("a", &[[0.0, 0.0]], 0.0);
    one.root_positions.truncate(1);
    one.rotations.truncate(NUM_JOINTS);
    assert_eq!(classes(&one).len(), 1);
}

#[test]
fn short_runs_become_part_of_their_longer_neighbours() {
    let settled = |text: &str, least| {
        let mut values: Vec<char> = text.chars().collect();
        absorb_short_runs(&mut values, least);
        values.into_iter().collect::<String>()
    };
    assert_eq!(settled("aaaabaaacccc", 2), "aaaaaaaacccc");
    assert_eq!(settled("aaabbcccc", 3), "aaacccccc");
    assert_eq!(settled("ab", 3), "bb");
    assert_eq!((settled("a", 3), settled("", 3)), ("a".into(), String::new()));
}
