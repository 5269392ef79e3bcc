//! Places patches in an environment: fitting blocks and tiles, overlaps, and obstacles.
//!
//! [`place_patches`] handles a whole environment, [`update_patches`] only the surroundings of one changed unit.

pub(in crate::stitch) mod change;
pub(in crate::stitch) mod fit;
pub(in crate::stitch) mod near;
pub(in crate::stitch) mod paths;
pub(in crate::stitch) mod place_patches;
pub(in crate::stitch) mod relation;
pub(in crate::stitch) mod solids;
pub(in crate::stitch) mod update_patches;
