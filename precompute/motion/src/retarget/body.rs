//! Geometry of a source skeleton: the joints of its roles and their hierarchy, sampled over its clips.

use crate::import::{Forward, ImportedClip, LEG_DOWN, LEG_SEGMENTS};
use crate::raw::RawClip;
use glam::{Quat, Vec3};
use throng_base::{maths, thresholds::RIG_FOOT_PLANTED_MPS};
use throng_core::{Joint, NUM_JOINTS};

/// Source joint of every role (NUM_JOINTS).
pub type Roles = [Option<usize>; NUM_JOINTS];

/// A clip and the roles of its joints.
#[derive(Clone, Copy, Debug)]
pub struct RetargetSource<'a> {
    /// The motion as read.
    pub clip: &'a RawClip,
    /// Source joint of each role.
    pub roles: &'a Roles,
    /// Heading that the rest pose faces where it is given; else it is found from the thighs (rad).
    pub heading: Option<f32>,
    /// Rotation that turns the motion upright where its floor was tilted.
    pub turn: Option<Quat>,
}

impl<'a> From<&'a ImportedClip> for RetargetSource<'a> {
    fn from(imported: &'a ImportedClip) -> Self {
        let heading = imported.forward.map(Forward::heading);
        Self { clip: &imported.clip, roles: &imported.roles.joints, heading, turn: None }
    }
}

/// World position and rotation of every role; absent roles repeat their nearest present ancestor.
pub type RolePose = [(Vec3, Quat); NUM_JOINTS];

/// Number of frames sampled over all clips of a skeleton, to measure what its offsets alone do not show.
const MAX_SAMPLES: usize = 3000;

/// A sampled frame.
#[derive(Clone, Debug)]
pub struct PoseSample {
    /// World transforms of the roles.
    pub pose: RolePose,
    /// True where ankle and toe of the left, and of the right foot hardly move.
    pub still_feet: [bool; 2],
}

/// The geometry of one source skeleton. Retargeting a clip needs only the serialised part.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SourceBody {
    /// Source joint of every role.
    pub roles: Roles,
    /// Rest transforms of the roles, turned about the vertical so that the left side is +X.
    /// `None` where the rest pose is not a standing body.
    #[serde(skip)]
    pub rest: Option<RolePose>,
    /// Position of every present role in the axes of its anchor (see [`anchor`]): the mean over the samples,
    /// exact where the source is rigid there (m).
    pub offsets: [Vec3; NUM_JOINTS],
    /// Ends of head and toes in the axes of their joints, where the source has them (m).
    pub tips: [Option<Vec3>; 3],
    /// Ends of the hands in the axes of their joints, where the source has them (m).
    pub hand_tips: [Option<Vec3>; 2],
    /// Sampled frames.
    #[serde(skip)]
    pub samples: Vec<PoseSample>,
}

/// The nearest ancestor of `j` whose role is present; the hips where there is none.
pub fn anchor(roles: &Roles, j: Joint) -> Joint {
    let mut above = std::iter::successors(j.parent(), |p| p.parent());
    above.find(|p| roles[p.index()].is_some()).unwrap_or(Joint::Hips)
}

/// World transforms of the roles at one frame; `scratch` is reused between calls.
pub fn role_pose(source: RetargetSource, frame: usize, scratch: &mut Vec<(Vec3, Quat)>) -> RolePose {
    let n = source.clip.joints.len();
    let base = frame * n;
    let clip = source.clip;
    chain(source, scratch, |j| {
        let (t, r) = (clip.translations[base + j], clip.rotations[base + j]);
        let turn = source.turn.filter(|_| clip.joints[j].parent.is_none());
        turn.map_or((t, r), |turn| (turn * t, maths::compose(turn, r).normalize()))
    })
}

fn chain(source: RetargetSource, world: &mut Vec<(Vec3, Quat)>, local: impl Fn(usize) -> (Vec3, Quat)) -> RolePose {
    world.clear();
    for (j, joint) in source.clip.joints.iter().enumerate() {
        let (t, r) = local(j);
        let w =
            joint.parent.map_or((t, r), |p| (world[p].0 + world[p].1 * t, maths::compose(world[p].1, r).normalize()));
        world.push(w);
    }
    // The joint that plays the role, or the one that its nearest present ancestor plays.
    Joint::ALL.map(|j| world[source.roles[j.index()].or(source.roles[anchor(source.roles, j).index()]).unwrap_or(0)])
}

impl SourceBody {
    /// Measures the skeleton that all of `sources` share.
    pub fn measure(sources: &[RetargetSource]) -> Self {
        let first = sources[0];
        let samples = sample_frames(sources);
        let rest = chain(first, &mut Vec::new(), |j| (first.clip.joints[j].offset, first.clip.joints[j].rest_rotation));
        let tip = |j: Joint| first.roles[j.index()].and_then(|s| tip_of(first.clip, s));
        Self {
            roles: *first.roles,
            rest: standing_pose(rest, first.heading),
            offsets: mean_offsets(first.roles, &samples),
            tips: [tip(Joint::Head), tip(Joint::LeftToe), tip(Joint::RightToe)],
            hand_tips: [tip(Joint::LeftHand), tip(Joint::RightHand)],
            samples,
        }
    }

    /// True where the source plays the role.
    pub fn has(&self, j: Joint) -> bool {
        self.roles[j.index()].is_some()
    }

    /// Mean of a world vector in the axes of `j`, over the samples that give one; `None` where they cancel out.
    pub fn mean_local(&self, j: Joint, world: impl Fn(&PoseSample) -> Option<Vec3>) -> Option<Vec3> {
        let sum: Vec3 = self.samples.iter().filter_map(|s| world(s).map(|v| s.pose[j.index()].1.inverse() * v)).sum();
        sum.try_normalize()
    }

    /// Thigh plus shin, the mean of both sides (m).
    pub fn leg_length(&self) -> f32 {
        use Joint::*;
        [LeftShin, LeftFoot, RightShin, RightFoot].iter().map(|j| self.offsets[j.index()].length()).sum::<f32>() * 0.5
    }
}

/// Up to [`MAX_SAMPLES`] frames, spread evenly over all clips.
fn sample_frames(sources: &[RetargetSource]) -> Vec<PoseSample> {
    let total: usize = sources.iter().map(|s| s.clip.num_frames).sum();
    let stride = total.div_ceil(MAX_SAMPLES).max(1);
    let mut scratch = Vec::new();
    let mut out = Vec::new();
    for source in sources {
        for frame in (0..source.clip.num_frames).step_by(stride) {
            let pose = role_pose(*source, frame, &mut scratch);
            let next = (frame + 1).min(source.clip.num_frames - 1);
            let ahead = role_pose(*source, next, &mut scratch);
            let rate = source.clip.rate_hz as f32;
            let slow = |j: Joint| (ahead[j.index()].0 - pose[j.index()].0).length() * rate < RIG_FOOT_PLANTED_MPS;
            let still_feet =
                [slow(Joint::LeftFoot) && slow(Joint::LeftToe), slow(Joint::RightFoot) && slow(Joint::RightToe)];
            out.push(PoseSample { pose, still_feet });
        }
    }
    out
}

/// Mean position of every present role in its anchor's axes.
fn mean_offsets(roles: &Roles, samples: &[PoseSample]) -> [Vec3; NUM_JOINTS] {
    let mut sums = [glam::DVec3::ZERO; NUM_JOINTS];
    for s in samples {
        for &j in &Joint::ALL[1..] {
            let (p, r) = s.pose[anchor(roles, j).index()];
            sums[j.index()] += (r.inverse() * (s.pose[j.index()].0 - p)).as_dvec3();
        }
    }
    sums.map(|v| (v / samples.len().max(1) as f64).as_vec3())
}

/// Offset of the child of `joint` that starts the longest chain, where it has a length: the middle finger of a hand.
fn tip_of(clip: &RawClip, joint: usize) -> Option<Vec3> {
    let n = clip.joints.len();
    let mut reach = vec![0f32; n];
    for j in (joint + 1..n).rev() {
        reach[j] += clip.joints[j].offset.length();
        if let Some(p) = clip.joints[j].parent {
            reach[p] = reach[p].max(reach[j]);
        }
    }
    let children = (joint + 1..n).filter(|&j| clip.joints[j].parent == Some(joint));
    let longest = children.max_by(|&a, &b| reach[a].total_cmp(&reach[b]).then(b.cmp(&a)))?;
    let offset = clip.joints[longest].offset;
    (offset.length() > 0.005).then_some(offset)
}

/// The pose turned so that its left side is +X, or by the heading that is given, where it is a standing body by the rules of
/// import.
fn standing_pose(pose: RolePose, heading: Option<f32>) -> Option<RolePose> {
    let at = |j: Joint| pose[j.index()].0;
    use Joint::*;
    let down = |(a, b)| (at(b) - at(a)).normalize_or_zero().y < -LEG_DOWN;
    let legs = LEG_SEGMENTS.into_iter().all(down);
    let trunk = (at(Head) - at(Hips)).normalize_or_zero().y > 0.7;
    let left = at(LeftThigh) - at(RightThigh);
    if !(legs && trunk && left.length() > 0.02 && left.normalize().y.abs() < 0.3) {
        return None;
    }
    // A direction (x, z) turned by the angle atan2(z, x) about +Y lies along +X.
    let turn = Quat::from_rotation_y(heading.map_or_else(|| left.z.atan2(left.x), |h| -h));
    Some(pose.map(|(p, r)| (turn * p, maths::compose(turn, r))))
}
