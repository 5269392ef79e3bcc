//! Verification of results by means independent of the planner.
//!
//! Nothing of the planner's mathematics is used: poses come from the clip's own kinematics in floats, distances from a search
//! over single triangles, limits from angles of directions. Shared are only the data: shapes, paths, capsules and limits.

mod distance;
#[cfg(test)]
mod tests;

use crate::body::BodyCapsule;
use crate::limits::{JointLimits, SwingLimit};
use crate::problem::MovingSolid;
use crate::rotation::Rigid;
use crate::setup::{AllowedContact, HeldCapsule};
use distance::{BoundedSolid, RecheckCapsule, capsule_distance, solid_distance};
use glam::{DMat3, DQuat, DVec3, Quat, Vec3};
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_motion::Clip;
use throng_motion::clip::joint_transforms;

/// Samples a second (Hz).
pub(crate) const RATE_HZ: f64 = 1000.0;
/// Tolerated excess of speeds, as a share of the limit: clips hold floats.
const SPEED_TOLERANCE: f64 = 1e-3;
/// Tolerated excess of limits (rad).
const LIMIT_TOLERANCE: f64 = 5e-3;

/// Another character around.
#[derive(Clone, Copy, Debug)]
pub struct OtherClip<'a> {
    /// Name in allowances.
    pub name: &'a str,
    /// Motion, from the same moment on.
    pub clip: &'a Clip,
    /// Proportions.
    pub skeleton: &'a Skeleton,
    /// Capsules of its body.
    pub capsules: &'a [BodyCapsule],
}

/// Inputs of a check.
#[derive(Clone, Copy, Debug)]
pub struct Recheck<'a> {
    /// Proportions.
    pub skeleton: &'a Skeleton,
    /// The clip that was changed.
    pub before: &'a Clip,
    /// The changed clip.
    pub after: &'a Clip,
    /// Begin and end of the span in which it may differ (s).
    pub span_s: [f64; 2],
    /// Joints that may differ, and their limits.
    pub planned: &'a [(Joint, JointLimits)],
    /// Capsules of the body.
    pub capsules: &'a [BodyCapsule],
    /// Capsules that the last of the planned joints carries.
    pub held: &'a [HeldCapsule],
    /// Solids around.
    pub solids: &'a [MovingSolid],
    /// Other characters around.
    pub others: &'a [OtherClip<'a>],
    /// Contacts that are allowed.
    pub allowed: &'a [AllowedContact],
    /// Tolerated depth in solids and other characters (m).
    pub penetration_m: f64,
    /// Tolerated depth of parts of the own body in each other (m).
    pub self_press_m: f64,
}

/// A fault that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct RecheckViolation {
    /// Time (s).
    pub time_s: f64,
    /// Description.
    pub what: String,
}

/// Result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct RecheckReport {
    /// All faults.
    pub violations: Vec<RecheckViolation>,
    /// Largest depth in solids and other characters; 0 where there is none (m).
    pub penetration_max_m: f64,
    /// Least distance from solids and other characters; infinite without any (m).
    pub clearance_min_m: f64,
    /// Largest excess over limits; negative inside (rad).
    pub outside_limits_rad: f64,
    /// Fastest joint, as a share of its limit.
    pub speed_share: f64,
    /// Largest angle of a face from its gaze target, beyond the reach of the neck; 0 where nobody looks (rad).
    pub gaze_off_rad: f64,
    /// Largest distance by which the weight is farther off the planted feet than in the clip; 0 where that is not checked (m).
    pub off_balance_m: f64,
    /// Largest distance of the second hand at an object from where it holds it, between the clip's frames, too (m).
    pub second_hand_off_m: f64,
    /// Number of samples.
    pub samples: usize,
}

impl RecheckReport {
    /// Adds a fault.
    pub(crate) fn add_violation(&mut self, time_s: f64, what: String) {
        self.violations.push(RecheckViolation { time_s, what });
    }
}

impl Default for RecheckReport {
    /// A report before any sample.
    fn default() -> Self {
        Self {
            violations: Vec::new(),
            penetration_max_m: 0.0,
            clearance_min_m: f64::INFINITY,
            outside_limits_rad: f64::NEG_INFINITY,
            speed_share: 0.0,
            gaze_off_rad: 0.0,
            off_balance_m: 0.0,
            second_hand_off_m: 0.0,
            samples: 0,
        }
    }
}

/// Checks that everything outside of spans is as it was, to the bit (but for the sign of a quaternion).
///
/// - `spans`: joints, and the times from and to which they may differ (s).
pub fn check_unchanged(before: &Clip, after: &Clip, spans: &[(Joint, [f64; 2])], report: &mut RecheckReport) {
    let (a, b) = (before, after);
    let mut wrong = |frame: usize, what: String| report.add_violation(frame as f64 / a.rate_hz, what);
    if a.num_frames() != b.num_frames() || a.rate_hz != b.rate_hz {
        return wrong(0, "frames or rate differ".into());
    }
    for frame in 0..a.num_frames() {
        let time_s = frame as f64 / a.rate_hz;
        let inside = |[from, to]: [f64; 2]| from - 1e-4 < time_s && time_s < to + 1e-4;
        let may_differ = |joint: Joint| spans.iter().any(|(j, span)| *j == joint && inside(*span));
        if a.root_positions[frame] != b.root_positions[frame] && !may_differ(Joint::Hips) {
            wrong(frame, "places of the hips differ".into());
        }
        for joint in Joint::ALL {
            let [p, q] = [a, b].map(|c| c.frame_rotations(frame)[joint.index()]);
            if p != q && p != -q && !may_differ(joint) {
                wrong(frame, format!("{} changed outside of the plan", joint.name()));
            }
        }
    }
}

impl Recheck<'_> {
    /// Checks the whole span a thousand times a second, and every frame of the clip outside of it.
    pub fn run(&self) -> RecheckReport {
        let mut report = RecheckReport::default();
        let spans: Vec<(Joint, [f64; 2])> = self.planned.iter().map(|(j, _)| (*j, self.span_s)).collect();
        check_unchanged(self.before, self.after, &spans, &mut report);
        self.check_span(&mut report);
        report
    }

    /// Checks the span alone; adds to a report.
    pub fn check_span(&self, report: &mut RecheckReport) {
        self.check_speeds(report);
        let solids: Vec<BoundedSolid> = self.solids.iter().map(BoundedSolid::new).collect();
        let samples = ((self.span_s[1] - self.span_s[0]) * RATE_HZ).round() as usize;
        for sample in 0..=samples {
            let time_s = self.span_s[0] + sample as f64 / RATE_HZ;
            self.check_moment(time_s.min(self.span_s[1]), &solids, report);
        }
        report.samples += samples + 1;
    }

    fn check_speeds(&self, report: &mut RecheckReport) {
        let clip = self.after;
        for frame in 1..clip.num_frames() {
            let time_s = frame as f64 / clip.rate_hz;
            if time_s <= self.span_s[0] + 1e-6 || time_s > self.span_s[1] + 1e-6 {
                continue;
            }
            for (joint, limits) in self.planned {
                let [p, q] = [frame - 1, frame].map(|f| clip.frame_rotations(f)[joint.index()].as_dquat().normalize());
                let speed = p.angle_between(q).min(p.angle_between(-q)) * clip.rate_hz;
                report.speed_share = report.speed_share.max(speed / limits.speed);
                if speed > limits.speed * (1.0 + SPEED_TOLERANCE) {
                    let what = format!("{} turns at {speed:.2} rad/s, at most {:.2}", joint.name(), limits.speed);
                    report.add_violation(time_s, what);
                }
            }
        }
    }

    fn check_moment(&self, time_s: f64, solids: &[BoundedSolid], report: &mut RecheckReport) {
        let (turns, joints) = pose_at(self.after, self.skeleton, time_s);
        for (joint, limits) in self.planned {
            let by = limit_excess(limits, turns[joint.index()]);
            report.outside_limits_rad = report.outside_limits_rad.max(by);
            if by > LIMIT_TOLERANCE {
                let what = format!("{} is out of limits by {by:.4} rad", joint.name());
                report.add_violation(time_s, what);
            }
        }
        let parts = self.planned_capsules(&joints);
        for (name, core) in &parts {
            for bounded in solids.iter().filter(|b| !self.may_touch(name, &b.solid.name, time_s)) {
                let gap = solid_distance(core, bounded, time_s, report.clearance_min_m.max(0.01));
                self.record_gap(name, &bounded.solid.name, gap, time_s, report);
            }
            for other in self.others.iter().filter(|o| !self.may_touch(name, o.name, time_s)) {
                let (_, theirs) = pose_at(other.clip, other.skeleton, time_s);
                for c in other.capsules {
                    let gap = capsule_distance(core, &place_capsule(c, &theirs));
                    self.record_gap(name, other.name, gap, time_s, report);
                }
            }
        }
        self.check_self_collision(&parts, &joints, time_s, report);
    }

    fn record_gap(&self, part: &str, with: &str, gap: f64, time_s: f64, report: &mut RecheckReport) {
        report.clearance_min_m = report.clearance_min_m.min(gap);
        report.penetration_max_m = report.penetration_max_m.max(-gap);
        if gap < -self.penetration_m {
            report.add_violation(time_s, format!("{part} is {:.4} m deep in {with}", -gap));
        }
    }

    /// Capsules that the planned joints carry.
    fn planned_capsules(&self, joints: &[(Vec3, Quat); NUM_JOINTS]) -> Vec<(String, RecheckCapsule)> {
        let of = |c: &&BodyCapsule| self.is_carried(c.joint);
        let mut parts: Vec<(String, RecheckCapsule)> =
            self.capsules.iter().filter(of).map(|c| (c.joint.name().to_owned(), place_capsule(c, joints))).collect();
        if let Some((joint, _)) = self.planned.last() {
            for h in self.held {
                let c = BodyCapsule { joint: *joint, core: h.core, radius: h.radius };
                parts.push((h.name.clone(), place_capsule(&c, joints)));
            }
        }
        parts
    }

    fn is_carried(&self, joint: Joint) -> bool {
        let is_planned = |joint: Joint| self.planned.iter().any(|(j, _)| *j == joint);
        std::iter::successors(Some(joint), |j| j.parent()).any(is_planned)
    }

    /// Checks parts of the limb against the rest of the body, but for neighbours and parts that overlap in the rest pose.
    fn check_self_collision(
        &self,
        parts: &[(String, RecheckCapsule)],
        joints: &[(Vec3, Quat); NUM_JOINTS],
        time_s: f64,
        report: &mut RecheckReport,
    ) {
        let rest = self.skeleton.rest_positions().map(|p| (p, Quat::IDENTITY));
        let rest_parts = self.planned_capsules(&rest);
        let near = |name: &str, joint: Joint| {
            let own = Joint::from_name(name).or(self.planned.last().map(|p| p.0));
            own.is_some_and(|j| self.next_inwards(j) == Some(joint) || self.next_inwards(joint) == Some(j))
        };
        for ((name, core), (_, at_rest)) in parts.iter().zip(&rest_parts) {
            for c in self.capsules.iter().filter(|c| !self.is_carried(c.joint)) {
                let fills = self.capsules.iter().filter(|d| d.joint == c.joint);
                let fused = || fills.clone().any(|d| capsule_distance(at_rest, &place_capsule(d, &rest)) < 0.0);
                let gap = capsule_distance(core, &place_capsule(c, joints));
                let too_deep = gap < -self.self_press_m - self.penetration_m;
                if too_deep && !near(name, c.joint) && !fused() && !self.may_touch(name, c.joint.name(), time_s) {
                    let what = format!("{name} is {:.4} m deep in {}", -gap, c.joint.name());
                    report.add_violation(time_s, what);
                }
            }
        }
    }

    /// The next joint towards the hips that has a capsule.
    fn next_inwards(&self, joint: Joint) -> Option<Joint> {
        let has_capsule = |at: &Joint| self.capsules.iter().any(|c| c.joint == *at);
        std::iter::successors(joint.parent(), |j| j.parent()).find(has_capsule)
    }

    fn may_touch(&self, part: &str, with: &str, time_s: f64) -> bool {
        self.allowed.iter().any(|a| {
            let here = a.window_s.is_none_or(|[from, to]| from <= time_s && time_s <= to);
            here && a.other == with && a.part.as_deref().is_none_or(|p| p == part)
        })
    }
}

/// Rotations of the joints relative to their parents, interpolated evenly between frames, and their world transforms.
fn pose_at(clip: &Clip, skeleton: &Skeleton, time_s: f64) -> ([Quat; NUM_JOINTS], [(Vec3, Quat); NUM_JOINTS]) {
    let last = clip.num_frames() - 1;
    let at = (time_s * clip.rate_hz).clamp(0.0, last as f64);
    let (frame, share) = (at as usize, at.fract() as f32);
    let next = (frame + 1).min(last);
    let turns: [Quat; NUM_JOINTS] =
        std::array::from_fn(|j| clip.frame_rotations(frame)[j].slerp(clip.frame_rotations(next)[j], share));
    let root = clip.root_positions[frame].lerp(clip.root_positions[next], share);
    (turns, joint_transforms(skeleton, root, |j| turns[j]))
}

/// World transform of a joint at any time.
pub(crate) fn place_at(clip: &Clip, skeleton: &Skeleton, joint: Joint, time_s: f64) -> Rigid {
    let (position, rotation) = pose_at(clip, skeleton, time_s).1[joint.index()];
    Rigid::from_joint(position, rotation)
}

fn place_capsule(c: &BodyCapsule, joints: &[(Vec3, Quat); NUM_JOINTS]) -> RecheckCapsule {
    let (position, rotation) = joints[c.joint.index()];
    let place = Rigid::from_joint(position, rotation);
    let [a, b] = [c.core.a, c.core.b].map(|p| place.transform_point(p));
    RecheckCapsule { a, b, radius: c.radius }
}

/// Excess of a rotation over the limits of its joint; negative inside (rad).
pub(crate) fn limit_excess(limits: &JointLimits, rotation: Quat) -> f64 {
    let q = rotation.as_dquat().normalize();
    // In a mirror at x = 0 a rotation matrix R becomes M R M.
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let r = DMat3::from_quat(q);
    let r = if limits.mirrored { mirror * r * mirror } else { r };
    let r = DMat3::from_quat(limits.centre).transpose() * r;
    // The swing leads from the segment at rest to where it points, straight.
    let to = r * limits.segment;
    let angle = limits.segment.angle_between(to);
    let across = limits.segment.cross(to);
    let swing = across.try_normalize().map_or(DVec3::ZERO, |axis| axis * angle);
    // The rest is twist: the angle of an axis across the segment from where the swing alone would turn it.
    let carried = DQuat::from_rotation_arc(limits.segment, to) * limits.axes[0];
    let found = r * limits.axes[0];
    let twist = carried.cross(found).dot(to).atan2(carried.dot(found));
    let [x, y] = limits.axes.map(|a| swing.dot(a));
    let by_swing = match limits.swing {
        SwingLimit::Ellipse([a, b]) => ((x / a).powi(2) + (y / b).powi(2)).sqrt().mul_add(a.min(b), -a.min(b)),
        SwingLimit::Hinge { flexion, play } => (flexion.least - x).max(x - flexion.most).max(y.abs() - play),
    };
    by_swing.max(limits.twist.least - twist).max(twist - limits.twist.most)
}
