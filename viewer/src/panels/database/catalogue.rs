//! The clips of a bundle as a list: searched and sorted.

use crate::bundle::OpenBundle;
use crate::panels::paint::TableSort;
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Range;
use throng_core::format::{ClipMeta, ClipRecord};
use throng_precompute::abilities::played_frames;

/// Order of two clips by each column of the list.
const ORDERS: [fn(&CatalogueClip, &CatalogueClip) -> Ordering; 7] = [
    |a, b| a.name.cmp(&b.name),
    |a, b| a.duration_s.total_cmp(&b.duration_s),
    |a, b| a.usable.total_cmp(&b.usable),
    |a, b| a.played.total_cmp(&b.played),
    |a, b| a.states.cmp(&b.states),
    |a, b| a.actions.cmp(&b.actions),
    |a, b| a.tags.cmp(&b.tags),
];

/// A clip in the list.
#[derive(Clone, Debug, PartialEq)]
pub struct CatalogueClip {
    /// Name.
    pub name: String,
    /// A copy with left and right exchanged.
    pub mirrored: bool,
    /// Length (s).
    pub duration_s: f64,
    /// Share of the frames that are not left out (0 to 1).
    pub usable: f32,
    /// Share of the frames that the motion graph plays (0 to 1).
    pub played: f32,
    /// States of the motion graph in it.
    pub states: u32,
    /// Actions that leave them.
    pub actions: u32,
    /// Names of its tags, each once.
    pub tags: String,
    /// Searched text, in lower case.
    haystack: String,
}

/// All clips of a bundle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipCatalogue {
    /// In the order of the bundle.
    pub entries: Vec<CatalogueClip>,
}

impl ClipCatalogue {
    /// Collects the entries of the list.
    pub fn from_bundle(bundle: &OpenBundle) -> Self {
        let played = played_frames(bundle.tables());
        let graph = bundle.tables().graph();
        let entry = |(record, meta): (&ClipRecord, &ClipMeta)| {
            let rows = record.first_frame..record.first_frame + record.num_frames;
            let states = states_within(bundle, &rows);
            let n = record.num_frames as f32;
            let excluded = (0..record.num_frames).filter(|f| meta.excluded.iter().any(|e| e.1 <= *f && *f < e.2));
            let kept = played[rows.start as usize..rows.end as usize].iter().filter(|p| **p).count();
            let tags: BTreeSet<&str> = meta.tags.iter().map(|t| t.0.as_str()).collect();
            let tags = Vec::from_iter(tags).join(", ");
            CatalogueClip {
                name: meta.name.clone(),
                mirrored: record.mirrored != 0,
                duration_s: f64::from(record.num_frames) / f64::from(bundle.rate_hz()),
                usable: 1.0 - excluded.count() as f32 / n,
                played: kept as f32 / n,
                actions: graph.action_offsets[states.end] - graph.action_offsets[states.start],
                states: states.len() as u32,
                haystack: format!("{}\n{}\n{tags}", meta.name, meta.source).to_lowercase(),
                tags,
            }
        };
        Self { entries: bundle.clips().map(entry).collect() }
    }

    /// Numbers of the clips that have every word of the query in name, tags or source, in the order asked for.
    pub fn select(&self, query: &str, sort: TableSort) -> Vec<usize> {
        let query = query.to_lowercase();
        let words: Vec<&str> = query.split_whitespace().collect();
        let matches = |e: &CatalogueClip| words.iter().all(|w| e.haystack.contains(w));
        let mut out: Vec<usize> = (0..self.entries.len()).filter(|&i| matches(&self.entries[i])).collect();
        sort.sort(&mut out, &ORDERS, &self.entries);
        out
    }
}

/// Numbers of the states whose frames lie in a range of rows.
pub fn states_within(bundle: &OpenBundle, rows: &Range<u32>) -> Range<usize> {
    let states = &bundle.tables().graph().states;
    states.partition_point(|s| s.frame < rows.start)..states.partition_point(|s| s.frame < rows.end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::golden;

    fn entry(name: &str, source: &str, tags: &str, states: u32) -> CatalogueClip {
        let haystack = format!("{name}\n{source}\n{tags}").to_lowercase();
        let (name, tags) = (name.to_owned(), tags.to_owned());
        let duration_s = name.len() as f64;
        CatalogueClip {
            name,
            mirrored: false,
            duration_s,
            usable: 1.0,
            played: 0.5,
            states,
            actions: 2,
            tags,
            haystack,
        }
    }

    fn catalogue() -> ClipCatalogue {
        ClipCatalogue {
            entries: vec![
                entry("Walk_01", "mocap/a.bvh", "walk, slow", 3),
                entry("run_02", "mocap/b.bvh", "run", 9),
                entry("walk_03~mirror", "mocap/b.bvh", "walk", 5),
            ],
        }
    }

    #[test]
    fn every_word_has_to_match_name_tags_or_source_in_any_case() {
        let c = catalogue();
        let found = |query| c.select(query, TableSort::default());
        assert_eq!(found("").len(), 3);
        assert_eq!(found("  WALK "), [0, 2]);
        assert_eq!(found("walk b.bvh"), [2]);
        assert_eq!(found("slow mocap"), [0]);
        assert_eq!(found("walk run"), [0usize; 0]);
    }

    #[test]
    fn the_order_is_that_of_the_column() {
        let c = catalogue();
        // That of states.
        let column = 4;
        assert_eq!(c.select("", TableSort { column, descending: false }), [0, 2, 1]);
        assert_eq!(c.select("", TableSort { column, descending: true }), [1, 2, 0]);
        assert_eq!(c.select("walk", TableSort { column, descending: true }), [2, 0]);
    }

    #[test]
    fn sums_over_clips_are_those_of_the_bundle() {
        let bundle = golden();
        let c = ClipCatalogue::from_bundle(&bundle);
        let graph = bundle.tables().graph();
        assert_eq!(c.entries.iter().map(|e| e.states as usize).sum::<usize>(), graph.states.len());
        assert_eq!(c.entries.iter().map(|e| e.actions as usize).sum::<usize>(), graph.action_segments.len());
        let played: f32 = bundle.clips().zip(&c.entries).map(|((r, _), e)| e.played * r.num_frames as f32).sum();
        assert_eq!(played.round() as u64, bundle.tables().meta().frames_kept);
        let usable: f32 = bundle.clips().zip(&c.entries).map(|((r, _), e)| e.usable * r.num_frames as f32).sum();
        assert_eq!(usable.round() as u64, bundle.tables().meta().frames_in);
    }
}
