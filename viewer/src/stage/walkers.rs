//! A scene of walkers: place, body and colour of all characters, and the ground.

use super::{Layout, Palette, body, cues};
use crate::document::WalkersDocument;
use crate::model::Model;
use crate::render::{CharacterInstance, Emphasis, Rgba, SolidInstance};
use crate::settings::Colouring;
use glam::Vec3;
use throng_runtime::NUM_JOINTS;
use throng_runtime::patch::Placement;

/// Speed at which the colour of speed is that of a fast character (m/s).
const FAST_MPS: f32 = 5.0;
/// Most characters whose cues are drawn.
const MAX_CUES: usize = 2000;
/// Length of trails (s).
const TRAIL_S: f32 = 6.0;
/// Lines on the ground lie so much above it (m).
const ABOVE_M: f32 = 0.015;

pub(super) fn lay_out(out: &mut Layout, model: &Model, scene: &WalkersDocument, palette: &Palette, dark: bool) {
    let (moment, database) = (scene.run().moment(), scene.bundle().tables().skeleton());
    let selected = model.selection.character;
    let colours = if dark { [0x4a4f57, 0x434850] } else { [0xd2d4d5, 0xc4c6c8] };
    let at_origin = Placement::new(0.0, 0.0, 0.0, 0.0);
    let fields = (0..scene.hills().len() as u32).zip(colours.map(Rgba::hex));
    out.solids.instances.extend(fields.map(|(mesh, colour)| SolidInstance { mesh, placement: at_origin, colour }));
    for (c, (&root, pose)) in moment.roots.iter().zip(moment.poses.chunks_exact(NUM_JOINTS)).enumerate() {
        body::put(&mut out.poses, pose, &body::stretch(database, scene.body(c)));
        out.instances.push(CharacterInstance {
            root,
            colour: colour(model, scene, c, palette),
            emphasis: if selected == Some(c) { Emphasis::Selected } else { Emphasis::None },
        });
    }
    let mut o = model.settings.overlays;
    // On hills, marks on level ground would be hidden.
    o.contacts &= scene.hills().is_empty();
    let n = moment.roots.len();
    let count = if o.of_all { n.min(MAX_CUES) } else { 0 };
    for c in (0..count).chain(selected.filter(|&c| c >= count && c < n)) {
        let (root, pose) = (moment.roots[c], &moment.poses[c * NUM_JOINTS..][..NUM_JOINTS]);
        if o.trails {
            let points: Vec<Vec3> = scene.run().trail(c, TRAIL_S).map(|p| p + Vec3::Y * ABOVE_M).collect();
            out.shapes.polyline(&points, 2.0, palette.selected.alpha(0.7));
        }
        cues::body(&mut out.shapes, o, (root, pose), moment.contacts[c], palette);
    }
}

/// By the blend space, or the speed.
fn colour(model: &Model, scene: &WalkersDocument, c: usize, palette: &Palette) -> Rgba {
    match model.settings.colouring {
        Colouring::Plain => palette.plain,
        Colouring::Speed => palette.slow.mix(palette.fast, (scene.run().moment().speeds[c] / FAST_MPS).min(1.0)),
        // Characters take the spaces in turn.
        Colouring::Target | Colouring::Clip => cues::category(c % scene.scene().spaces.len()),
    }
}
