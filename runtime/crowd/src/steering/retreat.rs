//! Stepping back where two crowds press against each other without progress.

use crate::Space;
use crate::steering::config::SteeringConfig;
use crate::steering::density_grid::DensityGrid;

/// A half of the way between walls, as seen along the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Half {
    /// The half of oncoming agents.
    Left,
    /// Its own.
    Right,
}

/// An agent that makes no progress.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocked<V> {
    pub position: V,
    /// Unit vector along which it wants to go.
    pub ahead: V,
    /// Time without progress, [`SteeringConfig::patience_on_left_s`] or more (s).
    pub waited: f64,
    /// Where it is between walls, if there are some at hand.
    pub half: Option<Half>,
}

impl<V: Space> Blocked<V> {
    /// Direction in which it steps back, if more agents in front want to come than agents behind want to go on. So the few
    /// retreat before the many, in whole groups, as all of them see the same; equal groups stay and slide past to the
    /// right.
    ///
    /// Between walls there is no room for that: agents in the left half give way to those in the right half, even if they
    /// are as many; each side has a half of its own. See [`crate::steering::keep_right`].
    pub fn retreat(&self, grid: &DensityGrid<V>, steering: &SteeringConfig) -> Option<V> {
        let Self { position, ahead, waited, half } = *self;
        if waited < steering.patience_s && half != Some(Half::Left) {
            return None;
        }
        let (open, between_walls) = (steering.retreat_squares, steering.retreat_squares_between_walls);
        let far = if half.is_some() { between_walls } else { open };
        let (ratio, by, own_half) = (steering.outnumbered_ratio, steering.outnumbered_by, steering.own_half_factor);
        let at = position * grid.per_m();
        let here = grid.square(at);
        let (mut against, mut along) = (here.opposed(ahead), here.agreed(ahead));
        for k in 1..=far {
            let step = ahead * k as f32;
            against += grid.square(at + step).opposed(ahead);
            along += grid.square(at - step).agreed(ahead);
        }
        let (stronger, more) = match half {
            None => (ratio, by),
            Some(Half::Left) => (ratio / own_half, 0.0),
            Some(Half::Right) => (ratio * own_half, 2.0 * by),
        };
        // One who just stands counts as half, and nobody steps back from that one alone.
        let is_weaker = against >= 1.0 && against > stronger * along + more;
        is_weaker.then(|| (ahead * -steering.retreat_back + ahead.right() * steering.retreat_right).unit_and_length().0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn blocked(position: Vec2, ahead: Vec2) -> Blocked<Vec2> {
        Blocked { position, ahead, waited: 1.0, half: None }
    }

    #[test]
    fn smaller_group_steps_back() {
        let mut grid = DensityGrid::new(1.2, Vec2::splat(60.0), 100);
        let side = grid.side();
        // Twelve agents that want to go along X stand before two that want to go the other way.
        for i in 0..12 {
            grid.add(Vec2::X * side * (0.5 - (i % 3) as f32), Vec2::ZERO, Vec2::X);
        }
        let ahead = Vec2::X * side * 1.5;
        grid.add(ahead, Vec2::ZERO, Vec2::NEG_X);
        grid.add(ahead, Vec2::ZERO, Vec2::NEG_X);
        let way = blocked(ahead, Vec2::NEG_X).retreat(&grid, &SteeringConfig::DEFAULT).expect("the two give way");
        assert!(way.x > 0.3 && way.dot(Vec2::NEG_X.right()) > 0.3, "{way}");
        assert_eq!(
            blocked(Vec2::X * side * 0.5, Vec2::X).retreat(&grid, &SteeringConfig::DEFAULT),
            None,
            "the twelve do not"
        );
        assert_eq!(blocked(Vec2::Y * 20.0, Vec2::X).retreat(&grid, &SteeringConfig::DEFAULT), None, "an empty place");
    }

    #[test]
    fn left_half_between_walls_steps_back_before_as_many() {
        let mut grid = DensityGrid::new(1.2, Vec2::splat(60.0), 100);
        for k in 1..=8 {
            for side in [-1.0f32, 1.0] {
                (0..2).for_each(|_| grid.add(Vec2::X * (side * 0.6 * k as f32), Vec2::ZERO, Vec2::X * -side));
            }
        }
        for side in [-1.0f32, 1.0] {
            let blocked = blocked(Vec2::X * (side * 0.6), Vec2::X * -side);
            let yields =
                |half, waited| Blocked { half, waited, ..blocked }.retreat(&grid, &SteeringConfig::DEFAULT).is_some();
            assert!(yields(Some(Half::Left), 1.0) && yields(Some(Half::Left), 0.5));
            assert!(!yields(Some(Half::Right), 1.0) && !yields(None, 1.0));
        }
    }
}
