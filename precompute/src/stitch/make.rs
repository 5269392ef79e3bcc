//! Stitching from the first step to the last, all of it or what a change left to do.

use super::allow::allow;
use super::assemble::{Judged, assemble};
use super::joined::Joined;
use super::lay::{Laid, Stitcher};
use super::library::STAGE;
use super::outcome::Counts;
use super::report::{Reason, StitchReport, peak_bytes};
use super::resettle::Before;
use super::same::Same;
use super::settled::{Settled, Standing, settle};
use crate::environment::Environment;
use crate::error::BuildError;
use crate::progress::Progress;
use std::cell::OnceCell;
use std::collections::HashMap;
use std::time::Instant;
use throng_runtime::patch::NONE;
use throng_runtime::world::{WorldData, WorldMeta};

/// A stitched world and all that was found on the way.
pub(super) struct Made<'a> {
    /// Patches in their places.
    pub laid: Laid,
    /// The graph.
    pub joined: Joined<'a>,
    /// What its cells are to the component.
    pub settled: Settled,
    /// The world.
    pub world: WorldData,
    /// What came of it.
    pub report: StitchReport,
}

/// Stitching, in reading order.
///
/// - `before`: what is changed.
///
/// # Errors
/// As [`super::stitch`].
pub(super) fn make<'a>(
    stitcher: &mut Stitcher<'a>,
    environment: &Environment,
    before: Option<&Made<'a>>,
    progress: &dyn Progress,
) -> Result<Made<'a>, BuildError> {
    let begin = Instant::now();
    let laid = stitcher.lay(environment)?;
    let situated = stitcher.prepare(&laid, progress);
    let joined = allow(stitcher, &laid, situated)?;
    progress.begin("component", joined.num_nodes as u64, "cells");
    let before = before.map(|before| Before {
        joined: &before.joined,
        settled: &before.settled,
        same: same(before, &laid, &joined),
    });
    let settled = settle(&joined, before.as_ref()).ok_or_else(|| no_component(stitcher, environment))?;
    progress.end();
    let judged = Judged { joined: &joined, settled: &settled };
    let (mut world, counts) = assemble(stitcher, environment, &laid, &judged);
    check_reached(stitcher, environment, &laid, &judged)?;
    let mut report = report(stitcher, &laid, &world, &counts);
    world.meta = meta(stitcher, environment, &report)?;
    report.seconds = begin.elapsed().as_secs_f64();
    Ok(Made { laid, joined, settled, world, report })
}

/// The number that each instance had before; [`NONE`] for those that are new or have something else around them.
fn same(before: &Made<'_>, laid: &Laid, joined: &Joined<'_>) -> Vec<u32> {
    let key = |laid: &Laid, joined: &Joined<'_>, i: u32| {
        let p = laid.fitted[i as usize].placement;
        (Same::new(joined.situation(i)), [p.x, p.y, p.z, p.heading].map(f32::to_bits))
    };
    let old = |i: u32| key(&before.laid, &before.joined, i);
    let num_before = before.laid.fitted.len() as u32;
    // Most have the number that they had.
    let by_key: OnceCell<HashMap<_, u32>> = OnceCell::new();
    let of = |i: u32| {
        let new = key(laid, joined, i);
        if i < num_before && old(i) == new {
            return i;
        }
        by_key.get_or_init(|| (0..num_before).map(|i| (old(i), i)).collect()).get(&new).copied().unwrap_or(NONE)
    };
    (0..laid.fitted.len() as u32).map(of).collect()
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
