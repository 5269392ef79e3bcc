//! A trial of a bundle: characters chase targets of their own, and what they do is measured.

use crate::overlap::{OverlapMeter, Present};
use crate::quality::{self, MotionQuality, QualityMeter, Track};
use crate::slip::SlipMeter;
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::collections::HashMap;
use std::f32::consts::TAU;
use std::time::Instant;
use throng_motion::error::BuildError;
use throng_runtime::base::limits::{CHARACTERS, SECONDS, STEP_HZ};
use throng_runtime::characters::{AvoidConfig, Characters, CharactersConfig, Order, PolicyCharacters, Spawn};
use throng_runtime::stops::REST;
use throng_runtime::{Body, Bundle, Cast, Contacts, Error, Inline, NUM_JOINTS, Planar};

/// What is tried.
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
    /// Nearest and farthest a target stands at the start (m).
    pub distances: [f32; 2],
    /// Targets stand to the left and to the right by turns, so that two streams walk through each other; otherwise in any
    /// direction.
    pub streams: bool,
    /// A target counts as reached within this distance (m).
    pub reach_m: f32,
    /// When the crowd is drawn: while many are still on their way (s).
    pub snapshot_s: f32,
    /// Character whose poses are recorded, if any (< characters).
    pub recorded: Option<usize>,
    /// How characters move.
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
            motion: CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() },
        }
    }
}

/// What a trial measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct TrialReport {
    /// Number of characters.
    pub characters: usize,
    /// Simulated time (s).
    pub simulated_s: f32,
    /// Share of the characters that came within reach of their target.
    pub reached_fraction: f64,
    /// Share of the characters within one and a half reaches at the end.
    pub stayed_fraction: f64,
    /// Mean time to reach the target, of characters that did; none where none did (s).
    pub mean_arrival_s: Option<f64>,
    /// Distance to the target at the end, mean over all characters (m).
    pub mean_final_distance_m: f64,
    /// The same share by how far the target stood at the start.
    pub reached_by_distance: Vec<Share>,
    /// The same share by where the target stood at the start, as the character saw it.
    pub reached_by_direction: Vec<Share>,
    /// Longest time from one choice of a character to its next: so long it heeds nothing (s).
    pub longest_wait_s: f64,
    /// Share of the characters near their targets at the end that stand still there.
    pub standing_fraction: f64,
    /// Pairs of characters that were in each other at any time: discs of 0.25 m about their roots, or trunks and heads.
    pub character_overlaps: usize,
    /// How deep the two who were most in each other were (m).
    pub deepest_overlap_m: f64,
    /// Share of the time on the way that characters stood.
    pub stopped_share: f64,
    /// Mean speed of planted heels and toes (m/s).
    pub foot_slip_mean_mps: f64,
    /// 95th percentile of the speed of planted heels and toes (m/s).
    pub foot_slip_p95_mps: f64,
    /// The motion beside that of the clips.
    #[serde(flatten)]
    pub quality: MotionQuality,
    /// Steps of all characters a second of wall time, control and poses included, on one thread.
    pub steps_per_second: f64,
    /// Poses made a second of wall time.
    pub poses_per_second: f64,
    /// Choices made a second of wall time.
    pub choices_per_second: f64,
}

/// How many of some characters reached their targets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Share {
    /// What their targets have in common, such as `2 to 3 m` or `behind`.
    pub targets: String,
    /// Number of the characters.
    pub characters: usize,
    /// Share of them that came within reach.
    pub reached_fraction: f64,
}

/// What a trial leaves to be drawn.
#[derive(Clone, Debug, Default)]
pub struct TrialRecord {
    /// Time at which the crowd was recorded (s).
    pub snapshot_s: f32,
    /// Planar roots then.
    pub roots: Vec<Planar>,
    /// Where each character had been by then, five times a second (m).
    pub trails: Vec<Vec<Vec2>>,
    /// Targets (m).
    pub targets: Vec<Vec3>,
    /// When each target was reached; infinite where it was not (s).
    pub arrivals_s: Vec<f32>,
    /// World positions of all joints of each character then (m).
    pub poses: Vec<[Vec3; NUM_JOINTS]>,
    /// The recorded character, every step.
    pub frames: Vec<TrialFrame>,
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
    /// Segment that is played.
    pub segment: u32,
}

/// Runs a trial of the first behaviour of a bundle.
///
/// # Errors
/// [`BuildError::Stage`] where the bundle has no behaviour or the config is out of range.
pub fn run(tables: &Bundle, config: &TrialConfig) -> Result<(TrialReport, TrialRecord), BuildError> {
    let fail = |e: Error| stage_error(e.to_string());
    check(tables, config)?;
    let (mut cast, targets) = scatter(tables, config).map_err(fail)?;
    let mut watch = Watch::new(config, tables, cast.bodies().roots.to_vec(), targets);
    let dt = 1.0 / config.step_hz;
    let busy_s = play(&mut cast, config, |cast, step| {
        watch.observe(cast, config, step, dt);
        Ok(())
    })?;
    let characters = cast.characters();
    Ok(watch.finish(characters, config, num_steps(config), busy_s))
}

/// Steps of a trial.
pub(crate) fn num_steps(config: &TrialConfig) -> usize {
    (config.seconds * config.step_hz).round().max(1.0) as usize
}

/// Steps characters through a trial, and shows them after the first choice and after every step.
///
/// - returns the time that steps took (s).
///
/// # Errors
/// As [`run`], and what `look` fails with.
pub(crate) fn play(
    cast: &mut PolicyCharacters,
    config: &TrialConfig,
    mut look: impl FnMut(&PolicyCharacters, usize) -> Result<(), BuildError>,
) -> Result<f64, BuildError> {
    let mut busy_s = 0.0;
    for step in 0..=num_steps(config) {
        let begin = Instant::now();
        // The first step only takes the first choice.
        let dt = if step == 0 { 0.0 } else { 1.0 / config.step_hz };
        cast.step(dt, &Inline).map_err(|e| stage_error(e.to_string()))?;
        busy_s += begin.elapsed().as_secs_f64();
        look(cast, step)?;
    }
    Ok(busy_s)
}

/// Checks that a bundle can be tried this way.
///
/// # Errors
/// As [`run`].
pub(crate) fn check(tables: &Bundle, config: &TrialConfig) -> Result<(), BuildError> {
    let fail = |e: Error| stage_error(e.to_string());
    if tables.policies().is_empty() {
        let message = "the bundle has no behaviour".into();
        let help = "Build it from a config with `behaviours`".into();
        return Err(BuildError::Stage { stage: "trial", message, help });
    }
    CHARACTERS.check_count("characters", config.characters).map_err(fail)?;
    SECONDS.check("seconds", None, config.seconds).map_err(fail)?;
    STEP_HZ.check("step_hz", None, config.step_hz).map_err(fail)?;
    if let Some(recorded) = config.recorded.filter(|&c| c >= config.characters) {
        return Err(stage_error(format!(
            "expected one of the {} characters to follow, counted from 0, found {}",
            config.characters, recorded
        )));
    }
    Ok(())
}

fn stage_error(message: String) -> BuildError {
    BuildError::Stage { stage: "trial", message, help: "`throng run --help` lists what may be given".into() }
}

/// Characters on a loose grid, each with a target in some direction; targets are apart where there is room. Those who make
/// way start where somebody stands, if anybody does.
pub(crate) fn scatter(tables: &Bundle, config: &TrialConfig) -> Result<(PolicyCharacters, Vec<Vec3>), Error> {
    let mut rng = Pcg64Mcg::seed_from_u64(config.seed);
    let states = starts(tables, &config.motion);
    let side = (config.characters as f32).sqrt().ceil() as usize;
    let middle = (side as f32 - 1.0) * 0.5;
    let [near, far] = config.distances;
    let mut cast = PolicyCharacters::with_capacity(tables, config.characters, config.motion)?;
    cast.gather();
    let (mut targets, mut taken) = (Vec::new(), HashMap::new());
    for i in 0..config.characters {
        let place = |k: usize| (k as f32 - middle) * SPACING_M;
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
        let is_free = |p: &Vec2| around(*p).all(|c| taken.get(&c).is_none_or(|o: &Vec2| o.distance(*p) >= APART_M));
        let target = (0..TRIES).map(|_| draw()).find(is_free).unwrap_or_else(&mut draw);
        taken.insert(cell(target), target);
        let state = Some(states[rng.random_range(0..states.len())]);
        let id = cast.spawn(Spawn { root, state })?;
        let target = Vec3::new(target.x, 0.0, target.y);
        cast.order(id, Order::aim(0, target))?;
        targets.push(target);
    }
    cast.settle();
    Ok((cast, targets))
}

/// States to start in: of those who make way, the ones in which somebody stands upright, where there are any.
pub fn starts(tables: &Bundle, motion: &CharactersConfig) -> Vec<u32> {
    let all = 0..tables.graph().states.len() as u32;
    let radius = |s: u32| tables.stops().stops[s as usize].radius;
    let rests: Vec<u32> = all.clone().filter(|&s| tables.stops().stops[s as usize].kind == REST).collect();
    let least = rests.iter().map(|&s| radius(s)).fold(f32::INFINITY, f32::min);
    match motion.avoid.is_some() && !rests.is_empty() {
        true => rests.into_iter().filter(|&s| radius(s) < least + 0.03).collect(),
        false => all.collect(),
    }
}

/// Distance of neighbours on the grid of starts, and how far each is from its place along an axis (m).
const SPACING_M: f32 = 2.0;
const JITTER_M: f32 = 0.6;
/// Targets are this far apart (m).
const APART_M: f32 = 0.8;
/// Targets that are drawn before one is taken as it is.
const TRIES: usize = 20;

/// Cells that hold one target at most.
fn cell(p: Vec2) -> [i32; 2] {
    (p * (std::f32::consts::SQRT_2 / APART_M)).floor().to_array().map(|v| v as i32)
}

/// Cells in which a target is that is too near to a place.
fn around(p: Vec2) -> impl Iterator<Item = [i32; 2]> {
    let [x, z] = cell(p);
    (-2..=2).flat_map(move |dx| (-2..=2).map(move |dz| [x + dx, z + dz]))
}

/// Who moves less than this over [`STILL_S`] stands (m).
const STILL_M: f32 = 0.15;
/// (s)
const STILL_S: f32 = 1.0;
/// Who is slower does not walk (m/s).
const STANDING_MPS: f32 = 0.1;
/// Characters whose motion is compared with the clips.
const TRACKED: usize = 50;
/// Groups of targets by their distance.
const RINGS: usize = 4;

fn place(root: Planar) -> Vec2 {
    Vec2::new(root.x, root.z)
}

/// Shares by distance at the start, from the nearest on.
fn by_distance(config: &TrialConfig, all: impl Iterator<Item = (f32, bool)> + Clone) -> Vec<Share> {
    let [near, far] = config.distances;
    let step = (far - near) / RINGS as f32;
    let ring = |distance: f32| (((distance - near) / step) as usize).min(RINGS - 1);
    let share = |k: usize| {
        let [low, high] = [k, k + 1].map(|k| near + step * k as f32);
        share(format!("{low:.0} to {high:.0} m"), all.clone().filter(|a| ring(a.0) == k).map(|a| a.1))
    };
    (0..RINGS).map(share).collect()
}

/// Shares by direction at the start, a quarter of the circle each.
fn by_direction(all: impl Iterator<Item = (Vec2, bool)> + Clone) -> Vec<Share> {
    let quarter = |p: Vec2| match (p.x.abs() > p.y.abs(), p.x > 0.0, p.y > 0.0) {
        (false, _, true) => 0,
        (true, true, _) => 1,
        (true, false, _) => 2,
        (false, _, false) => 3,
    };
    let names = ["ahead", "to the left", "to the right", "behind"].into_iter().enumerate();
    let of = |k: usize| all.clone().filter(move |a| quarter(a.0) == k).map(|a| a.1);
    names.map(|(k, name)| share(name.into(), of(k))).collect()
}

fn share(targets: String, reached: impl Iterator<Item = bool>) -> Share {
    let (characters, arrived) = reached.fold((0, 0), |(n, r), yes| (n + 1, r + usize::from(yes)));
    Share { targets, characters, reached_fraction: arrived as f64 / characters.max(1) as f64 }
}

/// Looks at characters after every step.
struct Watch<'a> {
    tables: &'a Bundle,
    record: TrialRecord,
    slip: SlipMeter,
    /// Roots at the start.
    starts: Vec<Planar>,
    /// Of each character, the number of its choices and when it made the last one (s).
    choices: Vec<(u32, f32)>,
    overlaps: OverlapMeter,
    present: Vec<Present>,
    /// Roots at the last step.
    before: Vec<Planar>,
    /// Steps of all characters on the way, and those in which they stood.
    on_the_way: [u64; 2],
    longest_wait_s: f32,
    /// Of the first [`TRACKED`] characters.
    tracks: Vec<Track>,
    segments: Vec<u32>,
    /// Where each character was [`STILL_S`] before the end (m).
    late: Vec<Vec2>,
}

impl<'a> Watch<'a> {
    fn new(config: &TrialConfig, tables: &'a Bundle, starts: Vec<Planar>, targets: Vec<Vec3>) -> Self {
        let n = config.characters;
        let record = TrialRecord {
            trails: vec![Vec::new(); n],
            arrivals_s: vec![f32::INFINITY; n],
            targets,
            ..TrialRecord::default()
        };
        let choices = vec![(0, 0.0); n];
        Self {
            tables,
            record,
            slip: SlipMeter::new(n),
            before: starts.clone(),
            starts,
            choices,
            overlaps: OverlapMeter::default(),
            present: Vec::with_capacity(n),
            on_the_way: [0; 2],
            longest_wait_s: 0.0,
            tracks: vec![Track::default(); n.min(TRACKED)],
            segments: vec![u32::MAX; n.min(TRACKED)],
            late: Vec::new(),
        }
    }

    fn observe(&mut self, cast: &PolicyCharacters, config: &TrialConfig, step: usize, dt: f32) {
        let (characters, bodies) = (cast.characters(), cast.bodies());
        self.present.clear();
        let one = |c: usize| {
            Present::with_body(c, &Body { root: bodies.roots[c], model: &bodies.model[c] }, self.tables.skeleton())
        };
        self.present.extend((0..config.characters).map(one));
        self.overlaps.observe(&self.present);
        let time_s = step as f32 * dt;
        if time_s <= config.snapshot_s.min(config.seconds) + 0.5 * dt {
            self.follow(characters, config, step, time_s, dt);
        }
        if self.late.is_empty() && time_s >= config.seconds - STILL_S {
            self.late = (0..config.characters).map(|c| place(characters.root(c))).collect();
        }
        for c in 0..config.characters {
            let (count, since_s) = self.choices[c];
            self.longest_wait_s = self.longest_wait_s.max(time_s - since_s);
            // Who is held looks for a way again and again.
            let chosen = characters.num_choices(c).wrapping_add(characters.blocked(c));
            if chosen != count {
                self.choices[c] = (chosen, time_s);
            }
            let root = characters.root(c);
            if self.record.arrivals_s[c].is_infinite() {
                let stands = place(root).distance(place(self.before[c])) < STANDING_MPS * dt;
                self.on_the_way[0] += 1;
                self.on_the_way[1] += u64::from(stands && step > 0);
            }
            self.before[c] = root;
            let target = self.record.targets[c];
            let distance = (root.x - target.x).hypot(root.z - target.z);
            if distance < config.reach_m {
                self.record.arrivals_s[c] = self.record.arrivals_s[c].min(time_s);
            }
        }
        self.slip.observe_characters(characters, dt);
        self.track(characters);
        let Some(c) = config.recorded else { return };
        self.record.frames.push(TrialFrame {
            time_s,
            root: characters.root(c),
            positions: characters.joint_positions(c),
            contacts: characters.contacts(c),
            segment: characters.segment(c).0,
        });
    }

    /// Adds a sample to each track of who is still on the way.
    fn track(&mut self, characters: &Characters) {
        let segments = &self.tables.graph().segments;
        for (c, (track, last)) in self.tracks.iter_mut().zip(&mut self.segments).enumerate() {
            let now = characters.segment(c).0;
            let of = |s: u32| segments.get(s as usize);
            let goes_on = of(*last).zip(of(now)).is_none_or(|(a, b)| a.start + a.num_frames == b.start);
            if now != *last && !goes_on {
                track.changes.push(track.positions.len());
            }
            *last = now;
            if self.record.arrivals_s[c].is_infinite() {
                track.positions.push(characters.joint_positions(c));
            }
        }
    }

    /// Grows the trails up to the snapshot, and takes it.
    fn follow(&mut self, characters: &Characters, config: &TrialConfig, step: usize, time_s: f32, dt: f32) {
        let trail_every = (config.step_hz / 5.0).round().max(1.0) as usize;
        let (n, r) = (config.characters, &mut self.record);
        let is_last = time_s + dt > config.snapshot_s.min(config.seconds) + 0.5 * dt;
        if is_last || step.is_multiple_of(trail_every) {
            r.roots = (0..n).map(|c| characters.root(c)).collect();
            r.trails.iter_mut().zip(&r.roots).for_each(|(t, p)| t.push(Vec2::new(p.x, p.z)));
        }
        if is_last {
            r.snapshot_s = time_s;
            r.poses = (0..n).map(|c| characters.joint_positions(c)).collect();
        }
    }

    fn finish(
        self,
        characters: &Characters,
        config: &TrialConfig,
        steps: usize,
        busy_s: f64,
    ) -> (TrialReport, TrialRecord) {
        let n = config.characters;
        let left = |c: usize| {
            let (root, target) = (characters.root(c), self.record.targets[c]);
            f64::from((root.x - target.x).hypot(root.z - target.z))
        };
        let arrived: Vec<f64> =
            self.record.arrivals_s.iter().filter(|t| t.is_finite()).map(|&t| f64::from(t)).collect();
        let near: Vec<usize> = (0..n).filter(|&c| left(c) < 1.5 * f64::from(config.reach_m)).collect();
        let is_still =
            |c: &&usize| self.late.get(**c).is_some_and(|p| p.distance(place(characters.root(**c))) < STILL_M);
        let standing = near.iter().filter(is_still).count();
        let reached = |c: usize| self.record.arrivals_s[c].is_finite();
        let seen = |c: usize| {
            let (start, t) = (self.starts[c], self.record.targets[c]);
            let seen = start.rotation().inverse() * (t - start.translation());
            Vec2::new(seen.x, seen.z)
        };
        let choices: u64 = (0..n).map(|c| u64::from(characters.num_choices(c))).sum();
        let tables_hz = self.tables.meta().rate_hz as f32;
        let mut meter = QualityMeter::new(config.step_hz.max(tables_hz), tables_hz);
        self.tracks.iter().for_each(|t| meter.add(t));
        let per_second = |count: f64| count / busy_s.max(1e-9);
        let report = TrialReport {
            characters: n,
            simulated_s: config.seconds,
            reached_fraction: arrived.len() as f64 / n as f64,
            stayed_fraction: near.len() as f64 / n as f64,
            reached_by_distance: by_distance(config, (0..n).map(|c| (seen(c).length(), reached(c)))),
            reached_by_direction: by_direction((0..n).map(|c| (seen(c), reached(c)))),
            longest_wait_s: f64::from(self.longest_wait_s),
            standing_fraction: standing as f64 / near.len().max(1) as f64,
            mean_arrival_s: (!arrived.is_empty()).then(|| arrived.iter().sum::<f64>() / arrived.len() as f64),
            mean_final_distance_m: (0..n).map(left).sum::<f64>() / n as f64,
            character_overlaps: self.overlaps.pairs(),
            deepest_overlap_m: f64::from(self.overlaps.deepest_m()),
            stopped_share: self.on_the_way[1] as f64 / self.on_the_way[0].max(1) as f64,
            foot_slip_mean_mps: self.slip.mean_mps(),
            foot_slip_p95_mps: self.slip.p95_mps(),
            quality: MotionQuality::new(&meter.figures(), &quality::of_clips(self.tables)),
            steps_per_second: per_second((steps + 1) as f64),
            poses_per_second: per_second(((steps + 1) * n) as f64),
            choices_per_second: per_second(choices as f64),
        };
        (report, self.record)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_by_where_targets_stood() {
        let all = [(2.0, true), (2.9, false), (3.0, true), (6.0, true), (7.0, false)];
        let shares = by_distance(&TrialConfig::default(), all.into_iter());
        let rows: Vec<_> = shares.iter().map(|s| (&*s.targets, s.characters, s.reached_fraction)).collect();
        assert_eq!(rows, [("2 to 3 m", 2, 0.5), ("3 to 4 m", 1, 1.0), ("4 to 5 m", 0, 0.0), ("5 to 6 m", 2, 0.5)]);
        // +X is to the left, +Z ahead.
        let seen =
            [(Vec2::Y, true), (Vec2::X, false), (-Vec2::X, true), (Vec2::new(0.3, -1.0), true), (-Vec2::Y, false)];
        let shares = by_direction(seen.into_iter());
        assert_eq!(shares.iter().map(|s| s.reached_fraction).collect::<Vec<_>>(), [1.0, 0.0, 1.0, 0.5]);
    }
}
