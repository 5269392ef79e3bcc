//! Tasks of limbs in the viewer: dropped on the window, planned beside it, dragged with the mouse, scrubbed.

use crate::common::{Viewing, drop_files};
use eframe::egui::{Pos2, vec2};
use glam::Vec3;
use std::path::PathBuf;
use throng_planner::task::Handle;
use throng_viewer::args::{Args, PanelChoice};
use throng_viewer::command::{PlanCommand, ViewerCommand};
use throng_viewer::settings::PanelKind;

fn file(name: &str) -> PathBuf {
    PathBuf::from("../data/tasks").join(name)
}

/// At rest, planned.
fn planned(v: &mut Viewing) {
    v.until("a motion", |v| v.model().document.task().is_some_and(|t| t.planning.is_none() && !t.motions().is_empty()));
    v.apply(ViewerCommand::Play(false));
    v.harness.run_steps(3);
}

fn opened(name: &str) -> Viewing {
    let args = Args { file: Some(file(name)), panel: vec![PanelChoice::Open(PanelKind::Plan)], ..Args::default() };
    let mut v = Viewing::new(&args, vec2(1100.0, 760.0));
    planned(&mut v);
    v.apply(ViewerCommand::FrameAll);
    v.harness.run_steps(3);
    v
}

fn drag(v: &mut Viewing, from: Pos2, to: Pos2) {
    v.harness.hover_at(from);
    v.harness.run_steps(2);
    v.press(from, true);
    // Far enough that it is no click, and back to where it is to be.
    for at in [from + vec2(30.0, 0.0), from + vec2(30.0, 6.0), to] {
        v.harness.hover_at(at);
        v.harness.run_steps(2);
    }
}

#[test]
fn an_obstacle_is_dragged_and_the_limb_is_planned_anew() {
    let mut v = opened("arm-low.toml");
    let at = |v: &Viewing| v.model().document.task().expect("a task").place_of(Handle::Thing(0), 0.0).expect("a place");
    let clip = |v: &Viewing| v.model().document.task().expect("a task").clip(0).clone();
    let (was, before) = (at(&v).position.as_vec3(), clip(&v));
    // Anywhere on the post, not at its foot alone.
    let high = was + Vec3::Y * 0.6;
    let (from, to) = (v.on_screen(high), v.on_screen(high + Vec3::new(0.02, 0.0, 0.08)));
    drag(&mut v, from, to);
    assert_eq!(v.model().selection.plan.handle, Some(Handle::Thing(0)));
    assert!(
        v.model().document.task().is_some_and(|t| t.is_changed() && t.planning.is_none()),
        "not before it is let go"
    );
    v.press(to, false);
    planned(&mut v);
    let moved = at(&v).position.as_vec3() - was;
    assert!(moved.y.abs() < 1e-4 && moved.distance(Vec3::new(0.02, 0.0, 0.08)) < 0.03, "{moved}");
    let task = v.model().document.task().expect("a task");
    let motion = task.shown_motion().expect("a motion");
    assert!(!task.is_changed() && motion.report.solved && motion.report.recheck_violations == 0, "{:?}", motion.report);
    assert_ne!(clip(&v), before);
}

#[test]
fn the_place_of_a_thing_is_dragged_and_it_is_brought_there() {
    let mut v = opened("together.toml");
    let task = v.model().document.task().expect("a task");
    let place = task.task().handles().into_iter().find(|h| matches!(h, Handle::Place(_))).expect("a place");
    let time_s = v.model().task_time_s();
    let was = task.place_of(place, time_s).expect("a place").position.as_vec3();
    let (from, to) = (v.on_screen(was), v.on_screen(was + Vec3::new(0.0, 0.0, 0.03)));
    drag(&mut v, from, to);
    assert_eq!(v.model().selection.plan.handle, Some(place));
    v.press(to, false);
    planned(&mut v);
    let task = v.model().document.task().expect("a task");
    let there = task.place_of(place, time_s).expect("a place").position.as_vec3();
    assert!(there.distance(was) > 0.005 && there.distance(was) < 0.1, "{there} {was}");
    assert!(task.shown_motion().is_some_and(|m| m.report.recheck_violations == 0));
}

#[test]
fn a_task_is_dropped_played_scrubbed_and_cancelled() {
    let mut v = Viewing::empty();
    drop_files(&mut v, &[&file("ring.toml")]);
    v.until("the task", |v| v.model().document.task().is_some());
    planned(&mut v);
    assert_eq!(v.model().settings.side_panel, Some(PanelKind::Plan));
    let (frames, rate_hz) = v.model().shown_clip().expect("a clip");
    assert_eq!((frames, rate_hz), v.model().document.task().expect("a task").frames());
    v.apply(ViewerCommand::Seek(60));
    assert!((v.model().task_time_s() - 60.0 / f64::from(rate_hz)).abs() < 1e-6);
    let before = v.model().document.task().expect("a task").clip(0).clone();
    v.apply(ViewerCommand::Plan(PlanCommand::Plan));
    v.apply(ViewerCommand::Plan(PlanCommand::Cancel));
    v.harness.run_steps(3);
    let task = v.model().document.task().expect("a task");
    assert!(task.planning.is_none() && *task.clip(0) == before);
    // The thing in the hand is where the hand is; it goes back where it lay where the clip is shown as it was.
    let cube = task.task().things.iter().position(|t| t.is_object).expect("a cube");
    let carried = task.place_of_thing(cube, 3.0);
    v.apply(ViewerCommand::Plan(PlanCommand::Show(None)));
    let task = v.model().document.task().expect("a task");
    assert!(task.place_of_thing(cube, 3.0).position.distance(carried.position) > 0.05);
    v.apply(ViewerCommand::Close);
    v.harness.run_steps(3);
    assert!(v.model().document.task().is_none());
}
