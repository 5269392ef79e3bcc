//! Sidecar files beside clips, written by people: ranges to leave out, names of ranges, effective hits.
//!
//! `CLIP.toml` beside `CLIP.bvh`:
//!
//! ```toml
//! unit = "seconds"          # or "frames" of the file, from 0; ends are exclusive
//! exclude = [[0.0, 1.5], [20.0, inf]]
//!
//! [[tags]]
//! name = "punch"
//! start = 3.2
//! end = 4.0
//!
//! [[hits]]
//! name = "punch"            # a punch, a kick, or a name of your own
//! joint = "right_hand"
//! at = 3.6                  # or start and end: the joint's fastest moment in between
//! ```
//!
//! `automatic_hits = false` leaves the clip with the hits that are marked.

mod hit;
#[cfg(test)]
mod tests;

use super::{classes::NamedClass, hits::HitMark};
use crate::clip::{Clip, ClipTag, Exclusion, ExclusionReason, FrameRange};
use crate::error::{BuildError, Result, ensure};
use crate::import::{ImportedClip, ImportedSet, archive, clip_in_file};
use crate::mirror;
pub use hit::SidecarHit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use throng_base::file::MAX_TEXT_BYTES;
use throng_base::text::{TomlSource, did_you_mean};

/// Most entries of each list of a sidecar.
const MOST_ENTRIES: usize = 10_000;

/// Ranges, names and hits for one clip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Sidecar {
    /// Unit of all numbers.
    pub unit: TimeUnit,
    /// Ranges to leave out, `[start, end]`; `inf` is the clip's end (as `unit` says).
    pub exclude: Vec<[f64; 2]>,
    /// Names of ranges.
    pub tags: Vec<SidecarTag>,
    /// Effective hits; each replaces a found hit of the same joint nearby.
    pub hits: Vec<SidecarHit>,
    /// Look for hits, too; false keeps those of `hits` alone.
    pub automatic_hits: bool,
    /// Class of the whole clip, or parts of it, where motion and names mislead.
    pub class: Option<NamedClass>,
}

impl Default for Sidecar {
    fn default() -> Self {
        Self {
            unit: TimeUnit::default(),
            exclude: Vec::new(),
            tags: Vec::new(),
            hits: Vec::new(),
            automatic_hits: true,
            class: None,
        }
    }
}

/// A name on a range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SidecarTag {
    /// The name, as configs and reports use it.
    pub name: String,
    /// Begin (as `unit` says).
    pub start: f64,
    /// End (as `unit` says).
    pub end: f64,
}

/// Unit of the numbers of a sidecar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TimeUnit {
    /// Seconds from the clip's first frame.
    #[default]
    Seconds,
    /// Frames of the file, from 0.
    Frames,
}

/// The sidecars of a build by clip name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Sidecars {
    entries: BTreeMap<String, SidecarEntry>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct SidecarEntry {
    sidecar: Sidecar,
    /// Frames a second of the file.
    source_rate_hz: f64,
    /// The sidecar file; `None` for the config's table `clips`.
    file: Option<PathBuf>,
}

/// Place in a file at which something about a clip is written.
#[derive(Clone, Debug, PartialEq)]
pub struct SidecarPlace {
    /// The sidecar; `None` for the config, whose file the reader of the config adds.
    pub file: Option<PathBuf>,
    /// The key in it.
    pub key: String,
}

impl SidecarPlace {
    fn new(file: Option<&Path>, clip_name: &str, key: &str) -> Self {
        let outer = if file.is_none() { format!("clips.{clip_name}.") } else { String::new() };
        Self { file: file.map(Path::to_path_buf), key: format!("{outer}{key}") }
    }

    /// An error at this place.
    pub fn fault(&self, why: impl std::fmt::Display) -> BuildError {
        let fault = BuildError::key(&self.key, why);
        if let Some(file) = &self.file { fault.in_file(file) } else { fault }
    }
}

/// Contents of a sidecar, in the clip's frames.
#[derive(Clone, Debug, PartialEq)]
pub struct SidecarAnnotations {
    /// Ranges to leave out.
    pub excluded: Vec<Exclusion>,
    /// Names.
    pub tags: Vec<ClipTag>,
    /// Hits.
    pub hits: Vec<HitMark>,
    /// True where hits are searched for, too.
    pub automatic_hits: bool,
    /// Class, or parts of it.
    pub class: NamedClass,
}

impl Default for SidecarAnnotations {
    fn default() -> Self {
        let (excluded, tags, hits, class) = (Vec::new(), Vec::new(), Vec::new(), NamedClass::default());
        Self { excluded, tags, hits, automatic_hits: true, class }
    }
}

impl Sidecar {
    /// Reads the sidecar's text; `origin` is the file as errors name it.
    ///
    /// # Errors
    /// [`BuildError::Config`] with file, line and key.
    pub fn parse(text: &str, origin: &str) -> Result<Self> {
        Self::from_source(&TomlSource::new(text, Path::new(origin)))
    }

    fn from_source(source: &TomlSource) -> Result<Self> {
        let sidecar: Self = source.parse(
            "Expected `unit`, `exclude = [[start, end], ...]`, `[[tags]]` with name, start, end, `[[hits]]` with name, \
             joint, at, `automatic_hits`, and `class = { gait = \"walk\" }`.",
        )?;
        sidecar.check().map_err(|e| e.with_position(source))?;
        Ok(sidecar)
    }

    /// Refuses ranges that end before they start, names without letters, joints that do not exist, and lists of more than
    /// 10 000 entries.
    ///
    /// # Errors
    /// [`BuildError::Key`] for the first of them.
    pub fn check(&self) -> Result<()> {
        let fault = |list: &str, i: usize, what: &str| BuildError::key(format!("{list}[{i}]"), what);
        let sound = |start: f64, end: f64| start >= 0.0 && start.is_finite() && end > start;
        let lists = [("exclude", self.exclude.len()), ("tags", self.tags.len()), ("hits", self.hits.len())];
        if let Some((list, num)) = lists.into_iter().find(|(_, num)| *num > MOST_ENTRIES) {
            let why = format!("expected at most {MOST_ENTRIES} entries, found {num}. Cut the clip into several files.");
            return Err(BuildError::key(list, why));
        }
        for (i, [start, end]) in self.exclude.iter().enumerate() {
            let what = || format!("expected 0 <= start < end, found [{start}, {end}]. Exchange or correct them.");
            ensure(sound(*start, *end), || fault("exclude", i, &what()))?;
        }
        for (i, SidecarTag { name, start, end }) in self.tags.iter().enumerate() {
            let what = "expected a name, found an empty one. Name the range.";
            ensure(!name.trim().is_empty(), || fault("tags", i, what))?;
            ensure(sound(*start, *end), || fault("tags", i, &wrong_range(name, *start, *end)))?;
        }
        for (i, h) in self.hits.iter().enumerate() {
            let what = "expected a name, found an empty one. Name the kind of blow.";
            ensure(!h.name.trim().is_empty(), || fault("hits", i, what))?;
            h.times().and(h.joint()).map_err(|what| fault("hits", i, &what))?;
        }
        Ok(())
    }
}

impl Sidecars {
    /// Adds the sidecar of the clip `name`. `source_rate_hz` is the rate of the clip's file, `file` that of the sidecar; none for an entry
    /// of the config's table `clips`.
    ///
    /// # Errors
    /// [`BuildError::Key`] for ranges that end before they start, or joints that do not exist.
    pub fn insert(&mut self, name: &str, sidecar: Sidecar, source_rate_hz: f64, file: Option<&Path>) -> Result<()> {
        sidecar.check().map_err(|e| match file {
            Some(file) => e.in_file(file),
            None => e.within_key(&format!("clips.{name}")),
        })?;
        let file = file.map(Path::to_path_buf);
        self.entries.insert(name.into(), SidecarEntry { sidecar, source_rate_hz, file });
        Ok(())
    }

    /// Reads `CLIP.toml` beside the clip's file and adds it; false where there is none.
    ///
    /// # Errors
    /// [`BuildError::Io`] for a file that cannot be read, [`BuildError::Config`] for one that is wrong.
    pub fn insert_beside(&mut self, clip_name: &str, file: &Path, source_rate_hz: f64) -> Result<bool> {
        let path = file.with_extension("toml");
        let read = if archive::split(&path).is_none() {
            TomlSource::read(&path, "a sidecar")
        } else if archive::is_file(&path) {
            let bytes = archive::read_file(&path, "a sidecar", MAX_TEXT_BYTES)?;
            Ok(TomlSource::new(&String::from_utf8_lossy(&bytes), &path))
        } else {
            return Ok(false);
        };
        let source = match read {
            Err(throng_base::Error::Io { source, .. })
                if matches!(source.kind(), ErrorKind::NotFound | ErrorKind::InvalidFilename) =>
            {
                return Ok(false);
            }
            source => source?,
        };
        self.insert(clip_name, Sidecar::from_source(&source)?, source_rate_hz, Some(&path))?;
        Ok(true)
    }

    /// The sidecar files beside imported clips, and those that a config has in a table by clip name.
    ///
    /// - `names`: names of the clips (raw.clips.len()).
    ///
    /// # Errors
    /// As [`Sidecars::insert`] and [`Sidecars::insert_beside`]; a sidecar of a clip that is not there.
    pub fn collect(raw: &ImportedSet, names: &[String], table: &BTreeMap<String, Sidecar>) -> Result<Self> {
        let mut out = Self::default();
        let mut rates = BTreeMap::new();
        for (ImportedClip { clip, .. }, name) in raw.clips.iter().zip(names) {
            match clip_in_file(&clip.path) {
                Some((file, _)) => refuse_beside(&file, name)?,
                None => drop(out.insert_beside(name, &clip.path, clip.rate_hz)?),
            }
            rates.insert(name, clip.rate_hz);
        }
        for (name, sidecar) in table {
            out.insert(name, sidecar.clone(), rates.get(name).copied().unwrap_or(1.0), None)?;
        }
        out.check_names(names.iter().map(String::as_str))?;
        Ok(out)
    }

    /// The sidecar of one clip alone.
    pub fn for_clip(&self, name: &str) -> Self {
        Self { entries: self.entries.get_key_value(name).map(|(n, e)| (n.clone(), e.clone())).into_iter().collect() }
    }

    /// Refuses sidecars of clips that are not there.
    pub(super) fn check_names<'a>(&self, names: impl Iterator<Item = &'a str>) -> Result<()> {
        let names: BTreeSet<&str> = names.collect();
        let Some((name, entry)) = self.entries.iter().find(|(name, _)| !names.contains(name.as_str())) else {
            return Ok(());
        };
        let meant = did_you_mean(name, names.iter().copied());
        let why = format!("there is no clip `{name}`.{meant}");
        Err(match &entry.file {
            Some(file) => BuildError::Config { message: format!("{}: {why}", file.display()) },
            None => BuildError::key(format!("clips.{name}"), why),
        })
    }

    /// The annotations of a clip, in its frames. A mirrored copy has its original's, sides exchanged.
    ///
    /// # Errors
    /// [`BuildError::Config`] for a range or hit that begins after the clip's end.
    pub(super) fn annotations_of(&self, clip: &Clip) -> Result<SidecarAnnotations> {
        let Some(entry) = self.entries.get(original_name(clip)) else { return Ok(SidecarAnnotations::default()) };
        let n = clip.num_frames();
        let per_unit = match entry.sidecar.unit {
            TimeUnit::Seconds => clip.rate_hz,
            TimeUnit::Frames => clip.rate_hz / entry.source_rate_hz,
        };
        let place = |key: &str| SidecarPlace::new(entry.file.as_deref(), original_name(clip), key);
        let frames = |start: f64, end: f64, key: &str| -> Result<FrameRange> {
            let at = |t: f64| ((t * per_unit - 1e-6).ceil().max(0.0)).min(n as f64) as usize;
            let range = at(start)..at(end);
            let why = || {
                format!(
                    "starts at {start}, after the end of clip `{}` ({:.2} in the same unit). Correct the start or remove the range.",
                    original_name(clip),
                    n as f64 / per_unit
                )
            };
            ensure(range.start < n, || place(key).fault(why()))?;
            Ok(range)
        };
        let (automatic_hits, class) = (entry.sidecar.automatic_hits, entry.sidecar.class.clone().unwrap_or_default());
        let mut out = SidecarAnnotations { automatic_hits, class, ..SidecarAnnotations::default() };
        for (i, [start, end]) in entry.sidecar.exclude.iter().enumerate() {
            let range = frames(*start, *end, &format!("exclude[{i}]"))?;
            out.excluded.push(Exclusion { range, reason: ExclusionReason::Sidecar });
        }
        for (i, t) in entry.sidecar.tags.iter().enumerate() {
            let range = frames(t.start, t.end, &format!("tags[{i}]"))?;
            out.tags.push(ClipTag { name: t.name.clone(), range });
        }
        for (i, h) in entry.sidecar.hits.iter().enumerate() {
            let place = place(&format!("hits[{i}]"));
            let wrong = |why| place.fault(why);
            let ((start, end), joint) = (h.times().map_err(wrong)?, h.joint().map_err(wrong)?);
            let mut range = frames(start, end, &format!("hits[{i}]"))?;
            if start == end {
                range.start = (start * per_unit).round() as usize;
            }
            range.end = range.end.max(range.start + 1);
            let joint = if clip.mirrored { joint.mirrored() } else { joint };
            out.hits.push(HitMark { kind: h.kind(), joint, range, place });
        }
        Ok(out)
    }
}

/// The fault of a named range that ends before it starts.
fn wrong_range(name: &str, start: f64, end: f64) -> String {
    format!("`{name}`: expected 0 <= start < end, found start = {start}, end = {end}. Exchange or correct them.")
}

/// Refuses a sidecar beside a file of several clips.
fn refuse_beside(file: &Path, clip: &str) -> Result<()> {
    let sidecar = file.with_extension("toml");
    let (shown, file) = (sidecar.display(), file.display());
    let message = format!("{shown}: {file} holds several clips. Write this into a config, under [clips.\"{clip}\"].");
    ensure(!archive::is_file(&sidecar), || BuildError::Config { message })
}

/// Name of a clip, or of the one that it is a mirrored copy of.
pub(super) fn original_name(clip: &Clip) -> &str {
    clip.name.strip_suffix(mirror::SUFFIX).filter(|_| clip.mirrored).unwrap_or(&clip.name)
}
