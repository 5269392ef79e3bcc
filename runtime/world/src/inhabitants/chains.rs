//! Chains: the reserved steps of a character, up to a node from which it can come to rest.

use super::{purpose::Purpose, reservations::UnitReservations};
use crate::{WorldGraph, WorldNode, WorldStep, plan::SearchSpace};
use glam::Vec3;
use throng_base::maths;
use throng_core::{Planar, characters::uniform_random};

/// Most steps between two places where a character can come to rest.
pub(super) const MAX_CHAIN: usize = 128;
/// Least distance of the hips of two that follow each other, at which no bodies touch (m), and frames between two
/// times at which it is compared.
pub(super) const APART_M: f32 = 2.5;
const APART_EVERY: f32 = 4.0;
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

    /// Adds a step (there is room); returns the slots after it.
    pub fn extend_chain_by(&mut self, character: usize, step: WorldStep) -> &mut [WorldStep] {
        let end = &mut self.ranges[character][1];
        let room = &mut self.steps[character * MAX_CHAIN..][..MAX_CHAIN][*end..];
        *end += 1;
        room[0] = step;
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

/// Places and reservations of a character over time, from now to the end of its chain.
pub(super) struct ChainSchedule<'a> {
    pub graph: &'a WorldGraph,
    /// Planar root now.
    pub root: Planar,
    /// Time until the chain begins (frames).
    pub frames_left: f32,
    /// Instances that the present motion leads through, and node that it leads to.
    pub through: [u32; 2],
    pub at: WorldNode,
    pub chain: &'a [WorldStep],
}

impl ChainSchedule<'_> {
    fn end_frames(&self) -> f32 {
        self.frames_left + self.chain.iter().map(WorldStep::num_frames).sum::<u32>() as f32
    }

    /// True where it leads through a passage or a climb.
    pub fn is_narrow(&self) -> bool {
        let chain = self.chain.iter().map(|s| s.to.instance);
        self.through.into_iter().chain([self.at.instance]).chain(chain).any(|instance| self.graph.is_narrow(instance))
    }

    /// Time after which a unit is surely released: the end of the step after the last one that leads to it (frames);
    /// none for one that the character may stay in.
    fn frames_until_release(&self, unit: u32) -> Option<f32> {
        let needs = |instance: u32| self.graph.resources(instance).contains(&unit);
        let (mut leads_there, mut frames) = (needs(self.at.instance), self.frames_left);
        let mut released = (!leads_there).then_some(if self.through.into_iter().any(needs) { frames } else { 0.0 });
        for step in self.chain {
            let was_there = std::mem::replace(&mut leads_there, needs(step.to.instance));
            frames += step.num_frames() as f32;
            if leads_there {
                released = None;
            } else if was_there || needs(step.instance) {
                released = Some(frames);
            }
        }
        released
    }

    /// Approximate position of the hips: they go along a straight line from each node to the next (m).
    fn place_at(&self, mut frames: f32) -> Vec3 {
        let place = |node| self.graph.place(node).translation();
        let (mut from, mut to) = (Vec3::new(self.root.x, place(self.at).y, self.root.z), place(self.at));
        let mut length = self.frames_left.max(1.0);
        for step in self.chain {
            if frames <= length {
                break;
            }
            frames -= length;
            (from, to, length) = (to, place(step.to), step.num_frames() as f32);
        }
        from.lerp(to, (frames / length).min(1.0))
    }

    /// True where a character may use a unit that another one reserves: both leave it, the other one before the
    /// character stays in it, and on their way their hips are never nearer than a distance (m).
    pub fn follows(&self, other: &Self, unit: u32, least_m: f32) -> bool {
        let passes = self.frames_until_release(unit).is_some();
        let is_left = |left: f32| passes || left <= self.end_frames();
        other.frames_until_release(unit).is_some_and(is_left) && self.is_apart(other, least_m)
    }

    fn is_apart(&self, other: &Self, least_m: f32) -> bool {
        let num = (self.end_frames().min(other.end_frames()) / APART_EVERY).ceil() as u32;
        let far = |k: u32| {
            let frames = k as f32 * APART_EVERY;
            self.place_at(frames).distance_squared(other.place_at(frames)) > least_m * least_m
        };
        (0..=num).all(far)
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
    /// True where it ends on a tile that leads to no passage and no climb, and leads through these behind others.
    pub off_climbs: bool,
}

impl SearchSpace for SafetySearch<'_> {
    fn admits(&self, instance: u32) -> bool {
        self.off_climbs && !self.graph.is_off_climbs(instance)
            || self.reservations.are_free(self.graph, instance, self.character)
    }

    fn is_target(&self, node: WorldNode) -> bool {
        let at = self.graph.place(node);
        (self.graph.is_stop(node) || self.is_inside && self.graph.is_safe(node))
            && (!self.off_climbs || self.graph.is_off_climbs(node.instance))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::World;
    use crate::inhabitants::{InhabitantGoal, Inhabitants, InhabitantsConfig};
    use crate::made_up_floor::{SIDE, tables, world};
    use crate::plan::{Nodes, SearchResult};
    use throng_base::Inline;
    use throng_core::CharacterGroup;

    #[test]
    fn who_leaves_comes_to_rest_elsewhere() {
        let tables = tables();
        let world = World::from_data(&world(&tables, &["#####", "#b###", "#####"]), &tables).unwrap();
        let graph = world.graph();
        let reservations = UnitReservations::new(graph);
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
                off_climbs: false,
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

    #[test]
    fn who_is_behind_follows_through_a_passage_but_not_to_where_another_one_may_stay() {
        let tables = tables();
        let rows = ["###......###", "############", "###......###"];
        let world = World::from_data(&world(&tables, &rows), &tables).unwrap();
        let graph = world.graph();
        let rest = |x: f32| world.nearest_place(Vec3::new(x * SIDE, 0.9, SIDE), 2.0).unwrap();
        let mut people = Inhabitants::new(&world, 1, InhabitantsConfig::default()).unwrap();
        let id = people.spawn(rest(1.0).node).unwrap();
        people.order(id, InhabitantGoal::GoToPlace { place: rest(10.0) }).unwrap();
        while people.reserved_steps(id).unwrap().len() < 5 {
            people.step(1.0 / 30.0, &Inline).unwrap();
        }
        let chain = people.reserved_steps(id).unwrap().to_vec();
        let at = people.state(id).unwrap().node;
        let place = graph.place(at);
        let schedule = |behind_m: f32, frames_left| ChainSchedule {
            graph,
            root: Planar::new(place.x - behind_m, place.z, 0.0),
            frames_left,
            through: [at.instance; 2],
            at,
            chain: &chain,
        };
        let [middle, end] = [chain.len() / 2, chain.len() - 1].map(|k| graph.resources(chain[k].to.instance)[0]);
        let (first, behind, too_near) = (schedule(0.0, 1.0), schedule(5.0, 130.0), schedule(1.0, 30.0));
        assert!(first.is_narrow() && behind.follows(&first, middle, APART_M));
        assert!(!too_near.follows(&first, middle, APART_M) && !behind.follows(&first, end, APART_M));
    }
}
