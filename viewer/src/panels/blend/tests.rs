//! The panel, driven as a user does.

use super::*;
use crate::command::ViewStage;
use crate::fixtures::boxing::Boxing;
use crate::fixtures::golden_path;
use crate::fixtures::paces::Paces;
use crate::panels::tests::{Trial, click, trial};
use crate::run::BlendCompanions;
use eframe::egui::{Key, Modifiers, Pos2, Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use plane::MapPlane;

fn panel(paces: &Paces) -> Harness<'static, Trial<BlendPanelState>> {
    let mut h = trial::<BlendPanelState>(Some(&paces.bundle()), vec2(400.0, 900.0), show);
    h.run_steps(3);
    h
}

fn blending(h: &Harness<'_, Trial<BlendPanelState>>) -> Blending {
    *h.state().model.document.blend().unwrap().1.blending()
}

/// The map as it was drawn.
fn plane(h: &Harness<'_, Trial<BlendPanelState>>) -> MapPlane {
    h.state().state.surface.as_ref().unwrap().key.plane
}

#[test]
fn a_bundle_without_blend_spaces_says_so_and_what_to_do() {
    let boxing = Boxing::new();
    let mut h = trial::<BlendPanelState>(Some(&boxing.bundle()), vec2(400.0, 300.0), show);
    h.run_steps(2);
    h.get_by_label("There is no blend space");
    h.get_by_label_contains("[blend.NAME]");
}

#[test]
fn beside_a_crowd_the_point_waits_until_it_is_shown_walking() {
    let mut h = trial::<BlendPanelState>(Some(&golden_path()), vec2(400.0, 900.0), show);
    h.run_steps(2);
    assert_eq!(h.state().model.shown_stage(), ViewStage::Crowd);
    h.get_by_label("Show it walking").click();
    h.run_steps(2);
    assert_eq!(h.state().model.shown_stage(), ViewStage::Blend);
    assert!(h.query_by_label("Show it walking").is_none());
}

#[test]
fn a_click_beside_the_examples_moves_the_point_and_one_on_an_example_shows_its_weights() {
    let paces = Paces::new();
    let mut h = panel(&paces);
    let plane = plane(&h);
    let to = plane.position_at(0.37, 0.81);
    click(&mut h, to);
    let wanted = plane.moved(&[0.0; 6], to);
    assert_eq!(blending(&h).point, wanted);
    assert_eq!(h.state().model.shown_stage(), ViewStage::Blend);
    let example = 7;
    let at = {
        let bundle = h.state().model.document.bundle().unwrap();
        plane.screen(&bundle.blends[0].examples()[example].parameters)
    };
    click(&mut h, at);
    assert_eq!((h.state().state.example, blending(&h).point), (Some(example), wanted));
    assert_eq!(h.state().state.surface.as_ref().unwrap().key.example, example);
    h.get_by_label("strongest").click();
    h.run_steps(2);
    assert_eq!(h.state().state.example, None);
}

#[test]
fn arrow_keys_move_the_point_once_the_map_has_the_focus() {
    let paces = Paces::new();
    let mut h = panel(&paces);
    h.key_press(Key::ArrowUp);
    h.run_steps(2);
    let before = blending(&h).point;
    let (plane, at) = (plane(&h), plane(&h).position_at(0.45, 0.4));
    click(&mut h, at);
    assert!(h.state().state.has_focus());
    let clicked = blending(&h).point;
    assert_ne!(before, clicked);
    h.key_press(Key::ArrowUp);
    h.key_press_modifiers(Modifiers::SHIFT, Key::ArrowLeft);
    h.run_steps(3);
    let moved = plane.stepped(&plane.stepped(&clicked, 0.0, 0.02), -0.1, 0.0);
    let now = blending(&h).point;
    assert!(now.iter().zip(moved).all(|(a, b)| (a - b).abs() < 1e-4), "{now:?}, expected {moved:?}");
}

#[test]
fn the_body_is_changed_and_others_walk_beside() {
    let paces = Paces::new();
    let mut h = panel(&paces);
    h.get_by_label("sizes").click();
    h.run_steps(2);
    assert_eq!(blending(&h).companions, BlendCompanions::Sizes);
    assert_eq!(h.state().model.document.blend().unwrap().1.bodies().len(), 3);
    h.get_by_label("retarget").click();
    h.run_steps(2);
    assert!(!blending(&h).retarget);
    h.get_by_label("retargeted");
}

#[test]
fn examples_are_listed_by_weight_and_a_click_chooses_one() {
    let paces = Paces::new();
    let mut h = panel(&paces);
    let names = h.state().model.document.bundle().unwrap().blend_meta(0).examples.clone();
    let shown = |h: &Harness<'_, Trial<BlendPanelState>>| -> Vec<Rect> {
        names.iter().filter_map(|n| Some(h.query_by_label(n)?.rect())).collect()
    };
    let few = shown(&h).len();
    assert!((1..20).contains(&few), "{few}");
    h.get_by_label("all").click();
    h.run_steps(3);
    assert_eq!(shown(&h).len(), 20);
    let at: Pos2 = h.get_by_label(&names[19]).rect().center();
    click(&mut h, at);
    assert_eq!(h.state().state.example, Some(19));
}

#[test]
fn another_space_keeps_axes_of_the_same_names() {
    use throng_core::blend::axis;
    let paces = Paces::new();
    let bundle = crate::bundle::OpenBundle::open(&paces.bundle()).unwrap();
    let space = &bundle.blends[0];
    let mut from = Blending::straight_walk(0, space);
    from.point[..2].copy_from_slice(&[1.0, -0.3]);
    let input = BlendPanelInput {
        space,
        meta: bundle.blend_meta(0),
        blending: from,
        moment: &BlendMoment { point: from.point, ..BlendMoment::default() },
        example: 0,
        document: 1,
    };
    let same = carried_over(&input, &from, Blending::straight_walk(3, space), &input.meta.axes);
    assert_eq!((same.space, same.point), (3, from.point));
    assert_eq!(space.axis_of(axis::SPEED), Some(0));
}
