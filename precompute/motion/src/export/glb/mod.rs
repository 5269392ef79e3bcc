//! Writes takes as binary glTF 2.0: skins, joints and animation, with a plain body or the user's own.
//!
//! Every skeleton hangs below a node of its own, so that programs which make one armature of all joints of a tree keep
//! characters apart; skinned meshes are roots of the scene, where a node's frame could not be taken for the mesh's.
//! Meshes, bind matrices and times are shared. The document comes first in such a file: the lengths in it are known before a
//! number is written, and numbers are then copied from the take's file track by track.

mod figure;
pub(crate) mod parts;

use super::{scratch::TrackScratch, take::Take};
use crate::error::{BuildError, Result};
pub(crate) use figure::animate_actors;
use parts::GlbParts;
use std::io::{self, Write};

/// A document of a take, ready to be written.
pub struct Glb<'a> {
    take: &'a Take,
    /// File that holds the numbers of tracks.
    scratch: &'a TrackScratch,
    parts: GlbParts,
    document: String,
}

impl<'a> Glb<'a> {
    /// A document with plain bodies.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a take that is too large for the format.
    pub fn new(take: &'a Take) -> Result<Self> {
        Self::from_parts(take, figure::plain_body_parts(take), take.scratch())
    }

    /// - `parts`: bodies and their animations; `scratch`: file that holds their tracks.
    pub(crate) fn from_parts(take: &'a Take, parts: GlbParts, scratch: &'a TrackScratch) -> Result<Self> {
        let document = parts.document();
        let glb = Self { take, scratch, parts, document };
        let bytes = glb.num_bytes();
        if bytes > u64::from(u32::MAX) {
            return Err(BuildError::Stage {
                stage: "export",
                message: format!("a .glb file holds 4.29 GB at most, and this would be {:.2} GB", bytes as f64 / 1e9),
                help: "Export fewer characters, a shorter stretch or fewer frames a second; .npz has no limit".into(),
            });
        }
        Ok(glb)
    }

    /// Length of the file.
    pub fn num_bytes(&self) -> u64 {
        12 + 8 + self.document.len() as u64 + 8 + self.parts.num_bytes()
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let document = &self.document;
        let word = |n: u64| u32::try_from(n).unwrap_or(u32::MAX).to_le_bytes();
        out.write_all(b"glTF")?;
        out.write_all(&word(2))?;
        out.write_all(&word(self.num_bytes()))?;
        out.write_all(&word(document.len() as u64))?;
        out.write_all(b"JSON")?;
        out.write_all(document.as_bytes())?;
        out.write_all(&word(self.parts.num_bytes()))?;
        out.write_all(b"BIN\0")?;
        self.parts.write(self.take, self.scratch, out)
    }
}
