//! Promise: a long run leaves nothing behind. After every round of a soak, as much memory is in use as after the first,
//! and no more than one simulation is there at a time.
#![allow(unsafe_code, reason = "an allocator that counts is an unsafe trait")]

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicI64, Ordering::SeqCst};
use std::sync::{Mutex, PoisonError};
use throng_bake::cache::Cache;
use throng_checks::soak::{self, Pools, SoakConfig, SoakReport};
use throng_core::Inline;
use throng_lab::run::{BuildContext, built_in_scene};
use throng_motion::progress::Silent;
use throng_simulation::Simulation;

/// What is allocated now, by all threads (bytes).
static IN_USE: AtomicI64 = AtomicI64::new(0);
/// The most that was allocated (bytes).
static MOST: AtomicI64 = AtomicI64::new(0);
/// One test at a time counts.
static TURN: Mutex<()> = Mutex::new(());

struct Counting;

fn more(bytes: usize) {
    let before = IN_USE.fetch_add(bytes as i64, SeqCst);
    MOST.fetch_max(before + bytes as i64, SeqCst);
}

fn less(bytes: usize) {
    IN_USE.fetch_sub(bytes as i64, SeqCst);
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: the caller's promises are the system allocator's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        less(layout.size());
        // SAFETY: as above.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Rounds after the first, in which what is made once is made.
const ROUNDS: usize = 4;
/// What may come and go: queues of threads (bytes).
const MARGIN: i64 = 64 << 10;

#[test]
fn runs_of_every_kind_leave_no_memory_behind() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().expect("a folder");
    let with = BuildContext { cache: &Cache::disabled(), progress: &Silent, report_news: &|_| {} };
    let scenes = soak::scenes(folder.path(), &with).expect("scenes of every kind");
    let config = SoakConfig { run_s: 0.5, ..SoakConfig::default() };
    let (pools, mut rng) = (Pools::new().expect("threads"), Pcg64Mcg::seed_from_u64(5));
    let mut report = SoakReport::default();
    let mut in_use = [0; 1 + ROUNDS];
    for (round, in_use) in in_use.iter_mut().enumerate() {
        for scene in &scenes {
            let mut scene = scene.clone();
            scene.seed = round as u64;
            soak::turn(&scene, &config, &pools, &mut rng, &mut report).expect("a run");
        }
        *in_use = IN_USE.load(SeqCst);
    }
    assert_eq!((report.runs, report.failed), (((1 + ROUNDS) * scenes.len()) as u64, 0), "{:?}", report.faults);
    let most = in_use[1..].iter().max().expect("rounds");
    assert!(most - in_use[0] < MARGIN, "bytes in use after each round: {in_use:?}");

    // The counter sees what stays.
    let kept = vec![1u8; 2 * MARGIN as usize];
    assert!(IN_USE.load(SeqCst) - in_use[ROUNDS] > MARGIN, "{}", kept.len());
}

/// A crowd of hours: people come, shop and leave, and their places are taken by others.
#[test]
fn a_crowd_that_comes_and_goes_for_an_hour_takes_no_more_memory() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().expect("a folder");
    let with = BuildContext { cache: &Cache::disabled(), progress: &Silent, report_news: &|_| {} };
    let scenes = soak::scenes(folder.path(), &with).expect("scenes of every kind");
    for (name, least_entries) in [("market", 500), ("floor", 2000)] {
        let scene = scenes.iter().find(|s| s.name == name).expect("a scene with a source");
        let mut sim = Simulation::new(&scene.open().expect("it is complete")).expect("a simulation");
        let mut there: Vec<bool> = sim.roots().map(|root| root.is_some()).collect();
        let (mut entries, mut in_use) = (0, Vec::new());
        for minute in 1..=60 {
            for step in 1..=600 {
                sim.step_to(f64::from(60 * (minute - 1)) + 0.1 * f64::from(step), &Inline).expect("a step");
                for (there, root) in there.iter_mut().zip(sim.roots()) {
                    entries += usize::from(root.is_some() && !*there);
                    *there = root.is_some();
                }
            }
            in_use.push(IN_USE.load(SeqCst));
        }
        let (early, late) = (&in_use[9], in_use[10..].iter().max().expect("minutes"));
        assert!(late - early < MARGIN, "{name}: bytes in use after each minute: {in_use:?}");
        assert!(entries > least_entries, "{name}: {entries} came");
        assert!(there.iter().any(|&there| there), "{name}: somebody is there at the end");
    }
}

#[test]
fn a_run_is_repeated_in_the_room_of_the_one_before() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let scene = built_in_scene("circle").expect("it is read").expect("it is there").resized(2000);
    let config = SoakConfig { run_s: 0.1, ..SoakConfig::default() };
    let (pools, mut rng) = (Pools::new().expect("threads"), Pcg64Mcg::seed_from_u64(5));
    let mut report = SoakReport::default();

    let compiled = scene.open().expect("it needs no file");
    let before = IN_USE.load(SeqCst);
    let simulation = Simulation::new(&compiled).expect("a simulation");
    let one = IN_USE.load(SeqCst) - before;
    drop(simulation);
    drop(compiled);

    let before = IN_USE.load(SeqCst);
    MOST.store(before, SeqCst);
    soak::turn(&scene, &config, &pools, &mut rng, &mut report).expect("a run");
    let most = MOST.load(SeqCst) - before;
    assert!(report.failed == 0 && one > 100_000, "{one} {:?}", report.faults);
    // It grows as it runs, and who watches it takes room, too; with one more it would be four times as much.
    assert!(2 * most < 7 * one, "{most} bytes at most, where a simulation takes {one}");
}
