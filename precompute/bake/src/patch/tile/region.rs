//! Outline of a tile on the ground, and the test of paths against it.

use super::layout::{TileLayout, TileSpot};
use crate::environment::TileEdges;
use glam::Vec2;

/// Largest sway of a path back across the edge that it has just crossed (m).
const SWAY_M: f32 = 0.04;

/// One side of the outline: points `p` with `normal . p <= offset` are inside.
pub(super) struct OutlineSide {
    /// Outward normal: (x, z). Unit.
    pub normal: Vec2,
    /// Offset along the normal (m).
    pub offset: f32,
    /// Edge on this side, if any.
    pub edge: Option<u32>,
}

/// The outline of a tile.
pub(super) struct TileOutline<'a> {
    /// Edges of the tile.
    pub edges: &'a TileEdges,
    /// Sides; those of edges first, in the order of the edges.
    pub sides: Vec<OutlineSide>,
    /// Centre: (x, z) (m).
    pub centre: Vec2,
    /// Least distance of roots from the sides (m).
    pub margin: f32,
    /// Length of the longest step to a neighbour (m).
    pub size: f32,
}

impl<'a> TileOutline<'a> {
    /// Outline implied by edges; a margin takes at most half of the narrowest edge.
    pub fn new(edges: &'a TileEdges, margin: f32) -> Self {
        let centre = Vec2::new(edges.centre[0], edges.centre[2]);
        let side = |normal: Vec2, half: f32, edge| OutlineSide { normal, offset: normal.dot(centre) + half, edge };
        let mut sides = Vec::new();
        let mut narrowest = f32::MAX;
        for (i, (step, width)) in edges.steps.iter().zip(&edges.widths).enumerate() {
            let across = Vec2::new(step[0], step[2]);
            let normal = across.normalize_or_zero();
            sides.push(side(normal, across.length() / 2.0, Some(2 * i as u32)));
            sides.push(side(-normal, across.length() / 2.0, Some(2 * i as u32 + 1)));
            narrowest = narrowest.min(*width);
        }
        if edges.steps.len() == 1 {
            let lateral = lateral(sides[1].normal);
            sides.push(side(lateral, edges.widths[0] / 2.0, None));
            sides.push(side(-lateral, edges.widths[0] / 2.0, None));
        }
        let size = edges.steps.iter().map(|s| s[0].hypot(s[2])).fold(0.0, f32::max);
        Self { edges, sides, centre, margin: margin.min(narrowest / 4.0), size }
    }

    /// Depth of a point inside a side; negative outside (m).
    pub fn inset(&self, side: usize, p: Vec2) -> f32 {
        self.sides[side].offset - self.sides[side].normal.dot(p)
    }

    /// True if a point is more than `reach` outside the tile.
    pub fn is_left(&self, p: Vec2, reach: f32) -> bool {
        (0..self.sides.len()).any(|s| self.inset(s, p) < -reach)
    }

    /// True if a path stays within the tile, and away from its edges except where it crosses them.
    ///
    /// - `path`: points, with the length of the path up to each.
    pub fn contains(&self, layout: &TileLayout, from: u32, to: u32, path: &[(Vec2, f32)]) -> bool {
        let (from, to) = (&layout.spots[from as usize], &layout.spots[to as usize]);
        let total = path.last().map_or(0.0, |p| p.1);
        // Oblique paths take a little more than the margin to leave it.
        let near = self.margin + 0.25;
        path.iter().all(|&(p, walked)| {
            self.sides.iter().enumerate().all(|(s, side)| {
                let crossed = |spot: &TileSpot, d: f32| side.edge.is_some_and(|e| spot.edge == e) && d <= near;
                let least =
                    if crossed(from, walked) || crossed(to, total - walked) { -SWAY_M } else { self.margin - SWAY_M };
                self.inset(s, p) >= least
            })
        })
    }
}

/// Direction to the left of `ahead`: (x, z).
pub(super) fn lateral(ahead: Vec2) -> Vec2 {
    Vec2::new(ahead.y, -ahead.x)
}

/// True where a path crosses itself.
///
/// - `points`: of the path, in order; sampled every few frames.
pub(super) fn crosses_itself(points: &[(Vec2, f32)]) -> bool {
    const STRIDE: usize = 4;
    let coarse: Vec<Vec2> = points.iter().step_by(STRIDE).chain(points.last()).map(|p| p.0).collect();
    let cuts = |i: usize, j: usize| crosses(coarse[i], coarse[i + 1], coarse[j], coarse[j + 1]);
    (2..coarse.len().saturating_sub(1)).any(|j| (0..j - 1).any(|i| cuts(i, j)))
}

/// True where the segments a-b and c-d share an inner point.
fn crosses(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let side = |p: Vec2, q: Vec2, r: Vec2| (q - p).perp_dot(r - p);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(points: &[(f32, f32)]) -> Vec<(Vec2, f32)> {
        // Each corner often enough that none is skipped.
        let dense = points
            .windows(2)
            .flat_map(|w| (0..8).map(move |k| Vec2::from(w[0]).lerp(Vec2::from(w[1]), k as f32 / 8.0)));
        dense.chain(points.last().map(|&p| p.into())).map(|p| (p, 0.0)).collect()
    }

    #[test]
    fn a_loop_crosses_itself_and_a_bend_does_not() {
        assert!(crosses_itself(&path(&[(0.0, 0.0), (0.0, 2.0), (1.0, 2.0), (1.0, 1.1), (-1.1, 1.1)])));
        assert!(!crosses_itself(&path(&[(0.0, 0.0), (0.0, 2.0), (1.0, 2.0), (1.0, 1.0), (0.5, 1.0)])));
        assert!(!crosses_itself(&path(&[(0.0, 0.0), (0.0, 2.0)])));
    }

    #[test]
    fn the_left_of_ahead_is_plus_x() {
        assert_eq!(lateral(Vec2::new(0.0, 1.0)), Vec2::new(1.0, 0.0));
    }
}
