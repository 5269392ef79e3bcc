//! Stepping back where two crowds press against each other without progress.

use crate::{Space, steering::config::SteeringConfig, steering::density_grid::DensityGrid};

/// Agents on a square and the next one from which on it is dense there.
const JAM: f32 = 4.0;

/// A half of the way between walls, as seen along the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CorridorHalf {
    /// The half of oncoming agents.
    Left,
    /// The half of the agent itself.
    Right,
}

/// An agent that makes no progress.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockedAgent<V> {
    pub position: V,
    /// Unit vector along which it wants to go.
    pub ahead: V,
    /// Time without progress, [`SteeringConfig::patience_on_left_s`] or more (s).
    pub waited: f64,
    /// Half of the passage that it is in, if there are walls at hand.
    pub half: Option<CorridorHalf>,
}

impl<V: Space> BlockedAgent<V> {
    /// Direction in which it steps back, if more agents in front want to come than agents behind want to go on. So the few
    /// retreat before the many, in whole groups, as all of them see the same; equal groups stay and slide past to the
    /// right.
    ///
    /// Between walls there is no room for that: agents in the left half give way to those in the right half, even if they
    /// are as many; each side has a half of its own. See [`crate::steering::keep_right`].
    pub fn retreat_direction(&self, grid: &DensityGrid<V>, steering: &SteeringConfig) -> Option<V> {
        let Self { position, ahead, waited, half } = *self;
        if waited < steering.patience_s && half != Some(CorridorHalf::Left) {
            return None;
        }
        let (open, between_walls) = (steering.retreat_squares, steering.retreat_squares_between_walls);
        let far = if half.is_some() { between_walls } else { open };
        let (ratio, by, own_half) = (steering.outnumbered_ratio, steering.outnumbered_by, steering.own_half_factor);
        let at = position * grid.per_m;
        let here = grid.square(at);
        let (mut against, mut along) = (here.num_opposed(ahead), here.num_agreeing(ahead));
        for k in 1..=far {
            let step = ahead * k as f32;
            against += grid.square(at + step).num_opposed(ahead);
            along += grid.square(at - step).num_agreeing(ahead);
        }
        let (stronger, more) = match half {
            None => (ratio, by),
            Some(CorridorHalf::Left) => (ratio / own_half, 0.0),
            Some(CorridorHalf::Right) => (ratio * own_half, 2.0 * by),
        };
        // An agent that just stands counts as half, and does not make others step back alone.
        let is_weaker = against >= 1.0 && against > stronger * along + more;
        is_weaker.then(|| backward_direction(ahead, 1.0, steering))
    }

    /// Direction in which an agent steps back by chance, after a long wait in a dense crowd: of equal groups that block
    /// each other, or of two side by side in a door, none is the weaker. Some step back, now these, now those, and the
    /// jam comes loose.
    pub fn random_retreat_direction(
        &self,
        agent: u32,
        time: f64,
        grid: &DensityGrid<V>,
        steering: &SteeringConfig,
    ) -> Option<V> {
        let at = self.position * grid.per_m;
        let is_dense = || grid.square(at).num + grid.square(at + self.ahead).num >= JAM;
        if self.waited < steering.patience_in_jams_s || !is_dense() {
            return None;
        }
        let lot = random_lot(agent, (time / steering.jam_turn_s) as u32);
        let side = if lot & 1 == 0 { 1.0 } else { -1.0 };
        let share = (lot >> 8) as f32 / (u32::MAX >> 8) as f32;
        (share < steering.jam_share).then(|| backward_direction(self.ahead, side, steering))
    }
}

/// Back from where one wants to go, and to the right (1) or to the left (-1).
fn backward_direction<V: Space>(ahead: V, side: f32, steering: &SteeringConfig) -> V {
    let aside = ahead.right() * (side * steering.retreat_right);
    (ahead * -steering.retreat_back + aside).unit_and_length().0
}

/// A number by chance, the same at any time and in any order of agents (Steele, Lea and Flood 2014, SplitMix).
fn random_lot(agent: u32, turn: u32) -> u32 {
    let mut x = (u64::from(agent) << 32 | u64::from(turn)).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ x >> 31) >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn blocked(position: Vec2, ahead: Vec2) -> BlockedAgent<Vec2> {
        BlockedAgent { position, ahead, waited: 1.0, half: None }
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
        let direction =
            blocked(ahead, Vec2::NEG_X).retreat_direction(&grid, &SteeringConfig::DEFAULT).expect("the two give way");
        assert!(direction.x > 0.3 && direction.dot(Vec2::NEG_X.right()) > 0.3, "{direction}");
        assert_eq!(
            blocked(Vec2::X * side * 0.5, Vec2::X).retreat_direction(&grid, &SteeringConfig::DEFAULT),
            None,
            "the twelve do not"
        );
        assert_eq!(
            blocked(Vec2::Y * 20.0, Vec2::X).retreat_direction(&grid, &SteeringConfig::DEFAULT),
            None,
            "an empty place"
        );
    }

    #[test]
    fn some_step_back_by_chance_after_a_long_wait() {
        let steering = SteeringConfig::default();
        let waits = |waited| BlockedAgent { waited, ..blocked(Vec2::ZERO, Vec2::X) };
        let mut grid = DensityGrid::new(1.2, Vec2::splat(60.0), 100);
        let alone = waits(10.0);
        assert!((0..1000).all(|agent| alone.random_retreat_direction(agent, 1.0, &grid, &steering).is_none()));
        (0..4).for_each(|_| grid.add(Vec2::ZERO, Vec2::ZERO, Vec2::X));
        let back = |agent, time, waited| waits(waited).random_retreat_direction(agent, time, &grid, &steering);
        let ways: Vec<Vec2> = (0..1000).filter_map(|agent| back(agent, 1.0, 10.0)).collect();
        assert!((ways.len() as f32 - 1000.0 * steering.jam_share).abs() < 50.0, "{}", ways.len());
        let to_the_right = ways.iter().filter(|w| w.dot(Vec2::X.right()) > 0.0).count();
        assert!(to_the_right * 10 > 4 * ways.len() && to_the_right * 10 < 6 * ways.len(), "{to_the_right}");
        assert!(ways.iter().all(|w| w.x < 0.0));
        assert!((0..1000).all(|agent| back(agent, 1.0, 1.0).is_none()), "not at once");
        let turns = (0..100).filter(|i| back(7, 2.0 * f64::from(*i) + 1.0, 10.0).is_some()).count();
        assert!((10..60).contains(&turns), "everybody at some time: {turns}");
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
            let yields = |half, waited| {
                BlockedAgent { half, waited, ..blocked }.retreat_direction(&grid, &SteeringConfig::DEFAULT).is_some()
            };
            assert!(yields(Some(CorridorHalf::Left), 1.0) && yields(Some(CorridorHalf::Left), 0.5));
            assert!(!yields(Some(CorridorHalf::Right), 1.0) && !yields(None, 1.0));
        }
    }
}
