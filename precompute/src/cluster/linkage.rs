//! Complete linkage of items of which only near pairs are known, and those only from below.

use super::neighbours::Item;

/// Another item, and how far away it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Neighbour {
    pub item: u32,
    /// Largest distance between a frame of one item and a frame of the other, or less. [Unit: rad]
    pub linkage: f32,
    /// True where `linkage` is that distance and not less.
    pub exact: bool,
}

/// Merges items as long as there are near pairs, the nearest pair first.
///
/// - `neighbours`: for every item the ones that may be near enough to merge, ascending by item; `a` among those of `b`
///   wherever `b` is among those of `a`.
/// - `linkage`: of two items, none where it is too large to merge.
/// - returns what is left, with the frames of what was merged.
///
/// What complete linkage joins must be near in every pair, so pairs that are not near can be forgotten: this is the
/// whole hierarchy below the height that "near" stands for. Items are followed from nearest neighbour to nearest
/// neighbour until two are each other's, which gives the merges of "nearest pair first" in another order, ties aside.
/// Linkages are worked out only where the nearest neighbour depends on them.
pub(super) fn link(
    items: Vec<Item>,
    neighbours: Vec<Vec<Neighbour>>,
    linkage: impl Fn(&Item, &Item) -> Option<f32>,
) -> Vec<Item> {
    let items = items.into_iter().map(Some).collect();
    let mut links = Links { items, neighbours, linkage };
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
                chain.truncate(chain.len() - 2);
                links.merge(top, n);
            }
            Some(n) => chain.push(n.item),
        }
    }
    links.items.into_iter().flatten().collect()
}

struct Links<F> {
    /// Items and, behind those given, what was merged; none where an item has gone into another.
    items: Vec<Option<Item>>,
    /// Items that are gone may still be among them. [Size: items.len()]
    neighbours: Vec<Vec<Neighbour>>,
    linkage: F,
}

impl<F: Fn(&Item, &Item) -> Option<f32>> Links<F> {
    /// The nearest neighbour, of equally near ones `preferred`, else the first. Its linkage is exact.
    fn nearest(&mut self, of: u32, preferred: Option<u32>) -> Option<Neighbour> {
        let mut near = std::mem::take(&mut self.neighbours[of as usize]);
        near.retain(|n| self.items[n.item as usize].is_some());
        let key = |n: &Neighbour| (n.linkage, Some(n.item) != preferred);
        let nearest = loop {
            let best = near.iter().enumerate().min_by(|(_, a), (_, b)| {
                let (a, b) = (key(a), key(b));
                a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
            });
            let Some((k, n)) = best.map(|(k, n)| (k, *n)) else { break None };
            if n.exact {
                break Some(n);
            }
            let found = match (&self.items[of as usize], &self.items[n.item as usize]) {
                (Some(a), Some(b)) => (self.linkage)(a, b),
                _ => None,
            };
            match found {
                Some(linkage) => (near[k].linkage, near[k].exact) = (linkage, true),
                None => {
                    near.remove(k);
                }
            }
            self.tell(n.item, of, found);
        };
        self.neighbours[of as usize] = near;
        nearest
    }

    /// Lets an item know the linkage of another one.
    fn tell(&mut self, item: u32, of: u32, linkage: Option<f32>) {
        let near = &mut self.neighbours[item as usize];
        if let Ok(k) = near.binary_search_by_key(&of, |n| n.item) {
            match linkage {
                Some(linkage) => (near[k].linkage, near[k].exact) = (linkage, true),
                None => {
                    near.remove(k);
                }
            }
        }
    }

    /// Makes one new item of two.
    fn merge(&mut self, a: u32, b: Neighbour) {
        let merged = self.items.len() as u32;
        let mut all = Item { frames: Vec::new(), diameter: b.linkage };
        for item in [a, b.item].into_iter().filter_map(|i| self.items[i as usize].take()) {
            all.frames.extend(item.frames);
            all.diameter = all.diameter.max(item.diameter);
        }
        self.items.push(Some(all));
        let [a, b] = [a, b.item].map(|i| std::mem::take(&mut self.neighbours[i as usize]));
        let mut common = common(&a, &b);
        common.retain(|n| self.items[n.item as usize].is_some());
        for n in &common {
            self.neighbours[n.item as usize].push(Neighbour { item: merged, ..*n });
        }
        self.neighbours.push(common);
    }
}

/// What is near to both of two items, as far away as from the farther one.
fn common(a: &[Neighbour], b: &[Neighbour]) -> Vec<Neighbour> {
    let mut out = Vec::new();
    let mut rest = b.iter().peekable();
    for n in a {
        while rest.next_if(|m| m.item < n.item).is_some() {}
        if let Some(m) = rest.next_if(|m| m.item == n.item) {
            let exact = n.exact && m.exact;
            out.push(Neighbour { item: n.item, linkage: n.linkage.max(m.linkage), exact });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn farthest(a: &Item, b: &Item, distance: impl Fn(u32, u32) -> f32) -> f32 {
        a.frames
            .iter()
            .flat_map(|&f| b.frames.iter().map(move |&g| (f, g)))
            .map(|(f, g)| distance(f, g))
            .fold(0.0, f32::max)
    }

    /// Frames and diameter of what is left of `n` frames.
    fn linked(n: u32, distance: impl Fn(u32, u32) -> f32, known_from_below: f32, limit: f32) -> Vec<(Vec<u32>, f32)> {
        let row = |i: u32| {
            let near = (0..n).filter(|&j| j != i && known_from_below * distance(i, j) < limit);
            near.map(|j| Neighbour { item: j, linkage: known_from_below * distance(i, j), exact: false }).collect()
        };
        let items = (0..n).map(|f| Item { frames: vec![f], diameter: 0.0 }).collect();
        let left =
            link(items, (0..n).map(row).collect(), |a, b| Some(farthest(a, b, &distance)).filter(|&d| d < limit));
        let mut left: Vec<_> = left.into_iter().map(|i| (i.frames, i.diameter)).collect();
        left.iter_mut().for_each(|(frames, _)| frames.sort_unstable());
        left.sort_by(|a, b| a.0.cmp(&b.0));
        left
    }

    #[test]
    fn merges_on_a_line_are_those_worked_out_by_hand() {
        // 0 1 . . 3.5 . 6: first 0-1 at 1, then 3.5-6 at 2.5, then all at 6.
        let x = [0.0f32, 1.0, 3.5, 6.0];
        for known in [1.0, 0.5, 0.0] {
            let left = |limit| linked(4, |i, j| (x[i as usize] - x[j as usize]).abs(), known, limit);
            assert_eq!(left(7.0), [(vec![0, 1, 2, 3], 6.0)]);
            let pairs = [(vec![0, 1], 1.0), (vec![2, 3], 2.5)];
            assert_eq!(left(6.0), pairs, "at the limit itself nothing merges");
            assert_eq!(left(2.6), pairs);
            assert_eq!(left(2.5), [(vec![0, 1], 1.0), (vec![2], 0.0), (vec![3], 0.0)]);
        }
    }

    #[test]
    fn equal_distances_end_too() {
        assert_eq!(linked(9, |_, _| 1.0, 0.9, 2.0), [((0..9).collect(), 1.0)]);
        assert_eq!(linked(0, |_, _| 1.0, 0.9, 2.0), []);
    }
}
