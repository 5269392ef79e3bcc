//! Writes BVH that other tools open: centimetres, six channels on roots, three rotations elsewhere.
//!
//! A joint whose translation varies gets position channels too. Ends of chains become End Sites.

use crate::raw::RawClip;
use glam::{DQuat, EulerRot};
use std::io::{self, Write};

/// Centimetres in a metre: what tools expect of a BVH file.
const UNITS_PER_METRE: f32 = 100.0;
/// Translations that differ by less are one offset (m).
const SAME_PLACE: f32 = 1e-6;

/// Order of the joints in a file, and which of them carry position channels.
struct Layout {
    children: Vec<Vec<usize>>,
    moves: Vec<bool>,
}

/// Writes a clip in metres as BVH text in centimetres. Rotation channels are Z, X, Y.
///
/// Reading the text back gives the same world positions to 0.1 mm.
///
/// # Errors
/// Whatever `out` fails with.
pub fn write(clip: &RawClip, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let layout = Layout::of(clip);
    writeln!(out, "HIERARCHY")?;
    let mut order = Vec::with_capacity(clip.joints.len());
    for root in (0..clip.joints.len()).filter(|&j| clip.joints[j].parent.is_none()) {
        write_hierarchy(clip, &layout, root, &mut order, out)?;
    }
    writeln!(out, "MOTION\nFrames: {}\nFrame Time: {:.12}", clip.num_frames, 1.0 / clip.rate_hz)?;
    for frame in 0..clip.num_frames {
        write_frame(clip, &layout, &order, frame, out)?;
    }
    Ok(())
}

impl Layout {
    fn of(clip: &RawClip) -> Self {
        let n = clip.joints.len();
        let mut children = vec![Vec::new(); n];
        let mut moves: Vec<bool> = clip.joints.iter().map(|j| j.parent.is_none()).collect();
        for (j, joint) in clip.joints.iter().enumerate() {
            if let Some(p) = joint.parent {
                children[p].push(j);
            }
        }
        for (i, t) in clip.translations.iter().enumerate() {
            moves[i % n] |= t.distance(clip.joints[i % n].offset) > SAME_PLACE;
        }
        Self { children, moves }
    }

    fn is_end_site(&self, clip: &RawClip, joint: usize) -> bool {
        clip.joints[joint].is_end && clip.joints[joint].parent.is_some() && self.children[joint].is_empty()
    }
}

/// Writes one tree without recursion; appends the joints that have channels to `order`.
fn write_hierarchy(
    clip: &RawClip,
    layout: &Layout,
    root: usize,
    order: &mut Vec<usize>,
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    // A joint to open, or the depth of a block to close.
    enum Step {
        Open(usize, usize),
        Close(usize),
    }
    let mut stack = vec![Step::Open(root, 0)];
    while let Some(step) = stack.pop() {
        match step {
            Step::Close(depth) => writeln!(out, "{}}}", "\t".repeat(depth))?,
            Step::Open(j, depth) if layout.is_end_site(clip, j) => write_end_site(clip, Some(j), depth, out)?,
            Step::Open(j, depth) => {
                order.push(j);
                write_joint(clip, layout, j, depth, out)?;
                stack.push(Step::Close(depth));
                if layout.children[j].is_empty() {
                    write_end_site(clip, None, depth + 1, out)?;
                }
                stack.extend(layout.children[j].iter().rev().map(|&c| Step::Open(c, depth + 1)));
            }
        }
    }
    Ok(())
}

fn write_joint(
    clip: &RawClip,
    layout: &Layout,
    joint: usize,
    depth: usize,
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    let indent = "\t".repeat(depth);
    let keyword = if clip.joints[joint].parent.is_none() { "ROOT" } else { "JOINT" };
    let offset = clip.joints[joint].offset * UNITS_PER_METRE;
    writeln!(out, "{indent}{keyword} {}\n{indent}{{", clip.joints[joint].name)?;
    writeln!(out, "{indent}\tOFFSET {:.6} {:.6} {:.6}", offset.x, offset.y, offset.z)?;
    let positions = if layout.moves[joint] { "6 Xposition Yposition Zposition" } else { "3" };
    writeln!(out, "{indent}\tCHANNELS {positions} Zrotation Xrotation Yrotation")
}

/// An end site, of no length where the joint has no end of its own: readers want every chain to have one.
fn write_end_site(clip: &RawClip, end: Option<usize>, depth: usize, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
    let indent = "\t".repeat(depth);
    let offset = end.map_or(glam::Vec3::ZERO, |e| clip.joints[e].offset * UNITS_PER_METRE);
    writeln!(out, "{indent}End Site\n{indent}{{")?;
    writeln!(out, "{indent}\tOFFSET {:.6} {:.6} {:.6}\n{indent}}}", offset.x, offset.y, offset.z)
}

fn write_frame(
    clip: &RawClip,
    layout: &Layout,
    order: &[usize],
    frame: usize,
    out: &mut (impl Write + ?Sized),
) -> io::Result<()> {
    let base = frame * clip.joints.len();
    let mut separator = "";
    for &j in order {
        if layout.moves[j] {
            let t = clip.translations[base + j] * UNITS_PER_METRE;
            write!(out, "{separator}{:.6} {:.6} {:.6}", t.x, t.y, t.z)?;
            separator = " ";
        }
        let rotation: DQuat = clip.rotations[base + j].as_dquat().normalize();
        let (z, x, y) = rotation.to_euler(EulerRot::ZXY);
        write!(out, "{separator}{:.6} {:.6} {:.6}", z.to_degrees(), x.to_degrees(), y.to_degrees())?;
        separator = " ";
    }
    writeln!(out)
}
