//! The panel, driven as a user does.

use super::*;
use crate::panels::tests::{Trial, trial};
use eframe::egui::vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use std::path::Path;
use throng_planner::task::Handle;

fn panel() -> Harness<'static, Trial<PlanPanelState>> {
    let task = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/tasks/arm-low.toml");
    let mut h = trial::<PlanPanelState>(Some(&task), vec2(420.0, 900.0), show);
    h.state_mut().model.is_unhurried = true;
    let ctx = h.ctx.clone();
    h.state_mut().model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Plan));
    h.run_steps(3);
    h
}

#[test]
fn without_a_task_it_says_what_to_open() {
    let mut h = trial::<PlanPanelState>(None, vec2(400.0, 300.0), show);
    h.run_steps(2);
    h.get_by_label_contains("data/tasks/*.toml");
}

#[test]
fn motions_are_listed_shown_and_told_apart() {
    let mut h = panel();
    h.state_mut().model.selection.plan.num_motions = 2;
    h.run_steps(2);
    h.get_by_label("Plan").click();
    h.run_steps(4);
    let task = h.state().model.document.task().expect("a task");
    assert_eq!((task.motions().len(), task.shown(), task.is_changed()), (2, Some(0), false));
    assert!(task.motions().iter().all(|m| m.report.solved && m.distance_rad.is_some_and(|d| d > 0.0)));
    h.get_by_label("The check finds no fault.");
    let seed = task.motions()[1].seed;
    h.get_by_label_contains(&format!("2 · seed {seed} ·")).click();
    h.run_steps(2);
    assert_eq!(h.state().model.document.task().and_then(TaskDocument::shown), Some(1));
    h.get_by_label("the clip as it was").click();
    h.run_steps(2);
    let task = h.state().model.document.task().expect("a task");
    assert_eq!((task.shown(), task.clip(0)), (None, &task.clips_before()[0]));
}

#[test]
fn what_is_put_elsewhere_is_planned_for_again() {
    let mut h = panel();
    let ctx = h.ctx.clone();
    let clip =
        |h: &Harness<'_, Trial<PlanPanelState>>| h.state().model.document.task().expect("a task").clip(0).clone();
    let (before, handle) = (clip(&h), Handle::Thing(0));
    let place = |h: &Harness<'_, Trial<PlanPanelState>>| {
        let task = h.state().model.document.task().expect("a task");
        task.place_of(handle, 0.0).expect("a place").position
    };
    let was = place(&h);
    let model = |h: &mut Harness<'static, Trial<PlanPanelState>>, c: PlanCommand| {
        h.state_mut().model.apply(&ctx, ViewerCommand::Plan(c))
    };
    model(&mut h, PlanCommand::Move(handle, glam::Vec3::new(0.03, 0.0, 0.1)));
    h.run_steps(2);
    assert!(h.state().model.document.task().is_some_and(TaskDocument::is_changed));
    h.get_by_label_contains("The scene has changed since");
    // What is shown stays as it was planned until there is something new.
    assert_eq!(clip(&h), before);
    model(&mut h, PlanCommand::EndMove);
    h.run_steps(2);
    assert!(place(&h).distance(was + DVec3::new(0.03, 0.0, 0.1)) < 1e-6);
    let task = h.state().model.document.task().expect("a task");
    assert!(!task.is_changed() && task.shown_motion().is_some_and(|m| m.report.recheck_violations == 0));
    assert_ne!(clip(&h), before);
}

#[test]
fn a_motion_is_written_as_the_command_does_and_the_clip_as_it_was_is_not() {
    let mut h = panel();
    let (ctx, folder) = (h.ctx.clone(), tempfile::tempdir().expect("a folder"));
    let out = folder.path().join("a.bvh");
    let model = &mut h.state_mut().model;
    model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Save(out.clone())));
    let written = std::fs::read_to_string(&out).expect("a clip");
    assert!(written.starts_with("HIERARCHY") && model.messages.iter().all(|m| !m.is_error), "{:?}", model.messages);
    model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Save(folder.path().join("a.txt"))));
    model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Show(None)));
    model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Save(folder.path().join("b.bvh"))));
    assert_eq!(model.messages.iter().filter(|m| m.is_error).count(), 2);
    assert!(!folder.path().join("b.bvh").exists());
}

#[test]
fn what_was_put_elsewhere_is_written_into_the_tasks_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("arm.toml");
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/tasks/arm-low.toml"));
    let text = text.expect("a task");
    std::fs::write(&path, &text).expect("a file");
    let mut h = trial::<PlanPanelState>(Some(&path), vec2(420.0, 1500.0), show);
    h.state_mut().model.is_unhurried = true;
    let ctx = h.ctx.clone();
    h.state_mut().model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Plan));
    h.state_mut().model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Move(Handle::Thing(0), glam::Vec3::Z * 0.03)));
    h.state_mut().model.apply(&ctx, ViewerCommand::Plan(PlanCommand::EndMove));
    h.run_steps(3);
    let motion = h.state().model.document.task().and_then(TaskDocument::shown_motion).expect("a motion");
    assert!(motion.report.solved && motion.report.recheck_violations == 0);
    h.state_mut().model.apply(&ctx, ViewerCommand::Plan(PlanCommand::SaveTask(path.clone())));
    h.run_steps(3);
    let written = std::fs::read_to_string(&path).expect("a task");
    let changed: Vec<_> = text.lines().zip(written.lines()).filter(|(a, b)| a != b).collect();
    assert!(changed.len() == 1 && changed[0].0.starts_with("at = ["), "{changed:?}");
    // Its motions stay: it was not read again.
    assert!(h.state().model.document.task().is_some_and(|t| !t.motions().is_empty()));
    // Names in it are seen from its folder.
    let model = &mut h.state_mut().model;
    model.apply(&ctx, ViewerCommand::Plan(PlanCommand::SaveTask(std::env::temp_dir().join("arm.toml"))));
    assert!(model.messages.iter().any(|m| m.is_error && m.text.contains("in the folder of")), "{:?}", model.messages);
}

#[test]
fn a_plan_that_is_cancelled_leaves_the_motions() {
    let mut h = panel();
    let ctx = h.ctx.clone();
    let model = &mut h.state_mut().model;
    let before = model.document.task().expect("a task").clip(0).clone();
    model.is_unhurried = false;
    model.selection.plan.seed = Some(9);
    model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Plan));
    model.apply(&ctx, ViewerCommand::Plan(PlanCommand::Cancel));
    assert!(!model.is_busy());
    model.advance(&ctx, 0.1);
    assert_eq!(*model.document.task().expect("a task").clip(0), before);
}
