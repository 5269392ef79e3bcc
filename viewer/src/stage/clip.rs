//! A clip of the database: the pose at the play head, and poses before and after it.

use super::{StageLayout, StagePalette, cues};
use crate::bundle::OpenBundle;
use crate::model::Model;
use crate::render::CharacterInstance;
use glam::Vec3;
use throng_core::characters::SampleJob;
use throng_core::{Mat3x4, NUM_JOINTS, Planar};

/// Time between two poses of the onion skin (s).
const SKIN_EVERY_S: f32 = 0.4;
/// Poses of the onion skin on either side.
const SKINS: i32 = 4;

pub(super) fn lay_out(out: &mut StageLayout, model: &Model, bundle: &OpenBundle, palette: &StagePalette) {
    let Some(row) = model.shown_row() else { return };
    let record = bundle.tables().clips()[model.selection.clip];
    let ratio = model.player.frame.fract();
    let mut frames = vec![row];
    let mut ratios = vec![if row + 1 < record.first_frame + record.num_frames { ratio } else { 0.0 }];
    let stride = (SKIN_EVERY_S * bundle.rate_hz()).round().max(1.0) as i32;
    let mut ages = vec![0];
    if model.settings.overlays.onion_skin {
        // Ghosts stand still while the play head moves, so that they can be compared.
        let within = (row - record.first_frame) as i32;
        for k in -SKINS..=SKINS + 1 {
            let frame = (within.div_euclid(stride) + k) * stride;
            let apart = (frame - within).abs();
            if apart > stride / 3 && frame >= 0 && frame < record.num_frames as i32 {
                frames.push(record.first_frame + frame as u32);
                ratios.push(0.0);
                ages.push(apart / stride + 1);
            }
        }
    }
    out.poses.resize(frames.len() * NUM_JOINTS, Mat3x4::default());
    let job = SampleJob { motion_set: &bundle.motion_set, frames: &frames, ratios: &ratios, matrices: &mut out.poses };
    if job.run().is_err() {
        out.poses.clear();
        return;
    }
    for (i, &frame) in frames.iter().enumerate() {
        let shown = if bundle.is_made(frame) { palette.target } else { palette.on_the_way };
        let colour = if i == 0 { shown } else { palette.plain.alpha(0.42 / (0.6 + 0.4 * ages[i] as f32)) };
        let root = planar(bundle, frame, ratios[i]);
        out.instances.push(CharacterInstance { root, colour, is_selected: false, look: 0 });
    }
    draw_cues(out, model, bundle, row, palette);
}

fn draw_cues(out: &mut StageLayout, model: &Model, bundle: &OpenBundle, row: u32, palette: &StagePalette) {
    let o = model.settings.overlays;
    if o.trails {
        let record = bundle.tables().clips()[model.selection.clip];
        let rows = (record.first_frame..record.first_frame + record.num_frames).step_by(3);
        let points: Vec<Vec3> = rows.map(|row| bundle.planar(row).translation().with_y(0.012)).collect();
        out.shapes.polyline(&points, 2.0, palette.middle.alpha(0.5));
    }
    if o.contacts {
        cues::hits(&mut out.shapes, model, bundle, row, palette);
    }
    let root = out.instances[0].root;
    let pose = &out.poses[..NUM_JOINTS];
    cues::body(&mut out.shapes, o, root, pose, bundle.tables().contacts()[row as usize], palette);
}

/// Planar root between a row and the next.
fn planar(bundle: &OpenBundle, row: u32, ratio: f32) -> Planar {
    let a = bundle.planar(row);
    if ratio == 0.0 {
        return a;
    }
    let b = bundle.planar(row + 1);
    // Headings are unwrapped within a clip.
    Planar::new(a.x + (b.x - a.x) * ratio, a.z + (b.z - a.z) * ratio, a.heading + (b.heading - a.heading) * ratio)
}
