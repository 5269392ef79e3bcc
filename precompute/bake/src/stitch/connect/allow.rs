//! Graph of a world before dead ends are removed: all motion that no unit obstructs.

use super::joined::{GraphInstance, InstanceOverlap, JoinedGraph, exits};
use super::prepare::PreparedWorld;
use crate::stitch::place::place_patches::PlacedPatches;
use throng_core::patch::{NONE, PatchTables};

/// Builds the graph of a world (prepared for `placed`, whose sizes are checked).
pub fn build_joined_graph(patches: &PatchTables, placed: &PlacedPatches, prepared: PreparedWorld) -> JoinedGraph {
    let mut joined = JoinedGraph {
        patches: patches.clone(),
        exits: exits(patches),
        parts: Vec::with_capacity(placed.fitted.len()),
        neighbours: placed.neighbours.clone(),
        situations: prepared.situations,
        overlaps: Vec::new(),
        crossings: prepared.crossings,
        crossing_of: prepared.crossing_of,
        shares_floor: prepared.shares_floor,
        num_nodes: 0,
        num_words: 0,
    };
    add_instances(placed, &prepared.situation_of, &mut joined);
    add_overlaps(placed, &mut joined);
    joined
}

fn add_instances(placed: &PlacedPatches, situations: &[u32], joined: &mut JoinedGraph) {
    for (i, f) in placed.fitted.iter().enumerate() {
        let patch = &joined.patches.patches[f.patch as usize];
        joined.parts.push(GraphInstance {
            patch: f.patch,
            situation: situations[i],
            first_node: joined.num_nodes as u32,
            first_word: joined.num_words as u32,
            first_neighbour: placed.first_neighbour[i],
            first_overlap: 0,
            num_overlaps: 0,
        });
        joined.num_nodes += patch.num_cells as usize;
        joined.num_words += joined.exits[f.patch as usize].len();
    }
}

/// Adds the overlaps of each instance, by the number of the other.
fn add_overlaps(placed: &PlacedPatches, joined: &mut JoinedGraph) {
    let pairs = || (0u32..).zip(&placed.pairs).zip(&joined.crossing_of).filter(|(_, crossing)| **crossing != NONE);
    for ((_, (a, b, _)), _) in pairs() {
        [a, b].into_iter().for_each(|i| joined.parts[*i as usize].num_overlaps += 1);
    }
    let mut next = 0;
    for part in &mut joined.parts {
        part.first_overlap = next;
        next += part.num_overlaps;
    }
    let mut at: Vec<u32> = joined.parts.iter().map(|p| p.first_overlap).collect();
    let mut overlaps = vec![InstanceOverlap { other: NONE, side: 0, pair: NONE, crossing: NONE }; next as usize];
    for ((pair, &(a, b, _)), &crossing) in pairs() {
        for (owner, other, side) in [(a, b, 0), (b, a, 1)] {
            overlaps[at[owner as usize] as usize] = InstanceOverlap { other, side, pair, crossing };
            at[owner as usize] += 1;
        }
    }
    for part in &joined.parts {
        let own = part.first_overlap as usize..(part.first_overlap + part.num_overlaps) as usize;
        overlaps[own].sort_unstable_by_key(|o| o.other);
    }
    joined.overlaps = overlaps;
}
