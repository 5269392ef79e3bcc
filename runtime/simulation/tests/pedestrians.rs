//! Promise: agents with bodies are one character group. Bodies are where their agents are, come and go with them, and are saved with
//! them.

use glam::{Vec2, Vec3};
use std::path::Path;
use throng_core::walkers::WalkersConfig;
use throng_core::{Bundle, CharacterGroup, Error, Executor, Id, Inline, Joint, OrderStatus, Planar, Skeleton};
use throng_crowd::{Agent, AgentOrder, AtEnd, Crowd, CrowdSetup, Obstacle, Streets};
use throng_simulation::{CharacterEvent, Pedestrians};

const DT: f32 = 1.0 / 60.0;
const CAPACITY: usize = 14;

fn ground(x: f32, z: f32) -> Vec3 {
    Vec3::new(x, 0.0, z)
}

/// The golden tables of the current version, which have a blend space.
fn golden() -> Bundle {
    let name = format!("../../data/golden/tables_v{}.throng", throng_core::format::VERSION);
    Bundle::open(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).expect("golden tables")
}

/// Nobody yet, in streets round a house and a closed yard.
fn empty(capacity: usize) -> Pedestrians {
    let house = Obstacle::Box { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 3.0, 3.0) };
    let corners = [ground(20.0, 20.0), ground(30.0, 20.0), ground(30.0, 30.0), ground(20.0, 30.0)];
    let wall = |i: usize| Obstacle::Wall { from: corners[i], to: corners[(i + 1) % 4], radius: 0.2 };
    let solids = [house, wall(0), wall(1), wall(2), wall(3)];
    let crowd = Crowd::on_ground(CrowdSetup::in_streets(&Streets::new(&solids, 0.4).unwrap(), capacity)).unwrap();
    let small = throng_simulation::wander::scaled_skeleton(&Skeleton::default(), 0.8, 1.0);
    Pedestrians::new(crowd, golden().blend("walks").unwrap(), &[Skeleton::default(), small], WalkersConfig::default())
        .unwrap()
}

/// Twelve people behind a house, who are sent to its other side and leave there, but for the first, which stays.
fn street() -> (Pedestrians, Vec<Id>) {
    let mut people = empty(CAPACITY);
    let spawn = |i: usize| {
        let id = people.spawn(Agent::standing_at(ground(i as f32 - 6.0, -6.0))).unwrap();
        let at_end = if i == 0 { AtEnd::Stay } else { AtEnd::Leave };
        people.order(id, AgentOrder::to_goal(ground(0.0, 7.0)).with_arrival(2.0).then_at_end(at_end)).unwrap();
        id
    };
    let ids = (0..12).map(spawn).collect();
    (people, ids)
}

fn step(people: &mut Pedestrians, steps: usize) {
    (0..steps).for_each(|_| people.step(DT, &Inline).unwrap());
}

/// Hash, roots and events after each of some steps.
type Seen = (u64, Vec<Planar>, Vec<(Id, CharacterEvent)>);

fn watch(people: &mut Pedestrians, steps: usize, run: &dyn Executor) -> Vec<Seen> {
    let step = |_| {
        people.step(DT, run).unwrap();
        let bodies = people.bodies();
        (people.hash(), bodies.roots.to_vec(), people.events().to_vec())
    };
    (0..steps).map(step).collect()
}

/// The first step after which two runs differ.
fn differ(a: &[Seen], b: &[Seen]) -> Option<usize> {
    (0..a.len().max(b.len())).find(|&k| a.get(k) != b.get(k))
}

/// Farthest that hips are from the centres of their discs (m).
fn farthest_hips(people: &Pedestrians) -> f32 {
    let crowd = people.crowd();
    let away = |&id: &Id| {
        let hips = people.bodies().get(id).unwrap().position(Joint::Hips);
        let centre = crowd.position(id, crowd.time_s()).expect("who has a body is there");
        Vec2::new(hips.x, hips.z).distance(Vec2::new(centre.x, centre.z))
    };
    people.bodies().ids.iter().map(away).fold(0.0, f32::max)
}

#[test]
fn bodies_stay_with_their_agents_and_leave_with_them() {
    let (mut people, ids) = street();
    assert!(
        matches!(people.status(ids[3]).unwrap(), OrderStatus::Going { left_m } if left_m > 13.0),
        "round the house"
    );
    let mut left = Vec::new();
    for _ in 0..2400 {
        step(&mut people, 1);
        let there: Vec<Id> = people.crowd().ids().collect();
        let mut bodies = people.bodies().ids.to_vec();
        bodies.sort_unstable();
        assert_eq!(bodies, there);
        assert!(farthest_hips(&people) < 0.3, "{} m", farthest_hips(&people));
        left.extend(people.events().iter().filter(|e| e.1 == CharacterEvent::Left).map(|e| e.0));
    }
    left.sort_unstable();
    assert_eq!((left, people.bodies().ids), (ids[1..].to_vec(), &ids[..1]));
    assert_eq!(people.status(ids[0]).unwrap(), OrderStatus::Arrived);
    assert!(matches!(people.status(ids[5]), Err(Error::Gone(who)) if who == ids[5]));
}

#[test]
fn bodies_face_the_way_and_have_the_size_of_their_place() {
    let (mut people, ids) = street();
    step(&mut people, 90);
    let bodies = people.bodies();
    let velocity = people.crowd().smooth_velocity(ids[4]).unwrap();
    let ahead = bodies.get(ids[4]).unwrap().root.rotation() * Vec3::Z;
    assert!(ahead.dot(velocity.normalize()) > 0.8, "{ahead} {velocity}");
    let [tall, small] = [0, 1].map(|i| bodies.get(ids[i]).unwrap().position(Joint::Head).y);
    assert!((small / tall - 0.8).abs() < 0.05, "{small} and {tall}");
}

#[test]
fn they_are_put_elsewhere_where_there_is_room() {
    let (mut people, ids) = street();
    step(&mut people, 30);
    let hash = people.hash();
    let beside = people.crowd().position(ids[1], people.crowd().time_s()).unwrap();
    for (x, z) in [(beside.x + 0.2, beside.z), (0.0, 0.0), (25.0, 25.0), (f32::NAN, 0.0)] {
        assert!(people.place(ids[0], Planar::new(x, z, 0.0)).is_err());
    }
    let taken = people.place(ids[0], Planar::new(beside.x, beside.z, 0.0)).unwrap_err();
    assert!(matches!(taken, Error::Occupied { who, .. } if who == ids[0]));
    let turned = people.place(ids[0], Planar::new(-8.0, 8.0, f32::INFINITY)).unwrap_err();
    assert!(matches!(turned, Error::Value { what: "heading", who: Some(who), .. } if who == ids[0]));
    assert_eq!(people.hash(), hash, "nothing has changed");
    let root = Planar::new(-8.0, 8.0, 1.0);
    people.place(ids[0], root).unwrap();
    assert_eq!(people.bodies().get(ids[0]).unwrap().root, root);
    step(&mut people, 300);
    assert!(farthest_hips(&people) < 0.3);
    assert!(matches!(people.status(ids[0]).unwrap(), OrderStatus::Going { .. } | OrderStatus::Arrived));
}

#[test]
fn impossible_orders_and_starts_are_told_with_the_id() {
    let (mut people, ids) = street();
    people.despawn(ids[3]).unwrap();
    let new = people.spawn(Agent::standing_at(ground(-9.0, 0.0))).unwrap();
    assert_eq!((new.index, new.generation), (ids[3].index, 1));
    let hash = people.hash();
    let unreachable = people.order(new, AgentOrder::to_goal(ground(25.0, 25.0))).unwrap_err();
    assert!(
        matches!(unreachable, Error::NoPath { who: Some(who), .. } if who == new),
        "into a closed yard: {unreachable}"
    );
    let through = people.order(new, AgentOrder::along_subgoals(vec![ground(0.0, 0.0)])).unwrap_err();
    assert!(matches!(through, Error::Occupied { who, .. } if who == new), "{through}");
    let fast = people.order(new, AgentOrder::to_goal(ground(5.0, 0.0)).at_speed(9.0)).unwrap_err();
    assert!(matches!(fast, Error::Value { what: "speed", who: Some(who), .. } if who == new), "{fast}");
    assert!(
        matches!(people.order(ids[3], AgentOrder::to_goal(ground(5.0, 0.0))), Err(Error::Gone(who)) if who == ids[3])
    );
    assert!(matches!(people.spawn(Agent::standing_at(ground(-9.2, 0.0))), Err(Error::Occupied { .. })));
    assert!(matches!(people.step(1.5, &Inline), Err(Error::Value { what: "dt_s", .. })));
    assert_eq!(people.hash(), hash, "nothing has changed");
    for x in [9.0, 11.0] {
        people.spawn(Agent::standing_at(ground(x, 0.0))).unwrap();
    }
    assert!(matches!(people.spawn(Agent::standing_at(ground(13.0, 0.0))), Err(Error::Full { capacity: CAPACITY })));
    people.despawn(ids[0]).unwrap();
    people.spawn(Agent::standing_at(ground(13.0, 0.0))).unwrap();
    let air =
        Crowd::in_air(CrowdSetup { agents: vec![Agent::standing_at(Vec3::ZERO)], ..CrowdSetup::default() }).unwrap();
    let flying = Pedestrians::new(air, golden().blend("walks").unwrap(), &[], WalkersConfig::default());
    assert!(matches!(flying, Err(Error::Value { got: 3.0, .. })));
}

#[test]
fn what_was_saved_is_replayed_bit_by_bit() {
    let (mut people, ids) = street();
    step(&mut people, 400);
    people.despawn(ids[2]).unwrap();
    // In the middle, while places are free and rows are out of order.
    let mut bytes = Vec::new();
    people.save(&mut bytes);
    let hash = people.hash();
    let later = watch(&mut people, 600, &Inline);
    assert!(later.iter().any(|seen| !seen.2.is_empty()), "somebody leaves");
    for mut other in [people.clone(), empty(CAPACITY)] {
        other.load(&bytes).unwrap();
        assert!(other.hash() == hash && other.events().is_empty());
        assert_eq!(differ(&watch(&mut other, 600, &Inline), &later), None);
    }
    for k in 0..200 {
        let at = bytes.len() * k / 200;
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (k % 8);
        for damaged in [&flipped[..], &bytes[..at]] {
            let before = people.hash();
            assert!(matches!(people.load(damaged), Err(Error::Snapshot { .. })), "byte {at}");
            assert_eq!(people.hash(), before);
        }
    }
    assert!(empty(CAPACITY + 1).load(&bytes).is_err(), "of another capacity");
}

#[test]
fn threads_change_nothing() {
    /// Each part on a thread of its own, the last one first.
    struct Threads;
    impl Executor for Threads {
        fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
            std::thread::scope(|scope| (0..num_parts).rev().for_each(|k| drop(scope.spawn(move || part(k)))));
        }
    }
    let mut people = empty(2400);
    for i in 0..2300 {
        let at = ground(40.0 + (i % 50) as f32, 40.0 + (i / 50) as f32);
        let id = people.spawn(Agent::standing_at(at)).unwrap();
        people
            .order(id, AgentOrder::along_subgoals(vec![at + ground(if i % 2 == 0 { 3.0 } else { -3.0 }, 2.0)]))
            .unwrap();
    }
    let mut others = people.clone();
    assert_eq!(differ(&watch(&mut people, 20, &Inline), &watch(&mut others, 20, &Threads)), None);
}

#[test]
fn bodies_go_on_with_another_bundle() {
    let (mut people, ids) = street();
    step(&mut people, 60);
    let adopted = people.adopt(&golden()).unwrap();
    assert_eq!(adopted.num_characters, ids.len());
    step(&mut people, 60);
    assert!(farthest_hips(&people) < 0.3);
}

/// No character group takes memory for a number that nobody can have meant.
#[test]
fn a_capacity_or_step_out_of_its_range_is_an_error() {
    use throng_core::characters::{Characters, MotionSet, PolicyCharacters};
    use throng_core::walkers::Walkers;
    use throng_crowd::CrowdConfig;
    use throng_simulation::sparring::{Sparring, TargetPractice};
    let (golden, boxing) = (golden(), throng_core::characters::made_up::tables_with(&[]));
    for capacity in [usize::MAX, usize::MAX / 2 + 2, 1 << 40, 1_000_001] {
        let config = CrowdConfig { capacity, largest_radius_m: 0.3, largest_speed_mps: 2.0, ..CrowdConfig::default() };
        let setup = || CrowdSetup { config, ..CrowdSetup::default() };
        let refused: [String; 7] = [
            Characters::with_capacity(&MotionSet::new(&boxing), Default::default(), capacity).map(|_| ()).unwrap_err(),
            PolicyCharacters::with_capacity(&boxing, capacity, Default::default()).map(|_| ()).unwrap_err(),
            Walkers::with_capacity(golden.blend("walks").unwrap(), &[], WalkersConfig::default(), capacity)
                .map(|_| ())
                .unwrap_err(),
            Sparring::with_capacity(&boxing, capacity, Default::default()).map(|_| ()).unwrap_err(),
            TargetPractice::with_capacity(&boxing, capacity, Default::default()).map(|_| ()).unwrap_err(),
            Crowd::on_ground(setup()).map(|_| ()).map_err(Error::from).unwrap_err(),
            Crowd::in_air(setup()).map(|_| ()).map_err(Error::from).unwrap_err(),
        ]
        .map(|e: Error| e.to_string());
        for e in refused {
            assert!(e.contains("capacity") && e.contains("0 to 1000000"), "{capacity}: {e}");
        }
    }
    let mut people = empty(2);
    for dt_s in [-1.0, 1.1, f32::NAN, f32::INFINITY] {
        let e = people.step(dt_s, &Inline).unwrap_err().to_string();
        assert!(e.contains("dt_s") && e.contains("0 to 1 s"), "{e}");
    }
}
