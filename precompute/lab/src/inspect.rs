//! Reports on the content of a clip or bundle, for people and for programs.

mod bundle;
mod classes;
mod folder;
pub mod hit_picture;
mod level;

pub use bundle::BundleReport;
pub use classes::{ClassLine, ClassTime};
pub use folder::{FileLine, FolderReport, inspect_all};
pub use level::{LevelLinkLine, LevelPlaceLine, LevelReport};
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use throng_bake::config::BuildConfig;
use throng_bake::pipeline;
use throng_core::Skeleton;
use throng_motion::annotate::hits::{HitPoint, HitReport};
use throng_motion::annotate::{self, ContactSanity};
use throng_motion::clip::{Clip, ClipSet, Exclusion};
use throng_motion::error::{BuildError, Result, Warnings};
use throng_motion::import::{self, ImportConfig, ImportedClip};
use throng_motion::raw::{RawClip, SourceFormat};

/// Findings of import in a clip. The names of the fields are keys of the JSON report.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ClipReport {
    /// The file.
    pub file: String,
    /// `bvh`, `asf_amc`, `npz`, `gltf` or `fbx`.
    pub format: &'static str,
    /// Number of joints, ends of chains included.
    pub joints: usize,
    /// Number of frames.
    pub frames: usize,
    /// Frames a second (Hz).
    pub rate_hz: f64,
    /// Length of the clip (s).
    pub duration_s: f64,
    /// Length of one unit of the file (m).
    pub metres_per_unit: f64,
    /// Axis that points up in the file: `Y` or `Z`.
    pub up: char,
    /// `t_pose`, `a_pose` or `other`.
    pub rest_pose: &'static str,
    /// Heading the rest pose faces (degrees).
    pub facing_deg: f32,
    /// Body height estimated from the lengths of the segments (m).
    pub height_m: f32,
    /// Skeleton profile, or that roles were guessed.
    pub profile: String,
    /// Source joint of each role.
    pub roles: BTreeMap<&'static str, String>,
    /// Properties that were detected, each with the reason.
    pub findings: Vec<String>,
    /// How the feet behave once contacts are known, at the default database rate.
    pub contact: ContactSanity,
    /// Effective hitting points a build would find.
    pub hits: HitReport,
    /// Classes of its motion, the longest first.
    pub classes: Vec<ClassTime>,
    /// Its motion in time.
    pub spans: Vec<ClassLine>,
    /// Frames of the file that a build would leave out: reason, first frame, frame after the last.
    pub excluded: Vec<(String, usize, usize)>,
    /// Oddities that import tolerates.
    pub warnings: Vec<String>,
}

/// A clip as the file holds it and as a build would use it, with its report.
#[derive(Clone, Debug)]
pub struct InspectedClip {
    /// The source's own joints.
    pub imported: ImportedClip,
    /// The clip on the database skeleton, at the default database rate, annotated.
    pub clips: ClipSet,
    /// The findings.
    pub report: ClipReport,
}

/// Reads a clip and reports what a build would make of it.
///
/// # Errors
/// As [`inspect_clip`].
pub fn inspect(path: &Path, config: &ImportConfig) -> Result<ClipReport> {
    Ok(inspect_clip(path, &BuildConfig { import: config.clone(), ..BuildConfig::default() })?.report)
}

/// Like [`inspect`], with all settings of a config for reading, retargeting, resampling and annotating; keeps the motion.
///
/// # Errors
/// As the import and retarget stages; [`BuildError::Stage`] for a folder or pattern of several clips.
pub fn inspect_clip(path: &Path, config: &BuildConfig) -> Result<InspectedClip> {
    let files = import::expand(&[path.to_path_buf()])?;
    let [file] = files.as_slice() else {
        let message = format!("{}: expected one clip, found {}", path.display(), files.len());
        let help = format!("Name a single {} file", import::FORMATS);
        return Err(BuildError::Stage { stage: "inspect", message, help });
    };
    let imported = import::read_clip(file, &config.import)?;
    let mut warnings = Warnings::default();
    // At the rate of a build, so that it finds the same speeds.
    let clips = pipeline::clips_of(std::slice::from_ref(&imported), config, &mut warnings)?;
    let mut report = match clips.clips.first() {
        Some(clip) => ClipReport::from_annotated(&imported, clip, &clips.skeleton, config),
        None => ClipReport::from_imported(&imported),
    };
    report.warnings.extend(warnings.messages);
    Ok(InspectedClip { imported, clips, report })
}

/// Converts an excluded range to frames of the file: reason, first frame, frame after the last.
fn excluded_in_source(e: &Exclusion, clip: &Clip, source: &RawClip) -> (String, usize, usize) {
    let step = source.rate_hz / clip.rate_hz;
    let at = |frame: usize| ((frame as f64 * step).round() as usize).min(source.num_frames);
    let end = if e.range.end >= clip.num_frames() { source.num_frames } else { at(e.range.end) };
    (e.reason.to_string(), at(e.range.start), end)
}

impl ClipReport {
    /// Combines the findings of import with those of the later stages of a build.
    fn from_annotated(imported: &ImportedClip, clip: &Clip, skeleton: &Skeleton, config: &BuildConfig) -> Self {
        let (contact, hits) = (annotate::contact_sanity(clip, skeleton), HitReport::new(&HitPoint::from_clip(clip)));
        let excluded = clip.excluded.iter().map(|e| excluded_in_source(e, clip, &imported.clip)).collect();
        let spans = ClassLine::of_spans(&clip.classes, clip.rate_hz);
        let classes = classes::sum_classes(spans.iter());
        let mut report = Self { contact, hits, classes, spans, excluded, ..Self::from_imported(imported) };
        // A config that keeps heights as captured implies terrain.
        let advice = report.contact.stance.advice().filter(|_| config.retarget.align_ground);
        report.warnings.extend(advice.map(|advice| format!("{}: {advice}.", report.file)));
        report
    }

    /// Collects the findings of import.
    fn from_imported(imported: &ImportedClip) -> Self {
        let clip = &imported.clip;
        let roles = imported.roles.pairs(&clip.joints).map(|(role, joint)| (role.name(), joint.to_owned()));
        Self {
            file: clip.path.display().to_string(),
            format: match clip.format {
                SourceFormat::Bvh => "bvh",
                SourceFormat::AsfAmc => "asf_amc",
                SourceFormat::Npz => "npz",
                SourceFormat::Gltf => "gltf",
                SourceFormat::Fbx => "fbx",
            },
            joints: clip.joints.len(),
            frames: clip.num_frames,
            rate_hz: clip.rate_hz,
            duration_s: clip.num_frames as f64 / clip.rate_hz,
            metres_per_unit: imported.metres_per_unit,
            up: imported.up.letter(),
            rest_pose: imported.rest_pose.kind.name(),
            facing_deg: imported.facing.to_degrees() + 0.0,
            height_m: imported.height,
            profile: imported.roles.profile.clone(),
            roles: roles.collect(),
            findings: imported.findings.clone(),
            contact: ContactSanity::default(),
            hits: HitReport::default(),
            classes: Vec::new(),
            spans: Vec::new(),
            excluded: Vec::new(),
            warnings: imported.warnings.messages.clone(),
        }
    }
}

impl fmt::Display for ClipReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.file)?;
        writeln!(f, "  format   {}, {} joints", self.format, self.joints)?;
        writeln!(f, "  motion   {} frames at {} Hz, {:.2} s", self.frames, self.rate_hz, self.duration_s)?;
        writeln!(f, "  body     {:.2} m tall, skeleton profile: {}", self.height_m, self.profile)?;
        writeln!(f, "  found")?;
        self.findings.iter().try_for_each(|finding| writeln!(f, "    {finding}"))?;
        writeln!(f, "  roles")?;
        for role in throng_core::Joint::ALL {
            let joint = self.roles.get(role.name()).map_or("-", String::as_str);
            writeln!(f, "    {:<16} {joint}", role.name())?;
        }
        let c = &self.contact;
        let [left, right] = [c.left_share, c.right_share].map(|share| 100.0 * share);
        let speeds = format!("{:.3} m/s on average, {:.3} at the 95th percentile", c.mean_speed_mps, c.p95_speed_mps);
        writeln!(f, "  contact  left {left:.0} %, right {right:.0} %, planted feet move at {speeds}")?;
        writeln!(f, "  feet     stand {}", c.stance)?;
        writeln!(f, "  hits     {}", self.hits)?;
        for ClassLine { from_s, to_s, speed_mps, class, .. } in &self.spans {
            let manner = if class.manner.is_empty() { String::new() } else { format!(", {}", class.manner) };
            writeln!(f, "  class    {from_s:.1} to {to_s:.1} s: {class}{manner}, {speed_mps:.1} m/s")?;
        }
        let mut excluded = self.excluded.iter();
        excluded.try_for_each(|(why, start, end)| writeln!(f, "  excluded frames {start} to {end}: {why}"))?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "  warning  {warning}"))
    }
}
