//! People who meet stand and face each other, whoever passes; those who come again have a body.

use crate::things::BUNDLE;
use std::f32::consts::PI;
use std::path::Path;
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
