//! The real app, driven as people drive it.

use crate::common;
use crate::common::boxing::Boxing;
use crate::common::{Viewing, drop_files, golden};
use eframe::egui::{self, Key, Modifiers, pos2};
use egui_kittest::kittest::Queryable;
use glam::Vec3;
use std::path::PathBuf;
use throng_viewer::command::{SceneCommand, ViewerCommand};
use throng_viewer::document::{SceneChoice, SceneDocument};
use throng_viewer::panels::PANELS;
use throng_viewer::render::Rgba;
use throng_viewer::run::{SceneRun, target_home};
use throng_viewer::settings::{Colouring, PanelKind};
use throng_viewer::stage::StageLayout;

fn scene(v: &Viewing) -> &SceneDocument {
    v.model().document.scene().expect("a scene")
}

/// Where the first character's target hangs (m).
fn home(v: &Viewing) -> Vec3 {
    target(v, 0)
}

/// Where a character's target hangs (m).
fn target(v: &Viewing, who: usize) -> Vec3 {
    target_home(run(v).simulation(), who).expect("a target")
}

fn run(v: &Viewing) -> &SceneRun {
    &scene(v).run
}

/// The segment that a character plays, and how many frames of it have passed.
fn segment(v: &Viewing, who: usize) -> (u32, f32) {
    scene(v).chooser(who).expect("a policy").characters.segment(who)
}

/// All poses as bits.
fn poses(v: &Viewing) -> Vec<u32> {
    let rows = run(v).simulation().poses().flatten().flatten().flat_map(|m| m.rows);
    rows.flatten().map(f32::to_bits).collect()
}

/// A copy of the golden bundle in a folder of its own.
fn copied() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("copy.throng");
    std::fs::copy(golden(), &path).expect("a copy");
    (folder, path)
}

fn has_message(v: &Viewing, part: &str) -> bool {
    v.model().messages.iter().any(|m| m.text.contains(part))
}

#[test]
fn a_run_that_is_scrubbed_back_shows_the_same_step_again() {
    let mut v = Viewing::of(&golden());
    v.harness.run_steps(40);
    v.harness.get_by_label("Pause").click();
    v.harness.run_steps(2);
    assert!(!run(&v).head.is_playing());
    let (step, seen) = (run(&v).head.shown_step(), poses(&v));
    assert!(step >= 30, "step {step}");

    v.harness.get_by_label("Play").click();
    let mut shown = vec![(step, seen)];
    for _ in 0..60 {
        v.harness.step();
        shown.push((run(&v).head.shown_step(), poses(&v)));
    }
    let last = run(&v).head.shown_step();
    assert!(last > step + 30);
    let line = v.harness.get_by_label("Time").rect();
    let at = |ratio: f32| pos2(line.left() + ratio * line.width(), line.center().y);
    v.drag(at(1.0) - egui::vec2(6.0, 0.0), at(0.5 * (step + last) as f32 / last as f32));
    let now = run(&v).head.shown_step();
    assert!((step..last - 5).contains(&now) && !run(&v).head.is_playing(), "step {now} of {last} is shown");
    let (_, seen) = shown.iter().find(|s| s.0 == now).expect("every step was shown");
    assert!(poses(&v) == *seen, "step {now} is another one after scrubbing back");

    v.harness.key_press(Key::ArrowLeft);
    v.harness.run_steps(2);
    let back = run(&v).head.shown_step();
    v.harness.get_by_label("Step").click();
    v.harness.run_steps(2);
    assert_eq!(run(&v).head.shown_step(), back + 1);
}

#[test]
fn a_target_dragged_in_the_view_is_walked_to() {
    let mut v = Viewing::of(&golden());
    // So few that none is in its way for long.
    let choice = SceneChoice { characters: 6, ..scene(&v).choice };
    v.apply(ViewerCommand::Scene(SceneCommand::Restart(choice)));
    v.until("six characters", |v| v.model().num_characters() == 6);
    v.apply(ViewerCommand::SelectCharacter(Some(0)));
    v.apply(ViewerCommand::Play(false));
    v.harness.run_steps(2);
    let rect = v.harness.get_by_label("3-D view").rect();
    let old = target(&v, 0);
    let camera = v.model().settings.camera;
    let from = v.on_screen(old);
    let to = from + egui::vec2(60.0, 40.0);
    v.drag(from, to);
    let held = target(&v, 0);
    let size = glam::Vec2::new(rect.width(), rect.height());
    let wanted = camera.ray(glam::Vec2::new(to.x - rect.left(), to.y - rect.top()), size);
    let wanted = wanted.intersect_ground().expect("the ground");
    assert!((held - wanted).length() < 0.05, "{held} is not at {wanted}; it was at {old}");
    assert_eq!(v.model().settings.camera, camera, "the camera moved instead");

    let far = |v: &Viewing| {
        let root = run(v).simulation().root(0).expect("it is there");
        (Vec3::new(root.x, 0.0, root.z) - held.with_y(0.0)).length()
    };
    let before = far(&v);
    v.apply(ViewerCommand::Play(true));
    let mut nearest = before;
    for _ in 0..900 {
        v.harness.step();
        nearest = nearest.min(far(&v));
    }
    assert!(nearest < 0.6, "came only as near as {nearest} m from {before} m");
}

#[test]
fn who_plays_made_motion_is_pink() {
    let folder = tempfile::tempdir().expect("a folder");
    common::walk(folder.path(), 0.5);
    let mut v = Viewing::of(folder.path());
    v.until("the crowd", |v| v.model().document.scene().is_some());
    v.harness.get_by_label("View").click();
    v.harness.run_steps(2);
    v.harness.get_by_label("Colours").click();
    v.harness.run_steps(2);
    v.harness.get_by_label("made motion (pink)").click();
    v.harness.run_steps(2);
    assert_eq!(v.model().settings.colouring, Colouring::Made);
    let (mut layout, mut seen) = (StageLayout::default(), [0; 2]);
    for _ in 0..300 {
        v.harness.step();
        layout.lay_out(v.model(), true);
        let tables = v.model().document.bundle().expect("a bundle").tables();
        for (c, shown) in layout.instances.iter().enumerate() {
            let (segment, frames) = segment(&v, c);
            let s = &tables.graph().segments[segment as usize];
            let clip = &tables.meta().clips[s.clip as usize];
            let at = s.start - tables.clips()[s.clip as usize].first_frame + frames as u32;
            let is_made = clip.tags.iter().any(|(tag, from, to)| tag == "made" && (*from..*to).contains(&at));
            assert_eq!(shown.colour == Rgba::hex(0xe0457b), is_made, "{} {at}", clip.name);
            seen[usize::from(is_made)] += 1;
        }
    }
    assert!(seen[0] > 0 && seen[1] > 0, "captured and made: {seen:?}");
}

#[test]
fn every_panel_opens_and_closes_by_its_key() {
    let mut v = Viewing::of(&golden());
    for panel in PANELS {
        let open = |v: &Viewing| v.model().settings.panel(panel.kind.dock()) == Some(panel.kind);
        let was_open = open(&v);
        v.harness.key_press(panel.key);
        v.harness.run_steps(3);
        assert_ne!(open(&v), was_open, "{}", panel.title);
        if was_open {
            v.harness.key_press(panel.key);
            v.harness.run_steps(3);
        }
        assert!(open(&v), "{}", panel.title);
        assert!(v.has_no_errors(), "{}: {:?}", panel.title, v.model().messages);
    }
}

#[test]
fn the_list_of_keys_is_shown_and_closed() {
    let mut v = Viewing::of(&golden());
    v.harness.key_press(Key::H);
    v.harness.run_steps(3);
    v.harness.get_by_label("play or pause");
    v.harness.get_by_label("Close").click();
    v.harness.run_steps(3);
    assert!(v.harness.query_by_label("play or pause").is_none());
}

#[test]
fn a_dropped_broken_file_is_refused_and_the_open_bundle_stays() {
    let mut v = Viewing::of(&golden());
    let folder = tempfile::tempdir().expect("a folder");
    let broken = folder.path().join("broken.throng");
    std::fs::write(&broken, "no tables").expect("a file");
    drop_files(&mut v, &[&broken]);
    v.until("a message about the broken file", |v| has_message(v, "broken.throng"));
    assert!(has_message(&v, "The open file stays open"));
    assert_eq!(v.model().document.path(), Some(golden().as_path()));
    v.harness.run_steps(3);
    // The panel at the right has such a button, too.
    let buttons = v.harness.get_all_by_label("✖").collect::<Vec<_>>();
    let dismiss = buttons.iter().min_by(|a, b| a.rect().left().total_cmp(&b.rect().left()));
    dismiss.expect("the message can be taken away").click();
    drop(buttons);
    v.harness.run_steps(2);
    assert!(!has_message(&v, "broken.throng"));
    let now = run(&v).head.shown_step();
    v.harness.run_steps(5);
    assert!(run(&v).head.shown_step() > now, "the old run stopped");
}

#[test]
fn bundles_and_motion_files_that_are_dropped_are_opened() {
    let mut v = Viewing::empty();
    drop_files(&mut v, &[&golden()]);
    v.until("the bundle", |v| v.model().document.bundle().is_some());
    let folder = tempfile::tempdir().expect("a folder");
    let motion = common::bvh(folder.path());
    drop_files(&mut v, &[&motion]);
    v.until("the motion file", |v| v.model().document.raw_motion().is_some());
    assert_eq!(v.model().document.path(), Some(motion.as_path()));
    v.harness.run_steps(5);
    assert!(v.model().player.frame > 0.0, "the motion is not played");
}

#[test]
fn a_file_that_changes_on_disk_is_read_again_unless_it_is_broken() {
    let (_folder, path) = copied();
    let mut v = Viewing::of(&path);
    v.harness.run_steps(20);
    std::fs::write(&path, "no tables").expect("written over");
    v.until("a message about the broken version", |v| has_message(v, "The open file stays open"));
    assert!(run(&v).head.shown_step() > 0, "the old run is gone");
    std::fs::copy(golden(), &path).expect("written over");
    v.until("the good version", |v| has_message(v, "was reloaded"));
    assert_eq!(v.model().document.path(), Some(path.as_path()));
    assert!(v.model().document.scene().is_some());
}

#[test]
fn a_dropped_scene_runs_and_counts_its_blows() {
    let boxing = Boxing::new();
    let mut v = Viewing::empty();
    drop_files(&mut v, &[&boxing.pairs(4)]);
    v.until("the scene", |v| v.model().document.scene().is_some());
    assert_eq!(v.model().settings.opened[0][0].file_name(), Some("pairs.toml".as_ref()));
    v.apply(ViewerCommand::TogglePanel(PanelKind::Statistics));
    let thrown = |v: &Viewing| scene(v).run.figures().bout.expect("figures of blows").blows.thrown;
    v.until("some blows", |v| thrown(v) > 3);
    v.harness.get_by_label("thrown");
    v.harness.get_by_label("blocked");
    v.apply(ViewerCommand::Play(false));
    v.harness.run_steps(2);
    let joints = |v: &Viewing| (0..4).map(|who| scene(v).run.simulation().joint_positions(who)).collect::<Vec<_>>();
    let (last, seen) = (scene(&v).run.head.shown_step(), joints(&v));
    v.apply(ViewerCommand::Seek(0));
    assert_eq!(thrown(&v), 0);
    v.apply(ViewerCommand::Seek(last));
    assert!(joints(&v) == seen, "another bout after scrubbing back and on");
    assert!(v.has_no_errors(), "{:?}", v.model().messages);

    let choice = SceneChoice { characters: 8, ..scene(&v).choice };
    v.apply(ViewerCommand::Scene(SceneCommand::Restart(choice)));
    v.until("eight boxers", |v| v.model().num_characters() == 8);
    v.apply(ViewerCommand::Restart);
    v.until("the start", |v| scene(v).num_runs == 2);
    assert_eq!((v.model().num_characters(), scene(&v).run.head.shown_step()), (8, 0));
}

#[test]
fn a_hanging_target_dragged_in_the_view_keeps_its_height_unless_alt_is_held() {
    let boxing = Boxing::new();
    let mut v = Viewing::of(&boxing.targets(1));
    v.apply(ViewerCommand::Play(false));
    v.harness.run_steps(2);
    let camera = v.model().settings.camera;
    let old = home(&v);
    let from = v.on_screen(old);
    v.drag(from, from + egui::vec2(50.0, 30.0));
    let moved = home(&v);
    assert!((moved.y - old.y).abs() < 1e-4 && moved.distance(old) > 0.1, "{old} became {moved}");
    assert_eq!(v.model().settings.camera, camera, "the camera moved instead");

    v.harness.event(egui::Event::ModifiersChanged(Modifiers::ALT));
    let from = v.on_screen(moved);
    v.drag(from, from - egui::vec2(0.0, 40.0));
    let lifted = home(&v);
    assert!(lifted.y > moved.y + 0.05, "{moved} became {lifted}");
    assert!((lifted - moved).with_y(0.0).length() < 1e-3);
}

#[test]
fn a_character_is_steered_with_keys_and_frames_until_it_is_seen_are_counted() {
    let mut v = Viewing::of(&golden());
    v.apply(ViewerCommand::SelectCharacter(Some(3)));
    v.key(Key::G, true);
    v.key(Key::G, false);
    assert!(v.model().steering().is_some() && v.model().settings.follow);
    let root = |v: &Viewing| run(v).simulation().root(3).expect("it is there");
    let camera = |v: &Viewing| v.model().settings.camera;
    let mut travelled = 0.0;
    for key in [Key::W, Key::D, Key::W, Key::A, Key::W] {
        let from = root(&v).translation();
        v.key(key, true);
        let [right, _, back] = camera(&v).axes();
        let before = target(&v, 3);
        v.harness.step();
        let direction = (target(&v, 3) - root(&v).translation()).normalize_or_zero();
        let wanted = match key {
            Key::D => right,
            Key::A => -right,
            _ => -back.with_y(0.0).normalize(),
        };
        assert!(direction.dot(wanted) > 0.95, "{key:?}: {direction} for {wanted}, target {before}");
        (0..100).for_each(|_| v.harness.step());
        travelled += root(&v).translation().distance(from);
        v.key(key, false);
    }
    assert!(travelled > 2.0, "{travelled} m");
    let lags = &v.model().steering().expect("somebody").lags;
    let (median, p95) = lags.median_and_p95().expect("keys were measured");
    println!("frames from key to change: median {median}, 95th percentile {p95}, {:?} keys", lags.count());
    assert!(median >= 2 && lags.count().0 >= 2);
    // Who is let go stays, and A shows everything again.
    let held = target(&v, 3);
    (0..30).for_each(|_| v.harness.step());
    assert!(target(&v, 3).distance(held) < 1.7);
    v.key(Key::G, true);
    assert!(v.model().steering().is_none());
}

#[test]
fn who_is_steered_strikes_where_there_are_blows() {
    let boxing = Boxing::new();
    let mut v = Viewing::of(&boxing.bundle());
    v.key(Key::G, true);
    assert_eq!(v.model().selection.character, Some(0));
    v.key(Key::X, true);
    v.harness.step();
    let bundle = v.model().document.bundle().expect("a bundle");
    assert!(!bundle.motion_set.hits_of(segment(&v, 0).0).is_empty());
    let mut v = Viewing::of(&golden());
    v.key(Key::G, true);
    v.key(Key::X, true);
    v.harness.step();
    let has_blows = !v.model().document.bundle().expect("a bundle").motion_set.hits().is_empty();
    assert!(has_blows || v.model().messages.iter().any(|m| m.text.contains("No blow")));
}

#[test]
fn scenes_say_why_nobody_is_steered() {
    let boxing = Boxing::new();
    let mut v = Viewing::of(&boxing.pairs(2));
    v.key(Key::G, true);
    v.harness.step();
    assert!(v.model().steering().is_none());
    assert!(v.model().messages.iter().any(|m| m.text.contains("open its bundle")), "{:?}", v.model().messages);
}
