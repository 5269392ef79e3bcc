//! The same input, config and seed give the same bytes: at any number of threads, twice, with and without a cache.

use crate::common;
use glam::Vec3;
use std::path::Path;
use throng_core::characters::{ActionChoice, Characters, CharactersConfig, MotionSet, PolicyOrder};
use throng_core::{Bundle, CharacterGroup, Inline, Rayon};
use throng_precompute::cache::{Cache, content_hash};
use throng_precompute::trial::{self, TrialConfig};
use throng_simulation::sparring::Sparring;

fn on_threads<T: Send>(num_threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(num_threads).build().expect("a thread pool").install(work)
}

fn built(clips: &Path, out: &Path, cache: &Cache) -> Vec<u8> {
    let mut config = common::small_config(vec![clips.to_path_buf()]);
    config.resample.mirror = true;
    common::build(&config, out, cache);
    std::fs::read(out).expect("the bundle can be read")
}

#[test]
fn a_build_gives_the_same_bytes_at_any_number_of_threads_and_twice() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    common::write_clips(&clips, 0.6);
    let first = on_threads(1, || built(&clips, &out, &Cache::disabled()));
    for num_threads in [1, 2, 8] {
        let again = on_threads(num_threads, || built(&clips, &out, &Cache::disabled()));
        assert!(again == first, "{num_threads} threads, run twice");
    }
    let cache = Cache::in_folder(folder.path().join("cache"));
    for what in ["filling the cache", "using the cache"] {
        assert!(built(&clips, &out, &cache) == first, "{what}");
    }
}

#[test]
fn synthetic_clips_are_the_same_files_twice() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let files = |name: &str| {
        common::write_clips(&folder.path().join(name), 0.3);
        let read = |e: std::io::Result<std::fs::DirEntry>| {
            let e = e.expect("an entry");
            (e.file_name(), std::fs::read(e.path()).expect("a clip"))
        };
        let mut all: Vec<_> = std::fs::read_dir(folder.path().join(name)).expect("the folder").map(read).collect();
        all.sort();
        all
    };
    let first = files("a");
    assert!(!first.is_empty() && first == files("b"));
}

/// All readable state of some characters, as bytes.
fn bytes_of(characters: &Characters) -> Vec<u8> {
    let mut out = bytemuck::cast_slice::<_, u8>(characters.model_matrices()).to_vec();
    out.extend_from_slice(bytemuck::cast_slice(characters.local_transforms()));
    for c in 0..characters.num_characters() {
        let (root, (segment, time)) = (characters.root(c), characters.segment(c));
        out.extend([root.x, root.z, root.heading, time].into_iter().flat_map(f32::to_le_bytes));
        out.extend([segment, characters.num_choices(c)].into_iter().flat_map(u32::to_le_bytes));
        out.push(characters.contacts(c).0);
    }
    out
}

/// Characters of a crowd: several ranges and a part of one, and of a block.
const N: usize = 203;

/// Hashes of the bytes of a crowd after each of some steps.
fn crowd(
    tables: &Bundle,
    config: CharactersConfig,
    num_steps: usize,
    step: impl Fn(&mut Characters, &MotionSet, &[PolicyOrder]),
) -> Vec<u128> {
    let motion_set = MotionSet::new(tables);
    let mut orders = common::orders(N);
    let mut characters = Characters::new(&motion_set, config, &common::starts(tables, N)).expect("characters");
    let one_step = |k: usize| {
        orders.iter_mut().for_each(|o| *o = o.with_target(o.target() + Vec3::X * (0.01 * (k % 7) as f32)));
        step(&mut characters, &motion_set, &orders);
        content_hash(&bytes_of(&characters))
    };
    (0..num_steps).map(one_step).collect()
}

fn on_this_thread(characters: &mut Characters, motion_set: &MotionSet, orders: &[PolicyOrder]) {
    characters.step(motion_set, 1.0 / 30.0, orders).expect("a step");
}

fn config(choice: ActionChoice) -> CharactersConfig {
    CharactersConfig { choice, local_transforms: true, ..CharactersConfig::default() }
}

#[test]
fn steps_give_the_same_bytes_on_any_number_of_threads() {
    let tables = common::tables();
    for choice in [ActionChoice::LookAhead { temperature: 0.05 }, ActionChoice::BestAction] {
        let alone = crowd(&tables, config(choice), 120, on_this_thread);
        for num_threads in [1, 2, 8] {
            let together = on_threads(num_threads, || {
                crowd(&tables, config(choice), 120, |characters, motion_set, orders| {
                    characters.step_on(motion_set, 1.0 / 30.0, orders, &Rayon).expect("a step");
                })
            });
            let differs = (0..alone.len()).find(|&k| alone[k] != together[k]);
            assert_eq!(differs, None, "{choice:?}, {num_threads} threads: first step that differs");
        }
    }
}

#[test]
fn pairs_spar_the_same_on_any_number_of_threads() {
    let tables = common::boxing_tables();
    // Everything that can be read of pairs after each of some steps.
    let run = |step: &(dyn Fn(&mut Sparring) + Sync)| {
        let mut sparring = common::sparring(&tables, N).expect("pairs");
        let one_step = |_| {
            step(&mut sparring);
            let of = [content_hash(&bytes_of(sparring.characters()))];
            (of, sparring.events().to_vec(), sparring.heads().to_vec(), sparring.threats().to_vec(), sparring.figures())
        };
        (0..200).map(one_step).collect::<Vec<_>>()
    };
    let alone = run(&|s| s.step(1.0 / 30.0, &Inline).expect("a step"));
    let met = alone.iter().map(|a| a.1.len()).sum::<usize>();
    assert!(met > 100, "{met} blows that met are too few to prove anything");
    for num_threads in [1, 2, 8] {
        let together = on_threads(num_threads, || run(&|s| s.step(1.0 / 30.0, &Rayon).expect("a step")));
        let differs = (0..alone.len()).find(|&k| alone[k] != together[k]);
        assert_eq!(differs, None, "{num_threads} threads: first step that differs");
    }
}

#[test]
fn the_same_seed_gives_the_same_crowd_and_another_seed_another() {
    let tables = common::tables();
    let random = config(ActionChoice::LookAhead { temperature: 0.05 });
    let first = crowd(&tables, random, 300, on_this_thread);
    assert!(first == crowd(&tables, random, 300, on_this_thread));
    let other = CharactersConfig { seed: 2, ..random };
    assert!(first[299] != crowd(&tables, other, 300, on_this_thread)[299]);
    let sure = config(ActionChoice::LookAhead { temperature: 0.0 });
    let other = CharactersConfig { seed: 2, ..sure };
    // Whatever the temperature, the seed draws who stands how, so that nobody is in step with a neighbour.
    let calm = crowd(&tables, sure, 300, on_this_thread);
    assert!(calm == crowd(&tables, sure, 300, on_this_thread));
    assert!(calm[299] != crowd(&tables, other, 300, on_this_thread)[299], "all idle alike");
}

#[test]
fn a_character_does_not_depend_on_its_neighbours() {
    let tables = common::tables();
    let motion_set = MotionSet::new(&tables);
    let (starts, orders) = (common::starts(&tables, N), common::orders(N));
    let mut all = Characters::new(&motion_set, CharactersConfig::default(), &starts).expect("characters");
    let some = 0..5;
    let mut few = Characters::new(&motion_set, CharactersConfig::default(), &starts[some.clone()]).expect("characters");
    for _ in 0..60 {
        all.step(&motion_set, 0.05, &orders).expect("a step");
        few.step(&motion_set, 0.05, &orders[some.clone()]).expect("a step");
        for c in some.clone() {
            assert_eq!((all.root(c), all.segment(c)), (few.root(c), few.segment(c)), "character {c}");
            assert_eq!(all.pose(c), few.pose(c), "character {c}");
        }
    }
}

#[test]
fn a_trial_measures_the_same_twice() {
    let tables = common::tables();
    let trial = TrialConfig { characters: 30, seconds: 5.0, ..TrialConfig::default() };
    let figures = |config: &TrialConfig| {
        let (mut r, record) = trial::run(&tables, config).expect("a trial");
        // The only figures that depend on the machine.
        [r.steps_per_second, r.poses_per_second, r.choices_per_second] = [0.0; 3];
        let poses: Vec<_> = record.moments.into_iter().map(|moment| moment.poses).collect();
        (r, poses, record.targets, record.arrivals_s)
    };
    let first = figures(&trial);
    assert_eq!(first, figures(&trial));
    assert_ne!(first.2, figures(&TrialConfig { seed: 2, ..trial }).2);
}
