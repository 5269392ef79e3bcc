//! A clip of the database, with poses before and after the play head; a motion file: what was recorded, and what a build makes of it.

use super::{StageLayout, StagePalette, cues};
use crate::render::mesh::BodySide;
use crate::{bundle::OpenBundle, document::RawMotion, model::Model, render::CharacterInstance};
use glam::Vec3;
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Planar, characters::SampleJob};

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

/// Offset of the source's joints from the body (m).
const BESIDE: Vec3 = Vec3::new(1.1, 0.0, 0.0);

pub(super) fn lay_out_raw(out: &mut StageLayout, model: &Model, motion: &RawMotion, palette: &StagePalette) {
    source(out, model, motion, palette);
    let Some(clip) = motion.clips.clips.first() else { return };
    out.skeleton.clone_from(&motion.clips.skeleton);
    let frame = motion.clip_frame(model.player.frame);
    let joints = clip.joint_transforms(&motion.clips.skeleton, frame);
    out.poses.extend(joints.map(|(p, r)| Mat3x4::from_rotation_translation(r, p)));
    let colour = if clip.is_usable(frame) { palette.on_the_way } else { palette.plain };
    out.instances.push(CharacterInstance { root: Planar::IDENTITY, colour, is_selected: false, look: 0 });
    let o = model.settings.overlays;
    if o.trails {
        let points: Vec<Vec3> =
            (0..clip.num_frames()).step_by(3).map(|f| clip.root_positions[f].with_y(0.012)).collect();
        out.shapes.polyline(&points, 2.0, palette.middle.alpha(0.5));
    }
    let contacts = clip.contacts.get(frame).copied().unwrap_or_default();
    cues::body(&mut out.shapes, o, Planar::IDENTITY, &out.poses, contacts, palette);
}

/// The source's joints as limbs and balls, left and right in their colours.
fn source(out: &mut StageLayout, model: &Model, motion: &RawMotion, palette: &StagePalette) {
    let raw = &motion.imported.clip;
    if raw.num_frames == 0 {
        return;
    }
    let frame = (model.player.frame as usize).min(raw.num_frames - 1);
    let world = raw.world(frame);
    // Balls at joints are scaled with the body, so that they stand out from limbs.
    let radius = (0.011 * motion.imported.height / 1.7).clamp(0.003, 0.03);
    let hips = motion.imported.roles.get(Joint::Hips);
    for (j, ((joint, &(at, rotation)), side)) in raw.joints.iter().zip(&world).zip(sides(motion)).enumerate() {
        let colour = match side {
            BodySide::Left => palette.left,
            BodySide::Right => palette.right,
            BodySide::Middle => palette.middle,
        };
        // The connection from the origin to the hips is not a limb.
        if let Some(parent) = joint.parent.filter(|_| hips != Some(j)) {
            out.shapes.capsule(world[parent].0 + BESIDE, at + BESIDE, radius, colour.mix(palette.middle, 0.25));
        }
        if !joint.is_end {
            out.shapes.sphere(at + BESIDE, radius * 1.9, colour);
        }
        if model.settings.overlays.joint_axes {
            out.shapes.axes(at + BESIDE, rotation, 0.07, 1.5);
        }
    }
}

/// Side of each of the source's joints: from its role, or else from its parent (number of joints).
fn sides(motion: &RawMotion) -> Vec<BodySide> {
    let joints = &motion.imported.clip.joints;
    let mut sides: Vec<BodySide> = Vec::with_capacity(joints.len());
    for (j, joint) in joints.iter().enumerate() {
        let role = Joint::ALL.into_iter().find(|&role| motion.imported.roles.get(role) == Some(j));
        sides.push(match (role, joint.parent) {
            (Some(role), _) => BodySide::of_joint(role),
            (None, Some(parent)) => sides[parent],
            (None, None) => BodySide::Middle,
        });
    }
    sides
}
