//! Effective hits: the moments at which a fist or foot could deliver a blow (Lee and Lee 2004, section 6, "Data Annotation").
//!
//! "Punches can deliver power effectively when the direction of motion of the fist and the forearm axis are parallel
//! at the moment of hitting": the fist's velocity projected onto the forearm axis is above a threshold and not opposed
//! to it. Differs: the speeds that decide are relative to the hips' way over the ground and the arm has to grow longer
//! during the blow, so that running arms do not strike; the arm goes outwards and comes back, and nobody kicks
//! meanwhile, so that neither raised, offered nor balancing arms do. A blow lands a little after its fastest moment,
//! where the arm is nearly straight; kicks, and punches across the forearm, are told by their whole speed.

mod config;
mod mark;
mod peaks;
mod point;
mod report;
#[cfg(test)]
mod tests;
mod track;

use crate::clip::{Clip, ClipHit, FrameRange, HitKind};
use crate::error::Result;
pub use config::HitConfig;
use config::{KickConfig, PunchConfig};
use glam::Vec3;
pub use mark::HitMark;
use peaks::{ExtensionRun, SpeedPeak};
pub use point::{HitPoint, write_csv};
pub use report::HitReport;
use std::collections::BTreeMap;
use throng_core::{Contacts, Joint, Skeleton, skeleton::ARMS};
use track::{LimbTrack, Poses, STRIKING_LEGS, StrikingLimb};

/// Least duration of a blow; shorter ones are faults of the recording: a joint that jumps from one frame to the next (s).
const MIN_DURATION: f64 = 0.05;

/// Least time between two swings of one hand (s).
const SWING_GAP: f64 = 0.25;

/// Distance from wrist to shoulder, as a share of the arm's length, below which the arm is bent: the elbow by 50 degrees.
const BENT: f32 = 0.9;

/// Length of a limb where it is longest, as a share of its full length, below which it does not strike: knee or elbow is bent
/// by more than 80 degrees there, as a guard's is.
const FOLDED: f32 = 0.75;

/// Angle of the trunk above level below which a body lies, crawls, or reaches for the ground (rad).
const UPRIGHT: f32 = 0.35;

/// Time from its fastest moment to its full extension above which a fist reaches for something (s).
const LATE: f64 = 0.35;

/// Time within which a fist that struck comes back after its full extension (s).
const COMES_BACK: f64 = 0.6;

/// Time before and after a kick in which arms balance it (s).
const BALANCE: f64 = 0.4;

/// Speed below which a joint has no direction to strike in (m/s).
const MIN_SPEED: f32 = 0.05;

/// Finds the effective hits of a clip whose contacts and unusable frames are known: those that the search finds and those that
/// are marked, ascending by frame. Forces are left at 1; [`set_forces`] fills them in.
///
/// A mark replaces a found hit of the same joint nearby.
///
/// - `automatic`: false keeps the marks alone.
///
/// # Errors
/// [`crate::error::BuildError::Config`] for a mark on a frame that is left out or on a joint that does not move.
pub fn find_hits(
    clip: &Clip,
    skeleton: &Skeleton,
    cfg: &HitConfig,
    marks: &[HitMark],
    automatic: bool,
) -> Result<Vec<ClipHit>> {
    let poses = track::poses(clip, skeleton);
    let marked: Vec<ClipHit> = marks.iter().map(|m| m.hit(clip, &poses, skeleton)).collect::<Result<_, _>>()?;
    let mut hits = Vec::new();
    if automatic && cfg.enabled {
        let ranges = clip.usable_ranges();
        let search = HitSearch { clip, skeleton, poses: &poses, ranges: &ranges, landing_share: cfg.landing_share };
        if cfg.punches.enabled {
            hits.extend(search.punches(&cfg.punches));
        }
        if cfg.kicks.enabled {
            hits.extend(search.kicks(&cfg.kicks));
        }
        hits.retain(|h| !marked.iter().any(|m| m.joint == h.joint && search.are_near(m, h, cfg)));
    }
    hits.extend(marked);
    hits.sort_by(|a, b| (a.frame, a.joint.index(), &a.kind).cmp(&(b.frame, b.joint.index(), &b.kind)));
    Ok(hits)
}

/// Sets the force of every hit: its speed over that of the fastest hit of its kind in the set.
pub fn set_forces(clips: &mut [Clip]) {
    let mut fastest: BTreeMap<HitKind, f32> = BTreeMap::new();
    for hit in clips.iter().flat_map(|c| &c.hits) {
        let f = fastest.entry(hit.kind.clone()).or_insert(hit.speed_mps);
        *f = f.max(hit.speed_mps);
    }
    for hit in clips.iter_mut().flat_map(|c| &mut c.hits) {
        hit.force = fastest.get(&hit.kind).map_or(1.0, |f| hit.speed_mps / f);
    }
}

/// Inputs of the search for hits of one clip.
struct HitSearch<'a> {
    clip: &'a Clip,
    skeleton: &'a Skeleton,
    poses: &'a Poses,
    ranges: &'a [FrameRange],
    landing_share: f32,
}

impl HitSearch<'_> {
    fn punches(&self, cfg: &PunchConfig) -> Vec<ClipHit> {
        let feet = STRIKING_LEGS.map(|limb| self.track(limb).tips);
        let raised = |f: usize| (feet[0][f].y - feet[1][f].y).abs() > cfg.raised_foot;
        let balance = self.frames(BALANCE);
        let kicks =
            |peak: usize| (peak.saturating_sub(balance)..=peak + balance).any(|f| f < feet[0].len() && raised(f));
        let mut out = Vec::new();
        for limb in ARMS {
            let [root, _, end] = limb;
            let track = self.track(limb);
            let mut blows = self.thrusts(limb, &track, cfg);
            if let Some(speed) = cfg.swing_speed {
                // A bent arm need not grow longer.
                let shoulder = |f: usize| self.poses[f][root.index()].0.y;
                let min_frames = self.frames_up(MIN_DURATION);
                let in_range =
                    |r: &FrameRange| peaks::swings(&track.speeds, r.clone(), speed, min_frames, self.landing_share);
                let all = self.ranges.iter().flat_map(in_range);
                let bent = |b: &SpeedPeak| track.extensions[b.landing] < BENT;
                let high = |b: &SpeedPeak| track.tips[b.landing].y >= shoulder(b.landing) - cfg.swing_drop;
                let apart = self.frames(SWING_GAP);
                let swings = peaks::strongest(all.filter(|b| bent(b) && high(b)).collect(), apart);
                add_apart(&mut blows, swings, apart);
            }
            blows.retain(|b| !kicks(b.peak));
            let blows = peaks::strongest(blows, self.frames(cfg.min_gap));
            out.extend(blows.iter().filter_map(|b| self.hit(HitKind::Punch, end, &track, b.landing)));
        }
        out
    }

    /// Blows along the forearm; in the world, too, they go in its direction, and outwards.
    fn thrusts(&self, [root, _, end]: StrikingLimb, track: &LimbTrack, cfg: &PunchConfig) -> Vec<SpeedPeak> {
        let level = cfg.elevation_deg.to_radians();
        let strikes = |(range, run): (&FrameRange, ExtensionRun)| {
            let blow = SpeedPeak::from_run(&track.thrusts, &run, self.landing_share);
            let arm = self.offset(run.full, root, end);
            let velocity = track.velocities[blow.landing];
            let back_by = run.full + self.frames(COMES_BACK);
            let shortest = (run.full..back_by.min(range.end)).map(|f| track.extensions[f]).fold(run.longest, f32::min);
            let is_fist = blow.speed >= cfg.thrust_speed
                && run.growth >= cfg.extension
                && run.longest >= FOLDED
                && run.full - blow.peak <= self.frames(LATE)
                && velocity.dot(track.axes[blow.landing]) > 0.0
                && elevation(arm).abs() <= level
                && elevation(velocity) <= level
                && (run.longest - shortest >= cfg.retreat || back_by > range.end)
                && self.is_upright(run.full);
            is_fist.then_some(blow)
        };
        self.runs(track).filter_map(strikes).collect()
    }

    /// Blows of feet that are high above the other foot where the leg is longest.
    fn kicks(&self, cfg: &KickConfig) -> Vec<ClipHit> {
        let tracks = STRIKING_LEGS.map(|limb| self.track(limb));
        let planted = [Contacts::LEFT, Contacts::RIGHT];
        let mut out = Vec::new();
        for (side, [_, _, foot]) in STRIKING_LEGS.into_iter().enumerate() {
            let (track, other) = (&tracks[side], &tracks[1 - side]);
            let strikes = |(_, run): (&FrameRange, ExtensionRun)| {
                let blow = SpeedPeak::from_run(&track.speeds, &run, self.landing_share);
                let thrust = SpeedPeak::from_run(&track.thrusts, &run, self.landing_share);
                let stands = self.clip.contacts.get(blow.landing).is_some_and(|c| c.any(planted[side]));
                let is_kick = (blow.speed >= cfg.swing_speed || thrust.speed >= cfg.thrust_speed)
                    && run.growth >= cfg.extension
                    && track.extensions[blow.landing] >= FOLDED
                    && track.tips[run.full].y - other.tips[run.full].y >= cfg.height
                    && self.is_upright(run.full)
                    && !stands;
                is_kick.then_some(blow)
            };
            let blows = peaks::strongest(self.runs(track).filter_map(strikes).collect(), self.frames(cfg.min_gap));
            out.extend(blows.iter().filter_map(|b| self.hit(HitKind::Kick, foot, track, b.landing)));
        }
        out
    }

    fn track(&self, limb: StrikingLimb) -> LimbTrack {
        LimbTrack::new(self.poses, self.skeleton, limb, self.clip.rate_hz)
    }

    /// Runs in which a limb grows longer, for at least as long as a blow takes, and the usable frames that each is in.
    fn runs(&self, track: &LimbTrack) -> impl Iterator<Item = (&FrameRange, ExtensionRun)> {
        let shortest = self.frames_up(MIN_DURATION);
        let in_range = |r: &'_ FrameRange| peaks::outward_runs(&track.extensions, r.clone());
        let all: Vec<(&FrameRange, ExtensionRun)> =
            self.ranges.iter().flat_map(|r| in_range(r).into_iter().map(move |run| (r, run))).collect();
        all.into_iter().filter(move |(_, run)| run.full - run.start >= shortest)
    }

    fn is_upright(&self, frame: usize) -> bool {
        elevation(self.offset(frame, Joint::Hips, Joint::Neck)) >= UPRIGHT
    }

    /// Offset of a joint from another one at a frame (m).
    fn offset(&self, frame: usize, from: Joint, to: Joint) -> Vec3 {
        self.poses[frame][to.index()].0 - self.poses[frame][from.index()].0
    }

    fn frames(&self, seconds: impl Into<f64>) -> usize {
        (seconds.into() * self.clip.rate_hz).round() as usize
    }

    fn frames_up(&self, seconds: f64) -> usize {
        (seconds * self.clip.rate_hz).ceil() as usize
    }

    fn hit(&self, kind: HitKind, joint: Joint, track: &LimbTrack, frame: usize) -> Option<ClipHit> {
        hit_at(self.clip, frame, kind, joint, (track.tips[frame], track.velocities[frame]))
    }

    /// True for two hits of one joint that are one blow.
    fn are_near(&self, a: &ClipHit, b: &ClipHit, cfg: &HitConfig) -> bool {
        let gap = if b.kind == HitKind::Kick { cfg.kicks.min_gap } else { cfg.punches.min_gap };
        a.frame.abs_diff(b.frame) < self.frames(gap)
    }
}

/// Angle above level (rad).
fn elevation(direction: Vec3) -> f32 {
    // Rounding may make it longer than 1.
    direction.normalize_or_zero().y.clamp(-1.0, 1.0).asin()
}

/// Adds blows that are at least `min_gap` frames from the blows that are there.
fn add_apart(blows: &mut Vec<SpeedPeak>, more: impl IntoIterator<Item = SpeedPeak>, min_gap: usize) {
    let num = blows.len();
    for b in more {
        if blows[..num].iter().all(|a| a.peak.abs_diff(b.peak) >= min_gap) {
            blows.push(b);
        }
    }
}

/// A hit relative to its frame's planar root; `None` where the joint does not move.
///
/// - `motion`: position and velocity of the striking point in the world.
fn hit_at(clip: &Clip, frame: usize, kind: HitKind, joint: Joint, motion: (Vec3, Vec3)) -> Option<ClipHit> {
    let root = clip.planar(frame);
    let to_root = root.rotation().inverse();
    let (position, velocity) = (to_root * (motion.0 - root.translation()), to_root * motion.1);
    let (speed_mps, direction) = (velocity.length(), velocity / velocity.length());
    let hit = ClipHit { frame, kind, joint, position, direction, speed_mps, force: 1.0 };
    (speed_mps >= MIN_SPEED).then_some(hit)
}
