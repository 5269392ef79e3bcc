//! Inhabitants that are saved at any moment and go on as if nothing had happened.

use super::inhabitants::open;
use super::made_up_world::SIT;
use glam::Vec3;
use throng_core::base::crc32;
use throng_core::characters::CharactersConfig;
use throng_core::{CharacterGroup, Error, Id, Inline};
use throng_world::World;
use throng_world::inhabitants::{
    InhabitantActivity, InhabitantGoal, Inhabitants, InhabitantsConfig, scatter_rest_nodes,
};

const DT: f32 = 1.0 / 30.0;
/// Where the checksum of a snapshot lies, and where its state begins.
const CHECKSUM: usize = 40;
const BODY: usize = 44;

/// Two rooms with benches, and a narrow way between them.
fn rooms() -> World {
    open(&["#####.#####", "#b#######b#", "#####.#####"])
}

fn busy(world: &World, seed: u64) -> Inhabitants {
    let characters = CharactersConfig { seed, ..CharactersConfig::default() };
    let config = InhabitantsConfig { characters, max_path: 16, ..InhabitantsConfig::default() };
    let mut people = Inhabitants::new(world, 10, config).expect("room");
    scatter_rest_nodes(world.graph(), 10, seed).into_iter().for_each(|start| _ = people.spawn(start).expect("a start"));
    // One has left: ids and rows differ.
    people.despawn(Id::first(3)).expect("it was there");
    people
}

/// Some steps with new orders for all, which depend on the state alone.
fn go_on(people: &mut Inhabitants, num_steps: usize) {
    for _ in 0..num_steps {
        for id in people.ids().to_vec() {
            let (state, c) = (people.state(id).unwrap(), id.index);
            let n = state.num_fulfilled + 1;
            let is_free =
                state.goal == InhabitantGoal::Roam && c % 4 != 0 || state.activity == InhabitantActivity::Unreachable;
            if is_free || state.activity == InhabitantActivity::Arrived && c != 5 {
                let goal = match c % 4 {
                    1 => InhabitantGoal::Perform { tag: SIT, seconds: 1.0 + c as f32 },
                    2 => InhabitantGoal::GoNear { place: Vec3::new((n % 7) as f32, 1.0, 1.0), within_m: 4.0 },
                    _ => InhabitantGoal::GoTo { instance: (7 * c + 13 * n) % 31 },
                };
                people.order(id, goal).expect("a goal");
            }
        }
        people.step(DT, &Inline).expect("a step");
    }
}

fn saved(people: &Inhabitants) -> Vec<u8> {
    let mut out = Vec::new();
    people.save(&mut out);
    out
}

#[test]
fn who_is_loaded_goes_on_as_if_nothing_had_happened() {
    let world = rooms();
    for seed in 1..4 {
        let (mut people, mut other) = (busy(&world, seed), busy(&world, seed));
        for moment in [0, 1, 37, 200, 113, 611, 40] {
            go_on(&mut people, moment);
            let bytes = saved(&people);
            let mut undisturbed = people.clone();
            go_on(&mut undisturbed, 300);
            go_on(&mut people, 77);
            people.load(&bytes).expect("its own snapshot");
            other.load(&bytes).expect("a snapshot of the same");
            assert_eq!((saved(&other), people.hash()), (bytes, other.hash()));
            for again in [&mut people, &mut other] {
                go_on(again, 300);
                assert_eq!(saved(again), saved(&undisturbed), "seed {seed}, {moment} steps on");
                assert_eq!(again.characters().model_matrices(), undisturbed.characters().model_matrices());
                for &id in again.ids() {
                    assert_eq!(again.path_steps(id).unwrap(), undisturbed.path_steps(id).unwrap());
                    assert!(again.units_of(id).unwrap().all(|u| undisturbed.holder(u) == Some(id)));
                    assert_eq!(again.units_of(id).unwrap().count(), undisturbed.units_of(id).unwrap().count());
                }
            }
        }
        assert!(people.ids().iter().map(|id| people.state(*id).unwrap().num_fulfilled).sum::<u32>() > 5);
    }
}

#[test]
fn what_is_cut_damaged_or_foreign_is_refused_and_changes_nothing() {
    let world = rooms();
    let mut people = busy(&world, 2);
    go_on(&mut people, 400);
    let (bytes, before) = (saved(&people), people.hash());
    let mut refuse = |bytes: &[u8], why: &str| {
        assert!(matches!(people.load(bytes), Err(Error::Snapshot { .. })), "{why}");
        assert_eq!(people.hash(), before, "{why}");
    };
    for len in (0..bytes.len()).step_by(97).chain(0..64) {
        refuse(&bytes[..len], "cut");
    }
    for i in (0..bytes.len()).step_by(61).chain(0..64) {
        let mut damaged = bytes.clone();
        damaged[i] ^= 1 << (i % 8);
        refuse(&damaged, "damaged");
    }
    refuse(&[&bytes[..], &[0]].concat(), "more than one");
    refuse(&saved(&busy(&open(&["#####", "#b###", "#####"]), 2)), "of another world");
    refuse(&saved(&busy(&world, 3)), "of another seed");
}

/// Damaged bytes with a corrected checksum do not panic, and nobody shares a reservation: a state in which two hold the
/// same unit would not be loaded again.
#[test]
fn nothing_that_can_be_loaded_panics() {
    let world = rooms();
    let mut people = busy(&world, 1);
    go_on(&mut people, 500);
    let bytes = saved(&people);
    let mut num_loaded = 0;
    for i in (BODY..bytes.len()).step_by(5) {
        let mut forged = bytes.clone();
        forged[i] ^= [1, 0x80, 0xff][i % 3];
        let sum = crc32(&forged[BODY..]);
        forged[CHECKSUM..BODY].copy_from_slice(&sum.to_le_bytes());
        match people.load(&forged) {
            Ok(()) => {
                num_loaded += 1;
                for _ in 0..30 {
                    people.step(1.0, &Inline).expect("a step");
                }
                let later = saved(&people);
                people.load(&later).expect("nobody shares a unit");
                assert!(people.bodies().roots.iter().all(|r| r.translation().is_finite()), "byte {i}");
            }
            Err(e) => assert!(matches!(e, Error::Snapshot { .. }), "{e}"),
        }
    }
    assert!(num_loaded > 0);
}

#[test]
fn a_capacity_out_of_its_range_is_an_error() {
    let world = rooms();
    for (capacity, max_path) in [(usize::MAX, 16), (1_000_001, 16), (1_000_000, 65_536)] {
        let config = InhabitantsConfig { max_path, ..InhabitantsConfig::default() };
        let e = Inhabitants::new(&world, capacity, config).map(|_| ()).unwrap_err().to_string();
        assert!(e.contains("capacity") && e.contains("0 to "), "{e}");
    }
}
