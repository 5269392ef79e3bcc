//! The browser driven as a user would.

use super::*;
use crate::fixtures::{golden_path, mocap::recording};
use crate::panels::tests::{Trial, click, trial};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, MouseWheelSource, Pos2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

type Browser = Harness<'static, Trial<DatabasePanelState>>;

fn browser() -> Browser {
    let mut harness = trial::<DatabasePanelState>(Some(&golden_path()), vec2(1300.0, 320.0), show);
    harness.run();
    harness
}

fn names(harness: &Browser) -> Vec<String> {
    let bundle = harness.state().model.document.bundle().unwrap();
    (0..bundle.tables().clips().len()).map(|c| bundle.clip_name(c).to_owned()).collect()
}

/// A place in the timeline: 0 at its left edge, 1 at its right one.
fn place(harness: &Browser, ratio: f32) -> Pos2 {
    let rect = harness.get_by_label("Timeline").rect();
    pos2(rect.left() + ratio * rect.width(), rect.center().y)
}

#[test]
fn without_a_document_the_panel_says_what_to_do() {
    let mut harness = trial::<DatabasePanelState>(None, vec2(900.0, 300.0), show);
    harness.run();
    harness.get_by_label_contains("Open a bundle or a motion file");
}

#[test]
fn a_search_leaves_what_matches_and_is_cleared() {
    let mut harness = browser();
    let names = names(&harness);
    assert!(names.len() > 1);
    harness.get_by_role_and_label(Role::TextInput, "Search").focus();
    harness.run();
    harness.get_by_role_and_label(Role::TextInput, "Search").type_text(&names[1]);
    harness.run();
    let matching = names.iter().filter(|n| n.contains(&names[1])).count();
    harness.get_by_label(&format!("{matching} of {}", names.len()));
    harness.get_by_role_and_label(Role::TextInput, "Search").type_text(" no such word");
    harness.run();
    harness.get_by_label_contains("No clip matches");
    harness.get_by_label("Clear").click();
    harness.run();
    harness.get_by_label(&format!("{} clips", names.len()));
}

#[test]
fn a_click_selects_a_clip_and_the_arrow_keys_go_on_from_it() {
    let mut harness = browser();
    let names = names(&harness);
    harness.get_by_label(&names[1]).click();
    harness.run();
    assert_eq!(harness.state().commands, [ViewerCommand::ShowClip { clip: 1, frame: 0 }]);
    harness.key_press(Key::ArrowUp);
    harness.run();
    assert_eq!(harness.state().commands.last(), Some(&ViewerCommand::ShowClip { clip: 0, frame: 0 }));
    harness.key_press(Key::End);
    harness.run();
    assert_eq!(harness.state().commands.last(), Some(&ViewerCommand::ShowClip { clip: names.len() - 1, frame: 0 }));
}

#[test]
fn a_click_on_a_title_sorts_and_a_second_one_turns_the_order_round() {
    let mut harness = browser();
    let rows = |h: &Browser| h.state().state.list.rows().to_vec();
    harness.get_by_label("Sort by Length").click();
    harness.run();
    let ascending = rows(&harness);
    harness.get_by_label("Sort by Length").click();
    harness.run();
    let clips = harness.state().model.document.bundle().unwrap().tables().clips();
    assert!(ascending.is_sorted_by_key(|c| clips[*c].num_frames));
    assert!(rows(&harness).is_sorted_by_key(|c| std::cmp::Reverse(clips[*c].num_frames)));
    assert!(harness.state().commands.is_empty());
}

#[test]
fn a_click_on_the_timeline_goes_there() {
    let mut harness = browser();
    let n = harness.state().model.document.bundle().unwrap().tables().clips()[0].num_frames;
    let middle = place(&harness, 0.5);
    click(&mut harness, middle);
    let frame = harness.state().model.player.frame;
    assert!((frame - 0.5 * n as f32).abs() <= 1.0, "{frame} of {n}");
    assert_eq!(harness.state().commands, [ViewerCommand::ShowClip { clip: 0, frame: frame as u32 }]);
    let end = place(&harness, 0.999);
    click(&mut harness, end);
    assert_eq!(harness.state().model.player.frame, (n - 1) as f32);
}

#[test]
fn the_wheel_zooms_about_the_pointer_and_fit_shows_all_again() {
    let mut harness = browser();
    let at = place(&harness, 0.25);
    click(&mut harness, at);
    let before = harness.state().model.player.frame;
    let (unit, delta) = (eframe::egui::MouseWheelUnit::Point, vec2(0.0, 300.0));
    let phase = eframe::egui::TouchPhase::Move;
    harness.event(eframe::egui::Event::MouseWheel {
        unit,
        delta,
        phase,
        modifiers: Default::default(),
        source: MouseWheelSource::Wheel,
    });
    harness.run_steps(8);
    assert!(harness.state().state.view.span.is_some());
    click(&mut harness, at + vec2(1.0, 0.0));
    assert!((harness.state().model.player.frame - before).abs() <= 1.0);
    harness.get_by_label("Fit").click();
    harness.run_steps(2);
    assert!(harness.state().state.view.span.is_none());
}

#[test]
fn an_action_leads_to_the_start_of_its_segment() {
    let mut harness = browser();
    let bundle = harness.state().model.document.bundle().unwrap();
    let clip = harness.state().model.selection.clip;
    let track = TimelineTrack::from_bundle(bundle, clip).unwrap();
    let out = OutgoingActions::from_frame(bundle, clip, &track, 0).unwrap();
    let action = *out.actions.last().unwrap();
    let label =
        format!("Go to {} {}–{}", bundle.clip_name(action.clip), action.start, action.start + action.num_frames);
    harness.get_by_label(&label).click();
    harness.run();
    assert_eq!(harness.state().commands, [ViewerCommand::ShowClip { clip: action.clip, frame: action.start }]);
}

#[test]
fn a_motion_file_is_scrubbed_in_frames_of_the_file() {
    let Some(path) = recording("cmu-asfamc/02/02_01.amc") else { return };
    let mut harness = trial::<DatabasePanelState>(Some(&path), vec2(1000.0, 320.0), show);
    harness.run_steps(3);
    let OpenDocument::Clip(raw) = &harness.state().model.document else { panic!("a motion file is open") };
    let n = raw.imported.clip.num_frames as f32;
    let rect = harness.get_by_label("Timeline").rect();
    click(&mut harness, rect.center());
    let frame = harness.state().model.player.frame;
    assert!((frame - 0.5 * n).abs() < 0.02 * n, "{frame} of {n}");
    assert!(matches!(harness.state().commands[..], [ViewerCommand::Seek(_)]));
}
