//! Blackboards: a global one, and one for each cell of a hierarchy of cells (Kim, Kim and Shin 2003a, section 3.1).

use super::tables::{BlackboardTable, NONE};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Most posts on the blackboards of cells at a time; a new post replaces the oldest.
const POSTS: usize = 4096;
/// Number of lists of posts, hashed by their cells.
const BUCKETS: usize = 1024;

/// All blackboards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Blackboards {
    pub cell_m: f32,
    pub levels: u32,
    /// Note of each event on the global blackboard.
    global: Vec<BlackboardNote>,
    posts: Vec<CellPost>,
    /// First post of each bucket; [`NONE`] for an empty one.
    first: Vec<u32>,
    /// Number of posts ever made: the next one takes this index, modulo [`POSTS`].
    count: u64,
}

/// Note on a blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct BlackboardNote {
    /// Agent that wrote it last; [`NONE`] for an event posted as it happened.
    pub by: u32,
    /// Time of writing (s).
    pub since: f64,
    /// Time until which it is shown (s).
    pub until: f64,
}

/// Post on the blackboard of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct CellPost {
    event: u16,
    level: u32,
    cell: [i32; 2],
    note: BlackboardNote,
    /// Next post in the list of its bucket.
    next: u32,
}

/// Post that a blackboard shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlackboardPost {
    /// Number of the event, among those of the scenario.
    pub event: usize,
    /// Cell of the blackboard; `None` for the global one.
    pub cell: Option<BlackboardArea>,
    /// Number of the agent that wrote it last; `None` where the event was posted as it happened.
    pub by: Option<usize>,
    /// Time of writing (s).
    pub since_s: f64,
    /// Time until which it is shown; infinite where it never ends (s).
    pub until_s: f64,
}

/// Square cell with a blackboard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlackboardArea {
    /// Level in the hierarchy; cells of level 0 are the smallest.
    pub level: u32,
    /// Centre, x and z (m).
    pub middle: [f32; 2],
    /// Side (m).
    pub side_m: f32,
}

impl Blackboards {
    pub fn new(table: BlackboardTable, num_events: usize) -> Self {
        let has_cells = table.cell_m > 0.0;
        Self {
            cell_m: table.cell_m,
            levels: table.levels,
            global: vec![BlackboardNote { by: NONE, since: 0.0, until: f64::NEG_INFINITY }; num_events],
            posts: Vec::with_capacity(if has_cells { POSTS } else { 0 }),
            first: vec![NONE; if has_cells { BUCKETS } else { 0 }],
            count: 0,
        }
    }

    /// Posts an event on the global blackboard, or on that of the cell of a level at a position.
    pub fn post_event(&mut self, event: u16, cell: Option<(Vec3, u32)>, note: BlackboardNote) {
        let Some((at, level)) = cell else {
            self.global[usize::from(event)] = note;
            return;
        };
        let level = level.min(self.levels - 1);
        let cell = self.cell(at, level);
        let bucket = bucket(level, cell);
        let is_same = |p: &CellPost| (p.event, p.level, p.cell) == (event, level, cell);
        let known = self.posts_of(bucket).find(|n| is_same(&self.posts[*n]));
        if let Some(number) = known {
            self.posts[number].note = note;
            return;
        }
        let place = (self.count % POSTS as u64) as usize;
        self.count += 1;
        let post = CellPost { event, level, cell, note, next: self.first[bucket] };
        if place == self.posts.len() {
            self.posts.push(post);
            self.first[bucket] = place as u32;
        } else {
            self.unlink_post(place as u32);
            self.posts[place] = CellPost { next: self.first[bucket], ..post };
            self.first[bucket] = place as u32;
        }
    }

    fn unlink_post(&mut self, number: u32) {
        let old = self.posts[number as usize];
        let bucket = bucket(old.level, old.cell);
        let before = self.posts_of(bucket).find(|n| self.posts[*n].next == number);
        if self.first[bucket] == number {
            self.first[bucket] = old.next;
        } else if let Some(before) = before {
            self.posts[before].next = old.next;
        }
    }

    /// Numbers of the posts in the list of a bucket.
    fn posts_of(&self, bucket: usize) -> impl Iterator<Item = usize> + '_ {
        let next = |number: &usize| Some(self.posts.get(*number)?.next as usize);
        std::iter::successors(Some(self.first[bucket] as usize), next).take_while(|number| *number != NONE as usize)
    }

    /// Events on the global blackboard, as bits.
    pub fn global_events(&self, now: f64) -> u64 {
        self.global.iter().enumerate().filter(|(_, note)| now <= note.until).fold(0, |bits, (e, _)| bits | 1 << e)
    }

    /// Events on the blackboards that are read at a position: the global one, and those of the cells of all levels, as bits.
    pub fn events_at(&self, at: Vec3, now: f64) -> u64 {
        let mut news = self.global_events(now);
        if self.posts.is_empty() {
            return news;
        }
        for level in 0..self.levels {
            let cell = self.cell(at, level);
            for post in self.posts_of(bucket(level, cell)).map(|number| &self.posts[number]) {
                if (post.level, post.cell) == (level, cell) && now <= post.note.until {
                    news |= 1 << post.event;
                }
            }
        }
        news
    }

    /// Side of the cells of a level (m).
    fn side_m(&self, level: u32) -> f32 {
        self.cell_m * (1 << level) as f32
    }

    /// All visible posts: those of the global blackboard, then those of cells.
    pub fn visible_posts(&self, now: f64) -> impl Iterator<Item = BlackboardPost> + '_ {
        let posted = |event: u16, cell, note: &BlackboardNote| BlackboardPost {
            event: usize::from(event),
            cell,
            by: (note.by != NONE).then_some(note.by as usize),
            since_s: note.since,
            until_s: note.until,
        };
        let global = (0..).zip(&self.global).filter(move |(_, p)| now <= p.until);
        let cells = self.posts.iter().filter(move |p| now <= p.note.until).map(move |p| {
            let side_m = self.side_m(p.level);
            let middle = p.cell.map(|c| (c as f32 + 0.5) * side_m);
            posted(p.event, Some(BlackboardArea { level: p.level, middle, side_m }), &p.note)
        });
        global.map(move |(e, note)| posted(e, None, note)).chain(cells)
    }

    fn cell(&self, at: Vec3, level: u32) -> [i32; 2] {
        let side = self.side_m(level);
        [(at.x / side).floor() as i32, (at.z / side).floor() as i32]
    }

    /// True where loaded blackboards can be those of the same scenario.
    ///
    /// - `num_agents`: number of agents, which may have written.
    pub fn is_compatible(&self, own: &Self, num_agents: u32) -> bool {
        let is_written =
            |p: &BlackboardNote| (p.by == NONE || p.by < num_agents) && p.since.is_finite() && !p.until.is_nan();
        // Every post is in the list of its bucket, once: lists end.
        let mut listed = 0;
        for (list, &first) in self.first.iter().enumerate() {
            let mut number = first;
            while number != NONE {
                let post = self.posts.get(number as usize).filter(|p| bucket(p.level, p.cell) == list);
                let Some(post) = post.filter(|_| listed < self.posts.len()) else { return false };
                (number, listed) = (post.next, listed + 1);
            }
        }
        (self.cell_m, self.levels, self.global.len(), self.first.len())
            == (own.cell_m, own.levels, own.global.len(), own.first.len())
            && self.count < 1 << 62
            && self.posts.len() as u64 == self.count.min(POSTS as u64)
            && listed == self.posts.len()
            && self.posts.iter().all(|p| usize::from(p.event) < self.global.len() && p.level < self.levels)
            && self.global.iter().chain(self.posts.iter().map(|p| &p.note)).all(is_written)
    }
}

fn bucket(level: u32, [x, z]: [i32; 2]) -> usize {
    let mixed =
        (x as u32).wrapping_mul(0x9E37_79B1) ^ (z as u32).wrapping_mul(0x85EB_CA77) ^ level.wrapping_mul(0xC2B2_AE3D);
    (mixed ^ mixed >> 15) as usize % BUCKETS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn posts_in_the_list_of_another_cell_are_refused() {
        let own = Blackboards::new(BlackboardTable { cell_m: 1.0, levels: 4 }, 1);
        let mut blackboards = own.clone();
        for x in [0.5, 7.5] {
            let note = BlackboardNote { by: NONE, since: 0.0, until: 9.0 };
            blackboards.post_event(0, Some((Vec3::new(x, 0.0, 0.0), 0)), note);
        }
        assert!(blackboards.is_compatible(&own, 1));
        let lists: Vec<usize> = (0..BUCKETS).filter(|list| blackboards.first[*list] != NONE).collect();
        for change in [
            |b: &mut Blackboards, lists: &[usize]| b.first.swap(lists[0], lists[1]),
            |b: &mut Blackboards, lists: &[usize]| b.posts[b.first[lists[0]] as usize].next = b.first[lists[0]],
            |b: &mut Blackboards, lists: &[usize]| b.first[lists[0]] = NONE,
            |b: &mut Blackboards, _: &[usize]| b.count = u64::MAX,
        ] {
            let mut forged = blackboards.clone();
            change(&mut forged, &lists);
            assert!(!forged.is_compatible(&own, 1));
        }
    }
}
