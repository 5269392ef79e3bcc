//! Writes the motion of a clip as glTF, in any of the ways that the format has for it.

use glam::{DQuat, DVec3, Mat4, Quat, Vec3};
use serde_json::{Value, json};
use throng_motion::raw::RawClip;

pub const FLOAT: u32 = 5126;
pub const BYTE: u32 = 5120;
pub const SHORT: u32 = 5122;

/// A glTF document that is being put together, and its bytes.
pub struct Glb {
    pub json: Value,
    pub bytes: Vec<u8>,
}

/// How the motion of a clip is written.
#[derive(Clone, Copy)]
pub struct Style {
    pub interpolation: &'static str,
    /// Type of the numbers of rotations.
    pub rotations: u32,
    pub sparse: bool,
    /// Joints have axes of their own at rest.
    pub own_axes: bool,
    /// An armature above the skeleton: its scale, as a matrix or not.
    pub armature: Option<(f64, bool)>,
    /// The way of the body is on the armature; the root only turns, and stands where it was at first.
    pub root_above: bool,
    /// A skin with its bind pose; nodes are in the first frame's pose where nothing moves them.
    pub skin: bool,
    pub name: &'static str,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            interpolation: "LINEAR",
            rotations: FLOAT,
            sparse: false,
            own_axes: true,
            armature: None,
            root_above: false,
            skin: false,
            name: "",
        }
    }
}

impl Glb {
    pub fn new() -> Self {
        let json = json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }], "nodes": [],
            "accessors": [], "bufferViews": [], "buffers": [{}], "animations": [], "skins": [], "meshes": [] });
        Self { json, bytes: Vec::new() }
    }

    /// Adds to a list; returns the place in it.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let at = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": at, "byteLength": bytes.len() }))
    }

    /// Numbers of a type; whole ones stand for -1 to 1.
    pub fn accessor(&mut self, kind: &str, number: u32, values: &[f32], sparse: bool) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes = |values: &[f32]| -> Vec<u8> {
            let of = |v: &f32| match number {
                FLOAT => v.to_le_bytes().to_vec(),
                SHORT => ((v * 32767.0).round() as i16).to_le_bytes().to_vec(),
                _ => vec![(v * 127.0).round() as i8 as u8],
            };
            values.iter().flat_map(of).collect()
        };
        let count = values.len() / width;
        let mut accessor = json!({ "componentType": number, "count": count, "type": kind });
        if number != FLOAT {
            accessor["normalized"] = json!(true);
        }
        if sparse {
            // Every item but those that are zero stands beside.
            let items: Vec<usize> =
                (0..count).filter(|i| values[i * width..][..width].iter().any(|v| *v != 0.0)).collect();
            let places: Vec<u8> = items.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect();
            let kept: Vec<f32> = items.iter().flat_map(|&i| values[i * width..][..width].to_vec()).collect();
            let (places, kept) = (self.view(&places), self.view(&bytes(&kept)));
            accessor["sparse"] = json!({ "count": items.len(), "indices": { "bufferView": places, "componentType": 5123 },
                "values": { "bufferView": kept } });
        } else {
            accessor["bufferView"] = json!(self.view(&bytes(values)));
        }
        self.push("accessors", accessor)
    }

    /// Adds the motion of a clip, as a skeleton below the scene and an animation of it; returns the nodes of its joints.
    pub fn add(&mut self, clip: &RawClip, style: Style) -> Vec<usize> {
        let n = clip.joints.len();
        let axes: Vec<DQuat> = (0..n).map(|j| if style.own_axes { axes_of(j) } else { DQuat::IDENTITY }).collect();
        let (scale, as_matrix) = style.armature.unwrap_or((1.0, false));
        // As programs with Z up write it: the skeleton lies, its armature makes it stand.
        let turn = if style.armature.is_some() { DQuat::from_rotation_x(-1.5) } else { DQuat::IDENTITY };
        let root_at = |frame: usize| clip.translations[frame * n].as_dvec3();
        let way = |frame: usize| if style.root_above { root_at(frame) - root_at(0) } else { DVec3::ZERO };
        let local = |frame: usize, j: usize| {
            let (t, r) = (clip.translations[frame * n + j].as_dvec3(), clip.rotations[frame * n + j].as_dquat());
            let above = clip.joints[j].parent.map(|p| axes[p]);
            let t = if above.is_none() { turn.inverse() * (t - way(frame)) / scale } else { t / scale };
            let r = if above.is_none() { turn.inverse() * r } else { r };
            let above = above.unwrap_or(DQuat::IDENTITY).inverse();
            ((above * t).as_vec3(), (above * r * axes[j]).as_quat())
        };
        let first = self.json["nodes"].as_array().unwrap().len();
        for (j, joint) in clip.joints.iter().enumerate() {
            let (t, r) = match style.skin {
                true => local(0, j),
                false => {
                    let at_rest = |j: usize| clip.joints[j].parent.map_or(turn.inverse(), |p| axes[p].inverse());
                    let t = at_rest(j) * joint.offset.as_dvec3() / scale;
                    (t.as_vec3(), (at_rest(j) * axes[j]).as_quat())
                }
            };
            let children: Vec<usize> =
                (0..n).filter(|&c| clip.joints[c].parent == Some(j)).map(|c| first + c).collect();
            let mut node = json!({ "name": joint.name, "translation": t.to_array(), "rotation": r.to_array() });
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            self.push("nodes", node);
        }
        let joints: Vec<usize> = (first..first + n).collect();
        let mut top = first;
        if style.armature.is_some() {
            let (scale, turn) = (Vec3::splat(scale as f32), turn.as_quat());
            let mut node = json!({ "name": format!("Armature{}", style.name), "children": [first] });
            if as_matrix {
                node["matrix"] = json!(Mat4::from_scale_rotation_translation(scale, turn, Vec3::ZERO).to_cols_array());
            } else {
                node["scale"] = json!(scale.to_array());
                node["rotation"] = json!(turn.to_array());
            }
            top = self.push("nodes", node);
        }
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(top));
        if style.skin {
            self.bind(clip, &joints, &axes);
        }
        let times: Vec<f32> = (0..clip.num_frames).map(|f| (f as f64 / clip.rate_hz) as f32).collect();
        let mut tracks: Vec<(usize, &str, Vec<f32>)> = Vec::new();
        for j in 0..n {
            let frames = || (0..clip.num_frames).map(|f| local(f, j));
            tracks.push((first + j, "rotation", frames().flat_map(|(_, r)| r.to_array()).collect()));
            if j == 0 {
                tracks.push((first, "translation", frames().flat_map(|(t, _)| t.to_array()).collect()));
            }
        }
        if style.root_above {
            let way = (0..clip.num_frames).flat_map(|f| way(f).as_vec3().to_array()).collect();
            tracks.push((top, "translation", way));
        }
        self.animation(style, &times, &tracks);
        joints
    }

    /// Adds an animation: nodes, what of them is moved, and its values at times.
    pub fn animation(&mut self, style: Style, times: &[f32], tracks: &[(usize, &str, Vec<f32>)]) {
        let input = self.accessor("SCALAR", FLOAT, times, false);
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for (node, path, values) in tracks {
            let (kind, width, number) =
                if *path == "rotation" { ("VEC4", 4, style.rotations) } else { ("VEC3", 3, FLOAT) };
            let spline: Vec<f32> =
                values.chunks(width).flat_map(|v| [&vec![0.5; width], v, &vec![-0.5; width]].concat()).collect();
            let values = if style.interpolation == "CUBICSPLINE" { &spline } else { values };
            let output = self.accessor(kind, number, values, style.sparse);
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(json!({ "input": input, "output": output, "interpolation": style.interpolation }));
        }
        self.push("animations", json!({ "name": style.name, "channels": channels, "samplers": samplers }));
    }

    /// A skin of some joints, bound where all turns are zero, in a space that lies on its back.
    fn bind(&mut self, clip: &RawClip, joints: &[usize], axes: &[DQuat]) {
        let space = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let mut at = vec![Vec3::ZERO; joints.len()];
        let mut matrices = Vec::new();
        for (j, joint) in clip.joints.iter().enumerate() {
            at[j] = joint.parent.map_or(Vec3::ZERO, |p| at[p]) + joint.offset;
            let bound = Mat4::from_rotation_translation(space * axes[j].as_quat(), space * at[j]);
            matrices.extend(bound.inverse().to_cols_array());
        }
        let matrices = self.accessor("MAT4", FLOAT, &matrices, false);
        let skin = self.push("skins", json!({ "joints": joints, "inverseBindMatrices": matrices }));
        let mesh = self.push("meshes", json!({ "primitives": [] }));
        let node = self.push("nodes", json!({ "name": "body", "mesh": mesh, "skin": skin }));
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(node));
    }

    /// The binary file.
    pub fn glb(&self) -> Vec<u8> {
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 28 + text.len() + self.bytes.len();
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((length as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(chunk);
        }
        out
    }

    /// The document, whose numbers lie in another file.
    pub fn gltf(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["uri"] = json!(uri);
        json.to_string().into_bytes()
    }
}

/// Axes of a joint at rest: any, but the same ones every time.
fn axes_of(joint: usize) -> DQuat {
    let v = DVec3::new((joint % 3) as f64 - 1.0, (joint % 5) as f64 * 0.4 - 1.0, (joint % 7) as f64 * 0.3 - 1.0);
    DQuat::from_scaled_axis(v)
}
