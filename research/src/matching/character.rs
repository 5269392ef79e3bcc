//! A character that is moved by matching.

use super::boxes::BoxSearch;
use super::database::Database;
use super::distance::Nearest;
use super::features::Row;
use super::goal::MatchGoal;
use throng_core::Planar;

/// Frames between two searches.
pub const SEARCH_FRAMES: u32 = 10;

/// Where a character is, and what it plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Character {
    /// Planar root in the world.
    pub root: Planar,
    /// Frame that plays.
    pub frame: u32,
    /// Frames played since the last search.
    since: u32,
}

impl Character {
    /// Starts at a frame (the frame is usable).
    pub fn new(root: Planar, frame: u32) -> Self {
        Self { root, frame, since: SEARCH_FRAMES }
    }

    /// True where it is time to search: every few frames, and where there is no more to play.
    ///
    /// - `is_hit`: the frame that plays is that of a hit, after which everything may be different.
    pub fn wants_search(&self, database: &Database, is_hit: bool) -> bool {
        self.since >= SEARCH_FRAMES || is_hit || !database.goes_on(self.frame)
    }

    /// What it looks for now, and how near it must be: nearer than what plays already, where that can go on.
    pub fn query(&self, database: &Database, goal: &MatchGoal) -> (Row, Nearest) {
        let query = database.query(self.frame, goal);
        let limit = if database.goes_on(self.frame) {
            super::brute_force(
                std::slice::from_ref(database.row_of(self.frame)),
                &query,
                Nearest::within(f32::INFINITY),
            )
            .distance
        } else {
            f32::INFINITY
        };
        (query, Nearest::within(limit))
    }

    /// Searches, and goes on from what is found.
    pub fn search(&mut self, database: &Database, boxes: &BoxSearch<'_>, goal: &MatchGoal) {
        let (query, from) = self.query(database, goal);
        if let Some(row) = boxes.find(&query, from).row {
            self.frame = database.frame(row);
        }
        self.since = 0;
    }

    /// Plays one frame, if there is one.
    pub fn advance(&mut self, database: &Database) {
        if database.goes_on(self.frame) {
            self.root = self.root.compose(database.step(self.frame));
            self.frame += 1;
            self.since += 1;
        }
    }
}
