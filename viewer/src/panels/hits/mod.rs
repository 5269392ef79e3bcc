//! Effective hits: where blows land, seen from three sides (Lee and Lee 2004, figure 4).

mod collection;
mod plot;

use super::paint::{PanelWidget, TableSort, choose, empty, figure_of_pose, legend, no_bundle};
use super::{clip_frame, policy::behaviour_name, words};
use crate::command::{Commands, ViewerCommand};
use crate::theme::{ThemePalette, viridis};
use crate::{bundle::OpenBundle, model::Model, volume::Volume};
use collection::{HitFilter, HitRanges, joint_name, moment};
use eframe::egui::epaint::Mesh;
use eframe::egui::{CentralPanel, Color32, Frame, Panel, Response, RichText, Role, Sense, Ui, Visuals};
use glam::{Vec2, Vec3};
use plot::{HitBounds, HitViewPlace};
use std::{collections::BTreeSet, iter::once};
use throng_core::{Joint, policy::PolicyTable};
use throng_precompute::{annotate::hits::HitPoint, picture::BodyFigure};

/// Width from which on the list lies beside the views (points).
const WIDE: f32 = 700.0;

/// Meaning of the colours of hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum HitColouring {
    /// Force of the blow.
    #[default]
    Force,
    /// Joint that strikes.
    Limb,
}

/// View settings of the panel, and cached results.
#[derive(Clone, Debug, Default)]
pub struct HitsPanelState {
    hits: Option<(u64, Vec<HitPoint>)>,
    filter: HitFilter,
    colours: HitColouring,
    /// Behaviour whose volume is drawn; without a choice, the first one with heights.
    outlined: Option<Option<usize>>,
    sort: TableSort,
    /// The body shown for scale, with its document and frame row.
    body: Option<((u64, u32), BodyFigure)>,
    dots: Option<(HitDotsKey, [Mesh; 3])>,
    /// Hit under the pointer in the frame before, and true if it was in the list.
    hovered: Option<(usize, bool)>,
}

/// Key of the dots.
#[derive(Clone, Debug, PartialEq)]
struct HitDotsKey {
    document: u64,
    filter: HitFilter,
    colours: HitColouring,
    dark: bool,
    places: [HitViewPlace; 3],
}

/// Hits that are shown.
struct HitsInput<'a> {
    bundle: &'a OpenBundle,
    /// All hits, in the order of the bundle.
    hits: &'a [HitPoint],
    /// Numbers of the selected hits, in the order of the list.
    shown: &'a [usize],
    /// Ranges over the selected hits; none without any.
    ranges: Option<HitRanges>,
    /// Number of the hit under the pointer, or else of the one that is shown as a clip.
    standing_out: Option<usize>,
}

/// Input shared by all views.
struct HitViewInput<'a> {
    body: Option<&'a BodyFigure>,
    outlined: Option<&'a PolicyTable>,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut HitsPanelState, commands: &mut Commands) {
    let Some(bundle) = model.document.bundle() else {
        if model.document.raw_motion().is_some() {
            return empty(ui, "Hits are part of a bundle", "Build one from this motion, then open it.");
        }
        return no_bundle(ui, &model.document);
    };
    if state.hits.as_ref().is_none_or(|h| h.0 != model.generation) {
        let (colours, sort) = (state.colours, state.sort);
        *state = HitsPanelState { colours, sort, ..HitsPanelState::default() };
        state.hits = Some((model.generation, HitPoint::from_bundle(bundle.tables())));
    }
    let Some((_, hits)) = state.hits.take() else { return };
    if hits.is_empty() {
        empty(ui, "This bundle has no effective hits", NO_HITS);
    } else {
        show_hits(ui, model, &hits, state, commands);
    }
    state.hits = Some((model.generation, hits));
}

const NO_HITS: &str = "A hit is where a fist or foot moves fast along its limb. Build from clips with blows \
     (`throng synth --set boxing` makes some), lower the thresholds in `annotate.hits`, or mark hits in sidecar files.";

fn show_hits(ui: &mut Ui, model: &Model, hits: &[HitPoint], state: &mut HitsPanelState, commands: &mut Commands) {
    let Some(bundle) = model.document.bundle() else { return };
    let shown = collection::select_hits(hits, &state.filter, state.sort);
    let playing = model.shown_row().filter(|_| model.shows_clip());
    let playing = playing.and_then(|row| shown.iter().copied().find(|&i| bundle.tables().hits()[i].frame == row));
    let before = state.hovered.take();
    let standing_out = before.map(|h| h.0).filter(|i| shown.contains(i)).or(playing);
    let input = HitsInput { bundle, hits, shown: &shown, ranges: HitRanges::over(hits, &shown), standing_out };
    options(ui, &input, state);
    summary(ui, &input);
    if shown.is_empty() {
        return empty(ui, "No hit is of this kind and limb", "Choose other ones above.");
    }
    let mut chosen = None;
    if ui.available_width() >= WIDE {
        let scrolls = before.is_some_and(|h| !h.1);
        let panel = Panel::right("list of hits").default_size(400.0).min_size(200.0);
        panel.frame(Frame::NONE.inner_margin(4)).show(ui, |ui| {
            let listed = collection::show_list(ui, &input, &mut state.sort, scrolls);
            chosen = listed.chosen.map(|row| shown[row]);
            state.hovered = listed.hovered.map(|(row, _)| (shown[row], true));
        });
    }
    CentralPanel::default_margins().frame(Frame::NONE.inner_margin(2)).show(ui, |ui| {
        chosen = chosen.or(views(ui, model, &input, state));
    });
    let chosen = chosen.map(|i: usize| clip_frame(bundle, bundle.tables().hits()[i].frame));
    commands.extend(chosen.map(|(clip, frame)| ViewerCommand::ShowClip { clip, frame }));
}

fn options(ui: &mut Ui, &HitsInput { bundle, hits, ranges, .. }: &HitsInput<'_>, state: &mut HitsPanelState) {
    ui.horizontal_wrapped(|ui| {
        let kinds: BTreeSet<&String> = hits.iter().map(|h| &h.kind).collect();
        let kinds = kinds.into_iter().map(|k| (Some(k.clone()), k.clone()));
        let kinds = once((None, "all kinds".to_owned())).chain(kinds);
        choose(ui, "Kind", Some(84.0), &mut state.filter.kind, kinds);
        let present: BTreeSet<Joint> = hits.iter().map(|h| h.joint).collect();
        let joints = present.iter().map(|&j| (Some(j), joint_name(j)));
        let joints = once((None, "all limbs".to_owned())).chain(joints);
        choose(ui, "Limb", Some(94.0), &mut state.filter.joint, joints);
        outline_choice(ui, bundle, state);
        ui.separator();
        ui.label("colour");
        ui.selectable_value(&mut state.colours, HitColouring::Force, "force");
        ui.selectable_value(&mut state.colours, HitColouring::Limb, "limb");
        let visuals = ui.visuals().clone();
        match (state.colours, ranges) {
            (HitColouring::Force, Some(r)) => legend(ui, r.force, "", |t| viridis::line(t, visuals.dark_mode)),
            (HitColouring::Limb, _) => {
                for joint in present {
                    ui.colored_label(limb_colour(joint, &visuals), joint_name(joint));
                }
            }
            _ => {}
        }
    });
}

/// Behaviours that have a volume to be drawn.
fn volumes(bundle: &OpenBundle) -> impl Iterator<Item = (usize, &PolicyTable)> {
    let all = bundle.tables().policies().iter().enumerate();
    all.filter(|(_, p)| !p.grid().is_polar() || Volume::of_region(p.region()).is_some())
}

fn outlined(bundle: &OpenBundle, state: &HitsPanelState) -> Option<usize> {
    state.outlined.unwrap_or_else(|| volumes(bundle).find(|v| !v.1.grid().is_polar()).map(|v| v.0))
}

fn outline_choice(ui: &mut Ui, bundle: &OpenBundle, state: &mut HitsPanelState) {
    if volumes(bundle).next().is_none() {
        return;
    }
    let now = outlined(bundle, state);
    let mut chosen = now;
    let named = volumes(bundle).map(|(p, _)| (Some(p), format!("grid of {}", behaviour_name(bundle, p))));
    let options = once((None, "no grid".to_owned())).chain(named);
    let tip = "Where a behaviour has values, and, dashed, where it is active";
    choose(ui, "Grid", None, &mut chosen, options).on_hover_text(tip);
    if chosen != now {
        state.outlined = Some(chosen);
    }
}

fn summary(ui: &mut Ui, input: &HitsInput<'_>) {
    let Some(r) = input.ranges else { return };
    let (shown, all) = (input.shown.len(), input.hits.len());
    let count = if shown == all { format!("{all} effective hits") } else { format!("{shown} of {all} hits") };
    let span = |[low, high]: [f32; 2]| format!("{low:.2} to {high:.2}");
    ui.horizontal_wrapped(|ui| {
        ui.strong(count);
        ui.label(format!("angle {} rad, distance {} m, height {} m", span(r.angle), span(r.distance), span(r.height)));
    });
}

/// Shows the three views; returns the hit that was clicked.
fn views(ui: &mut Ui, model: &Model, input: &HitsInput<'_>, state: &mut HitsPanelState) -> Option<usize> {
    let &HitsInput { bundle, hits, shown, ranges, standing_out } = input;
    let (rect, _) = ui.allocate_exact_size(ui.available_size(), Sense::hover());
    let outlined = outlined(bundle, state).and_then(|p| bundle.motion_set.policy(p));
    let edges = outlined.into_iter().flat_map(outline_points);
    let seen = hits.iter().map(|e| e.position).chain(edges).collect::<Vec<_>>();
    let bounds = HitBounds::around(seen.iter().copied());
    let places = HitViewPlace::lay_out(bounds, rect);
    let visuals = ui.visuals().clone();
    let standing = || bundle.tables().graph().states.iter().find(|s| s.standing != 0).map_or(0, |s| s.frame);
    let row = standing_out.map_or_else(standing, |i| bundle.tables().hits()[i].frame);
    if state.body.as_ref().is_none_or(|b| b.0 != (model.generation, row)) {
        let figure = |pose: Vec<_>| figure_of_pose(bundle.tables().skeleton(), &pose);
        state.body = bundle.sample_rows(&[row]).map(|pose| ((model.generation, row), figure(pose)));
    }
    let (document, dark) = (model.generation, visuals.dark_mode);
    let key = HitDotsKey { document, filter: state.filter.clone(), colours: state.colours, dark, places };
    if state.dots.as_ref().is_none_or(|d| d.0 != key) {
        let colour = |e: &HitPoint| colour(e, state.colours, ranges, &visuals);
        let of = |p: &HitViewPlace| plot::dots(p, shown.iter().map(|&i| &hits[i]).map(|e| (e.position, colour(e))));
        state.dots = Some((key, places.each_ref().map(of)));
    }
    let scene = HitViewInput { body: state.body.as_ref().map(|b| &b.1), outlined };
    let painter = ui.painter_at(rect);
    let mut clicked = None;
    for (k, place) in places.iter().enumerate() {
        let dots = state.dots.as_ref().map(|d| d.1[k].clone()).unwrap_or_default();
        plot::paint(&painter, &visuals, place, &scene, dots);
        if let Some(e) = standing_out.map(|i| &hits[i]) {
            plot::paint_mark(&painter, place, e, colour(e, state.colours, ranges, &visuals), &visuals);
        }
        let name = format!("Hits, {} view", place.view.title().to_lowercase());
        let response = ui.interact(place.rect, ui.scope_id().with(&name), Sense::click()).named(Role::Canvas, name);
        let Some(at) = response.hover_pos() else { continue };
        let places = shown.iter().map(|&i| (i, hits[i].position));
        if let Some(hit) = plot::pointed_at(place, at, places) {
            state.hovered = Some((hit, false));
            clicked = response.clicked().then_some(hit).or(clicked);
            show_tooltip(response, &hits[hit]);
            ui.ctx().request_repaint();
        }
    }
    clicked
}

/// Corners of the outline of a behaviour (m).
fn outline_points(policy: &PolicyTable) -> Vec<Vec3> {
    let of_grid = (!policy.grid().is_polar()).then(|| Volume::of_grid(policy));
    let volumes = of_grid.into_iter().chain(Volume::of_region(policy.region()));
    let of_volume = |v: Volume| {
        let [low, high] = v.height;
        let ends = move |p: Vec2| [low, high].map(|y| Vec3::new(p.x, y, p.y));
        v.over_ground().into_iter().flat_map(ends).collect::<Vec<_>>()
    };
    volumes.flat_map(of_volume).collect()
}

/// Shows a tooltip about a hit.
fn show_tooltip(response: Response, e: &HitPoint) {
    response.on_hover_ui_at_pointer(|ui| {
        ui.label(RichText::new(format!("{}, {}", e.kind, joint_name(e.joint))).strong());
        ui.label(format!("force {:.2}, {:.1} m/s", e.force, e.speed_mps));
        let place = words::place(Vec2::new(e.position.x, e.position.z));
        ui.label(format!("{place}, {:.2} m high", e.position.y));
        ui.label(format!("{}, frame {}", moment(e), e.frame));
        ui.weak("A click shows the clip at this frame.");
    });
}

fn colour(e: &HitPoint, colours: HitColouring, ranges: Option<HitRanges>, visuals: &Visuals) -> Color32 {
    match colours {
        HitColouring::Force => {
            viridis::line(viridis::ratio(e.force, ranges.map_or([0.0, 1.0], |r| r.force)), visuals.dark_mode)
        }
        HitColouring::Limb => limb_colour(e.joint, visuals),
    }
}

fn limb_colour(joint: Joint, visuals: &Visuals) -> Color32 {
    let p = ThemePalette::for_visuals(visuals);
    match joint {
        Joint::LeftHand => p.left,
        Joint::RightHand => p.right,
        Joint::LeftFoot => p.standing,
        Joint::RightFoot => p.state,
        other => p.of_name(other.name()),
    }
}

#[cfg(test)]
mod tests;
