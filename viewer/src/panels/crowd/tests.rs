use super::*;
use crate::command::BlackboardFilter;
use crate::fixtures::market::Market;
use crate::fixtures::meeting::Meeting;
use crate::fixtures::paces::Paces;
use crate::panels::tests::{Trial, click, trial};
use crate::run::agents::{AgentEventKind, EventFilter};
use eframe::egui::vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// The panel alone, with a scene that has run for some steps.
fn panel(meeting: &Meeting, steps: i32) -> Harness<'static, Trial<CrowdPanelState>> {
    let mut harness = trial(Some(&meeting.scene(12)), vec2(380.0, 1300.0), show);
    let ctx = harness.ctx.clone();
    let model = &mut harness.state_mut().model;
    model.is_unhurried = true;
    model.apply(&ctx, ViewerCommand::Play(false));
    model.apply(&ctx, ViewerCommand::Step(steps));
    model.advance(&ctx, 0.0);
    harness.run_steps(3);
    harness
}

#[test]
fn overlays_can_be_switched() {
    let meeting = Meeting::new();
    let mut harness = panel(&meeting, 60);
    for (label, is_done) in [
        ("bounds: all", (|m| m.selection.scene.bounds == crate::command::OverlayScope::All) as fn(&Model) -> bool),
        ("paths: none", |m| m.selection.scene.paths == crate::command::OverlayScope::None),
        ("trails: all", |m| m.settings.overlays.trails && m.settings.overlays.of_all),
        ("cells", |m| !m.selection.scene.cells),
        ("Kind colliding", |m| !m.selection.scene.kinds[1]),
    ] {
        assert!(!is_done(&harness.state().model), "{label}");
        let at = harness.get_by_label(label).rect().center();
        click(&mut harness, at);
        assert!(is_done(&harness.state().model), "{label}");
    }
}

/// The panel with a market that has run for some steps, and an agent of it.
fn market(market: &Market, steps: i32) -> Harness<'static, Trial<CrowdPanelState>> {
    let mut harness = trial(Some(&market.scene(24)), vec2(380.0, 2600.0), show);
    let ctx = harness.ctx.clone();
    let model = &mut harness.state_mut().model;
    model.is_unhurried = true;
    model.apply(&ctx, ViewerCommand::Play(false));
    model.apply(&ctx, ViewerCommand::SelectCharacter(Some(5)));
    model.apply(&ctx, ViewerCommand::Step(steps));
    model.advance(&ctx, 0.0);
    harness.run_steps(3);
    harness
}

fn press(harness: &mut Harness<'static, Trial<CrowdPanelState>>, label: &str) {
    let at = harness.get_by_label(label).rect().center();
    click(harness, at);
    harness.run_steps(2);
}

#[test]
fn graphs_messages_and_boards_of_a_market_are_shown() {
    let place = Market::new();
    let mut harness = market(&place, 240);
    harness.get_by_label("Graph day");
    press(&mut harness, "Message sale");
    assert_eq!(harness.state().model.selection.scene.message, Some(1));
    harness.get_by_label_contains("of 24 know of sale at 4.0 s");
    // Two cells of every teller, and the global board.
    assert!(harness.get_all_by_label_contains("Entry cell").next().is_some());
    harness.get_by_label_contains("Entry global: opening, as it happened at 0.5 s, for 26.5 s more");
    press(&mut harness, "board cells: 4 m");
    assert_eq!(harness.state().model.selection.scene.blackboards, BlackboardFilter::Level(1));
    let entry = harness.get_all_by_label_contains("Entry cell").next().unwrap().rect().center();
    click(&mut harness, entry);
    assert!(harness.state().model.selection.scene.cell.is_some_and(|c| c.level == 1));
    // The agent that wrote it is selected.
    let writer = harness.state().model.selection.character.unwrap();
    let brains = harness.state().model.document.scene().unwrap().run.simulation().brains().unwrap();
    assert!(brains.learnt_event(writer, 1).is_some());
    press(&mut harness, "Happen opening");
    let events = |h: &Harness<'static, Trial<CrowdPanelState>>| h.state().model.selection.scene.kinds;
    press(&mut harness, "without the engine's");
    assert!(!events(&harness)[AgentEventKind::Resetting.number()] && events(&harness)[AgentEventKind::Learnt.number()]);
}

#[test]
fn events_are_filtered_by_message_and_place() {
    let place = Market::new();
    let mut harness = market(&place, 240);
    press(&mut harness, "without the engine's");
    let named =
        |h: &Harness<'static, Trial<CrowdPanelState>>, label: &str| h.query_all_by_label_contains(label).count();
    assert!(named(&harness, "Event edge") > 2);
    harness.state_mut().state.message = Some(0);
    harness.run_steps(2);
    assert!(named(&harness, "Event learnt") > 0 && named(&harness, "Event came") == 0);
    (harness.state_mut().state.message, harness.state_mut().state.place) = (None, Some(0));
    harness.run_steps(2);
    assert!(named(&harness, "Event learnt") == 0 && named(&harness, "Event came") > 0);
}

#[test]
fn bodies_can_be_left_out_where_there_are_some() {
    let meeting = Meeting::new();
    assert!(panel(&meeting, 1).query_by_label("bodies").is_none());
    let paces = Paces::new();
    let mut harness = trial(Some(&paces.crowd(3)), vec2(380.0, 1300.0), show);
    harness.run_steps(3);
    let at = harness.get_by_label("bodies").rect().center();
    click(&mut harness, at);
    assert!(!harness.state().model.selection.scene.bodies);
}

#[test]
fn a_click_on_an_event_selects_its_agent_and_shows_its_forces() {
    let meeting = Meeting::new();
    let mut harness = panel(&meeting, 90);
    assert!(harness.query_by_label("driving").is_none());
    let scene = harness.state().model.document.scene().unwrap();
    let last = scene.run.log.last(&EventFilter::of_kinds([true; AgentEventKind::COUNT]), f64::INFINITY, 1)[0];
    let name = format!("Event {} {}", last.kind.name(), last.agent);
    let at = harness.get_all_by_label(&name).next().unwrap().rect().center();
    click(&mut harness, at);
    harness.run_steps(2);
    assert_eq!(harness.state().model.selection.character, Some(last.agent));
    for term in ["driving", "interaction", "decelerating", "damping", "turning", "safety", "sum", "taken"] {
        harness.get_by_label(term);
    }
    let at = harness.get_by_label("of the selected agent only").rect().center();
    click(&mut harness, at);
    assert!(harness.state().state.only_selected);
    assert!(harness.get_all_by_label(&name).next().is_some());
}
