//! Worlds of motion patches in the viewer: shown, told, edited with the mouse, and drawn without a screen.

use crate::common::square::Square;
use crate::common::{Viewing, adapter, assert_drawn_alike};
use eframe::egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable;
use glam::Vec3;
use throng_viewer::args::{Args, PanelChoice, PictureSize};
use throng_viewer::command::{Tool, ViewerCommand, WorldCommand};
use throng_viewer::settings::PanelKind;
use throng_world::inhabitants::InhabitantGoal;

/// The panel Patches beside the view.
fn opened(file: &std::path::Path) -> Viewing {
    let panel = vec![PanelChoice::Open(PanelKind::Patches)];
    let args = Args { file: Some(file.to_path_buf()), panel, ..Args::default() };
    let mut v = Viewing::new(&args, vec2(1000.0, 700.0));
    v.harness.run_steps(3);
    v.apply(ViewerCommand::Play(false));
    v.apply(ViewerCommand::FrameAll);
    v.harness.run_steps(3);
    v
}

/// The world once more, when it has been stitched.
fn stitched(v: &mut Viewing) {
    v.until("the new world", |v| v.model().document.world().is_some_and(|w| w.working.is_none()));
    v.harness.run_steps(3);
}

fn tool(v: &mut Viewing, tool: Tool) {
    v.apply(ViewerCommand::World(WorldCommand::Tool(tool)));
    v.harness.run_steps(2);
}

#[test]
fn units_are_edited_and_characters_get_orders() {
    let square = Square::new();
    let mut v = opened(&square.world(3));
    let num_units = |v: &Viewing| v.model().document.world().expect("a world").placed().len();
    assert_eq!(num_units(&v), 10);
    let post = |v: &Viewing| v.model().document.world().expect("a world").placed()[9].placement;

    // A drag moves the post along the side.
    tool(&mut v, Tool::Move);
    let (from, to) = (v.on_screen(Vec3::new(-2.2, 0.6, 0.0)), v.on_screen(Vec3::new(-2.2, 0.6, 2.0)));
    v.harness.hover_at(from);
    v.press(from, true);
    for part in [0.3, 0.7, 1.0] {
        v.harness.hover_at(from + (to - from) * part);
        v.harness.run_steps(2);
    }
    let draft = v.model().selection.world.draft;
    assert!(draft.is_some_and(|d| (d.at.z - 2.0).abs() < 0.3), "{draft:?}");
    assert_eq!(post(&v).z, 0.0, "nothing is stitched before it is let go");
    v.press(to, false);
    stitched(&mut v);
    assert!((post(&v).z - 2.0).abs() < 0.3 && (post(&v).x + 2.2).abs() < 0.3, "{:?}", post(&v));
    assert_eq!((v.model().selection.world.draft, v.model().selection.world.place), (None, Some(9)));

    // A key turns it.
    let heading = post(&v).heading;
    v.harness.key_press(Key::Q);
    v.harness.run_steps(3);
    stitched(&mut v);
    assert!((post(&v).heading - heading - 15f32.to_radians()).abs() < 1e-3, "{:?}", post(&v));

    // One more panel goes beside the others, though it is not pointed at exactly.
    tool(&mut v, Tool::Create(0));
    let at = v.on_screen(Vec3::new(8.7, 0.0, 2.5));
    v.click(at);
    stitched(&mut v);
    assert_eq!(num_units(&v), 11, "{:?}", v.model().messages);
    let p = v.model().document.world().expect("a world").placed()[10].placement;
    assert!((p.x - 8.4).abs() < 1e-3 && (p.z - 2.8).abs() < 1e-3, "{p:?}");
    assert!(v.model().document.world().is_some_and(|w| w.edited.is_some()));

    // Delete removes it.
    tool(&mut v, Tool::Move);
    v.harness.key_press(Key::Delete);
    v.harness.run_steps(3);
    stitched(&mut v);
    assert_eq!(num_units(&v), 10);

    // Keys and buttons take changes back and make them again.
    v.harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    v.harness.run_steps(3);
    stitched(&mut v);
    assert_eq!((num_units(&v), v.model().selection.world.place), (11, Some(10)));
    v.harness.get_by_label("Undo").click();
    v.harness.run_steps(3);
    stitched(&mut v);
    assert_eq!(num_units(&v), 10);
    v.harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    v.harness.run_steps(3);
    stitched(&mut v);
    assert_eq!(num_units(&v), 11);
    v.harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    v.harness.run_steps(3);
    stitched(&mut v);
    assert_eq!(num_units(&v), 10);

    // A panel that cannot be reached is refused with the reason.
    tool(&mut v, Tool::Select);
    let far = throng_core::patch::Placement::new(70.0, 0.0, 0.0, 0.0);
    let change = throng_viewer::document::world::UnitChange::Add { unit: 0, at: far };
    v.apply(ViewerCommand::World(WorldCommand::Edit(change)));
    stitched(&mut v);
    assert_eq!(num_units(&v), 10);
    let refused = v.model().document.world().and_then(|w| w.refused.as_ref()).expect("a reason").reason.clone();
    assert!(refused.contains("ground"), "{refused}");
    v.harness.get_by_label_contains(&refused);
    v.harness.key_press(Key::Escape);
    v.harness.run_steps(3);
    assert!(v.harness.query_by_label_contains(&refused).is_none());

    // A click with the tool Send tells the selected one where to go.
    v.apply(ViewerCommand::SelectCharacter(Some(0)));
    tool(&mut v, Tool::Send);
    let at = v.on_screen(Vec3::new(5.6, 0.0, 5.6));
    v.click(at);
    v.harness.run_steps(3);
    let told = v.model().document.world().and_then(|w| w.run.order_of(0));
    let Some(InhabitantGoal::GoNear { place, .. }) = told else { panic!("{told:?}") };
    assert!(place.distance(Vec3::new(5.6, 0.0, 5.6)) < 0.3, "{place}");
    v.harness.get_by_label("Roam").click();
    v.harness.run_steps(3);
    assert_eq!(v.model().document.world().and_then(|w| w.run.order_of(0)), Some(InhabitantGoal::Roam));
}

#[test]
fn a_scene_in_a_world_is_drawn_the_same_every_time() {
    if adapter().is_none() {
        return;
    }
    let square = Square::new();
    square.world(3);
    let args = Args {
        file: Some(square.scene(3)),
        panel: vec![PanelChoice::None],
        character: Some(1),
        size: Some(PictureSize { width: 640, height: 400 }),
        frames: Some(60),
        ..Args::default()
    };
    let one = Args { characters: Some(1), character: None, ..args.clone() };
    assert_drawn_alike(square.folder(), &args, 3, &one);
}

#[test]
fn who_is_steered_on_patches_is_sent_ahead() {
    let square = Square::new();
    let mut v = opened(&square.world(3));
    v.apply(ViewerCommand::SelectCharacter(Some(0)));
    v.key(Key::G, true);
    v.key(Key::G, false);
    let mut sent = 0;
    for pressed in [Key::W, Key::A, Key::S, Key::D] {
        v.key(pressed, true);
        let world = v.model().document.world().expect("a world");
        let (at, goal) = (world.run.reel.moment().roots[0].translation(), world.run.reel.moment().states[0].goal);
        let [right, _, back] = v.model().settings.camera.axes();
        let ahead = -back.with_y(0.0).normalize();
        let wanted = match pressed {
            Key::W => ahead,
            Key::S => -ahead,
            Key::D => right,
            _ => -right,
        };
        // At an edge of the world there may be nowhere to go.
        if let InhabitantGoal::GoNear { place, .. } = goal
            && (place - at).length() > 1.0
        {
            assert!((place - at).with_y(0.0).normalize().dot(wanted) > 0.9, "{pressed:?}: {}", place - at);
            sent += 1;
        }
        v.key(pressed, false);
    }
    assert!(sent > 0, "{:?}", v.model().messages);
    assert!(v.has_no_errors(), "{:?}", v.model().messages);
}
