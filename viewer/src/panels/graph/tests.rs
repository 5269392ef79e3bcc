//! The panel, driven as a user does.

use super::*;
pub(super) use crate::fixtures::golden;
use crate::fixtures::golden_path;
use crate::run::RunInput;
use crate::settings::ViewerSettings;
use eframe::egui::{Event, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

struct Panel {
    model: Model,
    state: GraphPanelState,
    commands: Vec<ViewerCommand>,
}
use crate::fixtures::quietly;

fn panel(prepare: impl FnOnce(&mut Model)) -> Harness<'static, Panel> {
    let mut model = Model::new(ViewerSettings::default());
    quietly(|with| model.open_now(&golden_path(), with)).unwrap();
    prepare(&mut model);
    let panel = Panel { model, state: GraphPanelState::default(), commands: Vec::new() };
    Harness::builder()
        .with_size([1200.0, 320.0])
        .build_ui_state(|ui, p: &mut Panel| show(ui, &p.model, &mut p.state, &mut p.commands), panel)
}

fn place_of(h: &Harness<'_, Panel>, state: u32) -> Pos2 {
    let p = h.state();
    let drawn = p.state.drawn.as_ref().unwrap();
    let drawing = GraphDrawing {
        bundle: p.model.document.bundle().unwrap(),
        layout: &drawn.layout,
        links: &drawn.links,
        scale: p.state.view.scale(&drawn.layout, p.state.rect.unwrap()),
        selected: None,
        hovered: None,
        marked: None,
        playing: None,
    };
    drawing.state_place(state).unwrap()
}

fn click_at(h: &mut Harness<'_, Panel>, at: Pos2) {
    h.hover_at(at);
    h.step();
    for pressed in [true, false] {
        h.event(Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE });
        h.step();
    }
}

#[test]
fn a_click_on_a_state_selects_it_and_one_beside_it_none() {
    let mut h = panel(|_| {});
    h.step();
    let at = place_of(&h, 5);
    click_at(&mut h, at);
    assert_eq!(h.state().commands, [ViewerCommand::SelectState(Some(5))]);
    h.state_mut().commands.clear();
    let empty = h.state().state.rect.unwrap().right_bottom() - Vec2::splat(3.0);
    click_at(&mut h, empty);
    assert_eq!(h.state().commands, [ViewerCommand::SelectState(None)]);
}

#[test]
fn a_click_selects_what_was_pressed_though_the_drawing_moves_before_the_release() {
    let mut h = panel(|_| {});
    h.step();
    let at = place_of(&h, 5);
    let top = h.state().state.rect.unwrap().top();
    h.hover_at(at);
    h.step();
    let button =
        |pressed| Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    h.event(button(true));
    h.step();
    // The header is wrapped into more lines.
    h.set_size(Vec2::new(420.0, 320.0));
    h.step();
    assert!(h.state().state.rect.unwrap().top() > top + 10.0);
    h.event(button(false));
    h.step();
    assert_eq!(h.state().commands, [ViewerCommand::SelectState(Some(5))]);
}

#[test]
fn a_click_on_an_action_lets_the_selected_character_play_it() {
    let mut h = panel(|m| {
        m.selection.character = Some(3);
        m.selection.state = Some(7);
    });
    h.step();
    let bundle = golden();
    let segment = outgoing_segments(&bundle, 7)[0];
    h.get_by_label(&format!("Play {}", bundle.describe_segment(segment))).click();
    h.step();
    let commands = &h.state().commands;
    assert_eq!(commands.as_slice(), [ViewerCommand::Input(RunInput::Play { character: 3, segment })]);
}

#[test]
fn without_a_character_a_click_on_an_action_shows_its_motion() {
    let mut h = panel(|m| m.selection.state = Some(7));
    h.step();
    let bundle = golden();
    let segment = outgoing_segments(&bundle, 7)[0];
    h.get_by_label(&format!("Play {}", bundle.describe_segment(segment))).click();
    h.step();
    let s = bundle.tables().graph().segments[segment as usize];
    let frame = s.start - bundle.tables().clips()[s.clip as usize].first_frame;
    assert_eq!(h.state().commands, [ViewerCommand::ShowClip { clip: s.clip as usize, frame }]);
}

/// Segments of a state's actions, the cheapest first, as they are listed at first.
fn outgoing_segments(bundle: &OpenBundle, state: u32) -> Vec<u32> {
    let mut found: Vec<_> = links::outgoing(bundle.tables().graph(), state).collect();
    found.sort_by(|a, b| a.error.total_cmp(&b.error));
    found.iter().map(|l| l.segment).collect()
}

#[test]
fn a_searched_clip_scrolls_into_sight() {
    let bundle = golden();
    let layout = GraphLayout::new(bundle.tables());
    let lane = layout.lanes.last().unwrap();
    let name = bundle.clip_name(lane.clip).to_uppercase();
    let (row, s) = find(&bundle, &layout, &name).unwrap();
    assert!(row == lane.row && (lane.start..=lane.end).contains(&s));
    assert_eq!(find(&bundle, &layout, "no such clip"), None);
    assert_eq!(find(&bundle, &layout, ""), None);
}
