//! What going farther costs at least, anywhere in a world.

use crate::patch::{CellRecord, KIND_TILE, LinkRecord};
use crate::world::{JointTableRecord, WorldGraph};
use glam::{Vec3, Vec3Swizzles};

/// What a metre up counts beside those along: who slides down fast has to come up again. [Unit: frames/m]
const CLIMBS: [f32; 6] = [0.0, 5.0, 10.0, 15.0, 20.0, 30.0];

/// What a metre costs at least. [Unit: frames/m]
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Along the ground and up, beside each other.
    along: [[f32; 2]; CLIMBS.len()],
    up: f32,
    down: f32,
}

impl Pace {
    /// By the fastest step that there is in each direction.
    pub fn new(graph: &WorldGraph<'_>) -> Self {
        let mut out =
            Self { along: CLIMBS.map(|climb| [f32::INFINITY, climb]), up: f32::INFINITY, down: f32::INFINITY };
        let (patches, tables) = (graph.patches(), graph.world().tables);
        let gap = tables.iter().map(|t| widest_gap(graph, t)).fold(0.0, f32::max);
        for (p, record) in patches.patches.iter().enumerate() {
            let gap = if record.kind == KIND_TILE { 0.0 } else { gap };
            let cells = patches.cells_of(p);
            for l in patches.links_of(p) {
                out.add(at(cells, l.from), at(cells, l.to), gap, l.num_frames.into());
            }
        }
        tables.iter().for_each(|t| out.add_joints(graph, t));
        let known = |p: f32| if p < f32::INFINITY { p } else { 0.0 };
        // Where steps up take less than the climb alone counts, that is of no use.
        let along = |[p, climb]: [f32; 2]| if (0.0..f32::INFINITY).contains(&p) { [p, climb] } else { [0.0; 2] };
        Self { along: out.along.map(along), up: known(out.up), down: known(out.down) }
    }

    /// Of a way from one place to within so many metres of another one. [Unit: frames]
    pub fn cost(&self, from: Vec3, to: Vec3, within: f32) -> f32 {
        let way = to - from;
        let rise = if way.y > 0.0 { self.up } else { self.down };
        let (far, high) = ((way.xz().length() - within).max(0.0), way.y - within);
        let along = self.along.iter().map(|[p, climb]| p * far + climb * high);
        along.fold(rise * (way.y.abs() - within), f32::max).max(0.0)
    }

    fn add(&mut self, from: Vec3, to: Vec3, gap: f32, frames: f32) {
        let way = to - from;
        for [p, climb] in &mut self.along {
            *p = p.min((frames - *climb * (way.y + gap)) / (way.xz().length() + gap));
        }
        self.up = self.up.min(frames / (way.y.max(0.0) + gap));
        self.down = self.down.min(frames / ((-way.y).max(0.0) + gap));
    }

    /// Steps out of links of a tile, and into them.
    fn add_joints(&mut self, graph: &WorldGraph<'_>, t: &JointTableRecord) {
        let patches = graph.patches();
        if patches.patches[t.patch_a as usize].kind != KIND_TILE {
            return;
        }
        let (cells_a, cells_b) = (patches.cells_of(t.patch_a as usize), patches.cells_of(t.patch_b as usize));
        for j in graph.joints(t) {
            let l: &LinkRecord = &patches.links_of(t.patch_a as usize)[j.a as usize];
            let b = t.placement.transform_point(at(cells_b, j.b));
            self.add(at(cells_a, l.from), b, 0.0, j.a_offset as f32);
            self.add(b, at(cells_a, l.to), 0.0, f32::from(l.num_frames) - j.a_offset as f32);
        }
    }
}

/// The farthest that two cells of blocks are from each other which are joined. [Unit: m]
fn widest_gap(graph: &WorldGraph<'_>, t: &JointTableRecord) -> f32 {
    let patches = graph.patches();
    if patches.patches[t.patch_a as usize].kind == KIND_TILE {
        return 0.0;
    }
    let (cells_a, cells_b) = (patches.cells_of(t.patch_a as usize), patches.cells_of(t.patch_b as usize));
    let gap = |(a, b)| at(cells_a, a).distance(t.placement.transform_point(at(cells_b, b)));
    graph.joints(t).iter().map(|j| gap((j.a, j.b))).fold(0.0, f32::max)
}

fn at(cells: &[CellRecord], cell: u32) -> Vec3 {
    cells[cell as usize].placement.translation()
}
