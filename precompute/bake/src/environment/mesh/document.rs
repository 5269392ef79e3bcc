//! The parts of a glTF document that geometry needs, and the container that may hold it.

use serde::Deserialize;
use std::collections::BTreeMap;

/// "glTF" at the start of binary files.
const MAGIC: &[u8] = b"glTF";
/// Type of the chunk that holds the document.
const JSON: u32 = 0x4E4F_534A;
/// Type of the chunk that holds buffer 0.
const BIN: u32 = 0x004E_4942;

/// A glTF document.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Document {
    pub scene: Option<usize>,
    pub scenes: Vec<SceneNodes>,
    pub nodes: Vec<Node>,
    pub meshes: Vec<Mesh>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    pub extensions_required: Vec<String>,
}

/// The outermost nodes of a scene.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct SceneNodes {
    pub nodes: Vec<usize>,
}

/// A frame, what it shows and the frames in it.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Node {
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub matrix: Option<[f32; 16]>,
    pub translation: Option<[f32; 3]>,
    pub rotation: Option<[f32; 4]>,
    pub scale: Option<[f32; 3]>,
}

/// Geometry in parts.
#[derive(Debug, Deserialize)]
pub struct Mesh {
    pub primitives: Vec<Primitive>,
}

/// A part of a mesh.
#[derive(Debug, Deserialize)]
pub struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub mode: Option<u32>,
}

/// Typed numbers in a part of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<serde_json::Value>,
}

/// A part of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
}

/// Bytes, in a file of their own, in the text, or in the binary container.
#[derive(Debug, Deserialize)]
pub struct Buffer {
    pub uri: Option<String>,
}

/// The document of a `.gltf` or `.glb` file and the bytes that come with it.
pub fn parse(bytes: &[u8]) -> Result<(Document, Option<&[u8]>), String> {
    let (text, binary) = if bytes.starts_with(MAGIC) { chunks(bytes)? } else { (bytes, None) };
    let document: Document =
        serde_json::from_slice(text).map_err(|e| format!("expected a glTF 2.0 document as JSON: {e}"))?;
    if let Some(extension) = document.extensions_required.first() {
        let help = "export without compression and other required extensions";
        return Err(format!("extensionsRequired: `{extension}` is not supported; {help}"));
    }
    Ok((document, binary))
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
