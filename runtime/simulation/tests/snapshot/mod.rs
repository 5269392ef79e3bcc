//! Promise: whatever moves, a snapshot brings all of it back, on any number of threads, and bytes of anybody do no harm.

mod damage;
mod doors;
mod kinds;
pub(crate) mod scenes;

use std::sync::atomic::{AtomicUsize, Ordering};
use throng_core::*;
use throng_simulation::{AnyCharacterGroup, CharacterEvent, CompiledScene, Simulation, SimulationEvent};
use throng_world as world;

const DT: f64 = 1.0 / 30.0;

/// All that can be seen of a simulation.
#[derive(Debug, PartialEq)]
struct Seen {
    hash: u64,
    roots: Vec<Option<Planar>>,
    poses: Vec<Option<[Mat3x4; NUM_JOINTS]>>,
    events: Vec<SimulationEvent>,
}

fn see(sim: &Simulation) -> Seen {
    let poses = sim.poses().map(|p| p.copied()).collect();
    Seen { hash: sim.hash(), roots: sim.roots().collect(), poses, events: sim.events().to_vec() }
}

fn new(scene: &CompiledScene) -> Simulation {
    Simulation::new(scene).unwrap_or_else(|e| panic!("{e}"))
}

/// What is seen after each of some steps.
fn watch(sim: &mut Simulation, steps: usize, run: &dyn Executor) -> Vec<Seen> {
    let step = |_| {
        sim.step_on(DT, run).unwrap_or_else(|e| panic!("{e}"));
        see(sim)
    };
    (0..steps).map(step).collect()
}

/// So many threads, which take one part after the other.
struct Threads(usize);

impl Executor for Threads {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..self.0 {
                scope.spawn(|| {
                    while let Some(k) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|k| *k < num_parts) {
                        part(k);
                    }
                });
            }
        });
    }
}

/// The first step after which two runs differ.
fn differ(a: &[Seen], b: &[Seen]) -> Option<usize> {
    (0..a.len().max(b.len())).find(|&k| a.get(k) != b.get(k))
}

#[test]
fn what_follows_a_snapshot_repeats_bit_by_bit() {
    for (name, scene) in scenes::all() {
        let mut sim = new(&scene);
        // At the start, in the middle of bouts, while news are told on, and later.
        for steps in [0, 7, 30, 45] {
            watch(&mut sim, steps, &Inline);
            let (bytes, hash) = (sim.snapshot(), sim.hash());
            let poses = see(&sim).poses;
            let undisturbed = watch(&mut sim, 40, &Inline);
            assert_ne!(sim.hash(), hash, "{name}");
            for (mut other, who) in [(new(&scene), "fresh"), (sim.clone(), "live")] {
                other.restore(&bytes).unwrap_or_else(|e| panic!("{name}, {who}: {e}"));
                assert!(other.hash() == hash && other.snapshot() == bytes, "{name}, {who}");
                assert!(other.events().is_empty());
                for (then, now) in poses.iter().zip(other.poses()) {
                    let joints = then.iter().flatten().zip(now.into_iter().flatten());
                    let apart = joints.map(|(a, b)| (a.translation() - b.translation()).length());
                    // Feet of blended bodies are put down anew.
                    assert!(then.is_some() == now.is_some() && apart.fold(0.0, f32::max) < 0.02, "{name}, {who}");
                }
                let again = watch(&mut other, 40, &Inline);
                assert_eq!(differ(&undisturbed, &again), None, "{name}, {who}: first step that differs");
            }
            sim.restore(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }
}

#[test]
fn captured_people_on_their_way_go_on_alike_from_any_step() {
    let scene = scenes::compile(scenes::TRAVELLERS, &scenes::boxing(0.0));
    let mut sim = new(&scene);
    watch(&mut sim, 60, &Inline);
    for step in 0..12 {
        let bytes = sim.snapshot();
        let mut other = new(&scene);
        other.restore(&bytes).unwrap();
        watch(&mut sim, 1, &Inline);
        watch(&mut other, 1, &Inline);
        assert!(other.snapshot() == sim.snapshot(), "step {step}");
    }
}

#[test]
fn scenes_are_busy_enough_to_prove_anything() {
    let mut happened = std::collections::BTreeSet::new();
    for (_, scene) in scenes::all() {
        let mut sim = new(&scene);
        let events = watch(&mut sim, 150, &Inline).into_iter().flat_map(|s| s.events);
        happened.extend(events.map(|e| match e.kind {
            CharacterEvent::Hit { .. } => "hit",
            CharacterEvent::Struck { .. } => "struck",
            CharacterEvent::Fulfilled => "fulfilled",
            CharacterEvent::Arrived => "arrived",
            CharacterEvent::Left => "left",
            CharacterEvent::Stuck => "stuck",
            CharacterEvent::RunInto { .. } => "run into",
        }));
    }
    for what in ["hit", "struck", "fulfilled", "arrived", "left"] {
        assert!(happened.contains(what), "nobody is {what}: {happened:?}");
    }
}

#[test]
fn threads_change_nothing() {
    for (name, scene) in scenes::all() {
        let alone = watch(&mut new(&scene), 60, &Inline);
        for threads in [1, 2, 5] {
            let together = watch(&mut new(&scene), 60, &Threads(threads));
            assert_eq!(differ(&alone, &together), None, "{name}, {threads} threads: first step that differs");
        }
    }
}

#[test]
fn many_are_moved_alike_on_several_threads() {
    // More than fit in a part, and enough agents for their engine to be run in parts.
    let many = [
        scenes::SPARRING.replace("count = 18", "count = 300"),
        scenes::PATHS.replace("count = 19", "count = 700"),
        "[[groups]]\nmotion = \"none\"\ncount = 2100\nplace = { disc = { centre = [0.0, 0.0], density = 0.7 } }\n\
         goal = { opposite = { centre = [0.0, 0.0] } }\n"
            .to_owned(),
    ];
    let scene = scenes::compile(&many.concat(), &scenes::boxing(0.0));
    let (mut alone, mut together) = (new(&scene), new(&scene));
    let (first, second) = (watch(&mut alone, 12, &Inline), watch(&mut together, 12, &Threads(3)));
    assert_eq!(differ(&first, &second), None);
    let bytes = alone.snapshot();
    let first = watch(&mut alone, 5, &Inline);
    together.restore(&bytes).unwrap();
    assert_eq!(differ(&first, &watch(&mut together, 5, &Threads(2))), None);
}

#[test]
fn what_is_told_from_outside_is_kept() {
    let scene = scenes::compile(&[scenes::POLICY, scenes::SPARRING, scenes::PATCHES].concat(), &scenes::boxing(0.0));
    let mut sim = new(&scene);
    let before = sim.snapshot();
    let calm = watch(&mut sim, 30, &Inline);
    for group in 0..3 {
        match sim.character_group_mut(group) {
            AnyCharacterGroup::Policy(p) => {
                p.set_home(2, glam::Vec3::new(1.0, 1.4, 0.0)).unwrap();
                p.set_weights(&[0.3]).unwrap();
            }
            AnyCharacterGroup::Sparring(s) => {
                s.set_weights(&[-1.0]).unwrap();
                s.play(3, 1).unwrap();
            }
            AnyCharacterGroup::Patches(p) => p.order_goal(1, Some(world::inhabitants::InhabitantGoal::Roam)).unwrap(),
            _ => unreachable!("three kinds"),
        }
    }
    let bytes = sim.snapshot();
    let told = watch(&mut sim, 30, &Inline);
    for mut other in [new(&scene), sim.clone()] {
        other.restore(&bytes).unwrap();
        assert_eq!(differ(&told, &watch(&mut other, 30, &Inline)), None);
    }
    // Back to before anything was told, targets are dragged again.
    sim.restore(&before).unwrap();
    assert_eq!(differ(&calm, &watch(&mut sim, 30, &Inline)), None);
}

#[test]
fn choices_do_not_depend_on_how_a_group_is_split() {
    for (kind, count, parts) in [
        (scenes::POLICY, 11, [4, 7]),
        (scenes::SPARRING, 18, [6, 12]),
        (scenes::PATHS, 19, [8, 11]),
        (scenes::PATCHES, 5, [2, 3]),
    ] {
        // So far apart that nobody has to make way.
        let kind = kind.replace("spacing_m = 4.0", "spacing_m = 40.0");
        let with = |n: usize| kind.replace(&format!("count = {count}"), &format!("count = {n}"));
        let groups = [kind.clone(), parts.map(with).concat()];
        let [mut whole, mut split] = groups.map(|text| new(&scenes::compile(&text, &scenes::boxing(0.0))));
        assert_eq!((whole.groups().len(), split.groups().len()), (1, 2));
        for step in 0..120 {
            for sim in [&mut whole, &mut split] {
                sim.step(DT).unwrap();
            }
            for who in 0..count {
                assert_eq!(chosen(&whole, who), chosen(&split, who), "step {step}, {who} of {kind}");
            }
        }
    }
}

/// What a character has chosen at random, apart from where a grid puts it: choices made and segment, or the body.
fn chosen(sim: &Simulation, who: usize) -> (Option<(u32, u32)>, Option<[Mat3x4; NUM_JOINTS]>) {
    let (characters, number) = match sim.locate(who) {
        (AnyCharacterGroup::Policy(p), number) => (p.practice().characters(), number),
        (AnyCharacterGroup::Sparring(s), number) => (s.sparring().characters(), number),
        _ => return (None, sim.pose(who).copied()),
    };
    (Some((characters.num_choices(number), characters.segment(number).0)), None)
}
