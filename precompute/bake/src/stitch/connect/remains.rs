//! Remaining motion of a world's instances and pairs: recomputed only where a change matters.

use super::crossing::{PairState, RemainingJoints};
use super::outcome::{InstanceOutcome, InstanceState, WorldCounts, cell_reason, is_end, link_reason};
use super::prepare::{StitchCache, make_missing};
use super::{component_cells::ComponentCells, joined::JoinedGraph};
use crate::stitch::place::place_patches::PlacedPatches;
use crate::stitch::sets::numbers::{IdentityArc, SharedNumbers};
use crate::{stitch::place::relation::RelativePlacement, stitch::report::RemovalReason};
use rayon::prelude::*;
use std::{collections::HashMap, sync::Arc};
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

/// Finds the remaining motion of a world.
///
/// - `found`: results of earlier searches.
pub fn find_remains(found: &mut StitchCache, placed: &PlacedPatches, judged: &JudgedGraph<'_>) -> WorldRemains {
    let mut out = WorldRemains::default();
    find_outcomes(&mut found.outcomes, placed, judged, &mut out);
    find_remaining_joints(&mut found.remaining, placed, judged.joined, &mut out);
    out
}

fn find_outcomes(
    known: &mut HashMap<InstanceState, Arc<InstanceOutcome>>,
    placed: &PlacedPatches,
    judged: &JudgedGraph<'_>,
    out: &mut WorldRemains,
) {
    let all = (0..placed.fitted.len() as u32).into_par_iter().with_min_len(256);
    let states: Vec<InstanceState> = all.map(|i| judged.state(i)).collect();
    make_missing(known, &states, |state| Arc::new(InstanceOutcome::new(&judged.joined.patches, state)));
    let mut numbers = SharedNumbers::default();
    out.outcome_of = states.iter().map(|state| numbers.number_of(&known[state])).collect();
    out.outcomes = numbers.all;
}

fn find_remaining_joints(
    known: &mut HashMap<PairState, Arc<RemainingJoints>>,
    placed: &PlacedPatches,
    joined: &JoinedGraph,
    out: &mut WorldRemains,
) {
    let state = |(&crossing, (a, b, _)): (&u32, &(u32, u32, RelativePlacement))| {
        let crossing = IdentityArc::new(joined.crossings.get(crossing as usize)?);
        Some(PairState { crossing, sides: [*a, *b].map(|i| IdentityArc::new(out.outcome(i))) })
    };
    let states: Vec<Option<PairState>> = joined.crossing_of.iter().zip(&placed.pairs).map(state).collect();
    let with_joints: Vec<PairState> = states.iter().flatten().cloned().collect();
    make_missing(known, &with_joints, |key| {
        let crossing = &key.crossing.0;
        let links = joined.patches.links_of(crossing.relation.a as usize);
        Arc::new(crossing.remaining(links, &key.sides[0].0.cells, &key.sides[1].0.cells))
    });
    let mut numbers = SharedNumbers::default();
    let number = |state: &Option<PairState>| state.as_ref().map_or(NONE, |state| numbers.number_of(&known[state]));
    out.remaining_of = states.iter().map(number).collect();
    out.remaining = numbers.all;
}
