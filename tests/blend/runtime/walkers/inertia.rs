//! Trajectories without given positions: they follow orders within the limits of inertia.

use super::*;
use throng_core::blend::{BlendSpace, axis};
use throng_core::walkers::InertiaConfig;

const LIMITS: InertiaConfig = InertiaConfig { speeding_up_mps2: 2.0, slowing_down_mps2: 1.5, sideways_mps2: 2.4 };

fn walkers_in(space: BlendSpace, n: usize) -> (Walkers, Vec<Id>) {
    let config = WalkersConfig { inertia: LIMITS, ..WalkersConfig::default() };
    let mut walkers = Walkers::with_capacity(space, &[], config, n).expect("walkers");
    let start = |c: usize| WalkerStart { phase: c as f32 / n as f32, ..WalkerStart::default() };
    let ids = (0..n).map(|c| walkers.spawn(start(c)).expect("room")).collect();
    (walkers, ids)
}

fn one() -> (Walkers, Id) {
    let (walkers, ids) = walkers_in(MadeUp::locomotion().space(), 1);
    (walkers, ids[0])
}

fn at(walkers: &Walkers) -> Vec2 {
    Vec2::new(walkers.root(0).x, walkers.root(0).z)
}

fn step_for(walkers: &mut Walkers, seconds: f32, dt_s: f32) -> Vec<Vec2> {
    let step = |_| {
        walkers.step(dt_s, &Inline).expect("a step");
        at(walkers)
    };
    (0..(seconds / dt_s).round() as usize).map(step).collect()
}

/// Largest acceleration of a path along and across it (m/s^2).
fn accelerations(path: &[Vec2], dt_s: f32) -> [f32; 2] {
    path.windows(3).fold([0.0f32; 2], |[along, across], p| {
        let [v, w] = [p[1] - p[0], p[2] - p[1]];
        let (change, ahead) = ((w - v) / (dt_s * dt_s), (v + w).normalize_or_zero());
        [along.max(change.dot(ahead).abs()), across.max(change.perp_dot(ahead).abs())]
    })
}

#[test]
fn speed_changes_at_the_limits_whatever_the_step() {
    for dt_s in [1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0] {
        let (mut walkers, id) = one();
        walkers.order(id, Control::walk(Vec2::new(0.0, 3.0))).expect("an order");
        let begin = step_for(&mut walkers, 1.0, dt_s);
        // Half of 2 m/s^2 for a second.
        assert!((at(&walkers) - Vec2::new(0.0, 1.0)).length() < 1e-3, "{}", at(&walkers));
        step_for(&mut walkers, 1.0, dt_s);
        // 2.25 m until 3 m/s are reached after 1.5 s, and half a second at that speed.
        let z = at(&walkers).y;
        assert!((z - 3.75).abs() < 0.02, "{z}");
        walkers.order(id, Control::walk(Vec2::ZERO)).expect("an order");
        let stop = step_for(&mut walkers, 2.5, dt_s);
        // 3^2 / (2 * 1.5) m, in 2 s.
        assert!((at(&walkers).y - z - 3.0).abs() < 0.06, "{}", at(&walkers).y - z);
        let still = stop[(2.1 / dt_s) as usize..].iter().all(|p| *p == at(&walkers));
        assert!(still, "it stands after 2 s");
        for (path, most) in [(begin, LIMITS.speeding_up_mps2), (stop, LIMITS.slowing_down_mps2)] {
            let [along, across] = accelerations(&path, dt_s);
            assert!(along < 1.02 * most && across < 0.01, "{along} and {across} m/s^2, at most {most}");
        }
    }
}

#[test]
fn an_order_to_cut_is_followed_at_once() {
    let (mut walkers, id) = one();
    walkers.order(id, Control { cut: true, ..Control::walk(Vec2::new(0.0, 3.0)) }).expect("an order");
    step_for(&mut walkers, 0.5, DT_S);
    assert!((at(&walkers).y - 1.5).abs() < 1e-3);
    let here = at(&walkers);
    walkers.order(id, Control { cut: true, ..Control::default() }).expect("an order");
    step_for(&mut walkers, 0.1, DT_S);
    assert_eq!(at(&walkers), here);
}

#[test]
fn turns_stay_within_the_sideways_limit_and_end() {
    for (speed, angle) in [(1.4f32, 1.6f32), (1.4, 3.1), (2.5, 0.8), (4.0, 1.6), (0.8, -2.5), (0.0, 3.1), (0.0, -1.2)] {
        let (mut walkers, id) = one();
        walkers.order(id, Control { cut: true, ..Control::walk(Vec2::Y * speed) }).expect("an order");
        step_for(&mut walkers, 0.5, DT_S);
        let to = Vec2::new(angle.sin(), angle.cos());
        walkers.order(id, Control::walk(to * speed.max(1.2))).expect("an order");
        let path = step_for(&mut walkers, 4.0, DT_S);
        let [along, across] = accelerations(&path, DT_S);
        assert!(along < 2.1 && across < 2.5, "{speed}, {angle}: {along} and {across} m/s^2");
        let last = (path[path.len() - 1] - path[path.len() - 2]) / DT_S;
        assert!(last.distance(to * speed.max(1.2)) < 0.01, "{speed}, {angle}: {last}");
        let ended = path.windows(2).position(|p| (p[1] - p[0]).normalize_or_zero().dot(to) > 0.98);
        let seconds = ended.expect("it turns") as f32 * DT_S;
        assert!(seconds < if speed < 2.0 { 1.4 } else { 2.6 }, "{speed}, {angle}: turned after {seconds} s");
    }
}

/// Side and back steps go through a stand, without an arc between them.
#[test]
fn whoever_keeps_a_heading_reverses_on_a_line() {
    let (mut walkers, id) = one();
    let side = |x: f32| Control { heading: Some(0.0), ..Control::walk(Vec2::new(x, 0.0)) };
    for x in [0.7, -0.7, 0.7] {
        walkers.order(id, side(x)).expect("an order");
        let path = step_for(&mut walkers, 2.0, DT_S);
        assert!(path.iter().all(|p| p.y.abs() < 1e-3), "{path:?}");
        assert!(((path[119] - path[118]).x / DT_S - x).abs() < 0.01);
    }
}

#[test]
fn walkers_on_given_positions_are_there_and_keep_their_speed_afterwards() {
    let (mut walkers, id) = one();
    for z in [1.0, 1.1, 4.0, 4.02] {
        let position = Some(Vec2::new(0.3, z));
        walkers.order(id, Control { position, ..Control::walk(Vec2::new(0.0, 1.2)) }).expect("an order");
        step_for(&mut walkers, DT_S, DT_S);
        assert_eq!(at(&walkers), Vec2::new(0.3, z));
    }
    step_for(&mut walkers, 1.0, DT_S);
    assert!((at(&walkers) - Vec2::new(0.3, 5.22)).length() < 1e-3, "{}", at(&walkers));
}

/// Speeds over the ground of toes near it, ascending (m/s).
fn low_toe_speeds(space: &BlendSpace, speed: f32, radius: Option<f32>) -> Vec<f32> {
    let (mut walkers, ids) = walkers_in(space.clone(), 8);
    let turning_rate = radius.map(|r| speed / r);
    for id in ids {
        walkers.order(id, Control { turning_rate, ..Control::walk(Vec2::Y * speed) }).expect("an order");
    }
    let (mut before, mut speeds): (Option<Vec<Vec3>>, _) = (None, Vec::new());
    for i in 0..720 {
        walkers.step(DT_S, &Inline).expect("a step");
        let toes = |c: usize| [Joint::LeftToe, Joint::RightToe].map(|j| walkers.joint_positions(c)[j.index()]);
        let now: Vec<Vec3> = (0..8).flat_map(toes).collect();
        if let Some(was) = before.filter(|_| i > 240) {
            let low = now.iter().zip(was).filter(|(p, _)| p.y < 0.035);
            speeds.extend(low.map(|(p, q)| (p.x - q.x).hypot(p.z - q.z) / DT_S));
        }
        before = Some(now);
    }
    speeds.sort_by(f32::total_cmp);
    speeds
}

#[test]
fn toes_on_circles_are_as_slow_as_on_straights() {
    let tables = crate::common::blend_tables();
    let space = tables.blend(&tables.meta().blends[0].name).expect("a space");
    for speed in [0.9, 1.2, 1.5] {
        let [straight, circle] = [None, Some(5.0)].map(|radius| {
            let speeds = low_toe_speeds(&space, speed, radius);
            [50, 95].map(|percent| speeds[speeds.len() * percent / 100])
        });
        println!("{speed} m/s, low toes: straight {straight:?}, on a circle of 5 m {circle:?} m/s");
        assert!(circle[1] < 1.2 * straight[1] + 0.05, "{circle:?} where {straight:?} on a straight");
    }
}

#[test]
fn the_blend_turns_as_the_path_does_whether_positions_are_given_or_not() {
    let tables = crate::common::blend_tables();
    let space = tables.blend(&tables.meta().blends[0].name).expect("a space");
    let gyration = space.axis_of(axis::GYRATION).expect("an axis of turning");
    for (speed, radius) in [(0.9f32, 5.0f32), (1.4, 2.5), (2.2, -3.0)] {
        let (mut walkers, ids) = walkers_in(space.clone(), 2);
        let (omega, mut position) = (speed / radius, Vec2::ZERO);
        for i in 0..360 {
            let heading = omega * i as f32 * DT_S;
            let velocity = speed * Vec2::new(heading.sin(), heading.cos());
            position += velocity * DT_S;
            walkers.order(ids[0], Control { position: Some(position), ..Control::walk(velocity) }).expect("an order");
            walkers.order(ids[1], Control::walk(velocity)).expect("an order");
            walkers.step(DT_S, &Inline).expect("a step");
            for c in (0..2).filter(|_| i > 180) {
                let got = walkers.parameters(c)[gyration];
                assert!((got - omega).abs() < 0.05 * omega.abs(), "{got} on a curve of {omega} rad/s");
            }
        }
    }
}

/// Root mean squares of the second difference of pelvis, and of toes in the air, and of its change from step to step (m/s^2).
fn roughness(space: &BlendSpace, dt_s: f32) -> [[f32; 2]; 2] {
    let (mut walkers, ids) = walkers_in(space.clone(), 4);
    for (c, id) in ids.into_iter().enumerate() {
        walkers.order(id, Control::walk(Vec2::Y * (1.0 + 0.15 * c as f32))).expect("an order");
    }
    let mut paths = [0; 8].map(|_| Vec::new());
    for i in 0..(8.0 / dt_s) as usize {
        walkers.step(dt_s, &Inline).expect("a step");
        for c in (0..4).filter(|_| i as f32 * dt_s > 3.0) {
            let all = walkers.joint_positions(c);
            paths[c].push(all[0]);
            paths[4 + c].push(all[Joint::LeftToe.index()]);
        }
    }
    let rms = |squares: Vec<f32>| (squares.iter().sum::<f32>() / squares.len() as f32).sqrt() / (dt_s * dt_s);
    [0, 4].map(|first| {
        let all = || paths[first..first + 4].iter();
        // What the ground stops is not smooth.
        let is_free = |p: &[Vec3]| p.iter().all(|p| p.y > 0.05);
        let bends = all().flat_map(|p| p.windows(3).filter(|w| is_free(w)));
        let changes = all().flat_map(|p| p.windows(4).filter(|w| is_free(w)));
        [
            rms(bends.map(|w| (w[2] - 2.0 * w[1] + w[0]).length_squared()).collect()),
            rms(changes.map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).length_squared()).collect()),
        ]
    })
}

#[test]
fn steps_of_240_hz_are_as_smooth_as_those_of_30_hz() {
    let tables = crate::common::blend_tables();
    let space = tables.blend(&tables.meta().blends[0].name).expect("a space");
    let [slow, fast] = [1.0 / 30.0, 1.0 / 240.0].map(|dt_s| roughness(&space, dt_s));
    println!("pelvis and toe, second difference and its change at 30 Hz {slow:?}, at 240 Hz {fast:?} m/s^2");
    for (slow, fast) in slow.into_iter().zip(fast) {
        // Short steps show peaks that long ones average, but no corner.
        assert!(fast[0] < 1.6 * slow[0] && fast[1] < 0.5 * slow[1], "{fast:?} where {slow:?} at 30 Hz");
    }
}
