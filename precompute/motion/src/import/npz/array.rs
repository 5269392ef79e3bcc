//! NumPy arrays in a zip file, as `numpy.savez` and `numpy.savez_compressed` write them.

use crate::error::ensure;
use std::io::{Cursor, Read};
use throng_base::file::MAX_MOTION_BYTES;
use zip::ZipArchive;

/// Longest header of an array.
const MAX_HEADER: usize = 1 << 16;
/// Bytes of an array for each byte of its file, and for every file: arrays are compressed.
const BYTES_PER_BYTE: u64 = 64;
const FREE_BYTES: u64 = 64 << 20;
/// Most dimensions of an array.
const MAX_DIMENSIONS: usize = 8;

/// The arrays of a zip file, by name.
pub struct NpzArrays<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Most bytes of an array.
    most: u64,
}

/// Numbers and their shape, read as 64-bit floats.
pub struct NpyArray {
    pub shape: Vec<usize>,
    file: Vec<u8>,
    /// Position of the numbers in the file (bytes).
    data: usize,
    /// Length of a number (bytes).
    size: usize,
    read: fn(&[u8]) -> f64,
}

impl NpyArray {
    /// Number of rows of a table with `width` columns.
    pub fn rows(&self, width: usize) -> Result<usize, String> {
        match self.shape.as_slice() {
            [rows, columns] if *columns == width => Ok(*rows),
            shape => Err(format!("expected a table of {width} columns, found the shape {shape:?}")),
        }
    }

    /// All numbers, in order.
    fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        self.file[self.data..].chunks_exact(self.size).map(self.read)
    }

    /// The numbers of one row.
    pub fn row(&self, row: usize, width: usize) -> impl Iterator<Item = f64> + '_ {
        self.numbers().skip(row * width).take(width)
    }
}

fn number(bytes: &[u8], at: usize, length: usize) -> Result<usize, String> {
    let part = at.checked_add(length).and_then(|end| bytes.get(at..end));
    let part = part.ok_or("the file ends too early: it is cut short")?;
    Ok(part.iter().rev().fold(0, |v, &b| v << 8 | usize::from(b)))
}

impl<'a> NpzArrays<'a> {
    /// Reads the list of files at the end of a zip file.
    pub fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let zip = ZipArchive::new(Cursor::new(bytes));
        let most = (bytes.len() as u64).saturating_mul(BYTES_PER_BYTE).saturating_add(FREE_BYTES).min(MAX_MOTION_BYTES);
        Ok(Self { zip: zip.map_err(|e| format!("this is no .npz file, or it is damaged: {e}"))?, most })
    }

    pub fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    /// The array of a name.
    pub fn get(&mut self, name: &str) -> Result<NpyArray, String> {
        let Some(index) = self.zip.index_for_name(&format!("{name}.npy")) else {
            let names: Vec<_> =
                self.zip.file_names().flatten().map(|n| n.trim_end_matches(".npy").to_owned()).take(40).collect();
            return Err(format!("there is no array `{name}`, only: {}", names.join(", ")));
        };
        let (mut bytes, most) = (Vec::new(), self.most);
        // Lengths in an archive need not be true; the checksum is checked at the end of the file.
        let file = self.zip.by_index(index).map_err(|e| e.to_string());
        let read = file.and_then(|file| file.take(most + 1).read_to_end(&mut bytes).map_err(|e| e.to_string()));
        let whole = read.and_then(|n| match n as u64 > most {
            true => Err(format!("expected {} MiB at most of a file of its size, found more", most >> 20)),
            false => array(bytes),
        });
        whole.map_err(|e| format!("`{name}`: {e}"))
    }
}

/// Reads one array.
fn array(bytes: Vec<u8>) -> Result<NpyArray, String> {
    ensure(bytes.get(..6) == Some(b"\x93NUMPY"), || "it is no NumPy array".to_owned())?;
    let wide = bytes.get(6).is_some_and(|&v| v > 1);
    let length = number(&bytes, 8, if wide { 4 } else { 2 })?;
    let start: usize = if wide { 12 } else { 10 };
    let header = bytes.get(start..start.saturating_add(length.min(MAX_HEADER))).ok_or("its header is cut short")?;
    let header = String::from_utf8_lossy(header);
    let field = |name: &str| {
        let after = header.split_once(&format!("'{name}':")).map(|(_, after)| after.trim_start());
        after.ok_or_else(|| format!("its header has no `{name}`"))
    };
    let by_rows = !field("fortran_order")?.starts_with("True");
    ensure(by_rows, || "it is stored by columns: save it with `numpy.ascontiguousarray`".to_owned())?;
    let kind = field("descr")?.trim_start_matches('\'').split('\'').next().unwrap_or_default().to_owned();
    let read: fn(&[u8]) -> f64 = match kind.as_str() {
        "<f8" => |b| f64::from_le_bytes(std::array::from_fn(|i| b[i])),
        "<f4" => |b| f64::from(f32::from_le_bytes(std::array::from_fn(|i| b[i]))),
        "<i8" => |b| i64::from_le_bytes(std::array::from_fn(|i| b[i])) as f64,
        "<i4" => |b| f64::from(i32::from_le_bytes(std::array::from_fn(|i| b[i]))),
        _ => return Err(format!("expected numbers (f4, f8, i4 or i8, little-endian), found `{kind}`")),
    };
    let size = if kind.ends_with('8') { 8 } else { 4 };
    let list = field("shape")?.trim_start_matches('(').split(')').next().unwrap_or_default();
    let numbers = list.split(',').map(str::trim).filter(|n| !n.is_empty()).take(MAX_DIMENSIONS);
    let whole = |n: &str| n.parse().map_err(|_| format!("expected whole numbers in its shape, found `{n}`"));
    let shape: Vec<usize> = numbers.map(whole).collect::<Result<_, _>>()?;
    let count = shape.iter().try_fold(1usize, |all, n| all.checked_mul(*n)).and_then(|n| n.checked_mul(size));
    let data = (start + length).min(bytes.len());
    let num_bytes = bytes.len() - data;
    ensure(count == Some(num_bytes), || format!("its shape {shape:?} does not fit its {num_bytes} bytes"))?;
    Ok(NpyArray { shape, file: bytes, data, size, read })
}
