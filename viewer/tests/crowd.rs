//! Scenes of crowds in the real app, driven as people drive it.

use crate::common::market::Market;
use crate::common::meeting::Meeting;
use crate::common::{Viewing, adapter, assert_drawn_alike};
use eframe::egui::{Key, vec2};
use egui_kittest::kittest::Queryable;
use throng_viewer::args::{Args, PanelChoice, PictureSize};
use throng_viewer::command::{BlackboardCell, SceneCommand, ViewerCommand};
use throng_viewer::document::{SceneChoice, SceneDocument};
use throng_viewer::panels::PANELS;
use throng_viewer::settings::PanelKind;

fn scene(v: &Viewing) -> &SceneDocument {
    v.model().document.scene().expect("a scene")
}

fn now(v: &Viewing) -> u32 {
    scene(v).run.head.shown_step()
}

/// Places of all agents (m).
fn places(v: &Viewing) -> Vec<Option<glam::Vec3>> {
    (0..v.model().num_characters()).map(|who| scene(v).run.place(who)).collect()
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
    let (last, seen) = (now(&v), places(&v));
    v.harness.run_steps(5);
    assert_eq!(now(&v), last);

    // A click on an agent selects it, and its forces are told.
    let at = v.on_screen(scene(&v).run.place(7).expect("it is there"));
    v.click(at);
    assert_eq!(v.model().selection.character, Some(7));
    v.harness.run_steps(2);
    v.harness.get_by_label("driving");

    v.harness.key_press(Key::ArrowRight);
    v.harness.run_steps(3);
    assert_eq!(now(&v), last + 1);
    v.harness.get_by_label("Step").click();
    v.harness.run_steps(3);
    assert_eq!(now(&v), last + 2);
    v.apply(ViewerCommand::Seek(last));
    assert_eq!(places(&v), seen);
    v.apply(ViewerCommand::Step(-20));
    v.harness.run_steps(2);
    assert_eq!(now(&v), last - 20);
    // A second on: what is kept first, then new steps.
    v.apply(ViewerCommand::Step(60));
    v.until("a second more", |v| now(v) == last + 40);
    v.harness.run_steps(3);
    assert_eq!(now(&v), last + 40);
    v.apply(ViewerCommand::Speed(4.0));
    v.apply(ViewerCommand::Play(true));
    v.harness.run_steps(10);
    assert!(now(&v) > last + 60 && v.has_no_errors(), "{:?}", v.model().messages);
}

#[test]
fn a_scene_restarts_with_other_numbers_and_is_saved() {
    let meeting = Meeting::new();
    let mut v = Viewing::of(&meeting.scene(12));
    v.until("half a second", |v| now(v) >= 30);
    v.apply(ViewerCommand::Play(false));
    v.apply(ViewerCommand::SelectCharacter(Some(20)));
    let file = meeting.folder().join("kept.state");
    v.apply(ViewerCommand::Scene(SceneCommand::Save(file.clone())));
    let (hash, time_s) = (scene(&v).run.simulation().hash(), scene(&v).run.simulation().time_s());

    let choice = SceneChoice { characters: 10, ..scene(&v).choice };
    v.apply(ViewerCommand::Scene(SceneCommand::Restart(choice)));
    v.until("ten agents", |v| v.model().num_characters() == 10);
    assert_eq!((v.model().selection.character, now(&v), v.model().is_playing()), (None, 0, false));
    v.apply(ViewerCommand::Scene(SceneCommand::Restore(file)));
    v.until("those of before", |v| v.model().num_characters() == 24);
    assert_eq!((scene(&v).run.simulation().hash(), scene(&v).run.simulation().time_s()), (hash, time_s));

    let runs = scene(&v).num_runs;
    v.harness.key_press(Key::R);
    v.until("the start", |v| scene(v).num_runs > runs);
    assert_eq!(scene(&v).run.simulation().time_s(), 0.0);
    // All panels have something to say of it.
    for panel in PANELS {
        v.apply(ViewerCommand::TogglePanel(panel.kind));
        v.harness.run_steps(2);
    }
    assert!(v.has_no_errors(), "{:?}", v.model().messages);
    let impossible = SceneChoice { characters: 0, ..choice };
    v.apply(ViewerCommand::Scene(SceneCommand::Restart(impossible)));
    assert!(v.model().messages.iter().any(|m| m.is_error && m.text.contains("is unchanged")));
    assert_eq!(v.model().num_characters(), 24);
}

#[test]
fn a_scene_that_is_edited_goes_on_at_its_time_and_a_broken_one_leaves_the_old_one() {
    let market = Market::new();
    let path = market.scene(12);
    let mut v = Viewing::of(&path);
    let choice = SceneChoice { seed: 8, ..scene(&v).choice };
    v.apply(ViewerCommand::Scene(SceneCommand::Restart(choice)));
    v.until("the other seed", |v| scene(v).num_runs == 1);
    v.until("a second", |v| now(v) >= 60);
    v.apply(ViewerCommand::Play(false));
    v.apply(ViewerCommand::SelectCharacter(Some(4)));
    v.harness.run_steps(2);
    let step = now(&v);
    let says = |v: &Viewing, text: &str| v.model().messages.iter().any(|m| m.text.contains(text));

    let text = std::fs::read_to_string(&path).expect("a scene");
    std::fs::write(&path, text.replace("probability = 0.8", "probability = 1.8")).expect("written over");
    v.until("a message", |v| says(v, "stays open"));
    assert!(says(&v, "market.toml:"), "{:?}", v.model().messages);
    assert!(says(&v, "probability") && now(&v) == step, "{:?}", v.model().messages);
    let line = text.lines().position(|l| l.contains("probability = 0.8")).expect("the line") + 1;
    assert!(says(&v, &format!("market.toml:{line}:")), "{:?}", v.model().messages);

    std::fs::write(&path, text.replace("name = \"sale\"\nat_s = 1.0", "name = \"sale\"\nat_s = 0.25"))
        .expect("written over");
    v.until("the new version", |v| says(v, "was reloaded"));
    assert!(v.has_no_errors(), "{:?}", v.model().messages);
    assert_eq!((now(&v), scene(&v).choice.seed, v.model().selection.character), (step, 8, Some(4)));
    assert!(!v.model().is_playing());
    assert_eq!(scene(&v).run.spread.times(1)[0], 0.25);
    // The way there is recorded, too.
    v.apply(ViewerCommand::Seek(10));
    assert_eq!(scene(&v).run.spread.times(1)[0], 0.25);
    v.apply(ViewerCommand::Play(true));
    // A new seed in the file counts.
    std::fs::write(&path, text.replace("seed = 3", "seed = 4")).expect("written over");
    v.until("the new seed", |v| scene(v).choice.seed == 4);
}

#[test]
fn a_click_on_a_cell_with_a_board_reads_it_and_keeps_the_agent() {
    let market = Market::new();
    let mut v = Viewing::of(&market.scene(24));
    v.until("some seconds", |v| now(v) >= 180);
    v.apply(ViewerCommand::Play(false));
    v.apply(ViewerCommand::SelectCharacter(Some(5)));
    v.apply(ViewerCommand::FrameAll);
    v.harness.run_steps(2);
    let brains = scene(&v).run.simulation().brains().expect("agent brains");
    // A spot of a smallest cell with nobody near.
    let far = |p: &glam::Vec3| places(&v).into_iter().flatten().all(|a| a.distance(*p) > 0.9);
    let offsets: Vec<_> =
        (-4..=4).flat_map(|i| (-4..=4).map(move |k| glam::Vec3::new(i as f32, 0.0, k as f32) * 0.2)).collect();
    let found = brains.posts().filter_map(|p| p.cell).filter(|c| c.level == 0).find_map(|cell| {
        let at = glam::Vec3::new(cell.middle[0], 0.0, cell.middle[1]);
        Some((cell, offsets.iter().map(|o| at + *o).find(far)?))
    });
    let (smallest, free) = found.expect("a free spot");
    let pixel = v.on_screen(free);
    v.click(pixel);
    assert_eq!(v.model().selection.scene.cell, Some(BlackboardCell::from_cell(&smallest)));
    assert_eq!(v.model().selection.character, Some(5));
    // A tip waits until the pointer has moved and rests again.
    v.harness.hover_at(pixel + vec2(3.0, 0.0));
    v.harness.run_steps(60);
    assert!(v.harness.query_all_by_label_contains("board of a cell of 2 m").next().is_some());
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
        character: Some(1),
        size: Some(PictureSize { width: 640, height: 400 }),
        frames: Some(60),
        ..Args::default()
    };
    assert_drawn_alike(meeting.folder(), &args, 24, &Args { characters: Some(10), ..args.clone() });
}
