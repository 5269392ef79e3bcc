//! Narrow passages: tiles that lead from one place to another and nowhere else; and climbs: floors of few tiles, with the
//! stairs, ladders and slides that lead there.
//!
//! A character that waits in one blocks it; so none rests there, and each goes through the whole passage at once, alone
//! or behind others.

use super::WorldGraph;
use throng_core::patch::NONE;

/// Longest passage that is taken as a whole: in longer ones people follow each other (instances).
const LONGEST: usize = 8;
/// Largest climb that is taken as a whole (instances).
const HIGHEST: usize = 64;
/// A path around an instance that is not longer than this is no detour (instances).
const AROUND: usize = 5;

/// True for every instance that is part of a narrow passage or of a climb (instances).
pub(super) fn narrow_passages(graph: &WorldGraph) -> Vec<bool> {
    let all = 0..graph.num_instances() as u32;
    let mut narrow: Vec<bool> = all.clone().map(|i| is_narrow(graph, i)).collect();
    retain_parts(graph, &mut narrow, LONGEST);
    // A block that needs a unit of a small floor leads there.
    let (mut is_small, mut climbs) = (vec![false; graph.world().units.len()], vec![false; narrow.len()]);
    for i in all.clone().filter(|&i| graph.is_tile(i) && is_on_small_floor(graph, i)) {
        climbs[i as usize] = true;
        graph.resources(i).iter().for_each(|&unit| is_small[unit as usize] = true);
    }
    for i in all.filter(|&i| !graph.is_tile(i)) {
        climbs[i as usize] = graph.resources(i).iter().any(|&unit| is_small[unit as usize]);
    }
    retain_parts(graph, &mut climbs, HIGHEST);
    narrow.iter_mut().zip(climbs).for_each(|(narrow, climbs)| *narrow |= climbs);
    narrow
}

/// Keeps what was marked in parts that lead elsewhere and are not larger than a limit (instances).
fn retain_parts(graph: &WorldGraph, marked: &mut [bool], limit: usize) {
    let mut seen = vec![false; marked.len()];
    for first in 0..marked.len() {
        if !marked[first] || seen[first] {
            continue;
        }
        seen[first] = true;
        let (mut part, mut next, mut leads_out) = (vec![first as u32], 0, false);
        while let Some(&i) = part.get(next) {
            next += 1;
            for_each_other(graph, i, |o| {
                leads_out |= !marked[o as usize];
                if marked[o as usize] && !seen[o as usize] {
                    seen[o as usize] = true;
                    part.push(o);
                }
            });
        }
        if part.len() > limit || !leads_out {
            part.iter().for_each(|&i| marked[i as usize] = false);
        }
    }
}

/// True for a tile on a floor of few tiles.
fn is_on_small_floor(graph: &WorldGraph, instance: u32) -> bool {
    let (mut floor, mut next) = (vec![instance], 0);
    while let Some(&i) = floor.get(next) {
        next += 1;
        let first = graph.instance(i).first_neighbour;
        let num_edges = graph.patches().patches[graph.instance(i).patch as usize].num_edges;
        for o in (first..first + num_edges).filter_map(|slot| graph.bounds.neighbour(graph, slot)) {
            if !floor.contains(&o) {
                floor.push(o);
            }
        }
        if floor.len() > LONGEST {
            return false;
        }
    }
    true
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
    let edges = r.first_neighbour..r.first_neighbour + num_edges;
    edges.filter_map(|slot| graph.bounds.neighbour(graph, slot)).for_each(&mut visit);
    for (_, a, _) in graph.adjacencies(instance).filter(|(k, ..)| graph.bounds.is_open_outwards(*k)) {
        visit(a.other);
    }
}
