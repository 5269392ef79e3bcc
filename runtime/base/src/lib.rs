//! Foundation of all crates of the runtime: ids, errors, limits, files and their frame, snapshots, hashes, threads, vectors of eight floats.

mod checksum;
pub mod clock;
mod comm;
pub mod error;
pub mod file;
pub mod frame;
pub mod ground;
mod hash;
mod id;
pub mod limits;
pub mod maths;
mod prefetch;
mod run;
pub mod simd;
mod snapshot;
#[cfg(feature = "text")]
pub mod text;
pub mod thresholds;

/// Defines functions that return the defaults of keys of a file, for `#[serde(default = "...")]`.
#[macro_export]
macro_rules! key_defaults {
    ($($visibility:vis $name:ident: $kind:ty = $value:expr;)*) => {
        $($visibility fn $name() -> $kind { $value })*
    };
}

pub use checksum::{crc32, crc32_of_pieces};
pub use comm::{Comm, LocalComm, SingleRank, Traffic, rank_range, unexpected_message};
pub use error::{Error, Result};
pub use glam;
pub use hash::{Hash128, StateHash};
pub use id::Id;
pub use prefetch::prefetch;
pub use run::{Executor, Inline, run_each};
#[cfg(feature = "rayon")]
pub use run::{Rayon, limit_threads};
pub use snapshot::{Bytes, SnapshotKind};
