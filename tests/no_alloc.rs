//! A step allocates nothing, and neither does a batch of queries or poses. A scene allocates with its size.
#![allow(unsafe_code, reason = "an allocator that counts is an unsafe trait")]

mod common;
#[path = "common/counting.rs"]
mod counting;
#[allow(dead_code, reason = "a part of it is enough here")]
#[path = "blend/runtime/made_up.rs"]
mod made_up_blend;

use counting::allocations;
use glam::{Vec2, Vec3};
use std::hint::black_box;
use std::path::Path;
use throng_core::blend::{BlendedPosture, MAX_AXES};
use throng_core::body::HeightField;
use throng_core::characters::{
    ActionChoice, AvoidConfig, Characters, CharactersConfig, MotionSet, PolicyCharacters, PolicyOrder, SampleJob, Spawn,
};
use throng_core::policy::{self, BestActionJob, LookAheadJob, RankedActions};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{CharacterGroup, Id, Inline, Mat3x4, NUM_JOINTS, Planar};
use throng_crowd::{Agent, AgentOrder, AtEnd, Crowd, CrowdConfig, CrowdSetup, Obstacle, Route, Scheme, Streets};
use throng_precompute::run::{SceneRunConfig, run};
use throng_simulation::sparring::{PracticeConfig, TargetPractice};
use throng_simulation::{Pedestrians, Scene, Simulation};
use throng_world::World;
use throng_world::inhabitants::{InhabitantGoal, Inhabitants, InhabitantsConfig, scatter_rest_nodes};
use throng_world::made_up_floor as made_up;

/// Where a target hangs before its boxer (m).
const HOME: Vec3 = Vec3::new(0.0, 1.5, 0.6);

#[test]
fn the_counter_sees_allocations() {
    assert_eq!(allocations(|| drop(black_box(Box::new(1u64)))), 1);
    assert_eq!(allocations(|| drop(black_box(vec![0u8; 100]))), 1);
    let mut grown: Vec<u8> = Vec::with_capacity(1);
    assert_eq!(allocations(|| black_box(&mut grown).reserve_exact(64)), 1);
    assert_eq!(allocations(|| drop(black_box(grown))), 0);
    assert_eq!(allocations(|| ()), 0);
}

#[test]
fn steps_allocate_nothing() {
    const N: usize = 100;
    let tables = common::tables();
    let motion_set = MotionSet::new(&tables);
    let (starts, orders) = (common::starts(&tables, N), common::orders(N));
    for choice in [
        ActionChoice::BestAction,
        ActionChoice::LookAhead { temperature: 0.0 },
        ActionChoice::LookAhead { temperature: 0.05 },
    ] {
        for local_transforms in [false, true] {
            let config = CharactersConfig { choice, local_transforms, ..CharactersConfig::default() };
            let mut characters = Characters::new(&motion_set, config, &starts).expect("characters");
            characters.step(&motion_set, 0.0, &orders).expect("a first step");
            let chosen = |t: &Characters| (0..N).map(|c| t.num_choices(c)).sum::<u32>();
            let before = chosen(&characters);
            let n = allocations(|| {
                for _ in 0..300 {
                    characters.step(&motion_set, 1.0 / 60.0, &orders).expect("a step");
                }
            });
            let made = chosen(&characters) - before;
            assert!(made > 3 * N as u32, "{made} choices in 5 s are too few to prove anything");
            assert_eq!(n, 0, "{choice:?}, local transforms {local_transforms}");
        }
    }
}

#[test]
fn characters_that_make_way_allocate_nothing() {
    let config = CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() };
    let tables = common::tables();
    let mut character_group = PolicyCharacters::with_capacity(&tables, 144, config).expect("room");
    for i in 0..144 {
        let root = Planar::new(0.8 * (i % 12) as f32, 0.8 * (i / 12) as f32, i as f32);
        let id = character_group.spawn(Spawn::standing_at(root)).expect("there is room");
        character_group
            .order(id, PolicyOrder::towards(0, Vec3::new(5.0 - root.x, 0.0, 5.0 - root.z)))
            .expect("an order");
    }
    let n = allocations(|| (0..600).for_each(|_| character_group.step(1.0 / 60.0, &Inline).expect("a step")));
    let blocked = (0..144).filter(|&c| character_group.characters().num_blocked_choices(c) > 0).count();
    assert!(blocked > 3, "{blocked} in each other's way prove little");
    assert_eq!(n, 0);
}

#[test]
fn a_step_towards_two_goals_allocates_nothing() {
    const N: usize = 9;
    let tables = common::tables();
    let motion_set = MotionSet::new(&tables);
    let (starts, orders) = (common::starts(&tables, N), common::orders(N));
    let mut characters = Characters::new(&motion_set, CharactersConfig::default(), &starts).expect("characters");
    let orders: Vec<PolicyOrder> = orders.into_iter().map(|order| order.with_policy(0, 0.5)).collect();
    characters.step(&motion_set, 0.0, &orders).expect("a first step");
    let n = allocations(|| (0..100).for_each(|_| characters.step(&motion_set, 0.05, &orders).expect("a step")));
    assert_eq!(n, 0);
}

#[test]
fn inhabitants_allocate_nothing() {
    let tables = made_up::tables();
    let world = made_up::world(&tables, &["#########", "#b#####b#", "###...###", "##b######", "#########"]);
    let world = World::from_data(&world, &tables).expect("a world");
    let starts = scatter_rest_nodes(world.graph(), 14, 2);
    let mut people = Inhabitants::new(&world, starts.len(), InhabitantsConfig::default()).expect("room");
    let mut n = allocations(|| starts.iter().for_each(|&start| _ = people.spawn(start).expect("a start")));
    let (ids, mut kept) = (people.ids().to_vec(), Vec::new());
    for round in 0..20u32 {
        for &id in &ids {
            let goal = match id.index % 4 {
                0 => InhabitantGoal::Roam,
                3 => InhabitantGoal::GoNear { place: Vec3::new((round % 9) as f32 * 2.0, 1.0, 1.0), within_m: 4.0 },
                1 => InhabitantGoal::GoTo { instance: (7 * id.index + 11 * round) % 40 },
                _ => InhabitantGoal::Perform { tag: made_up::SIT, seconds: 4.0 },
            };
            n += allocations(|| people.order(id, goal).expect("a goal"));
        }
        n += allocations(|| (0..900).for_each(|_| people.step(1.0 / 30.0, &Inline).expect("a step")));
        // What is restored has the same room.
        kept.clear();
        people.save(&mut kept);
        people.load(&kept).expect("its own bytes");
    }
    let fulfilled: u32 = ids.iter().map(|id| people.state(*id).expect("there").num_fulfilled).sum();
    assert!(fulfilled > 40, "{fulfilled} goals are too few to prove anything");
    let back = people.characters().root(1);
    n += allocations(|| people.despawn(ids[0]).expect("there"));
    n += allocations(|| people.place(ids[1], back).expect("its own place is free"));
    assert_eq!(n, 0);
}

#[test]
fn sparring_and_practice_allocate_nothing() {
    let tables = common::boxing_tables();
    let mut sparring = common::sparring(&tables, 40).expect("pairs");
    sparring.step(0.0, &Inline).expect("a first step");
    let n = allocations(|| (0..600).for_each(|_| sparring.step(1.0 / 60.0, &Inline).expect("a step")));
    let blows = sparring.figures().blows;
    assert!(blows.landed + blows.blocked > 10, "{blows:?} are too few to prove anything");
    assert_eq!(n, 0);
    // One step that plays many segments.
    assert_eq!(allocations(|| sparring.step(1.0, &Inline).expect("a long step")), 0);
    // A pair leaves, and another one takes its place.
    let n = allocations(|| {
        sparring.despawn(sparring.bodies().ids[3]).expect("it is there");
        sparring.spawn([Spawn::standing_at(Planar::IDENTITY); 2]).expect("there is room");
    });
    assert_eq!(n, 0);

    let starts = common::pairs(&tables, 40).concat();
    let mut practice = TargetPractice::with_capacity(&tables, starts.len(), PracticeConfig::default()).expect("boxers");
    let mut enter = |start: Spawn| {
        let home = start.root.translation() + start.root.rotation() * HOME;
        practice.spawn(start).and_then(|id| practice.order(id, PolicyOrder::towards(0, home).with_policy(1, 1.0)))
    };
    let n = allocations(|| starts.iter().for_each(|start| enter(*start).expect("there is room")));
    assert_eq!(n, 0);
    let n = allocations(|| (0..600).for_each(|_| practice.step(1.0 / 60.0, &Inline).expect("a step")));
    assert!(practice.figures().blows.landed > 10, "{:?}", practice.figures().blows);
    assert_eq!(n, 0);
}

/// Boxers, pairs, walkers on paths, agents with bodies and agents without; without orders.
const SCENE: &str = r#"
bundle = "boxing.throng"
[[groups]]
motion = "policy"
count = 6
behaviours = [{ name = "approach" }]
target = { drag = [{ time_s = 1.0, x_m = 0.2 }, { time_s = 2.0 }] }
[[groups]]
motion = "sparring"
count = 20
place = { grid = { centre = [40.0, 0.0], spacing_m = 4.0, distance_m = 0.9 } }
behaviours = [{ name = "approach" }, { name = "throw-punches", weight = 2.0 }, { name = "evade" }]
[[groups]]
motion = "blend"
bundle = "GOLDEN"
count = 20
spaces = ["walks"]
paths = { area_m = 20.0 }
[[groups]]
motion = "blend"
bundle = "GOLDEN"
count = 20
spaces = ["walks", "walks"]
place = { block = { from = [-20.0, -8.0], to = [-12.0, 8.0] } }
goal = { shift = { by = [8.0, 0.0] } }
[[groups]]
motion = "none"
count = 20
place = { block = { from = [12.0, -8.0], to = [20.0, 8.0] } }
goal = { shift = { by = [-8.0, 0.0] } }
"#;

#[test]
fn a_simulation_allocates_nothing() {
    let golden = format!("data/golden/tables_v{}.throng", throng_core::format::VERSION);
    let golden = std::path::absolute(golden).expect("a path");
    let scene = Scene::parse(&SCENE.replace("GOLDEN", &golden.to_string_lossy()), "scene.toml".as_ref());
    let scene = scene.and_then(|s| s.compile(&common::boxing_tables())).expect("a scene");
    let mut sim = Simulation::new(&scene).expect("a simulation");
    let mut events = 0;
    let mut go_on = |sim: &mut Simulation| {
        allocations(|| {
            for _ in 0..300 {
                sim.step(1.0 / 60.0).expect("a step");
                events += sim.events().len();
            }
        })
    };
    assert_eq!(go_on(&mut sim), 0);
    // Nor does one that goes on from a snapshot.
    let bytes = sim.snapshot();
    sim.restore(&bytes).expect("its own state");
    assert_eq!(go_on(&mut sim), 0);
    assert!(events > 0, "a scene in which nothing happens proves little");
}

#[test]
fn batches_of_queries_allocate_nothing() {
    const N: usize = 256;
    let tables = common::tables();
    let table = &tables.policies()[0];
    let states: Vec<u32> = common::starts(&tables, N).iter().map(|s| s.state).collect();
    let targets = vec![Vec3::new(0.5, 0.0, 3.0); N];
    let weights = vec![1.0; N];
    let mut actions = vec![0u8; N];
    let mut ranked = vec![RankedActions::NONE; N];
    let goals = [policy::LookAheadGoal { policy: table, weights: &weights, targets: &targets }];
    let n = allocations(|| {
        for choice in 0..4 {
            BestActionJob { policy: table, states: &states, targets: &targets, choice, actions: &mut actions }
                .run()
                .expect("a batch");
        }
        LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run().expect("a batch");
    });
    assert_eq!(n, 0);
    assert!(ranked.iter().all(|r| r.scores[0].is_finite()));
}

#[test]
fn a_batch_of_poses_allocates_nothing() {
    let tables = common::tables();
    let motion_set = MotionSet::new(&tables);
    let frames: Vec<u32> = (0..333).collect();
    let ratios = vec![0.25; frames.len()];
    let mut matrices = vec![Mat3x4::default(); frames.len() * NUM_JOINTS];
    let job = SampleJob { motion_set: &motion_set, frames: &frames, ratios: &ratios, matrices: &mut matrices };
    assert_eq!(allocations(|| job.run().expect("a batch")), 0);
    assert!(matrices.iter().all(|m| *m != Mat3x4::default()));
}

#[test]
fn walkers_allocate_nothing() {
    const N: usize = 100;
    let made_up = made_up_blend::MadeUp::locomotion();
    let config = WalkersConfig { local_transforms: true, ..WalkersConfig::default() };
    let mut walkers = Walkers::with_capacity(made_up.space(), &[], config, N).expect("walkers");
    let ground = HeightField::new(Vec2::splat(-50.0), 10.0, [11, 11], vec![0.5; 121]).expect("a field");
    walkers.set_ground(ground);
    let mut ids = [Id::default(); N];
    let entered = allocations(|| {
        ids.fill_with(|| walkers.spawn(WalkerStart::default()).expect("room"));
    });
    assert_eq!(entered, 0);
    let mut before = walkers.joint_positions(7);
    for round in 0..10 {
        let n = allocations(|| {
            for (c, id) in ids.iter_mut().enumerate() {
                let velocity = Vec2::from_angle(c as f32) * (round % 6) as f32;
                walkers.order(*id, Control::walk(velocity)).expect("an order");
                if c % 9 == round {
                    walkers.despawn(*id).expect("a walker");
                    *id = walkers.spawn(WalkerStart::default()).expect("room");
                }
            }
            for _ in 0..30 {
                walkers.step(1.0 / 60.0, &Inline).expect("a step");
            }
        });
        assert_eq!(n, 0);
        assert_ne!(before, walkers.joint_positions(7), "no walker moves");
        before = walkers.joint_positions(7);
    }
}

#[test]
fn batches_of_blending_allocate_nothing() {
    const N: usize = 64;
    let made_up = made_up_blend::MadeUp::locomotion();
    let space = made_up.space();
    let parameters: Vec<[f32; MAX_AXES]> = (0..N).map(|i| [0.08 * i as f32; MAX_AXES]).collect();
    let mut weights = vec![0.0; N * space.stride()];
    let (mut phases, seconds) = (vec![0.3; N], vec![0.1; N]);
    let mut postures = vec![BlendedPosture::default(); N];
    let n = allocations(|| {
        space.weights(&parameters, &mut weights).expect("weights");
        space.advance(&weights, &seconds, &mut phases).expect("a tick");
        space.blend_postures(&weights, &phases, &mut postures).expect("postures");
    });
    assert_eq!(n, 0);
    assert!(postures.iter().all(|p| *p != BlendedPosture::default()));
}

#[test]
fn pedestrians_allocate_nothing_but_for_orders() {
    const N: usize = 40;
    let streets = Streets::new(&[], 0.4).expect("streets");
    let crowd = Crowd::on_ground(CrowdSetup::in_streets(&streets, N)).expect("a crowd");
    let space = made_up_blend::MadeUp::locomotion().space();
    let mut people = Pedestrians::new(crowd, space, &[], WalkersConfig::default()).expect("pedestrians");
    let (mut kept, mut num_left) = (Vec::new(), 0);
    for round in 0..3 {
        let spawn = |people: &mut Pedestrians| {
            let newcomers = (people.bodies().ids.len()..N).map(|i| Vec3::new((i % 8) as f32, 0.0, (i / 8) as f32));
            newcomers.filter(|at| people.spawn(Agent::standing_at(*at)).is_ok()).count()
        };
        let mut num_new = 0;
        assert_eq!(allocations(|| num_new = spawn(&mut people)), 0, "round {round}");
        assert!(num_new > 5, "round {round}: {num_new} enter");
        let ids = people.bodies().ids.to_vec();
        let (&idle, others) = ids.split_last().expect("people");
        for &id in others {
            people
                .order(id, AgentOrder::to_goal(Vec3::new(3.0, 0.0, 9.0)).with_arrival(3.0).then_at_end(AtEnd::Leave))
                .expect("a way");
        }
        let moved = allocations(|| {
            people.place(idle, Planar::new(-9.0 - round as f32, 5.0, 1.0)).expect("room");
            for _ in 0..400 {
                people.step(1.0 / 60.0, &Inline).expect("a step");
                num_left += people.events().len();
            }
            people.despawn(idle).expect("it stays there");
        });
        assert_eq!(moved, 0, "round {round}");
        kept.clear();
        people.save(&mut kept);
        people.load(&kept).expect("its own bytes");
    }
    assert!(num_left > N, "{num_left} events are too few to prove anything");
}

/// Agents that meet, arrive, leave, stay or go round, past a wall and an obstacle that moves.
fn busy_crowd(scheme: Scheme) -> CrowdSetup {
    let config = CrowdConfig { scheme, capacity: 210, ..CrowdConfig::default() };
    let mut setup = CrowdSetup { config, ..CrowdSetup::default() };
    for i in 0..200 {
        let position = Vec3::new((i % 20) as f32 * 0.7, 0.0, (i / 20) as f32 * 0.7);
        let at_end = [AtEnd::Stay, AtEnd::Leave, AtEnd::Again][i % 3];
        let subgoals =
            vec![position, Vec3::new(30.0 - position.x, 0.0, 5.0), Vec3::new(19.0 - position.x, 0.0, position.z)];
        setup.routes.push(Route { subgoals, arrival_radius: 0.5, at_end });
        setup.agents.push(Agent { position, route: Some(i), ..Agent::default() });
    }
    setup.obstacles = vec![
        Obstacle::Wall { from: Vec3::new(-2.0, 0.0, -1.0), to: Vec3::new(40.0, 0.0, -1.0), radius: 0.1 },
        Obstacle::Mover {
            path: vec![(0.0, Vec3::new(24.0, 0.0, 20.0)), (9.0, Vec3::new(24.0, 0.0, -5.0))],
            radius: 0.6,
        },
    ];
    setup
}

/// To look for a group's bundle took a message for the file and all its lines, at every step and for every group.
#[test]
fn twice_as_many_groups_allocate_twice_as_much() {
    let of = |num: usize| {
        let group = |i: usize| {
            let (x, z) = (3 * (i % 20), 3 * (i / 20));
            format!(
                "[[groups]]\nmotion = \"none\"\ncount = 1\nplace = {{ block = {{ from = [{x}.0, {z}.0], to = [{x}.5, {z}.5] }} }}\n\
                 goal = {{ shift = {{ by = [9.0, 0.0] }} }}\n\n"
            )
        };
        let text: String = (0..num).map(group).collect();
        let scene = Scene::parse(&text, Path::new("made-up.toml")).expect("a scene").open().expect("it names no files");
        let config = SceneRunConfig { seconds: Some(0.2), ..SceneRunConfig::default() };
        allocations(|| drop(run(&scene, &config).expect("it runs")))
    };
    let num = [40, 80, 160].map(of);
    assert!(num[2] - num[1] < 3 * (num[1] - num[0]), "40, 80 and 160 groups: {num:?} allocations");
}

#[test]
fn a_crowd_allocates_nothing_whatever_its_scheme() {
    for scheme in [Scheme::Registration, Scheme::Occupancy] {
        let mut crowd = Crowd::on_ground(busy_crowd(scheme)).expect("a crowd");
        let mut events = 0;
        for i in 1..=20 {
            let n = allocations(|| crowd.advance(f64::from(i), &mut |_| events += 1).expect("time passes"));
            assert_eq!(n, 0, "{scheme:?}, second {i}");
            let newcomer =
                Agent { position: Vec3::new(-5.0 - i as f32, 0.0, -9.0), route: Some(0), ..Agent::default() };
            assert_eq!(allocations(|| drop(crowd.spawn(newcomer))), 0, "{scheme:?}");
        }
        let c = crowd.counts();
        let is_busy = match scheme {
            Scheme::Registration => events > 2000 && c.colliding > 0,
            Scheme::Occupancy => events > 2000 && c.colliding > 0 && c.entering > 0 && c.contacting + c.leaving > 0,
        };
        assert!(is_busy, "{scheme:?}: {c:?}, {events} events are too few to prove anything");
    }
}
