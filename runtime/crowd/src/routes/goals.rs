//! Goals of agents, with their distances from everywhere: computed once, and shared by all agents on the way there.

use crate::routes::streets::{GoalCosts, OpenPoint, Streets};
use glam::{Vec3, Vec3Swizzles};
use std::collections::{BinaryHeap, HashMap, VecDeque};

/// Goals of a crowd that knows its streets. Unused goals are kept until their memory is needed.
#[derive(Clone, Debug, Default)]
pub(crate) struct GoalTable {
    all: Vec<GoalSlot>,
    /// Numbers of known goals, by place.
    known: HashMap<[u32; 3], u32>,
    /// Unused goals, the oldest first, and some that are in use again.
    idle: VecDeque<u32>,
    /// Goals for which there is memory.
    reserved: usize,
    open: BinaryHeap<OpenPoint>,
}

#[derive(Clone, Debug, Default)]
struct GoalSlot {
    place: Option<[u32; 3]>,
    /// Number of subgoals of routes that it is.
    users: u32,
    is_idle: bool,
    costs: GoalCosts,
}

impl GoalTable {
    /// Distances of a goal.
    pub fn costs(&self, number: u32) -> &GoalCosts {
        &self.all[number as usize].costs
    }

    /// Takes memory for one more goal in use, and for one that is computed before the last is released.
    pub fn reserve(&mut self, streets: &Streets) {
        self.reserved += 1;
        let [points, waiting] = streets.sizes();
        self.open.reserve(waiting.saturating_sub(self.open.len()));
        while self.all.len() <= self.reserved {
            self.idle.push_back(self.all.len() as u32);
            self.all.push(GoalSlot { is_idle: true, costs: GoalCosts::with_capacity(points), ..GoalSlot::default() });
        }
        self.known.reserve(2 * self.all.len());
    }

    /// The number of a goal, which has one user more. Allocates nothing where there is memory for it.
    pub fn take_goal(&mut self, streets: &Streets, place: Vec3) -> u32 {
        let key = place.to_array().map(f32::to_bits);
        let number = self.known.get(&key).copied().unwrap_or_else(|| self.find_costs(streets, place, key));
        self.all[number as usize].users += 1;
        number
    }

    /// Computes the distances of a new goal, in place of an unused one.
    fn find_costs(&mut self, streets: &Streets, place: Vec3, key: [u32; 3]) -> u32 {
        let number = loop {
            let Some(number) = self.idle.pop_front() else {
                self.all.push(GoalSlot::default());
                break self.all.len() - 1;
            };
            let goal = &mut self.all[number as usize];
            goal.is_idle = false;
            if goal.users == 0 {
                break number as usize;
            }
        };
        let goal = &mut self.all[number];
        if let Some(before) = goal.place.replace(key) {
            self.known.remove(&before);
        }
        self.known.insert(key, number as u32);
        streets.find_costs(place.xz(), &mut goal.costs, &mut self.open);
        number as u32
    }

    /// Releases a goal for one user.
    pub fn release(&mut self, number: u32) {
        let goal = &mut self.all[number as usize];
        goal.users -= 1;
        if goal.users == 0 && !std::mem::replace(&mut goal.is_idle, true) {
            self.idle.push_back(number);
        }
    }

    /// Finds all paths anew, as a door has opened or closed.
    ///
    /// - `is_new`: it is a door for the first time.
    pub fn find_again(&mut self, streets: &Streets, is_new: bool) {
        let Self { all, known, open, .. } = self;
        for goal in all {
            match goal.place {
                Some(place) if goal.users > 0 => {
                    let [x, _, z] = place.map(f32::from_bits);
                    if is_new {
                        streets.find_costs(glam::Vec2::new(x, z), &mut goal.costs, open);
                    } else {
                        streets.find_paths(&mut goal.costs, open);
                    }
                }
                _ => {
                    if let Some(place) = goal.place.take() {
                        known.remove(&place);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Obstacle;
    use crate::routes::streets::NoPath;
    use glam::Vec2;

    #[test]
    fn goals_are_shared_and_their_memory_is_used_again() {
        let block = Obstacle::Ball { centre: Vec3::ZERO, radius: 1.0 };
        let streets = Streets::new(&[block], 0.4).unwrap();
        let mut goals = GoalTable::default();
        (0..2).for_each(|_| goals.reserve(&streets));
        let at = |x: f32| Vec3::new(x, 0.0, 2.0);
        let (a, b) = (goals.take_goal(&streets, at(1.0)), goals.take_goal(&streets, at(2.0)));
        assert_eq!(goals.take_goal(&streets, at(1.0)), a, "the same place");
        goals.release(a);
        goals.release(b);
        assert_eq!(goals.take_goal(&streets, at(2.0)), b, "still known");
        goals.release(b);
        for k in 0..100 {
            let number = goals.take_goal(&streets, at(10.0 + k as f32));
            assert_ne!(number, a, "somebody goes there");
            goals.release(number);
        }
        assert_eq!((goals.all.len(), goals.idle.len()), (3, 2));
        assert!(streets.check_path(at(-5.0).xz(), goals.costs(a)).is_ok());
        assert_eq!(streets.check_path(Vec2::X * 0.5, goals.costs(a)), Err(NoPath::Start(0)));
    }
}
