//! Copies of a character's nodes and skins, one for each actor, that share its meshes.

use super::Wearer;
use crate::export::take::PRESENCE_TRACK;
use crate::{export::Take, export::glb::animate_actors, export::glb::parts::GlbParts, import::gltf};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Parts of a document that refer to nodes in ways of their own, or are made anew.
const LEFT_OUT: [&str; 5] = ["animations", "nodes", "skins", "scenes", "scene"];
/// Extensions of a document that parts of nodes and meshes refer to.
const LOOKED_UP: [&str; 2] = ["KHR_lights_punctual", "KHR_materials_variants"];

/// The document in which every actor is a copy of the character.
pub fn copied_parts(wearer: &Wearer, take: &Take) -> GlbParts {
    let mut json = wearer.json.clone();
    if let Some(document) = json.as_object_mut() {
        LEFT_OUT.iter().for_each(|key| drop(document.remove(*key)));
        if let Some(Value::Object(extensions)) = document.get_mut("extensions") {
            extensions.retain(|name, _| LOOKED_UP.contains(&name.as_str()));
        }
        if document.get("extensions").is_some_and(|e| e.as_object().is_none_or(serde_json::Map::is_empty)) {
            document.remove("extensions");
        }
        document.insert("scene".into(), json!(0));
        document.insert("scenes".into(), json!([{ "nodes": [] }]));
    }
    let mut parts = GlbParts::new(json, wearer.buffer.clone());
    let copy = |parts: &mut GlbParts, a| copy_character(parts, wearer, take, a);
    let move_copy = |parts: &mut GlbParts, animation: &mut Value, a: usize, copied: &CopiedCharacter| {
        let frames = take.num_frames(a);
        let times = parts.add_times(frames, take.rate_hz());
        for (track, moved) in wearer.moved.iter().enumerate() {
            let node = copied.nodes[&wearer.rig.joints[moved.joint]];
            let values = parts.add_track(a, track, 4, frames);
            parts.add_channel(animation, [times, values], node, "rotation");
            if moved.joint == wearer.centre {
                let values = parts.add_track(a, wearer.moved.len(), 3, frames);
                parts.add_channel(animation, [times, values], node, "translation");
            }
        }
        if take.actors()[a].is_ever_away {
            let values = parts.add_presence(a, PRESENCE_TRACK, wearer.scale(take, a) as f32, frames);
            parts.add_channel(animation, [times, values], copied.holder, "scale");
        }
    };
    animate_actors(&mut parts, take, copy, move_copy);
    parts
}

/// A copy: the node above it, and the new index of each of its nodes.
struct CopiedCharacter {
    holder: usize,
    nodes: BTreeMap<usize, usize>,
}

fn copy_character(parts: &mut GlbParts, wearer: &Wearer, take: &Take, a: usize) -> CopiedCharacter {
    let (document, below) = (&wearer.document, wearer.nodes());
    let name = if take.is_library() { "figure" } else { take.actors()[a].name.as_str() };
    let scale = wearer.scale(take, a) as f32;
    let holder = parts.push("nodes", json!({ "name": name, "scale": [scale, scale, scale] }));
    let nodes: BTreeMap<usize, usize> = below.iter().enumerate().map(|(i, &n)| (n, holder + 1 + i)).collect();
    parts.set("nodes", holder, "children", json!([nodes[&below[0]]]));
    for &n in &below {
        parts.push("nodes", node(wearer, n, &nodes));
    }
    parts.add_scene_root(holder);
    let is_own = |i: &usize| document.skins[*i].joints.iter().all(|j| nodes.contains_key(j));
    let own = (0..document.skins.len()).filter(is_own);
    let skins: BTreeMap<usize, usize> =
        own.map(|i| (i, parts.push("skins", skin(&wearer.json["skins"][i], &nodes)))).collect();
    for node in wearer.json["nodes"].as_array().into_iter().flatten() {
        let Some(skin) = node["skin"].as_u64().and_then(|s| skins.get(&(s as usize))) else { continue };
        if node["mesh"].is_null() {
            continue;
        }
        let mut root = json!({ "mesh": node["mesh"], "skin": skin });
        root["name"] = format!("{name} {}", node["name"].as_str().unwrap_or("body")).into();
        if node["weights"].is_array() {
            root["weights"] = node["weights"].clone();
        }
        let root = parts.push("nodes", root);
        parts.add_scene_root(root);
    }
    CopiedCharacter { holder, nodes }
}

/// A node of the copy; meshes of skins are elsewhere.
fn node(wearer: &Wearer, n: usize, nodes: &BTreeMap<usize, usize>) -> Value {
    let mut node = wearer.json["nodes"][n].clone();
    let Some(fields) = node.as_object_mut() else { return node };
    if fields.remove("skin").is_some() {
        fields.remove("mesh");
        fields.remove("weights");
    }
    let children: Vec<usize> = wearer.document.nodes[n].children.iter().filter_map(|c| nodes.get(c).copied()).collect();
    match children.is_empty() {
        true => drop(fields.remove("children")),
        false => drop(fields.insert("children".into(), json!(children))),
    }
    if fields.remove("matrix").is_some() {
        let local = gltf::local_transform(&wearer.document.nodes[n]);
        fields.insert("translation".into(), json!(local.translation.as_vec3().to_array()));
        fields.insert("rotation".into(), json!(local.rotation.as_quat().normalize().to_array()));
        fields.insert("scale".into(), json!(local.scale.as_vec3().to_array()));
    }
    node
}

fn skin(skin: &Value, nodes: &BTreeMap<usize, usize>) -> Value {
    let mut out = skin.clone();
    let place = |n: &Value| n.as_u64().and_then(|n| nodes.get(&(n as usize)).copied());
    out["joints"] = skin["joints"].as_array().into_iter().flatten().filter_map(place).collect();
    match (place(&skin["skeleton"]), out.as_object_mut()) {
        (Some(root), Some(fields)) => drop(fields.insert("skeleton".into(), json!(root))),
        (None, Some(fields)) => drop(fields.remove("skeleton")),
        _ => {}
    }
    out
}
