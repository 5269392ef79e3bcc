//! Collisions of a patch's motion with a unit: bodies as spheres, distances from a unit, and the links that pass by it.
//!
//! [`mask::Obstacle`] finds the links that one unit obstructs; [`seen`] holds the samples, for reuse after small moves.

pub(in crate::stitch) mod bodies;
pub(in crate::stitch) mod collision_span;
pub(in crate::stitch) mod field;
pub(in crate::stitch) mod link_clearance;
pub(in crate::stitch) mod mask;
pub(in crate::stitch) mod plan;
pub(in crate::stitch) mod sampler;
pub(in crate::stitch) mod swept;
