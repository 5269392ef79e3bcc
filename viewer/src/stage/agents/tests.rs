use super::super::scene::pick;
use super::*;
use crate::command::{SceneCommand, SceneViewOptions, ViewerCommand};
use crate::fixtures::meeting::Meeting;
use crate::fixtures::paces::Paces;
use crate::fixtures::quietly;
use crate::settings::ViewerSettings;
use eframe::egui;
use glam::Vec2;
use std::path::Path;

fn open(path: &Path) -> Model {
    let mut model = Model::new(ViewerSettings::default());
    model.is_unhurried = true;
    quietly(|with| model.open_now(path, with)).unwrap();
    model
}

fn advance(model: &mut Model, steps: i32) {
    let ctx = egui::Context::default();
    model.apply(&ctx, ViewerCommand::Play(false));
    model.apply(&ctx, ViewerCommand::Step(steps));
    model.advance(&ctx, 0.0);
}

fn len(model: &Model) -> usize {
    let mut layout = StageLayout::default();
    layout.lay_out(model, true);
    layout.shapes.len()
}

#[test]
fn all_agents_are_drawn_and_details_of_the_selected_one() {
    let meeting = Meeting::new();
    for path in [meeting.scene(12), meeting.flock(12)] {
        let mut model = open(&path);
        advance(&mut model, 90);
        let ctx = egui::Context::default();
        let quiet = SceneViewOptions {
            marks: false,
            bounds: OverlayScope::None,
            paths: OverlayScope::None,
            ..SceneViewOptions::default()
        };
        model.apply(&ctx, ViewerCommand::Scene(SceneCommand::SetOptions(quiet)));
        let plain = len(&model);
        assert!(plain >= 24, "{plain}");
        model.apply(
            &ctx,
            ViewerCommand::Scene(SceneCommand::SetOptions(SceneViewOptions { bounds: OverlayScope::All, ..quiet })),
        );
        assert_eq!(len(&model), plain + 24);
        model.apply(
            &ctx,
            ViewerCommand::Scene(SceneCommand::SetOptions(SceneViewOptions { paths: OverlayScope::All, ..quiet })),
        );
        assert!(len(&model) >= plain + 48);
        model.apply(&ctx, ViewerCommand::Scene(SceneCommand::SetOptions(SceneViewOptions { marks: true, ..quiet })));
        assert!(len(&model) > plain, "nothing has happened within 1.5 s");
        model.apply(&ctx, ViewerCommand::Scene(SceneCommand::SetOptions(quiet)));
        model.apply(&ctx, ViewerCommand::SelectCharacter(Some(5)));
        let selected = len(&model);
        assert!(selected > plain + 12, "{plain} {selected}");
        let fewer = SceneViewOptions { cells: false, forces: false, ..quiet };
        model.apply(&ctx, ViewerCommand::Scene(SceneCommand::SetOptions(fewer)));
        assert!(len(&model) < selected - 10);
    }
}

#[test]
fn bodies_are_drawn_over_discs_and_can_be_selected() {
    let paces = Paces::new();
    let mut model = open(&paces.crowd(4));
    advance(&mut model, 30);
    let mut layout = StageLayout::default();
    layout.lay_out(&model, true);
    assert_eq!(layout.instances.len(), 8);
    assert_eq!(layout.poses(&model).len(), 8 * throng_core::NUM_JOINTS);
    let run = &model.document.scene().unwrap().run;
    for (i, instance) in layout.instances.iter().enumerate() {
        let at = run.place(layout.drawn[i]).unwrap();
        assert!(instance.root.translation().distance(at) < 0.3, "{i}");
    }
    let ctx = egui::Context::default();
    let discs = SceneViewOptions { bodies: false, ..SceneViewOptions::default() };
    model.apply(&ctx, ViewerCommand::Scene(SceneCommand::SetOptions(discs)));
    layout.lay_out(&model, true);
    assert!(layout.instances.is_empty() && layout.poses(&model).is_empty());
    // The clips that bodies are made of can be shown.
    model.apply(&ctx, ViewerCommand::ShowClip { clip: 0, frame: 3 });
    layout.lay_out(&model, true);
    assert!(model.shows_clip() && !layout.instances.is_empty());
}

#[test]
fn a_ray_through_an_agent_selects_it() {
    let meeting = Meeting::new();
    for path in [meeting.scene(12), meeting.flock(12)] {
        let mut model = open(&path);
        advance(&mut model, 30);
        let scene = model.document.scene().unwrap();
        let (camera, view) = (model.settings.camera, Vec2::new(800.0, 500.0));
        let mut found = 0;
        for m in 0..24 {
            let pixel = camera.project(scene.run.place(m).unwrap(), view).unwrap();
            found += usize::from(pick(scene, &camera, &camera.ray(pixel, view), view) == Some(m));
        }
        // In the air one may hide another.
        assert!(found >= 20, "{found} of 24");
        let beside = camera.ray(Vec2::new(2.0, 2.0), view);
        assert_eq!(pick(scene, &camera, &beside, view), None);
    }
}
