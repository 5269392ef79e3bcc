//! Three views of the same space at one scale: from the front, from above, from the side.

use eframe::egui::{Pos2, Rect, pos2, vec2};
use glam::{Vec2, Vec3};

/// Room for the numbers at the left of a view, below it, and for its title above it (points).
const LEFT: f32 = 34.0;
const BELOW: f32 = 17.0;
const ABOVE: f32 = 17.0;
/// Space between views (points).
const GAP: f32 = 8.0;

/// From where the hits are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitViewpoint {
    /// Face to face: the left side of the body is at the right.
    Front,
    /// From above: ahead is up, the left side is at the left, as on the map of values.
    Top,
    /// From its right side: ahead is at the right.
    Side,
}

/// Titles of the viewpoints in their order, and labels of the left and the right edge.
const WORDS: [(&str, [&str; 2]); 3] =
    [("Front", ["right", "left"]), ("Top", ["left", "right"]), ("Side", ["behind", "ahead"])];

impl HitViewpoint {
    /// All of them, from left to right.
    pub const ALL: [Self; 3] = [Self::Front, Self::Top, Self::Side];

    /// Title above the view.
    pub fn title(self) -> &'static str {
        WORDS[self as usize].0
    }

    /// Labels of its left and its right edge.
    pub fn ends(self) -> [&'static str; 2] {
        WORDS[self as usize].1
    }

    /// Projection of a place: to the right and up (m).
    pub fn flat(self, p: Vec3) -> Vec2 {
        match self {
            Self::Front => Vec2::new(p.x, p.y),
            Self::Top => Vec2::new(-p.x, p.z),
            Self::Side => Vec2::new(p.z, p.y),
        }
    }

    /// The coordinate of the body's frame that a place along the horizontal axis stands for (m).
    pub fn across(self, right: f32) -> f32 {
        // Adding 0 makes the place of the root +0, not -0.
        if self == Self::Top { 0.0 - right } else { right }
    }
}

/// A box around all that is to be seen, as seen from the planar root (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitBounds {
    /// Least left, up, ahead.
    pub low: Vec3,
    /// Greatest.
    pub high: Vec3,
}

impl HitBounds {
    /// Room for all places and for a standing body, or for as much of one as is near the places.
    pub fn around(places: impl Iterator<Item = Vec3> + Clone, whole_body: bool) -> Self {
        let lowest = places.clone().map(|p| p.y).fold(1.2, f32::min);
        let bottom = if whole_body { 0.0 } else { (lowest - 0.3).max(0.0) };
        let body = (Vec3::new(-0.4, bottom, -0.3), Vec3::new(0.4, 1.8, 0.5));
        let (mut low, mut high) = places.fold(body, |(l, h), p| (l.min(p), h.max(p)));
        let wide = low.x.abs().max(high.x);
        (low.x, high.x) = (-wide, wide);
        let margin = Vec3::splat(0.08);
        (low, high) = (low - margin, high + margin);
        Self { low: low.with_y(low.y.max(-0.08)), high }
    }
}

/// Placement of a view on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitViewPlace {
    /// Viewpoint.
    pub view: HitViewpoint,
    /// The part of the screen that shows places.
    pub rect: Rect,
    /// Points that a metre takes.
    pub per_m: f32,
    /// Screen position of the planar root, which may lie outside.
    origin: Pos2,
}

impl HitViewPlace {
    /// Lays the views side by side at the largest scale that fits all three.
    pub fn lay_out(bounds: HitBounds, rect: Rect) -> [Self; 3] {
        let corners = HitViewpoint::ALL.map(|v| {
            let (a, b) = (v.flat(bounds.low), v.flat(bounds.high));
            (a.min(b), a.max(b))
        });
        let width: f32 = corners.iter().map(|(low, high)| high.x - low.x).sum();
        let height = corners.iter().map(|(low, high)| high.y - low.y).fold(0.0, f32::max);
        let room = vec2(rect.width() - 3.0 * LEFT - 3.0 * GAP, rect.height() - ABOVE - BELOW);
        let per_m = (room.x / width).min(room.y / height).max(5.0);
        let mut x = rect.left() + 0.5 * (room.x - width * per_m).max(0.0);
        let bottom = rect.top() + ABOVE + 0.5 * (room.y + height * per_m).max(height * per_m);
        std::array::from_fn(|k| {
            let (view, (low, high)) = (HitViewpoint::ALL[k], corners[k]);
            let size = (high - low) * per_m;
            let rect = Rect::from_min_max(pos2(x + LEFT, bottom - size.y), pos2(x + LEFT + size.x, bottom));
            x += LEFT + size.x + GAP;
            Self { view, rect, per_m, origin: rect.left_bottom() + vec2(-low.x, low.y) * per_m }
        })
    }

    /// Screen position of a place.
    pub fn screen(&self, p: Vec3) -> Pos2 {
        self.screen_of(self.view.flat(p))
    }

    /// Screen position of a place in the plane that is seen (m).
    pub fn screen_of(&self, flat: Vec2) -> Pos2 {
        self.origin + vec2(flat.x, -flat.y) * self.per_m
    }

    /// Place in the plane that is seen (m).
    pub fn flat_at(&self, p: Pos2) -> Vec2 {
        let d = (p - self.origin) / self.per_m;
        Vec2::new(d.x, -d.y)
    }

    /// Distance of neighbouring ticks: the smallest of 0.1, 0.2, 0.5, 1, 2 m whose labels do not touch (m).
    pub fn tick_m(&self) -> f32 {
        [0.1, 0.2, 0.5, 1.0].into_iter().find(|t| t * self.per_m >= 30.0).unwrap_or(2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_seen_in_all_views_and_goes_back_to_itself() {
        let places = [Vec3::new(0.9, 1.6, 0.8), Vec3::new(-0.2, 2.1, 1.4), Vec3::new(0.0, 0.3, -0.6)];
        for whole_body in [true, false] {
            let bounds = HitBounds::around(places.into_iter(), whole_body);
            for rect in [
                Rect::from_min_size(pos2(10.0, 20.0), vec2(900.0, 260.0)),
                Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 500.0)),
            ] {
                let views = HitViewPlace::lay_out(bounds, rect);
                for view in views {
                    assert!(rect.contains_rect(view.rect), "{view:?}");
                    for p in places {
                        let at = view.screen(p);
                        assert!(view.rect.contains(at), "{view:?} {p}");
                        assert!((view.flat_at(at) - view.view.flat(p)).length() < 1e-4);
                    }
                }
                assert!(views.windows(2).all(|v| v[0].rect.right() < v[1].rect.left() && v[0].per_m == v[1].per_m));
            }
        }
    }

    #[test]
    fn sides_are_where_their_words_say() {
        let left = Vec3::X;
        assert!(HitViewpoint::Front.flat(left).x > 0.0 && HitViewpoint::Front.ends()[1] == "left");
        assert!(HitViewpoint::Top.flat(left).x < 0.0 && HitViewpoint::Top.ends()[0] == "left");
        assert!(HitViewpoint::Side.flat(Vec3::Z).x > 0.0 && HitViewpoint::Side.ends()[1] == "ahead");
        assert_eq!(HitViewpoint::Top.across(HitViewpoint::Top.flat(left).x), 1.0);
    }
}
