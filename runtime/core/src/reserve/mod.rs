//! Reservations: the ground that every character needs until the end of its action and for the stop that may follow.
//!
//! A new path may be taken only if it meets no other one. All paths end in a place to stay at for good, so that no
//! character ever has to leave its path: no two discs overlap, whatever the characters choose (the argument of the
//! event-driven crowds of Kim, Kim and Shin 2003, section 2, for motion that cannot be stopped at once).

mod path;

use glam::Vec2;
pub use path::{PathNode, TimedPath};
use throng_base::ground::is_one_floor;
pub use throng_base::ground::{ExternalObstacle, ExternalObstacles, ReservedRegion};
use throng_geometry::{Bounds2d, BoxGrid, Capsule2d};

const NONE: u32 = u32::MAX;

/// Paths of all characters on the ground, by number.
///
/// All memory is allocated in [`PathReservations::with_capacity`], except for walls.
#[derive(Clone, Debug)]
pub struct PathReservations {
    /// Most nodes of a path.
    pub(crate) max_nodes: usize,
    nodes: Vec<PathNode>,
    slots: Vec<ReservationSlot>,
    grid: BoxGrid,
    walls: Vec<FloorWall>,
    wall_grid: BoxGrid,
    pub(crate) external_obstacles: ExternalObstacles,
    /// Depth to which the discs of members of one group may overlap (m, >= 0).
    pub(crate) group_depth_m: f32,
}

#[derive(Clone, Copy, Debug)]
struct ReservationSlot {
    num_nodes: u32,
    elapsed_s: f32,
    /// Group, whose members may come nearer to each other.
    group: u32,
    velocity: Vec2,
    /// Lowest and highest ground on the path (m).
    heights_m: [f32; 2],
}

impl ReservationSlot {
    const FREE: Self = Self { num_nodes: 0, elapsed_s: 0.0, group: NONE, velocity: Vec2::ZERO, heights_m: [0.0; 2] };
}

/// Wall on ground between two heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorWall {
    /// Wall, from above.
    pub wall: Capsule2d,
    /// Lowest and highest ground at it (m).
    pub heights_m: [f32; 2],
}

impl From<&Capsule2d> for FloorWall {
    /// A wall through all floors.
    fn from(wall: &Capsule2d) -> Self {
        Self { wall: *wall, heights_m: [f32::NEG_INFINITY, f32::INFINITY] }
    }
}

/// Paths that touched when they were taken may be found this deep in each other later (m).
pub const ROUNDING_M: f32 = 0.002;

/// Path that a character might take.
#[derive(Clone, Debug, Default)]
pub struct ReservedPath {
    /// Nodes of the path, from now on (at least one).
    pub nodes: Vec<PathNode>,
    /// Mean velocity of its motion, for others to avoid (m/s).
    pub velocity: Vec2,
    /// Lowest and highest ground on it (m); 0 where the ground has one floor.
    pub heights_m: [f32; 2],
}

impl ReservedPath {
    /// The path as it begins.
    pub fn begun(&self, elapsed_s: f32) -> TimedPath<'_> {
        TimedPath { nodes: &self.nodes, elapsed_s, heights_m: self.heights_m }
    }
}

impl PathReservations {
    /// Room for so many paths of up to so many nodes.
    pub fn with_capacity(capacity: usize, room: usize) -> Self {
        Self {
            max_nodes: room,
            // Most paths are far shorter than the longest: memory that none is written into takes no room.
            nodes: bytemuck::zeroed_vec(capacity * room),
            slots: vec![ReservationSlot::FREE; capacity],
            grid: BoxGrid::with_capacity(capacity),
            walls: Vec::new(),
            wall_grid: BoxGrid::with_capacity(0),
            external_obstacles: ExternalObstacles::default(),
            group_depth_m: 0.0,
        }
    }

    /// Walls, on all floors.
    pub fn walls(&self) -> impl Iterator<Item = &Capsule2d> {
        self.walls.iter().map(|w| &w.wall)
    }

    /// Replaces the walls.
    pub fn set_walls(&mut self, walls: impl IntoIterator<Item = FloorWall>) {
        self.wall_grid.clear();
        self.walls.clear();
        for wall in walls {
            self.wall_grid.set(self.walls.len(), wall.wall.bounds());
            self.walls.push(wall);
        }
    }

    /// True where a wall on the floors of some ground is so near to a box that `meets` says so.
    pub fn meets_wall(&self, bounds: &Bounds2d, heights_m: [f32; 2], meets: impl Fn(&Capsule2d) -> bool) -> bool {
        if self.walls.is_empty() {
            return false;
        }
        let mut found = false;
        self.wall_grid.visit_intersecting(bounds, |at| {
            let wall = &self.walls[at];
            found = is_one_floor(wall.heights_m, heights_m) && meets(&wall.wall);
            !found
        });
        found
    }

    /// Copies walls and external obstacles.
    pub fn copy_surroundings(&mut self, other: &Self) {
        self.walls.clone_from(&other.walls);
        self.wall_grid.clone_from(&other.wall_grid);
        self.external_obstacles.clone_from(&other.external_obstacles);
    }

    /// Removes all paths; walls and external obstacles stay.
    pub fn clear(&mut self) {
        self.slots.fill(ReservationSlot::FREE);
        self.grid.clear();
    }

    /// Reserves a path in place of the previous one (who < capacity; 1 to `room` nodes).
    ///
    /// - `elapsed_s`: time since the path began (s).
    pub fn set(&mut self, who: usize, path: &ReservedPath, elapsed_s: f32) {
        self.nodes[who * self.max_nodes..][..path.nodes.len()].copy_from_slice(&path.nodes);
        let (num_nodes, group) = (path.nodes.len() as u32, self.slots[who].group);
        let ReservedPath { velocity, heights_m, .. } = *path;
        self.slots[who] = ReservationSlot { num_nodes, elapsed_s, group, velocity, heights_m };
        self.grid.set(who, bounds(&path.nodes));
    }

    /// Removes a path; its group stays.
    pub fn remove(&mut self, who: usize) {
        self.slots[who] = ReservationSlot { group: self.slots[who].group, ..ReservationSlot::FREE };
        self.grid.remove(who);
    }

    /// Time since a path began (s).
    pub fn set_elapsed(&mut self, who: usize, elapsed_s: f32) {
        self.slots[who].elapsed_s = elapsed_s;
    }

    /// Moves a character into a group, whose members may come nearer to each other.
    pub fn set_group(&mut self, who: usize, group: Option<u32>) {
        self.slots[who].group = group.unwrap_or(NONE);
    }

    /// Path of a character that has one.
    pub fn path(&self, who: usize) -> TimedPath<'_> {
        let slot = &self.slots[who];
        let nodes = &self.nodes[who * self.max_nodes..][..slot.num_nodes as usize];
        TimedPath { nodes, elapsed_s: slot.elapsed_s, heights_m: slot.heights_m }
    }

    /// Mean velocity of a character's motion (m/s).
    pub fn velocity(&self, who: usize) -> Vec2 {
        self.slots[who].velocity
    }

    /// Calls `found` for every other character whose path has a place in the box and whose group is another one, in no
    /// order, until it returns false.
    pub fn for_each_near(&self, who: usize, bounds: &Bounds2d, mut found: impl FnMut(usize) -> bool) {
        self.grid.visit_intersecting(bounds, |at| at == who || self.are_together(who, at) || found(at));
    }

    fn are_together(&self, a: usize, b: usize) -> bool {
        self.slots[a].group != NONE && self.slots[a].group == self.slots[b].group
    }

    /// True if a path from now on meets no wall, no other path and no region reserved by an external obstacle. Members
    /// of its group are ignored while it is already too deep inside one of them.
    ///
    /// - `ago_s`: time since the start of the path, for the others (s).
    pub fn is_clear(&self, who: usize, path: &ReservedPath, ago_s: f32) -> bool {
        let own = path.begun(0.0);
        let is_deep = || !self.is_apart(who, &self.path(who), 0.0, ROUNDING_M);
        self.is_clear_of_all(who, &own, ago_s, 0.0) && (self.is_apart(who, &own, ago_s, 0.0) || is_deep())
    }

    /// True if a path leads no deeper into members of its group than allowed, within `slack_m` (m).
    fn is_apart(&self, who: usize, own: &TimedPath<'_>, ago_s: f32, slack_m: f32) -> bool {
        let mut apart = true;
        if self.slots[who].group != NONE && !own.nodes.is_empty() {
            self.grid.visit_intersecting(&bounds(own.nodes), |at| {
                if at != who && self.are_together(who, at) {
                    let other = self.path(at);
                    let other = TimedPath { elapsed_s: other.elapsed_s - ago_s, ..other };
                    apart = !own.meets_path(&other, -self.group_depth_m - slack_m);
                }
                apart
            });
        }
        apart
    }

    /// True if a path that has begun meets nothing, see [`PathReservations::is_clear`]; others, except members of its
    /// group, must stay `room_m` away (m).
    pub fn is_clear_of_all(&self, who: usize, own: &TimedPath<'_>, ago_s: f32, room_m: f32) -> bool {
        let bounds = bounds(own.nodes);
        if self.meets_wall(&bounds, own.heights_m, |wall| own.meets_capsule(wall)) {
            return false;
        }
        let mut clear = true;
        self.for_each_near(who, &bounds, |other| {
            let other = self.path(other);
            clear = !own.meets_path(&TimedPath { elapsed_s: other.elapsed_s - ago_s, ..other }, room_m);
            clear
        });
        if clear {
            self.external_obstacles.visit_reserved_near(&bounds, |ground| {
                clear = !own.meets_capsule(ground);
                clear
            });
        }
        clear
    }
}

/// A box around the discs of a path.
pub fn bounds(nodes: &[PathNode]) -> Bounds2d {
    let mut before_m = 0.0f32;
    nodes.iter().fold(Bounds2d::EMPTY, |b, n| {
        let disc = Bounds2d::around_disc(n.place, n.radius_m.max(before_m));
        before_m = n.radius_m;
        b.union(disc)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn members_of_a_group_may_come_into_each_others_discs_as_far_as_it_allows() {
        let at = |x: f32| ReservedPath {
            nodes: vec![PathNode::new(0.0, Vec2::new(x, 0.0), 0.3)],
            ..ReservedPath::default()
        };
        let mut book = PathReservations::with_capacity(3, 1);
        book.group_depth_m = 0.1;
        [(0, Some(7)), (1, Some(7)), (2, None)].into_iter().for_each(|(who, group)| book.set_group(who, group));
        book.set(0, &at(0.0), 0.0);
        assert!(book.is_clear(1, &at(0.51), 0.0) && !book.is_clear(1, &at(0.49), 0.0));
        assert!(book.is_clear(2, &at(0.61), 0.0) && !book.is_clear(2, &at(0.59), 0.0));
        let mut seen = 0;
        book.for_each_near(1, &Bounds2d::around_disc(Vec2::ZERO, 1.0), |_| {
            seen += 1;
            true
        });
        assert_eq!(seen, 0, "they do not turn aside for each other");
        // A character that is too deep inside another one may go on.
        book.set(1, &at(0.2), 0.0);
        assert!(book.is_clear(1, &at(0.3), 0.0));
        book.remove(1);
        // Deeper than they are wide, they take no notice.
        book.group_depth_m = 10.0;
        assert!(book.is_clear(1, &at(0.0), 0.0));
    }

    proptest! {
        /// Against a list of all paths, while paths come, change and go.
        #[test]
        fn paths_are_found_as_in_a_list(steps in proptest::collection::vec((0usize..12, -9.0f32..9.0, -9.0f32..9.0, 0.0f32..4.0, any::<bool>()), 1..60)) {
            let mut book = PathReservations::with_capacity(12, 2);
            let mut list: Vec<Option<ReservedPath>> = vec![None; 12];
            for (who, x, z, length, stays) in steps {
                let node = |k: f32| PathNode::new(k, Vec2::new(x + k * length, z), 0.3);
                let path = ReservedPath { nodes: vec![node(0.0), node(1.0)], ..ReservedPath::default() };
                let own = path.begun(0.0);
                let meets = |p: &ReservedPath| own.meets_path(&p.begun(0.0), 0.0);
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
