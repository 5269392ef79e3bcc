//! Content of a bundle: its motion and its effective hits, clip by clip.

use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;
use throng_core::Bundle;
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
    /// Names of the activities that standing people can be asked for.
    pub activities: BTreeSet<String>,
    /// Effective hitting points.
    pub hits: HitReport,
    /// Number of hits by clip and kind; clips without hits are left out.
    pub clip_hits: BTreeMap<String, BTreeMap<String, usize>>,
}

impl BundleReport {
    /// Report of an open bundle.
    pub fn new(file: &Path, tables: &Bundle) -> Self {
        let (meta, graph, points) = (tables.meta(), tables.graph(), HitPoint::from_bundle(tables));
        let mut clip_hits: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
        for h in &points {
            *clip_hits.entry(h.clip.clone()).or_default().entry(h.kind.clone()).or_insert(0) += 1;
        }
        Self {
            file: file.display().to_string(),
            name: meta.name.clone(),
            clips: tables.clips().len(),
            frames: tables.frames().len(),
            rate_hz: meta.rate_hz,
            states: graph.states.len(),
            actions: graph.action_segments.len(),
            behaviours: meta.behaviours.clone(),
            blend_spaces: tables.blends().names.clone(),
            activities: meta.activities.iter().map(|a| a.tag.clone()).collect(),
            hits: HitReport::new(&points),
            clip_hits,
        }
    }
}

impl fmt::Display for BundleReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.file)?;
        writeln!(f, "  name     {}, behaviours: {}", self.name, self.behaviours.join(", "))?;
        writeln!(f, "  motion   {} clips, {} frames at {} Hz", self.clips, self.frames, self.rate_hz)?;
        writeln!(f, "  graph    {} states, {} actions", self.states, self.actions)?;
        if !self.blend_spaces.is_empty() {
            writeln!(f, "  blends   {}", self.blend_spaces.join(", "))?;
        }
        if !self.activities.is_empty() {
            writeln!(f, "  standing {}", self.activities.iter().map(String::as_str).collect::<Vec<_>>().join(", "))?;
        }
        writeln!(f, "  hits     {}", self.hits)?;
        for (clip, kinds) in &self.clip_hits {
            let kinds: Vec<String> = kinds.iter().map(|(kind, n)| format!("{kind} {n}")).collect();
            writeln!(f, "    {clip:<24} {}", kinds.join(", "))?;
        }
        Ok(())
    }
}
