//! The picture of a crowd of discs or balls: from above at a few times, in the air also from the side.

use super::{Colour, Picture, WorldMoment, WorldStrip, colour, obstacle_solid, sheet, world_strip};
use crate::run::{
    AgentFigures, AgentsRecord, CrowdMoment, RecordedAgent, SceneFigures, TRAIL_S, position_on_timed_path,
};
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI};
use throng_bake::environment::UnitSolid;
use throng_base::thresholds::DIRECTION_SHOWN_MPS;
use throng_crowd::Obstacle;
use throng_geometry::BoundingBox;

/// Colours of groups, in their order.
const GROUPS: [u32; 6] = [0xe8743b, 0x2f63a8, 0x1f9e89, 0x7a2bbf, 0xc0b027, 0xb0446a];
/// Colour of agents that know of a happening, and of doors.
const INFORMED_COLOUR: Colour = Colour::hex(0xd62728);
/// Colour of obstacles.
pub(super) const OBSTACLE_COLOUR: Colour = Colour::hex(0x8a8578);
/// Height of obstacles with corners (m).
const OBSTACLE_M: f32 = 0.3;
/// Radius of standing places (m).
const SLOT_M: f32 = 0.3;
/// Least radius of what is drawn, over the width of the crowd.
const LEAST_RADIUS: f32 = 0.001;
/// Number of points of the trail behind an agent: 2.4 s.
const TRAIL_POINTS: usize = 7;
/// Greatest number of agents whose paths are drawn.
const MAX_PATHS: usize = 60;

/// Draws a crowd at a few times.
pub(super) fn crowd_sheet(scene: &str, figures: &SceneFigures, record: &AgentsRecord) -> Picture {
    let f = figures.crowd.clone().unwrap_or_default();
    let (agents, engine) = (figures.agents.unwrap_or(0), figures.engine.as_deref().unwrap_or_default());
    let remark = if f.informed.is_some() { "ringed: knows" } else { "" };
    let header = [&format!("{scene}: {agents} agents, engine {engine}"), &subtitle(figures, &f), remark];
    moments_sheet(header, record)
}

/// Draws characters with policies on the way to goals, at a few times.
pub(super) fn travel_sheet(title: &str, figures: &SceneFigures, record: &AgentsRecord) -> Picture {
    let (f, stuck) = (figures.travel.clone().unwrap_or_default(), figures.stuck.unwrap_or(0));
    let subtitle = format!("{:.2} m/s towards the goal; {} there, {stuck} stuck", f.progress_mps, f.arrived);
    moments_sheet([title, &subtitle, ""], record)
}

/// - `header`: title, subtitle, and a remark beside the legend.
fn moments_sheet([title, subtitle, remark]: [&str; 3], record: &AgentsRecord) -> Picture {
    let (low, high) = extent(record);
    let size = high - low;
    let entries: Vec<_> = record.names.iter().enumerate().map(|(g, n)| (group_colour(g), n.clone())).collect();
    // Wide crowds are placed below each other, others side by side.
    let columns = if size.x > 2.5 * size.z { 1 } else { 2 };
    let views = [(FRAC_PI_2, size.z, "from above"), (0.0, size.y, "from the side")];
    let strips = views.iter().take(if record.in_the_air { 2 } else { 1 }).map(|(elevation, height, from)| {
        let moment = |m: &CrowdMoment| draw_moment(record, m, LEAST_RADIUS * size.x, from);
        let aspect = (height / size.x).clamp(0.1, 0.6 * columns as f32);
        world_strip(&WorldStrip {
            title,
            subtitle,
            moments: &record.moments.iter().map(moment).collect::<Vec<_>>(),
            units: &[],
            columns,
            centre: Some(0.5 * (low + high)),
            width_m: size.x.max(height / aspect),
            aspect,
            view_angles: (PI, *elevation),
            legend: (&entries, remark),
        })
    });
    sheet(&strips.collect::<Vec<_>>().iter().collect::<Vec<_>>())
}

fn subtitle(figures: &SceneFigures, r: &AgentFigures) -> String {
    let (arrived, stuck) = (r.arrived, figures.stuck.unwrap_or(0));
    let (overlap_mm, events) = (1000.0 * r.max_overlap_m, r.events_per_agent_second.unwrap_or_default());
    let mut text = format!("{:.2} m/s towards the goal of {:.2} wanted; ", r.progress_mps, r.desired_mps);
    text += &format!("{arrived} there, {stuck} stuck; deepest overlap {overlap_mm:.1} mm; ");
    text += &format!("{events:.1} events an agent and second");
    if let Some(order) = r.lane_order {
        text += &format!("; order of lanes {order:.2}");
    }
    if let Some(flow) = r.flow.as_ref().and_then(|f| f.flow_per_m_s) {
        text += &format!("; {flow:.2} persons/(m s)");
    }
    if let Some(informed) = r.informed {
        text += &format!("; {informed} know");
    }
    text
}

pub(super) fn group_colour(group: usize) -> Colour {
    Colour::hex(GROUPS[group % GROUPS.len()])
}

/// Least and greatest coordinates of all agents, with a margin.
fn extent(record: &AgentsRecord) -> (Vec3, Vec3) {
    let seen = record.moments.iter().flat_map(|m| m.agents.iter().flatten().map(|s| s.at));
    let slots = record.places.iter().flat_map(|p| p.slots.iter().copied().chain([p.at]));
    let all = seen.chain(record.trails.iter().flat_map(|t| t.1.iter().copied())).chain(slots);
    let all = all.filter(|p| p.is_finite() && p.abs().max_element() < 1e6);
    let (low, high) = all.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    if !low.is_finite() {
        return (Vec3::splat(-5.0), Vec3::splat(5.0));
    }
    let room = 2.0 * record.radii.iter().copied().fold(0.5, f32::max) + 0.01 * (high - low).max_element();
    (low - room, high + room)
}

/// - `least_m`: least radius of what is drawn (m).
/// - `from`: name of the view.
fn draw_moment(record: &AgentsRecord, moment: &CrowdMoment, least_m: f32, from: &str) -> WorldMoment {
    let bar = |from: Vec3, to: Vec3, radius: f32| UnitSolid::Bar { from, to, radius: radius.max(least_m) };
    let what = if record.in_the_air { from } else { "" };
    let mut out = WorldMoment { label: Some(format!("{:.1} s {what}", moment.time_s)), ..WorldMoment::default() };
    // Paths that lead around obstacles.
    let bent: Vec<&Vec<Vec3>> = record.paths.iter().filter(|w| w.len() > 2).collect();
    let some = bent.iter().step_by(bent.len().div_ceil(MAX_PATHS).max(1));
    out.trails.extend(some.map(|path| (path.to_vec(), colour::REACHED.alpha(0.5))));
    for obstacle in &record.obstacles {
        let mover = OBSTACLE_COLOUR.mix(colour::INK, 0.4);
        out.solids.extend(match obstacle {
            Obstacle::Ball { centre, radius } if record.in_the_air => {
                Some((bar(*centre, *centre, *radius), OBSTACLE_COLOUR))
            }
            Obstacle::Wall { from, to, radius } => Some((bar(*from, *to, *radius), OBSTACLE_COLOUR)),
            Obstacle::Mover { path, radius } => {
                let at = position_on_timed_path(path, moment.time_s);
                Some((bar(at, at, *radius), mover))
            }
            Obstacle::Box { min, max } if record.in_the_air => {
                // Only the edges: boxes around a flock would hide it.
                let corners = BoundingBox { min: *min, max: *max }.corners();
                let edges = (0..8).flat_map(|i| [1, 2, 4].map(|bit| (i, i | bit))).filter(|(i, j)| i != j);
                out.trails.extend(edges.map(|(i, j)| (vec![corners[i], corners[j]], OBSTACLE_COLOUR)));
                None
            }
            other => obstacle_solid(other, OBSTACLE_M).map(|solid| (solid, OBSTACLE_COLOUR)),
        });
    }
    for (door, is_open) in record.doors.iter().zip(&moment.is_open) {
        let Obstacle::Wall { from, to, radius } = door else { continue };
        // The two ends of an open door are left.
        let parts = if *is_open { vec![(*from, *from), (*to, *to)] } else { vec![(*from, *to)] };
        out.solids.extend(parts.into_iter().map(|(a, b)| (bar(a, b, radius.max(2.0 * least_m)), INFORMED_COLOUR)));
    }
    for place in &record.places {
        out.rings.push((place.at, place.radius, colour::REACHED.alpha(0.5)));
        out.rings.extend(place.slots.iter().map(|slot| (*slot, SLOT_M, colour::REACHED.alpha(0.6))));
        out.names.push((place.at, place.name.clone(), colour::REACHED));
    }
    // Positions of some agents in the last seconds.
    let upto = (moment.time_s / TRAIL_S) as usize + 1;
    for (m, trail) in record.trails.iter().filter(|(m, _)| moment.agents.get(*m).is_some_and(Option::is_some)) {
        let upto = upto.min(trail.len());
        let tint = group_colour(record.groups.get(*m).copied().unwrap_or(0));
        out.trails.push((trail[upto.saturating_sub(TRAIL_POINTS)..upto].to_vec(), tint.alpha(0.5)));
    }
    for (m, agent) in moment.agents.iter().enumerate() {
        let Some(RecordedAgent { at, velocity, is_informed }) = *agent else { continue };
        let radius = record.radii[m].max(least_m);
        out.solids.push((bar(at, at, radius), group_colour(record.groups[m])));
        out.rings.extend(is_informed.then_some((at, 1.4 * radius, INFORMED_COLOUR)));
        // A tick along the velocity.
        if velocity.length() > DIRECTION_SHOWN_MPS {
            out.trails.push((vec![at, at + 1.6 * radius * velocity.normalize()], colour::INK));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(in_the_air: bool) -> AgentsRecord {
        let seen = |m: usize, t: f32| {
            let at = Vec3::new(t + m as f32, if in_the_air { 3.0 } else { 0.0 }, 2.0 * m as f32);
            Some(RecordedAgent { at, velocity: Vec3::X, is_informed: m == 1 })
        };
        let moment = |t: f32| CrowdMoment {
            time_s: f64::from(t),
            agents: (0..4).map(|m| seen(m, t)).chain([None]).collect(),
            is_open: Vec::new(),
        };
        AgentsRecord {
            first: 0,
            in_the_air,
            names: vec!["a".into(), "b".into()],
            groups: vec![0, 1, 0, 1, 0],
            radii: vec![0.3; 5],
            moments: (0..4).map(|t| moment(t as f32)).collect(),
            trails: vec![(0, (0..8).map(|i| Vec3::X * 0.4 * i as f32).collect())],
            paths: vec![vec![Vec3::ZERO, Vec3::Z, Vec3::X]],
            doors: Vec::new(),
            places: Vec::new(),
            obstacles: vec![
                Obstacle::Ball { centre: Vec3::Z, radius: 0.5 },
                Obstacle::Wall { from: Vec3::ZERO, to: Vec3::Y, radius: 0.2 },
                Obstacle::Polygon { corners: vec![Vec3::ZERO, Vec3::X, Vec3::Z] },
                Obstacle::Box { min: Vec3::ZERO, max: Vec3::ONE },
                Obstacle::Mover { path: vec![(0.0, Vec3::ZERO), (2.0, Vec3::X)], radius: 0.4 },
            ],
        }
    }

    #[test]
    fn all_agents_are_drawn_and_the_air_is_also_seen_from_the_side() {
        let report = SceneFigures::default();
        let (ground, air) =
            (crowd_sheet("square", &report, &record(false)), crowd_sheet("square", &report, &record(true)));
        assert_ne!(ground, air);
        assert_eq!(ground, crowd_sheet("square", &report, &record(false)));
        let mut empty = record(false);
        empty.moments.iter_mut().for_each(|m| m.agents.fill(None));
        empty.trails.clear();
        assert_ne!(ground, crowd_sheet("square", &report, &empty));
    }

    #[test]
    fn empty_and_broken_records_are_drawn_without_a_panic() {
        crowd_sheet("square", &SceneFigures::default(), &AgentsRecord::default());
        let mut broken = record(false);
        broken.moments[0].agents[0] = Some(RecordedAgent { at: Vec3::NAN, velocity: Vec3::NAN, is_informed: true });
        broken.obstacles.push(Obstacle::Mover { path: Vec::new(), radius: 1.0 });
        crowd_sheet("square", &SceneFigures::default(), &broken);
    }
}
