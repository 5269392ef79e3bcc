//! Serde of rows of plain old data as one run of bytes: as fast as memory, where element by element is not.

use bytemuck::Pod;
use serde::{Deserialize, Deserializer, Serializer, de::Error};
use throng_base::error::ensure;

/// For `#[serde(with)]`.
pub(crate) fn serialize<T: Pod, S: Serializer>(rows: &[T], to: S) -> Result<S::Ok, S::Error> {
    to.serialize_bytes(bytemuck::cast_slice(rows))
}

/// For `#[serde(with)]`.
pub(crate) fn deserialize<'de, T: Pod, D: Deserializer<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    let bytes = <&[u8]>::deserialize(from)?;
    let expected = || format!("rows of {} bytes", size_of::<T>());
    ensure(bytes.len().is_multiple_of(size_of::<T>()), || D::Error::invalid_length(bytes.len(), &&*expected()))?;
    Ok(bytemuck::pod_collect_to_vec(bytes))
}
