//! Axis-aligned boxes, and a tree of them for nearest and overlap queries.

use glam::Vec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Lowest corner (m).
    pub min: Vec3,
    /// Highest corner (m).
    pub max: Vec3,
}

impl BoundingBox {
    /// Empty box.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around some points.
    pub fn around_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// True if the box holds no point.
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max).all())
    }

    /// Smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Box enlarged by `by` on every side (m).
    pub fn expanded(self, by: f32) -> Self {
        Self { min: self.min - by, max: self.max + by }
    }

    /// Centre of the box (m).
    pub fn centre(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// True if a point is inside or on the surface.
    pub fn contains(&self, p: Vec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    /// True if two boxes have a point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Distance from a point, 0 inside (m).
    pub fn distance(&self, p: Vec3) -> f32 {
        (self.min - p).max(p - self.max).max(Vec3::ZERO).length()
    }

    /// Box around this one, its corners mapped by a rigid transformation.
    pub fn mapped(&self, map: impl Fn(Vec3) -> Vec3) -> Self {
        if self.is_empty() { Self::EMPTY } else { Self::around_points(self.corners().map(map)) }
    }

    /// Corners: x varies fastest, then y, then z.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
            let (a, b) = (self.min, self.max);
            Vec3::new(pick(0, a.x, b.x), pick(1, a.y, b.y), pick(2, a.z, b.z))
        })
    }
}

/// Most items of a leaf.
const LEAF: usize = 4;

/// A tree over the bounds of numbered items.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundsTree {
    /// Nodes; the root is first.
    nodes: Vec<BoundsNode>,
    /// Items in the order of the leaves.
    items: Vec<u32>,
}

#[derive(Clone, Debug, PartialEq)]
struct BoundsNode {
    bounds: BoundingBox,
    /// First item of a leaf, or the first of its two children.
    first: u32,
    /// Number of items of a leaf; 0 for an inner node.
    count: u32,
}

impl BoundsTree {
    /// Tree over items with these bounds; items with empty bounds are never found.
    pub fn new(bounds: &[BoundingBox]) -> Self {
        let mut items: Vec<u32> = (0..bounds.len() as u32).filter(|&i| !bounds[i as usize].is_empty()).collect();
        let mut tree = Self { nodes: Vec::new(), items: Vec::new() };
        if !items.is_empty() {
            tree.nodes.push(BoundsNode { bounds: BoundingBox::EMPTY, first: 0, count: 0 });
            tree.fill_node(0, 0, &mut items, bounds);
        }
        tree.items = items;
        tree
    }

    /// Fills a node with `items`, which begin at index `first` of all.
    fn fill_node(&mut self, node: usize, first: usize, items: &mut [u32], bounds: &[BoundingBox]) {
        let all = items.iter().fold(BoundingBox::EMPTY, |b, &i| b.union(bounds[i as usize]));
        self.nodes[node].bounds = all;
        if items.len() <= LEAF {
            (self.nodes[node].first, self.nodes[node].count) = (first as u32, items.len() as u32);
            return;
        }
        let centres = BoundingBox::around_points(items.iter().map(|&i| bounds[i as usize].centre()));
        let extent = centres.max - centres.min;
        let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
        let key = |i: u32| bounds[i as usize].centre()[axis];
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        let child = self.nodes.len();
        self.nodes[node].first = child as u32;
        self.nodes.extend([(); 2].map(|()| BoundsNode { bounds: BoundingBox::EMPTY, first: 0, count: 0 }));
        let (low, high) = items.split_at_mut(middle);
        self.fill_node(child, first, low, bounds);
        self.fill_node(child + 1, first + middle, high, bounds);
    }

    /// Item with the least distance from `p`, if below `limit`, and that distance; on a tie the lower number.
    ///
    /// - `distance`: of an item, given its number and the least distance so far; not below that of its bounds for
    ///   points outside of them.
    pub fn nearest(&self, p: Vec3, limit: f32, mut distance: impl FnMut(usize) -> f32) -> Option<(usize, f32)> {
        let mut best: Option<(usize, f32)> = None;
        let mut stack = [0u32; 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            if is_out_of_reach(&node.bounds, p, best.map_or(limit, |b| b.1)) {
                continue;
            }
            if node.count == 0 {
                let (a, b) = (node.first, node.first + 1);
                let of = |i: u32| self.nodes[i as usize].bounds.distance(p);
                // The nearer child is pushed last, so it is visited first.
                let (far, near) = if of(a) <= of(b) { (b, a) } else { (a, b) };
                (stack[depth], stack[depth + 1]) = (far, near);
                depth += 2;
                continue;
            }
            for &item in &self.items[node.first as usize..(node.first + node.count) as usize] {
                let d = distance(item as usize);
                let closer = best.map_or(d < limit, |(i, b)| d < b || d == b && (item as usize) < i);
                if closer {
                    best = Some((item as usize, d));
                }
            }
        }
        best
    }

    /// Calls `visit` for every item of each leaf whose bounds overlap `bounds`, which may include near items that do
    /// not.
    pub fn overlapping(&self, bounds: &BoundingBox, mut visit: impl FnMut(usize)) {
        let mut stack: Vec<u32> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(i) = stack.pop() {
            let node = &self.nodes[i as usize];
            if !node.bounds.overlaps(bounds) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first + 1, node.first]);
            }
            let items = &self.items[node.first as usize..][..node.count as usize];
            items.iter().for_each(|&i| visit(i as usize));
        }
    }

    /// Bounds of all items.
    pub fn bounds(&self) -> BoundingBox {
        self.nodes.first().map_or(BoundingBox::EMPTY, |n| n.bounds)
    }
}

/// True if nothing in `bounds` can be nearer to `p` than `limit`. Inside, distances may be negative.
fn is_out_of_reach(bounds: &BoundingBox, p: Vec3, limit: f32) -> bool {
    let d = bounds.distance(p);
    d > 0.0 && d > limit
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-5.0f32..5.0).prop_map(Vec3::from)
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_a_scan_finds(
            centres in prop::collection::vec((point(), 0.0f32..1.0), 0..60), p in point(), limit in 0.1f32..9.0
        ) {
            let boxes: Vec<BoundingBox> =
                centres.iter().map(|(c, r)| BoundingBox { min: *c - *r, max: *c + *r }).collect();
            // Signed distances to balls: below 0 within.
            let distance = |i: usize| (p - centres[i].0).length() - centres[i].1;
            let tree = BoundsTree::new(&boxes);
            let found = tree.nearest(p, limit, distance);
            let scan = (0..boxes.len()).map(|i| (i, distance(i))).filter(|d| d.1 < limit);
            let scan = scan.min_by(|a, b| a.1.total_cmp(&b.1));
            prop_assert_eq!(found.map(|f| f.1), scan.map(|s| s.1));
            let mut seen = vec![false; boxes.len()];
            let around = BoundingBox { min: p - limit, max: p + limit };
            tree.overlapping(&around, |i| seen[i] = true);
            prop_assert!((0..boxes.len()).all(|i| seen[i] || !boxes[i].overlaps(&around)));
        }

        #[test]
        fn mapped_bounds_hold_the_mapped_box(
            a in point(), b in point(), at in point(), heading in -4.0f32..4.0, t in prop::array::uniform3(0.0f32..1.0)
        ) {
            let bounds = BoundingBox::around_points([a, b]);
            let inside = bounds.min + (bounds.max - bounds.min) * Vec3::from(t);
            let map = |p: Vec3| at + glam::Quat::from_rotation_y(heading) * p;
            prop_assert!(bounds.mapped(map).expanded(1e-4).contains(map(inside)));
        }
    }

    #[test]
    fn nothing_is_near_an_empty_tree() {
        let tree = BoundsTree::new(&[BoundingBox::EMPTY]);
        assert_eq!(tree.nearest(Vec3::ZERO, f32::INFINITY, |_| 0.0), None);
        assert!(tree.bounds().is_empty());
        tree.overlapping(&BoundingBox::around_points([Vec3::ZERO]), |_| panic!("nothing is there"));
    }
}
