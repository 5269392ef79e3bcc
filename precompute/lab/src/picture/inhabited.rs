//! The picture of a world: all characters at its end, and moments of a lively one.

use super::canvas::{Area, Picture};
use super::discs::group_colour;
use super::figure::{BodyColours, Figure};
use super::furniture::legend;
use super::sheet::sheet;
use super::world::{WorldFigure, WorldLook, WorldMoment, WorldStrip, WorldView, world_sheet, world_strip, world_units};
use crate::run::{Figures, Pose, WorldRecord};
use glam::Vec3;
use std::f32::consts::PI;
use throng_bake::environment::PlacedGeometry;
use throng_runtime::Joint;
use throng_runtime::simulation::scene::PictureConfig;

/// Moments side by side, and rows of them.
const COLUMNS: usize = 10;
const ROWS: usize = 2;
/// Looks between moments.
const STRIDE: usize = 5;
/// Width that a moment shows (m).
const WIDTH_M: f32 = 2.6;
/// From where worlds are seen: heading and elevation (rad).
const FROM: (f32, f32) = (0.8 * PI, 0.6);

/// Draws a world: all characters in it at the end, and moments of a followed one.
///
/// - `groups`: names and characters of the groups in the world, at the end; where there are several, each has a colour.
pub(super) fn inhabited_sheet(
    title: &str,
    figures: &Figures,
    (picture, record): (&PictureConfig, &WorldRecord),
    groups: &[(String, Vec<Pose>)],
    geometry: &PlacedGeometry,
) -> Picture {
    let units = world_units(geometry);
    let tint = |g: usize| if groups.len() > 1 { BodyColours::plain(group_colour(g)) } else { BodyColours::default() };
    let of_group = |(g, (_, poses)): (usize, &(String, Vec<Pose>))| -> Vec<WorldFigure> {
        let one = |p: &Pose| WorldFigure { figure: Figure::from_positions(p), colours: tint(g) };
        poses.iter().map(one).collect()
    };
    let bodies: Vec<WorldFigure> = groups.iter().enumerate().flat_map(of_group).collect();
    let f = figures.world.clone().unwrap_or_default();
    let subtitle = format!(
        "{:.0} s: {} overlap(s) of people, {} penetration(s), {} stuck; {:.1} wishes fulfilled and {:.0} m travelled a \
         minute and character; planted feet slip {:.0} mm/s (95th percentile)",
        figures.simulated_s,
        figures.character_overlaps.unwrap_or(0),
        f.environment_penetrations,
        figures.stuck.unwrap_or(0),
        f.fulfilled_per_minute,
        f.travelled_m_per_minute,
        1000.0 * figures.foot_slip_p95_mps.unwrap_or_default()
    );
    let middle = Vec3::from_array(picture.focus.unwrap_or_default());
    let look = WorldLook { heading: FROM.0, elevation: FROM.1, focus: picture.width_m.map(|width| (middle, width)) };
    let overview = WorldView {
        title,
        subtitle: &subtitle,
        size: (1600, 1100),
        figures: &bodies,
        units: &units,
        solids: &[],
        trails: &[],
        names: &[],
        look,
    };
    let mut overview = world_sheet(&overview);
    if groups.len() > 1 {
        let entries: Vec<_> = groups.iter().enumerate().map(|(g, (name, _))| (group_colour(g), name.clone())).collect();
        legend(&mut overview, Area::new(0.0, 0.0, 1584.0, 84.0), 1.0, &entries, "");
    }
    let Some((who, from)) = liveliest(record) else {
        return overview;
    };
    let looks = record.looks[from..].iter().step_by(STRIDE).take(COLUMNS * ROWS);
    let moments: Vec<WorldMoment> = looks.map(|(t, p)| WorldMoment::of(*t, Figure::from_positions(&p[who]))).collect();
    let strip = WorldStrip {
        title: &format!("Character {}", record.followed[who]),
        subtitle: "one moment every half a second; what stands before the person is left out",
        moments: &moments,
        units: &units,
        columns: COLUMNS,
        width_m: WIDTH_M,
        from: (FROM.0, 0.25),
    };
    sheet(&[&overview, &world_strip(&strip)])
}

/// Which recorded character to show, and from which look on: where the hips move up and down most.
fn liveliest(record: &WorldRecord) -> Option<(usize, usize)> {
    let span = STRIDE * COLUMNS * ROWS;
    let starts: Vec<usize> = (0..record.looks.len().saturating_sub(span).max(1)).step_by(STRIDE).collect();
    let range = |who: usize, from: usize| {
        let looks = record.looks[from..].iter().take(span);
        let heights = looks.map(|(_, p)| p[who][Joint::Hips.index()].y);
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        high - low
    };
    let all = (0..record.followed.len()).flat_map(|w| starts.iter().map(move |&s| (w, s)));
    let all = all.filter(|_| !record.looks.is_empty());
    all.max_by(|a, b| range(a.0, a.1).total_cmp(&range(b.0, b.1)))
}
