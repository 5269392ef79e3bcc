//! The picture of a group with policies: all characters at the end, and moments around blows of the recorded ones.

use super::canvas::Area;
use super::furniture::header;
use super::shadow::Shadows;
use super::text::{Align, TextStyle, draw_text};
use super::{
    ArrivalState, BodyColours, BodyFigure, Colour, CrowdCharacter, CrowdView, Focus, Picture, PictureCamera, colour,
    crowd_overview, sheet, sprite,
};
use crate::run::{FightFrame, FightRecord, JointPositions, SceneFigures};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;
use throng_core::{Joint, Planar};
use throng_simulation::scene::GroupConfig;
use throng_simulation::sparring::StruckPart;
use throng_simulation::{CharacterEvent, GroupMotion, SimulationEvent};

/// Number of moments side by side.
const COLUMNS: usize = 8;
/// Time between moments (s).
const MOMENT_S: f32 = 0.1;
/// Number of rows of moments, each around another blow.
const ROWS: usize = 3;
/// Width that a moment shows (m).
const WIDTH_M: f32 = 2.1;

/// Draws a group with policies: all characters from above, and rows of moments around blows that landed.
///
/// - `poses`: poses of the whole group at the end.
pub(super) fn fight_sheet(
    title: &str,
    figures: &SceneFigures,
    group: &GroupConfig,
    record: &FightRecord,
    poses: &[JointPositions],
) -> Picture {
    let f = figures.blows.clone().unwrap_or_default();
    let [landed, blocked] = [f.landed_fraction, f.blocked_fraction].map(|share| 100.0 * share);
    let hits = f.hits_per_minute;
    let blows = match f.thrown {
        0 => String::from("no blow was thrown"),
        thrown => format!(
            "{thrown} blows thrown, {landed:.0} % landed, {blocked:.0} % blocked; {hits:.1} landed a minute and character"
        ),
    };
    let slip_mmps = 1000.0 * figures.foot_slip_p95_mps.unwrap_or_default();
    let subtitle =
        format!("{:.0} s: {blows}; planted feet slip {slip_mmps:.0} mm/s (95th percentile)", figures.simulated_s);
    let crowd = overview(group, record, poses, [title, &subtitle]);
    if f.thrown == 0 {
        return crowd;
    }
    sheet(&[&crowd, &draw_moments(record, group.target.radius_m as f32)])
}

fn overview(group: &GroupConfig, record: &FightRecord, poses: &[JointPositions], lines: [&str; 2]) -> Picture {
    let [title, subtitle] = lines;
    let is_pairs = group.motion == GroupMotion::Sparring;
    let one = |(c, &root): (usize, &Planar)| CrowdCharacter {
        root,
        figure: poses.get(c).map(BodyFigure::from_positions),
        trail: &[],
        target: record.targets.get(c).filter(|_| !is_pairs).map(|t| Vec2::new(t.x, t.z)),
        arrival: if is_pairs && c % 2 == 1 { ArrivalState::OnTheWay } else { ArrivalState::Reached },
    };
    let characters: Vec<_> = record.roots.iter().enumerate().map(one).collect();
    let few = characters.len() <= 4;
    let middle: Vec2 = characters.iter().map(|c| Vec2::new(c.root.x, c.root.z)).sum::<Vec2>();
    let centre = middle / characters.len().max(1) as f32;
    crowd_overview(&CrowdView {
        title,
        subtitle,
        size: (1600, if few { 620 } else { 1000 }),
        characters: &characters,
        walls: &record.walls,
        reach_m: group.target.radius_m as f32,
        names: if is_pairs { ["the first of a pair", "the second", ""] } else { ["characters", "", ""] },
        remark: if is_pairs { "at the end" } else { "at the end; ring: target" },
        marked: None,
        focus: few.then_some(Focus { centre, width_m: 6.0 }),
    })
}

/// Draws rows of moments, each around a blow that landed.
///
/// - `radius_m`: radius of the target, if there is one (m).
fn draw_moments(record: &FightRecord, radius_m: f32) -> Picture {
    let rows = choose_blows(&record.events.iter().filter_map(LandedBlow::from_event).collect::<Vec<_>>());
    let (width, edge, top, label) = (1600.0, 16.0, 84.0, 30.0);
    let cell = (width - 2.0 * edge) / COLUMNS as f32;
    let height = 2.15 * (cell / WIDTH_M);
    let num_rows = rows.len().max(1) as f32;
    let mut page = Picture::new(width as u32, (top + num_rows * (height + label + edge)) as u32, colour::PAPER);
    let subtitle = if rows.is_empty() {
        "no blow of the recorded characters landed"
    } else {
        "each row around a blow that landed, seen from beside; red: where it met, violet: where arms caught it"
    };
    header(&mut page, 1.0, "Blows", subtitle);
    for (row, event) in rows.iter().enumerate() {
        let y = top + row as f32 * (height + label + edge);
        for column in 0..COLUMNS {
            let time_s = event.time_s + (column as f32 - 3.0) * MOMENT_S;
            let Some(frame) = nearest_frame(&record.frames, time_s) else { continue };
            let area = Area::new(edge + column as f32 * cell, y, cell, height);
            let panel = draw_moment(frame, event, record, radius_m, area.size);
            page.draw_picture(&panel, (area.min.x as i32, area.min.y as i32));
            let style = TextStyle { size: 19.0, colour: colour::INK, align: Align::Centre, bold: column == 3 };
            let at = Vec2::new(area.min.x + 0.5 * cell, area.max().y + 22.0);
            draw_text(&mut page, at, &format!("{:.2} s", frame.time_s), style);
        }
    }
    page
}

/// A blow that landed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LandedBlow {
    time_s: f32,
    /// Number of the striking character within the group.
    character: usize,
    point: Vec3,
    /// Part of the opponent that was hit; none for a target.
    part: Option<StruckPart>,
}

impl LandedBlow {
    fn from_event(event: &SimulationEvent) -> Option<Self> {
        let (point, part) = match event.kind {
            CharacterEvent::Hit { at } => (at, None),
            CharacterEvent::Struck { part, at, .. } => (at, Some(part)),
            _ => return None,
        };
        Some(Self { time_s: event.time_s as f32, character: event.who, point, part })
    }
}

/// Selects the blows to show: spread over the run, at least two seconds apart.
fn choose_blows(events: &[LandedBlow]) -> Vec<LandedBlow> {
    let mut apart: Vec<LandedBlow> = Vec::new();
    for e in events {
        if apart.last().is_none_or(|l| e.time_s - l.time_s > 2.0) && e.time_s > 0.4 {
            apart.push(*e);
        }
    }
    let n = apart.len();
    (0..ROWS.min(n)).map(|k| apart[k * n / ROWS.min(n)]).collect()
}

fn nearest_frame(frames: &[FightFrame], time_s: f32) -> Option<&FightFrame> {
    let i = frames.partition_point(|f| f.time_s < time_s);
    let near = |i: usize| frames.get(i).map(|f| (f, (f.time_s - time_s).abs()));
    [i.checked_sub(1).and_then(near), near(i)].into_iter().flatten().min_by(|a, b| a.1.total_cmp(&b.1)).map(|n| n.0)
}

/// Draws one moment, seen from beside the line of the blow.
fn draw_moment(frame: &FightFrame, event: &LandedBlow, record: &FightRecord, radius_m: f32, size: Vec2) -> Picture {
    let px_per_m = size.x / WIDTH_M;
    let mut panel = Picture::new(size.x as u32, size.y as u32, colour::GROUND);
    let ground_y = size.y - 0.16 * px_per_m;
    panel.stroke_line(&[Vec2::new(0.0, ground_y), Vec2::new(size.x, ground_y)], 1.2, colour::GRID);
    let at_blow = nearest_frame(&record.frames, event.time_s).unwrap_or(frame);
    let striker = at_blow.poses.get(event.character).map_or(Vec3::ZERO, |p| p[Joint::Hips.index()]);
    let other = at_blow.poses.get(event.character ^ 1).map_or(event.point, |p| p[Joint::Hips.index()]);
    let line = other - striker;
    let camera = PictureCamera::looking_along(line.x.atan2(line.z) + FRAC_PI_2, 0.08);
    let middle = 0.5 * (striker + other) * Vec3::new(1.0, 0.0, 1.0);
    let camera = camera.framed(middle, Vec2::new(0.5 * size.x, ground_y), px_per_m);
    let all = frame.poses.iter().map(BodyFigure::from_positions).enumerate();
    let mut figures: Vec<(usize, BodyFigure)> = all.filter(|(_, f)| f.is_drawable()).collect();
    figures.sort_by(|a, b| camera.depth(b.1.joint(Joint::Hips)).total_cmp(&camera.depth(a.1.joint(Joint::Hips))));
    if let Some(mut shadows) = Shadows::new(&panel) {
        figures.iter().for_each(|(_, f)| shadows.add(f, &camera));
        shadows.draw(&mut panel, (0.03 * px_per_m) as usize + 1, colour::INK.alpha(0.22));
    }
    if let Some(target) = frame.target {
        panel.fill_disc(camera.project(target), radius_m * px_per_m, colour::MARK.mix(colour::GROUND, 0.5));
    }
    for (character, figure) in &figures {
        let colours = if *character == 0 { BodyColours::default() } else { BodyColours::plain(SECOND_COLOUR) };
        sprite::draw(&mut panel, figure, &colours, &camera);
    }
    let blows = record.events.iter().filter_map(LandedBlow::from_event);
    for e in blows.filter(|e| (e.time_s - frame.time_s).abs() < 0.02) {
        let tint = if e.part == Some(StruckPart::Arm) { colour::MARK } else { BLOW_COLOUR };
        panel.stroke_oval(camera.project(e.point), Vec2::splat(0.09 * px_per_m), 3.0, tint);
    }
    panel
}

/// Colour of the second of a pair.
const SECOND_COLOUR: Colour = Colour::hex(0x4f9a6b);
/// Colour of the point that a blow hit.
const BLOW_COLOUR: Colour = Colour::hex(0xd62728);

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Skeleton;

    fn event(time_s: f32) -> SimulationEvent {
        let happened = CharacterEvent::Struck { opponent: 1, part: StruckPart::Head, at: Vec3::new(0.0, 1.5, 0.7) };
        SimulationEvent { time_s: f64::from(time_s), who: 0, kind: happened }
    }

    #[test]
    fn blows_are_spread_over_the_run() {
        let events: Vec<_> = (0..60).filter_map(|i| LandedBlow::from_event(&event(0.5 * i as f32))).collect();
        let times: Vec<f32> = choose_blows(&events).iter().map(|e| e.time_s).collect();
        assert_eq!(times.len(), ROWS);
        assert!(times.windows(2).all(|w| w[1] - w[0] > 5.0), "{times:?}");
        assert_eq!(choose_blows(&events[..3]).len(), 1);
        assert!(choose_blows(&[]).is_empty());
    }

    #[test]
    fn empty_and_broken_records_are_drawn_without_a_panic() {
        let pose = Skeleton::default().rest_positions();
        let frame = |time_s, poses| FightFrame { time_s, poses, target: Some(Vec3::new(0.0, 1.5, 0.7)) };
        let whole = FightRecord {
            frames: vec![frame(0.5, vec![pose, pose]), frame(0.6, vec![[Vec3::NAN; 22]]), frame(0.7, vec![])],
            events: vec![event(0.5), event(5.0)],
            ..FightRecord::default()
        };
        assert!(draw_moments(&whole, 0.12).height() > draw_moments(&FightRecord::default(), 0.12).height() / 2);
        assert_eq!(draw_moments(&whole, 0.12), draw_moments(&whole, 0.12));
        assert_ne!(draw_moments(&whole, 0.12), draw_moments(&whole, 0.3), "the target has its radius");
    }
}
