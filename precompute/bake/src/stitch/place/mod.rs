//! Places patches in an environment: fitting blocks and tiles, overlaps, and obstacles.

pub(in crate::stitch) mod fit;
pub(in crate::stitch) mod near;
pub(in crate::stitch) mod paths;
pub(in crate::stitch) mod place_patches;
pub(in crate::stitch) mod relation;
pub(in crate::stitch) mod solids;
