//! Complete linkage of items for which only near pairs are known, with estimated distances.

/// A neighbouring item and its distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Neighbour {
    pub item: u32,
    /// Lower bound of the largest distance between a frame of one item and a frame of the other (rad).
    pub linkage: f32,
    /// True if `linkage` is as good as [`Distance::estimate`] gives it.
    pub estimated: bool,
}

/// Distance between items.
pub(super) trait Distance {
    /// A group of frames.
    type Item;

    /// Lower estimate of the largest distance between a frame of `a` and one of `b`; `None` if even that is too large
    /// to merge.
    fn estimate(&self, a: &Self::Item, b: &Self::Item) -> Option<f32>;
    /// Merges two items; returns both unchanged if the largest distance between a frame of `a` and one of `b` is too
    /// large.
    fn join(&self, a: Self::Item, b: Self::Item) -> Result<Self::Item, [Self::Item; 2]>;
}

/// Merges items as long as there are near pairs, the nearest pair first.
///
/// - `neighbours`: for every item those that may be near enough to merge, ascending by item; symmetric.
/// - returns the remaining items, with the frames of merged ones.
///
/// Items joined by complete linkage are near in every pair, so other pairs can be forgotten: this is the whole
/// hierarchy below the height of the limit. The search follows nearest neighbours until two are each other's, which
/// gives the merges of "nearest pair first" in another order, ties aside. Estimates decide which neighbour is nearest,
/// and are made only if the outcome depends on them; exact distances of frames decide whether two items may merge.
pub fn merge_items<D: Distance>(items: Vec<D::Item>, neighbours: Vec<Vec<Neighbour>>, distance: &D) -> Vec<D::Item> {
    let items = items.into_iter().map(Some).collect();
    let mut links = NeighbourLinks { items, neighbours, distance };
    let mut chain: Vec<u32> = Vec::new();
    let mut next = 0;
    while next < links.items.len() {
        let Some(&top) = chain.last() else {
            if links.items[next].is_some() && !links.neighbours[next].is_empty() {
                chain.push(next as u32);
            } else {
                next += 1;
            }
            continue;
        };
        let before = chain.len().checked_sub(2).map(|k| chain[k]);
        match links.nearest(top, before) {
            None => {
                chain.pop();
            }
            Some(n) if Some(n.item) == before => {
                chain.pop();
                if links.merge(top, n.item) {
                    chain.pop();
                }
            }
            Some(n) => chain.push(n.item),
        }
    }
    links.items.into_iter().flatten().collect()
}

struct NeighbourLinks<'a, D: Distance> {
    /// Given items, then merged ones; `None` for an item that was merged into another.
    items: Vec<Option<D::Item>>,
    /// May still list items that were merged (items.len()).
    neighbours: Vec<Vec<Neighbour>>,
    distance: &'a D,
}

impl<D: Distance> NeighbourLinks<'_, D> {
    /// Nearest neighbour, with an estimated linkage; of equally near ones `preferred`, else the first.
    fn nearest(&mut self, of: u32, preferred: Option<u32>) -> Option<Neighbour> {
        let mut near = std::mem::take(&mut self.neighbours[of as usize]);
        near.retain(|n| self.items[n.item as usize].is_some());
        let key = |n: &Neighbour| (n.linkage, Some(n.item) != preferred);
        let nearest = loop {
            let best = near.iter().min_by(|a, b| {
                let (a, b) = (key(a), key(b));
                a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
            });
            let Some(n) = best.copied() else { break None };
            if n.estimated {
                break Some(n);
            }
            let found = match (&self.items[of as usize], &self.items[n.item as usize]) {
                (Some(a), Some(b)) => self.distance.estimate(a, b),
                _ => None,
            };
            set_linkage(&mut near, n.item, found);
            set_linkage(&mut self.neighbours[n.item as usize], of, found);
        };
        self.neighbours[of as usize] = near;
        nearest
    }

    /// Merges two items; if they are too far apart, removes their pair and returns false.
    fn merge(&mut self, a: u32, b: u32) -> bool {
        let pair = [a, b].map(|i| self.items[i as usize].take());
        let joined = match pair {
            [Some(a), Some(b)] => self.distance.join(a, b),
            pair => {
                [self.items[a as usize], self.items[b as usize]] = pair;
                return false;
            }
        };
        let all = match joined {
            Ok(all) => all,
            Err(pair) => {
                [self.items[a as usize], self.items[b as usize]] = pair.map(Some);
                set_linkage(&mut self.neighbours[a as usize], b, None);
                set_linkage(&mut self.neighbours[b as usize], a, None);
                return false;
            }
        };
        let merged = self.items.len() as u32;
        let [a, b] = [a, b].map(|i| std::mem::take(&mut self.neighbours[i as usize]));
        let mut common = common_neighbours(&a, &b);
        common.retain(|n| self.items[n.item as usize].is_some());
        common.iter().for_each(|n| self.neighbours[n.item as usize].push(Neighbour { item: merged, ..*n }));
        self.items.push(Some(all));
        self.neighbours.push(common);
        true
    }
}

/// Updates the linkage to one of an item's neighbours.
fn set_linkage(near: &mut Vec<Neighbour>, item: u32, linkage: Option<f32>) {
    match (near.binary_search_by_key(&item, |n| n.item), linkage) {
        (Ok(k), Some(linkage)) => (near[k].linkage, near[k].estimated) = (linkage, true),
        (Ok(k), None) => _ = near.remove(k),
        (Err(_), _) => {}
    }
}

/// Common neighbours of two items, each with the larger of the two linkages.
fn common_neighbours(a: &[Neighbour], b: &[Neighbour]) -> Vec<Neighbour> {
    let mut out = Vec::new();
    let mut rest = b.iter().peekable();
    for n in a {
        while rest.next_if(|m| m.item < n.item).is_some() {}
        if let Some(m) = rest.next_if(|m| m.item == n.item) {
            let estimated = n.estimated && m.estimated;
            out.push(Neighbour { item: n.item, linkage: n.linkage.max(m.linkage), estimated });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of which all distances are known, and how much of them is known roughly.
    struct Known<F> {
        distance: F,
        from_below: f32,
        limit: f32,
    }

    /// Frames and their diameter.
    type Group = (Vec<u32>, f32);

    impl<F: Fn(u32, u32) -> f32> Distance for Known<F> {
        type Item = Group;

        fn estimate(&self, a: &Group, b: &Group) -> Option<f32> {
            let first = (self.distance)(a.0[0], b.0[0]) * self.from_below;
            Some(first).filter(|&d| d < self.limit)
        }

        fn join(&self, a: Group, b: Group) -> Result<Group, [Group; 2]> {
            let pairs = a.0.iter().flat_map(|&f| b.0.iter().map(move |&g| (f, g)));
            let height = pairs.map(|(f, g)| (self.distance)(f, g)).fold(0.0, f32::max);
            if height < self.limit { Ok(([a.0, b.0].concat(), height.max(a.1).max(b.1))) } else { Err([a, b]) }
        }
    }

    /// Frames and diameter of what is left of `n` frames.
    fn linked(n: u32, known: &Known<impl Fn(u32, u32) -> f32>) -> Vec<Group> {
        let roughly = |i: u32, j: u32| known.from_below * (known.distance)(i, j);
        let row = |i: u32| {
            let near = (0..n).filter(|&j| j != i && roughly(i, j) < known.limit);
            near.map(|j| Neighbour { item: j, linkage: 0.5 * roughly(i, j), estimated: false }).collect()
        };
        let items = (0..n).map(|f| (vec![f], 0.0)).collect();
        let mut left = merge_items(items, (0..n).map(row).collect(), known);
        left.iter_mut().for_each(|(frames, _)| frames.sort_unstable());
        left.sort_by(|a, b| a.0.cmp(&b.0));
        left
    }

    #[test]
    fn merges_on_a_line_are_those_worked_out_by_hand() {
        // 0 1 . . 3.5 . 6: first 0-1 at 1, then 3.5-6 at 2.5, then all at 6.
        let x = [0.0f32, 1.0, 3.5, 6.0];
        for from_below in [1.0, 0.9] {
            let distance = |i, j| (x[i as usize] - x[j as usize]).abs();
            let left = |limit| linked(4, &Known { distance, from_below, limit });
            assert_eq!(left(7.0), [(vec![0, 1, 2, 3], 6.0)]);
            let pairs = [(vec![0, 1], 1.0), (vec![2, 3], 2.5)];
            assert_eq!(left(6.0), pairs, "at the limit itself nothing merges");
            assert_eq!(left(2.6), pairs);
            assert_eq!(left(2.5), [(vec![0, 1], 1.0), (vec![2], 0.0), (vec![3], 0.0)]);
        }
    }

    #[test]
    fn equal_distances_end_too() {
        assert_eq!(linked(9, &Known { distance: |_, _| 1.0, from_below: 0.9, limit: 2.0 }), [((0..9).collect(), 1.0)]);
        assert_eq!(linked(0, &Known { distance: |_, _| 1.0, from_below: 0.9, limit: 2.0 }), []);
    }

    #[test]
    fn estimates_that_are_far_too_small_cost_groups_but_not_the_promise() {
        let x: Vec<f32> = (0..40).map(|k| (k as f32 * 1.7).sin() * 5.0).collect();
        let distance = |i: u32, j: u32| (x[i as usize] - x[j as usize]).abs();
        let left = linked(40, &Known { distance, from_below: 0.3, limit: 1.0 });
        assert_eq!(left.iter().map(|(frames, _)| frames.len()).sum::<usize>(), 40);
        for (frames, diameter) in left {
            let widest = frames.iter().flat_map(|&i| frames.iter().map(move |&j| (i, j)));
            assert_eq!(widest.map(|(i, j)| distance(i, j)).fold(0.0, f32::max), diameter);
            assert!(diameter < 1.0);
        }
    }
}
