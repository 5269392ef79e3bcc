//! Two axes of a parameter box on the screen.

use eframe::egui::{Pos2, Rect, pos2};
use std::ops::RangeInclusive;
use throng_core::blend::{AxisRecord, ExampleRecord, MAX_AXES, axis};
use throng_precompute::picture::step_up;

/// Distance within which a position on the map counts as an example (points).
const NEAR: f32 = 9.0;

/// Axes of a map: across, and upwards if there is more than one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapAxes {
    /// From left to right.
    pub across: usize,
    /// From below upwards.
    pub up: Option<usize>,
}

impl MapAxes {
    /// Turning rate across and speed upwards where the box has both, else its first two axes.
    pub fn default_for(axes: &[AxisRecord]) -> Self {
        let of = |kind: u32| axes.iter().position(|a| a.kind == kind);
        let up = of(axis::SPEED).unwrap_or(0);
        let other = |a: &usize| *a != up;
        let across = of(axis::GYRATION).or_else(|| of(axis::SIDE)).filter(other);
        match across.or_else(|| (0..axes.len()).find(other)) {
            Some(across) => Self { across, up: Some(up) },
            None => Self { across: up, up: None },
        }
    }

    /// These axes if they exist and differ; else those of [`MapAxes::default_for`].
    pub fn checked(self, axes: &[AxisRecord]) -> Self {
        let is_there = |a: usize| a < axes.len();
        let good = match self.up {
            Some(up) => is_there(up) && is_there(self.across) && up != self.across,
            None => axes.len() == 1 && self.across == 0,
        };
        if good { self } else { Self::default_for(axes) }
    }

    /// Shows another axis across; swaps the two axes if it was the one upwards.
    pub fn with_across(self, axis: usize) -> Self {
        Self { across: axis, up: self.up.map(|up| if up == axis { self.across } else { up }) }
    }

    /// Shows another axis upwards; swaps the two axes if it was the one across.
    pub fn with_up(self, axis: usize) -> Self {
        Self { across: if self.across == axis { self.up.unwrap_or(axis) } else { self.across }, up: Some(axis) }
    }
}

/// Maps points of a parameter box to the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapPlane {
    /// The axes.
    pub shown: MapAxes,
    /// Low and high of the axis across.
    across: [f32; 2],
    /// Low and high of the axis upwards.
    up: [f32; 2],
    /// Part of the screen.
    pub rect: Rect,
    /// The axis across is mirrored: left is at the left, as in every view from above.
    pub turned: bool,
}

impl MapPlane {
    /// The map of two axes within a part of the screen (the axes that are shown are there).
    pub fn new(axes: &[AxisRecord], shown: MapAxes, rect: Rect) -> Self {
        let bounds = |a: usize| [axes[a].low, axes[a].high];
        let turned = [axis::GYRATION, axis::SIDE].contains(&axes[shown.across].kind);
        Self { shown, across: bounds(shown.across), up: shown.up.map_or([0.0, 1.0], bounds), rect, turned }
    }

    /// Screen position of a point.
    pub fn screen(&self, point: &[f32; MAX_AXES]) -> Pos2 {
        let up = self.shown.up.map_or(0.5, |a| ratio(point[a], self.up));
        self.position_at(ratio(point[self.shown.across], self.across), up)
    }

    /// Screen position of ratios from low to high.
    pub fn position_at(&self, across: f32, up: f32) -> Pos2 {
        let across = if self.turned { 1.0 - across } else { across };
        pos2(self.rect.left() + across * self.rect.width(), self.rect.bottom() - up * self.rect.height())
    }

    /// A point moved to a screen position, within the box; coordinates on hidden axes stay unchanged.
    pub fn moved(&self, point: &[f32; MAX_AXES], to: Pos2) -> [f32; MAX_AXES] {
        let across = ((to.x - self.rect.left()) / self.rect.width()).clamp(0.0, 1.0);
        let across = if self.turned { 1.0 - across } else { across };
        let up = ((self.rect.bottom() - to.y) / self.rect.height()).clamp(0.0, 1.0);
        self.point_with(point, across, up)
    }

    /// A point moved by parts of the map to the right and upwards, within the box.
    pub fn stepped(&self, point: &[f32; MAX_AXES], right: f32, up: f32) -> [f32; MAX_AXES] {
        let right = if self.turned { -right } else { right };
        let across = (ratio(point[self.shown.across], self.across) + right).clamp(0.0, 1.0);
        let upwards = self.shown.up.map_or(0.5, |a| (ratio(point[a], self.up) + up).clamp(0.0, 1.0));
        self.point_with(point, across, upwards)
    }

    /// A point with other values on the shown axes, as ratios from low to high.
    pub fn point_with(&self, point: &[f32; MAX_AXES], across: f32, up: f32) -> [f32; MAX_AXES] {
        let mut out = *point;
        out[self.shown.across] = value(across, self.across);
        if let Some(a) = self.shown.up {
            out[a] = value(up, self.up);
        }
        out
    }

    /// Distance of an example from a point along the hidden axes: 0 for no distance, 1 for the length of the box.
    pub fn depth(&self, axes: &[AxisRecord], example: &ExampleRecord, point: &[f32; MAX_AXES]) -> f32 {
        let hidden = (0..axes.len()).filter(|&a| a != self.shown.across && Some(a) != self.shown.up);
        let apart = |a: usize| (example.parameters[a] - point[a]).abs() / (axes[a].high - axes[a].low).max(1e-6);
        hidden.map(apart).fold(0.0, f32::max).min(1.0)
    }

    /// The example at a screen position; among overlapping ones the one with the least depth.
    pub fn pointed_at(
        &self,
        axes: &[AxisRecord],
        examples: &[ExampleRecord],
        point: &[f32; MAX_AXES],
        at: Pos2,
    ) -> Option<usize> {
        let far = |e: &ExampleRecord| self.screen(&e.parameters).distance(at);
        let near = examples.iter().enumerate().filter(|(_, e)| far(e) < NEAR);
        let order = |e: &ExampleRecord| self.depth(axes, e, point) + far(e) / NEAR * 0.1;
        near.min_by(|a, b| order(a.1).total_cmp(&order(b.1))).map(|(i, _)| i)
    }

    /// Round values across, with their screen positions.
    pub fn ticks_across(&self) -> impl Iterator<Item = (f32, Pos2)> {
        ticks(self.across, (self.rect.width() / 60.0) as usize)
            .map(|v| (v, self.position_at(ratio(v, self.across), 0.0)))
    }

    /// Round values upwards, with their screen positions; none if one axis alone is shown.
    pub fn ticks_up(&self) -> impl Iterator<Item = (f32, Pos2)> {
        let most = self.shown.up.map_or(0, |_| (self.rect.height() / 32.0) as usize);
        ticks(self.up, most).map(|v| (v, self.position_at(if self.turned { 1.0 } else { 0.0 }, ratio(v, self.up))))
    }
}

fn ratio(v: f32, [low, high]: [f32; 2]) -> f32 {
    (v - low) / (high - low).max(1e-9)
}

fn value(ratio: f32, [low, high]: [f32; 2]) -> f32 {
    (low + ratio * (high - low)).clamp(low, high)
}

/// Multiples of 1, 2 or 5 times a power of ten within a range, about `most` of them.
fn ticks([low, high]: [f32; 2], most: usize) -> impl Iterator<Item = f32> {
    let least = (high - low) / most.max(1) as f32;
    let step = step_up(f64::from(least)) as f32;
    let steps: RangeInclusive<i32> = (low / step - 1e-3).ceil() as i32..=(high / step + 1e-3).floor() as i32;
    steps.filter(move |_| most > 0).map(move |i| i as f32 * step)
}

/// Unit of the numbers of an axis.
pub fn unit(kind: u32) -> &'static str {
    match kind {
        axis::SPEED | axis::SIDE => " m/s",
        axis::GYRATION => " rad/s",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::vec2;

    fn record(kind: u32, low: f32, high: f32) -> AxisRecord {
        AxisRecord { kind, num_knots: 2, low, high }
    }

    fn axes() -> [AxisRecord; 3] {
        [record(axis::STYLE, 0.0, 2.0), record(axis::SPEED, -1.0, 3.0), record(axis::GYRATION, -1.5, 1.5)]
    }

    fn plane() -> MapPlane {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(300.0, 200.0));
        MapPlane::new(&axes(), MapAxes::default_for(&axes()), rect)
    }

    fn point(values: [f32; 3]) -> [f32; MAX_AXES] {
        std::array::from_fn(|a| values.get(a).copied().unwrap_or(0.0))
    }

    #[test]
    fn turning_rate_and_speed_are_shown_where_there_are_both() {
        assert_eq!(MapAxes::default_for(&axes()), MapAxes { across: 2, up: Some(1) });
        assert_eq!(MapAxes::default_for(&axes()[..2]), MapAxes { across: 0, up: Some(1) });
        assert_eq!(MapAxes::default_for(&axes()[2..]), MapAxes { across: 0, up: None });
        let shown = MapAxes::default_for(&axes());
        assert_eq!(shown.with_across(1), MapAxes { across: 1, up: Some(2) });
        assert_eq!(shown.with_up(0), MapAxes { across: 2, up: Some(0) });
        assert_eq!(shown.checked(&axes()[..2]), MapAxes { across: 0, up: Some(1) });
        assert_eq!(MapAxes { across: 0, up: Some(2) }.checked(&axes()), MapAxes { across: 0, up: Some(2) });
    }

    #[test]
    fn a_point_goes_to_the_screen_and_back_and_left_is_at_the_left() {
        let (plane, p) = (plane(), point([1.2, 0.7, -0.9]));
        let back = plane.moved(&point([1.2, 9.0, 9.0]), plane.screen(&p));
        assert!((0..3).all(|a| (back[a] - p[a]).abs() < 1e-4), "{back:?}");
        assert!(plane.screen(&point([0.0, 0.0, 1.0])).x < plane.screen(&point([0.0, 0.0, -1.0])).x);
        assert!(plane.screen(&point([0.0, 2.0, 0.0])).y < plane.screen(&point([0.0, 1.0, 0.0])).y);
    }

    #[test]
    fn a_point_stays_in_the_box_however_far_it_is_dragged_or_stepped() {
        let (plane, p) = (plane(), point([1.2, 0.7, -0.9]));
        assert_eq!(plane.moved(&p, pos2(-1e6, -1e6))[..3], [1.2, 3.0, 1.5]);
        assert_eq!(plane.moved(&p, pos2(1e6, 1e6))[..3], [1.2, -1.0, -1.5]);
        let stepped = plane.stepped(&p, 0.1, 0.25);
        assert!((stepped[1] - 1.7).abs() < 1e-5 && (stepped[2] + 1.2).abs() < 1e-5, "{stepped:?}");
        assert_eq!(plane.stepped(&p, -9.0, 9.0)[..3], [1.2, 3.0, 1.5]);
    }

    #[test]
    fn pointing_picks_the_example_at_the_depth_of_the_point() {
        let example = |values| ExampleRecord { parameters: point(values), ..bytemuck::Zeroable::zeroed() };
        let all = [example([0.0, 1.0, 0.0]), example([2.0, 1.0, 0.0]), example([2.0, 2.0, 0.0])];
        let (plane, at) = (plane(), plane().screen(&all[0].parameters) + vec2(2.0, 1.0));
        let found = |style| plane.pointed_at(&axes(), &all, &point([style, 0.0, 0.0]), at);
        assert_eq!([found(0.3), found(1.9)], [Some(0), Some(1)]);
        assert_eq!(plane.pointed_at(&axes(), &all, &point([0.0; 3]), pos2(20.0, 30.0)), None);
        assert_eq!(plane.depth(&axes(), &all[1], &point([0.5, 0.0, 0.0])), 0.75);
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(ticks([-1.5, 1.5], 4).collect::<Vec<_>>(), [-1.0, 0.0, 1.0]);
        assert_eq!(ticks([0.0, 2.0], 4).collect::<Vec<_>>(), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(ticks([0.0, 2.0], 0).count(), 0);
    }
}
