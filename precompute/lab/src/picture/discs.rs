//! The picture of a crowd of discs or balls: from above at a few times, in the air also from the side.

use super::canvas::Area;
use super::furniture::{NamePlates, grid, header, legend, nice_step, scale_bar};
use super::{Colour, Picture, PictureCamera, colour};
use crate::run::{
    AgentFigures, AgentsRecord, CrowdMoment, RecordedAgent, RecordedPlace, SceneFigures, TRAIL_S,
    position_on_timed_path,
};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use throng_crowd::Obstacle;

/// Colours of groups, in their order.
const GROUPS: [u32; 6] = [0xe8743b, 0x2f63a8, 0x1f9e89, 0x7a2bbf, 0xc0b027, 0xb0446a];
/// Colour of agents that know of a happening, and of doors.
const INFORMED_COLOUR: Colour = Colour::hex(0xd62728);
/// Colour of obstacles.
pub(super) const OBSTACLE_COLOUR: Colour = Colour::hex(0x8a8578);
/// Width of the page (px).
pub(super) const WIDTH: f32 = 1600.0;
/// Margin around panels (px).
const EDGE: f32 = 16.0;
/// Height of the title (px).
const TOP: f32 = 84.0;
/// Greatest height of a panel (px).
const MAX_PANEL_HEIGHT: f32 = 900.0;
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
    let views = &[ViewDirection::Above, ViewDirection::Side][..if record.in_the_air { 2 } else { 1 }];
    let sizes: Vec<Vec2> = views.iter().map(|v| v.projected_size(high - low)).collect();
    // Views of wide crowds are placed below each other, others side by side.
    let columns = if sizes[0].x > 2.5 * sizes[0].y { 1 } else { 2 };
    let width = (WIDTH - EDGE * (columns as f32 + 1.0)) / columns as f32;
    let tallest = sizes.iter().map(|s| s.y / s.x).fold(0.0, f32::max);
    let px_per_m = (width / sizes[0].x).min(MAX_PANEL_HEIGHT / (tallest * sizes[0].x));
    let heights: Vec<f32> = sizes.iter().map(|s| (s.y * px_per_m).max(60.0)).collect();
    let rows = record.moments.len().max(1).div_ceil(columns);
    let row = heights.iter().map(|h| h + EDGE).sum::<f32>();
    let mut page = Picture::new(WIDTH as u32, (TOP + rows as f32 * row) as u32, colour::PAPER);
    header(&mut page, 1.0, title, subtitle);
    let entries: Vec<_> = record.names.iter().enumerate().map(|(g, n)| (group_colour(g), n.clone())).collect();
    legend(&mut page, Area::new(0.0, 0.0, WIDTH - EDGE, TOP), 1.0, &entries, remark);
    for (i, moment) in record.moments.iter().enumerate() {
        let x = EDGE + (i % columns) as f32 * (width + EDGE);
        let mut y = TOP + (i / columns) as f32 * row;
        for (view, height) in views.iter().zip(&heights) {
            let mut panel = Picture::new(width as u32, *height as u32, colour::GROUND);
            let middle = 0.5 * Vec2::new(panel.width() as f32, panel.height() as f32);
            let camera = view.camera().framed(0.5 * (low + high), middle, px_per_m);
            draw(&mut panel, &camera, record, moment, *view);
            page.draw_picture(&panel, (x as i32, y as i32));
            y += height + EDGE;
        }
    }
    page
}

/// Direction from which a crowd is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ViewDirection {
    Above,
    Side,
}

impl ViewDirection {
    /// Camera of the view: +X to the right; from above +Z downwards, from the side height upwards.
    fn camera(self) -> PictureCamera {
        PictureCamera::looking_along(PI, if self == Self::Above { FRAC_PI_2 } else { 0.0 })
    }

    /// Width and height of a box in this view.
    fn projected_size(self, size: Vec3) -> Vec2 {
        Vec2::new(size.x, if self == Self::Above { size.z } else { size.y })
    }
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

fn draw(panel: &mut Picture, camera: &PictureCamera, record: &AgentsRecord, moment: &CrowdMoment, view: ViewDirection) {
    let width = panel.width() as f32;
    if view == ViewDirection::Above {
        grid(panel, camera, nice_step(width / camera.px_per_m / 16.0), 1.0);
    }
    draw_paths(panel, camera, record);
    record.obstacles.iter().for_each(|o| draw_obstacle(panel, camera, o, (moment.time_s, record.in_the_air)));
    let doors = record.doors.iter().zip(&moment.is_open);
    doors.for_each(|(door, is_open)| draw_door(panel, camera, door, *is_open));
    let mut tags = NamePlates::default();
    record.places.iter().for_each(|p| draw_place(panel, camera, p, &mut tags));
    draw_trails(panel, camera, record, moment);
    let mut order: Vec<(usize, &RecordedAgent)> =
        moment.agents.iter().enumerate().filter_map(|(m, s)| Some((m, s.as_ref()?))).collect();
    order.sort_by(|a, b| camera.depth(b.1.at).total_cmp(&camera.depth(a.1.at)).then(a.0.cmp(&b.0)));
    order.iter().for_each(|(m, s)| draw_agent(panel, camera, s, record.radii[*m], record.groups[*m]));
    scale_bar(panel, camera, 1.0);
    let what = if record.in_the_air { [" from above", " from the side"][view as usize] } else { "" };
    tags.draw_plate(panel, Vec2::new(0.5 * width, 26.0), 1.0, &format!("{:.1} s{what}", moment.time_s), colour::INK);
}

fn draw_agent(panel: &mut Picture, camera: &PictureCamera, s: &RecordedAgent, radius: f32, group: usize) {
    let (at, px) = (camera.project(s.at), (radius * camera.px_per_m).max(1.2));
    panel.fill_disc(at, px, group_colour(group));
    if s.is_informed {
        panel.stroke_oval(at, Vec2::splat(px), (0.3 * px).clamp(1.2, 4.0), INFORMED_COLOUR);
    }
    let ahead = camera.project(s.at + s.velocity) - at;
    // A tick along the velocity, longer for faster agents.
    if px > 2.0 && ahead.length() > 0.1 * camera.px_per_m {
        let tip = at + ahead.normalize_or_zero() * px * 1.5;
        panel.stroke_line(&[at, tip], (0.28 * px).clamp(1.0, 3.0), colour::INK);
    }
}

/// Draws the positions of some agents in the last seconds.
fn draw_trails(panel: &mut Picture, camera: &PictureCamera, record: &AgentsRecord, moment: &CrowdMoment) {
    let upto = (moment.time_s / TRAIL_S) as usize + 1;
    for (m, trail) in &record.trails {
        let is_there = moment.agents.get(*m).is_some_and(Option::is_some);
        let upto = if is_there { upto.min(trail.len()) } else { 0 };
        let recent = &trail[upto.saturating_sub(TRAIL_POINTS)..upto];
        let points: Vec<Vec2> = recent.iter().map(|p| camera.project(*p)).collect();
        let tint = group_colour(record.groups.get(*m).copied().unwrap_or(0));
        panel.stroke_line(&points, (0.12 * camera.px_per_m).clamp(0.8, 2.5), tint.alpha(0.35));
    }
}

/// Draws paths that lead around obstacles.
fn draw_paths(panel: &mut Picture, camera: &PictureCamera, record: &AgentsRecord) {
    let bent: Vec<&Vec<Vec3>> = record.paths.iter().filter(|w| w.len() > 2).collect();
    for path in bent.iter().step_by(bent.len().div_ceil(MAX_PATHS).max(1)) {
        let points: Vec<Vec2> = path.iter().map(|p| camera.project(*p)).collect();
        panel.stroke_line(&points, 1.0, colour::REACHED.alpha(0.35));
    }
}

/// Draws a door: a thick line if it is closed, its two ends if it is open.
fn draw_door(panel: &mut Picture, camera: &PictureCamera, door: &Obstacle, is_open: bool) {
    let Obstacle::Wall { from, to, .. } = door else { return };
    let (a, b) = (camera.project(*from), camera.project(*to));
    if is_open {
        [a, b].iter().for_each(|end| panel.fill_disc(*end, 3.5, INFORMED_COLOUR));
    } else {
        panel.stroke_line(&[a, b], 4.0, INFORMED_COLOUR);
    }
}

/// Draws a place: its edge, its name, and its standing places.
fn draw_place(panel: &mut Picture, camera: &PictureCamera, place: &RecordedPlace, tags: &mut NamePlates) {
    let at = camera.project(place.at);
    panel.stroke_oval(at, Vec2::splat(place.radius * camera.px_per_m), 1.2, colour::REACHED.alpha(0.5));
    let radius = (0.3 * camera.px_per_m).clamp(1.5, 9.0);
    for slot in &place.slots {
        panel.stroke_oval(camera.project(*slot), Vec2::splat(radius), 1.0, colour::REACHED.alpha(0.6));
    }
    tags.draw_plate(panel, at, 0.8, &place.name, colour::REACHED);
}

fn draw_obstacle(panel: &mut Picture, camera: &PictureCamera, obstacle: &Obstacle, (time_s, in_the_air): (f64, bool)) {
    let scale = camera.px_per_m;
    match obstacle {
        Obstacle::Ball { centre, radius } => panel.fill_disc(camera.project(*centre), radius * scale, OBSTACLE_COLOUR),
        Obstacle::Wall { from, to, radius } => {
            let (a, b, width) = (camera.project(*from), camera.project(*to), (2.0 * radius * scale).max(2.0));
            if a.distance(b) < 0.5 {
                panel.fill_disc(a, 0.5 * width, OBSTACLE_COLOUR);
            } else {
                panel.stroke_line(&[a, b], width, OBSTACLE_COLOUR);
            }
        }
        Obstacle::Polygon { corners } => {
            panel.fill_polygon(&corners.iter().map(|c| camera.project(*c)).collect::<Vec<_>>(), OBSTACLE_COLOUR);
        }
        Obstacle::Box { min, max } => {
            let (a, b) = (camera.project(*min), camera.project(*max));
            let (min, max) = (a.min(b), a.max(b));
            if in_the_air {
                // Only the outline: boxes around a flock would hide it.
                let outline = [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y), min];
                panel.stroke_line(&outline, 1.5, OBSTACLE_COLOUR);
            } else {
                panel.fill_rect(Area::new(min.x, min.y, max.x - min.x, max.y - min.y), 0.0, OBSTACLE_COLOUR);
            }
        }
        Obstacle::Mover { path, radius } => {
            let at = camera.project(position_on_timed_path(path, time_s));
            panel.fill_disc(at, radius * scale, OBSTACLE_COLOUR.mix(colour::INK, 0.4));
        }
        _ => {}
    }
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
