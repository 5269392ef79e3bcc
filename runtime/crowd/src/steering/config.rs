//! The numbers of steering that were tuned by trial.

use serde::{Deserialize, Serialize};
use throng_base::{Result, error::check_value};

/// A number or numbers that can be out of a range.
trait CheckRange {
    /// The first number that is not between two others.
    fn first_outside(&self, least: f32, most: f32) -> Option<f32>;
}

impl CheckRange for f32 {
    fn first_outside(&self, least: f32, most: f32) -> Option<f32> {
        (!(least..=most).contains(self)).then_some(*self)
    }
}

impl CheckRange for f64 {
    fn first_outside(&self, least: f32, most: f32) -> Option<f32> {
        (!(f64::from(least)..=f64::from(most)).contains(self)).then_some(*self as f32)
    }
}

impl CheckRange for u32 {
    fn first_outside(&self, least: f32, most: f32) -> Option<f32> {
        (*self as f32).first_outside(least, most)
    }
}

impl<const N: usize> CheckRange for [f32; N] {
    fn first_outside(&self, least: f32, most: f32) -> Option<f32> {
        self.iter().find_map(|n| n.first_outside(least, most))
    }
}

/// A config of numbers, each with its default and its range: `/// What it does.`, `name: type = default, least, most;`.
macro_rules! config_of_numbers {
    ($(#[$about:meta])* $config:ident { $($(#[$doc:meta])* $name:ident: $kind:ty = $default:expr, $least:expr, $most:expr;)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $config {
            $($(#[$doc])* #[doc = concat!(" Default ", stringify!($default), ".")] pub $name: $kind,)*
        }

        impl Default for $config {
            fn default() -> Self {
                Self::DEFAULT
            }
        }

        impl $config {
            pub(crate) const DEFAULT: Self = Self { $($name: $default),* };

            /// Every number is within its range.
            pub(crate) fn check(&self) -> Result<()> {
                $(
                    let outside = self.$name.first_outside($least, $most);
                    let what = concat!("steering.", stringify!($name));
                    let expected = concat!("between ", stringify!($least), " and ", stringify!($most));
                    check_value(what, None, outside.map_or(f64::NAN, f64::from), outside.is_none(), expected)?;
                )*
                Ok(())
            }
        }
    };
}

config_of_numbers! {
/// Steering of agents, beyond the parameters of their [`crate::ForceField`]: the same for all agents of a crowd.
///
/// The defaults were found by trial, mostly in corridors 1.6 to 14 m wide with 38 to 2000 agents. Squares are those of
/// the density grid, whose side is [`SteeringConfig::square_radii`] times the largest radius.
SteeringConfig {
    // Plans.
    /// Tries for a safe plan near the desired one before an agent brakes (1 to 20).
    plan_tries: u32 = 6, 1.0, 20.0;
    /// Length of each try after the second, as a share of the one before: the first push away from an obstruction often
    /// is enough. With 0.6 for all tries, agents act a tenth more often and progress no faster (0.1 to 1).
    retry_length: f32 = 0.8, 0.1, 1.0;
    /// Factor by which a push away from an obstruction exceeds a linear guess (1 to 2).
    push_factor: f32 = 1.1, 1.0, 2.0;
    /// Wait of a blocked agent, in smallest intervals; no plan may be longer, as cells are sized by it (1 to 10).
    blocked_intervals: f32 = 2.0, 1.0, 10.0;
    /// Factor by which an agent that yields may exceed its desired speed (1 to 2).
    largest_speed_ratio: f32 = 1.25, 1.0, 2.0;

    // Progress.
    /// Speed below which an agent does not pass its goal by much (m/s, 0 to 10).
    slow_mps: f32 = 0.1, 0.0, 10.0;
    /// Distance toward the goal that counts as progress (m, 0 to 10).
    progress_m: f32 = 0.1, 0.0, 10.0;
    /// Time without progress after which an agent is stuck (s, 0.1 to 1000).
    stuck_after_s: f64 = 10.0, 0.1, 1000.0;

    // Ways.
    /// Time after which an agent plans its path again (s, 0.1 to 100).
    look_s: f64 = 1.0, 0.1, 100.0;
    /// Distance from its aim at a corner at which it plans again (m, 0.01 to 10).
    corner_m: f32 = 0.6, 0.01, 10.0;
    /// Distance between the places at a corner that an agent compares (m, 0.1 to 10).
    place_m: f32 = 1.2, 0.1, 10.0;
    /// Excess length of a path up to which it is compared with the shortest (m, 0 to 1000).
    detour_m: f32 = 6.0, 0.0, 1000.0;
    /// Cost of each oncoming agent at a corner, as a length of path (m, 0 to 100).
    oncoming_cost_m: f32 = 1.0, 0.0, 100.0;
    /// Cost of each agent that goes the same way, as a length of path (m, 0 to 100).
    crowd_cost_m: f32 = 0.3, 0.0, 100.0;
    /// Cost of each agent that comes toward a place from beyond it, as a length of path, so that an agent at a row of
    /// doors takes one that others do not stream out of (m, 0 to 100).
    beyond_cost_m: f32 = 0.5, 0.0, 100.0;
    /// Cost of passing a corner on its left, where many come, as a length of path (m, 0 to 100).
    pass_left_m: f32 = 4.0, 0.0, 100.0;
    /// Cost of each metre that a place is in the left half, where many come, as a length of path: to go round the
    /// outside of a bend takes up to two metres for each (0 to 100).
    left_half_cost: f32 = 2.0, 0.0, 100.0;
    /// Advantage that another place needs over the present aim (m, 0 to 100).
    keep_aim_m: f32 = 0.5, 0.0, 100.0;

    // Speed.
    /// Time for which the way has to be free for the desired speed: 1000 agents in the `corridor` of the bench progress
    /// with 0.95 m/s with 0.55 s, with 0.98 m/s with 0.45 s and with 1.0 m/s with 0.4 s; with less, some block each other
    /// for longer (s, 0.01 to 10).
    clear_s: f32 = 0.4, 0.01, 10.0;
    /// Places straight ahead whose density gives the speed of people there (squares, 0 to 100).
    density_places: [f32; 3] = [1.0, 2.0, 3.0], 0.0, 100.0;
    /// Share of the sum of two radii within which one agent is in front of the other and not beside it (0 to 1).
    front_width: f32 = 0.88, 0.0, 1.0;
    /// Distance to the goal from which on an agent keeps less and less distance to standing agents (m, 0.01 to 100).
    pressing_m: f32 = 4.0, 0.01, 100.0;

    // Directions.
    /// Share of their distance that the radii of two may take up: an agent that touches another may still slide past
    /// (0.5 to 1).
    closest: f32 = 0.95, 0.5, 1.0;
    /// Difference in score to the best direction up to which another one still counts: headings then change smoothly
    /// (0.001 to 10).
    softness: f32 = 0.1, 0.001, 10.0;
    /// Cosine of the angle within which a direction is near another (-1 to 1).
    near_cosine: f32 = 0.75, -1.0, 1.0;
    /// Distance within which others are considered first, in sums of two radii (1 to 100).
    at_hand_radii: f32 = 3.0, 1.0, 100.0;
    /// Cosine of the angle to a solid below which a direction leads past it (0 to 1).
    past_cosine: f32 = 0.02, 0.0, 1.0;
    /// Gap to a solid that counts as none (m, 0 to 1).
    touching_m: f32 = 0.02, 0.0, 1.0;
    /// Share of [`crate::ForceField::right`] that counts without oncoming agents. With all of it, agents that walk behind
    /// each other drift to the right; with none, large head-on crowds take longer to sort (0 to 1).
    right_among_own: f32 = 0.5, 0.0, 1.0;

    // The crowd seen from afar.
    /// Time between two fillings of the density grid (s, 0.01 to 10).
    refresh_s: f64 = 0.25, 0.01, 10.0;
    /// Side of a square of the density grid, in radii of the largest agent (1 to 100).
    square_radii: f32 = 4.0, 1.0, 100.0;
    /// Places along each direction where the grid is read, nearest first: so far away that no agent finds itself there
    /// (squares, 1 to 100).
    lane_places: [f32; 3] = [1.7, 3.2, 4.7], 1.0, 100.0;
    /// Number of these whose agents' speed counts; farther away, only their intent counts (0 to 3).
    crowding_places: u32 = 2, 0.0, 3.0;
    /// Places straight ahead where oncoming agents are looked for (squares, 0 to 100).
    ahead_places: [f32; 5] = [3.0, 5.0, 7.0, 9.0, 11.0], 0.0, 100.0;
    /// Places straight ahead where oncoming agents are looked for still farther away, where no walls guide an agent.
    /// 1000 agents on a disc that go to the opposite points turn aside before they are dense, and progress with 0.7 m/s
    /// in place of 0.5 m/s (squares, 0 to 100).
    far_places: [f32; 4] = [13.5, 16.0, 19.0, 22.0], 0.0, 100.0;
    /// Places straight ahead, from its own on, whose oncoming agents count as in its way already (squares, 0 to 100).
    facing_places: [f32; 3] = [0.0, 1.0, 2.0], 0.0, 100.0;
    /// Agents of a square that want the same way beyond which more make it no better. Without a limit all draw together:
    /// 2000 agents in the `corridor` of the bench progress with 0.66 m/s in place of 0.73 m/s. With 0, 39 of them are
    /// stuck in place of 3 (0 to 1000).
    most_agreed: f32 = 1.0, 0.0, 1000.0;
    /// Agents coming toward one for which it turns aside with all its will; fewer do less with the third power, as it
    /// passes a few one by one (0.1 to 1000).
    many_coming: f32 = 4.0, 0.1, 1000.0;
    /// Agents of a square to the right from which on an agent turns aside less, and with which it does not (0 to 1000).
    full_square: [f32; 2] = [3.0, 5.0], 0.0, 1000.0;
    /// Time for which a direction has to be free to be wholly worth turning to (s, 0.01 to 10).
    open_s: f32 = 0.5, 0.01, 10.0;

    // Between walls.
    /// Cosine of the angle to its right or left within which a wall is beside an agent (0 to 1).
    wall_cosine: f32 = 0.7, 0.0, 1.0;
    /// Advantage of directions to the right between walls when a crowd comes. 500 agents in a corridor of 7 m progress
    /// with 0.58 m/s with 0.2, with 0.76 m/s with 0.6, with 0.85 m/s with 1.2 to 2.0; with 2.0 narrow ones take a
    /// little longer (0 to 100).
    keep_right: f32 = 1.2, 0.0, 100.0;
    /// Growth of this advantage toward the left wall where no wall is at hand, never beyond that at hand. With 0, 500
    /// agents in a corridor of 7 m progress with 0.57 m/s, with 1 with 0.80 m/s, with 2 to 4 with 0.85 m/s (0 to 100).
    keep_right_afar: f32 = 2.0, 0.0, 100.0;
    /// Largest distances at which a wall beside an agent shows in which half of the passage it is: of any wall, and of
    /// long ones, see `wall_seen_share`. With 20 m for all, walls of side arms count at crossings: two streams through
    /// a bend of 10 m progress with 0.66 m/s in place of 0.74 m/s, and 90 of 400 stand for 10 s in place of 6. With 5 m
    /// for all, half of two crowds of 5000 that meet in a street of 33 m stand for 10 s, in place of a fifth (m, 0 to
    /// 1000).
    wall_seen_m: [f32; 2] = [5.0, 20.0], 0.0, 1000.0;
    /// Largest distance at which a long wall counts so, as a share of its length (0 to 1).
    wall_seen_share: f32 = 0.05, 0.0, 1.0;
    /// Shortest wall that counts so; anything shorter is a post (m, 0 to 1000).
    wall_length_m: f32 = 3.0, 0.0, 1000.0;
    /// Farthest that a wall is at hand. With 1 m, corridors of 3 m jam; with 3 m, those of 7 m take a tenth longer (m, 0
    /// to 1000).
    wall_at_hand_m: f32 = 2.0, 0.0, 1000.0;

    // Stepping back. Without it, a third of small groups never get through corridors, and none of the large ones.
    /// Time without progress after which an agent may step back: about what it takes to go round an agent. 0.3 s and 2 s
    /// make no difference beyond that of seeds (s, 0 to 100).
    patience_s: f64 = 0.7, 0.0, 100.0;
    /// Time without progress after which an agent may step back in the left half of the passage between walls. With 0.7
    /// s narrow corridors take a tenth longer, with 0.2 s those of 3 m and more do (s, 0 to 100).
    patience_on_left_s: f64 = 0.4, 0.0, 100.0;
    /// Distance within which an agent counts agents against it and behind it. With 3, three times as many of the agents
    /// that cross each other at a junction of three corridors stand for 10 s (squares, 0 to 100).
    retreat_squares: u32 = 6, 0.0, 100.0;
    /// Distance within which an agent counts them between walls, where whole columns have to back out. Of 300 agents in
    /// a corridor of 2 m, 118 get through within 300 s with 12 and 196 with 18; with 32 corridors of 3 m take longer
    /// (squares, 0 to 100).
    retreat_squares_between_walls: u32 = 18, 0.0, 100.0;
    /// Oncoming agents for each agent that goes its way, from which on it steps back (0.1 to 100).
    outnumbered_ratio: f32 = 1.3, 0.1, 100.0;
    /// Number by which oncoming agents have to exceed the others. With 3, two streams through doors of 1.2 to 2.4 m
    /// more often block each other for 10 s (0 to 100).
    outnumbered_by: f32 = 1.0, 0.0, 100.0;
    /// Factor by which more (fewer) oncoming agents are needed in the right (left) half of the passage between walls.
    /// 100 agents in a corridor of 3 m progress with 0.44 m/s with 1.5, with 0.54 m/s with 3, with 0.64 m/s with 6 and
    /// 12 (1 to 100).
    own_half_factor: f32 = 6.0, 1.0, 100.0;
    /// Backward part of the direction of an agent that steps back (-1 to 1).
    retreat_back: f32 = 0.57, -1.0, 1.0;
    /// Rightward part of it: more, as the others keep to their own right and leave room. Straight back, wide corridors
    /// with 8 agents take a third longer (-1 to 1).
    retreat_right: f32 = 0.8, -1.0, 1.0;
    /// Time without progress after which an agent may step back by chance, whatever is in its way. Without it, two side
    /// by side in a door of twice their width stay there for good (s, 0 to 1000).
    patience_in_jams_s: f64 = 3.0, 0.0, 1000.0;
    /// Share of those that do so at a time (0 to 1).
    jam_share: f32 = 0.3, 0.0, 1.0;
    /// Duration of a turn of stepping back; then others are chosen (s, 0.1 to 100).
    jam_turn_s: f64 = 2.0, 0.1, 100.0;
    /// Share of its desired speed with which an agent steps back. Half of it, or all, make no difference (0 to 1).
    retreat_speed: f32 = 0.84, 0.0, 1.0;

    // The velocity that bodies follow.
    /// How much a velocity changes by itself, for the filter of [`crate::Crowd::smooth_velocity`] (m2/s3, 0.001 to 1000).
    filter_wander: f32 = 2.0, 0.001, 1000.0;
    /// Variance of an observed velocity that is sway (m2/s2, 0.001 to 1000).
    filter_sway: f32 = 0.1, 0.001, 1000.0;
}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_numbers_out_of_range_by_name() {
        assert!(SteeringConfig::default().check().is_ok());
        let places = SteeringConfig { lane_places: [1.7, f32::NAN, 4.7], ..SteeringConfig::default() };
        let tries = SteeringConfig { plan_tries: 0, ..SteeringConfig::default() };
        for (config, name) in [(places, "steering.lane_places"), (tries, "steering.plan_tries")] {
            let message = config.check().unwrap_err().to_string();
            assert!(message.contains(name) && message.contains("between 1.0 and"), "{message}");
        }
    }
}
