//! Lays patches over an environment: which block or tile fits where, what overlaps, and what stands in its reach.
//!
//! [`lay::Placer::lay`] looks at a whole environment, [`relay`] only at what is near one unit that was changed.

pub(in crate::stitch) mod change;
pub(in crate::stitch) mod fit;
pub(in crate::stitch) mod lay;
pub(in crate::stitch) mod near;
pub(in crate::stitch) mod paths;
pub(in crate::stitch) mod relation;
pub(in crate::stitch) mod relay;
pub(in crate::stitch) mod solids;
