//! Walkers: on their trajectories, feet planted, whatever happens to speed, direction, body and ground.

use super::made_up::MadeUp;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use throng_runtime::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::blend::{BlendError, HeightField};
use throng_runtime::{Contacts, Joint, Mat3x4, Planar, Skeleton};

const DT_S: f32 = 1.0 / 60.0;

/// The default skeleton, larger or smaller, with longer or shorter legs.
fn body(size: f32, legs: f32) -> Skeleton {
    let mut s = Skeleton::default();
    s.offsets.iter_mut().chain(&mut s.tips).for_each(|o| *o *= size);
    for j in [Joint::LeftShin, Joint::LeftFoot, Joint::RightShin, Joint::RightFoot] {
        let longer = s.offsets[j.index()].y * (legs - 1.0);
        s.offsets[j.index()].y += longer;
        s.offsets[0].y -= 0.5 * longer;
    }
    s
}

fn bodies() -> [Skeleton; 5] {
    [body(1.0, 1.0), body(0.6, 1.0), body(1.25, 1.0), body(1.0, 1.2), body(0.9, 0.85)]
}

/// How a walker's velocity goes over time: seconds to (velocity, heading).
type Course = fn(usize, f32) -> (Vec2, Option<f32>);

/// Walkers of all bodies on a course, each integrated on its own.
struct Outing {
    walkers: Walkers,
    controls: Vec<Control>,
    time_s: f32,
}

impl Outing {
    fn new(made_up: &MadeUp, config: WalkersConfig, n: usize) -> Self {
        let starts: Vec<_> = (0..n)
            .map(|c| WalkerStart { body: c % 5, root: Planar::new(4.0 * c as f32, 0.0, 0.0), phase: 0.37 * c as f32 })
            .collect();
        let walkers =
            Walkers::new(&made_up.space(), &Skeleton::default(), &bodies(), config, &starts).expect("walkers");
        let controls = starts.iter().map(|s| Control { position: Vec2::new(s.root.x, s.root.z), ..Control::default() });
        Self { walkers, controls: controls.collect(), time_s: 0.0 }
    }

    fn step(&mut self, made_up: &MadeUp, course: Course, ground: &HeightField) {
        self.time_s += DT_S;
        for (c, control) in self.controls.iter_mut().enumerate() {
            let (velocity, heading) = course(c, self.time_s);
            control.position += velocity * DT_S;
            (control.velocity, control.heading) = (velocity, heading);
        }
        self.walkers.step(&made_up.space(), DT_S, &self.controls, ground).expect("a step");
    }
}

/// What a foot stands on, in the world: bottom of the heel, and the ground below the toe joint on a flat foot.
fn sole(walkers: &Walkers, character: usize, side: usize) -> [Vec3; 2] {
    let s = &bodies()[character % 5];
    let (foot, toe) = [(Joint::LeftFoot, Joint::LeftToe), (Joint::RightFoot, Joint::RightToe)][side];
    let rest = s.rest_positions();
    let ball = s.offsets[toe.index()];
    let root = walkers.root(character);
    let pose = walkers.pose(character)[foot.index()];
    let [heel, ball] = [Vec3::new(0.0, -rest[foot.index()].y, -0.3 * ball.z), ball].map(|p| {
        let m = pose.translation() + pose.rotation() * p;
        root.rotation() * m + root.translation()
    });
    [heel, ball - Vec3::Y * rest[toe.index()].y]
}

const FEET: [Contacts; 2] = [Contacts::LEFT, Contacts::RIGHT];

/// The lower end of every planted foot moves so slowly over the ground, 95th percentile. [Unit: m/s]
fn slip_p95(made_up: &MadeUp, course: Course, seconds: f32) -> f32 {
    let mut outing = Outing::new(made_up, WalkersConfig::default(), 10);
    let flat = HeightField::flat();
    let mut speeds = Vec::new();
    let mut before: Vec<Option<[Vec3; 2]>> = vec![None; 20];
    while outing.time_s < seconds {
        outing.step(made_up, course, &flat);
        for c in 0..10 {
            for side in 0..2 {
                let now = sole(&outing.walkers, c, side);
                let down = outing.walkers.contacts(c).any(FEET[side]);
                let was = std::mem::replace(&mut before[2 * c + side], down.then_some(now));
                if let (true, Some(was)) = (down, was) {
                    let moved = |k: usize| Vec2::new(now[k].x - was[k].x, now[k].z - was[k].z).length();
                    speeds.push(moved(0).min(moved(1)) / DT_S);
                }
            }
        }
    }
    speeds.sort_by(f32::total_cmp);
    assert!(speeds.len() > 1000, "{} are too few to prove anything", speeds.len());
    speeds[speeds.len() * 95 / 100]
}

fn wandering(c: usize, t: f32) -> (Vec2, Option<f32>) {
    let speed = 1.2 + 0.9 * (0.9 * t + c as f32).sin();
    let heading = 1.5 * (0.4 * t + 0.7 * c as f32).sin();
    (speed * Vec2::new(heading.sin(), heading.cos()), None)
}

/// Other speeds and directions from one tick to the next.
fn jumping(c: usize, t: f32) -> (Vec2, Option<f32>) {
    let k = ((t / 0.7) as usize + 3 * c) % 7;
    let speed = [0.0, 1.0, 3.5, 0.5, 5.0, 1.5, 2.5][k];
    let heading: f32 = [0.0, 0.5, -0.6, 0.9, 0.2, -0.3, 1.4][(k + c) % 7];
    (speed * Vec2::new(heading.sin(), heading.cos()), None)
}

#[test]
fn planted_feet_do_not_slide() {
    let made_up = MadeUp::locomotion();
    let p95 = slip_p95(&made_up, wandering, 12.0);
    assert!(p95 < 0.02, "{p95} m/s while wandering");
    let p95 = slip_p95(&made_up, jumping, 12.0);
    assert!(p95 < 0.02, "{p95} m/s while jumping");
}

#[test]
fn the_root_lies_on_the_trajectory_and_the_hips_above_it() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
    for _ in 0..300 {
        outing.step(&made_up, wandering, &HeightField::flat());
        for c in 0..10 {
            let (root, want) = (outing.walkers.root(c), outing.controls[c].position);
            assert_eq!(Vec2::new(root.x, root.z), want);
            let size = bodies()[c % 5].leg_length() / Skeleton::default().leg_length();
            let hips = outing.walkers.pose(c)[0].translation();
            assert!(hips.x.hypot(hips.z) < 0.1 && (0.6..1.05).contains(&(hips.y / size)), "{c}: {hips}");
        }
    }
}

#[test]
fn soles_touch_the_ground_and_no_foot_goes_below_it() {
    let made_up = MadeUp::locomotion();
    for course in [wandering as Course, jumping] {
        let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
        for _ in 0..400 {
            outing.step(&made_up, course, &HeightField::flat());
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
fn who_stands_still_stands_still() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 5);
    let stop: Course = |_, t| (Vec2::new(0.0, if t < 2.0 { 1.5 } else { 0.0 }), None);
    for _ in 0..300 {
        outing.step(&made_up, stop, &HeightField::flat());
    }
    let soles = |o: &Outing| (0..10).map(|i| sole(&o.walkers, i / 2, i % 2)).collect::<Vec<_>>();
    let before = soles(&outing);
    for _ in 0..120 {
        outing.step(&made_up, stop, &HeightField::flat());
        for c in 0..5 {
            assert!(outing.walkers.contacts(c).any(Contacts::LEFT) && outing.walkers.contacts(c).any(Contacts::RIGHT));
        }
    }
    for (a, b) in before.iter().zip(soles(&outing)) {
        assert!(a[0].distance(b[0]) < 2e-3 && a[1].distance(b[1]) < 2e-3, "{a:?} {b:?}");
    }
}

#[test]
fn a_turn_on_the_spot_ends_at_the_heading_with_the_feet_below() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 5);
    let turn: Course = |_, t| (Vec2::ZERO, Some(if t < 1.0 { 0.0 } else { 2.5 }));
    let mut lifted = [false; 5];
    for _ in 0..360 {
        outing.step(&made_up, turn, &HeightField::flat());
        for (c, lifted) in lifted.iter_mut().enumerate() {
            *lifted |= FEET.iter().any(|f| !outing.walkers.contacts(c).any(*f));
        }
    }
    assert_eq!(lifted, [true; 5], "turning takes steps");
    for c in 0..5 {
        let root = outing.walkers.root(c);
        assert!((root.heading - 2.5).abs() < 0.02, "{}", root.heading);
        for (side, foot) in [Joint::LeftFoot, Joint::RightFoot].into_iter().enumerate() {
            let at = outing.walkers.pose(c)[foot.index()].translation();
            assert!(at.x * [1.0, -1.0][side] > 0.02 && at.z.abs() < 0.2, "{c}: {at}");
        }
    }
}

#[test]
fn side_and_back_steps_face_where_they_are_told() {
    let made_up = MadeUp::locomotion();
    for (velocity, axis, sign) in [(Vec2::new(0.7, 0.0), 1, 1.0), (Vec2::new(0.0, -0.8), 0, -1.0)] {
        let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
        outing.controls[0].velocity = velocity;
        for _ in 0..120 {
            outing.controls[0].position += velocity * DT_S;
            outing.controls[0].heading = Some(0.0);
            let flat = HeightField::flat();
            outing.walkers.step(&made_up.space(), DT_S, &outing.controls, &flat).expect("a step");
        }
        assert!(outing.walkers.root(0).heading.abs() < 1e-3);
        let p = outing.walkers.parameters(0);
        assert!((p[axis] - sign * velocity.length()).abs() < 0.01, "{p:?}");
    }
}

#[test]
fn who_follows_a_circle_faces_along_it() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    let circle: Course = |_, t| (1.5 * Vec2::new(t.sin(), t.cos()), None);
    for _ in 0..600 {
        outing.step(&made_up, circle, &HeightField::flat());
    }
    let off = (outing.walkers.root(0).heading - outing.time_s + PI).rem_euclid(TAU) - PI;
    assert!(off.abs() < 0.1, "{off}");
    assert!((outing.walkers.parameters(0)[2] - 1.0).abs() < 0.05);
}

#[test]
fn larger_bodies_walk_at_the_same_froude_number() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 3);
    let straight: Course = |_, _| (Vec2::new(0.0, 1.2), None);
    for _ in 0..120 {
        outing.step(&made_up, straight, &HeightField::flat());
    }
    for (c, size) in [1.0f32, 0.6, 1.25].into_iter().enumerate() {
        let p = outing.walkers.parameters(c)[0];
        assert!((p - 1.2 / size.sqrt()).abs() < 1e-3, "{c}: {p}");
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
        outing.step(&made_up, wandering, &HeightField::flat());
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

/// Somebody who walks back, aside and ahead, faster than the feet follow, has knees that point ahead.
#[test]
fn no_knee_ever_bends_backwards() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
    let about: Course = |c, t| {
        let k = (t / 0.6) as usize + c;
        (Vec2::new([0.0, 0.8, -0.8][k % 3], [1.4, -1.0, 0.5, -0.6][k % 4]), Some(0.0))
    };
    for i in 0..900 {
        outing.step(&made_up, if i < 450 { jumping } else { about }, &HeightField::flat());
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

/// However abruptly speed and direction change, no knee snaps.
#[test]
fn jumps_of_speed_do_not_throw_legs_about() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
    let mut before = [[f32::NAN; 2]; 10];
    for i in 0..900 {
        outing.step(&made_up, jumping, &HeightField::flat());
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

/// A trajectory that speeds up steadily is not followed late.
#[test]
fn steady_changes_are_followed_without_delay() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    let faster: Course = |_, t| (Vec2::new(0.0, 0.5 + t.min(3.0)), None);
    for i in 0..170 {
        outing.step(&made_up, faster, &HeightField::flat());
        let (got, asked) = (outing.walkers.parameters(0)[0], 0.5 + outing.time_s);
        assert!(i < 60 || (got - asked).abs() < 0.02, "{got} where {asked} was asked for, {} s", outing.time_s);
    }
    // A jump is eased.
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    outing.step(&made_up, |_, _| (Vec2::Y, None), &HeightField::flat());
    outing.step(&made_up, |_, _| (Vec2::Y * 4.0, None), &HeightField::flat());
    assert!(outing.walkers.parameters(0)[0] < 1.2);
}

#[test]
fn nobody_is_stretched_by_a_jump_to_elsewhere() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 5);
    let stand: Course = |_, _| (Vec2::ZERO, None);
    for shift in [0.3, 0.6, 30.0] {
        for _ in 0..60 {
            outing.step(&made_up, stand, &HeightField::flat());
        }
        outing.controls.iter_mut().for_each(|c| c.position.x += shift);
        for _ in 0..120 {
            outing.step(&made_up, stand, &HeightField::flat());
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
    let straight: Course = |_, _| (Vec2::new(0.0, 1.2), None);
    for i in 0..600 {
        outing.step(&made_up, straight, &field);
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
fn hands_that_touch_go_where_the_examples_have_them() {
    use throng_runtime::blend::channel;
    let mut made_up = MadeUp::locomotion();
    let place = Vec3::new(0.15, 0.35, 0.35);
    for row in &mut made_up.channels {
        row.values[channel::LEFT_TOUCH] = 1.0;
        row.values[channel::LEFT_HAND..][..3].copy_from_slice(&place.to_array());
    }
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    outing.step(&made_up, |_, _| (Vec2::ZERO, None), &HeightField::flat());
    let pose = outing.walkers.pose(0);
    let hand = pose[Joint::LeftHand.index()].translation() - pose[0].translation();
    assert!(hand.abs_diff_eq(place, 1e-4), "{hand}");
    let other = pose[Joint::RightHand.index()].translation() - pose[0].translation();
    assert!(other.x < -0.5, "the other arm is left as it is: {other}");
}

#[test]
fn threads_and_splits_change_nothing() {
    let made_up = MadeUp::locomotion();
    let run = |threads: usize, n: usize| -> Vec<Mat3x4> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut outing = Outing::new(&made_up, WalkersConfig { local_transforms: true, ..WalkersConfig::default() }, n);
        pool.install(|| {
            for i in 0..40 {
                for (c, control) in outing.controls.iter_mut().enumerate() {
                    control.velocity = wandering(c, i as f32 * DT_S).0;
                    control.position += control.velocity * DT_S;
                }
                let flat = HeightField::flat();
                if threads == 0 {
                    outing.walkers.step(&made_up.space(), DT_S, &outing.controls, &flat).expect("a step");
                } else {
                    outing.walkers.par_step(&made_up.space(), DT_S, &outing.controls, &flat).expect("a step");
                }
            }
        });
        outing.walkers.model_matrices().to_vec()
    };
    let one = run(1, 300);
    assert_eq!(one, run(2, 300));
    assert_eq!(one, run(8, 300));
    assert_eq!(one[..100 * 22], run(2, 100), "the others do not matter");
}

#[test]
fn a_snapshot_leads_to_the_same_steps() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 9);
    let flat = HeightField::flat();
    for _ in 0..50 {
        outing.step(&made_up, jumping, &flat);
    }
    let (snapshot, controls, time_s) = (outing.walkers.snapshot(), outing.controls.clone(), outing.time_s);
    for _ in 0..50 {
        outing.step(&made_up, jumping, &flat);
    }
    let want = outing.walkers.model_matrices().to_vec();
    outing.walkers.restore(&snapshot).expect("a snapshot");
    (outing.controls, outing.time_s) = (controls, time_s);
    for _ in 0..50 {
        outing.step(&made_up, jumping, &flat);
    }
    assert_eq!(outing.walkers.model_matrices(), want);
    assert!(snapshot.num_bytes() > 9 * 100);
    let other = Outing::new(&made_up, WalkersConfig::default(), 8);
    assert!(outing.walkers.restore(&other.walkers.snapshot()).is_err());
}

#[test]
fn local_transforms_build_the_same_pose() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig { local_transforms: true, ..WalkersConfig::default() }, 10);
    for _ in 0..30 {
        outing.step(&made_up, wandering, &HeightField::flat());
    }
    for c in 0..10 {
        let mut world = [glam::Mat4::IDENTITY; 22];
        for joint in Joint::ALL {
            let l = outing.walkers.local_transforms()[c * 22 + joint.index()];
            let local = glam::Mat4::from_rotation_translation(
                glam::Quat::from_array(l.rotation),
                Vec3::from_array(l.translation),
            );
            world[joint.index()] = joint.parent().map_or(local, |p| world[p.index()] * local);
            let want = outing.walkers.pose(c)[joint.index()].to_mat4();
            assert!(world[joint.index()].abs_diff_eq(want, 2e-4), "{c} {joint:?}");
        }
    }
}

#[test]
fn without_smoothing_parameters_are_those_asked_for() {
    let made_up = MadeUp::locomotion();
    let config = WalkersConfig { parameter_half_life_s: 0.0, ..WalkersConfig::default() };
    let mut outing = Outing::new(&made_up, config, 1);
    outing.step(&made_up, |_, _| (Vec2::new(0.0, 0.8), None), &HeightField::flat());
    outing.step(&made_up, |_, _| (Vec2::new(0.0, 4.0), None), &HeightField::flat());
    assert_eq!(outing.walkers.parameters(0)[0], 4.0);
    let sum: f32 = outing.walkers.weights(0).iter().sum();
    assert!((sum - 1.0).abs() < 1e-5);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let made_up = MadeUp::locomotion();
    let space = made_up.space();
    let new = |bodies: &[Skeleton], config: WalkersConfig, start: WalkerStart| {
        Walkers::new(&space, &Skeleton::default(), bodies, config, &[start]).map(|_| ())
    };
    let start = WalkerStart::default();
    let default = WalkersConfig::default();
    assert!(new(&bodies(), default, start).is_ok());
    assert!(matches!(new(&[], default, start), Err(BlendError::Index { what: "body", .. })));
    let nowhere = WalkerStart { root: Planar::new(f32::NAN, 0.0, 0.0), ..start };
    assert!(matches!(new(&bodies(), default, nowhere), Err(BlendError::Value { what: "start x", .. })));
    let mut crippled = Skeleton::default();
    crippled.offsets[Joint::LeftShin.index()] = Vec3::ZERO;
    assert!(matches!(new(&[crippled], default, start), Err(BlendError::Value { .. })));
    let config = WalkersConfig { tempo: [1.1, 1.2], ..default };
    assert!(matches!(new(&bodies(), config, start), Err(BlendError::Value { what: "tempo[0]", .. })));

    let mut outing = Outing::new(&made_up, default, 2);
    let flat = HeightField::flat();
    let good = Control::default();
    let before = outing.walkers.clone();
    for (dt_s, controls) in [
        (-1.0, vec![good; 2]),
        (f32::NAN, vec![good; 2]),
        (DT_S, vec![good; 3]),
        (DT_S, vec![good, Control { position: Vec2::new(f32::NAN, 0.0), ..good }]),
        (DT_S, vec![good, Control { heading: Some(f32::INFINITY), ..good }]),
    ] {
        assert!(outing.walkers.step(&space, dt_s, &controls, &flat).is_err());
        assert_eq!(outing.walkers.root(1), before.root(1));
    }
    let other = MadeUp::new(&[[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]], [2, 2, 2]);
    let e = outing.walkers.step(&other.space(), DT_S, &[good; 2], &flat).expect_err("another space");
    assert!(matches!(e, BlendError::OtherSpace { expected: 20, got: 2, .. }), "{e}");
}

#[test]
fn a_sharp_corner_is_taken_at_the_largest_turning_rate() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    let corner: Course = |_, t| (1.5 * if t < 1.0 { Vec2::Y } else { Vec2::X }, None);
    let mut before = 0.0;
    for _ in 0..180 {
        outing.step(&made_up, corner, &HeightField::flat());
        let heading = outing.walkers.root(0).heading;
        assert!((heading - before).abs() < WalkersConfig::default().max_turning_rate * DT_S + 1e-4);
        before = heading;
    }
    assert!((before - FRAC_PI_2).abs() < 0.02, "{before}");
}
