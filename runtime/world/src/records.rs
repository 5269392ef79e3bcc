//! The records of a world file.

use bytemuck::{Pod, Zeroable};
use throng_core::patch::Placement;

/// Patch of the world, with its placement. Beside its records an instance has bits only.
///
/// Bits are in words of 64, lowest first; every instance begins with a word of its own. A set bit means enabled.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct InstanceRecord {
    /// Number of the patch in the bundle.
    pub patch: u32,
    /// For a tile, where its edges' neighbours stand in [`super::WorldTables::neighbours`], one an edge.
    pub first_neighbour: u32,
    /// The patch's frame in the world.
    pub placement: Placement,
    /// First word of the cells' bits.
    pub first_cell_word: u32,
    /// First word of the links' bits.
    pub first_link_word: u32,
    /// First adjacency: where it overlaps others.
    pub first_adjacency: u32,
    /// Number of adjacencies.
    pub num_adjacencies: u32,
    /// First of the resources a character holds while it is here, in [`super::WorldTables::resources`].
    pub first_resource: u32,
    /// Number of resources (> 0).
    pub num_resources: u32,
}

const _: () = assert!(size_of::<InstanceRecord>() == 48);

/// Two instances that overlap, as seen from one of them; the other one has an adjacency of its own.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct AdjacencyRecord {
    /// The other instance.
    pub other: u32,
    /// The joints they may have.
    pub table: u32,
    /// 0 where the instance that owns this record plays the part of `a` in the table, 1 where that of `b`.
    pub side: u32,
    /// First word of the joints' bits, the same for both: bit 2k is set where joint k may be taken from a to b, bit
    /// 2k + 1 where from b to a.
    pub first_word: u32,
}

/// The joints of every pair of instances of two patches that stand to each other in one way.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct JointTableRecord {
    /// Patch on side a: a tile or a block.
    pub patch_a: u32,
    /// Patch on side b: a block.
    pub patch_b: u32,
    /// First joint.
    pub first_joint: u32,
    /// Number of joints.
    pub num_joints: u32,
    /// Side b's frame as seen from side a's.
    pub placement: Placement,
}

/// A place where motion of one instance may go on as motion of another: same pose group, near in place and heading.
///
/// Joints of a table are sorted by (a, a_offset, b).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Pod, Zeroable)]
#[repr(C)]
pub struct JointRecord {
    /// On side a: a cell of a block, or a link of a tile.
    pub a: u32,
    /// Frames into the link; [`throng_core::patch::NONE`] where `a` is a cell.
    pub a_offset: u32,
    /// Cell on side b.
    pub b: u32,
    /// Zero.
    pub reserved: u32,
}

/// A unit object of the world. Its number is the resource that characters hold.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct UnitRecord {
    /// Number in the bundle's list of unit objects.
    pub unit: u32,
    /// Placement of the unit in the world.
    pub placement: Placement,
}
