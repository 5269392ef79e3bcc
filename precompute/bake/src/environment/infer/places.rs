//! Places that stay fixed in the world while the body moves over, under or around them.

use super::super::touch::{PARTS, SkinPoints};
use glam::{Quat, Vec3};
use throng_base::maths::quantile;
use throng_base::thresholds::{HAND_HOLDS_MPS, SEATED_MPS};
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_geometry::BoundingBox;
use throng_motion::annotate::contacts::{detect_contacts, hysteresis, speeds};
use throng_motion::annotate::{ContactConfig, GroundShape};
use throng_motion::{Clip, FrameRange, runs_where};

/// Shortest hold and shortest seat (s).
const SHORTEST: [f32; 2] = [0.2, 0.7];
/// Least motion of the rest of the body relative to a fixed place (m).
const BODY_MOVES: f32 = 0.08;
/// Largest motion of a fixed place (m).
const PLACE_MOVES: f32 = 0.05;
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
pub enum TouchKind {
    Foot,
    Hand,
    Seat,
}

/// Place at which a part was planted for a while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InferredTouch {
    pub kind: TouchKind,
    /// Centre of the touching area: the sole, the grip, the underside of the thighs (m).
    pub point: Vec3,
    /// Box around the points of the skin (m).
    pub extent: BoundingBox,
    /// Direction from the right to the left shoulder. Unit.
    pub across: Vec3,
    /// Time for which it was planted (s).
    pub lasts_s: f32,
}

/// All places of a clip, part by part.
pub fn find_touches(clip: &Clip, skeleton: &Skeleton, cfg: &ContactConfig) -> Vec<InferredTouch> {
    let body = JointTracks::new(clip, skeleton);
    let uneven = ContactConfig { ground: GroundShape::Uneven, ..cfg.clone() };
    let planted = detect_contacts(clip, skeleton, &uneven);
    let mut out = Vec::new();
    for (part, bit) in PARTS.into_iter().enumerate().take(FOOT_PARTS) {
        let is_heel = part % 2 == 0;
        for run in runs_where(0..planted.len(), |f| planted[f].any(bit) && clip.is_usable(f)) {
            if is_heel && body.steepness(part, &run) > FOOT_STEEPEST {
                continue;
            }
            out.extend(body.touch_in_run(TouchKind::Foot, part, run, 0));
        }
    }
    for (part, joint) in [(4, Joint::LeftHand), (5, Joint::RightHand)] {
        for run in body.slow_runs(clip, joint, HAND_HOLDS_MPS, SHORTEST[0]) {
            // The palm is the second of a hand's points.
            out.extend(body.touch_in_run(TouchKind::Hand, part, run, 1));
        }
    }
    let sits = |run: &FrameRange| body.is_seated(run.start.midpoint(run.end));
    for run in body.slow_runs(clip, Joint::Hips, SEATED_MPS, SHORTEST[1]).into_iter().filter(sits) {
        out.extend(body.touch_in_run(TouchKind::Seat, SEAT, run, 0));
    }
    out
}

/// Joints of a clip over time.
struct JointTracks {
    transforms: Vec<[(Vec3, Quat); NUM_JOINTS]>,
    probes: SkinPoints,
    rate_hz: f64,
}

impl JointTracks {
    fn new(clip: &Clip, skeleton: &Skeleton) -> Self {
        let transforms = (0..clip.num_frames()).map(|f| clip.joint_transforms(skeleton, f)).collect();
        Self { transforms, probes: SkinPoints::new(skeleton), rate_hz: clip.rate_hz }
    }

    fn joint(&self, frame: usize, joint: Joint) -> Vec3 {
        self.transforms[frame][joint.index()].0
    }

    /// Runs of usable frames in which a joint is slow.
    fn slow_runs(&self, clip: &Clip, joint: Joint, [on, off]: [f32; 2], shortest_s: f32) -> Vec<FrameRange> {
        let path: Vec<Vec3> = (0..self.transforms.len()).map(|f| self.joint(f, joint)).collect();
        let speed = speeds(&path, clip.rate_hz);
        let below = |limit: f32| (0..path.len()).map(|f| speed[f] < limit && clip.is_usable(f)).collect::<Vec<_>>();
        let shortest = (f64::from(shortest_s) * clip.rate_hz).round() as usize;
        let still = hysteresis(&below(off), &below(on), shortest, 0);
        runs_where(0..still.len(), |f| still[f]).into_iter().filter(|r| r.len() >= shortest).collect()
    }

    /// Place of a part during a run; `None` if not fixed in the world.
    ///
    /// - `middle`: index of the skin point that represents the part.
    fn touch_in_run(&self, kind: TouchKind, part: usize, run: FrameRange, middle: usize) -> Option<InferredTouch> {
        let probes = self.probes.points_of(part);
        let track: Vec<Vec3> = run.clone().map(|f| probes[middle].position(&self.transforms[f])).collect();
        let far = if matches!(kind, TouchKind::Hand) { Joint::UpperChest } else { Joint::Hips };
        let rest = run.clone().zip(&track).map(|(f, p)| self.joint(f, far) - *p);
        let (moved, body) = (longest_side(track.iter().copied()), longest_side(rest));
        // Standing still on the ground says nothing about other heights; a seated body does not move.
        if kind != TouchKind::Seat && (moved > PLACE_MOVES || body < BODY_MOVES) {
            return None;
        }
        let at = run.start.midpoint(run.end);
        let lasts_s = (run.len() as f64 / self.rate_hz) as f32;
        let mut point = median(track);
        let extent = BoundingBox::around_points(probes.iter().map(|p| p.position(&self.transforms[at])));
        if kind != TouchKind::Hand {
            point.y = median(run.map(|f| Vec3::splat(self.lowest_point(part, f))).collect()).y;
        }
        let across = self.joint(at, Joint::LeftUpperArm) - self.joint(at, Joint::RightUpperArm);
        Some(InferredTouch { kind, point, extent, across: across.normalize_or(Vec3::X), lasts_s })
    }

    /// Height of the lowest point of a part's skin (m).
    fn lowest_point(&self, part: usize, frame: usize) -> f32 {
        let heights =
            self.probes.points_of(part).iter().map(|p| p.position(&self.transforms[frame]).y - p.radius.max(0.0));
        heights.fold(f32::INFINITY, f32::min)
    }

    /// Median height difference between heel and toes of a foot during a run, absolute (m).
    fn steepness(&self, heel: usize, run: &FrameRange) -> f32 {
        let by = |f: usize| (self.lowest_point(heel, f) - self.lowest_point(heel + 1, f)).abs();
        median(run.clone().map(|f| Vec3::splat(by(f))).collect()).y
    }

    /// True if both thighs are level and the trunk is upright.
    fn is_seated(&self, frame: usize) -> bool {
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
fn longest_side(points: impl IntoIterator<Item = Vec3>) -> f32 {
    let b = BoundingBox::around_points(points);
    (b.max - b.min).max_element()
}

/// The median of each coordinate (not empty).
fn median(points: Vec<Vec3>) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|k| quantile(points.iter().map(|p| p[k]), [1, 2]).unwrap_or_default()))
}
