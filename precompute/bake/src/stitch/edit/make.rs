//! Stitching from the first step to the last.

use crate::environment::{Environment, UnitSolid};
use crate::stitch::connect::assemble::{StitchResult, write_world};
use crate::stitch::connect::component_cells::{ComponentMembership, find_component};
use crate::stitch::connect::remains::{JudgedGraph, find_remains};
use crate::stitch::library::{Library, STAGE, refusal_error};
use crate::stitch::report::{RemovalReason, StitchReport};
use crate::{stages::stage_error, stitch::config::StitchConfig, stitch::connect::prepare::Stitcher};
use crate::{stitch::clearance::field::DistanceField, stitch::connect::outcome::WorldCounts};
use crate::{stitch::connect::allow::build_joined_graph, stitch::place::place_patches::PlacedPatches};
use serde::Serialize;
use std::time::Instant;
use throng_core::base::Hash128;
use throng_motion::error::{BuildError, Result};
use throng_motion::{memory, progress::Progress};
use throng_world::{WorldData, WorldMeta};

/// Stitching, in reading order.
///
/// # Errors
/// As [`crate::stitch::stitch`].
pub(in crate::stitch) fn make_world<'a>(
    stitcher: &mut Stitcher<'a>,
    environment: &Environment,
    progress: &dyn Progress,
) -> Result<(StitchResult, WorldData)> {
    let begin = Instant::now();
    let placed = stitcher.placer.place_patches(environment)?;
    stitcher.check_sizes(environment, &placed)?;
    progress.check()?;
    let prepared = stitcher.prepare(&placed, progress);
    progress.check()?;
    let joined = build_joined_graph(&stitcher.placer.patches, &placed, prepared);
    progress.begin("component", joined.num_nodes as u64, "cells");
    let largest = find_component(&joined).ok_or_else(|| stitcher.no_component(environment))?;
    progress.end();
    let judged = JudgedGraph { joined: &joined, component: &largest };
    let remains = find_remains(&mut stitcher.found, &placed, &judged);
    stitcher.check_reached(environment, &placed, &judged)?;
    let report = stitcher.report(&placed, &remains.counts());
    let meta = stitcher.meta(environment, &report)?;
    let mut made = StitchResult { patches: placed, joined, component: largest, remains, report };
    let mut world = write_world(environment, &made);
    world.meta = meta;
    stitcher.forget_all_but(&made.patches);
    let report = &mut made.report;
    (report.tables, report.joints) = (world.tables.len(), world.joints.len());
    (report.peak_bytes, report.seconds) = (memory::peak_bytes().unwrap_or(0), begin.elapsed().as_secs_f64());
    Ok((made, world))
}

/// Most cells of a world, about 80 bytes each during stitching, and most words of 64 links.
const MOST_CELLS: u64 = 50_000_000;
const MOST_WORDS: u64 = 100_000_000;

/// Reason why a world of instances with so many cells and links each is too large, if it is.
fn too_many(sizes: impl ExactSizeIterator<Item = [u32; 2]>) -> Option<String> {
    let instances = sizes.len();
    let (cells, words) = sizes.fold((0, 0), |(cells, words), [num_cells, num_links]| {
        (cells + u64::from(num_cells), words + u64::from(num_links.div_ceil(64)))
    });
    (cells > MOST_CELLS || words > MOST_WORDS).then(|| {
        format!(
            "{instances} instances have {cells} cells with {words} words of links, expected {MOST_CELLS} and {MOST_WORDS} at most"
        )
    })
}

impl Stitcher<'_> {
    /// Checks limits up front: later steps need memory for each cell, and obstacles are measured on a grid.
    fn check_sizes(&self, environment: &Environment, placed: &PlacedPatches) -> Result<()> {
        let patches = &self.placer.patches.patches;
        let sizes = placed.fitted.iter().map(|f| &patches[f.patch as usize]).map(|p| [p.num_cells, p.num_links]);
        if let Some(why) = too_many(sizes) {
            return Err(refusal_error(
                environment,
                why,
                "Stitch several smaller worlds, or bake patches of fewer cells",
            ));
        }
        let library = &self.placer.library;
        let is_too_large: Vec<bool> = library.geometries.iter().map(|g| DistanceField::is_too_large(g)).collect();
        let Some((_, unit, relation)) = placed.obstacles.iter().find(|o| is_too_large[o.2.b as usize]) else {
            return Ok(());
        };
        let bounds = &library.geometries[relation.b as usize].bounds;
        let (unit, size) = (library.describe(environment, *unit as usize), bounds.max - bounds.min);
        let why = format!("{unit} is in the way of motion, and too large to be measured: {size:.0} m");
        Err(refusal_error(environment, why, "Make several smaller units of it"))
    }

    fn no_component(&self, environment: &Environment) -> BuildError {
        let bundle = self.placer.library.bundle;
        let why = format!("no motion leads on for ever in any of the blocks of bundle {bundle} that fit it");
        refusal_error(environment, why, "Place more units, so that ways through them lead back to where they began")
    }

    /// Checks that every unit that is not just an obstacle belongs to an instance with remaining motion.
    fn check_reached(&self, environment: &Environment, placed: &PlacedPatches, judged: &JudgedGraph<'_>) -> Result<()> {
        if self.placer.config.allow_unreachable {
            return Ok(());
        }
        let has = |i: usize, what: ComponentMembership| judged.component.has_membership(judged.joined, i as u32, what);
        let mut reached = vec![false; environment.units.len()];
        for (_, f) in placed.fitted.iter().enumerate().filter(|(i, _)| has(*i, ComponentMembership::Inside)) {
            f.units.iter().for_each(|&u| reached[u as usize] = true);
        }
        let left: Vec<usize> =
            (0..reached.len()).filter(|&u| !reached[u] && !self.placer.is_obstacle(environment, u)).collect();
        let Some(&unit) = left.first() else { return Ok(()) };
        let here = || placed.fitted.iter().enumerate().filter(|(_, f)| f.units.contains(&(unit as u32)));
        let leads_away = here().any(|(i, _)| has(i, ComponentMembership::Unreached));
        let patches: Vec<&str> =
            here().map(|(_, f)| self.placer.library.names[f.patch as usize].name.as_str()).collect();
        let what = if leads_away { "no character can get there" } else { "no way leads out of it" };
        let more = if left.len() > 1 { format!(", as of {} more units", left.len() - 1) } else { String::new() };
        let unit = self.placer.library.describe(environment, unit);
        let why = format!("{unit}: {what}{more} (blocks: {})", patches.join(", "));
        let help = "Connect it, take what is in the way away, or set `allow_unreachable` under [stitch]";
        Err(refusal_error(environment, why, help))
    }

    fn report(&self, placed: &PlacedPatches, counts: &WorldCounts) -> StitchReport {
        let mut fitted = vec![0; self.placer.patterns.len()];
        placed.fitted.iter().for_each(|f| fitted[f.patch as usize] += 1);
        let patches = self.placer.library.names.iter().zip(fitted).filter(|(_, n)| *n > 0);
        StitchReport {
            instances: placed.fitted.len(),
            patches: patches.map(|(patch, n)| (patch.name.clone(), n)).collect(),
            cells: counts.cells,
            transitions: counts.links + counts.joints,
            motion_hours: counts.frames as f64 / self.placer.library.rate_hz / 3600.0,
            disabled: RemovalReason::ALL.iter().map(|&r| (r.name().to_owned(), counts.disabled[r as usize])).collect(),
            ..StitchReport::default()
        }
    }

    fn meta(&self, environment: &Environment, report: &StitchReport) -> Result<WorldMeta> {
        let as_toml = as_toml(environment)?;
        let source_hash = source_hash(&as_toml, &self.placer.config, &self.placer.library)?;
        Ok(WorldMeta {
            name: environment.name.clone(),
            generator: concat!("throng ", env!("CARGO_PKG_VERSION")).to_owned(),
            bundle: self.placer.library.bundle.to_owned(),
            bundle_hash: self.placer.library.bundle_hash,
            source: String::new(),
            source_hash,
            environment: as_toml,
            disabled: report.disabled.iter().map(|(name, count)| (name.clone(), *count)).collect(),
            cells: report.cells,
            transitions: report.transitions,
            motion_hours: report.motion_hours,
        })
    }
}

/// Serializes an environment or its settings as text.
///
/// # Errors
/// [`BuildError::Stage`] for numbers that TOML cannot hold.
pub(in crate::stitch) fn as_toml(value: &impl Serialize) -> Result<String> {
    let why =
        |e| stage_error(STAGE, format!("the world cannot be written as TOML: {e}"), "Give every unit a finite place");
    toml::to_string(value).map_err(why)
}

/// Content hash of all inputs of a stitched world. The bundle contains the units; their meshes are separate files.
///
/// # Errors
/// As [`as_toml`].
pub(in crate::stitch) fn source_hash(environment: &str, config: &StitchConfig, library: &Library<'_>) -> Result<u128> {
    let mut hash = Hash128::default();
    hash.add_bytes(environment.as_bytes());
    hash.add_bytes(as_toml(config)?.as_bytes());
    hash.add_bytes(&library.bundle_hash.to_le_bytes());
    for solid in library.geometries.iter().flat_map(|g| &g.solids) {
        if let UnitSolid::Mesh(triangles) = solid {
            hash.add_bytes(bytemuck::cast_slice(triangles.corners()));
        }
    }
    Ok(hash.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worlds_beyond_what_memory_holds_are_refused() {
        let of = |num: usize, size: [u32; 2]| too_many(vec![size; num].into_iter());
        // A block of 100 by 100 units that hold 5000 cells each is the largest; a pair of links takes a word, too.
        assert_eq!(of(0, [0, 0]), None);
        assert_eq!(of(10_000, [5000, 640_000]), None);
        assert_eq!(of(2, [25_000_000, 2]), None);
        for (num, size, part) in [
            (10_000, [5001, 0], "10000 instances have 50010000 cells with 0 words"),
            (10_000, [1, 640_001], "100010000 words of links, expected 50000000 and 100000000"),
            (3, [u32::MAX; 2], "12884901885 cells"),
        ] {
            let why = of(num, size).unwrap_or_default();
            assert!(why.contains(part), "{why}");
        }
    }
}
