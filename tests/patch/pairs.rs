//! Two people on one motion: they come together, play their capture in step where it has them, and part.

use super::inhabitants::open;
use super::made_up_world::{GIVE, SIDE, SIT};
use glam::Vec2;
use throng_core::base::ground::ReservedRegion;
use throng_core::characters::CharactersConfig;
use throng_core::planar::wrap_angle;
use throng_core::{CharacterGroup, Error, Id, Inline, NUM_JOINTS, Planar, Rayon};
use throng_geometry::Capsule2d;
use throng_world::inhabitants::{
    InhabitantActivity, InhabitantEvent, InhabitantGoal, Inhabitants, InhabitantsConfig, scatter_rest_nodes,
};
use throng_world::{World, WorldNode};

const DT: f32 = 1.0 / 60.0;
const PLAIN: [&str; 4] = ["####"; 4];
/// First frames of the two captures, and their length: after all that comes before them in the made-up bundle.
const GIVEN: [u32; 2] = [341, 402];
const FRAMES: u32 = 60;

fn people(world: &World, seed: u64, num: usize) -> Inhabitants {
    let characters = CharactersConfig { seed, ..CharactersConfig::default() };
    let mut people =
        Inhabitants::new(world, num, InhabitantsConfig { characters, ..Default::default() }).expect("room");
    scatter_rest_nodes(world.graph(), num, seed)
        .into_iter()
        .for_each(|start: WorldNode| _ = people.spawn(start).expect("a start"));
    people
}

fn saved(people: &Inhabitants) -> Vec<u8> {
    let mut out = Vec::new();
    people.save(&mut out);
    out
}

/// The frame of the captures that a character plays, and which of the two.
fn captured(people: &Inhabitants, c: usize) -> Option<(usize, f32)> {
    let (first, frames) = people.characters().scheduled_clip(c);
    (0..2).find(|&k| first == GIVEN[k]).map(|k| (k, frames))
}

/// Where the made-up capture has the two at a frame: they lean towards each other and back.
fn in_capture(side: usize, frame: f32) -> Planar {
    let there = (std::f32::consts::PI * frame / FRAMES as f32).sin().powi(2);
    match side {
        0 => Planar::new(0.0, 0.2 * there, 0.0),
        _ => Planar::new(0.0, SIDE - 0.3 * there, std::f32::consts::PI),
    }
}

/// Steps until two have begun, and returns after how many.
fn until_begun(people: &mut Inhabitants, two: [Id; 2]) -> usize {
    for step in 0..6000 {
        people.step(DT, &Inline).unwrap();
        if people.events().iter().any(|(id, e)| *id == two[0] && matches!(e, InhabitantEvent::Began { .. })) {
            let other = people.events().iter().find(|(id, _)| *id == two[1]).map(|e| e.1);
            assert_eq!(other, Some(InhabitantEvent::Began { with: two[0] }), "both begin in one step");
            return step;
        }
    }
    panic!("they never began: {:?} {:?}", people.state(two[0]), people.state(two[1]));
}

#[test]
fn two_are_to_each_other_as_in_capture_at_every_step_of_what_they_do_together() {
    let world = open(&PLAIN);
    for seed in 1..8 {
        let mut people = people(&world, seed, 6);
        let two = [Id::first(0), Id::first(1 + seed as usize % 5)];
        people.order_meeting(two, GIVE, 3.0).unwrap();
        until_begun(&mut people, two);
        let rows = two.map(|id| id.index as usize);
        let (mut worst, mut compared, mut entry) = (0.0f32, 0, 0);
        for _ in 0..2000 {
            people.step(DT, &Inline).unwrap();
            if people.state(two[0]).unwrap().num_fulfilled > 0 {
                break;
            }
            let Some([(a, at), (b, other)]) =
                rows.map(|c| captured(&people, c)).into_iter().collect::<Option<Vec<_>>>().map(|v| [v[0], v[1]])
            else {
                continue;
            };
            assert_eq!((a + b, at.to_bits()), (1, other.to_bits()), "they play both sides in step");
            if compared == 0 && at < 15.0 {
                entry += 1;
                continue;
            }
            let roots = rows.map(|c| people.characters().root(c));
            let is = roots[0].to_local(roots[1]);
            let wanted = in_capture(a, at).to_local(in_capture(b, at));
            let off = (is.x - wanted.x).hypot(is.z - wanted.z) + wrap_angle(is.heading - wanted.heading).abs();
            // Frames are interpolated between rows.
            assert!(off < 2e-3, "seed {seed}, frame {at}: {off}");
            worst = worst.max(off);
            compared += 1;
        }
        assert!(entry <= 32, "within half a second, not after {entry} steps");
        assert!(compared > 150, "two rounds are more than 3 s: {compared} steps");
        let done = two.map(|id| people.state(id).unwrap());
        assert!(done.iter().all(|s| s.num_fulfilled == 1 && s.activity == InhabitantActivity::Arrived), "{done:?}");
        assert!(people.meeting_state(two[0]).unwrap().is_none());
    }
}

#[test]
fn who_has_done_something_together_goes_on_soon() {
    let world = open(&PLAIN);
    for seed in 1..8 {
        let mut people = people(&world, seed, 2);
        let two = [Id::first(0), Id::first(1)];
        people.order_meeting(two, GIVE, 1.0).unwrap();
        until_begun(&mut people, two);
        let is_done = |people: &Inhabitants| two.iter().all(|id| people.state(*id).unwrap().num_fulfilled > 0);
        while !is_done(&people) {
            people.step(DT, &Inline).unwrap();
        }
        two.iter().for_each(|&id| people.order(id, InhabitantGoal::Roam).unwrap());
        let plays = |people: &Inhabitants| two.map(|id| people.characters().scheduled_clip(id.index as usize).0);
        let (rests, mut goes) = (plays(&people), [None; 2]);
        for step in 1..120 {
            people.step(DT, &Inline).unwrap();
            for (k, now) in plays(&people).into_iter().enumerate().filter(|(k, now)| *now != rests[*k]) {
                assert_ne!(now, GIVEN[k]);
                goes[k] = goes[k].or(Some(step as f32 * DT));
            }
        }
        // A rest of the made-up bundle takes 1 s.
        assert!(goes.iter().all(|s| s.is_some_and(|s| (0.15..0.6).contains(&s))), "seed {seed}: {goes:?}");
    }
}

#[test]
fn two_who_are_near_but_far_to_walk_meet_halfway() {
    let world = open(&["#.#", "#.#", "#.#", "#.#", "###"]);
    let mut people = Inhabitants::new(&world, 2, InhabitantsConfig::default()).expect("room");
    let at = |x: f32| world.view().instances.iter().position(|i| i.placement.x == x && i.placement.z == 0.0);
    for x in [0.0, 2.0 * SIDE] {
        let tile = at(x).expect("a tile there") as u32;
        people.spawn(world.graph().rest_cells(tile).next().expect("a place to stand")).expect("a start");
    }
    let two = [Id::first(0), Id::first(1)];
    people.order_meeting(two, GIVE, 1.0).unwrap();
    let seconds = until_begun(&mut people, two) as f32 * DT;
    assert!(seconds < 20.0, "begun after {seconds} s");
}

#[test]
fn everyone_holds_ground_of_their_own_while_two_do_something_together() {
    let world = open(&PLAIN);
    let mut people = people(&world, 3, 8);
    let (mut begun, mut fulfilled) = (0, 0);
    for step in 0..12_000 {
        for k in 0..4 {
            let two = [Id::first(2 * k), Id::first(2 * k + 1)];
            let is_free = |id: Id| {
                people
                    .state(id)
                    .is_ok_and(|s| s.activity == InhabitantActivity::Arrived || s.goal == InhabitantGoal::Roam)
            };
            if step % 50 == 0 && two.into_iter().all(is_free) {
                // All places may be taken.
                let told = people.order_meeting(two, GIVE, 1.0);
                assert!(matches!(told, Ok(()) | Err(Error::Occupied { .. })), "{told:?}");
            }
        }
        people.step(DT, &Inline).unwrap();
        for c in 0..8 {
            let root = people.characters().root(c);
            let units = world.view().units.iter().enumerate();
            let inside = |a: f32, b: f32| (a - b).abs() < SIDE * 0.5 - 0.1;
            for (unit, _) in units.filter(|(_, u)| inside(root.x, u.placement.x) && inside(root.z, u.placement.z)) {
                assert_eq!(people.holder(unit as u32), Some(Id::first(c)), "step {step}, character {c}");
            }
            let plays = captured(&people, c).is_some();
            let meets = people.meeting_state(Id::first(c)).unwrap().is_some();
            assert!(
                !plays || meets || people.state(Id::first(c)).unwrap().activity == InhabitantActivity::Arrived,
                "nobody does it alone"
            );
        }
        begun += people.events().iter().filter(|(_, e)| matches!(e, InhabitantEvent::Began { .. })).count();
        fulfilled += people.events().iter().filter(|(_, e)| *e == InhabitantEvent::Fulfilled).count();
    }
    assert!(begun > 40 && fulfilled + 8 >= begun, "{begun} begun, {fulfilled} fulfilled");
}

#[test]
fn two_who_are_loaded_in_the_middle_go_on_as_if_nothing_had_happened() {
    let world = open(&PLAIN);
    let mut people = people(&world, 5, 5);
    let two = [Id::first(1), Id::first(4)];
    people.order_meeting(two, GIVE, 4.0).unwrap();
    until_begun(&mut people, two);
    // In the entry, right after it, in the middle, and in the second round; on the way before.
    for steps in [1, 20, 25, 80, 60] {
        (0..steps).for_each(|_| people.step(DT, &Inline).unwrap());
        let (bytes, mut other) = (saved(&people), people.clone());
        other.order(two[0], InhabitantGoal::Roam).unwrap();
        (0..30).for_each(|_| other.step(DT, &Rayon).unwrap());
        other.load(&bytes).unwrap();
        assert_eq!(other.hash(), people.hash());
        let mut fresh = Inhabitants::new(&world, 5, *people_config(5)).unwrap();
        fresh.load(&bytes).unwrap();
        let mut on = people.clone();
        for _ in 0..200 {
            [&mut other, &mut fresh, &mut on].into_iter().for_each(|p| p.step(DT, &Inline).unwrap());
            assert_eq!([other.hash(), fresh.hash()], [on.hash(); 2]);
            assert_eq!([other.events(), fresh.events()], [on.events(); 2]);
        }
    }
}

fn people_config(seed: u64) -> Box<InhabitantsConfig> {
    let characters = CharactersConfig { seed, ..CharactersConfig::default() };
    Box::new(InhabitantsConfig { characters, ..Default::default() })
}

#[test]
fn who_is_told_something_else_leaves_without_a_jump_and_frees_the_other() {
    let world = open(&PLAIN);
    for (seed, after) in (1..9).zip([3, 20, 31, 40, 60, 75, 100, 119]) {
        let mut people = people(&world, seed, 4);
        let two = [Id::first(0), Id::first(2)];
        people.order_meeting(two, GIVE, 30.0).unwrap();
        until_begun(&mut people, two);
        (0..after).for_each(|_| people.step(DT, &Inline).unwrap());
        people.order(two[0], InhabitantGoal::Roam).unwrap();
        let mut before: Vec<_> = (0..4).map(|c| people.characters().joint_positions(c)).collect();
        let (mut told, mut left) = (Vec::new(), [None; 2]);
        for step in 0..400 {
            people.step(DT, &Inline).unwrap();
            told.extend(people.events().iter().filter(|e| e.1 == InhabitantEvent::BrokenOff).map(|e| e.0));
            for c in 0..4 {
                let now = people.characters().joint_positions(c);
                for j in 0..NUM_JOINTS {
                    let speed = (now[j] - before[c][j]).length() / DT;
                    assert!(speed < 8.0, "seed {seed}, step {step}, character {c}, joint {j}: {speed} m/s");
                }
                before[c] = now;
            }
            for (k, id) in two.into_iter().enumerate() {
                if left[k].is_none() && captured(&people, id.index as usize).is_none() {
                    left[k] = Some(step);
                }
            }
        }
        told.sort_by_key(|id| id.index);
        assert_eq!(told, two, "both are told once");
        assert_eq!(people.state(two[1]).unwrap().activity, InhabitantActivity::Arrived);
        // One round is 2 s: nobody plays it to the end if it stands near its place before.
        let last = left.map(|l| l.expect("both leave it"));
        assert!(last.iter().all(|&l| l <= 122), "{last:?}");
        if after < 10 {
            assert!(last.iter().all(|&l| l < 40), "they stand at their places: {last:?}");
        }
    }
}

#[test]
fn who_is_held_up_gives_up_after_a_minute_and_twice_the_way() {
    let world = open(&["####################"]);
    let begin = |apart: usize| {
        let mut people = Inhabitants::new(&world, 2, InhabitantsConfig::default()).expect("room");
        let mut rests: Vec<WorldNode> =
            (0..world.graph().num_instances() as u32).filter_map(|i| world.graph().rest_cells(i).next()).collect();
        rests.sort_by(|a, b| world.graph().place(*a).x.total_cmp(&world.graph().place(*b).x));
        [0, apart].into_iter().for_each(|k| _ = people.spawn(rests[k]).expect("a start"));
        let two = [Id::first(0), Id::first(1)];
        people.order_meeting(two, GIVE, 3.0).unwrap();
        (people, two)
    };
    for apart in [2, 9, 19] {
        let (mut free, two) = begin(apart);
        let walk_s = DT * until_begun(&mut free, two) as f32;
        // Everybody is on ground that others reserve, so nobody takes a step.
        let (mut held, _) = begin(apart);
        let everywhere = Capsule2d { from: Vec2::new(-50.0, 0.0), to: Vec2::new(100.0, 0.0), radius_m: 50.0 };
        let others = [ReservedRegion { bodies: Vec::new(), ground: vec![everywhere] }];
        let mut gave_up_s = None;
        for step in 1..12_000 {
            held.set_external_obstacles(others.iter());
            held.step(DT, &Inline).unwrap();
            if held.events().contains(&(two[0], InhabitantEvent::GaveUp)) {
                gave_up_s = Some(DT * step as f32);
                break;
            }
        }
        let waited_s = gave_up_s.expect("nobody comes") - 60.0;
        // The way, as it was walked, has a second or two of rest, and two begin where what they play ends.
        assert!(
            (2.0 * walk_s - 8.0..2.0 * walk_s + 0.1).contains(&waited_s),
            "{apart} tiles: {waited_s} s, way {walk_s} s"
        );
    }
}

#[test]
fn who_vanishes_or_is_put_elsewhere_frees_the_other() {
    let world = open(&PLAIN);
    let mut people = people(&world, 2, 3);
    let two = [Id::first(0), Id::first(1)];
    people.order_meeting(two, GIVE, 30.0).unwrap();
    people.place(two[0], people.characters().root(0)).unwrap();
    people.step(DT, &Inline).unwrap();
    let gave_up = |id: Id| (id, InhabitantEvent::GaveUp);
    assert!(two.iter().all(|&id| people.events().contains(&gave_up(id))), "{:?}", people.events());
    // Nobody does it alone.
    let num_fulfilled = |people: &Inhabitants| two.map(|id| people.state(id).unwrap().num_fulfilled);
    let before = num_fulfilled(&people);
    (0..900).for_each(|_| people.step(DT, &Inline).unwrap());
    assert_eq!(num_fulfilled(&people), before);
    people.order_meeting(two, GIVE, 30.0).unwrap();
    until_begun(&mut people, two);
    people.despawn(two[0]).unwrap();
    people.step(DT, &Inline).unwrap();
    assert_eq!(people.events(), [(two[1], InhabitantEvent::BrokenOff)]);
    assert!(people.meeting_state(two[1]).unwrap().is_none() && people.meeting_state(two[0]).is_err());
    (0..300).for_each(|_| people.step(DT, &Inline).unwrap());
}

#[test]
fn what_two_cannot_do_is_refused_and_changes_nothing() {
    let world = open(&PLAIN);
    let mut people = people(&world, 2, 3);
    let before = people.hash();
    let ids = [Id::first(0), Id::first(1)];
    let value = |told: Result<(), Error>, what: &str| match told {
        Err(Error::Value { what: w, .. }) => assert_eq!(w, what),
        other => panic!("{what}: {other:?}"),
    };
    value(people.order_meeting([ids[0]; 2], GIVE, 1.0), "other");
    value(people.order_meeting(ids, SIT, 1.0), "tag");
    value(people.order_meeting(ids, GIVE, f32::NAN), "seconds");
    value(people.order(ids[0], InhabitantGoal::Meet { tag: GIVE, seconds: 1.0 }), "goal");
    value(people.order(ids[0], InhabitantGoal::Perform { tag: GIVE, seconds: 1.0 }), "tag");
    assert!(people.order_meeting([ids[0], Id::first(7)], GIVE, 1.0).is_err());
    assert_eq!(people.hash(), before);
    // One tile alone has no edge to another.
    assert!(!Inhabitants::new(&open(&["###"]), 1, InhabitantsConfig::default()).unwrap().offers_pair(SIT));
}
