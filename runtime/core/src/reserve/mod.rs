//! Reservations: the ground that everybody needs until the end of what they do and for the stop that may follow.
//!
//! Whoever takes a new path takes one that meets no other. All paths end in a place to stay at for good, so that nobody
//! ever has to leave the path they have: whatever anybody wants, no two discs overlap (the argument of the event-driven
//! crowds of Kim, Kim and Shin 2003, section 2, for motion that cannot be stopped at once).

mod path;

use glam::Vec2;
pub use path::{Bounds, Moving, PathNode, Wall};

/// Side of a cell of the grid in which paths are found (m).
const CELL_M: f32 = 3.0;
const NONE: u32 = u32::MAX;

/// The paths of all who are on the ground, by number.
///
/// All memory is allocated in [`Reservations::with_capacity`], but for walls.
#[derive(Clone, Debug)]
pub struct Reservations {
    /// Most nodes of a path.
    room: usize,
    nodes: Vec<PathNode>,
    slots: Vec<Slot>,
    /// First path of each cell; cells share buckets (a power of two).
    buckets: Vec<u32>,
    /// No path reaches farther than this from the middle of its box along an axis (m).
    most_half_m: f32,
    walls: Vec<(Wall, Bounds)>,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    num_nodes: u32,
    bounds: Bounds,
    elapsed_s: f32,
    /// Those of one group take no notice of each other.
    group: u32,
    velocity: Vec2,
    /// The paths after and before it in its bucket.
    next: u32,
    before: u32,
}

impl Slot {
    const FREE: Self = Self {
        num_nodes: 0,
        bounds: Bounds::EMPTY,
        elapsed_s: 0.0,
        group: NONE,
        velocity: Vec2::ZERO,
        next: NONE,
        before: NONE,
    };
}

/// A path that somebody might take.
#[derive(Clone, Debug, Default)]
pub struct Path {
    /// Its nodes, from now on (at least one).
    pub nodes: Vec<PathNode>,
    /// Where its motion goes on the whole, as others see it (m/s).
    pub velocity: Vec2,
}

impl Reservations {
    /// Room for so many paths of up to so many nodes.
    pub fn with_capacity(capacity: usize, room: usize) -> Self {
        Self {
            room,
            nodes: vec![PathNode::default(); capacity * room],
            slots: vec![Slot::FREE; capacity],
            buckets: vec![NONE; (2 * capacity).next_power_of_two().max(16)],
            most_half_m: 0.0,
            walls: Vec::new(),
        }
    }

    /// Most nodes of a path.
    pub fn room(&self) -> usize {
        self.room
    }

    /// What stands for good.
    pub fn walls(&self) -> impl Iterator<Item = &Wall> {
        self.walls.iter().map(|w| &w.0)
    }

    /// Replaces what stands for good.
    pub fn set_walls(&mut self, walls: &[Wall]) {
        self.walls = walls.iter().map(|w| (*w, w.bounds())).collect();
    }

    /// Nobody is there any more; walls stay.
    pub fn clear(&mut self) {
        self.slots.fill(Slot::FREE);
        self.buckets.fill(NONE);
    }

    /// Reserves a path in place of the one before (who < capacity; 1 to `room` nodes).
    ///
    /// - `elapsed_s`: since it began (s).
    pub fn set(&mut self, who: usize, path: &Path, elapsed_s: f32) {
        self.remove(who);
        self.nodes[who * self.room..][..path.nodes.len()].copy_from_slice(&path.nodes);
        let bounds = Bounds::of(&path.nodes);
        let half = 0.5 * (bounds.max - bounds.min).max_element();
        self.most_half_m = self.most_half_m.max(half);
        let bucket = self.bucket(cell(0.5 * (bounds.min + bounds.max)));
        let next = self.buckets[bucket];
        let (num_nodes, group) = (path.nodes.len() as u32, self.slots[who].group);
        self.slots[who] = Slot { num_nodes, bounds, elapsed_s, group, velocity: path.velocity, next, before: NONE };
        if next != NONE {
            self.slots[next as usize].before = who as u32;
        }
        self.buckets[bucket] = who as u32;
    }

    /// Gives up a path; its group stays.
    pub fn remove(&mut self, who: usize) {
        let Slot { num_nodes, bounds, next, before, group, .. } = self.slots[who];
        if num_nodes == 0 {
            return;
        }
        match before {
            NONE => {
                let bucket = self.bucket(cell(0.5 * (bounds.min + bounds.max)));
                self.buckets[bucket] = next;
            }
            before => self.slots[before as usize].next = next,
        }
        if next != NONE {
            self.slots[next as usize].before = before;
        }
        self.slots[who] = Slot { group, ..Slot::FREE };
    }

    /// Time since a path began (s).
    pub fn set_elapsed(&mut self, who: usize, elapsed_s: f32) {
        self.slots[who].elapsed_s = elapsed_s;
    }

    /// Puts one into a group, whose members take no notice of each other.
    pub fn set_group(&mut self, who: usize, group: Option<u32>) {
        self.slots[who].group = group.unwrap_or(NONE);
    }

    /// The path of one who has one.
    pub fn path(&self, who: usize) -> Moving<'_> {
        let slot = &self.slots[who];
        let nodes = &self.nodes[who * self.room..][..slot.num_nodes as usize];
        Moving { nodes, elapsed_s: slot.elapsed_s }
    }

    /// Where the motion of one goes on the whole (m/s).
    pub fn velocity(&self, who: usize) -> Vec2 {
        self.slots[who].velocity
    }

    /// Calls `found` for everybody else whose path has a place in the box, in no order, until it returns false.
    pub fn near(&self, who: usize, bounds: &Bounds, mut found: impl FnMut(usize) -> bool) {
        let wide = bounds.grown(self.most_half_m);
        let (low, high) = (cell(wide.min), cell(wide.max));
        let group = self.slots[who].group;
        let mut is_found = |at: usize| {
            let slot = &self.slots[at];
            let is_other = at != who && slot.num_nodes > 0 && (group == NONE || slot.group != group);
            !(is_other && slot.bounds.meets(bounds)) || found(at)
        };
        let size = [0, 1].map(|k| i64::from(high[k]) - i64::from(low[k]) + 1);
        if size[0].saturating_mul(size[1]) > 4 * self.slots.len() as i64 {
            // Fewer paths than cells.
            (0..self.slots.len()).all(is_found);
            return;
        }
        // Cells of one bucket are met together: each path is found where its own cell is.
        for z in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let here = [x, z];
                let mut at = self.buckets[self.bucket(here)];
                while at != NONE {
                    let slot = &self.slots[at as usize];
                    if cell(0.5 * (slot.bounds.min + slot.bounds.max)) == here && !is_found(at as usize) {
                        return;
                    }
                    at = slot.next;
                }
            }
        }
    }

    /// True where a path from now on meets no wall and nobody else's path.
    ///
    /// - `ago_s`: how long ago now is for the others (s).
    pub fn is_clear(&self, who: usize, path: &Path, ago_s: f32) -> bool {
        self.meets_none(who, &Moving { nodes: &path.nodes, elapsed_s: 0.0 }, ago_s, 0.0)
    }

    /// As [`Reservations::is_clear`], for a path that is under way; nobody may come nearer than `room_m` (m).
    pub fn meets_none(&self, who: usize, own: &Moving<'_>, ago_s: f32, room_m: f32) -> bool {
        let bounds = Bounds::of(own.nodes);
        if self.walls.iter().any(|(wall, around)| around.meets(&bounds) && wall.meets(own)) {
            return false;
        }
        let mut clear = true;
        self.near(who, &bounds, |other| {
            let other = self.path(other);
            clear = !own.meets(&Moving { elapsed_s: other.elapsed_s - ago_s, ..other }, room_m);
            clear
        });
        clear
    }

    fn bucket(&self, [x, z]: [i32; 2]) -> usize {
        let hash = (x as u32).wrapping_mul(0x9E37_79B1) ^ (z as u32).wrapping_mul(0x85EB_CA77);
        (hash ^ hash >> 15) as usize & (self.buckets.len() - 1)
    }
}

/// The cell of a place; those of whole negative numbers are one lower than one might think, which is as good.
fn cell(place: Vec2) -> [i32; 2] {
    (place * (1.0 / CELL_M)).to_array().map(|v| v as i32 - i32::from(v < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against a list of all paths, while paths come, change and go.
        #[test]
        fn paths_are_found_as_in_a_list(steps in proptest::collection::vec((0usize..12, -9.0f32..9.0, -9.0f32..9.0, 0.0f32..4.0, any::<bool>()), 1..60)) {
            let mut book = Reservations::with_capacity(12, 2);
            let mut list: Vec<Option<Path>> = vec![None; 12];
            for (who, x, z, length, stays) in steps {
                let node = |k: f32| PathNode::new(k, Vec2::new(x + k * length, z), 0.3);
                let path = Path { nodes: vec![node(0.0), node(1.0)], velocity: Vec2::ZERO };
                let own = Moving { nodes: &path.nodes, elapsed_s: 0.0 };
                let meets = |p: &Path| own.meets(&Moving { nodes: &p.nodes, elapsed_s: 0.0 }, 0.0);
                let clear = !list.iter().enumerate().any(|(o, p)| o != who && p.as_ref().is_some_and(meets));
                prop_assert_eq!(book.is_clear(who, &path, 0.0), clear);
                if stays {
                    book.set(who, &path, 0.0);
                    list[who] = Some(path);
                } else {
                    book.remove(who);
                    list[who] = None;
                }
            }
        }
    }
}
