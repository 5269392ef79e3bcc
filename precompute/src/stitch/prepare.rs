//! Finds what pairs and surroundings of a world need, once for all that stand alike, and keeps it for the next change.

use super::bodies::Bodies;
use super::crossing::{Crossing, Left, PairState};
use super::field::Field;
use super::lay::{Laid, Stitcher};
use super::mask::{Hit, Obstacle};
use super::outcome::{Outcome, State};
use super::paths::{Nearness, Paths, Spots};
use super::relation::Relation;
use super::same::Same;
use super::seen::{Earlier, Mask};
use super::situation::{Situation, Surroundings};
use super::swept::Swept;
use super::table::{JointTable, Rule};
use crate::progress::Progress;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::sync::{Arc, OnceLock};
use throng_runtime::world::is_set;

/// What depends on patches alone, and tables that the last world needed.
pub(super) struct Found {
    paths: Vec<OnceLock<Paths>>,
    spots: Vec<OnceLock<Spots>>,
    swept: Vec<OnceLock<Swept>>,
    bodies: OnceLock<Bodies>,
    fields: Vec<OnceLock<Field>>,
    tables: HashMap<Relation, Arc<JointTable>>,
    masks: HashMap<Relation, Arc<Mask>>,
    /// What is left of motion among units.
    pub situations: HashMap<Surroundings, Arc<Situation>>,
    /// What is left of instances, by what they are to the component.
    pub outcomes: HashMap<State, Arc<Outcome>>,
    /// Joints that may be taken, by the pair and the situation of its side a.
    crossings: HashMap<(Relation, Same<Situation>), Arc<Crossing>>,
    /// Joints that are left between instances.
    pub left: HashMap<PairState, Option<Left>>,
}

impl Found {
    /// Nothing is found yet.
    pub fn new(num_patches: usize, num_units: usize) -> Self {
        fn empty<T>(count: usize) -> Vec<OnceLock<T>> {
            (0..count).map(|_| OnceLock::new()).collect()
        }
        Self {
            paths: empty(num_patches),
            spots: empty(num_patches),
            swept: empty(num_patches),
            bodies: OnceLock::new(),
            fields: empty(num_units),
            tables: HashMap::new(),
            masks: HashMap::new(),
            situations: HashMap::new(),
            outcomes: HashMap::new(),
            crossings: HashMap::new(),
            left: HashMap::new(),
        }
    }
}

/// The situations of all instances.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Situated {
    /// Number of each instance's.
    pub of: Vec<u32>,
    /// The situations, each once, by the first instance.
    pub situations: Vec<Arc<Situation>>,
}

/// What is named, once each; ascending.
fn distinct<T: Ord>(named: impl Iterator<Item = T>) -> Vec<T> {
    let mut out: Vec<T> = named.collect();
    out.sort_unstable();
    out.dedup();
    out
}

/// Forgets what no key names and makes what is new; keys may be named more than once.
pub(super) fn renew<K: Eq + Hash + Clone + Sync + Send, V: Send>(
    known: &mut HashMap<K, V>,
    keys: &[K],
    make: impl Fn(&K) -> V + Sync,
) {
    let needed: HashSet<&K> = keys.iter().collect();
    known.retain(|k, _| needed.contains(k));
    let new: Vec<&K> = needed.into_iter().filter(|k| !known.contains_key(k)).collect();
    let made: Vec<V> = new.par_iter().map(|k| make(k)).collect();
    known.extend(new.into_iter().cloned().zip(made));
}

impl Stitcher<'_> {
    /// Makes the tables, masks and situations that a world needs and no earlier one has; forgets all others.
    pub fn prepare(&mut self, laid: &Laid, progress: &dyn Progress) -> Situated {
        let relations = |of: &[(u32, u32, Relation)]| distinct(of.iter().map(|p| p.2));
        let (pairs, obstacles) = (relations(&laid.pairs), relations(&laid.obstacles));
        self.ready(&obstacles);

        let mut tables = std::mem::take(&mut self.found.tables);
        progress.begin("joints", pairs.len() as u64, "pairs");
        renew(&mut tables, &pairs, |r| counted(progress, Arc::new(self.table(r))));
        self.found.tables = tables;
        progress.end();
        let mut masks = std::mem::take(&mut self.found.masks);
        progress.begin("obstacles", obstacles.len() as u64, "pairs");
        let before = masks.clone();
        renew(&mut masks, &obstacles, |r| counted(progress, Arc::new(self.mask(r, &before))));
        self.found.masks = masks;
        progress.end();
        self.situate(laid)
    }

    /// What is made in parallel itself must not be waited for by what is.
    fn ready(&self, obstacles: &[Relation]) {
        if obstacles.is_empty() {
            return;
        }
        self.bodies();
        let mut patches: Vec<u32> = obstacles.iter().map(|r| r.a).collect();
        patches.dedup();
        patches.par_iter().for_each(|&p| {
            self.paths(p);
        });
        for p in patches {
            self.swept(p);
        }
    }

    /// The situations of all instances, and the bits of their joints.
    fn situate(&mut self, laid: &Laid) -> Situated {
        let mut numbers: HashMap<Surroundings, u32> = HashMap::new();
        let (mut order, mut of) = (Vec::new(), Vec::with_capacity(laid.fitted.len()));
        let mut obstacles = laid.obstacles.iter().peekable();
        for (i, f) in (0u32..).zip(&laid.fitted) {
            let mut own = Vec::new();
            while let Some((_, _, r)) = obstacles.next_if(|o| o.0 == i) {
                own.extend((!self.found.masks[r].words.is_empty()).then_some(*r));
            }
            own.sort_unstable();
            own.dedup();
            let key = Surroundings { patch: f.patch, obstacles: own };
            of.push(*numbers.entry(key).or_insert_with_key(|key| {
                order.push(key.clone());
                order.len() as u32 - 1
            }));
        }
        let mut known = std::mem::take(&mut self.found.situations);
        renew(&mut known, &order, |key| {
            let masks = key.obstacles.iter().map(|r| self.found.masks[r].words.as_slice());
            Arc::new(Situation::new(&self.patches, key.clone(), masks))
        });
        let situations: Vec<_> = order.iter().map(|key| Arc::clone(&known[key])).collect();
        self.found.situations = known;
        let situated = Situated { of, situations };
        self.cross(laid, &situated);
        situated
    }

    fn cross(&mut self, laid: &Laid, situated: &Situated) {
        let joined = |(a, _, r): &(u32, u32, Relation)| {
            (!self.found.tables[r].joints.is_empty()).then_some((*r, situated.of[*a as usize]))
        };
        let pairs = distinct(laid.pairs.iter().filter_map(joined));
        let key = |(r, s): (Relation, u32)| (r, Same::new(&situated.situations[s as usize]));
        let keys: Vec<_> = pairs.into_iter().map(key).collect();
        let mut known = std::mem::take(&mut self.found.crossings);
        renew(&mut known, &keys, |(relation, Same(situation))| {
            let hit = |link: u32, offsets| self.hit(&situation.surroundings, link, offsets);
            let table = &self.found.tables[relation];
            Arc::new(Crossing::new(&self.patches, [relation.a, relation.b], table, situation, hit))
        });
        self.found.crossings = known;
    }

    /// First and last frame of a link that collide with anything around it, as far as [`Situation::joint_words`] asks.
    fn hit(&self, surroundings: &Surroundings, link: u32, offsets: [u32; 2]) -> Option<Hit> {
        let in_the_way = surroundings.obstacles.iter().map(|r| (r, &self.found.masks[r]));
        let in_the_way = in_the_way.filter(|(_, mask)| is_set(&mask.words, 0, link));
        let link = link as usize;
        in_the_way.filter_map(|(r, mask)| self.obstacle(r).hit(link, mask.frame(link), offsets)).reduce(Hit::union)
    }

    /// The joints of a pair. [Limit: prepared]
    pub fn table_of(&self, relation: &Relation) -> &Arc<JointTable> {
        &self.found.tables[relation]
    }

    /// The joints of a pair that may be taken in a situation of its side a. [Limit: prepared]
    pub fn crossing_of(&self, relation: &Relation, situation: &Arc<Situation>) -> &Arc<Crossing> {
        &self.found.crossings[&(*relation, Same::new(situation))]
    }

    /// Roots of a patch's links.
    pub fn paths(&self, patch: u32) -> &Paths {
        let patch = patch as usize;
        self.found.paths[patch].get_or_init(|| Paths::new(&self.patches, &self.library, patch))
    }

    /// Bodies of all frames.
    pub fn bodies(&self) -> &Bodies {
        let l = &self.library;
        self.found.bodies.get_or_init(|| Bodies::new(l.frames, l.contacts, l.skeleton, self.config.penetration_m))
    }

    /// Where links pass; none where they have most of their roots in common.
    fn swept(&self, patch: u32) -> Option<&Swept> {
        let paths = self.paths(patch);
        let make = || Swept::new(paths, self.bodies());
        (!paths.is_shared()).then(|| self.found.swept[patch as usize].get_or_init(make))
    }

    fn table(&self, relation: &Relation) -> JointTable {
        let (patch, c) = (relation.a as usize, &self.config);
        let new_spots =
            || Spots::new(&self.patches, &self.library, self.paths(relation.a), patch, self.config.min_frames);
        let spots = self.found.spots[patch].get_or_init(new_spots);
        let nearness = Nearness { position: c.position_m, height: c.height_m, heading: c.heading_deg.to_radians() };
        let rule = Rule { nearness, joints_per_cell: c.joints_per_cell };
        let pattern = &self.patterns[patch];
        let panel = &self.library.geometries[pattern.units[0].0].bounds;
        JointTable::new(&self.patches, spots, pattern.is_tile.then_some(panel), relation, rule)
    }

    /// - `before`: masks of the world that is changed.
    fn mask(&self, relation: &Relation, before: &HashMap<Relation, Arc<Mask>>) -> Mask {
        let (unit, at) = (&self.library.geometries[relation.b as usize].bounds, relation.placement());
        let alike = before.iter().filter(|(r, _)| (r.a, r.b) == (relation.a, relation.b));
        let moved = alike.map(|(r, mask)| Earlier { mask, moved: Obstacle::moved(unit, r.placement(), at) });
        let earlier = moved.min_by(|a, b| a.moved.total_cmp(&b.moved));
        self.obstacle(relation).mask(self.swept(relation.a), earlier)
    }

    fn obstacle(&self, relation: &Relation) -> Obstacle<'_> {
        let (paths, unit) = (self.paths(relation.a), self.field(relation.b));
        Obstacle::new(paths, self.bodies(), unit, relation.placement())
    }

    /// Distances from a unit.
    pub fn field(&self, unit: u32) -> &Field {
        let unit = unit as usize;
        self.found.fields[unit].get_or_init(|| Field::new(&self.library.geometries[unit]))
    }
}

fn counted<T>(progress: &dyn Progress, made: T) -> T {
    progress.advance(1);
    made
}
