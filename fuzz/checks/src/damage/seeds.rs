//! Good files of every kind: synthetic ones, nothing captured.

use super::readers::ASF_AMC_SEAM;
use super::repair::{self, NPZ_SEAM};
use super::{scenes, snapshots};
use std::fmt::Write as _;
use std::path::Path;
use throng_core::characters::made_up;
use throng_core::{Joint, Skeleton};
use throng_motion::import;
use throng_motion::raw::RawClip;
use throng_world::{PathCosts, WorldGraph, made_up_floor};

/// A bundle with a blend space.
pub(super) const BLENDED: &[u8] = include_bytes!("../../../../data/golden/tables_v8.throng");
/// Unit objects.
pub(super) const UNITS: &str = include_str!("../../../../data/units/playground.toml");

fn texts(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|t| t.as_bytes().to_vec()).collect()
}

/// Bundles with policies, with grids for each state, with patches, and with a blend space.
pub fn bundle() -> Vec<Vec<u8>> {
    vec![
        made_up::bytes(&[], false),
        made_up::bytes(&[], true),
        snapshots::boxing_bytes(),
        made_up_floor::bundle("made up"),
        BLENDED.to_vec(),
    ]
}

/// A world of the made-up floor.
pub fn world() -> Vec<Vec<u8>> {
    let tables = made_up_floor::tables();
    let world = made_up_floor::world(&tables, &["#####", "#b##b", "###b#", "#####"]);
    let graph = WorldGraph::new(tables.patches(), &world.tables()).expect("a graph");
    let mut bytes = Vec::new();
    world.write(&PathCosts::bake(&graph).expect("path costs"), &mut bytes).expect("memory takes all bytes");
    vec![bytes]
}

/// BVH files.
pub fn bvh() -> Vec<Vec<u8>> {
    let plain = bvh_text(&Skeleton::default(), 6);
    texts(&[
        &plain,
        &plain.replace('\n', "\r\n").replace("Frames: 6", "Frames:\t6"),
        plain.trim_end(),
        &plain.replace("Zrotation Xrotation Yrotation", "Xrotation Yrotation Zrotation"),
    ])
}

/// ASF skeletons with AMC motion.
pub fn amc() -> Vec<Vec<u8>> {
    let (asf, amc) = (asf_text(&Skeleton::default()), amc_text(6));
    let join = |asf: &str, amc: &str| [asf.as_bytes(), ASF_AMC_SEAM, amc.as_bytes()].concat();
    vec![
        join(&asf, &amc),
        join(&asf.replace("angle deg", "angle rad"), &amc.replace(":DEGREES", ":RADIANS")),
        join(&asf, &amc.replace("0.5", "5.0e-001")),
    ]
}

/// SMPL files, whole and as arrays with [`NPZ_SEAM`] between them.
pub fn npz() -> Vec<Vec<u8>> {
    let frames = 6;
    let poses = |k: usize| if k.is_multiple_of(156) { std::f64::consts::FRAC_PI_2 } else { 0.01 * (k % 7) as f64 };
    let arrays =
        [npy(&[frames, 3], |k| [0.0, 0.01 * k as f64, 0.93][k % 3]), npy(&[frames, 156], poses), npy(&[1], |_| 60.0)];
    let parts: Vec<&[u8]> = arrays.iter().map(Vec::as_slice).collect();
    let seamed = parts.join(NPZ_SEAM);
    let whole = repair::npz(&seamed).expect("it has seams");
    vec![whole, seamed]
}

/// An array of 64-bit floats as NumPy writes it.
fn npy(shape: &[usize], value: impl Fn(usize) -> f64) -> Vec<u8> {
    let list: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({list}), }}");
    let header = format!("{header:117}\n");
    let length = (header.len() as u16).to_le_bytes();
    let data = (0..shape.iter().product()).flat_map(|k| value(k).to_le_bytes());
    b"\x93NUMPY\x01\x00".iter().copied().chain(length).chain(header.into_bytes()).chain(data).collect()
}

/// Archives of clips.
pub fn archive() -> Vec<Vec<u8>> {
    let [plain, smpl] = [bvh_text(&Skeleton::default(), 6).into_bytes(), npz().swap_remove(0)];
    vec![repair::zip(&["walk/slow.bvh", "notes.txt"], &[&plain, b"slow"]), repair::zip(&["a.npz"], &[&smpl])]
}

/// Build configs.
pub fn config() -> Vec<Vec<u8>> {
    let most = "name = \"walk\"\ninputs = [\"a\", \"b/*.amc\"]\n[import]\nmetres_per_unit = 0.01\nup = \"z\"\nstrict = true\n\
                [resample]\nrate_hz = 30.0\nmirror = true\n[graph]\nbranching = 3.0\n[policy]\n[[behaviours]]\nname = \
                \"approach\"\n[clips.walk]\nunit = \"seconds\"\nexclude = [[0.0, 1.5], [20.0, inf]]\ntags = [{ name = \
                \"punch\", start = 3.2, end = 4.0 }]\n";
    texts(&[
        "inputs = [\"clips/*.bvh\"]\n",
        most,
        include_str!("../../../../data/boxing.toml"),
        include_str!("../../../../data/locomotion.toml"),
        include_str!("../../../../data/office.toml"),
        include_str!("../../../../data/playground.toml"),
    ])
}

/// Scenes of every kind of motion.
pub fn scene() -> Vec<Vec<u8>> {
    let mut all = texts(&[
        include_str!("../../../../data/scenes/flock.toml"),
        include_str!("../../../../data/scenes/corridor.toml"),
        include_str!("../../../../data/scenes/bottleneck.toml"),
        include_str!("../../../../data/scenes/square.toml"),
        include_str!("../../../../data/scenes/plaza-all.toml"),
        include_str!("../../../../data/scenes/boxing-target.toml"),
        include_str!("../../../../data/scenes/museum.toml"),
        include_str!("../../../../data/scenes/race.toml"),
    ]);
    // Small enough to be run: people who find a door locked.
    let concert = include_str!("../../../../data/scenes/concert-exit.toml").replace("count = 5000", "count = 12");
    all.push(concert.into_bytes());
    let bundle = "bundle = \"own.throng\"\n";
    all.extend(snapshots::texts().iter().map(|t| format!("{bundle}{t}").into_bytes()));
    all
}

/// World files.
pub fn world_file() -> Vec<Vec<u8>> {
    texts(&[
        include_str!("../../../../data/worlds/playground-small.toml"),
        include_str!("../../../../data/worlds/playground-park.toml"),
    ])
}

/// Files of unit objects.
pub fn units() -> Vec<Vec<u8>> {
    texts(&[UNITS, include_str!("../../../../data/units/office.toml")])
}

/// Environment files.
pub fn environment() -> Vec<Vec<u8>> {
    texts(&[
        include_str!("../../../../data/environments/playground.toml"),
        include_str!("../../../../data/environments/office_stairs.toml"),
    ])
}

/// A square as a text with its bytes in it, and as a binary file.
pub fn gltf_mesh() -> Vec<Vec<u8>> {
    let mut data = Vec::new();
    for p in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]] {
        p.iter().for_each(|v| data.extend(v.to_le_bytes()));
    }
    [0u16, 1, 2, 0, 2, 3].iter().for_each(|i| data.extend(i.to_le_bytes()));
    // The same bytes in base 64.
    let text = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAAAAAAAIA/\
                AAABAAIAAAACAAMA";
    let json = |buffer: &str| {
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"children\":[1],\
             \"translation\":[0,1,0]}},{{\"mesh\":0,\"rotation\":[0,0.70710678,0,0.70710678],\"scale\":[2,1,1]}}],\
             \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\"indices\":1}}]}}],\"accessors\":[\
             {{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}},{{\"bufferView\":1,\
             \"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":48}},\
             {{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}}],\"buffers\":[{{{buffer}\"byteLength\":60}}]}}"
        )
    };
    vec![json(&format!("\"uri\":\"{text}\",")).into_bytes(), glb(&json(""), &data)]
}

/// A document and its bytes as a binary file.
fn glb(document: &str, data: &[u8]) -> Vec<u8> {
    let length = document.len().next_multiple_of(4);
    let document = format!("{document:<length$}");
    let mut binary = b"glTF".to_vec();
    binary.extend(2u32.to_le_bytes());
    binary.extend((28 + document.len() as u32 + data.len() as u32).to_le_bytes());
    for (kind, chunk) in [(0x4E4F_534Au32, document.as_bytes()), (0x004E_4942, data)] {
        binary.extend((chunk.len() as u32).to_le_bytes());
        binary.extend(kind.to_le_bytes());
        binary.extend(chunk);
    }
    binary
}

/// Motion as glTF, as a text and as a binary file.
pub fn gltf_motion() -> Vec<Vec<u8>> {
    let text = scenes::gltf(&walk());
    vec![glb(&text, &[]), text.into_bytes()]
}

/// A character with a skin, as a text and as a binary file.
pub fn character() -> Vec<Vec<u8>> {
    let mut json: serde_json::Value = serde_json::from_str(&scenes::gltf(&walk())).expect("a document");
    let joints = json["nodes"].as_array().map_or(0, Vec::len);
    json["skins"] = serde_json::json!([{ "joints": (0..joints).collect::<Vec<_>>(), "skeleton": 0 }]);
    json["meshes"] = serde_json::json!([{ "primitives": [{ "attributes": { "POSITION": 2 } }] }]);
    json["scenes"] = serde_json::json!([{ "nodes": [0, joints] }]);
    json["animations"] = serde_json::json!([]);
    let body = serde_json::json!({ "name": "body", "mesh": 0, "skin": 0 });
    json["nodes"].as_array_mut().into_iter().for_each(|nodes| nodes.push(body.clone()));
    let text = serde_json::to_string_pretty(&json).expect("a text");
    vec![glb(&text, &[]), text.into_bytes()]
}

/// Motion as FBX.
#[cfg(feature = "fbx")]
pub fn fbx() -> Vec<Vec<u8>> {
    vec![scenes::fbx(&walk()).into_bytes()]
}

/// The motion of [`bvh`], in centimetres.
fn walk() -> RawClip {
    let text = bvh_text(&Skeleton::default(), 6);
    import::bvh::parse(text.as_bytes(), Path::new("walk.bvh")).expect("a good file").clip
}

/// Sidecars.
pub fn sidecar() -> Vec<Vec<u8>> {
    texts(&[
        "unit = \"seconds\"\nexclude = [[0.0, 1.5], [20.0, inf]]\ntags = [{ name = \"punch\", start = 3.2, end = 4.0 }]\n",
        "unit = \"frames\"\nautomatic_hits = false\n[[hits]]\nname = \"jab\"\njoint = \"left_hand\"\nat = 12\n",
    ])
}

/// Skeleton profiles.
pub fn profile() -> Vec<Vec<u8>> {
    texts(&[
        include_str!("../../../../data/skeletons/snu.toml"),
        include_str!("../../../../data/skeletons/mixamo.toml"),
        include_str!("../../../../data/skeletons/cmu-asf.toml"),
    ])
}

/// Tasks of limbs, without meshes.
pub fn task() -> Vec<Vec<u8>> {
    texts(&[
        include_str!("../../../../data/tasks/hat.toml"),
        include_str!("../../../../data/tasks/together.toml"),
        include_str!("../../../../data/tasks/arm-low.toml"),
    ])
}

/// Meshes of triangles and of polygons.
pub fn obj() -> Vec<Vec<u8>> {
    let quads = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\nf -1 -2 -3\n";
    texts(&[include_str!("../../../../data/tasks/ring.obj"), quads])
}

/// Limits of joints.
pub fn limits() -> Vec<Vec<u8>> {
    texts(&[include_str!("../../../../data/skeletons/throng.limits.toml")])
}

/// A recording of policy characters.
pub fn recording() -> Vec<Vec<u8>> {
    vec![snapshots::recorded()]
}

/// A snapshot of policy characters.
pub fn of_policy() -> Vec<Vec<u8>> {
    vec![snapshots::good("policy")]
}

/// A snapshot of sparring pairs.
pub fn of_sparring() -> Vec<Vec<u8>> {
    vec![snapshots::good("sparring")]
}

/// A snapshot of people in a world.
pub fn of_patches() -> Vec<Vec<u8>> {
    vec![snapshots::good("patches")]
}

/// A snapshot of walkers.
pub fn of_paths() -> Vec<Vec<u8>> {
    vec![snapshots::good("paths")]
}

/// A snapshot of agents on the ground.
pub fn of_agents() -> Vec<Vec<u8>> {
    vec![snapshots::good("agents")]
}

/// A snapshot of agents in the air.
pub fn of_air() -> Vec<Vec<u8>> {
    vec![snapshots::good("air")]
}

/// A nodding skeleton of 22 joints in centimetres; the hips have position channels, one joint more than it needs.
fn bvh_text(skeleton: &Skeleton, num_frames: usize) -> String {
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

fn asf_text(skeleton: &Skeleton) -> String {
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

fn amc_text(num_frames: usize) -> String {
    let mut out = String::from("#!OML:ASF made up\n:FULLY-SPECIFIED\n:DEGREES\n");
    for frame in 1..=num_frames {
        let _ = write!(out, "{frame}\nroot 0 17.5 {frame} 0 1.6201e-014 0\n");
        for (name, _) in SEGMENTS.iter().filter(|(n, _)| !n.ends_with("hipjoint")) {
            let _ = writeln!(out, "{name} 0.5 -2.25 {frame}");
        }
    }
    out
}
