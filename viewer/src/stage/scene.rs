//! A scene: bodies, discs and balls, their surroundings, targets and blows.

use super::agents::{self, Brush};
use super::{StageLayout, StagePalette, body, bout, cues, variety, world};
use crate::document::{SceneDocument, SceneSurroundings};
use crate::render::{CharacterInstance, OrbitCamera, Ray, RecordInstance, Rgba, SolidInstance};
use crate::run::{PolicyChooser, detail_level, is_at_target};
use crate::{model::Model, run::agents::first_agent, settings::Colouring};
use glam::{Vec2, Vec3};
use std::sync::Arc;
use throng_base::thresholds::{AGENT_RADIUS_M, RUN_SPEED_MPS};
use throng_core::{characters::DetailLevel, patch::Placement};
use throng_precompute::run::policy_characters;
use throng_simulation::{AnyCharacterGroup, Simulation, agents::Disc, scenario::AgentBrains};

/// Most characters for which cues of all are drawn.
const MAX_CUES: usize = 1500;
/// Length of trails (s).
const TRAIL_S: f32 = 6.0;
/// Opacity of a disc below a body.
const BELOW_BODIES: f32 = 0.35;
/// Height of lines above the ground (m).
const ABOVE_M: f32 = 0.012;
/// Distance within which a click still selects a character (pixels).
const MISSED_PX: f32 = 8.0;

pub(super) fn lay_out(out: &mut StageLayout, model: &Model, scene: &SceneDocument, palette: &StagePalette, dark: bool) {
    let (run, selected) = (&scene.run, model.selection.character);
    let simulation = run.simulation();
    let brush = Brush::new(model, scene, palette, dark);
    draw_surroundings(out, &scene.surroundings, &brush);
    doors(out, &scene.surroundings, simulation, &brush);
    things(out, &scene.surroundings, simulation, &brush);
    agents::lay_out_obstacles(&mut out.shapes, &scene.surroundings, simulation.time_s(), &brush);
    agents::lay_out_blackboards(&mut out.shapes, simulation, &brush);
    let is_varied = variety::is_wanted(model);
    for (g, group) in simulation.groups().iter().enumerate() {
        let people = policy_characters(&simulation.character_groups()[group.character_group]);
        let records = people.map_or(&[][..], |p| p.instances());
        if let Some(bundle) = scene.bundle().filter(|_| !records.is_empty()) {
            out.rows = Some(Arc::clone(bundle.row_poses()));
        }
        for who in group.characters.clone() {
            let colour = match by_message(simulation, who, brush.options.message) {
                Some((brains, agent, event)) => agents::colour_by_message(brains, agent, event, &brush),
                None => variety::shirt_or_plain(model, who, colour(model.settings.colouring, scene, g, who, palette)),
            };
            match records.get(who - group.characters.start) {
                Some(&instance) if detail_level(simulation, who) == DetailLevel::Record => {
                    let look = if is_varied { variety::look_bits(who) } else { 0 };
                    out.records.push(RecordInstance { instance, colour, look });
                }
                _ => character(out, simulation, who, colour, &brush),
            }
        }
    }
    bout::lay_out(out, run, selected, model.settings.overlays.targets, palette);
    agents::lay_out(out, run, &brush);
    let mut o = model.settings.overlays;
    // On hills, marks on level ground would be hidden.
    o.contacts &= !scene.surroundings.has_hills;
    let n = simulation.num_characters();
    let count = if o.of_all { n.min(MAX_CUES) } else { 0 };
    for who in (0..count).chain(selected.filter(|&c| c >= count && c < n)) {
        if o.trails {
            let lift = if scene.surroundings.in_the_air { 0.0 } else { ABOVE_M };
            let points: Vec<Vec3> = run.trail(who, TRAIL_S).map(|p| p + Vec3::Y * lift).collect();
            let colour = if selected == Some(who) { palette.selected } else { palette.middle.alpha(0.5) };
            cues::trail(&mut out.shapes, &points, 2.0, colour);
        }
        if let Some(chooser) = scene.chooser(who).filter(|_| o.trajectory) {
            trajectory(out, &chooser, palette);
        }
        let is_posed = detail_level(simulation, who) != DetailLevel::Record;
        if let (Some(root), Some(pose), true) = (simulation.root(who), simulation.pose(who), is_posed) {
            cues::body(&mut out.shapes, o, root, pose, simulation.contacts(who), palette);
        }
    }
}

/// Agent brains, number of an agent, and number of the message, if the agent is coloured by its knowledge of a
/// message.
fn by_message(simulation: &Simulation, who: usize, event: Option<usize>) -> Option<(&AgentBrains, usize, usize)> {
    let event = event?;
    let brains = simulation.brains().filter(|m| event < m.event_names().len())?;
    let agent = who.checked_sub(first_agent(simulation)?).filter(|a| *a < brains.len())?;
    Some((brains, agent, event))
}

/// A body, a disc on the ground, or a ball in the air.
fn character(out: &mut StageLayout, simulation: &Simulation, who: usize, colour: Rgba, brush: &Brush<'_>) {
    let Some(root) = simulation.root(who) else { return };
    let is_selected = brush.selected == Some(who);
    let disc = simulation.disc(who);
    let pose = simulation.pose(who).filter(|_| disc.is_none() || brush.options.bodies);
    if let Some(disc) = &disc {
        let colour = if pose.is_some() { colour.alpha(BELOW_BODIES) } else { colour };
        // Where one message is looked at, discs have its colour.
        let disc = Disc { knows: disc.knows && brush.options.message.is_none(), ..*disc };
        agents::disc(&mut out.shapes, brush, &disc, colour, is_selected);
    }
    if let Some(pose) = pose {
        if policy_characters(simulation.locate(who).0).is_some() {
            out.poses.extend(pose);
        } else {
            let own = body::body_of_pose(&out.skeleton, pose);
            body::push_stretched(&mut out.poses, pose, &body::stretch(&out.skeleton, &own));
        }
        out.instances.push(CharacterInstance { root, colour, is_selected, look: 0 });
        out.drawn.push(who);
    }
}

/// Colour by the group, the clip or the speed; opponents differ, and inhabitants of worlds show their activity.
fn colour(colouring: Colouring, scene: &SceneDocument, group: usize, who: usize, palette: &StagePalette) -> Rgba {
    let simulation = scene.run.simulation();
    let by_speed = |share: f32| palette.slow.mix(palette.fast, share.min(1.0));
    let speed = || simulation.disc(who).map_or(0.0, |d| d.velocity.length());
    let by_desired = |desired: f32| by_speed(speed() / desired.max(1e-3));
    match (colouring, simulation.locate(who)) {
        (Colouring::Plain, _) => palette.plain,
        (Colouring::Speed, (AnyCharacterGroup::Paths(w), m)) => by_speed(w.speed(m) / RUN_SPEED_MPS),
        (Colouring::Speed, (AnyCharacterGroup::Ground(a), m)) => by_desired(a.layout().setup.agents[m].speed),
        (Colouring::Speed, (AnyCharacterGroup::Air(a), m)) => by_desired(a.layout().setup.agents[m].speed),
        (Colouring::Speed | Colouring::Clip | Colouring::Made, (group, _)) if policy_characters(group).is_some() => {
            scene.chooser(who).map_or(palette.plain, |c| colour_of_segment(&c, colouring, palette))
        }
        (Colouring::Speed | Colouring::Made, _) => palette.plain,
        (Colouring::Target, (AnyCharacterGroup::Patches(i), m)) => world::kind_of(i.state(m).activity).1,
        (Colouring::Target, (AnyCharacterGroup::Sparring(_), m)) => {
            [palette.left, palette.right][m % 2].mix(palette.plain, 0.25)
        }
        (Colouring::Target, (AnyCharacterGroup::Policy(_), _)) if is_at_target(simulation, who) => palette.reached,
        (Colouring::Target, (AnyCharacterGroup::Policy(_) | AnyCharacterGroup::Travel(_), _)) => palette.on_the_way,
        (Colouring::Target | Colouring::Clip, _) => cues::category(group),
    }
}

/// Obstacles, hills, and the units of worlds.
fn draw_surroundings(out: &mut StageLayout, standing: &SceneSurroundings, brush: &Brush<'_>) {
    out.solids.meshes = std::sync::Arc::clone(&standing.meshes);
    let hills = if brush.dark { [0x4a4f57, 0x434850] } else { [0xd2d4d5, 0xc4c6c8] };
    let colours = [agents::grey(brush.dark), Rgba::hex(hills[0]), Rgba::hex(hills[1])];
    let here = Placement::IDENTITY;
    out.solids.instances.extend((0..).zip(colours).map(|(mesh, colour)| SolidInstance::upright(mesh, here, colour)));
    out.solids.instances.extend(standing.units.iter().map(|u| {
        let colour = world::colour_of_unit(&u.name, u.is_floor, u.placement, brush.dark);
        SolidInstance::upright(u.mesh, u.placement, colour)
    }));
}

/// Doors: closed ones stand, of open ones only the sill is seen.
fn doors(out: &mut StageLayout, standing: &SceneSurroundings, simulation: &Simulation, brush: &Brush<'_>) {
    let colour = Rgba::hex(if brush.dark { 0xb5793f } else { 0xa0622a });
    let mut groups = simulation.character_groups().iter();
    let ground = groups.find_map(|c| if let AnyCharacterGroup::Ground(a) = c { Some(a) } else { None });
    let Some(agents) = ground else { return };
    for (d, door) in standing.doors.iter().enumerate() {
        if agents.is_open(d) {
            let [from, to] = door.ends.map(|p| p.with_y(ABOVE_M));
            out.shapes.line(from, to, 1.5, colour.alpha(0.6));
        } else {
            out.solids.instances.push(SolidInstance::upright(door.mesh, Placement::IDENTITY, colour));
        }
    }
}

/// Things, where they lie or are held.
fn things(out: &mut StageLayout, standing: &SceneSurroundings, simulation: &Simulation, brush: &Brush<'_>) {
    let colour = Rgba::hex(if brush.dark { 0x6fb3e0 } else { 0x1f6fa8 });
    let all = simulation.things().zip(&standing.things);
    out.solids.instances.extend(all.map(|(t, &mesh)| SolidInstance { mesh, at: t.at, turn: t.turn, colour }));
}

/// The character whose disc or body a ray hits, or nearly hits.
pub fn pick(scene: &SceneDocument, camera: &OrbitCamera, ray: &Ray, view: Vec2) -> Option<usize> {
    let simulation = scene.run.simulation();
    let missed = |who: usize| {
        let (at, radius) = match simulation.disc(who) {
            Some(disc) => (disc.centre, disc.radius),
            None => (simulation.root(who)?.translation(), AGENT_RADIUS_M),
        };
        let along = (at - ray.origin).dot(ray.direction);
        let from = match at.y > radius {
            true => ray.point_at(along).distance(at),
            false => ray.intersect_ground()?.distance(at.with_y(0.0)),
        };
        let slack = MISSED_PX / camera.pixels_per_metre(along, view.y);
        (along > 0.0 && from < radius + slack).then_some((who, (from - radius).max(0.0) / slack, along))
    };
    let all = (0..simulation.num_characters()).filter_map(missed);
    all.min_by(|a, b| a.1.total_cmp(&b.1).then(a.2.total_cmp(&b.2))).map(|f| f.0)
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
