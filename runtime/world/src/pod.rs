//! Serde of rows of plain old data as one run of bytes: as fast as memory, where element by element is not.

use bytemuck::Pod;
use serde::de::{Error, Visitor};
use serde::{Deserializer, Serializer};
use std::fmt;
use std::marker::PhantomData;

/// For `#[serde(with)]`.
pub(crate) fn serialize<T: Pod, S: Serializer>(rows: &[T], to: S) -> Result<S::Ok, S::Error> {
    to.serialize_bytes(bytemuck::cast_slice(rows))
}

/// For `#[serde(with)]`.
pub(crate) fn deserialize<'de, T: Pod, D: Deserializer<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    from.deserialize_bytes(PodRows(PhantomData))
}

struct PodRows<T>(PhantomData<T>);

impl<T: Pod> Visitor<'_> for PodRows<T> {
    type Value = Vec<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rows of {} bytes", size_of::<T>())
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Vec<T>, E> {
        match bytes.len() % size_of::<T>() {
            0 => {
                let mut rows = vec![T::zeroed(); bytes.len() / size_of::<T>()];
                bytemuck::cast_slice_mut(&mut rows).copy_from_slice(bytes);
                Ok(rows)
            }
            _ => Err(E::invalid_length(bytes.len(), &self)),
        }
    }
}
