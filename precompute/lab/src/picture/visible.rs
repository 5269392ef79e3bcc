//! Visibility of pieces: a depth buffer, filled in parallel bands of rows.

use super::{camera::PictureCamera, piece::PicturePiece};
use glam::Vec2;
use rayon::prelude::*;
use std::ops::Range;

/// Number of pixel rows of a band.
const BAND: usize = 32;

/// Number that stands for no piece.
pub(super) const NO_PIECE: u32 = u32::MAX;

/// A few rows of samples with the nearest piece at each.
pub(super) struct SampleBand {
    /// Samples in a row.
    pub width: usize,
    /// Rows of samples that the band covers; the first may lie above the picture.
    pub rows: Range<isize>,
    /// Depth of the nearest piece (m, width * rows).
    pub depth: Vec<f32>,
    /// Number of the nearest piece, or [`NO_PIECE`] (width * rows).
    pub piece: Vec<u32>,
}

impl SampleBand {
    /// Depth and number of the nearest piece at a sample; `None` outside of the band.
    pub fn sample_at(&self, x: isize, row: isize) -> Option<(f32, u32)> {
        let inside = (0..self.width as isize).contains(&x) && self.rows.contains(&row);
        let i = || (row - self.rows.start) as usize * self.width + x as usize;
        inside.then(i).map(|i| (self.depth[i], self.piece[i]))
    }

    fn draw(&mut self, number: u32, piece: &PicturePiece, camera: &PictureCamera, bounds: (Vec2, Vec2), rays: usize) {
        let (low, high) = ((bounds.0 * rays as f32).floor(), (bounds.1 * rays as f32).ceil());
        let columns = low.x.max(0.0) as usize..(high.x.max(0.0) as usize).min(self.width);
        let rows = (low.y as isize).max(self.rows.start)..(high.y as isize).min(self.rows.end);
        for row in rows {
            let start = (row - self.rows.start) as usize * self.width;
            for x in columns.clone() {
                let Some(hit) = piece.intersect(camera, sample_position(x as isize, row, rays)) else { continue };
                if hit.distance < self.depth[start + x] {
                    (self.depth[start + x], self.piece[start + x]) = (hit.distance, number);
                }
            }
        }
    }
}

/// Position of a sample in the picture (px).
pub(super) fn sample_position(x: isize, row: isize, rays: usize) -> Vec2 {
    (Vec2::new(x as f32, row as f32) + 0.5) / rays as f32
}

/// Rasterizes pieces in bands of pixel rows, and converts every band by `make`; results from top to bottom.
///
/// - `size`: size of the picture (px).
/// - `rays`: samples along each side of a pixel.
/// - `margin`: rows of samples that a band shares with its neighbours above and below.
/// - `make`: receives a band and its pixel rows.
pub(super) fn rasterize_bands<T: Send>(
    pieces: &[PicturePiece],
    camera: &PictureCamera,
    size: (usize, usize),
    rays: usize,
    margin: usize,
    make: impl Fn(&SampleBand, Range<usize>) -> T + Sync,
) -> Vec<T> {
    let boxes: Vec<(Vec2, Vec2)> = pieces.par_iter().map(|p| p.screen_box(camera)).collect();
    let mut of_band: Vec<Vec<u32>> = vec![Vec::new(); size.1.div_ceil(BAND)];
    let reach = margin as f32 / rays as f32 + 1.0;
    for (i, (low, high)) in boxes.iter().enumerate() {
        if !(low.is_finite() && high.is_finite()) || high.x < 0.0 || low.x > size.0 as f32 || high.y + reach < 0.0 {
            continue;
        }
        let first = ((low.y - reach).max(0.0) as usize / BAND).min(of_band.len());
        let last = ((high.y + reach).max(0.0) as usize / BAND + 1).clamp(first, of_band.len());
        of_band[first..last].iter_mut().for_each(|b| b.push(i as u32));
    }
    let band = |(number, numbers): (usize, &Vec<u32>)| {
        let pixels = number * BAND..((number + 1) * BAND).min(size.1);
        let rows = (pixels.start * rays) as isize - margin as isize..(pixels.end * rays + margin) as isize;
        let n = size.0 * rays * rows.len();
        let (depth, piece) = (vec![f32::INFINITY; n], vec![NO_PIECE; n]);
        let mut band = SampleBand { width: size.0 * rays, rows, depth, piece };
        numbers.iter().for_each(|&i| band.draw(i, &pieces[i as usize], camera, boxes[i as usize], rays));
        make(&band, pixels)
    };
    of_band.par_iter().enumerate().map(band).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::colour;
    use crate::picture::solid::RoundCone;
    use glam::Vec3;

    #[test]
    fn the_nearest_piece_is_seen_in_every_band() {
        let camera = PictureCamera::looking_along(0.0, 0.0).framed(Vec3::ZERO, Vec2::new(40.0, 60.0), 20.0);
        let wall = |z: f32| {
            let [a, b, c] = [Vec3::new(-9.0, -9.0, z), Vec3::new(9.0, -9.0, z), Vec3::new(0.0, 30.0, z)];
            PicturePiece::face([a, b, c], colour::INK)
        };
        let ball = PicturePiece::round(RoundCone::limb(Vec3::ZERO, Vec3::ZERO, 0.5, 0.5), colour::INK);
        let pieces = [wall(3.0), ball, wall(8.0)];
        let rows = rasterize_bands(&pieces, &camera, (80, 120), 2, 3, |band, pixels| {
            assert_eq!(band.rows.len(), pixels.len() * 2 + 6);
            pixels
                .map(|y| (0..80).map(|x| band.sample_at(2 * x, 2 * y as isize).unwrap().1).collect::<Vec<_>>())
                .collect()
        });
        let rows: Vec<Vec<u32>> = rows.into_iter().flat_map(|b: Vec<Vec<u32>>| b).collect();
        assert_eq!(rows.len(), 120);
        for (y, row) in rows.iter().enumerate() {
            for (x, piece) in row.iter().enumerate() {
                let from_ball = (Vec2::new(x as f32, y as f32) + 0.25 - Vec2::new(40.0, 60.0)).length() / 20.0;
                if from_ball < 0.49 {
                    assert_eq!(*piece, 1, "{x} {y}");
                } else if from_ball > 0.51 {
                    assert_eq!(*piece, 0, "{x} {y}");
                }
            }
        }
    }
}
