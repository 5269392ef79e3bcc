//! Triangles of glTF 2.0 files: positions and indices of triangle primitives, placed by the nodes of the scene.

use super::{AccessorReader, GltfDocument, GltfNode, GltfPrimitive, MAX_BYTES, document};
use crate::error::{BuildError, Result, ensure};
use glam::{Mat4, Quat, Vec3};
use std::{collections::BTreeSet, path::Path};
use throng_base::file::read_file;

/// Most levels of nodes.
const MAX_DEPTH: usize = 64;
/// Most triangles of a file, counted each time that a node shows them.
pub const MAX_TRIANGLES: usize = 5_000_000;
/// Most corners of triangles, including positions that no triangle uses.
const MAX_POSITIONS: usize = 3 * MAX_TRIANGLES;
/// Most parts of meshes that nodes show.
pub(crate) const MAX_PARTS: usize = 1_000_000;
/// Coordinates are smaller than this (m).
const MAX_POSITION: f32 = 1e6;

/// Triangles, not lines or points.
pub(crate) const TRIANGLES: u32 = 4;

/// Reads the triangles of a `.glb` or `.gltf` file.
///
/// Nodes of the default scene are taken, or of the first one, or all without a parent where the file has no
/// scene. Lines and points, skins, morph targets and materials are left out.
///
/// # Errors
/// [`BuildError::Io`], or [`BuildError::Config`] with file and mesh, accessor or buffer.
pub fn triangles(path: &Path) -> Result<Vec<[Vec3; 3]>> {
    Ok(scene(path)?.triangles)
}

/// Triangles of a scene, and the nodes that show them.
#[derive(Debug, Default)]
pub struct TriangleScene {
    /// Corners of all triangles (m).
    pub triangles: Vec<[Vec3; 3]>,
    /// Parts of meshes, in the order of their triangles.
    pub parts: Vec<ScenePart>,
    /// Nodes, parents before their children.
    pub nodes: Vec<SceneNode>,
}

/// Triangles of a node with one material.
#[derive(Debug)]
pub struct ScenePart {
    /// First triangle.
    pub first: usize,
    /// Node in [`TriangleScene::nodes`].
    pub node: usize,
    /// Name of the material.
    pub material: String,
}

/// Node of a scene.
#[derive(Debug)]
pub struct SceneNode {
    /// Name; the text of its extra property `throng` where it has one.
    pub name: String,
    /// Origin (m).
    pub at: Vec3,
    /// Parent in [`TriangleScene::nodes`].
    pub parent: Option<usize>,
}

/// Reads the triangles of a file as [`triangles`] does, with names.
///
/// # Errors
/// As [`triangles`].
pub fn scene(path: &Path) -> Result<TriangleScene> {
    let fail = |what: String| BuildError::Config { message: format!("{}: {what}", path.display()) };
    let bytes = read_file(path, "a mesh", MAX_BYTES)?;
    let (document, binary) = document(&bytes).map_err(fail)?;
    if let Some(extension) = document.extensions_required.first() {
        let help = "export without compression and other required extensions";
        return Err(fail(format!("extensionsRequired: `{extension}` is not supported; {help}")));
    }
    let reader = AccessorReader::new(&document, binary, path)?;
    let seen = vec![false; document.nodes.len()];
    let out = TriangleScene::default();
    let mut scene = SceneCollector { document: &document, reader, seen, positions: 0, parts: 0, out };
    for root in roots(&document).map_err(fail)? {
        scene.node(root, Mat4::IDENTITY, None, 0).map_err(fail)?;
    }
    ensure(!scene.out.triangles.is_empty(), || fail("expected triangles in the scene's meshes, found none".into()))?;
    Ok(scene.out)
}

fn roots(document: &GltfDocument) -> Result<Vec<usize>, String> {
    let scene = document.scene.unwrap_or(0);
    match document.scenes.get(scene) {
        Some(s) => Ok(s.nodes.clone()),
        None if document.scene.is_some() => Err(format!("scene: there is no scene {scene}")),
        None => {
            let children: BTreeSet<usize> = document.nodes.iter().flat_map(|n| &n.children).copied().collect();
            Ok((0..document.nodes.len()).filter(|i| !children.contains(i)).collect())
        }
    }
}

/// A scene whose triangles are being collected.
struct SceneCollector<'a> {
    document: &'a GltfDocument,
    reader: AccessorReader<'a>,
    /// True for nodes that were visited.
    seen: Vec<bool>,
    /// Positions that were read so far, over all parts.
    positions: usize,
    /// Parts of meshes that were visited so far.
    parts: usize,
    out: TriangleScene,
}

impl SceneCollector<'_> {
    fn node(&mut self, index: usize, outer: Mat4, parent: Option<usize>, depth: usize) -> Result<(), String> {
        let node = self.document.nodes.get(index).ok_or_else(|| format!("nodes[{index}]: there is no such node"))?;
        ensure(depth <= MAX_DEPTH, || format!("nodes[{index}]: expected at most {MAX_DEPTH} levels of nodes"))?;
        let is_first = !std::mem::replace(&mut self.seen[index], true);
        ensure(is_first, || format!("nodes[{index}]: it is held more than once; nodes have one parent"))?;
        let here = outer * transform(node).map_err(|e| format!("nodes[{index}].{e}"))?;
        let name = node.extras.get("throng").and_then(|mark| mark.as_str()).unwrap_or(&node.name).to_owned();
        let own = self.out.nodes.len();
        self.out.nodes.push(SceneNode { name, at: here.transform_point3(Vec3::ZERO), parent });
        if let Some(m) = node.mesh {
            let mesh =
                self.document.meshes.get(m).ok_or_else(|| format!("nodes[{index}].mesh: there is no mesh {m}"))?;
            for (i, primitive) in mesh.primitives.iter().enumerate() {
                let material = primitive.material.and_then(|m| self.document.materials.get(m));
                let material = material.map_or_else(String::new, |m| m.name.clone());
                self.out.parts.push(ScenePart { first: self.out.triangles.len(), node: own, material });
                self.primitive(primitive, here).map_err(|e| format!("meshes[{m}].primitives[{i}]: {e}"))?;
            }
        }
        node.children.iter().try_for_each(|&c| self.node(c, here, Some(own), depth + 1))
    }

    fn primitive(&mut self, primitive: &GltfPrimitive, at: Mat4) -> Result<(), String> {
        self.parts += 1;
        ensure(self.parts <= MAX_PARTS, || format!("nodes may show {MAX_PARTS} parts of meshes at most; merge them"))?;
        match primitive.mode.unwrap_or(TRIANGLES) {
            TRIANGLES => {}
            mode @ 5..=6 => {
                return Err(format!("mode {mode}: expected separate triangles; export without strips and fans"));
            }
            _ => return Ok(()),
        }
        let accessor = primitive.attributes.position.ok_or("expected an attribute POSITION, found none")?;
        // Parts may share accessors, so that a short text asks for much memory: they are counted before anything is made.
        let positions = self.reader.count(accessor)?;
        self.positions = self.positions.saturating_add(positions);
        let triangles = primitive.indices.map_or(Ok(positions), |i| self.reader.count(i))? / 3;
        if self.positions > MAX_POSITIONS || triangles > MAX_TRIANGLES - self.out.triangles.len() {
            return Err(format!(
                "a file may have {MAX_TRIANGLES} triangles and {MAX_POSITIONS} positions at most, each node that shows a \
                 mesh counted; export a simpler mesh"
            ));
        }
        let numbers = self.reader.floats(accessor, "VEC3")?;
        let points: Vec<Vec3> = numbers.chunks_exact(3).map(|p| at.transform_point3(Vec3::from_slice(p))).collect();
        if let Some(i) = points.iter().position(|p| p.is_nan() || p.abs().max_element() >= MAX_POSITION) {
            let point = points[i];
            return Err(format!("accessors[{accessor}]: position {i} is not a moderate number of metres: {point}"));
        }
        let indices = match primitive.indices {
            Some(i) => self.reader.indices(i)?,
            None => (0..points.len() as u32).collect(),
        };
        for t in indices.chunks_exact(3) {
            let corner = |k: usize| {
                let i = t[k] as usize;
                let known = points.len();
                points.get(i).copied().ok_or_else(|| format!("index {i} of {known} positions: expected less"))
            };
            self.out.triangles.push([corner(0)?, corner(1)?, corner(2)?]);
        }
        Ok(())
    }
}

/// A node's frame in its parent's.
fn transform(node: &GltfNode) -> Result<Mat4, String> {
    let (m, key) = match node.matrix {
        Some(m) => (Mat4::from_cols_array(&m), "matrix"),
        None => {
            let rotation = Quat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
            let scale = Vec3::from(node.scale.unwrap_or([1.0; 3]));
            let translation = Vec3::from(node.translation.unwrap_or([0.0; 3]));
            // Exporters round: the length is normalised.
            let m = Mat4::from_scale_rotation_translation(scale, rotation.normalize(), translation);
            (m, "rotation")
        }
    };
    if m.is_finite() { Ok(m) } else { Err(format!("{key}: expected finite numbers and a rotation other than 0")) }
}
