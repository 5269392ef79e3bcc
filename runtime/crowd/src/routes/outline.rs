//! Outlines of obstacles, from above: for paths round them.

use crate::Obstacle;
use glam::{Vec2, Vec3, Vec3Swizzles};
use std::f32::consts::TAU;
use throng_base::maths;
use throng_geometry::{polygon_contains, segment_distance_2d};

/// Something solid, from above.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ObstacleOutline {
    /// All points within `radius` of a line; a disc where its ends are one.
    Wall {
        /// First end (m).
        from: Vec2,
        /// The other end (m).
        to: Vec2,
        /// (m, >= 0)
        radius: f32,
    },
    /// A polygon, its corners in order around it (m, >= 3).
    Polygon(Vec<Vec2>),
}

impl ObstacleOutline {
    /// Outline of an obstacle; none of a moving one, and in the air none of an obstacle that can be passed above or
    /// below.
    ///
    /// - `heights`: lowest and highest position of agents in the air (m); `None` on the ground.
    pub fn from_obstacle(obstacle: &Obstacle, heights: Option<[f32; 2]>) -> Option<Self> {
        let spans = |low: Vec3, high: Vec3, radius: f32| {
            heights.is_none_or(|[lowest, highest]| {
                low.y.min(high.y) - radius <= lowest && low.y.max(high.y) + radius >= highest
            })
        };
        match obstacle {
            &Obstacle::Ball { centre, radius } if heights.is_none() => {
                Some(Self::Wall { from: centre.xz(), to: centre.xz(), radius })
            }
            &Obstacle::Wall { from, to, radius } if spans(from, to, radius) => {
                Some(Self::Wall { from: from.xz(), to: to.xz(), radius })
            }
            Obstacle::Polygon { corners } => Some(Self::Polygon(corners.iter().map(|c| c.xz()).collect())),
            &Obstacle::Box { min, max } if spans(min, max, 0.0) => {
                let (a, b) = (min.xz(), max.xz());
                Some(Self::Polygon(vec![a, Vec2::new(b.x, a.y), b, Vec2::new(a.x, b.y)]))
            }
            _ => None,
        }
    }

    /// Distance of a point; 0 inside (m).
    pub fn distance(&self, p: Vec2) -> f32 {
        self.distance_of_line(p, p)
    }

    /// Smallest distance of a straight line; 0 where it comes inside (m).
    pub fn distance_of_line(&self, a: Vec2, b: Vec2) -> f32 {
        match self {
            Self::Wall { from, to, radius } => (segment_distance_2d([a, b], [*from, *to]) - radius).max(0.0),
            Self::Polygon(_) if self.contains_point(a) => 0.0,
            Self::Polygon(corners) => {
                edges(corners).map(|e| segment_distance_2d([a, b], e)).fold(f32::INFINITY, f32::min)
            }
        }
    }

    /// Lines with a radius (m) that are its edge.
    pub fn edges(&self) -> impl Iterator<Item = ([Vec2; 2], f32)> + '_ {
        let (wall, polygon) = match self {
            Self::Wall { from, to, radius } => (Some(([*from, *to], *radius)), None),
            Self::Polygon(corners) => (None, Some(edges(corners).map(|e| (e, 0.0)))),
        };
        wall.into_iter().chain(polygon.into_iter().flatten())
    }

    /// True where a place is in a polygon.
    pub fn contains_point(&self, p: Vec2) -> bool {
        matches!(self, Self::Polygon(corners) if polygon_contains(corners.iter().copied(), p))
    }

    /// Corners that ways may lead round (m): one of a disc, two of a wall.
    pub fn corners(&self) -> Vec<Vec2> {
        match self {
            Self::Wall { from, to, .. } if from == to => vec![*from],
            Self::Wall { from, to, .. } => vec![*from, *to],
            Self::Polygon(corners) => corners.clone(),
        }
    }

    /// Lowest and highest x and z (m).
    pub fn bounds(&self) -> (Vec2, Vec2) {
        match self {
            Self::Wall { from, to, radius } => (from.min(*to) - *radius, from.max(*to) + *radius),
            Self::Polygon(corners) => {
                corners.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, h), c| (l.min(*c), h.max(*c)))
            }
        }
    }

    /// Points to go around it by, each with its corner: on circles about its corners, which keep `clearance` from them, and
    /// so does the straight line between two neighbours of a circle.
    pub fn points_around(&self, clearance: f32) -> Vec<(Vec2, Vec2)> {
        let (corners, radius) = (self.corners(), if let Self::Wall { radius, .. } = self { *radius } else { 0.0 });
        // Larger circles need more points for the same detour.
        let num = if radius > clearance { 24 } else { 12 };
        let out = (radius + clearance) * 1.002 / maths::cos(0.5 * TAU / num as f32);
        let away = |i: i32| maths::direction_at_angle(TAU * i as f32 / num as f32) * out;
        corners.into_iter().flat_map(|c| (0..num).map(move |i| (c + away(i), c))).collect()
    }
}

/// Lines from each corner to the next.
fn edges(corners: &[Vec2]) -> impl Iterator<Item = [Vec2; 2]> + '_ {
    (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vec2> {
        [-5.0f32..5.0, -5.0f32..5.0].prop_map(Vec2::from_array)
    }

    fn outline() -> impl Strategy<Value = ObstacleOutline> {
        prop_oneof![
            (point(), point(), 0.0f32..1.0).prop_map(|(from, to, radius)| ObstacleOutline::Wall { from, to, radius }),
            (point(), 0.2f32..1.0).prop_map(|(c, radius)| ObstacleOutline::Wall { from: c, to: c, radius }),
            // A star about a centre is a simple polygon.
            (point(), prop::collection::vec(0.5f32..2.0, 3..8)).prop_map(|(c, reach)| {
                let n = reach.len() as f32;
                let corner = |(i, r): (usize, &f32)| c + Vec2::from_angle(TAU * i as f32 / n) * *r;
                ObstacleOutline::Polygon(reach.iter().enumerate().map(corner).collect())
            }),
        ]
    }

    proptest! {
        #[test]
        fn distance_of_line_is_that_of_its_nearest_point(s in outline(), a in point(), b in point()) {
            let sampled = (0..=2000).map(|i| s.distance(a.lerp(b, i as f32 / 2000.0))).fold(f32::INFINITY, f32::min);
            let exact = s.distance_of_line(a, b);
            prop_assert!(exact <= sampled + 1e-4 && sampled <= exact + 0.01, "{exact} {sampled}");
        }

        #[test]
        fn points_around_a_corner_and_the_lines_between_them_keep_the_clearance(
            c in point(), radius in 0.0f32..2.0, clearance in 0.1f32..1.0,
        ) {
            let disc = ObstacleOutline::Wall { from: c, to: c, radius };
            let around = disc.points_around(clearance);
            for i in 0..around.len() {
                let line = disc.distance_of_line(around[i].0, around[(i + 1) % around.len()].0);
                prop_assert!(line >= clearance && line < 1.1 * clearance + 0.1 * radius, "{line}");
            }
        }
    }

    #[test]
    fn inside_is_at_no_distance() {
        let square =
            ObstacleOutline::Polygon([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(Vec2::from_array).to_vec());
        assert_eq!(square.distance(Vec2::new(1.0, 1.0)), 0.0);
        assert_eq!(square.distance(Vec2::new(7.0, 8.0)), 5.0);
        assert_eq!(square.distance_of_line(Vec2::new(-1.0, 2.0), Vec2::new(9.0, 2.0)), 0.0);
        assert_eq!(square.bounds(), (Vec2::ZERO, Vec2::splat(4.0)));
    }
}
