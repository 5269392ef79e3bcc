//! Every stored index of a world against its table, every number for being finite.

use super::{AdjacencyRecord, InstanceRecord, JointRecord, JointTableRecord, WorldTables, tags};
use throng_base::error::ensure;
use throng_core::format::{FormatError, SectionTag};
use throng_core::patch::{KIND_BLOCK, KIND_TILE, NONE, PatchTables};

/// Coordinates stay below this (m).
const FAR: f32 = 1e5;
/// Places of joints that tables are looked up by, 4 bytes each.
const MOST_PLACES: u64 = 1 << 30;

pub(super) fn world(w: &WorldTables, patches: &PatchTables) -> Result<(), FormatError> {
    units(w)?;
    joint_tables(w, patches)?;
    instances(w, patches)?;
    neighbours(w, patches)?;
    adjacencies(w)
}

/// A counter of what records of a table use up, in order.
struct Tiling {
    tag: SectionTag,
    next: u64,
}

impl Tiling {
    fn new(tag: SectionTag) -> Self {
        Self { tag, next: 0 }
    }

    /// The next record's part must follow the last one's.
    fn part(&mut self, owner: SectionTag, index: usize, first: u32, count: u64) -> Result<(), FormatError> {
        let message = || format!("its part of {} begins at {first}, expected {}", self.tag, self.next);
        ensure(u64::from(first) == self.next, || FormatError::value(owner, index, message()))?;
        self.next += count;
        Ok(())
    }

    /// The parts together are the whole section.
    fn end(&self, len: usize) -> Result<(), FormatError> {
        let message = || format!("section {} has {len} elements, expected {}", self.tag, self.next);
        ensure(len as u64 == self.next, || FormatError::layout(message()))
    }
}

fn units(w: &WorldTables) -> Result<(), FormatError> {
    let Some(i) = w.units.iter().position(|u| !u.placement.is_moderate(FAR)) else { return Ok(()) };
    let message = format!("it stands nowhere, expected numbers below {FAR}: {:?}", w.units[i].placement);
    Err(FormatError::value(tags::UNITS, i, message))
}

/// Tables name patches that exist, are named by an adjacency, and have joints, which tile the section, ascend, and are
/// listed once each by side b.
fn joint_tables(w: &WorldTables, patches: &PatchTables) -> Result<(), FormatError> {
    let (mut joints, mut num_places) = (Tiling::new(tags::JOINTS), 0);
    let mut is_named = vec![false; w.tables.len()];
    for a in &w.adjacencies {
        if let Some(named) = is_named.get_mut(a.table as usize) {
            *named = true;
        }
    }
    for (i, t) in w.tables.iter().enumerate() {
        let wrong = |message: String| FormatError::value(tags::TABLES, i, message);
        let limit = patches.patches.len();
        let stands = (t.patch_a.max(t.patch_b) as usize) < limit && t.placement.is_moderate(FAR);
        ensure(stands, || wrong(format!("no such patches, there are {limit}: {t:?}")))?;
        let is_block = patches.patches[t.patch_b as usize].kind == KIND_BLOCK;
        ensure(is_block, || wrong(format!("patch {} on side b is not a block", t.patch_b)))?;
        let what = "it has no joints, or no instances that overlap name it";
        ensure(t.num_joints > 0 && is_named[i], || wrong(what.to_owned()))?;
        let [a, b] = [t.patch_a, t.patch_b].map(|p| &patches.patches[p as usize]);
        num_places +=
            2 + u64::from(if a.kind == KIND_TILE { a.num_links } else { a.num_cells }) + u64::from(b.num_cells);
        if num_places > MOST_PLACES {
            return Err(wrong(format!(
                "it and those before it have {num_places} places for joints, expected {MOST_PLACES} at most"
            )));
        }
        joints.part(tags::TABLES, i, t.first_joint, t.num_joints.into())?;
        let range = t.first_joint as usize..t.first_joint as usize + t.num_joints as usize;
        let (Some(list), Some(order)) = (w.joints.get(range.clone()), w.joints_by_b.get(range)) else {
            return Err(wrong(format!("its joints end after {}", w.joints.len())));
        };
        joints_of(t, list, patches)?;
        let key = |k: &u32| list.get(*k as usize).map(|j| (j.b, j.a, j.a_offset));
        let sorted = order.windows(2).all(|p| key(&p[0]) < key(&p[1])) && order.iter().all(|k| *k < t.num_joints);
        ensure(sorted, || wrong("its joints by side b do not ascend or do not exist".to_owned()))?;
    }
    joints.end(w.joints.len())?;
    joints.end(w.joints_by_b.len())
}

fn joints_of(t: &JointTableRecord, list: &[JointRecord], patches: &PatchTables) -> Result<(), FormatError> {
    let first = t.first_joint as usize;
    let (cells_a, cells_b) = (patches.cells_of(t.patch_a as usize), patches.cells_of(t.patch_b as usize));
    let links_a = patches.links_of(t.patch_a as usize);
    let tile = patches.patches[t.patch_a as usize].kind == KIND_TILE;
    for (i, j) in list.iter().enumerate() {
        let wrong = |what: &str| FormatError::value(tags::JOINTS, first + i, format!("{what}: {j:?}"));
        let a_exists = match tile {
            true => links_a.get(j.a as usize).is_some_and(|l| 0 < j.a_offset && j.a_offset < l.num_frames.into()),
            false => (j.a as usize) < cells_a.len() && j.a_offset == NONE,
        };
        let exists = a_exists && (j.b as usize) < cells_b.len() && j.reserved == 0;
        ensure(exists, || wrong("no such cells, link or offset"))?;
        ensure(i == 0 || list[i - 1] < *j, || wrong("it does not follow the joint before it"))?;
    }
    Ok(())
}

/// Instances name patches that exist; their bits, adjacencies, neighbours and resources tile their sections.
fn instances(w: &WorldTables, patches: &PatchTables) -> Result<(), FormatError> {
    let mut parts = [tags::NEIGHBOURS, tags::CELLS, tags::LINKS, tags::ADJACENCIES, tags::RESOURCES].map(Tiling::new);
    for (i, r) in w.instances.iter().enumerate() {
        let wrong = |message: &str| FormatError::value(tags::INSTANCES, i, format!("{message}: {r:?}"));
        let p = patches.patches.get(r.patch as usize).ok_or_else(|| wrong("no such patch"))?;
        ensure(r.placement.is_moderate(FAR), || wrong("it stands nowhere"))?;
        ensure(r.num_resources != 0, || wrong("it has no units"))?;
        let num_words = |bits: u32| u64::from(bits.div_ceil(64));
        let counts = [
            (r.first_neighbour, u64::from(p.num_edges)),
            (r.first_cell_word, num_words(p.num_cells)),
            (r.first_link_word, num_words(p.num_links)),
            (r.first_adjacency, u64::from(r.num_adjacencies)),
            (r.first_resource, u64::from(r.num_resources)),
        ];
        for (part, (first, count)) in parts.iter_mut().zip(counts) {
            part.part(tags::INSTANCES, i, first, count)?;
        }
    }
    let lengths = [w.neighbours.len(), w.cell_words.len(), w.link_words.len(), w.adjacencies.len(), w.resources.len()];
    parts.iter().zip(lengths).try_for_each(|(part, len)| part.end(len))?;
    resources(w)
}

/// Units of an instance exist and ascend.
fn resources(w: &WorldTables) -> Result<(), FormatError> {
    for r in &w.instances {
        let first = r.first_resource as usize;
        let list = &w.resources[first..first + r.num_resources as usize];
        for (k, &u) in list.iter().enumerate() {
            if u as usize >= w.units.len() || k > 0 && list[k - 1] >= u {
                let message = format!("unit {u} does not exist or does not ascend, there are {}", w.units.len());
                return Err(FormatError::value(tags::RESOURCES, first + k, message));
            }
        }
    }
    Ok(())
}

/// The instance across an edge is of the same patch, and its neighbour across the opposite edge is the tile.
fn neighbours(w: &WorldTables, patches: &PatchTables) -> Result<(), FormatError> {
    for (i, r) in w.instances.iter().enumerate() {
        for (e, edge) in patches.edges_of(r.patch as usize).iter().enumerate() {
            let at = r.first_neighbour as usize + e;
            let other = w.neighbours[at];
            if other == NONE {
                continue;
            }
            let back = |o: &InstanceRecord| {
                o.patch == r.patch && w.neighbours[o.first_neighbour as usize + edge.opposite as usize] == i as u32
            };
            if !w.instances.get(other as usize).is_some_and(back) {
                let message = format!("instance {other} is not the neighbour of instance {i} across its edge {e}");
                return Err(FormatError::value(tags::NEIGHBOURS, at, message));
            }
        }
    }
    Ok(())
}

/// Adjacencies come in pairs that share a table's bits, and two instances have a table in common once.
fn adjacencies(w: &WorldTables) -> Result<(), FormatError> {
    let of = |r: &InstanceRecord| r.first_adjacency as usize..r.first_adjacency as usize + r.num_adjacencies as usize;
    let key = |a: &AdjacencyRecord| [a.other, a.table, a.side, a.first_word];
    let mut sorted: Vec<[u32; 4]> = w.adjacencies.iter().map(key).collect();
    w.instances.iter().for_each(|r| sorted[of(r)].sort_unstable());
    for (i, r) in w.instances.iter().enumerate() {
        let first = of(r).start;
        if let Some(k) = sorted[of(r)].windows(2).position(|p| p[0][..2] == p[1][..2]) {
            let [other, table, ..] = sorted[first + k];
            let message = format!("instance {i} has table {table} with instance {other} twice");
            return Err(FormatError::value(tags::ADJACENCIES, first, message));
        }
        for (k, a) in w.adjacencies[of(r)].iter().enumerate() {
            let wrong = |what: &str| FormatError::value(tags::ADJACENCIES, first + k, format!("{what}: {a:?}"));
            let other = w.instances.get(a.other as usize).ok_or_else(|| wrong("no such instance"))?;
            let table = w.tables.get(a.table as usize).ok_or_else(|| wrong("no such table"))?;
            let sides = if a.side == 0 { (r.patch, other.patch) } else { (other.patch, r.patch) };
            ensure(a.side <= 1 && sides == (table.patch_a, table.patch_b), || wrong("its table is of other patches"))?;
            let num_words = (2 * u64::from(table.num_joints)).div_ceil(64);
            let end = u64::from(a.first_word) + num_words;
            ensure(end <= w.joint_words.len() as u64, || wrong("its bits lie outside of their section"))?;
            let back = AdjacencyRecord { other: i as u32, side: 1 - a.side, ..*a };
            let is_mutual = sorted[of(other)].binary_search(&key(&back)).is_ok();
            ensure(is_mutual, || wrong("the other instance does not have it"))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WorldData;
    use crate::made_up_floor::{tables, world};

    /// Error message of a made-up world that has been changed.
    fn wrong(change: impl FnOnce(&mut WorldData)) -> String {
        let tables = tables();
        let mut data = world(&tables, &["###", "bb#", "###"]);
        change(&mut data);
        data.check(tables.patches()).map_or_else(|e| e.to_string(), |()| String::new())
    }

    /// A table at the end, with so many joints.
    fn add_table(w: &mut WorldData, num_joints: u32) {
        w.tables.push(JointTableRecord { first_joint: w.joints.len() as u32, num_joints, ..w.tables[0] });
        w.joints.extend_from_within(..num_joints as usize);
        w.joints_by_b.extend(0..num_joints);
    }

    #[test]
    fn tables_without_joints_or_that_nobody_names_are_refused() {
        assert_eq!(wrong(|_| ()), "");
        for num_joints in 0..3 {
            let why = wrong(|w| add_table(w, num_joints));
            assert!(why.contains("no joints, or no instances that overlap name it"), "{why}");
        }
        let why = wrong(|w| {
            add_table(w, 0);
            w.adjacencies.iter_mut().for_each(|a| a.table = 1);
        });
        assert!(why.contains("no joints, or no instances that overlap name it"), "{why}");
    }

    #[test]
    fn instances_with_a_table_twice_are_refused_soon() {
        // As many as comparing all with all of would take minutes.
        let why = wrong(|w| {
            let n = 100_000;
            let ends: Vec<usize> = (0..w.instances.len()).filter(|&i| w.instances[i].num_adjacencies > 0).collect();
            let adjacencies = std::mem::take(&mut w.adjacencies);
            for (&i, a) in ends.iter().zip(adjacencies) {
                w.instances[i].num_adjacencies = n;
                w.adjacencies.extend((0..n).map(|k| AdjacencyRecord { first_word: a.first_word + k, ..a }));
            }
            w.joint_words.resize(n as usize + 2, 0);
            let mut first = 0;
            for r in &mut w.instances {
                r.first_adjacency = first;
                first += r.num_adjacencies;
            }
        });
        assert!(why.contains("has table 0 with instance") && why.contains("`throng stitch` (a world)"), "{why}");
    }

    #[test]
    fn units_far_away_are_refused_by_how_far() {
        let why = wrong(|w| w.units[1].placement.x = 2e5);
        assert!(why.contains("expected numbers below 100000"), "{why}");
    }
}
