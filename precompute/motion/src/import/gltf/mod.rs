//! Reads glTF 2.0 (`.gltf`, `.glb`): documents and their numbers, for meshes too, and animations of skeletons.
//!
//! Animations have times of keys but no rate: the most frequent spacing of keys is that of the frames.

mod accessor;
mod document;
mod mesh;
mod sampler;

use super::nodes::{self, AnimationSpan, FALLBACK_HZ, RigScene, Transform, rate_of_keys};
use super::{MAX_JOINTS, SourceClip, archive, content_error};
use crate::error::{ImportError, ensure};
use crate::raw::SourceFormat;
pub(crate) use accessor::base64;
pub use accessor::{AccessorReader, MAX_BYTES, path_beside};
pub(crate) use document::split;
pub use document::{
    Accessor, Attributes, Buffer, BufferView, GltfAnimation, GltfChannel, GltfDocument, GltfMesh, GltfNode,
    GltfPrimitive, GltfSampler, GltfTarget, Interpolation, SceneNodes, Skin, Sparse, SparsePart, ViewExtensions,
    parse as document,
};
use glam::{DMat4, DQuat, DVec3, Mat4};
pub(crate) use mesh::{MAX_PARTS, TRIANGLES};
pub use mesh::{MAX_TRIANGLES, SceneNode, ScenePart, TriangleScene, scene, triangles};
use sampler::{Keys, Samplers};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const HELP: &str = "Export it again";

/// The files beside a `.gltf` file that hold its numbers.
///
/// - `bytes`: contents of the file at `path`.
///
/// # Errors
/// [`ImportError::Content`] for a document that cannot be read, or names a file elsewhere.
pub fn buffer_files(bytes: &[u8], path: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let fail = |what: String| content_error(path, what, HELP);
    let (document, _) = document(bytes).map_err(fail)?;
    let uris = document.buffers.iter().filter_map(|b| b.uri.as_deref()).filter(|uri| !uri.starts_with("data:"));
    uris.map(|uri| path_beside(path, uri).map_err(fail)).collect()
}

/// Reads the clips of a `.gltf` or `.glb` file: one for each animation and each skeleton that it moves.
///
/// # Errors
/// [`ImportError::Content`] naming the part of the document that is missing or wrong.
pub fn parse(bytes: &[u8], path: &Path) -> Result<Vec<SourceClip>, ImportError> {
    let fail = |what: String| content_error(path, what, HELP);
    let (document, binary) = document(bytes).map_err(fail)?;
    let reader = AccessorReader::new(&document, binary, path)?;
    let num_bytes = archive::counted_bytes(path, bytes.len()).saturating_add(reader.num_bytes());
    let scene_nodes = bound_nodes(&document, &reader).map_err(fail)?;
    let mut samplers = Samplers::new(&reader, num_bytes);
    let mut animations: Vec<Box<dyn nodes::NodeAnimation>> = Vec::new();
    for (i, a) in document.animations.iter().enumerate() {
        let tracks = KeyTracks::new(a, i, scene_nodes.len(), &mut samplers);
        animations.push(Box::new(tracks.map_err(|e| fail(format!("animations[{i}].{e}")))?));
    }
    let skins = document.skins.iter().map(|s| s.joints.clone()).collect();
    let format = SourceFormat::Gltf;
    RigScene { path, format, num_bytes, nodes: scene_nodes, skins, animations }.clips()
}

/// The people of a `.gltf` or `.glb` file that have skins, in the rest pose of its nodes.
///
/// # Errors
/// [`ImportError::Content`] naming the missing part.
pub(crate) fn rigs(bytes: &[u8], path: &Path) -> Result<Vec<nodes::Rig>, ImportError> {
    let fail = |what: String| content_error(path, what, HELP);
    let (document, binary) = document(bytes).map_err(fail)?;
    let help = "Export the mesh with the skeleton that carries it, as .glb";
    ensure(!document.skins.is_empty(), || content_error(path, "it has no skin: no joints carry a mesh", help))?;
    let reader = AccessorReader::new(&document, binary, path)?;
    let num_bytes = bytes.len().saturating_add(reader.num_bytes());
    let nodes = bound_nodes(&document, &reader).map_err(fail)?;
    let skins = document.skins.iter().map(|s| s.joints.clone()).collect();
    RigScene { path, format: SourceFormat::Gltf, num_bytes, nodes, skins, animations: Vec::new() }.rigs()
}

fn scene_nodes(document: &GltfDocument) -> Result<Vec<nodes::RigNode>, String> {
    let mut out = Vec::new();
    for (i, node) in document.nodes.iter().enumerate() {
        let name = if node.name.is_empty() { format!("node {i}") } else { node.name.clone() };
        let shows = node.mesh.is_some() || node.camera.is_some();
        out.push(nodes::RigNode { name, parent: None, local: local_transform(node), bind: None, shows });
    }
    for (i, node) in document.nodes.iter().enumerate() {
        for &c in &node.children {
            let child = out.get_mut(c).ok_or_else(|| format!("nodes[{i}]: there is no node {c}"))?;
            let is_first = child.parent.replace(i).is_none();
            ensure(is_first, || format!("nodes[{c}]: it is held more than once; nodes have one parent"))?;
        }
    }
    Ok(out)
}

pub(crate) fn local_transform(node: &GltfNode) -> Transform {
    if let Some(m) = node.matrix {
        let (scale, rotation, translation) = Mat4::from_cols_array(&m).as_dmat4().to_scale_rotation_translation();
        return Transform { scale, rotation, translation };
    }
    let vector = |v: Option<[f32; 3]>, default| v.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |r| DQuat::from_array(r.map(f64::from)));
    Transform { scale: vector(node.scale, DVec3::ONE), rotation, translation: vector(node.translation, DVec3::ZERO) }
}

/// The nodes, with the rotations of joints in which skins were bound to them.
fn bound_nodes(document: &GltfDocument, reader: &AccessorReader<'_>) -> Result<Vec<nodes::RigNode>, String> {
    let mut nodes = scene_nodes(document)?;
    for (i, skin) in document.skins.iter().enumerate() {
        let what = || format!("skins[{i}]: expected at most {MAX_JOINTS} joints, found {}", skin.joints.len());
        ensure(skin.joints.len() <= MAX_JOINTS, what)?;
        let Some(accessor) = skin.inverse_bind_matrices else { continue };
        let fail = |e: String| format!("skins[{i}].inverseBindMatrices: {e}");
        let (found, least) = (reader.count(accessor).map_err(fail)?, skin.joints.len());
        ensure(found >= least, || fail(format!("expected {least} matrices, found fewer")))?;
        ensure(found <= MAX_JOINTS, || fail(format!("expected at most {MAX_JOINTS} matrices, found more")))?;
        let numbers = reader.floats(accessor, "MAT4").map_err(fail)?;
        for (&joint, m) in skin.joints.iter().zip(numbers.chunks_exact(16)) {
            let node = nodes.get_mut(joint).ok_or_else(|| format!("skins[{i}]: there is no node {joint}"))?;
            let matrix = DMat4::from_cols_array(&std::array::from_fn(|k| f64::from(m[k])));
            // A matrix without a rotation leaves the pose of the nodes.
            let (_, rotation, _) = matrix.inverse().to_scale_rotation_translation();
            node.bind = node.bind.or(Some(rotation).filter(|r| r.is_normalized()));
        }
    }
    Ok(nodes)
}

/// The keys of an animation, by the node that they move.
struct KeyTracks {
    name: String,
    by_node: BTreeMap<usize, [Option<Keys>; 3]>,
    moved: BTreeSet<usize>,
}

/// Quantities that keys move, in the order of [`KeyTracks::by_node`].
const PATHS: [&str; 3] = ["scale", "rotation", "translation"];

impl KeyTracks {
    fn new(own: &GltfAnimation, place: usize, num_nodes: usize, samplers: &mut Samplers<'_>) -> Result<Self, String> {
        let mut by_node = BTreeMap::<usize, [Option<Keys>; 3]>::new();
        for (i, channel) in own.channels.iter().enumerate() {
            let path = PATHS.iter().position(|p| *p == channel.target.path);
            let (Some(path), Some(node)) = (path, channel.target.node) else { continue };
            ensure(node < num_nodes, || format!("channels[{i}]: there is no node {node}"))?;
            let at = channel.sampler;
            let sampler = own.samplers.get(at).ok_or_else(|| format!("channels[{i}]: there is no sampler {at}"))?;
            let keys = samplers.keys(sampler, PATHS[path] == "rotation").map_err(|e| format!("samplers[{at}]: {e}"))?;
            by_node.entry(node).or_default()[path] = Some(keys);
        }
        let name = if own.name.is_empty() { format!("animation {place}") } else { own.name.clone() };
        let moved = by_node.keys().copied().collect();
        Ok(Self { name, by_node, moved })
    }
}

impl nodes::NodeAnimation for KeyTracks {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn moved(&self) -> &BTreeSet<usize> {
        &self.moved
    }

    fn span(&self, nodes: &BTreeSet<usize>) -> AnimationSpan {
        let of_nodes = self.by_node.iter().filter(|(n, _)| nodes.contains(n));
        let tracks = of_nodes.flat_map(|(_, keys)| keys.iter().flatten()).map(Keys::times);
        let (begin, end) = tracks.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(begin, end), times| {
            // They are in order.
            (times.first().map_or(begin, |t| begin.min(*t)), times.last().map_or(end, |t| end.max(*t)))
        });
        let (rate_hz, why) = match rate_of_keys(tracks) {
            Some(rate_hz) => (rate_hz, "most keys are that far apart"),
            None => (FALLBACK_HZ, "its keys are too far apart to be frames"),
        };
        AnimationSpan { begin, end, rate_hz, finding: format!("{rate_hz} frames a second: {why}.") }
    }

    fn local(&self, node: usize, seconds: f64, rest: Transform) -> Transform {
        let Some([scale, rotation, translation]) = self.by_node.get(&node) else { return rest };
        let vector = |keys: &Option<Keys>, rest| keys.as_ref().map_or(rest, |k| k.vector(seconds));
        Transform {
            scale: vector(scale, rest.scale),
            rotation: rotation.as_ref().map_or(rest.rotation, |k| k.rotation(seconds)),
            translation: vector(translation, rest.translation),
        }
    }
}
