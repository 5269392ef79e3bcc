//! Lays patches over an environment and finds what meets there; keeps what pairs that stand alike have in common.

use super::bodies::Bodies;
use super::config::StitchConfig;
use super::field::Field;
use super::fit::{Fitted, UnitIndex, fit, neighbours};
use super::library::{Library, Pattern, STAGE};
use super::mask::{self, Hit};
use super::near::overlapping;
use super::paths::{Nearness, Paths, Spots};
use super::relation::Relation;
use super::solids;
use super::table::{JointTable, Rule};
use crate::environment::{Bounds, Environment, PlacedUnit};
use crate::error::BuildError;
use crate::progress::Progress;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, OnceLock};
use throng_runtime::patch::Patches;

/// Patches in their places, and what meets there.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Laid {
    /// The instances.
    pub fitted: Vec<Fitted>,
    /// Instance across each edge of each tile.
    pub neighbours: Vec<u32>,
    /// First of each instance's.
    pub first_neighbour: Vec<u32>,
    /// Pairs of instances that overlap, side a first; ascending.
    pub pairs: Vec<(u32, u32, Relation)>,
    /// Units that are in the reach of an instance and do not belong to it: instance, placed unit; ascending.
    pub obstacles: Vec<(u32, u32, Relation)>,
}

/// Everything about patches and pairs of them that does not depend on an environment, found when first needed.
pub(super) struct Stitcher<'a> {
    /// The patches.
    pub patches: Patches<'a>,
    /// What else is known of the bundle.
    pub library: Library<'a>,
    /// How to stitch.
    pub config: StitchConfig,
    /// Units of the patches.
    pub patterns: Vec<Pattern>,
    paths: Vec<OnceLock<Paths>>,
    spots: Vec<OnceLock<Spots>>,
    bodies: OnceLock<Bodies>,
    fields: Vec<OnceLock<Field>>,
    tables: HashMap<Relation, Arc<JointTable>>,
    masks: HashMap<Relation, Arc<Vec<Hit>>>,
}

impl<'a> Stitcher<'a> {
    /// Nothing is found yet.
    ///
    /// # Errors
    /// [`BuildError`] where the parts of the library do not go together or a setting is out of its limits.
    pub fn new(patches: Patches<'a>, library: Library<'a>, config: &StitchConfig) -> Result<Self, BuildError> {
        config.check()?;
        let patterns = library.patterns(&patches)?;
        let count = patches.patches.len();
        Ok(Self {
            patches,
            library,
            config: config.clone(),
            patterns,
            paths: (0..count).map(|_| OnceLock::new()).collect(),
            spots: (0..count).map(|_| OnceLock::new()).collect(),
            bodies: OnceLock::new(),
            fields: library.units.units.iter().map(|_| OnceLock::new()).collect(),
            tables: HashMap::new(),
            masks: HashMap::new(),
        })
    }

    /// Fits patches into an environment and finds what meets there.
    ///
    /// # Errors
    /// [`BuildError::Stage`] names units that stand in each other or that no block fits.
    pub fn lay(&self, environment: &Environment) -> Result<Laid, BuildError> {
        self.check_units(environment)?;
        solids::check(&self.library, environment, self.config.overlap_m)?;
        let index = UnitIndex::new(environment);
        let fitted = fit(&self.library, &self.patterns, &index);
        self.check_cover(environment, &fitted)?;
        let (neighbours, first_neighbour) = neighbours(&self.patches, &self.patterns, &index, &fitted);
        let bounds: Vec<Bounds> = fitted.iter().map(|f| self.reach(f)).collect();
        let pairs = self.pairs(&fitted, &bounds);
        let obstacles = self.obstacles(environment, &fitted, &bounds);
        Ok(Laid { fitted, neighbours, first_neighbour, pairs, obstacles })
    }

    /// Makes the tables and masks that pairs of a world need and no earlier one has; forgets all others.
    pub fn prepare(&mut self, laid: &Laid, progress: &dyn Progress) {
        let relations = |of: &[(u32, u32, Relation)]| of.iter().map(|p| p.2).collect::<BTreeSet<Relation>>();
        let (tables, masks) = (relations(&laid.pairs), relations(&laid.obstacles));
        self.tables.retain(|r, _| tables.contains(r));
        self.masks.retain(|r, _| masks.contains(r));
        let new_tables: Vec<Relation> = tables.into_iter().filter(|r| !self.tables.contains_key(r)).collect();
        let new_masks: Vec<Relation> = masks.into_iter().filter(|r| !self.masks.contains_key(r)).collect();

        progress.begin("joints", new_tables.len() as u64, "pairs");
        let made: Vec<_> = new_tables.par_iter().map(|r| counted(progress, Arc::new(self.table(r)))).collect();
        self.tables.extend(new_tables.into_iter().zip(made));
        progress.end();
        progress.begin("obstacles", new_masks.len() as u64, "pairs");
        let made: Vec<_> = new_masks.par_iter().map(|r| counted(progress, Arc::new(self.mask(r)))).collect();
        self.masks.extend(new_masks.into_iter().zip(made));
        progress.end();
    }

    /// The joints of a pair. [Limit: prepared]
    pub fn table_of(&self, relation: &Relation) -> &Arc<JointTable> {
        &self.tables[relation]
    }

    /// The links of an instance that a unit is in the way of. [Limit: prepared]
    pub fn mask_of(&self, relation: &Relation) -> &[Hit] {
        &self.masks[relation]
    }

    /// Roots of a patch's links.
    pub fn paths(&self, patch: u32) -> &Paths {
        let patch = patch as usize;
        self.paths[patch].get_or_init(|| Paths::new(&self.patches, &self.library, patch))
    }

    /// Bodies of all frames.
    pub fn bodies(&self) -> &Bodies {
        let l = &self.library;
        self.bodies.get_or_init(|| Bodies::new(l.frames, l.contacts, l.skeleton))
    }

    fn table(&self, relation: &Relation) -> JointTable {
        let (patch, c) = (relation.a as usize, &self.config);
        let new_spots =
            || Spots::new(&self.patches, &self.library, self.paths(relation.a), patch, self.config.min_frames);
        let spots = self.spots[patch].get_or_init(new_spots);
        let nearness = Nearness { position: c.position_m, height: c.height_m, heading: c.heading_deg.to_radians() };
        let rule = Rule { nearness, joints_per_cell: c.joints_per_cell };
        let pattern = &self.patterns[patch];
        let panel = &self.library.geometries[pattern.units[0].0].bounds;
        JointTable::new(&self.patches, spots, pattern.is_tile.then_some(panel), relation, rule)
    }

    fn mask(&self, relation: &Relation) -> Vec<Hit> {
        let num_links = self.patches.patches[relation.a as usize].num_links as usize;
        let (paths, unit) = (self.paths(relation.a), self.field(relation.b));
        mask::hits(paths, num_links, self.bodies(), unit, relation.placement(), self.config.penetration_m)
    }

    /// Distances from a unit.
    pub fn field(&self, unit: u32) -> &Field {
        let unit = unit as usize;
        self.fields[unit].get_or_init(|| Field::new(&self.library.geometries[unit]))
    }

    /// All that bodies reach in an instance.
    fn reach(&self, fitted: &Fitted) -> Bounds {
        let p = &self.patches.patches[fitted.patch as usize];
        Bounds { min: p.min.into(), max: p.max.into() }.placed(fitted.placement)
    }

    /// Pairs of which one at least is a block; a tile is side a, of two blocks that of the lower patch.
    fn pairs(&self, fitted: &[Fitted], bounds: &[Bounds]) -> Vec<(u32, u32, Relation)> {
        let tile = |i: u32| self.patterns[fitted[i as usize].patch as usize].is_tile;
        let here = |i: u32| (fitted[i as usize].patch, fitted[i as usize].placement);
        let pair = |(i, j): (u32, u32)| {
            let (ij, ji) = (Relation::new(here(i), here(j)), Relation::new(here(j), here(i)));
            let first = match (tile(i), tile(j)) {
                (true, _) => true,
                (_, true) => false,
                _ => ij <= ji,
            };
            if first { (i, j, ij) } else { (j, i, ji) }
        };
        let mut pairs: Vec<_> = overlapping(bounds, bounds)
            .into_iter()
            .filter(|&(i, j)| i < j && !(tile(i) && tile(j)))
            .map(pair)
            .collect();
        pairs.sort_unstable();
        pairs
    }

    fn obstacles(&self, environment: &Environment, fitted: &[Fitted], bounds: &[Bounds]) -> Vec<(u32, u32, Relation)> {
        let shape = |p: &PlacedUnit| self.library.geometries[p.unit].bounds.placed(p.placement);
        let units: Vec<Bounds> = environment.units.iter().map(shape).collect();
        let relation = |(i, u): (u32, u32)| {
            let (f, p) = (&fitted[i as usize], &environment.units[u as usize]);
            (i, u, Relation::new((f.patch, f.placement), (p.unit as u32, p.placement)))
        };
        overlapping(bounds, &units)
            .into_iter()
            .filter(|(i, u)| !fitted[*i as usize].units.contains(u))
            .map(relation)
            .collect()
    }

    fn check_units(&self, environment: &Environment) -> Result<(), BuildError> {
        let count = self.library.units.units.len();
        let refuse = |message: String, help: &str| {
            Err(BuildError::Stage {
                stage: STAGE,
                message: format!("environment {}: {message}", environment.name),
                help: help.into(),
            })
        };
        let wrong = |u: &PlacedUnit| u.unit >= count || !u.placement.is_moderate(1e5);
        if let Some(i) = environment.units.iter().position(wrong) {
            let u = &environment.units[i];
            return refuse(
                format!("place {i} has unit number {} at {:?}, expected one of {count} units", u.unit, u.placement),
                "Place units that the bundle describes",
            );
        }
        let known = |name: &&String| !self.library.units.units.iter().any(|u| u.name == **name);
        match self.config.obstacles.iter().find(known) {
            None => Ok(()),
            Some(name) => refuse(
                format!(
                    "[stitch] obstacles names the unit {name}, which the bundle {} does not have",
                    self.library.bundle
                ),
                "Correct the name",
            ),
        }
    }

    /// Every unit that is more than an obstacle must belong to an instance.
    fn check_cover(&self, environment: &Environment, fitted: &[Fitted]) -> Result<(), BuildError> {
        let mut covered = vec![false; environment.units.len()];
        fitted.iter().flat_map(|f| &f.units).for_each(|&u| covered[u as usize] = true);
        let left: Vec<usize> =
            (0..covered.len()).filter(|&i| !covered[i] && !self.is_obstacle(environment, i)).collect();
        let Some(&first) = left.first() else {
            return if fitted.is_empty() { Err(self.nothing_fits(environment)) } else { Ok(()) };
        };
        let unit = environment.units[first].unit;
        let used = self.patterns.iter().any(|p| p.units.iter().any(|u| u.0 == unit));
        let help = if used {
            "Place it as it stood to other units where the motion was captured"
        } else {
            "No patch of the bundle has such a unit: list it as `obstacles` under [stitch] if it is only in the way"
        };
        let more = if left.len() > 1 { format!(", nor {} more", left.len() - 1) } else { String::new() };
        Err(BuildError::Stage {
            stage: STAGE,
            message: format!(
                "environment {}: no block fits {}{more}",
                environment.name,
                self.library.describe(environment, first)
            ),
            help: help.into(),
        })
    }

    fn nothing_fits(&self, environment: &Environment) -> BuildError {
        BuildError::Stage {
            stage: STAGE,
            message: format!(
                "no block of bundle {} fits environment {}, which has {} units",
                self.library.bundle,
                environment.name,
                environment.units.len()
            ),
            help: "Place units that its patches consist of".into(),
        }
    }

    /// True for a unit that is only in the way.
    pub fn is_obstacle(&self, environment: &Environment, index: usize) -> bool {
        self.config.obstacles.contains(&self.library.units.units[environment.units[index].unit].name)
    }
}

fn counted<T>(progress: &dyn Progress, made: T) -> T {
    progress.advance(1);
    made
}
