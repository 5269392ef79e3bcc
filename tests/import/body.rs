//! A hand-made body for the tests: the joints of a Mixamo rig in a T-pose, facing +Z, Y up, 1.75 m tall.

use glam::Vec3;
use std::fmt::Write;

/// Name, parent and offset in metres.
pub const BODY: [(&str, Option<usize>, [f32; 3]); 22] = [
    ("Hips", None, [0.0, 0.96, 0.0]),
    ("Spine", Some(0), [0.0, 0.1, 0.0]),
    ("Spine1", Some(1), [0.0, 0.15, 0.0]),
    ("Spine2", Some(2), [0.0, 0.15, 0.0]),
    ("Neck", Some(3), [0.0, 0.12, 0.0]),
    ("Head", Some(4), [0.0, 0.1, 0.0]),
    ("LeftShoulder", Some(3), [0.03, 0.1, 0.0]),
    ("LeftArm", Some(6), [0.15, 0.0, 0.0]),
    ("LeftForeArm", Some(7), [0.28, 0.0, 0.0]),
    ("LeftHand", Some(8), [0.25, 0.0, 0.0]),
    ("RightShoulder", Some(3), [-0.03, 0.1, 0.0]),
    ("RightArm", Some(10), [-0.15, 0.0, 0.0]),
    ("RightForeArm", Some(11), [-0.28, 0.0, 0.0]),
    ("RightHand", Some(12), [-0.25, 0.0, 0.0]),
    ("LeftUpLeg", Some(0), [0.09, -0.05, 0.0]),
    ("LeftLeg", Some(14), [0.0, -0.42, 0.0]),
    ("LeftFoot", Some(15), [0.0, -0.42, 0.0]),
    ("RightUpLeg", Some(0), [-0.09, -0.05, 0.0]),
    ("RightLeg", Some(17), [0.0, -0.42, 0.0]),
    ("RightFoot", Some(18), [0.0, -0.42, 0.0]),
    ("LeftToeBase", Some(16), [0.0, -0.06, 0.13]),
    ("RightToeBase", Some(19), [0.0, -0.06, 0.13]),
];

/// The body as BVH text, standing for `num_frames` frames; `map` turns metres and Y up into the file's world.
pub fn bvh(num_frames: usize, rename: impl Fn(&str) -> String, map: impl Fn(Vec3) -> Vec3) -> String {
    let mut text = String::from("HIERARCHY\n");
    write_joint(&mut text, 0, &rename, &map);
    writeln!(text, "MOTION\nFrames: {num_frames}\nFrame Time: 0.0333333").unwrap();
    let root = map(Vec3::from(BODY[0].2));
    let line = format!("{} {} {}{}\n", root.x, root.y, root.z, " 0".repeat(3 * BODY.len()));
    text.push_str(&line.repeat(num_frames));
    text
}

fn write_joint(text: &mut String, j: usize, rename: &impl Fn(&str) -> String, map: &impl Fn(Vec3) -> Vec3) {
    let (name, parent, offset) = BODY[j];
    let o = map(Vec3::from(offset));
    let (keyword, channels) =
        if parent.is_none() { ("ROOT", "6 Xposition Yposition Zposition") } else { ("JOINT", "3") };
    writeln!(text, "{keyword} {}\n{{\nOFFSET {} {} {}", rename(name), o.x, o.y, o.z).unwrap();
    writeln!(text, "CHANNELS {channels} Zrotation Xrotation Yrotation").unwrap();
    let children: Vec<_> = (0..BODY.len()).filter(|&c| BODY[c].1 == Some(j)).collect();
    if children.is_empty() {
        text.push_str("End Site\n{\nOFFSET 0 0 0\n}\n");
    }
    for c in children {
        write_joint(text, c, rename, map);
    }
    text.push_str("}\n");
}
