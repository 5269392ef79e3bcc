//! The parts of a glTF document that geometry needs, and the container that may hold it.

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

/// A glTF document.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Document {
    pub scene: Option<usize>,
    #[serde(deserialize_with = "limited")]
    pub scenes: Vec<SceneNodes>,
    #[serde(deserialize_with = "limited")]
    pub nodes: Vec<Node>,
    #[serde(deserialize_with = "limited")]
    pub meshes: Vec<Mesh>,
    #[serde(deserialize_with = "limited")]
    pub accessors: Vec<Accessor>,
    #[serde(deserialize_with = "limited")]
    pub buffer_views: Vec<BufferView>,
    #[serde(deserialize_with = "limited")]
    pub buffers: Vec<Buffer>,
    #[serde(deserialize_with = "limited")]
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
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub mode: Option<u32>,
}

/// Accessors of what each corner has; the others are not read.
#[derive(Debug, Deserialize)]
pub struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
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
    pub sparse: Option<IgnoredAny>,
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
    if text.len() > MAX_TEXT {
        let mib = MAX_TEXT >> 20;
        return Err(format!("its document has {} bytes, expected {mib} MiB at most; export it as .glb", text.len()));
    }
    let document: Document =
        serde_json::from_slice(text).map_err(|e| format!("expected a glTF 2.0 document as JSON: {e}"))?;
    if let Some(extension) = document.extensions_required.first() {
        let help = "export without compression and other required extensions";
        return Err(format!("extensionsRequired: `{extension}` is not supported; {help}"));
    }
    Ok((document, binary))
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
