//! A character with a skin, as a GLB file: a box around each joint, in centimetres, with proportions of its own.

use glam::{Mat4, Vec3};
use serde_json::{Value, json};
use throng_core::{Joint, Skeleton};

/// Units of the file in a metre.
const UNITS: f32 = 100.0;
/// Half of a box's edge (m).
const HALF_M: f32 = 0.05;
/// Corners of a box, and its triangles, anticlockwise from outside.
const CORNERS: [[f32; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];
const FACES: [[u16; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2]];

/// The joint that a frame of the surface is.
pub fn part_of(frame: u16) -> Option<Joint> {
    Joint::ALL.get(usize::from(frame)).copied()
}

/// Names as Mixamo's.
fn name(joint: Joint) -> String {
    let all = ["Hips", "Spine", "Spine1", "Spine2", "Neck", "Head", "Shoulder", "Arm", "ForeArm", "Hand"];
    let leg = ["UpLeg", "Leg", "Foot", "ToeBase"];
    let side = |left: Joint, what: &str| {
        let side = if joint == left { "Left" } else { "Right" };
        format!("mixamorig:{side}{what}")
    };
    let left = if (10..14).contains(&joint.index()) || joint.index() >= 18 { joint.mirrored() } else { joint };
    match left.index() {
        i @ 0..=5 => format!("mixamorig:{}", all[i]),
        i @ 6..=9 => side(left, all[i]),
        i => side(left, leg[i - 14]),
    }
}

/// Where joints are at rest: legs and arms shorter than the database's, the trunk longer (m).
fn places() -> Vec<Vec3> {
    let mut body = Skeleton::default();
    for joint in Joint::ALL {
        body.offsets[joint.index()] *= match joint.index() {
            0 | 14..=21 => 0.9,
            1..=5 => 1.1,
            _ => 0.85,
        };
    }
    body.rest_positions().to_vec()
}

/// The file.
pub fn glb() -> Vec<u8> {
    glb_with(|_| ())
}

/// The file, of a document that is changed before it is written.
pub fn glb_with(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let places = places();
    let mut bytes: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut view = |part: Vec<u8>| {
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len() }));
        bytes.extend(part);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    };
    let floats = |all: Vec<f32>| all.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let each = || places.iter().flat_map(|p| CORNERS.map(|c| (*p + Vec3::from(c) * HALF_M) * UNITS));
    view(floats(each().flat_map(|p| p.to_array()).collect()));
    view((0..places.len()).flat_map(|j| [[j as u8, 0, 0, 0]; 8]).flatten().collect());
    view(floats((0..places.len()).flat_map(|_| [[1.0, 0.0, 0.0, 0.0]; 8]).flatten().collect()));
    let triangles = |j: usize| FACES.map(|[a, b, c, d]| [a, b, c, a, c, d].map(|i| i + 8 * j as u16));
    let indices: Vec<u16> = (0..places.len()).flat_map(triangles).flatten().collect();
    view(indices.iter().flat_map(|i| i.to_le_bytes()).collect());
    view(floats(places.iter().flat_map(|p| Mat4::from_translation(-*p * UNITS).to_cols_array()).collect()));
    let n = places.len();
    let accessor = |view: usize, kind: &str, number: u32, count: usize| json!({ "bufferView": view, "componentType": number, "count": count, "type": kind });
    let mut nodes: Vec<Value> = Joint::ALL
        .map(|joint| {
            let from = joint.parent().map_or(Vec3::ZERO, |p| places[p.index()]);
            let children: Vec<usize> =
                Joint::ALL.iter().filter(|c| c.parent() == Some(joint)).map(|c| c.index()).collect();
            let at = (places[joint.index()] - from) * UNITS;
            let mut node = json!({ "name": name(joint), "translation": at.to_array() });
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            node
        })
        .to_vec();
    nodes.push(json!({ "name": "Armature", "scale": Vec3::splat(1.0 / UNITS).to_array(), "children": [0] }));
    nodes.push(json!({ "name": "body", "mesh": 0, "skin": 0 }));
    let mut json = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [n, n + 1] }], "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2 }, "indices": 3, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [0.02, 0.05, 0.9, 1.0] } }],
        "skins": [{ "joints": (0..n).collect::<Vec<_>>(), "inverseBindMatrices": 4 }],
        "accessors": [accessor(0, "VEC3", 5126, 8 * n), accessor(1, "VEC4", 5121, 8 * n), accessor(2, "VEC4", 5126, 8 * n),
            accessor(3, "SCALAR", 5123, indices.len()), accessor(4, "MAT4", 5126, n)],
        "bufferViews": views, "buffers": [{ "byteLength": bytes.len() }],
    });
    change(&mut json);
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = |kind: u32, bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), &kind.to_le_bytes(), bytes].concat();
    let chunks = [chunk(0x4E4F_534A, &text), chunk(0x004E_4942, &bytes)].concat();
    [&b"glTF"[..], &2u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}
