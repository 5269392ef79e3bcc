//! Effective hitting points from the front, from above and from the side, around a body (Lee and Lee 2004, figure 4).

mod panel;

use super::furniture::{header, legend};
use super::{BodyFigure, Colour, Picture, PictureCamera, canvas::Area, colour};
use glam::{Vec2, Vec3};
use panel::{HitPanel, PanelAxis};
use std::f32::consts::{FRAC_PI_2, PI};
use throng_core::Joint;
use throng_motion::annotate::hits::{HitPoint, HitReport};

/// Input of [`hit_views`].
#[derive(Clone, Copy, Debug)]
pub struct HitView<'a> {
    /// First line.
    pub title: &'a str,
    /// The points.
    pub points: &'a [HitPoint],
    /// A body for scale, its planar root at the origin, facing +Z.
    pub body: Option<&'a BodyFigure>,
    /// Width of the picture; the height follows (px).
    pub width: u32,
}

/// Draws hitting points as seen from the planar root: from the front, from above, and from the character's right.
///
/// A point's colour shows the side of its joint, its size the force, its tail the direction of the blow. Kicks are rings;
/// kinds named by tags have a colour of their own.
pub fn hit_views(view: &HitView<'_>) -> Picture {
    let unit = view.width.clamp(200, 8000) as f32 / 1600.0;
    let (size, panels) = page_layout(view, unit);
    let mut page = Picture::new(size.x as u32, size.y as u32, colour::PAPER);
    header(&mut page, unit, view.title, &HitReport::new(view.points).to_string());
    let area = Area::new(0.0, 0.0, size.x - 20.0 * unit, size.y);
    legend(&mut page, area, unit, &legend_entries(view.points), "larger: more forceful; tails: where blows come from");
    panels.iter().for_each(|panel| panel.draw(&mut page, view.points, view.body, unit));
    page
}

/// Colour of a hit: by side, and another one for kinds that only tags name.
fn hit_colour(hit: &HitPoint) -> Colour {
    match hit.joint {
        _ if !["punch", "kick"].contains(&hit.kind.as_str()) => colour::MARK,
        j if j.name().starts_with("left") => colour::LEFT,
        j if j.name().starts_with("right") => colour::RIGHT,
        _ => colour::BODY,
    }
}

/// Entries of the legend: every joint with its number of hits, tags by their names.
fn legend_entries(points: &[HitPoint]) -> Vec<(Colour, String)> {
    let mut out: Vec<(Colour, String, usize)> = Vec::new();
    let tagged = |h: &HitPoint| hit_colour(h) == colour::MARK;
    let name = |h: &HitPoint| if tagged(h) { h.kind.clone() } else { h.joint.name().replace('_', " ") };
    let mut sorted: Vec<&HitPoint> = points.iter().collect();
    sorted.sort_by_key(|h| (tagged(h), h.joint != Joint::LeftHand && h.joint != Joint::RightHand, name(h)));
    for h in sorted {
        match out.last_mut() {
            Some(last) if last.1 == name(h) => last.2 += 1,
            _ => out.push((hit_colour(h), name(h), 1)),
        }
    }
    out.into_iter().map(|(tint, name, n)| (tint, format!("{name} {n}"))).collect()
}

/// Size of the page, and its panels (px).
fn page_layout(view: &HitView<'_>, unit: f32) -> (Vec2, [HitPanel; 3]) {
    let (edge, gap, top, label) = (20.0 * unit, 24.0 * unit, 112.0 * unit, 56.0 * unit);
    let (min, max) = bounds(view);
    let span = max - min;
    let room = 1600.0 * unit - 2.0 * edge - 2.0 * gap - 3.0 * label;
    let px_per_m = room / (2.0 * span.x + span.z);
    let axes = [("left", Vec3::X), ("ahead", Vec3::Z), ("height", Vec3::Y)];
    let [left, ahead, up] = axes.map(|(name, direction)| PanelAxis { name, direction });
    let height = px_per_m * span.y.max(span.z);
    let mut x = edge;
    let mut panel = |title, camera: PictureCamera, across: PanelAxis, upwards: PanelAxis| {
        let size = px_per_m * Vec2::new(span.dot(across.direction), span.dot(upwards.direction));
        let area = Area::new(x + label, top + 0.5 * (height - size.y), size.x, size.y);
        x += label + size.x + gap;
        let camera = camera.framed(0.5 * (min + max), 0.5 * area.size, px_per_m);
        HitPanel { title, area, camera, across, upwards, min, max }
    };
    let panels = [
        panel("front", PictureCamera::looking_along(PI, 0.0), left, up),
        panel("top", PictureCamera::looking_along(0.0, FRAC_PI_2), left, ahead),
        panel("side", PictureCamera::looking_along(FRAC_PI_2, 0.0), ahead, up),
    ];
    (Vec2::new(1600.0 * unit, top + height + 62.0 * unit), panels)
}

/// Corners of the shown space: all points and the body, extended equally to the left and right (m).
fn bounds(view: &HitView<'_>) -> (Vec3, Vec3) {
    let (mut min, mut max) = (Vec3::new(-0.7, 0.0, -0.5), Vec3::new(0.7, 1.85, 0.9));
    let body = view.body.filter(|b| b.is_drawable()).into_iter().flat_map(|b| b.joints);
    for p in view.points.iter().map(|h| h.position).chain(body).filter(|p| p.is_finite() && p.length() < 10.0) {
        (min, max) = (min.min(p - 0.12), max.max(p + 0.12));
    }
    let wide = max.x.max(-min.x);
    (Vec3::new(-wide, min.y.min(0.0), min.z), Vec3::new(wide, max.y, max.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Skeleton;

    fn point(kind: &str, joint: Joint, position: Vec3) -> HitPoint {
        HitPoint {
            clip: "a".into(),
            frame: 0,
            time_s: 0.0,
            kind: kind.into(),
            joint,
            position,
            direction: Vec3::Z,
            speed_mps: 5.0,
            force: 1.0,
        }
    }

    fn view<'a>(points: &'a [HitPoint], body: Option<&'a BodyFigure>) -> HitView<'a> {
        HitView { title: "t", points, body, width: 800 }
    }

    /// True where the picture has about that colour within two pixels.
    fn has(picture: &Picture, at: Vec2, tint: Colour) -> bool {
        let near = |c: [u8; 4], t: [f32; 3]| (0..3).all(|i| (f32::from(c[i]) - 255.0 * t[i]).abs() < 40.0);
        (0..25).any(|i| {
            let (x, y) = (at.x as i32 + i % 5 - 2, at.y as i32 + i / 5 - 2);
            picture.pixel(x as u32, y as u32).is_some_and(|c| near(c, [tint.r, tint.g, tint.b]))
        })
    }

    #[test]
    fn a_point_is_where_it_belongs_in_every_view() {
        let points = [point("punch", Joint::LeftHand, Vec3::new(0.4, 1.4, 0.8))];
        let view = view(&points, None);
        let (picture, (_, panels)) = (hit_views(&view), page_layout(&view, 0.5));
        let seen = panels.each_ref().map(|p| p.area.min + p.camera.project(points[0].position));
        for (at, panel) in seen.iter().zip(&panels) {
            assert!(has(&picture, *at, colour::LEFT), "{}", panel.title);
        }
        let middle = panels.each_ref().map(|p| p.area.min + p.camera.project(Vec3::Y * 0.9));
        assert!(seen[0].x > middle[0].x, "from the front the left is on the right");
        assert!(seen[1].x < middle[1].x && seen[1].y < middle[1].y, "from above the left is on the left, ahead is up");
        assert!(seen[2].x > middle[2].x, "from the right, ahead is on the right");
    }

    #[test]
    fn kinds_and_sides_have_entries_of_their_own() {
        let points = [
            point("kick", Joint::RightFoot, Vec3::Z),
            point("punch", Joint::RightHand, Vec3::Z),
            point("butt", Joint::Head, Vec3::Z),
            point("punch", Joint::RightHand, Vec3::Z),
        ];
        let entries: Vec<String> = legend_entries(&points).into_iter().map(|e| e.1).collect();
        assert_eq!(entries, ["right hand 2", "right foot 1", "butt 1"]);
    }

    #[test]
    fn no_points_and_broken_ones_are_drawn_without_a_panic() {
        let body = BodyFigure::from_positions(&Skeleton::default().rest_positions());
        let broken = [point("punch", Joint::LeftHand, Vec3::NAN), point("kick", Joint::LeftFoot, Vec3::splat(1e9))];
        let none = hit_views(&view(&[], Some(&body)));
        assert_eq!(none, hit_views(&view(&[], Some(&body))));
        assert_eq!(hit_views(&view(&broken, Some(&body))).width(), none.width());
    }
}
