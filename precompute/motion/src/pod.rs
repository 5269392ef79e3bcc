//! Plain-old-data records in the cache: their bytes.

use crate::error::ensure;
use bytemuck::Pod;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

/// Serialises a slice of records as bytes.
pub fn serialize<T: Pod, S: Serializer>(records: &[T], out: S) -> Result<S::Ok, S::Error> {
    bytemuck::cast_slice::<T, u8>(records).serialize(out)
}

/// Reads records back.
pub fn deserialize<'de, T: Pod, D: Deserializer<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    let bytes = Vec::<u8>::deserialize(from)?;
    ensure(bytes.len() % size_of::<T>() == 0, || D::Error::custom("bytes do not make whole records"))?;
    Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
}

/// Serialisation of a single record.
pub mod one {
    use super::*;

    /// Serialises a record as bytes.
    pub fn serialize<T: Pod, S: Serializer>(record: &T, out: S) -> Result<S::Ok, S::Error> {
        super::serialize(std::slice::from_ref(record), out)
    }

    /// Reads a record back.
    pub fn deserialize<'de, T: Pod, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
        match super::deserialize::<T, D>(from)?.as_slice() {
            [record] => Ok(*record),
            _ => Err(D::Error::custom("expected one record")),
        }
    }
}
