//! Regions on the ground: boxes in a grid, and the obstacles and reserved regions that one group of characters gets from others.

use glam::Vec2;

/// Side of a cell of a grid (m).
const CELL_M: f32 = 3.0;
const NONE: u32 = u32::MAX;

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds2d {
    /// Lowest x and z (m).
    pub min: Vec2,
    /// Highest x and z (m).
    pub max: Vec2,
}

impl Bounds2d {
    /// Empty box, which holds no point.
    pub const EMPTY: Self = Self { min: Vec2::INFINITY, max: Vec2::NEG_INFINITY };

    /// Bounding box of a disc.
    pub fn around_disc(centre: Vec2, radius_m: f32) -> Self {
        Self { min: centre, max: centre }.expanded_by(radius_m)
    }

    /// Box expanded by `by_m` on every side.
    pub fn expanded_by(self, by_m: f32) -> Self {
        Self { min: self.min - by_m, max: self.max + by_m }
    }

    /// Smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// True where the two boxes share a point.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

/// 2-D capsule: all points within a radius of a line segment; a disc where both ends are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Capsule2d {
    /// One end (m).
    pub from: Vec2,
    /// Other end (m).
    pub to: Vec2,
    /// Radius (m, >= 0).
    pub radius_m: f32,
}

impl Capsule2d {
    /// Bounding box.
    pub fn bounds(&self) -> Bounds2d {
        Bounds2d { min: self.from.min(self.to), max: self.from.max(self.to) }.expanded_by(self.radius_m)
    }

    /// Signed distance of a point from its surface, negative inside (m).
    pub fn distance_to(&self, place: Vec2) -> f32 {
        segment_distance_squared(self.from - place, self.to - place).sqrt() - self.radius_m
    }

    /// True where the two capsules overlap.
    pub fn intersects(&self, other: &Self) -> bool {
        let reach = self.radius_m + other.radius_m;
        distance_between_segments_squared([self.from, self.to], [other.from, other.to]) < reach * reach
    }
}

/// Squared distance of a line segment from the origin (m2).
pub fn segment_distance_squared(from: Vec2, to: Vec2) -> f32 {
    let offset = to - from;
    let share = (-from.dot(offset) / offset.length_squared().max(1e-12)).clamp(0.0, 1.0);
    (from + offset * share).length_squared()
}

/// Squared distance between two line segments (m2).
fn distance_between_segments_squared(a: [Vec2; 2], b: [Vec2; 2]) -> f32 {
    let side = |l: [Vec2; 2], p: Vec2| (l[1] - l[0]).perp_dot(p - l[0]);
    if side(a, b[0]) * side(a, b[1]) < 0.0 && side(b, a[0]) * side(b, a[1]) < 0.0 {
        return 0.0;
    }
    let to_line = |p: Vec2, l: [Vec2; 2]| segment_distance_squared(l[0] - p, l[1] - p);
    to_line(a[0], b).min(to_line(a[1], b)).min(to_line(b[0], a)).min(to_line(b[1], a))
}

/// Numbered boxes in a hash grid, found by region.
#[derive(Clone, Debug)]
pub struct BoxGrid {
    slots: Vec<BoxSlot>,
    /// First box of each bucket (a power of two).
    buckets: Vec<u32>,
    /// Largest half extent of any box along an axis (m).
    most_half_m: f32,
}

#[derive(Clone, Copy, Debug)]
struct BoxSlot {
    /// Bounds of the box; empty where there is none.
    bounds: Bounds2d,
    /// Next and previous boxes in its bucket.
    next: u32,
    before: u32,
}

const FREE: BoxSlot = BoxSlot { bounds: Bounds2d::EMPTY, next: NONE, before: NONE };

impl BoxGrid {
    /// Empty grid with room for `capacity` boxes; more boxes allocate memory.
    pub fn with_capacity(capacity: usize) -> Self {
        let buckets = (2 * capacity).next_power_of_two().max(16);
        Self { slots: Vec::with_capacity(capacity), buckets: vec![NONE; buckets], most_half_m: 0.0 }
    }

    /// Removes all boxes.
    pub fn clear(&mut self) {
        self.slots.clear();
        self.buckets.fill(NONE);
        self.most_half_m = 0.0;
    }

    /// Inserts a box, or replaces the one of that number.
    pub fn set(&mut self, number: usize, bounds: Bounds2d) {
        self.remove(number);
        if number >= self.slots.len() {
            self.slots.resize(number + 1, FREE);
            if 2 * self.slots.len() > self.buckets.len() {
                self.grow();
            }
        }
        self.slots[number] = BoxSlot { bounds, ..FREE };
        self.link(number);
    }

    /// Removes a box, if it is there.
    pub fn remove(&mut self, number: usize) {
        let Some(&BoxSlot { bounds, next, before }) = self.slots.get(number) else { return };
        if bounds == Bounds2d::EMPTY {
            return;
        }
        match before {
            NONE => {
                let bucket = self.bucket(cell_at(box_centre(&bounds)));
                self.buckets[bucket] = next;
            }
            before => self.slots[before as usize].next = next,
        }
        if next != NONE {
            self.slots[next as usize].before = before;
        }
        self.slots[number] = FREE;
    }

    /// Box of a number; [`Bounds2d::EMPTY`] where there is none.
    pub fn bounds(&self, number: usize) -> Bounds2d {
        self.slots.get(number).map_or(Bounds2d::EMPTY, |s| s.bounds)
    }

    /// Calls `found` for every box that intersects `bounds`, in no particular order, until it returns false.
    #[inline]
    pub fn visit_intersecting(&self, bounds: &Bounds2d, mut found: impl FnMut(usize) -> bool) {
        let wide = bounds.expanded_by(self.most_half_m);
        let (low, high) = (cell_at(wide.min), cell_at(wide.max));
        let mut is_found = |at: usize| !self.slots[at].bounds.intersects(bounds) || found(at);
        let size = [0, 1].map(|k| i64::from(high[k]) - i64::from(low[k]) + 1);
        if size[0].saturating_mul(size[1]) > 4 * self.slots.len() as i64 {
            // Fewer boxes than cells.
            (0..self.slots.len()).all(is_found);
            return;
        }
        // Cells of one bucket are met together: each box is found where its own cell is.
        for z in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let here = [x, z];
                let mut at = self.buckets[self.bucket(here)];
                while at != NONE {
                    let slot = &self.slots[at as usize];
                    if cell_at(box_centre(&slot.bounds)) == here && !is_found(at as usize) {
                        return;
                    }
                    at = slot.next;
                }
            }
        }
    }

    fn link(&mut self, number: usize) {
        let bounds = self.slots[number].bounds;
        self.most_half_m = self.most_half_m.max(0.5 * (bounds.max - bounds.min).max_element());
        let bucket = self.bucket(cell_at(box_centre(&bounds)));
        let next = self.buckets[bucket];
        self.slots[number] = BoxSlot { bounds, next, before: NONE };
        if next != NONE {
            self.slots[next as usize].before = number as u32;
        }
        self.buckets[bucket] = number as u32;
    }

    fn grow(&mut self) {
        let buckets = (4 * self.slots.len()).next_power_of_two();
        self.buckets.clear();
        self.buckets.resize(buckets, NONE);
        for number in 0..self.slots.len() {
            if self.slots[number].bounds != Bounds2d::EMPTY {
                self.link(number);
            }
        }
    }

    fn bucket(&self, [x, z]: [i32; 2]) -> usize {
        let hash = (x as u32).wrapping_mul(0x9E37_79B1) ^ (z as u32).wrapping_mul(0x85EB_CA77);
        (hash ^ hash >> 15) as usize & (self.buckets.len() - 1)
    }
}

fn box_centre(bounds: &Bounds2d) -> Vec2 {
    0.5 * (bounds.min + bounds.max)
}

/// Cell of a place. Whole negative numbers get a cell one lower than rounding down gives, which does no harm.
fn cell_at(place: Vec2) -> [i32; 2] {
    (place * (1.0 / CELL_M)).to_array().map(|v| (v as i32).saturating_sub(i32::from(v < 0.0)))
}

/// External obstacle: a body that another group moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExternalObstacle {
    /// Position of its centre (m).
    pub place: Vec2,
    /// Mean velocity (m/s).
    pub velocity: Vec2,
    /// Radius of its disc (m).
    pub radius_m: f32,
}

/// Bodies of one group of characters, and the regions that it reserves.
#[derive(Clone, Debug, Default)]
pub struct ReservedRegion {
    /// Bodies of the group.
    pub bodies: Vec<ExternalObstacle>,
    /// Reserved regions, which no other group may enter.
    pub ground: Vec<Capsule2d>,
}

impl ReservedRegion {
    /// Adds a body that stops for nobody, and reserves the ground that it may reach within a second.
    pub fn reserve_ahead(&mut self, body: ExternalObstacle) {
        self.bodies.push(body);
        self.ground.push(Capsule2d { from: body.place, to: body.place + body.velocity, radius_m: body.radius_m });
    }
}

/// External obstacles of one group: bodies of all other groups, to steer around, and their reserved regions, to keep out of.
///
/// Groups that keep out of the regions of others, and reserve all that they may need for their actions and for the stop after
/// them, never overlap each other.
#[derive(Clone, Debug)]
pub struct ExternalObstacles {
    bodies: Vec<ExternalObstacle>,
    reserved: Vec<Capsule2d>,
    body_grid: BoxGrid,
    reserved_grid: BoxGrid,
}

impl Default for ExternalObstacles {
    fn default() -> Self {
        let grid = || BoxGrid::with_capacity(0);
        Self { bodies: Vec::new(), reserved: Vec::new(), body_grid: grid(), reserved_grid: grid() }
    }
}

impl ExternalObstacles {
    /// Replaces all obstacles by the bodies and reserved regions of `others`.
    pub fn replace_all<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        if !self.is_empty() {
            self.bodies.clear();
            self.reserved.clear();
            self.body_grid.clear();
            self.reserved_grid.clear();
        }
        for other in others {
            for body in &other.bodies {
                self.body_grid.set(self.bodies.len(), Bounds2d::around_disc(body.place, body.radius_m));
                self.bodies.push(*body);
            }
            for ground in &other.ground {
                self.reserved_grid.set(self.reserved.len(), ground.bounds());
                self.reserved.push(*ground);
            }
        }
    }

    /// True where there are neither bodies nor reserved regions.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.reserved.is_empty()
    }

    /// Calls `found` for every body whose disc's box intersects `bounds`, in no particular order, until it returns false.
    pub fn visit_bodies_near(&self, bounds: &Bounds2d, mut found: impl FnMut(usize, &ExternalObstacle) -> bool) {
        if !self.bodies.is_empty() {
            self.body_grid.visit_intersecting(bounds, |n| found(n, &self.bodies[n]));
        }
    }

    /// Calls `found` for every reserved region whose box intersects `bounds`, in no particular order, until it returns false.
    pub fn visit_reserved_near(&self, bounds: &Bounds2d, mut found: impl FnMut(&Capsule2d) -> bool) {
        if !self.reserved.is_empty() {
            self.reserved_grid.visit_intersecting(bounds, |n| found(&self.reserved[n]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn boxes_beyond_all_cells_are_found() {
        let mut grid = BoxGrid::with_capacity(2);
        let boxes = [-1e14f32, 1e14].map(|x| Bounds2d::around_disc(Vec2::splat(x), 1.0));
        (0..2).for_each(|n| grid.set(n, boxes[n]));
        for (n, bounds) in boxes.iter().enumerate() {
            let mut found = Vec::new();
            grid.visit_intersecting(bounds, |n| {
                found.push(n);
                true
            });
            assert_eq!(found, [n]);
        }
    }

    proptest! {
        /// Against a list of all boxes, while boxes come, change and go.
        #[test]
        fn boxes_are_found_as_in_a_list(steps in proptest::collection::vec((0usize..40, -30.0f32..30.0, -30.0f32..30.0, 0.0f32..6.0, any::<bool>()), 1..120)) {
            let (mut grid, mut list) = (BoxGrid::with_capacity(4), [Bounds2d::EMPTY; 40]);
            for (number, x, z, half, stays) in steps {
                let bounds = Bounds2d::around_disc(Vec2::new(x, z), half);
                let mut found = Vec::new();
                grid.visit_intersecting(&bounds, |n| {
                    found.push(n);
                    true
                });
                found.sort_unstable();
                let wanted: Vec<usize> = (0..40).filter(|&n| list[n].intersects(&bounds)).collect();
                prop_assert_eq!(found, wanted);
                if stays {
                    grid.set(number, bounds);
                    list[number] = bounds;
                } else {
                    grid.remove(number);
                    list[number] = Bounds2d::EMPTY;
                }
                prop_assert_eq!(grid.bounds(number), list[number]);
            }
        }

        #[test]
        fn rods_meet_where_dense_sampling_says_so(a in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, 0.0f32..1.0], b in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0, 0.0f32..1.0]) {
            let capsule = |v: [f32; 5]| Capsule2d { from: Vec2::new(v[0], v[1]), to: Vec2::new(v[2], v[3]), radius_m: v[4] };
            let (a, b) = (capsule(a), capsule(b));
            let gap = (0..=400).map(|i| b.distance_to(a.from.lerp(a.to, i as f32 / 400.0)) - a.radius_m).fold(f32::INFINITY, f32::min);
            prop_assert_eq!(a.intersects(&b), b.intersects(&a));
            prop_assert!(gap >= 0.0 || a.intersects(&b), "{gap} m apart, and not seen");
            prop_assert!(gap <= 0.02 || !a.intersects(&b), "{gap} m apart, but seen");
            prop_assert!(!a.intersects(&b) || a.bounds().intersects(&b.bounds()));
        }
    }
}
