//! Ways of the members of a scene around what stands.

use super::group::GroupConfig;
use super::obstacle::{plan, solid_from_above};
use crate::route::{NoWay, RouteMap};
use glam::Vec2;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use throng_runtime::crowd::{Obstacle, Space};

/// What ways keep from walls beyond the radius of members, the least first. Members take them in turn, so that they do not
/// pass corners in single file; where a gap is too narrow for more, they take the widest way that there is. [Unit: m]
pub(super) const MARGINS_M: [f32; 4] = [0.15, 0.3, 0.5, 0.8];

/// Route maps by clearance: groups of the same radius share them.
#[derive(Clone, Debug, Default)]
pub(super) struct RouteMaps {
    /// Of each group: its first map; those of greater clearance follow. [Size: groups, or 0 without maps]
    of_group: Vec<usize>,
    maps: Vec<RouteMap>,
    /// Numbers of obstacles behind a map's solids.
    obstacles: Vec<usize>,
}

impl RouteMaps {
    /// Maps for all groups; none where nothing stands in the way.
    ///
    /// - `heights`: lowest and highest that members start. [Unit: m]
    pub fn new<V: Space>(obstacles: &[Obstacle<V>], heights: [f32; 2], groups: &[GroupConfig]) -> Self {
        let all = obstacles.iter().enumerate();
        let standing: Vec<_> = all.filter_map(|(i, o)| Some((i, solid_from_above(o, heights)?))).collect();
        let mut maps = Self { obstacles: standing.iter().map(|s| s.0).collect(), ..Self::default() };
        for group in groups.iter().filter(|_| !standing.is_empty()) {
            let least = group.radius_m[1] + MARGINS_M[0];
            let known = maps.maps.iter().step_by(MARGINS_M.len()).position(|m| m.clearance() == least);
            maps.of_group.push(known.map_or(maps.maps.len(), |k| k * MARGINS_M.len()));
            if known.is_none() {
                let solids = || standing.iter().map(|s| s.1.clone()).collect();
                let map = |margin: &f32| RouteMap::new(solids(), group.radius_m[1] + margin);
                maps.maps.extend(MARGINS_M.iter().map(map));
            }
        }
        maps
    }

    /// Maps of a group, that of the least clearance first; `None` where nothing has to be gone around.
    fn of(&mut self, group: usize) -> Option<&mut [RouteMap]> {
        let first = *self.of_group.get(group)?;
        self.maps.get_mut(first..first + MARGINS_M.len())
    }

    /// Number of the obstacle behind a solid of the maps.
    pub fn obstacle(&self, solid: usize) -> usize {
        self.obstacles[solid]
    }

    /// Corners of the way from one point to another, both included.
    ///
    /// # Errors
    /// [`NoWay`] at the least clearance.
    pub fn leg<V: Space>(&mut self, group: usize, member: usize, from: V, to: V) -> Result<Vec<V>, NoWay> {
        let Some(maps) = self.of(group) else { return Ok(vec![from, to]) };
        let own = member % maps.len();
        let wider = maps[1..=own].iter_mut().rev().find_map(|m| m.way(plan(from), plan(to)).ok());
        let flat = wider.map_or_else(|| maps[0].way(plan(from), plan(to)), Ok)?;
        Ok(lift(&flat, from, to))
    }

    /// A point by chance between two corners that no obstacle is near; one in an obstacle where there is hardly any other,
    /// to which there is no way then.
    pub fn free_point<V: Space>(&mut self, group: usize, (from, to): (&[f32], &[f32]), rng: &mut Pcg64Mcg) -> V {
        const TRIES: usize = 200;
        let mut at = V::default();
        for _ in 0..TRIES {
            let c: [f32; 3] = std::array::from_fn(|i| from.get(i).map_or(0.0, |&f| rng.random_range(f..to[i])));
            at = V::from_coordinates(c);
            let Some([map, ..]) = self.of(group) else { break };
            if map.is_clear(plan(at), plan(at), map.clearance()) {
                break;
            }
        }
        at
    }
}

/// A way on the ground at the heights between two ends.
fn lift<V: Space>(flat: &[Vec2], from: V, to: V) -> Vec<V> {
    if V::DIMENSIONS == 2 {
        return flat.iter().map(|p| V::from_coordinates([p.x, p.y, 0.0])).collect();
    }
    let legs = || flat.windows(2).map(|w| w[0].distance(w[1]));
    let all = legs().sum::<f32>().max(1e-6);
    let (low, high) = (from.coordinates()[1], to.coordinates()[1]);
    let mut gone = 0.0;
    let along = std::iter::once(0.0).chain(legs()).map(|leg| {
        gone += leg;
        gone / all
    });
    let place = |(p, share): (&Vec2, f32)| V::from_coordinates([p.x, low + (high - low) * share, p.y]);
    flat.iter().zip(along).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn ways_in_the_air_go_around_columns_and_rise_evenly() {
        let column = Obstacle::Wall { from: Vec3::ZERO, to: Vec3::new(0.0, 30.0, 0.0), radius: 1.0 };
        let low = Obstacle::Wall { from: Vec3::new(5.0, 0.0, 0.0), to: Vec3::new(5.0, 3.0, 0.0), radius: 1.0 };
        let text = "count = 1\nplace = { disc = { centre = [0.0, 0.0, 0.0], density = 1.0 } }\ngoal = { stay = {} }\n";
        let group: GroupConfig = toml::from_str(text).unwrap();
        let mut maps = RouteMaps::new(&[low, column], [5.0, 20.0], &[group.clone(), group]);
        assert_eq!(maps.maps.len(), MARGINS_M.len(), "groups of the same radius share maps");
        assert_eq!(maps.obstacle(0), 1, "what can be flown over is not planned around");
        let (from, to) = (Vec3::new(-9.0, 6.0, 0.0), Vec3::new(9.0, 16.0, 0.0));
        let lengths: Vec<f32> = (0..4)
            .map(|m| {
                let way = maps.leg(1, m, from, to).unwrap();
                assert!(way.len() > 2 && way[0] == from && way[way.len() - 1] == to, "{way:?}");
                assert!(way.windows(2).all(|w| w[0].y < w[1].y), "{way:?}");
                way.windows(2).map(|w| w[0].distance(w[1])).sum()
            })
            .collect();
        assert!(lengths.windows(2).all(|w| w[0] < w[1]), "every member has its own clearance: {lengths:?}");
    }
}
