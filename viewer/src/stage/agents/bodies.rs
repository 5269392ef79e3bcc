//! Bodies of a crowd's agents, over their discs.

use super::super::{Layout, body, cues};
use super::Brush;
use crate::document::CrowdDocument;
use crate::model::Model;
use crate::render::{CharacterInstance, Emphasis, Rgba};
use crate::run::agents::SeenBodies;
use throng_runtime::NUM_JOINTS;

/// Adds a body for each agent that has one.
pub(super) fn lay_out(
    out: &mut Layout,
    model: &Model,
    (crowd, bodies): (&CrowdDocument, &SeenBodies),
    brush: &Brush<'_>,
    colour: impl Fn(usize) -> Rgba,
) {
    let (skeletons, Some(bundle)) = (&brush.cast.skeletons, crowd.bundle()) else { return };
    let database = bundle.tables().skeleton();
    let stretches: Vec<_> = skeletons.iter().map(|s| body::stretch(database, s)).collect();
    let (selected, o) = (model.selection.character, model.settings.overlays);
    let all = bodies.agents.iter().zip(&bodies.roots).zip(bodies.poses.chunks_exact(NUM_JOINTS));
    for (((&m, &root), pose), &contacts) in all.zip(&bodies.contacts) {
        let m = m as usize;
        body::put(&mut out.poses, pose, &stretches[m % stretches.len()]);
        let is_selected = selected == Some(m);
        let emphasis = if is_selected { Emphasis::Selected } else { Emphasis::None };
        out.instances.push(CharacterInstance { root, colour: colour(m), emphasis });
        if is_selected {
            cues::body(&mut out.shapes, o, (root, pose), contacts, brush.palette);
        }
    }
}

/// The agent whose body was laid out as a character; none if discs are drawn alone.
pub fn of_body(crowd: &CrowdDocument, character: usize) -> Option<usize> {
    Some(*crowd.run().moment().bodies.as_ref()?.agents.get(character)? as usize)
}
