//! Routes as splines that agents follow.

use crate::error::check;
use crate::space::solid::{Solid, is_inside};
use crate::{AtEnd, Obstacle, Route, Space};
use serde::{Deserialize, Serialize};
use throng_base::{Result, prefetch};

/// Most pieces that one event moves on.
const MOST_PIECES: usize = 8;

/// Difference of distances that counts as none (m).
const AS_NEAR_M: f32 = 0.01;

/// Where an agent is on its route.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Cursor {
    /// Piece of the spline.
    pub piece: u32,
    /// Share of the piece that is done (0 to 1).
    pub share: f32,
}

/// A route made ready: a cubic through each pair of subgoals, tangents continuous in the length of the chords.
#[derive(Clone, Debug)]
pub(crate) struct Spline<V> {
    pub route: Route<V>,
    pieces: Vec<Piece<V>>,
    goal: V,
}

#[derive(Clone, Copy, Debug)]
struct Piece<V> {
    from: V,
    to: V,
    /// Tangents at both ends times the length of the chord.
    leave: V,
    arrive: V,
    /// Of the chord (m).
    length: f32,
    /// Of the chords that follow (m).
    rest: f32,
}

impl<V: Space> Piece<V> {
    fn point(&self, u: f32) -> V {
        let (v, uu) = (1.0 - u, u * u);
        let vv = v * v;
        self.from * (vv * (1.0 + 2.0 * u))
            + self.to * (uu * (1.0 + 2.0 * v))
            + self.leave * (u * vv)
            + self.arrive * (-uu * v)
    }

    /// Newton's step from a share of the piece to the point that is nearest to `x`, up to the share `most`.
    fn nearer(&self, share: f32, x: V, most: f32) -> f32 {
        let tangent = self.tangent(share);
        let step = (x - self.point(share)).dot(tangent) / tangent.length_squared().max(1e-12);
        (share + step).clamp(0.0, most)
    }

    /// Share, up to `most`, of the point that is about nearest to `x`.
    fn nearest(&self, x: V, most: f32) -> f32 {
        let square = |share: f32| (x - self.point(share)).length_squared();
        let samples = [0.25, 0.5, 0.75, 1.0].map(|s| s * most);
        let best = samples.into_iter().fold(0.0, |a, b| if square(b) < square(a) { b } else { a });
        (0..2).fold(best, |share, _| self.nearer(share, x, most))
    }

    fn tangent(&self, u: f32) -> V {
        let v = 1.0 - u;
        (self.to - self.from) * (6.0 * u * v) + self.leave * (v * (1.0 - 3.0 * u)) + self.arrive * (u * (3.0 * u - 2.0))
    }
}

/// How near to its place an agent stays that has no order (m).
const STAY_M: f32 = 0.5;

impl<V: Space> Spline<V> {
    /// The route of an agent that stays at a place.
    pub fn staying(at: V) -> Self {
        let route = Route { subgoals: vec![at], arrival_radius: STAY_M, at_end: AtEnd::Stay };
        Self { route, pieces: Vec::new(), goal: at }
    }

    /// Makes it the route of an agent that stays at a place. Allocates nothing.
    pub fn stay(&mut self, at: V) {
        self.route.subgoals.clear();
        self.route.subgoals.push(at);
        (self.route.arrival_radius, self.route.at_end) = (STAY_M, AtEnd::Stay);
        self.pieces.clear();
        self.goal = at;
    }

    /// Lays cubics through the subgoals of a route.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for a route without subgoals or with numbers that are out of range.
    pub fn new(n: usize, route: &Route<V>) -> Result<Self> {
        let goals = &route.subgoals;
        check("route.subgoals", n, goals.len() as f32, !goals.is_empty(), "at least 1")?;
        let far = goals.iter().find(|g| !(g.is_finite() && g.length() < 1e6)).map(|g| g.length());
        check("route.subgoals", n, far.unwrap_or(0.0), far.is_none(), "finite and within 1e6 m")?;
        let radius = route.arrival_radius;
        check("route.arrival_radius", n, radius, radius > 0.0 && radius < 1e6, "above 0 and below 1e6")?;
        let goal = goals[goals.len() - 1];
        let mut points = route.subgoals.clone();
        points.dedup_by(|a, b| (*a - *b).length() < 1e-3);
        let ahead = |i: usize| (points[i + 1] - points[i]).unit_and_length();
        let tangent = |i: usize| match (i.checked_sub(1), i + 1 < points.len()) {
            (None, _) => ahead(0).0,
            (Some(before), false) => ahead(before).0,
            (Some(before), true) => (ahead(before).0 + ahead(i).0).unit_and_length().0,
        };
        let mut pieces: Vec<_> = (0..points.len() - 1)
            .map(|i| {
                let length = ahead(i).1;
                let (leave, arrive) = (tangent(i) * length, tangent(i + 1) * length);
                Piece { from: points[i], to: points[i + 1], leave, arrive, length, rest: 0.0 }
            })
            .collect();
        let mut rest = 0.0;
        for piece in pieces.iter_mut().rev() {
            piece.rest = rest;
            rest += piece.length;
        }
        Ok(Self { route: route.clone(), pieces, goal })
    }

    /// The first subgoal that is in an obstacle.
    pub fn blocked_by(&self, obstacle: &Obstacle<V>, solids: &[Solid<V>]) -> Option<usize> {
        let inside = |&g: &V| {
            let polygon = matches!(obstacle, Obstacle::Polygon { corners } if is_inside(corners, g));
            polygon || solids.iter().any(|s| s.away(g).1 <= 0.0)
        };
        self.route.subgoals.iter().position(inside)
    }

    /// Where an agent at `x` begins: at the nearest of some points of the spline.
    pub fn begin(&self, x: V) -> Cursor {
        let mut best = (f32::INFINITY, Cursor::default());
        for (piece, p) in self.pieces.iter().enumerate() {
            for i in 0..16 {
                let share = i as f32 / 16.0;
                let distance = (p.point(share) - x).length_squared();
                if distance < best.0 {
                    best = (distance, Cursor { piece: piece as u32, share });
                }
            }
        }
        best.1
    }

    /// Moves the cursor to the point of the spline that is nearest to `x`, by Newton's step from where it was.
    ///
    /// - `ahead`: how far on the point is that is gone for, see [`Spline::ahead`] (m).
    pub fn follow(&self, cursor: &mut Cursor, x: V, ahead: f32) {
        for _ in 0..MOST_PIECES {
            let Some(piece) = self.pieces.get(cursor.piece as usize) else { return };
            cursor.share = piece.nearer(cursor.share, x, 1.0);
            if cursor.share < 1.0 || cursor.piece as usize + 1 == self.pieces.len() {
                break;
            }
            *cursor = Cursor { piece: cursor.piece + 1, share: 0.0 };
        }
        self.turn_back(cursor, x, ahead);
    }

    /// Moves the cursor on to a piece that begins within `ahead` metres and is about as near to `x` as where it is. Where a way
    /// turns back on itself, an agent that aims at a point ahead turns before it is at the tip: without this, it would then be
    /// led back to the tip, and go round before it.
    fn turn_back(&self, cursor: &mut Cursor, x: V, ahead: f32) {
        let Some(piece) = self.pieces.get(cursor.piece as usize) else { return };
        let mut nearest = (x - piece.point(cursor.share)).length();
        let mut way = (1.0 - cursor.share) * piece.length;
        let next = cursor.piece as usize + 1;
        for (number, piece) in (next as u32..).zip(self.pieces[next..].iter().take(MOST_PIECES)) {
            if way >= ahead {
                return;
            }
            let share = piece.nearest(x, ((ahead - way) / piece.length).min(1.0));
            let distance = (x - piece.point(share)).length();
            if distance <= nearest + AS_NEAR_M {
                nearest = nearest.min(distance);
                *cursor = Cursor { piece: number, share };
            }
            way += piece.length;
        }
    }

    /// Prefetches the piece that a cursor is on.
    #[inline]
    pub fn prefetch(&self, cursor: Cursor) {
        if let Some(piece) = self.pieces.get(cursor.piece as usize) {
            prefetch(piece);
        }
    }

    /// Point of the spline `ahead` metres on; the goal beyond its end.
    pub fn ahead(&self, cursor: Cursor, ahead: f32) -> V {
        let mut left = ahead;
        let (mut at, mut share) = (cursor.piece as usize, cursor.share);
        while let Some(piece) = self.pieces.get(at) {
            let rest = (1.0 - share) * piece.length;
            if left < rest {
                return piece.point(share + left / piece.length);
            }
            left -= rest;
            (at, share) = (at + 1, 0.0);
        }
        self.goal
    }

    /// Way that is left (m).
    pub fn left(&self, cursor: Cursor, x: V) -> f32 {
        match self.pieces.get(cursor.piece as usize) {
            Some(p) if cursor.piece as usize + 1 < self.pieces.len() || cursor.share < 1.0 => {
                p.rest + p.length * (1.0 - cursor.share)
            }
            _ => (self.goal - x).length(),
        }
    }

    /// True where an agent at `x` is at the end.
    pub fn is_there(&self, cursor: Cursor, x: V) -> bool {
        let last = cursor.piece as usize + 1 >= self.pieces.len();
        last && (self.goal - x).length_squared() <= self.route.arrival_radius * self.route.arrival_radius
    }

    /// See [`Route::arrival_radius`] (m).
    pub fn arrival_radius(&self) -> f32 {
        self.route.arrival_radius
    }

    /// See [`Route::at_end`].
    pub fn at_end(&self) -> AtEnd {
        self.route.at_end
    }

    /// The last subgoal.
    pub fn goal(&self) -> V {
        self.goal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn spline(points: &[[f32; 2]]) -> Spline<Vec2> {
        let subgoals = points.iter().map(|&p| Vec2::from_array(p)).collect();
        Spline::new(0, &Route { subgoals, arrival_radius: 0.5, at_end: AtEnd::Stay }).unwrap()
    }

    #[test]
    fn goes_through_its_subgoals_with_continuous_tangents() {
        let s = spline(&[[0.0, 0.0], [4.0, 0.0], [6.0, 3.0], [6.0, 9.0]]);
        for (a, b) in s.pieces.iter().zip(&s.pieces[1..]) {
            assert!((a.point(1.0) - b.point(0.0)).length() < 1e-6);
            // Per metre of chord.
            let (before, after) = (a.tangent(1.0) / a.length, b.tangent(0.0) / b.length);
            assert!((before - after).length() < 1e-5, "{before} {after}");
        }
        assert_eq!((s.pieces[0].point(0.0), s.pieces[2].point(1.0)), (Vec2::ZERO, Vec2::new(6.0, 9.0)));
    }

    #[test]
    fn tangent_is_the_derivative() {
        let s = spline(&[[0.0, 0.0], [4.0, 1.0], [5.0, 5.0]]);
        for u in [0.1f32, 0.5, 0.8] {
            let p = &s.pieces[0];
            let slope = (p.point(u + 1e-2) - p.point(u - 1e-2)) / 2e-2;
            assert!((slope - p.tangent(u)).length() < 1e-2, "{slope}");
        }
    }

    #[test]
    fn cursor_follows_agent_beside_the_spline() {
        let s = spline(&[[0.0, 0.0], [4.0, 0.0], [6.0, 3.0], [6.0, 9.0]]);
        let mut cursor = s.begin(Vec2::new(-1.0, 1.0));
        assert_eq!(cursor, Cursor::default());
        let mut left = f32::INFINITY;
        for i in 0..60 {
            let at = Vec2::new(i as f32 * 0.1, (i as f32 * 0.1 - 3.5).max(0.0) * 1.2 + 0.3);
            s.follow(&mut cursor, at, 1.0);
            assert!(s.left(cursor, at) <= left + 1e-4);
            left = s.left(cursor, at);
        }
        assert!(cursor.piece >= 1, "{cursor:?}");
        assert_eq!(s.ahead(cursor, 100.0), Vec2::new(6.0, 9.0));
        assert!(s.is_there(Cursor { piece: 2, share: 0.9 }, Vec2::new(6.2, 9.3)));
    }

    #[test]
    fn single_subgoal_is_straight_ahead() {
        let s = spline(&[[3.0, 4.0]]);
        assert_eq!(s.ahead(s.begin(Vec2::ZERO), 1.0), Vec2::new(3.0, 4.0));
        assert_eq!(s.left(Cursor::default(), Vec2::ZERO), 5.0);
    }
}
