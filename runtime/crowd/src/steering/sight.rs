//! Looking ahead: how long each of several directions is free, which speed it allows, and which one to take.

use crate::steering::density_grid::DensityGrid;
use crate::steering::far_field::{FarFieldBias, FarFieldView, num_facing};
use crate::steering::forces::{SteeredAgent, contact_horizon};
use crate::{ForceField, Space, space::solid::ConvexSolid, steering::config::SteeringConfig};

/// Number of directions that are looked in.
pub(crate) const DIRECTIONS: usize = 8;
/// A time that stands for never (s).
const NEVER: f32 = 1e3;
/// Most steps towards a solid along one direction; at a wall, two are enough.
const MAX_STEPS_TO_SOLID: usize = 5;
/// Room for rounding (m).
pub(crate) const ROUNDING: f32 = 0.01;

/// Another agent or moving obstacle as an agent sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenNeighbour<V> {
    /// Offset from the seeing agent (m).
    pub offset: V,
    /// (m/s)
    pub velocity: V,
    /// Distance of the centres (m).
    pub distance: f32,
    /// Sum of the radii (m).
    pub radii: f32,
    /// False for a moving obstacle, which stops for no agent.
    pub yields: bool,
}

/// View of an agent in each direction of [`Space::fan`], at its desired speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectionalSight<'a, V> {
    steering: &'a SteeringConfig,
    directions: [V; DIRECTIONS],
    /// Coordinates of the directions.
    axes: [[f32; DIRECTIONS]; 3],
    speed: f32,
    /// Time to a contact below which that takes speed, see [`ForceField::horizon_s`] (s).
    horizon: f32,
    /// Time until something is in the way (s).
    free: [f32; DIRECTIONS],
    /// Share of the speed that is kept, see [`DirectionalSight::see_agent`] (0 to 1).
    open: [f32; DIRECTIONS],
}

impl<'a, V: Space> DirectionalSight<'a, V> {
    /// View along a unit vector, still empty.
    ///
    /// - `horizon`: see [`ForceField::horizon_s`] (s).
    #[inline]
    pub fn looking_along(ahead: V, speed: f32, horizon: f32, steering: &'a SteeringConfig) -> Self {
        let directions = ahead.fan();
        let axes = [0, 1, 2].map(|axis| directions.map(|d| d.coordinates()[axis]));
        Self { steering, directions, axes, speed, horizon, free: [NEVER; DIRECTIONS], open: [1.0; DIRECTIONS] }
    }

    /// Components of a vector along all directions.
    #[inline(always)]
    fn along_each(&self, v: V) -> [f32; DIRECTIONS] {
        let (c, axes) = (v.coordinates(), &self.axes);
        let mut out = [0.0; DIRECTIONS];
        for i in 0..DIRECTIONS {
            let flat = c[0] * axes[0][i] + c[1] * axes[1][i];
            out[i] = if V::DIMENSIONS == 3 { flat + c[2] * axes[2][i] } else { flat };
        }
        out
    }

    /// Adds all agents that are not farther behind than `behind` and may be met before `latest`: the near ones first,
    /// as few of the others can be met before them in any direction.
    #[inline(always)]
    pub fn see_all(&mut self, seen: &[SeenNeighbour<V>], behind: f32, comfort: f32, latest: f32) {
        let ahead = self.directions[0];
        let at_hand = self.steering.at_hand_radii;
        let is_near = |other: &SeenNeighbour<V>| other.distance < at_hand * other.radii;
        for other in seen {
            if is_near(other) && other.offset.dot(ahead) > behind {
                self.see_agent(other, comfort);
            }
        }
        let most = |all: &[f32; DIRECTIONS]| all.iter().fold(0.0, |a: f32, &b| a.max(b));
        // A later contact takes neither time nor speed from any direction.
        let last = most(&self.free).max(self.horizon * most(&self.open)).min(latest);
        for other in seen {
            // Straight at them it comes nearer with its speed, less their own speed away from it.
            let closing = self.speed * other.distance - other.offset.dot(other.velocity);
            let soon = (other.distance - other.radii - comfort - ROUNDING) * other.distance < last * closing;
            if !is_near(other) && soon && other.offset.dot(ahead) > behind {
                self.see_agent(other, comfort);
            }
        }
    }

    /// Adds another agent: for each direction, the time of the first contact if that agent keeps its velocity, and the
    /// share of the speed that can be kept.
    ///
    /// Behind another agent it loses its excess of speed over that one, and all the less the later it gets there;
    /// straight before one that stands or comes toward it, all. Only the part along the line of centres counts: an
    /// agent that touches another one's side can slide past. The score uses the speed that a direction allows, not the
    /// time for which it is free: else an agent behind a slightly slower one finds its way blocked and turns aside, and
    /// in dense streams all do so all the time, into each other's ways. 1000 agents that walk one way, three on two
    /// square metres, progress with 1.11 m/s in place of 0.83 m/s.
    #[inline(always)]
    pub fn see_agent(&mut self, other: &SeenNeighbour<V>, comfort: f32) {
        let radii = (other.radii + comfort).min(other.distance * self.steering.closest);
        let gap = other.distance * other.distance - radii * radii;
        let (toward, along) = (self.along_each(other.offset), self.along_each(other.velocity));
        let recede = other.offset.dot(other.velocity);
        let squares = self.speed * self.speed + other.velocity.length_squared();
        let (per_full, per_horizon) = ((other.distance * self.speed).max(1e-6).recip(), self.horizon.recip());
        let (mut times, mut lost) = ([NEVER; DIRECTIONS], [0.0f32; DIRECTIONS]);
        for i in 0..DIRECTIONS {
            // Of the relative motion: its component toward the other one, and the square of its speed.
            let toward = self.speed * toward[i] - recede;
            let square = squares - 2.0 * self.speed * along[i];
            let root = toward * toward - square * gap;
            let time = gap / (toward + root.max(0.0).sqrt()).max(1e-6);
            let meets = toward > 0.0 && root > 0.0;
            times[i] = if meets { time } else { NEVER };
            lost[i] = if meets { (toward * per_full).min(1.0) } else { 0.0 };
        }
        for i in 0..DIRECTIONS {
            self.free[i] = self.free[i].min(times[i]);
            self.open[i] = self.open[i].min(1.0 - lost[i] * (1.0 - times[i] * per_horizon).max(0.0));
        }
    }

    /// Adds a static solid: steps to the plane that touches it at its nearest point, as it is convex and wholly beyond,
    /// and repeats from there.
    pub fn see_solid(&mut self, solid: &ConvexSolid<V>, x: V, radius: f32) {
        let reach = self.speed * self.horizon;
        let (nearest, distance) = solid.direction_and_distance(x);
        if distance - radius > reach {
            return;
        }
        for ((direction, free), open) in self.directions.iter().zip(&mut self.free).zip(&mut self.open) {
            // An agent that it follows may be met before a wall, and yet take less of its speed.
            let farthest = reach.min(self.speed * free.max(*open * self.horizon));
            let (mut distance, mut away, mut gap) = (0.0, nearest, distance - radius);
            for _ in 0..MAX_STEPS_TO_SOLID {
                let toward = -direction.dot(away);
                if toward < self.steering.past_cosine {
                    break;
                }
                if gap < self.steering.touching_m {
                    let time = distance / self.speed.max(1e-3);
                    (*free, *open) = (free.min(time), open.min(time / self.horizon));
                    break;
                }
                distance += gap / toward;
                if distance > farthest {
                    break;
                }
                let (next, distance) = solid.direction_and_distance(x + *direction * distance);
                (away, gap) = (next, distance - radius);
            }
        }
    }

    /// Earliest contact in any direction (s).
    #[cfg(test)]
    pub fn earliest_contact(&self) -> f32 {
        self.free.iter().fold(NEVER, |a, &b| a.min(b))
    }

    /// Direction to take, and the time for which it is free. A direction scores for the speed it allows, against
    /// detours, for its preference by the far field (see [`FarFieldView`]) and for the present velocity. Of two sides the right
    /// one is a little better where the way is not free, and better anyway by the agent's `lean`.
    #[inline]
    pub fn choose_direction(
        &self,
        field: &ForceField,
        me: &SteeredAgent<V>,
        grid: &DensityGrid<V>,
        lean: &FarFieldBias,
    ) -> (V, f32) {
        let steering = self.steering;
        let right = self.directions[0].right();
        let blocked = 1.0 - self.open[0];
        let (keep, side) = (self.along_each(me.velocity), self.along_each(right));
        let straight = self.along_each(self.directions[0]);
        let far = FarFieldView {
            position: me.position,
            directions: &self.directions,
            speed: self.speed,
            distance_left: me.distance_left,
        };
        let mut scores = far.preferences(field, grid, lean.evades, &side, &self.free, steering);
        let looks = blocked > 0.0 && lean.coming < 1.0;
        let faced = if looks { lean.coming + num_facing(grid, me.position, self.directions[0], steering) } else { 1.0 };
        let among_own = steering.right_among_own;
        let to_the_right = lean.to_the_right + field.right * blocked * (among_own + (1.0 - among_own) * faced.min(1.0));
        for i in 0..DIRECTIONS {
            let worth = (1.0 - field.directness + field.directness * straight[i]) * self.open[i];
            scores[i] += worth + field.keeping * keep[i] + to_the_right * side[i];
        }
        let mut best = 0;
        for i in 1..DIRECTIONS {
            if scores[i] > scores[best] + 1e-4 {
                best = i;
            }
        }
        let beside = self.along_each(self.directions[best]);
        let (mut heading, mut free, mut sum) = (V::default(), 0.0, 0.0);
        for i in 0..DIRECTIONS {
            let say = scores[i] - scores[best] + steering.softness;
            if say > 0.0 && beside[i] > steering.near_cosine {
                heading += self.directions[i] * say;
                free += self.free[i].min(contact_horizon(field, steering)) * say;
                sum += say;
            }
        }
        (heading.unit_and_length().0, free / sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    fn seen(offset: Vec2, velocity: Vec2) -> SeenNeighbour<Vec2> {
        SeenNeighbour { offset, velocity, distance: offset.length(), radii: 0.6, yields: true }
    }

    #[test]
    fn finds_time_of_contact_in_each_direction() {
        let mut sight = DirectionalSight::looking_along(Vec2::X, 1.3, 2.0, &SteeringConfig::DEFAULT);
        sight.see_agent(&seen(Vec2::new(3.2, 0.0), Vec2::new(-1.3, 0.0)), 0.0);
        assert!((sight.free[0] - 1.0).abs() < 1e-5, "{:?}", sight.free);
        for (direction, free) in sight.directions.iter().zip(sight.free) {
            // Sampled: the first time at which the discs touch.
            let gap = |t: f32| (Vec2::new(3.2 - 1.3 * t, 0.0) - direction * (1.3 * t)).length() - 0.6;
            let first = (0..4000).map(|i| i as f32 * 1e-3).find(|&t| gap(t) <= 0.0);
            assert!((first.unwrap_or(NEVER) - free).abs() < 2e-3, "{direction} {first:?} {free}");
        }
    }

    #[test]
    fn loses_excess_speed_behind_others() {
        let open = |ahead: f32, velocity: f32| {
            let mut sight = DirectionalSight::looking_along(Vec2::X, 1.3, 2.0, &SteeringConfig::DEFAULT);
            sight.see_agent(&seen(Vec2::new(ahead, 0.0), Vec2::X * velocity), 0.0);
            sight.open[0]
        };
        // Met after 1 s, half the horizon: half of what it goes faster is lost.
        assert!((open(1.9, 0.0) - 0.5).abs() < 1e-5, "a standing agent");
        assert!((open(0.86, 1.04) - 0.9).abs() < 1e-5, "an agent at four fifths of its speed");
        assert!((open(3.2, -1.3) - 0.5).abs() < 1e-5, "an oncoming agent counts as standing");
        assert_eq!((open(0.7, 1.3), open(3.3, 0.0)), (1.0, 1.0), "as fast as it is, and met after the horizon");
        assert!((open(1.25, 0.65) - 0.75).abs() < 1e-5, "an agent at half its speed");
    }

    #[test]
    fn order_of_neighbours_and_walls_makes_no_difference() {
        let wall = ConvexSolid::Capsule { from: Vec2::new(1.8, -9.0), to: Vec2::new(1.8, 9.0), radius: 0.0 };
        let ahead = seen(Vec2::new(0.75, 0.0), Vec2::X * 1.1);
        let [mut one, mut other] = [DirectionalSight::looking_along(Vec2::X, 1.3, 2.0, &SteeringConfig::DEFAULT); 2];
        one.see_agent(&ahead, 0.0);
        one.see_solid(&wall, Vec2::ZERO, 0.3);
        other.see_solid(&wall, Vec2::ZERO, 0.3);
        other.see_agent(&ahead, 0.0);
        assert_eq!((one.free, one.open), (other.free, other.open));
        assert!((one.open[0] - 1.5 / 1.3 / 2.0).abs() < 0.02, "the wall, not the agent before it: {:?}", one.open);
    }

    #[test]
    fn follows_slower_agent_and_goes_round_standing_one() {
        let grid = DensityGrid::new(1.2, Vec2::splat(10.0), 10);
        let me = SteeredAgent { velocity: Vec2::X, distance_left: 10.0, ..SteeredAgent::default() };
        let heading = |velocity: f32| {
            let mut sight = DirectionalSight::looking_along(Vec2::X, 1.3, 2.0, &SteeringConfig::DEFAULT);
            sight.see_agent(&seen(Vec2::new(0.9, 0.0), Vec2::X * velocity), 0.0);
            sight.choose_direction(&ForceField::default(), &me, &grid, &FarFieldBias::default()).0
        };
        assert!(heading(1.2).x > 0.98 && heading(0.0).x < 0.95, "{} {}", heading(1.2), heading(0.0));
    }

    /// A skipped neighbour is met after the horizon in each direction, or after another one.
    fn skipped_neighbours_do_not_matter<V: Space>(others: &[([f32; 3], [f32; 3])]) -> Result<(), TestCaseError> {
        let ahead = V::from_coordinates([0.6, -0.8, 0.0]);
        let (mut all, mut some) = (
            DirectionalSight::looking_along(ahead, 1.3, 2.0, &SteeringConfig::DEFAULT),
            DirectionalSight::looking_along(ahead, 1.3, 2.0, &SteeringConfig::DEFAULT),
        );
        let seen: Vec<SeenNeighbour<V>> = others
            .iter()
            .map(|&(x, v)| (V::from_coordinates(x), V::from_coordinates(v)))
            .map(|(offset, velocity)| SeenNeighbour {
                offset,
                velocity,
                distance: offset.length(),
                radii: 0.6,
                yields: true,
            })
            .collect();
        seen.iter().filter(|o| o.offset.dot(ahead) > -0.3).for_each(|o| all.see_agent(o, 0.02));
        some.see_all(&seen, -0.3, 0.02, 2.0);
        prop_assert_eq!(all.free.map(|t| t.min(2.0)), some.free.map(|t| t.min(2.0)));
        prop_assert_eq!(all.open, some.open);
        Ok(())
    }

    proptest! {
        #[test]
        fn skipped_neighbours_do_not_matter_on_the_ground(others in others()) {
            skipped_neighbours_do_not_matter::<Vec2>(&others)?;
        }

        #[test]
        fn skipped_neighbours_do_not_matter_in_the_air(others in others()) {
            skipped_neighbours_do_not_matter::<Vec3>(&others)?;
        }
    }

    fn others() -> impl Strategy<Value = Vec<([f32; 3], [f32; 3])>> {
        let vector = |most: f32| prop::array::uniform3(-most..most);
        proptest::collection::vec((vector(6.0), vector(2.0)), 0..40)
    }

    #[test]
    fn chooses_free_direction() {
        let grid = DensityGrid::new(1.2, Vec2::splat(10.0), 10);
        let field = ForceField::default();
        let me = SteeredAgent { velocity: Vec2::X, distance_left: 10.0, ..SteeredAgent::default() };
        let mut sight = DirectionalSight::looking_along(Vec2::X, 1.3, 2.0, &SteeringConfig::DEFAULT);
        assert!(sight.choose_direction(&field, &me, &grid, &FarFieldBias::default()).0.distance(Vec2::X) < 1e-6);
        // To the left (-y is to the left of +x: the right of (1, 0) is (0, 1)).
        for y in [0.0, 0.6, 1.2] {
            sight.see_agent(&seen(Vec2::new(1.0, y), Vec2::ZERO), 0.0);
        }
        assert!(sight.choose_direction(&field, &me, &grid, &FarFieldBias::default()).0.y < -0.2);
    }
}
