//! The graph over a world: nodes are (instance, cell), edges are links and joints. It is never stored, only walked.

mod baked;
mod connections;
mod joints;
mod passages;
mod rest;
mod steps;

pub(crate) use baked::BakedCosts;
pub use baked::PathCosts;
pub(crate) use connections::OpenConnections;
pub(crate) use steps::{JointCrossing, StepVisitor};
pub use steps::{WorldNode, WorldStep};

use super::{InstanceRecord, WorldTables, is_set, path_hierarchy::PathHierarchy};
use glam::Vec3;
use joints::JointIndex;
use std::sync::{Arc, OnceLock};
use throng_base::error::ensure;
use throng_core::format::FormatError;
use throng_core::patch::{CellRecord, KIND_TILE, LinkRecord, NONE, PatchTables, Placement};

/// A world with its patches, and tables computed from them once: the number of every instance's first node, the links
/// that lead to rest, and the connections between instances.
#[derive(Clone, Debug)]
pub struct WorldGraph {
    patches: PatchTables,
    world: WorldTables,
    /// Number of the first node of each instance, and of all nodes (instances + 1).
    first_node: Vec<u32>,
    /// Link of each node that leads towards the nearest rest cell within its instance; [`NONE`] where none does.
    to_rest: Vec<u32>,
    /// True for instances that are part of a narrow passage.
    narrow: Vec<bool>,
    /// Index of the joints in their tables.
    joints: JointIndex,
    /// Open connections between instances.
    pub(crate) bounds: OpenConnections,
    /// Path hierarchy, computed by the first planner.
    hierarchy: Arc<OnceLock<PathHierarchy>>,
}

impl WorldGraph {
    /// Works out what is needed of a world that was checked, see [`super::World::open`] and
    /// [`super::WorldData::check`].
    ///
    /// # Errors
    /// [`FormatError::Layout`] where the world has no instance, or more nodes than can be counted.
    pub fn new(patches: &PatchTables, world: &WorldTables) -> Result<Self, FormatError> {
        let mut graph = Self::without_costs(patches, world)?;
        graph.to_rest = rest::links_to_rest(&graph);
        graph.bounds = OpenConnections::new(&graph);
        graph.narrow = passages::narrow_passages(&graph);
        Ok(graph)
    }

    /// Builds the graph with tables from a file, which takes no search.
    ///
    /// # Errors
    /// As [`WorldGraph::new`], and where the tables do not fit the world.
    pub(crate) fn from_baked(
        patches: &PatchTables,
        world: &WorldTables,
        baked: BakedCosts,
    ) -> Result<Self, FormatError> {
        let mut graph = Self::without_costs(patches, world)?;
        (graph.to_rest, graph.narrow, graph.bounds) = (baked.to_rest, baked.narrow, baked.bounds);
        let message = "its path costs (section WPTH) are not those of its instances, or cannot be";
        ensure(graph.is_sound() && baked.hierarchy.is_sound(&graph), || FormatError::layout(message))?;
        let _ = graph.hierarchy.set(baked.hierarchy);
        Ok(graph)
    }

    /// Counts nodes, and looks joints up.
    fn without_costs(patches: &PatchTables, world: &WorldTables) -> Result<Self, FormatError> {
        let message = "the world has no instance: no character can be there";
        ensure(!world.instances.is_empty(), || FormatError::layout(message))?;
        let mut first_node = Vec::with_capacity(world.instances.len() + 1);
        let mut next = 0u32;
        for r in &world.instances {
            first_node.push(next);
            next = next
                .checked_add(patches.patches[r.patch as usize].num_cells)
                .filter(|n| *n < NONE)
                .ok_or_else(|| FormatError::layout("the world has more cells than can be counted"))?;
        }
        first_node.push(next);
        Ok(Self {
            patches: patches.clone(),
            world: world.clone(),
            first_node,
            to_rest: Vec::new(),
            narrow: Vec::new(),
            joints: JointIndex::new(patches, world),
            bounds: OpenConnections::default(),
            hierarchy: Arc::default(),
        })
    }

    /// True where what was read from a file goes with the world: links to rest begin at their cells, and can be taken.
    fn is_sound(&self) -> bool {
        let to_rest = |instance: u32| {
            let first = self.first_node[instance as usize] as usize;
            let (links, here) = (self.links(instance), &self.to_rest[first..][..self.cells(instance).len()]);
            let begins = |(cell, &link): (u32, &u32)| {
                let can_be_taken = |l: &LinkRecord| {
                    let inside = self.is_node(WorldNode { instance, cell: l.to });
                    l.from == cell && !l.is_for_two() && inside && self.is_link_enabled(instance, link)
                };
                link == NONE || links.get(link as usize).is_some_and(can_be_taken)
            };
            (0u32..).zip(here).all(begins)
        };
        self.to_rest.len() == self.num_nodes()
            && self.narrow.len() == self.num_instances()
            && self.bounds.is_sound(&self.world)
            && (0..self.num_instances() as u32).all(to_rest)
    }

    /// The world.
    pub fn world(&self) -> &WorldTables {
        &self.world
    }

    /// The patches that it consists of.
    pub fn patches(&self) -> &PatchTables {
        &self.patches
    }

    /// Number of instances.
    pub fn num_instances(&self) -> usize {
        self.world.instances.len()
    }

    /// Number of nodes, those that are disabled among them.
    pub fn num_nodes(&self) -> usize {
        self.first_node[self.num_instances()] as usize
    }

    /// Number of a node among all.
    pub(crate) fn index(&self, node: WorldNode) -> usize {
        (self.first_node[node.instance as usize] + node.cell) as usize
    }

    /// Number of cells of an instance.
    pub(crate) fn num_cells(&self, instance: u32) -> u32 {
        self.first_node[instance as usize + 1] - self.first_node[instance as usize]
    }

    /// An instance (instance < num_instances).
    pub fn instance(&self, instance: u32) -> &InstanceRecord {
        &self.world.instances[instance as usize]
    }

    /// True for an instance of a tile (instance < num_instances).
    pub fn is_tile(&self, instance: u32) -> bool {
        self.patches.patches[self.instance(instance).patch as usize].kind == KIND_TILE
    }

    /// Cells of an instance, disabled ones among them (instance < num_instances).
    pub fn cells(&self, instance: u32) -> &[CellRecord] {
        self.patches.cells_of(self.instance(instance).patch as usize)
    }

    /// Links of an instance, disabled ones among them (instance < num_instances).
    pub fn links(&self, instance: u32) -> &[LinkRecord] {
        self.patches.links_of(self.instance(instance).patch as usize)
    }

    /// The cell of a node (the node exists).
    pub fn cell(&self, node: WorldNode) -> &CellRecord {
        &self.cells(node.instance)[node.cell as usize]
    }

    /// Placement of a node in the world: planar root and height of the hips.
    pub fn place(&self, node: WorldNode) -> Placement {
        self.instance(node.instance).placement.compose(self.cell(node).placement)
    }

    /// True where a cell is enabled and not an exit: those are the entries of neighbours (the node exists).
    pub fn is_node(&self, node: WorldNode) -> bool {
        self.is_enabled(node) && !self.cell(node).has_flags(CellRecord::IS_EXIT)
    }

    /// True where a character may stay (the node exists).
    pub fn is_rest(&self, node: WorldNode) -> bool {
        let link = self.to_rest[self.index(node)];
        link != NONE && self.links(node.instance)[link as usize].to == node.cell
    }

    /// True where a rest cell can be reached without leaving the instance (the node exists).
    pub fn is_safe(&self, node: WorldNode) -> bool {
        self.to_rest[self.index(node)] != NONE
    }

    /// True for an instance of a narrow passage or a climb (instance < num_instances).
    pub(crate) fn is_narrow(&self, instance: u32) -> bool {
        self.narrow[instance as usize]
    }

    /// True for a tile that leads to no passage and no climb (instance < num_instances).
    pub(crate) fn is_off_climbs(&self, instance: u32) -> bool {
        self.is_tile(instance)
            && !self.is_narrow(instance)
            && !self.adjacencies(instance).any(|(_, a, _)| self.is_narrow(a.other))
    }

    /// True where a character may rest during a path: within an instance that is no narrow passage, nor part of a climb. (the node exists)
    pub fn is_stop(&self, node: WorldNode) -> bool {
        self.is_safe(node) && !self.is_narrow(node.instance)
    }

    /// True where motion with a tag begins at a node inside of an instance, and a character may stay there.
    pub fn can_begin_tag(&self, node: WorldNode, tag: u16) -> bool {
        let shows = |step| self.link(&step).is_some_and(|l| l.tag == tag);
        self.is_safe(node) && self.cell(node).edge == NONE && self.whole_link_steps(node).any(shows)
    }

    /// Units that are held in an instance (instance < num_instances).
    pub fn resources(&self, instance: u32) -> &[u32] {
        let r = self.instance(instance);
        &self.world.resources[r.first_resource as usize..][..r.num_resources as usize]
    }

    /// First step towards rest from a node that is safe; at a rest cell, the step that stays there.
    pub(crate) fn step_to_rest(&self, node: WorldNode) -> Option<WorldStep> {
        let link = self.to_rest[self.index(node)];
        if link == NONE { None } else { self.step_along(node.instance, link) }
    }

    /// Length of the longest link that one character plays alone (frames).
    pub(crate) fn max_link_frames(&self) -> u32 {
        self.patches.links.iter().filter(|l| !l.is_for_two()).map(|l| l.num_frames).max().unwrap_or(0).into()
    }

    /// True where a cell is enabled (the node exists).
    pub fn is_enabled(&self, node: WorldNode) -> bool {
        is_set(&self.world.cell_words, self.instance(node.instance).first_cell_word, node.cell)
    }

    /// True where a link is enabled (instance < num_instances, the link within its patch).
    pub fn is_link_enabled(&self, instance: u32, link: u32) -> bool {
        is_set(&self.world.link_words, self.instance(instance).first_link_word, link)
    }

    /// Path hierarchy, computed when it is first needed, and shared with clones.
    pub(crate) fn hierarchy(&self) -> &PathHierarchy {
        self.hierarchy.get_or_init(|| PathHierarchy::new(self))
    }

    /// Lowest and highest corner of all that bodies reach in an instance, in its patch's frame (m).
    pub(crate) fn reach_bounds(&self, instance: u32) -> [Vec3; 2] {
        let p = &self.patches.patches[self.instance(instance).patch as usize];
        [p.min, p.max].map(Vec3::from_array)
    }

    /// Middle of all that bodies reach in an instance (m).
    pub(crate) fn centre(&self, instance: u32) -> Vec3 {
        let [min, max] = self.reach_bounds(instance);
        self.instance(instance).placement.transform_point((min + max) * 0.5)
    }
}
