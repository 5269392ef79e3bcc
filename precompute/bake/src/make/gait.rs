//! Gaits: steady walks of clips, from the moment at which a foot leaves the ground, played round as long as needed.

use super::feet::{MadeFoot, foot_point};
use serde::{Deserialize, Serialize};
use throng_base::{maths, thresholds::WALKING_MPS};
use throng_core::format::{Gait, MotionClass, Posture};
use throng_core::planar::{twist_about_y, wrap_angle};
use throng_core::{Contacts, NUM_JOINTS, Planar, Skeleton};
use throng_motion::clip::{Clip, FrameRange};

/// Feet of both sides.
pub(super) const FEET: [Contacts; 2] = [Contacts::LEFT, Contacts::RIGHT];
/// Shortest and longest time of two steps (s).
const PERIOD_S: [f64; 2] = [0.45, 2.2];
/// Frames before the event that belong to a gait.
pub(super) const LEAD: usize = 4;
/// Number of cycles that a gait has, played round where its clip is shorter, and number that a good clip has.
const CYCLES: f32 = 4.3;
const LONG: f32 = 3.3;
/// Frames over which the seam of a cycle is smoothed.
const SEAM: usize = 10;
/// Largest turn of a steady gait within a cycle, and largest angle between its travel and its heading (rad).
const STRAIGHT: [f32; 2] = [0.35, 0.6];
/// Largest difference of the poses of a steady gait a cycle apart (rad a joint), of the heights of the hips then, and of their
/// heights within a cycle: a jump or a stair is none (m).
const STEADY: f32 = 0.25;
const STEADY_RISE_M: f32 = 0.06;
const LARGEST_BOB_M: f32 = 0.2;
/// Cost of a gait that is crouched, carries something or goes otherwise than ahead (rad).
const SPECIAL: f32 = 0.4;
/// Cost of a gait that is all played round, beside its seams (rad).
const SEAMS: f32 = 0.1;
/// Shares of a step over which a foot leaves its place, and comes to the next.
const EASE: f32 = 0.35;
/// Shortest quick step, and time over which steps become quick (frames).
const LEAST_STEP: usize = 6;
const HASTE: usize = 4;
/// Shortest time for which a foot leaves the ground (s).
const MIN_SWING_S: f64 = 0.1;

/// A steady gait of a clip.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct GaitCycle {
    /// Its frames: [`LEAD`] or fewer before the event, and several cycles after it.
    pub clip: Clip,
    /// Frame at which `foot` leaves the ground.
    pub event: usize,
    /// Foot that leaves: 0 left, 1 right.
    pub foot: usize,
    /// Duration of two steps (frames).
    pub period: usize,
    /// Mean place and heading at the event.
    base: Planar,
    /// Mean travel (m/frame), in the frame of `base`.
    pub travel: [f32; 2],
    /// Frames at which the frames of `clip` were captured, counted as they are; empty where they are the same.
    captured_at: Vec<f32>,
    /// Difference of the poses a cycle apart (rad a joint); smaller is steadier.
    pub unsteadiness: f32,
    /// Its class.
    pub class: MotionClass,
}

/// A stay of a foot on the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct FootStay {
    /// First and last frame.
    pub first: usize,
    pub last: usize,
    /// Frame at which the foot is flat.
    pub flat: usize,
    /// Place of the ball, and direction of the foot, there.
    pub base: Planar,
    /// True for a foot that is in the air where the clip begins, instead of a stay.
    pub in_air: bool,
}

impl GaitCycle {
    /// The steadiest cycle of each gait that starts with each foot in a clip.
    pub fn find(clip: &Clip, skeleton: &Skeleton) -> Vec<Self> {
        let mut best: Vec<Self> = Vec::new();
        for run in clip.usable_ranges() {
            for foot in [0, 1] {
                let leaves: Vec<usize> = departures(clip, &run, foot).collect();
                for pair in leaves.windows(2) {
                    let Some(found) = Self::from_cycle(clip, skeleton, &run, foot, [pair[0], pair[1]]) else {
                        continue;
                    };
                    match best.iter_mut().find(|b| b.foot == foot && b.class.gait == found.class.gait) {
                        Some(b) if b.unsteadiness <= found.unsteadiness => {}
                        Some(b) => *b = found,
                        None => best.push(found),
                    }
                }
            }
        }
        best.sort_by_key(|b| b.foot);
        best
    }

    /// True if it goes sideways or backwards.
    pub fn goes_aside(&self) -> bool {
        matches!(self.class.gait, Gait::Strafe | Gait::Backwards)
    }

    /// The gait of one cycle, if it is steady and goes ahead.
    fn from_cycle(clip: &Clip, body: &Skeleton, run: &FrameRange, foot: usize, [from, to]: [usize; 2]) -> Option<Self> {
        let period = to - from;
        let seconds = period as f64 / clip.rate_hz;
        if !(PERIOD_S[0]..=PERIOD_S[1]).contains(&seconds) {
            return None;
        }
        let others = departures(clip, run, 1 - foot).filter(|f| (from + 1..to).contains(f)).count();
        let (base, travel) = mean_course(clip, from, period);
        let turn = wrap_angle(clip.planar(to).heading - clip.planar(from).heading).abs();
        let speed = travel[0].hypot(travel[1]) * clip.rate_hz as f32;
        let aside = maths::atan2(travel[0], travel[1]).abs();
        let heights = || clip.root_positions[from..=to].iter().map(|p| p.y);
        let bob = heights().fold(f32::MIN, f32::max) - heights().fold(f32::MAX, f32::min);
        let is_steady = pose_difference(clip, from, to) < STEADY && hips_rise(clip, from, to) < STEADY_RISE_M;
        let class = clip.class_at(from);
        let is_aside = class.is_some_and(|c| matches!(c.gait, Gait::Strafe | Gait::Backwards));
        if others != 1 || turn > STRAIGHT[0] || aside > STRAIGHT[1] && !is_aside || speed < WALKING_MPS {
            return None;
        }
        if bob > LARGEST_BOB_M || !is_steady {
            return None;
        }
        let is_plain = class
            .is_none_or(|c| c.posture == Posture::Upright && !c.carrying && matches!(c.gait, Gait::Walk | Gait::Run));
        let lead = (from - run.start).min(LEAD);
        let frames = (CYCLES * period as f32) as usize + LEAD;
        // What comes after the gait, in the same clip, is none of it.
        let is_like = |f: &usize| {
            pose_difference(clip, f - period, *f) < STEADY && hips_rise(clip, f - period, *f) < STEADY_RISE_M
        };
        let end = (to + 1..run.end).find(|f| !is_like(f)).unwrap_or(run.end);
        let missing = 1.0 - ((end - from) as f32 / (LONG * period as f32)).min(1.0);
        let unsteadiness = pose_difference(clip, from, to)
            + turn
            + 0.3 * aside
            + SEAMS * missing
            + if is_plain { 0.0 } else { SPECIAL };
        let cut = play_round(clip, from - lead..end, lead + frames, period);
        let class = class.cloned().unwrap_or_default();
        let is_unknown = matches!(class.gait, Gait::Stand | Gait::Other);
        let class = if is_unknown { MotionClass { gait: Gait::Walk, neutral: false, ..class } } else { class };
        let captured_at = Vec::new();
        let gait = Self { clip: cut, event: lead, foot, period, base, travel, captured_at, unsteadiness, class };
        gait.plants(body, foot).get(1).is_some().then_some(gait)
    }

    /// This gait with so many quick steps after its event, and as it was captured before and after them.
    ///
    /// - `step_s`: time of a quick step (s); a gait whose steps are as quick stays as it is.
    pub fn with_quick_steps(&self, steps: usize, step_s: f32) -> Self {
        let slow = steps * self.period / 2;
        let step = ((step_s * self.clip.rate_hz as f32).round() as usize).max(LEAST_STEP).max(self.period.div_ceil(4));
        let quick = steps * step;
        if quick >= slow {
            return self.clone();
        }
        let share = |f: usize| (f.min(quick - 1 - f) as f32 / HASTE as f32).min(1.0);
        let gain = (slow - quick) as f32 / (0..quick).map(share).sum::<f32>();
        let mut captured_at: Vec<f32> = (0..=self.event).map(|f| f as f32).collect();
        let mut at = self.event as f32;
        for f in 0..quick - 1 {
            at += 1.0 + gain * 0.5 * (share(f) + share(f + 1));
            captured_at.push(at);
        }
        captured_at.extend((self.event + slow..self.clip.num_frames()).map(|f| f as f32));
        let clip = sample_clip(&self.clip, &captured_at);
        Self { clip, captured_at, period: 2 * step, ..self.clone() }
    }

    /// Speed (m/s).
    pub fn speed_mps(&self) -> f32 {
        self.travel[0].hypot(self.travel[1]) * self.clip.rate_hz as f32
    }

    /// Turn within a cycle, left positive (rad).
    pub fn turn(&self) -> f32 {
        wrap_angle(self.clip.planar(self.event + self.period).heading - self.clip.planar(self.event).heading)
    }

    /// Mean place and heading at a frame of the gait's clip.
    pub fn course(&self, frame: usize) -> Planar {
        let k = self.captured_at.get(frame).copied().unwrap_or(frame as f32) - self.event as f32;
        self.base.compose(Planar::new(self.travel[0] * k, self.travel[1] * k, 0.0))
    }

    /// Stays of a foot on the ground, in order, after one in the air if the clip begins so.
    pub(super) fn plants(&self, skeleton: &Skeleton, foot: usize) -> Vec<FootStay> {
        let (clip, [heel, toe]) = (&self.clip, Contacts::FEET[foot]);
        let planted = |f: usize| clip.contacts[f].any(FEET[foot]);
        let gap = ((MIN_SWING_S * clip.rate_hz) as usize).max(1);
        let mut runs: Vec<FrameRange> = throng_motion::clip::runs_where(0..clip.num_frames(), planted);
        let mut k = 1;
        while k < runs.len() {
            if runs[k].start - runs[k - 1].end < gap {
                runs[k - 1].end = runs[k].end;
                runs.remove(k);
            } else {
                k += 1;
            }
        }
        let plant = |run: FrameRange| {
            let both: Vec<usize> = run.clone().filter(|&f| clip.contacts[f].all(Contacts(heel.0 | toe.0))).collect();
            let flat = both.get(both.len() / 2).copied().unwrap_or((run.start + run.end) / 2);
            let base = foot_point(clip, skeleton, flat, foot).planar();
            FootStay { first: run.start, last: run.end - 1, flat, base, in_air: false }
        };
        let place = foot_point(clip, skeleton, 0, foot).planar();
        let begins = FootStay { first: 0, last: 0, flat: 0, base: place, in_air: true };
        let in_air = runs.first().is_some_and(|r| r.start > 0).then_some(begins);
        in_air.into_iter().chain(runs.into_iter().map(plant)).collect()
    }

    /// The foot at a frame, for its stay on the ground or between two of them: how far its step is (0 to 1, or a little
    /// beyond, as feet swing past their place), and its pose in the frame of where it is then.
    pub fn foot(&self, skeleton: &Skeleton, frame: usize, foot: usize, between: [&FootStay; 2]) -> (f32, MadeFoot) {
        let at = foot_point(&self.clip, skeleton, frame, foot);
        let [a, b] = between;
        let (dx, dz) = (b.base.x - a.base.x, b.base.z - a.base.z);
        let square = dx * dx + dz * dz;
        if a.first == b.first {
            return (0.0, at.seen_from(a.base));
        }
        let time = (frame as f32 - a.last as f32) / b.first.saturating_sub(a.last).max(1) as f32;
        let eased = super::smoother(time);
        let gone =
            if square > 0.01 { ((at.toe.x - a.base.x) * dx + (at.toe.z - a.base.z) * dz) / square } else { eased };
        // As far as it has come, but at rest where it leaves and lands, so that longer and shorter steps are as smooth.
        let share = eased + super::smooth(time / EASE) * super::smooth((1.0 - time) / EASE) * (gone - eased);
        (share, at.seen_from(lerp_planar(a.base, b.base, share)))
    }
}

/// Between two places, headings on the shorter way.
pub(super) fn lerp_planar(a: Planar, b: Planar, share: f32) -> Planar {
    let heading = a.heading + share * wrap_angle(b.heading - a.heading);
    Planar::new(a.x + share * (b.x - a.x), a.z + share * (b.z - a.z), heading)
}

/// Mean difference of the joints of two frames, beside the hips (rad).
fn pose_difference(clip: &Clip, a: usize, b: usize) -> f32 {
    let apart = |j: usize| clip.frame_rotations(a)[j].angle_between(clip.frame_rotations(b)[j]);
    (1..NUM_JOINTS).map(apart).sum::<f32>() / NUM_JOINTS as f32
}

/// Difference of the heights of the hips in two frames (m).
fn hips_rise(clip: &Clip, a: usize, b: usize) -> f32 {
    (clip.root_positions[a].y - clip.root_positions[b].y).abs()
}

/// Time for which a clip walks (s).
pub(super) fn walking_s(clip: &Clip) -> f64 {
    clip.usable_ranges().iter().map(|run| walking_frames(clip, run)).sum::<usize>() as f64 / clip.rate_hz
}

/// Number of frames of a run in which the root is faster than a walk's least speed.
fn walking_frames(clip: &Clip, run: &FrameRange) -> usize {
    let half = ((0.2 * clip.rate_hz) as usize).max(1);
    let goes = |f: usize| {
        let (a, b) = (f.saturating_sub(half).max(run.start), (f + half).min(run.end - 1));
        let by = (clip.root_positions[b] - clip.root_positions[a]).with_y(0.0).length();
        by * clip.rate_hz as f32 > WALKING_MPS * (b - a).max(1) as f32
    };
    run.clone().filter(|&f| goes(f)).count()
}

/// Last frames of a foot's stays on the ground within a run.
fn departures(clip: &Clip, run: &FrameRange, foot: usize) -> impl Iterator<Item = usize> {
    let swing = ((MIN_SWING_S * clip.rate_hz).round() as usize).max(1);
    let planted = move |f: usize| clip.contacts[f].any(FEET[foot]);
    (run.start..run.end.saturating_sub(swing + 1)).filter(move |&f| planted(f) && !(f + 1..=f + swing).any(planted))
}

/// Mean place, heading and travel over a cycle.
fn mean_course(clip: &Clip, from: usize, period: usize) -> (Planar, [f32; 2]) {
    let n = period as f32;
    let by = (clip.root_positions[from + period] - clip.root_positions[from]) / n;
    let (mut x, mut z, mut sin, mut cos) = (0.0, 0.0, 0.0, 0.0);
    for k in 0..period {
        let p = clip.root_positions[from + k] - by * k as f32;
        let (s, c) = maths::sin_cos(twist_about_y(clip.hips_rotation(from + k)));
        (x, z, sin, cos) = (x + p.x / n, z + p.z / n, sin + s, cos + c);
    }
    let base = Planar::new(x, z, maths::atan2(sin, cos));
    let local = Planar::new(0.0, 0.0, base.heading).inverse_transform_point(glam::Vec2::new(by.x, by.z));
    (base, [local.x, local.y])
}

/// Frames of a clip from `range.start` on; where it ends, cycles are played again, with a smooth seam.
fn play_round(clip: &Clip, range: FrameRange, num_frames: usize, period: usize) -> Clip {
    let captured = range.len().min(num_frames);
    let frames = range.start..range.start + captured;
    let mut out = Clip {
        contacts: clip.contacts[frames.clone()].to_vec(),
        ..Clip::new(
            clip.name.clone(),
            clip.rate_hz,
            clip.root_positions[frames.clone()].to_vec(),
            clip.rotations[frames.start * NUM_JOINTS..frames.end * NUM_JOINTS].to_vec(),
        )
    };
    // What the last captured frame differs by from the one a cycle before is taken along, and fades.
    let (last, before) = (captured - 1, captured - 1 - period);
    let by = out.planar(last).compose(out.planar(before).inverse());
    let rise = out.root_positions[last].y - out.root_positions[before].y;
    let offset: Vec<glam::Quat> = (0..NUM_JOINTS)
        .map(|j| {
            let from = out.frame_rotations(before)[j];
            let from = if j == 0 { maths::compose(maths::rotation_y(by.heading), from) } else { from };
            maths::compose(out.frame_rotations(last)[j], from.inverse()).normalize()
        })
        .collect();
    for f in captured..num_frames {
        let source = f - period;
        let share = 1.0 - super::smooth((f - last) as f32 / SEAM as f32);
        let fades = f - last < period;
        let p = out.root_positions[source];
        let moved = by.transform_point(glam::Vec2::new(p.x, p.z));
        let up = if fades { rise * share } else { 0.0 };
        out.root_positions.push(glam::Vec3::new(moved.x, p.y + up, moved.y));
        for (j, offset) in offset.iter().enumerate() {
            let q = out.rotations[source * NUM_JOINTS + j];
            let q = if j == 0 { maths::compose(maths::rotation_y(by.heading), q) } else { q };
            let fade =
                if fades { maths::slerp_f32(glam::Quat::IDENTITY, *offset, share) } else { glam::Quat::IDENTITY };
            out.rotations.push(maths::compose(fade, q).normalize());
        }
        out.contacts.push(out.contacts[source]);
    }
    out
}

/// A clip at other moments.
///
/// - `at`: frames of the clip, with the shares of the time to the next (0 to its number of frames - 1).
fn sample_clip(clip: &Clip, at: &[f32]) -> Clip {
    let (mut roots, mut rotations, mut contacts) = (Vec::new(), Vec::new(), Vec::new());
    for at in at {
        let (a, share) = (at.floor() as usize, at.fract());
        let b = (a + 1).min(clip.num_frames() - 1);
        roots.push(clip.root_positions[a].lerp(clip.root_positions[b], share));
        let (from, to) = (clip.frame_rotations(a), clip.frame_rotations(b));
        rotations.extend(from.iter().zip(to).map(|(p, q)| maths::slerp_f32(*p, *q, share)));
        contacts.push(clip.contacts[if share < 0.5 { a } else { b }]);
    }
    Clip { contacts, ..Clip::new(clip.name.clone(), clip.rate_hz, roots, rotations) }
}

/// Difference of two gaits at their events (rad a joint).
pub(super) fn gait_distance(a: &GaitCycle, b: &GaitCycle) -> f32 {
    let pose = |g: &GaitCycle, k: usize| g.clip.frame_rotations(g.event + k * g.period / 4).to_vec();
    let apart = |k: usize| {
        let (p, q) = (pose(a, k), pose(b, k));
        (1..NUM_JOINTS).map(|j| p[j].angle_between(q[j])).sum::<f32>() / NUM_JOINTS as f32
    };
    let poses = (0..4).map(apart).sum::<f32>() / 4.0;
    poses + 0.1 * (a.speed_mps() - b.speed_mps()).abs()
}
