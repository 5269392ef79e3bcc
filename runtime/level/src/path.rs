//! Paths between points of a level, over links too.

use crate::search::LevelSearch;
use crate::{Level, LevelLink, LevelPoint};
use glam::Vec3;
use throng_base::{Error, Result};

/// Distance from the ground within which a point is taken to be on it (m).
const NEAR_M: f32 = 1.5;

/// A link on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkPassage {
    /// Number of the corner at its start; the next one is its end.
    pub corner: usize,
    /// Number of the link.
    pub link: usize,
}

/// Shortest path, and the memory of its search: a path of a size that was there before allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct LevelPath {
    corners: Vec<Vec3>,
    links: Vec<LinkPassage>,
    length_m: f64,
    search: LevelSearch,
    /// Lengths from the end of each link to the target (m).
    from_links: Vec<f64>,
}

impl LevelPath {
    /// Corners, with both ends (m).
    pub fn corners(&self) -> &[Vec3] {
        &self.corners
    }

    /// Links, in their order.
    pub fn links(&self) -> &[LinkPassage] {
        &self.links
    }

    /// Length along the ground, with the costs of links (m).
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    fn find_leg(&mut self, level: &Level, ends: [&LevelPoint; 2], most_m: f64) -> Option<f64> {
        self.search.find_path(level, ends, most_m, &mut self.corners)
    }
}

impl Level {
    /// Finds the shortest path between two points, in the plane of x and z, with the costs of links. Points beside the
    /// ground count as the nearest place on it.
    ///
    /// # Errors
    /// [`Error::NoPath`] for a point that is more than 1.5 m from the ground, or where nothing leads; the path is empty then.
    pub fn path(&self, from: Vec3, to: Vec3, out: &mut LevelPath) -> Result<()> {
        self.find_path(from, to, self.links(), out)
    }

    /// Finds the shortest path that takes no link, see [`Level::path`].
    ///
    /// # Errors
    /// As [`Level::path`].
    pub fn path_on_foot(&self, from: Vec3, to: Vec3, out: &mut LevelPath) -> Result<()> {
        self.find_path(from, to, &[], out)
    }

    fn find_path(&self, from: Vec3, to: Vec3, links: &[LevelLink], out: &mut LevelPath) -> Result<()> {
        let ends = [from, to].map(|at| self.nearest(at, NEAR_M).unwrap_or(LevelPoint::UNKNOWN));
        out.corners.clear();
        out.links.clear();
        out.length_m = f64::INFINITY;
        let is_ground = ends.iter().all(|e| (e.polygon as usize) < self.num_polygons());
        match is_ground.then(|| self.path_between([&ends[0], &ends[1]], links, out)).flatten() {
            Some(length_m) => {
                out.length_m = length_m;
                Ok(())
            }
            None => {
                out.corners.clear();
                Err(Error::NoPath { who: None, from, to })
            }
        }
    }

    fn path_between(&self, [from, to]: [&LevelPoint; 2], links: &[LevelLink], out: &mut LevelPath) -> Option<f64> {
        out.corners.push(from.at);
        let direct = out.find_leg(self, [from, to], f64::INFINITY);
        if links.is_empty() {
            return direct;
        }
        // Links whose ends are farther away, in a straight line, than the best path so far need no search.
        let mut best = (direct.unwrap_or(f64::INFINITY), None);
        let num = out.corners.len();
        out.from_links.clear();
        for j in 0..links.len() {
            let cost = out.find_leg(self, [&self.link_end(j, 1), to], best.0);
            out.corners.truncate(num);
            out.from_links.push(cost.unwrap_or(f64::INFINITY));
        }
        for i in 0..links.len() {
            let to_link = out.find_leg(self, [from, &self.link_end(i, 0)], best.0).unwrap_or(f64::INFINITY);
            out.corners.truncate(num);
            for (j, from_link) in out.from_links.iter().enumerate() {
                let between = f64::from(links[i].cost_m) + f64::from(self.0.link_costs[i * links.len() + j]);
                if to_link + between + from_link < best.0 {
                    best = (to_link + between + from_link, Some([i, j]));
                }
            }
        }
        let Some([first, last]) = best.1 else { return direct };
        out.corners.truncate(1);
        let (mut here, mut link, mut length) = (*from, first, 0.0);
        // No way takes a link twice.
        for _ in 0..=links.len() {
            let [start, end] = [0, 1].map(|side| self.link_end(link, side));
            length += out.find_leg(self, [&here, &start], f64::INFINITY)? + f64::from(links[link].cost_m);
            out.links.push(LinkPassage { corner: out.corners.len() - 1, link });
            out.corners.push(end.at);
            here = end;
            if link == last {
                return Some(length + out.find_leg(self, [&here, to], f64::INFINITY)?);
            }
            link = self.0.link_next[link * links.len() + last] as usize;
        }
        None
    }

    /// Start (0) or end (1) of a link.
    fn link_end(&self, link: usize, side: usize) -> LevelPoint {
        let link = &self.links()[link];
        LevelPoint { at: link.ends[side].into(), polygon: link.polygons[side] }
    }
}
