//! Remaining motion of a world's instances and pairs: recomputed only where a change matters.

use super::component_cells::ComponentCells;
use super::crossing::{PairState, RemainingJoints};
use super::joined::JoinedGraph;
use super::outcome::{InstanceOutcome, InstanceState, WorldCounts, cell_reason, is_end, link_reason};
use super::prepare::{ChangedWorld, StitchCache, make_missing};
use crate::stitch::place::place_patches::PlacedPatches;
use crate::stitch::report::RemovalReason;
use crate::stitch::sets::identity_arc::IdentityArc;
use crate::stitch::sets::numbers::SharedNumbers;
use rayon::prelude::*;
use std::sync::Arc;
use throng_core::patch::NONE;
use throng_world::is_set;

/// The graph of a world, with the membership of its cells in the component.
pub(in crate::stitch) struct JudgedGraph<'j> {
    /// The graph.
    pub joined: &'j JoinedGraph,
    /// Membership of every cell.
    pub component: &'j ComponentCells,
}

impl JudgedGraph<'_> {
    /// Reason why a cell is removed; `None` if it remains.
    pub fn cell_reason(&self, part: u32, cell: u32) -> Option<RemovalReason> {
        let c = &self.joined.cells(part)[cell as usize];
        let alone = is_end(c) && self.joined.neighbour(part, c.edge).is_none();
        cell_reason(self.component.membership(self.joined, part, cell), alone)
    }

    /// Reason why a link is removed; `None` if it remains.
    pub fn link_reason(&self, part: u32, link: u32) -> Option<RemovalReason> {
        let l = &self.joined.patches.links_of(self.joined.parts[part as usize].patch as usize)[link as usize];
        let free = is_set(&self.joined.situation(part).link_words, 0, link);
        link_reason(free, self.cell_reason(part, l.from), || self.cell_reason(part, l.to))
    }

    /// True for an instance whose state relative to the component is unchanged.
    ///
    /// - `was`: its previous number, with equal surroundings.
    fn is_alike(&self, part: u32, before: &Self, was: u32) -> bool {
        let (now, old) = (self.joined.words(part), before.joined.words(was));
        let edges = self.joined.patches.edges_of(self.joined.parts[part as usize].patch as usize).len() as u32;
        self.component.inside[now.clone()] == before.component.inside[old.clone()]
            && self.component.to.moved[now] == before.component.to.moved[old]
            && (0..edges).all(|e| self.joined.neighbour(part, e).is_some() == before.joined.neighbour(was, e).is_some())
    }

    /// State of an instance relative to the component.
    fn state(&self, part: u32) -> InstanceState {
        let (joined, words) = (self.joined, self.joined.words(part));
        let edges = joined.patches.edges_of(joined.parts[part as usize].patch as usize).len() as u32;
        InstanceState {
            situation: IdentityArc::new(joined.situation(part)),
            inside: self.component.inside[words.clone()].to_vec(),
            leads: self.component.to.moved[words].to_vec(),
            has_neighbour: (0..edges).map(|e| joined.neighbour(part, e).is_some()).collect(),
        }
    }
}

/// Remaining motion of instances and pairs.
#[derive(Clone, Debug, Default)]
pub(in crate::stitch) struct WorldRemains {
    /// Number of the remaining motion of each instance.
    pub outcome_of: Vec<u32>,
    /// Remaining motions, each once, by the first instance.
    pub outcomes: Vec<Arc<InstanceOutcome>>,
    /// Number of the remaining joints of each pair; [`NONE`] without joints.
    pub remaining_of: Vec<u32>,
    /// Remaining joints, each set once, by the first pair.
    pub remaining: Vec<Arc<RemainingJoints>>,
}

impl WorldRemains {
    /// Remaining motion of an instance.
    pub fn outcome(&self, instance: u32) -> &Arc<InstanceOutcome> {
        &self.outcomes[self.outcome_of[instance as usize] as usize]
    }

    /// Counts of all remaining motion.
    pub fn counts(&self) -> WorldCounts {
        let mut sum = WorldCounts::default();
        self.outcome_of.iter().for_each(|&o| sum.add(&self.outcomes[o as usize].counts));
        let left = self.remaining_of.iter().filter_map(|&l| self.remaining.get(l as usize));
        sum.joints = left.map(|left| left.count).sum();
        sum
    }
}

/// Search for the remaining motion of a world.
pub(in crate::stitch) struct RemainsSearch<'s> {
    /// Results of earlier searches.
    pub found: &'s mut StitchCache,
    /// Placed patches.
    pub placed: &'s PlacedPatches,
    /// The graph.
    pub judged: &'s JudgedGraph<'s>,
    /// The world before a change, and the previous number of each unchanged instance, as in
    /// [`super::update_component::PriorGraph::previous_of`].
    pub past: Option<(ChangedWorld<'s>, &'s [u32])>,
}

impl RemainsSearch<'_> {
    /// Finds the remaining motion.
    pub fn find(mut self) -> WorldRemains {
        let mut out = WorldRemains::default();
        let is_same = self.find_outcomes(&mut out);
        self.find_remaining_joints(&is_same, &mut out);
        out
    }

    /// - returns for each instance whether its remaining motion is unchanged.
    fn find_outcomes(&mut self, out: &mut WorldRemains) -> Vec<bool> {
        let Self { placed, judged, past, .. } = *self;
        let all = 0..placed.fitted.len() as u32;
        let was = |i: u32| past.map_or(NONE, |(_, same)| same[i as usize]);
        let before = past.map(|(past, _)| {
            (past.result, JudgedGraph { joined: &past.result.joined, component: &past.result.component })
        });
        let state = |i: u32| match &before {
            Some((_, before)) if was(i) != NONE && judged.is_alike(i, before, was(i)) => None,
            _ => Some(judged.state(i)),
        };
        let states: Vec<Option<InstanceState>> = all.clone().into_par_iter().with_min_len(256).map(state).collect();
        let new: Vec<InstanceState> = states.iter().flatten().cloned().collect();
        let known = &mut self.found.outcomes;
        make_missing(known, &new, |state| Arc::new(InstanceOutcome::new(&judged.joined.patches, state)));
        let mut numbers = SharedNumbers::new(before.as_ref().map_or(&[], |(made, _)| &made.remains.outcomes));
        for (i, state) in all.zip(&states) {
            out.outcome_of.push(match (state, &before) {
                (Some(state), _) => numbers.number_of(&known[state]),
                (None, Some((made, _))) => numbers.renumber(made.remains.outcome_of[was(i) as usize]),
                (None, None) => NONE,
            });
        }
        out.outcomes = numbers.all;
        states.iter().map(Option::is_none).collect()
    }

    /// - `is_same`: for each instance, whether its remaining motion is unchanged.
    fn find_remaining_joints(&mut self, is_same: &[bool], out: &mut WorldRemains) {
        let (placed, joined, past) = (self.placed, self.judged.joined, self.past.map(|(past, _)| past));
        let before = past.map(|past| past.result);
        let crossing_before = |was: u32| {
            let joined = &before?.joined;
            joined.crossings.get(*joined.crossing_of.get(was as usize)? as usize)
        };
        // Previous number of a pair, if everything about it is unchanged.
        let was = |k: usize| {
            let was = past.map_or(NONE, |past| past.kept.previous_pair_of[k]);
            let (a, b, _) = placed.pairs[k];
            let is_left = is_same[a as usize] && is_same[b as usize];
            let crossing = &joined.crossings[joined.crossing_of[k] as usize];
            let is_alike = is_left && crossing_before(was).is_some_and(|before| Arc::ptr_eq(before, crossing));
            if is_alike { was } else { NONE }
        };
        let state = |k: usize| PairState {
            crossing: IdentityArc::new(&joined.crossings[joined.crossing_of[k] as usize]),
            sides: [placed.pairs[k].0, placed.pairs[k].1].map(|i| IdentityArc::new(out.outcome(i))),
        };
        let has_joints = |k: &usize| joined.crossing_of[*k] != NONE;
        let pairs: Vec<(usize, u32)> = (0..placed.pairs.len()).filter(has_joints).map(|k| (k, was(k))).collect();
        let new: Vec<PairState> = pairs.iter().filter(|(_, was)| *was == NONE).map(|(k, _)| state(*k)).collect();
        let known = &mut self.found.remaining;
        make_missing(known, &new, |key| {
            let crossing = &key.crossing.0;
            let links = joined.patches.links_of(crossing.relation.a as usize);
            Arc::new(crossing.remaining(links, &key.sides[0].0.cells, &key.sides[1].0.cells))
        });
        let mut numbers = SharedNumbers::new(before.map_or(&[], |made| &made.remains.remaining));
        let mut left_of = vec![NONE; placed.pairs.len()];
        let mut new = new.iter();
        for (k, was) in pairs {
            left_of[k] = match (was, before) {
                (NONE, _) | (_, None) => new.next().map_or(NONE, |key| numbers.number_of(&known[key])),
                (was, Some(made)) => numbers.renumber(made.remains.remaining_of[was as usize]),
            };
        }
        (out.remaining_of, out.remaining) = (left_of, numbers.all);
    }
}
