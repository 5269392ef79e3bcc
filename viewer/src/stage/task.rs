//! A task of limbs: characters and things at the play head, other motions, paths of hands, and the trees of searches.

use super::{StageLayout, StagePalette, cues};
use crate::render::{CharacterInstance, Rgba, SolidInstance};
use crate::{document::TaskDocument, model::Model};
use glam::DVec3;
use std::sync::Arc;
use throng_core::{Mat3x4, NUM_JOINTS, Planar, Skeleton};
use throng_planner::task::{Handle, StepOutcome};
use throng_planner::{linkage::Chain, rotation::Rigid, search::LoggedTrees};
use throng_precompute::Clip;

/// Colours of things, by their number.
const TINTS: [u32; 6] = [0xb08a4a, 0x5f8f56, 0x87609c, 0xb5653f, 0x4a8f9f, 0x8a8578];
/// Colours of characters but the first.
const OTHERS: [u32; 3] = [0x7d8aa0, 0x9a8fa0, 0x8fa08a];
/// Alpha of motions that are not shown.
const GHOST: f32 = 0.28;
/// Most nodes of a tree that are drawn; larger trees are thinned.
const MAX_NODES: usize = 12_000;
/// Length of the axes of places, to either side (m).
const PLACE_M: f32 = 0.06;

/// The tree that grows from the start, and that which grows from the goal.
pub const TREES: [Rgba; 2] = [Rgba::hex(0x4f86e0), Rgba::hex(0xe0457b)];

/// Colour of a node: darkest at the beginning of the search's time, lightest at its end.
///
/// - `tree`: 0 for that at the start, 1 for that at the goal.
pub fn colour_of_node(tree: usize, grown: &LoggedTrees, time_s: f64) -> Rgba {
    let [from, to] = grown.window_s;
    let share = ((time_s - from) / (to - from).max(1e-9)).clamp(0.0, 1.0) as f32;
    let hue = TREES[tree];
    if share < 0.5 {
        hue.mix(Rgba::hex(0x101418), 0.6 * (1.0 - 2.0 * share))
    } else {
        hue.mix(Rgba::WHITE, 1.4 * (share - 0.5))
    }
}

/// Results of the inspected steps.
pub fn inspected_steps<'a>(model: &Model, task: &'a TaskDocument) -> impl Iterator<Item = &'a StepOutcome> {
    let step = model.selection.plan.step;
    let all = task.shown_motion().into_iter().flat_map(|m| m.outcome.done.iter().enumerate());
    all.filter(move |(i, _)| step.is_none_or(|s| s == *i)).map(|(_, d)| d)
}

/// Position of the end of the limb of a step, in a clip of its character at a frame; the trees show it, too (m).
pub fn end_of_limb(task: &TaskDocument, done: &StepOutcome, clip: &Clip, frame: usize) -> DVec3 {
    let skeleton = &task.actors()[done.character].skeleton;
    let tip = Chain::new(done.limb, skeleton).tip;
    let (at, turn) = clip.joint_transforms(skeleton, frame)[done.limb.joints()[2].index()];
    at.as_dvec3() + turn.as_dquat() * tip
}

pub(super) fn lay_out(out: &mut StageLayout, model: &Model, task: &TaskDocument, palette: &StagePalette, dark: bool) {
    out.solids.meshes = Arc::clone(&task.meshes);
    if let Some(first) = task.actors().first() {
        out.skeleton.clone_from(&first.skeleton);
    }
    let time_s = model.task_time_s();
    bodies(out, model, task, time_s, palette);
    things(out, model, task, time_s, palette, dark);
    draw_limb_paths(out, model, task, palette);
    if model.selection.plan.trees {
        out.shapes.on_top(true);
        inspected_steps(model, task).flat_map(|d| &d.trees).for_each(|grown| trees(out, grown));
        out.shapes.on_top(false);
    }
}

fn bodies(out: &mut StageLayout, model: &Model, task: &TaskDocument, time_s: f64, palette: &StagePalette) {
    let mut add = |clip: &Clip, skeleton: &Skeleton, colour: Rgba| {
        let joints = clip.joint_transforms(skeleton, frame(clip, time_s));
        out.poses.extend(joints.map(|(p, r)| Mat3x4::from_rotation_translation(r, p)));
        let root = Planar::IDENTITY;
        out.instances.push(CharacterInstance { root, colour, is_selected: false, look: 0 });
    };
    for (i, actor) in task.actors().iter().enumerate() {
        let colour = if i == 0 { palette.on_the_way } else { Rgba::hex(OTHERS[(i - 1) % OTHERS.len()]) };
        let shown = task.clip(i);
        add(shown, &actor.skeleton, colour);
        if !model.selection.plan.ghosts {
            continue;
        }
        // Draws only motions that differ at this time: identical ones would flicker.
        let pose = |clip: &Clip| clip.frame_rotations(frame(clip, time_s)).to_vec();
        let mut seen = vec![pose(shown)];
        let motions = task.motions().iter().map(|m| &m.outcome.clips[i][1]);
        for ghost in motions.chain([&task.clips_before()[i]]) {
            let here = pose(ghost);
            if !seen.contains(&here) {
                add(ghost, &actor.skeleton, palette.plain.alpha(GHOST));
                seen.push(here);
            }
        }
    }
    if let Some(pose) = out.poses.get(..NUM_JOINTS) {
        let clip = task.clip(0);
        let contacts = clip.contacts.get(frame(clip, time_s)).copied().unwrap_or_default();
        cues::body(&mut out.shapes, model.settings.overlays, Planar::IDENTITY, pose, contacts, palette);
    }
}

/// The nearest frame.
fn frame(clip: &Clip, time_s: f64) -> usize {
    ((time_s * clip.rate_hz).round().max(0.0) as usize).min(clip.num_frames().saturating_sub(1))
}

fn things(out: &mut StageLayout, model: &Model, task: &TaskDocument, time_s: f64, palette: &StagePalette, dark: bool) {
    let selected = model.selection.plan.handle;
    let instance = |i: usize, place: Rigid, colour: Rgba| {
        let (at, turn) = (place.position.as_vec3(), place.rotation.as_quat());
        SolidInstance { mesh: i as u32, at, turn, colour }
    };
    for i in 0..task.task().things.len() {
        let tint = Rgba::hex(TINTS[i % TINTS.len()]);
        let tint = if dark { tint } else { tint.mix(Rgba::WHITE, 0.2) };
        let is_selected = selected == Some(Handle::Thing(i));
        let colour = if is_selected { tint.mix(palette.selected, 0.6) } else { tint };
        let here = task.place_of_thing(i, time_s);
        out.solids.instances.push(instance(i, here, colour));
        // Position before a character takes it: the thing is dragged there.
        let own = task.place_of(Handle::Thing(i), time_s).filter(|own| own.position.distance(here.position) > 1e-3);
        if let Some(own) = own.filter(|_| is_selected) {
            out.solids.instances.push(instance(i, own, colour.alpha(0.4)));
        }
    }
    out.shapes.on_top(true);
    for handle in task.task().handles().into_iter().filter(|h| matches!(h, Handle::Place(_))) {
        let Some(at) = task.place_of(handle, time_s) else { continue };
        let colour = if selected == Some(handle) { palette.selected } else { palette.target };
        let position = at.position.as_vec3();
        out.shapes.axes(position, at.rotation.as_quat(), PLACE_M, 1.5);
        out.shapes.sphere(position, 0.018, colour);
    }
    out.shapes.on_top(false);
}

/// Paths of planned hands and feet, and their paths before planning.
fn draw_limb_paths(out: &mut StageLayout, model: &Model, task: &TaskDocument, palette: &StagePalette) {
    for done in inspected_steps(model, task) {
        let (before, after) = (&task.clips_before()[done.character], task.clip(done.character));
        let differs = |f: &usize| before.frame_rotations(*f) != after.frame_rotations(*f);
        let frames: Vec<usize> = (0..before.num_frames()).filter(differs).collect();
        let (Some(first), Some(last)) = (frames.first(), frames.last()) else { continue };
        let windows: Vec<[f64; 2]> = done.trees.iter().map(|g| g.window_s).collect();
        let within = |f: &usize| {
            let t = *f as f64 / after.rate_hz;
            windows.is_empty() || windows.iter().any(|w| w[0] - 1e-6 <= t && t <= w[1] + 1e-6)
        };
        let shown: Vec<usize> = (*first..=*last).filter(within).collect();
        let colours = [palette.middle.alpha(0.35), palette.selected];
        for ((clip, colour), width) in [before, after].into_iter().zip(colours).zip([1.5, 2.5]) {
            let at = |f: usize| end_of_limb(task, done, clip, f).as_vec3();
            for pair in shown.windows(2).filter(|w| w[1] == w[0] + 1) {
                out.shapes.line(at(pair[0]), at(pair[1]), width, colour);
            }
        }
    }
}

fn trees(out: &mut StageLayout, grown: &LoggedTrees) {
    for (k, tree) in grown.trees.iter().enumerate() {
        let stride = tree.len() / MAX_NODES + 1;
        for node in tree.iter().skip(1).step_by(stride) {
            let parent = tree[node.parent].tip.as_vec3();
            out.shapes.line(parent, node.tip.as_vec3(), 1.2, colour_of_node(k, grown, node.time_s));
        }
        let root = tree.first().map(|n| n.tip.as_vec3());
        root.iter().for_each(|at| out.shapes.sphere(*at, 0.012, TREES[k]));
    }
}
