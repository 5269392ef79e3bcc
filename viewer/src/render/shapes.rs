//! A list of simple shapes in the world, refilled every frame: trails, axes, markers, arrows.

use super::Rgba;
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Instance of a line: a strip of constant width in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct LineInstance {
    pub a: [f32; 3],
    pub width_px: f32,
    pub b: [f32; 3],
    pub on_top: u32,
    pub colour: Rgba,
}

/// Instance of a round cone: the hull of two spheres.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct RoundInstance {
    pub a: [f32; 3],
    pub radius_a: f32,
    pub b: [f32; 3],
    pub radius_b: f32,
    pub on_top: u32,
    pub colour: Rgba,
}

/// Instance of a horizontal ring; a filled square where `inner` is negative.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct RingInstance {
    pub centre: [f32; 3],
    pub inner: f32,
    pub outer: f32,
    pub on_top: u32,
    pub colour: Rgba,
}

/// Shapes to draw, in world space.
///
/// Shapes added after [`ShapeList::on_top`]`(true)` are drawn over everything else, among themselves by depth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeList {
    pub(super) lines: Vec<LineInstance>,
    pub(super) rounds: Vec<RoundInstance>,
    pub(super) rings: Vec<RingInstance>,
    on_top: u32,
}

impl ShapeList {
    /// Removes all shapes and keeps their memory.
    pub fn clear(&mut self) {
        self.lines.clear();
        self.rounds.clear();
        self.rings.clear();
        self.on_top = 0;
    }

    /// Number of instances to draw.
    pub fn len(&self) -> usize {
        self.lines.len() + self.rounds.len() + self.rings.len()
    }

    /// True if there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the shapes added from now on are drawn over everything else.
    pub fn on_top(&mut self, on_top: bool) -> &mut Self {
        self.on_top = u32::from(on_top);
        self
    }

    /// A straight line of constant width on the screen (m, pixels).
    pub fn line(&mut self, a: Vec3, b: Vec3, width_px: f32, colour: Rgba) {
        let (a, b) = (a.to_array(), b.to_array());
        self.lines.push(LineInstance { a, width_px, b, on_top: self.on_top, colour });
    }

    /// Straight lines from point to point (m, pixels).
    pub fn polyline(&mut self, points: &[Vec3], width_px: f32, colour: Rgba) {
        points.windows(2).for_each(|w| self.line(w[0], w[1], width_px, colour));
    }

    /// A circle on a horizontal plane, as a line (m, pixels).
    pub fn circle(&mut self, centre: Vec3, radius: f32, width_px: f32, colour: Rgba) {
        const CORNERS: usize = 48;
        let at = |i: usize| {
            let (s, c) = (TAU * i as f32 / CORNERS as f32).sin_cos();
            centre + Vec3::new(s, 0.0, c) * radius
        };
        (0..CORNERS).for_each(|i| self.line(at(i), at(i + 1), width_px, colour));
    }

    /// A capsule (m).
    pub fn capsule(&mut self, a: Vec3, b: Vec3, radius: f32, colour: Rgba) {
        self.round_cone(a, radius, b, radius, colour);
    }

    /// The hull of two spheres of different radii (m).
    pub fn round_cone(&mut self, a: Vec3, radius_a: f32, b: Vec3, radius_b: f32, colour: Rgba) {
        let (a, b) = (a.to_array(), b.to_array());
        self.rounds.push(RoundInstance { a, radius_a, b, radius_b, on_top: self.on_top, colour });
    }

    /// A sphere (m).
    pub fn sphere(&mut self, centre: Vec3, radius: f32, colour: Rgba) {
        self.round_cone(centre, radius, centre, radius, colour);
    }

    /// A filled horizontal circle (m).
    pub fn disc(&mut self, centre: Vec3, radius: f32, colour: Rgba) {
        self.ring(centre, 0.0, radius, colour);
    }

    /// A horizontal band between two circles (m).
    pub fn ring(&mut self, centre: Vec3, inner: f32, outer: f32, colour: Rgba) {
        self.rings.push(RingInstance { centre: centre.to_array(), inner, outer, on_top: self.on_top, colour });
    }

    /// A filled horizontal square along the axes, of half a side (m).
    pub fn square(&mut self, centre: Vec3, half: f32, colour: Rgba) {
        self.ring(centre, -1.0, half, colour);
    }

    /// A solid arrow with its tip at `b` (m).
    pub fn arrow(&mut self, a: Vec3, b: Vec3, radius: f32, colour: Rgba) {
        let length = a.distance(b);
        if length < 1e-6 {
            return;
        }
        let head = (radius * 6.0).min(0.6 * length);
        let neck = b + (a - b) * (head / length);
        self.capsule(a, neck, radius, colour);
        self.round_cone(neck, radius * 2.6, b, radius * 0.25, colour);
    }

    /// The axes of a frame: X red, Y green, Z blue (m, pixels).
    pub fn axes(&mut self, origin: Vec3, rotation: Quat, size: f32, width_px: f32) {
        let axes = [(Vec3::X, Rgba::hex(0xd9483b)), (Vec3::Y, Rgba::hex(0x3fa34d)), (Vec3::Z, Rgba::hex(0x3b78d9))];
        for (axis, colour) in axes {
            self.line(origin, origin + rotation * (axis * size), width_px, colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_keep_what_they_were_given() {
        let mut shapes = ShapeList::default();
        shapes.polyline(&[Vec3::ZERO, Vec3::X, Vec3::Y], 2.0, Rgba::WHITE);
        shapes.on_top(true).axes(Vec3::ONE, Quat::IDENTITY, 0.5, 1.0);
        shapes.arrow(Vec3::ZERO, Vec3::Z, 0.02, Rgba::WHITE);
        shapes.arrow(Vec3::ZERO, Vec3::ZERO, 0.02, Rgba::WHITE);
        assert_eq!((shapes.lines.len(), shapes.rounds.len()), (5, 2));
        assert_eq!(shapes.lines.iter().map(|l| l.on_top).collect::<Vec<_>>(), [0, 0, 1, 1, 1]);
        assert_eq!(shapes.rounds[1].b, [0.0, 0.0, 1.0]);
        shapes.clear();
        assert!(shapes.is_empty());
        shapes.sphere(Vec3::ZERO, 1.0, Rgba::WHITE);
        assert_eq!(shapes.rounds[0].on_top, 0);
    }
}
