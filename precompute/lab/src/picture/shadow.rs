//! Soft shadows of figures on the ground.

use super::canvas::source_over;
use super::figure::body_solids;
use super::paint::light_direction;
use super::{BodyColours, BodyFigure, Colour, Picture, PictureCamera};
use glam::Vec3;
use tiny_skia::{FillRule, Mask, Path, PathBuilder, Transform};

/// Number of corners of a half disc's outline.
const CORNERS: usize = 10;

/// Collects the shadows of many figures, and draws them at once, so that overlapping ones do not add up.
pub(super) struct Shadows {
    mask: Mask,
}

impl Shadows {
    /// An empty collection for a picture.
    pub fn new(picture: &Picture) -> Option<Self> {
        Mask::new(picture.width(), picture.height()).map(|mask| Self { mask })
    }

    /// Adds the shadow of a figure on the ground y = 0, as `camera` sees it.
    pub fn add(&mut self, figure: &BodyFigure, camera: &PictureCamera) {
        if let Some(path) = Some(figure).filter(|f| f.is_drawable()).and_then(|f| shadow_outline(f, camera)) {
            self.mask.fill_path(&path, FillRule::Winding, true, Transform::identity());
        }
    }

    /// Blurs by `radius` pixels and darkens the picture.
    pub fn draw(mut self, picture: &mut Picture, radius: usize, colour: Colour) {
        let (w, h) = (picture.width() as usize, picture.height() as usize);
        for _ in 0..2 {
            blur_rows(self.mask.data_mut(), w, radius);
            let mut turned = transposed(self.mask.data(), w, h);
            blur_rows(&mut turned, h, radius);
            self.mask.data_mut().copy_from_slice(&transposed(&turned, h, w));
        }
        for (pixel, &m) in picture.pixels_mut().iter_mut().zip(self.mask.data()) {
            if m > 0 {
                let c = colour.alpha(colour.a * f32::from(m) / 255.0).to_skia().premultiply().to_color_u8();
                *pixel = source_over(c, *pixel);
            }
        }
    }
}

/// The outlines of all solids, all in the same sense of rotation: filled by winding they are their union.
fn shadow_outline(figure: &BodyFigure, camera: &PictureCamera) -> Option<Path> {
    let mut b = PathBuilder::new();
    for (solid, _) in body_solids(figure, &BodyColours::default()) {
        let [(p, rp), (q, rq)] = solid.shadow(light_direction(camera));
        let corners = disc_hull(p, rp, q, rq).map(|c| camera.project(c));
        if corners.iter().all(|c| c.is_finite() && c.abs().max_element() < 1e6) {
            b.move_to(corners[0].x, corners[0].y);
            corners[1..].iter().for_each(|c| b.line_to(c.x, c.y));
            b.close();
        }
    }
    b.finish()
}

/// Convex outline of two discs on the ground: the half of each that is turned away from the other.
fn disc_hull(p: Vec3, rp: f32, q: Vec3, rq: f32) -> [Vec3; 2 * CORNERS] {
    let d = q - p;
    let along = d.x.atan2(d.z);
    std::array::from_fn(|i| {
        let half = std::f32::consts::PI * (i % CORNERS) as f32 / (CORNERS - 1) as f32;
        let (centre, r, start) = if i < CORNERS { (q, rq, along - 1.570_796_4) } else { (p, rp, along + 1.570_796_4) };
        let (s, c) = (start + half).sin_cos();
        centre + Vec3::new(s, 0.0, c) * r
    })
}

/// Running mean over `2 radius + 1` pixels along every row.
fn blur_rows(data: &mut [u8], width: usize, radius: usize) {
    let span = 2 * radius + 1;
    let mut old = vec![0u8; width];
    for row in data.chunks_exact_mut(width) {
        if row.iter().all(|&v| v == 0) {
            continue;
        }
        old.copy_from_slice(row);
        let at = |i: usize| u32::from(old.get(i).copied().unwrap_or(0));
        let mut sum: u32 = (0..radius).map(at).sum();
        for x in 0..width {
            sum += at(x + radius);
            row[x] = (sum / span as u32) as u8;
            sum -= if x >= radius { at(x - radius) } else { 0 };
        }
    }
}

/// Transposes rows and columns.
fn transposed(data: &[u8], width: usize, height: usize) -> Vec<u8> {
    (0..data.len()).map(|i| data[i % height * width + i / height]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::colour;
    use glam::Vec2;
    use throng_core::Skeleton;

    #[test]
    fn blur_keeps_the_sum_away_from_the_edges() {
        let mut row = vec![0u8; 41];
        row[20] = 210;
        blur_rows(&mut row, 41, 3);
        assert_eq!(row[17..=23], [30; 7]);
        assert_eq!(row.iter().map(|&v| u32::from(v)).sum::<u32>(), 210);
    }

    #[test]
    fn a_shadow_lies_at_the_feet_and_away_from_the_light() {
        let camera = PictureCamera::looking_along(0.0, 0.7).framed(Vec3::ZERO, Vec2::new(100.0, 100.0), 50.0);
        let mut picture = Picture::new(200, 200, colour::GROUND);
        let blank = picture.pixel(0, 0);
        let mut shadows = Shadows::new(&picture).expect("a mask");
        shadows.add(&BodyFigure::from_positions(&Skeleton::default().rest_positions()), &camera);
        shadows.draw(&mut picture, 2, colour::INK.alpha(0.3));
        let at = |x: f32| {
            let p = camera.project(Vec3::ZERO);
            picture.pixel((p.x + x) as u32, p.y as u32)
        };
        assert_ne!(at(0.0), blank);
        assert_eq!(at(-80.0), blank, "the light comes from the left");
    }
}
