//! Stances: frames in which a body stands at ease, and one made of a gait where no clip has any.

use super::feet::{MadeFoot, foot_point};
use super::gait::GaitCycle;
use super::stepping::{CoursePose, ankle_of, reach_feet};
use crate::graph::{MotionGraphConfig, holds_arm_out, is_held_out, standing_runs_of};
use crate::stops::idle_frames_left;
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use throng_base::maths;
use throng_core::format::{ClassSpan, Gait, MotionClass};
use throng_core::{Joint, NUM_JOINTS, Planar, Skeleton, planar::twist_about_y, skeleton::ARMS};
use throng_geometry::distance_to_segment;
use throng_motion::{Clip, FrameRange, retarget::LEGS};

/// Time that a stance lasts where its clip has as much (s).
const LONG_S: f64 = 2.0;
/// Least height of hips and head of who stands upright, as shares of those of the rest pose.
const UPRIGHT: [f32; 2] = [0.88, 0.85];
/// Largest distance of the feet of who stands at ease, and largest angle between them (m, rad).
const FEET_APART: (f32, f32) = (0.55, 1.4);
/// Cost of a stance that is not neutral, as unrest.
const GESTURE: f32 = 0.3;
/// Weight of the likeness of a stance to the gait, and unrest from which no clip stands at ease.
const LIKENESS: f32 = 1.0;
const MOST_UNREST: f32 = 1.0;
/// Most stances of a clip, and of a manner, and difference from which two are unlike (rad a joint).
const MAX_STANCES: usize = 3;
const OTHER_STANCE: f32 = 0.1;
/// Share of the bend of a runner's elbows, and of its trunk, that is left where it stands.
const BENT: f32 = 0.3;
/// Sine and cosine of the angle of hanging arms off straight down.
const HANGS: [f32; 2] = [0.28, 0.96];
/// Distance from the trunk's axis up to which a hand lies on the body, and bend of the elbow of an arm that hangs (m, rad).
const AT_BODY_M: f32 = 0.3;
const HANGING_ELBOW: f32 = 0.4;
/// Least time of a made stance (s).
const HELD_S: f32 = 6.0;

/// Frames that stand at ease.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RestStance {
    /// The frames.
    pub clip: Clip,
    /// Their class.
    pub class: MotionClass,
    /// Unrest: speed of joints and arms away from the body; smaller is calmer.
    pub unrest: f32,
    /// True if its frames are made, as no clip stands at ease.
    pub made: bool,
}

impl RestStance {
    /// The calmest stances of a clip, each unlike those before it.
    pub fn find(clip: &Clip, skeleton: &Skeleton, cfg: &MotionGraphConfig) -> Vec<Self> {
        let long = (LONG_S * clip.rate_hz) as usize;
        let rest = skeleton.rest_positions();
        let mut all: Vec<(f32, f32, FrameRange)> = Vec::new();
        for run in clip.usable_ranges() {
            for stand in standing_runs_of(clip, &run, cfg) {
                for from in stand.clone().step_by((long / 2).max(1)) {
                    let window = from..(from + long).min(stand.end);
                    if window.len() < long / 6 {
                        continue;
                    }
                    let Some(unrest) = unrest(clip, skeleton, &window, &rest) else { continue };
                    // Short stands may do, but long ones look alive.
                    let short = 1.0 - window.len() as f32 / long as f32;
                    let gestures = clip.class_at(window.start).is_some_and(|c| !c.neutral);
                    let unrest = unrest + if gestures { GESTURE } else { 0.0 };
                    all.push((unrest + 0.3 * short, unrest, window));
                }
            }
        }
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let best = pick_unlike(all.iter(), |(_, _, window)| clip.frame_rotations(window.start));
        let stance = |(_, unrest, window): &(f32, f32, FrameRange)| {
            let known = clip.class_at(window.start).cloned();
            let class = known.unwrap_or(MotionClass { neutral: true, ..MotionClass::default() });
            Self { clip: cut(clip, window.clone()), class, unrest: *unrest, made: false }
        };
        best.into_iter().map(stance).collect()
    }

    /// Stances in which those stop and set off who go in the manner of some gaits, the calmest and likest first: captured
    /// neutral ones of that manner, else one that is made.
    ///
    /// - `all`: the captured ones, of all manners.
    pub fn choose(all: &[Self], gaits: &[&GaitCycle], skeleton: &Skeleton) -> Vec<Self> {
        let Some(first) = gaits.first() else { return Vec::new() };
        let cost = |s: &Self| s.unrest + LIKENESS * s.distance_from(first);
        let mut calm: Vec<&Self> = all.iter().filter(|s| s.unrest < MOST_UNREST).collect();
        calm.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        // Long only where the feet stay under the hips: other stands are held for longer, over feet that stay.
        let is_long = |s: &Self| {
            let left = idle_frames_left(&s.clip, skeleton)[0] as usize + 1;
            (left + 1) as f64 >= LONG_S * s.clip.rate_hz && left == s.clip.num_frames()
        };
        calm.sort_by_cached_key(|s| (!s.class.neutral, !is_long(s)));
        let own = calm.iter().copied().filter(|s| s.class.neutral && s.class.manner == first.class.manner);
        let long = |(s, k): (&Self, u64)| if is_long(s) { s.clone() } else { s.prolong(skeleton, HELD_S, k) };
        let own = pick_unlike(own, |s| s.clip.frame_rotations(0));
        let mut out: Vec<Self> = own.into_iter().zip(0..).map(long).collect();
        if out.is_empty() {
            // Who runs stands as those do who walk so, or as anybody stands.
            let walk = gaits.iter().find(|g| g.class.gait != Gait::Run);
            out.extend(match (walk, calm.first().filter(|s| s.class.neutral)) {
                (None, Some(stance)) => Some(long((stance, 0))),
                _ => Self::of_gait(walk.unwrap_or(first), skeleton),
            });
        }
        out
    }

    /// A stance made of a gait: the mean of its poses, feet side by side on the ground, breathing.
    pub fn of_gait(gait: &GaitCycle, skeleton: &Skeleton) -> Option<Self> {
        let cycle = gait.event..gait.event + gait.period;
        let mean = |j: usize| {
            let seen = |f: usize| {
                let q = gait.clip.frame_rotations(f)[j];
                if j == 0 { maths::compose(maths::rotation_y(-gait.course(f).heading), q) } else { q }
            };
            let first = seen(cycle.start);
            let sum = cycle
                .clone()
                .map(seen)
                .fold(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), |sum, q| if first.dot(q) < 0.0 { sum - q } else { sum + q });
            maths::normalize_or_identity(sum)
        };
        let mut rotations: [Quat; NUM_JOINTS] = std::array::from_fn(mean);
        if gait.class.gait == Gait::Run {
            let trunk = [Joint::Hips, Joint::Spine, Joint::Chest, Joint::UpperChest];
            for j in trunk.into_iter().chain(ARMS.map(|[_, elbow, _]| elbow)).map(Joint::index) {
                rotations[j] = maths::slerp_f32(Quat::IDENTITY, rotations[j], BENT);
            }
        }
        if !gait.class.carrying {
            hang_arms(&mut rotations, skeleton, gait.class.gait == Gait::Run);
        }
        let flat: [MadeFoot; 2] = {
            let of = |foot: usize| {
                let plants = gait.plants(skeleton, foot);
                let plant = plants.iter().find(|p| p.first > 0).or(plants.first())?;
                let at = gait.course(plant.flat).to_local(plant.base);
                let seen = foot_point(&gait.clip, skeleton, plant.flat, foot).seen_from(plant.base);
                let side = if foot == 0 { 1.0 } else { -1.0 };
                // Feet side by side, no wider than a hand, each a little outwards.
                let apart = (side * at.x).clamp(0.07, 0.14) * side;
                let out = (side * at.heading).clamp(0.0, 0.25) * side;
                Some(seen.laid_at(Planar::new(apart, 0.06, out)))
            };
            [of(0)?, of(1)?]
        };
        let height = standing_height(gait, cycle, skeleton, &rotations, &flat);
        let class = MotionClass { gait: Gait::Stand, neutral: true, ..gait.class.clone() };
        let mut pose = CoursePose { hips: Vec3::Y * height, rotations };
        reach_feet(&mut pose, skeleton, &flat);
        let still = Clip::new("stand", gait.clip.rate_hz, vec![pose.hips], pose.rotations.to_vec());
        Some(Self { clip: still, class, unrest: 0.0, made: true }.prolong(skeleton, HELD_S, 0))
    }

    /// Difference of the body above the legs from the mean of a gait (rad a joint).
    pub fn distance_from(&self, gait: &GaitCycle) -> f32 {
        let legs = 14;
        let still = self.clip.frame_rotations(0);
        let apart = |j: usize| {
            let of = |k: usize| gait.clip.frame_rotations(gait.event + k * gait.period / 8)[j].angle_between(still[j]);
            (0..8).map(of).sum::<f32>() / 8.0
        };
        (1..legs).map(apart).sum::<f32>() / (legs - 1) as f32
    }

    /// Frame of the stance after so many frames: played forth and back.
    pub fn frame(&self, k: usize) -> usize {
        let last = self.clip.num_frames() - 1;
        let at = k % (2 * last).max(1);
        if at <= last { at } else { 2 * last - at }
    }

    /// Mean place of the hips and mean heading.
    pub fn course(&self) -> Planar {
        let (n, mut out, mut sin, mut cos) = (self.clip.num_frames() as f32, Planar::IDENTITY, 0.0, 0.0);
        for f in 0..self.clip.num_frames() {
            let p = self.clip.root_positions[f];
            let (s, c) = maths::sin_cos(twist_about_y(self.clip.hips_rotation(f)));
            (out.x, out.z, sin, cos) = (out.x + p.x / n, out.z + p.z / n, sin + s, cos + c);
        }
        Planar { heading: maths::atan2(sin, cos), ..out }
    }
}

/// Straightens elbows whose hands are held before the body, and turns arms that are held out at their shoulders, so that they hang.
/// Hands on hips and folded ones stay, except for those of runners.
fn hang_arms(rotations: &mut [Quat; NUM_JOINTS], skeleton: &Skeleton, runs: bool) {
    let joints_of = |rotations: &[Quat; NUM_JOINTS]| {
        Clip::new("stand", 1.0, vec![Vec3::Y], rotations.to_vec()).joint_transforms(skeleton, 0)
    };
    let at = joints_of(rotations).map(|(at, _)| at);
    for [_, elbow, wrist] in ARMS.map(|arm| arm.map(Joint::index)) {
        let [hips, neck] = [Joint::Hips, Joint::Neck].map(|j| at[j.index()]);
        let away_m = distance_to_segment(at[wrist], [hips, neck]);
        let bend = rotations[elbow].angle_between(Quat::IDENTITY);
        if away_m > AT_BODY_M && bend > HANGING_ELBOW {
            rotations[elbow] = maths::slerp_f32(Quat::IDENTITY, rotations[elbow], HANGING_ELBOW / bend);
        }
    }
    let joints = joints_of(rotations);
    let at = joints.map(|(at, _)| at);
    for arm in ARMS {
        let [shoulder, _, wrist] = arm.map(Joint::index);
        let reach = (at[wrist] - at[shoulder]).normalize_or(Vec3::NEG_Y);
        if !is_held_out(&at, arm) && (!runs || -reach.y > HANGS[1]) {
            continue;
        }
        let hangs = reach.with_y(0.0).normalize_or_zero() * HANGS[0] - Vec3::Y * HANGS[1];
        let above = arm[0].parent().map_or(Quat::IDENTITY, |j| joints[j.index()].1);
        let turned = maths::compose(Quat::from_rotation_arc(reach, hangs), joints[shoulder].1);
        rotations[shoulder] = maths::compose(above.inverse(), turned).normalize();
    }
}

/// Height of the hips over feet on the ground whose legs are as straight as those of a gait at their straightest (m).
fn standing_height(
    gait: &GaitCycle,
    cycle: FrameRange,
    skeleton: &Skeleton,
    rotations: &[Quat; NUM_JOINTS],
    feet: &[MadeFoot; 2],
) -> f32 {
    let legs = LEGS.map(|leg| leg.map(Joint::index));
    let longest = |[thigh, _, ankle, _]: [usize; 4]| {
        let of = |f: usize| {
            let at = gait.clip.joint_positions(skeleton, f);
            at[thigh].distance(at[ankle])
        };
        cycle.clone().map(of).fold(0.0, f32::max)
    };
    let of_leg = |foot: usize| {
        let hip = rotations[0] * skeleton.offsets[legs[foot][0]];
        let to = ankle_of(&feet[foot], skeleton, foot) - hip;
        let reach = longest(legs[foot]);
        to.y + (reach * reach - to.x * to.x - to.z * to.z).max(0.0).sqrt()
    };
    of_leg(0).min(of_leg(1))
}

/// Unrest of some frames; `None` if they do not stand upright and at ease.
fn unrest(clip: &Clip, skeleton: &Skeleton, window: &FrameRange, rest: &[Vec3; NUM_JOINTS]) -> Option<f32> {
    let mut before: Option<[Vec3; NUM_JOINTS]> = None;
    let (mut moved, mut arms) = (0.0, 0.0);
    for f in window.clone() {
        let at = clip.joint_positions(skeleton, f);
        let high = |j: Joint, share: f32| at[j.index()].y > share * rest[j.index()].y;
        let feet = [0, 1].map(|foot| foot_point(clip, skeleton, f, foot).planar());
        let apart = (feet[0].x - feet[1].x).hypot(feet[0].z - feet[1].z);
        let turned = throng_core::planar::wrap_angle(feet[0].heading - feet[1].heading).abs();
        let upright = high(Joint::Hips, UPRIGHT[0]) && high(Joint::Head, UPRIGHT[1]);
        if !upright || holds_arm_out(&at) || apart > FEET_APART.0 || turned > FEET_APART.1 {
            return None;
        }
        for [shoulder, _, hand] in ARMS {
            let reach = at[hand.index()] - at[shoulder.index()];
            arms += 1.0 + reach.y / reach.length().max(1e-3);
        }
        if let Some(was) = before.replace(at) {
            let all = at.iter().zip(&was).map(|(a, b)| a.distance(*b)).sum::<f32>();
            moved += all * clip.rate_hz as f32 / NUM_JOINTS as f32;
        }
    }
    let n = window.len() as f32;
    Some(moved / n + 0.3 * arms / n)
}

/// The first few whose poses are unlike those before them.
fn pick_unlike<'a, T>(all: impl Iterator<Item = &'a T>, pose: impl Fn(&'a T) -> &'a [Quat]) -> Vec<&'a T> {
    let mut out: Vec<&T> = Vec::new();
    for item in all {
        let is_new = out.iter().copied().all(|o| pose_distance(pose(o), pose(item)) > OTHER_STANCE);
        if out.len() < MAX_STANCES && is_new {
            out.push(item);
        }
    }
    out
}

/// Mean angle between the joints of two poses (rad).
fn pose_distance(a: &[Quat], b: &[Quat]) -> f32 {
    a.iter().zip(b).skip(1).map(|(a, b)| a.angle_between(*b)).sum::<f32>() / (NUM_JOINTS - 1) as f32
}

/// Frames of a clip as a clip.
pub(super) fn cut(clip: &Clip, range: FrameRange) -> Clip {
    let rotations = clip.rotations[range.start * NUM_JOINTS..range.end * NUM_JOINTS].to_vec();
    let contacts = clip.contacts[range.clone()].to_vec();
    let class = clip.class_at(range.start).cloned().unwrap_or(MotionClass { neutral: true, ..Default::default() });
    let classes = vec![ClassSpan { frames: 0..range.len() as u32, class, speed_mps: 0.0, travel_deg: 0.0 }];
    Clip {
        contacts,
        classes,
        ..Clip::new(clip.name.clone(), clip.rate_hz, clip.root_positions[range].to_vec(), rotations)
    }
}
