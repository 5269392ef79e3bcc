//! Places that stay fixed in the world while the body moves over, under or around them.

use super::super::Bounds;
use super::super::touch::{PARTS, Probes};
use glam::{Quat, Vec3};
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_motion::annotate::contacts::{detect, hysteresis, speeds};
use throng_motion::annotate::{ContactConfig, Ground};
use throng_motion::clip::{Clip, FrameRange, runs};

/// Speeds of a holding hand: falls below the first and stays below the second (m/s).
const HOLD_SPEEDS: [f32; 2] = [0.12, 0.25];
/// Shortest hold and shortest seat (s).
const SHORTEST: [f32; 2] = [0.2, 0.7];
/// Least motion of the rest of the body relative to a fixed place (m).
const BODY_MOVES: f32 = 0.08;
/// Largest motion of a fixed place (m).
const PLACE_MOVES: f32 = 0.05;
/// Speeds of a seated body: falls below the first and stays below the second (m/s).
const SEAT_SPEEDS: [f32; 2] = [0.1, 0.2];
/// Largest slope of the thighs of a seated body (fall over length).
const SEAT_STEEPEST: f32 = 0.6;
/// Largest difference in height of heel and toes of a flat foot; beyond it the foot stands on its ball (m).
const FOOT_STEEPEST: f32 = 0.06;
/// Number of parts that belong to feet.
const FOOT_PARTS: usize = 4;
/// Part number of the seat.
const SEAT: usize = 6;

/// Kind of a touching part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Foot,
    Hand,
    Seat,
}

/// Place at which a part was planted for a while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    pub kind: Kind,
    /// Centre of the touching area: the sole, the grip, the underside of the thighs (m).
    pub point: Vec3,
    /// Box around the points of the skin (m).
    pub extent: Bounds,
    /// Direction from the right to the left shoulder. Unit.
    pub across: Vec3,
    /// Time for which it was planted (s).
    pub lasts_s: f32,
}

/// All places of a clip, part by part.
pub fn find(clip: &Clip, skeleton: &Skeleton, cfg: &ContactConfig) -> Vec<Touch> {
    let body = Motion::new(clip, skeleton);
    let uneven = ContactConfig { ground: Ground::Uneven, ..cfg.clone() };
    let planted = detect(clip, skeleton, &uneven);
    let mut out = Vec::new();
    for (part, bit) in PARTS.into_iter().enumerate().take(FOOT_PARTS) {
        let is_heel = part % 2 == 0;
        for run in runs(0..planted.len(), |f| planted[f].any(bit) && clip.is_usable(f)) {
            if is_heel && body.steepness(part, &run) > FOOT_STEEPEST {
                continue;
            }
            out.extend(body.place(Kind::Foot, part, run, 0));
        }
    }
    for (part, joint) in [(4, Joint::LeftHand), (5, Joint::RightHand)] {
        for run in body.slow(clip, joint, HOLD_SPEEDS, SHORTEST[0]) {
            // The palm is the second of a hand's points.
            out.extend(body.place(Kind::Hand, part, run, 1));
        }
    }
    for run in body.slow(clip, Joint::Hips, SEAT_SPEEDS, SHORTEST[1]) {
        if body.sits(run.start.midpoint(run.end)) {
            out.extend(body.place(Kind::Seat, SEAT, run, 0));
        }
    }
    out
}

/// Joints of a clip over time.
struct Motion {
    transforms: Vec<[(Vec3, Quat); NUM_JOINTS]>,
    probes: Probes,
    rate_hz: f64,
}

impl Motion {
    fn new(clip: &Clip, skeleton: &Skeleton) -> Self {
        let transforms = (0..clip.num_frames()).map(|f| clip.joint_transforms(skeleton, f)).collect();
        Self { transforms, probes: Probes::new(skeleton), rate_hz: clip.rate_hz }
    }

    fn joint(&self, frame: usize, joint: Joint) -> Vec3 {
        self.transforms[frame][joint.index()].0
    }

    /// Runs of usable frames in which a joint is slow.
    fn slow(&self, clip: &Clip, joint: Joint, [on, off]: [f32; 2], shortest_s: f32) -> Vec<FrameRange> {
        let path: Vec<Vec3> = (0..self.transforms.len()).map(|f| self.joint(f, joint)).collect();
        let speed = speeds(&path, clip.rate_hz);
        let below = |limit: f32| (0..path.len()).map(|f| speed[f] < limit && clip.is_usable(f)).collect::<Vec<_>>();
        let shortest = (f64::from(shortest_s) * clip.rate_hz).round() as usize;
        let still = hysteresis(&below(off), &below(on), shortest, 0);
        runs(0..still.len(), |f| still[f]).into_iter().filter(|r| r.len() >= shortest).collect()
    }

    /// Place of a part during a run; `None` if not fixed in the world.
    ///
    /// - `middle`: index of the skin point that represents the part.
    fn place(&self, kind: Kind, part: usize, run: FrameRange, middle: usize) -> Option<Touch> {
        let probes = self.probes.of(part);
        let track: Vec<Vec3> = run.clone().map(|f| probes[middle].at(&self.transforms[f])).collect();
        let far = match kind {
            Kind::Hand => Joint::UpperChest,
            _ => Joint::Hips,
        };
        let rest = run.clone().zip(&track).map(|(f, p)| self.joint(f, far) - *p);
        let (moved, body) = (spread(track.iter().copied()), spread(rest));
        // Standing still on the ground says nothing about other heights; a seated body does not move.
        if kind != Kind::Seat && (moved > PLACE_MOVES || body < BODY_MOVES) {
            return None;
        }
        let at = run.start.midpoint(run.end);
        let lasts_s = (run.len() as f64 / self.rate_hz) as f32;
        let mut point = median(track);
        let extent = Bounds::of(probes.iter().map(|p| p.at(&self.transforms[at])));
        if kind != Kind::Hand {
            point.y = median(run.map(|f| Vec3::splat(self.lowest(part, f))).collect()).y;
        }
        let across = self.joint(at, Joint::LeftUpperArm) - self.joint(at, Joint::RightUpperArm);
        Some(Touch { kind, point, extent, across: across.normalize_or(Vec3::X), lasts_s })
    }

    /// Height of the lowest point of a part's skin (m).
    fn lowest(&self, part: usize, frame: usize) -> f32 {
        let heights = self.probes.of(part).iter().map(|p| p.at(&self.transforms[frame]).y - p.radius.max(0.0));
        heights.fold(f32::INFINITY, f32::min)
    }

    /// Median height difference between heel and toes of a foot during a run, absolute (m).
    fn steepness(&self, heel: usize, run: &FrameRange) -> f32 {
        let by = |f: usize| (self.lowest(heel, f) - self.lowest(heel + 1, f)).abs();
        median(run.clone().map(|f| Vec3::splat(by(f))).collect()).y
    }

    /// True if both thighs are level and the trunk is upright.
    fn sits(&self, frame: usize) -> bool {
        let is_level = |thigh: Joint, shin: Joint| {
            let d = self.joint(frame, shin) - self.joint(frame, thigh);
            d.y.abs() < SEAT_STEEPEST * d.length()
        };
        let trunk = self.joint(frame, Joint::Neck) - self.joint(frame, Joint::Hips);
        is_level(Joint::LeftThigh, Joint::LeftShin)
            && is_level(Joint::RightThigh, Joint::RightShin)
            && trunk.y > 0.7 * trunk.length()
    }
}

/// Longest side of the box around some points.
fn spread(points: impl IntoIterator<Item = Vec3>) -> f32 {
    let b = Bounds::of(points);
    (b.max - b.min).max_element()
}

/// The median of each coordinate (not empty).
fn median(points: Vec<Vec3>) -> Vec3 {
    let of = |k: usize| {
        let mut v: Vec<f32> = points.iter().map(|p| p[k]).collect();
        v.sort_by(f32::total_cmp);
        v[v.len() / 2]
    };
    Vec3::new(of(0), of(1), of(2))
}
