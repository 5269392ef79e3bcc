//! Bodies that give way when they are struck.

use super::*;

const DT: f32 = 1.0 / 240.0;

/// A characters and its twin, which will not be pushed.
fn twins(r: &MotionSet, n: usize, foot_lock: bool) -> [Characters; 2] {
    let foot_lock = FootLockConfig { enabled: foot_lock, ..FootLockConfig::default() };
    let characters =
        Characters::new(r, CharactersConfig { foot_lock, ..CharactersConfig::default() }, &starts(n)).unwrap();
    [characters.clone(), characters]
}

fn step(r: &MotionSet, twins: &mut [Characters; 2], dt: f32) {
    let orders = orders(twins[0].num_characters());
    for t in twins {
        t.step(r, dt, &orders).unwrap();
    }
}

/// Twins with locked feet that have walked for a while.
fn walking_twins(n: usize) -> (MotionSet, [Characters; 2]) {
    moved_twins(&tables(), n)
}

/// Twins with locked feet that have moved for a while.
fn moved_twins(tables: &Bundle, n: usize) -> (MotionSet, [Characters; 2]) {
    let r = MotionSet::new(tables);
    let mut t = twins(&r, n, true);
    (0..30).for_each(|_| step(&r, &mut t, DT));
    (r, t)
}

/// World position of the middle of the head (m).
fn head(r: &MotionSet, t: &Characters, c: usize) -> Vec3 {
    let (root, m) = (t.root(c), &t.pose(c)[Joint::Head.index()]);
    root.rotation() * m.to_mat4().transform_point3(crate::body::head_centre(&r.skeleton)) + root.translation()
}

fn joint(t: &Characters, c: usize, j: Joint) -> Vec3 {
    t.joint_positions(c)[j.index()]
}

#[test]
fn what_is_struck_moves_as_far_as_asked_and_comes_back() {
    let r = MotionSet::new(&tables());
    let half_life = ReactionConfig::default().half_life_s;
    let aside = |t: &[Characters; 2], c: usize, j: Joint| match j {
        Joint::Head => head(&r, &t[0], c) - head(&r, &t[1], c),
        // What the upper trunk carries is the base of the neck.
        _ => joint(&t[0], c, Joint::Neck) - joint(&t[1], c, Joint::Neck),
    };
    for (struck, by) in [
        (Joint::Head, Vec3::new(0.0, 0.0, -0.1)),
        (Joint::Head, Vec3::new(0.08, 0.0, 0.03)),
        (Joint::UpperChest, Vec3::new(-0.05, 0.0, 0.08)),
        (Joint::Chest, Vec3::new(0.0, 0.0, -0.12)),
    ] {
        let mut t = twins(&r, 5, false);
        (0..40).for_each(|_| step(&r, &mut t, DT));
        (0..5).for_each(|c| t[0].push(c, struck, by).unwrap());
        let mut furthest = [Vec3::ZERO; 5];
        let mut peak_s = [0.0; 5];
        for k in 0..240 {
            step(&r, &mut t, DT);
            for c in 0..5 {
                let now = aside(&t, c, struck);
                if now.length() > furthest[c].length() {
                    (furthest[c], peak_s[c]) = (now, k as f32 * DT);
                }
            }
        }
        for c in 0..5 {
            // The spine cannot lengthen, so that the body moves on an arc: what lies along the spine is lost.
            let along = furthest[c].dot(by) / by.length_squared();
            let off = furthest[c] - by;
            assert!((0.75..1.02).contains(&along), "{struck:?} {by} {}", furthest[c]);
            assert!(off.x.hypot(off.z) < 0.25 * by.length(), "{struck:?} {by} {}", furthest[c]);
            assert!((0.5 * half_life..1.1 * half_life).contains(&peak_s[c]), "{}", peak_s[c]);
            assert!(aside(&t, c, struck).length() < 1e-3, "it comes back");
        }
        (0..240).for_each(|_| step(&r, &mut t, DT));
        assert!(t[0].model_matrices() == t[1].model_matrices(), "and is as if nothing had been, to the last bit");
    }
}

#[test]
fn half_of_a_displacement_is_left_after_the_half_life() {
    let config = ReactionConfig { half_life_s: 0.2, ..ReactionConfig::default() };
    let mut reaction = crate::body::reaction::tests::reaction_to_push(&config, Vec3::new(0.1, 0.0, 0.0));
    let mut path = Vec::new();
    for _ in 0..2000 {
        path.push(crate::body::reaction::tests::trunk_after(&mut reaction, &config, 1e-3).x);
    }
    let peak = path.iter().copied().fold(0.0, f32::max);
    let at = path.iter().position(|p| *p == peak).unwrap();
    assert!((peak - 0.1).abs() < 1e-4, "{peak}");
    assert!((path[at + 200] - 0.05).abs() < 5e-4, "{}", path[at + 200]);
    assert_eq!(path[1999], 0.0);
}

#[test]
fn feet_stay_while_the_body_gives_way() {
    let r = MotionSet::new(&standing_tables());
    for foot_lock in [false, true] {
        let mut t = twins(&r, 4, foot_lock);
        (0..30).for_each(|_| step(&r, &mut t, DT));
        (0..4).for_each(|c| t[0].push(c, Joint::UpperChest, Vec3::new(0.08, 0.0, 0.06)).unwrap());
        let mut hips = 0.0f32;
        for _ in 0..60 {
            step(&r, &mut t, DT);
            for c in 0..4 {
                for foot in [Joint::LeftFoot, Joint::LeftToe, Joint::RightFoot, Joint::RightToe] {
                    let moved = joint(&t[0], c, foot) - joint(&t[1], c, foot);
                    assert!(moved.length() < 2e-3, "{foot:?} {moved}");
                }
                hips = hips.max((joint(&t[0], c, Joint::Hips) - joint(&t[1], c, Joint::Hips)).length());
            }
        }
        assert!((hips - 0.04).abs() < 0.002, "{hips}");
    }
}

#[test]
fn joints_keep_their_lengths_and_nothing_jumps() {
    let (r, mut t) = moved_twins(&standing_tables(), 3);
    let mut before: Vec<[Vec3; 2]> = vec![[Vec3::ZERO; 2]; 3 * NUM_JOINTS];
    for k in 0..300 {
        if k % 37 == 0 {
            let by = Vec3::new(0.09 * (k as f32).sin(), 0.02, 0.09 * (k as f32).cos());
            (0..3).for_each(|c| t[0].push(c, Joint::ALL[k / 37 % 6], by).unwrap());
        }
        step(&r, &mut t, DT);
        for c in 0..3 {
            let (with, without) = (t[0].joint_positions(c), t[1].joint_positions(c));
            for j in Joint::ALL {
                let i = j.index();
                if let Some(p) = j.parent() {
                    let length = (with[i] - with[p.index()]).length();
                    assert!((length - r.skeleton.offsets[i].length()).abs() < 2e-3, "{j:?}");
                }
                // What the push adds has no jumps, nor has its velocity.
                let aside = with[i] - without[i];
                let [last, velocity] = before[c * NUM_JOINTS + i];
                let now = (aside - last) / DT;
                let bound = if i <= Joint::RightHand.index() { 4.0 } else { 6.0 };
                assert!(now.length() < bound, "{j:?} {now} m/s");
                assert!((now - velocity).length() / DT < 600.0, "{j:?} {} m/s^2", (now - velocity).length() / DT);
                before[c * NUM_JOINTS + i] = [aside, now];
            }
        }
    }
}

#[test]
fn pushes_add_up_to_the_limit_and_no_further() {
    let (r, mut t) = walking_twins(2);
    let most = ReactionConfig::default().max_displacement_m;
    let mut furthest = 0.0f32;
    for _ in 0..60 {
        t[0].push(0, Joint::UpperChest, Vec3::new(0.0, 0.0, -0.1)).unwrap();
        step(&r, &mut t, DT);
        furthest = furthest.max((joint(&t[0], 0, Joint::Neck) - joint(&t[1], 0, Joint::Neck)).length());
    }
    assert!(furthest > 0.75 * most && furthest < 1.1 * most, "{furthest}");
}

#[test]
fn neighbours_of_who_is_struck_keep_their_pose_to_the_last_bit() {
    let (r, mut t) = walking_twins(9);
    t[0].push(3, Joint::Head, Vec3::new(0.1, 0.0, 0.0)).unwrap();
    for k in 0..100 {
        step(&r, &mut t, DT);
        for c in (0..9).filter(|c| *c != 3) {
            assert!(t[0].pose(c) == t[1].pose(c), "step {k}, character {c}");
        }
        assert!(k > 50 || t[0].pose(3) != t[1].pose(3));
    }
}

#[test]
fn a_restored_characters_goes_on_giving_way() {
    let (r, mut t) = walking_twins(5);
    t[0].push(2, Joint::Head, Vec3::new(0.1, 0.0, -0.1)).unwrap();
    (0..7).for_each(|_| step(&r, &mut t, DT));
    let kept = t[0].snapshot();
    t[1].restore(&r, &kept).unwrap();
    for _ in 0..40 {
        step(&r, &mut t, DT);
        assert!(t[0].model_matrices() == t[1].model_matrices());
    }
}

#[test]
fn a_struck_arm_moves_the_trunk_a_little_and_config_switches_it_off() {
    let r = MotionSet::new(&tables());
    let push = |config: ReactionConfig| {
        let config = CharactersConfig { reaction: config, ..CharactersConfig::default() };
        let characters = Characters::new(&r, config, &starts(1)).unwrap();
        let mut t = [characters.clone(), characters];
        step(&r, &mut t, DT);
        t[0].push(0, Joint::LeftForearm, Vec3::new(0.0, 0.0, -0.1)).unwrap();
        (0..20).for_each(|_| step(&r, &mut t, DT));
        (joint(&t[0], 0, Joint::Neck) - joint(&t[1], 0, Joint::Neck)).length()
    };
    let moved = push(ReactionConfig::default());
    assert!((0.02..0.035).contains(&moved), "{moved}");
    assert_eq!(push(ReactionConfig { enabled: false, ..ReactionConfig::default() }), 0.0);
}

#[test]
fn refuses_pushes_that_cannot_be() {
    let r = MotionSet::new(&tables());
    let mut t = Characters::new(&r, plain(), &starts(2)).unwrap();
    assert!(matches!(t.push(2, Joint::Head, Vec3::X), Err(Error::Index { what: "character", .. })));
    for by in [Vec3::NAN, Vec3::INFINITY, Vec3::X * 1e4] {
        assert!(matches!(t.push(0, Joint::Head, by), Err(Error::Value { what: "displacement", .. })));
    }
    assert!(matches!(t.shift_by(0, Vec2::NAN), Err(Error::Value { what: "shift", .. })));
    let reaction = ReactionConfig { hips_share: 1.5, ..ReactionConfig::default() };
    let config = CharactersConfig { reaction, ..plain() };
    let refused = Characters::new(&r, config, &starts(2));
    assert!(matches!(refused, Err(Error::Value { what: "reaction.hips_share", .. })));
}

#[test]
fn a_shifted_character_leaves_its_planted_feet_and_takes_them_along_later() {
    let tables = tables();
    let r = MotionSet::new(&tables);
    let mut t = twins(&r, 2, true);
    (0..2).for_each(|_| step(&r, &mut t, DT));
    let by = Vec2::new(0.03, -0.02);
    for _ in 0..8 {
        t[0].shift_by(0, by / 8.0).unwrap();
        step(&r, &mut t, DT);
    }
    let aside = |t: &[Characters; 2], j| joint(&t[0], 0, j) - joint(&t[1], 0, j);
    let hips = aside(&t, Joint::Hips);
    assert!((Vec2::new(hips.x, hips.z) - by).length() < 1e-4, "{hips}");
    // The left foot is planted in all frames of the made-up tables, the right one never.
    assert!(aside(&t, Joint::LeftFoot).length() < 0.006, "{}", aside(&t, Joint::LeftFoot));
    assert!((aside(&t, Joint::RightFoot) - hips).length() < 1e-3);
}
