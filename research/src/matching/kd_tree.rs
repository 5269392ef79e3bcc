//! Search through a k-d tree: rows parted again and again where they spread most.

use super::boxes::bounding_box;
use super::distance::{Nearest, to_box, to_row};
use super::features::{Row, WIDTH};
use throng_core::simd::vectorize;

/// Rows in a leaf, at most.
const LEAF: usize = 32;
/// Nodes that wait on the way down, at most: one a level.
const MAX_WAITING: usize = 64;

/// A k-d tree whose nodes keep the box around their rows. Exact: finds what [`super::brute_force`] finds.
#[derive(Clone, Debug)]
pub struct KdTree {
    /// In the order of the leaves.
    rows: Vec<Row>,
    /// Number of each row before it was put there.
    numbers: Vec<u32>,
    /// The root is the last one.
    nodes: Vec<KdNode>,
}

#[derive(Clone, Debug)]
struct KdNode {
    bounds: [Row; 2],
    kind: NodeKind,
}

#[derive(Clone, Copy, Debug)]
enum NodeKind {
    /// Rows from, and up to.
    Leaf(u32, u32),
    /// Two nodes.
    Inner(u32, u32),
}

impl KdTree {
    /// Parts rows at the median of the number that spreads most, until few are left.
    pub fn new(rows: &[Row]) -> Self {
        let numbers: Vec<u32> = (0..rows.len() as u32).collect();
        let mut tree = Self { rows: Vec::with_capacity(rows.len()), numbers: Vec::new(), nodes: Vec::new() };
        let mut order = numbers;
        if !rows.is_empty() {
            tree.part(rows, &mut order);
        }
        tree
    }

    /// Adds a node over some rows; returns its number. Depth is the logarithm of their number.
    fn part(&mut self, all: &[Row], order: &mut [u32]) -> u32 {
        let rows: Vec<Row> = order.iter().map(|&i| all[i as usize]).collect();
        let bounds = bounding_box(&rows);
        let kind = if order.len() <= LEAF {
            let first = self.rows.len() as u32;
            self.rows.extend_from_slice(&rows);
            self.numbers.extend_from_slice(order);
            NodeKind::Leaf(first, self.rows.len() as u32)
        } else {
            let spread = |k: &usize| bounds[1][*k] - bounds[0][*k];
            let widest = (0..WIDTH).max_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(0);
            let value = |i: &u32| all[*i as usize][widest];
            let middle = order.len() / 2;
            order.select_nth_unstable_by(middle, |a, b| value(a).total_cmp(&value(b)).then(a.cmp(b)));
            let (low, high) = order.split_at_mut(middle);
            NodeKind::Inner(self.part(all, low), self.part(all, high))
        };
        self.nodes.push(KdNode { bounds, kind });
        self.nodes.len() as u32 - 1
    }

    /// The nearest row that is nearer than what the search begins with.
    pub fn find(&self, query: &Row, nearest: Nearest) -> Nearest {
        vectorize(
            #[inline(always)]
            || self.walk(query, nearest),
        )
    }

    #[inline(always)]
    fn walk(&self, query: &Row, mut nearest: Nearest) -> Nearest {
        let mut waiting = [(0.0f32, 0u32); MAX_WAITING];
        let mut len = 0usize;
        let Some(root) = self.nodes.len().checked_sub(1) else { return nearest };
        let mut at = Some((0.0, root as u32));
        while let Some((distance, node)) = at.take().or_else(|| {
            len = len.checked_sub(1)?;
            Some(waiting[len])
        }) {
            // As near as what was found may still have a lower number.
            if distance > nearest.distance {
                continue;
            }
            match self.nodes[node as usize].kind {
                NodeKind::Leaf(first, end) => {
                    for i in first as usize..end as usize {
                        let distance = to_row(query, &self.rows[i], nearest.distance);
                        nearest.offer(self.numbers[i], distance);
                    }
                }
                NodeKind::Inner(a, b) => {
                    let [da, db] = [a, b].map(|n| {
                        let [low, high] = &self.nodes[n as usize].bounds;
                        to_box(query, low, high, nearest.distance)
                    });
                    let (near, far) = if da <= db { ((da, a), (db, b)) } else { ((db, b), (da, a)) };
                    waiting[len] = far;
                    len += 1;
                    at = Some(near);
                }
            }
        }
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::super::boxes::BoxSearch;
    use super::super::distance::brute_force;
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Rows that wander, as frames do, on coarse steps, so that some are equally far from a query.
    fn wandering(count: usize, steps: u32, rng: &mut Pcg64) -> Vec<Row> {
        let mut row = [0.0; WIDTH];
        (0..count)
            .map(|_| {
                for v in &mut row[..43] {
                    *v += 0.5 * (rng.random_range(0..2 * steps + 1) as f32 - steps as f32);
                }
                row
            })
            .collect()
    }

    proptest! {
        #[test]
        fn searches_find_what_looking_at_every_row_finds(seed in any::<u64>(), count in 1usize..700, steps in 0u32..4) {
            let mut rng = Pcg64::seed_from_u64(seed);
            let rows = wandering(count, steps, &mut rng);
            let (boxes, tree) = (BoxSearch::new(&rows), KdTree::new(&rows));
            let mut query = rows[rng.random_range(0..count)];
            for far in [0.0f32, 0.5, 20.0] {
                query[..43].iter_mut().for_each(|v| *v += far * rng.random_range(-1.0..1.0f32));
                let all = brute_force(&rows, &query, Nearest::within(f32::INFINITY));
                let expected = rows.iter().map(|r| r.iter().zip(&query).map(|(a, b)| (a - b) * (a - b)).sum::<f32>());
                let least = expected.fold(f32::INFINITY, f32::min);
                prop_assert!((all.distance - least).abs() <= 1e-5 * least, "{} {}", all.distance, least);
                for from in [f32::INFINITY, all.distance * 1.5 + 0.1, all.distance, all.distance * 0.5] {
                    let expected = brute_force(&rows, &query, Nearest::within(from));
                    prop_assert_eq!(boxes.find(&query, Nearest::within(from)), expected);
                    prop_assert_eq!(tree.find(&query, Nearest::within(from)), expected);
                }
            }
        }
    }

    #[test]
    fn finds_nothing_where_there_is_nothing() {
        let none = Nearest::within(f32::INFINITY);
        assert_eq!(KdTree::new(&[]).find(&[0.0; WIDTH], none), none);
        assert_eq!(BoxSearch::new(&[]).find(&[0.0; WIDTH], none), none);
    }
}
