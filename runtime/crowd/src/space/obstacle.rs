//! Obstacles that stand or move.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Something that no agent enters. A new kind has to be added wherever `Obstacle::` is matched: other crates have `_` arms, which
/// leave it out of walls, outlines, overlaps, levels and pictures without a word.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Obstacle<V = Vec3> {
    /// A disc or ball that stays where it is.
    Ball {
        /// Centre (m).
        centre: V,
        /// (m, > 0)
        radius: f32,
    },
    /// Disc or ball that moves through points, at constant speed between two of them; it never stops. Agents get out of
    /// its way as far as they can: a trapped agent is struck, which [`crate::CrowdEventKind::Struck`] reports.
    Mover {
        /// Positions at times. Before the first and after the last it stands still. (s, m, >= 1, times rise)
        path: Vec<(f64, V)>,
        /// (m, > 0)
        radius: f32,
    },
    /// Wall, or in 3-D a rod or column: all points within `radius` of a line from `from` to `to`.
    Wall {
        /// First end (m).
        from: V,
        /// The other end (m).
        to: V,
        /// Radius: half of the thickness (m, >= 0).
        radius: f32,
    },
    /// A solid polygon in 2-D, its corners in order around it.
    Polygon {
        /// (m, >= 3)
        corners: Vec<V>,
    },
    /// A solid box along the axes, a rectangle in 2-D.
    Box {
        /// Smallest coordinates (m).
        min: V,
        /// Largest coordinates (m, > min).
        max: V,
    },
}

/// Something that draws agents near or drives them away: a window display, a puddle (Kim, Kim and Shin 2003b, eq. 17, second term).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interest<V = Vec3> {
    /// Position (m).
    pub position: V,
    /// c_int in eq. 17 at its place, less with the distance: above 0 attracts, below 0 repels (m/s2).
    pub strength: f32,
    /// Distance within which it has an effect (m, > 0).
    pub reach: f32,
}

impl<V> Obstacle<V> {
    /// Converts it to another space.
    pub fn map<W>(self, f: impl Fn(V) -> W) -> Obstacle<W> {
        match self {
            Self::Ball { centre, radius } => Obstacle::Ball { centre: f(centre), radius },
            Self::Mover { path, radius } => {
                Obstacle::Mover { path: path.into_iter().map(|(time, at)| (time, f(at))).collect(), radius }
            }
            Self::Wall { from, to, radius } => Obstacle::Wall { from: f(from), to: f(to), radius },
            Self::Polygon { corners } => Obstacle::Polygon { corners: corners.into_iter().map(f).collect() },
            Self::Box { min, max } => Obstacle::Box { min: f(min), max: f(max) },
        }
    }
}

impl<V> Interest<V> {
    /// Converts it to another space.
    pub fn map<W>(self, f: impl Fn(V) -> W) -> Interest<W> {
        Interest { position: f(self.position), strength: self.strength, reach: self.reach }
    }
}
