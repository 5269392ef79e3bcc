//! Paints pieces shaded and anti-aliased, with several rays a pixel, and the shadows that they cast.

use super::visible::{NO_PIECE, SampleBand, rasterize_bands, sample_position};
use super::{Colour, Picture, PictureCamera, canvas::source_over, colour, piece::PicturePiece};
use glam::{Vec2, Vec3};
use std::ops::Range;
use throng_geometry::BoundingBox;
use tiny_skia::PremultipliedColorU8;

/// Number of rays along each side of a pixel.
const RAYS: usize = 3;
/// Least step in depth at which a contour is drawn (m).
const CONTOUR_STEP: f32 = 0.07;
/// Longest side of the shadow map (px).
const SHADOW_PX: f32 = 3000.0;
/// Finest resolution of the shadow map (px/m).
const SHADOW_FINEST: f32 = 160.0;

/// Direction towards the light: from above, the left and the viewer.
fn light_direction(camera: &PictureCamera) -> Vec3 {
    (Vec3::Y * 1.0 - camera.right * 0.34 - camera.forward.with_y(0.0).normalize_or_zero() * 0.42).normalize()
}

/// Paints pieces and their shadows over a panel.
pub(super) fn draw_pieces(panel: &mut Picture, camera: &PictureCamera, pieces: &[PicturePiece]) {
    let extent = Vec2::new(panel.width() as f32, panel.height() as f32);
    let reach = Vec2::splat(2.0 * camera.px_per_m);
    // Shadows of pieces far outside of the picture are not worth their time.
    let near = |p: &&PicturePiece| {
        let (low, high) = p.screen_box(camera);
        high.cmpge(-reach).all() && low.cmple(extent + reach).all()
    };
    let pieces: Vec<PicturePiece> = pieces.iter().filter(near).copied().collect();
    let contour = 1.0 - 0.5 * (camera.px_per_m / 110.0).min(1.0);
    let light = light_direction(camera);
    let shadows = ShadowMap::new(&pieces, light);
    let painter = Painter { pieces: &pieces, camera: *camera, light, shadows, contour };
    let size = (panel.width() as usize, panel.height() as usize);
    let bands = rasterize_bands(&pieces, camera, size, RAYS, 1, |band, pixels| painter.paint(band, pixels, size.0));
    panel.pixels_mut().iter_mut().zip(bands.concat()).for_each(|(pixel, top)| *pixel = source_over(top, *pixel));
}

/// Converts bands of samples to pixels.
struct Painter<'a> {
    pieces: &'a [PicturePiece],
    camera: PictureCamera,
    light: Vec3,
    shadows: Option<ShadowMap>,
    /// Brightness of contours.
    contour: f32,
}

impl Painter<'_> {
    fn paint(&self, band: &SampleBand, pixels: Range<usize>, columns: usize) -> Vec<PremultipliedColorU8> {
        let mut out = Vec::with_capacity(pixels.len() * columns);
        for y in pixels {
            for x in 0..columns {
                let mut sum = [0.0f32; 4];
                for row in (y * RAYS) as isize..((y + 1) * RAYS) as isize {
                    for column in (x * RAYS) as isize..((x + 1) * RAYS) as isize {
                        let c = self.sample(band, column, row);
                        sum = [sum[0] + c.r * c.a, sum[1] + c.g * c.a, sum[2] + c.b * c.a, sum[3] + c.a];
                    }
                }
                let [r, g, b, a] = sum.map(|v| (v / (RAYS * RAYS) as f32 * 255.0 + 0.5) as u8);
                let c = PremultipliedColorU8::from_rgba(r.min(a), g.min(a), b.min(a), a);
                out.push(c.unwrap_or(PremultipliedColorU8::TRANSPARENT));
            }
        }
        out
    }

    fn sample(&self, band: &SampleBand, x: isize, row: isize) -> Colour {
        let screen = sample_position(x, row, RAYS);
        let seen = band.sample_at(x, row).filter(|s| s.1 != NO_PIECE);
        let seen = seen.and_then(|(_, i)| Some((i, self.pieces[i as usize].intersect(&self.camera, screen)?)));
        let Some((i, hit)) = seen else {
            let shadow = self.camera.ground_point(screen).map_or(0.0, |p| self.shadow(p));
            return colour::INK.alpha(0.3 * shadow);
        };
        let p = self.camera.unproject(screen) + self.camera.forward * hit.distance;
        let lit = shade(self.pieces[i as usize].colour, hit.normal, self.light, self.camera.forward);
        let faces_light = (8.0 * hit.normal.dot(self.light)).clamp(0.0, 1.0);
        let dark = 1.0 - 0.34 * faces_light * self.shadow(p + hit.normal * 0.02);
        let k = dark * if self.is_contour(band, x, row, hit.distance) { self.contour } else { 1.0 };
        Colour { r: lit.r * k, g: lit.g * k, b: lit.b * k, a: 1.0 }
    }

    fn shadow(&self, p: Vec3) -> f32 {
        self.shadows.as_ref().map_or(0.0, |s| s.shadow_at(p))
    }

    /// True where the surface is clearly nearer than a neighbouring sample.
    fn is_contour(&self, band: &SampleBand, x: isize, row: isize, depth: f32) -> bool {
        let beside =
            |(dx, dy): (isize, isize)| band.sample_at(x + dx, row + dy).is_some_and(|s| s.0 > depth + CONTOUR_STEP);
        [(-1, 0), (1, 0), (0, -1), (0, 1)].into_iter().any(beside)
    }
}

/// Depths up to which light reaches, as seen from the light.
struct ShadowMap {
    camera: PictureCamera,
    width: usize,
    /// Depth of the lit surface (m, width * height).
    depth: Vec<f32>,
}

impl ShadowMap {
    /// The shadow map of pieces; `None` without pieces.
    fn new(pieces: &[PicturePiece], light: Vec3) -> Option<Self> {
        let all = pieces.iter().fold(BoundingBox::EMPTY, |b, p| b.union(p.bounds()));
        if all.is_empty() {
            return None;
        }
        let right = light.cross(Vec3::Z).normalize_or(Vec3::X);
        let up = -light.cross(right);
        let seen =
            PictureCamera { right, up, forward: -light, target: all.centre(), screen: Vec2::ZERO, px_per_m: 1.0 };
        let reach = all.corners().map(|c| seen.project(c).abs()).into_iter().fold(Vec2::splat(0.5), Vec2::max);
        let px_per_m = (0.5 * SHADOW_PX / reach.max_element()).min(SHADOW_FINEST);
        let half = (reach * px_per_m).ceil() + 2.0;
        let size = ((2.0 * half.x) as usize, (2.0 * half.y) as usize);
        let camera = PictureCamera { screen: half, px_per_m, ..seen };
        let rows = rasterize_bands(pieces, &camera, size, 1, 0, |band, _| band.depth.clone());
        Some(Self { camera, width: size.0, depth: rows.concat() })
    }

    /// Share of shadow at a point (0 to 1).
    fn shadow_at(&self, p: Vec3) -> f32 {
        let (screen, depth) = (self.camera.project(p), self.camera.depth(p));
        // The depth of flat ground differs from one sample to the next; the bias keeps it from shadowing itself.
        let bias = 0.015 + 1.5 / self.camera.px_per_m;
        let mut dark = 0.0;
        for dy in -1..=1 {
            for dx in -1..=1 {
                let (x, y) = (screen.x.floor() + dx as f32, screen.y.floor() + dy as f32);
                if x >= 0.0 && y >= 0.0 && (x as usize) < self.width {
                    let lit = self.depth.get(y as usize * self.width + x as usize).copied().unwrap_or(f32::INFINITY);
                    dark += if lit < depth - bias { 1.0 } else { 0.0 };
                }
            }
        }
        dark / 9.0
    }
}

/// Shades a colour: half-Lambert key light, a cool sky, a warm reflection of the ground, and a darker edge.
fn shade(base: Colour, normal: Vec3, light: Vec3, forward: Vec3) -> Colour {
    let key = (0.5 + 0.5 * normal.dot(light)).powi(2);
    let sky = 0.5 + 0.5 * normal.y;
    let edge = 1.0 - (-normal.dot(forward)).clamp(0.0, 1.0);
    let strength = (0.44 + 0.16 * sky + 0.56 * key) * (1.0 - 0.22 * edge * edge * edge);
    let warm = 0.05 * (1.0 - sky);
    let c = |v: f32, tint: f32| (v * (strength + tint)).clamp(0.0, 1.0);
    Colour { r: c(base.r, warm), g: c(base.g, 0.3 * warm), b: c(base.b, 0.04 * sky), a: base.a }
}
