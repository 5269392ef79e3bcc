//! Effective hits: the moments at which a fist or foot could deliver a blow (Lee and Lee 2004, section 6, "Data Annotation").
//!
//! "Punches can deliver power effectively when the direction of motion of the fist and the forearm axis are parallel
//! at the moment of hitting": the fist's velocity projected onto the forearm axis is above a threshold and not opposed
//! to it. Differs: the speeds that decide are relative to the hips' way over the ground and the arm has to grow longer
//! during the blow, so that running arms do not strike; a blow lands a little after its fastest moment, where the arm
//! is nearly straight; kicks, and punches across the forearm, are told by their whole speed.

mod config;
mod mark;
mod peaks;
mod point;
mod report;
#[cfg(test)]
mod tests;
mod track;

use crate::clip::{Clip, FrameRange, Hit, HitKind};
use crate::error::BuildError;
pub use config::HitConfig;
use config::{KickConfig, PunchConfig};
pub use mark::HitMark;
use peaks::{Blow, Rule};
pub use point::{HitPoint, write_csv};
pub use report::HitReport;
use std::collections::BTreeMap;
use throng_core::{Contacts, Joint, Skeleton};
use track::{Limb, Poses, Track};

/// Blows that are shorter are faults of the recording: a joint that jumps from one frame to the next (s).
const MIN_DURATION: f64 = 0.05;

/// A thrust lasts as long as the fist moves out along the forearm, with at least this share of its greatest speed.
const THRUST_LASTS: f32 = 0.1;

/// The same of a swing, whose speed never turns negative.
const SWING_LASTS: f32 = 0.25;

/// Arms whose wrist is this near to the shoulder, as a share of the arm's length, are bent: the elbow by 50 degrees.
const BENT: f32 = 0.9;

/// A slower joint has no direction to strike in (m/s).
const MIN_SPEED: f32 = 0.05;

/// Effective hits of a clip whose contacts and unusable frames are known: those that are found and those that are
/// marked, ascending by frame. Forces are left at 1; [`set_forces`] fills them in.
///
/// A mark takes the place of what is found for the same joint nearby.
///
/// - `automatic`: false leaves the marks alone.
///
/// # Errors
/// [`BuildError::Config`] for a mark on a frame that is left out or on a joint that does not move.
pub fn find(
    clip: &Clip,
    skeleton: &Skeleton,
    cfg: &HitConfig,
    marks: &[HitMark],
    automatic: bool,
) -> Result<Vec<Hit>, BuildError> {
    let poses = track::poses(clip, skeleton);
    let marked: Vec<Hit> = marks.iter().map(|m| m.hit(clip, &poses, skeleton)).collect::<Result<_, _>>()?;
    let mut hits = Vec::new();
    if automatic && cfg.enabled {
        let ranges = clip.usable_ranges();
        let search = Search { clip, skeleton, poses: &poses, ranges: &ranges, landing_share: cfg.landing_share };
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

/// What is looked through.
struct Search<'a> {
    clip: &'a Clip,
    skeleton: &'a Skeleton,
    poses: &'a Poses,
    ranges: &'a [FrameRange],
    landing_share: f32,
}

impl Search<'_> {
    fn punches(&self, cfg: &PunchConfig) -> Vec<Hit> {
        let mut out = Vec::new();
        for limb in Limb::ARMS {
            let track = self.track(limb);
            let mut blows = self.thrusts(&track, cfg.thrust_speed, cfg.extension, cfg.min_gap);
            if let Some(speed) = cfg.swing_speed {
                // The arm is bent and need not grow longer.
                let mut swings = self.swings(&track, speed, f32::NEG_INFINITY, cfg.min_gap);
                let shoulder = |f: usize| self.poses[f][limb.root.index()].0.y;
                swings.retain(|b| track.extensions[b.landing] < BENT);
                swings.retain(|b| track.tips[b.landing].y >= shoulder(b.landing) - cfg.swing_drop);
                add_apart(&mut blows, swings, self.frames(cfg.min_gap));
            }
            out.extend(blows.iter().filter_map(|b| self.hit(HitKind::Punch, limb.end, &track, b.landing)));
        }
        out
    }

    fn kicks(&self, cfg: &KickConfig) -> Vec<Hit> {
        let tracks = Limb::LEGS.map(|limb| self.track(limb));
        let planted = [Contacts::LEFT, Contacts::RIGHT];
        let mut out = Vec::new();
        for (side, limb) in Limb::LEGS.into_iter().enumerate() {
            let (track, other) = (&tracks[side], &tracks[1 - side]);
            let mut blows = self.thrusts(track, cfg.thrust_speed, cfg.extension, cfg.min_gap);
            add_apart(
                &mut blows,
                self.swings(track, cfg.swing_speed, cfg.extension, cfg.min_gap),
                self.frames(cfg.min_gap),
            );
            blows.retain(|b| {
                let stands = self.clip.contacts.get(b.landing).is_some_and(|c| c.any(planted[side]));
                !stands && track.tips[b.landing].y - other.tips[b.landing].y >= cfg.height
            });
            out.extend(blows.iter().filter_map(|b| self.hit(HitKind::Kick, limb.end, track, b.landing)));
        }
        out
    }

    fn track(&self, limb: Limb) -> Track {
        Track::new(self.poses, self.skeleton, limb, self.clip.rate_hz)
    }

    /// Blows along forearm or shin; in the world, too, they go where the limb points.
    fn thrusts(&self, track: &Track, speed: f32, extension: f32, min_gap: f32) -> Vec<Blow> {
        let rule = Rule { lasting_share: THRUST_LASTS, ..self.rule(speed, extension, min_gap) };
        let mut found = self.blows(&track.thrusts, track, &rule);
        found.retain(|b| track.velocities[b.landing].dot(track.axes[b.landing]) > 0.0);
        found
    }

    /// Blows in any direction.
    fn swings(&self, track: &Track, speed: f32, extension: f32, min_gap: f32) -> Vec<Blow> {
        self.blows(&track.speeds, track, &self.rule(speed, extension, min_gap))
    }

    fn rule(&self, speed: f32, extension: f32, min_gap: f32) -> Rule {
        Rule {
            speed,
            lasting_share: SWING_LASTS,
            extension,
            min_frames: (MIN_DURATION * self.clip.rate_hz).ceil() as usize,
            min_gap: self.frames(min_gap),
            landing_share: self.landing_share,
        }
    }

    fn blows(&self, speeds: &[f32], track: &Track, rule: &Rule) -> Vec<Blow> {
        let in_range = |range: &FrameRange| peaks::blows(speeds, &track.extensions, range.clone(), rule);
        self.ranges.iter().flat_map(in_range).collect()
    }

    fn frames(&self, seconds: f32) -> usize {
        (f64::from(seconds) * self.clip.rate_hz).round() as usize
    }

    fn hit(&self, kind: HitKind, joint: Joint, track: &Track, frame: usize) -> Option<Hit> {
        hit_at(self.clip, frame, kind, joint, (track.tips[frame], track.velocities[frame]))
    }

    /// True for two hits of one joint that are one blow.
    fn are_near(&self, a: &Hit, b: &Hit, cfg: &HitConfig) -> bool {
        let gap = if b.kind == HitKind::Kick { cfg.kicks.min_gap } else { cfg.punches.min_gap };
        a.frame.abs_diff(b.frame) < self.frames(gap)
    }
}

/// Adds blows that are at least `min_gap` frames from those that are there.
fn add_apart(blows: &mut Vec<Blow>, more: impl IntoIterator<Item = Blow>, min_gap: usize) {
    let num = blows.len();
    for b in more {
        if blows[..num].iter().all(|a| a.peak.abs_diff(b.peak) >= min_gap) {
            blows.push(b);
        }
    }
}

/// A hit as seen from its frame's planar root; `None` where the joint does not move.
///
/// - `motion`: position and velocity of the striking point in the world.
fn hit_at(clip: &Clip, frame: usize, kind: HitKind, joint: Joint, motion: (glam::Vec3, glam::Vec3)) -> Option<Hit> {
    let root = clip.planar(frame);
    let to_root = root.rotation().inverse();
    let (position, velocity) = (to_root * (motion.0 - root.translation()), to_root * motion.1);
    let speed_mps = velocity.length();
    (speed_mps >= MIN_SPEED).then(|| Hit {
        frame,
        kind,
        joint,
        position,
        direction: velocity / speed_mps,
        speed_mps,
        force: 1.0,
    })
}
