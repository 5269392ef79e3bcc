//! The visibility graph.

use super::solid::Solid;
use glam::Vec2;
use petgraph::algo::astar;
use petgraph::graph::{NodeIndex, UnGraph};

/// Ways around solids that keep a clearance.
#[derive(Clone, Debug)]
pub struct RouteMap {
    solids: Vec<Solid>,
    bounds: Vec<(Vec2, Vec2)>,
    clearance: f32,
    /// Points to go around corners by, joined where they see each other; lengths in metres.
    graph: UnGraph<Vec2, f32>,
}

/// Why there is no way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoWay {
    /// The start is in that solid.
    Start(usize),
    /// The goal is in that solid, or nearer to it than the clearance.
    Goal(usize),
    /// What stands separates the two, or leaves no gap that is wide enough.
    Separated,
}

impl RouteMap {
    /// Prepares ways.
    ///
    /// - `clearance`: that centres keep from everything. [Unit: m] [Limit: > 0]
    pub fn new(solids: Vec<Solid>, clearance: f32) -> Self {
        let bounds = solids.iter().map(Solid::bounds).collect();
        let mut map = Self { solids, bounds, clearance, graph: UnGraph::default() };
        let around: Vec<Vec2> = map.solids.iter().flat_map(|s| s.points_around(clearance)).collect();
        for p in around {
            if map.is_clear(p, p, clearance) {
                map.join(p, clearance);
            }
        }
        map
    }

    /// Clearance that ways keep. [Unit: m]
    pub fn clearance(&self) -> f32 {
        self.clearance
    }

    /// What ways lead around.
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// The shortest way, with both its ends. It keeps the clearance, but near a start that is nearer to a solid it keeps as
    /// much as the start has.
    ///
    /// # Errors
    /// [`NoWay`].
    pub fn way(&mut self, from: Vec2, to: Vec2) -> Result<Vec<Vec2>, NoWay> {
        if let Some(i) = self.solids.iter().position(|s| s.distance(from) <= 0.0) {
            return Err(NoWay::Start(i));
        }
        if let Some(i) = self.solids.iter().position(|s| s.distance(to) < self.clearance) {
            return Err(NoWay::Goal(i));
        }
        // A hair less, so that rounding does not close the way out.
        let at_start = self.solids.iter().map(|s| s.distance(from)).fold(self.clearance, f32::min) * 0.999;
        if self.is_clear(from, to, at_start) {
            return Ok(vec![from, to]);
        }
        let goal = self.join(to, self.clearance);
        let start = self.join(from, at_start);
        let way = astar(&self.graph, start, |n| n == goal, |e| *e.weight(), |n| self.graph[n].distance(to));
        let points = way.map(|(_, nodes)| nodes.into_iter().map(|n| self.graph[n]).collect());
        // The last two, in this order: removing the last one moves no other.
        self.graph.remove_node(start);
        self.graph.remove_node(goal);
        points.ok_or(NoWay::Separated)
    }

    /// Adds a point, joined with all that it sees.
    fn join(&mut self, p: Vec2, clearance: f32) -> NodeIndex {
        let new = self.graph.add_node(p);
        for other in self.graph.node_indices().filter(|&n| n != new).collect::<Vec<_>>() {
            let q = self.graph[other];
            if self.is_clear(p, q, clearance) {
                self.graph.add_edge(new, other, p.distance(q));
            }
        }
        new
    }

    /// True where a straight line keeps a clearance from everything.
    pub fn is_clear(&self, a: Vec2, b: Vec2, clearance: f32) -> bool {
        let (low, high) = (a.min(b) - clearance, a.max(b) + clearance);
        let is_near = |(l, h): &(Vec2, Vec2)| l.cmple(high).all() && h.cmpge(low).all();
        let mut near = self.solids.iter().zip(&self.bounds).filter(|(_, b)| is_near(b));
        near.all(|(s, _)| s.distance_of_line(a, b) >= clearance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BinaryHeap;
    use std::f32::consts::{FRAC_PI_2, SQRT_2};

    fn length(way: &[Vec2]) -> f32 {
        way.windows(2).map(|w| w[0].distance(w[1])).sum()
    }

    fn wall(from: [f32; 2], to: [f32; 2]) -> Solid {
        Solid::Wall { from: from.into(), to: to.into(), radius: 0.0 }
    }

    /// Length of the shortest way over a fine grid whose steps keep the clearance: brute force.
    fn over_grid(map: &RouteMap, from: Vec2, to: Vec2, half: f32, step: f32) -> Option<f32> {
        let n = (2.0 * half / step) as i32 + 1;
        let at = |i: i32| Vec2::new((i % n) as f32, (i / n) as f32) * step - half;
        let index = |p: Vec2| {
            let c = ((p + half) / step).round();
            c.y as i32 * n + c.x as i32
        };
        // Sixteen directions: ways over a grid are at most 3 % longer than straight ones.
        let mut moves = Vec::new();
        for dx in -2i32..=2 {
            for dz in -2i32..=2 {
                let is_primitive = (dx.abs(), dz.abs()) != (2, 2) && (dx, dz) != (0, 0) && dx.abs() + dz.abs() != 2
                    || (dx.abs(), dz.abs()) == (1, 1);
                if is_primitive {
                    moves.push((dx, dz));
                }
            }
        }
        let mut best = vec![f32::INFINITY; (n * n) as usize];
        let mut open = BinaryHeap::from([(std::cmp::Reverse(0u64), index(from))]);
        best[index(from) as usize] = 0.0;
        while let Some((_, i)) = open.pop() {
            if i == index(to) {
                return Some(best[i as usize]);
            }
            for (dx, dz) in &moves {
                let (x, z) = (i % n + dx, i / n + dz);
                if x < 0 || z < 0 || x >= n || z >= n {
                    continue;
                }
                let j = z * n + x;
                let then = best[i as usize] + at(i).distance(at(j));
                if then < best[j as usize] - 1e-5 && map.is_clear(at(i), at(j), map.clearance) {
                    best[j as usize] = then;
                    open.push((std::cmp::Reverse((then * 1e4) as u64), j));
                }
            }
        }
        None
    }

    #[test]
    fn ways_are_as_short_as_brute_force_finds_and_keep_the_clearance() {
        let scenes = [
            vec![wall([0.0, -3.0], [0.0, 2.0])],
            vec![wall([-1.0, -9.0], [-1.0, 2.0]), wall([1.5, -2.0], [1.5, 9.0])],
            vec![
                Solid::Polygon(
                    [[-1.0, -2.0], [1.0, -2.5], [2.0, 2.0], [0.0, 0.5], [-2.0, 3.0]].map(Vec2::from).to_vec(),
                ),
                Solid::Wall { from: Vec2::new(0.0, 4.5), to: Vec2::new(0.0, 4.5), radius: 0.8 },
            ],
        ];
        for (s, solids) in scenes.into_iter().enumerate() {
            let mut map = RouteMap::new(solids, 0.4);
            for (from, to) in [([-4.0, 0.0], [4.0, 0.0]), ([-4.0, -4.0], [4.0, 3.0]), ([-4.0, 2.0], [3.0, -1.0])] {
                let (from, to) = (Vec2::from(from), Vec2::from(to));
                let way = map.way(from, to).unwrap();
                assert_eq!((way[0], way[way.len() - 1]), (from, to));
                for leg in way.windows(2) {
                    assert!(map.is_clear(leg[0], leg[1], 0.399), "scene {s}: {leg:?}");
                }
                let brute = over_grid(&map, from, to, 6.0, 0.1).expect("a way over the grid");
                assert!(length(&way) <= 1.01 * brute, "scene {s}: {} against {brute}", length(&way));
                assert!(length(&way) >= 0.95 * brute, "scene {s}: {} against {brute}", length(&way));
            }
        }
    }

    /// Around the end of a wall: a tangent, an arc, a tangent.
    #[test]
    fn the_way_around_a_wall_s_end_is_hardly_longer_than_the_shortest() {
        let mut map = RouteMap::new(vec![wall([0.0, -50.0], [0.0, 0.0])], 1.0);
        let reach = SQRT_2;
        let way = map.way(Vec2::new(-reach, 0.0), Vec2::new(reach, 0.0)).unwrap();
        let exact = 2.0 * 1.0 + FRAC_PI_2;
        assert!(length(&way) >= exact && length(&way) < 1.05 * exact, "{} against {exact}", length(&way));
    }

    #[test]
    fn what_can_be_seen_is_gone_to_straight() {
        let mut map = RouteMap::new(vec![wall([0.0, -3.0], [0.0, -1.0])], 0.4);
        let ends = [Vec2::new(-2.0, 0.0), Vec2::new(2.0, 0.0)];
        assert_eq!(map.way(ends[0], ends[1]), Ok(ends.to_vec()));
        let nodes = map.graph.node_count();
        map.way(Vec2::new(-2.0, -2.0), Vec2::new(2.0, -2.0)).unwrap();
        assert_eq!(map.graph.node_count(), nodes, "ends are taken out again");
    }

    #[test]
    fn gaps_that_are_too_narrow_and_goals_in_walls_are_told() {
        let gap = |half: f32| vec![wall([0.0, -9.0], [0.0, -half]), wall([0.0, half], [0.0, 9.0])];
        let room = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0], [-9.0, -9.0]];
        let around = || room.windows(2).map(|w| wall(w[0], w[1]));
        let (from, to) = (Vec2::new(-3.0, 4.0), Vec2::new(3.0, 1.0));
        let wide = RouteMap::new(gap(0.6).into_iter().chain(around()).collect(), 0.5).way(from, to);
        assert!(wide.unwrap().len() > 2);
        let narrow = RouteMap::new(gap(0.4).into_iter().chain(around()).collect(), 0.5).way(from, to);
        assert_eq!(narrow, Err(NoWay::Separated));
        let block = Solid::Polygon([[2.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 2.0]].map(Vec2::from).to_vec());
        let mut map = RouteMap::new(vec![block], 0.5);
        assert_eq!(map.way(from, to), Err(NoWay::Goal(0)));
        assert_eq!(map.way(to, from), Err(NoWay::Start(0)));
        assert_eq!(map.way(from, Vec2::new(4.2, 1.0)), Err(NoWay::Goal(0)), "nearer than the clearance");
        assert!(map.way(Vec2::new(4.2, 1.0), from).is_ok(), "one who stands at the wall gets away from it");
    }
}
