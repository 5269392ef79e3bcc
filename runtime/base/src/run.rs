//! Threads on which the parts of a step run.

use std::sync::{Mutex, PoisonError};

/// Runs independent parts of a step, on one or several threads.
///
/// Results depend neither on the thread that runs a part nor on the order of parts.
///
/// ```
/// use throng_base::Executor;
///
/// /// A scope of threads, one for each part; an engine passes parts to its job system instead.
/// struct ThreadEach;
///
/// impl Executor for ThreadEach {
///     fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
///         std::thread::scope(|scope| (0..num_parts).for_each(|k| drop(scope.spawn(move || part(k)))));
///     }
/// }
/// ```
pub trait Executor: Sync {
    /// Calls `part` once with every number below `num_parts`, and returns when all calls have.
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync));

    /// False where parts run one after the other, so that splitting work would gain nothing.
    fn is_parallel(&self) -> bool {
        true
    }
}

/// Most parts of one call of [`Executor::run`].
const MAX_PARTS: usize = 64;

/// Calls `work` once with each of some parts, on the threads of `run`. Allocates nothing.
pub fn run_each<T: Send>(run: &dyn Executor, mut parts: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
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

/// Runs parts one after the other, on the caller's thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inline;

impl Executor for Inline {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        (0..num_parts).for_each(part);
    }

    fn is_parallel(&self) -> bool {
        false
    }
}

/// Runs parts on rayon's current pool.
#[cfg(feature = "rayon")]
#[derive(Clone, Copy, Debug, Default)]
pub struct Rayon;

#[cfg(feature = "rayon")]
impl Executor for Rayon {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        use rayon::prelude::*;
        (0..num_parts).into_par_iter().for_each(part);
    }

    fn is_parallel(&self) -> bool {
        rayon::current_num_threads() > 1
    }
}

/// Most threads of a pool per hardware thread. On two cores, a build of a minute of motion takes as long with 64 threads as with
/// two, with 512 seven times as long, with 1000 forty times, since idle threads search for work.
#[cfg(feature = "rayon")]
const MOST_A_CORE: usize = 32;

/// Gives rayon's global pool fewer threads than `RAYON_NUM_THREADS` asks for, where that number is uselessly large. Must be called
/// at the beginning of a program: a pool that has started stays as it is.
#[cfg(feature = "rayon")]
pub fn limit_threads() {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let asked = std::env::var("RAYON_NUM_THREADS").ok();
    if let Some(num) = reduced_thread_count(asked.as_deref(), cores) {
        // An existing pool was made by the caller, and stays.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(num).build_global();
    }
}

/// Number of threads in place of one that is too large; `None` where the one asked for is fine.
#[cfg(feature = "rayon")]
fn reduced_thread_count(asked: Option<&str>, cores: usize) -> Option<usize> {
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
            assert_eq!(reduced_thread_count(asked, cores), expected, "{asked:?} on {cores}");
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
