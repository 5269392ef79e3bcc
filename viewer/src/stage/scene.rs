//! A scene of groups: bodies, discs and balls, what stands around them, targets and blows.

use super::agents::obstacles;
use super::{Layout, Palette, body, cues, world};
use crate::document::{SceneDocument, Standing};
use crate::model::Model;
use crate::render::{Camera, CharacterInstance, Emphasis, Ray, Rgba, Shapes, SolidInstance};
use crate::settings::Colouring;
use glam::{Vec2, Vec3};
use throng_precompute::run::SeenObstacle;
use throng_runtime::patch::Placement;
use throng_runtime::simulation::{Event, Happened, Motion, Simulation};
use throng_runtime::sparring::Part;

/// Cues of all characters are drawn for so many at most.
const MAX_CUES: usize = 1500;
/// Length of trails (s).
const TRAIL_S: f32 = 6.0;
/// Speed at which the colour of speed is that of a fast character (m/s).
const FAST_MPS: f32 = 3.0;
/// Marks of blows fade within this time (s).
const MARK_S: f64 = 0.8;
/// How much of a disc is seen below a body.
const BELOW_BODIES: f32 = 0.35;
/// Lines on the ground lie so much above it (m).
const ABOVE_M: f32 = 0.012;
/// Radius in which a character without a disc is met (m).
const BODY_M: f32 = 0.3;
/// A click selects a character that it misses by so much (pixels).
const MISSED_PX: f32 = 8.0;

pub(super) fn lay_out(out: &mut Layout, model: &Model, scene: &SceneDocument, palette: &Palette, dark: bool) {
    let (run, selected) = (scene.run(), model.selection.character);
    let simulation = run.simulation();
    standing(out, scene.standing(), simulation.time_s(), palette, dark);
    for (g, group) in simulation.groups().iter().enumerate() {
        for who in group.characters.clone() {
            let is_selected = selected == Some(who);
            let colour = colour(model.settings.colouring, simulation, (g, who), palette);
            character(out, simulation, who, (colour, is_selected), palette);
            if group.motion == Motion::Policy
                && let Some(target) = simulation.target(who)
            {
                out.shapes.sphere(target, 0.09, palette.target);
            }
        }
    }
    let o = model.settings.overlays;
    let n = simulation.num_characters();
    let count = if o.of_all { n.min(MAX_CUES) } else { 0 };
    for who in (0..count).chain(selected.filter(|&c| c >= count && c < n)) {
        if o.trails {
            let points: Vec<Vec3> = run.trail(who, TRAIL_S).map(|p| p + Vec3::Y * ABOVE_M).collect();
            let colour = if selected == Some(who) { palette.selected } else { palette.middle.alpha(0.5) };
            cues::trail(&mut out.shapes, &points, 2.0, colour);
        }
        if let (Some(root), Some(pose)) = (simulation.root(who), simulation.pose(who)) {
            cues::body(&mut out.shapes, o, (root, pose), simulation.contacts(who), palette);
        }
    }
    let marks = run.events().take_while(|e| simulation.time_s() - e.time_s < MARK_S);
    marks.for_each(|event| mark(&mut out.shapes, event, simulation.time_s(), palette));
}

/// A body, a disc on the ground, or a ball in the air.
fn character(
    out: &mut Layout,
    simulation: &Simulation,
    who: usize,
    (colour, is_selected): (Rgba, bool),
    palette: &Palette,
) {
    let Some(root) = simulation.root(who) else { return };
    let pose = simulation.pose(who);
    if let Some(disc) = simulation.disc(who) {
        let colour = if pose.is_some() { colour.alpha(BELOW_BODIES) } else { colour };
        let ahead = disc.velocity * (0.95 * disc.radius / disc.velocity.length().max(1e-6));
        let in_the_air = disc.centre.y > disc.radius;
        match in_the_air {
            true => out.shapes.sphere(disc.centre, disc.radius, colour),
            false => out.shapes.disc(disc.centre.with_y(0.01), disc.radius, colour),
        }
        if disc.knows && !in_the_air {
            out.shapes.disc(disc.centre.with_y(0.013), 0.35 * disc.radius, palette.target);
        }
        if is_selected && !in_the_air {
            out.shapes.ring(disc.centre.with_y(0.018), disc.radius, 1.15 * disc.radius, palette.selected);
        }
        if pose.is_none() && is_selected && in_the_air {
            out.shapes.circle(disc.centre, 1.25 * disc.radius, 2.5, palette.selected);
        }
        if pose.is_none() {
            let from = if in_the_air { disc.centre } else { disc.centre.with_y(0.015) };
            out.shapes.line(from, from + ahead, 2.0, palette.middle);
        }
    }
    if let Some(pose) = pose {
        body::put(&mut out.poses, pose, &body::stretch_of_pose(&out.skeleton, pose));
        let emphasis = if is_selected { Emphasis::Selected } else { Emphasis::None };
        out.instances.push(CharacterInstance { root, colour, emphasis });
        out.drawn.push(who);
    }
}

/// By the group or the speed; opponents differ, and inhabitants of worlds show what they are doing.
fn colour(colouring: Colouring, simulation: &Simulation, (group, who): (usize, usize), palette: &Palette) -> Rgba {
    use throng_runtime::simulation::GroupCast;
    match (colouring, simulation.member(who)) {
        (Colouring::Plain, _) => palette.plain,
        (Colouring::Speed, (GroupCast::Paths(w), m)) => {
            palette.slow.mix(palette.fast, (w.speed(m) / FAST_MPS).min(1.0))
        }
        (Colouring::Speed, _) => {
            let speed = simulation.disc(who).map_or(0.0, |d| d.velocity.length());
            palette.slow.mix(palette.fast, (speed / FAST_MPS).min(1.0))
        }
        (Colouring::Target, (GroupCast::Patches(i), m)) => world::colour_of(i.inhabitants().status(m).doing),
        (Colouring::Target, (GroupCast::Sparring(_), m)) if m % 2 == 0 => palette.slow,
        (Colouring::Target, (GroupCast::Sparring(_), _)) => palette.on_the_way,
        (Colouring::Target | Colouring::Clip, _) => cues::category(group),
    }
}

/// Obstacles, and the units of worlds.
fn standing(out: &mut Layout, standing: &Standing, time_s: f64, palette: &Palette, dark: bool) {
    out.solids.meshes = std::sync::Arc::clone(&standing.meshes);
    let grey = Rgba::hex(if dark { 0x77808d } else { 0x9aa1ab });
    let origin = Placement::new(0.0, 0.0, 0.0, 0.0);
    out.solids.instances.push(SolidInstance { mesh: 0, placement: origin, colour: grey });
    out.solids.instances.extend(standing.units.iter().map(|u| SolidInstance {
        mesh: u.mesh,
        placement: u.placement,
        colour: world::colour_of_unit(&u.name, u.is_floor, u.placement, dark),
    }));
    for obstacle in &standing.obstacles {
        match obstacle {
            SeenObstacle::Box(low, high) if standing.in_the_air => {
                obstacles::edges(&mut out.shapes, *low, *high, grey);
            }
            SeenObstacle::Mover { way, radius } => {
                let at = obstacles::place(way, time_s);
                match standing.in_the_air {
                    true => out.shapes.sphere(at, *radius, palette.target),
                    false => out.shapes.disc(at.with_y(ABOVE_M), *radius, palette.target),
                }
            }
            _ => {}
        }
    }
}

/// A blow that has landed.
fn mark(shapes: &mut Shapes, event: &Event, now_s: f64, palette: &Palette) {
    let (at, colour) = match event.happened {
        Happened::Hit { at } => (at, palette.reached),
        Happened::Struck { at, part: Part::Arm, .. } => (at, palette.plain),
        Happened::Struck { at, .. } => (at, palette.target),
        _ => return,
    };
    let strength = 1.0 - ((now_s - event.time_s) / MARK_S) as f32;
    shapes.on_top(true);
    shapes.sphere(at, 0.05, colour.alpha(strength));
    shapes.on_top(false);
}

/// The character without a body that a ray meets, or nearly so.
pub fn pick(scene: &SceneDocument, camera: &Camera, ray: &Ray, view: Vec2) -> Option<usize> {
    let simulation = scene.run().simulation();
    let missed = |who: usize| {
        let (at, radius) = match simulation.disc(who) {
            Some(disc) => (disc.centre, disc.radius),
            None => (simulation.root(who)?.translation(), BODY_M),
        };
        let along = (at - ray.origin).dot(ray.direction);
        let from = match at.y > radius {
            true => ray.at(along).distance(at),
            false => ray.meets_ground()?.distance(at.with_y(0.0)),
        };
        let slack = MISSED_PX / camera.pixels_per_metre(along, view.y);
        (along > 0.0 && from < radius + slack).then_some((who, (from - radius).max(0.0) / slack, along))
    };
    let all = (0..simulation.num_characters()).filter_map(missed);
    all.min_by(|a, b| a.1.total_cmp(&b.1).then(a.2.total_cmp(&b.2))).map(|f| f.0)
}
