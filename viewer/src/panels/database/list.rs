//! The list of clips, with a search field.

use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::{RowTable, TableCell, TableColumn, TableSort, time_text};
use crate::{bundle::OpenBundle, model::Model};
use eframe::egui::{Button, Label, RichText, TextEdit, Ui};
use std::{cmp::Ordering, collections::BTreeSet, ops::Range};
use throng_core::format::{ClipMeta, ClipRecord};
use throng_precompute::abilities::played_frames;

/// Columns; that of tags is the last one, so that it can be left out.
const COLUMNS: [TableColumn<'static>; 7] = [
    TableColumn::text("Clip", "Name; copies with left and right exchanged are dimmed and end in ~mirror", 100.0, 3.0),
    TableColumn::number("Length", "Duration", 62.0),
    TableColumn::number("Usable", "Share of the frames that are not left out", 52.0).spare(1),
    TableColumn::number("Played", "Share of the frames that the motion graph plays", 52.0).spare(1),
    TableColumn::number("States", "States of the motion graph that lie in the clip", 48.0).spare(2),
    TableColumn::number("Actions", "Actions that leave these states", 54.0).spare(2),
    TableColumn::text("Tags", "Names of its tags", 48.0, 1.0),
];

/// State of the list.
#[derive(Clone, Debug, Default)]
pub struct ClipListState {
    query: String,
    sort: TableSort,
    /// Key of the rows: document, query, order.
    made_of: Option<(u64, String, TableSort)>,
    catalogue: ClipCatalogue,
    rows: Vec<usize>,
    shown: Option<usize>,
}

impl ClipListState {
    /// Numbers of the clips that are listed, in order.
    #[cfg(test)]
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Rebuilds the rows if something has changed.
    fn refresh(&mut self, document: u64, bundle: &OpenBundle) {
        let now = (document, self.query.clone(), self.sort);
        if self.made_of.as_ref() == Some(&now) {
            return;
        }
        if self.made_of.as_ref().map(|m| m.0) != Some(document) {
            self.catalogue = ClipCatalogue::from_bundle(bundle);
            self.shown = None;
        }
        self.rows = self.catalogue.select(&self.query, self.sort);
        self.made_of = Some(now);
    }
}

/// Shows the list.
pub fn show(ui: &mut Ui, state: &mut ClipListState, model: &Model, bundle: &OpenBundle, commands: &mut Commands) {
    let selected = model.selection.clip;
    state.refresh(model.generation, bundle);
    search(ui, state);
    if state.rows.is_empty() {
        ui.add_space(12.0);
        ui.vertical_centered(|ui| {
            ui.label(format!("No clip matches \"{}\".", state.query.trim()));
            ui.label(RichText::new("Every word is looked for in names, tags and source files.").weak());
        });
        return;
    }
    let has_tags = state.catalogue.entries.iter().any(|e| !e.tags.is_empty());
    let columns = if has_tags { &COLUMNS[..] } else { &COLUMNS[..COLUMNS.len() - 1] };
    let table = RowTable {
        selected: state.rows.iter().position(|r| *r == selected),
        sort: Some(state.sort),
        scroll_to_selected: state.shown != Some(selected),
        ..RowTable::new("clips", columns, state.rows.len())
    };
    let response = table.show(ui, |row, column| cell(&state.catalogue.entries[state.rows[row]], column));
    state.shown = Some(selected);
    state.sort = response.sort.unwrap_or(state.sort);
    commands.extend(response.chosen.map(|row| ViewerCommand::ShowClip { clip: state.rows[row], frame: 0 }));
}

fn search(ui: &mut Ui, state: &mut ClipListState) {
    ui.horizontal(|ui| {
        let (listed, total) = (state.rows.len(), state.catalogue.entries.len());
        let count = if listed == total { format!("{total} clips") } else { format!("{listed} of {total}") };
        let name = ui.label("Search");
        let width = (ui.available_width() - 120.0).max(60.0);
        let edit = TextEdit::singleline(&mut state.query).hint_text("name, tag, source").desired_width(width);
        ui.add(edit).labelled_by(name.id);
        let clear = Button::new("Clear").small();
        if ui.add_enabled(!state.query.is_empty(), clear).on_hover_text("Clear the search").clicked() {
            state.query.clear();
        }
        ui.add(Label::new(RichText::new(count).weak()).truncate());
    });
}

/// A clip in a column, which [`COLUMNS`] numbers.
fn cell(entry: &CatalogueClip, column: usize) -> TableCell {
    let share = |v: f32, weak| TableCell { text: format!("{:.0} %", 100.0 * v), weak, ..TableCell::default() };
    let count = |n: u32| if n == 0 { TableCell::weak("0") } else { TableCell::new(n.to_string()) };
    match column {
        0 if entry.mirrored => TableCell::weak(&entry.name).ending(),
        0 => TableCell::new(&entry.name).ending(),
        1 => TableCell::new(time_text(entry.duration_s)),
        2 => share(entry.usable, entry.usable >= 1.0),
        3 => share(entry.played, entry.played <= 0.0),
        4 => count(entry.states),
        5 => count(entry.actions),
        _ => TableCell::new(&entry.tags),
    }
}

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
