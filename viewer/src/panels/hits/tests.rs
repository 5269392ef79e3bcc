//! The panel, driven as a user does.

use super::*;
use crate::fixtures::boxing::Boxing;
use crate::fixtures::golden_path;
use crate::panels::tests::{Trial, click, trial};
use eframe::egui::vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

fn panel(boxing: &Boxing) -> Harness<'static, Trial<HitsPanelState>> {
    let mut h = trial::<HitsPanelState>(Some(&boxing.bundle()), vec2(1200.0, 320.0), show);
    h.run_steps(3);
    h
}

#[test]
fn a_bundle_without_hits_says_so_and_what_to_do() {
    let mut h = trial::<HitsPanelState>(Some(&golden_path()), vec2(900.0, 300.0), show);
    h.run_steps(2);
    h.get_by_label("This bundle has no effective hits");
    h.get_by_label_contains("annotate.hits");
}

#[test]
fn a_click_on_a_hit_in_any_view_shows_its_clip_at_its_frame() {
    let boxing = Boxing::new();
    let mut h = panel(&boxing);
    for k in 0..3 {
        let state = &h.state().state;
        let hits = &state.hits.as_ref().unwrap().1;
        let place = state.dots.as_ref().unwrap().0.places[k];
        let at = place.screen(hits[hits.len() / 2].position);
        let all = hits.iter().enumerate().map(|(i, e)| (i, e.position));
        let number = plot::pointed_at(&place, at, all).unwrap();
        click(&mut h, at);
        let bundle = h.state().model.document.bundle().unwrap();
        let expected = bundle.tables().hits()[number].frame;
        let (clip, frame) = clip_frame(bundle, expected);
        assert_eq!(h.state().commands.last(), Some(&ViewerCommand::ShowClip { clip, frame }));
        assert_eq!(h.state().model.shown_row(), Some(expected));
        // The body that is drawn for scale is the one that strikes.
        assert_eq!(h.state().state.body.as_ref().unwrap().0.1, expected);
    }
}

#[test]
fn the_fist_of_the_body_is_where_the_hit_is() {
    let boxing = Boxing::new();
    let bundle = OpenBundle::open(&boxing.bundle()).unwrap();
    for (e, record) in HitPoint::from_bundle(bundle.tables()).iter().zip(bundle.tables().hits()) {
        let body = figure_of_pose(bundle.tables().skeleton(), &bundle.sample_rows(&[record.frame]).unwrap());
        let apart = body.joint(e.joint).distance(e.position);
        // The striking point lies beyond the wrist or the ankle.
        assert!(apart < 0.25, "{apart} m at row {}", record.frame);
    }
}

#[test]
fn only_the_selected_patch_is_counted_and_listed() {
    let boxing = Boxing::new();
    let mut h = panel(&boxing);
    let all = h.state().state.hits.as_ref().unwrap().1.len();
    h.get_by_label(&format!("{all} effective hits"));
    h.state_mut().state.filter.joint = Some(Joint::LeftHand);
    h.run_steps(2);
    let left = h.state().state.hits.as_ref().unwrap().1.iter().filter(|e| e.joint == Joint::LeftHand).count();
    assert!(left > 0 && left < all);
    h.get_by_label(&format!("{left} of {all} hits"));
    h.state_mut().state.filter.joint = Some(Joint::Head);
    h.run_steps(2);
    h.get_by_label("No hit is of this kind and limb");
}
