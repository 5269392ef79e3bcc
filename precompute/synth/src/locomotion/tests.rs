//! What the whole set promises, measured on the finished clips.

use super::*;
use crate::SynthSet;
use crate::checks::*;
use glam::{Vec2, Vec3};
use std::sync::LazyLock;
use throng_core::planar::{twist_about_y, wrap_angle};
use throng_core::{Contacts, Joint, NUM_JOINTS};
use throng_motion::annotate::{AnnotateConfig, Sidecars, annotate};
use throng_motion::clip::runs_where;

/// At a rate at which the contacts of runners, of a fifth of a second, are well seen.
static SET: LazyLock<ClipSet> =
    LazyLock::new(|| locomotion(&SynthConfig { rate_hz: 60.0, ..SynthConfig::for_set(SynthSet::Locomotion) }));
/// The same with contacts as a build finds them.
static FOUND: LazyLock<ClipSet> =
    LazyLock::new(|| annotate(&SET, &AnnotateConfig::default(), &Sidecars::default()).unwrap());

/// Acts and their clips.
fn acts(set: &ClipSet) -> impl Iterator<Item = (LocomotionAct, &Clip)> {
    LocomotionAct::all().into_iter().zip(&set.clips)
}

/// Times at which a foot touches the ground with any part, first and last frames alike (frames).
fn stays(clip: &Clip, foot: usize) -> Vec<std::ops::Range<usize>> {
    let any = Contacts(FEET[foot].3.0 | FEET[foot].4.0);
    runs_where(0..clip.num_frames(), |f| clip.contacts[f].any(any))
}

#[test]
fn the_set_is_the_repertoire_once() {
    assert_eq!(LocomotionAct::all().len(), NUM_ACTS);
    assert_eq!(SET.clips.len(), NUM_ACTS);
    for (act, clip) in acts(&SET) {
        assert_eq!(clip.name, act.name(0));
        assert_eq!(clip.num_frames(), 241);
        let tags: Vec<_> = clip.tags.iter().map(|t| (t.name.as_str(), t.range.clone())).collect();
        assert_eq!(tags, [(act.gait.name(), 0..241), (act.manner.name, 0..241)]);
    }
}

#[test]
fn more_minutes_are_further_takes_and_fewer_the_first_acts() {
    let few = locomotion(&SynthConfig { minutes: 0.2, clip_seconds: 4.0, ..SynthConfig::default() });
    assert_eq!(
        few.clips.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
        ["walk_neutral_v070_g00", "walk_neutral_v070_gl04", "walk_neutral_v070_gr04"]
    );
    let take = clip(&LocomotionAct::all()[0], NUM_ACTS, 1, &SynthConfig::for_set(SynthSet::Locomotion), &few.skeleton);
    assert_eq!(take.name, "walk_neutral_v070_g00_t2");
    assert_ne!(take.rotations, few.clips[0].rotations);
}

#[test]
fn feet_stand_on_the_ground_knees_never_lock_and_nothing_pops() {
    assert_planted_feet_stand_still(&SET, 0.02);
    assert_soles_stay_above(&SET, -0.006);
    for (act, clip) in acts(&SET) {
        assert_knees_bend(clip, &(3.0..if act.gait.flies() { 130.0 } else { 103.0 }));
        assert_nothing_pops(clip, |j| match (j >= Joint::LeftThigh, act.gait.flies()) {
            (true, true) => 1600.0,
            (true, false) => 800.0,
            (false, true) => 110.0,
            (false, false) => 140.0,
        });
    }
}

/// Speed along the arc and turning rate over every window of one cycle.
fn fitted(act: &LocomotionAct, clip: &Clip) -> Vec<(f32, f32)> {
    let cycle = (2.0 * stride::Stride::for_act(act).period * clip.rate_hz).round() as usize;
    let seconds = cycle as f32 / clip.rate_hz as f32;
    let heading = |f: usize| twist_about_y(clip.frame_rotations(f)[0]);
    let ground = |f: usize| Vec2::new(clip.root_positions[f].x, clip.root_positions[f].z);
    let window = |f: usize| {
        let turned: f32 = (f..f + cycle).map(|f| wrap_angle(heading(f + 1) - heading(f))).sum();
        let (chord, half) = ((ground(f + cycle) - ground(f)).length(), 0.5 * turned);
        let arc = if half.abs() < 1e-4 { chord } else { chord * half / half.sin() };
        (arc / seconds, turned / seconds)
    };
    (0..clip.num_frames() - cycle).map(window).collect()
}

#[test]
fn speed_and_turning_are_what_was_asked() {
    for (act, clip) in acts(&SET).filter(|(a, _)| a.gait != GaitKind::Idle) {
        let windows = fitted(&act, clip);
        let n = windows.len() as f32;
        let speed = windows.iter().map(|w| w.0).sum::<f32>() / n;
        let gyration = windows.iter().map(|w| w.1).sum::<f32>() / n;
        let (asked, turning) = (act.drive.speed() as f32, act.drive.gyration as f32);
        assert!((gyration - turning).abs() < 0.01, "{}: {gyration} rad/s", clip.name);
        assert!((speed - asked).abs() < 0.03 * asked || asked == 0.0, "{}: {speed} m/s", clip.name);
    }
}

#[test]
fn speed_and_turning_are_steady_from_first_to_last() {
    for (act, clip) in acts(&SET).filter(|(a, _)| a.gait != GaitKind::Idle) {
        for (speed, gyration) in fitted(&act, clip) {
            // The body sways from side to side, which on a narrow arc is a little forward and back.
            assert!((speed - act.drive.speed() as f32).abs() < 0.12, "{}: {speed} m/s", clip.name);
            assert!((gyration - act.drive.gyration as f32).abs() < 0.025, "{}: {gyration} rad/s", clip.name);
        }
    }
}

fn assert_landings_alternate(set: &ClipSet) {
    for (act, clip) in acts(set).filter(|(a, _)| a.gait != GaitKind::Idle) {
        let mut landings: Vec<(usize, usize)> = (0..2)
            .flat_map(|foot| stays(clip, foot).into_iter().map(move |r| (r.start, foot)))
            .filter(|e| e.0 > 0)
            .collect();
        landings.sort_unstable();
        assert!(landings.windows(2).all(|w| w[0].1 != w[1].1), "{} at {} Hz: {landings:?}", clip.name, clip.rate_hz);
        let steps = clip.num_frames() as f64 / clip.rate_hz / stride::Stride::for_act(&act).period;
        assert!((landings.len() as f64 - steps).abs() < 1.6, "{}: {landings:?}, {steps} steps", clip.name);
    }
}

#[test]
fn every_step_is_found_as_one_contact_and_feet_alternate() {
    assert_landings_alternate(&FOUND);
    let slow = locomotion(&SynthConfig::for_set(SynthSet::Locomotion));
    assert_landings_alternate(&annotate(&slow, &AnnotateConfig::default(), &Sidecars::default()).unwrap());
}

#[test]
fn contacts_are_found_when_they_are() {
    for (act, clip) in acts(&FOUND).filter(|(a, _)| a.gait != GaitKind::Idle) {
        // Slow feet are seen to stand a little before and after they do.
        let stance = stride::Stride::for_act(&act).stance * clip.rate_hz;
        for foot in 0..2 {
            for stay in stays(clip, foot).iter().filter(|r| r.start > 0 && r.end < clip.num_frames()) {
                let late = stance - stay.len() as f64;
                assert!((-8.0..5.0).contains(&late), "{}: {stay:?}, stance of {stance} frames", clip.name);
            }
        }
    }
}

#[test]
fn runners_fly_and_walkers_do_not() {
    for (act, clip) in acts(&FOUND) {
        let up = clip.contacts.iter().filter(|c| **c == Contacts::NONE).count() as f32 / clip.num_frames() as f32;
        let wanted = match act.gait {
            GaitKind::Run => 0.2..0.62,
            GaitKind::Jog => 0.04..0.5,
            _ => 0.0..0.12,
        };
        assert!(wanted.contains(&up), "{}: {up} of the time in the air", clip.name);
    }
}

#[test]
fn bodies_in_the_air_fall_freely() {
    for (_, clip) in acts(&SET).filter(|(a, _)| a.gait == GaitKind::Run) {
        let mut falling = 0;
        for f in 2..clip.num_frames() - 2 {
            if clip.contacts[f - 2..f + 3].iter().all(|c| *c == Contacts::NONE) {
                let y = |f: usize| clip.root_positions[f].y * 3600.0;
                let acceleration = y(f - 1) - 2.0 * y(f) + y(f + 1);
                // The heel rocker counts as no contact yet.
                falling += usize::from((acceleration + 9.81).abs() < 1.0);
            }
        }
        assert!(falling >= 8, "{}: {falling} frames", clip.name);
    }
}

#[test]
fn standing_keeps_both_feet_down_and_returns_to_its_place() {
    for (act, clip) in acts(&FOUND).filter(|(a, _)| a.gait == GaitKind::Idle) {
        assert!(clip.contacts.iter().all(|c| c.all(Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0))), "{}", clip.name);
        let (first, last) = (clip.frame_rotations(0), clip.frame_rotations(clip.num_frames() - 1));
        for (j, (a, b)) in first.iter().zip(last).enumerate() {
            assert!(a.angle_between(*b) < 0.004, "{} {}", act.name(0), Joint::ALL[j].name());
        }
        let moved =
            (1..clip.num_frames()).map(|f| first[1].angle_between(clip.frame_rotations(f)[1])).fold(0.0, f32::max);
        assert!(moved > 0.002);
    }
}

#[test]
fn manners_are_told_apart_by_posture_and_timing() {
    let clip = |manner: &str| SET.clips.iter().find(|c| c.name == format!("walk_{manner}_v110_g00")).unwrap();
    let mean = |manner: &str, of: &dyn Fn(&[Vec3; NUM_JOINTS]) -> f32| {
        let clip = clip(manner);
        (0..clip.num_frames()).map(|f| of(&clip.joint_positions(&SET.skeleton, f))).sum::<f32>()
            / clip.num_frames() as f32
    };
    let head = |p: &[Vec3; NUM_JOINTS]| p[Joint::Head.index()].y;
    assert!(mean("proud", &head) > mean("neutral", &head) && mean("neutral", &head) > mean("tired", &head) + 0.06);
    let reach = |manner: &str| {
        let clip = clip(manner);
        let apart = |f: usize| {
            let p = clip.joint_positions(&SET.skeleton, f);
            (p[Joint::LeftHand.index()].z - p[Joint::RightHand.index()].z).abs()
        };
        (0..clip.num_frames()).map(apart).fold(0.0, f32::max)
    };
    assert!(reach("proud") > reach("neutral") + 0.03 && reach("neutral") > reach("tired") + 0.05);
}
