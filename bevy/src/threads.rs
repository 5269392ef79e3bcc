//! Steps on Bevy's threads.

use bevy::tasks::ComputeTaskPool;
use throng_runtime::Executor;

/// The pool on which systems run.
pub struct Pool(pub &'static ComputeTaskPool);

impl Executor for Pool {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        self.0.scope(|scope| (0..num_parts).for_each(|k| scope.spawn(async move { part(k) })));
    }

    fn is_parallel(&self) -> bool {
        self.0.thread_num() > 1
    }
}
