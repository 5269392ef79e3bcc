//! Hand-made blows: where they are found, what changes nothing, what is none.

use super::*;
use crate::annotate::sidecar::SidecarPlace;
use crate::annotate::{AnnotateConfig, EndsConfig, Sidecars, annotate};
use crate::clip::ClipSet;
use crate::mirror::mirror_clip;
use crate::resample::{ResampleConfig, resample};
use glam::{Quat, Vec3};
use proptest::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use throng_core::{NUM_JOINTS, Planar};

/// Times at which the punches of [`boxer`] start; not on frames (s).
const STARTS: [f32; 3] = [0.513, 1.327, 2.241];
/// Time from guard to a straight arm (s).
const OUT: f32 = 0.16;
/// Time back to guard (s).
const BACK: f32 = 0.35;
/// Distance from shoulder to wrist in guard and with a straight arm (m).
const REACH: [f32; 2] = [0.2, 0.535];

/// 0 in guard, 1 where the arm is straight.
fn outwards(t: f32) -> f32 {
    let ease = |u: f32| 0.5 - 0.5 * (PI * u.clamp(0.0, 1.0)).cos();
    STARTS.iter().map(|s| if t < s + OUT { ease((t - s) / OUT) } else { ease((s + OUT + BACK - t) / BACK) }).sum()
}

/// A clip of 3 s; `local` gives rotations by time, `way` adds to where the hips are.
fn clip(rate_hz: f64, path: impl Fn(f32) -> Vec3, local: impl Fn(f32, &mut [Quat])) -> Clip {
    let num = (3.0 * rate_hz) as usize;
    let (mut root_positions, mut rotations) = (Vec::new(), vec![Quat::IDENTITY; num * NUM_JOINTS]);
    for (frame, pose) in rotations.chunks_mut(NUM_JOINTS).enumerate() {
        let t = (frame as f64 / rate_hz) as f32;
        root_positions.push(Skeleton::default().offsets[0] + path(t));
        local(t, pose);
    }
    Clip { contacts: vec![Contacts::NONE; num], ..Clip::new("boxer", rate_hz, root_positions, rotations) }
}

/// Turns the right arm so that the wrist is straight ahead of the shoulder, the elbow out to the right.
fn reach_ahead(pose: &mut [Quat], distance: f32) {
    reach_at(pose, distance, 0.0);
}

/// As [`reach_ahead`], with the wrist above level by an angle (rad).
fn reach_at(pose: &mut [Quat], distance: f32, above: f32) {
    let s = Skeleton::default();
    let [upper, fore] = [Joint::RightForearm, Joint::RightHand].map(|j| s.offsets[j.index()].length());
    let along = (upper * upper + distance * distance - fore * fore) / (2.0 * distance);
    let up = Quat::from_rotation_x(-above);
    let elbow = up * Vec3::new(-(upper * upper - along * along).max(0.0).sqrt(), 0.0, along);
    let towards = |v: Vec3| Quat::from_rotation_arc(-Vec3::X, v.normalize());
    let shoulder = towards(elbow);
    pose[Joint::RightUpperArm.index()] = shoulder;
    pose[Joint::RightForearm.index()] = shoulder.inverse() * towards(up * Vec3::Z * distance - elbow);
}

/// Throws three straight punches with the right hand while the hips go their way.
fn boxer(rate_hz: f64, path: impl Fn(f32) -> Vec3) -> Clip {
    clip(rate_hz, path, |t, pose| reach_ahead(pose, REACH[0] + (REACH[1] - REACH[0]) * outwards(t)))
}

/// Lifts the bent right arm by an angle: elbow at a right angle, the fist scoops upwards (rad).
fn uppercutter(angle: f32) -> Clip {
    let lift = |t: f32| angle * (0.5 - 0.5 * (PI * ((t - 1.0) / 0.25).clamp(0.0, 1.0)).cos());
    clip(
        30.0,
        |_| Vec3::ZERO,
        |t, pose| {
            // The upper arm from hanging down to straight ahead, the forearm from straight ahead to straight up.
            let down = Quat::from_rotation_z(FRAC_PI_2);
            pose[Joint::RightUpperArm.index()] = Quat::from_rotation_x(-lift(t)) * down;
            pose[Joint::RightForearm.index()] = down.inverse() * Quat::from_rotation_x(-FRAC_PI_2) * down;
        },
    )
}

/// 0 before `start`, 1 after a time.
fn ease(t: f32, start: f32, time: f32) -> f32 {
    0.5 - 0.5 * (PI * ((t - start) / time).clamp(0.0, 1.0)).cos()
}

/// Kicks ahead with the left leg: the knee comes up bent, then the shin snaps straight.
fn kicker() -> Clip {
    kicker_with(|_, _| ())
}

fn kicker_with(arms: impl Fn(f32, &mut [Quat])) -> Clip {
    clip(
        30.0,
        |_| Vec3::ZERO,
        |t, pose| {
            arms(t, pose);
            let raised = ease(t, 1.0, 0.3) - ease(t, 2.0, 0.6);
            let bent = raised - ease(t, 1.25, 0.15) + ease(t, 1.6, 0.4);
            pose[Joint::LeftThigh.index()] = Quat::from_rotation_x(-1.5 * raised);
            pose[Joint::LeftShin.index()] = Quat::from_rotation_x(1.6 * bent.clamp(0.0, 1.0));
        },
    )
}

fn hits(clip: &Clip, cfg: &HitConfig) -> Vec<ClipHit> {
    find_hits(clip, &Skeleton::default(), cfg, &[], true).expect("nothing is marked")
}

fn frames(hits: &[ClipHit]) -> Vec<usize> {
    hits.iter().map(|h| h.frame).collect()
}

fn moved(clip: &Clip, by: Planar) -> Clip {
    let mut out = clip.clone();
    for (frame, p) in out.root_positions.iter_mut().enumerate() {
        *p = by.rotation() * *p + by.translation();
        let hips = &mut out.rotations[frame * NUM_JOINTS];
        *hips = by.rotation() * *hips;
    }
    out
}

#[test]
fn straight_punches_land_between_their_fastest_moment_and_the_straight_arm() {
    let found = hits(&boxer(30.0, |_| Vec3::ZERO), &HitConfig::default());
    assert_eq!(found.len(), STARTS.len(), "{found:?}");
    for (h, start) in found.iter().zip(STARTS) {
        let t = h.frame as f32 / 30.0;
        assert!((start + 0.4 * OUT..start + OUT).contains(&t), "{start}: {t}");
        assert_eq!((&h.kind, h.joint), (&HitKind::Punch, Joint::RightHand));
        assert!(h.direction.z > 0.9 && h.position.z > 0.4 && h.position.x < 0.0, "{h:?}");
        // The wrist alone is at its fastest 3.3 m/s; the tip of the fist swings about it.
        assert!((2.3..5.0).contains(&h.speed_mps), "{h:?}");
    }
}

#[test]
fn the_same_blows_are_found_at_any_rate() {
    let times = |clip: &Clip| -> Vec<f64> {
        hits(clip, &HitConfig::default()).iter().map(|h| h.frame as f64 / clip.rate_hz).collect()
    };
    let at_30 = times(&boxer(30.0, |_| Vec3::ZERO));
    for rate in [50.0, 60.0, 120.0] {
        let clip = boxer(rate, |_| Vec3::ZERO);
        let set = ClipSet { skeleton: Skeleton::default(), clips: vec![clip.clone()] };
        let resampled = resample(&set, &ResampleConfig { rate_hz: 30.0, mirror: false }).unwrap();
        for other in [times(&clip), times(&resampled.clips[0])] {
            assert_eq!(other.len(), at_30.len(), "{rate} Hz: {other:?}");
            let apart = at_30.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1.5 / 30.0, "{rate} Hz: {at_30:?} {other:?}");
        }
    }
}

proptest! {
    #[test]
    fn where_a_clip_lies_changes_nothing(x in -50.0f32..50.0, z in -50.0f32..50.0, heading in -PI..PI) {
        let (clip, cfg) = (boxer(30.0, |t| Vec3::Z * 0.3 * (TAU * t).sin()), HitConfig::default());
        let (here, there) = (hits(&clip, &cfg), hits(&moved(&clip, Planar::new(x, z, heading)), &cfg));
        prop_assert_eq!(frames(&here), frames(&there));
        for (a, b) in here.iter().zip(&there) {
            prop_assert!(a.position.distance(b.position) < 1e-3 && a.direction.distance(b.direction) < 1e-2);
        }
    }
}

#[test]
fn mirrored_clips_have_mirrored_hits() {
    let (clip, cfg) = (boxer(30.0, |_| Vec3::ZERO), HitConfig::default());
    let (here, there) = (hits(&clip, &cfg), hits(&mirror_clip(&clip), &cfg));
    for (h, m) in here.iter().zip(&there) {
        let image = crate::mirror::mirror_hit(h);
        assert_eq!((image.frame, image.joint), (m.frame, Joint::LeftHand));
        assert!(image.position.distance(m.position) < 1e-4 && image.direction.distance(m.direction) < 1e-3);
    }
    let set = ClipSet { skeleton: Skeleton::default(), clips: vec![clip.clone(), mirror_clip(&clip)] };
    // The left arm is stretched out all the time, as in a T-pose.
    let ends = EndsConfig { t_pose: false, still: false, ..EndsConfig::default() };
    let set = annotate(&set, &AnnotateConfig { ends, ..AnnotateConfig::default() }, &Sidecars::default()).unwrap();
    assert_eq!(set.clips[1].hits, set.clips[0].hits.iter().map(crate::mirror::mirror_hit).collect::<Vec<_>>());
    assert_eq!(set.clips[0].hits.len(), 3);
}

#[test]
fn steps_of_the_hips_decide_nothing_but_blows_that_go_backwards_are_none() {
    let cfg = HitConfig::default();
    let standing = frames(&hits(&boxer(30.0, |_| Vec3::ZERO), &cfg));
    for speed in [-1.0, 1.0, 4.0] {
        let found = hits(&boxer(30.0, |t| Vec3::Z * speed * t), &cfg);
        assert_eq!(frames(&found), standing, "{speed} m/s");
    }
    assert!(hits(&boxer(30.0, |t| Vec3::NEG_Z * 8.0 * t), &cfg).is_empty());
    let carried = clip(30.0, |t| Vec3::Z * (4.0 * t + 0.2 * (9.0 * t).sin()), |_, pose| reach_ahead(pose, 0.4));
    assert!(hits(&carried, &cfg).is_empty(), "fists that are carried along do not strike");
}

#[test]
fn thresholds_are_respected() {
    let clip = boxer(30.0, |_| Vec3::ZERO);
    let with = |change: fn(&mut HitConfig)| {
        let mut cfg = HitConfig::default();
        change(&mut cfg);
        hits(&clip, &cfg).len()
    };
    assert_eq!(with(|_| ()), 3);
    assert_eq!(with(|c| c.enabled = false), 0);
    assert_eq!(with(|c| c.punches.enabled = false), 0);
    assert_eq!(with(|c| c.punches.thrust_speed = 5.0), 0);
    assert_eq!(with(|c| c.punches.extension = 0.7), 0);
    assert_eq!(with(|c| c.punches.extension = 0.5), 3);
    assert_eq!(with(|c| c.punches.min_gap = 0.87), 2);
}

#[test]
fn arms_that_reach_up_or_down_or_stay_out_do_not_strike() {
    let out = |above: f32, back: f32| {
        let still = |_| Vec3::ZERO;
        clip(30.0, still, move |t, pose| {
            let share = ease(t, 1.0, OUT) - back * ease(t, 1.0 + OUT, BACK);
            reach_at(pose, REACH[0] + (REACH[1] - REACH[0]) * share, above.to_radians());
        })
    };
    let count = |clip: &Clip| hits(clip, &HitConfig::default()).len();
    assert_eq!([0.0, 40.0, -40.0, 70.0, -70.0].map(|above| count(&out(above, 1.0))), [1, 1, 1, 0, 0]);
    let mut cfg = HitConfig::default();
    cfg.punches.elevation_deg = 80.0;
    assert_eq!(hits(&out(70.0, 1.0), &cfg).len(), 1);
    // A hand that is offered.
    assert_eq!([1.0, 0.5, 0.1, 0.0].map(|back| count(&out(0.0, back))), [1, 1, 0, 0]);
    cfg.punches.retreat = 0.0;
    assert_eq!(hits(&out(0.0, 0.0), &cfg).len(), 1);
    // What comes after the clip is not known.
    let mut cut = out(0.0, 0.0);
    cut.excluded = vec![crate::clip::Exclusion { range: 45..90, reason: crate::clip::ExclusionReason::Sidecar }];
    assert_eq!(count(&cut), 1);
}

#[test]
fn blows_of_a_flurry_count_one_by_one() {
    let flurry = clip(
        60.0,
        |_| Vec3::ZERO,
        |t, pose| {
            let share = if (1.0..2.0).contains(&t) { 0.5 - 0.5 * (TAU * 5.0 * t).cos() } else { 0.0 };
            reach_ahead(pose, REACH[0] + (REACH[1] - REACH[0]) * share);
        },
    );
    let found = hits(&flurry, &HitConfig::default());
    assert_eq!(found.len(), 5, "five blows, 0.2 s apart: {found:?}");
}

#[test]
fn arms_that_balance_a_kick_do_not_strike() {
    let swings = |start: f32| {
        let arm = move |t: f32| ease(t, start, OUT) - ease(t, start + OUT, BACK);
        kicker_with(move |t, pose| reach_ahead(pose, REACH[0] + (REACH[1] - REACH[0]) * arm(t)))
    };
    let kinds = |clip: &Clip, cfg: &HitConfig| hits(clip, cfg).iter().map(|h| h.kind.clone()).collect::<Vec<_>>();
    let mut cfg = HitConfig::default();
    assert_eq!(kinds(&swings(1.3), &cfg), [HitKind::Kick]);
    assert_eq!(kinds(&swings(0.4), &cfg), [HitKind::Punch, HitKind::Kick]);
    cfg.punches.raised_foot = 2.0;
    assert_eq!(kinds(&swings(1.3), &cfg).len(), 2);
}

#[test]
fn bent_arms_strike_where_swings_count() {
    let clip = uppercutter(FRAC_PI_2);
    assert!(hits(&clip, &HitConfig::default()).is_empty());
    let swings = |clip: &Clip, speed: f32, drop: f32| {
        let mut cfg = HitConfig::default();
        (cfg.punches.swing_speed, cfg.punches.swing_drop) = (Some(speed), drop);
        hits(clip, &cfg)
    };
    let found = swings(&clip, 2.0, 0.25);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((1.1..1.25).contains(&(found[0].frame as f32 / 30.0)) && found[0].direction.y > 0.5, "{found:?}");
    assert!(swings(&clip, 4.5, 0.25).is_empty());
    let low = uppercutter(0.6);
    assert_eq!(swings(&low, 1.2, 0.25).len(), 1);
    assert!(swings(&low, 1.2, 0.0).is_empty(), "the fist lands below the shoulder");
}

#[test]
fn kicks_need_a_foot_high_above_the_other_that_does_not_stand() {
    let mut clip = kicker();
    let found = hits(&clip, &HitConfig::default());
    assert_eq!(found.len(), 1, "{found:?}");
    let h = &found[0];
    assert_eq!((&h.kind, h.joint), (&HitKind::Kick, Joint::LeftFoot));
    assert!((1.3..1.42).contains(&(h.frame as f32 / 30.0)) && h.position.z > 0.5 && h.position.y > 0.6, "{h:?}");
    let mut cfg = HitConfig::default();
    cfg.kicks.height = 1.0;
    assert!(hits(&clip, &cfg).is_empty());
    // Not on the way down: the knee is straight at 1.4 s, and the leg sinks from 2 s on.
    let leg = |f: usize| {
        let p = clip.joint_positions(&Skeleton::default(), f);
        p[Joint::LeftFoot.index()].distance(p[Joint::LeftThigh.index()])
    };
    assert!(leg(h.frame) > leg(h.frame - 1) && leg(h.frame) > 0.9 * leg(42));
    clip.contacts[h.frame] = Contacts::LEFT_TOE;
    assert!(hits(&clip, &HitConfig::default()).is_empty());
}

#[test]
fn frames_that_are_left_out_have_no_hits() {
    let mut clip = boxer(30.0, |_| Vec3::ZERO);
    let all = frames(&hits(&clip, &HitConfig::default()));
    clip.excluded = vec![crate::clip::Exclusion { range: 30..60, reason: crate::clip::ExclusionReason::Sidecar }];
    assert!((30..60).contains(&all[1]));
    assert_eq!(frames(&hits(&clip, &HitConfig::default())), [all[0], all[2]]);
}

#[test]
fn forces_are_shares_of_the_fastest_of_their_kind() {
    let hit = |kind: HitKind, speed_mps: f32| ClipHit {
        frame: 0,
        kind,
        joint: Joint::Head,
        position: Vec3::ZERO,
        direction: Vec3::Z,
        speed_mps,
        force: 1.0,
    };
    let mut clips = [boxer(30.0, |_| Vec3::ZERO), kicker()];
    clips[0].hits = vec![hit(HitKind::Punch, 2.0), hit(HitKind::Kick, 5.0)];
    clips[1].hits = vec![hit(HitKind::Punch, 4.0), hit(HitKind::Tag("butt".into()), 1.0)];
    set_forces(&mut clips);
    let forces = clips.each_ref().map(|c| c.hits.iter().map(|h| h.force).collect::<Vec<_>>());
    assert_eq!(forces, [vec![0.5, 1.0], vec![1.0, 1.0]]);
}

#[test]
fn marks_are_taken_as_they_are_and_replace_what_is_found_nearby() {
    let clip = boxer(30.0, |_| Vec3::ZERO);
    let found = hits(&clip, &HitConfig::default());
    let mark = |kind: HitKind, joint: Joint, range: FrameRange| HitMark {
        kind,
        joint,
        range,
        place: SidecarPlace { file: None, key: "hits[0]".into() },
    };
    let with = |marks: &[HitMark], automatic: bool| {
        find_hits(&clip, &Skeleton::default(), &HitConfig::default(), marks, automatic).map_err(|e| e.to_string())
    };
    let jab = mark(HitKind::Tag("jab".into()), Joint::RightHand, found[0].frame - 5..found[0].frame + 5);
    let marked = with(std::slice::from_ref(&jab), true).unwrap();
    assert_eq!(marked.len(), 3);
    assert_eq!((marked[0].kind.name(), &marked[1..]), ("jab", &found[1..]));
    assert!(marked[0].speed_mps >= found[0].speed_mps, "the fastest moment of the range");
    assert_eq!(with(std::slice::from_ref(&jab), false).unwrap().len(), 1);
    assert!(with(&[], false).unwrap().is_empty());

    let e = with(&[mark(HitKind::Punch, Joint::LeftHand, 40..41)], true).unwrap_err();
    assert!(e.contains("hits[0]: left_hand of clip `boxer` moves at 0.000 m/s"), "{e}");
    let mut cut = clip.clone();
    cut.excluded = vec![crate::clip::Exclusion { range: 0..30, reason: crate::clip::ExclusionReason::TPose }];
    let e = find_hits(&cut, &Skeleton::default(), &HitConfig::default(), &[jab], true).unwrap_err().to_string();
    assert!(e.contains("hits[0]: ") && e.contains("left out"), "{e}");
}

#[test]
fn what_points_straight_up_has_an_elevation() {
    assert!((1..1000).all(|y| (elevation(Vec3::Y * y as f32 * 0.37) - FRAC_PI_2).abs() < 1e-3));
}
