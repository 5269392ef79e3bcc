use super::*;
use crate::fixtures::meeting::Meeting;
use crate::panels::tests::{Trial, click, trial};
use eframe::egui::vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

#[test]
fn a_scene_is_restarted_saved_and_restored() {
    let meeting = Meeting::new();
    let mut harness = trial(Some(&meeting.scene(12)), vec2(380.0, 900.0), show);
    let ctx = harness.ctx.clone();
    let model = &mut harness.state_mut().model;
    model.is_unhurried = true;
    model.apply(&ctx, ViewerCommand::Play(false));
    model.apply(&ctx, ViewerCommand::Step(30));
    harness.run_steps(3);
    let press = |harness: &mut Harness<'static, Trial<SceneControlState>>, label: &str| {
        let at = harness.get_by_label(label).rect().center();
        click(harness, at);
    };
    let time = |harness: &Harness<'static, Trial<SceneControlState>>| {
        harness.state().model.document.scene().unwrap().run.simulation().time_s()
    };
    press(&mut harness, "Save");
    assert!(meeting.folder().join("meeting.state").exists());
    press(&mut harness, "Restart");
    assert_eq!(time(&harness), 0.0);
    press(&mut harness, "Restore");
    assert!((time(&harness) - 0.5).abs() < 1e-9);
}
