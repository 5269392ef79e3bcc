//! Where a target lies, and what it costs to come to it from the same part of the world.

use super::Target;
use super::inside::Inside;
use crate::patch::CellRecord;
use crate::world::atlas::{Atlas, class};
use crate::world::{Node, WorldGraph};

/// Where the target lies; memory for it.
#[derive(Clone, Debug)]
pub(super) struct End {
    pub instance: u32,
    /// Goals that its cells are among, where it is in a room: one, or classes, one bit each.
    goal: Option<u32>,
    classes: u32,
    /// Its district.
    pub district: Option<u32>,
    /// There, least costs from each way in.
    pub from_in: Vec<f32>,
    inside: Inside,
}

impl End {
    /// Memory for a world.
    pub fn new(graph: &WorldGraph<'_>, atlas: &Atlas) -> Self {
        let districts = 0..atlas.num_districts() as u32;
        Self {
            instance: 0,
            goal: None,
            classes: 0,
            district: None,
            from_in: Vec::with_capacity(districts.map(|d| atlas.ins_of(d).len()).max().unwrap_or(0)),
            inside: Inside::new(graph, atlas),
        }
    }

    /// Finds out where a target lies; false where there is none.
    pub fn find(&mut self, graph: &WorldGraph<'_>, atlas: &Atlas, target: Target) -> bool {
        let instance = target.instance();
        (self.instance, self.goal, self.classes, self.district) = (instance, None, 0, None);
        self.from_in.clear();
        let nodes = || {
            let all = (0..graph.num_cells(instance)).map(move |cell| Node { instance, cell });
            all.filter(|n| graph.is_node(*n) && target.is_at(graph, *n))
        };
        if nodes().next().is_none() {
            return false;
        }
        if let Some((district, first)) = atlas.district(instance) {
            self.district = Some(district);
            self.inside.begin(district, nodes().map(|n| first + n.cell));
            for way_in in 0..atlas.ins_of(district).len() as u32 {
                let cost = self.inside.cost_from(atlas, way_in);
                self.from_in.push(cost);
            }
            return true;
        }
        let Some(plane) = atlas.regions.room(instance).and_then(|r| atlas.plane(r)) else { return false };
        let num_edges = graph.patches().patches[graph.instance(instance).patch as usize].num_edges;
        let mut all = nodes();
        let (first, several) = (all.next(), all.next().is_some());
        self.goal = match first {
            Some(node) if !several => plane.goal_at(Some(node.cell)),
            _ if nodes().all(|n| graph.cell(n).is(CellRecord::IS_REST)) => plane.goal_at(None),
            _ => None,
        };
        nodes().for_each(|n| self.classes |= 1 << class(graph.cell(n), num_edges));
        true
    }

    /// What it costs at least to go to the target without coming through another part of the world. [Unit: frames]
    pub fn cost(&mut self, atlas: &Atlas, node: Node) -> f32 {
        if let Some((district, first)) = atlas.district(node.instance) {
            let here = self.district == Some(district);
            return if here { self.inside.cost(atlas, first + node.cell) } else { f32::INFINITY };
        }
        let (here, there) = (atlas.regions.room(node.instance), atlas.regions.room(self.instance));
        let Some(room) = here.filter(|_| here == there) else { return f32::INFINITY };
        self.cost_at(atlas, room, atlas.regions.way(node.instance, self.instance), node.cell)
    }

    /// The same from a cell of a tile of the target's room, which lies so many copies away from there.
    pub fn cost_at(&self, atlas: &Atlas, room: u32, way: [i32; 2], cell: u32) -> f32 {
        let Some(plane) = atlas.plane(room) else { return f32::INFINITY };
        let cost = |goal| plane.cost(plane.look(goal, way), cell);
        match self.goal {
            Some(goal) => cost(goal),
            None => (0..u32::BITS).filter(|c| self.classes >> c & 1 == 1).map(cost).fold(f32::INFINITY, f32::min),
        }
    }
}
