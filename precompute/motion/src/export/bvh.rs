//! Writes BVH that other tools open: centimetres, six channels on roots, three rotations elsewhere.
//!
//! A joint whose translation varies gets position channels too. Ends of chains become End Sites.

use super::take::Take;
use crate::raw::{RawClip, RawJoint, children_of};
use glam::{DQuat, EulerRot, Quat, Vec3};
use std::io::{self, Write};

/// Centimetres in a metre: the unit that tools expect in a BVH file.
const UNITS_PER_METRE: f32 = 100.0;
/// Difference below which translations are one offset (m).
const SAME_PLACE: f32 = 1e-6;

/// Writes a clip in metres as BVH text in centimetres. Rotation channels are Z, X, Y.
///
/// Reading the text back gives the same world positions to 0.1 mm.
///
/// # Errors
/// Errors of `out`.
pub fn write_clip(clip: &RawClip, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let n = clip.joints.len();
    let mut moves = vec![false; n];
    for (i, t) in clip.translations.iter().enumerate() {
        moves[i % n] |= t.distance(clip.joints[i % n].offset) > SAME_PLACE;
    }
    let mut writer = BvhWriter::new(&clip.joints, moves, out);
    writer.write_head(clip.num_frames, clip.rate_hz)?;
    for frame in 0..clip.num_frames {
        let of = frame * n..(frame + 1) * n;
        writer.write_frame(&clip.translations[of.clone()], &clip.rotations[of])?;
    }
    Ok(())
}

/// Writes an actor of a take, while it is present, as [`write_clip()`] does a clip: joints have the names of their roles.
///
/// # Errors
/// Errors of `out`.
pub fn write_actor(take: &Take, actor: usize, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let who = &take.actors()[actor];
    let joints = super::joints(&who.skeleton);
    let mut moves = who.moves.to_vec();
    moves.resize(joints.len(), false);
    let mut writer = BvhWriter::new(&joints, moves, out);
    writer.write_head(who.present_frames.len(), take.rate_hz())?;
    let mut translations: Vec<Vec3> = joints.iter().map(|j| j.offset).collect();
    let mut rotations = vec![Quat::IDENTITY; joints.len()];
    take.poses(actor, |frame, pose, _| {
        if !who.present_frames.contains(&frame) {
            return Ok(());
        }
        translations[..pose.translations.len()].copy_from_slice(&pose.translations);
        rotations[..pose.rotations.len()].copy_from_slice(&pose.rotations);
        writer.write_frame(&translations, &rotations)
    })
}

/// A file under way.
struct BvhWriter<'a, W: Write + ?Sized> {
    joints: &'a [RawJoint],
    children: Vec<Vec<usize>>,
    /// True for joints that carry position channels.
    moves: Vec<bool>,
    /// Joints that have channels, in the order of the file.
    order: Vec<usize>,
    out: &'a mut W,
}

impl<'a, W: Write + ?Sized> BvhWriter<'a, W> {
    fn new(joints: &'a [RawJoint], mut moves: Vec<bool>, out: &'a mut W) -> Self {
        let children = children_of(joints.iter().map(|j| j.parent));
        joints.iter().zip(&mut moves).for_each(|(joint, moves)| *moves |= joint.parent.is_none());
        Self { joints, children, moves, order: Vec::with_capacity(joints.len()), out }
    }

    fn is_end_site(&self, joint: usize) -> bool {
        self.joints[joint].is_end && self.joints[joint].parent.is_some() && self.children[joint].is_empty()
    }

    /// Writes all but the frames.
    fn write_head(&mut self, frames: usize, rate_hz: f64) -> io::Result<()> {
        writeln!(self.out, "HIERARCHY")?;
        for root in (0..self.joints.len()).filter(|&j| self.joints[j].parent.is_none()) {
            self.write_hierarchy(root)?;
        }
        writeln!(self.out, "MOTION\nFrames: {frames}\nFrame Time: {:.12}", 1.0 / rate_hz)
    }

    /// Writes one tree without recursion.
    fn write_hierarchy(&mut self, root: usize) -> io::Result<()> {
        // A joint to open, or the depth of a block to close.
        enum HierarchyStep {
            Open(usize, usize),
            Close(usize),
        }
        let mut stack = vec![HierarchyStep::Open(root, 0)];
        while let Some(step) = stack.pop() {
            match step {
                HierarchyStep::Close(depth) => writeln!(self.out, "{}}}", "\t".repeat(depth))?,
                HierarchyStep::Open(j, depth) if self.is_end_site(j) => self.write_end_site(Some(j), depth)?,
                HierarchyStep::Open(j, depth) => {
                    self.order.push(j);
                    self.write_joint(j, depth)?;
                    stack.push(HierarchyStep::Close(depth));
                    if self.children[j].is_empty() {
                        self.write_end_site(None, depth + 1)?;
                    }
                    stack.extend(self.children[j].iter().rev().map(|&c| HierarchyStep::Open(c, depth + 1)));
                }
            }
        }
        Ok(())
    }

    fn write_joint(&mut self, joint: usize, depth: usize) -> io::Result<()> {
        let indent = "\t".repeat(depth);
        let RawJoint { name, parent, offset, .. } = &self.joints[joint];
        let keyword = if parent.is_none() { "ROOT" } else { "JOINT" };
        let offset = offset * UNITS_PER_METRE;
        writeln!(self.out, "{indent}{keyword} {name}\n{indent}{{")?;
        writeln!(self.out, "{indent}\tOFFSET {:.6} {:.6} {:.6}", offset.x, offset.y, offset.z)?;
        let positions = if self.moves[joint] { "6 Xposition Yposition Zposition" } else { "3" };
        writeln!(self.out, "{indent}\tCHANNELS {positions} Zrotation Xrotation Yrotation")
    }

    /// Writes an end site, of no length where the joint has no end of its own: readers want every chain to have one.
    fn write_end_site(&mut self, end: Option<usize>, depth: usize) -> io::Result<()> {
        let indent = "\t".repeat(depth);
        let offset = end.map_or(Vec3::ZERO, |e| self.joints[e].offset * UNITS_PER_METRE);
        writeln!(self.out, "{indent}End Site\n{indent}{{")?;
        writeln!(self.out, "{indent}\tOFFSET {:.6} {:.6} {:.6}\n{indent}}}", offset.x, offset.y, offset.z)
    }

    /// - `translations`, `rotations`: local transforms of one frame (joints.len()).
    fn write_frame(&mut self, translations: &[Vec3], rotations: &[Quat]) -> io::Result<()> {
        let mut separator = "";
        for &j in &self.order {
            if self.moves[j] {
                let t = translations[j] * UNITS_PER_METRE;
                write!(self.out, "{separator}{:.6} {:.6} {:.6}", t.x, t.y, t.z)?;
                separator = " ";
            }
            let rotation: DQuat = rotations[j].as_dquat().normalize();
            let (z, x, y) = rotation.to_euler(EulerRot::ZXY);
            write!(self.out, "{separator}{:.6} {:.6} {:.6}", z.to_degrees(), x.to_degrees(), y.to_degrees())?;
            separator = " ";
        }
        writeln!(self.out)
    }
}
