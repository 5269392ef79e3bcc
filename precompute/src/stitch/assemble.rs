//! The world that is left: bits of what belongs to the component, the tables it needs, and the figures.

use super::bits::Pool;
use super::crossing::PairState;
use super::joined::{Joined, Overlap};
use super::lay::{Laid, Stitcher};
use super::outcome::{Counts, Outcome, State, is_end, of_cell, of_link};
use super::prepare::renew;
use super::relation::Relation;
use super::report::Reason;
use super::same::Same;
use super::settled::Settled;
use super::table::JointTable;
use crate::environment::Environment;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use throng_runtime::patch::NONE;
use throng_runtime::world::{AdjacencyRecord, InstanceRecord, JointTableRecord, UnitRecord, WorldData, is_set};

/// The graph of a world and what each of its cells is to the component.
pub(super) struct Judged<'j, 'a> {
    /// The graph.
    pub joined: &'j Joined<'a>,
    /// What every cell is.
    pub settled: &'j Settled,
}

impl Judged<'_, '_> {
    /// Why a cell is taken out; none where it is left.
    pub fn cell(&self, part: u32, cell: u32) -> Option<Reason> {
        let c = &self.joined.cells(part)[cell as usize];
        let alone = is_end(c) && self.joined.neighbour(part, c.edge).is_none();
        of_cell(self.settled.standing(self.joined, part, cell), alone)
    }

    /// Why a link is taken out; none where it is left.
    pub fn link(&self, part: u32, link: u32) -> Option<Reason> {
        let l = &self.joined.patches.links_of(self.joined.parts[part as usize].patch as usize)[link as usize];
        let free = is_set(&self.joined.situation(part).link_words, 0, link);
        of_link(free, self.cell(part, l.from), || self.cell(part, l.to))
    }

    /// What an instance is to the component.
    fn state(&self, part: u32) -> State {
        let (joined, words) = (self.joined, self.joined.words(part));
        let edges = joined.patches.edges_of(joined.parts[part as usize].patch as usize).len() as u32;
        State {
            situation: Same::new(joined.situation(part)),
            inside: self.settled.inside[words.clone()].to_vec(),
            leads: self.settled.to.moved[words].to_vec(),
            has_neighbour: (0..edges).map(|e| joined.neighbour(part, e).is_some()).collect(),
        }
    }
}

/// Puts the world together that is left. Its meta data are still empty.
pub(super) fn assemble(
    stitcher: &mut Stitcher<'_>,
    environment: &Environment,
    laid: &Laid,
    judged: &Judged<'_, '_>,
) -> (WorldData, Counts) {
    let units = environment.units.iter().map(|u| UnitRecord { unit: u.unit as u32, placement: u.placement });
    let mut world = WorldData { units: units.collect(), neighbours: laid.neighbours.clone(), ..WorldData::default() };
    let (outcomes, mut counts) = instances(stitcher, laid, judged, &mut world);
    counts.joints = joints(stitcher, judged.joined, &outcomes, &mut world);
    resources(stitcher, laid, &mut world);
    (world, counts)
}

/// - returns what is left of each, and how much of all.
fn instances(
    stitcher: &mut Stitcher<'_>,
    laid: &Laid,
    judged: &Judged<'_, '_>,
    world: &mut WorldData,
) -> (Vec<Same<Outcome>>, Counts) {
    let joined = judged.joined;
    let states: Vec<State> = (0..laid.fitted.len() as u32).into_par_iter().map(|i| judged.state(i)).collect();
    let known = &mut stitcher.found.outcomes;
    renew(known, &states, |state| Arc::new(Outcome::new(&joined.patches, state)));
    let outcomes: Vec<_> = states.iter().map(|state| Same::new(&known[state])).collect();
    let mut sum = Counts::default();
    for (i, Same(outcome)) in outcomes.iter().enumerate() {
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
        world.cell_words.extend(&outcome.cells);
        world.link_words.extend(&outcome.links);
        sum.add(&outcome.counts);
    }
    (outcomes, sum)
}

/// Joint tables that are needed, bits of joints, adjacencies.
fn joints(stitcher: &mut Stitcher<'_>, joined: &Joined<'_>, outcomes: &[Same<Outcome>], world: &mut WorldData) -> u64 {
    let pairs = pairs(joined, outcomes);
    let keys: Vec<PairState> = pairs.iter().map(|p| p.2.clone()).collect();
    let known = &mut stitcher.found.left;
    renew(known, &keys, |key| {
        let links = joined.patches.links_of(key.patch as usize);
        key.crossing.0.left(links, &key.sides[0].0.cells, &key.sides[1].0.cells)
    });
    let (mut pool, mut first_words) = (Pool::default(), HashMap::new());
    let mut count = 0;
    let mut by_owner: Vec<Vec<AdjacencyRecord>> = vec![Vec::new(); joined.parts.len()];
    for (a, o, key) in &pairs {
        let Some(left) = &known[key] else { continue };
        count += left.count;
        let first_word = *first_words.entry(key).or_insert_with(|| pool.place(&left.words));
        let record = |other, side| AdjacencyRecord { other, table: o.table, side, first_word };
        by_owner[*a as usize].push(record(o.other, 0));
        by_owner[o.other as usize].push(record(*a, 1));
    }
    world.joint_words = pool.words;
    let used: BTreeSet<(Relation, u32)> =
        by_owner.iter().flatten().map(|a| (joined.relations[a.table as usize], a.table)).collect();
    let mut numbers = vec![NONE; joined.relations.len()];
    for (number, (relation, table)) in used.into_iter().enumerate() {
        numbers[table as usize] = number as u32;
        add_table(stitcher.table_of(&relation), &relation, world);
    }
    for (instance, mut own) in world.instances.iter_mut().zip(by_owner) {
        own.iter_mut().for_each(|a| a.table = numbers[a.table as usize]);
        own.sort_unstable_by_key(|a| a.other);
        (instance.first_adjacency, instance.num_adjacencies) = (world.adjacencies.len() as u32, own.len() as u32);
        world.adjacencies.extend(own);
    }
    count
}

/// All pairs of instances that overlap, by their side a, and what the joints that are left depend on.
fn pairs<'j>(joined: &'j Joined<'_>, outcomes: &[Same<Outcome>]) -> Vec<(u32, &'j Overlap, PairState)> {
    let state = |a: u32, o: &Overlap| PairState {
        patch: joined.parts[a as usize].patch,
        crossing: Same::new(&joined.crossings[o.crossing as usize]),
        sides: [a, o.other].map(|i| outcomes[i as usize].clone()),
    };
    let of = |a: u32| joined.overlaps_of(a).iter().filter(|o| o.side == 0).map(move |o| (a, o, state(a, o)));
    (0..joined.parts.len() as u32).flat_map(of).collect()
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
