//! Tags of the sections, in file order.

use throng_core::format::SectionTag;

/// [`crate::WorldMeta`], encoded.
pub const META: SectionTag = SectionTag(*b"WMET");
/// [`crate::UnitRecord`] per unit.
pub const UNITS: SectionTag = SectionTag(*b"WUNI");
/// [`crate::InstanceRecord`] per instance.
pub const INSTANCES: SectionTag = SectionTag(*b"WINS");
/// Instance across each edge of each tile (u32).
pub const NEIGHBOURS: SectionTag = SectionTag(*b"WNEI");
/// Bits of the cells (u64).
pub const CELLS: SectionTag = SectionTag(*b"WCEL");
/// Bits of the links (u64).
pub const LINKS: SectionTag = SectionTag(*b"WLNK");
/// [`crate::AdjacencyRecord`] per instance and other instance that it overlaps.
pub const ADJACENCIES: SectionTag = SectionTag(*b"WADJ");
/// [`crate::JointTableRecord`] per table.
pub const TABLES: SectionTag = SectionTag(*b"WTAB");
/// [`crate::JointRecord`] per joint of each table.
pub const JOINTS: SectionTag = SectionTag(*b"WJOI");
/// Joints of each table by their side b (u32).
pub const JOINTS_BY_B: SectionTag = SectionTag(*b"WJOB");
/// Bits of the joints (u64).
pub const JOINT_BITS: SectionTag = SectionTag(*b"WJBT");
/// Units of each instance (u32).
pub const RESOURCES: SectionTag = SectionTag(*b"WRES");
/// [`crate::PathCosts`], encoded.
pub const PATHS: SectionTag = SectionTag(*b"WPTH");
