//! Captured people on the way to goals: they find their way round walls, make way for each other, and never overlap.

use crate::common;
use glam::{Vec2, Vec3};
use throng_core::stops::BODY_RADIUS_M;
use throng_core::{Error, Inline};
use throng_precompute::cache::Cache;
use throng_precompute::graph::MakeMotion;
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_simulation::{AnyCharacterGroup, CharacterEvent, MotionKind, Order, Scene, Simulation};

/// A scene of people with a small bundle of walking.
fn people(text: &str) -> Result<Simulation, String> {
    people_with(common::bundle(), text)
}

fn people_with(bundle: &[u8], text: &str) -> Result<Simulation, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("walk.throng"), bundle).expect("a bundle");
    let text = format!("bundle = \"walk.throng\"\n{text}");
    let scene = Scene::parse(&text, &folder.path().join("people.toml")).map_err(|e| e.to_string())?;
    let compiled = scene.open().map_err(|e| e.to_string())?;
    Simulation::new(&compiled).map_err(|e| e.to_string())
}

fn group(count: usize, [from, to]: [[f32; 2]; 2], goal: &str) -> String {
    format!(
        "[[groups]]\nmotion = \"policy\"\ncount = {count}\nplace = {{ block = {{ from = {from:?}, to = {to:?} }} }}\n\
         goal = {{ {goal} }}\n"
    )
}

fn wall(from: [f32; 2], to: [f32; 2]) -> String {
    format!("[[environment.obstacles]]\nwall = {{ points = [{from:?}, {to:?}], radius_m = 0.1 }}\n")
}

/// Runs to a time; nobody comes nearer to another one or to a wall than bodies are wide. Returns those who arrived.
fn walk(sim: &mut Simulation, walls: &[[[f32; 2]; 2]], until_s: f64) -> usize {
    let mut arrived = 0;
    while sim.time_s() < until_s - 1e-9 {
        let next_s = sim.time_s() + 1.0 / 30.0;
        sim.step_to(next_s, &Inline).expect("it goes on");
        arrived += sim.events().iter().filter(|e| matches!(e.kind, CharacterEvent::Arrived)).count();
        let at: Vec<Vec2> = sim.roots().flatten().map(|r| Vec2::new(r.x, r.z)).collect();
        for (i, a) in at.iter().enumerate() {
            let others = at[..i].iter().map(|b| a.distance(*b)).fold(f32::INFINITY, f32::min);
            assert!(others > 2.0 * BODY_RADIUS_M - 2e-3, "{others} m from another one at {next_s} s");
            let gap = |[from, to]: &[[f32; 2]; 2]| {
                throng_geometry::distance_to_segment(*a, [Vec2::from(*from), Vec2::from(*to)]) - 0.1
            };
            let nearest = walls.iter().map(gap).fold(f32::INFINITY, f32::min);
            assert!(nearest > BODY_RADIUS_M - 2e-3, "{nearest} m from a wall at {next_s} s");
        }
    }
    arrived
}

#[test]
fn a_manner_that_the_motion_lacks_is_refused_by_name() {
    let text = group(2, [[-4.0, -7.0], [4.0, -3.0]], "shift = { by = [0.0, 10.0] }");
    let e = people(&text.replace("count", "manners = [\"merry\"]\ncount")).unwrap_err();
    assert!(e.contains("groups[0]") && e.contains("manner \"merry\""), "{e}");
}

#[test]
fn people_find_their_way_round_walls_and_through_doors() {
    let start = [[-4.0, -7.0], [4.0, -3.0]];
    let across = "shift = { by = [0.0, 10.0] }";
    let long = vec![[[-8.0, 0.0], [8.0, 0.0]]];
    let corner = vec![[[-6.0, 0.0], [6.0, 0.0]], [[6.0, 0.0], [6.0, -8.0]]];
    let door = vec![[[-12.0, 0.0], [-1.5, 0.0]], [[1.5, 0.0], [12.0, 0.0]]];
    for walls in [long, corner, door] {
        let solid: String = walls.iter().map(|[from, to]| wall(*from, *to)).collect();
        let mut sim = people(&(group(6, start, across) + &solid)).unwrap();
        let arrived = walk(&mut sim, &walls, 60.0);
        assert!(arrived >= 6, "{arrived} of 6 arrive: {walls:?}");
    }
}

/// Walls that leave a passage of a width along the x axis, 2 m long (m).
fn passage(width: f32) -> Vec<[[f32; 2]; 2]> {
    // Walls are 0.1 m thick to each side.
    let (side, end) = (0.5 * width + 0.1, 0.9);
    let beside = |z: f32| {
        let far = z.signum() * 10.0;
        [[[-end, z], [-end, far]], [[end, z], [end, far]], [[-end, z], [end, z]]]
    };
    [side, -side].into_iter().flat_map(beside).collect()
}

/// A scene of people who go to the other side of a passage from one side, or from both.
fn through(width: f32, count: usize, sides: usize, seed: u32) -> Result<Simulation, String> {
    let group =
        |x: [f32; 2], by: f32| group(count, [[x[0], -5.0], [x[1], 5.0]], &format!("shift = {{ by = [{by:.1}, 0.0] }}"));
    let groups = [group([-12.0, -3.0], 16.0), group([3.0, 12.0], -16.0)];
    let solid: String = passage(width).iter().map(|[from, to]| wall(*from, *to)).collect();
    people(&(format!("seed = {seed}\n") + &groups[..sides].concat() + &solid))
}

#[test]
fn a_person_alone_passes_a_gap_of_a_metre_as_on_free_ground() {
    for seed in 1..=12 {
        let mut sim = through(1.0, 1, 1, seed).unwrap();
        let start = sim.roots().flatten().next().expect("a person");
        let walls = passage(1.0);
        // By the gap, at nearly a metre a second.
        let [from, to] = [Vec2::new(start.x, start.z), Vec2::new(start.x + 16.0, start.z)];
        let free_s = f64::from(from.length() + to.length()) / 0.9;
        assert_eq!(walk(&mut sim, &walls, 1.5 * free_s + 2.0), 1, "seed {seed}, {free_s} s");
    }
}

#[test]
fn crowds_pass_gaps_one_after_the_other() {
    for (width, sides, until_s) in [(1.0, 1, 80.0), (1.8, 1, 60.0), (2.2, 2, 120.0)] {
        for seed in 1..=2 {
            let mut sim = through(width, 14, sides, seed).unwrap();
            let arrived = walk(&mut sim, &passage(width), until_s);
            assert!(arrived >= 14 * sides - 1, "{arrived} of {} pass {width} m, seed {seed}", 14 * sides);
        }
    }
}

#[test]
fn two_streams_pass_each_other() {
    let (left, right) = ([[-16.0, -4.0], [-8.0, 4.0]], [[8.0, -4.0], [16.0, 4.0]]);
    let walls = [[[-30.0, -5.0], [30.0, -5.0]], [[-30.0, 5.0], [30.0, 5.0]]];
    let solid: String = walls.iter().map(|[from, to]| wall(*from, *to)).collect();
    let text = group(16, left, "shift = { by = [24.0, 0.0] }") + &group(16, right, "shift = { by = [-24.0, 0.0] }");
    let mut sim = people(&(text + &solid)).unwrap();
    let arrived = walk(&mut sim, &walls, 60.0);
    assert!(arrived >= 31, "{arrived} of 32 arrive");
}

#[test]
fn people_go_on_from_a_snapshot_bit_by_bit_and_leave_at_their_goals() {
    let text = group(8, [[-4.0, -7.0], [4.0, -3.0]], "point = { at = [0.0, 6.0] }") + "at_end = \"leave\"\n";
    let mut sim = people(&text).unwrap();
    let mut other = people(&text).unwrap();
    walk(&mut sim, &[], 8.0);
    let kept = sim.snapshot();
    other.restore(&kept).unwrap();
    assert_eq!(other.snapshot(), kept);
    walk(&mut sim, &[], 40.0);
    walk(&mut other, &[], 40.0);
    assert_eq!(sim.snapshot(), other.snapshot());
    let left = sim.roots().filter(Option::is_none).count();
    assert!(left >= 7, "{left} of 8 have left");
    let AnyCharacterGroup::Travel(travellers) = &sim.character_groups()[0] else { panic!("no travellers") };
    assert_eq!((0..8).filter(|&n| travellers.root(n).is_none()).count(), left);
    for at in (0..kept.len()).step_by(kept.len() / 97) {
        let mut damaged = kept.clone();
        damaged[at] ^= 0x10;
        assert!(other.restore(&damaged).is_err(), "byte {at}");
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_key() {
    let refused = |text: &str| people(text).unwrap_err();
    let told = refused(&group(2, [[-1.0, -1.0], [-0.8, -0.8]], "stay = {}"));
    assert!(told.contains("groups[0]") && told.contains("enlarge `place`"), "{told}");
    let told = refused(
        &(group(1, [[-4.0, -4.0], [-3.0, -3.0]], "point = { at = [0.0, 0.0] }") + &wall([-1.0, 0.0], [1.0, 0.0])),
    );
    assert!(told.contains("groups[0]") && told.contains("environment.obstacles[0]"), "{told}");
    let told = refused(&group(1, [[0.0, 0.0], [1.0, 1.0]], "point = { at = [0.0] }"));
    assert!(told.contains("groups[0].goal.point.at"), "{told}");
}

#[test]
fn people_go_stop_turn_and_follow_as_they_are_ordered() {
    let text = group(4, [[-4.0, -9.0], [4.0, -5.0]], "shift = { by = [0.0, 9.0] }") + "at_end = \"leave\"\n";
    let mut sim = people(&format!("{text}{}", wall([0.0, -2.0], [9.0, -2.0]))).unwrap();
    let at = |sim: &Simulation, who| sim.root(who).map(|r| Vec2::new(r.x, r.z)).unwrap();
    let step = |sim: &mut Simulation, seconds: f64| {
        let mut arrived = Vec::new();
        for _ in 0..(seconds * 30.0) as usize {
            sim.step(1.0 / 30.0).unwrap();
            arrived.extend(sim.events().iter().filter(|e| e.kind == CharacterEvent::Arrived).map(|e| e.who));
        }
        arrived
    };
    step(&mut sim, 0.5);
    let goal = Vec2::new(6.0, 3.0);
    sim.order(0, Order::go(Vec3::new(goal.x, 0.0, goal.y)).arrive_facing(2.0)).unwrap();
    sim.order(1, Order::stop()).unwrap();
    sim.order(2, Order::follow(0)).unwrap();
    let arrived = step(&mut sim, 30.0);
    assert!(arrived.contains(&0) && at(&sim, 0).distance(goal) < 1.0, "at {}", at(&sim, 0));
    let facing = sim.root(0).unwrap().heading;
    assert!((facing - 2.0).sin().abs() < 0.3 && (facing - 2.0).cos() > 0.0, "faces {facing}");
    let far = at(&sim, 2).distance(at(&sim, 0));
    assert!((0.4..2.8).contains(&far), "follows at {far} m");
    assert!(sim.root(3).is_none(), "who has no order leaves");
    let stands = at(&sim, 1);
    sim.order(1, Order::turn_to(-1.0)).unwrap();
    step(&mut sim, 4.0);
    let turned = sim.root(1).unwrap().heading + 1.0;
    assert!(at(&sim, 1).distance(stands) < 0.5 && turned.sin().abs() < 0.3 && turned.cos() > 0.0, "{turned} rad off");
    assert!(matches!(sim.order(3, Order::stop()), Err(Error::Gone(_))));
    let told = sim.order(0, Order::stop().at_speed(-1.0)).unwrap_err().to_string();
    assert!(told.contains("speed_mps") && told.contains("0.01 to 100"), "{told}");
    // A snapshot in the middle of orders goes on bit by bit, in a simulation with others.
    sim.order(1, Order::go(Vec3::new(-6.0, 0.0, 4.0))).unwrap();
    step(&mut sim, 1.0);
    let kept = sim.snapshot();
    let mut other = people(&format!("{text}{}", wall([0.0, -2.0], [9.0, -2.0]))).unwrap();
    other.order(2, Order::go(Vec3::new(0.0, 0.0, -12.0))).unwrap();
    step(&mut other, 1.0);
    other.restore(&kept).unwrap();
    assert_eq!([&mut sim, &mut other].map(|sim| (step(sim, 5.0), sim.hash()))[0], (Vec::new(), other.hash()));
}

/// A bundle of clips that stand, walk and run straight on.
fn walks_and_runs() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("gaits.throng"));
    let config = SynthConfig::for_set(SynthSet::Locomotion);
    synth::write_set(SynthSet::Locomotion, &config, &clips).expect("synthetic clips can be written");
    let names = ["idle_neutral", "walk_neutral_v110_g00", "walk_neutral_v150_g00", "run_neutral_v320_g00"];
    let inputs = names.map(|name| clips.join(name).with_extension("bvh")).to_vec();
    let mut config = common::small_config(inputs);
    config.graph.make = MakeMotion::Missing;
    common::build(&config, &out, &Cache::disabled());
    std::fs::read(&out).expect("what was built can be read")
}

#[test]
fn captured_people_walk_and_run_as_they_are_ordered() {
    let bundle = walks_and_runs();
    let start = group(4, [[-8.0, -0.5], [8.0, 0.5]], "shift = { by = [0.0, 1.0] }");
    let walks = 0.9..1.9;
    // Speeds of steering end with it.
    for (steered, speed, expected) in [
        (false, None, walks.clone()),
        (false, Some(1.2), walks.clone()),
        (false, Some(4.0), 2.6..4.5),
        (true, None, walks),
    ] {
        let mut sim = people_with(&bundle, &start).unwrap();
        (0..90).for_each(|_| sim.step(1.0 / 30.0).unwrap());
        if steered {
            (0..4).for_each(|who| sim.order(who, Order::steer(Vec2::new(0.0, 4.0))).unwrap());
            (0..30).for_each(|_| sim.step(1.0 / 30.0).unwrap());
        }
        let at = |sim: &Simulation, who| sim.root(who).map(|r| Vec2::new(r.x, r.z)).unwrap();
        let starts = [0, 1, 2, 3].map(|who| at(&sim, who));
        let goals = starts.map(|at| at + Vec2::new(0.0, 24.0));
        for who in 0..4 {
            let order = Order::go(Vec3::new(goals[who].x, 0.0, goals[who].y));
            sim.order(who, speed.map_or(order, |speed| order.at_speed(speed))).unwrap();
        }
        let (mut ways, mut times, mut last) = ([0.0f32; 4], [0.0f32; 4], starts);
        for _ in 0..1200 {
            sim.step(1.0 / 30.0).unwrap();
            for who in 0..4 {
                let now = at(&sim, who);
                if now.distance(starts[who]) > 5.0 && now.distance(goals[who]) > 6.0 {
                    ways[who] += now.distance(last[who]);
                    times[who] += 1.0 / 30.0;
                }
                last[who] = now;
            }
        }
        for who in 0..4 {
            let (mean, far) = (ways[who] / times[who], last[who].distance(goals[who]));
            assert!(expected.contains(&mean) && ways[who] < 14.0 && far < 0.6, "{speed:?}: {mean} m/s, {far} m off");
        }
    }
}
