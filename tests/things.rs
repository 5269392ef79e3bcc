//! People take things, carry them and put them down: hands meet things, things stay in hands and lie where they were put.

use crate::common;
use glam::Vec3;
use std::path::Path;
use std::sync::LazyLock;
use throng_core::{Bundle, Joint};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_simulation::{Scene, Simulation};

/// Walking in one manner, and what people do who stand.
const CONFIG: &str = r#"
name = "people"
synth = { set = "locomotion", also = [{ set = "people" }] }
behaviours = []
resample = { mirror = false }
annotate.ends.still = false
graph.enabled = false
[activities]
greet = {}
handshake = {}
take = {}
put = {}
[blend.ahead]
axes = [{ kind = "speed" }, { kind = "gyration" }]
examples = [{ clip = "idle_neutral", still = true }, { clip = "turn_neutral_*" }, { clip = "walk_neutral_*" }]
"#;

pub static BUNDLE: LazyLock<Bundle> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("people.throng");
    let config = BuildConfig::parse(CONFIG, &folder.path().join("people.toml")).expect("a config");
    common::build(&config, &out, &Cache::disabled());
    Bundle::open(&out).expect("a bundle")
});

/// Three people in a room with two tables carry a thing to and fro, and another one that hangs from a hand.
fn room(seed: u64, height: f32, depth: f32) -> Simulation {
    let text = format!(
        r#"
seed = {seed}
bundle = "people.throng"
[[groups]]
name = "people"
motion = "blend"
spaces = ["ahead"]
count = 3
place = {{ block = {{ from = [-1.5, -1.0], to = [1.5, 1.0] }} }}
radius_m = [0.2, 0.22]
speed_mps = [0.8, 1.4]
graph = "life"
[[environment.obstacles]]
polygon = {{ corners = [[-3.5, -2.0], [-2.9, -2.0], [-2.9, 2.0], [-3.5, 2.0]] }}
[[environment.obstacles]]
polygon = {{ corners = [[2.9, -2.0], [3.5, -2.0], [3.5, 2.0], [2.9, 2.0]] }}
[[things]]
name = "cup"
at = [{near}, {height}, 0.4]
[[things]]
name = "bag"
at = [{far}, {height}, -0.7]
carried = "hanging"
[graphs.life]
level = "social"
start = "stroll"
edges = [
    {{ from = "stroll", to = "cup", when = "not taken('cup')", probability = 0.5 }},
    {{ from = "stroll", to = "bag", when = "not taken('bag')", probability = 0.5 }},
    {{ from = "stroll", to = "stroll" }},
    {{ from = "cup", to = "stroll" }},
    {{ from = "bag", to = "stroll" }},
]
[graphs.life.states]
stroll = {{ do = [{{ roam = [0.0, 0.0], within_m = 1.0 }}, {{ stay = "random" }}] }}
cup = {{ do = [{{ take = "cup" }}, {{ put = "cup", on = [{far}, {height}, 0.5] }}, {{ take = "cup" }}, {{ put = "cup" }}] }}
bag = {{ do = [{{ take = "bag" }}, {{ roam = [0.0, 0.0], within_m = 1.0 }}, {{ put = "bag" }}] }}
"#,
        near = -2.9 - depth,
        far = 2.9 + depth,
    );
    let scene = Scene::parse(&text, Path::new("room.toml")).expect("a scene");
    Simulation::new(&scene.compile(&BUNDLE).expect("it compiles")).expect("a simulation")
}

/// Rooms that differ in all that counts: seed, height of the tables (m), and how far from its edge a thing lies (m).
const ROOMS: [(u64, f32, f32); 10] = [
    (1, 0.9, 0.1),
    (2, 0.8, 0.1),
    (3, 1.0, 0.15),
    (4, 1.2, 0.1),
    (5, 1.35, 0.15),
    (6, 0.85, 0.05),
    (7, 1.1, 0.2),
    (8, 0.95, 0.1),
    (9, 1.25, 0.05),
    (10, 1.05, 0.12),
];

#[test]
fn hands_meet_things_and_keep_them() {
    for (seed, height, depth) in ROOMS {
        let mut room = room(seed, height, depth);
        let mut before: Vec<Vec3> = room.things().map(|t| t.at).collect();
        let mut held_for = [0; 2];
        for step in 0..60 * 60 {
            room.step(1.0 / 60.0).expect("a step");
            for (n, thing) in room.things().enumerate() {
                let name = format!("room {seed}, step {step}, {}", thing.name);
                // A hand is never faster than 6 m/s here, and nothing jumps.
                assert!(thing.at.distance(before[n]) < 0.1, "{name}: {} after {}", thing.at, before[n]);
                before[n] = thing.at;
                held_for[n] = if thing.keeper.is_some() { held_for[n] + 1 } else { 0 };
                assert!((thing.turn.length() - 1.0).abs() < 1e-4, "{name}");
                // A third of a second after the grasp, it lies in one of the palms.
                if let Some(who) = thing.keeper.filter(|_| held_for[n] > 20) {
                    let joints = room.joint_positions(who).expect("a body");
                    let arms = [[Joint::LeftForearm, Joint::LeftHand], [Joint::RightForearm, Joint::RightHand]];
                    let off = arms.map(|[elbow, wrist]| {
                        let forearm = joints[elbow.index()].distance(joints[wrist.index()]);
                        (joints[wrist.index()].distance(thing.at) - 0.35 * forearm).abs()
                    });
                    assert!(off[0].min(off[1]) < 2e-3, "{name}: {off:?}");
                }
            }
        }
        let done = room.handling_counts();
        assert!(done.taken >= 3 && done.put >= 2, "room {seed}: {done:?}");
        let off = [0.95, 1.0].map(|share| done.palm_error_m(share));
        println!(
            "room {seed}, tables {height} m high, {depth} m from the edge: {} taken, {} put down, palms off {off:?} m",
            done.taken, done.put
        );
        assert!(off[1] <= 0.02, "room {seed}: {off:?}");
        assert_eq!(done.missed, 0, "room {seed}");
        for thing in room.things().filter(|t| t.keeper.is_none()) {
            assert!((thing.at.y - height).abs() < 1e-3, "room {seed}: {} lies at {}", thing.name, thing.at);
        }
    }
}

#[test]
fn things_out_of_reach_stay_where_they_are() {
    let mut room = room(12, 2.4, 0.1);
    let before: Vec<Vec3> = room.things().map(|t| t.at).collect();
    (0..60 * 40).for_each(|_| room.step(1.0 / 60.0).expect("a step"));
    let done = room.handling_counts();
    assert!((done.taken, done.put) == (0, 0) && done.missed >= 3, "{done:?}");
    assert!(room.things().map(|t| t.at).eq(before.iter().copied()));
}

#[test]
fn people_bend_down_to_low_things_and_stand_near_high_ones() {
    for (seed, height) in [(13, 0.2), (14, 0.45), (15, 1.6)] {
        let mut room = room(seed, height, 0.05);
        let (mut lowest, mut usual) = (f32::INFINITY, 0.0f32);
        let (mut hips, mut fastest) = ([0.0f32; 3], 0.0f32);
        for step in 0..60 * 40 {
            room.step(1.0 / 60.0).expect("a step");
            for who in 0..3 {
                let joints = room.joint_positions(who).expect("a body");
                let at = |j: Joint| joints[j.index()].y;
                (lowest, usual) = (lowest.min(at(Joint::Head)), usual.max(at(Joint::Hips)));
                // Legs that step lower hips by some centimetres too; here one who bends down.
                if step > 0 && at(Joint::Hips) < usual - 0.2 {
                    fastest = fastest.max((hips[who] - at(Joint::Hips)).abs() * 60.0);
                }
                hips[who] = at(Joint::Hips);
                let feet = [Joint::LeftFoot, Joint::RightFoot].map(at);
                assert!(feet.iter().all(|f| (0.0..0.5).contains(f)), "step {step}: ankles at {feet:?}");
            }
        }
        let done = room.handling_counts();
        println!(
            "things {height} m high: {done:?}, palms off {} m, heads down to {lowest:.2} m, hips up and down at {fastest:.2} m/s",
            done.palm_error_m(1.0)
        );
        // Captured people who sit down and crouch: 0.8 m/s (`single` of SNU).
        assert!(fastest < 0.9, "{height}: hips go at {fastest} m/s");
        assert!(done.taken >= 2 && done.put >= 1 && done.palm_error_m(1.0) <= 0.02, "{height}: {done:?}");
        assert_eq!(lowest < usual + 0.35, height < 1.0, "heads down to {lowest} m, hips up to {usual} m");
    }
}

#[test]
fn a_snapshot_in_the_middle_of_a_grasp_brings_back_what_follows() {
    let mut kept = Vec::new();
    let mut room = room(11, 0.95, 0.1);
    for _ in 0..60 * 12 {
        room.step(1.0 / 60.0).expect("a step");
        if kept.len() < 40 && room.handling_counts().taken < 2 {
            kept.push((room.snapshot(), room.time_s()));
        }
    }
    let (hash, handled) = (room.hash(), room.handling_counts());
    assert!(handled.taken > 0, "nothing was taken: {handled:?}");
    let things: Vec<_> = room.things().map(|t| (t.at, t.turn)).collect();
    for (bytes, time_s) in kept.iter().step_by(13) {
        room.restore(bytes).expect("its own bytes");
        let steps = (60.0 * (12.0 - time_s)).round() as usize;
        (0..steps).for_each(|_| room.step(1.0 / 60.0).expect("a step"));
        assert_eq!((room.hash(), room.handling_counts()), (hash, handled), "from {time_s} s");
        assert!(room.things().map(|t| (t.at, t.turn)).eq(things.iter().copied()));
    }
}
