//! Steps on the caller's own threads, without callbacks: helper threads run parts until the step is over.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use throng_base::Executor;

/// Work queue of the parts of a step, for helper threads.
#[derive(Default)]
pub struct WorkQueue {
    state: Mutex<QueueState>,
    changed: Condvar,
}

#[derive(Default)]
struct QueueState {
    /// True while a step is announced or running.
    is_open: bool,
    /// Function that runs a part, while there are independent parts.
    part: Option<PartPointer>,
    /// Number of the next free part.
    next: usize,
    num_parts: usize,
    /// Number of threads that run a part.
    num_busy: usize,
    /// True if a part has panicked on a helper.
    has_panicked: bool,
}

type Guard<'a> = MutexGuard<'a, QueueState>;

/// Pointer to the function of [`WorkQueue::run`], which is only set while that call lasts.
#[derive(Clone, Copy)]
struct PartPointer(*const (dyn Fn(usize) + Sync));

// SAFETY: the function that it points to is `Sync`.
unsafe impl Send for PartPointer {}

impl WorkQueue {
    fn lock(&self) -> Guard<'_> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, work: Guard<'a>) -> Guard<'a> {
        self.changed.wait(work).unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets helpers wait for the next step from now on.
    pub fn announce_step(&self) {
        self.lock().is_open = true;
    }

    pub fn is_open(&self) -> bool {
        self.lock().is_open
    }

    /// Ends the step: helpers return.
    pub fn close_step(&self) {
        self.lock().is_open = false;
        self.changed.notify_all();
    }

    /// Runs parts until the step is over; returns at once if no step is announced.
    pub fn run_parts(&self) {
        let mut work = self.lock();
        while work.is_open {
            work = match self.run_one_part(work) {
                Ok(work) => work,
                Err(work) => self.wait(work),
            };
        }
    }

    /// Runs one part; an error if there is none to run.
    fn run_one_part<'a>(&'a self, mut work: Guard<'a>) -> Result<Guard<'a>, Guard<'a>> {
        let (Some(part), true) = (work.part, work.next < work.num_parts) else { return Err(work) };
        let k = work.next;
        work.next += 1;
        work.num_busy += 1;
        drop(work);
        // SAFETY: `run` keeps it alive, as it does not return until no thread is busy.
        let part = unsafe { &*part.0 };
        let has_panicked = catch_unwind(AssertUnwindSafe(|| part(k))).is_err();
        let mut work = self.lock();
        work.num_busy -= 1;
        work.has_panicked |= has_panicked;
        if work.num_busy == 0 && work.next == work.num_parts {
            self.changed.notify_all();
        }
        Ok(work)
    }
}

impl Executor for WorkQueue {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        // SAFETY: only the lifetime of the pointer changes; it is removed before this call returns.
        let part = PartPointer(unsafe {
            std::mem::transmute::<*const (dyn Fn(usize) + Sync + '_), *const (dyn Fn(usize) + Sync)>(part)
        });
        let mut work = self.lock();
        (work.part, work.next, work.num_parts) = (Some(part), 0, num_parts);
        self.changed.notify_all();
        let mut work = loop {
            work = match self.run_one_part(work) {
                Ok(work) => work,
                Err(work) if work.num_busy == 0 => break work,
                Err(work) => self.wait(work),
            };
        };
        // No thread runs a part any more.
        work.part = None;
        let has_panicked = std::mem::take(&mut work.has_panicked);
        drop(work);
        if has_panicked {
            resume_unwind(Box::new("a part of the step has failed".to_owned()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn each_part_is_done_once_whoever_helps() {
        for num_helpers in [0, 1, 3] {
            let queue = WorkQueue::default();
            queue.announce_step();
            let counts: Vec<AtomicUsize> = (0..200).map(|_| AtomicUsize::new(0)).collect();
            std::thread::scope(|s| {
                (0..num_helpers).for_each(|_| drop(s.spawn(|| queue.run_parts())));
                for num_parts in [0, 1, 7, 200] {
                    queue.run(num_parts, &|k| _ = counts[k].fetch_add(1, Ordering::Relaxed));
                }
                queue.close_step();
            });
            let got: Vec<usize> = counts.into_iter().map(AtomicUsize::into_inner).collect();
            let expected: Vec<usize> = (0..200).map(|k| 1 + usize::from(k < 7) + usize::from(k < 1)).collect();
            assert_eq!(got, expected, "{num_helpers} helpers");
        }
    }

    #[test]
    fn a_part_that_panics_ends_the_step_after_all_parts() {
        let queue = WorkQueue::default();
        queue.announce_step();
        let done = AtomicUsize::new(0);
        let work = |k: usize| {
            assert_ne!(k, 3, "the third");
            done.fetch_add(1, Ordering::Relaxed);
        };
        std::thread::scope(|s| {
            s.spawn(|| queue.run_parts());
            let outcome = catch_unwind(AssertUnwindSafe(|| queue.run(20, &work)));
            queue.close_step();
            assert!(outcome.is_err());
        });
        assert_eq!(done.into_inner(), 19);
        queue.run(2, &|_| ());
    }

    #[test]
    fn help_without_a_step_returns() {
        WorkQueue::default().run_parts();
    }
}
