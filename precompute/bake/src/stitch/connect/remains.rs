//! Remaining motion of a world's instances and pairs: recomputed only where a change matters.

use super::crossing::{Left, PairState};
use super::joined::Joined;
use super::outcome::{Counts, Outcome, State, is_end, of_cell, of_link};
use super::prepare::{Found, Past, learn};
use super::settled::Settled;
use crate::stitch::place::lay::Laid;
use crate::stitch::report::Reason;
use crate::stitch::sets::numbers::Numbers;
use crate::stitch::sets::same::Same;
use rayon::prelude::*;
use std::sync::Arc;
use throng_core::patch::NONE;
use throng_world::is_set;

/// The graph of a world, with the membership of its cells in the component.
pub(in crate::stitch) struct Judged<'j> {
    /// The graph.
    pub joined: &'j Joined,
    /// Membership of every cell.
    pub settled: &'j Settled,
}

impl Judged<'_> {
    /// Reason why a cell is removed; `None` if it remains.
    pub fn cell(&self, part: u32, cell: u32) -> Option<Reason> {
        let c = &self.joined.cells(part)[cell as usize];
        let alone = is_end(c) && self.joined.neighbour(part, c.edge).is_none();
        of_cell(self.settled.standing(self.joined, part, cell), alone)
    }

    /// Reason why a link is removed; `None` if it remains.
    pub fn link(&self, part: u32, link: u32) -> Option<Reason> {
        let l = &self.joined.patches.links_of(self.joined.parts[part as usize].patch as usize)[link as usize];
        let free = is_set(&self.joined.situation(part).link_words, 0, link);
        of_link(free, self.cell(part, l.from), || self.cell(part, l.to))
    }

    /// True for an instance whose state relative to the component is unchanged.
    ///
    /// - `was`: its previous number, with equal surroundings.
    fn is_alike(&self, part: u32, before: &Self, was: u32) -> bool {
        let (now, old) = (self.joined.words(part), before.joined.words(was));
        let edges = self.joined.patches.edges_of(self.joined.parts[part as usize].patch as usize).len() as u32;
        self.settled.inside[now.clone()] == before.settled.inside[old.clone()]
            && self.settled.to.moved[now] == before.settled.to.moved[old]
            && (0..edges).all(|e| self.joined.neighbour(part, e).is_some() == before.joined.neighbour(was, e).is_some())
    }

    /// State of an instance relative to the component.
    fn state(&self, part: u32) -> State {
        let (joined, words) = (self.joined, self.joined.words(part));
        let edges = joined.patches.edges_of(joined.parts[part as usize].patch as usize).len() as u32;
        State {
            situation: Same::new(joined.situation(part)),
            inside: self.settled.inside[words.clone()].to_vec(),
            leads: self.settled.to.moved[words].to_vec(),
            has_neighbour: (0..edges).map(|e| joined.neighbour(part, e).is_some()).collect(),
        }
    }
}

/// Remaining motion of instances and pairs.
#[derive(Clone, Debug, Default)]
pub(in crate::stitch) struct Remains {
    /// Number of the remaining motion of each instance.
    pub outcome_of: Vec<u32>,
    /// Remaining motions, each once, by the first instance.
    pub outcomes: Vec<Arc<Outcome>>,
    /// Number of the remaining joints of each pair; [`NONE`] without joints.
    pub left_of: Vec<u32>,
    /// Remaining joints, each set once, by the first pair.
    pub left: Vec<Arc<Left>>,
}

impl Remains {
    /// Remaining motion of an instance.
    pub fn outcome(&self, instance: u32) -> &Arc<Outcome> {
        &self.outcomes[self.outcome_of[instance as usize] as usize]
    }

    /// Counts of all remaining motion.
    pub fn counts(&self) -> Counts {
        let mut sum = Counts::default();
        self.outcome_of.iter().for_each(|&o| sum.add(&self.outcomes[o as usize].counts));
        let left = self.left_of.iter().filter_map(|&l| self.left.get(l as usize));
        sum.joints = left.map(|left| left.count).sum();
        sum
    }
}

/// Finds the remaining motion of a world.
///
/// - `past`: the world before a change, and the previous number of each unchanged instance, as in
///   [`super::resettle::Before::same`].
pub(in crate::stitch) fn remain(
    found: &mut Found,
    laid: &Laid,
    judged: &Judged<'_>,
    past: Option<(Past<'_>, &[u32])>,
) -> Remains {
    let mut out = Remains::default();
    let is_same = outcomes(found, laid, judged, past, &mut out);
    left(found, laid, judged.joined, past.map(|(past, _)| past), &is_same, &mut out);
    out
}

/// - returns for each instance whether its remaining motion is unchanged.
fn outcomes(
    found: &mut Found,
    laid: &Laid,
    judged: &Judged<'_>,
    past: Option<(Past<'_>, &[u32])>,
    out: &mut Remains,
) -> Vec<bool> {
    let all = 0..laid.fitted.len() as u32;
    let was = |i: u32| past.map_or(NONE, |(_, same)| same[i as usize]);
    let before = past.map(|(past, _)| (past.made, Judged { joined: &past.made.joined, settled: &past.made.settled }));
    let state = |i: u32| match &before {
        Some((_, before)) if was(i) != NONE && judged.is_alike(i, before, was(i)) => None,
        _ => Some(judged.state(i)),
    };
    let states: Vec<Option<State>> = all.clone().into_par_iter().with_min_len(256).map(state).collect();
    let new: Vec<State> = states.iter().flatten().cloned().collect();
    let known = &mut found.outcomes;
    learn(known, &new, |state| Arc::new(Outcome::new(&judged.joined.patches, state)));
    let mut numbers = Numbers::new(before.as_ref().map_or(&[], |(made, _)| &made.remains.outcomes));
    for (i, state) in all.zip(&states) {
        out.outcome_of.push(match (state, &before) {
            (Some(state), _) => numbers.of(&known[state]),
            (None, Some((made, _))) => numbers.same(made.remains.outcome_of[was(i) as usize]),
            (None, None) => NONE,
        });
    }
    out.outcomes = numbers.into_all();
    states.iter().map(Option::is_none).collect()
}

/// - `is_same`: for each instance, whether its remaining motion is unchanged.
fn left(found: &mut Found, laid: &Laid, joined: &Joined, past: Option<Past<'_>>, is_same: &[bool], out: &mut Remains) {
    let before = past.map(|past| past.made);
    let crossing_before = |was: u32| {
        let joined = &before?.joined;
        joined.crossings.get(*joined.crossing_of.get(was as usize)? as usize)
    };
    // Previous number of a pair, if everything about it is unchanged.
    let was = |k: usize| {
        let was = past.map_or(NONE, |past| past.kept.pairs_were[k]);
        let (a, b, _) = laid.pairs[k];
        let is_left = is_same[a as usize] && is_same[b as usize];
        let crossing = &joined.crossings[joined.crossing_of[k] as usize];
        let is_alike = is_left && crossing_before(was).is_some_and(|before| Arc::ptr_eq(before, crossing));
        if is_alike { was } else { NONE }
    };
    let state = |k: usize| PairState {
        crossing: Same::new(&joined.crossings[joined.crossing_of[k] as usize]),
        sides: [laid.pairs[k].0, laid.pairs[k].1].map(|i| Same::new(out.outcome(i))),
    };
    let has_joints = |k: &usize| joined.crossing_of[*k] != NONE;
    let pairs: Vec<(usize, u32)> = (0..laid.pairs.len()).filter(has_joints).map(|k| (k, was(k))).collect();
    let new: Vec<PairState> = pairs.iter().filter(|(_, was)| *was == NONE).map(|(k, _)| state(*k)).collect();
    let known = &mut found.left;
    learn(known, &new, |key| {
        let crossing = &key.crossing.0;
        let links = joined.patches.links_of(crossing.relation.a as usize);
        Arc::new(crossing.left(links, &key.sides[0].0.cells, &key.sides[1].0.cells))
    });
    let mut numbers = Numbers::new(before.map_or(&[], |made| &made.remains.left));
    let mut left_of = vec![NONE; laid.pairs.len()];
    let mut new = new.iter();
    for (k, was) in pairs {
        left_of[k] = match (was, before) {
            (NONE, _) | (_, None) => new.next().map_or(NONE, |key| numbers.of(&known[key])),
            (was, Some(made)) => numbers.same(made.remains.left_of[was as usize]),
        };
    }
    (out.left_of, out.left) = (left_of, numbers.into_all());
}
