//! Pose groups and motion patches: ranges tile their sections, links lie in clips, edges and twins belong together.

use super::super::{Bundle, tags};
use super::{check_unique, check_used, refuse};
use crate::format::FormatError;
use crate::patch::{CellRecord, EdgeRecord, KIND_BLOCK, KIND_TILE, LinkRecord, NONE, PairRecord, PatchRecord};
use throng_base::error::ensure;

/// Coordinates within a patch stay below this (m).
const FAR: f32 = 1e4;
/// Largest deviation of the steps across opposite edges from being opposite (m).
const STEP_TOLERANCE: f32 = 1e-3;
/// Most edges of a tile: sets of them, and of its inside, have a bit each.
const MOST_EDGES: u32 = 31;

/// Groups exist and are one a frame, where frames were grouped.
pub fn pose_groups(t: &Bundle) -> Result<(), FormatError> {
    let (groups, num_groups, num_frames) = (t.pose_groups(), t.meta().pose_groups, t.frames().len());
    if groups.is_empty() {
        let fault = || format!("META counts {num_groups} pose groups, but frames have none");
        return ensure(num_groups == 0, || FormatError::layout(fault()));
    }
    let fault = || format!("{} pose groups for {num_frames} frames", groups.len());
    ensure(groups.len() == num_frames, || FormatError::layout(fault()))?;
    groups.iter().enumerate().try_for_each(|(i, &g)| {
        let fault = || format!("pose group {g} does not exist, there are {num_groups}");
        ensure(g == NONE || u64::from(g) < num_groups, || FormatError::value(tags::POSE_GROUPS, i, fault()))
    })
}

/// Every patch, and nothing left over.
pub fn patches(t: &Bundle) -> Result<(), FormatError> {
    let all = t.patches();
    names(t)?;
    let mut next = [0u64; 3];
    let lengths = [all.cells.len(), all.links.len(), all.edges.len()];
    for (i, p) in all.patches.iter().enumerate() {
        let error = |fault: &str| FormatError::value(tags::PATCHES, i, format!("{fault}: {p:?}"));
        let parts = [(p.first_cell, p.num_cells), (p.first_link, p.num_links), (p.first_edge, p.num_edges)];
        for ((next, (first, count)), len) in next.iter_mut().zip(parts).zip(lengths) {
            let follows = u64::from(first) == *next && *next + u64::from(count) <= len as u64;
            ensure(follows, || error("its cells, links or edges do not follow those of the patch before it"))?;
            *next += u64::from(count);
        }
        let is_kind = p.kind == KIND_BLOCK && p.num_edges == 0 || p.kind == KIND_TILE;
        ensure(is_kind && p.reserved == 0, || error("no such kind, or a block with edges"))?;
        let fault = || format!("it has {} edges, expected {MOST_EDGES} at most", p.num_edges);
        ensure(p.num_edges <= MOST_EDGES, || error(&fault()))?;
        let bounded = p.min.iter().zip(&p.max).all(|(a, b)| a <= b && a.abs() < FAR && b.abs() < FAR);
        ensure(bounded, || error("its bounds cannot be"))?;
        edges(p, all.edges_of(i))?;
        cells(t, p, all.cells_of(i), all.edges_of(i))?;
        links(t, p, all.cells_of(i), all.links_of(i))?;
    }
    let mut sections = [tags::PATCH_CELLS, tags::PATCH_LINKS, tags::PATCH_EDGES].into_iter().zip(lengths).zip(next);
    sections.try_for_each(|((tag, len), used)| check_used(tag, len, used, "patches"))?;
    pairs(t)
}

/// Both links of a pair are for two people and have the same length and tag; pairs ascend.
fn pairs(t: &Bundle) -> Result<(), FormatError> {
    let all = t.patches();
    let order = |p: &PairRecord| (p.patch, p.edge, p.link, p.partner_link);
    for (i, p) in all.pairs.iter().enumerate() {
        let error = |fault: &str| FormatError::value(tags::PATCH_PAIRS, i, format!("{fault}: {p:?}"));
        let follows = i == 0 || order(&all.pairs[i - 1]) < order(p);
        ensure(follows, || error("it does not follow the pair before it"))?;
        let has_edge = all.patches.get(p.patch as usize).is_some_and(|patch| p.edge < patch.num_edges);
        ensure(has_edge, || error("no such patch or edge"))?;
        let links = all.links_of(p.patch as usize);
        let both = links.get(p.link as usize).zip(links.get(p.partner_link as usize));
        let (own, other) = both.ok_or_else(|| error("no such link"))?;
        let alike = own.is_for_two() && own.tag == other.tag && own.num_frames == other.num_frames;
        ensure(alike, || error("its links are not of two who do the same together"))?;
        let fault = "its links have one frame, expected 2 or more: one to begin, and what is done then";
        ensure(own.num_frames >= 2, || error(fault))?;
    }
    Ok(())
}

/// Every patch has a name of its own and units that stand somewhere.
fn names(t: &Bundle) -> Result<(), FormatError> {
    let (names, records) = (&t.meta().patches, t.patches().patches.len());
    let fault = || format!("META names {} patches, there are {records}", names.len());
    ensure(names.len() == records, || FormatError::layout(fault()))?;
    check_unique(names.iter().map(|p| &p.name), "META names two patches")?;
    names.iter().try_for_each(|p| {
        let fault = || format!("patch `{}` has no units, or one that stands nowhere", p.name);
        let stands = !p.units.is_empty() && p.units.iter().all(|(_, at)| at.is_moderate(FAR));
        ensure(stands, || FormatError::layout(fault()))
    })
}

/// Each edge has an opposite one, a step away in the opposite direction.
fn edges(p: &PatchRecord, edges: &[EdgeRecord]) -> Result<(), FormatError> {
    for (i, e) in edges.iter().enumerate() {
        let opposite = |o: &EdgeRecord| {
            let back = o.step.iter().zip(&e.step).all(|(a, b)| (a + b).abs() < STEP_TOLERANCE);
            back && o.opposite as usize == i && e.opposite as usize != i
        };
        let good = e.step.iter().all(|v| v.abs() < FAR) && edges.get(e.opposite as usize).is_some_and(opposite);
        let (index, fault) = (p.first_edge as usize + i, || format!("it has no opposite edge: {e:?}"));
        ensure(good, || FormatError::value(tags::PATCH_EDGES, index, fault()))?;
    }
    Ok(())
}

/// Cells have groups, flags and twins that exist; their links follow each other.
fn cells(t: &Bundle, p: &PatchRecord, cells: &[CellRecord], edges: &[EdgeRecord]) -> Result<(), FormatError> {
    let (rest, entry, exit) = (CellRecord::IS_REST, CellRecord::IS_ENTRY, CellRecord::IS_EXIT);
    let mut next = 0u64;
    for (i, c) in cells.iter().enumerate() {
        let index = p.first_cell as usize + i;
        let error = |fault: &str| FormatError::value(tags::PATCH_CELLS, index, format!("{fault}: {c:?}"));
        let good = c.placement.is_moderate(FAR) && u64::from(c.group) < t.meta().pose_groups && c.reserved == [0; 2];
        ensure(good, || error("no such place or pose group"))?;
        // At most one of the three.
        let crossing = c.has_flags(entry) || c.has_flags(exit);
        ensure([0, rest, entry, exit].contains(&c.flags), || error("its flags do not go together"))?;
        let follows = u64::from(c.first_link) == next && (!c.has_flags(exit) || c.num_links == 0);
        ensure(follows, || error("its links do not follow those of the cell before it, or leave an exit"))?;
        next += u64::from(c.num_links);
        if !crossing {
            let inside = c.edge == NONE && c.twin == NONE;
            ensure(inside, || error("it has an edge, but is neither an entry nor an exit"))?;
            continue;
        }
        let edge = edges.get(c.edge as usize).ok_or_else(|| error("no such edge"))?;
        let other = if c.has_flags(entry) { exit } else { entry };
        let twin = |o: &CellRecord| o.twin as usize == i && o.has_flags(other) && o.edge == edge.opposite;
        let has_twin = cells.get(c.twin as usize).is_some_and(twin);
        ensure(has_twin, || error("it has no twin on the opposite edge"))?;
    }
    let fault = || format!("cells begin {next} links of a patch, it has {}", p.num_links);
    ensure(next == u64::from(p.num_links), || FormatError::layout(fault()))
}

/// Links lie within one clip, are those of the cells they begin in, and lead to cells that exist.
fn links(t: &Bundle, p: &PatchRecord, cells: &[CellRecord], links: &[LinkRecord]) -> Result<(), FormatError> {
    let num_tags = t.meta().link_tags.len();
    for (from, c) in cells.iter().enumerate() {
        let first = c.first_link as usize;
        let mut stays = false;
        for (k, l) in links[first..first + c.num_links as usize].iter().enumerate() {
            let index = p.first_link as usize + first + k;
            let error = |fault: &str| FormatError::value(tags::PATCH_LINKS, index, format!("{fault}: {l:?}"));
            let joins = l.from as usize == from && (l.to as usize) < cells.len();
            ensure(joins, || error("it does not begin in its cell, or ends in none"))?;
            let clip = t.clips().partition_point(|c| c.first_frame <= l.frame).wrapping_sub(1);
            let last = u64::from(l.frame) + u64::from(l.num_frames);
            let inside = t.clips().get(clip).is_some_and(|c| last < u64::from(c.first_frame) + u64::from(c.num_frames));
            ensure(l.num_frames > 0 && inside, || error("it leaves its clip"))?;
            let tag = usize::from(l.tag & !LinkRecord::FOR_TWO);
            let has_tag = tag <= num_tags && (!l.is_for_two() || tag > 0);
            let good = has_tag && l.start.is_moderate(FAR) && l.end.is_moderate(FAR);
            ensure(good, || error("no such tag or place"))?;
            stays |= l.to == l.from && !l.is_for_two();
        }
        let fault = "no character can stay there: no link leads back to it";
        let nowhere = (c.has_flags(CellRecord::IS_REST) && !stays).then_some(p.first_cell as usize + from);
        refuse(tags::PATCH_CELLS, nowhere, fault)?;
    }
    Ok(())
}
