use super::*;
use crate::fixtures::meeting::Meeting;
use crate::fixtures::paces::Paces;
use crate::panels::tests::{Trial, click, trial};
use eframe::egui::vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// The panel alone, with a scene that has run for some steps.
fn panel(meeting: &Meeting, steps: i32) -> Harness<'static, Trial<State>> {
    let mut harness = trial(Some(&meeting.scene(12)), vec2(380.0, 1300.0), show);
    let ctx = harness.ctx.clone();
    let model = &mut harness.state_mut().model;
    model.is_unhurried = true;
    model.apply(&ctx, Command::Play(false));
    model.apply(&ctx, Command::Step(steps));
    model.advance(&ctx, 0.0);
    harness.run_steps(3);
    harness
}

#[test]
fn overlays_can_be_switched() {
    let meeting = Meeting::new();
    let mut harness = panel(&meeting, 60);
    for (label, is_done) in [
        ("bounds: all", (|m| m.selection.scene.bounds == crate::command::Whose::All) as fn(&Model) -> bool),
        ("paths: none", |m| m.selection.scene.paths == crate::command::Whose::Nobody),
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
    let last = scene.run().log().last(&[true; crate::run::agents::What::COUNT], f64::INFINITY, 1)[0];
    let name = format!("Event {} {}", last.what.name(), last.agent);
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
