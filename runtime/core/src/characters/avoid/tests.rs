use crate::Bundle;
use crate::body::HeightField;
use crate::character_group::CharacterGroup;
use crate::characters::made_up::{bent_tables, bytes, tables};
use crate::characters::tests::TwoThreads;
use crate::characters::{
    ActionChoice, AvoidConfig, CharactersConfig, PolicyCharacters, PolicyOrder, Spawn, uniform_random,
};
use crate::format::{AlignedBytes, FormatError, FrameRow};
use crate::planar::Planar;
use crate::skeleton::Joint;
use crate::stops::SweepNode;
use glam::{Vec2, Vec3};
use proptest::prelude::*;
use throng_base::{Error, Executor, Id, Inline};
use throng_geometry::Capsule2d;

/// Radius of every character's disc in the made-up bundle (m).
const RADIUS_M: f32 = 0.3;

fn config(choice: ActionChoice) -> CharactersConfig {
    CharactersConfig { avoid: Some(AvoidConfig::default()), choice, ..CharactersConfig::default() }
}

/// Characters at the starts that have room, among those asked for.
fn character_group_of(starts: &[(f32, f32, f32, u32)], config: CharactersConfig) -> PolicyCharacters {
    let mut group = PolicyCharacters::with_capacity(&bent_tables(&[]), starts.len(), config).unwrap();
    for &(x, z, heading, state) in starts {
        match group.spawn(Spawn { root: Planar::new(x, z, heading), state: Some(state), floor_m: 0.0 }) {
            Ok(_) | Err(Error::Occupied { .. }) => {}
            Err(e) => panic!("{e}"),
        }
    }
    group
}

fn places(group: &PolicyCharacters) -> Vec<Vec2> {
    group.bodies().roots.iter().map(|r| Vec2::new(r.x, r.z)).collect()
}

/// Floors that are 3 m above each other, as heights by z at the knots of a grid.
fn floors(heights_at: impl Fn(f32) -> Vec<f32>) -> HeightField {
    let heights = |k: usize| heights_at((k / 2) as f32 * 0.25 - 10.0);
    HeightField::with_floors(Vec2::splat(-10.0), 0.25, [2, 81], (0..2 * 81).map(heights).collect()).unwrap()
}

#[test]
fn who_walks_up_a_ramp_comes_to_be_above_others() {
    // Up from z = -7 to -1; beyond, the upper floor lies over the lower one.
    let ramp = |z: f32| (0.5 * (z + 7.0)).clamp(0.0, 3.0);
    let above_and_below = |z: f32| match ramp(z) {
        height if height > 2.0 => vec![0.0, height],
        height => vec![height],
    };
    let mut group = PolicyCharacters::with_capacity(&bent_tables(&[]), 2, config(ActionChoice::BestAction)).unwrap();
    group.set_ground(floors(above_and_below));
    let spawn = |group: &mut PolicyCharacters, at: Vec2| {
        let root = Planar::new(at.x, at.y, 0.0);
        let id = group.spawn(Spawn { root, state: Some(0), floor_m: 0.0 }).unwrap();
        group.order(id, PolicyOrder::towards(0, Vec3::new(0.0, 0.0, 8.0))).unwrap();
        id
    };
    let climber = spawn(&mut group, Vec2::new(0.0, -8.0));
    let hips = |group: &PolicyCharacters| group.bodies().get(climber).unwrap().world(Joint::Hips).w_axis.y;
    let mut seen: Vec<(f32, f32)> = Vec::new();
    while seen.last().is_none_or(|(z, _)| *z < 1.0) {
        group.step(1.0 / 30.0, &Inline).unwrap();
        assert_on_paths(&group);
        seen.push((places(&group)[0].y, hips(&group)));
        assert!(seen.len() < 9000, "it comes nowhere: {:?}", seen.last());
    }
    let [low, high] = [&seen[..9], &seen[seen.len() - 9..]].map(|part| part.iter().map(|s| s.1).sum::<f32>() / 9.0);
    assert!((high - low - 3.0).abs() < 0.1, "from {low} m to {high} m");
    let steepest = seen.windows(2).map(|w| (w[1].1 - w[0].1).abs()).fold(0.0, f32::max);
    assert!(steepest < 0.1, "{steepest} m in a thirtieth of a second");
    // Somebody comes below it.
    let at = places(&group)[0];
    spawn(&mut group, at);
    assert!(least_room(&places(&group)) < 0.0);
}

/// Smallest gap between the discs of any two characters (m).
fn least_room(places: &[Vec2]) -> f32 {
    let pairs = places.iter().enumerate().flat_map(|(i, a)| places[..i].iter().map(|b| a.distance(*b)));
    pairs.fold(f32::INFINITY, f32::min) - 2.0 * RADIUS_M
}

/// Asserts that every character is on its reserved path.
fn assert_on_paths(group: &PolicyCharacters) {
    let book = group.characters().reservations().expect("they make way");
    for (at, place) in places(group).iter().enumerate() {
        let reserved = book.path(at).position_now();
        assert!(place.distance(reserved) < 0.012, "character {at} is at {place}, its path at {reserved}");
    }
}

fn starts() -> impl Strategy<Value = Vec<(f32, f32, f32, u32)>> {
    proptest::collection::vec((-2.5f32..2.5, -2.5f32..2.5, -3.0f32..3.0, 0u32..4), 2..14)
}

fn choices() -> impl Strategy<Value = ActionChoice> {
    prop_oneof![
        Just(ActionChoice::BestAction),
        (0.0f32..2.0).prop_map(|temperature| ActionChoice::LookAhead { temperature })
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Under any orders and steps, no two discs ever overlap, and all are where their paths say.
    #[test]
    fn nobody_ever_walks_through_anybody(
        starts in starts(), choice in choices(),
        steps in proptest::collection::vec((0.001f32..0.25, -4.0f32..4.0, -4.0f32..4.0, any::<u8>()), 40..160),
    ) {
        let mut group = character_group_of(&starts, config(choice));
        let ids: Vec<Id> = group.ids().to_vec();
        for (k, (dt_s, x, z, what)) in steps.into_iter().enumerate() {
            let id = ids[usize::from(what) % ids.len()];
            // Goals in others, segments at once, places anywhere.
            match what / 32 {
                0 | 1 => group.order(id, PolicyOrder::towards(0, Vec3::new(x, 0.0, z))).unwrap(),
                2 => {
                    let other = group.bodies().roots[usize::from(what) / 3 % ids.len()];
                    group.order(id, PolicyOrder::towards(0, Vec3::new(other.x, 0.0, other.z))).unwrap();
                }
                3 => drop(group.play_segment(id, u32::from(what) % 4)),
                4 => drop(group.place(id, Planar::new(x, z, x))),
                _ => {}
            }
            // Many short steps look between.
            let parts = 1 + k % 3;
            for _ in 0..parts {
                group.step(dt_s / parts as f32, &Inline).unwrap();
                assert_on_paths(&group);
                let room = least_room(&places(&group));
                prop_assert!(room > -1e-3, "{} m in each other", -room);
            }
        }
    }

    #[test]
    fn walls_are_not_walked_through(
        starts in starts(), ends in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0], target in [-5.0f32..5.0, -5.0f32..5.0],
    ) {
        let wall = Capsule2d { from: Vec2::new(ends[0], ends[1]), to: Vec2::new(ends[2], ends[3]), radius_m: 0.05 };
        let gap = |p: Vec2| {
            let offset = wall.to - wall.from;
            let share = ((p - wall.from).dot(offset) / offset.length_squared().max(1e-9)).clamp(0.0, 1.0);
            p.distance(wall.from + offset * share) - wall.radius_m - RADIUS_M
        };
        let mut group = PolicyCharacters::with_capacity(&bent_tables(&[]), starts.len(), config(ActionChoice::BestAction)).unwrap();
        group.set_walls(&[wall]);
        for (x, z, heading, state) in starts {
            if let Ok(id) = group.spawn(Spawn { root: Planar::new(x, z, heading), state: Some(state), floor_m: 0.0 }) {
                group.order(id, PolicyOrder::towards(0, Vec3::new(target[0], 0.0, target[1]))).unwrap();
            }
        }
        for step in 0..200 {
            group.step(1.0 / 30.0, &Inline).unwrap();
            if step == 90 {
                group.adopt(&tables()).unwrap();
            }
            let room = places(&group).into_iter().map(gap).fold(f32::INFINITY, f32::min);
            prop_assert!(room > -1e-3, "{} m in the wall at step {step}", -room);
        }
    }

    /// Who is above others walks as they do, whatever both do below each other; on one floor nobody meets anybody.
    #[test]
    fn floors_above_each_other_are_two_places(
        starts in starts(), target in [-3.0f32..3.0, 3.0f32..7.0],
    ) {
        let mut group = PolicyCharacters::with_capacity(&bent_tables(&[]), 2 * starts.len(), config(ActionChoice::BestAction)).unwrap();
        group.set_ground(floors(|_| vec![3.0, 0.0]));
        let mut pairs = Vec::new();
        for (x, z, heading, state) in starts {
            let start = |floor_m| Spawn { root: Planar::new(x, z + 4.0, heading), state: Some(state), floor_m };
            if let Ok(lower) = group.spawn(start(0.0)) {
                let upper = group.spawn(start(3.0)).expect("free where the floor below is");
                pairs.push([lower, upper]);
            }
        }
        pairs.iter().flatten().for_each(|&id| group.order(id, PolicyOrder::towards(0, Vec3::new(target[0], 0.0, target[1]))).unwrap());
        for _ in 0..150 {
            group.step(1.0 / 30.0, &Inline).unwrap();
            let rows = |side: usize| pairs.iter().map(|p| group.row(p[side]).unwrap()).collect::<Vec<_>>();
            let all = places(&group);
            let [lower, upper] = [0, 1].map(|side| rows(side).into_iter().map(|row| all[row]).collect::<Vec<_>>());
            prop_assert_eq!(&lower, &upper);
            prop_assert!(least_room(&lower) > -1e-3, "{} m in each other", -least_room(&lower));
        }
    }

    #[test]
    fn those_who_come_later_leave_those_who_walk_as_they_are(
        starts in starts(), before in 1usize..80, target in [-5.0f32..5.0, -5.0f32..5.0],
    ) {
        let config = config(ActionChoice::BestAction);
        let mut group = PolicyCharacters::with_capacity(&bent_tables(&[]), starts.len() + 1, config).unwrap();
        for (x, z, heading, state) in starts {
            if let Ok(id) = group.spawn(Spawn { root: Planar::new(x, z, heading), state: Some(state), floor_m: 0.0 }) {
                group.order(id, PolicyOrder::towards(0, Vec3::new(target[0], 0.0, target[1]))).unwrap();
            }
        }
        (0..before).for_each(|_| group.step(0.04, &Inline).unwrap());
        let paces = |group: &mut PolicyCharacters| -> Vec<_> {
            let of = |at| group.characters().last_choice(at).is_some().then_some(at);
            let begun: Vec<usize> = (0..group.ids().len()).filter_map(of).collect();
            begun.into_iter().map(|at| {
                let (b, _, lane) = group.characters.lane_mut(at);
                (at, b.pace[lane], b.wait[lane].to_bits())
            }).collect()
        };
        let then = paces(&mut group);
        group.hold_entrants();
        group.spawn(Spawn { root: Planar::new(50.0, 50.0, 0.0), state: Some(0), floor_m: 0.0 }).unwrap();
        group.release_entrants();
        prop_assert_eq!(then, paces(&mut group));
        for _ in 0..60 {
            assert_on_paths(&group);
            group.step(0.04, &Inline).unwrap();
            let room = least_room(&places(&group));
            prop_assert!(room > -1e-3, "{} m in each other", -room);
        }
    }

    #[test]
    fn a_snapshot_goes_on_as_what_was_saved(starts in starts(), before in 1usize..60, target in [-5.0f32..5.0, -5.0f32..5.0]) {
        let mut first = character_group_of(&starts, config(ActionChoice::LookAhead { temperature: 0.5 }));
        for &id in &first.ids().to_vec() {
            first.order(id, PolicyOrder::towards(0, Vec3::new(target[0], 0.0, target[1]))).unwrap();
        }
        (0..before).for_each(|_| first.step(0.04, &Inline).unwrap());
        let mut saved = Vec::new();
        first.save(&mut saved);
        let mut second = PolicyCharacters::with_capacity(&bent_tables(&[]), starts.len(), first.characters().config).unwrap();
        second.load(&saved).unwrap();
        for _ in 0..60 {
            first.step(0.03, &Inline).unwrap();
            second.step(0.03, &Inline).unwrap();
            prop_assert_eq!(first.hash(), second.hash());
        }
    }
}

#[test]
fn the_stop_of_one_who_has_not_begun_follows_its_segment() {
    let mut group = character_group_of(&[(0.0, 0.0, 0.0, 1)], config(ActionChoice::BestAction));
    let (tables, mut out) = (tables(), crate::reserve::ReservedPath::default());
    let motion_set = crate::characters::MotionSet::new(&tables);
    // A step has passed the end of the segment, and every path is reserved anew before the next choice.
    let (block, _, lane) = group.characters.lane_mut(0);
    let end_s = block.length[lane] as f32 / motion_set.rate_hz;
    block.time[lane] = block.length[lane] as f32 + 0.7;
    super::path::path_of_state(block, lane, &motion_set, &mut out);
    assert_eq!(out.nodes[0].time_s, end_s);
}

#[test]
fn threads_change_nothing() {
    let crowd: Vec<_> =
        (0..400).map(|i| ((i % 20) as f32 * 1.1, (i / 20) as f32 * 1.1, i as f32, i as u32 % 4)).collect();
    let run = |run: &dyn Executor| {
        let mut group = character_group_of(&crowd, config(ActionChoice::LookAhead { temperature: 0.3 }));
        for (k, &id) in group.ids().to_vec().iter().enumerate() {
            group
                .order(id, PolicyOrder::towards(0, Vec3::new((k * 7 % 22) as f32, 0.0, (k * 13 % 22) as f32)))
                .unwrap();
        }
        (0..90).for_each(|_| group.step(0.05, run).unwrap());
        assert!(least_room(&places(&group)) > -1e-3);
        group.hash()
    };
    assert_eq!(run(&Inline), run(&TwoThreads));
}

#[test]
fn who_would_start_in_anothers_way_is_refused_and_forged_snapshots_too() {
    let mut group = PolicyCharacters::with_capacity(&bent_tables(&[]), 3, config(ActionChoice::BestAction)).unwrap();
    let first = group.spawn(Spawn { root: Planar::IDENTITY, state: Some(0), floor_m: 0.0 }).unwrap();
    let near = Spawn { root: Planar::new(0.5, 0.0, 0.0), state: Some(0), floor_m: 0.0 };
    assert!(matches!(group.spawn(near), Err(Error::Occupied { .. })));
    let far = group.spawn(Spawn { root: Planar::new(9.0, 0.0, 0.0), state: Some(0), floor_m: 0.0 }).unwrap();
    let before = group.hash();
    assert!(matches!(group.place(far, Planar::new(0.3, 0.3, 0.0)), Err(Error::Occupied { .. })));
    assert_eq!(group.hash(), before);
    // The same places without avoidance: two overlap, which characters with avoidance do not accept.
    let blind = CharactersConfig { avoid: None, ..config(ActionChoice::BestAction) };
    let mut others = PolicyCharacters::with_capacity(&bent_tables(&[]), 3, blind).unwrap();
    others.spawn(Spawn { root: Planar::IDENTITY, state: Some(0), floor_m: 0.0 }).unwrap();
    others.spawn(near).unwrap();
    assert_eq!(group.characters.find_path_conflict(&group.motion_set, &others.characters.saved_blocks().0, 2), Some(1));
    group.despawn(first).unwrap();
    assert_eq!(group.characters.find_path_conflict(&group.motion_set, &group.characters.saved_blocks().0, 1), None);
}

#[test]
fn what_is_refused_changes_nothing_and_names_who_it_is_about() {
    let at = |x: f32| Spawn { root: Planar::new(x, 0.0, 0.0), state: Some(0), floor_m: 0.0 };
    let mut group = PolicyCharacters::with_capacity(&bent_tables(&[]), 4, config(ActionChoice::BestAction)).unwrap();
    let gone = group.spawn(at(20.0)).unwrap();
    let ids = [0.0, 0.65].map(|x| group.spawn(at(x)).unwrap());
    // Ids and rows are not the same from here on.
    group.despawn(gone).unwrap();
    group.step(0.04, &Inline).unwrap();
    let before = group.hash();
    assert!(matches!(group.spawn(at(0.3)), Err(Error::Occupied { .. })));
    assert_eq!(group.hash(), before, "a spawn is refused");
    let bad = [Vec3::X, Vec3::NAN];
    assert!(matches!(group.aim_all(&bad, &bad), Err(Error::Value { .. })));
    assert_eq!(group.hash(), before, "targets are refused");
    let targets = ids.map(|id| group.order_of(id).unwrap().target());
    for (k, id) in ids.into_iter().enumerate() {
        let towards = Vec2::new(if k == 0 { 0.3 } else { -0.3 }, 0.0);
        group.shift_by(id, towards).unwrap();
        assert_eq!(group.hash(), before, "it stays where it is");
    }
    // A character that has turned to the other one has room to stop, and none to walk on.
    let (mut refused, segments) = (0, 0..group.motion_set().graph().segments.len() as u32);
    for (x, segment) in (8..30).flat_map(|k| segments.clone().map(move |s| (0.1 * k as f32, s))) {
        for heading in [-1.6, 1.6] {
            let (id, mut other) = (ids[1], group.clone());
            if other.place(id, Planar::new(x, 0.0, heading)).is_err() {
                continue;
            }
            let before = other.hash();
            match other.play_segment(id, segment) {
                Ok(()) => {}
                Err(Error::Occupied { who, .. }) => {
                    refused += 1;
                    assert_eq!((who, other.hash()), (id, before));
                }
                Err(e) => panic!("{e}"),
            }
        }
    }
    assert!(refused > 0);
    group.step(0.04, &Inline).unwrap();
    assert_eq!(ids.map(|id| group.order_of(id).unwrap().target()), targets);
}

#[test]
fn blows_come_in_the_order_of_their_numbers() {
    // Every character strikes twice: at the end of a segment and at the start of the next one.
    let hits: Vec<_> = (0..80).map(crate::characters::tests::blows::hit).collect();
    let tables = crate::characters::made_up::tables_with(&hits);
    let mut group = PolicyCharacters::with_capacity(&tables, 12, config(ActionChoice::BestAction)).unwrap();
    (0..12).for_each(|k| {
        _ = group
            .spawn(Spawn { root: Planar::new(9.0 * k as f32, 0.0, 0.0), state: Some(k % 4), floor_m: 0.0 })
            .unwrap()
    });
    let mut twice = 0;
    for _ in 0..300 {
        group.step(0.1, &Inline).unwrap();
        let who: Vec<u32> = group.characters().blows().iter().map(|b| b.character).collect();
        assert!(who.is_sorted(), "{who:?}");
        twice += who.windows(2).filter(|w| w[0] == w[1]).count();
    }
    assert!(twice > 100, "{twice}");
}

#[test]
fn two_who_meet_pass_each_other() {
    // The made-up motion only walks ahead: one is held until the other is gone.
    let mut group = character_group_of(
        &[(0.0, 0.0, 0.0, 0), (0.35, 6.0, std::f32::consts::PI, 0)],
        config(ActionChoice::BestAction),
    );
    assert_eq!(group.ids().len(), 2);
    (0..400).for_each(|_| group.step(0.02, &Inline).unwrap());
    assert!(group.ids().iter().enumerate().all(|(at, _)| group.characters().num_choices(at) > 3));
}

/// The made-up bundle, where a frame of the second segment, and the node of its sweep, lie elsewhere.
fn with_root_at(x: f32) -> Result<Bundle, FormatError> {
    let tables = tables();
    let (node, row) = (tables.stops().nodes[31], tables.frames()[30]);
    assert_eq!((node.frame, tables.graph().segments[1].start), (10, 20));
    let [from_x, from_z, heading] = tables.frames()[20].planar;
    let root = Planar::new(from_x, from_z, heading).compose(Planar::new(x, node.z, 0.0));
    let mut bytes = bytes(&[], false);
    let mut put = |from: &[u8], to: &[u8]| {
        let at = bytes.windows(from.len()).position(|w| w == from).expect("it is there");
        bytes[at..at + to.len()].copy_from_slice(to);
    };
    put(bytemuck::bytes_of(&node), bytemuck::bytes_of(&SweepNode { x, ..node }));
    let moved = FrameRow { planar: [root.x, root.z, row.planar[2]], ..row };
    put(bytemuck::bytes_of(&row), bytemuck::bytes_of(&moved));
    Bundle::from_bytes_unverified(AlignedBytes::from_slice(&bytes))
}

#[test]
fn ways_that_leap_are_saved_and_read_back_and_refused_where_they_leap_too_far() {
    let refused = with_root_at(150.0).unwrap_err().to_string();
    assert!(refused.contains("leaps"), "{refused}");
    for (k, x) in [3.0, 30.0, -70.0, 99.0].into_iter().enumerate() {
        let bundle = with_root_at(x).unwrap();
        for trial in 0..100 {
            let draw = |n: u64| uniform_random(k as u64, trial, n);
            let config = config(ActionChoice::BestAction);
            let mut group = PolicyCharacters::with_capacity(&bundle, 6, config).unwrap();
            for n in 0..6 {
                let root = Planar::new((n % 3) as f32 * 4.0, (n / 3) as f32 * 4.0, 6.0 * draw(n));
                let target = Vec3::new(8.0 * draw(n + 10), 0.0, 8.0 * draw(n + 20));
                // Some starts lie on another character's long path.
                if let Ok(id) = group.spawn(Spawn { root, state: Some(n as u32 % 4), floor_m: 0.0 }) {
                    group.order(id, PolicyOrder::towards(0, target)).unwrap();
                }
            }
            assert!(group.ids().len() >= 2);
            for step in 0..20 {
                group.step(0.1, &Inline).unwrap();
                let mut saved = Vec::new();
                group.save(&mut saved);
                group.clone().load(&saved).unwrap_or_else(|e| panic!("{x} m, trial {trial}, step {step}: {e}"));
            }
        }
    }
}
