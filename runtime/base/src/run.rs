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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_is_given_to_one_call() {
        for n in [0, 1, MAX_PARTS, MAX_PARTS + 1, 3 * MAX_PARTS] {
            let mut numbers = vec![0; n];
            run_each(&Inline, numbers.iter_mut().enumerate(), |(k, number)| *number += k + 1);
            assert!(numbers.iter().enumerate().all(|(k, number)| *number == k + 1), "{n}");
        }
    }
}
