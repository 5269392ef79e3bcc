//! What is possible in a world before dead ends are looked for: everything that no unit is in the way of.

use super::bits::{Pool, all_set};
use super::joined::{Joined, Overlap, Part};
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
        parts: Vec::with_capacity(laid.fitted.len()),
        neighbours: laid.neighbours.clone(),
        situations: situated.situations,
        overlaps: Vec::new(),
        tables: Vec::new(),
        joint_words: Vec::new(),
        num_nodes: 0,
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
            first_neighbour: laid.first_neighbour[i],
            first_overlap: 0,
            num_overlaps: 0,
        });
        joined.num_nodes += patch.num_cells as usize;
    }
    Ok(())
}

/// Bits of the joints of every pair, and from each instance where it overlaps others.
fn overlaps(stitcher: &Stitcher<'_>, laid: &Laid, joined: &mut Joined<'_>) {
    let mut numbers = HashMap::new();
    let mut first_words = HashMap::new();
    let mut pool = Pool::default();
    let mut by_owner: Vec<Vec<Overlap>> = vec![Vec::new(); laid.fitted.len()];
    for (a, b, relation) in &laid.pairs {
        let table = stitcher.table_of(relation);
        if table.joints.is_empty() {
            continue;
        }
        let number = *numbers.entry(relation).or_insert_with(|| {
            joined.tables.push(Arc::clone(table));
            joined.tables.len() as u32 - 1
        });
        let situation = joined.parts[*a as usize].situation;
        let first_word = *first_words.entry((number, situation)).or_insert_with(|| {
            let surroundings = &joined.situations[situation as usize].surroundings;
            match stitcher.joint_words_of(relation, surroundings) {
                None => pool.place(&all_set(2 * table.joints.len())),
                Some(words) => pool.place(words),
            }
        });
        let from = |other: u32, side: u32| Overlap { other, table: number, side, first_word };
        by_owner[*a as usize].push(from(*b, 0));
        by_owner[*b as usize].push(from(*a, 1));
    }
    joined.joint_words = pool.words;
    for (part, mut own) in joined.parts.iter_mut().zip(by_owner) {
        own.sort_unstable_by_key(|o| o.other);
        (part.first_overlap, part.num_overlaps) = (joined.overlaps.len() as u32, own.len() as u32);
        joined.overlaps.extend(own);
    }
}
