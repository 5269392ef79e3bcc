//! Content of a bundle: its motion and its effective hits, clip by clip.

use super::classes::{ClassLine, ClassTime, describe, sum_classes};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;
use throng_bake::examples::BlendReport;
use throng_core::Bundle;
use throng_core::format::FormatError;
use throng_motion::annotate::hits::{HitPoint, HitReport};

/// Content of a bundle. The names of the fields are keys of the JSON report.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BundleReport {
    /// The file.
    pub file: String,
    /// The database's name.
    pub name: String,
    /// Clips, mirrored copies included.
    pub clips: usize,
    /// Frames of all clips.
    pub frames: usize,
    /// Frames a second (Hz).
    pub rate_hz: f64,
    /// States of the motion graph.
    pub states: usize,
    /// Actions of all states.
    pub actions: usize,
    /// Names of the behaviours.
    pub behaviours: Vec<String>,
    /// Names of the blend spaces.
    pub blend_spaces: Vec<String>,
    /// Quality of the blend spaces and the examples they are made of.
    pub blends: Vec<BlendReport>,
    /// Names of the activities that standing people can be asked for.
    pub activities: BTreeSet<String>,
    /// Activities by tag: how many, and the time they take (s).
    pub activity_times: BTreeMap<String, (usize, f64)>,
    /// Classes of the motion, mirrored copies not counted, the longest first.
    pub classes: Vec<ClassTime>,
    /// Effective hitting points.
    pub hits: HitReport,
    /// Number of hits by clip and kind; clips without hits are left out.
    pub clip_hits: BTreeMap<String, BTreeMap<String, usize>>,
}

impl BundleReport {
    /// Report of an open bundle.
    ///
    /// # Errors
    /// As [`BlendReport::of_bundle`].
    pub fn new(file: &Path, tables: &Bundle) -> Result<Self, FormatError> {
        let (meta, graph, points) = (tables.meta(), tables.graph(), HitPoint::from_bundle(tables));
        let mut clip_hits: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
        for h in &points {
            *clip_hits.entry(h.clip.clone()).or_default().entry(h.kind.clone()).or_insert(0) += 1;
        }
        let mut activity_times: BTreeMap<String, (usize, f64)> = BTreeMap::new();
        for a in &meta.activities {
            let (num, time_s) = activity_times.entry(a.tag.clone()).or_default();
            *num += 1;
            *time_s += f64::from(a.num_frames) / meta.rate_hz;
        }
        let originals = tables.clips().iter().zip(&meta.clips).filter(|(c, _)| c.mirrored == 0);
        let spans: Vec<ClassLine> =
            originals.flat_map(|(_, m)| ClassLine::of_spans(&m.classes, meta.rate_hz)).collect();
        let classes = sum_classes(spans.iter());
        Ok(Self {
            file: file.display().to_string(),
            name: meta.name.clone(),
            clips: tables.clips().len(),
            frames: tables.frames().len(),
            rate_hz: meta.rate_hz,
            states: graph.states.len(),
            actions: graph.action_segments.len(),
            behaviours: meta.behaviours.clone(),
            blend_spaces: tables.blends().names.clone(),
            blends: BlendReport::of_bundle(tables)?,
            activities: meta.activities.iter().map(|a| a.tag.clone()).collect(),
            activity_times,
            classes,
            hits: HitReport::new(&points),
            clip_hits,
        })
    }
}

impl fmt::Display for BundleReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.file)?;
        writeln!(f, "  name     {}, behaviours: {}", self.name, self.behaviours.join(", "))?;
        writeln!(f, "  motion   {} clips, {} frames at {} Hz", self.clips, self.frames, self.rate_hz)?;
        writeln!(f, "  graph    {} states, {} actions", self.states, self.actions)?;
        for b in &self.blends {
            let reason = if b.quality.reason.is_empty() { String::new() } else { format!(" ({})", b.quality.reason) };
            let (num, clips) = (b.examples.len(), b.clips().join(", "));
            writeln!(f, "  blends   {}: {}{reason}; {num} examples of {clips}", b.name, b.quality.word)?;
        }
        if !self.activities.is_empty() {
            let some = |(tag, (num, time_s)): (&String, &(usize, f64))| format!("{tag} ({num}, {time_s:.0} s)");
            writeln!(f, "  standing {}", self.activity_times.iter().map(some).collect::<Vec<_>>().join(", "))?;
        }
        if !self.classes.is_empty() {
            writeln!(f, "  classes  {}", describe(&self.classes, ToString::to_string))?;
        }
        writeln!(f, "  hits     {}", self.hits)?;
        for (clip, kinds) in &self.clip_hits {
            let kinds: Vec<String> = kinds.iter().map(|(kind, n)| format!("{kind} {n}")).collect();
            writeln!(f, "    {clip:<24} {}", kinds.join(", "))?;
        }
        Ok(())
    }
}
