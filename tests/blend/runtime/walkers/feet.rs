//! Feet, legs and hands.

use super::*;

#[test]
fn planted_feet_do_not_slide() {
    let made_up = MadeUp::locomotion();
    let p95 = slip_p95(&made_up, wandering, 12.0);
    assert!(p95 < 0.02, "{p95} m/s while wandering");
    let p95 = slip_p95(&made_up, jumping, 12.0);
    assert!(p95 < 0.02, "{p95} m/s while jumping");
}

#[test]
fn soles_touch_the_ground_and_no_foot_goes_below_it() {
    let made_up = MadeUp::locomotion();
    for course in [wandering as Course, jumping] {
        let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
        for _ in 0..400 {
            outing.step(course);
            for c in 0..10 {
                for side in 0..2 {
                    let low = sole(&outing.walkers, c, side).map(|p| p.y).into_iter().fold(f32::INFINITY, f32::min);
                    assert!(low > -0.012, "{c}: {low} at {}", outing.time_s);
                }
            }
        }
    }
}

#[test]
fn knees_move_smoothly_and_stay_soft() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
    let knee = |w: &Walkers, c: usize, side: usize| {
        let leg = [
            [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot],
            [Joint::RightThigh, Joint::RightShin, Joint::RightFoot],
        ];
        let [a, b, d] = leg[side].map(|j| w.pose(c)[j.index()].translation());
        (b - a).angle_between(d - b)
    };
    let mut before = [[f32::NAN; 2]; 10];
    for i in 0..600 {
        outing.step(wandering);
        for (c, before) in before.iter_mut().enumerate() {
            for (side, before) in before.iter_mut().enumerate() {
                let now = knee(&outing.walkers, c, side);
                assert!(now > 0.02, "{c}: a straight knee");
                // 14 rad/s is what a sprinter's knee reaches.
                assert!(i == 0 || (now - *before).abs() < 14.0 * DT_S * 1.5, "{c}: {before} to {now} at step {i}");
                *before = now;
            }
        }
    }
}

const LEGS: [[Joint; 3]; 2] =
    [[Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot], [Joint::RightThigh, Joint::RightShin, Joint::RightFoot]];

#[test]
fn knees_never_bend_backwards() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
    let about: Course = |c, t| {
        let k = (t / 0.6) as usize + c;
        (Vec2::new([0.0, 0.8, -0.8][k % 3], [1.4, -1.0, 0.5, -0.6][k % 4]), Some(0.0))
    };
    for i in 0..900 {
        outing.step(if i < 450 { jumping } else { about });
        for c in 0..10 {
            for leg in LEGS {
                let [hip, knee, ankle] = leg.map(|j| outing.walkers.pose(c)[j.index()].translation());
                let ahead = outing.walkers.pose(c)[leg[0].index()].rotation() * Vec3::Z;
                let line = (ankle - hip).normalize();
                let out = (knee - hip) - line * (knee - hip).dot(line);
                assert!(out.dot(ahead) > -1e-3, "{c} at step {i}: {out} against {ahead}");
            }
        }
    }
}

#[test]
fn abrupt_changes_of_speed_do_not_snap_knees() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
    let mut before = [[f32::NAN; 2]; 10];
    for i in 0..900 {
        outing.step(jumping);
        for (c, before) in before.iter_mut().enumerate() {
            for (side, before) in before.iter_mut().enumerate() {
                let [hip, knee, ankle] = LEGS[side].map(|j| outing.walkers.pose(c)[j.index()].translation());
                let now = (knee - hip).angle_between(ankle - knee);
                // A sprinter's knee turns at 20 rad/s, a child's faster.
                assert!(i == 0 || (now - *before).abs() < 30.0 * DT_S, "{c}: {before} to {now} at step {i}");
                *before = now;
            }
        }
    }
}

#[test]
fn jumps_of_the_trajectory_do_not_stretch_legs() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 5);
    let stand: Course = |_, _| (Vec2::ZERO, None);
    for shift in [0.3, 0.6, 30.0] {
        for _ in 0..60 {
            outing.step(stand);
        }
        outing.positions.iter_mut().for_each(|p| p.x += shift);
        for _ in 0..120 {
            outing.step(stand);
        }
        for c in 0..5 {
            let size = bodies()[c].leg_length() / Skeleton::default().leg_length();
            for (foot, side) in [(Joint::LeftFoot, 1.0), (Joint::RightFoot, -1.0)] {
                let at = outing.walkers.pose(c)[foot.index()].translation();
                assert!((at.x / size - 0.092 * side).abs() < 0.12, "{c} after {shift}: {at}");
            }
        }
    }
}

#[test]
fn feet_follow_the_ground() {
    let made_up = MadeUp::locomotion();
    let slope = |p: Vec2| 0.15 * p.y;
    let (size, spacing) = ([64, 64], 1.0);
    let origin = Vec2::new(-8.0, -8.0);
    let heights = (0..64 * 64).map(|i| slope(origin + spacing * Vec2::new((i % 64) as f32, (i / 64) as f32))).collect();
    let field = HeightField::new(origin, spacing, size, heights).expect("a field");
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 5);
    outing.walkers.set_ground(field);
    let straight: Course = |_, _| (Vec2::new(0.0, 1.2), None);
    for i in 0..600 {
        outing.step(straight);
        for c in (0..5).filter(|_| i > 60) {
            for side in 0..2 {
                let sole = sole(&outing.walkers, c, side);
                let over = sole.map(|p| p.y - slope(Vec2::new(p.x, p.z)));
                assert!(over[0].min(over[1]) > -0.02, "{c} goes below by {over:?}");
                if outing.walkers.contacts(c).any(FEET[side]) {
                    assert!(over[0].min(over[1]) < 0.04, "{c} is above by {over:?}");
                }
            }
        }
    }
}

#[test]
fn touching_hands_are_placed_as_in_the_examples() {
    use throng_core::blend::channel;
    let mut made_up = MadeUp::locomotion();
    let place = Vec3::new(0.15, 0.35, 0.35);
    for row in &mut made_up.channels {
        row.values[channel::LEFT_TOUCH] = 1.0;
        row.values[channel::LEFT_HAND..][..3].copy_from_slice(&place.to_array());
    }
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    outing.step(|_, _| (Vec2::ZERO, None));
    let pose = outing.walkers.pose(0);
    let hand = pose[Joint::LeftHand.index()].translation() - pose[0].translation();
    assert!(hand.abs_diff_eq(place, 1e-4), "{hand}");
    let other = pose[Joint::RightHand.index()].translation() - pose[0].translation();
    assert!(other.x < -0.5, "the other arm is left as it is: {other}");
}
