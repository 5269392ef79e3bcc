//! Shortest paths over convex polygons, any-angle: Polyanya.
//!
//! A node is a root, which is the start or a corner that the path bends at, and the part of an edge that is seen from the
//! root. Nodes are expanded over the polygon behind the edge, by their least possible length. Straight
//! lines estimate it (Cui, Harabor and Grastien, "Compromise-free Pathfinding on a Navigation Mesh", 2017). Lengths are those in the plane
//! of x and z.

use crate::{Level, LevelPoint, NONE};
use glam::{DVec2, Vec3, Vec3Swizzles};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Weight of what is left of a path against what is behind: paths are at most so many times longer than the shortest (Pohl 1970),
/// and a query that may take any of several equal ones does not look at all of them.
const WEIGHT: f64 = 1.02;
/// Rounding that a corner's distance may have (m).
const SLACK_M: f64 = 1e-7;
/// Distance from a vertex within which a ray goes to it (m).
const NEAR_VERTEX_M: f64 = 1e-4;
/// Rounding of areas (m^2).
const FLAT: f64 = 1e-8;
/// Largest number of nodes for each edge of a level; damaged levels may have no end.
const MOST_NODES: usize = 200;

/// Place that a path begins or bends at.
#[derive(Clone, Copy, Debug)]
struct PathRoot {
    at: DVec2,
    /// Vertex; [`NONE`] for the start.
    vertex: u32,
    before: u32,
    /// Length of the path so far (m).
    length: f64,
}

/// Part of an edge that is seen from a root.
#[derive(Clone, Copy, Debug)]
struct SeenInterval {
    root: u32,
    /// Polygon behind the edge, and the number of the edge as one of its own.
    polygon: u32,
    edge: u32,
    /// Right and left end, as seen from the root, and the vertices there; [`NONE`] between vertices.
    ends: [DVec2; 2],
    vertices: [u32; 2],
}

/// A node that waits for its turn.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WaitingNode {
    least: f64,
    node: u32,
}

impl Eq for WaitingNode {}

impl PartialOrd for WaitingNode {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for WaitingNode {
    /// The shortest comes first; of equal ones, that found last.
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least).then(self.node.cmp(&other.node))
    }
}

/// Target of a search.
#[derive(Clone, Copy, Debug)]
struct SearchTarget {
    at: DVec2,
    polygon: u32,
}

/// Memory of searches. Allocates until it is as large as the largest search.
#[derive(Clone, Debug, Default)]
pub(crate) struct LevelSearch {
    nodes: Vec<SeenInterval>,
    roots: Vec<PathRoot>,
    waiting: BinaryHeap<WaitingNode>,
    /// Search in which each vertex was reached last, and the length of the path to it (m).
    reached: Vec<(u32, f64)>,
    round: u32,
    fresh: Vec<SeenInterval>,
}

/// Position on the plane of x and z (m).
pub(crate) fn flat(at: Vec3) -> DVec2 {
    at.xz().as_dvec2()
}

impl LevelSearch {
    /// Finds the shortest path between places, and adds its corners after the start to `corners`. Returns its length (m).
    ///
    /// - `most_m`: none for paths that are longer (m).
    pub fn find_path(
        &mut self,
        level: &Level,
        [from, to]: [&LevelPoint; 2],
        most_m: f64,
        corners: &mut Vec<Vec3>,
    ) -> Option<f64> {
        let straight = flat(from.at).distance(flat(to.at));
        if from.polygon == to.polygon {
            corners.push(to.at);
            return Some(straight).filter(|&m| m <= most_m);
        }
        if level.component(from.polygon) != level.component(to.polygon) {
            return None;
        }
        let target = SearchTarget { at: flat(to.at), polygon: to.polygon };
        self.begin(level, from);
        let last = self.run(level, from.polygon, &target, most_m)?;
        let root = self.roots[last.root as usize];
        let (length, bend) = length_through(root.at, last.ends, target.at);
        let first = corners.len();
        corners.push(to.at);
        if let Some(end) = bend {
            corners.push(match last.vertices[end] {
                NONE => {
                    let at = last.ends[end].as_vec2();
                    Vec3::new(at.x, level.height_on(last.polygon, at), at.y)
                }
                vertex => level.0.vertices[vertex as usize].at.into(),
            });
        }
        let mut bent = &self.roots[last.root as usize];
        while bent.vertex != NONE {
            corners.push(level.0.vertices[bent.vertex as usize].at.into());
            bent = &self.roots[bent.before as usize];
        }
        corners[first..].reverse();
        Some(self.roots[last.root as usize].length + length)
    }

    fn begin(&mut self, level: &Level, from: &LevelPoint) {
        self.nodes.clear();
        self.roots.clear();
        self.waiting.clear();
        self.reached.resize(level.0.vertices.len(), (0, 0.0));
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.reached.fill((0, 0.0));
            self.round = 1;
        }
        self.roots.push(PathRoot { at: flat(from.at), vertex: NONE, before: NONE, length: 0.0 });
    }

    /// Expands nodes up to that by which the path ends.
    fn run(&mut self, level: &Level, start: u32, target: &SearchTarget, most_m: f64) -> Option<SeenInterval> {
        let (polygons, edges) = (&level.0.polygons, &level.0.edges);
        let own = polygons[start as usize];
        for k in 0..own.num_edges {
            let [a, b] = [k, (k + 1) % own.num_edges].map(|k| edges[(own.first_edge + k) as usize]);
            let (ends, vertices) = ([a, b].map(|e| level.flat(e.vertex)), [a, b].map(|e| e.vertex));
            let node = SeenInterval { root: 0, polygon: a.neighbour, edge: a.twin, ends, vertices };
            if a.neighbour != NONE && !self.is_dead_end(level, node.polygon, target) {
                self.wait(node, target, most_m);
            }
        }
        let mut left = MOST_NODES * edges.len();
        while let Some(WaitingNode { node, .. }) = self.waiting.pop() {
            let mut node = self.nodes[node as usize];
            if target.polygon == node.polygon {
                return Some(node);
            }
            loop {
                let root = self.roots[node.root as usize];
                let is_old = root.vertex != NONE && self.reached[root.vertex as usize].1 < root.length - SLACK_M;
                left = left.checked_sub(1)?;
                self.fresh.clear();
                if !is_old {
                    self.expand(level, &node, target);
                }
                // A corridor is followed without waiting.
                match self.fresh[..] {
                    [next] if target.polygon != next.polygon => node = next,
                    _ => break,
                }
            }
            for k in 0..self.fresh.len() {
                self.wait(self.fresh[k], target, most_m);
            }
        }
        None
    }

    fn is_dead_end(&self, level: &Level, polygon: u32, target: &SearchTarget) -> bool {
        target.polygon != polygon && level.0.polygons[polygon as usize].num_open < 2
    }

    /// Puts a node among those that wait, with the least length of a path by it.
    fn wait(&mut self, node: SeenInterval, target: &SearchTarget, most_m: f64) {
        let root = self.roots[node.root as usize];
        let left = length_through(root.at, node.ends, target.at).0;
        // In the target's own polygon the length is known.
        let least = root.length + if target.polygon == node.polygon { left } else { WEIGHT * left };
        if least <= most_m {
            self.waiting.push(WaitingNode { least, node: self.nodes.len() as u32 });
            self.nodes.push(node);
        }
    }

    /// Finds what is seen through a node on the far edges of its polygon, and what is reached round its ends.
    fn expand(&mut self, level: &Level, node: &SeenInterval, target: &SearchTarget) {
        let (polygon, edges) = (level.0.polygons[node.polygon as usize], &level.0.edges);
        let root = self.roots[node.root as usize];
        let rays = node.ends.map(|end| end - root.at);
        let is_left_root = rays[1].length_squared() < SLACK_M * SLACK_M;
        // Roots at the ends, made when they are needed; none where the path cannot bend, or others lead there.
        let mut bends: [Option<Option<u32>>; 2] = [None; 2];
        for k in 1..polygon.num_edges {
            let own = (node.edge - polygon.first_edge + k) % polygon.num_edges;
            let own_next = (own + 1) % polygon.num_edges;
            let [edge, next] = [own, own_next].map(|k| edges[(polygon.first_edge + k) as usize]);
            let vertices = [edge.vertex, next.vertex];
            let [u, v] = vertices.map(|vertex| level.flat(vertex));
            if edge.neighbour == NONE || self.is_dead_end(level, edge.neighbour, target) {
                continue;
            }
            // Shares of the edge at which the rays cross it.
            let [right, left] = [0, 1].map(|side| {
                let [a, b] = [u, v].map(|p| rays[side].perp_dot(p - root.at));
                match side {
                    // From the ray to its right: the edges of the polygon begin on it, and the root is on their line.
                    0 if a >= -FLAT => f64::from(u8::from(b < -FLAT)),
                    1 if is_left_root => 1.0,
                    1 if a > FLAT || a >= -FLAT && b > FLAT => 0.0,
                    _ if b <= FLAT => 1.0,
                    _ => a / (a - b),
                }
            });
            // Vertices of a straight wall are not quite on one line: a ray along it ends at the vertex, not beside it.
            let least = NEAR_VERTEX_M / (v - u).length();
            let [right, left] = [right, left].map(|share| match share {
                share if share < least => 0.0,
                share if share > 1.0 - least => 1.0,
                share => share,
            });
            let cut = |share: f64| match share {
                0.0 => (u, vertices[0]),
                1.0 => (v, vertices[1]),
                share => (u + (v - u) * share, NONE),
            };
            let left = left.max(right);
            for (part, [from, to]) in [[0.0, right], [right, left], [left, 1.0]].into_iter().enumerate() {
                if to <= from {
                    continue;
                }
                let root = match part {
                    1 => node.root,
                    _ => {
                        let side = part / 2;
                        let bend = bends[side].unwrap_or_else(|| self.bend_at(level, node, side));
                        bends[side] = Some(bend);
                        let Some(bend) = bend else { continue };
                        bend
                    }
                };
                let [(from, a), (to, b)] = [from, to].map(cut);
                if edge.neighbour != NONE {
                    let (polygon, ends, vertices) = (edge.neighbour, [from, to], [a, b]);
                    self.fresh.push(SeenInterval { root, polygon, edge: edge.twin, ends, vertices });
                }
            }
        }
    }

    /// Root at an end of a node; none where no shortest path bends there.
    fn bend_at(&mut self, level: &Level, node: &SeenInterval, side: usize) -> Option<u32> {
        let (at, vertex) = (node.ends[side], node.vertices[side]);
        if vertex == NONE || level.0.vertices[vertex as usize].is_corner == 0 {
            return None;
        }
        let before = self.roots[node.root as usize];
        let length = before.length + before.at.distance(at);
        let (round, best) = &mut self.reached[vertex as usize];
        if *round == self.round && *best < length - SLACK_M {
            return None;
        }
        *best = if *round == self.round { best.min(length) } else { length };
        *round = self.round;
        if before.vertex == vertex {
            return Some(node.root);
        }
        self.roots.push(PathRoot { at, vertex, before: node.root, length });
        Some(self.roots.len() as u32 - 1)
    }
}

/// Least length from a root through the part of an edge to a target behind it, and the end that the path bends at (m).
fn length_through(root: DVec2, ends: [DVec2; 2], target: DVec2) -> (f64, Option<usize>) {
    let [right, left] = ends;
    let line = left - right;
    let side = line.perp_dot(target - right);
    // Who comes back over the edge is as far as its mirror image.
    let target =
        if side > 0.0 { target - line.perp() * (2.0 * side / line.length_squared().max(1e-18)) } else { target };
    let to = target - root;
    let bend = if to.perp_dot(right - root) > FLAT {
        0
    } else if to.perp_dot(left - root) < -FLAT {
        1
    } else {
        return (to.length(), None);
    };
    (root.distance(ends[bend]) + ends[bend].distance(target), Some(bend))
}
