//! The picture of a group on random paths: all characters at the end, one path in several styles, and moments of a character
//! that changed speed.

use super::world::OBLIQUE_VIEW;
use super::{
    BodyColours, BodyFigure, Colour, Picture, WorldCamera, WorldFigure, WorldMoment, WorldSheet, WorldStrip, colour,
    sheet, world_sheet, world_strip,
};
use crate::run::{JointPositions, PathsRecord, SceneFigures, StyleWalk, style_path};
use glam::Vec3;
use std::f32::consts::PI;
use throng_core::{Joint, NUM_JOINTS};

/// Number of moments side by side, and of rows.
const COLUMNS: usize = 12;
const ROWS: usize = 3;
/// Width that a moment shows (m).
const WIDTH_M: f32 = 2.2;
/// Distance between styles side by side (m).
const APART_M: f32 = 3.2;
/// Colour of the path under figures.
const TRAIL_COLOUR: Colour = Colour::hex(0x8a8578);
/// Width of the overview (m).
const OVERVIEW_M: f32 = 34.0;

/// Draws a group on random paths.
///
/// - `poses`: poses of the whole group at the end.
/// - `styles`: a path in several styles; may be empty.
/// - `length_m`: length of that path (m).
pub(super) fn walkers_sheet(
    title: &str,
    centre: [f32; 2],
    figures: &SceneFigures,
    record: &PathsRecord,
    poses: &[JointPositions],
    styles: &[StyleWalk],
    length_m: f32,
) -> Picture {
    let mut pictures = vec![overview(title, centre, figures, poses)];
    if !styles.is_empty() {
        pictures.push(styles_sheet(styles, length_m));
    }
    pictures.extend(draw_moments(record));
    sheet(&pictures.iter().collect::<Vec<_>>())
}

fn world_figure(pose: &[Vec3; NUM_JOINTS]) -> WorldFigure {
    WorldFigure { figure: BodyFigure::from_positions(pose), colours: BodyColours::default() }
}

fn overview(title: &str, centre: [f32; 2], figures: &SceneFigures, poses: &[JointPositions]) -> Picture {
    let bodies: Vec<WorldFigure> = poses.iter().map(world_figure).collect();
    let f = figures.paths.clone().unwrap_or_default();
    let (mean, most, slip_mmps) =
        (f.speed_mean_mps, f.speed_max_mps, 1000.0 * figures.foot_slip_p95_mps.unwrap_or_default());
    let pace = format!("{:.0} s at {mean:.1} m/s on average, {most:.1} at most", figures.simulated_s);
    let subtitle = format!("{pace}; planted feet slip {slip_mmps:.0} mm/s (95th percentile)");
    let focus = Some((Vec3::new(centre[0], 0.0, centre[1]), OVERVIEW_M));
    let (size, camera) = ((1600, 900), WorldCamera { focus, ..OBLIQUE_VIEW });
    world_sheet(&WorldSheet { title, subtitle: &subtitle, size, figures: &bodies, camera, ..WorldSheet::default() })
}

/// Draws a path in several styles, side by side, seen from beside.
fn styles_sheet(styles: &[StyleWalk], length_m: f32) -> Picture {
    let beside = |i: usize| Vec3::X * (i as f32 * -APART_M);
    let (mut figures, mut trails, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for (i, style) in styles.iter().enumerate() {
        let place = |p: &[Vec3; NUM_JOINTS]| p.map(|j| j + beside(i));
        figures.extend(style.poses.iter().map(|p| world_figure(&place(p))));
        let point = |k: usize| {
            let (at, _) = style_path(length_m * k as f32 / 100.0);
            Vec3::new(at.x, 0.005, at.y) + beside(i)
        };
        trails.push(((0..=100).map(point).collect(), TRAIL_COLOUR));
        names.push((point(0) - Vec3::Z * 0.9, style.name.clone(), colour::INK));
    }
    let centre = Vec3::new(0.4 - 0.5 * APART_M * (styles.len() - 1) as f32, 0.6, 0.45 * length_m);
    world_sheet(&WorldSheet {
        title: "One path in several styles",
        subtitle: "figures are equally far apart along the path, not in time",
        size: (1600, 1000),
        figures: &figures,
        trails: &trails,
        names: &names,
        camera: WorldCamera { heading: 0.5 * PI, elevation: 0.7, focus: Some((centre, 1.25 * length_m)) },
        ..WorldSheet::default()
    })
}

/// Draws moments of the recorded character whose speed changed most.
fn draw_moments(record: &PathsRecord) -> Option<Picture> {
    let span = COLUMNS * ROWS;
    let num = record.samples.first()?.1.len();
    let range = |who: usize, from: usize| {
        let speeds = record.samples[from..].iter().take(span).map(|(_, s, _)| s[who]);
        let (low, high) = speeds.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let starts = 0..record.samples.len().saturating_sub(span).max(1);
    let all = (0..num).flat_map(|w| starts.clone().map(move |s| (w, s)));
    let (who, from) = all.max_by(|a, b| range(a.0, a.1).total_cmp(&range(b.0, b.1)))?;
    let shown = &record.samples[from..(from + span).min(record.samples.len())];
    let one = |time_s: f32, pose| WorldMoment::of_one(time_s, BodyFigure::from_positions(pose));
    let moments: Vec<WorldMoment> = shown.iter().map(|(t, _, p)| one(*t, &p[who])).collect();
    let speeds: Vec<f32> = shown.iter().map(|(_, s, _)| s[who]).collect();
    let [first, last] = [shown.first()?, shown.last()?].map(|s| s.2[who][Joint::Hips.index()]);
    let offset = last - first;
    let (first, last, most) = (speeds.first()?, speeds.last()?, speeds.iter().copied().fold(0.0, f32::max));
    let range = format!("from {first:.1} to {last:.1} m/s, {most:.1} at most");
    let strip = WorldStrip {
        title: &format!("Character {who}"),
        subtitle: &format!("one moment every tenth of a second; {range}"),
        moments: &moments,
        columns: COLUMNS,
        width_m: WIDTH_M,
        // Seen from beside its direction of travel.
        view_angles: (offset.x.atan2(offset.z) + 0.5 * PI, 0.15),
        ..WorldStrip::default()
    };
    Some(world_strip(&strip))
}
