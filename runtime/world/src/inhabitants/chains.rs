//! Chains: the reserved steps of a character, up to a node from which it can come to rest.

use super::purpose::Purpose;
use super::reservations::UnitReservations;
use crate::plan::SearchSpace;
use crate::{WorldGraph, WorldNode, WorldStep};
use throng_base::maths;
use throng_core::characters::uniform_random;

/// Most steps between two places where a character can come to rest.
pub(super) const MAX_CHAIN: usize = 128;
/// Most nodes that are opened in looking for such a place.
pub(super) const MAX_OPENED: usize = 4096;

/// Chains of all characters; memory for all of them.
#[derive(Clone, Debug)]
pub(super) struct Chains {
    steps: Vec<WorldStep>,
    /// Index of the next step, and of the one after the last.
    ranges: Vec<[usize; 2]>,
}

impl Chains {
    pub fn new(num_characters: usize) -> Self {
        Self { steps: vec![WorldStep::NONE; num_characters * MAX_CHAIN], ranges: vec![[0, 0]; num_characters] }
    }

    /// Steps that are left.
    pub fn steps_of(&self, character: usize) -> &[WorldStep] {
        let [next, end] = self.ranges[character];
        &self.steps[character * MAX_CHAIN..][next..end]
    }

    /// Removes the next step and returns it.
    pub fn pop(&mut self, character: usize) -> Option<WorldStep> {
        let step = *self.steps_of(character).first()?;
        self.ranges[character][0] += 1;
        Some(step)
    }

    /// Replaces the chain by other steps (at most MAX_CHAIN).
    pub fn set(&mut self, character: usize, steps: &[WorldStep]) {
        self.steps[character * MAX_CHAIN..][..steps.len()].copy_from_slice(steps);
        self.ranges[character] = [0, steps.len()];
    }

    /// Copies the chain of another character.
    pub fn copy(&mut self, from: usize, to: usize) {
        self.steps.copy_within(from * MAX_CHAIN..(from + 1) * MAX_CHAIN, to * MAX_CHAIN);
        self.ranges[to] = self.ranges[from];
    }

    /// Replaces the chain by one step; returns the slots after it.
    pub fn begin_chain(&mut self, character: usize, step: WorldStep) -> &mut [WorldStep] {
        let room = &mut self.steps[character * MAX_CHAIN..][..MAX_CHAIN];
        room[0] = step;
        self.ranges[character] = [0, 1];
        &mut room[1..]
    }

    /// Adds the steps that were written there, or removes the chain where there are too many.
    ///
    /// - returns false where there are too many.
    pub fn extend_chain(&mut self, character: usize, num_steps: usize) -> bool {
        let fits = num_steps < MAX_CHAIN;
        self.ranges[character] = if fits { [0, 1 + num_steps] } else { [0, 0] };
        fits
    }
}

/// Search for the nearest place to come to rest, through free instances, along randomly preferred paths.
pub(super) struct SafetySearch<'a> {
    pub graph: &'a WorldGraph,
    pub reservations: &'a UnitReservations,
    pub character: u32,
    pub seed: u64,
    pub draw: u32,
    /// Direction in which the character roams, if any, its position (m), and the least distance from there at which the
    /// search ends (m). It then ends on no chair and no equipment.
    pub bound: Option<(Purpose, [f32; 2], f32)>,
    /// True where it may end in a passage.
    pub is_inside: bool,
}

impl SearchSpace for SafetySearch<'_> {
    fn admits(&self, instance: u32) -> bool {
        self.reservations.are_free(self.graph, instance, self.character)
    }

    fn is_target(&self, node: WorldNode) -> bool {
        let at = self.graph.place(node);
        (self.graph.is_stop(node) || self.is_inside && self.graph.is_safe(node))
            && self.bound.is_none_or(|(_, [x, z], least_m)| {
                self.graph.is_tile(node.instance) && maths::hypot(at.x - x, at.z - z) >= least_m
            })
    }

    fn cost(&self, step: &WorldStep) -> f32 {
        let chance =
            uniform_random(self.seed ^ u64::from(self.draw), u64::from(step.to.instance), u64::from(step.to.cell));
        // A link of a tile may be entered from a block or left for one: the tile's units are needed too.
        let free = self.graph.link(step).is_none() || self.admits(step.instance);
        // Paths in other directions cost up to three times as much.
        let lead = self.bound.and_then(|(purpose, from, _)| purpose.alignment(self.graph, from, step));
        let astray = lead.map_or(0.0, |lead| 2.0 - 2.0 * lead);
        if free { step.num_frames() as f32 * (0.5 + chance + astray) } else { f32::INFINITY }
    }
}

/// Search for a path to one of the steps of a path.
pub(super) struct RejoinSearch<'a> {
    pub graph: &'a WorldGraph,
    pub reservations: &'a UnitReservations,
    pub character: u32,
    /// Node of the character.
    pub start: WorldNode,
    /// The steps.
    pub steps: &'a [WorldStep],
    /// True where it may lead through what others hold.
    pub through: bool,
}

impl SearchSpace for RejoinSearch<'_> {
    fn admits(&self, instance: u32) -> bool {
        self.through || self.reservations.are_free(self.graph, instance, self.character)
    }

    fn is_target(&self, node: WorldNode) -> bool {
        node != self.start && self.steps.iter().any(|s| s.to == node)
    }

    fn cost(&self, step: &WorldStep) -> f32 {
        step.num_frames() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::World;
    use crate::made_up_floor::{SIDE, tables, world};
    use crate::plan::{Nodes, SearchResult};

    #[test]
    fn who_leaves_comes_to_rest_elsewhere() {
        let tables = tables();
        let world = World::from_data(&world(&tables, &["#####", "#b###", "#####"]), &tables).unwrap();
        let graph = world.graph();
        let reservations = UnitReservations::new(graph, 1);
        let mut nodes = Nodes::new(graph);
        let start = graph.rest_cells(7).next().unwrap();
        let [from, mut nearest] = [graph.place(start), graph.place(start)].map(|p| [p.x, p.z]);
        for (draw, least_m) in (0..40).map(|k| (k, [0.0, 1.2 * SIDE][k as usize % 2])) {
            let bound = Some((Purpose::default(), from, least_m));
            let mut space = SafetySearch {
                graph,
                reservations: &reservations,
                character: 0,
                seed: 1,
                draw,
                bound,
                is_inside: false,
            };
            let SearchResult::Path(path) = nodes.search(graph, start, &mut space, MAX_OPENED) else {
                panic!("no path for draw {draw}")
            };
            let mut steps = [WorldStep::NONE; MAX_CHAIN];
            let num_steps = nodes.write_path(path, &mut steps);
            let end = steps[..num_steps].last().map_or(start, |s| s.to);
            let at = [graph.place(end).x, graph.place(end).z];
            let away_m = maths::hypot(at[0] - from[0], at[1] - from[1]);
            assert!(graph.is_stop(end) && graph.is_tile(end.instance) && away_m >= least_m, "{draw}: {away_m} m");
            if least_m == 0.0 {
                nearest = at;
            }
        }
        assert!(maths::hypot(nearest[0] - from[0], nearest[1] - from[1]) < 1.2 * SIDE, "others need not leave");
    }
}
