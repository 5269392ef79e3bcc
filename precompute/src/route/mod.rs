//! Routes on the ground around what stands: the shortest ways that keep a clearance.
//!
//! A visibility graph: around every corner of every solid stand points at a little more than the clearance; points that see
//! each other are joined, and the shortest way is found by A*. It is written here on `petgraph`, which the motion graph needs
//! anyway: the well-kept crate for navigation meshes, polyanya 0.18, brings some 70 further crates, two versions of
//! `hashbrown` and of `rstar` among them, and a triangulation alone (spade) finds no way. Scenes have tens of corners, for
//! which the graph is small and, unlike a mesh of triangles, gives the shortest ways themselves.

mod map;
mod smooth;
mod solid;

pub use map::{NoWay, RouteMap};
pub use smooth::smooth;
pub use solid::Solid;
