//! The world that is left: bits of what belongs to the component, the tables it needs, and the figures.

use super::bits::{Pool, num_words, set};
use super::component::Standing;
use super::joined::{Joined, Overlap};
use super::lay::{Laid, Stitcher};
use super::relation::Relation;
use super::report::Reason;
use super::table::JointTable;
use crate::environment::Environment;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashSet};
use throng_runtime::patch::{CellRecord, NONE};
use throng_runtime::world::{AdjacencyRecord, InstanceRecord, JointTableRecord, UnitRecord, WorldData, is_set};

/// Figures of a world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Counts {
    /// Nodes left.
    pub cells: u64,
    /// Links left.
    pub links: u64,
    /// Joints left.
    pub joints: u64,
    /// Frames of the links left.
    pub frames: u64,
    /// Cells and links taken out, by reason.
    pub disabled: [u64; 4],
}

/// The graph of a world and what each of its nodes is to the component.
pub(super) struct Judged<'j, 'a> {
    /// The graph.
    pub joined: &'j Joined<'a>,
    /// What every node is. [Size: nodes]
    pub standing: &'j [Standing],
}

impl Judged<'_, '_> {
    /// True where a node is left.
    fn inside(&self, node: Option<u32>) -> bool {
        node.is_some_and(|n| self.standing[n as usize] == Standing::Inside)
    }

    /// Why a cell is taken out; none where it is left.
    pub fn cell(&self, part: u32, cell: u32) -> Option<Reason> {
        let c = &self.joined.cells(part)[cell as usize];
        let p = &self.joined.parts[part as usize];
        let at_end = c.flags & (CellRecord::IS_ENTRY | CellRecord::IS_EXIT) != 0
            && self.joined.neighbours[(p.first_neighbour + c.edge) as usize] == NONE;
        let standing = self.joined.node(part, cell).map_or(Standing::DeadEnd, |n| self.standing[n as usize]);
        match standing {
            Standing::Inside => None,
            _ if at_end => Some(Reason::NoNeighbour),
            Standing::DeadEnd => Some(Reason::DeadEnd),
            Standing::Unreached => Some(Reason::OutsideComponent),
        }
    }

    /// Why a link is taken out; none where it is left.
    pub fn link(&self, part: u32, link: u32) -> Option<Reason> {
        let j = self.joined;
        let p = &j.parts[part as usize];
        if !is_set(&j.link_words, p.first_link_word, link) {
            return Some(Reason::Obstacle);
        }
        let Some(end) = j.end_of(part, link) else { return Some(Reason::NoNeighbour) };
        let from = j.patches.links_of(p.patch as usize)[link as usize].from;
        match self.standing[end as usize] {
            _ if self.standing[(p.first_node + from) as usize] != Standing::Inside => self.cell(part, from),
            Standing::Inside => None,
            // It would be part of the component if it led back to it.
            _ => Some(Reason::DeadEnd),
        }
    }

    /// Bits of cells and links of an instance.
    fn bits(&self, part: u32) -> (Vec<u64>, Vec<u64>, Counts) {
        let patch = self.joined.parts[part as usize].patch as usize;
        let (cells, links) = (self.joined.cells(part), self.joined.patches.links_of(patch));
        let mut counts = Counts::default();
        let (mut cell_words, mut link_words) = (vec![0; num_words(cells.len())], vec![0; num_words(links.len())]);
        for (c, cell) in cells.iter().enumerate() {
            match self.cell(part, c as u32) {
                Some(reason) => counts.disabled[reason as usize] += 1,
                None => {
                    set(&mut cell_words, c as u32);
                    // An exit is the neighbour's entry.
                    counts.cells += u64::from(!cell.is(CellRecord::IS_EXIT));
                }
            }
        }
        for (l, link) in links.iter().enumerate() {
            match self.link(part, l as u32) {
                Some(reason) => counts.disabled[reason as usize] += 1,
                None => {
                    set(&mut link_words, l as u32);
                    counts.links += 1;
                    counts.frames += u64::from(link.num_frames);
                }
            }
        }
        (cell_words, link_words, counts)
    }

    /// Bits of the joints that are left between an instance on side a and another; none where none is.
    fn joint_bits(&self, part: u32, overlap: &Overlap) -> Option<(Vec<u64>, u64)> {
        let j = self.joined;
        let p = &j.parts[part as usize];
        let links = j.patches.links_of(p.patch as usize);
        let table = &j.tables[overlap.table as usize];
        let mut words = vec![0; num_words(2 * table.joints.len())];
        let mut count = 0;
        for (k, joint) in (0u32..).zip(&table.joints) {
            let other = j.node(overlap.other, joint.b);
            if !self.inside(other) {
                continue;
            }
            let (from, to) = match joint.a_offset {
                NONE => (Some(p.first_node + joint.a), Some(p.first_node + joint.a)),
                _ => (Some(p.first_node + links[joint.a as usize].from), j.end_of(part, joint.a)),
            };
            for (bit, own) in [(2 * k, from), (2 * k + 1, to)] {
                if self.inside(own) && is_set(&j.joint_words, overlap.first_word, bit) {
                    set(&mut words, bit);
                    count += 1;
                }
            }
        }
        (count > 0).then_some((words, count))
    }
}

/// Puts the world together that is left. Its meta data are still empty.
pub(super) fn assemble(
    stitcher: &Stitcher<'_>,
    environment: &Environment,
    laid: &Laid,
    judged: &Judged<'_, '_>,
) -> (WorldData, Counts) {
    let units = environment.units.iter().map(|u| UnitRecord { unit: u.unit as u32, placement: u.placement });
    let mut world = WorldData { units: units.collect(), neighbours: laid.neighbours.clone(), ..WorldData::default() };
    let mut counts = instances(laid, judged, &mut world);
    counts.joints = joints(stitcher, laid, judged, &mut world);
    resources(stitcher, laid, &mut world);
    (world, counts)
}

fn instances(laid: &Laid, judged: &Judged<'_, '_>, world: &mut WorldData) -> Counts {
    let bits: Vec<_> = (0..laid.fitted.len() as u32).into_par_iter().map(|i| judged.bits(i)).collect();
    let mut sum = Counts::default();
    for (i, (cells, links, counts)) in bits.into_iter().enumerate() {
        world.instances.push(InstanceRecord {
            patch: laid.fitted[i].patch,
            first_neighbour: laid.first_neighbour[i],
            placement: laid.fitted[i].placement,
            first_cell_word: world.cell_words.len() as u32,
            first_link_word: world.link_words.len() as u32,
            first_adjacency: 0,
            num_adjacencies: 0,
            first_resource: 0,
            num_resources: 0,
        });
        world.cell_words.extend(cells);
        world.link_words.extend(links);
        sum.cells += counts.cells;
        sum.links += counts.links;
        sum.frames += counts.frames;
        (0..4).for_each(|r| sum.disabled[r] += counts.disabled[r]);
    }
    sum
}

/// Joint tables that are needed, bits of joints, adjacencies.
fn joints(stitcher: &Stitcher<'_>, laid: &Laid, judged: &Judged<'_, '_>, world: &mut WorldData) -> u64 {
    let joined = judged.joined;
    let left = |part: u32| -> Vec<Option<(Vec<u64>, u64)>> {
        joined.overlaps_of(part).iter().map(|o| if o.side == 0 { judged.joint_bits(part, o) } else { None }).collect()
    };
    let relation_of = table_relations(stitcher, laid);
    let mut pool = Pool::default();
    let mut count = 0;
    let mut by_owner: Vec<Vec<AdjacencyRecord>> = vec![Vec::new(); laid.fitted.len()];
    // Some at a time: the bits of all pairs, before equal ones are put together, would fill the memory.
    let parts: Vec<u32> = (0..laid.fitted.len() as u32).collect();
    for some in parts.chunks(256) {
        let bits: Vec<_> = some.par_iter().map(|&p| left(p)).collect();
        for (&a, bits) in some.iter().zip(bits) {
            for (o, bits) in joined.overlaps_of(a).iter().zip(bits) {
                let Some((words, of_pair)) = bits else { continue };
                count += of_pair;
                let first_word = pool.place(&words);
                let record = |other, side| AdjacencyRecord { other, table: o.table, side, first_word };
                by_owner[a as usize].push(record(o.other, 0));
                by_owner[o.other as usize].push(record(a, 1));
            }
        }
    }
    world.joint_words = pool.words;
    let used: BTreeSet<(Relation, u32)> =
        by_owner.iter().flatten().map(|a| (relation_of[a.table as usize], a.table)).collect();
    let mut numbers = vec![NONE; joined.tables.len()];
    for (number, (relation, table)) in used.into_iter().enumerate() {
        numbers[table as usize] = number as u32;
        add_table(&joined.tables[table as usize], &relation, world);
    }
    for (instance, mut own) in world.instances.iter_mut().zip(by_owner) {
        own.iter_mut().for_each(|a| a.table = numbers[a.table as usize]);
        own.sort_unstable_by_key(|a| a.other);
        (instance.first_adjacency, instance.num_adjacencies) = (world.adjacencies.len() as u32, own.len() as u32);
        world.adjacencies.extend(own);
    }
    count
}

/// The relation of every table of the graph, which numbers them in the order of the pairs.
fn table_relations(stitcher: &Stitcher<'_>, laid: &Laid) -> Vec<Relation> {
    let mut seen = HashSet::new();
    let with_joints = laid.pairs.iter().map(|p| p.2).filter(|r| !stitcher.table_of(r).joints.is_empty());
    with_joints.filter(|r| seen.insert(*r)).collect()
}

fn add_table(table: &JointTable, relation: &Relation, world: &mut WorldData) {
    world.tables.push(JointTableRecord {
        patch_a: relation.a,
        patch_b: relation.b,
        first_joint: world.joints.len() as u32,
        num_joints: table.joints.len() as u32,
        placement: relation.placement(),
    });
    world.joints.extend_from_slice(&table.joints);
    world.joints_by_b.extend_from_slice(&table.by_b);
}

/// What characters hold in each instance: its own units, and for a block the panels of tiles that it takes place on.
fn resources(stitcher: &Stitcher<'_>, laid: &Laid, world: &mut WorldData) {
    let mut held: Vec<Vec<u32>> = laid.fitted.iter().map(|f| f.units.clone()).collect();
    for (a, b, relation) in &laid.pairs {
        if stitcher.table_of(relation).shares_floor {
            held[*b as usize].extend(&laid.fitted[*a as usize].units);
        }
    }
    for (instance, mut units) in world.instances.iter_mut().zip(held) {
        units.sort_unstable();
        units.dedup();
        (instance.first_resource, instance.num_resources) = (world.resources.len() as u32, units.len() as u32);
        world.resources.extend(units);
    }
}
