//! One figure, shaded and anti-aliased, without a shadow.

use super::camera::PictureCamera;
use super::canvas::{Picture, source_over};
use super::figure::{BodyColours, BodyFigure, body_solids};
use super::paint::paint_pieces;
use super::piece::PicturePiece;
use glam::Vec2;
use tiny_skia::PremultipliedColorU8;

/// Greatest side of a sprite; a larger figure is not drawn (px).
const MAX_SIDE: f32 = 4096.0;

/// A drawn figure, ready to be copied onto a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sprite {
    pub corner: (i32, i32),
    pub size: (usize, usize),
    /// Pixels (width * height).
    pub pixels: Vec<PremultipliedColorU8>,
}

/// Draws a figure on a picture, if it can be drawn.
pub(super) fn draw(picture: &mut Picture, figure: &BodyFigure, colours: &BodyColours, camera: &PictureCamera) {
    if let Some(sprite) = Sprite::new(figure, colours, camera, (picture.width(), picture.height())) {
        sprite.draw(picture);
    }
}

impl Sprite {
    /// The sprite of a figure; `None` where that cannot be drawn or lies outside of the picture's `size`.
    pub fn new(figure: &BodyFigure, colours: &BodyColours, camera: &PictureCamera, size: (u32, u32)) -> Option<Self> {
        if !figure.is_drawable() {
            return None;
        }
        let solids = body_solids(figure, colours).into_iter();
        let pieces: Vec<PicturePiece> = solids.map(|(s, c)| PicturePiece::round(s, c)).collect();
        let boxes = || pieces.iter().map(|p| p.screen_box(camera));
        let min = boxes().fold(Vec2::INFINITY, |m, b| m.min(b.0)).floor().max(Vec2::ZERO);
        let max = boxes().fold(Vec2::NEG_INFINITY, |m, b| m.max(b.1)).ceil();
        let extent = max.min(Vec2::new(size.0 as f32, size.1 as f32)) - min;
        if !(extent.min_element() >= 1.0 && extent.max_element() <= MAX_SIDE) {
            return None;
        }
        let size = (extent.x as usize, extent.y as usize);
        let camera = PictureCamera { screen: camera.screen - min, ..*camera };
        Some(Self { corner: (min.x as i32, min.y as i32), size, pixels: paint_pieces(&pieces, &camera, size, None) })
    }

    /// Draws the sprite over a picture.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::colour;
    use glam::Vec3;
    use throng_core::Skeleton;

    fn standing() -> BodyFigure {
        BodyFigure::from_positions(&Skeleton::default().rest_positions())
    }

    #[test]
    fn what_is_nearer_hides_what_is_farther() {
        let camera = PictureCamera::looking_along(-std::f32::consts::FRAC_PI_2, 0.0).framed(
            Vec3::Y,
            Vec2::new(50.0, 50.0),
            40.0,
        );
        let sprite = Sprite::new(&standing(), &BodyColours::default(), &camera, (100, 100)).expect("is drawn");
        let knee = camera.project(standing().joint(throng_core::Joint::LeftShin));
        let i = (knee.y as i32 - sprite.corner.1) as usize * sprite.size.0 + (knee.x as i32 - sprite.corner.0) as usize;
        let seen = sprite.pixels[i];
        assert!(seen.red() > seen.blue(), "seen from the left the left leg, which is warm, is in front: {seen:?}");
    }

    #[test]
    fn a_figure_outside_or_broken_is_not_drawn() {
        let camera = PictureCamera::looking_along(0.0, 0.5).framed(Vec3::ZERO, Vec2::new(50.0, 50.0), 20.0);
        let draw = |f: &BodyFigure| Sprite::new(f, &BodyColours::default(), &camera, (100, 100));
        assert!(draw(&standing()).is_some());
        assert!(draw(&standing().translated(Vec3::X * 100.0)).is_none());
        assert!(draw(&standing().translated(Vec3::X * f32::NAN)).is_none());
    }

    #[test]
    fn a_sprite_over_the_edge_is_cut_off() {
        let camera = PictureCamera::looking_along(0.0, 0.5).framed(Vec3::ZERO, Vec2::new(0.0, 99.0), 60.0);
        let mut picture = Picture::new(100, 100, colour::PAPER);
        let before = picture.clone();
        let sprite = Sprite::new(&standing(), &BodyColours::default(), &camera, (100, 100)).expect("half of it");
        sprite.draw(&mut picture);
        assert_ne!(picture, before);
    }
}
