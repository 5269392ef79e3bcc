//! The motion graph: segments along the time of their clips, states between them, and the links of a state.

mod draw;
mod layout;
pub(super) mod links;
pub(super) mod list;
mod view;

use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::{PanelWidget, TableSort, legend};
use crate::theme::{ThemePalette, viridis};
use crate::{bundle::OpenBundle, model::Model, panels::clip_frame};
use draw::GraphDrawing;
use eframe::egui::{Align, CursorIcon, Layout as UiLayout, Rect, Response, Role, Sense, TextEdit, Ui, UiBuilder, Vec2};
use layout::GraphLayout;
use links::{ActionLinks, GraphFacts};
use view::GraphView;

/// Motion shown around a clip that is searched (s).
const AROUND_S: f32 = 8.0;

/// Results computed once for a bundle.
#[derive(Clone, Debug)]
struct DrawnGraph {
    /// Generation of the document.
    document: u64,
    layout: GraphLayout,
    links: ActionLinks,
    facts: GraphFacts,
}

/// View settings of the graph.
#[derive(Clone, Debug, Default)]
pub struct GraphPanelState {
    drawn: Option<DrawnGraph>,
    view: GraphView,
    /// Order of the actions of a state; none until one was asked for.
    sort: Option<TableSort>,
    search: String,
    follow: bool,
    /// Segment that stands out since the last frame.
    marked: Option<u32>,
    /// Segment whose row is under the pointer in this frame.
    hovered_action: Option<u32>,
    /// State that was under the pointer when the button was pressed.
    pressed: Option<u32>,
    /// Where the drawing was shown last.
    rect: Option<Rect>,
}

/// Shows the motion graph of the open bundle.
pub fn show(ui: &mut Ui, model: &Model, state: &mut GraphPanelState, commands: &mut Commands) {
    let Some(bundle) = model.document.bundle() else {
        return drop(ui.weak("A motion graph is part of a bundle; open one to see it."));
    };
    if bundle.tables().graph().states.is_empty() {
        return drop(ui.weak("This bundle has no motion graph."));
    }
    if state.drawn.as_ref().is_none_or(|d| d.document != model.generation) {
        let (document, tables) = (model.generation, bundle.tables());
        let (links, facts) = (ActionLinks::new(tables.graph()), GraphFacts::new(tables));
        state.drawn = Some(DrawnGraph { document, layout: GraphLayout::new(tables), links, facts });
        state.view = GraphView::default();
    }
    show_header(ui, bundle, state);
    state.marked = state.hovered_action.take();
    let looked_at = model.inspected_state().filter(|&s| (s as usize) < bundle.tables().graph().states.len());
    let rest = ui.available_rect_before_wrap();
    let list_width = if looked_at.is_some() { list::width().min(0.5 * rest.width()) } else { 0.0 };
    let (drawing, side) = rest.split_left_right_at_x(rest.right() - list_width);
    show_drawing(ui, drawing, model, state, commands);
    if let Some(looked_at) = looked_at {
        let side = side.shrink2(Vec2::new(8.0, 0.0));
        let builder = UiBuilder::new().max_rect(side).layout(UiLayout::top_down(Align::Min));
        ui.scope_builder(builder, |ui| list::show(ui, model, looked_at, state, commands));
    }
}

fn show_header(ui: &mut Ui, bundle: &OpenBundle, state: &mut GraphPanelState) {
    let GraphPanelState { drawn, view, search, follow, rect, .. } = state;
    let Some(drawn) = drawn else { return };
    ui.horizontal_wrapped(|ui| {
        drawn.facts.show(ui);
        ui.separator();
        if ui.button("Fit").on_hover_text("Show all of the graph").clicked() {
            *view = GraphView::default();
        }
        ui.checkbox(follow, "Follow").on_hover_text("Keep the segment of the selected character in sight");
        let edit = TextEdit::singleline(search).id_salt("find clip").hint_text("find clip").desired_width(110.0);
        let searched = ui.add(edit).changed();
        if searched && let (Some(rect), Some(found)) = (*rect, find(bundle, &drawn.layout, search)) {
            view.show(&drawn.layout, rect, found, AROUND_S);
        }
        ui.end_row();
        let dark = ui.visuals().dark_mode;
        let most = drawn.links.max_plays as f32;
        legend(ui, [0.0, most], "bars: played by", |t| viridis::line(t.sqrt(), dark));
        legend(ui, [0.0, drawn.links.max_error], "links: error", |t| viridis::line(t, dark));
        let palette = ThemePalette::for_visuals(ui.visuals());
        ui.colored_label(palette.incoming, "links in");
        ui.colored_label(palette.standing, "standing");
    });
}

/// Place of the first used clip with a name that contains a text.
fn find(bundle: &OpenBundle, layout: &GraphLayout, text: &str) -> Option<(usize, f32)> {
    let text = text.trim().to_lowercase();
    let is_meant = |clip: usize| bundle.clip_name(clip).to_lowercase().contains(&text);
    let lane = layout.lanes.iter().find(|l| !text.is_empty() && is_meant(l.clip))?;
    Some((lane.row, 0.5 * (lane.start + lane.end).min(2.0 * lane.start + AROUND_S)))
}

fn show_drawing(ui: &mut Ui, rect: Rect, model: &Model, state: &mut GraphPanelState, commands: &mut Commands) {
    ui.advance_cursor_after_rect(rect);
    // A fixed name keeps the widget's identity, whatever is shown above it.
    let response = ui.interact(rect, ui.scope_id().with("drawing"), Sense::click_and_drag());
    let response = response.named(Role::Canvas, "Motion graph");
    let (Some(bundle), Some(drawn)) = (model.document.bundle(), &state.drawn) else { return };
    state.rect = Some(rect);
    state.view.interact(ui, &drawn.layout, &response);
    let chooser = model.selection.character.and_then(|c| model.document.chooser(c));
    let playing = chooser.map(|c| c.characters.segment(c.number));
    if let Some((segment, frames)) = playing.filter(|_| state.follow) {
        let bar = drawn.layout.bar(segment);
        let row = drawn.layout.lanes[bar.lane as usize].row;
        state.view.centre(&drawn.layout, rect, (row, drawn.layout.moment(bar, frames)));
    }
    let mut drawing = GraphDrawing {
        bundle,
        layout: &drawn.layout,
        links: &drawn.links,
        scale: state.view.scale(&drawn.layout, rect),
        selected: model.inspected_state(),
        hovered: None,
        marked: state.marked,
        playing,
    };
    drawing.hovered = response.hover_pos().and_then(|p| drawing.state_at(p));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    drawing.paint(ui, &painter);
    // The drawing may move under the pointer before the button is released.
    if response.contains_pointer() && ui.input(|i| i.pointer.primary_pressed()) {
        state.pressed = drawing.hovered;
    }
    if response.clicked() && response.interact_pointer_pos().is_some() {
        commands.push(ViewerCommand::SelectState(state.pressed.take()));
    }
    show_tooltip(response, &drawing);
}

/// Shows a tooltip about the state or segment under the pointer.
fn show_tooltip(response: Response, drawing: &GraphDrawing<'_>) {
    let Some(point) = response.hover_pos().filter(|_| !response.dragged()) else { return };
    let (bundle, graph) = (drawing.bundle, drawing.bundle.tables().graph());
    if let Some(state) = drawing.hovered {
        let record = graph.states[state as usize];
        let (clip, frame) = clip_frame(bundle, record.frame);
        response.on_hover_cursor(CursorIcon::PointingHand).on_hover_ui_at_pointer(|ui| {
            let standing = if record.standing != 0 { ", standing" } else { "" };
            ui.strong(format!("State {state}{standing}"));
            ui.label(format!("{} {frame}", bundle.clip_name(clip)));
            let (out, into) = (graph.segments_of(state).len(), drawing.links.incoming[state as usize].len());
            ui.label(format!("{out} actions, {into} lead here"));
        });
    } else if let Some(segment) = drawing.segment_at(point) {
        response.on_hover_ui_at_pointer(|ui| {
            let record = &graph.segments[segment as usize];
            ui.strong(bundle.describe_segment(segment));
            let plays = drawing.links.plays[segment as usize];
            let seconds = record.num_frames as f32 / bundle.rate_hz();
            ui.label(format!("{seconds:.2} s, leads to state {}; {plays} actions play it", record.end));
        });
    }
}

#[cfg(test)]
mod tests;
