//! The browser driven as a user would.

use super::*;
use crate::fixtures::{golden, golden_path, mocap::recording};
use crate::panels::graph::links::ActionLink;
use crate::panels::graph::list;
use crate::panels::show_segment;
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
    let from = track.state_from(0).unwrap();
    let action = *list::sorted(bundle, from.state, list::BY_ERROR).last().unwrap();
    let (label, leads) =
        (format!("Go to {}", bundle.describe_segment(action.segment)), show_segment(bundle, action.segment));
    harness.get_by_label(&label).click();
    harness.run();
    assert_eq!(harness.state().commands, [leads]);
}

#[test]
fn actions_equal_those_of_a_full_search() {
    let bundle = golden();
    let (tables, graph) = (bundle.tables(), bundle.tables().graph());
    let mut found = 0;
    for (clip, record) in tables.clips().iter().enumerate() {
        let track = TimelineTrack::from_bundle(&bundle, clip).unwrap();
        let rows = record.first_frame..record.first_frame + record.num_frames;
        for frame in 0..record.num_frames {
            let after = |s: &usize| {
                let row = graph.states[*s].frame;
                rows.contains(&row) && row >= rows.start + frame
            };
            let state = (0..graph.states.len()).filter(after).min_by_key(|s| graph.states[*s].frame);
            let from = track.state_from(frame);
            assert_eq!(from.map(|from| from.state as usize), state);
            let Some((from, state)) = from.zip(state) else { continue };
            let out = list::sorted(&bundle, from.state, list::BY_ERROR);
            let actions = graph.action_offsets[state] as usize..graph.action_offsets[state + 1] as usize;
            let mut expected: Vec<_> =
                actions.map(|a| (graph.action_segments[a], graph.action_errors[a].to_bits())).collect();
            let mut got: Vec<_> = out.iter().map(|w| (w.segment, w.error.to_bits())).collect();
            expected.sort_unstable();
            got.sort_unstable();
            assert_eq!(got, expected);
            assert!(out.is_sorted_by(|a, b| a.error <= b.error));
            let row = rows.start + from.frame;
            let continues = |w: &&ActionLink| graph.segments[w.segment as usize].start == row;
            assert!(out.iter().filter(continues).all(|w| w.error == 0.0));
            found += out.len();
        }
    }
    assert!(found > 100, "{found}");
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
