//! Nodes of scene files (glTF, FBX) and their animations, to clips: one for each person that an animation moves.
//!
//! Nodes have frames of their own at rest, and scales; joints of clips have neither. A clip therefore holds the world position
//! of each joint, and its rotation relative to rest. So nodes above a skeleton count for its root.

mod people;
mod rate;

use super::{FrameSink, MAX_NAME, SourceClip, content_error, duplicate_names, nearest_axis};
use crate::error::{ImportError, Warnings, ensure};
use crate::raw::{RawJoint, SourceFormat};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use people::ScenePerson;
#[cfg(feature = "fbx")]
pub(super) use rate::without_rounding;
pub(super) use rate::{FALLBACK_HZ, rate_of_keys};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Most clips of a file.
const MAX_CLIPS: usize = 10_000;
/// Numbers of transforms are smaller than this (units of the file).
const MAX_NUMBER: f64 = 1e9;
/// Share of a frame by which a time may miss a key (rounding of times).
const ON_FRAME: f64 = 0.01;
/// Joint transforms that any file may make, beside one for each byte: few keys may stand for long motion.
const FREE_TRANSFORMS: usize = 2 << 20;
/// Bytes of joints that all clips of a file may have together, for each byte of it and for every file: each clip has joints of
/// its own.
const JOINT_BYTES: usize = 64;
const FREE_JOINT_BYTES: usize = 256 << 20;

/// A node's frame in that of its parent: scaled, then rotated, then moved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    pub scale: DVec3,
    pub rotation: DQuat,
    pub translation: DVec3,
}

impl Transform {
    /// True where all numbers are moderate and the rotation is one; lengths of quaternions are made 1.
    fn normalized(mut self) -> Option<Self> {
        let moderate = |v: DVec3| v.is_finite() && v.abs().max_element() < MAX_NUMBER;
        let length = self.rotation.length();
        self.rotation /= length;
        (moderate(self.scale) && moderate(self.translation) && self.rotation.is_finite()).then_some(self)
    }
}

/// A node of a scene.
pub(crate) struct RigNode {
    pub name: String,
    pub parent: Option<usize>,
    /// Transform without animation.
    pub local: Transform,
    /// Rotation in the space in which the skin was bound to it, where the file has it.
    pub bind: Option<DQuat>,
    /// True where it shows something itself, such as a mesh.
    pub shows: bool,
}

/// Motion of nodes.
pub(super) trait NodeAnimation {
    fn name(&self) -> String;
    /// Nodes that it moves.
    fn moved(&self) -> &BTreeSet<usize>;
    /// Time span in which it moves any of some nodes.
    fn span(&self, nodes: &BTreeSet<usize>) -> AnimationSpan;
    /// Transform of a node that it moves, at a time (s); `rest`: its transform otherwise.
    fn local(&self, node: usize, seconds: f64, rest: Transform) -> Transform;
    /// Number of layers that are added up for a transform (1 or more).
    fn num_layers(&self) -> usize {
        1
    }
}

/// First and last time (s), and frames a second in between (Hz).
pub(super) struct AnimationSpan {
    pub begin: f64,
    pub end: f64,
    pub rate_hz: f64,
    /// Reason for that rate.
    pub finding: String,
}

/// A person of a scene at rest.
pub(crate) struct Rig {
    /// One frame; its joints are in the order of `joints`.
    pub clip: SourceClip,
    /// Nodes above the skeleton, outermost first.
    pub above: Vec<usize>,
    /// Nodes of the skeleton, parents first.
    pub joints: Vec<usize>,
    /// World rotation of each node where its joint of the clip is not turned (joints.len()).
    pub axes: Vec<DQuat>,
}

/// A scene file.
pub(super) struct RigScene<'a> {
    pub path: &'a Path,
    pub format: SourceFormat,
    /// Length of the file, including buffers beside it (bytes).
    pub num_bytes: usize,
    pub nodes: Vec<RigNode>,
    /// Nodes that carry a mesh together; none where the file has no such mesh.
    pub skins: Vec<Vec<usize>>,
    pub animations: Vec<Box<dyn NodeAnimation + 'a>>,
}

impl RigScene<'_> {
    /// A clip for each animation and each person that it moves, by animation.
    ///
    /// # Errors
    /// [`ImportError::Content`] naming node or animation.
    pub fn clips(&self) -> Result<Vec<SourceClip>, ImportError> {
        let fail = |what: String, help: &str| content_error(self.path, what, help);
        let help = "Export it with animations, or leave it out";
        ensure(!self.animations.is_empty(), || fail("it holds no animation".into(), help))?;
        let people =
            people::find_people(self).map_err(|what| fail(what, "Export the skeleton and its motion again"))?;
        let nodes = |p: &ScenePerson| p.above.iter().chain(&p.joints).copied().collect::<BTreeSet<usize>>();
        let nodes: Vec<BTreeSet<usize>> = people.iter().map(nodes).collect();
        let mut pairs = Vec::new();
        for (a, animation) in self.animations.iter().enumerate() {
            let moved = (0..people.len()).filter(|&p| animation.moved().iter().any(|n| nodes[p].contains(n)));
            pairs.extend(moved.map(|p| (a, p)));
            let what = || format!("expected {MAX_CLIPS} clips at most, found more");
            ensure(pairs.len() <= MAX_CLIPS, || fail(what(), "Export fewer at once"))?;
            let what = || format!("animation {a}: expected a name of at most {MAX_NAME} bytes, found a longer one");
            ensure(animation.name().len() <= MAX_NAME, || fail(what(), "Give it a shorter name"))?;
        }
        let of_joint = |n: &usize| size_of::<RawJoint>() + self.nodes[*n].name.len();
        let joint_bytes: Vec<usize> = people.iter().map(|p| p.joints.iter().map(of_joint).sum()).collect();
        let most = self.num_bytes.saturating_mul(JOINT_BYTES).saturating_add(FREE_JOINT_BYTES);
        let what = || format!("the joints of {} clips are too many for its file", pairs.len());
        let needed: usize = pairs.iter().map(|&(_, p)| joint_bytes[p]).sum();
        ensure(needed <= most, || fail(what(), "Export fewer at once"))?;
        let help = "Export it with the motion of its joints";
        ensure(!pairs.is_empty(), || fail("its animations move no skeleton".into(), help))?;
        let names = self.names(&pairs, &people);
        let mut budget = self.num_bytes.saturating_add(FREE_TRANSFORMS);
        let mut clips = Vec::new();
        for ((a, p), name) in pairs.into_iter().zip(names) {
            let animation = &*self.animations[a];
            let mut clip = self.clip(animation, &people[p], animation.span(&nodes[p]), &mut budget)?;
            if let Some(name) = name {
                clip.clip.name = format!("{}/{name}", clip.clip.name);
                clip.clip.path.push(name);
            }
            clips.push(clip);
        }
        Ok(clips)
    }

    /// The people of the scene without animation: clips of one frame.
    ///
    /// # Errors
    /// [`ImportError::Content`] naming the node.
    pub fn rigs(&self) -> Result<Vec<Rig>, ImportError> {
        let fail = |what: String| content_error(self.path, what, "Export the character with its skeleton and skin");
        let people = people::find_people(self).map_err(fail)?;
        people.into_iter().map(|p| self.rig(p).map_err(fail)).collect()
    }

    fn rig(&self, person: ScenePerson) -> Result<Rig, String> {
        let rest = RestSkeleton::new(self, &person)?;
        let world = person.world(self, |node| self.nodes[node].local)?;
        let mut sink = FrameSink::new(rest.joints.clone(), rest.joints.len());
        sink.begin_frame();
        let mut turned = vec![(DVec3::ZERO, DQuat::IDENTITY); rest.joints.len()];
        rest.pose_joints(&world, &mut turned, &mut sink);
        ensure(sink.end_frame(), || "it has too many joints".to_owned())?;
        let clip = sink.into_clip(self.path, self.format, FALLBACK_HZ);
        let (findings, warnings) = (Vec::new(), Warnings::default());
        let clip = SourceClip { clip, declared_metres_per_unit: Some(1.0), findings, warnings };
        let ScenePerson { above, joints, .. } = person;
        Ok(Rig { clip, above, joints, axes: rest.rotations })
    }

    /// Names of clips in their file: by animation where there are several, by person where there are several; `None` where
    /// there is one clip.
    fn names(&self, pairs: &[(usize, usize)], people: &[ScenePerson]) -> Vec<Option<String>> {
        let several = |of: fn(&(usize, usize)) -> usize| pairs.iter().any(|p| of(p) != of(&pairs[0]));
        let (animations, persons) = (several(|p| p.0), several(|p| p.1));
        let (mut taken, mut numbers) = (BTreeSet::new(), BTreeMap::<String, usize>::new());
        let mut name = |&(a, p): &(usize, usize)| {
            let parts = [animations.then(|| self.animations[a].name()), persons.then(|| people[p].name.clone())];
            let words: Vec<String> =
                parts.iter().flatten().map(|n| plain_clip_name(n)).filter(|n| !n.is_empty()).collect();
            let base = if words.is_empty() { "clip".to_owned() } else { words.join("/") };
            let number = numbers.entry(base.clone()).or_insert(0);
            let free = loop {
                *number += 1;
                let name = if *number == 1 { base.clone() } else { format!("{base} {number}") };
                if taken.insert(name.clone()) {
                    break name;
                }
            };
            Some(free).filter(|_| pairs.len() > 1)
        };
        pairs.iter().map(&mut name).collect()
    }

    fn clip(
        &self,
        animation: &dyn NodeAnimation,
        person: &ScenePerson,
        span: AnimationSpan,
        budget: &mut usize,
    ) -> Result<SourceClip, ImportError> {
        let fail =
            |what: String, help| content_error(self.path, format!("animation `{}`: {what}", animation.name()), help);
        let AnimationSpan { begin, end, rate_hz, finding } = span;
        let rest =
            RestSkeleton::new(self, person).map_err(|e| fail(e, "Apply scales and mirrors, and export it again"))?;
        // Nodes above are posed, too, and each layer is evaluated for each transform.
        let cost = rest.joints.len().max(person.above.len()) * animation.num_layers();
        let mut sink = FrameSink::new(rest.joints.clone(), *budget / cost * rest.joints.len());
        let mut turned = vec![(DVec3::ZERO, DQuat::IDENTITY); rest.joints.len()];
        let num_frames = (((end - begin) * rate_hz + ON_FRAME).floor() as usize).saturating_add(1);
        let too_many = || {
            let what = format!("{num_frames} frames of {} joints are too many for its file", rest.joints.len());
            fail(what, "Check the times of its keys")
        };
        ensure(num_frames.saturating_mul(cost) <= *budget, too_many)?;
        for frame in 0..num_frames {
            let seconds = begin + frame as f64 / rate_hz;
            let local = |node: usize| animation.local(node, seconds, self.nodes[node].local);
            let world = person.world(self, local).map_err(|e| fail(e, "Export it again"))?;
            sink.begin_frame();
            rest.pose_joints(&world, &mut turned, &mut sink);
            ensure(sink.end_frame(), too_many)?;
        }
        *budget -= sink.num_frames() * cost;
        let warnings = duplicate_names(&rest.joints, self.path);
        let clip = sink.into_clip(self.path, self.format, rate_hz);
        Ok(SourceClip { clip, declared_metres_per_unit: Some(1.0), findings: vec![finding], warnings })
    }
}

/// A name without the characters that stand for folders in paths.
fn plain_clip_name(name: &str) -> String {
    let of = |c: char| if c.is_control() || matches!(c, '/' | '\\' | ':') { '_' } else { c };
    name.trim().trim_start_matches('.').chars().map(of).collect()
}

/// World transform of a node.
#[derive(Clone, Copy)]
struct WorldTransform {
    affine: DAffine3,
    /// The product of the rotations alone.
    rotation: DQuat,
}

impl ScenePerson {
    /// World transforms of the joints (joints.len()).
    fn world(&self, scene: &RigScene<'_>, local: impl Fn(usize) -> Transform) -> Result<Vec<WorldTransform>, String> {
        let step = |outer: WorldTransform, node: usize| {
            let wrong = || format!("node `{}`: expected moderate numbers and a rotation", scene.nodes[node].name);
            let t = local(node).normalized().ok_or_else(wrong)?;
            let inner = DAffine3::from_scale_rotation_translation(t.scale, t.rotation, t.translation);
            let affine = outer.affine * inner;
            let moderate = affine.is_finite() && affine.translation.abs().max_element() < MAX_NUMBER;
            let rotation = (outer.rotation * t.rotation).normalize();
            if moderate { Ok::<_, String>(WorldTransform { affine, rotation }) } else { Err(wrong()) }
        };
        let mut above = WorldTransform { affine: DAffine3::IDENTITY, rotation: DQuat::IDENTITY };
        for &node in &self.above {
            above = step(above, node)?;
        }
        let mut out: Vec<WorldTransform> = Vec::with_capacity(self.joints.len());
        for (&node, parent) in self.joints.iter().zip(&self.parents) {
            out.push(step(parent.map_or(above, |p| out[p]), node)?);
        }
        Ok(out)
    }
}

/// A skeleton at rest: rotations in the world, and joints whose rest rotations are the identity.
struct RestSkeleton {
    rotations: Vec<DQuat>,
    joints: Vec<RawJoint>,
}

impl RestSkeleton {
    /// Writes a pose into `sink`: the place of each joint, and its turn from rest, as its parent sees them.
    ///
    /// - `world`: transforms of all joints, in the scene.
    /// - `turned`: overwritten by the place of each joint, and its turn from rest, in the scene (joints.len()).
    fn pose_joints(&self, world: &[WorldTransform], turned: &mut [(DVec3, DQuat)], sink: &mut FrameSink) {
        for (j, joint) in self.joints.iter().enumerate() {
            turned[j] = (world[j].affine.translation, world[j].rotation * self.rotations[j].inverse());
            let (at, by) = joint.parent.map_or((DVec3::ZERO, DQuat::IDENTITY), |p| turned[p]);
            sink.translations[j] = by.inverse() * (turned[j].0 - at);
            sink.rotations[j] = by.inverse() * turned[j].1;
        }
    }

    /// The pose in which skins were bound, as far as the file has it; else the pose without animation.
    fn new(scene: &RigScene<'_>, person: &ScenePerson) -> Result<Self, String> {
        let world = person.world(scene, |node| scene.nodes[node].local)?;
        let node = |j: usize| &scene.nodes[person.joints[j]];
        if let Some(j) = (0..world.len()).find(|&j| world[j].affine.matrix3.determinant() < 0.0) {
            return Err(format!("node `{}` is mirrored by a negative scale", node(j).name));
        }
        // Skins may be bound in axes of their own, such as those of a program with Z up.
        let up = (0..world.len()).find_map(|j| Some(node(j).bind? * world[j].rotation.inverse() * DVec3::Y));
        let up = up.map_or(Vec3::Y, |up| nearest_axis(up.as_vec3()));
        let axes = DQuat::from_rotation_arc(up.as_dvec3(), DVec3::Y);
        let mut rotations: Vec<DQuat> = Vec::new();
        let mut joints: Vec<RawJoint> = Vec::new();
        for (j, &parent) in person.parents.iter().enumerate() {
            let above = parent.map_or(DQuat::IDENTITY, |p| rotations[p] * world[p].rotation.inverse());
            rotations.push(node(j).bind.map_or(above * world[j].rotation, |bind| axes * bind).normalize());
            let offset =
                above * (world[j].affine.translation - parent.map_or(DVec3::ZERO, |p| world[p].affine.translation));
            let name = node(j).name.clone();
            // A root keeps the place that its motion gives it.
            let offset = if parent.is_some() { offset.as_vec3() } else { Vec3::ZERO };
            joints.push(RawJoint::new(name, parent, offset, false));
        }
        Ok(Self { rotations, joints })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_hold_nothing_that_leads_elsewhere() {
        for (name, want) in
            [("Run", "Run"), ("a/b\\c", "a_b_c"), ("..", ""), ("../x", "_x"), (" |mixamo.com| ", "|mixamo.com|")]
        {
            assert_eq!(plain_clip_name(name), want);
        }
    }
}
