//! Content of many motion files: one line each, and what is missing for which behaviour.

use super::classes::{describe, sum_classes};
use super::{ClassTime, ClipReport};
use crate::abilities::Abilities;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use throng_bake::config::BuildConfig;
use throng_bake::graph::MakeMotion;
use throng_bake::pipeline;
use throng_bake::report::SourcePerformer;
use throng_motion::clip::ClipSet;
use throng_motion::error::{ImportError, Result, Warnings};
use throng_motion::import::{self, ImportedClip, ImportedSet};
use throng_motion::progress::Progress;
use throng_motion::retarget;

/// Share of the time on the ground below which a foot makes its clip odd.
const LITTLE_CONTACT: f32 = 0.05;

/// Speeds of planted feet above which they skate: mean, and 95th percentile (mm/s).
const SKATES_MM_PER_S: [f32; 2] = [100.0, 200.0];
/// Verdict on a file that is left out by its name.
const LEFT_OUT: &str = "left out";

/// Content of many motion files. The names of the fields are keys of the JSON report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FolderReport {
    /// One entry a file, sorted by path.
    pub files: Vec<FileLine>,
    /// Performers of the motion: files of one source skeleton together.
    pub performers: Vec<SourcePerformer>,
    /// Files that hold the motion of another one, number by number: the file, and that other one.
    pub repeated: Vec<[String; 2]>,
    /// Classes of all motion, the longest first.
    pub classes: Vec<ClassTime>,
    /// Abilities in the motion.
    pub motion: Abilities,
    /// Abilities that a behaviour needs and the motion lacks, each with the clips that would add it.
    pub missing: Vec<String>,
    /// Oddities that import tolerates.
    pub warnings: Vec<String>,
}

/// One motion file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FileLine {
    /// The file.
    pub file: String,
    /// `good`, `odd`, `skipped` or `left out` by its name.
    pub verdict: &'static str,
    /// Reason why it is odd or skipped; empty where it is good.
    pub why: String,
    /// Findings of import; absent for a skipped file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<ClipReport>,
    /// Usable motion (s).
    pub usable_s: f64,
}

/// Reads motion files as a build with this config would, and reports their content.
///
/// # Errors
/// A path that yields no file; a bad profile; as the retarget, resample and annotate stages.
pub fn inspect_all(paths: &[PathBuf], config: &BuildConfig, progress: &dyn Progress) -> Result<FolderReport> {
    let mut set = import::read_by(&|_, read| read(), paths, &config.import, progress)?;
    let names: Vec<&str> = set.clips.iter().map(|c| c.clip.name.as_str()).collect();
    config.select.check(&names)?;
    let is_left_out = |c: &mut ImportedClip| !config.select.takes(&c.clip.name);
    let left_out: Vec<ImportedClip> = set.clips.extract_if(.., is_left_out).collect();
    let mut warnings = Warnings::default();
    let clips = match set.clips.is_empty() {
        true => ClipSet { skeleton: Default::default(), clips: Vec::new() },
        false => pipeline::clips_of(&set.clips, config, &mut warnings)?,
    };
    let motion = Abilities::of_clips(&clips);
    let mut missing = match config.graph.make {
        _ if clips.clips.is_empty() => Vec::new(),
        MakeMotion::Missing => motion.missing_in_files(config.resample.mirror),
        MakeMotion::None => motion.missing(config.resample.mirror),
    };
    if !clips.clips.is_empty() && motion.blows == 0 {
        missing.push("no blows: nobody can box; add punches or kicks where they should".into());
    }
    let path = |i: usize| set.clips[i].clip.path.display().to_string();
    let mut files = file_lines(&set, &clips, config);
    files.extend(left_out.iter().map(|c| FileLine {
        file: c.clip.path.display().to_string(),
        verdict: LEFT_OUT,
        ..FileLine::default()
    }));
    files.sort_by(|a, b| PathBuf::from(&a.file).cmp(&PathBuf::from(&b.file)));
    let classes = sum_classes(files.iter().filter_map(|l| l.clip.as_ref()).flat_map(|c| &c.spans));
    Ok(FolderReport {
        files,
        classes,
        performers: performers(&set.clips, &clips),
        repeated: set.repeated().into_iter().map(|[first, i]| [path(i), path(first)]).collect(),
        motion,
        missing,
        warnings: import::skeleton_warnings(&set.clips).into_iter().chain(warnings.messages).collect(),
    })
}

fn performers(imported: &[ImportedClip], clips: &ClipSet) -> Vec<SourcePerformer> {
    let performer = |indices: Vec<usize>| SourcePerformer {
        height_m: imported[indices[0]].height,
        clips: indices.iter().map(|&i| clips.clips[i].name.clone()).collect(),
    };
    retarget::performers(imported).into_iter().map(performer).collect()
}

/// One line for each file.
fn file_lines(set: &ImportedSet, clips: &ClipSet, config: &BuildConfig) -> Vec<FileLine> {
    let copies: BTreeMap<usize, usize> = set.repeated().into_iter().map(|[first, i]| (i, first)).collect();
    let read = set.clips.iter().zip(&clips.clips).enumerate().map(|(i, (imported, clip))| {
        let usable_s = clip.usable_ranges().iter().map(ExactSizeIterator::len).sum::<usize>() as f64 / clip.rate_hz;
        let report = ClipReport::from_annotated(imported, clip, &clips.skeleton, config);
        let original =
            copies.get(&i).map(|&first| format!("the same motion as {}", set.clips[first].clip.path.display()));
        let why = original.or_else(|| oddity(imported, usable_s, &report)).unwrap_or_default();
        let verdict = if why.is_empty() { "good" } else { "odd" };
        FileLine { file: report.file.clone(), verdict, why, clip: Some(report), usable_s }
    });
    let skipped = set.skipped.iter().map(|e| {
        let (file, why) = split_message(e);
        FileLine { file, verdict: "skipped", why, ..FileLine::default() }
    });
    read.chain(skipped).collect()
}

/// Reason why a clip is odd, if it is.
fn oddity(imported: &ImportedClip, usable_s: f64, report: &ClipReport) -> Option<String> {
    let contact = &report.contact;
    if usable_s < 0.5 {
        let parts = report.excluded.iter().map(|(why, from, to)| format!("{why} {from} to {to}"));
        let parts =
            if report.excluded.is_empty() { "it is short".into() } else { parts.collect::<Vec<_>>().join(", ") };
        return Some(format!("hardly a usable frame: {parts}"));
    }
    let within = |w: &str| w.strip_prefix(&format!("{}: ", report.file)).unwrap_or(w).to_owned();
    let of_skeleton = |w: &&String| imported.roles.warnings.contains(&within(w));
    let all: Vec<String> = report.warnings.iter().filter(|w| !of_skeleton(w)).map(|w| within(w)).collect();
    // Noise and the like explain why feet hardly stand, or slide.
    if !all.is_empty() {
        return Some(all.join(" "));
    }
    let stands = contact.left_share.min(contact.right_share) >= LITTLE_CONTACT;
    let has = |gaits: &[&str]| report.classes.iter().any(|c| gaits.contains(&c.gait));
    let walks = has(&["walk", "strafe", "sneak", "backwards"]);
    let [mean, p95] = [contact.mean_speed_mps, contact.p95_speed_mps].map(|mps| 1e3 * mps);
    let slides = match stands {
        true if p95 > SKATES_MM_PER_S[1] && (walks || has(&["run", "jog"])) => {
            format!("one planted foot in twenty slides at {p95:.0} mm/s or more")
        }
        true => return None,
        false if walks => "hardly a foot stays where it is put down".to_owned(),
        false => return Some("feet hardly touch the ground".to_owned()),
    };
    let why = "; the root does not go as the feet step: export it with its own root motion";
    Some(format!("skates: {slides}{}", if stands && mean < SKATES_MM_PER_S[0] { "" } else { why }))
}

/// Splits an error's message into the file and the rest.
fn split_message(e: &ImportError) -> (String, String) {
    let (text, path) = (e.to_string(), e.path().map_or_else(String::new, |p| p.display().to_string()));
    let why = text.strip_prefix(&path).map_or(&*text, |rest| rest.trim_start_matches([':', ' ']));
    (path, why.to_owned())
}

impl fmt::Display for FolderReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.files.iter().map(|l| l.file.chars().count()).max().unwrap_or(0).min(60);
        for line in &self.files {
            let why = if line.why.is_empty() { String::new() } else { format!(": {}", line.why) };
            let Some(c) = &line.clip else {
                writeln!(f, "{:width$}  {}{why}", line.file, line.verdict)?;
                continue;
            };
            let ClipReport { duration_s, rate_hz, metres_per_unit, up, height_m, joints, profile, .. } = c;
            let classes = describe(&c.classes, ToString::to_string);
            let repeated = c.findings.iter().find(|f| f.starts_with("a loop of"));
            let repeated = repeated.map_or_else(String::new, |f| format!("; {f}"));
            writeln!(
                f,
                "{:width$}  {duration_s:6.1} s  {rate_hz:5.1} Hz  {metres_per_unit:.4} m/unit  {up} up  {height_m:.2} m, \
                 {joints} joints, {profile}; {classes}{repeated}  {}{why}",
                line.file, line.verdict
            )?;
        }
        let count = |verdict: &str| self.files.iter().filter(|l| l.verdict == verdict).count();
        writeln!(f)?;
        write!(f, "files       {} good, {} odd, {} skipped", count("good"), count("odd"), count("skipped"))?;
        match count(LEFT_OUT) {
            0 => writeln!(f)?,
            n => writeln!(f, ", {n} left out by name")?,
        }
        for p in &self.performers {
            let some: Vec<&str> = p.clips.iter().take(3).map(String::as_str).collect();
            let more = if p.clips.len() > some.len() { ", ..." } else { "" };
            let (some, num) = (some.join(", "), p.clips.len());
            writeln!(f, "performer   {:.2} m tall, in {num} file(s): {some}{more}", p.height_m)?;
        }
        writeln!(f, "classes     {}", describe(&self.classes, ToString::to_string))?;
        let manners = describe(&self.classes, |c| c.manner.clone());
        if !manners.is_empty() {
            writeln!(f, "manners     {manners}")?;
        }
        let m = &self.motion;
        writeln!(
            f,
            "motion      {:.0} s usable: {:.0} s walking up to {:.1} m/s ({:.0} s backwards), {:.0} s standing, {} start(s), {} stop(s)",
            m.usable_s, m.walking_s, m.fastest_mps, m.backwards_s, m.standing_s, m.starts, m.stops
        )?;
        let [left, right] = [m.turn_left_deg_per_s, m.turn_right_deg_per_s];
        writeln!(f, "turns       left {left:.0} deg/s, right {right:.0} deg/s at most, while walking")?;
        writeln!(f, "blows       {}", m.blows)?;
        self.repeated.iter().try_for_each(|[one, other]| writeln!(f, "twice       {one} is {other}"))?;
        self.missing.iter().try_for_each(|what| writeln!(f, "missing     {what}"))?;
        self.warnings.iter().try_for_each(|what| writeln!(f, "warning     {what}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use throng_core::{NUM_JOINTS, Skeleton};
    use throng_motion::clip::Clip;

    #[test]
    fn all_that_is_odd_about_a_file_is_told_and_what_is_odd_about_a_skeleton_once() {
        let skeleton = Skeleton::default();
        let clip = |name| Clip::new(name, 30.0, vec![skeleton.offsets[0]; 60], vec![Quat::IDENTITY; 60 * NUM_JOINTS]);
        let set = ClipSet { clips: ["a", "b"].map(clip).to_vec(), skeleton };
        let mut set = import::import_made(&set, "folder".as_ref(), &Default::default()).unwrap();
        for clip in &mut set.clips {
            clip.roles.warnings.push("its neck is odd.".into());
            for what in ["its neck is odd.", "it shakes.", "walks on the spot."] {
                clip.warnings.push(format!("{}: {what}", clip.clip.path.display()));
            }
            let mut report = ClipReport::from_imported(clip);
            (report.contact.left_share, report.contact.right_share) = (0.6, 0.6);
            assert_eq!(oddity(clip, 2.0, &report).unwrap(), "it shakes. walks on the spot.");
            (report.contact.left_share, report.contact.right_share) = (0.0, 0.0);
            assert_eq!(oddity(clip, 2.0, &report).unwrap(), "it shakes. walks on the spot.", "which is why");
            report.warnings.clear();
            assert_eq!(oddity(clip, 2.0, &report).unwrap(), "feet hardly touch the ground");
            report.classes = vec![ClassTime { gait: "walk", ..ClassTime::default() }];
            assert!(oddity(clip, 2.0, &report).unwrap().contains("hardly a foot stays where it is put down"));
            (report.contact.left_share, report.contact.right_share) = (0.5, 0.5);
            assert_eq!(oddity(clip, 2.0, &report), None);
            report.contact.p95_speed_mps = 0.236;
            let told = oddity(clip, 2.0, &report).unwrap();
            assert!(told.ends_with("one planted foot in twenty slides at 236 mm/s or more"), "{told}");
            report.contact.mean_speed_mps = 0.15;
            assert!(oddity(clip, 2.0, &report).unwrap().contains("the root does not go as the feet step"));
            report.classes[0].gait = "stand";
            assert_eq!(oddity(clip, 2.0, &report), None, "who bows may shuffle");
        }
        let warnings = import::skeleton_warnings(&set.clips);
        assert!(warnings.len() == 1 && warnings[0].ends_with("a.bvh and 1 more: its neck is odd."), "{warnings:?}");
    }
}
