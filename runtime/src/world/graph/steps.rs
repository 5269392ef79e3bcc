//! Steps from node to node: along links, into and out of links of tiles, and across joints of cells.

use super::WorldGraph;
use crate::patch::{CellRecord, KIND_TILE, LinkRecord, NONE};
use crate::world::{AdjacencyRecord, JointRecord, JointTableRecord, is_set};
use std::ops::Range;

/// A cell of an instance. An exit of a tile is the entry of its neighbour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node {
    /// The instance.
    pub instance: u32,
    /// The cell, within its patch.
    pub cell: u32,
}

impl Node {
    /// Stands where there is no node.
    pub const NONE: Self = Self { instance: NONE, cell: NONE };
}

/// One edge of the graph over a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Where it leads.
    pub to: Node,
    /// Instance whose link is played.
    pub instance: u32,
    /// The link, within the patch; it begins at the node that is left, at one of its tile's links, or at a cell that is
    /// joined to that node.
    pub link: u32,
    /// Frame of the link that it begins at.
    pub from_offset: u16,
    /// Frame of the link that it ends at. [Limit: > from_offset]
    pub to_offset: u16,
}

impl Step {
    /// Stands where there is no step.
    pub const NONE: Self = Self { to: Node::NONE, instance: NONE, link: NONE, from_offset: 0, to_offset: 0 };

    /// Frames that it plays.
    pub fn num_frames(&self) -> u32 {
        u32::from(self.to_offset - self.from_offset)
    }
}

/// What a joint leads to from a cell of a block.
pub(crate) enum Crossing {
    /// A cell of another block, which is left along a link.
    Cell(Node),
    /// The rest of a tile's link.
    Link(Step),
}

impl<'w> WorldGraph<'w> {
    /// The link that a step plays, none for [`Step::NONE`].
    pub fn link(&self, step: &Step) -> Option<&'w LinkRecord> {
        (step.link != NONE).then(|| &self.links(step.instance)[step.link as usize])
    }

    /// Distance over the ground from where a step's motion begins to where it ends, as a share of its link's.
    /// [Unit: m]
    pub fn length(&self, step: &Step) -> f32 {
        self.link(step).map_or(0.0, |l| {
            let share = step.num_frames() as f32 / f32::from(l.num_frames);
            (l.end.translation() - l.start.translation()).length() * share
        })
    }

    /// Calls `visit` with every step that can be taken from a node.
    pub fn for_each_step(&self, node: Node, mut visit: impl FnMut(Step)) {
        let cell = self.cell(node);
        let tile = self.is_tile(node.instance);
        let links = cell.first_link..cell.first_link + cell.num_links;
        let leads_out = tile && self.adjacencies(node.instance).any(|(_, a, t)| self.has_joints(a, t, &links));
        for link in links {
            if let Some(step) = self.step_along(node.instance, link) {
                visit(step);
            }
            if leads_out {
                self.for_each_way_out(node.instance, link, &mut visit);
            }
        }
        if !tile {
            self.for_each_joint(node, &mut visit);
        }
    }

    /// The step that plays a whole link, where the link and the node it leads to are enabled.
    pub(crate) fn step_along(&self, instance: u32, link: u32) -> Option<Step> {
        let l = &self.links(instance)[link as usize];
        let to = self.end_node(instance, l)?;
        let enabled = self.is_link_enabled(instance, link);
        enabled.then_some(Step { to, instance, link, from_offset: 0, to_offset: l.num_frames })
    }

    /// The node a link leads to: across an edge, the entry of the neighbour.
    pub(crate) fn end_node(&self, instance: u32, link: &LinkRecord) -> Option<Node> {
        let to = Node { instance, cell: link.to };
        if !self.is_enabled(to) {
            return None;
        }
        let cell = self.cell(to);
        if !cell.is(CellRecord::IS_EXIT) {
            return Some(to);
        }
        let slot = self.instance(instance).first_neighbour + cell.edge;
        let entry = Node { instance: self.world.neighbours[slot as usize], cell: cell.twin };
        (entry.instance != NONE && self.is_enabled(entry)).then_some(entry)
    }

    /// True for the cells of an instance at which some step may end; for a tile all. Others are only passed, on the way
    /// across a joint from another block's cell into a link that begins there: no way leads to them.
    ///
    /// [Size: cells of the instance] [Limit: instance < num_instances]
    pub fn come_to(&self, instance: u32) -> Vec<bool> {
        let mut cells = vec![self.is_tile(instance); self.cells(instance).len()];
        for (link, l) in (0u32..).zip(self.links(instance)) {
            cells[l.to as usize] |= self.is_link_enabled(instance, link);
        }
        let is_tile = |table: &JointTableRecord| self.patches.patches[table.patch_a as usize].kind == KIND_TILE;
        for (_, adjacency, table) in self.adjacencies(instance).filter(|(_, a, t)| a.side == 1 && is_tile(t)) {
            for (k, j) in self.joints(table).iter().enumerate() {
                cells[j.b as usize] |= self.may_go(adjacency, k, true);
            }
        }
        cells
    }

    /// Adjacencies of an instance, each with its table and number.
    pub(crate) fn adjacencies(
        &self,
        instance: u32,
    ) -> impl Iterator<Item = (usize, &'w AdjacencyRecord, &'w JointTableRecord)> {
        let (r, world) = (self.instance(instance), self.world);
        let range = r.first_adjacency as usize..r.first_adjacency as usize + r.num_adjacencies as usize;
        range.map(move |i| (i, &world.adjacencies[i], &world.tables[world.adjacencies[i].table as usize]))
    }

    /// Joints of a table, in their order.
    pub(crate) fn joints(&self, table: &JointTableRecord) -> &'w [JointRecord] {
        &self.world.joints[table.first_joint as usize..][..table.num_joints as usize]
    }

    /// True where a tile has joints in some of its links.
    fn has_joints(&self, adjacency: &AdjacencyRecord, table: &JointTableRecord, links: &Range<u32>) -> bool {
        let joints = self.joints(table);
        let first = joints.partition_point(|j| j.a < links.start);
        adjacency.side == 0 && joints.get(first).is_some_and(|j| j.a < links.end)
    }

    /// Joints of an instance's cell, or on side a of a tile of its link, with their numbers in the table.
    pub(crate) fn joints_at(
        &self,
        adjacency: &AdjacencyRecord,
        table: &JointTableRecord,
        at: u32,
    ) -> impl Iterator<Item = (usize, &'w JointRecord)> {
        let (joints, on_a) = (self.joints(table), adjacency.side == 0);
        let order = &self.world.joints_by_b[table.first_joint as usize..][..table.num_joints as usize];
        let first = match on_a {
            true => joints.partition_point(|j| j.a < at),
            false => order.partition_point(|&k| joints[k as usize].b < at),
        };
        let number = move |k: usize| if on_a { k } else { order[k] as usize };
        let all = (first..joints.len()).map(move |k| (number(k), &joints[number(k)]));
        all.take_while(move |(_, j)| at == if on_a { j.a } else { j.b })
    }

    /// Steps that leave a link of a tile before its end, into blocks. The rest of the link may be disabled: joints have
    /// bits of their own, set where what is played of the link is free of obstacles.
    fn for_each_way_out(&self, instance: u32, link: u32, visit: &mut impl FnMut(Step)) {
        for (_, adjacency, table) in self.adjacencies(instance).filter(|(_, a, _)| a.side == 0) {
            let joints = self.joints(table);
            let first = joints.partition_point(|j| j.a < link);
            for (k, j) in joints.iter().enumerate().skip(first).take_while(|(_, j)| j.a == link) {
                let to = Node { instance: adjacency.other, cell: j.b };
                if self.may_go(adjacency, k, true) && self.is_enabled(to) {
                    visit(Step { to, instance, link, from_offset: 0, to_offset: j.a_offset as u16 });
                }
            }
        }
    }

    /// Steps from a cell of a block into other instances.
    ///
    /// From cell to cell one goes on along a link: joints do not follow each other without motion, which would carry a
    /// character farther and farther from where its own motion ended.
    fn for_each_joint(&self, node: Node, visit: &mut impl FnMut(Step)) {
        self.for_each_crossing(node, |_, crossing| match crossing {
            Crossing::Link(step) => visit(step),
            Crossing::Cell(to) => {
                let cell = self.cell(to);
                let links = cell.first_link..cell.first_link + cell.num_links;
                links.filter_map(|l| self.step_along(to.instance, l)).for_each(&mut *visit);
            }
        });
    }

    /// Calls `visit` with all that joints of a block's cell lead to, each with its adjacency.
    pub(crate) fn for_each_crossing(&self, node: Node, mut visit: impl FnMut(&AdjacencyRecord, Crossing)) {
        for (_, adjacency, table) in self.adjacencies(node.instance) {
            let joints = self.joints(table);
            let mut cross = |k: usize, to_b: bool, cell: u32| {
                let to = Node { instance: adjacency.other, cell };
                if self.may_go(adjacency, k, to_b) && self.is_enabled(to) {
                    visit(adjacency, Crossing::Cell(to));
                }
            };
            if adjacency.side == 0 {
                let first = joints.partition_point(|j| j.a < node.cell);
                for (k, j) in joints.iter().enumerate().skip(first).take_while(|(_, j)| j.a == node.cell) {
                    cross(k, true, j.b);
                }
                continue;
            }
            let order = &self.world.joints_by_b[table.first_joint as usize..][..table.num_joints as usize];
            let first = order.partition_point(|&k| joints[k as usize].b < node.cell);
            let here = order[first..].iter().map(|&k| k as usize).take_while(|&k| joints[k].b == node.cell);
            if self.patches.patches[table.patch_a as usize].kind != KIND_TILE {
                here.for_each(|k| cross(k, false, joints[k].a));
                continue;
            }
            for k in here {
                if let Some(step) = self.enter_link(adjacency, k, &joints[k]) {
                    visit(adjacency, Crossing::Link(step));
                }
            }
        }
    }

    /// From a cell of a block into a link of a tile, which is played to its end; what comes before may be disabled.
    fn enter_link(&self, adjacency: &AdjacencyRecord, joint: usize, j: &JointRecord) -> Option<Step> {
        let (instance, l) = (adjacency.other, &self.links(adjacency.other)[j.a as usize]);
        let to = self.end_node(instance, l)?;
        let step = Step { to, instance, link: j.a, from_offset: j.a_offset as u16, to_offset: l.num_frames };
        self.may_go(adjacency, joint, false).then_some(step)
    }

    /// True where a joint may be taken, from side a to side b or back.
    pub(crate) fn may_go(&self, adjacency: &AdjacencyRecord, joint: usize, to_b: bool) -> bool {
        is_set(self.world.joint_words, adjacency.first_word, 2 * joint as u32 + u32::from(!to_b))
    }
}
