//! Tags of the sections, in file order.

use throng_core::format::Tag;

/// [`crate::WorldMeta`], encoded.
pub const META: Tag = Tag(*b"WMET");
/// [`crate::UnitRecord`] per unit.
pub const UNITS: Tag = Tag(*b"WUNI");
/// [`crate::InstanceRecord`] per instance.
pub const INSTANCES: Tag = Tag(*b"WINS");
/// Instance across each edge of each tile (u32).
pub const NEIGHBOURS: Tag = Tag(*b"WNEI");
/// Bits of the cells (u64).
pub const CELLS: Tag = Tag(*b"WCEL");
/// Bits of the links (u64).
pub const LINKS: Tag = Tag(*b"WLNK");
/// [`crate::AdjacencyRecord`] per instance and other instance that it overlaps.
pub const ADJACENCIES: Tag = Tag(*b"WADJ");
/// [`crate::JointTableRecord`] per table.
pub const TABLES: Tag = Tag(*b"WTAB");
/// [`crate::JointRecord`] per joint of each table.
pub const JOINTS: Tag = Tag(*b"WJOI");
/// Joints of each table by their side b (u32).
pub const JOINTS_BY_B: Tag = Tag(*b"WJOB");
/// Bits of the joints (u64).
pub const JOINT_BITS: Tag = Tag(*b"WJBT");
/// Units of each instance (u32).
pub const RESOURCES: Tag = Tag(*b"WRES");
/// [`crate::PathCosts`], encoded.
pub const PATHS: Tag = Tag(*b"WPTH");
