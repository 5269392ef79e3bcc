//! The bundle: one little-endian file of checked sections (`*.throng`).
//!
//! It has the frame of [`throng_base::frame`]; sections hold plain-old-data records that are viewed in place.
//!
//! Version history (a number is never used twice; any change of layout or meaning takes the next one):
//!
//! - 1: 22 joints, frame rows of 192 bytes, motion graph, polar and box policies.
//! - 2: effective hits, policies on space-time grids and on adaptive grids.
//! - 3: pose groups and motion patches; contacts of seven bits; a motion graph may be absent where there are patches.
//! - 4: blend spaces; a motion graph may be absent where there are any.
//! - 5: frame rows of 96 bytes, whose rotations are packed as a section of its own says.
//! - 6: stop tables. META may be followed by a list of activities, where there are any.
//! - 7: activities say when hands hold a thing; links and pairs of links that two people play together.
//! - 8: clips say of every frame what class of motion it is.

mod meta;
mod motion_class;
mod records;
mod rotation_code;

pub use meta::{ActivityMeta, BlendMeta, ClipMeta, MADE_TAG, Meta, PatchMeta, SourceMeta, decode, encode};
pub use motion_class::{ClassSpan, Gait, MotionClass, Posture};
pub use records::{ClipRecord, FrameRow, ROTATION_BYTES, SkeletonRecord};
pub use rotation_code::{JointCode, RotationCode};
pub use throng_base::frame::{
    ALIGN, AlignedBytes, BundleWriter, FileHeader, FileKind, FileStorage, FormatError, MAGIC, SectionEntry,
    SectionLayout, SectionTag, Table, VERSION, crc32, crc32_of_pieces,
};
