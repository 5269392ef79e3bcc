//! Opened levels: every index and number of the file is checked once.

use crate::records::{KIND, LevelTables};
use crate::{LevelData, LevelHead, LevelLink, LevelPlace, LevelWall, NONE};
use glam::{DVec2, Vec3};
use std::path::Path;
use std::sync::Arc;
use throng_base::frame::{AlignedBytes, FileStorage, FormatError, SectionLayout, SectionTag};
use throng_base::{Error, Result, error::ensure};

/// Most links: the table of their costs grows with the square.
const MAX_LINKS: usize = 1000;
/// Largest difference between the heights of the ends of a wall of one floor (m).
const MOST_RISE_M: f32 = 0.5;
/// Coordinates are smaller than this (m).
const FARTHEST_M: f32 = 1e5;

/// A level. Clones are cheap and share its file.
#[derive(Clone, Debug)]
pub struct Level(pub(crate) Arc<LevelTables>);

/// Named place of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedPlace<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its kind.
    pub kind: &'a str,
    /// Point on the ground (m).
    pub at: Vec3,
}

impl Level {
    /// Reads and checks a file, which may be replaced afterwards.
    ///
    /// # Errors
    /// [`Error::Io`], or [`Error::Format`] with what is wrong with the file and what to do.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::from_storage(FileStorage::read(path.as_ref(), "a level"), path.as_ref())
    }

    /// Maps and checks a file, see [`Level::open`]: several processes share its pages.
    ///
    /// # Errors
    /// As [`Level::open`].
    ///
    /// # Safety
    /// As [`FileStorage::map`].
    #[allow(unsafe_code)]
    pub unsafe fn map(path: impl AsRef<Path>) -> Result<Self> {
        // SAFETY: the caller promises what is asked for.
        Self::from_storage(unsafe { FileStorage::map(path.as_ref(), "a level") }, path.as_ref())
    }

    /// Checks a level in memory.
    ///
    /// # Errors
    /// What is wrong, and what to do.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::new(FileStorage::Memory(AlignedBytes::from_slice(bytes)))
    }

    /// Level of tables in memory.
    ///
    /// # Errors
    /// As [`Level::from_bytes`].
    pub fn from_data(data: &LevelData) -> Result<Self, FormatError> {
        let mut bytes = Vec::new();
        data.write(&mut bytes).map_err(|e| FormatError::layout(e.to_string()))?;
        Self::from_bytes(&bytes)
    }

    fn from_storage(storage: Result<FileStorage, FormatError>, path: &Path) -> Result<Self> {
        storage.and_then(Self::new).map_err(|e| match e {
            FormatError::Io { path, source } => Error::Io { path, source },
            e => Error::Format { path: path.to_path_buf(), why: e.to_string() },
        })
    }

    fn new(storage: FileStorage) -> Result<Self, FormatError> {
        let layout = SectionLayout::read_kind(storage.bytes(), true, KIND)?;
        let tables = LevelTables::new(&Arc::new(storage), &layout)?;
        check(&tables)?;
        Ok(Self(Arc::new(tables)))
    }

    /// Settings that it was made with.
    pub fn head(&self) -> &LevelHead {
        &self.0.head[0]
    }

    /// Number of convex parts of the ground.
    pub fn num_polygons(&self) -> usize {
        self.0.polygons.len()
    }

    /// Number of the connected part of the ground that a polygon belongs to (polygon < number of polygons).
    pub fn component(&self, polygon: u32) -> u32 {
        self.0.polygons[polygon as usize].component
    }

    /// Number of the place that a polygon is of (polygon < number of polygons).
    pub fn place_of(&self, polygon: u32) -> Option<usize> {
        Some(self.0.polygons[polygon as usize].place as usize).filter(|&p| p != NONE as usize)
    }

    /// Triangles of a polygon (m, polygon < number of polygons).
    pub fn triangles(&self, polygon: u32) -> &[[[f32; 3]; 3]] {
        let p = &self.0.polygons[polygon as usize];
        &self.0.triangles[p.first_triangle as usize..][..p.num_triangles as usize]
    }

    /// Corners of polygons (m).
    pub fn vertices(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.0.vertices.iter().map(|v| Vec3::from(v.at))
    }

    /// Numbers of a polygon's vertices (polygon < number of polygons).
    pub fn vertices_of(&self, polygon: u32) -> impl Iterator<Item = u32> + Clone + '_ {
        let p = &self.0.polygons[polygon as usize];
        self.0.edges[p.first_edge as usize..][..p.num_edges as usize].iter().map(|e| e.vertex)
    }

    /// Borders of the ground.
    pub fn walls(&self) -> &[LevelWall] {
        &self.0.walls
    }

    /// Ends of the borders of the ground (m), parted so that each is on one floor: somebody may walk below the upper end of a ramp.
    pub fn walls_of_floors(&self) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        self.walls().iter().flat_map(|wall| {
            let [from, to] = [wall.from, wall.to].map(Vec3::from);
            let num = ((to.y - from.y).abs() / MOST_RISE_M).ceil().max(1.0) as usize;
            let at = move |k: usize| from.lerp(to, k as f32 / num as f32);
            (0..num).map(move |k| [at(k), at(k + 1)])
        })
    }

    /// Links.
    pub fn links(&self) -> &[LevelLink] {
        &self.0.links
    }

    /// Name of a place or a link.
    pub fn name(&self, [from, to]: [u32; 2]) -> &str {
        // Ranges were checked.
        std::str::from_utf8(&self.0.names[from as usize..to as usize]).unwrap_or_default()
    }

    /// Named places.
    pub fn places(&self) -> impl Iterator<Item = NamedPlace<'_>> {
        self.0.places.iter().map(|p: &LevelPlace| NamedPlace {
            name: self.name(p.name),
            kind: self.name(p.kind),
            at: p.at.into(),
        })
    }

    /// The place of that name.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the names that there are.
    pub fn place(&self, name: &str) -> Result<NamedPlace<'_>> {
        self.places().find(|p| p.name == name).ok_or_else(|| Error::Unknown {
            what: "place of the level",
            name: name.to_owned(),
            known: self.places().map(|p| format!("\"{}\"", p.name)).collect(),
        })
    }

    /// Length of the file (bytes).
    pub fn num_bytes(&self) -> usize {
        self.0.num_bytes
    }

    /// Position of a vertex on the plane (m).
    pub(crate) fn flat(&self, vertex: u32) -> DVec2 {
        let [x, _, z] = self.0.vertices[vertex as usize].at;
        DVec2::new(x.into(), z.into())
    }
}

/// Checks every index and every number.
fn check(t: &LevelTables) -> Result<(), FormatError> {
    let fault = |tag: &[u8; 4], i: usize, why: &str| FormatError::value(SectionTag(*tag), i, why);
    let all = |tag, mut good: &mut dyn Iterator<Item = bool>, why| match (&mut good).position(|good| !good) {
        Some(i) => Err(fault(tag, i, why)),
        None => Ok(()),
    };
    let is_near = |at: &[f32; 3]| at.iter().all(|x| x.abs() < FARTHEST_M);
    let [num_vertices, num_polygons, num_edges] = [t.vertices.len(), t.polygons.len(), t.edges.len()];
    let is_range = |first: u32, num: u32, all: usize| first as usize + num as usize <= all;
    let names = std::str::from_utf8(&t.names).map_err(|e| fault(b"LNAM", e.valid_up_to(), "a name is no UTF-8"))?;
    let is_name = |[from, to]: [u32; 2]| names.get(from as usize..to as usize).is_some();

    ensure(t.head.len() == 1, || fault(b"LHED", 0, "expected one head"))?;
    let head = &t.head[0];
    let sizes = [head.radius_m, head.height_m, head.climb_m, head.slope, head.low[0], head.low[1], head.square_m];
    let good = sizes.iter().all(|x| x.abs() < FARTHEST_M) && head.square_m > 0.0;
    ensure(good, || fault(b"LHED", 0, "a size is not moderate"))?;
    let num_squares = head.squares.map(|n| n as usize).iter().product::<usize>();
    let good = head.squares.iter().all(|&n| (1..1 << 15).contains(&n)) && t.squares.len() == num_squares + 1;
    ensure(good, || fault(b"LSQR", 0, "the grid has another number of squares"))?;
    all(b"LSQR", &mut t.squares.windows(2).map(|w| w[0] <= w[1]), "squares do not follow each other")?;
    let good = t.squares[num_squares] as usize == t.listed.len();
    ensure(good, || fault(b"LSQR", num_squares, "the grid ends elsewhere"))?;
    all(b"LLST", &mut t.listed.iter().map(|&p| (p as usize) < num_polygons), "there is no such polygon")?;

    all(b"LVRT", &mut t.vertices.iter().map(|v| is_near(&v.at)), "not a moderate number of metres")?;
    let is_distance = |d: &f32| (0.0..1e9).contains(d);
    all(b"LTRI", &mut t.triangles.iter().map(|c| c.iter().all(is_near)), "not a moderate number of metres")?;
    let good = |e: &crate::LevelEdge| {
        let is_open = (e.neighbour as usize) < num_polygons && (e.twin as usize) < num_edges;
        (e.vertex as usize) < num_vertices && (e.neighbour == NONE || is_open)
    };
    all(b"LEDG", &mut t.edges.iter().map(good), "there is no such vertex, polygon or edge")?;
    let num_places = t.places.len() as u32;
    for (i, p) in t.polygons.iter().enumerate() {
        let good = is_range(p.first_edge, p.num_edges, num_edges)
            && is_range(p.first_triangle, p.num_triangles, t.triangles.len())
            && p.num_edges >= 3
            && p.num_triangles >= 1
            && (p.place == NONE || p.place < num_places);
        ensure(good, || fault(b"LPOL", i, "there is no such edge, triangle or place"))?;
        for k in p.first_edge..p.first_edge + p.num_edges {
            let e = t.edges[k as usize];
            if e.neighbour != NONE {
                let (other, twin) = (t.polygons[e.neighbour as usize], t.edges[e.twin as usize]);
                let is_its = (other.first_edge..other.first_edge.saturating_add(other.num_edges)).contains(&e.twin);
                let good = is_its && twin.twin == k && twin.neighbour == i as u32 && other.component == p.component;
                ensure(good, || fault(b"LEDG", k as usize, "its neighbour has another one"))?;
            }
        }
    }
    let good = |p: &LevelPlace| is_near(&p.at) && is_name(p.kind) && is_name(p.name);
    all(b"LPLC", &mut t.places.iter().map(good), "not a place with a name")?;
    let num_links = t.links.len();
    ensure(num_links <= MAX_LINKS, || fault(b"LLNK", num_links, "there are at most 1000 links"))?;
    let good = |l: &LevelLink| {
        let is_ground = l.polygons.iter().all(|&p| (p as usize) < num_polygons);
        is_ground && is_name(l.kind) && is_name(l.name) && l.ends.iter().all(is_near) && is_distance(&l.cost_m)
    };
    all(b"LLNK", &mut t.links.iter().map(good), "not a link between polygons")?;
    let good = t.link_costs.len() == num_links * num_links && t.link_next.len() == t.link_costs.len();
    ensure(good, || fault(b"LCST", 0, "expected a row for each link"))?;
    all(b"LCST", &mut t.link_costs.iter().map(|&c| c >= 0.0), "not a cost")?;
    all(b"LNXT", &mut t.link_next.iter().map(|&n| (n as usize) < num_links), "there is no such link")?;
    all(b"LWAL", &mut t.walls.iter().map(|w| is_near(&w.from) && is_near(&w.to)), "not a moderate number of metres")
}
