//! One closed cycle of a clip: the best-closing one of a steady stretch, with its seam smoothed.

use super::twist::{FacingTwist, SteadyCourse, rotate_ground};
use super::{ClipTrack, FractionalPose, StepCycle, displacement, exponential};
use glam::{DQuat, DVec3, Quat, Vec3};
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton};
use throng_motion::{FrameRange, mirror::mirror_rotation};

/// Range over which a cycle's end is moved to close best (frames).
const END_SEARCH: f64 = 1.0;
/// Places tried on each side of a cycle's end.
const END_STEPS: i32 = 16;
/// Shortest and longest loop of a still example (s).
const STILL_S: (f64, f64) = (1.5, 8.0);
/// Most frames of a still stretch that are tried as the ends of a loop, evenly spread.
const STILL_TRIES: usize = 120;
/// Largest difference of the ends of a still loop; beyond it the loop is played forth and back (rad).
const STILL_CLOSING: f64 = 0.035;
/// Least time of a still example that is played forth and back (s).
const RETURN_S: f64 = 3.0;

/// A cycle of a clip.
#[derive(Clone, Debug)]
pub struct Cycle<'a> {
    /// The clip it is taken from.
    pub track: ClipTrack<'a>,
    /// Keytimes; those of the right foot are meaningless for a still cycle.
    pub steps: StepCycle,
    /// Kind of the cycle.
    kind: CycleKind,
    /// Path of the facing frame.
    pub course: SteadyCourse,
    /// Mean turn of a joint from its end to its beginning, before the seam is closed (rad).
    pub closing: f64,
    /// Distance of the hips from its end to its beginning, before the seam is closed (m).
    pub closing_m: f64,
    /// Changes that close the seam, at its beginning and its end; linear in between.
    seam: [PoseShift; 2],
}

/// A small change of a pose: of the hips' position, and a log-displacement of every joint.
#[derive(Clone, Copy, Debug)]
struct PoseShift {
    hips: Vec3,
    turns: [DVec3; NUM_JOINTS],
}

impl<'a> Cycle<'a> {
    /// The best-closing cycle of a steady stretch.
    ///
    /// - `cycles`: consecutive (not empty).
    pub fn find_best(track: ClipTrack<'a>, cycles: &[StepCycle]) -> Self {
        let last = (track.clip.num_frames() - 1) as f64;
        let ends = |c: &StepCycle| {
            let (c, step) = (*c, END_SEARCH / f64::from(END_STEPS));
            (-END_STEPS..=END_STEPS)
                .map(move |k| c.with_end(c.end + f64::from(k) * step))
                .filter(move |c| c.end <= last)
        };
        // Poses determine the period better than strikes, which fall on frames.
        let alike = |c: &StepCycle| {
            let costs = ends(c).map(|c| (difference(&track, c.start, c.end), c.end - c.start));
            costs.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(c.end - c.start, |(_, period)| period)
        };
        let period = cycles.iter().map(alike).sum::<f64>() / cycles.len() as f64;
        let twist = FacingTwist::mean_of_cycles(&track, cycles, period);
        let cost = |c: &StepCycle| {
            let course = SteadyCourse::fit_to_track(&track, twist, c.start, c.end);
            let (metres, angle) = if cycles.len() > 1 { course.pose_gap(&track, c.start, c.end) } else { (0.0, 0.0) };
            difference(&track, c.start, c.end) + metres + angle / NUM_JOINTS as f64
        };
        let best = cycles.iter().flat_map(ends).map(|c| (cost(&c), c)).min_by(|a, b| a.0.total_cmp(&b.0));
        let steps = best.map_or(cycles[0], |(_, c)| c);
        let twist = if cycles.len() > 1 {
            twist
        } else {
            FacingTwist::mean_of_cycles(&track, &[steps], steps.end - steps.start)
        };
        let course = SteadyCourse::fit_to_track(&track, twist, steps.start, steps.end);
        Self::new(track, steps, course, CycleKind::Whole)
    }

    /// A cycle of one step and its mirrored image, for straight motion that is too short for two steps: the step that
    /// meets its image best.
    ///
    /// - `firsts`: cycles of which only the first step is used (not empty).
    pub fn from_half_cycle(track: ClipTrack<'a>, firsts: &[StepCycle]) -> Self {
        let last = (track.clip.num_frames() - 1) as f64;
        let ends = |s: &StepCycle| {
            let (s, step) = (*s, END_SEARCH / f64::from(END_STEPS));
            let ends = (-END_STEPS..=END_STEPS).map(move |k| s.right_strike + f64::from(k) * step);
            ends.filter(move |end| *end <= last).map(move |end| s.first_half(end))
        };
        let cost = |s: &StepCycle| {
            let (a, b) = (track.pose_at(s.start).mirrored(), track.pose_at(s.right_strike));
            pose_distance(&a, &b)
        };
        let best = firsts.iter().flat_map(ends).map(|s| (cost(&s), s)).min_by(|a, b| a.0.total_cmp(&b.0));
        let steps = best.map_or(firsts[0].first_half(firsts[0].right_strike), |(_, s)| s);
        let course = SteadyCourse::from_step(&track, steps.start, steps.right_strike);
        Self::new(track, steps, course, CycleKind::Halved)
    }

    /// The best-closing loop of a stretch without steps.
    pub fn from_still(track: ClipTrack<'a>, range: &FrameRange) -> Self {
        let rate = track.rate();
        let length = range.len().saturating_sub(1) as f64;
        let (least, most) = ((STILL_S.0 * rate).min(length), (STILL_S.1 * rate).min(length));
        let tries: Vec<f64> = {
            let n = STILL_TRIES.min(range.len()).max(2);
            (0..n).map(|i| (range.start as f64 + length * i as f64 / (n - 1) as f64).round()).collect()
        };
        let pairs = tries.iter().flat_map(|&a| tries.iter().map(move |&b| (a, b)));
        let cost = |a: f64, b: f64| {
            difference(&track, a, b) + track.position_at(a).distance(track.position_at(b)) - 1e-4 * (b - a) / rate
        };
        let ends = pairs.filter(|(a, b)| (least..=most).contains(&(b - a))).map(|(a, b)| (cost(a, b), (a, b)));
        let ends = ends.min_by(|x, y| x.0.total_cmp(&y.0)).map(|best| best.1);
        let (start, end) = ends.unwrap_or((range.start as f64, range.start as f64 + length));
        let steps = StepCycle { start, left_off: end, right_strike: 0.5 * (start + end), right_off: end, end };
        let course = SteadyCourse::fit_to_track(&track, FacingTwist::default(), start, end);
        let cycle = Self::new(track.clone(), steps, course, CycleKind::Still);
        if cycle.closing <= STILL_CLOSING { cycle } else { Self::new(track, steps, course, CycleKind::Returning) }
    }

    fn new(track: ClipTrack<'a>, steps: StepCycle, course: SteadyCourse, kind: CycleKind) -> Self {
        let none = PoseShift { hips: Vec3::ZERO, turns: [DVec3::ZERO; NUM_JOINTS] };
        let mut cycle = Self { track, steps, kind, course, closing: 0.0, closing_m: 0.0, seam: [none; 2] };
        let (first, last) = match kind {
            CycleKind::Whole | CycleKind::Still => (cycle.open_pose(steps.start), cycle.open_pose(steps.end)),
            CycleKind::Halved => (cycle.open_pose(steps.start).mirrored(), cycle.open_pose(steps.right_strike)),
            CycleKind::Returning => return cycle,
        };
        // Both ends move half the way to each other.
        let half = |j: usize| 0.5 * displacement(first.rotations[j].as_dquat(), last.rotations[j].as_dquat());
        let there = PoseShift { hips: 0.5 * (last.hips - first.hips), turns: std::array::from_fn(half) };
        let back = PoseShift { hips: -there.hips, turns: there.turns.map(|v| -v) };
        cycle.seam = [if kind == CycleKind::Halved { there.mirrored() } else { there }, back];
        cycle.closing = there.turns.iter().map(|v| 4.0 * v.length()).sum::<f64>() / NUM_JOINTS as f64;
        cycle.closing_m = f64::from(2.0 * there.hips.length());
        cycle
    }

    /// True if both feet stay on the ground.
    pub fn is_still(&self) -> bool {
        matches!(self.kind, CycleKind::Still | CycleKind::Returning)
    }

    /// Time of the cycle (s).
    pub fn duration_s(&self) -> f64 {
        let once = (self.steps.end - self.steps.start) / self.track.rate();
        if self.kind == CycleKind::Returning { (2.0 * once).max(RETURN_S) } else { once }
    }

    /// The frames it lies in: the first one and how many.
    pub fn frames(&self) -> (usize, usize) {
        let first = self.steps.start.ceil().max(0.0) as usize;
        let end = if self.kind == CycleKind::Halved { self.steps.right_strike } else { self.steps.end };
        let end = (end.ceil() as usize).max(first + 1);
        (first, end - first)
    }

    /// Pose at a generic time in [0, 1) in the facing frame: hips relative to its origin, their orientation to its
    /// heading. The cycle is closed.
    pub fn pose(&self, generic: f64) -> FractionalPose {
        if self.kind == CycleKind::Halved && generic >= 0.5 {
            return self.pose(generic - 0.5).mirrored();
        }
        let time = self.time(generic);
        let mut pose = self.open_pose(time);
        let end = if self.kind == CycleKind::Halved { self.steps.right_strike } else { self.steps.end };
        let part = (time - self.steps.start) / (end - self.steps.start);
        let [first, last] = &self.seam;
        pose.hips += first.hips.lerp(last.hips, part as f32);
        for (j, q) in pose.rotations.iter_mut().enumerate() {
            *q = (q.as_dquat() * exponential(first.turns[j].lerp(last.turns[j], part))).normalize().as_quat();
        }
        pose
    }

    /// Positions of some joints relative to the hips in such a pose (m).
    pub fn limb_positions(pose: &FractionalPose, skeleton: &Skeleton, joints: [Joint; 4]) -> [Vec3; 4] {
        let all = throng_motion::clip::joint_transforms(skeleton, Vec3::ZERO, |j| pose.rotations[j]);
        joints.map(|j| all[j.index()].0)
    }

    /// Seconds that pass per unit of generic time: constant between the strikes (s).
    pub fn rate(&self, generic: f64) -> f64 {
        let s = &self.steps;
        match (self.is_still(), generic < 0.5) {
            (true, _) => self.duration_s(),
            (false, true) => 2.0 * (s.right_strike - s.start) / self.track.rate(),
            (false, false) => 2.0 * (s.end - s.right_strike) / self.track.rate(),
        }
    }

    /// Shares of the left and the right foot in contact with the ground: 1 from a strike to the off, but for half a
    /// frame at each end, over which they rise and fall.
    pub fn contacts(&self, generic: f64) -> [f64; 2] {
        let s = &self.steps;
        if self.is_still() {
            return [1.0; 2];
        }
        let (time, period) = (s.time(generic), s.end - s.start);
        let stands = |strike: f64, off: f64| {
            let one = |shift: f64| (time + shift - strike + 0.5).min(off + 0.5 - time - shift).clamp(0.0, 1.0);
            one(-period).max(one(0.0)).max(one(period))
        };
        [stands(s.start, s.left_off), stands(s.right_strike, s.right_off)]
    }

    /// Shares of the left and the right hand in touch with something.
    pub fn hand_contacts(&self, generic: f64) -> [f64; 2] {
        if self.kind == CycleKind::Halved && generic >= 0.5 {
            let [left, right] = self.hand_contacts(generic - 0.5);
            return [right, left];
        }
        let time = self.time(generic);
        [Contacts::LEFT_HAND, Contacts::RIGHT_HAND].map(|part| self.track.touch_at(time, part))
    }

    /// Time of the clip at a generic time (frames).
    fn time(&self, generic: f64) -> f64 {
        let s = &self.steps;
        match self.kind {
            CycleKind::Returning => s.start + (s.end - s.start) * 0.5 * (1.0 - (std::f64::consts::TAU * generic).cos()),
            CycleKind::Whole | CycleKind::Halved | CycleKind::Still => s.time(generic),
        }
    }

    fn open_pose(&self, time: f64) -> FractionalPose {
        let mut pose = self.track.pose_at(time);
        let (origin, heading) = self.course.frame_at(time);
        let ground = glam::DVec2::new(f64::from(pose.hips.x), f64::from(pose.hips.z));
        let seen = rotate_ground(ground - origin, -heading);
        pose.hips = Vec3::new(seen.x as f32, pose.hips.y, seen.y as f32);
        pose.rotations[0] = (DQuat::from_rotation_y(-heading) * pose.rotations[0].as_dquat()).as_quat();
        pose
    }
}

/// Kind of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CycleKind {
    /// Two steps.
    Whole,
    /// One step and its mirrored image.
    Halved,
    /// No steps, played as a loop.
    Still,
    /// No steps, played forth and back.
    Returning,
}

impl PoseShift {
    /// The change of the mirrored pose.
    fn mirrored(&self) -> Self {
        let turn = |j: Joint| self.turns[j.mirrored().index()] * DVec3::new(1.0, -1.0, -1.0);
        Self { hips: self.hips * Vec3::new(-1.0, 1.0, 1.0), turns: Joint::ALL.map(turn) }
    }
}

impl FractionalPose {
    /// The pose mirrored at x = 0.
    fn mirrored(&self) -> Self {
        let rotations = Joint::ALL.map(|j| mirror_rotation(self.rotations[j.mirrored().index()]));
        Self { hips: Vec3::new(-self.hips.x, self.hips.y, self.hips.z), rotations }
    }
}

/// Difference of the poses and their motion at two times: the mean turn of a joint, and the difference of the hips'
/// height (rad, m).
fn difference(track: &ClipTrack<'_>, a: f64, b: f64) -> f64 {
    let at = |shift: f64| pose_distance(&track.pose_at(a + shift), &track.pose_at(b + shift));
    let inside = b + 1.0 <= (track.clip.num_frames() - 1) as f64;
    if inside { 0.5 * (at(0.0) + at(1.0)) } else { at(0.0) }
}

/// Difference of two poses, regardless of place and heading (rad, m).
fn pose_distance(p: &FractionalPose, q: &FractionalPose) -> f64 {
    let turn = |p: &Quat, q: &Quat| f64::from(2.0 * p.dot(*q).abs().min(1.0).acos());
    let mut turns: f64 = p.rotations[1..].iter().zip(&q.rotations[1..]).map(|(p, q)| turn(p, q)).sum();
    // Only the tilt of the hips, since the course holds their heading.
    turns += f64::from((p.rotations[0] * Vec3::Y).angle_between(q.rotations[0] * Vec3::Y));
    turns / NUM_JOINTS as f64 + f64::from((p.hips.y - q.hips.y).abs())
}
