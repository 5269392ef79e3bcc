//! The database browser: clips, and a timeline of the selected one.

mod lanes;
mod list;
mod strip;
mod timeline;
mod track;

use super::paint::{TableSort, no_bundle, time_text};
use crate::command::{Commands, ViewerCommand};
use crate::document::{OpenDocument, RawMotion};
use crate::{bundle::OpenBundle, model::Model, panels::graph::list::show_actions, panels::show_segment};
use crate::{panels::words::counted, theme::ThemePalette};
use eframe::egui::{Button, CentralPanel, Frame, Label, Panel, RichText, ScrollArea, Ui};
use strip::PoseSource;
use timeline::{TimelineInput, TimelineView};
use track::TimelineTrack;

/// Width from which on the actions lie beside the timeline (points).
const WIDE: f32 = 820.0;

/// View settings of the panel, and cached results.
#[derive(Clone, Debug, Default)]
pub struct DatabasePanelState {
    list: list::ClipListState,
    view: TimelineView,
    track: Option<(u64, usize, TimelineTrack)>,
    highlighted: Option<u32>,
    /// Order of the actions; none until one was asked for.
    sort: Option<TableSort>,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut DatabasePanelState, commands: &mut Commands) {
    match (&model.document, model.document.bundle()) {
        (OpenDocument::Clip(raw), _) => raw_view(ui, raw, model, state, commands),
        (_, Some(_)) => bundle_view(ui, model, state, commands),
        (document, None) => no_bundle(ui, document),
    }
}

fn bundle_view(ui: &mut Ui, model: &Model, state: &mut DatabasePanelState, commands: &mut Commands) {
    let Some(bundle) = model.document.bundle() else { return };
    let (document, clip) = (model.generation, model.selection.clip);
    Panel::left("clips").default_size(430.0).min_size(300.0).frame(Frame::NONE.inner_margin(4)).show(ui, |ui| {
        list::show(ui, &mut state.list, model, bundle, commands);
    });
    if state.track.as_ref().is_none_or(|t| (t.0, t.1) != (document, clip)) {
        state.track = TimelineTrack::from_bundle(bundle, clip).map(|t| (document, clip, t));
    }
    let Some((_, _, track)) = &state.track else { return };
    let head = (model.player.frame as u32).min(track.num_frames - 1);
    let (source, highlighted) = (PoseSource::Bundle(bundle, clip), state.highlighted);
    let scene = TimelineInput { document, track, source, next_state: track.state_from(head), highlighted, head };
    let wide = ui.available_width() >= WIDE;
    let actions =
        if wide { Panel::right("actions").default_size(460.0) } else { Panel::bottom("actions").default_size(90.0) };
    actions.min_size(60.0).frame(Frame::NONE.inner_margin(4)).show(ui, |ui| {
        state.highlighted = show_next_actions(ui, bundle, &scene, &mut state.sort, commands);
    });
    let goes_to = clip_view(ui, &scene, &mut state.view);
    commands.extend(goes_to.map(|frame| ViewerCommand::ShowClip { clip, frame }));
}

fn raw_view(ui: &mut Ui, raw: &RawMotion, model: &Model, state: &mut DatabasePanelState, commands: &mut Commands) {
    let document = model.generation;
    if state.track.as_ref().is_none_or(|t| (t.0, t.1) != (document, 0)) {
        state.track = TimelineTrack::from_raw(raw).map(|t| (document, 0, t));
    }
    let Some((_, _, track)) = &state.track else { return };
    // The player counts frames of the file.
    let step = raw.imported.clip.rate_hz / f64::from(track.rate_hz);
    let head = ((f64::from(model.player.frame) / step).round() as u32).min(track.num_frames - 1);
    let scene =
        TimelineInput { document, track, source: PoseSource::Raw(raw), next_state: None, highlighted: None, head };
    let goes_to = clip_view(ui, &scene, &mut state.view);
    commands.extend(goes_to.map(|frame| ViewerCommand::Seek((f64::from(frame) * step).round() as u32)));
}

/// Shows a description of a clip, and its timeline.
fn clip_view(ui: &mut Ui, scene: &TimelineInput<'_>, view: &mut TimelineView) -> Option<u32> {
    let shown = CentralPanel::default_margins().frame(Frame::NONE.inner_margin(4)).show(ui, |ui| {
        header(ui, scene, view);
        let area = ScrollArea::vertical().id_salt("timeline").auto_shrink([false, false]);
        area.show(ui, |ui| timeline::show(ui, scene, view)).inner
    });
    shown.inner
}

fn header(ui: &mut Ui, scene: &TimelineInput<'_>, view: &mut TimelineView) {
    let track = scene.track;
    ui.horizontal(|ui| {
        let fit = Button::new("Fit").small();
        let hint = "Show all of the clip. Scroll to zoom, drag with the right button to move.";
        if ui.add_enabled(view.span.is_some(), fit).on_hover_text(hint).on_disabled_hover_text(hint).clicked() {
            view.span = None;
        }
        ui.strong(&track.name);
        let here = format!("at {:.2} s, frame {}", scene.head as f32 / track.rate_hz, scene.head);
        ui.label(RichText::new(here).color(ThemePalette::for_visuals(ui.visuals()).head));
        let mirrored = if track.mirrored { "mirrored, " } else { "" };
        let (frames, rate, time) = (track.num_frames, track.rate_hz, time_text(track.duration_s()));
        let facts = format!("{mirrored}{frames} frames at {rate} Hz, {time}, from {}", track.source);
        ui.add(Label::new(RichText::new(facts).weak()).truncate());
    });
}

/// Shows the actions; a click shows where one leads.
///
/// - `sort`: order, none until one was asked for.
/// - returns the segment that is pointed at.
fn show_next_actions(
    ui: &mut Ui,
    bundle: &OpenBundle,
    scene: &TimelineInput<'_>,
    sort: &mut Option<TableSort>,
    commands: &mut Commands,
) -> Option<u32> {
    let Some(from) = scene.next_state else {
        ui.strong("Actions from here");
        ui.label(RichText::new("No state of the motion graph follows in this clip: no character passes here.").weak());
        return None;
    };
    let wait = from.frame.saturating_sub(scene.head);
    let graph = bundle.tables().graph();
    ui.horizontal_wrapped(|ui| {
        ui.strong(counted(graph.segments_of(from.state).len(), "action"));
        let standing = if from.standing { ", standing" } else { "" };
        let when = if wait == 0 { "here".to_owned() } else { format!("in {wait} frames") };
        let text = format!("of state {}{standing}, {when}", from.state);
        let response = ui.link(text).on_hover_text("Select this state, and go to its frame");
        if response.clicked() {
            commands.push(ViewerCommand::SelectState(Some(from.state)));
            let row = graph.states[from.state as usize].frame;
            commands.push(ViewerCommand::ShowClip { clip: bundle.clip_of(row), frame: from.frame });
        }
    });
    let touched = show_actions(ui, bundle, from.state, "Go to", sort);
    commands.extend(touched.chosen.map(|segment| show_segment(bundle, segment)));
    touched.hovered
}

#[cfg(test)]
mod tests;
