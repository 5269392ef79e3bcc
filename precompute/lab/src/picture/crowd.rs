//! A crowd from above: positions, trails and targets of characters.

use super::canvas::Area;
use super::discs::OBSTACLE_COLOUR;
use super::furniture::{grid, legend, nice_step, page_with_panel, scale_bar};
use super::shadow::Shadows;
use super::sprite::Sprite;
use super::{BodyColours, BodyFigure, Colour, Picture, PictureCamera, colour};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};
use throng_core::Planar;
use throng_geometry::Capsule2d;

/// Whether a character has reached its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArrivalState {
    /// Still walking, or has no target.
    OnTheWay,
    /// Still walking, in the opposite direction.
    OnTheWayBack,
    /// Within reach of its target now, or has been.
    Reached,
}

/// One character of a crowd.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrowdCharacter<'a> {
    /// Position and heading on the ground.
    pub root: Planar,
    /// Its body; without one, only a mark with the heading is drawn.
    pub figure: Option<BodyFigure>,
    /// Past positions of the root, oldest first, as (x, z) (m).
    pub trail: &'a [Vec2],
    /// Target, as (x, z) (m).
    pub target: Option<Vec2>,
    /// Arrival, which decides the colour.
    pub arrival: ArrivalState,
}

/// Input of [`crowd_overview`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrowdView<'a> {
    /// First line.
    pub title: &'a str,
    /// Second line.
    pub subtitle: &'a str,
    /// Width and height (px).
    pub size: (u32, u32),
    /// All characters.
    pub characters: &'a [CrowdCharacter<'a>],
    /// Walls.
    pub walls: &'a [Capsule2d],
    /// Radius around a target within which it is reached; drawn as a ring (m).
    pub reach_m: f32,
    /// Names of the colours: [`ArrivalState::Reached`], [`ArrivalState::OnTheWay`], [`ArrivalState::OnTheWayBack`]. The legend leaves empty
    /// ones out.
    pub names: [&'a str; 3],
    /// Remark below the legend.
    pub remark: &'a str,
    /// Index of a character that is ringed and named, for instance the one a strip shows.
    pub marked: Option<(usize, &'a str)>,
    /// Shows only this part of the ground; everything where `None`.
    pub focus: Option<Focus>,
}

/// A part of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// Centre, as (x, z) (m).
    pub centre: Vec2,
    /// Width; the height follows from the picture (m, 1 to 10000).
    pub width_m: f32,
}

/// Draws a crowd from obliquely above, in parallel projection: +X to the right, +Z towards the viewer.
///
/// The view fits all roots, targets and trails unless `focus` names a part. Characters whose root is not finite are
/// left out.
pub fn crowd_overview(view: &CrowdView<'_>) -> Picture {
    let (mut page, mut panel, at) = page_with_panel(view.size, view.title, view.subtitle);
    let unit = page.width() as f32 / 1600.0;
    let extent = Vec2::new(panel.width() as f32, panel.height() as f32);
    let camera = match view.focus.filter(|f| f.centre.is_finite()) {
        Some(focus) => focus_camera(focus, extent),
        None => fit_camera(&view.present().collect::<Vec<_>>(), extent, unit),
    };
    draw_ground(&mut panel, &camera, unit, view);
    draw_characters(&mut panel, &camera, unit, view.present().collect());
    if let Some((character, name)) = view.marked.and_then(|(i, name)| Some((view.characters.get(i)?, name))) {
        draw_mark(&mut panel, &camera, unit, character, name);
    }
    scale_bar(&mut panel, &camera, unit);
    page.draw_picture(&panel, at);
    draw_legend(&mut page, unit, view);
    page
}

impl CrowdView<'_> {
    /// Characters that can be drawn.
    fn present(&self) -> impl Iterator<Item = &CrowdCharacter<'_>> {
        self.characters.iter().filter(|c| is_finite(c.root))
    }
}

fn is_finite(p: Planar) -> bool {
    p.x.is_finite() && p.z.is_finite() && p.heading.is_finite()
}

/// World point of (x, z) on the ground.
fn ground_point(p: Vec2) -> Vec3 {
    Vec3::new(p.x, 0.0, p.y)
}

fn colour_of(arrival: ArrivalState) -> Colour {
    match arrival {
        ArrivalState::OnTheWay => colour::ON_THE_WAY,
        ArrivalState::OnTheWayBack => colour::RIGHT,
        ArrivalState::Reached => colour::REACHED,
    }
}

/// Camera that shows everything, tilted so that the crowd fills the panel as well as possible.
fn fit_camera(characters: &[&CrowdCharacter<'_>], size: Vec2, unit: f32) -> PictureCamera {
    let all =
        characters.iter().flat_map(|c| c.trail.iter().copied().chain(c.target).chain([Vec2::new(c.root.x, c.root.z)]));
    let all = all.filter(|p| p.is_finite() && p.abs().max_element() < 1e5);
    let (mut min, mut max) = all.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    if !min.is_finite() {
        (min, max) = (Vec2::splat(-3.0), Vec2::splat(3.0));
    }
    let margin = 0.8;
    let extent = (max - min + 2.0 * margin).max(Vec2::splat(4.0));
    let tilt = (size.y / size.x * extent.x / extent.y).clamp(0.6, 0.92).asin();
    let camera = PictureCamera::looking_along(PI, tilt);
    let body = 1.8 * tilt.cos();
    let room = size - Vec2::splat(8.0 * unit);
    let px_per_m = (room.x / extent.x).min(room.y / (extent.y * tilt.sin() + body)).clamp(0.01, 150.0 * unit);
    let centre = 0.5 * size + Vec2::new(0.0, 0.5 * body * px_per_m);
    camera.framed(ground_point(0.5 * (min + max)), centre, px_per_m)
}

/// Camera that shows a part of the ground.
fn focus_camera(focus: Focus, size: Vec2) -> PictureCamera {
    let px_per_m = size.x / focus.width_m.clamp(1.0, 10_000.0);
    let centre = 0.5 * size + Vec2::new(0.0, 0.6 * px_per_m);
    PictureCamera::looking_along(PI, 0.62).framed(ground_point(focus.centre), centre, px_per_m)
}

/// Draws grid, walls, trails, targets and the lines to them.
fn draw_ground(panel: &mut Picture, camera: &PictureCamera, unit: f32, view: &CrowdView<'_>) {
    grid(panel, camera, nice_step(panel.width() as f32 / camera.px_per_m / 16.0), unit);
    view.walls.iter().for_each(|wall| draw_wall(panel, camera, unit, wall));
    view.present().for_each(|c| draw_trail(panel, camera, unit, c.trail, colour_of(c.arrival)));
    let ring = camera.ground_disc(view.reach_m.clamp(0.0, 100.0));
    for c in view.present() {
        let Some(target) = c.target.filter(|t| t.is_finite()) else { continue };
        let (at, tint) = (camera.project(ground_point(target)), colour_of(c.arrival));
        let waits = c.arrival != ArrivalState::Reached;
        panel.stroke_oval(at, ring, 1.2 * unit, tint.alpha(if waits { 0.7 } else { 0.3 }));
        if !waits {
            continue;
        }
        panel.stroke_line(&[camera.project(c.root.translation()), at], 1.0 * unit, tint.alpha(0.3));
        let arm = 2.6 * unit;
        panel.stroke_line(&[at - Vec2::X * arm, at + Vec2::X * arm], 1.4 * unit, tint);
        panel.stroke_line(&[at - Vec2::Y * arm, at + Vec2::Y * arm], 1.4 * unit, tint);
    }
}

/// Draws the ground that a wall covers, at least two pixels wide.
fn draw_wall(panel: &mut Picture, camera: &PictureCamera, unit: f32, wall: &Capsule2d) {
    const ARC: u8 = 16;
    let radius_m = wall.radius_m.max(unit / camera.px_per_m);
    let ahead = (wall.to - wall.from).to_angle();
    let half = |end: Vec2, from: f32| {
        (0..=ARC).map(move |i| end + radius_m * Vec2::from_angle(from + PI * f32::from(i) / f32::from(ARC)))
    };
    let outline = half(wall.to, ahead - FRAC_PI_2).chain(half(wall.from, ahead + FRAC_PI_2));
    panel.fill_polygon(&outline.map(|p| camera.project(ground_point(p))).collect::<Vec<_>>(), OBSTACLE_COLOUR);
}

/// Draws a trail that fades with age, in four steps.
fn draw_trail(panel: &mut Picture, camera: &PictureCamera, unit: f32, trail: &[Vec2], tint: Colour) {
    let mut points: Vec<Vec2> = Vec::with_capacity(trail.len());
    for p in trail.iter().filter(|p| p.is_finite()) {
        let p = camera.project(ground_point(*p));
        if points.last().is_none_or(|q| q.distance(p) > 2.0 * unit) {
            points.push(p);
        }
    }
    let part = points.len().div_ceil(4).max(1);
    for k in 0..4 {
        let run = &points[(k * part).min(points.len())..((k + 1) * part + 1).min(points.len())];
        panel.stroke_line(run, 1.9 * unit, tint.alpha(0.12 + 0.16 * k as f32));
    }
}

/// Draws marks, shadows and bodies, far ones first.
fn draw_characters(panel: &mut Picture, camera: &PictureCamera, unit: f32, mut order: Vec<&CrowdCharacter<'_>>) {
    order.sort_by(|a, b| camera.depth(b.root.translation()).total_cmp(&camera.depth(a.root.translation())));
    let body_px = 1.75 * camera.px_per_m;
    let bodies = body_px > 10.0;
    if bodies && let Some(mut shadows) = Shadows::new(panel) {
        order.iter().filter_map(|c| c.figure.as_ref()).for_each(|f| shadows.add(f, camera));
        shadows.draw(panel, (0.012 * camera.px_per_m) as usize + 1, colour::INK.alpha(0.34));
    }
    let opacity = if bodies { 0.5 } else { 1.0 };
    order.iter().for_each(|c| draw_heading(panel, camera, c.root, colour_of(c.arrival), opacity));
    let size = (panel.width(), panel.height());
    let sprite = |c: &&CrowdCharacter<'_>| {
        let colours = BodyColours::plain(colour_of(c.arrival));
        c.figure.as_ref().filter(|_| bodies).and_then(|f| Sprite::new(f, &colours, camera, size))
    };
    let sprites: Vec<_> = order.par_iter().map(sprite).collect();
    for (sprite, c) in sprites.iter().zip(&order) {
        match sprite {
            Some(s) => s.draw(panel),
            None => panel.fill_disc(camera.project(c.root.translation()), 3.0 * unit, colour_of(c.arrival)),
        }
    }
}

/// Draws a heading as an arrowhead on the ground.
fn draw_heading(panel: &mut Picture, camera: &PictureCamera, root: Planar, tint: Colour, opacity: f32) {
    let at = |x: f32, z: f32| camera.project(ground_point(root.transform_point(Vec2::new(x, z))));
    let arrow = [at(0.0, 0.62), at(0.2, 0.3), at(0.0, 0.38), at(-0.2, 0.3)];
    panel.fill_polygon(&arrow, tint.alpha(opacity));
}

/// Draws a ring around one character, and its name above.
fn draw_mark(panel: &mut Picture, camera: &PictureCamera, unit: f32, character: &CrowdCharacter<'_>, name: &str) {
    if !is_finite(character.root) {
        return;
    }
    let foot = character.root.translation();
    let radii = camera.ground_disc(0.7).max(Vec2::splat(7.0 * unit));
    panel.stroke_oval(camera.project(foot), radii, 2.4 * unit, colour::MARK);
    let head = camera.project(foot + Vec3::Y * 2.0) - Vec2::new(0.0, 4.0 * unit);
    super::furniture::NamePlates::default().draw_plate(panel, head, unit, name, colour::MARK);
}

fn draw_legend(page: &mut Picture, unit: f32, view: &CrowdView<'_>) {
    let kinds = [ArrivalState::Reached, ArrivalState::OnTheWay, ArrivalState::OnTheWayBack];
    let entry = |(kind, name): (ArrivalState, &str)| {
        let count = view.characters.iter().filter(|c| c.arrival == kind).count();
        (colour_of(kind), format!("{name}: {count}"))
    };
    let named = kinds.into_iter().zip(view.names).filter(|(_, name)| !name.is_empty());
    let entries: Vec<(Colour, String)> = named.map(entry).collect();
    let area = Area::new(0.0, 0.0, page.width() as f32 - 16.0 * unit, 84.0 * unit);
    legend(page, area, unit, &entries, view.remark);
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Skeleton;

    fn standing(root: Planar) -> CrowdCharacter<'static> {
        let joints = Skeleton::default().rest_positions().map(|p| root.rotation() * p + root.translation());
        let figure = Some(BodyFigure::from_positions(&joints));
        CrowdCharacter { root, figure, trail: &[], target: None, arrival: ArrivalState::Reached }
    }

    fn view<'a>(characters: &'a [CrowdCharacter<'a>]) -> CrowdView<'a> {
        CrowdView {
            title: "t",
            subtitle: "s",
            size: (320, 200),
            characters,
            walls: &[],
            reach_m: 0.5,
            names: ["here", "there", ""],
            remark: "r",
            marked: Some((0, "A")),
            focus: None,
        }
    }

    #[test]
    fn all_characters_are_inside_the_view() {
        let at = |x: f32, z: f32| standing(Planar::new(x, z, 0.3));
        let characters = [at(-30.0, 4.0), at(12.0, -9.0), at(3.0, 25.0)];
        let size = Vec2::new(800.0, 500.0);
        let camera = fit_camera(&characters.iter().collect::<Vec<_>>(), size, 0.5);
        for p in characters.iter().flat_map(|c| c.figure.iter().flat_map(|f| f.joints)) {
            let s = camera.project(p);
            assert!(s.cmpge(Vec2::ZERO).all() && s.cmple(size).all(), "{p} is seen at {s}");
        }
    }

    #[test]
    fn same_input_same_bytes_at_any_thread_count() {
        let characters: Vec<_> =
            (0..60).map(|i| standing(Planar::new((i % 10) as f32, (i / 10) as f32, i as f32))).collect();
        let draw = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| crowd_overview(&view(&characters)).to_png().expect("encodes"))
        };
        assert_eq!(draw(1), draw(4));
    }

    #[test]
    fn colour_tells_which_characters_have_arrived() {
        let mut one = [standing(Planar::IDENTITY)];
        let reached = crowd_overview(&view(&one));
        one[0].arrival = ArrivalState::OnTheWay;
        assert_ne!(crowd_overview(&view(&one)), reached);
    }

    #[test]
    fn what_stands_in_the_way_is_drawn_on_the_ground() {
        let (post, fence) = (Vec2::new(2.0, 1.0), Vec2::new(-2.0, 1.0));
        let walls = [
            Capsule2d { from: post, to: post, radius_m: 0.5 },
            Capsule2d { from: fence, to: fence - Vec2::Y, radius_m: 0.1 },
            Capsule2d { from: Vec2::NAN, to: Vec2::INFINITY, radius_m: 1.0 },
        ];
        let one = [standing(Planar::IDENTITY)];
        let focus = Focus { centre: Vec2::ZERO, width_m: 8.0 };
        let seen = crowd_overview(&CrowdView {
            size: (1600, 1000),
            walls: &walls,
            marked: None,
            focus: Some(focus),
            ..view(&one)
        });
        let solid = |picture: &Picture, at: Vec2| {
            let panel = Vec2::new(1568.0, 900.0);
            let screen = focus_camera(focus, panel).project(ground_point(at)) + Vec2::new(16.0, 84.0);
            picture.pixel(screen.x as u32, screen.y as u32) == Some([0x8a, 0x85, 0x78, 0xff])
        };
        assert!(solid(&seen, post) && solid(&seen, post + 0.4 * Vec2::X) && solid(&seen, fence - 0.5 * Vec2::Y));
        assert!(!solid(&seen, post + 0.6 * Vec2::X) && !solid(&seen, fence + 0.3 * Vec2::Y));
    }

    #[test]
    fn empty_and_broken_crowds_are_drawn_without_a_panic() {
        crowd_overview(&view(&[]));
        let trail = [Vec2::NAN, Vec2::splat(1e30), Vec2::ZERO];
        let mut odd = standing(Planar::new(1e9, 0.0, 0.0));
        odd.trail = &trail;
        odd.target = Some(Vec2::INFINITY);
        crowd_overview(&view(&[odd, standing(Planar::new(f32::NAN, 0.0, 0.0))]));
    }
}
