//! The report driven as a user would.

use super::*;
use crate::command::ViewerCommand;
use crate::fixtures::{golden_path, mocap::recording};
use crate::panels::tests::trial;
use eframe::egui::vec2;
use egui_kittest::kittest::Queryable;

#[test]
fn without_a_document_the_panel_says_what_to_do() {
    let mut harness = trial::<ReportPanelState>(None, vec2(400.0, 300.0), show);
    harness.run();
    harness.get_by_label_contains("Open a bundle or a motion file");
}

#[test]
fn a_bundle_tells_what_it_was_made_of() {
    let mut harness = trial::<ReportPanelState>(Some(&golden_path()), vec2(420.0, 1400.0), show);
    harness.run();
    let bundle = crate::fixtures::golden();
    let meta = bundle.tables().meta();
    harness.get_by_label(&meta.generator);
    harness.get_by_label("Copy").click();
    harness.step();
    let copied = harness
        .output()
        .platform_output
        .commands
        .iter()
        .any(|c| matches!(c, eframe::egui::OutputCommand::CopyText(text) if *text == meta.config));
    assert!(copied);
}

#[test]
fn a_click_on_an_excluded_range_goes_there() {
    let Some(path) = recording("snu/single/walk_clockwise.amc") else { return };
    let mut harness = trial::<ReportPanelState>(Some(&path), vec2(420.0, 1400.0), show);
    harness.run();
    let OpenDocument::Clip(raw) = &harness.state().model.document else { panic!("a motion file is open") };
    let (excluded, rate) = (raw.report.excluded.clone(), raw.report.rate_hz);
    assert!(rate > 0.0 && !excluded.is_empty());
    for (reason, start, end) in excluded {
        harness.get_by_label_contains(&format!("{reason}: frames {start} to {end}")).click();
        harness.run();
        assert_eq!(harness.state().commands.last(), Some(&ViewerCommand::Seek(start as u32)));
    }
}

#[test]
fn sources_are_sorted_by_the_column_asked_for() {
    let source = |path: &str, bytes, hash| SourceMeta { path: path.into(), bytes, hash };
    let all = [source("b", 5, 1), source("a", 7, 3), source("c", 6, 2)];
    let rows = |sort: TableSort| {
        let mut rows = [0, 1, 2];
        sort.sort(&mut rows, &ORDERS, &all);
        rows
    };
    assert_eq!(rows(TableSort::default()), [0, 1, 2]);
    assert_eq!(rows(TableSort { column: 0, descending: false }), [1, 0, 2]);
    assert_eq!(rows(TableSort { column: 1, descending: true }), [1, 2, 0]);
    assert_eq!(rows(TableSort { column: 2, descending: false }), [0, 2, 1]);
}
