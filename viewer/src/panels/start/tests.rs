//! The start page driven as a user would.

use super::*;
use crate::command::ViewerCommand;
use crate::panels::SystemDialog;
use crate::panels::tests::trial;
use eframe::egui::{Role, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

#[test]
fn a_card_asks_for_its_scene_and_buttons_for_dialogs() {
    let mut harness = trial::<PanelStates>(None, vec2(1200.0, 780.0), show);
    harness.run_steps(2);
    harness.get_by_role_and_label(Role::Button, "Corridor").click();
    harness.step();
    let asked = harness.state().commands.clone();
    let [ViewerCommand::Open(paths)] = asked.as_slice() else { panic!("{asked:?}") };
    assert!(paths[0].ends_with("data/scenes/corridor.toml") && paths[0].is_file(), "{paths:?}");
    for (label, dialog) in [("Choose a folder…", SystemDialog::Folder), ("Choose files…", SystemDialog::Files)] {
        harness.get_by_label(label).click();
        harness.step();
        assert_eq!(harness.state_mut().state.dialog.take(), Some(dialog));
    }
}

#[test]
fn what_is_missing_is_said_to_be_and_can_be_taken_off_the_list() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = trial::<PanelStates>(None, vec2(1200.0, 780.0), show);
    let absent = folder.path().join("absent.throng");
    let entries = [vec![absent.clone()], vec![folder.path().to_path_buf()]];
    entries.iter().for_each(|e| harness.state_mut().model.settings.remember(e));
    harness.run_steps(3);
    harness.get_by_label("missing");
    assert!(harness.get_by_label("absent.throng").accesskit_node().is_disabled());
    let mut marks: Vec<_> = harness.get_all_by_label("✖").map(|n| n.rect().center()).collect();
    marks.sort_by(|a, b| a.y.total_cmp(&b.y));
    // The latest is the first.
    crate::panels::tests::click(&mut harness, marks[1]);
    assert_eq!(harness.state().model.settings.opened, [entries[1].clone()]);
    harness.run_steps(2);
    assert!(harness.query_by_label("missing").is_none());
    harness.get_by_label(&crate::model::name_of(&entries[1])).click();
    harness.run_steps(2);
    assert_eq!(harness.state().commands.last(), Some(&ViewerCommand::Open(entries[1].clone())));
}
