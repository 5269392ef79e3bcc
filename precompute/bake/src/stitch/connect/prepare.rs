//! Finds tables and obstacle masks for the pairs and surroundings of a world, once for equal placements, and caches
//! them for the next change.

use super::crossing::{CrossingJoints, PairState, RemainingJoints};
use super::outcome::{InstanceOutcome, InstanceState};
use super::situation::{PatchSituation, PatchSurroundings};
use super::table::JointTable;
use crate::stitch::clearance::collision_span::CollisionSpan;
use crate::stitch::clearance::link_clearance::{EarlierMask, ObstacleMask};
use crate::stitch::place::paths::{JoinSpots, LinkRoots};
use crate::stitch::place::place_patches::{PlacedPatches, Placer};
use crate::stitch::sets::numbers::{IdentityArc, SharedNumbers};
use crate::{stitch::clearance::bodies::FrameBodies, stitch::place::fit::FittedPatch};
use crate::{stitch::clearance::field::DistanceField, stitch::clearance::swept::SweptSquares};
use crate::{stitch::clearance::mask::MotionObstacle, stitch::place::relation::RelativePlacement};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::sync::{Arc, OnceLock};
use throng_core::patch::NONE;
use throng_motion::progress::Progress;
use throng_world::is_set;

/// A bundle's patches, with cached results that do not depend on an environment.
pub(in crate::stitch) struct Stitcher<'a> {
    /// Placement of patches.
    pub placer: Placer<'a>,
    /// Cached results of previous worlds.
    pub found: StitchCache,
}

/// Masks of obstacles, by the relation of the patch and the obstacle.
type KnownMasks = HashMap<RelativePlacement, Arc<ObstacleMask>>;

/// Results that depend on patches only, and tables of the last world.
#[derive(Default)]
pub(in crate::stitch) struct StitchCache {
    paths: Vec<OnceLock<LinkRoots>>,
    spots: Vec<OnceLock<JoinSpots>>,
    swept: Vec<OnceLock<SweptSquares>>,
    bodies: OnceLock<FrameBodies>,
    fields: Vec<OnceLock<DistanceField>>,
    tables: HashMap<RelativePlacement, Arc<JointTable>>,
    masks: KnownMasks,
    /// Unobstructed motion of patches, by their surroundings.
    pub situations: HashMap<PatchSurroundings, Arc<PatchSituation>>,
    /// Remaining motion of instances, by their state relative to the component.
    pub outcomes: HashMap<InstanceState, Arc<InstanceOutcome>>,
    /// Usable joints, by the pair and the situation of its side a.
    crossings: HashMap<(RelativePlacement, IdentityArc<PatchSituation>), Arc<CrossingJoints>>,
    /// Remaining joints between instances.
    pub remaining: HashMap<PairState, Arc<RemainingJoints>>,
}

impl StitchCache {
    /// An empty cache.
    pub fn new(num_patches: usize, num_units: usize) -> Self {
        fn empty<T>(count: usize) -> Vec<OnceLock<T>> {
            (0..count).map(|_| OnceLock::new()).collect()
        }
        let (paths, spots, swept) = (empty(num_patches), empty(num_patches), empty(num_patches));
        Self { paths, spots, swept, fields: empty(num_units), ..Self::default() }
    }
}

/// Situations of instances and usable joints of pairs of a world.
#[derive(Clone, Debug, Default)]
pub(in crate::stitch) struct PreparedWorld {
    /// Number of each instance's situation.
    pub situation_of: Vec<u32>,
    /// The situations, each once, by the first instance.
    pub situations: Vec<Arc<PatchSituation>>,
    /// Number of the usable joints of each pair; [`NONE`] without joints.
    pub crossing_of: Vec<u32>,
    /// Usable joints, each set once, by the first pair.
    pub crossings: Vec<Arc<CrossingJoints>>,
    /// True for pairs of a tile and a block whose motion uses its panel.
    pub shares_floor: Vec<bool>,
}

/// Distinct values; ascending.
fn distinct<T: Ord>(named: impl Iterator<Item = T>) -> Vec<T> {
    let mut out: Vec<T> = named.collect();
    out.sort_unstable();
    out.dedup();
    out
}

/// Computes missing entries in parallel; keys may be repeated.
pub(in crate::stitch) fn make_missing<K: Eq + Hash + Clone + Sync + Send, V: Send>(
    known: &mut HashMap<K, V>,
    keys: &[K],
    make: impl Fn(&K) -> V + Sync,
) {
    let unknown: HashSet<&K> = keys.iter().filter(|k| !known.contains_key(k)).collect();
    let new: Vec<&K> = unknown.into_iter().collect();
    let made: Vec<V> = new.par_iter().map(|k| make(k)).collect();
    known.extend(new.into_iter().cloned().zip(made));
}

impl<'a> Stitcher<'a> {
    /// A stitcher without cached results.
    pub fn new(placer: Placer<'a>) -> Self {
        let found = StitchCache::new(placer.patches.patches.len(), placer.library.units.units.len());
        Self { placer, found }
    }

    /// Computes the tables, masks, situations and crossings of a world that are not cached.
    pub fn prepare(&mut self, placed: &PlacedPatches, progress: &dyn Progress) -> PreparedWorld {
        self.forget_unshared();
        let pairs = distinct(placed.pairs.iter().map(|p| p.2));
        let obstacles = distinct(placed.obstacles.iter().map(|o| o.2).filter(|r| !self.found.masks.contains_key(r)));
        self.prepare_shared(&obstacles);

        let mut tables = std::mem::take(&mut self.found.tables);
        progress.begin("joints", pairs.len() as u64, "pairs");
        make_missing(&mut tables, &pairs, |r| count_progress(progress, Arc::new(self.table(r))));
        self.found.tables = tables;
        progress.end();
        let mut masks = std::mem::take(&mut self.found.masks);
        progress.begin("obstacles", obstacles.len() as u64, "pairs");
        let before = if obstacles.is_empty() { HashMap::new() } else { masks.clone() };
        make_missing(&mut masks, &obstacles, |r| count_progress(progress, Arc::new(self.mask(r, &before))));
        self.found.masks = masks;
        progress.end();
        let mut out = PreparedWorld::default();
        self.find_situations(placed, &mut out);
        self.find_crossings(placed, &mut out);
        out
    }

    /// Drops all tables and masks except those of a world.
    pub fn forget_all_but(&mut self, placed: &PlacedPatches) {
        let [pairs, obstacles] =
            [&placed.pairs, &placed.obstacles].map(|needed| needed.iter().map(|p| p.2).collect::<HashSet<_>>());
        self.found.tables.retain(|r, _| pairs.contains(r));
        self.found.masks.retain(|r, _| obstacles.contains(r));
    }

    /// Drops results that no world uses any more: first those that share others.
    fn forget_unshared(&mut self) {
        self.found.remaining.retain(|_, left| Arc::strong_count(left) > 1);
        self.found.outcomes.retain(|_, outcome| Arc::strong_count(outcome) > 1);
        self.found.crossings.retain(|_, crossing| Arc::strong_count(crossing) > 1);
        self.found.situations.retain(|_, situation| Arc::strong_count(situation) > 1);
    }

    /// Computes parallel results up front, so that other parallel work does not wait for them.
    fn prepare_shared(&self, obstacles: &[RelativePlacement]) {
        if obstacles.is_empty() {
            return;
        }
        self.bodies();
        let mut patches: Vec<u32> = obstacles.iter().map(|r| r.a).collect();
        patches.dedup();
        patches.par_iter().for_each(|&p| _ = self.paths(p));
        patches.iter().for_each(|&p| _ = self.swept(p));
    }

    /// Finds the situations of all instances.
    fn find_situations(&mut self, placed: &PlacedPatches, out: &mut PreparedWorld) {
        let mut obstacles = placed.obstacles.chunk_by(|o, p| o.0 == p.0).peekable();
        let mut around = |i: u32| obstacles.next_if(|o| o[0].0 == i).unwrap_or(&[]);
        let surroundings = |(i, f): (u32, &FittedPatch)| {
            let all = around(i).iter().map(|o| o.2).filter(|r| !self.found.masks[r].words.is_empty());
            PatchSurroundings { patch: f.patch, obstacles: distinct(all) }
        };
        let keys: Vec<PatchSurroundings> = (0u32..).zip(&placed.fitted).map(surroundings).collect();
        let mut known = std::mem::take(&mut self.found.situations);
        make_missing(&mut known, &keys, |key| {
            let masks = key.obstacles.iter().map(|r| self.found.masks[r].words.as_slice());
            Arc::new(PatchSituation::new(&self.placer.patches, key.clone(), masks))
        });
        let mut numbers = SharedNumbers::default();
        out.situation_of = keys.iter().map(|key| numbers.number_of(&known[key])).collect();
        out.situations = numbers.all;
        self.found.situations = known;
    }

    /// Finds the usable joints of all pairs.
    fn find_crossings(&mut self, placed: &PlacedPatches, out: &mut PreparedWorld) {
        let tables = &self.found.tables;
        let key = |(a, _, r): &(u32, u32, RelativePlacement)| {
            let situation = &out.situations[out.situation_of[*a as usize] as usize];
            (!tables[r].joints.is_empty()).then(|| (*r, IdentityArc::new(situation)))
        };
        let keys: Vec<_> = placed.pairs.iter().map(key).collect();
        let with_joints: Vec<_> = keys.iter().flatten().cloned().collect();
        let mut known = std::mem::take(&mut self.found.crossings);
        make_missing(&mut known, &with_joints, |(relation, IdentityArc(situation))| {
            let hit = |link: u32| self.collision_span(&situation.surroundings, link);
            let table = &self.found.tables[relation];
            Arc::new(CrossingJoints::new(&self.placer.patches, *relation, table, situation, hit))
        });
        let mut numbers = SharedNumbers::default();
        out.crossing_of =
            keys.iter().map(|key| key.as_ref().map_or(NONE, |key| numbers.number_of(&known[key]))).collect();
        out.shares_floor = placed.pairs.iter().map(|p| self.found.tables[&p.2].shares_floor).collect();
        out.crossings = numbers.all;
        self.found.crossings = known;
    }

    /// First and last frame of a link that collide with its surroundings.
    fn collision_span(&self, surroundings: &PatchSurroundings, link: u32) -> Option<CollisionSpan> {
        let in_the_way = surroundings.obstacles.iter().map(|r| (r, &self.found.masks[r]));
        let in_the_way = in_the_way.filter(|(_, mask)| is_set(&mask.words, 0, link));
        in_the_way
            .filter_map(|(r, mask)| self.obstacle(r).collision_span(mask, link as usize))
            .reduce(CollisionSpan::union)
    }

    /// Roots of a patch's links.
    pub fn paths(&self, patch: u32) -> &LinkRoots {
        let patch = patch as usize;
        self.found.paths[patch].get_or_init(|| LinkRoots::new(&self.placer.patches, &self.placer.library, patch))
    }

    /// Bodies of all frames.
    pub fn bodies(&self) -> &FrameBodies {
        let make = || FrameBodies::new(&self.placer.library, self.placer.config.penetration_m);
        self.found.bodies.get_or_init(make)
    }

    /// Ground swept by links; `None` if they have most of their roots in common.
    fn swept(&self, patch: u32) -> Option<&SweptSquares> {
        let paths = self.paths(patch);
        let make = || SweptSquares::new(paths, self.bodies());
        (!paths.is_shared).then(|| self.found.swept[patch as usize].get_or_init(make))
    }

    fn table(&self, relation: &RelativePlacement) -> JointTable {
        let Placer { patches, library, config, patterns } = &self.placer;
        let patch = relation.a as usize;
        let new_spots = || JoinSpots::new(patches, library, self.paths(relation.a), patch, config.min_frames);
        let spots = self.found.spots[patch].get_or_init(new_spots);
        let panel = &library.geometries[patterns[patch].units[0].0].bounds;
        JointTable::new(patches, spots, patterns[patch].is_tile.then_some(panel), relation, config)
    }

    /// - `before`: masks of the world before a change.
    fn mask(&self, relation: &RelativePlacement, before: &KnownMasks) -> ObstacleMask {
        let (unit, at) = (&self.placer.library.geometries[relation.b as usize].bounds, relation.placement());
        let alike = before.iter().filter(|(r, _)| (r.a, r.b) == (relation.a, relation.b));
        let shift = |r: &RelativePlacement| MotionObstacle::greatest_shift(unit, r.placement(), at);
        let moved = alike.map(|(r, mask)| (r, EarlierMask { mask, moved: shift(r) }));
        let least = moved.min_by(|(r, a), (s, b)| a.moved.total_cmp(&b.moved).then_with(|| r.cmp(s)));
        self.obstacle(relation).mask(self.swept(relation.a), least.map(|(_, earlier)| earlier))
    }

    fn obstacle(&self, relation: &RelativePlacement) -> MotionObstacle<'_> {
        let (paths, unit) = (self.paths(relation.a), self.field(relation.b));
        MotionObstacle::new(paths, self.bodies(), unit, relation.placement())
    }

    /// Distances from a unit.
    pub fn field(&self, unit: u32) -> &DistanceField {
        let unit = unit as usize;
        self.found.fields[unit].get_or_init(|| DistanceField::new(&self.placer.library.geometries[unit]))
    }
}

fn count_progress<T>(progress: &dyn Progress, made: T) -> T {
    progress.advance(1);
    made
}
