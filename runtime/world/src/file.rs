//! World files (`*.world`): the frame of a bundle under a name of its own, with the records of a world.
//!
//! Version history (a number is never used twice; any change of layout or meaning takes the next one):
//!
//! - 1: units, instances, neighbours, bits of cells and links, adjacencies, joint tables, resources.
//! - 2: path costs, which planners worked out at every start before; content hashes of the bundle and of the source.
//! - 3: the file that it was stitched from.

use super::graph::{BakedCosts, PathCosts};
use super::{WorldData, WorldError, WorldGraph, WorldMeta, WorldNode, WorldTables, check, tags};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};
use std::{io, path::Path};
use throng_base::{Error, Hash128, Result, error};
use throng_core::format::{
    AlignedBytes, BundleWriter, FileKind, FileStorage, FormatError, SectionLayout, Table, decode, encode,
};
use throng_core::{Bundle, characters::MotionSet};

/// First bytes of every world file.
pub const WORLD_MAGIC: [u8; 8] = *b"\x89THWRLD\n";
/// The version of world files that this code writes and reads.
pub const WORLD_VERSION: u32 = 4;

/// Description of the files' content, for messages.
const WHAT: &str = "a world";

const KIND: FileKind = FileKind { what: "world", magic: WORLD_MAGIC, version: WORLD_VERSION };

/// A world with the bundle it was stitched with, ready to plan in and to live in. Clones are cheap and share all of it.
///
/// As with [`Bundle`], everything that is relied on later is checked once, when it is opened. What planning knows of the
/// world beforehand lies in the file, so that opening it takes milliseconds.
///
/// ```no_run
/// use throng_core::{Bundle, glam::Vec3};
/// use throng_world::World;
///
/// let bundle = Bundle::open("playground.throng")?;
/// let world = World::open("playground.world", &bundle)?;
/// println!("somebody can stand at {}", world.nearest_place(Vec3::ZERO, 20.0)?.at);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct World(Arc<Opened>);

#[derive(Debug)]
struct Opened {
    meta: WorldMeta,
    graph: WorldGraph,
    /// Path costs as its file keeps them; none for a world in memory.
    paths: Option<Table<u8>>,
    motion_set: MotionSet,
    bundle_hash: u128,
    num_bytes: usize,
    hash: OnceLock<u128>,
}

impl World {
    /// Reads and checks a file against the bundle it was stitched with. It may be replaced, overwritten or cut short
    /// afterwards.
    ///
    /// # Errors
    /// [`Error::Io`], [`Error::Format`] with what is wrong with the file and what to do, or [`Error::OtherBundle`].
    pub fn open(path: impl AsRef<Path>, bundle: &Bundle) -> Result<Self> {
        Self::of_file(FileStorage::read(path.as_ref(), WHAT), path.as_ref(), bundle)
    }

    /// Maps and checks a file, see [`World::open`]: several processes share its pages.
    ///
    /// # Errors
    /// As [`World::open`].
    ///
    /// # Safety
    /// As [`Bundle::map`].
    #[allow(unsafe_code)]
    pub unsafe fn map(path: impl AsRef<Path>, bundle: &Bundle) -> Result<Self> {
        // SAFETY: the caller promises what is asked for.
        Self::of_file(unsafe { FileStorage::map(path.as_ref(), WHAT) }, path.as_ref(), bundle)
    }

    fn of_file(storage: Result<FileStorage, FormatError>, path: &Path, bundle: &Bundle) -> Result<Self> {
        let open = || Self::new(storage?, bundle);
        open().map_err(|e| match e {
            WorldError::Format(FormatError::Io { path, source }) => Error::Io { path, source },
            WorldError::OtherBundle { expected, got, .. } => Error::OtherBundle { expected, got },
            e => Error::Format { path: path.to_path_buf(), why: e.to_string() },
        })
    }

    /// Checks and opens a world in memory, see [`World::open`].
    ///
    /// # Errors
    /// [`WorldError`] says what is wrong, or that the world belongs to another bundle, and what to do.
    pub fn from_bytes(bytes: AlignedBytes, bundle: &Bundle) -> Result<Self, WorldError> {
        Self::new(FileStorage::Memory(bytes), bundle)
    }

    /// Reads the metadata of a file, for any bundle that it was stitched with.
    ///
    /// # Errors
    /// [`WorldError`] for a file that is no world of this version.
    pub fn read_meta(path: &Path) -> Result<WorldMeta, WorldError> {
        let storage = FileStorage::read(path, WHAT)?;
        let layout = SectionLayout::read_kind(storage.bytes(), true, KIND)?;
        Ok(decode("WMET", &storage.bytes()[layout.section::<u8>(tags::META)?])?)
    }

    fn new(storage: FileStorage, bundle: &Bundle) -> Result<Self, WorldError> {
        let layout = SectionLayout::read_kind(storage.bytes(), true, KIND)?;
        let storage = Arc::new(storage);
        let view = WorldTables::of_file(&storage, &layout)?;
        let meta: WorldMeta = decode("WMET", &storage.bytes()[layout.section::<u8>(tags::META)?])?;
        if meta.bundle_hash != bundle.hash() {
            let (expected, got) = (meta.bundle_hash, bundle.hash());
            let given = bundle.meta().name.clone();
            return Err(WorldError::OtherBundle { world: meta.name, bundle: meta.bundle, given, expected, got });
        }
        check::world(&view, bundle.patches())?;
        let paths: Table<u8> = Table::of_file(&storage, &layout.section::<u8>(tags::PATHS)?);
        let graph = WorldGraph::from_baked(bundle.patches(), &view, BakedCosts::decode(&paths)?)?;
        Ok(Self::opened(meta, graph, Some(paths), bundle, storage.bytes().len()))
    }

    fn opened(meta: WorldMeta, graph: WorldGraph, paths: Option<Table<u8>>, bundle: &Bundle, num_bytes: usize) -> Self {
        let (motion_set, bundle_hash) = (MotionSet::new(bundle), bundle.hash());
        Self(Arc::new(Opened { meta, graph, paths, motion_set, bundle_hash, num_bytes, hash: OnceLock::new() }))
    }

    /// A world in memory, as it was stitched. Its path costs are worked out when the first path is planned.
    ///
    /// # Errors
    /// As [`WorldGraph::new`].
    pub fn from_data(data: &WorldData, bundle: &Bundle) -> Result<Self, FormatError> {
        Ok(Self::opened(data.meta.clone(), WorldGraph::new(bundle.patches(), &data.tables())?, None, bundle, 0))
    }

    /// Metadata of the world.
    pub fn meta(&self) -> &WorldMeta {
        &self.0.meta
    }

    /// The graph over it.
    pub fn graph(&self) -> &WorldGraph {
        &self.0.graph
    }

    /// The motion of its bundle.
    pub fn motion_set(&self) -> &MotionSet {
        &self.0.motion_set
    }

    /// The records.
    pub fn view(&self) -> &WorldTables {
        self.0.graph.world()
    }

    /// Length of the file; 0 for a world in memory (bytes).
    pub fn num_bytes(&self) -> usize {
        self.0.num_bytes
    }

    /// Content hash of its bundle.
    pub fn bundle_hash(&self) -> u128 {
        self.0.bundle_hash
    }

    /// Content hash of the rows, of the path costs and of the bundle; found when it is first asked for.
    pub fn hash(&self) -> u128 {
        *self.0.hash.get_or_init(|| {
            let (mut hash, view) = (Hash128::default(), self.view());
            hash.add_bytes(&self.bundle_hash().to_le_bytes());
            view.hash_rows(&mut hash);
            match &self.0.paths {
                Some(paths) => hash.add_bytes(paths),
                // Writing to memory what can be written cannot fail.
                None => hash.add_bytes(&PathCosts::bake(self.graph()).unwrap_or_default().0),
            }
            hash.finish()
        })
    }

    /// The place nearest to a point where a character may stay.
    ///
    /// - `within_m`: no farther away than that (m).
    ///
    /// # Errors
    /// [`Error::Value`] for a point that is not finite, or where the nearest place is farther away: `got` says how far.
    pub fn nearest_place(&self, at: Vec3, within_m: f32) -> Result<RestPlace> {
        error::check_value("point", None, at.length(), at.is_finite(), "finite")?;
        let place =
            self.graph().nearest_rest(at).map(|node| RestPlace { node, at: self.graph().place(node).translation() });
        let away = place.map_or(f32::INFINITY, |p| p.at.distance(at));
        let expected = "no more than was asked for; name a point nearer to where one can stay";
        error::check_value("distance to the nearest place to stay (m)", None, away, away <= within_m, expected)?;
        place.ok_or(Error::Value { what: "places to stay", who: None, got: 0.0, expected: "at least one" })
    }
}

/// A place in a world where a character may stay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RestPlace {
    /// The node of the world's graph.
    pub node: WorldNode,
    /// Position of the hips at the node (m).
    pub at: Vec3,
}

impl WorldData {
    /// Writes the world as a file.
    ///
    /// - `paths`: of this world as it is, see [`PathCosts::bake`].
    ///
    /// # Errors
    /// What `out` returns, or [`io::ErrorKind::InvalidData`] where the meta data cannot be encoded.
    pub fn write(&self, paths: &PathCosts, out: &mut impl io::Write) -> io::Result<()> {
        let mut file = BundleWriter::new();
        file.section(
            tags::META,
            &encode("WMET", &self.meta).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?,
        );
        self.add_sections(&mut file);
        file.section(tags::PATHS, &paths.0);
        file.write_kind(out, KIND)
    }

    /// Checks the world as a file of it would be: every index against its table, every number for being finite.
    ///
    /// # Errors
    /// [`FormatError::Value`] or [`FormatError::Section`].
    pub fn check(&self, patches: &throng_core::patch::PatchTables) -> Result<(), FormatError> {
        check::world(&self.tables(), patches)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up_floor::{tables, world};

    #[test]
    fn worlds_whose_path_costs_differ_are_told_apart() {
        let tables = tables();
        let data = world(&tables, &["######", "#b####", "######", "###...", "#b#...", "###..."]);
        let memory = World::from_data(&data, &tables).unwrap();
        let mut costs = PathCosts::bake(memory.graph()).unwrap();
        let hash = |costs: &PathCosts| {
            let mut bytes = Vec::new();
            data.write(costs, &mut bytes).unwrap();
            World::from_bytes(AlignedBytes::from_slice(&bytes), &tables).unwrap().hash()
        };
        assert_eq!(hash(&costs), memory.hash(), "of a file and in memory");
        // Changes the cost from the last state to the last landmark.
        *costs.0.last_mut().unwrap() ^= 1;
        assert_ne!(hash(&costs), memory.hash());
    }
}
