//! Nodes, skins and animation of characters with plain bodies.

use super::super::take::{PRESENCE_TRACK, Take, rotation_track, translation_track};
use super::parts::{FLOAT, GlbParts, INDICES, UNSIGNED_BYTE, UNSIGNED_SHORT, VERTICES};
use glam::{Mat4, Vec3};
use serde_json::{Value, json};
use throng_core::{Joint, NUM_JOINTS, PlainBody, Skeleton};

/// Mesh and bind matrices that characters of one skeleton share.
struct SharedSkin {
    skeleton: Skeleton,
    mesh: usize,
    bind: usize,
}

/// The document of all actors with plain bodies; one figure with an animation for each of them, where they are clips.
pub fn plain_body_parts(take: &Take) -> GlbParts {
    let json = json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }] });
    let mut parts = GlbParts::new(json, Vec::new());
    let colour = json!({ "baseColorFactor": [0.55, 0.6, 0.68, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8 });
    parts.push("materials", json!({ "name": "body", "pbrMetallicRoughness": colour }));
    let mut shared: Vec<SharedSkin> = Vec::new();
    let add = |parts: &mut GlbParts, a: usize| add_figure(parts, &mut shared, take, a);
    animate_actors(&mut parts, take, add, |parts, animation, a, nodes| add_motion(parts, animation, take, a, *nodes));
    parts
}

/// Adds a figure for each actor and one animation of all of them; for a library one figure, and an animation for each actor.
///
/// - `add_figure`: adds the figure of an actor.
/// - `add_motion`: adds the tracks of an actor to the animation of its figure.
pub fn animate_actors<F>(
    parts: &mut GlbParts,
    take: &Take,
    mut add_figure: impl FnMut(&mut GlbParts, usize) -> F,
    add_motion: impl Fn(&mut GlbParts, &mut Value, usize, &F),
) {
    let empty = |name: &str| json!({ "name": name, "samplers": [], "channels": [] });
    let (mut together, mut figure) = (empty("take"), None);
    for (a, actor) in take.actors().iter().enumerate() {
        let known = figure.take().filter(|_| take.is_library());
        let figure = figure.insert(known.unwrap_or_else(|| add_figure(parts, a)));
        if take.num_frames(a) == 0 {
            continue;
        }
        if take.is_library() {
            let mut own = empty(&actor.name);
            add_motion(parts, &mut own, a, figure);
            parts.push("animations", own);
        } else {
            add_motion(parts, &mut together, a, figure);
        }
    }
    if together["channels"].as_array().is_some_and(|c| !c.is_empty()) {
        parts.push("animations", together);
    }
}

/// Adds holder, joints and body; returns the holder and the hips, which the other joints follow.
fn add_figure(parts: &mut GlbParts, shared: &mut Vec<SharedSkin>, take: &Take, a: usize) -> (usize, usize) {
    let actor = &take.actors()[a];
    let known = shared.iter().position(|s| s.skeleton == actor.skeleton).unwrap_or_else(|| {
        let one = add_shared_skin(parts, &actor.skeleton);
        shared.push(one);
        shared.len() - 1
    });
    let name = if take.is_library() { "figure" } else { actor.name.as_str() };
    let holder = parts.push("nodes", json!({ "name": name }));
    let hips = holder + 1;
    for joint in Joint::ALL {
        let below: Vec<usize> =
            Joint::ALL.into_iter().filter(|j| j.parent() == Some(joint)).map(|j| hips + j.index()).collect();
        let mut node = json!({ "name": joint.name(), "translation": actor.skeleton.offsets[joint.index()].to_array() });
        if !below.is_empty() {
            node["children"] = json!(below);
        }
        parts.push("nodes", node);
    }
    parts.set("nodes", holder, "children", json!([hips]));
    let joints: Vec<usize> = (hips..hips + NUM_JOINTS).collect();
    let SharedSkin { mesh, bind, .. } = shared[known];
    let skin =
        parts.push("skins", json!({ "name": name, "joints": joints, "skeleton": hips, "inverseBindMatrices": bind }));
    let body = parts.push("nodes", json!({ "name": format!("{name} body"), "mesh": mesh, "skin": skin }));
    parts.add_scene_root(holder);
    parts.add_scene_root(body);
    (holder, hips)
}

/// Adds the mesh and the bind matrices of a skeleton.
fn add_shared_skin(parts: &mut GlbParts, skeleton: &Skeleton) -> SharedSkin {
    let body = PlainBody::fine(skeleton);
    let joints: Vec<[u8; 4]> = body.joints.iter().map(|j| [*j, 0, 0, 0]).collect();
    let weights = vec![[1f32, 0.0, 0.0, 0.0]; body.joints.len()];
    let vertices = Some(VERTICES);
    let position = parts.add_static(&body.positions, FLOAT, "VEC3", vertices);
    let (low, high) =
        body.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    parts.set_bounds(position, &low.to_array(), &high.to_array());
    let normal = parts.add_static(&body.normals, FLOAT, "VEC3", vertices);
    let joints = parts.add_static(&joints, UNSIGNED_BYTE, "VEC4", vertices);
    let weights = parts.add_static(&weights, FLOAT, "VEC4", vertices);
    let indices = parts.add_static(body.triangles.as_flattened(), UNSIGNED_SHORT, "SCALAR", Some(INDICES));
    let rest = skeleton.rest_positions();
    let bind: Vec<[f32; 16]> = rest.iter().map(|p| Mat4::from_translation(-*p).to_cols_array()).collect();
    let bind = parts.add_static(&bind, FLOAT, "MAT4", None);
    let primitive = json!({ "attributes": { "POSITION": position, "NORMAL": normal, "JOINTS_0": joints,
        "WEIGHTS_0": weights }, "indices": indices, "material": 0 });
    let mesh = parts.push("meshes", json!({ "name": "body", "primitives": [primitive] }));
    SharedSkin { skeleton: skeleton.clone(), mesh, bind }
}

/// Adds the tracks of an actor to an animation.
fn add_motion(parts: &mut GlbParts, animation: &mut Value, take: &Take, a: usize, (holder, hips): (usize, usize)) {
    let (actor, frames) = (&take.actors()[a], take.num_frames(a));
    let times = parts.add_times(frames, take.rate_hz());
    for j in 0..NUM_JOINTS {
        let values = parts.add_track(a, rotation_track(j), 4, frames);
        parts.add_channel(animation, [times, values], hips + j, "rotation");
        if actor.moves[j] {
            let values = parts.add_track(a, translation_track(j), 3, frames);
            parts.add_channel(animation, [times, values], hips + j, "translation");
        }
    }
    if actor.is_ever_away {
        let values = parts.add_presence(a, PRESENCE_TRACK, 1.0, frames);
        parts.add_channel(animation, [times, values], holder, "scale");
    }
}
