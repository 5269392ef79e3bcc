//! A crowd: place and colour of all characters, and the cues of the selected character.

use super::{StageLayout, StagePalette, cues, values, variety};
use crate::bundle::OpenBundle;
use crate::model::Model;
use crate::render::{CharacterInstance, RecordInstance, Rgba};
use crate::run::{CrowdRun, PolicyChooser, TargetMode};
use crate::settings::Colouring;
use glam::Vec3;
use std::sync::Arc;
use throng_base::thresholds::RUN_SPEED_MPS;
use throng_core::characters::DetailLevel;

/// Most characters whose cues are drawn.
const MAX_CUES: usize = 2000;
/// Length of trails (s).
const TRAIL_S: f32 = 6.0;

pub(super) fn lay_out(out: &mut StageLayout, model: &Model, palette: &StagePalette) {
    let Some((bundle, run)) = model.shown_crowd() else { return };
    let n = run.characters().num_characters();
    let selected = model.selection.character;
    let (characters, has_records) = (run.characters(), !run.characters().instances().is_empty());
    let is_varied = variety::is_wanted(model);
    for c in 0..n {
        let colour = variety::shirt_or_plain(model, c, colour(model, bundle, run, c, palette));
        let look = if is_varied { variety::look_bits(c) } else { 0 };
        if characters.level(c) == DetailLevel::Record {
            out.records.push(RecordInstance { instance: characters.instances()[c], colour, look });
            continue;
        }
        let (root, is_selected) = (characters.root(c), selected == Some(c));
        out.instances.push(CharacterInstance { root, colour, is_selected, look: 0 });
        if has_records {
            out.poses.extend(characters.pose(c));
            out.drawn.push(c);
        }
    }
    out.rows = has_records.then(|| Arc::clone(bundle.row_poses()));
    let o = model.settings.overlays;
    if let Some(chooser) = selected.and_then(|c| run.chooser(bundle, c)).filter(|_| o.values) {
        values::lay_out(out, model, &chooser, palette);
    }
    let count = if o.of_all { n.min(MAX_CUES) } else { 0 };
    for c in (0..count).chain(selected.filter(|&c| c >= count && c < n)) {
        if o.trails {
            let is_selected = selected == Some(c);
            let points: Vec<Vec3> = run.trail(c, TRAIL_S).map(|p| Vec3::new(p.x, 0.012, p.y)).collect();
            let (width, colour) = if is_selected { (3.0, palette.selected) } else { (1.5, palette.middle.alpha(0.45)) };
            cues::trail(&mut out.shapes, &points, width, colour);
        }
        if let Some(chooser) = run.chooser(bundle, c).filter(|_| o.trajectory) {
            trajectory(out, &chooser, palette);
        }
        if characters.level(c) == DetailLevel::Record {
            continue;
        }
        let (root, pose) = (characters.root(c), characters.pose(c));
        cues::body(&mut out.shapes, o, root, pose, characters.contacts(c), palette);
    }
    if o.targets {
        targets(out, run, selected, palette);
    }
}

fn colour(model: &Model, bundle: &OpenBundle, run: &CrowdRun, c: usize, palette: &StagePalette) -> Rgba {
    match model.settings.colouring {
        Colouring::Plain => palette.plain,
        Colouring::Target => {
            let (root, target) = (run.characters().root(c), run.targets()[c]);
            let distance = (root.x - target.x).hypot(root.z - target.z);
            if distance < run.config().reach_m { palette.reached } else { palette.on_the_way }
        }
        Colouring::Clip | Colouring::Speed | Colouring::Made => run
            .chooser(bundle, c)
            .map_or(palette.plain, |chooser| colour_of_segment(&chooser, model.settings.colouring, palette)),
    }
}

/// By the speed or the clip of the segment that is played, or whether it is made.
pub(super) fn colour_of_segment(chooser: &PolicyChooser<'_>, colouring: Colouring, palette: &StagePalette) -> Rgba {
    let (segment, played) = chooser.characters.segment(chooser.number);
    let s = &chooser.bundle.tables().graph().segments[segment as usize];
    if colouring == Colouring::Clip {
        return cues::category(s.clip as usize);
    }
    if colouring == Colouring::Made {
        let row = s.start + (played as u32).min(s.num_frames);
        return if chooser.bundle.is_made(row) { palette.target } else { palette.plain };
    }
    let metres = s.displacement[0].hypot(s.displacement[1]);
    let speed = metres / s.num_frames as f32 * chooser.bundle.rate_hz();
    palette.slow.mix(palette.fast, (speed / RUN_SPEED_MPS).min(1.0))
}

/// Draws the ground path of the rest of the segment, and the final heading.
pub(super) fn trajectory(out: &mut StageLayout, chooser: &PolicyChooser<'_>, palette: &StagePalette) {
    let (bundle, characters) = (chooser.bundle, chooser.characters);
    let (segment, time) = characters.segment(chooser.number);
    let s = bundle.tables().graph().segments[segment as usize];
    let root = characters.root(chooser.number);
    let now = s.start + (time as u32).min(s.num_frames);
    let clip_to_world = root.compose(bundle.planar(now).inverse());
    let end = s.start + s.num_frames;
    let mut points = vec![root.translation().with_y(0.016)];
    let stride = (s.num_frames / 12).max(1) as usize;
    points
        .extend((now..end).step_by(stride).skip(1).map(|row| clip_to_world.compose(bundle.planar(row)).translation()));
    let goal = clip_to_world.compose(bundle.planar(end));
    points.push(goal.translation());
    points.iter_mut().for_each(|p| p.y = 0.016);
    out.shapes.polyline(&points, 2.5, palette.slow);
    let ahead = goal.rotation() * Vec3::Z * 0.22;
    let foot = goal.translation().with_y(0.02);
    out.shapes.arrow(foot, foot + ahead, 0.014, palette.slow);
}

fn targets(out: &mut StageLayout, run: &CrowdRun, selected: Option<usize>, palette: &StagePalette) {
    let mut put = |target: Vec3, is_selected: bool| {
        let (colour, at) = (palette.target, target.with_y(0.008));
        out.shapes.disc(at, 0.09, colour);
        out.shapes.ring(at, 0.17, if is_selected { 0.25 } else { 0.20 }, colour);
        if is_selected {
            out.shapes.line(at, at + Vec3::Y * 0.9, 2.5, colour);
            out.shapes.sphere(at + Vec3::Y * 0.9, 0.06, colour);
        }
    };
    if run.config().targets == TargetMode::Shared {
        put(run.targets()[0], true);
        return;
    }
    let n = run.targets().len();
    for c in (0..n.min(MAX_CUES)).filter(|&c| selected != Some(c)) {
        put(run.targets()[c], false);
    }
    if let Some(c) = selected.filter(|&c| c < n) {
        put(run.targets()[c], true);
        let (from, to) = (run.characters().root(c).translation().with_y(0.01), run.targets()[c].with_y(0.01));
        out.shapes.line(from, to, 1.0, palette.target.alpha(0.7));
    }
}
