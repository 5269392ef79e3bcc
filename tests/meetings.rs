//! People who meet stand and face each other, whoever passes; those who come again have a body.

use crate::things::BUNDLE;
use std::f32::consts::PI;
use std::path::Path;
use throng_core::Joint;
use throng_core::glam::Vec3;
use throng_simulation::{Scene, Simulation};

fn simulation(text: &str) -> Simulation {
    let scene = Scene::parse(text, Path::new("meetings.toml")).expect("a scene");
    Simulation::new(&scene.compile(&BUNDLE).expect("it compiles")).expect("a simulation")
}

/// Two streams of a narrow street; some of each greet one of the other, while the rest pass on both sides.
fn street(seed: u64, count: usize, speed_mps: f32) -> Simulation {
    let group = |name: &str, x: f32, to: f32| {
        format!(
            r#"
[[groups]]
name = "{name}"
motion = "blend"
spaces = ["ahead"]
count = {count}
place = {{ block = {{ from = [{low}, -1.8], to = [{high}, 1.8] }} }}
speed_mps = [{speed_mps}, {fast}]
acceleration_mps2 = [3.0, 4.0]
goal = {{ point = {{ at = [{to}, 0.0] }} }}
"#,
            low = x - 0.25 * count as f32,
            high = x + 0.25 * count as f32,
            fast = 1.15 * speed_mps,
        )
    };
    let groups = [group("east", -7.0, 40.0), group("west", 7.0, -40.0)].concat();
    simulation(&format!(
        r#"
seed = {seed}
bundle = "people.throng"
[agents]
meeting_m = 2.2
{groups}
[[relations]]
of = "east"
to = "west"
share = 0.1
friendship = 0.8
[[rules]]
name = "greet"
on = "meets"
when = "friendship(me, other) > 0.5 and not other.busy"
pause_s = 60.0
both = true
do = [{{ greet = "other", for_s = 3.0 }}]
"#
    ))
}

/// Greeting of one person: its beginning, how far it turned, and how far it is off the other (s, rad).
#[derive(Clone, Copy, Debug)]
struct Greeting {
    since_s: f64,
    turned: f32,
    off: f32,
}

fn wrap(angle: f32) -> f32 {
    (angle + PI).rem_euclid(2.0 * PI) - PI
}

#[test]
fn who_greets_turns_to_the_other_and_not_away_again() {
    let (mut all, mut worst_turn, mut num_off) = (0, 0.0f32, 0);
    for (seed, count, speed) in [(1, 12, 1.2), (2, 16, 1.0), (3, 12, 1.4), (4, 20, 1.2), (5, 16, 1.3)] {
        let mut sim = street(seed, count, speed);
        let mut greetings: Vec<Option<Greeting>> = vec![None; sim.num_characters()];
        let mut before: Vec<_> = sim.roots().collect();
        while sim.time_s() < 14.0 {
            sim.step(1.0 / 30.0).unwrap();
            let now: Vec<_> = sim.roots().collect();
            for (who, greeting) in greetings.iter_mut().enumerate() {
                let why = sim.brains().unwrap().explain(who, sim.time_s());
                let (Some(own), Some(was)) = (now[who], before[who]) else { continue };
                let other = why.because.other.and_then(|other| now[other]).filter(|_| why.action == "greet");
                match other {
                    Some(other) => {
                        let to = (other.x - own.x).atan2(other.z - own.z);
                        let g = greeting.get_or_insert(Greeting { since_s: sim.time_s(), turned: 0.0, off: PI });
                        g.turned += wrap(own.heading - was.heading).abs();
                        g.off = wrap(to - own.heading).abs();
                    }
                    None => {
                        if let Some(g) = greeting.take().filter(|g| sim.time_s() - g.since_s > 2.9) {
                            all += 1;
                            worst_turn = worst_turn.max(g.turned);
                            num_off += u32::from(g.off > 0.35);
                        }
                    }
                }
            }
            before = now;
        }
    }
    assert!(all >= 20, "{all} greetings");
    // Half a turn to face somebody who has just passed, and what the braking steps swing.
    assert!(worst_turn < 1.35 * PI, "somebody turned by {worst_turn} rad");
    assert!(num_off * 20 <= all, "{num_off} of {all} do not face the other at the end");
}

#[test]
fn who_comes_again_has_a_body_where_it_enters() {
    let mut sim = simulation(
        r#"
bundle = "people.throng"
[[groups]]
name = "passers"
motion = "blend"
spaces = ["ahead"]
count = 6
graph = "pass"
place = { block = { from = [0.0, -2.0], to = [2.0, 2.0] } }
source = { rates = [[0.0, 0.8]], reuse = true }
[graphs.pass]
level = "social"
start = "walk"
edges = []
[graphs.pass.states]
walk = { do = [{ leave = [8.0, 0.0] }] }
"#,
    );
    let mut entered = [0; 6];
    let mut was_there = [false; 6];
    while sim.time_s() < 60.0 {
        sim.step(1.0 / 30.0).unwrap();
        for who in 0..6 {
            let disc = sim.disc(who);
            if let Some((disc, joints)) = disc.as_ref().zip(sim.joint_positions(who)) {
                let off = (joints[0] - disc.centre).with_y(0.0).length();
                assert!(off < 0.3, "the body of {who} is {off} m from its disc at {} s", sim.time_s());
            }
            entered[who] += u32::from(disc.is_some() && !was_there[who]);
            was_there[who] = disc.is_some();
        }
    }
    assert!(entered.iter().sum::<u32>() > 20 && entered.iter().any(|&n| n > 2), "{entered:?}");
}

/// Three who walk past a stand: one waves at it, one points at it, one telephones for a while.
const GESTURES: &str = r#"
bundle = "people.throng"
places = [{ name = "stand", at = [4.0, 6.0], radius_m = 0.5 }]
[[groups]]
motion = "blend"
spaces = ["ahead"]
count = 3
place = { block = { from = [-0.5, -5.0], to = [0.5, 1.0], jitter = 0.0 } }
speed_mps = [1.2, 1.2]
goal = { point = { at = [0.0, 40.0] } }
[[events]]
name = "bell"
at_s = 2.0
[[events]]
name = "silence"
at_s = 7.0
[[rules]]
on = "bell"
when = "me.z > 1"
do = [{ gesture = "wave", at = "stand", for_s = 3 }]
[[rules]]
on = "bell"
when = "me.z <= 1 and me.z > -1"
do = [{ gesture = "point", at = "stand" }]
[[rules]]
on = "bell"
when = "me.z <= -1"
do = [{ gesture = "phone" }]
[[rules]]
on = "silence"
do = [{ gesture = "none" }]
"#;

#[test]
fn arms_wave_point_and_telephone_while_people_walk_on() {
    let mut sim = simulation(GESTURES);
    let [shoulder, wrist, head] = [Joint::RightUpperArm, Joint::RightHand, Joint::Head].map(Joint::index);
    // Heights of a hand over its shoulder, its distances from the head, and angles between the arm and the stand, before, during and after.
    let stand = Vec3::new(4.0, 1.2, 6.0);
    let mut seen = [[[0.0f32; 3]; 3]; 3];
    while sim.time_s() < 10.0 {
        sim.step(1.0 / 30.0).unwrap();
        let time_s = sim.time_s();
        let Some(when) = [1.5, 4.0, 9.5].iter().position(|t| (time_s - t).abs() < 0.02) else { continue };
        for who in 0..3 {
            let joints = sim.joint_positions(who).expect("a body");
            // Who walks with the stand on the left points with the left arm.
            let [left_shoulder, left_wrist] = [Joint::LeftUpperArm, Joint::LeftHand].map(|j| joints[j.index()]);
            let off = (left_wrist - left_shoulder).angle_between(stand - left_shoulder);
            seen[when][who] = [joints[wrist].y - joints[shoulder].y, joints[wrist].distance(joints[head]), off];
        }
    }
    let [before, during, after] = seen;
    assert!(during[2][0] > 0.1 && before[2][0].max(after[2][0]) < -0.2, "the hand that waves: {seen:?}");
    assert!(during[1][2] < 0.3 && before[1][2].min(after[1][2]) > 0.5, "the arm that points: {seen:?}");
    assert!(during[0][1] < 0.3 && before[0][1].min(after[0][1]) > 0.4, "the hand with the telephone: {seen:?}");
    let z = |who: usize| sim.root(who).expect("a body").z;
    assert!((0..3).all(|who| z(who) > 5.0), "all walk on");
}

#[test]
fn gestures_that_are_none_and_points_at_nothing_are_refused() {
    let refused = |from: &str, to: &str| {
        let text = GESTURES.replacen(from, to, 1);
        Scene::parse(&text, Path::new("a.toml")).and_then(|s| s.compile(&BUNDLE).map(drop)).unwrap_err().to_string()
    };
    let e = refused("gesture = \"wave\"", "gesture = \"shrug\"");
    assert!(e.contains("one of wave, point, phone") && e.contains("none"), "{e}");
    let e = refused("gesture = \"point\", at = \"stand\"", "gesture = \"point\"");
    assert!(e.contains("expected `at`"), "{e}");
}

#[test]
fn who_greets_or_shakes_hands_raises_a_hand() {
    let scene = |do_what: &str| {
        format!(
            r#"
bundle = "people.throng"
[agents]
meeting_m = 2.5
[[groups]]
motion = "blend"
spaces = ["ahead"]
name = "north"
count = 5
radius_m = [0.2, 0.22]
place = {{ block = {{ from = [-15.0, -4.0], to = [15.0, -3.8] }} }}
speed_mps = [1.1, 1.3]
goal = {{ shift = {{ by = [0.0, 8.0] }} }}
[[groups]]
motion = "blend"
spaces = ["ahead"]
name = "south"
count = 5
radius_m = [0.2, 0.22]
place = {{ block = {{ from = [-15.0, 3.8], to = [15.0, 4.0] }} }}
speed_mps = [1.1, 1.3]
goal = {{ shift = {{ by = [0.0, -8.0] }} }}
[[rules]]
on = "meets"
when = "me.group != other.group and not other.busy"
both = true
pause_s = 100
do = [{do_what}]
"#
        )
    };
    for (do_what, raised_m, apart_m) in
        [("{ greet = \"other\" }", 1.2, 0.0), ("{ shake_hands = \"other\" }", 0.9, 1.05)]
    {
        let mut sim = simulation(&scene(do_what));
        let mut highest = vec![0.0f32; 10];
        let mut nearest = vec![f32::INFINITY; 10];
        while sim.time_s() < 20.0 {
            sim.step(1.0 / 30.0).unwrap();
            let joints: Vec<_> = (0..10).map(|who| sim.joint_positions(who).expect("a body")).collect();
            for who in 0..10 {
                let busy = sim.brains().unwrap().explain(who, sim.time_s()).action;
                if busy == "greet" || busy == "shake_hands" {
                    let hand = |side: Joint| joints[who][side.index()].y;
                    highest[who] = highest[who].max(hand(Joint::RightHand).max(hand(Joint::LeftHand)));
                    let hips = |who: usize| joints[who][0];
                    let others = (0..10).filter(|other| *other != who).map(|other| hips(other).distance(hips(who)));
                    nearest[who] = others.fold(nearest[who], f32::min);
                }
            }
        }
        let raised = highest.iter().filter(|&&y| y > raised_m).count();
        assert!(raised >= 9, "{do_what}: hands of {raised} of 10 are raised: {highest:?}");
        if apart_m > 0.0 {
            nearest.sort_by(f32::total_cmp);
            assert!(nearest[2] > 0.8 * apart_m && nearest[5] < 1.3 * apart_m, "they stand apart by {nearest:?}");
        }
    }
}
