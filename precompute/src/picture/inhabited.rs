//! The picture of a scene in a world: everybody at its end, and moments of one who did much.

use super::canvas::Picture;
use super::figure::{BodyColours, Figure};
use super::sheet::sheet;
use super::world::{WorldFigure, WorldLook, WorldStrip, WorldView, world_sheet, world_strip, world_units};
use crate::environment::PlacedGeometry;
use crate::scene::world::{WorldRecord, WorldReport, WorldScene};
use glam::Vec3;
use std::f32::consts::PI;
use throng_runtime::{Joint, NUM_JOINTS};

/// Moments side by side, and rows of them.
const COLUMNS: usize = 10;
const ROWS: usize = 2;
/// Looks between moments.
const STRIDE: usize = 5;
/// Width that a moment shows. [Unit: m]
const WIDTH_M: f32 = 2.6;
/// From where worlds are seen: heading and elevation. [Unit: rad]
const FROM: (f32, f32) = (0.8 * PI, 0.6);

/// Draws a scene in a world: everybody at the end, and moments of a followed character.
///
/// - `followed`: numbers of the characters that were recorded, in the order of the record.
pub fn inhabited_sheet(
    scene: &WorldScene,
    report: &WorldReport,
    record: &WorldRecord,
    geometry: &PlacedGeometry,
    followed: &[usize],
) -> Picture {
    let units = world_units(geometry);
    let one = |p: &[Vec3; NUM_JOINTS]| WorldFigure { figure: Figure::from_positions(p), colours: BodyColours::default() };
    let figures: Vec<WorldFigure> = record.poses.iter().map(one).collect();
    let title = format!("{}: {} characters", scene.name, report.characters);
    let subtitle = format!(
        "{:.0} s: {} overlap(s) of people, {} penetration(s), {} stuck; {:.1} wishes fulfilled and {:.0} m travelled a \
         minute and character; planted feet slip {:.0} mm/s (95th percentile)",
        report.simulated_s,
        report.character_overlaps,
        report.environment_penetrations,
        report.stuck,
        report.fulfilled_per_minute,
        report.travelled_m_per_minute,
        1000.0 * report.foot_slip_p95_mps
    );
    let middle = Vec3::from_array(scene.picture.focus.unwrap_or_default());
    let look = WorldLook {
        heading: FROM.0,
        elevation: FROM.1,
        focus: scene.picture.width_m.map(|width| (middle, width)),
    };
    let (title, subtitle) = (title.as_str(), subtitle.as_str());
    let overview = WorldView {
        title,
        subtitle,
        size: (1600, 1100),
        figures: &figures,
        units: &units,
        trails: &[],
        names: &[],
        look,
    };
    let overview = world_sheet(&overview);
    let Some((who, from)) = liveliest(record, followed, scene.picture.follow) else {
        return overview;
    };
    let looks = record.followed[from..].iter().step_by(STRIDE).take(COLUMNS * ROWS);
    let moments: Vec<(f32, Figure)> = looks.map(|(t, p)| (*t, Figure::from_positions(&p[who]))).collect();
    let strip = WorldStrip {
        title: &format!("Character {}", followed[who]),
        subtitle: "one moment every half a second",
        moments: &moments,
        units: &units,
        columns: COLUMNS,
        width_m: WIDTH_M,
        from: (FROM.0, 0.25),
    };
    sheet(&[&overview, &world_strip(&strip)])
}

/// Which recorded character to show, and from which look on: where the hips move up and down most.
fn liveliest(record: &WorldRecord, followed: &[usize], asked: Option<usize>) -> Option<(usize, usize)> {
    let span = STRIDE * COLUMNS * ROWS;
    let starts: Vec<usize> = (0..record.followed.len().saturating_sub(span).max(1)).step_by(STRIDE).collect();
    let range = |who: usize, from: usize| {
        let looks = record.followed[from..].iter().take(span);
        let heights = looks.map(|(_, p)| p[who][Joint::Hips.index()].y);
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        high - low
    };
    let wanted = |who: &usize| asked.is_none_or(|a| followed[*who] == a);
    let all = (0..followed.len()).filter(wanted).flat_map(|w| starts.iter().map(move |&s| (w, s)));
    let all = all.filter(|_| !record.followed.is_empty());
    all.max_by(|a, b| range(a.0, a.1).total_cmp(&range(b.0, b.1)))
}
