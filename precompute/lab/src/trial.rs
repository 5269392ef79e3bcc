//! Trial of a bundle: characters chase targets of their own and are measured.

mod watch;

use crate::{made::MadeFigures, quality::MotionQuality};
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::{collections::HashMap, f32::consts::TAU, time::Instant};
use throng_core::base::limits::{CHARACTERS, SECONDS, STEP_HZ};
use throng_core::characters::{AvoidConfig, CharactersConfig, PolicyCharacters, PolicyOrder, Spawn};
use throng_core::{Bundle, CharacterGroup, Contacts, Error, Inline, NUM_JOINTS, Planar, stops::REST};
use throng_motion::error::{BuildError, Result};
use watch::TrialWatch;

/// Settings of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialConfig {
    /// Number of characters.
    pub characters: usize,
    /// Simulated time (s).
    pub seconds: f32,
    /// Steps a simulated second (Hz).
    pub step_hz: f32,
    /// Seed of places, targets and choices.
    pub seed: u64,
    /// Least and greatest distance of a target at the start (m).
    pub distances: [f32; 2],
    /// True for targets to the left and right in turn, so that two streams walk through each other; false for any direction.
    pub streams: bool,
    /// Distance within which a target counts as reached (m).
    pub reach_m: f32,
    /// Time at which the crowd is drawn, while many are still on their way (s).
    pub snapshot_s: f32,
    /// Character whose poses are recorded, if any (< characters).
    pub recorded: Option<usize>,
    /// Settings of the characters' motion.
    pub motion: CharactersConfig,
}

impl Default for TrialConfig {
    fn default() -> Self {
        Self {
            characters: 1000,
            seconds: 20.0,
            step_hz: 60.0,
            seed: 1,
            distances: [2.0, 6.0],
            streams: false,
            reach_m: 0.5,
            snapshot_s: 3.5,
            recorded: Some(0),
            motion: CharactersConfig {
                avoid: Some(AvoidConfig::default()),
                carriage: 1.0,
                ..CharactersConfig::default()
            },
        }
    }
}

/// Results of a trial.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct TrialReport {
    /// Number of characters.
    pub characters: usize,
    /// Simulated time (s).
    pub simulated_s: f32,
    /// True if characters avoid each other.
    pub avoiding: bool,
    /// Share of the characters that came within reach of their target.
    pub reached_fraction: f64,
    /// Share of the characters within one and a half reaches at the end.
    pub stayed_fraction: f64,
    /// Mean time to reach the target, of characters that did; none where none did (s).
    pub mean_arrival_s: Option<f64>,
    /// Distance to the target at the end, mean over all characters (m).
    pub mean_final_distance_m: f64,
    /// Share that came within reach, by the distance of the target at the start.
    pub reached_by_distance: Vec<ReachShare>,
    /// Share that came within reach, by the direction of the target at the start in the character's frame.
    pub reached_by_direction: Vec<ReachShare>,
    /// Longest time from one choice of a character to its next, in which it does not react (s).
    pub longest_wait_s: f64,
    /// Share that stands still, of the characters near their targets at the end.
    pub standing_fraction: f64,
    /// Pairs of characters that overlapped at any time: discs of 0.25 m around their roots, or trunks and heads.
    pub character_overlaps: usize,
    /// Deepest overlap of any pair (m).
    pub deepest_overlap_m: f64,
    /// Share of the time on the way in which characters stood.
    pub stopped_share: f64,
    /// Mean speed of planted heels and toes (m/s).
    pub foot_slip_mean_mps: f64,
    /// 95th percentile of the speed of planted heels and toes (m/s).
    pub foot_slip_p95_mps: f64,
    /// Made motion, if there is some.
    pub made: Option<MadeFigures>,
    /// Quality of the motion beside that of the clips, over the first 10 000 steps of 50 characters.
    #[serde(flatten)]
    pub quality: MotionQuality,
    /// Steps of all characters a second of wall time, control and poses included, on one thread.
    pub steps_per_second: f64,
    /// Poses made a second of wall time.
    pub poses_per_second: f64,
    /// Choices made a second of wall time.
    pub choices_per_second: f64,
}

/// Share of a group of characters that reached their targets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ReachShare {
    /// Common property of their targets, such as `2 to 3 m` or `behind`.
    pub targets: String,
    /// Number of the characters.
    pub characters: usize,
    /// Share of them that came within reach.
    pub reached_fraction: f64,
}

/// Record of a trial, for pictures.
#[derive(Clone, Debug, Default)]
pub struct TrialRecord {
    /// The crowd on its way, halfway from there to the end, and at the end.
    pub moments: Vec<TrialMoment>,
    /// Trail of each character until the first of them, five positions a second (m).
    pub trails: Vec<Vec<Vec2>>,
    /// Targets (m).
    pub targets: Vec<Vec3>,
    /// Time at which each target was reached; infinite if it was not (s).
    pub arrivals_s: Vec<f32>,
    /// Frames of the recorded character, one for each of the first 10 000 steps.
    pub frames: Vec<TrialFrame>,
}

/// The crowd at a moment.
#[derive(Clone, Debug, Default)]
pub struct TrialMoment {
    /// (s)
    pub time_s: f32,
    /// World positions of all joints of each character (m).
    pub poses: Vec<[Vec3; NUM_JOINTS]>,
}

/// The recorded character at one step.
#[derive(Clone, Copy, Debug)]
pub struct TrialFrame {
    /// (s)
    pub time_s: f32,
    /// Planar root.
    pub root: Planar,
    /// World positions of all joints (m).
    pub positions: [Vec3; NUM_JOINTS],
    /// Planted parts of the feet.
    pub contacts: Contacts,
}

/// Runs a trial of the first behaviour of a bundle.
///
/// # Errors
/// [`BuildError::Stage`] where the bundle has no behaviour or the config is out of range.
pub fn run(tables: &Bundle, config: &TrialConfig) -> Result<(TrialReport, TrialRecord)> {
    let fail = |e: Error| stage_error(e.to_string());
    check(tables, config)?;
    let (mut group, targets) = scatter_characters(tables, config).map_err(fail)?;
    let mut watch = TrialWatch::new(config, tables, group.bodies().roots.to_vec(), targets);
    let dt = 1.0 / config.step_hz;
    let busy_s = play(&mut group, config, |group, step| {
        watch.observe(group, config, step, dt);
        Ok(())
    })?;
    let characters = group.characters();
    Ok(watch.finish(characters, config, busy_s))
}

/// Number of steps of a trial.
pub(crate) fn num_steps(config: &TrialConfig) -> usize {
    (config.seconds * config.step_hz).round().max(1.0) as usize
}

/// Steps characters through a trial; calls `look` after the first choice and after every step.
///
/// - returns the wall time of the steps (s).
///
/// # Errors
/// As [`run`], and errors of `look`.
pub(crate) fn play(
    group: &mut PolicyCharacters,
    config: &TrialConfig,
    mut observe: impl FnMut(&PolicyCharacters, usize) -> Result<()>,
) -> Result<f64> {
    let mut busy_s = 0.0;
    for step in 0..=num_steps(config) {
        let begin = Instant::now();
        // The first step only makes the first choice.
        let dt = if step == 0 { 0.0 } else { 1.0 / config.step_hz };
        group.step(dt, &Inline).map_err(|e| stage_error(e.to_string()))?;
        busy_s += begin.elapsed().as_secs_f64();
        observe(group, step)?;
    }
    Ok(busy_s)
}

/// Checks that a bundle and a config allow a trial.
///
/// # Errors
/// As [`run`].
pub(crate) fn check(tables: &Bundle, config: &TrialConfig) -> Result<()> {
    let fail = |e: Error| stage_error(e.to_string());
    if tables.policies().is_empty() {
        let message = "the bundle has no behaviour".into();
        let help = "Build it of motion in which somebody walks, or from a config with `behaviours`; `throng view` shows its clips".into();
        return Err(BuildError::Stage { stage: "trial", message, help });
    }
    CHARACTERS.check_count("characters", config.characters).map_err(fail)?;
    SECONDS.check("seconds", None, config.seconds).map_err(fail)?;
    STEP_HZ.check("step_hz", None, config.step_hz).map_err(fail)?;
    let n = config.characters;
    match config.recorded.filter(|&c| c >= n) {
        Some(c) => Err(stage_error(format!("expected one of the {n} characters to follow, counted from 0, found {c}"))),
        None => Ok(()),
    }
}

fn stage_error(message: String) -> BuildError {
    BuildError::Stage { stage: "trial", message, help: "`throng run --help` lists what may be given".into() }
}

/// Characters and their targets (m).
type Scattered = Result<(PolicyCharacters, Vec<Vec3>), Error>;

/// Places characters on a loose grid, each with a target in some direction; targets are apart if there is room. Characters
/// that avoid each other start in a standing state, if there is one.
pub(crate) fn scatter_characters(tables: &Bundle, config: &TrialConfig) -> Scattered {
    scatter_from(tables, config, SPACING_M)
}

/// Like [`scatter_characters`], with an initial distance between neighbours (m), which grows as necessary.
fn scatter_from(tables: &Bundle, config: &TrialConfig, mut spacing_m: f32) -> Scattered {
    loop {
        match scatter_apart(tables, config, spacing_m) {
            // Motion that takes long to stop needs more room.
            Err(Error::Occupied { .. }) if spacing_m < MOST_SPACING_M => {
                spacing_m = (1.5 * spacing_m).min(MOST_SPACING_M);
            }
            done => return done,
        }
    }
}

/// Like [`scatter_characters`], with a fixed distance between neighbours (m).
fn scatter_apart(tables: &Bundle, config: &TrialConfig, spacing_m: f32) -> Scattered {
    let mut rng = Pcg64Mcg::seed_from_u64(config.seed);
    let states = start_states(tables, &config.motion);
    let side = (config.characters as f32).sqrt().ceil() as usize;
    let middle = (side as f32 - 1.0) * 0.5;
    let [near, far] = config.distances;
    let mut group = PolicyCharacters::with_capacity(tables, config.characters, config.motion)?;
    group.hold_entrants();
    let (mut targets, mut taken) = (Vec::new(), HashMap::new());
    for i in 0..config.characters {
        let place = |k: usize| (k as f32 - middle) * spacing_m;
        let (x, z) = (place(i % side), place(i / side));
        let mut jitter = || rng.random_range(-JITTER_M..JITTER_M);
        let (x, z) = (x + jitter(), z + jitter());
        let ahead = if rng.random_range(0..2) == 0 { 0.25 * TAU } else { 0.75 * TAU };
        let root = Planar::new(x, z, if config.streams { ahead } else { rng.random_range(0.0..TAU) });
        let mut draw = || {
            let angle = if config.streams { ahead + rng.random_range(-0.1..0.1) } else { rng.random_range(0.0..TAU) };
            let distance = near + (far - near) * rng.random_range(0.0..1.0f32);
            Vec2::new(x + distance * angle.sin(), z + distance * angle.cos())
        };
        let is_free =
            |p: &Vec2| cells_around(*p).all(|c| taken.get(&c).is_none_or(|o: &Vec2| o.distance(*p) >= APART_M));
        let target = (0..TRIES).map(|_| draw()).find(is_free).unwrap_or_else(&mut draw);
        taken.insert(target_cell(target), target);
        let state = Some(states[rng.random_range(0..states.len())]);
        let id = group.spawn(Spawn { root, state, floor_m: 0.0 })?;
        let target = Vec3::new(target.x, 0.0, target.y);
        group.order(id, PolicyOrder::towards(0, target))?;
        targets.push(target);
    }
    group.release_entrants();
    Ok((group, targets))
}

/// Start states: for characters that avoid each other, the upright standing ones, if there are any.
pub fn start_states(tables: &Bundle, motion: &CharactersConfig) -> Vec<u32> {
    let all = 0..tables.graph().states.len() as u32;
    let radius = |s: u32| tables.stops().stops[s as usize].radius;
    let rests: Vec<u32> = all.clone().filter(|&s| tables.stops().stops[s as usize].kind == REST).collect();
    let least = rests.iter().map(|&s| radius(s)).fold(f32::INFINITY, f32::min);
    match motion.avoid.is_some() && !rests.is_empty() {
        true => rests.into_iter().filter(|&s| radius(s) < least + 0.03).collect(),
        false => all.collect(),
    }
}

/// Initial and greatest distance of neighbours on the grid of starts, and largest offset from the grid along an axis (m).
const SPACING_M: f32 = 2.0;
const MOST_SPACING_M: f32 = 20.0;
const JITTER_M: f32 = 0.6;
/// Least distance between targets (m).
const APART_M: f32 = 0.8;
/// Number of draws before a target is accepted as it is.
const TRIES: usize = 20;

/// Cell of a grid whose cells hold one target at most.
fn target_cell(p: Vec2) -> [i32; 2] {
    (p * (std::f32::consts::SQRT_2 / APART_M)).floor().to_array().map(|v| v as i32)
}

/// Cells whose targets may be too near to a place.
fn cells_around(p: Vec2) -> impl Iterator<Item = [i32; 2]> {
    let [x, z] = target_cell(p);
    (-2..=2).flat_map(move |dx| (-2..=2).map(move |dz| [x + dx, z + dz]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::characters::made_up;
    use throng_core::format::AlignedBytes;

    #[test]
    fn characters_without_room_begin_farther_from_each_other() {
        let tables = Bundle::from_bytes(AlignedBytes::from_slice(&made_up::bytes(&[], false))).expect("tables");
        let config = TrialConfig { characters: 60, ..TrialConfig::default() };
        let refused = scatter_apart(&tables, &config, 0.4).map(|_| ());
        assert!(matches!(refused, Err(Error::Occupied { .. })), "{refused:?}");
        let (group, targets) = scatter_from(&tables, &config, 0.4).expect("room");
        assert_eq!((group.ids().len(), targets.len()), (60, 60));
        // Other errors are reported.
        let wrong = TrialConfig { distances: [f32::NAN; 2], ..config };
        assert!(!matches!(scatter_from(&tables, &wrong, 0.4), Ok(_) | Err(Error::Occupied { .. })));
    }
}
