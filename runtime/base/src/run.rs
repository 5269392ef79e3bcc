//! Whose threads work.

use std::sync::{Mutex, PoisonError};

/// Runs the parts of a step, which do not depend on each other, on whatever threads there are.
///
/// Results do not depend on who runs which part, nor on the order.
pub trait Run: Sync {
    /// Calls `part` once with every number below `num_parts`, and returns when all calls have.
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync));

    /// False where parts run one after the other: what takes work to be split is not split then.
    fn is_parallel(&self) -> bool {
        true
    }
}

/// Parts that one call of [`Run::run`] gets at most.
const MAX_PARTS: usize = 64;

/// Calls `work` once with each of some parts, on the threads of `run`. Allocates nothing.
pub fn run_each<T: Send>(run: &dyn Run, mut parts: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
    loop {
        let some: [Mutex<Option<T>>; MAX_PARTS] = std::array::from_fn(|_| Mutex::new(parts.next()));
        let is_part = |part: &Mutex<Option<T>>| part.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        let num_parts = some.iter().take_while(|part| is_part(part)).count();
        run.run(num_parts, &|k| {
            let part = some[k].lock().unwrap_or_else(PoisonError::into_inner).take();
            part.into_iter().for_each(&work);
        });
        if num_parts < MAX_PARTS {
            return;
        }
    }
}

/// One part after the other, on the caller's thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inline;

impl Run for Inline {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        (0..num_parts).for_each(part);
    }

    fn is_parallel(&self) -> bool {
        false
    }
}

/// On rayon's current pool.
#[cfg(feature = "rayon")]
#[derive(Clone, Copy, Debug, Default)]
pub struct Rayon;

#[cfg(feature = "rayon")]
impl Run for Rayon {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        use rayon::prelude::*;
        (0..num_parts).into_par_iter().for_each(part);
    }

    fn is_parallel(&self) -> bool {
        rayon::current_num_threads() > 1
    }
}

/// Threads of a pool at most, for each that the machine runs at a time. What a build of a minute of motion takes on two cores: at 64
/// threads what it takes at two, at 512 seven times that, at 1000 forty times, as threads without work look for some.
#[cfg(feature = "rayon")]
const MOST_A_CORE: usize = 32;

/// Gives rayon's global pool fewer threads than `RAYON_NUM_THREADS` asks for, where that is too many to be of use. For the
/// beginning of a program: a pool that has begun stays as it is.
#[cfg(feature = "rayon")]
pub fn limit_threads() {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let asked = std::env::var("RAYON_NUM_THREADS").ok();
    if let Some(num) = too_many(asked.as_deref(), cores) {
        // A pool that is there already has been asked for by the caller.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(num).build_global();
    }
}

/// The number of threads to have in place of more that were asked for.
#[cfg(feature = "rayon")]
fn too_many(asked: Option<&str>, cores: usize) -> Option<usize> {
    let most = MOST_A_CORE * cores;
    asked?.parse::<usize>().ok().filter(|&num| num > most).map(|_| most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(feature = "rayon")]
    #[test]
    fn only_what_is_of_no_use_is_taken_from_a_pool() {
        for (asked, cores, expected) in [
            (None, 2, None),
            (Some(""), 2, None),
            (Some("many"), 2, None),
            (Some("0"), 2, None),
            (Some("64"), 2, None),
            (Some("65"), 2, Some(64)),
            (Some("1000"), 2, Some(64)),
            (Some("1000"), 48, None),
            (Some("18446744073709551615"), 1, Some(32)),
        ] {
            assert_eq!(too_many(asked, cores), expected, "{asked:?} on {cores}");
        }
    }

    #[test]
    fn each_part_is_given_to_one_call() {
        for n in [0, 1, MAX_PARTS, MAX_PARTS + 1, 3 * MAX_PARTS] {
            let mut numbers = vec![0; n];
            run_each(&Inline, numbers.iter_mut().enumerate(), |(k, number)| *number += k + 1);
            assert!(numbers.iter().enumerate().all(|(k, number)| *number == k + 1), "{n}");
        }
    }
}
