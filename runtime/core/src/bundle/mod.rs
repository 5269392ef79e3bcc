//! Opening a bundle: read or map, check everything that could go wrong later, hand out views.

mod check;
mod policies;
mod sections;

pub use sections::tags;

use crate::blend::{Activity, ActivitySet, BlendSpace, Blends};
use crate::format::{
    ActivityMeta, AlignedBytes, ClipRecord, FileStorage, FormatError, FrameRow, Meta, RotationCode, SectionLayout,
    SectionTag, Table,
};
use crate::policy::{PolicyRecord, PolicyTable};
use crate::{body::ClipRows, contacts::Contacts};
use crate::{graph::MotionGraph, hits::HitRecord, patch::PatchTables, skeleton::Skeleton, stops::StopTables};
use sections::Sections;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use throng_base::{Error, Hash128, Result, error::ensure};

/// Description of the files' content, for messages.
const WHAT: &str = "a bundle";

/// An open bundle. A clone is cheap, and all clones share one file; nothing is copied but META and the skeleton.
///
/// [`Bundle::open`] reads the file: nothing that happens to it later is seen. [`Bundle::map`] maps it: pages come in as
/// they are touched, and several processes share them. Everything that is looked up later is checked once, here: magic,
/// version, lengths, alignment, padding, checksums, every stored index against its table, every number for being finite.
///
/// ```no_run
/// let bundle = throng_core::Bundle::open("people.throng")?;
/// println!("{}: {:?}", bundle.meta().name, bundle.meta().behaviours);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bundle {
    shared: Arc<OpenedBundle>,
    policies: Arc<[PolicyTable]>,
}

/// Data shared by all clones of a bundle.
#[derive(Debug)]
struct OpenedBundle {
    storage: Arc<FileStorage>,
    meta: Meta,
    skeleton: Skeleton,
    layout: SectionLayout,
    sections: Sections,
    graph: MotionGraph,
    stops: StopTables,
    patches: PatchTables,
    blends: Blends,
    hash: OnceLock<u128>,
}

impl Bundle {
    /// Reads and checks a file. It may be replaced, overwritten or cut short afterwards.
    ///
    /// # Errors
    /// [`FormatError`] says what is wrong with the file and what to do.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        Self::new(FileStorage::read(path.as_ref(), WHAT)?, true)
    }

    /// Maps and checks a file, as [`Bundle::open`] reads it: useful where several processes share one bundle of many
    /// megabytes. The check reads all of it once; the system may drop the pages from memory again.
    ///
    /// # Errors
    /// As [`Bundle::open`].
    ///
    /// # Safety
    /// For as long as the bundle, a clone or anything made with it lives, the file must not be written into or cut
    /// short, in this process or another: numbers that were checked would change, or reading them would end the
    /// process. Renaming a new file over it is fine; all writers of this workspace do so.
    #[allow(unsafe_code)]
    pub unsafe fn map(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        // SAFETY: the caller promises what is asked for.
        Self::new(unsafe { FileStorage::map(path.as_ref(), WHAT) }?, true)
    }

    /// Maps a file as [`Bundle::map`] does, without comparing the sections' checksums, see [`Bundle::open_unverified`].
    ///
    /// # Errors
    /// As [`Bundle::open`].
    ///
    /// # Safety
    /// As [`Bundle::map`].
    #[allow(unsafe_code)]
    pub unsafe fn map_unverified(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        // SAFETY: the caller promises what is asked for.
        Self::new(unsafe { FileStorage::map(path.as_ref(), WHAT) }?, false)
    }

    /// Reads a file as [`Bundle::open`] does, without comparing the sections' checksums. Everything that a view relies
    /// on for its safety is still checked.
    ///
    /// # Errors
    /// As [`Bundle::open`].
    pub fn open_unverified(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        Self::new(FileStorage::read(path.as_ref(), WHAT)?, false)
    }

    /// Checks and opens a bundle in memory, see [`Bundle::open`].
    ///
    /// # Errors
    /// As [`Bundle::open`].
    pub fn from_bytes(bytes: AlignedBytes) -> Result<Self, FormatError> {
        Self::new(FileStorage::Memory(bytes), true)
    }

    /// Opens a bundle in memory without comparing the sections' checksums, see [`Bundle::open_unverified`].
    ///
    /// # Errors
    /// As [`Bundle::open`].
    pub fn from_bytes_unverified(bytes: AlignedBytes) -> Result<Self, FormatError> {
        Self::new(FileStorage::Memory(bytes), false)
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        self.shared.storage.bytes()
    }

    fn new(storage: FileStorage, checksums: bool) -> Result<Self, FormatError> {
        let layout = SectionLayout::read(storage.bytes(), checksums)?;
        let storage = Arc::new(storage);
        let s = Sections::new(&storage, &layout)?;
        let meta = Meta::decode(&s.meta)?;
        for (tag, len) in [(tags::SKELETON, s.skeleton.len()), (tags::ROTATION_CODE, s.rotation_code.len())] {
            ensure(len == 1, || FormatError::layout(format!("section {tag} has {len} elements, expected 1")))?;
        }
        let skeleton = Skeleton::from(&s.skeleton[0]);
        let shared = OpenedBundle {
            storage,
            layout,
            graph: MotionGraph {
                states: s.states.clone(),
                segments: s.segments.clone(),
                action_offsets: s.action_offsets.clone(),
                action_segments: s.action_segments.clone(),
                // Those of policies with errors of their own follow.
                action_errors: s.action_errors.part(0..s.action_segments.len()).unwrap_or_default(),
            },
            stops: StopTables { sweeps: s.sweeps.clone(), nodes: s.sweep_nodes.clone(), stops: s.stops.clone() },
            patches: PatchTables {
                patches: s.patches.clone(),
                edges: s.patch_edges.clone(),
                cells: s.patch_cells.clone(),
                links: s.patch_links.clone(),
                pairs: s.patch_pairs.clone(),
            },
            blends: Blends {
                spaces: s.blends.clone(),
                examples: s.blend_examples.clone(),
                weights: s.blend_weights.clone(),
                references: s.blend_references.clone(),
                channels: s.blend_channels.clone(),
                names: meta.blends.iter().map(|b| b.name.clone()).collect(),
                skeleton: skeleton.clone(),
            },
            skeleton,
            meta,
            sections: s,
            hash: OnceLock::new(),
        };
        let mut bundle = Self { shared: Arc::new(shared), policies: Arc::default() };
        check::skeleton(bundle.skeleton())?;
        check::motion(&bundle)?;
        check::hits(&bundle)?;
        check::graph(&bundle)?;
        check::stops(&bundle)?;
        bundle.policies = policies::open_policies(&bundle)?.into();
        check::pose_groups(&bundle)?;
        check::patches(&bundle)?;
        check::blends(&bundle)?;
        check::activities(&bundle)?;
        Ok(bundle)
    }

    /// Metadata of the bundle: names, rates, sources.
    pub fn meta(&self) -> &Meta {
        &self.shared.meta
    }

    /// The database skeleton.
    pub fn skeleton(&self) -> &Skeleton {
        &self.shared.skeleton
    }

    /// The clips' places in [`Bundle::frames`].
    pub fn clips(&self) -> &Table<ClipRecord> {
        &self.shared.sections.clips
    }

    /// Every frame of every clip.
    pub fn frames(&self) -> &Table<FrameRow> {
        &self.shared.sections.frames
    }

    /// Code by which the rotations of [`Bundle::frames`] are packed.
    pub fn rotation_code(&self) -> &RotationCode {
        &self.shared.sections.rotation_code[0]
    }

    /// Foot contacts (frames().len()).
    pub fn contacts(&self) -> &Table<Contacts> {
        &self.shared.sections.contacts
    }

    /// Effective hits, ascending by frame.
    pub fn hits(&self) -> &Table<HitRecord> {
        &self.shared.sections.hits
    }

    /// The motion graph.
    pub fn graph(&self) -> &MotionGraph {
        &self.shared.graph
    }

    /// The stop tables of the motion graph.
    pub fn stops(&self) -> &StopTables {
        &self.shared.stops
    }

    /// The policies; their names are `meta().behaviours`.
    pub fn policies(&self) -> &Arc<[PolicyTable]> {
        &self.policies
    }

    /// Record of each policy beside its tables (policies().len()).
    pub fn policy_records(&self) -> &[PolicyRecord] {
        &self.shared.sections.policies
    }

    /// Number of the policy of a behaviour.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the names there are.
    pub fn find_policy(&self, behaviour: &str) -> Result<usize> {
        let names = &self.meta().behaviours;
        names.iter().position(|b| b == behaviour).ok_or_else(|| unknown("behaviour", behaviour, names.clone()))
    }

    /// The motion patches; empty where the bundle was built without them.
    pub fn patches(&self) -> &PatchTables {
        &self.shared.patches
    }

    /// Pose group of every frame, [`crate::patch::NONE`] where a frame has none; empty where frames were not
    /// grouped (frames().len() or 0).
    pub fn pose_groups(&self) -> &[u32] {
        &self.shared.sections.pose_groups
    }

    /// The blend spaces; empty where the bundle was built without them.
    pub fn blends(&self) -> &Blends {
        &self.shared.blends
    }

    /// Number of the blend space of a name.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the names there are.
    pub fn find_blend(&self, name: &str) -> Result<usize> {
        let names = self.meta().blends.iter().map(|b| &b.name);
        names.clone().position(|b| b == name).ok_or_else(|| unknown("blend space", name, names.cloned().collect()))
    }

    /// The blend space of a name, ready to be asked.
    ///
    /// # Errors
    /// As [`Bundle::find_blend`].
    pub fn blend(&self, name: &str) -> Result<BlendSpace> {
        let space = BlendSpace::new(self.blends(), self.find_blend(name)?);
        let space = space.unwrap_or_else(|e| unreachable!("checked when the bundle was opened: {e}"));
        Ok(space.with_activities(self.activities()).with_clips(self.clips(), self.meta().rate_hz as f32))
    }

    /// The activities; empty where the bundle was built without them.
    pub fn activities(&self) -> ActivitySet {
        let (activities, rate_hz) = (&self.meta().activities, self.meta().rate_hz as f32);
        let activity = |a: &ActivityMeta| Activity::new(a, &self.clips()[a.clip as usize], rate_hz);
        ActivitySet {
            activities: activities.iter().map(activity).collect(),
            contacts: self.contacts().clone(),
            skeleton: self.skeleton().clone(),
            rows: self.clip_rows(),
        }
    }

    /// Frames that layers may show.
    pub(crate) fn clip_rows(&self) -> ClipRows {
        let (frames, code) = (self.frames().clone(), self.shared.sections.rotation_code.clone());
        ClipRows::new(frames, code, self.clips(), self.meta())
    }

    /// A hash of the whole content. All bytes are read when it is asked for the first time.
    pub fn hash(&self) -> u128 {
        *self.shared.hash.get_or_init(|| Hash128::hash_bytes(self.bytes()))
    }

    /// True where both have the same content. Clones are compared at once, bundles that were opened one by one by [`Bundle::hash`].
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.shared, &other.shared) || self.hash() == other.hash()
    }

    /// Tag and length of every section, in file order (bytes).
    pub fn section_sizes(&self) -> impl Iterator<Item = (SectionTag, usize)> + '_ {
        self.shared.layout.sections().iter().map(|(s, bytes)| (s.tag, bytes.len()))
    }

    /// Bytes of a section, and the length of one of its elements (bytes); none where there is no such section. For
    /// callers that read the rows themselves, such as arrays of other languages.
    pub fn section_bytes(&self, tag: SectionTag) -> Option<(&[u8], usize)> {
        let (s, bytes) = self.shared.layout.sections().iter().find(|(s, _)| s.tag == tag)?;
        Some((&self.bytes()[bytes.clone()], s.elem_size as usize))
    }

    /// Length of the bundle (bytes).
    pub fn num_bytes(&self) -> usize {
        self.bytes().len()
    }

    fn sections(&self) -> &Sections {
        &self.shared.sections
    }
}

fn unknown(what: &'static str, name: &str, known: Vec<String>) -> Error {
    Error::Unknown { what, name: name.into(), known }
}
