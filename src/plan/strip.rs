//! The picture of a plan: moments before and after, seen from two sides.

use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;
use throng_core::Joint;
use throng_geometry::{SolidShape, TriangleMesh};
use throng_planner::rotation::Rigid;
use throng_planner::task::{ActorClip, Task, TaskGaze, TaskOutcome};
use throng_precompute::environment::UnitSolid;
use throng_precompute::picture::{
    self, BodyColours, BodyFigure, Colour, Picture, WorldFigure, WorldMoment, WorldStrip,
};

/// Number of moments side by side.
const COLUMNS: usize = 10;
/// Width that each moment shows (m).
const WIDTH_M: f32 = 2.0;
/// Time that is shown before the first plan and after the last one (s).
const MARGIN_S: f64 = 0.15;
/// Colours of objects, by their number.
const TINTS: [u32; 6] = [0xb08a4a, 0x5f8f56, 0x87609c, 0xb5653f, 0x4a8f9f, 0x8a8578];
/// Colour of gaze lines and targets.
const GAZE: u32 = 0xc8102e;
/// Begin of a gaze line relative to the head's joint (m).
const EYES: Vec3 = Vec3::new(0.0, 0.07, 0.1);
/// Colours of characters except the first.
const OTHERS: [u32; 3] = [0x7d8aa0, 0x9a8fa0, 0x8fa08a];

/// Draws the character of the first task.
pub fn draw(task: &Task, clips: &[ActorClip], outcome: &TaskOutcome, title: &str) -> Picture {
    let who = outcome.done.first().map_or(0, |d| d.character);
    let clip = &outcome.clips[who][1];
    let [from, to] = changed_span(outcome, who);
    // Heading of the character in the middle of the shown time span (rad).
    let shown = &outcome.clips[who][0];
    let middle = (0.5 * (from + to) * shown.rate_hz) as usize;
    let ahead = shown.planar(middle.min(shown.num_frames() - 1)).heading;
    let times: Vec<f64> = (0..COLUMNS)
        .map(|i| from + (to - from) * i as f64 / (COLUMNS - 1) as f64)
        .map(|t| (t * clip.rate_hz).round() / clip.rate_hz)
        .collect();
    let strip = |when: usize, [side, tilt]: [f32; 2], seen: &str| {
        let moments: Vec<WorldMoment> =
            times.iter().map(|t| world_moment(task, clips, outcome, [who, when], *t)).collect();
        picture::world_strip(&WorldStrip {
            title: &format!("{title}: {}", ["before", "after"][when]),
            subtitle: seen,
            moments: &moments,
            columns: COLUMNS,
            width_m: WIDTH_M,
            view_angles: (ahead + side, tilt),
            ..WorldStrip::default()
        })
    };
    let gazes = [([FRAC_PI_2, 0.1], "from the right side"), ([std::f32::consts::PI, 0.25], "from ahead")];
    let all: Vec<Picture> = gazes.iter().flat_map(|(gaze, seen)| [0, 1].map(|when| strip(when, *gaze, seen))).collect();
    picture::sheet(&all.iter().collect::<Vec<_>>())
}

/// Time span from the first to the last changed frame, with a margin; the whole clip if none changed (s).
fn changed_span(outcome: &TaskOutcome, who: usize) -> [f64; 2] {
    let [before, after] = &outcome.clips[who];
    let differs = |f: &usize| before.frame_rotations(*f) != after.frame_rotations(*f);
    let frames = 0..before.num_frames();
    let end_s = (before.num_frames() - 1) as f64 / before.rate_hz;
    match (frames.clone().find(differs), frames.rev().find(differs)) {
        (Some(first), Some(last)) => {
            [first as f64 / before.rate_hz - MARGIN_S, last as f64 / before.rate_hz + MARGIN_S]
                .map(|t| t.clamp(0.0, end_s))
        }
        _ => [0.0, end_s],
    }
}

/// All characters and objects at a time.
fn world_moment(task: &Task, clips: &[ActorClip], found: &TaskOutcome, [who, when]: [usize; 2], t: f64) -> WorldMoment {
    let figure = |i: usize| {
        let clip = &found.clips[i][when];
        let frame = ((t * clip.rate_hz).round() as usize).min(clip.num_frames() - 1);
        let skeleton = &clips[i].skeleton;
        BodyFigure::from_transforms(skeleton, &clip.joint_transforms(skeleton, frame))
    };
    let others = (0..found.clips.len()).filter(|i| *i != who).enumerate();
    let mut figures = vec![WorldFigure { figure: figure(who), colours: BodyColours::default() }];
    figures.extend(others.map(|(k, i)| WorldFigure {
        figure: figure(i),
        colours: BodyColours::plain(Colour::hex(OTHERS[k % OTHERS.len()])),
    }));
    let paths = &found.scenery[when].paths;
    let solids = task.things.iter().zip(paths).enumerate().flat_map(|(i, (thing, path))| {
        let at = path.place_at(t);
        thing.shapes.iter().filter_map(move |s| Some((solid(s, &at)?, Colour::hex(TINTS[i % TINTS.len()]))))
    });
    let gazes = (0..found.clips.len()).filter(|_| when == 1).flat_map(|i| gaze_solids(clips, found, i, t));
    let solids = solids.chain(gazes.map(|s| (s, Colour::hex(GAZE)))).collect();
    WorldMoment { time_s: t as f32, figures, framed: 1, solids, ..WorldMoment::default() }
}

/// Solids of a gaze: a line ahead of the face, as long as the distance to its target, and a ball at the target.
fn gaze_solids(clips: &[ActorClip], outcome: &TaskOutcome, who: usize, time_s: f64) -> Vec<UnitSolid> {
    let inside = |l: &&TaskGaze| l.character == who && l.times_s[0] < time_s && time_s < l.times_s[2];
    let Some(gaze) = outcome.gazes.iter().find(inside) else { return Vec::new() };
    let clip = &outcome.clips[who][1];
    let frame = ((time_s * clip.rate_hz).round() as usize).min(clip.num_frames() - 1);
    let (head, turn) = clip.joint_transforms(&clips[who].skeleton, frame)[Joint::Head.index()];
    let at = gaze.target.as_vec3();
    let eyes = head + turn * EYES;
    let to = eyes + turn * Vec3::Z * eyes.distance(at);
    vec![UnitSolid::Bar { from: eyes, to, radius: 0.004 }, UnitSolid::Bar { from: at, to: at, radius: 0.015 }]
}

/// Solid of a shape, in the world; `None` for a mesh that is too far away to be drawn.
fn solid(shape: &SolidShape, at: &Rigid) -> Option<UnitSolid> {
    let turn: Quat = at.rotation.as_quat();
    let point = |p: glam::DVec3| -> Vec3 { at.transform_point(p).as_vec3() };
    Some(match shape {
        SolidShape::Round { core, radius } => {
            UnitSolid::Bar { from: point(core.a), to: point(core.b), radius: *radius as f32 }
        }
        SolidShape::Cuboid { half } => {
            UnitSolid::Box { centre: at.position.as_vec3(), rotation: turn, half: half.as_vec3() }
        }
        SolidShape::Mesh(mesh) => {
            let placed = mesh.corners().iter().map(|t| t.map(|c| point(c.as_dvec3())));
            UnitSolid::Mesh(TriangleMesh::new(placed.collect()).ok()?)
        }
    })
}
