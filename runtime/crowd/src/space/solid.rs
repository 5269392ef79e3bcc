//! Convex bodies that obstacles are made of.

use crate::{Obstacle, Space, error::check};
use glam::Vec2;
use throng_base::Result;
use throng_geometry::{polygon_contains, share_along};

/// A convex body that stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ConvexSolid<V> {
    /// Disc or ball.
    Ball {
        /// (m)
        centre: V,
        /// (m)
        radius: f32,
    },
    /// All points within `radius` of a line.
    Capsule {
        /// (m)
        from: V,
        /// (m)
        to: V,
        /// (m)
        radius: f32,
    },
    /// Along the axes.
    Box {
        /// (m)
        min: V,
        /// (m)
        max: V,
    },
}

impl<V: Space> ConvexSolid<V> {
    /// Unit vector from the nearest point of the body to `x`, and how far that is: below zero inside, but for boxes,
    /// where it is zero.
    pub fn direction_and_distance(&self, x: V) -> (V, f32) {
        let (from_it, radius) = match *self {
            Self::Ball { centre, radius } => (x - centre, radius),
            Self::Capsule { from, to, radius } => {
                let along = to - from;
                let share = share_along(x, [from, to]);
                let mut from_it = x - (from + along * share);
                if 0.0 < share && share < 1.0 {
                    // What rounding left of a component along it would tilt a plane against a long wall into the wall.
                    from_it += along * -(from_it.dot(along) / along.length_squared().max(1e-12));
                }
                (from_it, radius)
            }
            Self::Box { min, max } => (x - x.max(min).min(max), 0.0),
        };
        let (away, distance) = from_it.unit_and_length();
        (away, distance - radius)
    }

    /// Extent of the body along a unit vector: the largest scalar product.
    pub fn reach(&self, along: V) -> f32 {
        match *self {
            Self::Ball { centre, radius } => centre.dot(along) + radius,
            Self::Capsule { from, to, radius } => from.dot(along).max(to.dot(along)) + radius,
            Self::Box { min, max } => {
                let (n, low, high) = (along.coordinates(), min.coordinates(), max.coordinates());
                (0..3).map(|i| (n[i] * low[i]).max(n[i] * high[i])).sum()
            }
        }
    }

    /// Smallest box along the axes around it.
    pub fn extents(&self) -> (V, V) {
        let around = |a: V, b: V, radius: f32| {
            let out = V::from_coordinates([radius; 3]);
            (a.min(b) - out, a.max(b) + out)
        };
        match *self {
            Self::Ball { centre, radius } => around(centre, centre, radius),
            Self::Capsule { from, to, radius } => around(from, to, radius),
            Self::Box { min, max } => (min, max),
        }
    }

    /// True where it and a box along the axes have a point in common, or nearly so.
    pub fn touches(&self, min: V, max: V) -> bool {
        let half = (max - min) * 0.5;
        match *self {
            Self::Ball { centre, radius } => Self::Box { min, max }.direction_and_distance(centre).1 <= radius,
            Self::Capsule { from, to, radius } => {
                // The distance from a box to a point of a line is convex along it.
                let solid = Self::Box { min, max };
                let at = |share: f32| solid.direction_and_distance(from + (to - from) * share).1;
                let (mut low, mut high) = (0.0f32, 1.0f32);
                for _ in 0..40 {
                    let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                    if at(a) <= at(b) { high = b } else { low = a }
                }
                at(0.5 * (low + high)).min(at(0.0)).min(at(1.0)) <= radius + 1e-3 * half.length()
            }
            Self::Box { min: low, max: high } => {
                let gap = (low - max).max(min - high).coordinates();
                gap.iter().take(V::DIMENSIONS).all(|&g| g <= 0.0)
            }
        }
    }
}

/// Convex bodies of an obstacle that stands; none for one that moves.
///
/// # Errors
/// [`throng_base::Error::Value`] where it has no body.
pub(crate) fn solids<V: Space>(n: usize, obstacle: &Obstacle<V>) -> Result<Vec<ConvexSolid<V>>> {
    let within = |radius: f32| radius > 0.0 && radius < 1e6;
    match obstacle {
        &Obstacle::Ball { centre, radius } => {
            let expected = "above 0 and below 1e6, around a centre that is finite";
            check("obstacle.radius", n, radius, centre.is_finite() && within(radius), expected)?;
            Ok(vec![ConvexSolid::Ball { centre, radius }])
        }
        Obstacle::Mover { path, radius } => {
            check("obstacle.radius", n, *radius, within(*radius), "above 0 and below 1e6")?;
            let good = !path.is_empty() && path.iter().all(|(t, x)| t.is_finite() && x.is_finite());
            check("obstacle.path", n, path.len() as f32, good, "at least 1 point, all of them finite")?;
            let late = path.windows(2).find(|w| w[1].0 <= w[0].0).map(|w| w[1].0 as f32);
            check("obstacle.path", n, late.unwrap_or(0.0), late.is_none(), "times that rise")?;
            Ok(Vec::new())
        }
        &Obstacle::Wall { from, to, radius } => {
            let good = from.is_finite() && to.is_finite() && (0.0..1e6).contains(&radius);
            check("obstacle.radius", n, radius, good, "between 0 and 1e6, around ends that are finite")?;
            Ok(vec![ConvexSolid::Capsule { from, to, radius }])
        }
        Obstacle::Polygon { corners } => {
            let num = corners.len() as f32;
            check("obstacle.corners", n, num, V::DIMENSIONS == 2, "a polygon on the ground; use boxes in the air")?;
            let good = corners.len() >= 3 && corners.iter().all(|c| c.is_finite());
            check("obstacle.corners", n, num, good, "at least 3 corners, all of them finite")?;
            let ends = corners.iter().zip(corners.iter().cycle().skip(1));
            Ok(ends.map(|(&from, &to)| ConvexSolid::Capsule { from, to, radius: 0.0 }).collect())
        }
        &Obstacle::Box { min, max } => {
            let size = (max - min).coordinates();
            let smallest = size.iter().take(V::DIMENSIONS).fold(f32::INFINITY, |a, &b| a.min(b));
            let good = min.is_finite() && max.is_finite() && smallest > 0.0;
            check("obstacle.max", n, smallest, good, "above min, both finite")?;
            Ok(vec![ConvexSolid::Box { min, max }])
        }
    }
}

/// True where a place is within a polygon on the ground.
pub(crate) fn is_inside<V: Space>(corners: &[V], x: V) -> bool {
    let on_plane = |v: V| {
        let [x, y, _] = v.coordinates();
        Vec2::new(x, y)
    };
    polygon_contains(corners.iter().map(|c| on_plane(*c)), on_plane(x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn solid() -> impl Strategy<Value = ConvexSolid<Vec2>> {
        let point = || [-5.0f32..5.0, -5.0f32..5.0].prop_map(Vec2::from_array);
        (0..3, point(), point(), 0.0f32..1.0).prop_map(|(kind, a, b, radius)| match kind {
            0 => ConvexSolid::Ball { centre: a, radius },
            1 => ConvexSolid::Capsule { from: a, to: b, radius },
            _ => ConvexSolid::Box { min: a.min(b), max: a.max(b) },
        })
    }

    proptest! {
        /// A plane through the nearest point has all of a convex body on one side.
        #[test]
        fn nearest_point_is_on_the_supporting_plane(s in solid(), x in [-9.0f32..9.0, -9.0f32..9.0]) {
            let x = Vec2::from_array(x);
            let (away, distance) = s.direction_and_distance(x);
            prop_assume!(distance > 0.01);
            prop_assert!((x.dot(away) - distance - s.reach(away)).abs() < 1e-3);
        }

        #[test]
        fn touches_what_holds_one_of_its_points(s in solid(), a in [-6.0f32..6.0, -6.0f32..6.0], size in 0.1f32..3.0) {
            let (min, max) = (Vec2::from_array(a), Vec2::from_array(a) + Vec2::splat(size));
            let points = (0..400).map(|i| min + Vec2::new((i % 20) as f32, (i / 20) as f32) * (size / 19.0));
            let any = points.clone().any(|p| s.direction_and_distance(p).1 <= 0.0);
            let near = points.clone().any(|p| s.direction_and_distance(p).1 <= 0.2 * size);
            prop_assert!(!any || s.touches(min, max));
            prop_assert!(near || !s.touches(min, max));
        }
    }

    #[test]
    fn all_of_a_long_wall_is_behind_the_plane_through_its_nearest_point() {
        for (from, to) in [([-500.0, -0.3], [500.0, -0.3]), ([-300.0, -400.0], [300.0, 400.0])] {
            let wall = ConvexSolid::Capsule { from: Vec2::from_array(from), to: Vec2::from_array(to), radius: 0.0 };
            let along = (Vec2::from_array(to) - Vec2::from_array(from)).normalize();
            for i in 0..1000 {
                let at = Vec2::from_array(from).lerp(Vec2::from_array(to), 0.3 + 0.000_41 * i as f32);
                let x = at + along.perp() * 0.3002;
                let (away, distance) = wall.direction_and_distance(x);
                // Half of the margin that the rule of safety keeps against rounding.
                assert!((x.dot(away) - wall.reach(away) - distance).abs() < 5e-5, "{x}: {away}, {distance} m");
            }
        }
    }
}
