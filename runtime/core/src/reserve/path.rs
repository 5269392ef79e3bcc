//! Predicted path: a disc whose centre moves from node to node, evenly in time, and stays at the last one for good.

use glam::Vec2;
use throng_base::ground::is_one_floor;
use throng_geometry::{Capsule2d, segment_distance_squared};

/// A place at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Zeroable)]
pub struct PathNode {
    /// Time since the path began (s).
    pub time_s: f32,
    /// Centre of the disc (m).
    pub place: Vec2,
    /// Radius of the disc from here on (m).
    pub radius_m: f32,
}

impl PathNode {
    /// A place at a time, and the radius from there on (s, m, m).
    pub fn new(time_s: f32, place: Vec2, radius_m: f32) -> Self {
        Self { time_s, place, radius_m }
    }
}

/// Path that has begun (at least one node).
#[derive(Clone, Copy, Debug)]
pub struct TimedPath<'a> {
    /// Nodes of the path, ascending in time.
    pub nodes: &'a [PathNode],
    /// Time since it began (s).
    pub elapsed_s: f32,
    /// Lowest and highest ground on it (m).
    pub heights_m: [f32; 2],
}

/// Most nodes that one capsule of a reserved region encloses.
const CAPSULE_NODES: usize = 6;

impl TimedPath<'_> {
    /// Largest number of capsules that a path of so many nodes reserves.
    pub fn max_reserved_regions(nodes: usize) -> usize {
        nodes.div_ceil(CAPSULE_NODES)
    }

    /// Number of the node after which the path is at a time since it began.
    fn node_before(&self, time_s: f32) -> usize {
        self.nodes.partition_point(|n| n.time_s <= time_s).saturating_sub(1)
    }

    /// Position at a time since the path began, which is after a node and not after the next one (s, m).
    fn position_at(&self, node: usize, time_s: f32) -> Vec2 {
        let from = self.nodes[node];
        match self.nodes.get(node + 1) {
            Some(to) if time_s > from.time_s => {
                from.place.lerp(to.place, ((time_s - from.time_s) / (to.time_s - from.time_s)).min(1.0))
            }
            _ => from.place,
        }
    }

    /// Position now (m).
    pub fn position_now(&self) -> Vec2 {
        self.position_at(self.node_before(self.elapsed_s), self.elapsed_s)
    }

    /// True for a path on other floors.
    pub fn is_on_other_floors(&self, other: &TimedPath<'_>) -> bool {
        !is_one_floor(self.heights_m, other.heights_m)
    }

    /// True where the discs of the two come nearer to each other than `room_m`, or deeper into each other than `-room_m`, at any
    /// time from now on (m).
    pub fn meets_path(&self, other: &TimedPath<'_>, room_m: f32) -> bool {
        if self.is_on_other_floors(other) {
            return false;
        }
        let (mut i, mut j) = (self.node_before(self.elapsed_s), other.node_before(other.elapsed_s));
        let (mut p, mut q) = (self.position_at(i, self.elapsed_s), other.position_at(j, other.elapsed_s));
        loop {
            // Time from now until either path reaches its next node.
            let left =
                |m: &TimedPath<'_>, k: usize| m.nodes.get(k + 1).map_or(f32::INFINITY, |n| n.time_s - m.elapsed_s);
            let (to_p, to_q) = (left(self, i), left(other, j));
            let until_s = to_p.min(to_q);
            let reach = (self.nodes[i].radius_m + other.nodes[j].radius_m + room_m).max(0.0);
            if until_s == f32::INFINITY {
                return p.distance_squared(q) < reach * reach;
            }
            let (next_p, next_q) =
                (self.position_at(i, self.elapsed_s + until_s), other.position_at(j, other.elapsed_s + until_s));
            if segment_distance_squared(p - q, next_p - next_q) < reach * reach {
                return true;
            }
            i += usize::from(to_p <= until_s);
            j += usize::from(to_q <= until_s);
            (p, q) = (next_p, next_q);
        }
    }

    /// True where it meets what stands, at any time from now on.
    pub fn meets_capsule(&self, capsule: &Capsule2d) -> bool {
        self.capsules().any(|own| own.intersects(capsule))
    }

    /// Adds the region that it reserves from now on: a few capsules, each around some of its nodes.
    pub fn add_reserved_regions(&self, out: &mut Vec<Capsule2d>) {
        let mut around: Option<(Capsule2d, usize)> = None;
        let mut places = [Vec2::ZERO; CAPSULE_NODES];
        for capsule in self.capsules() {
            let (whole, n) = around.get_or_insert((Capsule2d { to: capsule.from, ..capsule }, 0));
            places[*n] = capsule.to;
            *n += 1;
            whole.radius_m = whole.radius_m.max(capsule.radius_m);
            whole.to = capsule.to;
            if *n == CAPSULE_NODES {
                out.push(widen_capsule(*whole, &places[..*n]));
                around = None;
            }
        }
        out.extend(around.map(|(whole, n)| widen_capsule(whole, &places[..n])));
    }

    /// Capsules of all ground that it covers from now on, from node to node.
    pub fn capsules(&self) -> impl Iterator<Item = Capsule2d> + '_ {
        let first = self.node_before(self.elapsed_s);
        let mut from = self.position_now();
        (first..self.nodes.len()).map(move |k| {
            let to = self.nodes.get(k + 1).map_or(from, |n| n.place);
            Capsule2d { from: std::mem::replace(&mut from, to), to, radius_m: self.nodes[k].radius_m }
        })
    }
}

/// Capsule that also holds its discs about some places.
fn widen_capsule(capsule: Capsule2d, places: &[Vec2]) -> Capsule2d {
    let line = Capsule2d { radius_m: 0.0, ..capsule };
    let off = places.iter().map(|p| line.distance_to(*p)).fold(0.0, f32::max);
    Capsule2d { radius_m: capsule.radius_m + off, ..capsule }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reserve::bounds;
    use proptest::prelude::*;

    fn timed(nodes: &[PathNode], elapsed_s: f32) -> TimedPath<'_> {
        TimedPath { nodes, elapsed_s, heights_m: [0.0; 2] }
    }

    fn path() -> impl Strategy<Value = (Vec<PathNode>, f32)> {
        let node = (0.05f32..1.0, -3.0f32..3.0, -3.0f32..3.0, 0.1f32..0.6);
        (proptest::collection::vec(node, 1..8), 0.0f32..4.0).prop_map(|(steps, elapsed)| {
            let mut time_s = 0.0;
            let node = |(i, (dt, x, z, radius)): (usize, (f32, f32, f32, f32))| {
                time_s += if i == 0 { 0.0 } else { dt };
                PathNode::new(time_s, Vec2::new(x, z), radius)
            };
            (steps.into_iter().enumerate().map(node).collect(), elapsed)
        })
    }

    /// Centre and radius of the disc at a time.
    fn disc(nodes: &[PathNode], time_s: f32) -> (Vec2, f32) {
        for w in nodes.windows(2) {
            if time_s < w[1].time_s {
                let share = ((time_s - w[0].time_s) / (w[1].time_s - w[0].time_s)).max(0.0);
                return (w[0].place.lerp(w[1].place, share), w[0].radius_m);
            }
        }
        let last = nodes[nodes.len() - 1];
        (last.place, last.radius_m)
    }

    proptest! {
        #[test]
        fn held_ground_holds_all_discs((a, elapsed_s) in path()) {
            let mut held = Vec::new();
            timed(&a, elapsed_s).add_reserved_regions(&mut held);
            for k in 0..900 {
                let (at, radius) = disc(&a, elapsed_s + k as f32 * 1e-2);
                let least = held.iter().map(|capsule| capsule.distance_to(at)).fold(f32::INFINITY, f32::min);
                prop_assert!(least <= -radius + 1e-4, "{} m beyond", least + radius);
            }
        }

        #[test]
        fn paths_meet_where_dense_sampling_says_so((a, ea) in path(), (b, eb) in path()) {
            let (p, q) = (timed(&a, ea), timed(&b, eb));
            let gap = |k: i32| {
                let ((at, ra), (bt, rb)) = (disc(&a, ea + k as f32 * 1e-3), disc(&b, eb + k as f32 * 1e-3));
                at.distance(bt) - ra - rb
            };
            let (meets, gap) = (p.meets_path(&q, 0.0), (0..9000).map(gap).fold(f32::INFINITY, f32::min));
            prop_assert_eq!(meets, q.meets_path(&p, 0.0));
            prop_assert!(gap >= 0.0 || meets, "{gap} m apart, and not seen");
            // Between two samples the discs come nearer by no more than both can move.
            prop_assert!(gap <= 0.3 || !meets, "{gap} m apart, but seen");
            prop_assert!(gap >= 0.0 || bounds(&a).intersects(&bounds(&b)));
        }

        #[test]
        fn walls_are_met_where_dense_sampling_says_so((a, ea) in path(), ends in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0]) {
            let wall = Capsule2d { from: Vec2::new(ends[0], ends[1]), to: Vec2::new(ends[2], ends[3]), radius_m: 0.1 };
            let to_wall = |p: Vec2| (0..=300).map(|i| wall.from.lerp(wall.to, i as f32 / 300.0).distance(p)).fold(f32::INFINITY, f32::min);
            let gap = |k: i32| {
                let (at, radius) = disc(&a, ea + k as f32 * 1e-2);
                to_wall(at) - radius - 0.1
            };
            let (meets, gap) = (timed(&a, ea).meets_capsule(&wall), (0..900).map(gap).fold(f32::INFINITY, f32::min));
            prop_assert!(gap >= 0.0 || meets, "{gap} m apart, and not seen");
            prop_assert!(gap <= 1.7 || !meets, "{gap} m apart, but seen");
        }
    }
}
