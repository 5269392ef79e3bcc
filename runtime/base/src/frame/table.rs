//! Tables: rows of a file that stay readable for as long as they are held.
#![allow(unsafe_code)]

use super::FileStorage;
use bytemuck::Pod;
use std::ops::{Deref, Range};
use std::{any::Any, fmt, ptr::NonNull, sync::Arc};

/// Rows that never change: of a mapped file, or of a vector. Reads as a slice.
///
/// A clone is cheap and shares the rows. The file stays mapped, and the vector alive, until the last clone is gone.
pub struct Table<T: 'static> {
    first: NonNull<T>,
    len: usize,
    /// Owner of the memory of the rows; never read.
    keep: Option<Arc<dyn Any + Send + Sync>>,
}

// SAFETY: a table only hands out shared references to its rows, as an `Arc<[T]>` does; `keep` is `Send + Sync`.
unsafe impl<T: Send + Sync> Send for Table<T> {}
// SAFETY: as above.
unsafe impl<T: Send + Sync> Sync for Table<T> {}

impl<T> Table<T> {
    /// Table of the rows in a range of bytes of a file, whose bounds and element size were checked.
    pub fn of_file(storage: &Arc<FileStorage>, bytes: &Range<usize>) -> Self
    where
        T: Pod,
    {
        let rows: &[T] = bytemuck::cast_slice(&storage.bytes()[bytes.clone()]);
        Self { first: NonNull::from(rows).cast(), len: rows.len(), keep: Some(storage.clone()) }
    }

    /// Table of a range of the rows, or none where the range is out of bounds.
    pub fn part(&self, rows: Range<usize>) -> Option<Self> {
        let rows = self.get(rows)?;
        Some(Self { first: NonNull::from(rows).cast(), len: rows.len(), keep: self.keep.clone() })
    }

    /// True where both are the same rows of the same file or vector.
    pub fn is_same(&self, other: &Self) -> bool {
        std::ptr::eq(&raw const **self, &raw const **other)
    }
}

impl<T> Deref for Table<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        // SAFETY: `first` and `len` are those of a slice in what `keep` holds (or of the empty slice), which is never
        // changed and does not move: a file's map, the heap of its bytes in memory, or that of a vector.
        unsafe { std::slice::from_raw_parts(self.first.as_ptr(), self.len) }
    }
}

impl<T> Clone for Table<T> {
    fn clone(&self) -> Self {
        Self { first: self.first, len: self.len, keep: self.keep.clone() }
    }
}

impl<T> Default for Table<T> {
    fn default() -> Self {
        Self { first: NonNull::dangling(), len: 0, keep: None }
    }
}

impl<T: Send + Sync> From<Vec<T>> for Table<T> {
    fn from(rows: Vec<T>) -> Self {
        let keep = Arc::new(rows);
        Self { first: NonNull::from(keep.as_slice()).cast(), len: keep.len(), keep: Some(keep) }
    }
}

/// A copy of the rows of a slice, an array or a vector.
impl<T: Clone + Send + Sync, S: AsRef<[T]> + ?Sized> From<&S> for Table<T> {
    fn from(rows: &S) -> Self {
        rows.as_ref().to_vec().into()
    }
}

impl<T> From<&Table<T>> for Table<T> {
    fn from(rows: &Table<T>) -> Self {
        rows.clone()
    }
}

impl<'a, T> IntoIterator for &'a Table<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: PartialEq> PartialEq for Table<T> {
    fn eq(&self, other: &Self) -> bool {
        self.is_same(other) || **self == **other
    }
}

impl<T> fmt::Debug for Table<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{} rows of {}]", self.len, std::any::type_name::<T>())
    }
}

#[cfg(test)]
mod tests {
    use super::super::AlignedBytes;
    use super::*;

    #[test]
    fn rows_outlive_the_file_and_the_table_they_were_taken_from() {
        let bytes: Vec<u8> = (0..96).collect();
        let storage = Arc::new(FileStorage::Memory(AlignedBytes::from_slice(&bytes)));
        let all = Table::<u32>::of_file(&storage, &(64..96));
        drop(storage);
        let some = all.part(1..3).unwrap();
        assert!(all.part(7..9).is_none());
        drop(all);
        assert_eq!(&*some, &[0x47464544, 0x4b4a4948]);
    }

    #[test]
    fn equal_rows_are_equal_wherever_they_lie() {
        let a = Table::from(vec![1u8, 2, 3]);
        let b = Table::from(&[1u8, 2, 3][..]);
        assert!(a == b && !a.is_same(&b) && a.is_same(&a.clone()));
        assert!(a != a.part(0..2).unwrap());
        assert_eq!(Table::<u64>::default().len(), 0);
    }
}
