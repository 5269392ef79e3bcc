//! Places patches in an environment, and finds overlaps and obstacles.

use super::fit::{FittedPatch, UnitIndex};
use super::{near::overlapping_pairs, relation::RelativePlacement};
use crate::environment::{Environment, PlacedUnit};
use crate::stitch::library::{Library, STAGE, UnitPattern, refusal_error};
use crate::{stages::stage_error, stitch::config::StitchConfig};
use throng_core::patch::PatchTables;
use throng_geometry::BoundingBox;
use throng_motion::error::{BuildError, Result};

/// Placed patches, with their overlaps and obstacles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::stitch) struct PlacedPatches {
    /// The instances.
    pub fitted: Vec<FittedPatch>,
    /// Instance across each edge of each tile.
    pub neighbours: Vec<u32>,
    /// Index of each instance's first neighbour.
    pub first_neighbour: Vec<u32>,
    /// Pairs of instances that overlap, side a first; ascending.
    pub pairs: Vec<(u32, u32, RelativePlacement)>,
    /// Units within the bounds of an instance they do not belong to: instance, placed unit; ascending.
    pub obstacles: Vec<(u32, u32, RelativePlacement)>,
}

/// Places the patches of a bundle in environments.
pub(in crate::stitch) struct Placer<'a> {
    /// The patches.
    pub patches: PatchTables,
    /// Other data of the bundle.
    pub library: Library<'a>,
    /// Settings of stitching.
    pub config: StitchConfig,
    /// Units of the patches.
    pub patterns: Vec<UnitPattern>,
}

impl<'a> Placer<'a> {
    /// Checks settings, and that the parts of the library match.
    ///
    /// # Errors
    /// [`BuildError`] if the parts of the library do not match or a setting is out of its limits.
    pub fn new(patches: &PatchTables, library: Library<'a>, config: &StitchConfig) -> Result<Self> {
        config.check()?;
        let patterns = library.patterns(patches)?;
        Ok(Self { patches: patches.clone(), library, config: config.clone(), patterns })
    }

    /// Fits patches into an environment, and finds overlaps and obstacles.
    ///
    /// # Errors
    /// [`BuildError::Stage`] names units that overlap or that no block fits.
    pub fn place_patches(&self, environment: &Environment) -> Result<PlacedPatches> {
        self.check_units(environment)?;
        self.check_overlaps(environment)?;
        let index = UnitIndex::new(environment);
        let fitted = self.fit_patches(&index);
        self.check_cover(environment, &fitted)?;
        let (neighbours, first_neighbour) = self.neighbours(&index, &fitted);
        let bounds: Vec<BoundingBox> = fitted.iter().map(|f| self.instance_bounds(f)).collect();
        let geometries = &self.library.geometries;
        let shape = |u: &PlacedUnit| geometries[u.unit].bounds.mapped(|p| u.placement.transform_point(p));
        let shapes: Vec<BoundingBox> = environment.units.iter().map(shape).collect();
        let both = overlapping_pairs(&bounds, &bounds).into_iter().filter(|(i, j)| i < j);
        let mut pairs: Vec<_> = both.filter_map(|(i, j)| self.pair(&fitted, i, j)).collect();
        pairs.sort_unstable();
        let obstacle =
            |(i, u): (u32, u32)| Some((i, u, fitted[i as usize].obstacle(u, &environment.units[u as usize])?));
        let obstacles = overlapping_pairs(&bounds, &shapes).into_iter().filter_map(obstacle).collect();
        Ok(PlacedPatches { fitted, neighbours, first_neighbour, pairs, obstacles })
    }

    /// Bounds of the bodies in an instance.
    fn instance_bounds(&self, fitted: &FittedPatch) -> BoundingBox {
        let p = &self.patches.patches[fitted.patch as usize];
        BoundingBox { min: p.min.into(), max: p.max.into() }.mapped(|p| fitted.placement.transform_point(p))
    }

    /// Overlap of two instances, side a first: a tile, or of two blocks that of the lower patch; `None` for two tiles.
    fn pair(&self, fitted: &[FittedPatch], i: u32, j: u32) -> Option<(u32, u32, RelativePlacement)> {
        let tile = |i: u32| self.patterns[fitted[i as usize].patch as usize].is_tile;
        let [first, second] = [i, j].map(|i| &fitted[i as usize]);
        let relation =
            |a: &FittedPatch, b: &FittedPatch| RelativePlacement::new(a.patch, a.placement, b.patch, b.placement);
        let (ij, ji) = (relation(first, second), relation(second, first));
        let first = match (tile(i), tile(j)) {
            (true, true) => return None,
            (true, false) => true,
            (false, true) => false,
            // For a symmetric relation, the first instance is side a.
            (false, false) => (ij, i) <= (ji, j),
        };
        Some(if first { (i, j, ij) } else { (j, i, ji) })
    }

    /// Checks that every unit is one of the bundle's, at a valid place.
    fn check_units(&self, environment: &Environment) -> Result<()> {
        let count = self.library.units.units.len();
        if let Some(i) = environment.units.iter().position(|u| !self.is_known(u)) {
            let u = &environment.units[i];
            let why =
                format!("place {i} has unit number {} at {:?}, expected one of {count} units", u.unit, u.placement);
            return Err(refusal_error(environment, why, "Place units that the bundle describes"));
        }
        let known = |name: &&String| !self.library.units.units.iter().any(|u| u.name == **name);
        let Some(name) = self.config.obstacles.iter().find(known) else { return Ok(()) };
        let bundle = self.library.bundle;
        let why = format!("[stitch] obstacles names the unit {name}, which the bundle {bundle} does not have");
        Err(refusal_error(environment, why, "Correct the name"))
    }

    /// True for one of the bundle's units at a valid place.
    fn is_known(&self, unit: &PlacedUnit) -> bool {
        unit.unit < self.library.units.units.len() && unit.placement.is_moderate(1e5)
    }

    /// Checks that every unit that is not just an obstacle belongs to an instance.
    fn check_cover(&self, environment: &Environment, fitted: &[FittedPatch]) -> Result<()> {
        let mut covered = vec![false; environment.units.len()];
        fitted.iter().flat_map(|f| &f.units).for_each(|&u| covered[u as usize] = true);
        let left: Vec<usize> =
            (0..covered.len()).filter(|&i| !covered[i] && !self.is_obstacle(environment, i)).collect();
        let Some(&first) = left.first() else {
            return if fitted.is_empty() { Err(self.nothing_fits(environment)) } else { Ok(()) };
        };
        let unit = environment.units[first].unit;
        let used = self.patterns.iter().any(|p| p.units.iter().any(|u| u.0 == unit));
        let help = match used {
            true => "Place it as it stood to other units where the motion was captured",
            false => {
                "No patch of the bundle has such a unit: list it as `obstacles` under [stitch] if it is only in the way"
            }
        };
        let more = if left.len() > 1 { format!(", nor {} more", left.len() - 1) } else { String::new() };
        let why = format!("no block fits {}{more}", self.library.describe(environment, first));
        Err(refusal_error(environment, why, help))
    }

    fn nothing_fits(&self, environment: &Environment) -> BuildError {
        let (bundle, name, count) = (self.library.bundle, &environment.name, environment.units.len());
        let message = format!("no block of bundle {bundle} fits environment {name}, which has {count} units");
        stage_error(STAGE, message, "Place units that its patches consist of")
    }

    /// True for a unit that is an obstacle only.
    pub fn is_obstacle(&self, environment: &Environment, index: usize) -> bool {
        self.config.obstacles.contains(&self.library.units.units[environment.units[index].unit].name)
    }
}
