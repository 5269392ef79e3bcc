//! Scenes of crowds in the real app, driven as people drive it.

mod common;

use common::meeting::Meeting;
use common::{Viewing, adapter};
use eframe::egui::{self, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::Queryable;
use glam::Vec2;
use throng_viewer::args::{Args, Character, PanelChoice, Size};
use throng_viewer::command::{Command, CrowdCommand};
use throng_viewer::document::{CrowdChoice, CrowdDocument};
use throng_viewer::headless::draw_picture;
use throng_viewer::panels::PANELS;
use throng_viewer::settings::PanelKind;

fn crowd(v: &Viewing) -> &CrowdDocument {
    v.model().document.crowd_scene().expect("a scene of a crowd")
}

fn now(v: &Viewing) -> u32 {
    crowd(v).run().reel.head.now()
}

fn has_no_errors(v: &Viewing) -> bool {
    v.model().messages.iter().all(|m| !m.is_error)
}

/// Where an agent is on the screen.
fn on_screen(v: &Viewing, agent: usize) -> Pos2 {
    let rect = v.harness.get_by_label("3-D view").rect();
    let at = crowd(v).run().moment().agents[agent].expect("it is there").at;
    let at = v.model().settings.camera.project(at, Vec2::new(rect.width(), rect.height())).expect("in view");
    rect.min + vec2(at.x, at.y)
}

fn click(v: &mut Viewing, pos: Pos2) {
    v.harness.hover_at(pos);
    v.harness.run_steps(2);
    for pressed in [true, false] {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        v.harness.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
        v.harness.run_steps(2);
    }
}

#[test]
fn a_scene_opens_plays_and_is_paused_stepped_and_rewound() {
    let meeting = Meeting::new();
    let mut v = Viewing::of(&meeting.scene(12));
    assert!(v.model().is_playing() && v.model().document.bundle().is_none());
    assert_eq!((v.model().settings.side_panel, v.model().num_characters()), (Some(PanelKind::Crowd), 24));
    // From straight above.
    assert!(v.model().settings.camera.pitch > 1.5);
    v.until("a second", |v| now(v) >= 60);
    v.harness.get_by_label("Pause").click();
    v.harness.run_steps(2);
    let (last, seen) = (now(&v), crowd(&v).run().moment().clone());
    v.harness.run_steps(5);
    assert_eq!(now(&v), last);

    // A click on an agent selects it, and its forces are told.
    let at = on_screen(&v, 7);
    click(&mut v, at);
    assert_eq!(v.model().selection.character, Some(7));
    v.harness.run_steps(2);
    v.harness.get_by_label("driving");
    assert_eq!(crowd(&v).run().moment().details.as_ref().map(|d| d.agent), Some(7));

    v.harness.key_press(Key::ArrowRight);
    v.harness.run_steps(3);
    assert_eq!(now(&v), last + 1);
    v.harness.get_by_label("Step").click();
    v.harness.run_steps(3);
    assert_eq!(now(&v), last + 2);
    v.apply(Command::Seek(last));
    assert!(crowd(&v).run().moment().agents == seen.agents);
    v.apply(Command::Step(-20));
    v.harness.run_steps(2);
    assert_eq!(now(&v), last - 20);
    // A second on: what is kept first, then new steps.
    v.apply(Command::Step(60));
    v.until("a second more", |v| now(v) == last + 40);
    v.harness.run_steps(3);
    assert_eq!(now(&v), last + 40);
    v.apply(Command::Speed(4.0));
    v.apply(Command::Play(true));
    v.harness.run_steps(10);
    assert!(now(&v) > last + 60 && has_no_errors(&v), "{:?}", v.model().messages);
}

#[test]
fn a_scene_restarts_with_other_numbers_and_is_saved() {
    let meeting = Meeting::new();
    let mut v = Viewing::of(&meeting.scene(12));
    v.until("half a second", |v| now(v) >= 30);
    v.apply(Command::Play(false));
    v.apply(Command::SelectCharacter(Some(20)));
    let file = meeting.folder().join("kept.crowd");
    v.apply(Command::Crowd(CrowdCommand::Save(file.clone())));
    let (hash, time_s) = (crowd(&v).run().state_hash(), crowd(&v).run().moment().time_s);

    let choice = CrowdChoice { agents: 10, ..crowd(&v).choice() };
    v.apply(Command::Crowd(CrowdCommand::Begin(choice)));
    v.until("ten agents", |v| v.model().num_characters() == 10);
    assert_eq!((v.model().selection.character, now(&v), v.model().is_playing()), (None, 0, false));
    v.apply(Command::Crowd(CrowdCommand::Restore(file)));
    v.until("those of before", |v| v.model().num_characters() == 24);
    assert_eq!((crowd(&v).run().state_hash(), crowd(&v).run().moment().time_s), (hash, time_s));

    let runs = crowd(&v).num_runs();
    v.harness.key_press(Key::R);
    v.until("the start", |v| crowd(v).num_runs() > runs);
    assert_eq!(crowd(&v).run().moment().time_s, 0.0);
    // All panels have something to say of it.
    for panel in PANELS {
        v.apply(Command::TogglePanel(panel.kind));
        v.harness.run_steps(2);
    }
    assert!(has_no_errors(&v), "{:?}", v.model().messages);
    let impossible = CrowdChoice { agents: 1, ..choice };
    v.apply(Command::Crowd(CrowdCommand::Begin(impossible)));
    assert!(v.model().messages.iter().any(|m| m.is_error && m.text.contains("is unchanged")));
    assert_eq!(v.model().num_characters(), 24);
}

#[test]
fn scenes_are_drawn_the_same_every_time() {
    if adapter().is_none() {
        return;
    }
    let meeting = Meeting::new();
    let args = Args {
        file: Some(meeting.flock(12)),
        panel: vec![PanelChoice::Open(PanelKind::Crowd)],
        character: Some(Character(Some(1))),
        size: Some(Size { width: 640, height: 400 }),
        frames: Some(60),
        ..Args::default()
    };
    let (a, b) = (meeting.folder().join("a.png"), meeting.folder().join("b.png"));
    for out in [&a, &b] {
        let report = draw_picture(&args, out).expect("a picture");
        assert_eq!(report.figures.characters, 24);
    }
    let read = |path| std::fs::read(path).expect("a picture");
    assert!(read(&a) == read(&b), "two pictures differ");
    draw_picture(&Args { characters: Some(10), ..args }, &b).expect("a picture");
    assert!(read(&a) != read(&b), "the number of agents changes nothing");
}
