//! The sections of a bundle: the one list of their tags, names and rows.

use crate::blend::{BlendRecord, ChannelRow, ExampleRecord, ReferenceRow};
use crate::contacts::Contacts;
use crate::format::{
    ClipRecord, FileStorage, FormatError, FrameRow, RotationCode, SectionLayout, SkeletonRecord, Table,
};
use crate::graph::{MotionSegment, StateRecord};
use crate::hits::HitRecord;
use crate::patch::{CellRecord, EdgeRecord, LinkRecord, PairRecord, PatchRecord};
use crate::policy::{PathRecord, PolicyRecord, SegmentRecord, StateGridRecord};
use crate::stops::{StopRecord, SweepNode, SweepRecord};
use std::sync::Arc;

/// Makes the tags, and a struct with one table for each section, out of one list.
macro_rules! sections {
    ($($(#[$doc:meta])+ $tag:ident = $letters:literal, $field:ident: $row:ty;)+) => {
        /// Tags of the sections, in file order.
        pub mod tags {
            use crate::format::SectionTag;

            $($(#[$doc])+ pub const $tag: SectionTag = SectionTag(*$letters);)+
        }

        /// The rows of every section.
        #[derive(Debug)]
        pub(super) struct Sections {
            $(pub $field: Table<$row>,)+
        }

        impl Sections {
            /// Finds all sections in a file whose frame was checked.
            pub fn new(storage: &Arc<FileStorage>, layout: &SectionLayout) -> Result<Self, FormatError> {
                Ok(Self { $($field: Table::of_file(storage, &layout.section::<$row>(tags::$tag)?),)+ })
            }
        }
    };
}

sections! {
    /// [`crate::format::Meta`], encoded.
    META = b"META", meta: u8;
    /// One element: a [`crate::format::SkeletonRecord`].
    SKELETON = b"SKEL", skeleton: SkeletonRecord;
    /// [`crate::format::ClipRecord`] per clip.
    CLIPS = b"CLIP", clips: ClipRecord;
    /// [`crate::format::FrameRow`] per frame.
    FRAMES = b"FRAM", frames: FrameRow;
    /// One element: a [`crate::format::RotationCode`].
    ROTATION_CODE = b"RCOD", rotation_code: RotationCode;
    /// [`crate::Contacts`] per frame.
    CONTACTS = b"CONT", contacts: Contacts;
    /// [`crate::HitRecord`] per effective hit, ascending by frame.
    HITS = b"HITS", hits: HitRecord;
    /// [`crate::graph::StateRecord`] per state.
    STATES = b"STAT", states: StateRecord;
    /// [`crate::graph::MotionSegment`] per segment.
    SEGMENTS = b"SEGM", segments: MotionSegment;
    /// First action of each state, and the number of actions (u32).
    ACTION_OFFSETS = b"AOFF", action_offsets: u32;
    /// Segment of each action (u32).
    ACTION_SEGMENTS = b"ASEG", action_segments: u32;
    /// Error of each action (f32), then per policy with errors of its own, and action.
    ACTION_ERRORS = b"AERR", action_errors: f32;
    /// [`crate::stops::SweepRecord`] per segment.
    SWEEPS = b"SWEP", sweeps: SweepRecord;
    /// [`crate::stops::SweepNode`] per node of each sweep.
    SWEEP_NODES = b"SWND", sweep_nodes: SweepNode;
    /// [`crate::stops::StopRecord`] per state.
    STOPS = b"STOP", stops: StopRecord;
    /// [`crate::policy::PolicyRecord`] per policy.
    POLICIES = b"POLI", policies: PolicyRecord;
    /// [`crate::policy::SegmentRecord`] per policy and segment.
    POLICY_SEGMENTS = b"PSEG", policy_segments: SegmentRecord;
    /// [`crate::policy::PathRecord`] per policy with a space-time grid, and segment.
    POLICY_PATHS = b"PPTH", policy_paths: PathRecord;
    /// [`crate::policy::StateGridRecord`] per adaptive policy and state.
    POLICY_STATE_GRIDS = b"PGRD", policy_state_grids: StateGridRecord;
    /// Value per policy, state and cell (f32).
    POLICY_VALUES = b"PVAL", policy_values: f32;
    /// Best actions per policy, state, cell and choice (u8).
    POLICY_BEST = b"PBST", policy_best: u8;
    /// [`crate::patch::PatchRecord`] per motion patch.
    PATCHES = b"PATC", patches: PatchRecord;
    /// [`crate::patch::EdgeRecord`] per edge of each tile.
    PATCH_EDGES = b"PEDG", patch_edges: EdgeRecord;
    /// [`crate::patch::CellRecord`] per cell of each patch.
    PATCH_CELLS = b"PCEL", patch_cells: CellRecord;
    /// [`crate::patch::LinkRecord`] per link of each patch.
    PATCH_LINKS = b"PLNK", patch_links: LinkRecord;
    /// [`crate::patch::PairRecord`] per action of two people and edge of a tile.
    PATCH_PAIRS = b"PPAR", patch_pairs: PairRecord;
    /// Pose group per frame (u32), [`crate::patch::NONE`] where it has none; empty where frames were not grouped.
    POSE_GROUPS = b"GRPS", pose_groups: u32;
    /// [`crate::blend::BlendRecord`] per blend space.
    BLENDS = b"BLND", blends: BlendRecord;
    /// [`crate::blend::ExampleRecord`] per example of each blend space.
    BLEND_EXAMPLES = b"BEXM", blend_examples: ExampleRecord;
    /// Weight per blend space, knot of its table and example (f32).
    BLEND_WEIGHTS = b"BWGT", blend_weights: f32;
    /// [`crate::blend::ReferenceRow`] per blend space and phase.
    BLEND_REFERENCES = b"BREF", blend_references: ReferenceRow;
    /// [`crate::blend::ChannelRow`] per blend space, phase and example.
    BLEND_CHANNELS = b"BCHN", blend_channels: ChannelRow;
}
