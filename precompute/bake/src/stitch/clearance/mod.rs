//! What of a patch's motion collides with a unit: bodies as balls, distances from a unit, and the links that pass by it.
//!
//! [`mask::Obstacle`] finds the links in the way of one unit; what was looked at is kept in [`seen`] for small moves.

pub(in crate::stitch) mod bodies;
pub(in crate::stitch) mod field;
pub(in crate::stitch) mod hit;
pub(in crate::stitch) mod looks;
pub(in crate::stitch) mod mask;
pub(in crate::stitch) mod plan;
pub(in crate::stitch) mod seen;
pub(in crate::stitch) mod swept;
