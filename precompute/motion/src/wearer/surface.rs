//! The triangles of a character, their materials, and the frames that move them.

use super::Wearer;
use crate::error::ensure;
use crate::import::gltf::{AccessorReader, GltfPrimitive, MAX_BYTES, MAX_PARTS, MAX_TRIANGLES, TRIANGLES, base64};
use glam::{Mat4, Vec2, Vec3};
use serde_json::Value;
use std::{collections::HashMap, collections::hash_map::Entry, ops::Range};

/// Weight below which a joint does not count.
const MIN_WEIGHT: f32 = 1e-6;
/// Material of parts without one.
const PLAIN: Material = Material { colour: [0.6, 0.6, 0.6, 1.0], image: None, cutoff: 0.0 };

/// A corner of a character's triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCorner {
    /// Position in the space of its mesh (units of the file).
    pub position: Vec3,
    /// Normal outwards (unit, or 0 where the triangles there have no area).
    pub normal: Vec3,
    /// Position in its texture.
    pub texture: Vec2,
    /// Frames that move it, the strongest first.
    pub frames: [u16; 4],
    /// Weight of each frame (they sum to 1).
    pub weights: [f32; 4],
    /// Index in the list of materials.
    pub material: u16,
}

/// Look of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Red, green, blue and alpha, linear (0 to 1).
    pub colour: [f32; 4],
    /// Index in the list of images.
    pub image: Option<usize>,
    /// Alpha below which a surface is not drawn; 0 for whole surfaces.
    pub cutoff: f32,
}

/// The triangles of a character.
#[derive(Clone, Debug, Default)]
pub struct FigureSurface {
    /// Corners.
    pub corners: Vec<SurfaceCorner>,
    /// Indices of corners: three for each triangle, anticlockwise from outside.
    pub indices: Vec<u32>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Files of images, as they are in the file of the character.
    pub images: Vec<Vec<u8>>,
    /// Frames that move corners: a node, and the transform from the space of the mesh to the node's at rest.
    pub(super) frames: Vec<(usize, Mat4)>,
}

impl FigureSurface {
    /// Reads the meshes of a character: those of its skins, and those that hang on its joints.
    ///
    /// - `places`: index of each node of the document among the character's; `None` for nodes that are not its own.
    ///
    /// # Errors
    /// The part of the document that is missing or wrong.
    pub(super) fn read(wearer: &Wearer, places: &[Option<usize>]) -> Result<Self, String> {
        let document = &wearer.document;
        let compressed = |e: &&String| e.contains("draco") || e.contains("meshopt");
        if let Some(extension) = document.extensions_required.iter().find(compressed) {
            return Err(format!("its meshes are compressed ({extension}); export without compression"));
        }
        let reader = AccessorReader::from_buffer(document, &wearer.buffer);
        let mut out = Self { materials: materials(&wearer.json), ..Self::default() };
        let mut starts: HashMap<usize, usize> = HashMap::new();
        let is_own = |node: usize| places.get(node).is_some_and(Option::is_some);
        let mut parts = 0;
        for (n, node) in document.nodes.iter().enumerate() {
            let Some(mesh) = node.mesh else { continue };
            let mesh = document.meshes.get(mesh).ok_or_else(|| format!("nodes[{n}]: there is no mesh {mesh}"))?;
            let start = match node.skin {
                Some(skin) => {
                    let known =
                        document.skins.get(skin).ok_or_else(|| format!("nodes[{n}]: there is no skin {skin}"))?;
                    let missing = || format!("nodes[{n}]: expected joints in skin {skin}, found none");
                    // Skins lie within one skeleton.
                    if !is_own(*known.joints.first().ok_or_else(missing)?) {
                        continue;
                    }
                    match starts.entry(skin) {
                        Entry::Occupied(entry) => *entry.get(),
                        Entry::Vacant(entry) => *entry.insert(out.bind(&reader, skin, wearer)?),
                    }
                }
                None if is_own(n) => {
                    out.frames.push((n, Mat4::IDENTITY));
                    out.frames.len() - 1
                }
                None => continue,
            };
            parts += mesh.primitives.len();
            let too_many = || format!("a character may have {MAX_PARTS} parts of meshes at most; merge them");
            ensure(parts <= MAX_PARTS, too_many)?;
            for (i, primitive) in mesh.primitives.iter().enumerate() {
                let joints = node.skin.map(|s| start..start + document.skins[s].joints.len());
                out.primitive(&reader, primitive, joints, start).map_err(|e| format!("nodes[{n}], part {i}: {e}"))?;
            }
        }
        ensure(!out.indices.is_empty(), || "expected triangles on its skin, found none".to_owned())?;
        let too_many = || format!("expected {} joints of skins at most, found {}", u16::MAX, out.frames.len());
        ensure(out.frames.len() <= usize::from(u16::MAX), too_many)?;
        out.images = images(&wearer.json, &reader)?;
        let exist = out.materials.iter().filter_map(|m| m.image).all(|i| i < out.images.len());
        ensure(exist, || "a material names an image that there is not".to_owned())?;
        Ok(out)
    }

    /// Adds the frames of a skin; returns the index of the first.
    fn bind(&mut self, reader: &AccessorReader<'_>, skin: usize, wearer: &Wearer) -> Result<usize, String> {
        let (start, skin) = (self.frames.len(), &wearer.document.skins[skin]);
        let numbers = skin.inverse_bind_matrices.map(|a| reader.floats(a, "MAT4")).transpose()?;
        for (i, &joint) in skin.joints.iter().enumerate() {
            let inverse = match &numbers {
                Some(n) => Mat4::from_cols_slice(n.get(16 * i..16 * i + 16).ok_or("expected a matrix for each joint")?),
                None => Mat4::IDENTITY,
            };
            self.frames.push((joint, inverse));
        }
        Ok(start)
    }

    /// - `joints`: frames of the skin; `None` where all of it hangs on the frame `start`.
    fn primitive(
        &mut self,
        reader: &AccessorReader<'_>,
        primitive: &GltfPrimitive,
        joints: Option<Range<usize>>,
        start: usize,
    ) -> Result<(), String> {
        match primitive.mode.unwrap_or(TRIANGLES) {
            TRIANGLES => {}
            5..=6 => return Err("expected separate triangles; export without strips and fans".into()),
            _ => return Ok(()),
        }
        let has = &primitive.attributes;
        let accessor = has.position.ok_or("expected an attribute POSITION, found none")?;
        let n = reader.count(accessor)?;
        let triangles = primitive.indices.map_or(Ok(n), |i| reader.count(i))? / 3;
        if triangles + self.indices.len() / 3 > MAX_TRIANGLES
            || n.saturating_add(self.corners.len()) > 3 * MAX_TRIANGLES
        {
            return Err(format!("a character may have {MAX_TRIANGLES} triangles at most; export a simpler mesh"));
        }
        let list = |accessor: Option<usize>, kind: &str, width: usize| {
            let Some(a) = accessor else { return Ok(Vec::new()) };
            if reader.count(a)? == n {
                return reader.floats(a, kind);
            }
            Err(format!("accessors[{a}]: expected as many items as positions, {n} (each {width} numbers)"))
        };
        let positions = list(has.position, "VEC3", 3)?;
        let (normals, places) = (list(has.normal, "VEC3", 3)?, list(has.texture, "VEC2", 2)?);
        let (carriers, weights) = (list(has.joints, "VEC4", 4)?, list(has.weights, "VEC4", 4)?);
        let is_bound = joints.is_none() || !carriers.is_empty() && !weights.is_empty();
        ensure(is_bound, || "expected attributes JOINTS_0 and WEIGHTS_0 on a skin, found none".to_owned())?;
        let material = match primitive.material {
            Some(m) if m < self.materials.len() => m,
            Some(m) => return Err(format!("there is no material {m}")),
            None => self.plain(),
        };
        let material = u16::try_from(material)
            .map_err(|_| format!("expected {} materials at most, found more; merge them", 1 << 16))?;
        let first = self.corners.len() as u32;
        let three = |v: &[f32], i: usize| v.get(3 * i..3 * i + 3).map_or(Vec3::ZERO, Vec3::from_slice);
        for i in 0..n {
            let position = three(&positions, i);
            ensure(position.is_finite(), || format!("accessors[{accessor}]: position {i} is not a number"))?;
            let (frames, weights) = match &joints {
                None => ([start as u16, 0, 0, 0], [1.0, 0.0, 0.0, 0.0]),
                Some(joints) => carrying_frames(&carriers[4 * i..4 * i + 4], &weights[4 * i..4 * i + 4], joints)?,
            };
            let texture = places.get(2 * i..2 * i + 2).map_or(Vec2::ZERO, Vec2::from_slice);
            let normal = three(&normals, i).normalize_or_zero();
            self.corners.push(SurfaceCorner { position, normal, texture, frames, weights, material });
        }
        let indices = primitive.indices.map_or_else(|| Ok((0..n as u32).collect()), |i| reader.indices(i))?;
        if let Some(wrong) = indices.iter().find(|&&i| i as usize >= n) {
            return Err(format!("index {wrong} of {n} positions: expected less"));
        }
        self.indices.extend(indices.chunks_exact(3).flatten().map(|i| first + i));
        if normals.is_empty() {
            self.face_outwards(first, &indices);
        }
        Ok(())
    }

    /// Index of the material of parts without one.
    fn plain(&mut self) -> usize {
        if self.materials.last() != Some(&PLAIN) {
            self.materials.push(PLAIN);
        }
        self.materials.len() - 1
    }

    /// Makes normals of corners from the triangles around them.
    fn face_outwards(&mut self, first: u32, indices: &[u32]) {
        for t in indices.chunks_exact(3) {
            let at = |k: usize| (first + t[k]) as usize;
            let [a, b, c] = [0, 1, 2].map(|k| self.corners[at(k)].position);
            let normal = (b - a).cross(c - a);
            (0..3).for_each(|k| self.corners[at(k)].normal += normal);
        }
        let corners = &mut self.corners[first as usize..];
        corners.iter_mut().for_each(|c| c.normal = c.normal.normalize_or_zero());
    }
}

/// Frames and weights of a corner, the strongest first.
fn carrying_frames(carriers: &[f32], weights: &[f32], joints: &Range<usize>) -> Result<([u16; 4], [f32; 4]), String> {
    let mut all: [(usize, f32); 4] = std::array::from_fn(|k| (carriers[k] as usize, weights[k].max(0.0)));
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    let sum: f32 = all.iter().map(|a| a.1).sum();
    if let Some((j, _)) = all.iter().find(|(j, w)| *w > MIN_WEIGHT && *j >= joints.len()) {
        return Err(format!("JOINTS_0 names joint {j}, the skin has {}", joints.len()));
    }
    if !(sum > MIN_WEIGHT && sum.is_finite()) {
        // A corner without weights goes with the first joint.
        return Ok(([joints.start as u16, 0, 0, 0], [1.0, 0.0, 0.0, 0.0]));
    }
    let there = |(j, w): (usize, f32)| if w > MIN_WEIGHT { (joints.start + j, w / sum) } else { (joints.start, 0.0) };
    let all = all.map(there);
    Ok((all.map(|a| a.0 as u16), all.map(|a| a.1)))
}

fn materials(json: &Value) -> Vec<Material> {
    let number = |v: &Value| v.as_f64().map(|n| n as f32);
    let read = |m: &Value| {
        let surface = &m["pbrMetallicRoughness"];
        let factor = surface["baseColorFactor"].as_array();
        let colour = factor.map_or([1.0; 4], |f| std::array::from_fn(|i| f.get(i).and_then(number).unwrap_or(1.0)));
        let texture = surface["baseColorTexture"]["index"].as_u64();
        let image = texture.and_then(|t| json["textures"][t as usize]["source"].as_u64());
        let cutoff = match m["alphaMode"].as_str() {
            Some("MASK") => number(&m["alphaCutoff"]).unwrap_or(0.5),
            Some("BLEND") => 0.5,
            _ => 0.0,
        };
        Material { colour, image: image.map(|i| i as usize), cutoff }
    };
    json["materials"].as_array().into_iter().flatten().map(read).collect()
}

fn images(json: &Value, reader: &AccessorReader<'_>) -> Result<Vec<Vec<u8>>, String> {
    // Images may share bytes.
    let mut left = MAX_BYTES as usize;
    let read = |(i, image): (usize, &Value)| {
        let fail = |e: String| format!("images[{i}]: {e}");
        match (image["bufferView"].as_u64(), image["uri"].as_str()) {
            (Some(view), _) => {
                let bytes = reader.view(view as usize).map_err(fail)?;
                let after = left.checked_sub(bytes.len());
                let what = || format!("expected {} MiB at most in all images, found more", MAX_BYTES >> 20);
                left = after.ok_or_else(|| fail(what()))?;
                Ok(bytes.to_vec())
            }
            (None, Some(uri)) => {
                let data = uri.split_once(";base64,").and_then(|(_, text)| base64(text));
                data.ok_or_else(|| fail("expected data in base64".into()))
            }
            (None, None) => Err(fail("expected a buffer view or data, found neither".into())),
        }
    };
    json["images"].as_array().into_iter().flatten().enumerate().map(read).collect()
}
