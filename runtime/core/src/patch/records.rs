//! The records of the sections that hold motion patches.

use crate::placement::Placement;
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// Marks an absent cell, edge or instance.
pub const NONE: u32 = u32::MAX;

/// Kind of a patch that is placed over the places of its units and connects to others where they overlap.
pub const KIND_BLOCK: u32 = 0;
/// Kind of a patch that is placed side by side with copies of itself and connects to them across its edges.
pub const KIND_TILE: u32 = 1;

/// One motion patch: a building block and the motion embedded in it, as a graph of cells and links (Lee, Choi and Lee 2006, sections 4, 6).
///
/// The patch's frame is that of its first unit. Its cells are `first_cell..first_cell + num_cells`, its links
/// `first_link..first_link + num_links`, its edges `first_edge..first_edge + num_edges`; a block has no edges.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PatchRecord {
    /// [`KIND_BLOCK`] or [`KIND_TILE`].
    pub kind: u32,
    /// First cell.
    pub first_cell: u32,
    /// Number of cells.
    pub num_cells: u32,
    /// First link.
    pub first_link: u32,
    /// Number of links.
    pub num_links: u32,
    /// First edge.
    pub first_edge: u32,
    /// Number of edges.
    pub num_edges: u32,
    /// Zero.
    pub reserved: u32,
    /// Lowest corner of all that bodies reach (m).
    pub min: [f32; 3],
    /// Highest corner of all that bodies reach (m).
    pub max: [f32; 3],
}

/// An edge of a tile, which its copies join.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct EdgeRecord {
    /// Position of the neighbour across the edge, relative to the tile; its heading is 0 (m).
    pub step: [f32; 3],
    /// The opposite edge, within the patch: what leaves across this one enters the neighbour across that one.
    pub opposite: u32,
}

/// Meeting point of a patch's links: alike places, headings and poses.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct CellRecord {
    /// Planar root, and height of the hips, in the patch's frame: the mean over what lies in it.
    pub placement: Placement,
    /// Pose group.
    pub group: u32,
    /// Edge of a tile that is entered or left here, within the patch; [`NONE`] inside.
    pub edge: u32,
    /// For an exit, the entry cell (within the patch) of the neighbour across the edge; for an entry, the exit cell
    /// of the neighbour that leads here; [`NONE`] inside.
    pub twin: u32,
    /// See [`CellRecord::IS_REST`] and the others.
    pub flags: u32,
    /// First link that begins here, within the patch; links are sorted by the cell they begin in.
    pub first_link: u32,
    /// Number of links that begin here.
    pub num_links: u32,
    /// Zero.
    pub reserved: [u32; 2],
}

const _: () = assert!(size_of::<CellRecord>() == 48);

impl CellRecord {
    /// The character stands or sits still here and may stay: a link leads from the cell to itself.
    pub const IS_REST: u32 = 1;
    /// Links begin here at an edge of a tile.
    pub const IS_ENTRY: u32 = 2;
    /// Links end here at an edge of a tile; none begins here.
    pub const IS_EXIT: u32 = 4;

    /// True where all of `flags` are set.
    pub fn has_flags(&self, flags: u32) -> bool {
        self.flags & flags == flags
    }
}

/// Motion from one cell of a patch to another: the frames `frame ..= frame + num_frames` of one clip.
///
/// The planar root of frame k is `start` composed with what the clip moved since its first frame, plus k / num_frames
/// of what is missing to `end` then: position and heading change linearly (Lee, Choi and Lee 2006, section 6). Where the motion lies in
/// the patch as it was captured, nothing is missing.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct LinkRecord {
    /// Cell it begins in, within the patch.
    pub from: u32,
    /// Cell it ends in, within the patch.
    pub to: u32,
    /// First frame row.
    pub frame: u32,
    /// Frames played (> 0).
    pub num_frames: u16,
    /// Tag of the action that it shows: 0 for none, else 1 + index into [`crate::format::Meta::link_tags`]; with
    /// [`LinkRecord::FOR_TWO`] for one side of a [`PairRecord`].
    pub tag: u16,
    /// Planar root of the first frame in the patch's frame; y is the height of the clip's ground.
    pub start: Placement,
    /// Planar root of the last frame in the patch's frame; y as in `start`. The heading counts full turns.
    pub end: Placement,
}

const _: () = assert!(size_of::<LinkRecord>() == 48);

impl LinkRecord {
    /// Bit of a tag of an action of two people, whose links are never taken by one alone.
    pub const FOR_TWO: u16 = 1 << 15;

    /// True for one side of what two people do together.
    pub fn is_for_two(&self) -> bool {
        self.tag & Self::FOR_TWO != 0
    }
}

/// Joint action of two people across an edge of a tile, as they were captured together: one plays a link of the tile,
/// the partner at the same time a link of the copy beyond the edge.
///
/// Both links have the same number of frames and the same tag, with [`LinkRecord::FOR_TWO`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct PairRecord {
    /// Number of the patch: a tile.
    pub patch: u32,
    /// Edge, within the patch, beyond which the partner is.
    pub edge: u32,
    /// Link of the person in the tile, within the patch.
    pub link: u32,
    /// Link of the partner, within the patch.
    pub partner_link: u32,
}
