//! Threads that runs are repeated on.

use rand::{Rng, RngExt};
use rayon::{ThreadPool, ThreadPoolBuilder};
use throng_motion::error::BuildError;

/// Two threads, and eight. They stay for all runs: allocators keep memory for each thread that ever was, so that with
/// threads of its own every run would leave some behind.
#[derive(Debug)]
pub struct Pools([ThreadPool; 2]);

impl Pools {
    /// # Errors
    /// [`BuildError::Config`] where the system has no threads left.
    pub fn new() -> Result<Self, BuildError> {
        Ok(Self([build_pool(2)?, build_pool(8)?]))
    }

    /// One of them.
    pub fn any(&self, rng: &mut impl Rng) -> &ThreadPool {
        &self.0[rng.random_range(0..2usize)]
    }
}

/// A pool of so many threads.
pub(super) fn build_pool(threads: usize) -> Result<ThreadPool, BuildError> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| BuildError::Config { message: e.to_string() })
}
