//! World files (`*.world`): the frame of a bundle under a name of its own, with the records of a world.
//!
//! Version history (a number is never used twice; any change of layout or meaning takes the next one):
//!
//! - 1: units, instances, neighbours, bits of cells and links, adjacencies, joint tables, resources.

use super::{AdjacencyRecord, InstanceRecord, JointRecord, JointTableRecord, UnitRecord};
use super::{WorldData, WorldError, WorldMeta, WorldView, check};
use crate::format::{AlignedBytes, BundleWriter, Kind, Layout, Storage};
use crate::tables::Tables;
use bytemuck::Pod;
use std::{io, ops::Range, path::Path};

/// First bytes of every world file.
pub const WORLD_MAGIC: [u8; 8] = *b"\x89THWRLD\n";
/// The version of world files that this code writes and reads.
pub const WORLD_VERSION: u32 = 1;

const KIND: Kind = Kind { magic: WORLD_MAGIC, version: WORLD_VERSION };

/// Tags of the sections, in file order.
pub mod tags {
    use crate::format::Tag;

    /// [`crate::world::WorldMeta`], encoded.
    pub const META: Tag = Tag(*b"WMET");
    /// [`crate::world::UnitRecord`] per unit.
    pub const UNITS: Tag = Tag(*b"WUNI");
    /// [`crate::world::InstanceRecord`] per instance.
    pub const INSTANCES: Tag = Tag(*b"WINS");
    /// Instance across each edge of each tile (u32).
    pub const NEIGHBOURS: Tag = Tag(*b"WNEI");
    /// Bits of the cells (u64).
    pub const CELLS: Tag = Tag(*b"WCEL");
    /// Bits of the links (u64).
    pub const LINKS: Tag = Tag(*b"WLNK");
    /// [`crate::world::AdjacencyRecord`] per instance and other instance that it overlaps.
    pub const ADJACENCIES: Tag = Tag(*b"WADJ");
    /// [`crate::world::JointTableRecord`] per table.
    pub const TABLES: Tag = Tag(*b"WTAB");
    /// [`crate::world::JointRecord`] per joint of each table.
    pub const JOINTS: Tag = Tag(*b"WJOI");
    /// Joints of each table by their side b (u32).
    pub const JOINTS_BY_B: Tag = Tag(*b"WJOB");
    /// Bits of the joints (u64).
    pub const JOINT_BITS: Tag = Tag(*b"WJBT");
    /// Units of each instance (u32).
    pub const RESOURCES: Tag = Tag(*b"WRES");
}

#[derive(Debug)]
struct Sections {
    units: Range<usize>,
    instances: Range<usize>,
    neighbours: Range<usize>,
    cells: Range<usize>,
    links: Range<usize>,
    adjacencies: Range<usize>,
    tables: Range<usize>,
    joints: Range<usize>,
    joints_by_b: Range<usize>,
    joint_bits: Range<usize>,
    resources: Range<usize>,
}

/// An open world file. As with [`Tables`], everything that a view relies on is checked once, when it is opened.
#[derive(Debug)]
pub struct WorldFile {
    storage: Storage,
    meta: WorldMeta,
    sections: Sections,
}

impl WorldFile {
    /// Maps and checks a file against the bundle it was stitched with.
    ///
    /// # Errors
    /// [`WorldError`] says what is wrong with the file, or that it belongs to another bundle, and what to do.
    pub fn open(path: impl AsRef<Path>, tables: &Tables) -> Result<Self, WorldError> {
        Self::new(Storage::map(path.as_ref())?, tables)
    }

    /// As [`WorldFile::open`], of bytes in memory.
    ///
    /// # Errors
    /// As [`WorldFile::open`].
    pub fn from_bytes(bytes: AlignedBytes, tables: &Tables) -> Result<Self, WorldError> {
        Self::new(Storage::Memory(bytes), tables)
    }

    fn new(storage: Storage, tables: &Tables) -> Result<Self, WorldError> {
        let layout = Layout::read_kind(storage.bytes(), true, KIND)?;
        let sections = Sections {
            units: layout.section::<UnitRecord>(tags::UNITS)?,
            instances: layout.section::<InstanceRecord>(tags::INSTANCES)?,
            neighbours: layout.section::<u32>(tags::NEIGHBOURS)?,
            cells: layout.section::<u64>(tags::CELLS)?,
            links: layout.section::<u64>(tags::LINKS)?,
            adjacencies: layout.section::<AdjacencyRecord>(tags::ADJACENCIES)?,
            tables: layout.section::<JointTableRecord>(tags::TABLES)?,
            joints: layout.section::<JointRecord>(tags::JOINTS)?,
            joints_by_b: layout.section::<u32>(tags::JOINTS_BY_B)?,
            joint_bits: layout.section::<u64>(tags::JOINT_BITS)?,
            resources: layout.section::<u32>(tags::RESOURCES)?,
        };
        let meta = WorldMeta::decode(&storage.bytes()[layout.section::<u8>(tags::META)?])?;
        if meta.fingerprint != tables.fingerprint() {
            let (bundle, given) = (meta.bundle, tables.meta().name.clone());
            return Err(WorldError::OtherBundle { world: meta.name, bundle, given });
        }
        let file = Self { storage, meta, sections };
        check::world(&file.view(), &tables.patches())?;
        Ok(file)
    }

    /// What the world says of itself.
    pub fn meta(&self) -> &WorldMeta {
        &self.meta
    }

    /// The world.
    pub fn view(&self) -> WorldView<'_> {
        let s = &self.sections;
        WorldView {
            units: self.section(&s.units),
            instances: self.section(&s.instances),
            neighbours: self.section(&s.neighbours),
            cell_words: self.section(&s.cells),
            link_words: self.section(&s.links),
            adjacencies: self.section(&s.adjacencies),
            tables: self.section(&s.tables),
            joints: self.section(&s.joints),
            joints_by_b: self.section(&s.joints_by_b),
            joint_words: self.section(&s.joint_bits),
            resources: self.section(&s.resources),
        }
    }

    /// Length of the file. [Unit: bytes]
    pub fn num_bytes(&self) -> usize {
        self.storage.bytes().len()
    }

    fn section<T: Pod>(&self, range: &Range<usize>) -> &[T] {
        bytemuck::cast_slice(&self.storage.bytes()[range.clone()])
    }
}

impl WorldData {
    /// Writes the world as a file.
    ///
    /// # Errors
    /// What `out` returns, or [`io::ErrorKind::InvalidData`] where the meta data cannot be encoded.
    pub fn write(&self, out: &mut impl io::Write) -> io::Result<()> {
        let mut file = BundleWriter::new();
        file.section(tags::META, &self.meta.encode().map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?);
        file.section(tags::UNITS, &self.units);
        file.section(tags::INSTANCES, &self.instances);
        file.section(tags::NEIGHBOURS, &self.neighbours);
        file.section(tags::CELLS, &self.cell_words);
        file.section(tags::LINKS, &self.link_words);
        file.section(tags::ADJACENCIES, &self.adjacencies);
        file.section(tags::TABLES, &self.tables);
        file.section(tags::JOINTS, &self.joints);
        file.section(tags::JOINTS_BY_B, &self.joints_by_b);
        file.section(tags::JOINT_BITS, &self.joint_words);
        file.section(tags::RESOURCES, &self.resources);
        file.write_kind(out, KIND)
    }

    /// Checks the world as a file of it would be: every index against its table, every number for being finite.
    ///
    /// # Errors
    /// [`WorldError::Value`] or [`WorldError::Layout`].
    pub fn check(&self, patches: &crate::patch::Patches<'_>) -> Result<(), WorldError> {
        check::world(&self.view(), patches)
    }
}
