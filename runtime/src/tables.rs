//! Opening a bundle: map, check everything that could go wrong later, hand out views.

use crate::blend::{BlendRecord, Blends, ChannelRow, ExampleRecord, ReferenceRow};
use crate::contacts::Contacts;
use crate::format::{AlignedBytes, ClipRecord, FormatError, FrameRow, Layout, Meta, SkeletonRecord, Storage, Tag};
use crate::graph::{MotionGraph, MotionSegment, StateRecord};
use crate::hits::HitRecord;
use crate::patch::{CellRecord, EdgeRecord, LinkRecord, PatchRecord, Patches};
use crate::policy::{
    ActionTable, KIND_MOMENTS, PathRecord, PolicyRecord, PolicySlices, PolicyTable, SegmentRecord, StateGridRecord,
    TargetGrid,
};
use crate::skeleton::Skeleton;
use bytemuck::Pod;
use std::{ops::Range, path::Path};

/// Tags of the sections, in file order.
pub mod tags {
    use crate::format::Tag;

    /// [`crate::format::Meta`], encoded.
    pub const META: Tag = Tag(*b"META");
    /// One [`crate::format::SkeletonRecord`].
    pub const SKELETON: Tag = Tag(*b"SKEL");
    /// [`crate::format::ClipRecord`] per clip.
    pub const CLIPS: Tag = Tag(*b"CLIP");
    /// [`crate::format::FrameRow`] per frame.
    pub const FRAMES: Tag = Tag(*b"FRAM");
    /// [`crate::Contacts`] per frame.
    pub const CONTACTS: Tag = Tag(*b"CONT");
    /// [`crate::HitRecord`] per effective hit, ascending by frame.
    pub const HITS: Tag = Tag(*b"HITS");
    /// [`crate::graph::StateRecord`] per state.
    pub const STATES: Tag = Tag(*b"STAT");
    /// [`crate::graph::MotionSegment`] per segment.
    pub const SEGMENTS: Tag = Tag(*b"SEGM");
    /// First action of each state, and the number of actions (u32).
    pub const ACTION_OFFSETS: Tag = Tag(*b"AOFF");
    /// Segment of each action (u32).
    pub const ACTION_SEGMENTS: Tag = Tag(*b"ASEG");
    /// Error of each action (f32).
    pub const ACTION_ERRORS: Tag = Tag(*b"AERR");
    /// [`crate::policy::PolicyRecord`] per policy.
    pub const POLICIES: Tag = Tag(*b"POLI");
    /// [`crate::policy::SegmentRecord`] per policy and segment.
    pub const POLICY_SEGMENTS: Tag = Tag(*b"PSEG");
    /// [`crate::policy::PathRecord`] per policy with a grid of moments, and segment.
    pub const POLICY_PATHS: Tag = Tag(*b"PPTH");
    /// [`crate::policy::StateGridRecord`] per adaptive policy and state.
    pub const POLICY_STATE_GRIDS: Tag = Tag(*b"PGRD");
    /// Value per policy, state and cell (f32).
    pub const POLICY_VALUES: Tag = Tag(*b"PVAL");
    /// Best actions per policy, state, cell and choice (u8).
    pub const POLICY_BEST: Tag = Tag(*b"PBST");
    /// [`crate::patch::PatchRecord`] per motion patch.
    pub const PATCHES: Tag = Tag(*b"PATC");
    /// [`crate::patch::EdgeRecord`] per edge of each tile.
    pub const PATCH_EDGES: Tag = Tag(*b"PEDG");
    /// [`crate::patch::CellRecord`] per cell of each patch.
    pub const PATCH_CELLS: Tag = Tag(*b"PCEL");
    /// [`crate::patch::LinkRecord`] per link of each patch.
    pub const PATCH_LINKS: Tag = Tag(*b"PLNK");
    /// Pose group per frame (u32), [`crate::patch::NONE`] where it has none; empty where frames were not grouped.
    pub const POSE_GROUPS: Tag = Tag(*b"GRPS");
    /// [`crate::blend::BlendRecord`] per blend space.
    pub const BLENDS: Tag = Tag(*b"BLND");
    /// [`crate::blend::ExampleRecord`] per example of each blend space.
    pub const BLEND_EXAMPLES: Tag = Tag(*b"BEXM");
    /// Weight per blend space, knot of its table and example (f32).
    pub const BLEND_WEIGHTS: Tag = Tag(*b"BWGT");
    /// [`crate::blend::ReferenceRow`] per blend space and phase.
    pub const BLEND_REFERENCES: Tag = Tag(*b"BREF");
    /// [`crate::blend::ChannelRow`] per blend space, phase and example.
    pub const BLEND_CHANNELS: Tag = Tag(*b"BCHN");
}

#[derive(Debug)]
struct Sections {
    clips: Range<usize>,
    frames: Range<usize>,
    contacts: Range<usize>,
    hits: Range<usize>,
    states: Range<usize>,
    segments: Range<usize>,
    action_offsets: Range<usize>,
    action_segments: Range<usize>,
    action_errors: Range<usize>,
    policies: Range<usize>,
    policy_segments: Range<usize>,
    policy_paths: Range<usize>,
    policy_state_grids: Range<usize>,
    policy_values: Range<usize>,
    policy_best: Range<usize>,
    patches: Range<usize>,
    patch_edges: Range<usize>,
    patch_cells: Range<usize>,
    patch_links: Range<usize>,
    pose_groups: Range<usize>,
    blends: Range<usize>,
    blend_examples: Range<usize>,
    blend_weights: Range<usize>,
    blend_references: Range<usize>,
    blend_channels: Range<usize>,
}

/// An open bundle. Views borrow from it; nothing is copied but META and the skeleton.
///
/// A bundle is mapped, not read: pages come in as they are touched, and several processes share them. Everything a
/// view relies on is checked once, here: magic, version, lengths, alignment, padding, checksums, every stored
/// index against its table, every number for being finite.
#[derive(Debug)]
pub struct Tables {
    storage: Storage,
    meta: Meta,
    skeleton: Skeleton,
    sections: Sections,
    sizes: Vec<(Tag, usize)>,
    fingerprint: u64,
}

impl Tables {
    /// Maps and checks a file.
    ///
    /// # Errors
    /// [`FormatError`] says what is wrong with the file and what to do.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        Self::new(Storage::map(path.as_ref())?, true)
    }

    /// As [`Tables::open`], without comparing the sections' checksums. Everything that a view relies on for its
    /// safety is checked all the same.
    ///
    /// # Errors
    /// As [`Tables::open`].
    pub fn open_unverified(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        Self::new(Storage::map(path.as_ref())?, false)
    }

    /// As [`Tables::open`], of bytes in memory.
    ///
    /// # Errors
    /// As [`Tables::open`].
    pub fn from_bytes(bytes: AlignedBytes) -> Result<Self, FormatError> {
        Self::new(Storage::Memory(bytes), true)
    }

    /// As [`Tables::open_unverified`], of bytes in memory.
    ///
    /// # Errors
    /// As [`Tables::open`].
    pub fn from_bytes_unverified(bytes: AlignedBytes) -> Result<Self, FormatError> {
        Self::new(Storage::Memory(bytes), false)
    }

    fn new(storage: Storage, checksums: bool) -> Result<Self, FormatError> {
        let layout = Layout::read(storage.bytes(), checksums)?;
        let sections = Sections {
            clips: layout.section::<ClipRecord>(tags::CLIPS)?,
            frames: layout.section::<FrameRow>(tags::FRAMES)?,
            contacts: layout.section::<Contacts>(tags::CONTACTS)?,
            hits: layout.section::<HitRecord>(tags::HITS)?,
            states: layout.section::<StateRecord>(tags::STATES)?,
            segments: layout.section::<MotionSegment>(tags::SEGMENTS)?,
            action_offsets: layout.section::<u32>(tags::ACTION_OFFSETS)?,
            action_segments: layout.section::<u32>(tags::ACTION_SEGMENTS)?,
            action_errors: layout.section::<f32>(tags::ACTION_ERRORS)?,
            policies: layout.section::<PolicyRecord>(tags::POLICIES)?,
            policy_segments: layout.section::<SegmentRecord>(tags::POLICY_SEGMENTS)?,
            policy_paths: layout.section::<PathRecord>(tags::POLICY_PATHS)?,
            policy_state_grids: layout.section::<StateGridRecord>(tags::POLICY_STATE_GRIDS)?,
            policy_values: layout.section::<f32>(tags::POLICY_VALUES)?,
            policy_best: layout.section::<u8>(tags::POLICY_BEST)?,
            patches: layout.section::<PatchRecord>(tags::PATCHES)?,
            patch_edges: layout.section::<EdgeRecord>(tags::PATCH_EDGES)?,
            patch_cells: layout.section::<CellRecord>(tags::PATCH_CELLS)?,
            patch_links: layout.section::<LinkRecord>(tags::PATCH_LINKS)?,
            pose_groups: layout.section::<u32>(tags::POSE_GROUPS)?,
            blends: layout.section::<BlendRecord>(tags::BLENDS)?,
            blend_examples: layout.section::<ExampleRecord>(tags::BLEND_EXAMPLES)?,
            blend_weights: layout.section::<f32>(tags::BLEND_WEIGHTS)?,
            blend_references: layout.section::<ReferenceRow>(tags::BLEND_REFERENCES)?,
            blend_channels: layout.section::<ChannelRow>(tags::BLEND_CHANNELS)?,
        };
        let meta = Meta::decode(&storage.bytes()[layout.section::<u8>(tags::META)?])?;
        let record: &[SkeletonRecord] = view(storage.bytes(), &layout.section::<SkeletonRecord>(tags::SKELETON)?);
        let [record] = record else {
            return Err(FormatError::layout(format!("section SKEL has {} elements, expected 1", record.len())));
        };
        let skeleton = Skeleton::from(record);
        let sizes = layout.sizes().collect();
        let fingerprint = layout.fingerprint();
        let tables = Self { storage, meta, skeleton, sections, sizes, fingerprint };
        check::skeleton(&tables.skeleton)?;
        check::motion(&tables)?;
        check::hits(&tables)?;
        check::graph(&tables)?;
        check::policies(&tables)?;
        check::pose_groups(&tables)?;
        check::patches(&tables)?;
        check::blends(&tables)?;
        Ok(tables)
    }

    /// What the bundle says of itself.
    pub fn meta(&self) -> &Meta {
        &self.meta
    }

    /// The database skeleton.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// The clips' places in [`Tables::frames`].
    pub fn clips(&self) -> &[ClipRecord] {
        self.view(&self.sections.clips)
    }

    /// Every frame of every clip.
    pub fn frames(&self) -> &[FrameRow] {
        self.view(&self.sections.frames)
    }

    /// Foot contacts. [Size: frames().len()]
    pub fn contacts(&self) -> &[Contacts] {
        self.view(&self.sections.contacts)
    }

    /// Effective hits, ascending by frame.
    pub fn hits(&self) -> &[HitRecord] {
        self.view(&self.sections.hits)
    }

    /// The motion graph.
    pub fn graph(&self) -> MotionGraph<'_> {
        let s = &self.sections;
        MotionGraph {
            states: self.view(&s.states),
            segments: self.view(&s.segments),
            action_offsets: self.view(&s.action_offsets),
            action_segments: self.view(&s.action_segments),
            action_errors: self.view(&s.action_errors),
        }
    }

    /// Number of policies; their names are `meta().behaviours`.
    pub fn num_policies(&self) -> usize {
        self.policy_records().len()
    }

    /// Number of the policy of a behaviour.
    pub fn find_policy(&self, behaviour: &str) -> Option<usize> {
        self.meta.behaviours.iter().position(|b| b == behaviour)
    }

    /// What is stored of each policy beside its tables.
    pub fn policy_records(&self) -> &[PolicyRecord] {
        self.view(&self.sections.policies)
    }

    /// A policy; checks its tables anew, so take it once and keep it.
    ///
    /// # Panics
    /// Where `index` is not below [`Tables::num_policies`].
    pub fn policy(&self, index: usize) -> PolicyTable<'_> {
        match self.try_policy(index) {
            Ok(p) => p,
            Err(e) => unreachable!("checked when the bundle was opened: {e}"),
        }
    }

    fn try_policy(&self, index: usize) -> Result<PolicyTable<'_>, FormatError> {
        let wrong = |e: crate::policy::PolicyError| FormatError::value(tags::POLICIES, index, e.to_string());
        let graph = self.graph();
        let actions =
            ActionTable::new(graph.action_offsets, graph.action_segments, graph.segments.len()).map_err(wrong)?;
        let (num_states, num_segments) = (graph.states.len(), graph.segments.len());
        let records = self.policy_records();
        let (mut values_start, mut paths_start, mut grids_start, mut best_start) = (0usize, 0usize, 0usize, 0usize);
        for (i, r) in records[..=index].iter().enumerate() {
            let num_paths = if r.grid.kind == KIND_MOMENTS { num_segments } else { 0 };
            let num_grids = if r.adaptive == 0 { 0 } else { num_states };
            let state_grids = part(self.view(&self.sections.policy_state_grids), grids_start, num_grids);
            let num_values = match r.adaptive {
                0 => TargetGrid::new(r.grid).map_err(wrong)?.num_cells().saturating_mul(num_states),
                _ => state_grids.iter().fold(0, |sum: usize, g: &StateGridRecord| sum.saturating_add(g.num_cells())),
            };
            let num_best = num_values.saturating_mul(r.num_choices as usize);
            if i == index {
                let slices = PolicySlices {
                    segments: part(self.view(&self.sections.policy_segments), i * num_segments, num_segments),
                    paths: part(self.view(&self.sections.policy_paths), paths_start, num_paths),
                    state_grids,
                    values: part(self.view(&self.sections.policy_values), values_start, num_values),
                    best: part(self.view(&self.sections.policy_best), best_start, num_best),
                };
                return PolicyTable::new(r, actions, slices).map_err(wrong);
            }
            paths_start = paths_start.saturating_add(num_paths);
            grids_start = grids_start.saturating_add(num_grids);
            values_start = values_start.saturating_add(num_values);
            best_start = best_start.saturating_add(num_best);
        }
        Err(FormatError::value(tags::POLICIES, index, "no such policy"))
    }

    /// The motion patches; empty where the bundle was built without them.
    pub fn patches(&self) -> Patches<'_> {
        let s = &self.sections;
        Patches {
            patches: self.view(&s.patches),
            edges: self.view(&s.patch_edges),
            cells: self.view(&s.patch_cells),
            links: self.view(&s.patch_links),
        }
    }

    /// Pose group of every frame, [`crate::patch::NONE`] where a frame has none; empty where frames were not
    /// grouped. [Size: frames().len() or 0]
    pub fn pose_groups(&self) -> &[u32] {
        self.view(&self.sections.pose_groups)
    }

    /// The blend spaces; empty where the bundle was built without them.
    pub fn blends(&self) -> Blends<'_> {
        let s = &self.sections;
        Blends {
            spaces: self.view(&s.blends),
            examples: self.view(&s.blend_examples),
            weights: self.view(&s.blend_weights),
            references: self.view(&s.blend_references),
            channels: self.view(&s.blend_channels),
        }
    }

    /// Number of the blend space of a name.
    pub fn find_blend(&self, name: &str) -> Option<usize> {
        self.meta.blends.iter().position(|b| b.name == name)
    }

    /// A number that tells this bundle's content from others: of the checksums of all sections, and the length.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// Tag and length of every section, in file order. [Unit: bytes]
    pub fn section_sizes(&self) -> &[(Tag, usize)] {
        &self.sizes
    }

    /// Length of the bundle. [Unit: bytes]
    pub fn num_bytes(&self) -> usize {
        self.storage.bytes().len()
    }

    fn view<T: Pod>(&self, range: &Range<usize>) -> &[T] {
        view(self.storage.bytes(), range)
    }
}

/// The part of a slice, or an empty one where it has no such part: the policy's own check then names the lengths.
fn part<T>(all: &[T], start: usize, len: usize) -> &[T] {
    start.checked_add(len).and_then(|end| all.get(start..end)).unwrap_or(&[])
}

/// Sections start on 64 bytes of memory that does too, and their element size was compared with `T`'s.
fn view<'a, T: Pod>(bytes: &'a [u8], range: &Range<usize>) -> &'a [T] {
    bytemuck::cast_slice(&bytes[range.clone()])
}

mod check;
