//! Writes the seeds of all fuzz targets to `corpus/`: small synthetic files, nothing captured.
//!
//! `cargo run --example seeds` in this folder.

use std::fmt::Write as _;
use std::path::Path;
use throng_fuzz::{ASF_AMC_SEAM, bundle};
use throng_runtime::{Joint, Skeleton};

fn main() -> std::io::Result<()> {
    let bvh = bvh(&Skeleton::default(), 6);
    save("bvh", "plain", bvh.as_bytes())?;
    save("bvh", "crlf", bvh.replace('\n', "\r\n").replace("Frames: 6", "Frames:\t6").as_bytes())?;
    save("bvh", "no_last_newline", bvh.trim_end().as_bytes())?;
    save(
        "bvh",
        "metres_order_xyz",
        bvh.replace("Zrotation Xrotation Yrotation", "Xrotation Yrotation Zrotation").as_bytes(),
    )?;
    let (asf, amc) = (asf(&Skeleton::default()), amc(6));
    let join = |asf: &str, amc: &str| [asf.as_bytes(), ASF_AMC_SEAM, amc.as_bytes()].concat();
    save("amc", "plain", &join(&asf, &amc))?;
    save("amc", "radians", &join(&asf.replace("angle deg", "angle rad"), &amc.replace(":DEGREES", ":RADIANS")))?;
    save("amc", "exponents", &join(&asf, &amc.replace("0.5", "5.0e-001")))?;
    save("bundle", "small", &bundle::small())?;
    for (name, text) in CONFIGS {
        save("config", name, text.as_bytes())?;
    }
    Ok(())
}

fn save(target: &str, name: &str, bytes: &[u8]) -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join(name), bytes)
}

/// A nodding skeleton of 22 joints in centimetres; the hips have position channels, one joint more than it needs.
fn bvh(skeleton: &Skeleton, num_frames: usize) -> String {
    let mut out = String::from("HIERARCHY\n");
    bvh_joint(skeleton, Joint::Hips, 0, &mut out);
    let _ = write!(out, "MOTION\nFrames: {num_frames}\nFrame Time: 0.0333333\n");
    for frame in 0..num_frames {
        let angle = 5.0 * (frame as f32).sin();
        let _ = write!(out, "0.0 95.5 {frame}.0");
        for joint in depth_first(Joint::Hips) {
            if joint == Joint::Chest {
                out.push_str(" 0.0 12.5 0.0");
            }
            let _ = write!(out, " {angle:.4} {:.4} 1.6201e-014", -angle);
        }
        out.push('\n');
    }
    out
}

fn bvh_joint(skeleton: &Skeleton, joint: Joint, depth: usize, out: &mut String) {
    let o = skeleton.offsets[joint.index()] * 100.0;
    let keyword = if depth == 0 { "ROOT" } else { "JOINT" };
    let moves = matches!(joint, Joint::Hips | Joint::Chest);
    let channels = if moves { "6 Xposition Yposition Zposition" } else { "3" };
    let _ = write!(
        out,
        "{keyword} {}\n{{\nOFFSET {} {} {}\nCHANNELS {channels} Zrotation Xrotation Yrotation\n",
        joint.name(),
        o.x,
        o.y,
        o.z
    );
    let children: Vec<Joint> = Joint::ALL.into_iter().filter(|c| c.parent() == Some(joint)).collect();
    if children.is_empty() {
        out.push_str("End Site\n{\nOFFSET 0 0 7\n}\n");
    }
    children.into_iter().for_each(|c| bvh_joint(skeleton, c, depth + 1, out));
    out.push_str("}\n");
}

/// A joint and its descendants in the order a file lists them.
fn depth_first(joint: Joint) -> Vec<Joint> {
    let children = Joint::ALL.into_iter().filter(|c| c.parent() == Some(joint));
    std::iter::once(joint).chain(children.flat_map(depth_first)).collect()
}

/// The skeleton with names as the CMU database has them.
const SEGMENTS: [(&str, Joint); 17] = [
    ("lhipjoint", Joint::LeftThigh),
    ("lfemur", Joint::LeftShin),
    ("ltibia", Joint::LeftFoot),
    ("lfoot", Joint::LeftToe),
    ("rhipjoint", Joint::RightThigh),
    ("rfemur", Joint::RightShin),
    ("rtibia", Joint::RightFoot),
    ("rfoot", Joint::RightToe),
    ("lowerback", Joint::Spine),
    ("upperback", Joint::Chest),
    ("thorax", Joint::UpperChest),
    ("lowerneck", Joint::Neck),
    ("lclavicle", Joint::LeftUpperArm),
    ("lhumerus", Joint::LeftForearm),
    ("lradius", Joint::LeftHand),
    ("rclavicle", Joint::RightUpperArm),
    ("rhumerus", Joint::RightForearm),
];

fn asf(skeleton: &Skeleton) -> String {
    let mut out = String::from(
        "# synthetic\n:version 1.10\n:name VICON\n:units\n  mass 1.0\n  length 0.45\n  angle deg\n:documentation\n   \
         made up\n:root\n   order TX TY TZ RX RY RZ\n   axis XYZ\n   position 0 0 0\n   orientation 0 0 0\n:bonedata\n",
    );
    for (id, (name, end)) in SEGMENTS.into_iter().enumerate() {
        let o = skeleton.offsets[end.index()];
        let (d, length) = (o.normalize_or_zero(), o.length() / 0.0254 * 0.45);
        let _ = write!(
            out,
            "  begin\n     id {}\n     name {name}\n     direction {} {} {}\n     length {length}\n     axis 0 0 20 XYZ\n",
            id + 1,
            d.x,
            d.y,
            d.z
        );
        if !name.ends_with("hipjoint") {
            out.push_str(
                "    dof rx ry rz\n    limits (-160.0 20.0)\n           (-70.0 70.0)\n           (-60.0 70.0)\n",
            );
        }
        out.push_str("  end\n");
    }
    out.push_str(
        ":hierarchy\n  begin\n    root lhipjoint rhipjoint lowerback\n    lhipjoint lfemur\n    lfemur ltibia\n    \
         ltibia lfoot\n    rhipjoint rfemur\n    rfemur rtibia\n    rtibia rfoot\n    lowerback upperback\n    \
         upperback thorax\n    thorax lowerneck lclavicle rclavicle\n    lclavicle lhumerus\n    lhumerus lradius\n    \
         rclavicle rhumerus\n  end\n",
    );
    out
}

fn amc(num_frames: usize) -> String {
    let mut out = String::from("#!OML:ASF made up\n:FULLY-SPECIFIED\n:DEGREES\n");
    for frame in 1..=num_frames {
        let _ = write!(out, "{frame}\nroot 0 17.5 {frame} 0 1.6201e-014 0\n");
        for (name, _) in SEGMENTS.iter().filter(|(n, _)| !n.ends_with("hipjoint")) {
            let _ = writeln!(out, "{name} 0.5 -2.25 {frame}");
        }
    }
    out
}

const CONFIGS: [(&str, &str); 4] = [
    ("least", "inputs = [\"clips/*.bvh\"]\n"),
    (
        "most",
        "name = \"walk\"\ninputs = [\"a\", \"b/*.amc\"]\n[import]\nmetres_per_unit = 0.01\nup = \"z\"\nstrict = true\n\
         [resample]\nrate_hz = 30.0\nmirror = true\n[graph]\nbranching = 3.0\n[policy]\n[[behaviours]]\nname = \
         \"approach\"\n[clips.walk]\nunit = \"seconds\"\nexclude = [[0.0, 1.5], [20.0, inf]]\ntags = [{ name = \
         \"punch\", start = 3.2, end = 4.0 }]\n",
    ),
    ("unknown_key", "inputs = []\n[graph]\nbranshing = 3.0\n"),
    ("profile", "name = \"x\"\n[roles]\nhips = \"Hips\"\nhead = [\"Head\", \"head\"]\n"),
];
