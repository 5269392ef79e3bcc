//! The parts of a glTF 2.0 document that geometry and motion need, and the container that may hold it.

use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, SeqAccess, Visitor};
use std::marker::PhantomData;

/// "glTF" at the start of binary files.
const MAGIC: &[u8] = b"glTF";
/// Type of the chunk that holds the document.
const JSON: u32 = 0x4E4F_534A;
/// Type of the chunk that holds buffer 0.
const BIN: u32 = 0x004E_4942;

/// Most bytes of the document, buffers in it included (128 MiB).
const MAX_TEXT: usize = 128 << 20;
/// Most entries of each list of the document.
const MAX_ITEMS: usize = 1_000_000;

/// A glTF document. Its parts name each other by their places in these lists.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct GltfDocument {
    /// The scene that is shown.
    pub scene: Option<usize>,
    /// All scenes.
    #[serde(deserialize_with = "limited")]
    pub scenes: Vec<SceneNodes>,
    /// All nodes.
    #[serde(deserialize_with = "limited")]
    pub nodes: Vec<GltfNode>,
    /// All meshes.
    #[serde(deserialize_with = "limited")]
    pub meshes: Vec<GltfMesh>,
    /// All materials.
    #[serde(deserialize_with = "limited")]
    pub materials: Vec<GltfMaterial>,
    /// All skins.
    #[serde(deserialize_with = "limited")]
    pub skins: Vec<Skin>,
    /// All animations.
    #[serde(deserialize_with = "limited")]
    pub animations: Vec<GltfAnimation>,
    /// All accessors.
    #[serde(deserialize_with = "limited")]
    pub accessors: Vec<Accessor>,
    /// All parts of buffers.
    #[serde(deserialize_with = "limited")]
    pub buffer_views: Vec<BufferView>,
    /// All buffers.
    #[serde(deserialize_with = "limited")]
    pub buffers: Vec<Buffer>,
    /// Extensions without which the document means something else.
    #[serde(deserialize_with = "limited")]
    pub extensions_required: Vec<String>,
}

/// The outermost nodes of a scene.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct SceneNodes {
    /// Nodes.
    pub nodes: Vec<usize>,
}

/// A frame, what it shows and the frames in it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct GltfNode {
    /// Name, which need not be unique.
    pub name: String,
    /// Nodes in its frame.
    pub children: Vec<usize>,
    /// Mesh that it shows.
    pub mesh: Option<usize>,
    /// Skin that moves the mesh.
    pub skin: Option<usize>,
    /// Camera at the node.
    pub camera: Option<usize>,
    /// Frame in that of its parent, in columns; instead of the three that follow.
    pub matrix: Option<[f32; 16]>,
    /// Origin in the frame of its parent (m).
    pub translation: Option<[f32; 3]>,
    /// Rotation as a quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    /// Scale along its own axes.
    pub scale: Option<[f32; 3]>,
    /// Properties that a program added.
    pub extras: serde_json::Value,
}

/// A material.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct GltfMaterial {
    /// Its name.
    pub name: String,
}

/// Geometry in parts.
#[derive(Debug, Deserialize)]
pub struct GltfMesh {
    /// Parts.
    pub primitives: Vec<GltfPrimitive>,
}

/// A part of a mesh.
#[derive(Debug, Deserialize)]
pub struct GltfPrimitive {
    /// Attributes of each corner.
    pub attributes: Attributes,
    /// Accessor of the corners in order.
    pub indices: Option<usize>,
    /// Points, lines or triangles.
    pub mode: Option<u32>,
    /// Index of its material.
    pub material: Option<usize>,
}

/// Accessors of the attributes of corners; other attributes are not read.
#[derive(Debug, Deserialize)]
pub struct Attributes {
    /// Accessor of positions.
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
    /// Accessor of unit vectors outwards.
    #[serde(rename = "NORMAL")]
    pub normal: Option<usize>,
    /// Accessor of places in textures.
    #[serde(rename = "TEXCOORD_0")]
    pub texture: Option<usize>,
    /// Accessor of places of joints in the list of the skin.
    #[serde(rename = "JOINTS_0")]
    pub joints: Option<usize>,
    /// Accessor of how much each of them moves the corner.
    #[serde(rename = "WEIGHTS_0")]
    pub weights: Option<usize>,
}

/// Joints that carry a mesh.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Skin {
    /// Nodes.
    pub joints: Vec<usize>,
    /// Accessor of a matrix for each joint: from the space of the mesh to the joint's, in the bind pose.
    pub inverse_bind_matrices: Option<usize>,
}

/// Motion of nodes.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct GltfAnimation {
    /// Its name.
    pub name: String,
    /// Quantities that move, with their samplers.
    #[serde(deserialize_with = "limited")]
    pub channels: Vec<GltfChannel>,
    /// Values over time.
    #[serde(deserialize_with = "limited")]
    pub samplers: Vec<GltfSampler>,
}

/// A quantity of a node that a sampler moves.
#[derive(Debug, Deserialize)]
pub struct GltfChannel {
    /// Place in the animation's list of samplers.
    pub sampler: usize,
    /// The quantity.
    pub target: GltfTarget,
}

/// A quantity of a node.
#[derive(Debug, Deserialize)]
pub struct GltfTarget {
    /// The node; extensions leave it out.
    pub node: Option<usize>,
    /// `translation`, `rotation`, `scale`, `weights`, or what extensions add.
    pub path: String,
}

/// Values over time.
#[derive(Debug, Deserialize)]
pub struct GltfSampler {
    /// Accessor of the times (s).
    pub input: usize,
    /// Accessor of the values.
    pub output: usize,
    /// Interpolation between them.
    #[serde(default)]
    pub interpolation: Interpolation,
}

/// Interpolation between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Interpolation {
    /// The shortest path from one to the other.
    #[default]
    Linear,
    /// The earlier one.
    Step,
    /// A cubic spline, whose tangents lie before and after each value.
    CubicSpline,
}

/// Typed numbers in a part of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    /// Buffer view of the numbers; zeros where it is absent.
    pub buffer_view: Option<usize>,
    /// First byte in the view.
    #[serde(default)]
    pub byte_offset: usize,
    /// Code of the type of one number.
    pub component_type: u32,
    /// True where whole numbers stand for -1 to 1, or 0 to 1.
    #[serde(default)]
    pub normalized: bool,
    /// Number of items.
    pub count: usize,
    /// Type of an item by its numbers: `SCALAR`, `VEC3` and so on.
    #[serde(rename = "type")]
    pub kind: String,
    /// Items that differ from those in the buffer view.
    pub sparse: Option<Sparse>,
}

/// Items that replace those of an accessor.
#[derive(Debug, Deserialize)]
pub struct Sparse {
    /// Number of replaced items.
    pub count: usize,
    /// Indices of the replaced items.
    pub indices: SparsePart,
    /// Their numbers.
    pub values: SparsePart,
}

/// Buffer view of indices or numbers of replaced items.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparsePart {
    /// Buffer view.
    pub buffer_view: usize,
    /// First byte in it.
    #[serde(default)]
    pub byte_offset: usize,
    /// Code of the type of a place; that of the accessor, for numbers.
    pub component_type: Option<u32>,
}

/// A part of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    /// The buffer.
    pub buffer: usize,
    /// First byte in it.
    #[serde(default)]
    pub byte_offset: usize,
    /// Number of bytes.
    pub byte_length: usize,
    /// Bytes from one item to the next.
    pub byte_stride: Option<usize>,
    /// Data of extensions.
    #[serde(default)]
    pub extensions: ViewExtensions,
}

/// Data of extensions for a part of a buffer.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct ViewExtensions {
    /// Present where its bytes are elsewhere, compressed.
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub meshopt: Option<IgnoredAny>,
}

/// Bytes, in a file of their own, in the text, or in the binary container.
#[derive(Debug, Deserialize)]
pub struct Buffer {
    /// Place of the bytes.
    pub uri: Option<String>,
}

/// The document of a `.gltf` or `.glb` file and the bytes that come with it.
///
/// # Errors
/// The fault, and the way out.
pub fn parse(bytes: &[u8]) -> Result<(GltfDocument, Option<&[u8]>), String> {
    let (text, binary) = split(bytes)?;
    if text.len() > MAX_TEXT {
        let mib = MAX_TEXT >> 20;
        return Err(format!("its document has {} bytes, expected {mib} MiB at most; export it as .glb", text.len()));
    }
    let document = serde_json::from_slice(text).map_err(|e| format!("expected a glTF 2.0 document as JSON: {e}"))?;
    Ok((document, binary))
}

/// The text of a document and the bytes that come with it.
///
/// # Errors
/// The fault in the container.
pub(crate) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if bytes.starts_with(MAGIC) { chunks(bytes) } else { Ok((bytes, None)) }
}

/// A list that is not longer than [`MAX_ITEMS`]: in memory, an entry is up to a hundred times as long as in the text.
fn limited<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    struct List<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for List<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("a list")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
            let mut out = Vec::new();
            while let Some(item) = list.next_element()? {
                if out.len() == MAX_ITEMS {
                    return Err(A::Error::custom(format!("a list may have {MAX_ITEMS} entries, found more")));
                }
                out.push(item);
            }
            Ok(out)
        }
    }
    deserializer.deserialize_seq(List(PhantomData))
}

/// The document and the first binary chunk of a binary file.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| {
        let b = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    match word(4) {
        Some(2) => {}
        Some(v) => return Err(format!("expected glTF version 2, found {v}")),
        None => return Err("the file ends within its header".into()),
    }
    let mut at = 12;
    let (mut text, mut binary) = (None, None);
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let end = (at + 8).checked_add(length as usize).filter(|&e| e <= bytes.len());
        let end = end.ok_or_else(|| format!("the file ends within the chunk at byte {at}"))?;
        let chunk = &bytes[at + 8..end];
        match kind {
            JSON if text.is_none() => text = Some(chunk),
            BIN if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at = end;
    }
    Ok((text.ok_or("expected a chunk of JSON, found none")?, binary))
}
