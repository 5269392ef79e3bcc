//! One view of the hitting points: grid, body, points, axes in metres.

use super::super::canvas::Area;
use super::super::paint::draw_pieces;
use super::super::text::{Align, TextStyle, draw_text};
use super::super::world::figure_pieces;
use super::{HitPoint, hit_colour};
use crate::picture::{BodyColours, BodyFigure, Picture, PictureCamera, WorldFigure, colour};
use glam::{Vec2, Vec3};

/// Distance between grid lines (m).
const STEP: f32 = 0.25;
/// Radii of the least and the most forceful hit (px of a picture 1600 px wide).
const RADII: [f32; 2] = [3.5, 8.5];
/// Number of points above which they are drawn smaller, so that they do not hide each other and the body.
const MANY_POINTS: usize = 150;
/// Length of the tail of the most forceful hit (m).
const TAIL: f32 = 0.12;

/// A direction of the character that a panel shows along one of its edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct PanelAxis {
    pub name: &'static str,
    /// Unit.
    pub direction: Vec3,
}

/// One view.
#[derive(Clone, Copy, Debug)]
pub(super) struct HitPanel {
    /// Name of the view.
    pub title: &'static str,
    /// Position and size on the page.
    pub area: Area,
    /// Camera of the panel's own picture.
    pub camera: PictureCamera,
    /// Axis along the lower edge.
    pub across: PanelAxis,
    /// Axis along the left edge.
    pub upwards: PanelAxis,
    /// Corner of the shown space (m).
    pub min: Vec3,
    /// The opposite corner (m).
    pub max: Vec3,
}

impl HitPanel {
    /// Draws the view onto the page.
    pub fn draw(&self, page: &mut Picture, points: &[HitPoint], body: Option<&BodyFigure>, unit: f32) {
        let mut panel = Picture::new(self.area.size.x as u32, self.area.size.y as u32, colour::GROUND);
        self.grid(&mut panel, unit);
        let colours = BodyColours::plain(colour::BODY).faded(colour::GROUND, 0.5);
        let body = body.map(|figure| WorldFigure { figure: *figure, colours });
        draw_pieces(&mut panel, &self.camera, &body.iter().flat_map(figure_pieces).collect::<Vec<_>>());
        // Far points first.
        let mut order: Vec<&HitPoint> = points.iter().collect();
        order.sort_by(|a, b| self.camera.depth(b.position).total_cmp(&self.camera.depth(a.position)));
        let scale = (MANY_POINTS as f32 / points.len().max(1) as f32).sqrt().clamp(0.4, 1.0);
        order.into_iter().for_each(|h| self.draw_point(&mut panel, h, scale * unit));
        page.draw_picture(&panel, (self.area.min.x as i32, self.area.min.y as i32));
        self.labels(page, unit);
    }

    fn draw_point(&self, panel: &mut Picture, hit: &HitPoint, unit: f32) {
        let at = self.camera.project(hit.position);
        let radius = unit * (RADII[0] + (RADII[1] - RADII[0]) * hit.force.clamp(0.0, 1.0));
        let tail = self.camera.project(hit.position - hit.direction * TAIL * hit.force);
        panel.stroke_line(&[tail, at], 1.6 * unit, hit_colour(hit).alpha(0.55));
        if hit.kind == "kick" {
            panel.stroke_oval(at, Vec2::splat(radius), 2.6 * unit, hit_colour(hit));
        } else {
            panel.fill_disc(at, radius, colour::GROUND.alpha(0.7));
            panel.fill_disc(at, radius - unit, hit_colour(hit).alpha(0.85));
        }
    }

    /// Multiples of the grid's step between the panel's edges, along one of its axes (m).
    fn ticks(&self, axis: PanelAxis) -> impl Iterator<Item = (i32, f32)> {
        let (low, high) = (self.min.dot(axis.direction), self.max.dot(axis.direction));
        ((low / STEP).ceil() as i32..=(high / STEP).floor() as i32).map(|i| (i, i as f32 * STEP))
    }

    fn grid(&self, panel: &mut Picture, unit: f32) {
        let middle = 0.5 * (self.min + self.max);
        for (along, other) in [(self.across, self.upwards), (self.upwards, self.across)] {
            let half = 0.5 * (self.max - self.min).dot(other.direction) * other.direction;
            let base = middle - middle.dot(along.direction) * along.direction;
            for (i, value) in self.ticks(along) {
                let at = base + value * along.direction;
                let (width, ink) = match i {
                    0 => (1.8, colour::INK_SOFT.alpha(0.8)),
                    i if i % 2 == 0 => (1.2, colour::GRID),
                    _ => (0.9, colour::GRID.alpha(0.5)),
                };
                panel.stroke_line(&[at - half, at + half].map(|p| self.camera.project(p)), width * unit, ink);
            }
        }
    }

    /// Draws numbers along the edges, names of the axes, and the title.
    fn labels(&self, page: &mut Picture, unit: f32) {
        let (min, max) = (self.area.min, self.area.max());
        let style = TextStyle { size: 17.0 * unit, colour: colour::INK_SOFT, align: Align::Centre, bold: false };
        let at = |value: f32, axis: PanelAxis| min + self.camera.project(value * axis.direction);
        for (_, value) in self.ticks(self.across).filter(|t| t.0 % 2 == 0) {
            let place = Vec2::new(at(value, self.across).x, max.y + 20.0 * unit);
            draw_text(page, place, &format!("{value:.1}"), style);
        }
        let right = TextStyle { align: Align::Right, ..style };
        for (_, value) in self.ticks(self.upwards).filter(|t| t.0 % 2 == 0) {
            let place = Vec2::new(min.x - 7.0 * unit, at(value, self.upwards).y + 6.0 * unit);
            draw_text(page, place, &format!("{value:.1}"), right);
        }
        let place = Vec2::new(0.5 * (min.x + max.x), max.y + 42.0 * unit);
        draw_text(page, place, &format!("{} [m]", self.across.name), style);
        let strong = TextStyle { size: 21.0 * unit, colour: colour::INK, align: Align::Left, bold: true };
        draw_text(page, min + Vec2::new(10.0, 26.0) * unit, self.title, strong);
        let place = min - Vec2::new(44.0, 10.0) * unit;
        draw_text(page, place, &format!("{} [m]", self.upwards.name), TextStyle { align: Align::Left, ..style });
    }
}
