//! Narrow passages: tiles that lead from one place to another and nowhere else.
//!
//! A character that waits in one blocks it; so none rests there, and the passage is taken as a whole.

use super::WorldGraph;
use throng_core::patch::NONE;

/// Longest passage that is taken as a whole: in longer ones people follow each other (instances).
const LONGEST: usize = 8;
/// A path around an instance that is not longer than this is no detour (instances).
const AROUND: usize = 5;

/// True for every instance that is part of a narrow passage (instances).
pub(super) fn narrow_passages(graph: &WorldGraph) -> Vec<bool> {
    let mut narrow: Vec<bool> = (0..graph.num_instances() as u32).map(|i| is_narrow(graph, i)).collect();
    let mut seen = vec![false; narrow.len()];
    for first in 0..narrow.len() {
        if !narrow[first] || seen[first] {
            continue;
        }
        seen[first] = true;
        let (mut part, mut next, mut leads_out) = (vec![first as u32], 0, false);
        while let Some(&i) = part.get(next) {
            next += 1;
            for_each_other(graph, i, |o| {
                leads_out |= !narrow[o as usize];
                if narrow[o as usize] && !seen[o as usize] {
                    seen[o as usize] = true;
                    part.push(o);
                }
            });
        }
        if part.len() > LONGEST || !leads_out {
            part.iter().for_each(|&i| narrow[i as usize] = false);
        }
    }
    narrow
}

/// True for a tile between two others that are far from each other without it.
fn is_narrow(graph: &WorldGraph, instance: u32) -> bool {
    let (mut others, mut count) = ([NONE; 2], 0);
    for_each_other(graph, instance, |o| {
        if !others.contains(&o) {
            if let Some(slot) = others.get_mut(count) {
                *slot = o;
            }
            count += 1;
        }
    });
    graph.is_tile(instance) && count == 2 && !are_near(graph, others, instance)
}

/// True where one instance leads to another one through few others, without a given one.
fn are_near(graph: &WorldGraph, [from, to]: [u32; 2], without: u32) -> bool {
    let (mut seen, mut first) = (vec![without, from], 1);
    for _ in 0..AROUND {
        let end = seen.len();
        for at in first..end {
            for_each_other(graph, seen[at], |o| {
                if !seen.contains(&o) {
                    seen.push(o);
                }
            });
        }
        first = end;
    }
    seen.contains(&to)
}

/// Instances that one leads to.
fn for_each_other(graph: &WorldGraph, instance: u32, mut visit: impl FnMut(u32)) {
    let r = graph.instance(instance);
    let num_edges = graph.patches().patches[r.patch as usize].num_edges;
    for slot in r.first_neighbour..r.first_neighbour + num_edges {
        if graph.bounds.is_edge_open(slot) {
            visit(graph.world().neighbours[slot as usize]);
        }
    }
    for (k, a, _) in graph.adjacencies(instance) {
        if graph.bounds.is_open_outwards(k) {
            visit(a.other);
        }
    }
}
