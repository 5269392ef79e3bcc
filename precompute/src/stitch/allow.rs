//! What is possible in a world before dead ends are looked for: everything that no unit is in the way of.

use super::joined::{Joined, Overlap, Part, exits};
use super::lay::{Laid, Stitcher};
use super::library::STAGE;
use super::prepare::Situated;
use crate::error::BuildError;
use std::collections::HashMap;
use std::sync::Arc;
use throng_runtime::patch::NONE;

/// Puts the graph of a world together. [Limit: prepared for `laid`]
///
/// # Errors
/// [`BuildError::Stage`] where there are more cells or links than numbers of 32 bits count.
pub(super) fn allow<'a>(stitcher: &Stitcher<'a>, laid: &Laid, situated: Situated) -> Result<Joined<'a>, BuildError> {
    let mut joined = Joined {
        patches: stitcher.patches,
        exits: exits(&stitcher.patches),
        parts: Vec::with_capacity(laid.fitted.len()),
        neighbours: laid.neighbours.clone(),
        situations: situated.situations,
        overlaps: Vec::new(),
        relations: Vec::new(),
        crossings: Vec::new(),
        num_nodes: 0,
        num_words: 0,
    };
    parts(laid, &situated.of, &mut joined)?;
    overlaps(stitcher, laid, &mut joined);
    Ok(joined)
}

fn parts(laid: &Laid, situations: &[u32], joined: &mut Joined<'_>) -> Result<(), BuildError> {
    let mut num_words = 0u64;
    for (i, f) in laid.fitted.iter().enumerate() {
        let patch = &joined.patches.patches[f.patch as usize];
        num_words += u64::from(patch.num_links.div_ceil(64));
        if joined.num_nodes as u64 + u64::from(patch.num_cells) >= u64::from(NONE / 2) || num_words >= u64::from(NONE) {
            return Err(BuildError::Stage {
                stage: STAGE,
                message: format!(
                    "the first {} of {} instances have {} cells already",
                    i,
                    laid.fitted.len(),
                    joined.num_nodes
                ),
                help: "Stitch a smaller world".into(),
            });
        }
        joined.parts.push(Part {
            patch: f.patch,
            situation: situations[i],
            first_node: joined.num_nodes as u32,
            first_word: joined.num_words as u32,
            first_neighbour: laid.first_neighbour[i],
            first_overlap: 0,
            num_overlaps: 0,
        });
        joined.num_nodes += patch.num_cells as usize;
        joined.num_words += joined.exits[f.patch as usize].len();
    }
    Ok(())
}

/// The joints of every pair, and from each instance where it overlaps others.
fn overlaps(stitcher: &Stitcher<'_>, laid: &Laid, joined: &mut Joined<'_>) {
    let (mut tables, mut crossings) = (HashMap::new(), HashMap::new());
    let mut by_owner: Vec<Vec<Overlap>> = vec![Vec::new(); laid.fitted.len()];
    for (a, b, relation) in &laid.pairs {
        if stitcher.table_of(relation).joints.is_empty() {
            continue;
        }
        let table = *tables.entry(relation).or_insert_with(|| {
            joined.relations.push(*relation);
            joined.relations.len() as u32 - 1
        });
        let situation = joined.parts[*a as usize].situation;
        let crossing = *crossings.entry((table, situation)).or_insert_with(|| {
            let situation = &joined.situations[situation as usize];
            joined.crossings.push(Arc::clone(stitcher.crossing_of(relation, situation)));
            joined.crossings.len() as u32 - 1
        });
        let from = |other: u32, side: u32| Overlap { other, side, table, crossing };
        by_owner[*a as usize].push(from(*b, 0));
        by_owner[*b as usize].push(from(*a, 1));
    }
    for (part, mut own) in joined.parts.iter_mut().zip(by_owner) {
        own.sort_unstable_by_key(|o| o.other);
        (part.first_overlap, part.num_overlaps) = (joined.overlaps.len() as u32, own.len() as u32);
        joined.overlaps.extend(own);
    }
}
