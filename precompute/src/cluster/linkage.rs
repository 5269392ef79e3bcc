//! Complete linkage of items of which only near pairs are known.

/// Another item, and how far away it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Neighbour {
    pub item: u32,
    /// Largest distance between a frame of one item and a frame of the other. [Unit: rad]
    pub linkage: f32,
}

/// A tree of merges.
///
/// Items 0 to n - 1 are those given; item n + k is the k-th merge.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Merges {
    /// The two items of each merge.
    pub pairs: Vec<[u32; 2]>,
    /// Linkage of each merge. [Size: pairs.len()]
    pub heights: Vec<f32>,
}

/// Merges items as long as there are near pairs, the nearest pair first.
///
/// - `neighbours`: for every item the ones that are near enough to merge, ascending by item; `a` among those of `b`
///   wherever `b` is among those of `a`.
///
/// What complete linkage joins must be near in every pair, so pairs that are not near can be forgotten: this is the
/// whole hierarchy below the height that "near" stands for. Items are followed from nearest neighbour to nearest
/// neighbour until two are each other's, which gives the merges of "nearest pair first" in another order, ties aside.
pub(super) fn link(mut neighbours: Vec<Vec<Neighbour>>) -> Merges {
    let mut merges = Merges::default();
    let num_items = neighbours.len() as u32;
    let mut alive = vec![true; neighbours.len()];
    let mut chain: Vec<u32> = Vec::new();
    let mut next = 0;
    while next < alive.len() {
        let Some(&top) = chain.last() else {
            if alive[next] && !neighbours[next].is_empty() {
                chain.push(next as u32);
            } else {
                next += 1;
            }
            continue;
        };
        neighbours[top as usize].retain(|n| alive[n.item as usize]);
        let before = chain.len().checked_sub(2).map(|k| chain[k]);
        let Some(nearest) = nearest(&neighbours[top as usize], before) else {
            chain.pop();
            continue;
        };
        if Some(nearest.item) != before {
            chain.push(nearest.item);
            continue;
        }
        chain.truncate(chain.len() - 2);
        let merged = num_items + merges.pairs.len() as u32;
        let [a, b] = [top, nearest.item].map(|i| {
            alive[i as usize] = false;
            std::mem::take(&mut neighbours[i as usize])
        });
        let common = common(&a, &b, &alive);
        for n in &common {
            neighbours[n.item as usize].push(Neighbour { item: merged, linkage: n.linkage });
        }
        neighbours.push(common);
        alive.push(true);
        merges.pairs.push([top.min(nearest.item), top.max(nearest.item)]);
        merges.heights.push(nearest.linkage);
    }
    merges
}

/// The nearest, of equally near ones `preferred`, else the first.
fn nearest(neighbours: &[Neighbour], preferred: Option<u32>) -> Option<Neighbour> {
    let key = |n: &Neighbour| (n.linkage, Some(n.item) != preferred);
    neighbours.iter().copied().min_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal))
}

/// What is near to both of two items, as far away as from the farther one.
fn common(a: &[Neighbour], b: &[Neighbour], alive: &[bool]) -> Vec<Neighbour> {
    let mut out = Vec::new();
    let mut rest = b.iter().peekable();
    for n in a.iter().filter(|n| alive[n.item as usize]) {
        while rest.next_if(|m| m.item < n.item).is_some() {}
        if let Some(m) = rest.next_if(|m| m.item == n.item) {
            out.push(Neighbour { item: n.item, linkage: n.linkage.max(m.linkage) });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near_pairs(n: usize, distance: impl Fn(usize, usize) -> f32, limit: f32) -> Vec<Vec<Neighbour>> {
        let row = |i: usize| {
            let near = (0..n).filter(|&j| j != i && distance(i, j) < limit);
            near.map(|j| Neighbour { item: j as u32, linkage: distance(i, j) }).collect()
        };
        (0..n).map(row).collect()
    }

    #[test]
    fn merges_on_a_line_are_those_worked_out_by_hand() {
        // 0 1 . . 3.5 . 6: first 0-1 at 1, then 3.5-6 at 2.5, then all at 6.
        let x = [0.0f32, 1.0, 3.5, 6.0];
        let merges = |limit| link(near_pairs(4, |i, j| (x[i] - x[j]).abs(), limit));
        let all = merges(7.0);
        assert_eq!(all.pairs, [[0, 1], [2, 3], [4, 5]]);
        assert_eq!(all.heights, [1.0, 2.5, 6.0]);
        assert_eq!(merges(6.0).heights, [1.0, 2.5], "at the limit itself nothing merges");
        assert_eq!(merges(2.0).pairs, [[0, 1]]);
    }

    #[test]
    fn equal_distances_end_too() {
        let merges = link(near_pairs(9, |_, _| 1.0, 2.0));
        assert_eq!(merges.heights, [1.0; 8]);
        assert_eq!(link(Vec::new()), Merges::default());
    }
}
