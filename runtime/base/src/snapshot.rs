//! Common header of all snapshots: kind, version and setup of the state, and a checksum.

use crate::{Error, Result, crc32, error::ensure};
use serde::de::{DeserializeOwned, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

const MAGIC: [u8; 8] = *b"THRGSNAP";
/// Magic, kind, version, setup, length, checksum.
const HEADER: usize = 8 + 4 + 4 + 16 + 8 + 4;
/// Largest snapshot (bytes).
const LARGEST: usize = u32::MAX as usize;

/// Kind of state that a snapshot holds. Bytes of another kind, version or setup are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SnapshotKind {
    /// Name of the state in messages.
    pub what: &'static str,
    /// Tag that differs for each kind.
    pub tag: [u8; 4],
    /// Version of the layout, which grows by one with every change.
    pub version: u32,
    /// Content hash of everything that the state depends on: bundle, config, world.
    pub setup: u128,
}

impl SnapshotKind {
    /// Appends a state with its header.
    pub fn write(&self, state: &impl Serialize, out: &mut Vec<u8>) {
        let begin = out.len();
        out.resize(begin + HEADER, 0);
        // Writing a valid state to memory cannot fail.
        let _ = bincode::serde::encode_into_std_write(state, out, bincode_config());
        let body = &out[begin + HEADER..];
        let (length, sum) = (body.len() as u64, crc32(body));
        let (version, setup) = (self.version.to_le_bytes(), self.setup.to_le_bytes());
        let parts: [&[u8]; 6] = [&MAGIC, &self.tag, &version, &setup, &length.to_le_bytes(), &sum.to_le_bytes()];
        out[begin..begin + HEADER].copy_from_slice(&parts.concat());
    }

    /// Reads a state that begins `bytes`, and what follows it.
    ///
    /// # Errors
    /// [`Error::Snapshot`] where the bytes are cut short, damaged, or of another kind, version or setup.
    pub fn read<'a, T: DeserializeOwned>(&self, bytes: &'a [u8]) -> Result<(T, &'a [u8])> {
        let refusal = |why: String| Error::Snapshot { what: self.what, why };
        let (header, rest) = bytes.split_at_checked(HEADER).ok_or_else(|| {
            refusal(format!("it has {} bytes, expected {HEADER} or more; it is cut short", bytes.len()))
        })?;
        let other = "it is a snapshot of something else, or none; give one that was taken of this";
        ensure(header[..8] == MAGIC && header[8..12] == self.tag, || refusal(other.into()))?;
        let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        let version = || format!("it has version {}, expected {}; take a new one", word(12), self.version);
        ensure(word(12) == self.version, || refusal(version()))?;
        let setup = "it was taken with another bundle or setup; restore it into one made with the same";
        ensure(header[16..32] == self.setup.to_le_bytes(), || refusal(setup.into()))?;
        let length = u64::from(word(32)) | u64::from(word(36)) << 32;
        let short = || format!("it should go on for {length} bytes, and has {}; it is cut short", rest.len());
        let parts = usize::try_from(length).ok().and_then(|n| rest.split_at_checked(n));
        let (body, rest) = parts.ok_or_else(|| refusal(short()))?;
        ensure(crc32(body) == word(40), || refusal("its checksum is wrong; it is damaged".into()))?;
        let (state, used) = bincode::serde::borrow_decode_from_slice(body, bincode_config().with_limit::<LARGEST>())
            .map_err(|_| refusal("its content is that of another state; take a new one".into()))?;
        ensure(used == body.len(), || refusal(trailing_bytes_message(body.len() - used)))?;
        Ok((state, rest))
    }

    /// Reads a state that fills all of `bytes`.
    ///
    /// # Errors
    /// As [`SnapshotKind::read`], and for bytes that follow.
    pub fn read_all<T: DeserializeOwned>(&self, bytes: &[u8]) -> Result<T> {
        let (state, rest) = self.read(bytes)?;
        let why = || trailing_bytes_message(rest.len());
        ensure(rest.is_empty(), || Error::Snapshot { what: self.what, why: why() })?;
        Ok(state)
    }
}

/// Message about bytes after the end of a state.
fn trailing_bytes_message(num_bytes: usize) -> String {
    format!("{num_bytes} bytes follow its end, expected none; take a new one")
}

/// Bytes within a snapshot, such as a snapshot of a part: written at once, not one by one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bytes(pub Vec<u8>);

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(&self.0)
    }
}

impl<'de> Deserialize<'de> for Bytes {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct BytesVisitor;
        impl Visitor<'_> for BytesVisitor {
            type Value = Bytes;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("bytes")
            }

            fn visit_bytes<E>(self, bytes: &[u8]) -> Result<Bytes, E> {
                Ok(Bytes(bytes.to_vec()))
            }
        }
        // Borrowed: a length is compared with what is left before memory is taken for it.
        from.deserialize_bytes(BytesVisitor)
    }
}

fn bincode_config() -> bincode::config::Configuration<bincode::config::LittleEndian, bincode::config::Fixint> {
    bincode::config::standard().with_fixed_int_encoding()
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: SnapshotKind = SnapshotKind { what: "crowd", tag: *b"CRWD", version: 3, setup: 7 };

    #[test]
    fn comes_back_and_leaves_what_follows() {
        let mut bytes = vec![1, 2];
        KIND.write(&vec![3.0f32, 4.0], &mut bytes);
        bytes.push(9);
        let (state, rest): (Vec<f32>, _) = KIND.read(&bytes[2..]).unwrap();
        assert_eq!((state, rest), (vec![3.0, 4.0], &[9][..]));
    }

    #[test]
    fn parts_come_back_as_they_were() {
        let parts = vec![Bytes(vec![1, 2, 255]), Bytes::default()];
        let mut bytes = Vec::new();
        KIND.write(&parts, &mut bytes);
        assert_eq!(KIND.read_all::<Vec<Bytes>>(&bytes).unwrap(), parts);
        bytes.push(0);
        let e = KIND.read_all::<Vec<Bytes>>(&bytes).unwrap_err().to_string();
        assert!(e.contains("1 bytes follow its end, expected none"), "{e}");
    }

    /// Memory for so many bytes is not to be had.
    #[test]
    fn a_length_beyond_the_end_takes_no_memory() {
        let mut bytes = Vec::new();
        KIND.write(&(1u64, u64::from(u32::MAX) - 99), &mut bytes);
        let e = KIND.read_all::<Vec<Bytes>>(&bytes).unwrap_err().to_string();
        assert!(e.ends_with("its content is that of another state; take a new one"), "{e}");
    }

    #[test]
    fn every_flipped_bit_and_every_shorter_length_is_refused() {
        let mut bytes = Vec::new();
        KIND.write(&vec![3.0f32, 4.0], &mut bytes);
        for i in 0..bytes.len() {
            assert!(KIND.read::<Vec<f32>>(&bytes[..i]).is_err(), "{i} bytes");
            for bit in 0..8 {
                let mut other = bytes.clone();
                other[i] ^= 1 << bit;
                assert!(KIND.read::<Vec<f32>>(&other).is_err(), "bit {bit} of byte {i}");
            }
        }
        for other in [
            SnapshotKind { version: 2, ..KIND },
            SnapshotKind { setup: 8, ..KIND },
            SnapshotKind { tag: *b"WALK", ..KIND },
        ] {
            assert!(other.read::<Vec<f32>>(&bytes).is_err());
        }
    }
}
