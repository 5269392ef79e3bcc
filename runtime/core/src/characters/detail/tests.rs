//! Records and levels against characters that are posed whole.

use super::super::tests::{orders, starts, tables};
use super::super::{ActionChoice, AvoidConfig, CharacterStart, Characters, CharactersConfig, Detail, MotionSet};
use super::*;
use crate::planar::Planar;
use crate::skeleton::{Joint, NUM_JOINTS};
use glam::Vec2;
use glam::{Quat, Vec3};

const N: usize = 37;

fn config(avoid: bool) -> CharactersConfig {
    CharactersConfig {
        avoid: avoid.then(AvoidConfig::default),
        choice: ActionChoice::LookAhead { temperature: 0.5 },
        instances: true,
        ..CharactersConfig::default()
    }
}

fn people(r: &MotionSet, avoid: bool) -> Characters {
    let apart = |(i, s): (usize, CharacterStart)| CharacterStart {
        root: Planar::new(4.0 * i as f32, -2.0, s.root.heading),
        ..s
    };
    let starts: Vec<CharacterStart> = starts(N).into_iter().enumerate().map(apart).collect();
    Characters::new(r, config(avoid), &starts).unwrap()
}

/// Positions of all joints in the world, from a record and the rows of its bundle alone.
fn shown(r: &MotionSet, i: &PoseInstance) -> [Vec3; NUM_JOINTS] {
    let [frac, blend] = i.frac_blend.map(|u| f32::from(u) / 65535.0);
    let local = |row: u32, j: usize| r.rotation_code.rotation(&r.frames[row as usize], j);
    let between = |row: u32, j: usize| local(row, j).lerp(local((row + 1).min(119), j), frac);
    let height = |row: u32| {
        let h = |row: u32| r.frames[row.min(119) as usize].height;
        h(row) + frac * (h(row + 1) - h(row))
    };
    let mut out = [(Vec3::ZERO, Quat::IDENTITY); NUM_JOINTS];
    for j in Joint::ALL {
        let q = between(i.row_a, j.index()).lerp(between(i.row_b, j.index()), blend);
        out[j.index()] = match j.parent() {
            None => (Vec3::Y * (height(i.row_a) + blend * (height(i.row_b) - height(i.row_a))), q),
            Some(p) => {
                let (position, rotation) = out[p.index()];
                (position + rotation * r.skeleton.offsets[j.index()], rotation * q)
            }
        };
    }
    let place = Vec3::new(i.x, i.y, i.z);
    out.map(|(p, _)| place + Quat::from_rotation_y(i.heading) * p)
}

/// The largest distance of a joint from where it is posed.
fn farthest(r: &MotionSet, characters: &Characters, c: usize) -> f32 {
    let record = shown(r, &characters.instances()[c]);
    let posed = characters.joint_positions(c);
    record.iter().zip(posed).map(|(a, b)| a.distance(b)).fold(0.0, f32::max)
}

#[test]
fn people_go_where_they_would_go_whoever_looks() {
    let (r, orders) = (MotionSet::new(&tables()), orders(N));
    for avoid in [false, true] {
        let (mut full, mut seen, mut records) = (people(&r, avoid), people(&r, avoid), people(&r, avoid));
        records.set_detail(Some(Detail::RECORDS)).unwrap();
        let mut levels = [0; 3];
        for step in 0..240 {
            let eye = Vec2::new(60.0 + 80.0 * (0.05 * step as f32).sin(), 0.0);
            seen.set_detail(Some(Detail { eye, full_m: 10.0, posed_m: 40.0 })).unwrap();
            for who in [&mut full, &mut seen, &mut records] {
                who.step(&r, 1.0 / 30.0, &orders).unwrap();
            }
            for c in 0..N {
                for who in [&seen, &records] {
                    assert_eq!(who.root(c), full.root(c));
                    assert_eq!(who.segment(c), full.segment(c));
                    assert_eq!(who.instances()[c], full.instances()[c]);
                }
                levels[seen.level(c) as usize] += 1;
            }
        }
        assert!(levels.iter().all(|&n| n > 500), "{levels:?}");
        assert!(records.bodies.iter().all(|b| b.awake == 0), "a record has no body");
        assert!(records.model_matrices().iter().all(|m| *m == crate::Mat3x4::default()));
    }
}

#[test]
fn a_record_is_the_pose_but_for_transitions_and_does_not_jump_there() {
    let (r, orders) = (MotionSet::new(&tables()), orders(N));
    let free = crate::body::FootLockConfig { enabled: false, ..Default::default() };
    let config = CharactersConfig { foot_lock: free, ..config(false) };
    let mut characters = Characters::new(&r, config, &starts(N)).unwrap();
    let dt = 1.0 / 240.0;
    let (mut settled, mut fading) = (0.0f32, 0);
    let mut before: Option<Vec<[Vec3; NUM_JOINTS]>> = None;
    for _ in 0..720 {
        characters.step(&r, dt, &orders).unwrap();
        let records = characters.instances();
        for (c, i) in records.iter().enumerate() {
            assert!(r.frames_after(i.row_a) > 0 && r.frames_after(i.row_b) > 0, "the next row is of the same clip");
            match i.frac_blend[1] {
                0 => settled = settled.max(farthest(&r, &characters, c)),
                _ => fading += 1,
            }
        }
        let now: Vec<[Vec3; NUM_JOINTS]> = records.iter().map(|i| shown(&r, i)).collect();
        for (a, b) in now.iter().zip(before.iter().flatten()).flat_map(|(a, b)| a.iter().zip(b)) {
            assert!(a.distance(*b) < 6.0 * dt, "{} m/s", a.distance(*b) / dt);
        }
        before = Some(now);
    }
    // Straight between rows where poses are cubic.
    assert!(settled < 2e-3, "{settled}");
    assert!(fading > 100, "{fading}");
}

#[test]
fn who_comes_near_is_posed_as_if_always_seen() {
    let (r, orders) = (MotionSet::new(&tables()), orders(N));
    let free = crate::body::FootLockConfig { enabled: false, ..Default::default() };
    // Transitions settle before the next, so that the last one is all that counts.
    let config = CharactersConfig { foot_lock: free, half_life_s: 0.05, ..config(false) };
    for woken_at in 0..40 {
        let [mut full, mut far] = [(); 2].map(|()| Characters::new(&r, config, &starts(N)).unwrap());
        far.set_detail(Some(Detail::RECORDS)).unwrap();
        for step in 0..60 + woken_at {
            if step == 59 + woken_at {
                far.set_detail(None).unwrap();
            }
            [&mut full, &mut far].into_iter().for_each(|who| who.step(&r, 1.0 / 60.0, &orders).unwrap());
        }
        let apart = (0..N).map(|c| {
            let pairs = full.joint_positions(c).into_iter().zip(far.joint_positions(c));
            pairs.map(|(a, b)| a.distance(b)).fold(0.0, f32::max)
        });
        let worst = apart.fold(0.0, f32::max);
        assert!(worst < 1e-3, "{worst} m after {woken_at} steps");
    }
}

#[test]
fn distances_that_are_none_are_refused() {
    let r = MotionSet::new(&tables());
    let mut people = people(&r, false);
    let good = Detail { eye: Vec2::ZERO, full_m: 5.0, posed_m: 20.0 };
    assert!(people.set_detail(Some(good)).is_ok());
    for bad in [
        Detail { eye: Vec2::NAN, ..good },
        Detail { full_m: f32::NAN, ..good },
        Detail { posed_m: 4.0, ..good },
        Detail { full_m: -2.0, ..good },
    ] {
        assert!(people.set_detail(Some(bad)).is_err(), "{bad:?}");
    }
}
