//! Priority queues of searches: [`Heap`] by any key, [`Buckets`] by whole keys that grow.

mod buckets;
mod heap;

pub(crate) use buckets::Buckets;
pub(crate) use heap::Heap;
