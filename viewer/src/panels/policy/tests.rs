//! The panel, driven as a user does.

use super::*;
use crate::document::SceneDocument;
use crate::fixtures::boxing::Boxing;
use crate::fixtures::quietly;
use crate::fixtures::{golden, golden_path};
use crate::settings::ViewerSettings;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// Characters of the bundle that every checkout has, after some seconds.
pub fn golden_run(temperature: f32) -> SceneDocument {
    let folder = tempfile::tempdir().unwrap();
    let (path, bundle) = (folder.path().join("walk.toml"), golden());
    let (file, behaviour) = (bundle.path.display(), &bundle.tables().meta().behaviours[0]);
    let group = format!("motion = 'policy'\ncount = 12\ntemperature = {temperature:?}\ntarget = {{ height_m = 0.0 }}");
    let text = format!("bundle = '{file}'\n[[groups]]\n{group}\nbehaviours = [{{ name = '{behaviour}' }}]\n");
    std::fs::write(&path, text).unwrap();
    let mut scene = quietly(|with| SceneDocument::open(&path, with)).unwrap();
    (0..150).for_each(|_| scene.run.step().unwrap());
    scene
}

struct Panel {
    model: Model,
    state: PolicyPanelState,
    commands: Vec<ViewerCommand>,
}

fn panel(prepare: impl FnOnce(&mut Model)) -> Harness<'static, Panel> {
    panel_of_width(620.0, prepare)
}

fn panel_of_width(width: f32, prepare: impl FnOnce(&mut Model)) -> Harness<'static, Panel> {
    let mut model = Model::new(ViewerSettings::default());
    quietly(|with| model.open_now(&golden_path(), with)).unwrap();
    prepare(&mut model);
    let panel = Panel { model, state: PolicyPanelState::default(), commands: Vec::new() };
    Harness::builder()
        .with_size([width, 1000.0])
        .build_ui_state(|ui, p: &mut Panel| show(ui, &p.model, &mut p.state, &mut p.commands), panel)
}

#[test]
fn without_a_selection_it_says_what_to_do() {
    let mut h = panel(|_| {});
    h.step();
    h.get_by_label("select character 0").click();
    h.step();
    assert_eq!(h.state().commands, [ViewerCommand::SelectCharacter(Some(0))]);
    assert!(h.state().state.heats.is_empty());
}

#[test]
fn the_motion_of_a_candidate_can_be_shown() {
    let mut h = panel(|m| m.selection.character = Some(4));
    h.step();
    let chooser = h.state().model.document.chooser(4).unwrap();
    let (bundle, why) = (chooser.bundle, explain_choice(&chooser).unwrap());
    let second = why.candidates[1].segment;
    let record = bundle.tables().graph().segments[second as usize];
    let frame = record.start - bundle.tables().clips()[record.clip as usize].first_frame;
    let label = format!("Candidate {}", bundle.describe_segment(second));
    h.get_by_label(&label).click();
    h.step();
    assert_eq!(h.state().state.picked, Some(second));
    h.get_by_label("Show motion").click();
    h.step();
    assert_eq!(h.state().commands, [ViewerCommand::ShowClip { clip: record.clip as usize, frame }]);
}

#[test]
fn the_picture_is_kept_until_what_it_shows_changes() {
    let mut h = panel(|m| m.selection.state = Some(3));
    h.step();
    let first = h.state().state.heats[0].clone();
    h.step();
    assert!(std::sync::Arc::ptr_eq(&first.mesh, &h.state().state.heats[0].mesh));
    h.state_mut().model.selection.state = Some(4);
    h.step();
    let other = &h.state().state.heats[0];
    assert_eq!(other.key.state, 4);
    assert!(!std::sync::Arc::ptr_eq(&first.mesh, &other.mesh));
}

#[test]
fn the_chosen_action_and_its_reason_fit_a_narrow_panel() {
    // A panel of the usual width is 370 points wide, part of which its scroll bar may take.
    for width in [400.0, 370.0, 340.0] {
        let mut h = panel_of_width(width, |m| m.selection.character = Some(4));
        h.run_steps(2);
        let mut left = 0.0;
        for title in ["#", "plays", "score", "gap", "chance"] {
            let rect = h.get_by_label(title).rect();
            assert!(rect.left() >= left && rect.right() <= width, "{title} at {rect} of {width}");
            left = rect.right();
        }
        assert!(h.query_by_label("leads").is_none());
    }
    let mut h = panel(|m| m.selection.character = Some(4));
    h.run_steps(2);
    h.get_by_label("leads");
}

#[test]
fn a_choice_of_few_candidates_leaves_the_length_of_the_list_as_it_was() {
    let mut h = panel(|m| m.selection.character = Some(4));
    h.state_mut().state.shown = 1000;
    h.run_steps(2);
    assert_eq!(h.state().state.shown, 1000);
}

#[test]
fn all_heights_are_shown_with_the_same_colours_and_a_click_looks_at_one() {
    let boxing = Boxing::new();
    let mut model = Model::new(ViewerSettings::default());
    quietly(|with| model.open_now(&boxing.bundle(), with)).unwrap();
    model.selection.state = Some(0);
    for (policy, heights, name) in [(1, 3, "high"), (2, 4, "left")] {
        model.selection.policy = policy;
        let panel =
            Panel { model: std::mem::take(&mut model), state: PolicyPanelState::default(), commands: Vec::new() };
        let mut h = Harness::builder()
            .with_size([420.0, 900.0])
            .build_ui_state(|ui, p: &mut Panel| show(ui, &p.model, &mut p.state, &mut p.commands), panel);
        h.run_steps(2);
        let heats = &h.state().state.heats;
        assert_eq!(heats.len(), heights);
        assert!(heats.iter().all(|k| k.range == heats[0].range));
        assert!(heats.windows(2).all(|k| k[0].key.height + 1 == k[1].key.height));
        let bundle = h.state().model.document.bundle().unwrap();
        let label = chart::PolicyChart::new(&bundle.motion_set.policy(policy).unwrap().grid_of(0)).height_name(1);
        assert!(label.ends_with(name), "{label}");
        h.get_by_label(&format!("Values {label}")).click();
        h.run_steps(2);
        let state = &h.state().state;
        assert!(!state.slices && state.slice == 1 && state.heats.len() == 1);
        model = std::mem::take(&mut h.state_mut().model);
    }
}
