//! Paths of the agents of a scene around fixed obstacles.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use throng_crowd::{NoPath, Obstacle, Space, Streets};

/// Clearance of paths from walls beyond the largest radius of agents (m).
const MARGIN_M: f32 = 0.15;
/// Half of the narrowest gap that messages name (m).
const NARROWEST_M: f32 = 0.02;

/// Map of a scene for path finding.
#[derive(Clone, Debug, Default)]
pub(super) struct RouteMap {
    /// Streets without doors, as if all were open; `None` where there are no obstacles.
    pub streets: Option<Streets>,
    /// Streets with doors, for agents that are on their way.
    pub with_doors: Option<Streets>,
    /// Clearance of paths from obstacles (m).
    clearance: f32,
    /// Lowest and highest starts of agents in the air (m).
    heights: Option<[f32; 2]>,
}

impl RouteMap {
    /// - `first_door`: number of the first door among the obstacles.
    /// - `heights`: lowest and highest starts of agents (m).
    /// - `radius`: largest radius of agents (m).
    pub fn new<V: Space>(
        obstacles: &[Obstacle<V>],
        first_door: usize,
        heights: [f32; 2],
        radius: f32,
    ) -> throng_base::Result<Self> {
        let obstacles: Vec<Obstacle> = obstacles.iter().map(|o| o.clone().map(V::to_world)).collect();
        let heights = (V::DIMENSIONS == 3).then_some(heights);
        let clearance = radius + MARGIN_M;
        let streets = |of: &[Obstacle]| -> throng_base::Result<Option<Streets>> {
            let streets = Streets::with_limits(of, heights, clearance, radius)?;
            Ok(Some(streets).filter(|s| !s.is_open()))
        };
        let free = streets(&obstacles[..first_door])?;
        let with_doors = if first_door < obstacles.len() { streets(&obstacles)? } else { free.clone() };
        Ok(Self { streets: free, with_doors, clearance, heights })
    }

    /// Corners of the shortest path from one point to another, both included.
    ///
    /// # Errors
    /// [`NoPath`].
    pub fn shortest_path<V: Space>(&self, from: V, to: V) -> Result<Vec<V>, NoPath> {
        let Some(streets) = &self.streets else { return Ok(vec![from, to]) };
        Ok(streets.corners(from.to_world(), to.to_world())?.into_iter().map(V::from_world).collect())
    }

    /// Width of the widest gap on any path from one point to another, and the width that the largest agent needs; `None` where
    /// there is no path at all (m).
    pub fn widest_gap<V: Space>(&self, from: V, to: V) -> Option<[f32; 2]> {
        let obstacles = self.streets.as_ref()?.obstacles();
        let leads = |clearance: f32| {
            let streets = Streets::with_limits(obstacles, self.heights, clearance, 0.0);
            streets.is_ok_and(|s| s.corners(from.to_world(), to.to_world()).is_ok())
        };
        let (mut low, mut high) = (NARROWEST_M, self.clearance);
        if !leads(low) {
            return None;
        }
        while high - low > 0.001 {
            let middle = 0.5 * (low + high);
            if leads(middle) { low = middle } else { high = middle }
        }
        Some([2.0 * low, 2.0 * self.clearance])
    }

    /// Random points between two corners, one after the other from a start: no obstacle and no door is near them, and the path does not
    /// turn back at once. Where no such point is found, the last try is taken; where it is in an obstacle, planning its path
    /// fails.
    pub fn random_points<V: Space>(&self, start: V, [from, to]: [&[f32]; 2], num: usize, rng: &mut Pcg64Mcg) -> Vec<V> {
        const TRIES: usize = 200;
        let (mut at, mut before) = (start, V::default());
        let mut next = || {
            let mut point = at;
            for _ in 0..TRIES {
                let c: [f32; 3] = std::array::from_fn(|i| from.get(i).map_or(0.0, |&f| rng.random_range(f..to[i])));
                point = V::from_coordinates(c);
                let turns_back = before.dot(point - at) < 0.0;
                if !turns_back && self.with_doors.as_ref().is_none_or(|s| s.is_free(point.to_world())) {
                    break;
                }
            }
            before = point - at;
            at = point;
            point
        };
        (0..num).map(|_| next()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn ways_in_the_air_go_around_columns_and_rise_evenly() {
        let column = Obstacle::Wall { from: Vec3::ZERO, to: Vec3::new(0.0, 30.0, 0.0), radius: 1.0 };
        let low = Obstacle::Wall { from: Vec3::new(5.0, 0.0, 0.0), to: Vec3::new(5.0, 3.0, 0.0), radius: 1.0 };
        let map = RouteMap::new(&[low, column], 2, [5.0, 20.0], 0.3).unwrap();
        let (from, to) = (Vec3::new(-9.0, 6.0, 0.0), Vec3::new(9.0, 16.0, 0.0));
        let path = map.shortest_path(from, to).unwrap();
        assert!(path.len() > 2 && path[0] == from && path[path.len() - 1] == to, "{path:?}");
        assert!(path.windows(2).all(|w| w[0].y < w[1].y), "{path:?}");
    }
}
