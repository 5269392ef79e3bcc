//! Blend spaces and scenes of walkers in the real app, driven as people drive it.

use crate::common::Viewing;
use crate::common::paces::Paces;
use eframe::egui::{Key, Pos2, pos2};
use egui_kittest::kittest::Queryable;
use throng_core::NUM_JOINTS;
use throng_viewer::command::{SceneCommand, ViewStage, ViewerCommand};
use throng_viewer::document::SceneChoice;
use throng_viewer::run::{BlendRun, Blending};
use throng_viewer::settings::PanelKind;

fn run(v: &Viewing) -> &BlendRun {
    v.model().document.blend().expect("a walker").1
}

fn blending(v: &Viewing) -> Blending {
    *run(v).blending()
}

/// A place on the map, from its lower left corner; the edges that numbers stand at are left out.
fn on_map(v: &Viewing, right: f32, up: f32) -> Pos2 {
    let rect = v.harness.get_by_label("Parameter space").rect();
    pos2(rect.left() + (0.15 + 0.8 * right) * rect.width(), rect.bottom() - (0.15 + 0.8 * up) * rect.height())
}

#[test]
fn a_bundle_with_blend_spaces_only_opens_with_a_character_that_follows_the_point() {
    let paces = Paces::new();
    let mut v = Viewing::of(&paces.bundle());
    v.harness.run_steps(5);
    let m = v.model();
    assert!(m.document.scene().is_none() && m.shown_stage() == ViewStage::Blend && m.is_playing());
    assert_eq!(m.settings.side_panel, Some(PanelKind::Blend));
    assert_eq!(m.stages(), [ViewStage::Blend, ViewStage::Clip]);

    let before = blending(&v).point;
    let (from, to) = (on_map(&v, 0.5, 0.6), on_map(&v, 0.2, 0.9));
    v.drag(from, to);
    let after = blending(&v).point;
    // Faster, and to the left, which is positive.
    assert!(after[0] > before[0] + 0.1 && after[1] > before[1] + 0.2, "{before:?} became {after:?}");
    let camera = v.model().settings.camera.target;
    let (then, heading) = (run(&v).reel.head.shown_step(), run(&v).reel.moment().roots[0].heading);
    v.harness.run_steps(90);
    let steps = run(&v).reel.head.shown_step() - then;
    let turned = run(&v).reel.moment().roots[0].heading - heading;
    let wanted = after[1] * steps as f32 / 60.0;
    assert!(steps > 60 && (turned - wanted).abs() < 0.25, "turned by {turned}, expected {wanted}");
    assert!(run(&v).reel.moment().point.iter().zip(after).all(|(a, b)| (a - b).abs() < 0.02));
    assert!(v.model().settings.camera.target.distance(camera) > 0.5, "the camera stays behind");
    assert!(v.has_no_errors(), "{:?}", v.model().messages);
}

#[test]
fn a_stopped_walk_rewinds_and_shows_another_blend_at_the_same_time() {
    let paces = Paces::new();
    let mut v = Viewing::of(&paces.bundle());
    v.harness.run_steps(60);
    v.harness.get_by_label("Pause").click();
    v.harness.run_steps(2);
    let (last, seen) = (run(&v).reel.head.shown_step(), run(&v).reel.moment().clone());
    v.apply(ViewerCommand::Step(-20));
    v.harness.run_steps(2);
    assert!(run(&v).reel.moment().poses != seen.poses);
    v.apply(ViewerCommand::Seek(u32::MAX));
    assert!(run(&v).reel.head.shown_step() == last && run(&v).reel.moment().poses == seen.poses);

    let (from, to) = (on_map(&v, 0.5, 0.5), on_map(&v, 0.5, 0.05));
    v.drag(from, to);
    let now = run(&v).reel.moment();
    assert!(now.phase == seen.phase && now.poses != seen.poses && run(&v).reel.head.shown_step() == last);
    // The map has the keys now: arrows move the point, not time.
    let slow = blending(&v).point;
    v.harness.key_press(Key::ArrowRight);
    v.harness.run_steps(3);
    let moved = blending(&v).point;
    assert!(moved[1] < slow[1] && run(&v).reel.head.shown_step() == last, "{slow:?} became {moved:?}");

    v.harness.key_press(Key::C);
    v.harness.run_steps(3);
    assert_eq!(v.model().shown_stage(), ViewStage::Clip);
    v.harness.key_press(Key::C);
    v.harness.run_steps(3);
    assert_eq!(v.model().shown_stage(), ViewStage::Blend);
    v.apply(ViewerCommand::Restart);
    assert_eq!(run(&v).reel.head.shown_step(), 0);
    assert!(v.has_no_errors(), "{:?}", v.model().messages);
}

#[test]
fn a_reloaded_bundle_of_blend_spaces_keeps_the_point() {
    let paces = Paces::new();
    let mut v = Viewing::of(&paces.bundle());
    v.harness.run_steps(3);
    let mut wanted = blending(&v);
    (wanted.point[0], wanted.size) = (0.9, 0.8);
    v.apply(ViewerCommand::Blend(wanted));
    v.apply(ViewerCommand::Reload);
    v.until("the bundle again", |v| v.model().messages.iter().any(|m| m.text.contains("was reloaded")));
    assert_eq!(blending(&v), wanted);
    assert!(v.model().is_playing());
}

#[test]
fn a_scene_of_walkers_plays_rewinds_and_restarts() {
    let paces = Paces::new();
    let mut v = Viewing::of(&paces.scene(9, 0.0));
    v.harness.run_steps(80);
    let now = |v: &Viewing| v.model().head().expect("a head").shown_step();
    let joints = |v: &Viewing| {
        let simulation = v.model().document.scene().expect("a scene").run.simulation();
        (0..9).filter_map(|who| simulation.joint_positions(who)).flatten().collect::<Vec<_>>()
    };
    let (last, seen) = (now(&v), joints(&v));
    assert!(last > 60 && seen.len() == 9 * NUM_JOINTS);
    assert_eq!((v.model().num_characters(), v.model().stages()), (9, vec![ViewStage::Crowd, ViewStage::Clip]));
    v.apply(ViewerCommand::Play(false));
    v.apply(ViewerCommand::Seek(10));
    v.harness.run_steps(2);
    assert!(joints(&v) != seen);
    v.apply(ViewerCommand::Seek(last));
    assert!(joints(&v) == seen);

    v.apply(ViewerCommand::SelectCharacter(Some(4)));
    v.harness.run_steps(2);
    assert_eq!(v.model().selection.character, Some(4));
    let choice = SceneChoice { characters: 3, seed: 5, ..v.model().document.scene().expect("a scene").choice };
    v.apply(ViewerCommand::Scene(SceneCommand::Restart(choice)));
    v.until("three walkers", |v| v.model().num_characters() == 3);
    assert_eq!(v.model().selection.character, None);
    v.apply(ViewerCommand::Restart);
    v.until("the start", |v| v.model().document.scene().is_some_and(|s| s.num_runs == 2));
    assert_eq!(now(&v), 0);
    // All panels have something to say of it.
    for panel in throng_viewer::panels::PANELS {
        v.apply(ViewerCommand::TogglePanel(panel.kind));
        v.harness.run_steps(2);
    }
    assert!(v.has_no_errors(), "{:?}", v.model().messages);
}

#[test]
fn who_walks_in_a_blend_space_is_steered_with_keys() {
    use throng_core::blend::axis;
    let paces = Paces::new();
    let mut v = Viewing::of(&paces.bundle());
    v.key(Key::G, true);
    v.key(Key::G, false);
    let (bundle, _) = v.model().document.blend().expect("a blend space");
    let axes = bundle.blend(blending(&v).space).expect("a space").axes().to_vec();
    let of = |kind: u32| axes.iter().position(|a| a.kind == kind);
    let speed = of(axis::SPEED).expect("a speed");
    v.key(Key::W, true);
    let walks = blending(&v).point[speed];
    v.harness.run_steps(60);
    v.key(Key::W, false);
    let stands = blending(&v).point[speed];
    assert!(walks > stands && stands <= axes[speed].low.max(0.0), "{walks} and {stands}");
    let turn = of(axis::GYRATION).expect("turning");
    v.key(Key::A, true);
    assert!(blending(&v).point[turn] > 0.0);
    v.harness.run_steps(60);
    let lags = &v.model().steering().expect("somebody").lags;
    println!("frames from key to change: {:?}", lags.median_and_p95());
    assert!(lags.count().0 > 0 && lags.last() >= Some(1));
}
