//! Numbers of glTF accessors.

use super::document::{Accessor, GltfDocument, Sparse, SparsePart};
use super::{super::archive::read_file, super::source::content_error};
use crate::error::{ImportError, ensure};
use crate::export::glb::parts::{FLOAT, UNSIGNED_BYTE, UNSIGNED_SHORT};
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

/// Most bytes of all buffers of a document together (1 GiB).
pub const MAX_BYTES: u64 = 1 << 30;
/// Most items of an accessor without bytes.
const MAX_ZEROS: usize = 1_000_000;

const BYTE: u32 = 5120;
const SHORT: u32 = 5122;
const UNSIGNED_INT: u32 = 5125;

/// The buffers of a document, read.
pub struct AccessorReader<'a> {
    document: &'a GltfDocument,
    /// Bytes of each buffer; `None` for buffers whose contents are only in compressed parts.
    buffers: Vec<Option<Cow<'a, [u8]>>>,
}

impl<'a> AccessorReader<'a> {
    /// Reads all buffers: `binary` is the one without a place of its own, files lie beside `path`.
    ///
    /// # Errors
    /// [`ImportError`] with file and buffer.
    pub fn new(document: &'a GltfDocument, binary: Option<&'a [u8]>, path: &Path) -> Result<Self, ImportError> {
        let mut buffers: Vec<Option<Cow<'a, [u8]>>> = Vec::new();
        let mut left = MAX_BYTES;
        for (i, buffer) in document.buffers.iter().enumerate() {
            let fail = |what: &str, help| content_error(path, format!("buffers[{i}]: {what}"), help);
            let bytes = match buffer.uri.as_deref() {
                None => binary.filter(|_| i == 0).map(Cow::Borrowed),
                Some(uri) if uri.starts_with("data:") => {
                    let data = uri.split_once(";base64,").and_then(|(_, text)| base64(text));
                    Some(Cow::Owned(data.ok_or_else(|| fail("expected data in base64", "Export it again"))?))
                }
                Some(uri) => {
                    let file = path_beside(path, uri).map_err(|e| fail(&e, "Put it there"))?;
                    // Buffers of one file count each time: the rest of the limit for all is the limit of this one.
                    Some(Cow::Owned(read_file(&file, "what is left for the buffers of a document", left)?))
                }
            };
            let length = bytes.as_ref().map_or(0, |b| b.len() as u64);
            let what = format!("expected {} MiB at most in all buffers, found more", MAX_BYTES >> 20);
            left = left.checked_sub(length).ok_or_else(|| fail(&what, "Export less at once"))?;
            buffers.push(bytes);
        }
        Ok(Self { document, buffers })
    }

    /// A reader of the only buffer of a document, which was read before.
    pub(crate) fn from_buffer(document: &'a GltfDocument, bytes: &'a [u8]) -> Self {
        Self { document, buffers: vec![Some(Cow::Borrowed(bytes))] }
    }

    /// The bytes of a part of a buffer.
    ///
    /// # Errors
    /// The fault in it.
    pub(crate) fn view(&self, view: usize) -> Result<&[u8], String> {
        let length = self.document.buffer_views.get(view).map_or(0, |v| v.byte_length);
        let mut whole = self.items(view, 0, 1, length)?;
        whole.next().ok_or_else(|| format!("bufferViews[{view}] is empty"))
    }

    /// The bytes of a buffer, where it has some.
    pub(crate) fn bytes(&self, buffer: usize) -> Option<&[u8]> {
        self.buffers.get(buffer)?.as_deref()
    }

    /// Bytes of all buffers.
    pub fn num_bytes(&self) -> usize {
        self.buffers.iter().flatten().map(|b| b.len()).sum()
    }

    /// Numbers of an accessor, those of one item after another; whole numbers that stand for fractions are converted.
    ///
    /// - `kind`: type of its items: `SCALAR`, `VEC2`, `VEC3`, `VEC4` or `MAT4`.
    ///
    /// # Errors
    /// The accessor and its fault.
    pub fn floats(&self, accessor: usize, kind: &str) -> Result<Vec<f32>, String> {
        let a = self.accessor(accessor)?;
        self.numbers(a, kind).map_err(|what| format!("accessors[{accessor}]: {what}"))
    }

    /// Numbers of an accessor of indices.
    ///
    /// # Errors
    /// The accessor and its fault.
    pub fn indices(&self, accessor: usize) -> Result<Vec<u32>, String> {
        let name = |what: String| format!("accessors[{accessor}]: {what}");
        let a = self.accessor(accessor)?;
        let what = || format!("expected indices as SCALAR that are not sparse, found {}", a.kind);
        ensure(a.kind == "SCALAR" && a.sparse.is_none(), || name(what()))?;
        let view = a.buffer_view.ok_or_else(|| name("expected a buffer view, found none".into()))?;
        self.whole(view, a.byte_offset, a.component_type, a.count).map_err(name)
    }

    /// Number of items of an accessor.
    ///
    /// # Errors
    /// An accessor that does not exist.
    pub fn count(&self, accessor: usize) -> Result<usize, String> {
        Ok(self.accessor(accessor)?.count)
    }

    fn accessor(&self, index: usize) -> Result<&'a Accessor, String> {
        self.document.accessors.get(index).ok_or_else(|| format!("accessors[{index}]: there is no such accessor"))
    }

    fn numbers(&self, a: &Accessor, kind: &str) -> Result<Vec<f32>, String> {
        let width = match kind {
            _ if a.kind != kind => 0,
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let (size, read) = number(a.component_type, a.normalized)?;
        let fits = width > 0 && (width < 16 || a.component_type == FLOAT);
        ensure(fits, || format!("expected {kind}, found {} of type {}", a.kind, a.component_type))?;
        let mut out: Vec<f32> = match a.buffer_view {
            Some(view) => {
                let items = self.items(view, a.byte_offset, a.count, size * width)?;
                items.flat_map(|item| item.chunks_exact(size).map(read)).collect()
            }
            None if a.count > MAX_ZEROS => {
                return Err(format!("expected {MAX_ZEROS} items at most without a buffer view, found {}", a.count));
            }
            None => vec![0.0; a.count * width],
        };
        if let Some(Sparse { count, indices, values }) = &a.sparse {
            ensure(*count <= a.count, || format!("sparse: expected {} items at most, found {count}", a.count))?;
            let SparsePart { buffer_view, byte_offset, component_type } = indices;
            let places = self.whole(*buffer_view, *byte_offset, component_type.unwrap_or(0), *count)?;
            let items = self.items(values.buffer_view, values.byte_offset, *count, size * width)?;
            for (place, item) in places.into_iter().zip(items) {
                let known = out.len() / width;
                let replaced = out.chunks_exact_mut(width).nth(place as usize);
                let replaced = replaced.ok_or_else(|| format!("sparse: item {place} of {known}: expected less"))?;
                replaced.iter_mut().zip(item.chunks_exact(size).map(read)).for_each(|(o, v)| *o = v);
            }
        }
        Ok(out)
    }

    /// Whole numbers, none of them negative.
    fn whole(&self, view: usize, offset: usize, kind: u32, count: usize) -> Result<Vec<u32>, String> {
        let size = match kind {
            UNSIGNED_BYTE => 1,
            UNSIGNED_SHORT => 2,
            UNSIGNED_INT => 4,
            other => return Err(format!("expected indices as SCALAR of whole numbers, found type {other}")),
        };
        let items = self.items(view, offset, count, size)?;
        Ok(items.map(|b| b.iter().rev().fold(0u32, |v, &byte| v << 8 | u32::from(byte))).collect())
    }

    /// The bytes of every item.
    fn items(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = &[u8]>, String> {
        let v = self.document.buffer_views.get(view).ok_or_else(|| format!("there is no bufferViews[{view}]"))?;
        let buffer =
            self.buffers.get(v.buffer).ok_or_else(|| format!("bufferViews[{view}]: no buffers[{}]", v.buffer))?;
        let Some(buffer) = buffer else {
            return Err(match v.extensions.meshopt {
                Some(_) => {
                    format!("bufferViews[{view}] is compressed (meshopt_compression); export without compression")
                }
                None => format!("bufferViews[{view}]: buffers[{}] has no bytes; export it again", v.buffer),
            });
        };
        let end = v.byte_offset.checked_add(v.byte_length).filter(|&e| e <= buffer.len());
        let end =
            end.ok_or_else(|| format!("bufferViews[{view}] reaches beyond the {} bytes of its buffer", buffer.len()))?;
        let bytes = &buffer[v.byte_offset..end];
        let stride = v.byte_stride.unwrap_or(size);
        ensure(stride >= size, || format!("bufferViews[{view}].byteStride: expected at least {size}, found {stride}"))?;
        let needed = match count {
            0 => Some(0),
            n => (n - 1).checked_mul(stride).and_then(|s| s.checked_add(size)).and_then(|s| s.checked_add(offset)),
        };
        let beyond = || format!("{count} items reach beyond the {} bytes of bufferViews[{view}]", bytes.len());
        ensure(needed.is_some_and(|n| n <= bytes.len()), beyond)?;
        Ok((0..count).map(move |i| &bytes[offset + i * stride..offset + i * stride + size]))
    }
}

/// Reads a number from its bytes.
type ReadNumber = fn(&[u8]) -> f32;

/// Length of a number of a type (bytes), and its reader.
fn number(kind: u32, normalized: bool) -> Result<(usize, ReadNumber), String> {
    Ok(match (kind, normalized) {
        (BYTE, true) => (1, |b| (f32::from(b[0] as i8) / 127.0).max(-1.0)),
        (BYTE, false) => (1, |b| f32::from(b[0] as i8)),
        (UNSIGNED_BYTE, true) => (1, |b| f32::from(b[0]) / 255.0),
        (UNSIGNED_BYTE, false) => (1, |b| f32::from(b[0])),
        (SHORT, true) => (2, |b| (f32::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0)),
        (SHORT, false) => (2, |b| f32::from(i16::from_le_bytes([b[0], b[1]]))),
        (UNSIGNED_SHORT, true) => (2, |b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0),
        (UNSIGNED_SHORT, false) => (2, |b| f32::from(u16::from_le_bytes([b[0], b[1]]))),
        (FLOAT, _) => (4, |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        (other, _) => return Err(format!("expected numbers of 8 or 16 bits or of type {FLOAT}, found type {other}")),
    })
}

/// The bytes of a base64 text; `None` for characters that have no place there.
pub(crate) fn base64(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut held) = (0u32, 0);
    for c in text.trim_end_matches('=').bytes() {
        let v = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(v);
        held += 6;
        if held >= 8 {
            held -= 8;
            out.push((bits >> held) as u8);
        }
    }
    Some(out)
}

/// The file of a buffer, which lies in the folder of the file that names it, or deeper.
///
/// # Errors
/// A name that leads elsewhere.
pub fn path_beside(path: &Path, uri: &str) -> Result<PathBuf, String> {
    let name = unescaped(uri);
    let outside = || format!("expected a file in its own folder or below, found `{uri}`");
    let plain = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
    ensure(!name.is_empty() && !name.contains(['\\', ':', '\0']) && Path::new(&name).components().all(plain), outside)?;
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = folder.join(&name);
    // Links may lead anywhere. Where this fails the file does not exist, which is reported when it is read.
    match (file.canonicalize(), folder.canonicalize()) {
        (Ok(real), Ok(folder)) if !real.starts_with(&folder) => Err(outside()),
        _ => Ok(file),
    }
}

/// A file name whose `%20` and the like are written out.
fn unescaped(uri: &str) -> String {
    let mut parts = uri.split('%');
    let mut out = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        let code = part.get(..2).and_then(|h| u8::from_str_radix(h, 16).ok());
        out.push(code.unwrap_or(b'%'));
        out.extend_from_slice(&part.as_bytes()[if code.is_some() { 2 } else { 0 }..]);
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_escaped_names_are_written_out() {
        assert_eq!(base64("TWFueSBoYW5kcw==").as_deref(), Some(&b"Many hands"[..]));
        assert_eq!(base64("+/+/").as_deref(), Some(&[0xfb, 0xff, 0xbf][..]));
        assert_eq!(base64("a b"), None);
        assert_eq!(unescaped("my%20part.bin"), "my part.bin");
        assert_eq!(unescaped("100%"), "100%");
    }
}
