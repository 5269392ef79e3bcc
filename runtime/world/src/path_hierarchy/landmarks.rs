//! Landmarks: places all around a world, with the costs to reach them from everywhere (Goldberg and Harrelson 2005).
//!
//! A path to a landmark over another place is no shorter than the direct one: the difference of both places' costs to
//! the landmark is a lower bound of the cost between them.

use super::dial::{Dial, UNREACHED};
use super::{Entrance, PathHierarchy, each};
use crate::WorldGraph;
use serde::{Deserialize, Serialize};

/// Number of landmarks: more of them raise lower bounds, and each takes a search over the world for the first planner,
/// two bytes a state, and a comparison whenever the upper layer reaches a state.
const NUM: usize = 12;

/// Costs from somewhere to each landmark (frames).
pub(crate) type ToLandmarks = [u16; NUM];

/// Costs to landmarks from all states: entrances, and then exits.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Landmarks {
    /// Costs from or to each state.
    #[serde(with = "crate::pod")]
    pub costs: Vec<ToLandmarks>,
}

impl Landmarks {
    /// Chooses them, each as far from all others as can be, and searches from everywhere to them.
    ///
    /// None where costs through regions are not kept: each search would work all of them out anew.
    pub fn new(graph: &WorldGraph, hierarchy: &PathHierarchy) -> Self {
        let landmarks = if hierarchy.region_costs.keeps_rows() { choose(graph, hierarchy) } else { Vec::new() };
        let num_states = hierarchy.entrances.len() + hierarchy.exits.len();
        let mut out = Self { costs: vec![[UNREACHED; NUM]; num_states] };
        let costs = each(&landmarks, |&to, search| {
            search_back(hierarchy, to, search);
            (0..num_states as u32).map(|s| search.cost(s)).collect::<Vec<_>>()
        });
        for (k, costs) in costs.iter().enumerate() {
            out.costs.iter_mut().zip(costs).for_each(|(to, cost)| to[k] = *cost);
        }
        out
    }

    /// Distances from nowhere.
    pub const UNKNOWN_DISTANCES: ToLandmarks = [UNREACHED; NUM];

    /// Notes that a state is so near to somewhere, from where costs are known so far.
    pub fn note_distance(&self, from: &mut ToLandmarks, state: u32, cost: f32) {
        if cost < f32::from(UNREACHED) {
            let near = cost.max(0.0) as u16;
            for (from, on) in from.iter_mut().zip(&self.costs[state as usize]) {
                *from = (*from).min(near.saturating_add(*on));
            }
        }
    }

    /// Lower bound of the cost from somewhere to a state (frames).
    pub fn least_cost(&self, from: &ToLandmarks, state: u32) -> f32 {
        let pairs = from.iter().zip(&self.costs[state as usize]);
        // The largest stored cost may stand for a larger one, and bounds no difference.
        let known = |(from, on): (&u16, &u16)| if *on < UNREACHED - 1 { from.saturating_sub(*on) } else { 0 };
        pairs.map(known).fold(0, u16::max).into()
    }
}

/// Entrances that are far from each other.
fn choose(graph: &WorldGraph, hierarchy: &PathHierarchy) -> Vec<u32> {
    let place = |state: u32| Some((state, graph.centre(hierarchy.leads_from(state)?.1), f32::INFINITY));
    let mut places: Vec<_> = (0..hierarchy.entrances.len() as u32).filter_map(place).collect();
    let mut chosen = Vec::new();
    while let Some(&(state, at, far)) = places.iter().max_by(|a, b| a.2.total_cmp(&b.2).then(b.0.cmp(&a.0))) {
        if chosen.len() == NUM || far == 0.0 {
            break;
        }
        chosen.push(state);
        places.iter_mut().for_each(|p| p.2 = p.2.min(p.1.distance(at)));
    }
    chosen
}

/// Least costs to a state from all others.
fn search_back(hierarchy: &PathHierarchy, to: u32, search: &mut Dial) {
    let num_entrances = hierarchy.entrances.len() as u32;
    search.run(num_entrances as usize + hierarchy.exits.len(), [(to, 0)].into_iter(), |search, state| {
        let Some(out) = state.checked_sub(num_entrances) else {
            if let Entrance::Cluster { from, to } = hierarchy.entrances[state as usize] {
                let exits = hierarchy.exits_of(from).filter(|&o| hierarchy.exits[o as usize].to == Some(to));
                exits.for_each(|o| search.reach_state(num_entrances + o, 0));
            }
            let Some((region, ..)) = hierarchy.leads_from(state) else { return };
            for (place, &frames) in
                hierarchy.region_costs.list(region).zip(hierarchy.region_costs.row(state, region).unwrap_or_default())
            {
                if frames != UNREACHED {
                    search.reach_state(hierarchy.region_costs.states[place], frames);
                }
            }
            return;
        };
        let cluster = hierarchy.exits[out as usize].cluster;
        let number = out - hierarchy.exits_of(cluster).start;
        for (k, entrance) in hierarchy.entrances_of(cluster).enumerate() {
            let frames = hierarchy.costs_in(cluster).cost_across(k as u32, number);
            if frames < f32::INFINITY {
                search.reach_state(entrance, frames as u16);
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nowhere_is_nearer_than_landmarks_say(arcs in prop::collection::vec((0usize..8, 0usize..8, 0u16..90), 0..40)) {
            let mut far = [[u32::MAX; 8]; 8];
            (0..8).for_each(|n| far[n][n] = 0);
            arcs.iter().for_each(|&(from, to, frames)| far[from][to] = far[from][to].min(frames.into()));
            for by in 0..8 {
                for (from, to) in (0..8).flat_map(|from| (0..8).map(move |to| (from, to))) {
                    far[from][to] = far[from][to].min(far[from][by].saturating_add(far[by][to]));
                }
            }
            let cost = |from: usize, to: usize| u16::try_from(far[from][to]).unwrap_or(UNREACHED);
            let to_all = |from| std::array::from_fn(|k| cost(from, k % 5));
            let landmarks = Landmarks { costs: (0..8).map(to_all).collect() };
            for from in 0..8 {
                let mut near = Landmarks::UNKNOWN_DISTANCES;
                landmarks.note_distance(&mut near, from as u32, 0.0);
                for to in (0..8).filter(|&to| far[from][to] < u32::MAX) {
                    prop_assert!(landmarks.least_cost(&near, to as u32) <= far[from][to] as f32, "{} {}", from, to);
                }
            }
        }
    }
}
