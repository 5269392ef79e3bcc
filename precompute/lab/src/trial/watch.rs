//! Observes a trial after every step, and computes its report.

use super::{ReachShare, TrialConfig, TrialFrame, TrialMoment, TrialRecord, TrialReport, num_steps};
use crate::made::{MadeFigures, made_frames};
use crate::overlap::{OverlapMeter, PresentCharacter};
use crate::quality::{Change, MotionQuality, Track};
use crate::slip::SlipMeter;
use glam::{Vec2, Vec3};
use throng_base::thresholds::STANDING_MPS;
use throng_core::characters::{Characters, PolicyCharacters};
use throng_core::{BodyVolume, Bundle, CharacterGroup, Planar, PosedBody};

/// Time over which a character that has come to stand is slower than [`STANDING_MPS`] (s).
const STILL_S: f32 = 1.0;
/// Number of characters whose motion is compared with the clips.
const TRACKED: usize = 50;
/// Most recorded poses of each of them, and of the recorded character.
const MOST_POSES: usize = 10_000;
/// Number of target groups by distance.
const RINGS: usize = 4;

fn ground_position(root: Planar) -> Vec2 {
    Vec2::new(root.x, root.z)
}

/// Shares by distance of the target at the start, from the nearest on.
fn by_distance(config: &TrialConfig, all: impl Iterator<Item = (f32, bool)> + Clone) -> Vec<ReachShare> {
    let [near, far] = config.distances;
    let step = (far - near) / RINGS as f32;
    let ring = |distance: f32| (((distance - near) / step) as usize).min(RINGS - 1);
    let share = |k: usize| {
        let [low, high] = [k, k + 1].map(|k| near + step * k as f32);
        reach_share(format!("{low:.0} to {high:.0} m"), all.clone().filter(|a| ring(a.0) == k).map(|a| a.1))
    };
    (0..RINGS).map(share).collect()
}

/// Shares by direction of the target at the start, a quarter of the circle each.
fn by_direction(all: impl Iterator<Item = (Vec2, bool)> + Clone) -> Vec<ReachShare> {
    let quarter = |p: Vec2| match (p.x.abs() > p.y.abs(), p.x > 0.0, p.y > 0.0) {
        (false, _, true) => 0,
        (true, true, _) => 1,
        (true, false, _) => 2,
        (false, _, false) => 3,
    };
    let names = ["ahead", "to the left", "to the right", "behind"].into_iter().enumerate();
    let of = |k: usize| all.clone().filter(move |a| quarter(a.0) == k).map(|a| a.1);
    names.map(|(k, name)| reach_share(name.into(), of(k))).collect()
}

fn reach_share(targets: String, reached: impl Iterator<Item = bool>) -> ReachShare {
    let (characters, arrived) = reached.fold((0, 0), |(n, r), yes| (n + 1, r + usize::from(yes)));
    ReachShare { targets, characters, reached_fraction: arrived as f64 / characters.max(1) as f64 }
}

/// Observes characters after every step.
pub(super) struct TrialWatch<'a> {
    tables: &'a Bundle,
    record: TrialRecord,
    slip: SlipMeter,
    /// Roots at the start.
    starts: Vec<Planar>,
    /// Number of choices of each character, and the time of the last one (s).
    choices: Vec<(u32, f32)>,
    overlaps: OverlapMeter,
    present: Vec<PresentCharacter>,
    /// Roots at the last step.
    before: Vec<Planar>,
    /// Steps of all characters on the way, and the number of them in which they stood.
    on_the_way: [u64; 2],
    /// True for made frames.
    made: Vec<bool>,
    /// Steps in which characters moved, and the number of them that played made frames.
    moving: [u64; 2],
    longest_wait_s: f32,
    /// Tracks of the first [`TRACKED`] characters.
    tracks: Vec<Track>,
    segments: Vec<u32>,
    /// Position of each character [`STILL_S`] before the end (m).
    late: Vec<Vec2>,
}

impl<'a> TrialWatch<'a> {
    pub(super) fn new(config: &TrialConfig, tables: &'a Bundle, starts: Vec<Planar>, targets: Vec<Vec3>) -> Self {
        let n = config.characters;
        let (trails, arrivals_s) = (vec![Vec::new(); n], vec![f32::INFINITY; n]);
        let record = TrialRecord { trails, arrivals_s, targets, ..TrialRecord::default() };
        let choices = vec![(0, 0.0); n];
        Self {
            tables,
            record,
            slip: SlipMeter::new(n, tables.skeleton()),
            before: starts.clone(),
            starts,
            choices,
            overlaps: OverlapMeter::default(),
            present: Vec::with_capacity(n),
            on_the_way: [0; 2],
            made: made_frames(tables),
            moving: [0; 2],
            longest_wait_s: 0.0,
            tracks: vec![Track::default(); n.min(TRACKED)],
            segments: vec![u32::MAX; n.min(TRACKED)],
            late: Vec::new(),
        }
    }

    pub(super) fn observe(&mut self, group: &PolicyCharacters, config: &TrialConfig, step: usize, dt: f32) {
        let (characters, bodies) = (group.characters(), group.bodies());
        self.present.clear();
        let volume = BodyVolume::new(self.tables.skeleton());
        let one = |c: usize| {
            PresentCharacter::with_body(c, &PosedBody { root: bodies.roots[c], model: &bodies.model[c] }, &volume)
        };
        self.present.extend((0..config.characters).map(one));
        self.overlaps.observe_bodies(&self.present, |_, _| false);
        let time_s = step as f32 * dt;
        self.record_moments(characters, config, step, dt);
        if self.late.is_empty() && time_s >= config.seconds - STILL_S {
            self.late = (0..config.characters).map(|c| ground_position(characters.root(c))).collect();
        }
        for c in 0..config.characters {
            let (count, since_s) = self.choices[c];
            self.longest_wait_s = self.longest_wait_s.max(time_s - since_s);
            // Renewed searches of a blocked character count as choices.
            let chosen = characters.num_choices(c).wrapping_add(characters.num_blocked_choices(c));
            if chosen != count {
                self.choices[c] = (chosen, time_s);
            }
            let root = characters.root(c);
            if self.record.arrivals_s[c].is_infinite() {
                let stands = ground_position(root).distance(ground_position(self.before[c])) < STANDING_MPS * dt;
                self.on_the_way[0] += 1;
                self.on_the_way[1] += u64::from(stands && step > 0);
            }
            let moves = ground_position(root).distance(ground_position(self.before[c])) > STANDING_MPS * dt;
            let (segment, time) = characters.segment(c);
            if let Some(s) = self.tables.graph().segments.get(segment as usize).filter(|_| moves && step > 0) {
                self.moving[0] += 1;
                let frame = (s.start + time as u32) as usize;
                self.moving[1] += u64::from(self.made.get(frame).is_some_and(|made| *made));
            }
            self.before[c] = root;
            let target = self.record.targets[c];
            let distance = (root.x - target.x).hypot(root.z - target.z);
            if distance < config.reach_m {
                self.record.arrivals_s[c] = self.record.arrivals_s[c].min(time_s);
            }
        }
        self.slip.observe_characters(characters, dt);
        self.extend_tracks(characters);
        let Some(c) = config.recorded.filter(|_| self.record.frames.len() < MOST_POSES) else { return };
        let (root, positions, contacts) = (characters.root(c), characters.joint_positions(c), characters.contacts(c));
        self.record.frames.push(TrialFrame { time_s, root, positions, contacts });
    }

    /// Adds a sample to each track.
    fn extend_tracks(&mut self, characters: &Characters) {
        let segments = &self.tables.graph().segments;
        for (c, (track, last)) in self.tracks.iter_mut().zip(&mut self.segments).enumerate() {
            if track.positions.len() == MOST_POSES {
                continue;
            }
            let now = characters.segment(c).0;
            let of = |s: u32| segments.get(s as usize);
            if let Some((a, b)) = of(*last).zip(of(now)).filter(|_| now != *last)
                && a.start + a.num_frames != b.start
            {
                let frames = [a.start + a.num_frames - 1, b.start];
                track.changes.push(Change { sample: track.positions.len(), frames });
            }
            *last = now;
            track.positions.push(characters.joint_positions(c));
            if self.record.arrivals_s[c].is_infinite() {
                track.on_the_way = track.positions.len();
            }
        }
    }

    /// Grows the trails up to the first moment, and records the crowd at each moment.
    fn record_moments(&mut self, characters: &Characters, config: &TrialConfig, step: usize, dt: f32) {
        let (all, r, time_s) = (0..config.characters, &mut self.record, step as f32 * dt);
        let trail_every = (config.step_hz / 5.0).round().max(1.0) as usize;
        let later = [0.5 * (config.snapshot_s + config.seconds), config.seconds].into_iter();
        let mut due =
            std::iter::once(config.snapshot_s.min(config.seconds)).chain(later.filter(|at| *at > config.snapshot_s));
        let is_due = due.nth(r.moments.len()).is_some_and(|at| time_s > at - 0.5 * dt);
        if r.moments.is_empty() && (is_due || step.is_multiple_of(trail_every)) {
            r.trails.iter_mut().zip(all.clone()).for_each(|(t, c)| t.push(ground_position(characters.root(c))));
        }
        if is_due {
            let poses = all.map(|c| characters.joint_positions(c)).collect();
            r.moments.push(TrialMoment { time_s, poses });
        }
    }

    pub fn finish(self, characters: &Characters, config: &TrialConfig, busy_s: f64) -> (TrialReport, TrialRecord) {
        let (n, steps) = (config.characters, num_steps(config));
        let left = |c: usize| {
            let (root, target) = (characters.root(c), self.record.targets[c]);
            f64::from((root.x - target.x).hypot(root.z - target.z))
        };
        let arrived: Vec<f64> =
            self.record.arrivals_s.iter().filter(|t| t.is_finite()).map(|&t| f64::from(t)).collect();
        let near: Vec<usize> = (0..n).filter(|&c| left(c) < 1.5 * f64::from(config.reach_m)).collect();
        let moved_m = |c: usize| Some(self.late.get(c)?.distance(ground_position(characters.root(c))));
        let is_still = |c: &&usize| moved_m(**c).is_some_and(|m| m < STANDING_MPS * STILL_S);
        let standing = near.iter().filter(is_still).count();
        let reached = |c: usize| self.record.arrivals_s[c].is_finite();
        let seen = |c: usize| {
            let (start, t) = (self.starts[c], self.record.targets[c]);
            let seen = start.rotation().inverse() * (t - start.translation());
            Vec2::new(seen.x, seen.z)
        };
        let choices: u64 = (0..n).map(|c| u64::from(characters.num_choices(c))).sum();
        let per_second = |count: f64| count / busy_s.max(1e-9);
        let report = TrialReport {
            characters: n,
            simulated_s: config.seconds,
            avoiding: config.motion.avoid.is_some(),
            reached_fraction: arrived.len() as f64 / n as f64,
            stayed_fraction: near.len() as f64 / n as f64,
            reached_by_distance: by_distance(config, (0..n).map(|c| (seen(c).length(), reached(c)))),
            reached_by_direction: by_direction((0..n).map(|c| (seen(c), reached(c)))),
            longest_wait_s: f64::from(self.longest_wait_s),
            standing_fraction: standing as f64 / near.len().max(1) as f64,
            mean_arrival_s: (!arrived.is_empty()).then(|| arrived.iter().sum::<f64>() / arrived.len() as f64),
            mean_final_distance_m: (0..n).map(left).sum::<f64>() / n as f64,
            character_overlaps: self.overlaps.pairs(),
            deepest_overlap_m: self.overlaps.deepest_m,
            stopped_share: self.on_the_way[1] as f64 / self.on_the_way[0].max(1) as f64,
            foot_slip_mean_mps: self.slip.mean_mps(),
            foot_slip_p95_mps: self.slip.p95_mps(),
            made: MadeFigures::of_bundle(self.tables, &self.made, self.moving[1] as f64 / self.moving[0].max(1) as f64),
            quality: MotionQuality::new(self.tables, &self.tracks, config.step_hz),
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
