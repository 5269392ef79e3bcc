//! The META section: names, units, provenance, configuration; the only part of a bundle that is decoded, not viewed.

use super::{ClassSpan, FormatError};
use crate::hits::KIND_NAMES;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use throng_base::error::ensure;

/// Most bytes an encoded section may ask for while it is decoded (bytes).
const LIMIT: usize = 64 << 20;
/// Most bytes of META: a byte of it takes up to 24 of memory (bytes).
const MOST_META: usize = 16 << 20;
/// Name of the tag on frames that a build has made, as no clip had such motion.
pub const MADE_TAG: &str = "made";
/// Lowest and highest frame rate of a bundle: within it, a step plays a bounded number of segments (Hz).
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// Metadata of a bundle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// The database's name.
    pub name: String,
    /// Program and version that wrote it.
    pub generator: String,
    /// Frames a second of the rows (Hz, 1 to 1000).
    pub rate_hz: f64,
    /// The configuration it was built with, as TOML.
    pub config: String,
    /// The files it was built from.
    pub sources: Vec<SourceMeta>,
    /// The clips, in the order of their records.
    pub clips: Vec<ClipMeta>,
    /// Names of the behaviours, in the order of their policies.
    pub behaviours: Vec<String>,
    /// Names of the kinds of hits that come from tags, after [`crate::hits::KIND_NAMES`].
    pub hit_tags: Vec<String>,
    /// The motion patches, in the order of their records.
    pub patches: Vec<PatchMeta>,
    /// Tags of the actions that links of patches show, see [`crate::patch::LinkRecord::tag`].
    pub link_tags: Vec<String>,
    /// The unit objects that patches consist of, as TOML.
    pub units: String,
    /// The blend spaces, in the order of their records.
    pub blends: Vec<BlendMeta>,
    /// Number of pose groups; 0 where frames were not grouped.
    pub pose_groups: u64,
    /// Usable frames that went into the motion graph.
    pub frames_in: u64,
    /// Frames that its actions play.
    pub frames_kept: u64,
    /// Activities of bodies beside locomotion, see [`crate::blend::ActivitySet`]. Written after all else, and only
    /// where there are any, so that files without activities stay as they were.
    #[serde(skip)]
    pub activities: Vec<ActivityMeta>,
}

/// A file of the input.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SourceMeta {
    /// Path as the configuration gives it.
    pub path: String,
    /// Length (bytes).
    pub bytes: u64,
    /// Hash of its content (XXH3, 128 bits).
    pub hash: u128,
}

/// A clip and what is known of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClipMeta {
    /// Name of the clip.
    pub name: String,
    /// File it came from.
    pub source: String,
    /// Names on runs of frames: name, first frame, frame after the last.
    pub tags: Vec<(String, u32, u32)>,
    /// Runs of frames that are left out and why: reason, first frame, frame after the last.
    pub excluded: Vec<(String, u32, u32)>,
    /// Class of motion of every frame: spans in order.
    pub classes: Vec<ClassSpan>,
}

/// A motion patch: its name and the units it consists of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PatchMeta {
    /// Unique name: the units', joined by `+`, and a number where several arrangements of them occur.
    pub name: String,
    /// Name of each unit object and where it stands in the patch's frame; the first one stands at the identity.
    pub units: Vec<(String, crate::placement::Placement)>,
}

/// A blend space: its name, and those of its axes and examples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BlendMeta {
    /// Unique name.
    pub name: String,
    /// Names of the axes, in order; unique in their space.
    pub axes: Vec<String>,
    /// Names of the examples, in order: the clip's, with frames where it gave several.
    pub examples: Vec<String>,
}

/// An activity: frames of a clip that begin and end standing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ActivityMeta {
    /// Unique name.
    pub name: String,
    /// Tag by which the activity is requested; several activities may share one.
    pub tag: String,
    /// Clip of the activity.
    pub clip: u32,
    /// First frame within the clip.
    pub first_frame: u32,
    /// Number of frames (>= 2).
    pub num_frames: u32,
    /// First frame within the activity, and number of frames, of the part that goes on until the activity is to end.
    pub looped: Option<[u32; 2]>,
    /// First frame within the activity, and number of frames, in which the left and the right hand hold a thing.
    pub object_frames: [Option<[u32; 2]>; 2],
    /// The body does not stand in the middle of it: it cannot just walk away.
    pub is_seated: bool,
}

/// The bytes of a section that is encoded, by its tag.
///
/// # Errors
/// [`FormatError::Layout`] where it cannot be encoded.
pub fn encode(tag: &str, value: &impl Serialize) -> Result<Vec<u8>, FormatError> {
    bincode::serde::encode_to_vec(value, bincode::config::standard())
        .map_err(|e| FormatError::layout(format!("{tag} cannot be written: {e}")))
}

/// Reads the bytes of a section that is encoded, by its tag.
///
/// # Errors
/// [`FormatError::Layout`] where they are damaged, ask for too much memory, or are followed by others.
pub fn decode<T: DeserializeOwned>(tag: &str, bytes: &[u8]) -> Result<T, FormatError> {
    let (value, rest) = decode_first(tag, bytes)?;
    let (got, used) = (bytes.len(), bytes.len() - rest.len());
    ensure(got == used, || FormatError::layout(format!("{tag} has {got} bytes, expected {used}")))?;
    Ok(value)
}

/// Decodes the first value of some bytes as [`decode`] does, and returns the bytes after it.
fn decode_first<'a, T: DeserializeOwned>(tag: &str, bytes: &'a [u8]) -> Result<(T, &'a [u8]), FormatError> {
    let config = bincode::config::standard().with_limit::<LIMIT>();
    let (value, used) = bincode::serde::decode_from_slice(bytes, config)
        .map_err(|e| FormatError::layout(format!("{tag} cannot be read: {e}")))?;
    Ok((value, &bytes[used..]))
}

fn check_length(len: usize) -> Result<(), FormatError> {
    let way_out = "take fewer clips, or fewer and shorter tags, into one bundle";
    let fault = || format!("META has {len} bytes, expected up to {MOST_META}: {way_out}");
    ensure(len <= MOST_META, || FormatError::layout(fault()))
}

impl Meta {
    /// Names of the kinds of hits, by number: punch, kick, then those of tags.
    pub fn hit_kinds(&self) -> impl Iterator<Item = &str> {
        KIND_NAMES.into_iter().chain(self.hit_tags.iter().map(String::as_str))
    }

    /// The section's bytes.
    ///
    /// # Errors
    /// [`FormatError::Layout`] where it cannot be encoded, or is too long to be read again.
    pub fn encode(&self) -> Result<Vec<u8>, FormatError> {
        let mut bytes = encode("META", self)?;
        if !self.activities.is_empty() {
            bytes.extend(encode("META", &self.activities)?);
        }
        check_length(bytes.len())?;
        Ok(bytes)
    }

    /// Reads a section's bytes.
    ///
    /// # Errors
    /// [`FormatError::Layout`] where they are damaged, ask for too much memory, or are followed by others.
    pub fn decode(bytes: &[u8]) -> Result<Self, FormatError> {
        check_length(bytes.len())?;
        let (mut meta, rest): (Self, _) = decode_first("META", bytes)?;
        if !rest.is_empty() {
            meta.activities = decode("META", rest)?;
            let fault = "META is followed by a list of no activities";
            ensure(!meta.activities.is_empty(), || FormatError::layout(fault))?;
        }
        let fault = || format!("META gives a rate of {} Hz, expected 1 to 1000", meta.rate_hz);
        ensure(RATES_HZ.contains(&meta.rate_hz), || FormatError::layout(fault()))?;
        Ok(meta)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn activities_follow_all_else_and_none_leave_no_trace() {
        let bare = Meta { rate_hz: 60.0, ..Meta::default() };
        let wave = ActivityMeta { name: "wave".into(), looped: Some([3, 4]), ..ActivityMeta::default() };
        let full = Meta { activities: vec![wave], ..bare.clone() };
        let [short, long] = [&bare, &full].map(|m| m.encode().unwrap());
        assert_eq!(long[..short.len()], short);
        assert_eq!([&short, &long].map(|b| Meta::decode(b).unwrap()), [bare, full]);
        assert!((short.len() + 1..long.len()).all(|cut| Meta::decode(&long[..cut]).is_err()));
        assert!(Meta::decode(&[long, vec![0]].concat()).is_err());
    }

    /// An empty string is one byte that takes the memory of a string.
    #[test]
    #[cfg_attr(miri, ignore = "Miri takes hours for 16 million strings")]
    fn more_names_than_a_bundle_may_have_are_neither_written_nor_read() {
        let with = |n| Meta { rate_hz: 30.0, hit_tags: vec![String::new(); n], ..Meta::default() };
        let e = with(MOST_META).encode().unwrap_err().to_string();
        assert!(e.contains("expected up to 16777216") && e.contains("fewer clips"), "{e}");
        let bytes = encode("META", &with(MOST_META)).unwrap();
        assert!(Meta::decode(&bytes).is_err_and(|e| e.to_string().contains("expected up to")));
        assert!(Meta::decode(&with(1000).encode().unwrap()).is_ok());
    }

    /// A rate that is infinite as `f32`, or so large that time no longer notices a segment's end, made steps endless.
    #[test]
    fn rates_that_no_step_could_follow_are_refused() {
        let decode = |rate_hz| Meta::decode(&Meta { rate_hz, ..Meta::default() }.encode().unwrap());
        for rate_hz in [f64::NAN, f64::INFINITY, 1e200, 1e30, 1000.1, 0.9, 0.0, -30.0] {
            assert!(decode(rate_hz).is_err(), "{rate_hz}");
        }
        for rate_hz in [1.0, 30.0, 120.0, 1000.0] {
            assert_eq!(decode(rate_hz).unwrap().rate_hz, rate_hz);
        }
    }
}
