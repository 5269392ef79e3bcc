//! Small BVH files in any convention: names, rest pose, axes, unit and rotation order of choice; they walk.

use glam::{EulerRot, Quat, Vec3};
use std::collections::HashMap;
use std::f32::consts::FRAC_PI_2;
use std::fmt::Write;
use throng_core::{Joint, Skeleton};

/// Frames of the motion.
pub const FRAMES: usize = 60;

/// A joint of a rig.
#[derive(Clone, Debug)]
#[allow(dead_code, reason = "each test uses its own part of this module")]
pub struct RigPart {
    pub name: String,
    pub parent: Option<usize>,
    /// Where it is in a T-pose that faces +Z, left +X, Y up (m).
    pub at: Vec3,
    /// The role that moves it: its own, or that of the nearest joint above with one.
    pub moved_by: Joint,
    /// The role that must be found for it.
    pub role: Option<Joint>,
}

/// What the pose without rotations is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(dead_code, reason = "each test uses its own part of this module")]
pub enum Rest {
    TPose,
    /// Arms lowered by 45 degrees.
    APose,
    /// Every offset along +X.
    AlongX,
    /// Every offset along +Y.
    AlongY,
}

/// How a file is written.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    pub rest: Rest,
    pub order: &'static str,
    /// Units in a metre.
    pub scale: f32,
    /// Heading that the rest pose faces (rad).
    pub heading: f32,
    pub z_up: bool,
    /// Knees bend and arms swing; else the file holds a T-pose.
    pub moves: bool,
    /// Left and right of all places exchanged, names as they were.
    pub mirrored: bool,
}

impl Default for Style {
    fn default() -> Self {
        let (scale, heading) = (100.0, 0.0);
        Self { rest: Rest::TPose, order: "ZXY", scale, heading, z_up: false, moves: true, mirrored: false }
    }
}

/// Reads a table: `name;parent;place;role`, one joint a line, parents first.
///
/// The place is that of a role on the default skeleton, or an offset from the parent. The role is the place's where it
/// is left out, none where it is `-`. `{L,R}` in a line makes two joints, the second one mirrored.
pub fn parse(table: &str) -> Vec<RigPart> {
    let mut out: Vec<RigPart> = Vec::new();
    for line in table.lines().map(str::trim).filter(|l| !l.is_empty()) {
        match line.find('{') {
            None => add(&mut out, line, false),
            Some(_) => {
                let pick = |second: bool| {
                    let mut text = line.to_owned();
                    while let (Some(a), Some(b)) = (text.find('{'), text.find('}')) {
                        let inner = text[a + 1..b].split(',').nth(usize::from(second)).unwrap().to_owned();
                        text.replace_range(a..=b, &inner);
                    }
                    text
                };
                add(&mut out, &pick(false), false);
                add(&mut out, &pick(true), true);
            }
        }
    }
    out
}

fn add(out: &mut Vec<RigPart>, line: &str, mirror: bool) {
    let rest = Skeleton::default().rest_positions();
    let fields: Vec<&str> = line.split(';').collect();
    let parent = out.iter().position(|p| p.name == fields[1]);
    assert!(parent.is_some() || fields[1] == "-", "{line}: no parent");
    let side = |j: Joint| if mirror { j.mirrored() } else { j };
    let role_of = |name: &str| Joint::from_name(name).map(side);
    let at = match role_of(fields[2]) {
        Some(j) => rest[j.index()],
        None => {
            let v: Vec<f32> = fields[2].split(' ').map(|v| v.parse().expect(line)).collect();
            let offset = Vec3::new(if mirror { -v[0] } else { v[0] }, v[1], v[2]);
            parent.map_or(Vec3::ZERO, |p| out[p].at) + offset
        }
    };
    let role = match fields.get(3) {
        Some(&"-") => None,
        Some(name) => Some(role_of(name).expect(line)),
        None => role_of(fields[2]),
    };
    let above = parent.map_or(Joint::Hips, |p| out[p].moved_by);
    let moved_by = role.or(role_of(fields[2])).unwrap_or(above);
    out.push(RigPart { name: fields[0].into(), parent, at, moved_by, role });
}

/// Turn of each role against the T-pose at a frame, in the world.
pub fn turns(frame: usize) -> HashMap<Joint, Quat> {
    use Joint::*;
    let t = frame as f32 * 0.25;
    let mut local: HashMap<Joint, Quat> = HashMap::new();
    local.insert(Hips, Quat::from_rotation_y(0.02 * frame as f32));
    local.insert(Spine, Quat::from_rotation_x(0.1));
    for (sign, thigh, shin, arm, forearm) in [
        (1.0, LeftThigh, LeftShin, LeftUpperArm, LeftForearm),
        (-1.0, RightThigh, RightShin, RightUpperArm, RightForearm),
    ] {
        let swing = sign * t.sin();
        local.insert(thigh, Quat::from_rotation_x(-0.25 - 0.4 * swing));
        local.insert(shin, Quat::from_rotation_x(0.45 + 0.4 * swing));
        local.insert(arm, Quat::from_rotation_x(0.4 * swing) * Quat::from_rotation_z(-1.2 * sign));
        local.insert(forearm, Quat::from_rotation_y(-sign * (0.5 + 0.2 * swing)));
    }
    let mut world = HashMap::new();
    for j in Joint::ALL {
        let above = j.parent().map_or(Quat::IDENTITY, |p| world[&p]);
        world.insert(j, above * local.get(&j).copied().unwrap_or(Quat::IDENTITY));
    }
    world
}

/// The axes of every joint in the T-pose, so that without rotations the rig is in its rest pose.
fn axes(parts: &[RigPart], rest: Rest) -> Vec<Quat> {
    use Joint::*;
    let arm = |j: Joint| match j {
        LeftUpperArm | LeftForearm | LeftHand => 1.0,
        RightUpperArm | RightForearm | RightHand => -1.0,
        _ => 0.0,
    };
    (0..parts.len())
        .map(|j| {
            let child = parts.iter().filter(|p| p.parent == Some(j)).find_map(|c| (c.at - parts[j].at).try_normalize());
            let along = child.unwrap_or(Vec3::Y);
            match rest {
                Rest::TPose => Quat::IDENTITY,
                Rest::APose => Quat::from_rotation_z(arm(parts[j].moved_by) * 0.5 * FRAC_PI_2),
                Rest::AlongX => Quat::from_rotation_arc(Vec3::X, along),
                Rest::AlongY => Quat::from_rotation_arc(Vec3::Y, along),
            }
        })
        .collect()
}

/// The rig as BVH text.
pub fn bvh(parts: &[RigPart], style: &Style) -> String {
    let mut text = String::from("HIERARCHY\n");
    let axes = axes(parts, style.rest);
    let g = if style.z_up { Quat::from_rotation_x(FRAC_PI_2) } else { Quat::IDENTITY }
        * Quat::from_rotation_y(style.heading);
    let flip = |v: Vec3| if style.mirrored { Vec3::new(-v.x, v.y, v.z) } else { v };
    let place = |v: Vec3| g * flip(v) * style.scale;
    let turn = |q: Quat| {
        let q = if style.mirrored { Quat::from_xyzw(q.x, -q.y, -q.z, q.w) } else { q };
        g * q * g.inverse()
    };
    let offset = |j: usize| match parts[j].parent {
        None => parts[j].at,
        Some(p) => axes[p].inverse() * (parts[j].at - parts[p].at),
    };
    // Chains end a hand's length further on, forearms without hands where the hand would be.
    let end = |j: usize| {
        let parent = parts[j].parent.map_or(Vec3::ZERO, |p| parts[p].at);
        let length = if matches!(parts[j].moved_by, Joint::LeftForearm | Joint::RightForearm) { 0.25 } else { 0.08 };
        axes[j].inverse() * (parts[j].at - parent).normalize_or(Vec3::Y) * length
    };
    let mut order = Vec::new();
    for root in (0..parts.len()).filter(|&j| parts[j].parent.is_none()) {
        write_joint(&mut text, parts, root, style, &|j| place(offset(j)), &|j| place(end(j)), &mut order);
    }
    writeln!(text, "MOTION\nFrames: {FRAMES}\nFrame Time: 0.0333333").unwrap();
    for frame in 0..FRAMES {
        let turns = turns(if style.moves { frame } else { 0 });
        let world = |j: usize| {
            let still = Quat::IDENTITY;
            (if style.moves { turns[&parts[j].moved_by] } else { still }) * axes[j]
        };
        for &j in &order {
            let local = parts[j].parent.map_or(Quat::IDENTITY, world).inverse() * world(j);
            if parts[j].parent.is_none() {
                let at = place(parts[j].at + if style.moves { Vec3::Z * 0.04 * frame as f32 } else { Vec3::ZERO });
                write!(text, "{} {} {} ", at.x, at.y, at.z).unwrap();
            }
            let euler = match style.order {
                "ZXY" => EulerRot::ZXY,
                "XYZ" => EulerRot::XYZ,
                "YXZ" => EulerRot::YXZ,
                _ => EulerRot::ZYX,
            };
            let (a, b, c) = turn(local).to_euler(euler);
            write!(text, "{} {} {} ", a.to_degrees(), b.to_degrees(), c.to_degrees()).unwrap();
        }
        text.push('\n');
    }
    text
}

fn write_joint(
    text: &mut String,
    parts: &[RigPart],
    j: usize,
    style: &Style,
    offset: &impl Fn(usize) -> Vec3,
    end: &impl Fn(usize) -> Vec3,
    order: &mut Vec<usize>,
) {
    order.push(j);
    let o = offset(j);
    let (keyword, channels) =
        if parts[j].parent.is_none() { ("ROOT", "6 Xposition Yposition Zposition") } else { ("JOINT", "3") };
    writeln!(text, "{keyword} {}\n{{\nOFFSET {} {} {}\nCHANNELS {channels}", parts[j].name, o.x, o.y, o.z).unwrap();
    for axis in style.order.chars() {
        write!(text, " {axis}rotation").unwrap();
    }
    text.push('\n');
    let children: Vec<usize> = (0..parts.len()).filter(|&c| parts[c].parent == Some(j)).collect();
    if children.is_empty() {
        let e = end(j);
        writeln!(text, "End Site\n{{\nOFFSET {} {} {}\n}}", e.x, e.y, e.z).unwrap();
    }
    for c in children {
        write_joint(text, parts, c, style, offset, end, order);
    }
    text.push_str("}\n");
}
