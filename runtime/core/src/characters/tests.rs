//! Steps against a plain reference, one joint after the other, on made-up tables.

use super::made_up::FRAMES;
pub(crate) use super::made_up::{curve, standing_tables, tables, tables_with};
use super::*;
use crate::bundle::Bundle;
use crate::format::AlignedBytes;
use crate::hits::HitRecord;
use glam::Quat;

pub(crate) mod blows;
mod idle;
mod reactions;
mod replay;

pub(crate) fn starts(n: usize) -> Vec<CharacterStart> {
    (0..n).map(|i| CharacterStart { root: Planar::new(i as f32, -2.0, 0.5 * i as f32), state: i as u32 % 4 }).collect()
}

pub(crate) fn orders(n: usize) -> Vec<PolicyOrder> {
    (0..n).map(|i| PolicyOrder::towards(0, Vec3::new(3.0 - i as f32, 0.0, 1.0 + 0.3 * i as f32))).collect()
}

/// Two threads that take parts from both ends.
pub(crate) struct TwoThreads;

impl Executor for TwoThreads {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        std::thread::scope(|scope| {
            scope.spawn(|| (num_parts / 3..num_parts).rev().for_each(part));
            (0..num_parts / 3).rev().for_each(part);
        });
    }
}

/// World positions of all joints, straight from the rows.
fn reference(r: &MotionSet, characters: &Characters, c: usize) -> [Vec3; NUM_JOINTS] {
    let (segment, time) = characters.segment(c);
    let frame = r.graph.segments[segment as usize].start as usize + time as usize;
    let root = characters.root(c);
    model(r, frame, time.fract()).map(|p| root.translation() + root.rotation() * p)
}

/// Model-space positions of all joints between a row and the next, joint after joint.
fn model(r: &MotionSet, from: usize, ratio: f32) -> [Vec3; NUM_JOINTS] {
    let mut out = [(Vec3::ZERO, Quat::IDENTITY); NUM_JOINTS];
    for j in Joint::ALL {
        // No joint of these clips turns far, so w follows from x, y and z.
        let of = |k: usize| curve(r, from, ratio, |row| r.rotation_code.rotation(row, j.index()).to_array()[k]);
        let v = Vec3::new(of(0), of(1), of(2));
        let q = Quat::from_xyzw(v.x, v.y, v.z, (1.0 - v.length_squared()).sqrt());
        out[j.index()] = match j.parent() {
            None => (Vec3::Y * curve(r, from, ratio, |row| row.height), q),
            Some(p) => {
                let (position, rotation) = out[p.index()];
                (position + rotation * r.skeleton.offsets[j.index()], rotation * q)
            }
        };
    }
    out.map(|t| t.0)
}

pub(crate) fn plain() -> CharactersConfig {
    let foot_lock = FootLockConfig { enabled: false, ..FootLockConfig::default() };
    CharactersConfig { foot_lock, ..CharactersConfig::default() }
}

/// The motion of a bundle, so many characters, and orders for them.
fn moving(bundle: &Bundle, n: usize) -> (MotionSet, Characters, Vec<PolicyOrder>) {
    let r = MotionSet::new(bundle);
    let characters = Characters::new(&r, plain(), &starts(n)).unwrap();
    (r, characters, orders(n))
}

#[test]
fn poses_are_those_of_the_rows_once_a_transition_has_settled() {
    let r = MotionSet::new(&tables());
    let config = CharactersConfig { half_life_s: 0.005, ..plain() };
    let mut characters = Characters::new(&r, config, &starts(7)).unwrap();
    let orders = orders(7);
    for _ in 0..14 {
        characters.step(&r, 1.0 / 25.0, &orders).unwrap();
    }
    for c in 0..7 {
        assert!(characters.segment(c).1 > 2.0, "the transition has settled");
        for (got, want) in characters.joint_positions(c).iter().zip(reference(&r, &characters, c)) {
            assert!((*got - want).length() < 1e-4, "{got} {want}");
        }
    }
}

#[test]
fn sampled_frames_are_those_of_the_rows() {
    let r = MotionSet::new(&tables());
    let (frames, ratios) = ([0, 33, 119, 60, 7], [0.0, 0.25, 0.0, 1.0, 0.5]);
    let mut matrices = vec![Mat3x4::default(); 5 * NUM_JOINTS];
    SampleJob { motion_set: &r, frames: &frames, ratios: &ratios, matrices: &mut matrices }.run().unwrap();
    for (i, (&f, &ratio)) in frames.iter().zip(&ratios).enumerate() {
        let want = model(&r, f as usize, ratio);
        for (got, want) in matrices[i * NUM_JOINTS..].iter().zip(want) {
            assert!((got.translation() - want).length() < 1e-5);
        }
    }
    let job = SampleJob { motion_set: &r, frames: &[120], ratios: &[0.0], matrices: &mut matrices[..NUM_JOINTS] };
    assert!(matches!(job.run(), Err(Error::Index { .. })));
}

#[test]
fn nothing_jumps_where_segments_change() {
    let (r, mut characters, orders) = moving(&tables(), 9);
    characters.step(&r, 0.0, &orders).unwrap();
    let dt = 1.0 / 240.0;
    let mut before: Vec<_> = (0..9).map(|c| characters.joint_positions(c)).collect();
    let mut changes = 0;
    for _ in 0..480 {
        let old: Vec<_> = (0..9).map(|c| characters.segment(c).0).collect();
        characters.step(&r, dt, &orders).unwrap();
        for c in 0..9 {
            changes += usize::from(characters.segment(c).0 != old[c]);
            let now = characters.joint_positions(c);
            for (a, b) in now.iter().zip(&before[c]) {
                assert!((*a - *b).length() < 6.0 * dt, "faster than 6 m/s");
            }
            before[c] = now;
        }
    }
    assert!(changes > 20, "{changes}");
}

#[test]
fn roots_are_continuous_and_follow_the_segments() {
    let (r, mut characters, orders) = moving(&tables(), 4);
    characters.step(&r, 0.0, &orders).unwrap();
    let mut at: Vec<Planar> = (0..4).map(|c| characters.root(c)).collect();
    for (c, s) in starts(4).iter().enumerate() {
        assert!((at[c].x - s.root.x).abs() < 1e-5 && (at[c].z - s.root.z).abs() < 1e-5);
    }
    for _ in 0..5 {
        let segments: Vec<_> = (0..4).map(|c| characters.segment(c).0).collect();
        for _ in 0..20 {
            characters.step(&r, 1.0 / 30.0, &orders).unwrap();
        }
        for c in 0..4 {
            at[c] = at[c].compose(r.graph.segments[segments[c] as usize].displacement());
            let got = characters.root(c);
            assert!((got.x - at[c].x).abs() < 1e-3 && (got.z - at[c].z).abs() < 1e-3, "{got:?} {:?}", at[c]);
        }
    }
}

#[test]
fn planted_feet_stay_where_they_are() {
    let r = MotionSet::new(&tables());
    let foot_lock = FootLockConfig::default();
    let mut characters =
        Characters::new(&r, CharactersConfig { foot_lock, ..CharactersConfig::default() }, &starts(5)).unwrap();
    let orders = orders(5);
    for _ in 0..2 {
        characters.step(&r, 1.0 / 60.0, &orders).unwrap();
    }
    let feet = |t: &Characters, c| {
        let p = t.joint_positions(c);
        (p[Joint::LeftFoot.index()] + p[Joint::LeftToe.index()]) * 0.5
    };
    let before: Vec<_> = (0..5).map(|c| feet(&characters, c)).collect();
    for _ in 0..6 {
        characters.step(&r, 1.0 / 60.0, &orders).unwrap();
    }
    for (c, b) in before.iter().enumerate() {
        let moved = feet(&characters, c) - *b;
        assert!(moved.x.hypot(moved.z) < 0.01, "{moved}");
    }
}

#[test]
fn legs_keep_their_lengths_and_locals_rebuild_the_pose() {
    let r = MotionSet::new(&tables());
    let config = CharactersConfig { local_transforms: true, ..CharactersConfig::default() };
    let mut characters = Characters::new(&r, config, &starts(6)).unwrap();
    let orders = orders(6);
    for _ in 0..50 {
        characters.step(&r, 1.0 / 60.0, &orders).unwrap();
        for c in 0..6 {
            let (pose, locals) = (characters.pose(c), &characters.local_transforms()[c * NUM_JOINTS..][..NUM_JOINTS]);
            let mut built = [(Vec3::ZERO, Quat::IDENTITY); NUM_JOINTS];
            for j in Joint::ALL {
                let (p, q) = j.parent().map_or((Vec3::ZERO, Quat::IDENTITY), |p| built[p.index()]);
                let l = locals[j.index()];
                built[j.index()] = (p + q * Vec3::from_array(l.translation), q * Quat::from_array(l.rotation));
                let shown = pose[j.index()].translation();
                assert!((built[j.index()].0 - shown).length() < 2e-3, "{j:?} {} {shown}", built[j.index()].0);
                if let Some(parent) = j.parent() {
                    let length = (shown - pose[parent.index()].translation()).length();
                    assert!((length - r.skeleton.offsets[j.index()].length()).abs() < 2e-3, "{j:?}");
                }
            }
        }
    }
}

#[test]
fn refuses_what_does_not_fit() {
    let r = MotionSet::new(&tables());
    let bad_state = [CharacterStart { root: Planar::IDENTITY, state: 4 }];
    assert!(matches!(Characters::new(&r, plain(), &bad_state), Err(Error::Index { .. })));
    let mut characters = Characters::new(&r, plain(), &starts(2)).unwrap();
    let orders = orders(2);
    for few in [&orders[..1], &[]] {
        assert!(matches!(characters.step(&r, 0.1, few), Err(Error::Length { .. })));
    }
    assert!(matches!(characters.step(&r, 0.1, &[PolicyOrder::towards(1, Vec3::ZERO); 2]), Err(Error::Index { .. })));
    assert!(matches!(characters.step(&r, f32::NAN, &orders), Err(Error::Value { .. })));
    assert!(matches!(characters.step(&r, 0.1, &[PolicyOrder::towards(0, Vec3::NAN); 2]), Err(Error::Value { .. })));
    // As many frames and segments, other content; and the same content, opened again.
    let other = AlignedBytes::from_slice(&super::made_up::bytes(&[], true));
    let mut twin = r.clone();
    twin.bundle = Bundle::from_bytes(other).unwrap();
    assert!(matches!(characters.step(&twin, 0.1, &orders), Err(Error::OtherBundle { .. })));
    let kept = characters.snapshot();
    assert!(Characters::new(&twin, plain(), &starts(2)).unwrap().restore(&twin, &kept).is_err());
    characters.step(&MotionSet::new(&tables()), 0.1, &orders).unwrap();
    characters.restore(&MotionSet::new(&tables()), &kept).unwrap();
}
