//! Numbers of glTF accessors.

use super::MAX_BYTES;
use super::document::{Accessor, Document};
use glam::Vec3;
use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};
use throng_base::file::read_file;
use throng_motion::error::BuildError;

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// The buffers of a document, read.
pub struct Reader<'a> {
    document: &'a Document,
    buffers: Vec<Cow<'a, [u8]>>,
}

impl<'a> Reader<'a> {
    /// Reads all buffers: `binary` is the one without a place of its own, files lie beside `path`.
    pub fn new(document: &'a Document, binary: Option<&'a [u8]>, path: &Path) -> Result<Self, BuildError> {
        let mut buffers: Vec<Cow<'a, [u8]>> = Vec::new();
        let mut left = MAX_BYTES;
        for (i, buffer) in document.buffers.iter().enumerate() {
            let fail = |what: &str| BuildError::Config { message: format!("{}: buffers[{i}]: {what}", path.display()) };
            let bytes = match buffer.uri.as_deref() {
                None => Cow::Borrowed(binary.filter(|_| i == 0).ok_or_else(|| fail("it has no bytes"))?),
                Some(uri) if uri.starts_with("data:") => {
                    let text = uri.split_once(";base64,").ok_or_else(|| fail("expected data in base64"))?.1;
                    Cow::Owned(base64(text).ok_or_else(|| fail("expected data in base64, found other characters"))?)
                }
                Some(uri) => {
                    let file = beside(path, uri).map_err(|e| fail(&e))?;
                    // Buffers of one file count each time: what is left for all of them is what this one may have.
                    Cow::Owned(read_file(&file, "what is left for the buffers of a mesh", left)?)
                }
            };
            left = left
                .checked_sub(bytes.len() as u64)
                .ok_or_else(|| fail(&format!("expected {} MiB at most in all buffers, found more", MAX_BYTES >> 20)))?;
            buffers.push(bytes);
        }
        Ok(Self { document, buffers })
    }

    /// Numbers of an accessor of positions.
    pub fn positions(&self, accessor: usize) -> Result<Vec<Vec3>, String> {
        let name = |what: String| format!("accessors[{accessor}]: {what}");
        let a = self.accessor(accessor)?;
        if a.component_type != FLOAT || a.kind != "VEC3" {
            let found = (a.component_type, &a.kind);
            return Err(name(format!(
                "expected positions as VEC3 of type {FLOAT}, found {} of type {}",
                found.1, found.0
            )));
        }
        let number = |b: &[u8], i: usize| f32::from_le_bytes([b[i], b[i + 1], b[i + 2], b[i + 3]]);
        let items = self.items(a, 12).map_err(name)?;
        Ok(items.map(|b| Vec3::new(number(b, 0), number(b, 4), number(b, 8))).collect())
    }

    /// Numbers of an accessor of indices.
    pub fn indices(&self, accessor: usize) -> Result<Vec<u32>, String> {
        let name = |what: String| format!("accessors[{accessor}]: {what}");
        let a = self.accessor(accessor)?;
        let size = match (a.component_type, a.kind.as_str()) {
            (UNSIGNED_BYTE, "SCALAR") => 1,
            (UNSIGNED_SHORT, "SCALAR") => 2,
            (UNSIGNED_INT, "SCALAR") => 4,
            (t, kind) => {
                return Err(name(format!("expected indices as SCALAR of whole numbers, found {kind} of type {t}")));
            }
        };
        let items = self.items(a, size).map_err(name)?;
        Ok(items.map(|b| b.iter().rev().fold(0u32, |v, &byte| v << 8 | u32::from(byte))).collect())
    }

    /// Number of items of an accessor.
    pub fn count(&self, accessor: usize) -> Result<usize, String> {
        Ok(self.accessor(accessor)?.count)
    }

    fn accessor(&self, index: usize) -> Result<&'a Accessor, String> {
        self.document.accessors.get(index).ok_or_else(|| format!("accessors[{index}]: there is no such accessor"))
    }

    /// The bytes of every item.
    fn items(&self, a: &Accessor, size: usize) -> Result<impl Iterator<Item = &[u8]>, String> {
        if a.sparse.is_some() {
            return Err("sparse accessors are not supported; export without them".into());
        }
        let view = a.buffer_view.ok_or("expected a buffer view, found none; export without compression")?;
        let v = self.document.buffer_views.get(view).ok_or_else(|| format!("there is no bufferViews[{view}]"))?;
        let buffer =
            self.buffers.get(v.buffer).ok_or_else(|| format!("bufferViews[{view}]: no buffers[{}]", v.buffer))?;
        let end = v.byte_offset.checked_add(v.byte_length).filter(|&e| e <= buffer.len());
        let end =
            end.ok_or_else(|| format!("bufferViews[{view}] reaches beyond the {} bytes of its buffer", buffer.len()))?;
        let bytes = &buffer[v.byte_offset..end];
        let stride = v.byte_stride.unwrap_or(size);
        if stride < size {
            return Err(format!("bufferViews[{view}].byteStride: expected at least {size}, found {stride}"));
        }
        let needed = match a.count {
            0 => Some(0),
            n => {
                (n - 1).checked_mul(stride).and_then(|s| s.checked_add(size)).and_then(|s| s.checked_add(a.byte_offset))
            }
        };
        match needed {
            Some(n) if n <= bytes.len() => {
                Ok((0..a.count).map(move |i| &bytes[a.byte_offset + i * stride..a.byte_offset + i * stride + size]))
            }
            _ => Err(format!("{} items reach beyond the {} bytes of bufferViews[{view}]", a.count, bytes.len())),
        }
    }
}

/// The bytes of a base64 text; `None` for characters that have no place there.
fn base64(text: &str) -> Option<Vec<u8>> {
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
pub fn beside(path: &Path, uri: &str) -> Result<PathBuf, String> {
    let name = unescaped(uri);
    let outside = || format!("expected a file in the folder of the mesh, found `{uri}`; put it there");
    let plain = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
    if name.is_empty() || name.contains(['\\', ':', '\0']) || !Path::new(&name).components().all(plain) {
        return Err(outside());
    }
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = folder.join(&name);
    // Links may lead anywhere. Where this fails there is no such file, which is said when it is read.
    match (file.canonicalize(), folder.canonicalize()) {
        (Ok(real), Ok(folder)) if !real.starts_with(&folder) => Err(outside()),
        _ => Ok(file),
    }
}

/// A file name whose `%20` and the like are written out.
fn unescaped(uri: &str) -> String {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&c, after)) = rest.split_first() {
        let code =
            after.get(..2).and_then(|h| std::str::from_utf8(h).ok()).and_then(|h| u8::from_str_radix(h, 16).ok());
        match code.filter(|_| c == b'%') {
            Some(byte) => {
                out.push(byte);
                rest = &after[2..];
            }
            None => {
                out.push(c);
                rest = after;
            }
        }
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
