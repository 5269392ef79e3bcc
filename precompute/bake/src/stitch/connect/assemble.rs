//! Writes the remaining world: bits of cells in the component, and the tables it needs.

use super::{component_cells::ComponentCells, joined::JoinedGraph, remains::WorldRemains};
use crate::{environment::Environment, stitch::report::StitchReport, stitch::sets::rows::WordPool};
use crate::{stitch::place::place_patches::PlacedPatches, stitch::place::relation::RelativePlacement};
use std::collections::{BTreeMap, HashMap};
use throng_core::patch::NONE;
use throng_world::{AdjacencyRecord, InstanceRecord, JointTableRecord, UnitRecord, WorldData};

/// Writes a stitched world, except its metadata.
pub(in crate::stitch) fn write_world(environment: &Environment, made: &StitchResult) -> WorldData {
    let units = environment.units.iter().map(|u| UnitRecord { unit: u.unit as u32, placement: u.placement });
    let neighbours = made.patches.neighbours.clone();
    let mut world = WorldData { units: units.collect(), neighbours, ..WorldData::default() };
    write_instances(made, &mut world);
    write_joints(made, &mut world);
    resources(made, &mut world);
    world
}

/// Writes instances and their bits.
fn write_instances(made: &StitchResult, world: &mut WorldData) {
    let StitchResult { patches: placed, remains, .. } = made;
    for (i, f) in (0u32..).zip(&placed.fitted) {
        let outcome = remains.outcome(i);
        world.instances.push(InstanceRecord {
            patch: f.patch,
            first_neighbour: placed.first_neighbour[i as usize],
            placement: f.placement,
            first_cell_word: world.cell_words.len() as u32,
            first_link_word: world.link_words.len() as u32,
            first_adjacency: 0,
            num_adjacencies: 0,
            first_resource: 0,
            num_resources: 0,
        });
        world.cell_words.extend_from_slice(&outcome.cells);
        world.link_words.extend_from_slice(&outcome.links);
    }
}

/// Writes the needed joint tables, bits of joints, adjacencies.
fn write_joints(made: &StitchResult, world: &mut WorldData) {
    let StitchResult { patches: placed, joined, remains, .. } = made;
    let numbers = write_tables(made, world);
    let table_of: Vec<u32> =
        joined.crossings.iter().map(|c| numbers.get(&c.relation).copied().unwrap_or(NONE)).collect();
    let mut pool = WordPool::default();
    let mut first_words = vec![NONE; remains.remaining.len()];
    for i in 0..placed.fitted.len() as u32 {
        let first = world.adjacencies.len();
        for o in joined.overlaps_of(i) {
            let number = remains.remaining_of[o.pair as usize] as usize;
            let left = &remains.remaining[number];
            if left.count == 0 {
                continue;
            }
            // Bits are shared with the first of both.
            if first_words[number] == NONE && o.side == 0 {
                first_words[number] = pool.intern(&left.words);
            }
            let table = table_of[o.crossing as usize];
            world.adjacencies.push(AdjacencyRecord { other: o.other, table, side: o.side, first_word: number as u32 });
        }
        let instance = &mut world.instances[i as usize];
        (instance.first_adjacency, instance.num_adjacencies) = (first as u32, (world.adjacencies.len() - first) as u32);
    }
    world.adjacencies.iter_mut().for_each(|a| a.first_word = first_words[a.first_word as usize]);
    world.joint_words = pool.words;
}

/// Writes the tables of crossings with remaining joints, by their relations, and numbers them.
fn write_tables(made: &StitchResult, world: &mut WorldData) -> HashMap<RelativePlacement, u32> {
    let StitchResult { joined, remains, .. } = made;
    let mut is_used = vec![false; joined.crossings.len()];
    for (&crossing, &left) in joined.crossing_of.iter().zip(&remains.remaining_of) {
        if crossing != NONE && remains.remaining[left as usize].count > 0 {
            is_used[crossing as usize] = true;
        }
    }
    let used = joined.crossings.iter().zip(&is_used).filter(|(_, is_used)| **is_used);
    let by_relation: BTreeMap<_, _> = used.map(|(c, _)| (c.relation, &c.table)).collect();
    for (relation, table) in &by_relation {
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
    (0u32..).zip(by_relation).map(|(number, (relation, _))| (relation, number)).collect()
}

/// Reserved resources of each instance: its own units, and for a block the panels of tiles that its motion uses.
fn resources(made: &StitchResult, world: &mut WorldData) {
    let StitchResult { patches: placed, joined, .. } = made;
    let on_floor =
        || placed.pairs.iter().zip(&joined.shares_floor).filter(|(_, shares)| **shares).map(|(pair, _)| pair);
    let mut ends: Vec<usize> = placed.fitted.iter().map(|f| f.units.len()).collect();
    on_floor().for_each(|(a, b, _)| ends[*b as usize] += placed.fitted[*a as usize].units.len());
    let mut first = 0;
    for end in &mut ends {
        first += std::mem::replace(end, first);
    }
    let mut held = vec![NONE; first];
    let mut hold = |i: u32, units: &[u32]| {
        let end = &mut ends[i as usize];
        held[*end..*end + units.len()].copy_from_slice(units);
        *end += units.len();
    };
    (0u32..).zip(&placed.fitted).for_each(|(i, f)| hold(i, &f.units));
    on_floor().for_each(|(a, b, _)| hold(*b, &placed.fitted[*a as usize].units));
    let mut first = 0;
    for (instance, end) in world.instances.iter_mut().zip(ends) {
        let own = &mut held[first..end];
        first = end;
        own.sort_unstable();
        instance.first_resource = world.resources.len() as u32;
        world.resources.extend(own.chunk_by(|a, b| a == b).map(|same| same[0]));
        instance.num_resources = world.resources.len() as u32 - instance.first_resource;
    }
}

/// A stitched world, with its intermediate results.
pub(in crate::stitch) struct StitchResult {
    /// Placed patches.
    pub patches: PlacedPatches,
    /// The graph.
    pub joined: JoinedGraph,
    /// Membership of its cells in the component.
    pub component: ComponentCells,
    /// Remaining instances and pairs.
    pub remains: WorldRemains,
    /// Report.
    pub report: StitchReport,
}
