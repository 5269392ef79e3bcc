//! Writes BVH that other tools open: centimetres, six channels on roots, three rotations elsewhere.
//!
//! A joint whose translation varies gets position channels too. Ends of chains become End Sites.

use super::take::Take;
use crate::raw::{RawClip, RawJoint};
use glam::{DQuat, EulerRot, Quat, Vec3};
use std::io::{self, Write};

/// Centimetres in a metre: the unit that tools expect in a BVH file.
const UNITS_PER_METRE: f32 = 100.0;
/// Difference below which translations are one offset (m).
const SAME_PLACE: f32 = 1e-6;

/// Order of the joints in a file, and which of them carry position channels.
struct BvhLayout<'a> {
    joints: &'a [RawJoint],
    children: Vec<Vec<usize>>,
    moves: Vec<bool>,
}

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
    let layout = BvhLayout::from_joints(&clip.joints, moves);
    let order = write_head(&layout, clip.num_frames, clip.rate_hz, out)?;
    for frame in 0..clip.num_frames {
        let of = frame * n..(frame + 1) * n;
        write_frame(&layout, &order, &clip.translations[of.clone()], &clip.rotations[of], out)?;
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
    let layout = BvhLayout::from_joints(&joints, moves);
    let order = write_head(&layout, who.present_frames.len(), take.rate_hz(), out)?;
    let mut translations: Vec<Vec3> = joints.iter().map(|j| j.offset).collect();
    let mut rotations = vec![Quat::IDENTITY; joints.len()];
    take.poses(actor, |frame, pose, _| {
        if !who.present_frames.contains(&frame) {
            return Ok(());
        }
        translations[..pose.translations.len()].copy_from_slice(&pose.translations);
        rotations[..pose.rotations.len()].copy_from_slice(&pose.rotations);
        write_frame(&layout, &order, &translations, &rotations, out)
    })
}

impl<'a> BvhLayout<'a> {
    fn from_joints(joints: &'a [RawJoint], mut moves: Vec<bool>) -> Self {
        let mut children = vec![Vec::new(); joints.len()];
        for (j, joint) in joints.iter().enumerate() {
            match joint.parent {
                Some(p) => children[p].push(j),
                None => moves[j] = true,
            }
        }
        Self { joints, children, moves }
    }

    fn is_end_site(&self, joint: usize) -> bool {
        self.joints[joint].is_end && self.joints[joint].parent.is_some() && self.children[joint].is_empty()
    }
}

/// Writes all but the frames; returns the joints that have channels, in order.
fn write_head(
    layout: &BvhLayout<'_>,
    frames: usize,
    rate_hz: f64,
    out: &mut (impl Write + ?Sized),
) -> io::Result<Vec<usize>> {
    writeln!(out, "HIERARCHY")?;
    let mut order = Vec::with_capacity(layout.joints.len());
    for root in (0..layout.joints.len()).filter(|&j| layout.joints[j].parent.is_none()) {
        write_hierarchy(layout, root, &mut order, out)?;
    }
    writeln!(out, "MOTION\nFrames: {frames}\nFrame Time: {:.12}", 1.0 / rate_hz)?;
    Ok(order)
}

/// Writes one tree without recursion; appends the joints that have channels to `order`.
fn write_hierarchy(
    layout: &BvhLayout<'_>,
    root: usize,
    order: &mut Vec<usize>,
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    // A joint to open, or the depth of a block to close.
    enum HierarchyStep {
        Open(usize, usize),
        Close(usize),
    }
    let mut stack = vec![HierarchyStep::Open(root, 0)];
    while let Some(step) = stack.pop() {
        match step {
            HierarchyStep::Close(depth) => writeln!(out, "{}}}", "\t".repeat(depth))?,
            HierarchyStep::Open(j, depth) if layout.is_end_site(j) => write_end_site(layout, Some(j), depth, out)?,
            HierarchyStep::Open(j, depth) => {
                order.push(j);
                write_joint(layout, j, depth, out)?;
                stack.push(HierarchyStep::Close(depth));
                if layout.children[j].is_empty() {
                    write_end_site(layout, None, depth + 1, out)?;
                }
                stack.extend(layout.children[j].iter().rev().map(|&c| HierarchyStep::Open(c, depth + 1)));
            }
        }
    }
    Ok(())
}

fn write_joint(layout: &BvhLayout<'_>, joint: usize, depth: usize, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let indent = "\t".repeat(depth);
    let RawJoint { name, parent, offset, .. } = &layout.joints[joint];
    let keyword = if parent.is_none() { "ROOT" } else { "JOINT" };
    let offset = offset * UNITS_PER_METRE;
    writeln!(out, "{indent}{keyword} {name}\n{indent}{{")?;
    writeln!(out, "{indent}\tOFFSET {:.6} {:.6} {:.6}", offset.x, offset.y, offset.z)?;
    let positions = if layout.moves[joint] { "6 Xposition Yposition Zposition" } else { "3" };
    writeln!(out, "{indent}\tCHANNELS {positions} Zrotation Xrotation Yrotation")
}

/// Writes an end site, of no length where the joint has no end of its own: readers want every chain to have one.
fn write_end_site(
    layout: &BvhLayout<'_>,
    end: Option<usize>,
    depth: usize,
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    let indent = "\t".repeat(depth);
    let offset = end.map_or(Vec3::ZERO, |e| layout.joints[e].offset * UNITS_PER_METRE);
    writeln!(out, "{indent}End Site\n{indent}{{")?;
    writeln!(out, "{indent}\tOFFSET {:.6} {:.6} {:.6}\n{indent}}}", offset.x, offset.y, offset.z)
}

/// - `translations`, `rotations`: local transforms of one frame (layout.joints.len()).
fn write_frame(
    layout: &BvhLayout<'_>,
    order: &[usize],
    translations: &[Vec3],
    rotations: &[Quat],
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    let mut separator = "";
    for &j in order {
        if layout.moves[j] {
            let t = translations[j] * UNITS_PER_METRE;
            write!(out, "{separator}{:.6} {:.6} {:.6}", t.x, t.y, t.z)?;
            separator = " ";
        }
        let rotation: DQuat = rotations[j].as_dquat().normalize();
        let (z, x, y) = rotation.to_euler(EulerRot::ZXY);
        write!(out, "{separator}{:.6} {:.6} {:.6}", z.to_degrees(), x.to_degrees(), y.to_degrees())?;
        separator = " ";
    }
    writeln!(out)
}
