//! Steps from node to node: along links, into and out of links of tiles, and across joints of cells.

use super::WorldGraph;
use crate::{AdjacencyRecord, InstanceRecord, JointRecord, JointTableRecord, is_set};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use throng_core::patch::{CellRecord, KIND_TILE, LinkRecord, NONE};

/// A cell of an instance. An exit of a tile is the entry of its neighbour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct WorldNode {
    /// The instance.
    pub instance: u32,
    /// The cell, within its patch.
    pub cell: u32,
}

impl WorldNode {
    /// Marks an absent node.
    pub const NONE: Self = Self { instance: NONE, cell: NONE };
}

/// Edge of the graph over a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorldStep {
    /// Node at the end of the step.
    pub to: WorldNode,
    /// Instance whose link the step plays.
    pub instance: u32,
    /// The link, within the patch; it begins at the node that is left, at one of its tile's links, or at a cell that is
    /// joined to that node.
    pub link: u32,
    /// Frame of the link that it begins at.
    pub from_offset: u16,
    /// Frame of the link that it ends at (> from_offset).
    pub to_offset: u16,
}

impl WorldStep {
    /// Marks an absent step.
    pub const NONE: Self = Self { to: WorldNode::NONE, instance: NONE, link: NONE, from_offset: 0, to_offset: 0 };

    /// Frames that it plays.
    pub fn num_frames(&self) -> u32 {
        u32::from(self.to_offset - self.from_offset)
    }
}

/// Data shared by the steps along an instance's links.
struct InstanceSteps<'w> {
    record: &'w InstanceRecord,
    cells: &'w [CellRecord],
    links: &'w [LinkRecord],
}

impl<'w> InstanceSteps<'w> {
    fn of_instance(graph: &'w WorldGraph, instance: u32) -> Self {
        let record = graph.instance(instance);
        let patch = record.patch as usize;
        Self { record, cells: graph.patches.cells_of(patch), links: graph.patches.links_of(patch) }
    }

    fn step_along(&self, graph: &WorldGraph, instance: u32, link: u32) -> Option<WorldStep> {
        if !is_set(&graph.world.link_words, self.record.first_link_word, link) {
            return None;
        }
        let l = &self.links[link as usize];
        let to = self.end_node(graph, instance, l)?;
        Some(WorldStep { to, instance, link, from_offset: 0, to_offset: l.num_frames })
    }

    fn end_node(&self, graph: &WorldGraph, instance: u32, link: &LinkRecord) -> Option<WorldNode> {
        if !is_set(&graph.world.cell_words, self.record.first_cell_word, link.to) {
            return None;
        }
        let cell = &self.cells[link.to as usize];
        if !cell.has_flags(CellRecord::IS_EXIT) {
            return Some(WorldNode { instance, cell: link.to });
        }
        let slot = self.record.first_neighbour + cell.edge;
        let entry = WorldNode { instance: graph.world.neighbours[slot as usize], cell: cell.twin };
        (entry.instance != NONE && graph.is_enabled(entry)).then_some(entry)
    }
}

/// Visitor of the steps that can be taken from a node.
pub(crate) trait StepVisitor {
    /// True where steps along the links of a cell are to be followed: of the node, or of a block's cell that is joined to
    /// it.
    fn follows_links_of(&mut self, from: WorldNode) -> bool;
    /// Visits a step.
    fn visit_step(&mut self, step: WorldStep);
}

/// Visitor of all steps.
struct EveryStep<F>(F);

impl<F: FnMut(WorldStep)> StepVisitor for EveryStep<F> {
    fn follows_links_of(&mut self, _: WorldNode) -> bool {
        true
    }

    fn visit_step(&mut self, step: WorldStep) {
        (self.0)(step);
    }
}

/// Result of a joint from a cell of a block.
pub(crate) enum JointCrossing {
    /// A cell of another block, which is left along a link.
    Cell(WorldNode),
    /// The rest of a tile's link.
    Link(WorldStep),
}

impl WorldGraph {
    /// The link that a step plays, none for [`WorldStep::NONE`].
    pub fn link(&self, step: &WorldStep) -> Option<&LinkRecord> {
        (step.link != NONE).then(|| &self.links(step.instance)[step.link as usize])
    }

    /// Distance over the ground from where a step's motion begins to where it ends, as a share of its link's.
    /// (m)
    pub fn step_length(&self, step: &WorldStep) -> f32 {
        self.link(step).map_or(0.0, |l| {
            let share = step.num_frames() as f32 / f32::from(l.num_frames);
            (l.end.translation() - l.start.translation()).length() * share
        })
    }

    /// Calls `visit` with every step that can be taken from a node.
    pub fn for_each_step(&self, node: WorldNode, visit: impl FnMut(WorldStep)) {
        self.visit_steps(node, &mut EveryStep(visit));
    }

    /// Visits the steps that can be taken from a node; the visitor first chooses the cells whose links are followed.
    pub(crate) fn visit_steps(&self, node: WorldNode, walk: &mut impl StepVisitor) {
        if walk.follows_links_of(node) {
            self.for_each_link_step(node, |s| walk.visit_step(s));
        }
        if self.is_tile(node.instance) {
            let cell = self.cell(node);
            let links = cell.first_link..cell.first_link + cell.num_links;
            self.for_each_exit(node.instance, links, |s| walk.visit_step(s));
            return;
        }
        // After a cell of another block a link must follow: joints in a row without motion would carry a character
        // farther and farther from where its own motion ended.
        self.for_each_crossing(node, |_, crossing| match crossing {
            JointCrossing::Link(step) => walk.visit_step(step),
            JointCrossing::Cell(to) if walk.follows_links_of(to) => self.for_each_link_step(to, |s| walk.visit_step(s)),
            JointCrossing::Cell(_) => {}
        });
    }

    /// Steps along whole links from a cell.
    fn for_each_link_step(&self, from: WorldNode, mut visit: impl FnMut(WorldStep)) {
        let part = InstanceSteps::of_instance(self, from.instance);
        let cell = &part.cells[from.cell as usize];
        let links = cell.first_link..cell.first_link + cell.num_links;
        let alone = links.filter(|&l| !part.links[l as usize].is_for_two());
        alone.filter_map(|l| part.step_along(self, from.instance, l)).for_each(&mut visit);
    }

    /// Steps along whole links from a node, those of two characters among them.
    pub(crate) fn whole_link_steps(&self, from: WorldNode) -> impl Iterator<Item = WorldStep> + '_ {
        let cell = self.cell(from);
        (cell.first_link..cell.first_link + cell.num_links).filter_map(move |l| self.step_along(from.instance, l))
    }

    /// The step that plays a whole link, where the link and the node it leads to are enabled.
    pub(crate) fn step_along(&self, instance: u32, link: u32) -> Option<WorldStep> {
        InstanceSteps::of_instance(self, instance).step_along(self, instance, link)
    }

    /// The node a link leads to: across an edge, the entry of the neighbour.
    pub(crate) fn end_node(&self, instance: u32, link: &LinkRecord) -> Option<WorldNode> {
        InstanceSteps::of_instance(self, instance).end_node(self, instance, link)
    }

    /// True for the cells of an instance at which some step may end; for a tile all. Others are only passed, on the way
    /// across a joint from another block's cell into a link that begins there: no path leads to them.
    ///
    /// (cells of the instance, instance < num_instances)
    pub fn node_of_cell(&self, instance: u32) -> Vec<bool> {
        let mut cells = vec![self.is_tile(instance); self.cells(instance).len()];
        for (link, l) in (0u32..).zip(self.links(instance)) {
            cells[l.to as usize] |= self.is_link_enabled(instance, link);
        }
        let is_tile = |table: &JointTableRecord| self.patches.patches[table.patch_a as usize].kind == KIND_TILE;
        for (_, adjacency, table) in self.adjacencies(instance).filter(|(_, a, t)| a.side == 1 && is_tile(t)) {
            for (k, j) in self.joints(table).iter().enumerate() {
                cells[j.b as usize] |= self.can_go(adjacency, k, true);
            }
        }
        cells
    }

    /// Adjacencies of an instance, each with its table and number.
    pub(crate) fn adjacencies(
        &self,
        instance: u32,
    ) -> impl Iterator<Item = (usize, &AdjacencyRecord, &JointTableRecord)> {
        let (r, world) = (self.instance(instance), &self.world);
        let range = r.first_adjacency as usize..r.first_adjacency as usize + r.num_adjacencies as usize;
        range.map(move |i| (i, &world.adjacencies[i], &world.tables[world.adjacencies[i].table as usize]))
    }

    /// Joints of a table, in their order.
    pub(crate) fn joints(&self, table: &JointTableRecord) -> &[JointRecord] {
        &self.world.joints[table.first_joint as usize..][..table.num_joints as usize]
    }

    /// Joints of an instance's cell, or on side a of a tile of its link, with their numbers in the table.
    pub(crate) fn joints_at(
        &self,
        adjacency: &AdjacencyRecord,
        table: &JointTableRecord,
        at: u32,
    ) -> impl Iterator<Item = (usize, &JointRecord)> {
        let (joints, on_a) = (self.joints(table), adjacency.side == 0);
        let order = &self.world.joints_by_b[table.first_joint as usize..][..table.num_joints as usize];
        let places = match on_a {
            true => self.joints.at_a(adjacency.table, at..at + 1),
            false => self.joints.at_b(adjacency.table, at),
        };
        let number = move |k: usize| if on_a { k } else { order[k] as usize };
        places.map(move |k| (number(k), &joints[number(k)]))
    }

    /// Steps that leave links of a tile before their ends, into blocks. The rest of a link may be disabled: joints have
    /// bits of their own, set where what is played of the link is free of obstacles.
    fn for_each_exit(&self, instance: u32, links: Range<u32>, mut visit: impl FnMut(WorldStep)) {
        for (_, adjacency, table) in self.adjacencies(instance).filter(|(_, a, _)| a.side == 0) {
            let joints = self.joints(table);
            for k in self.joints.at_a(adjacency.table, links.clone()) {
                let j = &joints[k];
                let to = WorldNode { instance: adjacency.other, cell: j.b };
                if self.can_go(adjacency, k, true) && self.is_enabled(to) {
                    visit(WorldStep { to, instance, link: j.a, from_offset: 0, to_offset: j.a_offset as u16 });
                }
            }
        }
    }

    /// Calls `visit` with all that joints of a block's cell lead to, each with its adjacency.
    pub(crate) fn for_each_crossing(&self, node: WorldNode, mut visit: impl FnMut(&AdjacencyRecord, JointCrossing)) {
        for (_, adjacency, table) in self.adjacencies(node.instance) {
            let to_b = adjacency.side == 0;
            let into_tile = !to_b && self.patches.patches[table.patch_a as usize].kind == KIND_TILE;
            for (k, j) in self.joints_at(adjacency, table, node.cell) {
                if into_tile {
                    if let Some(step) = self.enter_link(adjacency, k, j) {
                        visit(adjacency, JointCrossing::Link(step));
                    }
                    continue;
                }
                let to = WorldNode { instance: adjacency.other, cell: if to_b { j.b } else { j.a } };
                if self.can_go(adjacency, k, to_b) && self.is_enabled(to) {
                    visit(adjacency, JointCrossing::Cell(to));
                }
            }
        }
    }

    /// Step from a cell of a block into a link of a tile, which is played to its end; the part before may be disabled.
    fn enter_link(&self, adjacency: &AdjacencyRecord, joint: usize, j: &JointRecord) -> Option<WorldStep> {
        let (instance, l) = (adjacency.other, &self.links(adjacency.other)[j.a as usize]);
        let to = self.end_node(instance, l)?;
        let step = WorldStep { to, instance, link: j.a, from_offset: j.a_offset as u16, to_offset: l.num_frames };
        self.can_go(adjacency, joint, false).then_some(step)
    }

    /// True where a joint may be taken, from side a to side b or back.
    pub(crate) fn can_go(&self, adjacency: &AdjacencyRecord, joint: usize, to_b: bool) -> bool {
        is_set(&self.world.joint_words, adjacency.first_word, 2 * joint as u32 + u32::from(!to_b))
    }
}
