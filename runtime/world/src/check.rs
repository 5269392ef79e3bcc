//! Every stored index of a world against its table, every number for being finite.

use super::tags;
use super::{AdjacencyRecord, InstanceRecord, JointRecord, JointTableRecord, WorldView};
use throng_core::format::{FormatError, Tag};
use throng_core::patch::{KIND_BLOCK, KIND_TILE, NONE, Patches};

/// Coordinates stay below this (m).
const FAR: f32 = 1e5;

pub(super) fn world(w: &WorldView, patches: &Patches) -> Result<(), FormatError> {
    units(w)?;
    joint_tables(w, patches)?;
    instances(w, patches)?;
    neighbours(w, patches)?;
    adjacencies(w)
}

/// A counter of what records of a table use up, in order.
struct Tiling {
    tag: Tag,
    next: u64,
}

impl Tiling {
    fn new(tag: Tag) -> Self {
        Self { tag, next: 0 }
    }

    /// The next record's part must follow the last one's.
    fn part(&mut self, owner: Tag, index: usize, first: u32, count: u64) -> Result<(), FormatError> {
        if u64::from(first) != self.next {
            let message = format!("its part of {} begins at {first}, expected {}", self.tag, self.next);
            return Err(FormatError::value(owner, index, message));
        }
        self.next += count;
        Ok(())
    }

    /// The parts together are the whole section.
    fn end(&self, len: usize) -> Result<(), FormatError> {
        match len as u64 == self.next {
            true => Ok(()),
            false => {
                Err(FormatError::layout(format!("section {} has {len} elements, expected {}", self.tag, self.next)))
            }
        }
    }
}

fn units(w: &WorldView) -> Result<(), FormatError> {
    match w.units.iter().position(|u| !u.placement.is_moderate(FAR)) {
        Some(i) => Err(FormatError::value(tags::UNITS, i, "it stands nowhere: its placement is not finite")),
        None => Ok(()),
    }
}

/// Tables name patches that exist, their joints tile the section, ascend, and are listed once each by side b.
fn joint_tables(w: &WorldView, patches: &Patches) -> Result<(), FormatError> {
    let mut joints = Tiling::new(tags::JOINTS);
    for (i, t) in w.tables.iter().enumerate() {
        let wrong = |message: String| Err(FormatError::value(tags::TABLES, i, message));
        let limit = patches.patches.len();
        if t.patch_a as usize >= limit || t.patch_b as usize >= limit || !t.placement.is_moderate(FAR) {
            return wrong(format!("no such patches, there are {limit}: {t:?}"));
        }
        if patches.patches[t.patch_b as usize].kind != KIND_BLOCK {
            return wrong(format!("patch {} on side b is not a block", t.patch_b));
        }
        joints.part(tags::TABLES, i, t.first_joint, t.num_joints.into())?;
        let range = t.first_joint as usize..t.first_joint as usize + t.num_joints as usize;
        let (Some(list), Some(order)) = (w.joints.get(range.clone()), w.joints_by_b.get(range)) else {
            return wrong(format!("its joints end after {}", w.joints.len()));
        };
        joints_of(t, list, patches)?;
        let key = |k: &u32| list.get(*k as usize).map(|j| (j.b, j.a, j.a_offset));
        let sorted = order.windows(2).all(|p| key(&p[0]) < key(&p[1]));
        if !sorted || !order.iter().all(|k| *k < t.num_joints) {
            return wrong("its joints by side b do not ascend or do not exist".to_owned());
        }
    }
    joints.end(w.joints.len())?;
    joints.end(w.joints_by_b.len())
}

fn joints_of(t: &JointTableRecord, list: &[JointRecord], patches: &Patches) -> Result<(), FormatError> {
    let first = t.first_joint as usize;
    let (cells_a, cells_b) = (patches.cells_of(t.patch_a as usize), patches.cells_of(t.patch_b as usize));
    let links_a = patches.links_of(t.patch_a as usize);
    let tile = patches.patches[t.patch_a as usize].kind == KIND_TILE;
    for (i, j) in list.iter().enumerate() {
        let wrong = |what: &str| Err(FormatError::value(tags::JOINTS, first + i, format!("{what}: {j:?}")));
        let a_exists = match tile {
            true => links_a.get(j.a as usize).is_some_and(|l| 0 < j.a_offset && j.a_offset < l.num_frames.into()),
            false => (j.a as usize) < cells_a.len() && j.a_offset == NONE,
        };
        if !a_exists || j.b as usize >= cells_b.len() || j.reserved != 0 {
            return wrong("no such cells, link or offset");
        }
        if i > 0 && list[i - 1] >= *j {
            return wrong("it does not follow the joint before it");
        }
    }
    Ok(())
}

/// Instances name patches that exist; their bits, adjacencies, neighbours and resources tile their sections.
fn instances(w: &WorldView, patches: &Patches) -> Result<(), FormatError> {
    let mut parts = [
        Tiling::new(tags::NEIGHBOURS),
        Tiling::new(tags::CELLS),
        Tiling::new(tags::LINKS),
        Tiling::new(tags::ADJACENCIES),
        Tiling::new(tags::RESOURCES),
    ];
    for (i, r) in w.instances.iter().enumerate() {
        let wrong = |message: &str| Err(FormatError::value(tags::INSTANCES, i, format!("{message}: {r:?}")));
        let Some(p) = patches.patches.get(r.patch as usize) else {
            return wrong("no such patch");
        };
        if !r.placement.is_moderate(FAR) {
            return wrong("it stands nowhere");
        }
        if r.num_resources == 0 {
            return wrong("it has no units");
        }
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
fn resources(w: &WorldView) -> Result<(), FormatError> {
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

/// What stands across an edge is of the same patch and has the tile across the opposite edge.
fn neighbours(w: &WorldView, patches: &Patches) -> Result<(), FormatError> {
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

/// Adjacencies come in pairs that share a table's bits.
fn adjacencies(w: &WorldView) -> Result<(), FormatError> {
    let of = |i: usize| {
        let r: &InstanceRecord = &w.instances[i];
        (r.first_adjacency as usize, &w.adjacencies[r.first_adjacency as usize..][..r.num_adjacencies as usize])
    };
    for (i, r) in w.instances.iter().enumerate() {
        let (first, list) = of(i);
        for (k, a) in list.iter().enumerate() {
            let wrong = |what: &str| Err(FormatError::value(tags::ADJACENCIES, first + k, format!("{what}: {a:?}")));
            let Some(other) = w.instances.get(a.other as usize) else {
                return wrong("no such instance");
            };
            let Some(table) = w.tables.get(a.table as usize) else {
                return wrong("no such table");
            };
            let sides = if a.side == 0 { (r.patch, other.patch) } else { (other.patch, r.patch) };
            if a.side > 1 || sides != (table.patch_a, table.patch_b) {
                return wrong("its table is of other patches");
            }
            let num_words = (2 * u64::from(table.num_joints)).div_ceil(64);
            if u64::from(a.first_word) + num_words > w.joint_words.len() as u64 {
                return wrong("its bits lie outside of their section");
            }
            let back = AdjacencyRecord { other: i as u32, side: 1 - a.side, ..*a };
            if !of(a.other as usize).1.contains(&back) {
                return wrong("the other instance does not have it");
            }
        }
    }
    Ok(())
}
