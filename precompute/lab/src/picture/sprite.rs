//! One figure, shaded and anti-aliased: rays against solids, nearest first, several rays a pixel.

use super::camera::Camera;
use super::canvas::{Picture, source_over};
use super::colour::{self, Colour};
use super::figure::{BodyColours, Figure, body};
use super::solid::Solid;
use glam::{Vec2, Vec3};
use tiny_skia::PremultipliedColorU8;

/// Rays along each side of a pixel.
const RAYS: usize = 3;
/// A step in depth from which a contour is drawn (m).
const CONTOUR_STEP: f32 = 0.07;
/// Largest sprite side; a figure that is larger on the screen is not drawn (px).
const MAX_SIDE: f32 = 4096.0;

/// A drawn figure, ready to be laid on a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sprite {
    corner: (i32, i32),
    size: (usize, usize),
    /// (width * height)
    pixels: Vec<PremultipliedColorU8>,
}

/// Direction towards the light that shades figures and throws their shadows: from above, the left and the viewer.
pub(super) fn light(camera: &Camera) -> Vec3 {
    (Vec3::Y * 1.0 - camera.right * 0.34 - camera.forward.with_y(0.0).normalize_or_zero() * 0.42).normalize()
}

/// Draws a figure. `None` where it cannot be drawn or lies outside of the picture's `size`.
pub(super) fn render(figure: &Figure, colours: &BodyColours, camera: &Camera, size: (u32, u32)) -> Option<Sprite> {
    if !figure.is_drawable() {
        return None;
    }
    let solids = body(figure, colours);
    let boxes: Vec<(Vec2, Vec2)> = solids.iter().map(|(s, _)| screen_box(s, camera)).collect();
    let min = boxes.iter().fold(Vec2::INFINITY, |m, b| m.min(b.0)).floor().max(Vec2::ZERO);
    let max = boxes.iter().fold(Vec2::NEG_INFINITY, |m, b| m.max(b.1)).ceil();
    let max = max.min(Vec2::new(size.0 as f32, size.1 as f32));
    let extent = max - min;
    if !(extent.min_element() >= 1.0 && extent.max_element() <= MAX_SIDE) {
        return None;
    }
    let mut rays = RayGrid::new(*camera, min, (extent.x as usize * RAYS, extent.y as usize * RAYS));
    for ((solid, colour), bounds) in solids.iter().zip(&boxes) {
        rays.draw(solid, *colour, *bounds);
    }
    Some(rays.resolve())
}

impl Sprite {
    /// Lays the sprite over the picture.
    pub fn draw(&self, picture: &mut Picture) {
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let (x0, y0) = (self.corner.0 as usize, self.corner.1 as usize);
        let pixels = picture.pixels_mut();
        for y in 0..self.size.1.min(height.saturating_sub(y0)) {
            for x in 0..self.size.0.min(width.saturating_sub(x0)) {
                let top = self.pixels[y * self.size.0 + x];
                if top.alpha() > 0 {
                    let p = &mut pixels[(y0 + y) * width + x0 + x];
                    *p = source_over(top, *p);
                }
            }
        }
    }
}

/// Screen rectangle that holds a solid (px).
fn screen_box(solid: &Solid, camera: &Camera) -> (Vec2, Vec2) {
    let (a, b, reach) = solid.bounds();
    let (a, b) = (camera.project(a), camera.project(b));
    let r = Vec2::splat(reach * camera.px_per_m + 1.0);
    (a.min(b) - r, a.max(b) + r)
}

/// The rays of one sprite: what each meets first.
struct RayGrid {
    camera: Camera,
    light: Vec3,
    /// Brightness of contours: they fade out where figures are so small that little else would be left.
    contour: f32,
    corner: Vec2,
    size: (usize, usize),
    /// Depth of the nearest surface (m, width * height).
    depth: Vec<f32>,
    /// Its shaded colour (width * height).
    colour: Vec<Colour>,
}

impl RayGrid {
    fn new(camera: Camera, corner: Vec2, size: (usize, usize)) -> Self {
        let n = size.0 * size.1;
        let colour = vec![colour::INK; n];
        let contour = 1.0 - 0.5 * (camera.px_per_m / 110.0).min(1.0);
        Self { camera, light: light(&camera), contour, corner, size, depth: vec![f32::INFINITY; n], colour }
    }

    fn draw(&mut self, solid: &Solid, colour: Colour, bounds: (Vec2, Vec2)) {
        let low = ((bounds.0 - self.corner) * RAYS as f32).floor().max(Vec2::ZERO);
        let high = ((bounds.1 - self.corner) * RAYS as f32).ceil().max(Vec2::ZERO);
        let (x_end, y_end) = ((high.x as usize).min(self.size.0), (high.y as usize).min(self.size.1));
        for y in low.y as usize..y_end {
            for x in low.x as usize..x_end {
                let screen = self.corner + (Vec2::new(x as f32, y as f32) + 0.5) / RAYS as f32;
                let origin = self.camera.unproject(screen) - self.camera.forward * 20.0;
                let Some(hit) = solid.hit(origin, self.camera.forward) else { continue };
                let i = y * self.size.0 + x;
                if hit.distance < self.depth[i] {
                    self.depth[i] = hit.distance;
                    self.colour[i] = shade(colour, hit.normal, self.light, self.camera.forward);
                }
            }
        }
    }

    /// True where the surface stands clearly before what is beside it.
    fn is_contour(&self, x: usize, y: usize) -> bool {
        let d = self.depth[y * self.size.0 + x] + CONTOUR_STEP;
        let beside = |dx: isize, dy: isize| {
            let (x, y) = (x.checked_add_signed(dx), y.checked_add_signed(dy));
            match (x, y) {
                (Some(x), Some(y)) if x < self.size.0 && y < self.size.1 => self.depth[y * self.size.0 + x],
                _ => f32::INFINITY,
            }
        };
        [(-1, 0), (1, 0), (0, -1), (0, 1)].into_iter().any(|(dx, dy)| beside(dx, dy) > d)
    }

    /// The mean of the rays of every pixel.
    fn resolve(&self) -> Sprite {
        let size = (self.size.0 / RAYS, self.size.1 / RAYS);
        let mut pixels = Vec::with_capacity(size.0 * size.1);
        for py in 0..size.1 {
            for px in 0..size.0 {
                pixels.push(self.pixel(px, py));
            }
        }
        Sprite { corner: (self.corner.x as i32, self.corner.y as i32), size, pixels }
    }

    fn pixel(&self, px: usize, py: usize) -> PremultipliedColorU8 {
        let mut sum = [0.0f32; 4];
        for y in py * RAYS..(py + 1) * RAYS {
            for x in px * RAYS..(px + 1) * RAYS {
                let i = y * self.size.0 + x;
                if self.depth[i] < f32::INFINITY {
                    let c = self.colour[i];
                    let k = if self.is_contour(x, y) { self.contour } else { 1.0 };
                    sum = [sum[0] + c.r * k, sum[1] + c.g * k, sum[2] + c.b * k, sum[3] + 1.0];
                }
            }
        }
        let [r, g, b, a] = sum.map(|v| v / (RAYS * RAYS) as f32);
        let byte = |v: f32| (v * 255.0 + 0.5) as u8;
        let a = byte(a);
        PremultipliedColorU8::from_rgba(byte(r).min(a), byte(g).min(a), byte(b).min(a), a)
            .unwrap_or(PremultipliedColorU8::TRANSPARENT)
    }
}

/// Half-Lambert key light, a cool sky, a warm reflection of the ground, and a darker edge.
pub(super) fn shade(base: Colour, normal: Vec3, light: Vec3, forward: Vec3) -> Colour {
    let key = (0.5 + 0.5 * normal.dot(light)).powi(2);
    let sky = 0.5 + 0.5 * normal.y;
    let edge = 1.0 - (-normal.dot(forward)).clamp(0.0, 1.0);
    let strength = (0.44 + 0.16 * sky + 0.56 * key) * (1.0 - 0.22 * edge * edge * edge);
    let warm = 0.05 * (1.0 - sky);
    let c = |v: f32, tint: f32| (v * (strength + tint)).clamp(0.0, 1.0);
    Colour { r: c(base.r, warm), g: c(base.g, 0.3 * warm), b: c(base.b, 0.04 * sky), a: base.a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_runtime::Skeleton;

    fn standing() -> Figure {
        Figure::from_positions(&Skeleton::default().rest_positions())
    }

    #[test]
    fn what_is_nearer_hides_what_is_farther() {
        let camera = Camera::looking(-std::f32::consts::FRAC_PI_2, 0.0).framed(Vec3::Y, Vec2::new(50.0, 50.0), 40.0);
        let sprite = render(&standing(), &BodyColours::default(), &camera, (100, 100)).expect("is drawn");
        let knee = camera.project(standing().joint(throng_runtime::Joint::LeftShin));
        let i = (knee.y as i32 - sprite.corner.1) as usize * sprite.size.0 + (knee.x as i32 - sprite.corner.0) as usize;
        let seen = sprite.pixels[i];
        assert!(seen.red() > seen.blue(), "seen from the left the left leg, which is warm, is in front: {seen:?}");
    }

    #[test]
    fn a_figure_outside_or_broken_is_not_drawn() {
        let camera = Camera::looking(0.0, 0.5).framed(Vec3::ZERO, Vec2::new(50.0, 50.0), 20.0);
        let draw = |f: &Figure| render(f, &BodyColours::default(), &camera, (100, 100));
        assert!(draw(&standing()).is_some());
        assert!(draw(&standing().translated(Vec3::X * 100.0)).is_none());
        assert!(draw(&standing().translated(Vec3::X * f32::NAN)).is_none());
    }

    #[test]
    fn a_sprite_over_the_edge_is_cut_off() {
        let camera = Camera::looking(0.0, 0.5).framed(Vec3::ZERO, Vec2::new(0.0, 99.0), 60.0);
        let mut picture = Picture::new(100, 100, colour::PAPER);
        let before = picture.clone();
        let sprite = render(&standing(), &BodyColours::default(), &camera, (100, 100)).expect("half of it");
        sprite.draw(&mut picture);
        assert_ne!(picture, before);
    }
}
