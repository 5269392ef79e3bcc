//! A small library of patches made up by hand: a tile that people walk across, a bench that they sit down on, and a
//! wall.

use std::path::Path;
use std::sync::Arc;
use throng_core::format::{FrameRow, PatchMeta, ROTATION_BYTES, RotationCode};
use throng_core::patch::{
    CellRecord, EdgeRecord, KIND_BLOCK, KIND_TILE, LinkRecord, NONE, PatchRecord, PatchTables, Placement,
};
use throng_core::{Contacts, Skeleton};
use throng_precompute::environment::{Environment, PlacedUnit, UnitGeometry, UnitSet, geometries};
use throng_precompute::stitch::Library;

/// Number of each unit.
pub const GROUND: usize = 0;
pub const BENCH: usize = 1;
pub const WALL: usize = 2;
pub const PANEL_M: f32 = 2.8;

const UNITS: &str = r#"
[[units]]
name = "ground"
symmetry = 4
floor = true
shapes = [{ box = { at = [0.0, -0.05, 0.0], size = [2.8, 0.1, 2.8] } }]
tile = { steps = [[2.8, 0.0, 0.0], [0.0, 0.0, 2.8]], widths = [2.8, 2.8] }
[[units]]
name = "bench"
shapes = [{ box = { at = [0.0, 0.2, 0.0], size = [0.5, 0.4, 0.4] } }]
[[units]]
name = "wall"
symmetry = 2
shapes = [{ box = { at = [0.0, 1.0, 0.0], size = [2.0, 2.0, 0.1] } }]
"#;

/// Frames of a walk straight on, each in a pose group of its own; the body only glides.
const FRAMES: usize = 57;
/// Half-way across a tile, and before the bench.
const HALF: u32 = 28;
const HIPS_M: f32 = 0.92;

/// Everything that a [`Library`] and [`PatchTables`] borrow.
pub struct MadeUp {
    pub units: UnitSet,
    pub geometries: Vec<Arc<UnitGeometry>>,
    pub skeleton: Skeleton,
    pub frames: Vec<FrameRow>,
    pub rotation_code: RotationCode,
    pub groups: Vec<u32>,
    pub contacts: Vec<Contacts>,
    pub names: Vec<PatchMeta>,
    pub patches: Vec<PatchRecord>,
    pub edges: Vec<EdgeRecord>,
    pub cells: Vec<CellRecord>,
    pub links: Vec<LinkRecord>,
}

impl MadeUp {
    pub fn new() -> Self {
        let units = UnitSet::parse(UNITS, Path::new("made-up.toml")).unwrap();
        let rotations = [0; ROTATION_BYTES];
        let frame = |k: usize| FrameRow { planar: [0.0, 0.05 * k as f32, 0.0], height: HIPS_M, rotations };
        let mut out = Self {
            geometries: geometries(&units).unwrap(),
            units,
            skeleton: Skeleton::default(),
            frames: (0..FRAMES).map(frame).collect(),
            rotation_code: RotationCode::of_rest_pose(),
            groups: (0..FRAMES as u32).collect(),
            contacts: vec![Contacts::default(); FRAMES],
            names: Vec::new(),
            patches: Vec::new(),
            edges: Vec::new(),
            cells: Vec::new(),
            links: Vec::new(),
        };
        let [x, z] = [[PANEL_M, 0.0, 0.0], [0.0, 0.0, PANEL_M]];
        let back = |s: [f32; 3]| s.map(|v| -v);
        let edges = [(x, 1), (back(x), 0), (z, 3), (back(z), 2)].map(|(step, opposite)| EdgeRecord { step, opposite });
        out.edges.extend(edges);
        let (cells, links) = tile();
        out.add("ground", "ground", KIND_TILE, cells, links);
        let (cells, links) = bench();
        out.add("bench", "bench", KIND_BLOCK, cells, links);
        out
    }

    fn add(&mut self, name: &str, unit: &str, kind: u32, mut cells: Vec<CellRecord>, mut links: Vec<LinkRecord>) {
        links.sort_by_key(|l| l.from);
        for (c, cell) in cells.iter_mut().enumerate() {
            cell.first_link = links.partition_point(|l| l.from < c as u32) as u32;
            cell.num_links = links.partition_point(|l| l.from <= c as u32) as u32 - cell.first_link;
        }
        let num_edges = if kind == KIND_TILE { 4 } else { 0 };
        self.patches.push(PatchRecord {
            kind,
            first_cell: self.cells.len() as u32,
            num_cells: cells.len() as u32,
            first_link: self.links.len() as u32,
            num_links: links.len() as u32,
            first_edge: self.edges.len() as u32 - num_edges,
            num_edges,
            reserved: 0,
            // Cells are up to 1.4 m from the middle, and arms are stretched out.
            min: [-2.3, -0.1, -2.3],
            max: [2.3, 1.9, 2.3],
        });
        self.cells.extend(cells);
        self.links.extend(links);
        self.names.push(PatchMeta { name: name.into(), units: vec![(unit.into(), Placement::IDENTITY)] });
    }

    pub fn patches(&self) -> PatchTables {
        PatchTables {
            patches: (&self.patches).into(),
            edges: (&self.edges).into(),
            cells: (&self.cells).into(),
            links: (&self.links).into(),
            pairs: [].as_slice().into(),
        }
    }

    pub fn library(&self) -> Library<'_> {
        Library {
            bundle: "made-up",
            bundle_hash: 7,
            rate_hz: 30.0,
            names: &self.names,
            units: &self.units,
            frames: &self.frames,
            rotation_code: &self.rotation_code,
            groups: &self.groups,
            contacts: &self.contacts,
            geometries: &self.geometries,
            skeleton: &self.skeleton,
        }
    }

    /// Root of frame `offset` of a link in its patch's frame, with the hips' height: written down anew from the
    /// definition of [`LinkRecord`].
    pub fn hips(&self, link: &LinkRecord, offset: u32) -> Placement {
        let row = |k: u32| {
            let [x, z, heading] = self.frames[(link.frame + k) as usize].planar;
            Placement::new(x, 0.0, z, heading)
        };
        let moved = |k: u32| link.start.compose(row(0).inverse().compose(row(k)));
        let (last, share) = (moved(link.num_frames.into()), offset as f32 / f32::from(link.num_frames));
        let at = moved(offset);
        Placement {
            x: at.x + share * (link.end.x - last.x),
            y: at.y + share * (link.end.y - link.start.y) + self.frames[(link.frame + offset) as usize].height,
            z: at.z + share * (link.end.z - last.z),
            heading: at.heading + share * (link.end.heading - last.heading),
        }
    }
}

fn cell(placement: Placement, group: u32, edge: u32, twin: u32, flags: u32) -> CellRecord {
    let placement = Placement { y: HIPS_M, ..placement };
    CellRecord { placement, group, edge, twin, flags, first_link: 0, num_links: 0, reserved: [0; 2] }
}

/// Cells 0 to 3 enter across the edges, 4 to 7 leave; every edge leads to every other one and in a curve to itself.
fn tile() -> (Vec<CellRecord>, Vec<LinkRecord>) {
    use std::f32::consts::{FRAC_PI_2, PI};
    let half = 0.5 * PANEL_M;
    let edges = [(half, 0.0, FRAC_PI_2), (-half, 0.0, -FRAC_PI_2), (0.0, half, 0.0), (0.0, -half, PI)];
    let outwards = |e: usize| Placement::new(edges[e].0, 0.0, edges[e].1, edges[e].2);
    let inwards = |e: usize| Placement { heading: edges[e].2 + PI, ..outwards(e) }.with_wrapped_heading();
    let opposite = [1, 0, 3, 2];
    let mut cells = Vec::new();
    cells.extend((0..4).map(|e| cell(inwards(e), 0, e as u32, 4 + opposite[e], CellRecord::IS_ENTRY)));
    cells.extend((0..4).map(|e| cell(outwards(e), 0, e as u32, opposite[e], CellRecord::IS_EXIT)));
    let mut links = Vec::new();
    for (from, to) in (0..16).map(|k| (k / 4, k % 4)) {
        let (start, end) = (inwards(from), outwards(to));
        let turn = Placement { heading: end.heading - start.heading, ..end }.with_wrapped_heading().heading;
        let end = Placement { heading: start.heading + turn, ..end };
        links.push(LinkRecord {
            from: from as u32,
            to: 4 + to as u32,
            frame: 0,
            num_frames: FRAMES as u16 - 1,
            tag: 0,
            start,
            end,
        });
    }
    (cells, links)
}

/// Cell 0 stands before the bench and faces it, cell 1 sits, cell 2 has turned away from it.
fn bench() -> (Vec<CellRecord>, Vec<LinkRecord>) {
    let before = Placement::new(0.0, 0.0, -0.8, 0.0);
    let sits = Placement::new(0.0, 0.0, -0.4, std::f32::consts::PI);
    let away = Placement { heading: std::f32::consts::PI, ..before };
    let cells = vec![
        cell(before, HALF, NONE, NONE, 0),
        cell(sits, 40, NONE, NONE, CellRecord::IS_REST),
        cell(away, HALF, NONE, NONE, 0),
    ];
    let link = |from, to, start, end| LinkRecord { from, to, frame: 20, num_frames: 20, tag: 0, start, end };
    let links = vec![link(0, 1, before, sits), link(1, 1, sits, sits), link(1, 2, sits, away)];
    (cells, links)
}

/// `across` by `along` panels from the origin towards +X and +Z.
pub fn panels(across: usize, along: usize) -> Environment {
    let at = |k: usize| Placement::new((k % across) as f32 * PANEL_M, 0.0, (k / across) as f32 * PANEL_M, 0.0);
    Environment {
        name: "made-up".into(),
        units: (0..across * along).map(|k| PlacedUnit { unit: GROUND, placement: at(k) }).collect(),
    }
}

/// The same with one more unit.
pub fn with(mut environment: Environment, unit: usize, x: f32, z: f32, heading: f32) -> Environment {
    environment.units.push(PlacedUnit { unit, placement: Placement::new(x, 0.0, z, heading) });
    environment
}
