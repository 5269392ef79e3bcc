//! Ways of the agents of a scene around what stands.

use super::group::GroupConfig;
use glam::{Vec3, Vec3Swizzles};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use throng_runtime::crowd::{NoWay, Obstacle, Space, Streets};

/// What ways keep from walls beyond the radius of agents, the least first. Agents take them in turn, so that they do not
/// pass corners in single file; where a gap is too narrow for more, they take the widest way that there is (m).
const MARGINS_M: [f32; 4] = [0.15, 0.3, 0.5, 0.8];

/// A wider way may be this much longer than the shortest .. (of its length).
const LONGER: f32 = 1.15;
/// ... and this much (m).
const LONGER_M: f32 = 2.0;

/// Route maps by clearance: groups of the same radius share them.
#[derive(Clone, Debug, Default)]
pub(super) struct RouteMaps {
    /// Of each group: its first map; those of greater clearance follow (groups, or 0 without maps).
    of_group: Vec<usize>,
    maps: Vec<Streets>,
}

impl RouteMaps {
    /// Maps for all groups; none where nothing stands in the way.
    ///
    /// - `heights`: lowest and highest that agents start (m).
    pub fn new<V: Space>(
        obstacles: &[Obstacle<V>],
        heights: [f32; 2],
        groups: &[GroupConfig],
    ) -> throng_base::Result<Self> {
        let obstacles: Vec<Obstacle> = obstacles.iter().map(|o| o.clone().map(V::to_world)).collect();
        let heights = (V::DIMENSIONS == 3).then_some(heights);
        let mut maps = Self::default();
        for group in groups {
            let least = group.radius_m[1] + MARGINS_M[0];
            let known = maps.maps.iter().step_by(MARGINS_M.len()).position(|m| m.clearance() == least);
            if let Some(known) = known {
                maps.of_group.push(known * MARGINS_M.len());
                continue;
            }
            let first = maps.maps.len();
            for margin in MARGINS_M {
                let map = Streets::with(&obstacles, heights, group.radius_m[1] + margin, group.radius_m[1])?;
                if map.is_open() {
                    return Ok(Self::default());
                }
                maps.maps.push(map);
            }
            maps.of_group.push(first);
        }
        Ok(maps)
    }

    /// Maps of a group, that of the least clearance first; `None` where nothing has to be gone around.
    fn of(&self, group: usize) -> Option<&[Streets]> {
        let first = *self.of_group.get(group)?;
        self.maps.get(first..first + MARGINS_M.len())
    }

    /// Corners of the way from one point to another, both included.
    ///
    /// # Errors
    /// [`NoWay`] at the least clearance.
    pub fn leg<V: Space>(&self, group: usize, agent: usize, from: V, to: V) -> Result<Vec<V>, NoWay> {
        let Some(maps) = self.of(group) else { return Ok(vec![from, to]) };
        let own = agent % maps.len();
        let (start, goal) = (from.to_world(), to.to_world());
        let least = maps[0].corners(start, goal)?;
        // A wider way must lead through the same gaps, not around the house.
        let longest = LONGER * length(&least) + LONGER_M;
        let wider = |m: &Streets| m.corners(start, goal).ok().filter(|w| length(w) <= longest);
        let own_way = maps[1..=own].iter().rev().find_map(wider);
        Ok(own_way.unwrap_or(least).into_iter().map(V::from_world).collect())
    }

    /// Points by chance between two corners, one after the other from a start: no obstacle is near them, and the way does not
    /// turn back at once. Where there is hardly such a point, one is taken as it is; where it is in an obstacle, its way will be
    /// refused.
    pub fn wander<V: Space>(
        &self,
        group: usize,
        start: V,
        (from, to, num): (&[f32], &[f32], usize),
        rng: &mut Pcg64Mcg,
    ) -> Vec<V> {
        const TRIES: usize = 200;
        let (mut at, mut before) = (start, V::default());
        let mut next = || {
            let mut point = at;
            for _ in 0..TRIES {
                let c: [f32; 3] = std::array::from_fn(|i| from.get(i).map_or(0.0, |&f| rng.random_range(f..to[i])));
                point = V::from_coordinates(c);
                let is_free = |m: &Streets| m.is_free(point.to_world());
                let turns_back = before.dot(point - at) < 0.0;
                if !turns_back && self.of(group).is_none_or(|maps| is_free(&maps[0])) {
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

/// Length over the ground (m).
fn length(way: &[Vec3]) -> f32 {
    way.windows(2).map(|w| w[0].xz().distance(w[1].xz())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn who_is_too_wide_for_a_gap_goes_through_it_all_the_same() {
        let wall =
            |from: f32, to: f32| Obstacle::Wall { from: Vec2::new(0.0, from), to: Vec2::new(0.0, to), radius: 0.0 };
        let text = "count = 1\nplace = { disc = { centre = [0.0, 0.0], density = 1.0 } }\ngoal = { stay = {} }\n";
        let group: GroupConfig = toml::from_str(text).unwrap();
        let maps = RouteMaps::new(&[wall(-90.0, -0.7), wall(0.7, 90.0)], [0.0; 2], &[group]).unwrap();
        let ways = [0, 1, 2, 3].map(|m| maps.leg(0, m, Vec2::new(-5.0, 3.0), Vec2::new(5.0, 3.0)).unwrap());
        assert!(ways.iter().all(|w| w.iter().all(|p| p.y.abs() < 4.0)), "{ways:?}");
        assert_ne!(ways[0], ways[1], "as wide as the gap allows");
    }

    #[test]
    fn ways_in_the_air_go_around_columns_and_rise_evenly() {
        let column = Obstacle::Wall { from: Vec3::ZERO, to: Vec3::new(0.0, 30.0, 0.0), radius: 1.0 };
        let low = Obstacle::Wall { from: Vec3::new(5.0, 0.0, 0.0), to: Vec3::new(5.0, 3.0, 0.0), radius: 1.0 };
        let text = "count = 1\nplace = { disc = { centre = [0.0, 0.0, 0.0], density = 1.0 } }\ngoal = { stay = {} }\n";
        let group: GroupConfig = toml::from_str(text).unwrap();
        let maps = RouteMaps::new(&[low, column], [5.0, 20.0], &[group.clone(), group]).unwrap();
        assert_eq!(maps.maps.len(), MARGINS_M.len(), "groups of the same radius share maps");
        let (from, to) = (Vec3::new(-9.0, 6.0, 0.0), Vec3::new(9.0, 16.0, 0.0));
        let lengths: Vec<f32> = (0..4)
            .map(|m| {
                let way = maps.leg(1, m, from, to).unwrap();
                assert!(way.len() > 2 && way[0] == from && way[way.len() - 1] == to, "{way:?}");
                assert!(way.windows(2).all(|w| w[0].y < w[1].y), "{way:?}");
                way.windows(2).map(|w| w[0].distance(w[1])).sum()
            })
            .collect();
        assert!(lengths.windows(2).all(|w| w[0] < w[1]), "every agent has its own clearance: {lengths:?}");
    }
}
