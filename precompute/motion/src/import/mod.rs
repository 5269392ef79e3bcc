//! Files to raw clips: BVH, ASF/AMC, SMPL's NPZ, glTF and FBX, in metres, Y up, with a role for every joint that matters.
//!
//! Each format has its own reader that yields a [`SourceClip`] in the file's units. A skeleton profile, or the
//! shape of the skeleton, says which joint plays which role; units, up axis and rest pose are then found from the
//! body's size and pose.

pub mod amc;
pub mod archive;
pub mod asf;
pub mod bvh;
pub mod config;
#[cfg(feature = "fbx")]
pub mod fbx;
mod files;
mod glitches;
pub mod gltf;
pub(crate) mod nodes;
pub mod npz;
pub mod obj;
mod oddities;
mod performers;
mod person;
pub mod profile;
mod rest;
pub mod roles;
mod scan;
mod shape;
pub(crate) mod source;
mod units;

use crate::clip::{Clip, ClipSet};
use crate::error::{ImportError, Warnings, ensure};
use crate::export::{self, to_raw};
use crate::{progress::Progress, raw::RawClip};
use asf::{Asf, AsfJoint, Dof};
pub use config::{Forward, ImportConfig, UpAxis};
pub use files::{
    EXTENSIONS, FORMATS, MotionFile, READS_FBX, clip_in_file, expand, find_motion_files, has_extension, is_motion,
    matches, read_along,
};
pub use glitches::{Glitch, GlitchKind, GlitchTreatment, Glitches};
use person::{ADULT_HEIGHT, HEIGHTS, rounded};
use profile::Profile;
use rayon::prelude::*;
pub(crate) use rest::{LEG_DOWN, LEG_SEGMENTS, nearest_axis};
pub use rest::{RestPose, RestPoseKind};
pub use roles::RoleMap;
use scan::{Scanner, TextPosition, parse_count, text};
pub(crate) use shape::split_words;
pub use source::SourceClip;
use source::{CoordinateAxis, FrameSink, MAX_JOINTS, MAX_NAME, content_error, duplicate_names};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
pub use throng_base::file::MAX_MOTION_BYTES;
use units::{body_height, rest_world};

/// A clip as read, with all findings about it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ImportedClip {
    /// The motion: metres, Y up, right-handed; the source's own joints.
    pub clip: RawClip,
    /// Source joint of each role.
    pub roles: RoleMap,
    /// Kind of the source's zero pose.
    pub rest_pose: RestPose,
    /// Length of one unit of the file (m).
    pub metres_per_unit: f64,
    /// Axis that points up in the file (the clip itself is Y up).
    pub up: UpAxis,
    /// Heading that the rest pose faces, about +Y; 0 where the rest pose is not a body (rad).
    pub facing: f32,
    /// Direction that the rest pose faces by the config.
    pub forward: Option<Forward>,
    /// Body height estimated from the lengths of the segments (m).
    pub height: f32,
    /// Frames that are no motion, in order; those that were bridged, too.
    pub glitches: Vec<Glitch>,
    /// Findings with their reasons, one sentence each.
    pub findings: Vec<String>,
    /// Oddities that are tolerable, naming the file; [`RoleMap::warnings`] included.
    pub warnings: Warnings,
}

/// All clips of a build, and the files that could not be read.
#[derive(Debug)]
pub struct ImportedSet {
    /// The clips, sorted by path; several of one file in the file's order.
    pub clips: Vec<ImportedClip>,
    /// Files that were skipped and the reasons, sorted by path.
    pub skipped: Vec<ImportError>,
}

impl ImportedSet {
    /// This set, if it holds a clip.
    ///
    /// # Errors
    /// The first bad file where no file is good.
    pub fn require_clips(mut self) -> Result<Self, ImportError> {
        if self.clips.is_empty() && !self.skipped.is_empty() { Err(self.skipped.swap_remove(0)) } else { Ok(self) }
    }

    /// Clips with the same motion as an earlier one, number by number, whatever the names of their files: pairs of indices of
    /// both.
    pub fn repeated(&self) -> Vec<[usize; 2]> {
        let hashes: Vec<u64> = self.clips.iter().map(|c| c.clip.motion_hash()).collect();
        let same = |i: usize, j: usize| Ok::<_, ImportError>(self.clips[i].clip.has_motion_of(&self.clips[j].clip));
        repeated(&hashes, same).unwrap_or_default()
    }
}

impl ImportedClip {
    /// Oddities of the clip, without those of its skeleton.
    pub fn own_warnings(&self) -> impl Iterator<Item = &str> {
        let path = format!("{}: ", self.clip.path.display());
        let of_skeleton = move |w: &str| {
            let what = w.strip_prefix(&path).unwrap_or(w);
            self.roles.warnings.iter().any(|of| of == what)
        };
        self.warnings.messages.iter().map(String::as_str).filter(move |w| !of_skeleton(w))
    }
}

/// Oddities of the skeletons of clips, once for all clips that have one.
pub fn skeleton_warnings(clips: &[ImportedClip]) -> Vec<String> {
    let mut of = BTreeMap::<&str, Vec<usize>>::new();
    for (i, clip) in clips.iter().enumerate() {
        clip.roles.warnings.iter().for_each(|w| of.entry(w).or_default().push(i));
    }
    let describe = |(what, which): (&str, Vec<usize>)| {
        let more = if which.len() > 1 { format!(" and {} more", which.len() - 1) } else { String::new() };
        format!("{}{more}: {what}", clips[which[0]].clip.path.display())
    };
    of.into_iter().map(describe).collect()
}

/// Repeated clips as in [`ImportedSet::repeated`], from hashes of their motion ([`crate::raw::RawClip::motion_hash`]).
///
/// - `same`: whether two clips have the same motion; asked where their hashes are the same.
///
/// # Errors
/// Errors of `same`.
pub fn repeated<E>(hashes: &[u64], same: impl Fn(usize, usize) -> Result<bool, E>) -> Result<Vec<[usize; 2]>, E> {
    let mut seen = BTreeMap::<u64, Vec<usize>>::new();
    let mut out = Vec::new();
    'clips: for (i, &hash) in hashes.iter().enumerate() {
        let alike = seen.entry(hash).or_default();
        for &first in &*alike {
            if same(first, i)? {
                out.push([first, i]);
                continue 'clips;
            }
        }
        alike.push(i);
    }
    Ok(out)
}

/// The clips of a motion file, or the reason why there are none.
pub type ClipsResult = Result<Vec<ImportedClip>, ImportError>;

/// Reads a motion file, or finds the stored result of an earlier reading.
pub type ClipReader<'a> = dyn Fn(&MotionFile, &dyn Fn() -> ClipsResult) -> ClipsResult + Sync + 'a;

/// Reads all motion files of `paths` (files, folders, archives, patterns, see [`find_motion_files`]), in parallel. Clips have the names of
/// their files ([`MotionFile::clip_name`]).
///
/// - `reader`: called for every file, with a function that reads it.
///
/// The result does not depend on the number of threads. A bad file is skipped and kept in
/// [`ImportedSet::skipped`].
///
/// # Errors
/// The first bad file (by path) where `config.strict` is set; a path that yields no file; a bad profile; errors that may not
/// occur again ([`ImportError::is_passing`]).
pub fn read_by(
    reader: &ClipReader<'_>,
    paths: &[PathBuf],
    config: &ImportConfig,
    progress: &dyn Progress,
) -> Result<ImportedSet, ImportError> {
    let files = files::find_motion_files(paths)?;
    let profiles = profile::load_profiles(&config.profiles)?;
    progress.begin("import", files.len() as u64, "files");
    let read = |file: &MotionFile| {
        progress.check()?;
        let result = reader(file, &|| read_with(&file.path, config, &profiles));
        progress.advance(1);
        let mut clips = result?;
        clips.iter_mut().for_each(|c| c.clip.name = file.clip_name(&c.clip.path));
        Ok(clips)
    };
    let results: Vec<ClipsResult> = files.par_iter().map(read).collect();
    progress.end();
    let mut set = ImportedSet { clips: Vec::new(), skipped: Vec::new() };
    for result in results {
        match result {
            Ok(clips) => set.clips.extend(clips),
            Err(e) if config.strict || e.is_passing() => return Err(e),
            Err(e) => set.skipped.push(e),
        }
    }
    Ok(set)
}

/// Reads as [`read_by`] does, with every file read anew.
///
/// # Errors
/// Errors of [`read_by`] and [`ImportedSet::require_clips`].
pub fn read(paths: &[PathBuf], config: &ImportConfig, progress: &dyn Progress) -> Result<ImportedSet, ImportError> {
    read_by(&|_, read| read(), paths, config, progress)?.require_clips()
}

/// Imports clips that were made, not read, in the way of files: each is written as BVH in memory and read again.
///
/// - `folder`: folder of their paths, in messages and provenance; it need not exist.
///
/// # Errors
/// Errors of [`read`].
pub fn import_made(set: &ClipSet, folder: &Path, config: &ImportConfig) -> Result<ImportedSet, ImportError> {
    let profiles = profile::load_profiles(&config.profiles)?;
    let one = |clip: &Clip| {
        let path = folder.join(format!("{}.bvh", clip.name));
        let mut text = Vec::new();
        let failed = |source| ImportError::Io { path: path.clone(), source };
        export::bvh::write_clip(&to_raw(clip, &set.skeleton), &mut text).map_err(failed)?;
        interpret(bvh::parse(&text, &path)?, config, &profiles)
    };
    Ok(ImportedSet { clips: set.clips.par_iter().map(one).collect::<Result<_, _>>()?, skipped: Vec::new() })
}

/// Reads the clip of a motion file, or the one that a path names among several (`FILE/CLIP`).
///
/// # Errors
/// [`ImportError`] naming the file and, for faults of the text, line and column; a file of several clips.
pub fn read_clip(path: &Path, config: &ImportConfig) -> Result<ImportedClip, ImportError> {
    let mut clips = read_clips(path, config)?;
    match clips.pop() {
        Some(clip) if clips.is_empty() => Ok(clip),
        last => {
            let names = clips.iter().chain(&last).map(|c| c.clip.path.display().to_string());
            let message = format!("expected one clip, found {}", clips.len() + 1);
            Err(content_error(path, message, &format!("Name one: {}", names.take(20).collect::<Vec<_>>().join(", "))))
        }
    }
}

/// Reads the clips of a motion file.
///
/// # Errors
/// [`ImportError`] naming the file; where some of several clips are bad, only if all are or `config.strict` is set.
pub fn read_clips(path: &Path, config: &ImportConfig) -> ClipsResult {
    read_with(path, config, &profile::load_profiles(&config.profiles)?)
}

fn read_with(path: &Path, config: &ImportConfig, profiles: &[Profile]) -> ClipsResult {
    let (mut good, mut bad) = (Vec::new(), Vec::new());
    for source in read_source(path, config.asf.as_deref())? {
        match interpret(source, config, profiles) {
            Ok(clip) => good.push(clip),
            Err(e) if config.strict => return Err(e),
            Err(e) => bad.push(e),
        }
    }
    match good.first_mut() {
        Some(first) => first.warnings.messages.extend(bad.into_iter().map(|e| format!("{e}. It is left out."))),
        None => return bad.into_iter().next().map_or(Ok(good), Err),
    }
    Ok(good)
}

/// True for a file of several clips.
pub fn holds_several(path: &Path) -> bool {
    files::may_hold_several(path) && read_source(path, None).is_ok_and(|clips| clips.len() > 1)
}

/// Reads the clips of a file in its own units and axes, or the one that a path names among several; `asf` is the skeleton
/// of an AMC file, found beside it if absent.
///
/// # Errors
/// Errors of the format's reader; an unknown extension; a clip that does not exist.
pub fn read_source(path: &Path, asf: Option<&Path>) -> Result<Vec<SourceClip>, ImportError> {
    let Some((file, name)) = clip_in_file(path) else { return read_file(path, asf) };
    let all = read_file(&file, asf)?;
    let names = all.iter().take(20).map(|c| c.clip.path.display().to_string()).collect::<Vec<_>>().join(", ");
    let found: Vec<SourceClip> = all.into_iter().filter(|c| c.clip.path == path).collect();
    let what = || format!("there is no clip `{name}`");
    ensure(!found.is_empty(), || content_error(&file, what(), &format!("It holds {names}")))?;
    Ok(found)
}

fn read_file(path: &Path, asf: Option<&Path>) -> Result<Vec<SourceClip>, ImportError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "bvh" => Ok(performers::split_performers(bvh::parse(&load(path)?, path)?)),
        "amc" => {
            let asf_path = asf.map_or_else(|| files::find_asf(path), |p| Ok(p.to_owned()))?;
            let skeleton = asf::parse(&load(&asf_path)?, &asf_path)?;
            Ok(vec![amc::parse(&load(path)?, path, &skeleton)?])
        }
        "npz" => Ok(vec![npz::parse(&load(path)?, path)?]),
        "glb" | "gltf" => gltf::parse(&load(path)?, path),
        #[cfg(feature = "fbx")]
        "fbx" => fbx::parse(&load(path)?, path),
        #[cfg(not(feature = "fbx"))]
        "fbx" => {
            let help = "Build it with `--features fbx`, or convert the file to .glb";
            Err(content_error(path, "this program was built without FBX", help))
        }
        "asf" => Err(content_error(path, "an ASF file is a skeleton without motion", "Name its AMC file")),
        archive::EXTENSION => {
            let deep = || content_error(path, "it lies in an archive that lies in another one", "Unpack the outer one");
            ensure(archive::split(path).is_none_or(|(outer, _)| outer.is_file()), deep)?;
            archive::members(path)?;
            Err(content_error(path, "it is an archive, not a clip", "Name a file in it: ARCHIVE.zip/CLIP.bvh"))
        }
        _ => {
            let message = format!("its extension is not {FORMATS}");
            Err(content_error(path, message, "Convert it, or correct its name"))
        }
    }
}

fn load(path: &Path) -> Result<Vec<u8>, ImportError> {
    archive::read_file(path, "motion", MAX_MOTION_BYTES)
}

/// Finds roles, units, axes and rest pose of a clip, and brings it into metres and Y up. Made clips (`import_made`) and the single
/// rest frame of a body that wears motion pass here too: checks have to admit them.
///
/// # Errors
/// [`ImportError::Content`] where a required role is missing or the skeleton has no size.
pub fn interpret(
    mut source: SourceClip,
    config: &ImportConfig,
    profiles: &[Profile],
) -> Result<ImportedClip, ImportError> {
    ensure(source.clip.num_frames != 0, || content_error(&source.clip.path, "it has no frames", "Leave it out"))?;
    let roles = roles::assign(&source.clip, profiles, config.profile.as_deref())?;
    let metres_per_unit = units::find_unit(&mut source, &roles, config)?;
    let up = units::find_up(&mut source, &roles, config);
    if let Some(rate_hz) = config.rate_hz {
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(content_error(&source.clip.path, "`rate_hz` must be above 0", "Correct it"));
        }
        source.clip.rate_hz = rate_hz;
        source.findings.push(format!("{rate_hz} frames a second: as given."));
    }
    let SourceClip { mut clip, mut findings, mut warnings, .. } = source;
    units::normalise(&mut clip, metres_per_unit, up);
    person::check_size(&clip, &roles, metres_per_unit, config.metres_per_unit.is_some())?;
    person::check_place(&clip, &roles, [0, clip.num_frames - 1])?;
    let glitches = glitches::treat_glitches(&mut clip, &roles, config.glitches, &mut warnings);
    // Glitches may be anywhere.
    let at = |f: usize| glitches.partition_point(|g| g.frames.end <= f);
    let is_motion = |f: &usize| glitches.get(at(*f)).is_none_or(|g| !g.frames.contains(f));
    person::check_place(&clip, &roles, (0..clip.num_frames).filter(is_motion))?;
    if config.loops && glitches.is_empty() {
        findings.extend(oddities::unroll_loop(&mut clip, &roles));
    }
    oddities::treat_oddities(&mut clip, &roles, config.root_motion, &mut warnings);
    let (rest_pose, facing) = rest::find_rest_pose(&clip, &roles, config.forward);
    findings.push(rest_pose.sentence.clone());
    let height = units::body_height(&clip, &roles);
    roles.warnings.iter().for_each(|warning| warnings.push(format!("{}: {warning}", clip.path.display())));
    Ok(ImportedClip {
        clip,
        roles,
        rest_pose,
        metres_per_unit,
        up,
        facing,
        forward: config.forward,
        height,
        glitches,
        findings,
        warnings,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_beyond_the_limit_and_what_is_no_file_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.amc", "a.bvh", "b.asf"] {
            let path = folder.path().join(name);
            // A file with a hole: it takes no room.
            std::fs::File::create(&path).unwrap().set_len(MAX_MOTION_BYTES + 1).unwrap();
            let e = load(&path).unwrap_err().to_string();
            assert!(e.contains(name) && e.contains("has 2147.5 MB, but motion may have 2147 MB at most"), "{e}");
        }
        std::fs::create_dir(folder.path().join("c.bvh")).unwrap();
        let e = read_source(&folder.path().join("c.bvh"), None).unwrap_err().to_string();
        assert!(e.contains("c.bvh: is a folder, expected motion in a regular file"), "{e}");
        #[cfg(unix)]
        assert!(load(Path::new("/dev/zero")).unwrap_err().to_string().contains("is a device or a pipe"));
    }
}
