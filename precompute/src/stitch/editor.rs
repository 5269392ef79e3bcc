//! A world that can be changed: what stays as it was is not computed again.

use super::allow::allow;
use super::assemble::{Judged, assemble};
use super::component::Standing;
use super::config::StitchConfig;
use super::joined::Joined;
use super::lay::{Laid, Stitcher};
use super::library::{Library, STAGE};
use super::outcome::Counts;
use super::report::{Reason, StitchReport, peak_bytes};
use super::same::Same;
use super::settled::{Settled, settle};
use crate::environment::{Environment, PlacedUnit};
use crate::error::BuildError;
use crate::progress::{Progress, Silent};
use std::collections::HashMap;
use std::time::Instant;
use throng_runtime::patch::{Patches, Placement};
use throng_runtime::world::{WorldData, WorldMeta};

/// A stitched world and all that was found on the way, so that a change costs little.
///
/// Joint tables and obstacle masks belong to pairs of things that stand to each other in one way: a change makes
/// those of the new pairs only. After every change the world is the one that stitching anew would give.
pub struct Editor<'a> {
    stitcher: Stitcher<'a>,
    environment: Environment,
    pub(super) laid: Laid,
    pub(super) joined: Joined<'a>,
    pub(super) settled: Settled,
    world: WorldData,
    report: StitchReport,
}

impl<'a> Editor<'a> {
    /// Stitches a world.
    ///
    /// # Errors
    /// As [`super::stitch`].
    pub fn new(
        patches: Patches<'a>,
        library: Library<'a>,
        environment: Environment,
        config: &StitchConfig,
        progress: &dyn Progress,
    ) -> Result<Self, BuildError> {
        let mut stitcher = Stitcher::new(patches, library, config)?;
        let made = make(&mut stitcher, &environment, None, progress)?;
        Ok(Self {
            stitcher,
            environment,
            laid: made.laid,
            joined: made.joined,
            settled: made.settled,
            world: made.world,
            report: made.report,
        })
    }

    /// The world as it is.
    pub fn world(&self) -> &WorldData {
        &self.world
    }

    /// The world, when no more changes are made.
    pub fn into_world(self) -> (WorldData, StitchReport) {
        (self.world, self.report)
    }

    /// The environment as it is.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// What came of the last change.
    pub fn report(&self) -> &StitchReport {
        &self.report
    }

    /// Places one more unit, after all others.
    ///
    /// - `unit`: its number in the bundle's set.
    /// - returns the number of the place.
    ///
    /// # Errors
    /// As [`super::stitch`]; the world stays as it was.
    pub fn add(&mut self, unit: usize, placement: Placement) -> Result<usize, BuildError> {
        let mut changed = self.environment.clone();
        changed.units.push(PlacedUnit { unit, placement });
        self.change(changed)?;
        Ok(self.environment.units.len() - 1)
    }

    /// Takes a placed unit away; those after it move up.
    ///
    /// # Errors
    /// As [`super::stitch`], or where there is no such place; the world stays as it was.
    pub fn remove(&mut self, index: usize) -> Result<(), BuildError> {
        self.check_place(index)?;
        let mut changed = self.environment.clone();
        changed.units.remove(index);
        self.change(changed)
    }

    /// Moves a placed unit.
    ///
    /// # Errors
    /// As [`super::stitch`], or where there is no such place; the world stays as it was.
    pub fn drag(&mut self, index: usize, placement: Placement) -> Result<(), BuildError> {
        self.check_place(index)?;
        let mut changed = self.environment.clone();
        changed.units[index].placement = placement;
        self.change(changed)
    }

    fn check_place(&self, index: usize) -> Result<(), BuildError> {
        if index < self.environment.units.len() {
            return Ok(());
        }
        Err(BuildError::Stage {
            stage: STAGE,
            message: format!(
                "environment {}: there is no place {index}, expected one below {}",
                self.environment.name,
                self.environment.units.len()
            ),
            help: "Name a unit that is there".into(),
        })
    }

    fn change(&mut self, environment: Environment) -> Result<(), BuildError> {
        let before = (&self.laid, &self.joined, &self.settled);
        let made = make(&mut self.stitcher, &environment, Some(before), &Silent)?;
        self.environment = environment;
        self.laid = made.laid;
        self.joined = made.joined;
        self.settled = made.settled;
        self.world = made.world;
        self.report = made.report;
        Ok(())
    }

    pub(super) fn stitcher(&self) -> &Stitcher<'a> {
        &self.stitcher
    }
}

struct Made<'a> {
    laid: Laid,
    joined: Joined<'a>,
    settled: Settled,
    world: WorldData,
    report: StitchReport,
}

/// Stitching, in reading order.
///
/// - `before`: what is changed.
fn make<'a>(
    stitcher: &mut Stitcher<'a>,
    environment: &Environment,
    before: Option<(&Laid, &Joined<'a>, &Settled)>,
    progress: &dyn Progress,
) -> Result<Made<'a>, BuildError> {
    let begin = Instant::now();
    let laid = stitcher.lay(environment)?;
    let situated = stitcher.prepare(&laid, progress);
    let joined = allow(stitcher, &laid, situated)?;
    progress.begin("component", joined.num_nodes as u64, "cells");
    let likely = before.and_then(|before| likely(before, &laid, &joined));
    let settled = settle(&joined, likely).ok_or_else(|| no_component(stitcher, environment))?;
    progress.end();
    let judged = Judged { joined: &joined, settled: &settled };
    let (mut world, counts) = assemble(stitcher, environment, &laid, &judged);
    check_reached(stitcher, environment, &laid, &judged)?;
    let mut report = report(stitcher, &laid, &world, &counts);
    world.meta = meta(stitcher, environment, &report)?;
    report.seconds = begin.elapsed().as_secs_f64();
    Ok(Made { laid, joined, settled, world, report })
}

/// A cell that belonged to the component, of an instance that is still there among the same units.
fn likely(before: (&Laid, &Joined<'_>, &Settled), laid: &Laid, joined: &Joined<'_>) -> Option<(u32, u32)> {
    let (laid_before, joined_before, settled) = before;
    let key = |laid: &Laid, joined: &Joined<'_>, i: u32| {
        let p = laid.fitted[i as usize].placement;
        (Same::new(joined.situation(i)), [p.x, p.y, p.z, p.heading].map(f32::to_bits))
    };
    let now: HashMap<_, u32> = (0..laid.fitted.len() as u32).map(|i| (key(laid, joined, i), i)).collect();
    (0..laid_before.fitted.len() as u32).find_map(|i| {
        let same = *now.get(&key(laid_before, joined_before, i))?;
        settled.first_inside(joined_before, i).map(|cell| (same, cell))
    })
}

fn no_component(stitcher: &Stitcher<'_>, environment: &Environment) -> BuildError {
    BuildError::Stage {
        stage: STAGE,
        message: format!(
            "environment {}: no motion leads on for ever in any of the blocks of bundle {} that fit it",
            environment.name, stitcher.library.bundle
        ),
        help: "Place more units, so that ways through them lead back to where they began".into(),
    }
}

/// Every unit that is more than an obstacle must belong to an instance of which something is left.
fn check_reached(
    stitcher: &Stitcher<'_>,
    environment: &Environment,
    laid: &Laid,
    judged: &Judged<'_, '_>,
) -> Result<(), BuildError> {
    if stitcher.config.allow_unreachable {
        return Ok(());
    }
    let has = |i: usize, what: Standing| judged.settled.has(judged.joined, i as u32, what);
    let mut reached = vec![false; environment.units.len()];
    for (i, f) in laid.fitted.iter().enumerate() {
        if has(i, Standing::Inside) {
            f.units.iter().for_each(|&u| reached[u as usize] = true);
        }
    }
    let left: Vec<usize> =
        (0..reached.len()).filter(|&u| !reached[u] && !stitcher.is_obstacle(environment, u)).collect();
    let Some(&unit) = left.first() else { return Ok(()) };
    let here = || laid.fitted.iter().enumerate().filter(|(_, f)| f.units.contains(&(unit as u32)));
    let leads_away = here().any(|(i, _)| has(i, Standing::Unreached));
    let patches: Vec<&str> = here().map(|(_, f)| stitcher.library.names[f.patch as usize].name.as_str()).collect();
    let what = if leads_away { "no character can get there" } else { "no way leads out of it" };
    let more = if left.len() > 1 { format!(", as of {} more units", left.len() - 1) } else { String::new() };
    Err(BuildError::Stage {
        stage: STAGE,
        message: format!(
            "environment {}: {}: {what}{more} (blocks: {})",
            environment.name,
            stitcher.library.describe(environment, unit),
            patches.join(", ")
        ),
        help: "Connect it, take what is in the way away, or set `allow_unreachable` under [stitch]".into(),
    })
}

fn report(stitcher: &Stitcher<'_>, laid: &Laid, world: &WorldData, counts: &Counts) -> StitchReport {
    let mut report = StitchReport {
        instances: laid.fitted.len(),
        cells: counts.cells,
        transitions: counts.links + counts.joints,
        motion_hours: counts.frames as f64 / stitcher.library.rate_hz / 3600.0,
        disabled: Reason::ALL.iter().map(|&r| (r.name().to_owned(), counts.disabled[r as usize])).collect(),
        tables: world.tables.len(),
        joints: world.joints.len(),
        peak_bytes: peak_bytes(),
        ..StitchReport::default()
    };
    for f in &laid.fitted {
        *report.patches.entry(stitcher.library.names[f.patch as usize].name.clone()).or_default() += 1;
    }
    report
}

fn meta(stitcher: &Stitcher<'_>, environment: &Environment, report: &StitchReport) -> Result<WorldMeta, BuildError> {
    let as_toml = toml::to_string(environment).map_err(|e| BuildError::Stage {
        stage: STAGE,
        message: format!("environment {} cannot be written as TOML: {e}", environment.name),
        help: "Give every unit a finite place".into(),
    })?;
    Ok(WorldMeta {
        name: environment.name.clone(),
        generator: concat!("throng ", env!("CARGO_PKG_VERSION")).to_owned(),
        bundle: stitcher.library.bundle.to_owned(),
        fingerprint: stitcher.library.fingerprint,
        environment: as_toml,
        disabled: report.disabled.iter().map(|(name, count)| (name.clone(), *count)).collect(),
        cells: report.cells,
        transitions: report.transitions,
        motion_hours: report.motion_hours,
    })
}
