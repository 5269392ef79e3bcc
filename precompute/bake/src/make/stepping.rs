//! Steps along a course: a gait's swings carry the feet from place to place, a stance gives what is at rest.
//!
//! Every stay of a foot on the ground has a place of its own: that of the gait as seen from the course at the moment at
//! which the foot is flat. Planted feet move within their place as they do in the gait, so that they slide no more; a
//! foot in the air goes from one place to the next as far as it has come in the gait.

use super::feet::{MadeFoot, foot_point};
use super::gait::{FootStay, GaitCycle, lerp_planar};
use super::{smooth, stance::RestStance};
use glam::{Quat, Vec2, Vec3};
use throng_base::maths;
use throng_core::{Contacts, Joint, NUM_JOINTS, Planar, Skeleton, planar::wrap_angle};
use throng_motion::retarget::{LEGS, bend_leg};
use throng_motion::{Clip, joint_transforms};

/// Share of a gait's swing that even the slowest step has, so that feet clear the ground, and speed of a gait from which
/// they do so with less (m/s).
const LEAST_SWING: (f32, f32) = (0.45, 1.3);
/// Time in which a foot rolls off its first stand, and comes to rest on its last (s).
const ROLL_S: f32 = 0.3;
/// Share of the roll of a gait below which a foot stands flat.
const FLAT: f32 = 0.03;
/// Turn of the body over a planted foot from which the foot turns with it (rad).
const TWIST: f32 = 0.4;
/// Longest leg, as a share of its length.
const STRAIGHT_LEG: f32 = 0.992;
/// Share of the way to the standing foot that hips move aside before a first step, and times before and after it (s).
const SHIFT: f32 = 0.35;
const SHIFT_S: [f32; 2] = [0.3, 0.2];
/// Share of a lean that neck and head each take back.
const UPRIGHT_HEAD: f32 = 0.3;
/// Frames from captured ones to those that are corrected wholly.
const FREE: f32 = 6.0;
/// Frames by which hips go down before a leg would be too short; twice as many change.
const LOWER: usize = 4;

/// A pose.
#[derive(Clone, Debug)]
pub(super) struct CoursePose {
    /// Position of the hips (m).
    pub hips: Vec3,
    /// Rotations relative to the parents; the hips' in the world.
    pub rotations: [Quat; NUM_JOINTS],
}

/// A course to walk, frame by frame.
pub(super) struct MadeCourse {
    /// Frame of the gait, ascending (num_frames).
    pub gait_at: Vec<usize>,
    /// Frame of the stance (num_frames).
    pub stance_at: Vec<usize>,
    /// Share of the gait in the pose (0 to 1; num_frames).
    pub weight: Vec<f32>,
    /// Lean to the left of the way (rad; num_frames, or none).
    pub lean: Vec<f32>,
    /// Mean place and heading (num_frames).
    pub path: Vec<Planar>,
    /// True if it begins, and ends, in the stance.
    pub stands: [bool; 2],
    /// Last frame of a begin, and first frame of an end, that goes as the gait does.
    pub captured: [usize; 2],
    /// Most steps before it stands.
    pub num_swings: usize,
}

/// A step of a foot.
#[derive(Clone, Copy, Debug)]
struct StepSwing {
    foot: usize,
    /// Stay of the gait that it ends.
    from: usize,
    /// Last frame on the ground before it, and first one after it; the number of frames if it is not over.
    lift: Option<usize>,
    land: usize,
}

/// A stay of a foot on the ground, in frames of the course.
#[derive(Clone, Copy, Debug)]
struct CourseStay {
    first: usize,
    last: usize,
    /// Stay of the gait that it plays.
    of_gait: usize,
    /// Frame at which the foot is flat, and its place then.
    flat: usize,
    base: Planar,
}

impl CourseStay {
    /// Place of the foot at a frame: it turns on its ball where the body would twist the leg.
    fn place(&self, path: &[Planar], f: usize) -> Planar {
        let f = f.clamp(self.first, self.last.max(self.first)).min(path.len() - 1);
        let twist = wrap_angle(path[f].heading - path[self.flat].heading);
        let over = (twist.abs() - TWIST).max(0.0);
        let turn = (over * over / (over + 0.3)).copysign(twist);
        Planar { heading: self.base.heading + turn, ..self.base }
    }

    /// True where the foot turns on its ball.
    fn turns(&self, path: &[Planar], f: usize) -> bool {
        let by = self.place(path, f + 1).heading - self.place(path, f.saturating_sub(1)).heading;
        by.abs() > 0.02
    }
}

/// Walks a course.
pub(super) struct CourseWalker<'a> {
    pub gait: &'a GaitCycle,
    pub stance: &'a RestStance,
    pub skeleton: &'a Skeleton,
    pub course: &'a MadeCourse,
}

impl CourseWalker<'_> {
    /// The clip of the course; `None` where the gait has too few steps for it.
    pub fn walk(&self) -> Option<Clip> {
        let n = self.course.path.len();
        let plants = [0, 1].map(|foot| self.gait.plants(self.skeleton, foot));
        let swings = self.swings(&plants);
        if plants.iter().any(Vec::is_empty) {
            return None;
        }
        let feet = [0, 1].map(|foot| self.made_plants(foot, &plants[foot], &swings));
        let mut poses: Vec<CoursePose> = (0..n).map(|f| self.body(f)).collect();
        self.shift_weight(&mut poses, &swings, &feet);
        let mut goals = Vec::with_capacity(n);
        let mut contacts = vec![Contacts::NONE; n];
        for f in 0..n {
            goals.push([0, 1].map(|foot| {
                let (at, bits) = self.foot(f, foot, &plants[foot], &feet[foot], &swings);
                contacts[f].insert(bits);
                at
            }));
        }
        self.lower(&mut poses, &goals);
        let (mut roots, mut rotations) = (Vec::with_capacity(n), Vec::<Quat>::with_capacity(n * NUM_JOINTS));
        for (pose, goals) in poses.iter_mut().zip(&goals) {
            reach_feet(pose, self.skeleton, goals);
            roots.push(pose.hips);
            for q in pose.rotations {
                let before = rotations.len().checked_sub(NUM_JOINTS).map(|k| rotations[k]);
                rotations.push(if before.is_some_and(|b| b.dot(q) < 0.0) { -q } else { q });
            }
        }
        Some(Clip { contacts, ..Clip::new("made", self.gait.clip.rate_hz, roots, rotations) })
    }

    /// Share of corrections that a frame takes: none where the gait goes on as captured, all some frames on.
    fn free_share(&self, f: usize) -> f32 {
        let ([begin, end], [from_stand, to_stand]) = (self.course.captured, self.course.stands);
        let from = if from_stand { 1.0 } else { smooth((f as f32 - begin as f32) / FREE) };
        let to = if to_stand { 1.0 } else { smooth((end as f32 - f as f32) / FREE) };
        from * to
    }

    /// The pose above the feet.
    fn body(&self, f: usize) -> CoursePose {
        let (g, s, share) = (self.course.gait_at[f], self.course.stance_at[f], self.course.weight[f]);
        let path = self.course.path[f];
        let part = |clip: &Clip, frame: usize, course: Planar| {
            let turn = maths::compose(maths::rotation_y(-course.heading), clip.hips_rotation(frame));
            (course.to_local(clip.planar(frame)), clip.root_positions[frame].y, turn)
        };
        let (still, low, calm) = part(&self.stance.clip, s, self.stance.course());
        let (goes, high, moves) = part(&self.gait.clip, g, self.gait.course(g));
        let at = path.compose(lerp_planar(still, goes, share));
        let (from, to) = (self.stance.clip.frame_rotations(s), self.gait.clip.frame_rotations(g));
        let rotations = std::array::from_fn(|j| match j {
            0 => maths::compose(maths::rotation_y(path.heading), maths::slerp_f32(calm, moves, share)).normalize(),
            _ => maths::slerp_f32(from[j], to[j], share),
        });
        let mut pose = CoursePose { hips: Vec3::new(at.x, low + share * (high - low), at.z), rotations };
        if let Some(lean) = self.course.lean.get(f) {
            self.lean(&mut pose, path, *lean);
        }
        pose
    }

    /// Leans a body to the left of its way, about the ground below it; its head stays more upright.
    fn lean(&self, pose: &mut CoursePose, path: Planar, lean: f32) {
        let [aside, ahead] = self.gait.travel;
        let along = maths::rotation_y(path.heading + maths::atan2(aside, ahead));
        let turn = maths::compose(maths::compose(along, maths::rotation_z(-lean)), along.conjugate());
        let ground = Vec3::new(path.x, 0.0, path.z);
        pose.hips = ground + maths::rotate(turn, pose.hips - ground);
        pose.rotations[0] = maths::compose(turn, pose.rotations[0]).normalize();
        for joint in [Joint::Neck, Joint::Head].map(Joint::index) {
            pose.rotations[joint] = maths::compose(maths::rotation_z(UPRIGHT_HEAD * lean), pose.rotations[joint]);
        }
    }

    /// Steps of both feet, in order.
    fn swings(&self, plants: &[Vec<FootStay>; 2]) -> Vec<StepSwing> {
        let (at, n) = (&self.course.gait_at, self.course.path.len());
        let mut out = Vec::new();
        for (foot, plants) in plants.iter().enumerate() {
            for (from, w) in plants.windows(2).enumerate() {
                let lift = at.partition_point(|&g| g <= w[0].last).checked_sub(1).filter(|_| !w[0].in_air);
                let land = at.partition_point(|&g| g < w[1].first);
                let is_begun = land > 0 && (lift.is_some() || !self.course.stands[0]);
                if is_begun && lift.is_none_or(|l| l + 1 < n) {
                    out.push(StepSwing { foot, from, lift, land });
                }
            }
        }
        out.sort_by_key(|s| (s.lift, s.foot));
        if self.course.stands[1] {
            let begun = out.iter().filter(|s| s.lift.is_none()).count();
            out.truncate(self.course.num_swings.saturating_add(begun));
        }
        out
    }

    /// Stays of a foot on the ground.
    fn made_plants(&self, foot: usize, plants: &[FootStay], swings: &[StepSwing]) -> Vec<CourseStay> {
        let (course, last) = (self.course, self.course.path.len() - 1);
        let first_of_gait = plants.partition_point(|p| p.last < course.gait_at[0]).min(plants.len().saturating_sub(1));
        let own: Vec<&StepSwing> = swings.iter().filter(|s| s.foot == foot).collect();
        let mut stays: Vec<(usize, usize, usize)> = Vec::new();
        let mut from = (0, own.first().map_or(first_of_gait, |s| s.from));
        for s in &own {
            if let Some(lift) = s.lift {
                stays.push((from.0, lift, from.1));
            }
            from = (s.land, s.from + 1);
        }
        // A foot that is in the air at the end has a place to land on.
        stays.push((from.0, last.max(from.0), from.1));
        let n = stays.len();
        let stance = self.stance_foot(foot);
        let place = |(k, (first, end, of_gait)): (usize, (usize, usize, usize))| {
            let plant = &plants[of_gait.min(plants.len() - 1)];
            let flat = course.gait_at.partition_point(|&g| g < plant.flat).min(last);
            let (flat, base) = if k == 0 && course.stands[0] {
                (0, course.path[0].compose(stance))
            } else if k + 1 == n && course.stands[1] {
                (last, course.path[last].compose(stance))
            } else if k == 0 && !course.stands[0] {
                // It stands, or its step had begun.
                (0, self.captured(0).compose(plant.base))
            } else if end >= course.captured[1] && !course.stands[1] {
                (last, self.captured(last).compose(plant.base))
            } else {
                let seen = self.gait.course(plant.flat).to_local(plant.base);
                (flat, course.path[flat].compose(lerp_planar(stance, seen, course.weight[flat])))
            };
            CourseStay { first, last: end, of_gait, flat, base }
        };
        stays.into_iter().enumerate().map(place).collect()
    }

    /// The world of the gait's clip, as it lies at a frame of the course.
    fn captured(&self, f: usize) -> Planar {
        self.course.path[f].compose(self.gait.course(self.course.gait_at[f]).inverse())
    }

    /// Place of a foot in the stance, as seen from its course.
    fn stance_foot(&self, foot: usize) -> Planar {
        let at = foot_point(&self.stance.clip, self.skeleton, self.course.stance_at[0], foot).planar();
        self.stance.course().to_local(at)
    }

    /// A foot at a frame, and its contacts.
    fn foot(
        &self,
        f: usize,
        foot: usize,
        plants: &[FootStay],
        made: &[CourseStay],
        swings: &[StepSwing],
    ) -> (MadeFoot, Contacts) {
        let (course, g) = (self.course, self.course.gait_at[f]);
        let [heel, toe] = Contacts::FEET[foot];
        let sole = Contacts(heel.0 | toe.0);
        let base = self.stance.course().compose(self.stance_foot(foot));
        let still = foot_point(&self.stance.clip, self.skeleton, course.stance_at[f], foot).seen_from(base);
        let least = LEAST_SWING.0 * (LEAST_SWING.1 / self.gait.speed_mps()).min(1.0);
        let share = least + (1.0 - least) * course.weight[f] * course.weight[f];
        let k = made.partition_point(|p| p.last < f).min(made.len() - 1);
        let stay = &made[k];
        let roll = |frames: usize| smooth(frames as f32 / self.gait.clip.rate_hz as f32 / ROLL_S);
        if f >= stay.first {
            let plant = &plants[stay.of_gait.min(plants.len() - 1)];
            let (begins, ends) = (k == 0 && course.stands[0], k + 1 == made.len() && course.stands[1]);
            let mut weight = share;
            let mut frame = g.clamp(plant.first, plant.last);
            if begins {
                let lift = if ends { usize::MAX } else { stay.last };
                weight *= 1.0 - roll(lift.saturating_sub(f).min(1000));
            }
            if ends {
                weight *= 1.0 - roll(f - stay.first);
                frame = frame.min(plant.flat);
            }
            let (_, goes) = self.gait.foot(self.skeleton, frame, foot, [plant; 2]);
            let bits = Contacts(self.gait.clip.contacts[frame].0 & sole.0);
            let bits = match (begins || ends, weight < FLAT, bits) {
                // While it rolls, it stands on its ball.
                (true, false, _) => toe,
                _ if stay.turns(&course.path, f) => toe,
                (false, _, bits) if bits != Contacts::NONE => bits,
                _ => sole,
            };
            return (still.lerp(&goes, weight).laid_at(stay.place(&course.path, f)), bits);
        }
        let swing = swings.iter().rfind(|s| s.foot == foot && s.lift.is_none_or(|l| l < f));
        let from = swing.map_or(0, |s| s.from).min(plants.len() - 1);
        let next = (from + 1).min(plants.len() - 1);
        let (step, goes) = self.gait.foot(self.skeleton, g, foot, [&plants[from], &plants[next]]);
        let start = match k {
            // The step had begun before.
            0 => self.captured(0).compose(plants[from].base),
            _ => made[k - 1].place(&course.path, f),
        };
        // A step that is not over where the gait goes on as captured ends as it does there.
        let end = course.captured[1];
        let start = match swing.filter(|s| !course.stands[1] && s.land > end) {
            Some(s) => {
                let lift = s.lift.unwrap_or(0);
                let share = smooth((f as f32 - lift as f32) / end.saturating_sub(lift).max(1) as f32);
                lerp_planar(start, self.captured(course.path.len() - 1).compose(plants[from].base), share)
            }
            None => start,
        };
        let land = stay.place(&course.path, f);
        (still.lerp(&goes, share).laid_at(lerp_planar(start, land, step)), Contacts::NONE)
    }

    /// Moves the hips over the foot that stands before another one leaves a stance.
    fn shift_weight(&self, poses: &mut [CoursePose], swings: &[StepSwing], feet: &[Vec<CourseStay>; 2]) {
        let rate = self.gait.clip.rate_hz as f32;
        for s in swings {
            let Some(lift) = s.lift else { continue };
            let land = s.land.min(poses.len() - 1);
            let idle = 1.0 - self.course.weight[(lift + land) / 2];
            let support = feet[1 - s.foot].iter().rfind(|p| p.first <= lift).or(feet[1 - s.foot].first());
            let Some(support) = support.filter(|_| idle > 0.0) else { continue };
            let path = self.course.path[(lift + land) / 2];
            let aside = path.inverse_transform_point(Vec2::new(support.base.x, support.base.z)).x;
            let along = path.rotation() * Vec3::X;
            for (f, pose) in poses.iter_mut().enumerate() {
                let before = 1.0 + (f as f32 - lift as f32) / (SHIFT_S[0] * rate);
                let after = 1.0 - (f as f32 - land as f32 + 0.3 * (land - lift) as f32) / (SHIFT_S[1] * rate);
                pose.hips += along * (SHIFT * idle * aside * smooth(before) * smooth(after) * self.free_share(f));
            }
        }
    }

    /// Lowers hips where a leg would not reach its foot.
    fn lower(&self, poses: &mut [CoursePose], goals: &[[MadeFoot; 2]]) {
        let need = |pose: &CoursePose, goals: &[MadeFoot; 2]| {
            let joints = joint_transforms(self.skeleton, pose.hips, |j| pose.rotations[j]);
            let of_leg = |foot: usize| {
                let [thigh, shin, ankle, _] = LEGS[foot].map(Joint::index);
                let hip = joints[thigh].0;
                let to = hip - ankle_of(&goals[foot], self.skeleton, foot);
                let whole = self.skeleton.offsets[shin].length() + self.skeleton.offsets[ankle].length();
                let most = (STRAIGHT_LEG * whole).max(joints[ankle].0.distance(hip));
                let below = (most * most - to.x * to.x - to.z * to.z).max(0.0).sqrt();
                (to.y - below).max(0.0)
            };
            of_leg(0).max(of_leg(1))
        };
        let needs: Vec<f32> = poses.iter().zip(goals).map(|(p, g)| need(p, g)).collect();
        let around = |f: usize, by: usize| f.saturating_sub(by)..(f + by + 1).min(needs.len());
        let most: Vec<f32> =
            (0..needs.len()).map(|f| needs[around(f, LOWER)].iter().copied().fold(0.0, f32::max)).collect();
        for (f, pose) in poses.iter_mut().enumerate() {
            let near = &most[around(f, LOWER)];
            pose.hips.y -= self.free_share(f) * near.iter().sum::<f32>() / near.len() as f32;
        }
    }
}

/// Position of the ankle of a foot.
pub(super) fn ankle_of(foot: &MadeFoot, skeleton: &Skeleton, side: usize) -> Vec3 {
    foot.toe - foot.turn * skeleton.offsets[LEGS[side][3].index()]
}

/// Turns legs and feet so that the feet are where they should be.
pub(super) fn reach_feet(pose: &mut CoursePose, skeleton: &Skeleton, feet: &[MadeFoot; 2]) {
    let joints = joint_transforms(skeleton, pose.hips, |j| pose.rotations[j]);
    let mut model = joints.map(|j| j.1);
    for (side, foot) in feet.iter().enumerate() {
        let leg = LEGS[side].map(Joint::index);
        let [thigh, shin, ankle, toe] = leg;
        bend_leg(skeleton, &mut model, [thigh, shin, ankle], joints[thigh].0, ankle_of(foot, skeleton, side));
        model[ankle] = foot.turn;
        let local = |model: &[Quat; NUM_JOINTS], of: usize, parent: usize| {
            maths::compose(model[parent].inverse(), model[of]).normalize()
        };
        pose.rotations[thigh] = local(&model, thigh, 0);
        pose.rotations[shin] = local(&model, shin, thigh);
        pose.rotations[ankle] = local(&model, ankle, shin);
        pose.rotations[toe] = foot.toes;
    }
}
