//! What is possible in a world before dead ends are looked for: everything that no unit is in the way of.

use super::bits::{Pool, all_set, clear, num_words};
use super::joined::{Joined, Overlap, Part};
use super::lay::{Laid, Stitcher};
use super::library::STAGE;
use super::mask::{Hit, merged};
use super::table::JointTable;
use crate::error::BuildError;
use std::collections::HashMap;
use std::sync::Arc;
use throng_runtime::patch::NONE;

/// Puts the graph of a world together. [Limit: prepared for `laid`]
///
/// # Errors
/// [`BuildError::Stage`] where there are more cells or links than numbers of 32 bits count.
pub(super) fn allow<'a>(stitcher: &Stitcher<'a>, laid: &Laid) -> Result<Joined<'a>, BuildError> {
    let hits = hits(stitcher, laid);
    let mut joined = Joined {
        patches: stitcher.patches,
        parts: Vec::with_capacity(laid.fitted.len()),
        neighbours: laid.neighbours.clone(),
        link_words: Vec::new(),
        overlaps: Vec::new(),
        tables: Vec::new(),
        joint_words: Vec::new(),
        num_nodes: 0,
    };
    parts(laid, &hits, &mut joined)?;
    overlaps(stitcher, laid, &hits, &mut joined);
    Ok(joined)
}

/// The links of every instance that anything is in the way of.
fn hits(stitcher: &Stitcher<'_>, laid: &Laid) -> Vec<Vec<Hit>> {
    let mut out = vec![Vec::new(); laid.fitted.len()];
    for same in laid.obstacles.chunk_by(|a, b| a.0 == b.0) {
        out[same[0].0 as usize] = merged(same.iter().map(|o| stitcher.mask_of(&o.2)));
    }
    out
}

fn parts(laid: &Laid, hits: &[Vec<Hit>], joined: &mut Joined<'_>) -> Result<(), BuildError> {
    for (i, f) in laid.fitted.iter().enumerate() {
        let patch = &joined.patches.patches[f.patch as usize];
        let words = (num_words(patch.num_links as usize) + joined.link_words.len()) as u64;
        if joined.num_nodes as u64 + u64::from(patch.num_cells) >= u64::from(NONE) || words >= u64::from(NONE) {
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
            first_node: joined.num_nodes as u32,
            first_link_word: joined.link_words.len() as u32,
            first_neighbour: laid.first_neighbour[i],
            first_overlap: 0,
            num_overlaps: 0,
        });
        joined.num_nodes += patch.num_cells as usize;
        let mut words = all_set(patch.num_links as usize);
        hits[i].iter().for_each(|h| clear(&mut words, h.link));
        joined.link_words.extend(words);
    }
    Ok(())
}

/// Bits of the joints of every pair, and from each instance where it overlaps others.
fn overlaps(stitcher: &Stitcher<'_>, laid: &Laid, hits: &[Vec<Hit>], joined: &mut Joined<'_>) {
    let mut numbers = HashMap::new();
    let mut pool = Pool::default();
    let mut unhindered: Vec<u32> = Vec::new();
    let mut by_owner: Vec<Vec<Overlap>> = vec![Vec::new(); laid.fitted.len()];
    for (a, b, relation) in &laid.pairs {
        let table = stitcher.table_of(relation);
        if table.joints.is_empty() {
            continue;
        }
        let number = *numbers.entry(relation).or_insert_with(|| {
            joined.tables.push(Arc::clone(table));
            unhindered.push(pool.place(&all_set(2 * table.joints.len())));
            joined.tables.len() as u32 - 1
        });
        let first_word = match joint_words(table, &hits[*a as usize]) {
            None => unhindered[number as usize],
            Some(words) => pool.place(&words),
        };
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

/// Joints that may be taken where links of side a collide: out of a link that is clear up to there, into one that is
/// clear from there. None where that is so for all.
fn joint_words(table: &JointTable, hits: &[Hit]) -> Option<Vec<u64>> {
    let mut words: Option<Vec<u64>> = None;
    for (k, j) in table.joints.iter().enumerate() {
        if j.a_offset == NONE {
            continue;
        }
        let Ok(at) = hits.binary_search_by_key(&j.a, |h| h.link) else { continue };
        let words = words.get_or_insert_with(|| all_set(2 * table.joints.len()));
        if u32::from(hits[at].first) <= j.a_offset {
            clear(words, 2 * k as u32);
        }
        if u32::from(hits[at].last) >= j.a_offset {
            clear(words, 2 * k as u32 + 1);
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_runtime::world::{JointRecord, is_set};

    #[test]
    fn a_link_may_be_left_before_and_entered_after_what_is_in_its_way() {
        let joint = |a, a_offset| JointRecord { a, a_offset, b: 0, reserved: 0 };
        let joints = vec![joint(1, 10), joint(1, 20), joint(1, 30), joint(2, 20), joint(20, NONE)];
        let table = JointTable { joints, ..JointTable::default() };
        let words = joint_words(&table, &[Hit { link: 1, first: 15, last: 25 }]).unwrap();
        let ways: Vec<(bool, bool)> =
            (0..5).map(|k| (is_set(&words, 0, 2 * k), is_set(&words, 0, 2 * k + 1))).collect();
        assert_eq!(ways, [(true, false), (false, false), (false, true), (true, true), (true, true)]);
        assert_eq!(joint_words(&table, &[Hit { link: 7, first: 0, last: 1 }]), None);
    }
}
