//! The selected character, in a line over the 3-D view.

use super::{show_caption, words};
use crate::model::Model;
use eframe::egui::{Rect, Ui, vec2};

/// Shows the selected character and its activity, at the upper right.
pub fn show(ui: &Ui, rect: Rect, model: &Model) {
    let Some(text) = describe(model) else { return };
    show_caption(ui, rect, text, 0.6, |size| rect.right_top() + vec2(-size.x - 16.0, 12.0));
}

fn describe(model: &Model) -> Option<String> {
    if model.shows_clip() {
        let bundle = model.document.bundle()?;
        let row = model.shown_row()?;
        let first = bundle.tables().clips().get(model.selection.clip)?.first_frame;
        return Some(format!("{}  frame {}", bundle.clip_name(model.selection.clip), row - first));
    }
    if let Some(world) = model.document.world() {
        let c = model.selection.character?;
        let state = world.run.reel.moment().states.get(c)?;
        let tags = &world.bundle().tables().meta().link_tags;
        let patch = world.patch_name(state.node.instance);
        let (activity, goal) = (words::inhabitant_activity(state), words::goal(state.goal, tags));
        return Some(format!("character {c} · {activity} · {goal} · on {patch}"));
    }
    if let Some((bundle, run)) = model.document.blend().filter(|_| model.shows_blend()) {
        let b = run.blending();
        return Some(format!("{} · size {:.2}", bundle.blend_meta(b.space).name, b.size));
    }
    let (scene, who) = (model.document.scene()?, model.selection.character?);
    let plays = scene.chooser(who).map(|c| c.bundle.describe_segment(c.characters.segment(c.number).0));
    let text = words::character(scene.run.simulation(), who)?;
    Some(plays.map_or(text.clone(), |plays| format!("{text} · {plays}")))
}
