//! The picture of a group with policies: all characters at the end, and moments around blows of the recorded ones.

use super::{
    BodyColours, BodyFigure, Colour, Picture, WorldCamera, WorldFigure, WorldMoment, WorldSheet, WorldStrip, colour,
    sheet, world_sheet, world_strip,
};
use super::{discs::OBSTACLE_COLOUR, world::OBLIQUE_VIEW};
use crate::run::{FightFrame, FightRecord, JointPositions, SceneFigures};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;
use throng_bake::environment::UnitSolid;
use throng_core::Joint;
use throng_simulation::{CharacterEvent, GroupMotion, SimulationEvent, scene::GroupConfig, sparring::StruckPart};

/// Number of moments side by side.
const COLUMNS: usize = 8;
/// Time between moments (s).
const MOMENT_S: f32 = 0.1;
/// Number of rows of moments, each around another blow.
const ROWS: usize = 3;
/// Width that a moment shows (m).
const WIDTH_M: f32 = 2.1;
/// Width of the view of a few characters (m).
const FEW_M: f32 = 6.0;
/// Colour of the second of a pair.
const SECOND_COLOUR: Colour = Colour::hex(0x4f9a6b);
/// Colour of the point that a blow hit, and the radius of its mark (m).
const BLOW_COLOUR: Colour = Colour::hex(0xd62728);
const BLOW_M: f32 = 0.06;

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
    let landed: Vec<LandedBlow> = record.events.iter().filter_map(LandedBlow::from_event).collect();
    let rows = choose_blows(&landed).into_iter().map(|blow| blow_strip(record, &blow, group.target.radius_m as f32));
    let pictures: Vec<Picture> = std::iter::once(crowd).chain(rows).collect();
    sheet(&pictures.iter().collect::<Vec<_>>())
}

fn overview(group: &GroupConfig, record: &FightRecord, poses: &[JointPositions], lines: [&str; 2]) -> Picture {
    let is_pairs = group.motion == GroupMotion::Sparring;
    let tints = if is_pairs { [colour::REACHED, colour::ON_THE_WAY] } else { [colour::REACHED; 2] };
    let body = |(c, p): (usize, &JointPositions)| WorldFigure {
        figure: BodyFigure::from_positions(p),
        colours: BodyColours::plain(tints[c % 2]),
    };
    let figures: Vec<WorldFigure> = poses.iter().enumerate().map(body).collect();
    let on_ground = |p: Vec2| Vec3::new(p.x, 0.0, p.y);
    let wall = |w: &throng_geometry::Capsule2d| {
        let (from, to, radius) = (on_ground(w.from), on_ground(w.to), w.radius_m.max(0.03));
        (UnitSolid::Bar { from, to, radius }, OBSTACLE_COLOUR)
    };
    let few = figures.len() <= 4;
    let middle: Vec3 = figures.iter().map(|f| f.figure.joint(Joint::Hips)).sum();
    let focus = few.then(|| (middle / figures.len().max(1) as f32, FEW_M));
    let targets = record.targets.iter().filter(|_| !is_pairs);
    let num = figures.len();
    let entries = match is_pairs {
        true => vec![
            (tints[0], format!("the first of a pair: {}", num.div_ceil(2))),
            (tints[1], format!("the second: {}", num / 2)),
        ],
        false => vec![(tints[0], format!("characters: {num}"))],
    };
    world_sheet(&WorldSheet {
        title: lines[0],
        subtitle: lines[1],
        size: (1600, if few { 800 } else { 1000 }),
        figures: &figures,
        solids: &record.walls.iter().map(wall).collect::<Vec<_>>(),
        rings: &targets.map(|t| (t.with_y(0.0), group.target.radius_m as f32, tints[0])).collect::<Vec<_>>(),
        legend: (&entries, if is_pairs { "at the end" } else { "at the end; ring: target" }),
        camera: WorldCamera { focus, ..OBLIQUE_VIEW },
        ..WorldSheet::default()
    })
}

/// Draws moments around a blow that landed, seen from beside its line.
///
/// - `radius_m`: radius of the target, if there is one (m).
fn blow_strip(record: &FightRecord, blow: &LandedBlow, radius_m: f32) -> Picture {
    let hips = |character: usize| {
        let frame = nearest_frame(&record.frames, blow.time_s)?;
        Some(frame.poses.get(character)?[Joint::Hips.index()])
    };
    let line = hips(blow.character ^ 1).unwrap_or(blow.point) - hips(blow.character).unwrap_or_default();
    let times = (0..COLUMNS).map(|column| blow.time_s + (column as f32 - 3.0) * MOMENT_S);
    let frames = times.filter_map(|time_s| nearest_frame(&record.frames, time_s));
    world_strip(&WorldStrip {
        title: &format!("Blow at {:.2} s", blow.time_s),
        subtitle: "moments around a blow that landed, seen from beside; red: where it met, violet: where arms caught it",
        moments: &frames.map(|frame| moment(frame, record, radius_m)).collect::<Vec<_>>(),
        columns: COLUMNS,
        width_m: WIDTH_M,
        view_angles: (line.x.atan2(line.z) + FRAC_PI_2, 0.08),
        ..WorldStrip::default()
    })
}

/// The recorded characters, their target, and where their blows land at that moment.
fn moment(frame: &FightFrame, record: &FightRecord, radius_m: f32) -> WorldMoment {
    let ball = |at: Vec3, radius: f32, tint: Colour| (UnitSolid::Bar { from: at, to: at, radius }, tint);
    let body = |(character, pose): (usize, &JointPositions)| WorldFigure {
        figure: BodyFigure::from_positions(pose),
        colours: if character == 0 { BodyColours::default() } else { BodyColours::plain(SECOND_COLOUR) },
    };
    let blows = record.events.iter().filter_map(LandedBlow::from_event);
    let now = blows.filter(|e| (e.time_s - frame.time_s).abs() < 0.02);
    let mark =
        |e: LandedBlow| ball(e.point, BLOW_M, if e.part == Some(StruckPart::Arm) { colour::MARK } else { BLOW_COLOUR });
    let target = frame.target.map(|at| ball(at, radius_m, colour::MARK.mix(colour::GROUND, 0.5)));
    WorldMoment {
        time_s: frame.time_s,
        figures: frame.poses.iter().enumerate().map(body).collect(),
        framed: frame.poses.len(),
        solids: target.into_iter().chain(now.map(mark)).collect(),
        ..WorldMoment::default()
    }
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
        let blow = LandedBlow::from_event(&event(0.5)).expect("a blow that landed");
        let draw = |radius_m: f32| blow_strip(&whole, &blow, radius_m);
        assert!(blow_strip(&FightRecord::default(), &blow, 0.12).height() > 100);
        assert_eq!(draw(0.12), draw(0.12));
        assert_ne!(draw(0.12), draw(0.3), "the target has its radius");
    }
}
