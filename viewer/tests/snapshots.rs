//! Every panel and the 3-D view look as they did: pictures in `tests/snapshots`.
//!
//! `UPDATE_SNAPSHOTS=1 cargo test -p throng-viewer --test all snapshots` takes new ones; look at them before they are kept.
//! Pixels are compared where Mesa's software adapter draws, since others round in other ways.

use crate::common::boxing::Boxing;
use crate::common::market::Market;
use crate::common::meeting::Meeting;
use crate::common::paces::Paces;
use crate::common::square::Square;
use crate::common::{Viewing, adapter, bvh, drop_files, faulty_bvh, golden, walk};
use eframe::egui::{self, Rect, vec2};
use egui_kittest::kittest::Queryable;
use egui_kittest::{SnapshotOptions, SnapshotResults};
use std::path::PathBuf;
use throng_core::patch::Placement;
use throng_precompute::run::News;
use throng_viewer::args::{Args, PanelChoice, ThemeName};
use throng_viewer::command::{
    OverlayScope, PlanCommand, PlanViewOptions, SceneCommand, SceneViewOptions, Tool, ViewerCommand, WorldCommand,
};
use throng_viewer::document::world::UnitChange;
use throng_viewer::document::{BuildEnd, FinishedBuild, OngoingBuild, ShownBuild};
use throng_viewer::panels::PANELS;
use throng_viewer::run::agents::AgentEventKind;
use throng_viewer::run::{BlendCompanions, Blending};
use throng_viewer::settings::{Dock, PanelKind};

/// Size of a picture of a panel (points).
const SIZE: egui::Vec2 = vec2(560.0, 380.0);
/// Size of a picture of the 3-D view (points).
const VIEW_SIZE: egui::Vec2 = vec2(420.0, 260.0);
/// Step of the run that is shown.
const STEP: u32 = 60;
/// Step of scenes of crowds, at which groups meet.
const MET: u32 = 200;

/// True where pictures can be compared; otherwise prints why not.
fn can_compare() -> bool {
    let Some(name) = adapter() else { return false };
    let comparable = name.contains("llvmpipe");
    if !comparable {
        println!("skipped: {name} is not the adapter that the pictures were made with (llvmpipe)");
    }
    comparable
}

/// Other versions of the adapter differ at some edges.
fn tolerance() -> SnapshotOptions {
    SnapshotOptions::new().threshold(1.5).max_failed_pixels(40)
}

fn crowd() -> Args {
    Args {
        file: Some(golden()),
        characters: Some(12),
        character: Some(3),
        panel: vec![PanelChoice::None],
        ..Args::default()
    }
}

/// The viewer at rest, at a known step of the run.
fn at_rest(args: &Args, size: egui::Vec2) -> Viewing {
    rest(Viewing::new(args, size))
}

/// The same, of one that has been opened.
fn rest(v: Viewing) -> Viewing {
    rest_at(v, STEP)
}

/// The same, at another step.
fn rest_at(mut v: Viewing, step: u32) -> Viewing {
    if !v.model().shows_clip() {
        v.until("the step", |v| v.model().head().is_some_and(|h| h.shown_step() >= step));
        v.apply(ViewerCommand::Seek(step));
    }
    v.apply(ViewerCommand::Play(false));
    v.apply(ViewerCommand::FrameAll);
    v.harness.remove_cursor();
    v.harness.run_steps(4);
    v
}

fn compare(results: &mut SnapshotResults, mut v: Viewing, name: &str) {
    v.harness.snapshot_options(name, &tolerance());
    results.extend(v.harness.take_snapshot_results());
}

#[test]
fn the_view_of_a_crowd() {
    if can_compare() {
        let mut results = SnapshotResults::new();
        compare(&mut results, at_rest(&crowd(), VIEW_SIZE), "view_crowd");
        let light = Args { theme: Some(ThemeName::Light), ..crowd() };
        compare(&mut results, at_rest(&light, VIEW_SIZE), "view_crowd_light");
    }
}

#[test]
fn the_view_of_a_clip() {
    if can_compare() {
        let mut results = SnapshotResults::new();
        compare(&mut results, at_rest(&Args { character: None, frame: Some(40), ..crowd() }, VIEW_SIZE), "view_clip");
    }
}

#[test]
fn the_view_of_a_motion_file() {
    if can_compare() {
        let mut results = SnapshotResults::new();
        let folder = tempfile::tempdir().expect("a folder");
        let args = Args { file: Some(bvh(folder.path())), frame: Some(40), panel: crowd().panel, ..Args::default() };
        compare(&mut results, at_rest(&args, VIEW_SIZE), "view_motion_file");
    }
}

/// The start page with two entries in its list, one of which is missing.
fn start_page(size: egui::Vec2, theme: Option<ThemeName>) -> Viewing {
    let mut v = Viewing::new(&Args { theme, ..Args::default() }, size);
    let opened = [vec![PathBuf::from("/motion/walks.zip")], vec![golden(), golden()], vec![golden()]];
    v.harness.state_mut().0.model.settings.opened = opened.to_vec();
    v.harness.run_steps(4);
    v
}

/// What a scene still needs differs from checkout to checkout, and the time that is left from run to run.
fn compare_page(results: &mut SnapshotResults, mut v: Viewing, name: &str) {
    v.harness.run_steps(4);
    let states = ["opens at once", "is built first, once"];
    let states = states.iter().flat_map(|s| v.harness.query_all_by_label(s).map(|n| n.rect()).collect::<Vec<_>>());
    let far = v.harness.query_all_by_label_contains("% of 3584").map(|n| n.rect());
    let masked = states.map(|r| (r, 130.0)).chain(far.map(|r| (r, 280.0))).collect::<Vec<_>>();
    for (rect, width) in masked {
        v.harness.mask(Rect::from_min_size(rect.left_top(), vec2(width, rect.height())));
    }
    compare(results, v, name);
}

fn walks() -> Vec<PathBuf> {
    vec!["/motion/walks".into()]
}

#[test]
fn the_start_page() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let (wide, small) = (vec2(1280.0, 800.0), vec2(800.0, 600.0));
    compare_page(&mut results, start_page(wide, None), "start_page");
    compare_page(&mut results, start_page(wide, Some(ThemeName::Light)), "start_page_light");
    compare_page(&mut results, start_page(small, None), "start_page_small");
    let building = OngoingBuild::default();
    building.run_with_cache(|with| {
        (with.report_news)(News::Making("building walks".into()));
        with.progress.stage_kept("motion");
        (with.report_news)(News::Skipped(
            "/motion/walks/torn.bvh:7:1: expected a channel, found the end of the file".into(),
        ));
        with.progress.begin("graph", 3584, "event frames");
        with.progress.advance(1541);
    });
    for (size, name) in [(wide, "start_page_building"), (small, "start_page_building_small")] {
        let mut v = start_page(size, None);
        v.harness.state_mut().0.model.build = Some(ShownBuild::UnderWay { paths: walks(), building: building.clone() });
        compare_page(&mut results, v, name);
    }
    let told = building.log().clone();
    let why = "/motion/walks: no motion file can be read: /motion/walks/torn.bvh:7:1: expected a channel, found the end \
               of the file. Add files of motion (.bvh, .amc with its .asf, .npz), or name another folder";
    let failed = FinishedBuild { paths: walks(), log: told, end: BuildEnd::Failed(why.into()) };
    let mut v = start_page(wide, None);
    v.harness.state_mut().0.model.build = Some(ShownBuild::Ended(Box::new(failed)));
    compare_page(&mut results, v, "start_page_failed");
}

#[test]
fn a_folder_that_was_dropped() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let folder = tempfile::tempdir().expect("a folder");
    let clips = folder.path().join("walks");
    std::fs::create_dir(&clips).expect("a folder in it");
    walk(&clips, 1.0);
    let mut v = Viewing::new(&Args { characters: Some(12), ..crowd() }, vec2(1280.0, 800.0));
    drop_files(&mut v, &[&clips]);
    v.until("the bundle", |v| v.model().asked == [clips.clone()]);
    compare(&mut results, rest(v), "folder_dropped");
}

#[test]
fn a_clip_with_glitches() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let folder = tempfile::tempdir().expect("a folder");
    let panel = [PanelKind::Database, PanelKind::Report].map(PanelChoice::Open).to_vec();
    let args = Args { file: Some(faulty_bvh(folder.path())), frame: Some(30), panel, ..Args::default() };
    let mut v = at_rest(&args, vec2(1280.0, 800.0));
    let line = v.harness.get_by_label("Timeline").rect();
    // The body is elsewhere from frame 80 on.
    let share = 80.5 / v.model().shown_clip().expect("a clip").0 as f32;
    v.harness.hover_at(egui::pos2(line.left() + share * line.width(), line.bottom() - 8.0));
    v.harness.run_steps(40);
    // In the list and in the tip.
    assert!(v.harness.get_all_by_label_contains("jump: frames 79 to 80").count() > 1);
    // The name of the folder is another one every time.
    let folder = folder.path().display().to_string();
    let named: Vec<Rect> = v.harness.query_all_by_label_contains(&folder).map(|n| n.rect()).collect();
    assert_eq!(named.len(), 3);
    for rect in named {
        v.harness.mask(Rect::from_min_size(rect.left_top(), vec2(440.0, rect.height())));
    }
    compare(&mut results, v, "clip_glitches");
}

#[test]
fn the_list_of_keys() {
    if can_compare() {
        let mut results = SnapshotResults::new();
        let mut v = at_rest(&crowd(), vec2(1000.0, 640.0));
        v.harness.key_press(egui::Key::H);
        v.harness.run_steps(4);
        compare(&mut results, v, "keys");
    }
}

#[test]
fn every_panel() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    for panel in PANELS.iter().filter(|p| p.kind != PanelKind::Hits) {
        let args = Args { panel: vec![PanelChoice::Open(panel.kind)], ..crowd() };
        let size = if panel.kind.dock() == Dock::Side { SIZE } else { vec2(800.0, 560.0) };
        let mut v = at_rest(&args, size);
        if panel.kind == PanelKind::Statistics {
            show_memory(&mut v);
        }
        let name = panel.title.to_lowercase().replace(' ', "_");
        compare(&mut results, v, &format!("panel_{name}"));
    }
}

#[test]
fn world() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let square = Square::new();
    let panel = vec![PanelChoice::Open(PanelKind::Patches)];
    let args = Args { file: Some(square.world(3)), panel, characters: Some(3), ..crowd() };
    let args = Args { character: Some(1), ..args };
    let mut v = at_rest(&args, vec2(1000.0, 640.0));
    // The name of the folder is another one every time.
    let field = v.harness.get_by_label("Save").rect();
    v.harness.mask(Rect::from_min_size(field.right_top(), vec2(500.0, field.height() + 4.0)));
    compare(&mut results, v, "panel_patches_world");
    // A refusal is shown beside the unit.
    let light = Args { theme: Some(ThemeName::Light), character: None, ..args };
    let mut v = at_rest(&light, vec2(1000.0, 640.0));
    v.apply(ViewerCommand::World(WorldCommand::Tool(Tool::Move)));
    v.apply(ViewerCommand::World(WorldCommand::SelectPlace(Some(4))));
    let to = Placement::new(7.4, 0.0, 2.8, 0.0);
    v.apply(ViewerCommand::World(WorldCommand::Edit(UnitChange::Move { place: 4, to })));
    v.until("an answer", |v| v.model().document.world().is_some_and(|w| w.working.is_none()));
    v.harness.run_steps(4);
    compare(&mut results, v, "panel_patches_refused");
}

#[test]
fn blend_spaces() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let paces = Paces::new();
    let panel = vec![PanelChoice::Open(PanelKind::Blend)];
    let args = Args { file: Some(paces.bundle()), panel, characters: None, character: None, ..crowd() };
    let light = Args { theme: Some(ThemeName::Light), ..args.clone() };
    for (args, name) in [(args, "panel_blend_space"), (light, "panel_blend_space_light")] {
        let mut v = Viewing::new(&args, vec2(1000.0, 860.0));
        let mut wanted = *v.model().document.blend().expect("a blend space").1.blending();
        wanted.point[..2].copy_from_slice(&[1.0, 0.25]);
        v.apply(ViewerCommand::Blend(Blending { companions: BlendCompanions::Sizes, ..wanted }));
        compare(&mut results, rest(v), name);
    }
    let scene = Args { file: Some(paces.scene(12, 1.0)), ..crowd() };
    compare(&mut results, at_rest(&scene, VIEW_SIZE), "view_walkers");
}

#[test]
fn scenes_of_crowds() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let meeting = Meeting::new();
    let panel = vec![PanelChoice::Open(PanelKind::Crowd)];
    let args = Args { file: Some(meeting.scene(12)), panel, characters: None, character: Some(5), ..Args::default() };
    let light = Args { theme: Some(ThemeName::Light), ..args.clone() };
    for (args, name) in [(args.clone(), "panel_crowd_scene"), (light, "panel_crowd_scene_light")] {
        let v = rest_at(Viewing::new(&args, vec2(1000.0, 1330.0)), MET);
        compare(&mut results, v, name);
    }
    let control = Args { panel: vec![PanelChoice::Open(PanelKind::Control)], ..args.clone() };
    let mut v = rest_at(Viewing::new(&control, vec2(1000.0, 640.0)), MET);
    // The name of the folder is another one every time.
    let field = v.harness.get_by_label("Snapshot file").rect();
    v.harness.mask(field);
    compare(&mut results, v, "panel_control_scene");
    let alone = Args { panel: vec![PanelChoice::None], ..args };
    let paces = Paces::new();
    let people = Args { file: Some(paces.crowd(8)), ..alone.clone() };
    let light = Args { theme: Some(ThemeName::Light), ..people.clone() };
    for (args, name) in [(people, "view_people"), (light, "view_people_light")] {
        compare(&mut results, rest_at(Viewing::new(&args, SIZE), MET), name);
    }
    let all = SceneViewOptions { bounds: OverlayScope::All, paths: OverlayScope::All, ..SceneViewOptions::default() };
    let flock = Args { file: Some(meeting.flock(12)), ..alone.clone() };
    let light = Args { theme: Some(ThemeName::Light), ..alone.clone() };
    for (args, name) in [(alone, "view_meeting"), (light, "view_meeting_light"), (flock, "view_flock")] {
        let mut v = Viewing::new(&args, SIZE);
        v.apply(ViewerCommand::Scene(SceneCommand::SetOptions(all)));
        compare(&mut results, rest_at(v, MET), name);
    }
}

#[test]
fn scenarios() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let market = Market::new();
    let args = Args {
        file: Some(market.scene(24)),
        panel: vec![PanelChoice::Open(PanelKind::Crowd)],
        characters: None,
        character: Some(5),
        message: Some("sale".into()),
        ..Args::default()
    };
    let light = Args { theme: Some(ThemeName::Light), ..args.clone() };
    for (args, name) in [(args, "panel_crowd_agent_brains"), (light, "panel_crowd_agent_brains_light")] {
        let mut v = Viewing::new(&args, vec2(1000.0, 2150.0));
        let kinds = AgentEventKind::all().map(|what| !what.is_of_engine());
        v.apply(ViewerCommand::Scene(SceneCommand::SetOptions(SceneViewOptions {
            kinds,
            ..v.model().selection.scene
        })));
        compare(&mut results, rest_at(v, MET), name);
    }
}

/// Two motions for one task, while the hand is in the ring.
#[test]
fn a_task_of_limbs() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let task = PathBuf::from("../data/tasks/ring.toml");
    let panel = vec![PanelChoice::Open(PanelKind::Plan)];
    let args = Args { file: Some(task), panel, characters: None, character: None, ..Args::default() };
    let light = Args { theme: Some(ThemeName::Light), ..args.clone() };
    for (args, name) in [(args, "panel_plan_task"), (light, "panel_plan_task_light")] {
        let mut v = Viewing::new(&args, vec2(1100.0, 720.0));
        let options = PlanViewOptions { num_motions: 2, ..v.model().selection.plan };
        v.apply(ViewerCommand::Plan(PlanCommand::SetOptions(options)));
        v.apply(ViewerCommand::Plan(PlanCommand::Plan));
        v.until("two motions", |v| v.model().document.task().is_some_and(|t| t.motions().len() == 2));
        let mut v = rest(v);
        v.apply(ViewerCommand::Seek(51));
        v.harness.run_steps(4);
        compare(&mut results, v, name);
    }
}

#[test]
fn boxing() {
    if !can_compare() {
        return;
    }
    let mut results = SnapshotResults::new();
    let boxing = Boxing::new();
    let bundle = Args { file: Some(boxing.bundle()), ..crowd() };
    let hits = Args { panel: vec![PanelChoice::Open(PanelKind::Hits)], character: None, ..bundle.clone() };
    compare(&mut results, at_rest(&hits, vec2(1000.0, 560.0)), "panel_hits");

    let alone = Args { file: Some(boxing.targets(1)), characters: None, character: Some(0), ..crowd() };
    let policy = Args { panel: vec![PanelChoice::Open(PanelKind::Policy)], ..alone.clone() };
    let mut v = Viewing::new(&policy, vec2(1000.0, 560.0));
    v.apply(ViewerCommand::SelectPolicy(1));
    compare(&mut results, rest(v), "panel_policy_heights");

    compare(&mut results, at_rest(&alone, SIZE), "view_target");
    let pair = Args { file: Some(boxing.pairs(2)), ..alone };
    compare(&mut results, at_rest(&pair, SIZE), "view_pair");
}

/// Times differ from run to run: shows the part of the statistics below them, and hides what is left of them.
fn show_memory(v: &mut Viewing) {
    let panel = v.harness.get_by_label("Statistics").rect();
    let within = panel.left_bottom() + vec2(20.0, 100.0);
    v.harness.hover_at(within);
    v.harness.run_steps(2);
    v.harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: vec2(0.0, -5000.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: egui::Modifiers::NONE,
    });
    v.harness.run_steps(60);
    v.harness.remove_cursor();
    v.harness.run_steps(4);
    let memory = v.harness.get_by_label("Memory of the tables").rect();
    let times = Rect::from_min_max(panel.left_bottom(), egui::pos2(SIZE.x, memory.top()));
    v.harness.mask(times);
}
