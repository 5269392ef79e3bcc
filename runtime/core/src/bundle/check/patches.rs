//! Pose groups and motion patches: ranges tile their sections, links lie in clips, edges and twins belong together.

use super::super::{Bundle, tags};
use crate::format::FormatError;
use crate::patch::{CellRecord, EdgeRecord, KIND_BLOCK, KIND_TILE, LinkRecord, NONE, PairRecord, PatchRecord};

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
        return match num_groups {
            0 => Ok(()),
            n => Err(FormatError::layout(format!("META counts {n} pose groups, but frames have none"))),
        };
    }
    if groups.len() != num_frames {
        return Err(FormatError::layout(format!("{} pose groups for {num_frames} frames", groups.len())));
    }
    match groups.iter().position(|&g| g != NONE && u64::from(g) >= num_groups) {
        Some(i) => {
            let message = format!("pose group {} does not exist, there are {num_groups}", groups[i]);
            Err(FormatError::value(tags::POSE_GROUPS, i, message))
        }
        None => Ok(()),
    }
}

/// Every patch, and nothing left over.
pub fn patches(t: &Bundle) -> Result<(), FormatError> {
    let all = t.patches();
    names(t)?;
    let mut next = [0u64; 3];
    let lengths = [all.cells.len(), all.links.len(), all.edges.len()];
    for (i, p) in all.patches.iter().enumerate() {
        let wrong = |what: &str| Err(FormatError::value(tags::PATCHES, i, format!("{what}: {p:?}")));
        let parts = [(p.first_cell, p.num_cells), (p.first_link, p.num_links), (p.first_edge, p.num_edges)];
        for ((next, (first, count)), len) in next.iter_mut().zip(parts).zip(lengths) {
            if u64::from(first) != *next || *next + u64::from(count) > len as u64 {
                return wrong("its cells, links or edges do not follow those of the patch before it");
            }
            *next += u64::from(count);
        }
        if !(p.kind == KIND_BLOCK && p.num_edges == 0 || p.kind == KIND_TILE) || p.reserved != 0 {
            return wrong("no such kind, or a block with edges");
        }
        if p.num_edges > MOST_EDGES {
            return wrong(&format!("it has {} edges, expected {MOST_EDGES} at most", p.num_edges));
        }
        if !p.min.iter().zip(&p.max).all(|(a, b)| a <= b && a.abs() < FAR && b.abs() < FAR) {
            return wrong("its bounds cannot be");
        }
        edges(p, all.edges_of(i))?;
        cells(t, p, all.cells_of(i), all.edges_of(i))?;
        links(t, p, all.cells_of(i), all.links_of(i))?;
    }
    let tags = [tags::PATCH_CELLS, tags::PATCH_LINKS, tags::PATCH_EDGES];
    match tags.iter().zip(next).zip(lengths).find(|((_, used), len)| *used != *len as u64) {
        Some(((tag, used), len)) => {
            Err(FormatError::layout(format!("section {tag} has {len} elements, its patches need {used}")))
        }
        None => pairs(t),
    }
}

/// Both links of a pair are for two people and have the same length and tag; pairs ascend.
fn pairs(t: &Bundle) -> Result<(), FormatError> {
    let all = t.patches();
    let order = |p: &PairRecord| (p.patch, p.edge, p.link, p.partner_link);
    for (i, p) in all.pairs.iter().enumerate() {
        let wrong = |what: &str| Err(FormatError::value(tags::PATCH_PAIRS, i, format!("{what}: {p:?}")));
        if i > 0 && order(&all.pairs[i - 1]) >= order(p) {
            return wrong("it does not follow the pair before it");
        }
        if all.patches.get(p.patch as usize).is_none_or(|patch| p.edge >= patch.num_edges) {
            return wrong("no such patch or edge");
        }
        let links = all.links_of(p.patch as usize);
        let [Some(own), Some(other)] = [p.link, p.partner_link].map(|l| links.get(l as usize)) else {
            return wrong("no such link");
        };
        if !own.is_for_two() || own.tag != other.tag || own.num_frames != other.num_frames {
            return wrong("its links are not of two who do the same together");
        }
        if own.num_frames < 2 {
            return wrong("its links have one frame, expected 2 or more: one to begin, and what is done then");
        }
    }
    Ok(())
}

/// Every patch has a name of its own and units that stand somewhere.
fn names(t: &Bundle) -> Result<(), FormatError> {
    let (names, records) = (&t.meta().patches, t.patches().patches.len());
    if names.len() != records {
        return Err(FormatError::layout(format!("META names {} patches, there are {records}", names.len())));
    }
    let mut sorted: Vec<&str> = names.iter().map(|p| p.name.as_str()).collect();
    sorted.sort_unstable();
    if let Some(pair) = sorted.windows(2).find(|p| p[0] == p[1]) {
        return Err(FormatError::layout(format!("META names two patches `{}`", pair[0])));
    }
    match names.iter().find(|p| p.units.is_empty() || p.units.iter().any(|(_, at)| !at.is_moderate(FAR))) {
        Some(p) => Err(FormatError::layout(format!("patch `{}` has no units, or one that stands nowhere", p.name))),
        None => Ok(()),
    }
}

/// Each edge has an opposite one, a step away in the opposite direction.
fn edges(p: &PatchRecord, edges: &[EdgeRecord]) -> Result<(), FormatError> {
    for (i, e) in edges.iter().enumerate() {
        let opposite = |o: &EdgeRecord| {
            let back = o.step.iter().zip(&e.step).all(|(a, b)| (a + b).abs() < STEP_TOLERANCE);
            back && o.opposite as usize == i && e.opposite as usize != i
        };
        let finite = e.step.iter().all(|v| v.abs() < FAR);
        if !finite || !edges.get(e.opposite as usize).is_some_and(opposite) {
            let message = format!("it has no opposite edge: {e:?}");
            return Err(FormatError::value(tags::PATCH_EDGES, p.first_edge as usize + i, message));
        }
    }
    Ok(())
}

/// Cells have groups, flags and twins that exist; their links follow each other.
fn cells(t: &Bundle, p: &PatchRecord, cells: &[CellRecord], edges: &[EdgeRecord]) -> Result<(), FormatError> {
    let (rest, entry, exit) = (CellRecord::IS_REST, CellRecord::IS_ENTRY, CellRecord::IS_EXIT);
    let mut next = 0u64;
    for (i, c) in cells.iter().enumerate() {
        let wrong = |what: &str| {
            Err(FormatError::value(tags::PATCH_CELLS, p.first_cell as usize + i, format!("{what}: {c:?}")))
        };
        if !c.placement.is_moderate(FAR) || u64::from(c.group) >= t.meta().pose_groups || c.reserved != [0; 2] {
            return wrong("no such place or pose group");
        }
        let crossing = c.has_flags(entry) || c.has_flags(exit);
        if c.flags & !(rest | entry | exit) != 0 || c.has_flags(entry | exit) || crossing && c.has_flags(rest) {
            return wrong("its flags do not go together");
        }
        if u64::from(c.first_link) != next || c.has_flags(exit) && c.num_links > 0 {
            return wrong("its links do not follow those of the cell before it, or leave an exit");
        }
        next += u64::from(c.num_links);
        if !crossing {
            if c.edge != NONE || c.twin != NONE {
                return wrong("it has an edge, but is neither an entry nor an exit");
            }
            continue;
        }
        let Some(edge) = edges.get(c.edge as usize) else {
            return wrong("no such edge");
        };
        let other = if c.has_flags(entry) { exit } else { entry };
        let twin = |o: &CellRecord| o.twin as usize == i && o.has_flags(other) && o.edge == edge.opposite;
        if !cells.get(c.twin as usize).is_some_and(twin) {
            return wrong("it has no twin on the opposite edge");
        }
    }
    match next == u64::from(p.num_links) {
        true => Ok(()),
        false => Err(FormatError::layout(format!("cells begin {next} links of a patch, it has {}", p.num_links))),
    }
}

/// Links lie within one clip, are those of the cells they begin in, and lead to cells that exist.
fn links(t: &Bundle, p: &PatchRecord, cells: &[CellRecord], links: &[LinkRecord]) -> Result<(), FormatError> {
    let num_tags = t.meta().link_tags.len();
    for (from, c) in cells.iter().enumerate() {
        let first = c.first_link as usize;
        let mut stays = false;
        for (k, l) in links[first..first + c.num_links as usize].iter().enumerate() {
            let wrong = |what: &str| {
                let index = p.first_link as usize + first + k;
                Err(FormatError::value(tags::PATCH_LINKS, index, format!("{what}: {l:?}")))
            };
            if l.from as usize != from || l.to as usize >= cells.len() {
                return wrong("it does not begin in its cell, or ends in none");
            }
            let clip = t.clips().partition_point(|c| c.first_frame <= l.frame).wrapping_sub(1);
            let last = u64::from(l.frame) + u64::from(l.num_frames);
            let inside = t.clips().get(clip).is_some_and(|c| last < u64::from(c.first_frame) + u64::from(c.num_frames));
            if l.num_frames == 0 || !inside {
                return wrong("it leaves its clip");
            }
            let tag = usize::from(l.tag & !LinkRecord::FOR_TWO);
            if tag > num_tags || l.is_for_two() && tag == 0 || !l.start.is_moderate(FAR) || !l.end.is_moderate(FAR) {
                return wrong("no such tag or place");
            }
            stays |= l.to == l.from && !l.is_for_two();
        }
        if c.has_flags(CellRecord::IS_REST) && !stays {
            let index = p.first_cell as usize + from;
            return Err(FormatError::value(
                tags::PATCH_CELLS,
                index,
                "no character can stay there: no link leads back to it",
            ));
        }
    }
    Ok(())
}
