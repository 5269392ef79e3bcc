//! The far field: which directions the crowd at large makes better or worse.

use crate::steering::density_grid::DensityGrid;
use crate::{ForceField, Space, steering::config::SteeringConfig, steering::sight::DIRECTIONS};

/// Reaction of an agent to others that come toward it from afar.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FarFieldBias {
    /// Number of oncoming agents, without those farther still.
    pub coming: f32,
    /// Added to the scores of directions to the right.
    pub to_the_right: f32,
    /// Bonus of directions to the right where there is room.
    pub evades: f32,
}

/// Numbers of agents that come toward one that goes along a unit vector, or want to: from afar, and from farther still.
/// None from beyond its goal, as if the path led straight on.
///
/// - `left`: distance to its goal (m).
#[inline]
pub fn oncoming<V: Space>(grid: &DensityGrid<V>, place: V, ahead: V, left: f32, steering: &SteeringConfig) -> [f32; 2] {
    let (at, near) = (place * grid.per_m, left * grid.per_m);
    let opposed = |k: &f32| if *k <= near { grid.square(at + ahead * *k).num_opposed(ahead) } else { 0.0 };
    [steering.ahead_places.iter().map(opposed).sum(), steering.far_places.iter().map(opposed).sum()]
}

/// Prefetches the squares that [`oncoming`] reads.
#[inline]
pub(crate) fn prefetch_oncoming<V: Space>(grid: &DensityGrid<V>, position: V, ahead: V, steering: &SteeringConfig) {
    let at = position * grid.per_m;
    grid.prefetch(steering.ahead_places.iter().chain(&steering.far_places).map(|&k| at + ahead * k));
}

/// Added to the scores of directions to the right in the open, where so many come toward an agent: two crowds that meet head-on
/// slide past each other instead of pressing, and agents that cross in one place go round it. Between walls, see
/// [`crate::steering::keep_right`].
#[inline]
pub(crate) fn evasion_bias(field: &ForceField, coming: f32, steering: &SteeringConfig) -> f32 {
    let share = (coming / steering.many_coming).min(1.0);
    field.evading * share * share * share
}

/// Number of near agents that come toward one that goes along a unit vector, or want to.
#[inline]
pub(crate) fn num_facing<V: Space>(grid: &DensityGrid<V>, position: V, ahead: V, steering: &SteeringConfig) -> f32 {
    let at = position * grid.per_m;
    steering.facing_places.map(|k| grid.square(at + ahead * k).num_opposed(ahead)).iter().sum()
}

/// View of an agent on the far field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FarFieldView<'a, V> {
    pub position: V,
    /// Candidate directions; the first one is the desired one.
    pub directions: &'a [V; DIRECTIONS],
    /// Desired speed (m/s).
    pub speed: f32,
    /// Distance to its goal, beyond which nothing matters (m).
    pub distance_left: f32,
}

impl<V: Space> FarFieldView<'_, V> {
    /// Preference of each direction, with its component to the right and the time for which it is free.
    ///
    /// Worse where others stand or come toward the agent, and where they want to go against it, even if they stand;
    /// better where they want to go its way. So agents with the same goal follow each other, and lanes form.
    ///
    /// - `evasion_bias`: bonus of the right where there is room, see [`evasion_bias`].
    #[inline]
    pub fn preferences(
        &self,
        field: &ForceField,
        grid: &DensityGrid<V>,
        evades: f32,
        side: &[f32; DIRECTIONS],
        free: &[f32; DIRECTIONS],
        steering: &SteeringConfig,
    ) -> [f32; DIRECTIONS] {
        let mut better = [0.0; DIRECTIONS];
        let near = self.distance_left * grid.per_m;
        if self.speed <= 0.0 || near < steering.lane_places[0] {
            return better;
        }
        let (at, ahead) = (self.position * grid.per_m, self.directions[0]);
        let per_speed = self.speed.recip();
        if field.crowding > 0.0 || field.lanes > 0.0 {
            for (better, &direction) in better.iter_mut().zip(self.directions) {
                for (place, &k) in steering.lane_places.iter().enumerate().take_while(|(_, k)| **k <= near) {
                    let square = grid.square(at + direction * k);
                    *better += field.lanes
                        * (square.num_agreeing(ahead).min(steering.most_agreed) - square.num_opposed(ahead));
                    if place < steering.crowding_places as usize {
                        *better -= field.crowding * square.obstruction(direction * per_speed);
                    }
                }
            }
        }
        if evades > 0.0 {
            let aside = evades * self.room_to_right(grid, at, steering.full_square);
            for i in 0..DIRECTIONS {
                let open = if side[i] > 0.0 { (free[i] / steering.open_s).min(1.0) } else { 1.0 };
                better[i] += aside * side[i] * open;
            }
        }
        better
    }

    /// Room to its right for turning aside (0 to 1).
    #[inline]
    fn room_to_right(&self, grid: &DensityGrid<V>, at: V, full: [f32; 2]) -> f32 {
        let ahead = self.directions[0];
        let right = at + ahead.right();
        let there = grid.square(right).num.max(grid.square(right + ahead).num);
        ((full[1] - there) / (full[1] - full[0])).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    /// A place in squares from the middle of an occupied square.
    fn place(grid: &DensityGrid<Vec2>, at: Vec2) -> Vec2 {
        (at + 0.5) * grid.side()
    }

    /// Preferences of an agent there that goes along X.
    fn prefer(grid: &DensityGrid<Vec2>, left: f32) -> [f32; DIRECTIONS] {
        let directions = Vec2::X.fan();
        let far = FarFieldView {
            position: place(grid, Vec2::ZERO),
            directions: &directions,
            speed: 1.3,
            distance_left: left,
        };
        let side = directions.map(|d| d.dot(Vec2::X.right()));
        let field = ForceField { lanes: 0.08, ..ForceField::default() };
        let coming = oncoming(grid, far.position, Vec2::X, left, &SteeringConfig::DEFAULT).iter().sum();
        far.preferences(
            &field,
            grid,
            evasion_bias(&field, coming, &SteeringConfig::DEFAULT),
            &side,
            &[9.0; DIRECTIONS],
            &SteeringConfig::DEFAULT,
        )
    }

    #[test]
    fn prefers_places_with_the_same_intent() {
        let mut grid = DensityGrid::new(1.2, Vec2::splat(60.0), 100);
        // Two columns that stand: at 37 degrees to the right they want its way, to the left the other one.
        for (direction, intent) in [(Vec2::X.fan()[3], Vec2::X), (Vec2::X.fan()[4], Vec2::NEG_X)] {
            for k in SteeringConfig::default().lane_places {
                grid.add(place(&grid, direction * k), Vec2::ZERO, intent);
            }
        }
        let better = prefer(&grid, 50.0);
        assert!(better[3] > 0.1 && better[4] < -0.1, "{better:?}");
        assert_eq!(prefer(&grid, 1.0), [0.0; DIRECTIONS], "all of it is beyond the goal");
    }

    #[test]
    fn evades_many_from_afar_and_few_hardly() {
        let steering = SteeringConfig::default();
        let field = ForceField::default();
        let mut grid = DensityGrid::new(1.2, Vec2::splat(60.0), 100);
        for k in SteeringConfig::default().far_places {
            grid.add(place(&grid, Vec2::X * k), Vec2::NEG_X * 1.3, Vec2::NEG_X);
        }
        let at = place(&grid, Vec2::ZERO);
        assert_eq!(oncoming(&grid, at, Vec2::X, 50.0, &steering), [0.0, 4.0]);
        assert_eq!(oncoming(&grid, at, Vec2::X, 10.0, &steering), [0.0, 0.0], "its way ends before they come");
        assert_eq!(
            (evasion_bias(&field, 4.0, &steering), evasion_bias(&field, 9.0, &steering)),
            (field.evading, field.evading)
        );
        assert!(evasion_bias(&field, 1.0, &steering) < 0.02 * field.evading);
    }

    #[test]
    fn turns_right_for_oncoming_crowd_while_there_is_room() {
        let mut grid = DensityGrid::new(1.2, Vec2::splat(60.0), 100);
        for k in SteeringConfig::default().ahead_places {
            grid.add(place(&grid, Vec2::X * k), Vec2::NEG_X * 1.3, Vec2::NEG_X);
        }
        let better = prefer(&grid, 50.0);
        assert!(better[3] > better[0] + 0.05 && better[3] > better[4] + 0.1, "{better:?}");
        for _ in 0..5 {
            grid.add(place(&grid, Vec2::X.right()), Vec2::X, Vec2::X);
        }
        let better = prefer(&grid, 50.0);
        assert!((better[3] - better[4]).abs() < 0.02, "the right side is full: {better:?}");
    }
}
