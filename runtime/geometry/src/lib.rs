//! Segments, capsules, boxes and triangles, the distances between them, and trees and grids that find them.
//!
//! All lengths are metres. Distances in `f64` ([`Segment`], [`SolidShape`]) serve planning; those in `f32` serve steps of
//! characters ([`nearest_points`], [`Capsule`]), environments ([`BoundingBox`], [`nearest_on_box`]) and the ground
//! ([`Capsule2d`], [`BoxGrid`]). A [`TriangleMesh`] answers both.

mod bounds;
mod box_grid;
mod capsule;
mod cuboid;
mod nearest;
mod plane;
mod round_cone;
mod segment;
mod solid_shape;
mod surface;
mod triangle;
mod triangle_mesh;
mod triangle_tree;
mod two_bones;

pub use bounds::{BoundingBox, BoundsTree};
pub use box_grid::BoxGrid;
pub use capsule::{Capsule, overlap_depth};
pub use nearest::{Vector, distance_to_segment, nearest_on_segment, nearest_points, segment_distance, share_along};
pub use plane::{Bounds2d, Capsule2d, polygon_contains, segment_distance_2d, segment_distance_squared};
pub use round_cone::{SurfaceHit, ray_round_cone};
pub use segment::Segment;
pub use solid_shape::SolidShape;
pub use surface::{SurfacePoint, nearest_on_bar, nearest_on_box};
pub use triangle::{RayCrossing, ray_crossing};
pub use triangle_mesh::{MeshError, TriangleMesh};
pub use two_bones::two_bone_offsets;
