//! Joints of a character that move, and how each does.

use super::Wearer;
use crate::retarget::{BodyFit, WornPose};
use crate::{export::Take, export::scratch::TrackScratch, import::RoleMap, raw::RawClip};
use glam::{DAffine3, DQuat, DVec3, Quat, Vec3};
use std::io;
use throng_base::maths;
use throng_core::skeleton::{ARMS, LEGS};
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_geometry::share_along;

/// Height of a character over that of the body whose motion it wears, at most: one with shorter legs keeps its hips lower.
const MOST_TALLER: f32 = 1.05;
/// Parts of the names of joints that take a share of a twist.
const TWIST_NAMES: [&str; 2] = ["twist", "roll"];

/// A joint that moves.
pub struct MovedJoint {
    /// Index in the rig.
    pub joint: usize,
    drive: JointDrive,
}

enum JointDrive {
    /// Turns as a role does. A joint that carries all of the body, where that is not the hips' joint, turns as the hips do.
    Role(Joint),
    /// Turns with a share of the twist of a limb.
    Twist(TwistShare),
}

/// A share of the twist of a limb.
struct TwistShare {
    limb: Joint,
    /// The joint whose twist is shared.
    source: Joint,
    /// Direction along the limb in a T-pose (unit).
    axis: Vec3,
    /// Share of the twist (-1 to 1).
    share: f32,
}

impl MovedJoint {
    /// The joint that it goes with.
    pub fn carrier(&self) -> Joint {
        match &self.drive {
            JointDrive::Role(joint) => *joint,
            JointDrive::Twist(twist) => twist.limb,
        }
    }

    /// True where it has a share of a twist.
    pub fn is_twist(&self) -> bool {
        matches!(self.drive, JointDrive::Twist(_))
    }
}

/// The joint that carries all joints with roles or skin: that of the hips, or one above it where the spine does not hang on
/// those, or where a joint above carries skin of its own.
///
/// - `skinned`: joints that carry skin.
pub fn centre_joint(clip: &RawClip, roles: &RoleMap, skinned: &[usize]) -> usize {
    let up = |joint: usize| std::iter::successors(Some(joint), |&j| clip.joints[j].parent);
    let hips = roles.get(Joint::Hips).unwrap_or(0);
    let all = || roles.joints.iter().flatten().chain(skinned);
    let carries = |joint: usize| all().all(|&j| up(j).any(|above| above == joint));
    up(hips).find(|&j| carries(j)).unwrap_or(hips)
}

/// The joints that move, parents first.
///
/// - `centre`: joint that [`centre_joint`] finds.
pub fn find_moved_joints(clip: &RawClip, roles: &RoleMap, fit: &BodyFit, centre: usize) -> Vec<MovedJoint> {
    let world = clip.world(0);
    let role_of = |joint: usize| {
        let role = Joint::ALL.into_iter().find(|r| roles.get(*r) == Some(joint));
        role.or((joint == centre).then_some(Joint::Hips))
    };
    let mut out = Vec::new();
    for joint in 0..clip.joints.len() {
        if let Some(role) = role_of(joint) {
            out.push(MovedJoint { joint, drive: JointDrive::Role(role) });
            continue;
        }
        let name = clip.joints[joint].name.to_lowercase();
        if !TWIST_NAMES.iter().any(|n| name.contains(n)) {
            continue;
        }
        let above = std::iter::successors(clip.joints[joint].parent, |&p| clip.joints[p].parent).find_map(role_of);
        // Thighs and upper arms twist at their begin, shins and forearms at their end.
        let legs = LEGS.map(|[thigh, shin, foot, _]| [thigh, shin, foot]);
        let mut limbs = legs.into_iter().chain(ARMS).flat_map(|[a, b, end]| [(a, b, true), (b, end, false)]);
        let Some((limb, end, at_begin)) = limbs.find(|l| Some(l.0) == above) else { continue };
        let (Some(from), Some(to)) = (roles.get(limb), roles.get(end)) else { continue };
        let along = share_along(world[joint].0, [world[from].0, world[to].0]);
        let axis = fit.t_pose_offset(limb, end).normalize_or(Vec3::X);
        let (of, share) = if at_begin { (limb, along - 1.0) } else { (end, along) };
        out.push(MovedJoint { joint, drive: JointDrive::Twist(TwistShare { limb, source: of, axis, share }) });
    }
    out
}

/// The angle by which a rotation turns about an axis before it swings the axis (rad).
fn twist_about(rotation: Quat, axis: Vec3) -> f32 {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    2.0 * rotation.xyz().dot(axis).atan2(rotation.w)
}

impl TwistShare {
    /// World rotation that is added to that of the joint it hangs on.
    fn turn(&self, model: &[Quat]) -> Quat {
        let above = self.source.parent().map_or(Quat::IDENTITY, |p| model[p.index()]);
        let angle = self.share * twist_about(maths::compose(above.inverse(), model[self.source.index()]), self.axis);
        let limb = model[self.limb.index()];
        maths::compose(maths::compose(limb, Quat::from_axis_angle(self.axis, angle)), limb.inverse())
    }
}

/// The character in the size that a skeleton asks for.
pub struct ScaledWearer<'a> {
    wearer: &'a Wearer,
    /// Skeleton of the motion.
    pub own: &'a Skeleton,
    fit: BodyFit,
    /// Scale of the character relative to its file.
    pub scale: f64,
    /// Transform from the world to the frame of the centre.
    back: DAffine3,
    /// Rotation of that frame.
    turn: DQuat,
    /// Joints from the hips' up to below the centre.
    below: Vec<usize>,
}

impl<'a> ScaledWearer<'a> {
    /// - `own`: skeleton of the motion.
    pub fn new(wearer: &'a Wearer, own: &'a Skeleton) -> Self {
        let tallest = MOST_TALLER * own.height() / wearer.height_m;
        let growth = f64::from((own.leg_length() / wearer.fit.skeleton.leg_length()).min(tallest));
        Self::with_growth(wearer, own, growth)
    }

    /// - `growth`: its size over that of its file (1).
    pub fn with_growth(wearer: &'a Wearer, own: &'a Skeleton, growth: f64) -> Self {
        let (clip, (frame, turn)) = (&wearer.rig.clip.clip, wearer.above_centre());
        let hips = wearer.roles.get(Joint::Hips).unwrap_or(wearer.centre);
        let up = std::iter::successors(Some(hips), |&j| clip.joints[j].parent);
        Self {
            wearer,
            own,
            fit: wearer.fit.scaled(growth as f32),
            scale: growth * wearer.metres_per_unit,
            back: frame.inverse(),
            turn,
            below: up.take_while(|&j| j != wearer.centre).collect(),
        }
    }

    /// Number of joints that move.
    pub fn num_moved(&self) -> usize {
        self.wearer.moved.len()
    }

    /// The numbers by which the character moves: rotations of the joints that do, and the position of the centre, each in the
    /// frame of its parent.
    ///
    /// - `pose`: world transforms of the skeleton's joints; `before`: numbers of the frame before, whose signs of rotations are
    ///   kept.
    pub fn numbers(&self, pose: &[(Vec3, Quat); NUM_JOINTS], before: Option<&[f32]>) -> Vec<f32> {
        let (wearer, clip) = (self.wearer, &self.wearer.rig.clip.clip);
        let worn = self.fit.wear_pose(self.own, pose);
        let world = joint_turns(wearer, clip, &worn);
        let mut numbers = Vec::with_capacity(4 * wearer.moved.len() + 3);
        for m in &wearer.moved {
            let axes = |j: usize| (world[j] * wearer.rig.axes[j]).normalize();
            let parent = clip.joints[m.joint].parent.map_or(self.turn, axes);
            let local = (parent.inverse() * axes(m.joint)).normalize().as_quat();
            let sign = before.map_or(1.0, |b| {
                let then = Quat::from_slice(&b[numbers.len()..numbers.len() + 4]);
                if then.dot(local) < 0.0 { -1.0 } else { 1.0 }
            });
            numbers.extend((local * sign).to_array());
        }
        let offset = |j: &usize| world[clip.joints[*j].parent.unwrap_or(0)] * clip.translations[*j].as_dvec3();
        let centre = worn.hips.as_dvec3() / self.scale - self.below.iter().map(offset).sum::<DVec3>();
        numbers.extend(self.back.transform_point3(centre).as_vec3().to_array());
        numbers
    }
}

/// Records the motion of all joints of a character in a take: rotations of those that move, and the position of the hips.
pub fn record_worn_motion(wearer: &Wearer, take: &Take, actor: usize, scratch: &mut TrackScratch) -> io::Result<()> {
    let sized = ScaledWearer::new(wearer, &take.actors()[actor].skeleton);
    let mut before: Option<Vec<f32>> = None;
    take.poses(actor, |_, pose, _| {
        let numbers = sized.numbers(&pose.world_transforms(), before.as_deref());
        scratch.push(actor, &numbers)?;
        before = Some(numbers);
        Ok(())
    })?;
    scratch.finish(actor)
}

/// World rotation of every joint of the rig relative to rest.
fn joint_turns(wearer: &Wearer, clip: &RawClip, worn: &WornPose) -> Vec<DQuat> {
    let mut moved = wearer.moved.iter().peekable();
    let mut world: Vec<DQuat> = Vec::with_capacity(clip.joints.len());
    for (j, joint) in clip.joints.iter().enumerate() {
        let rest = clip.rotations[j].as_dquat();
        let follows = joint.parent.map_or(rest, |p| world[p] * rest);
        world.push(match moved.next_if(|m| m.joint == j).map(|m| &m.drive) {
            Some(JointDrive::Role(role)) => worn.joints[role.index()].as_dquat(),
            Some(JointDrive::Twist(twist)) => twist.turn(&worn.model).as_dquat() * follows,
            None => follows,
        });
    }
    world
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twists_are_told_from_swings() {
        for angle in [-2.0f32, -0.3, 0.0, 0.7, 3.0] {
            let swing = Quat::from_rotation_arc(Vec3::X, Vec3::new(0.6, 0.0, 0.8));
            let got = twist_about(swing * Quat::from_rotation_x(angle), Vec3::X);
            assert!((got - angle).abs() < 1e-5, "{angle}: {got}");
        }
    }
}
