//! A character walking in a blend space: the body, the path so far, and the arc of the blended point.

use super::{StageLayout, StagePalette, body, cues};
use crate::render::{CharacterInstance, Rgba};
use crate::run::{BlendCompanions, BlendMoment, BlendRun};
use crate::{bundle::OpenBundle, settings::Overlays};
use glam::Vec3;
use throng_core::{NUM_JOINTS, Planar};

/// Length of the path behind (s).
const TRAIL_S: f32 = 4.0;
/// Steps between two of its points.
const TRAIL_EVERY: u32 = 4;
/// Height of lines above the ground (m).
const ABOVE_M: f32 = 0.012;

pub(super) fn lay_out(out: &mut StageLayout, o: Overlays, bundle: &OpenBundle, run: &BlendRun, palette: &StagePalette) {
    let moment = run.reel.moment();
    let database = bundle.tables().skeleton();
    for (i, (body, &root)) in run.bodies().zip(&moment.roots).enumerate() {
        let pose = &moment.poses[i * NUM_JOINTS..][..NUM_JOINTS];
        body::push_stretched(&mut out.poses, pose, &body::stretch(database, body));
        let colour = colour(run.blending().companions, i, palette);
        out.instances.push(CharacterInstance { root, colour, is_selected: false, look: 0 });
        if o.trails {
            trail(out, run, i, palette);
        }
        cues::body(&mut out.shapes, o, root, pose, moment.contacts[i], palette);
    }
}

/// Characters beside differ in colour from the selected one.
fn colour(beside: BlendCompanions, person: usize, palette: &StagePalette) -> Rgba {
    match (person, beside) {
        (0, _) => palette.on_the_way,
        (_, BlendCompanions::Retargeting) => palette.plain,
        (1, _) => palette.slow,
        _ => palette.reached,
    }
}

fn trail(out: &mut StageLayout, run: &BlendRun, person: usize, palette: &StagePalette) {
    let at = |m: &BlendMoment| m.roots.get(person).map(|r| r.translation().with_y(ABOVE_M));
    let points: Vec<Vec3> = run.reel.moments_before(TRAIL_S, TRAIL_EVERY).filter_map(at).collect();
    cues::trail(&mut out.shapes, &points, 2.0, palette.middle.alpha(0.7));
    let root = run.reel.moment().roots.get(person).copied().unwrap_or(Planar::IDENTITY);
    let foot = root.translation().with_y(ABOVE_M);
    let ahead = root.rotation() * Vec3::Z;
    out.shapes.arrow(foot + ahead * 0.35, foot + ahead * 0.6, 0.012, palette.slow);
}
