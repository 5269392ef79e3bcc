//! A plan that the safety rule allows, near to the desired one.

use super::decide::{AgentState, Decider, DecisionScratch};
use crate::safety::rule::{PlanCandidate, SafetyViolation, lever};
use crate::{Space, safety::reach::PlanReach, space::plan::MotionPlan};
use throng_base::thresholds::GIVING_WAY_MPS;

/// The motion that a new plan is wanted to have.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanAim<V> {
    /// (m/s^2)
    pub acceleration: V,
    /// Largest speed at the end of the plan (m/s).
    pub fastest: f32,
    /// Time until the plan ends (s).
    pub length: f32,
}

impl<V: Space> Decider<'_, V> {
    /// Finds the plans that a plan of a length has to be compared with.
    pub(super) fn collect_nearby_plans(&self, fresh: &MotionPlan<V>, length: f32, scratch: &mut DecisionScratch<V>) {
        scratch.others.clear();
        let reach = PlanReach::new(self.cells, self.scenery.fastest, fresh, length);
        reach.find_neighbours(scratch.rows.found_rows(), &mut scratch.others);
        for mover in &self.scenery.movers {
            let plan = mover.plan(self.time, length + 2.0 * self.scenery.speed / fresh.limit);
            let distance = plan.velocity.length() * (plan.end - plan.start) as f32;
            let free = (plan.position - fresh.position).length() - plan.radius - distance;
            if free < reach.mine {
                scratch.others.push(&plan);
            }
        }
        scratch.others.prepare(fresh.position, self.time);
    }

    /// A plan near the desired one for which the safety rule holds.
    pub(super) fn find_safe_plan(
        &self,
        fresh: &MotionPlan<V>,
        aim: &PlanAim<V>,
        region: (V, V),
        near: &[u32],
        scratch: &DecisionScratch<V>,
    ) -> Option<MotionPlan<V>> {
        let (shortest, steering) = (self.scenery.interval, &self.scenery.steering);
        let (mut a, mut length) = (aim.acceleration, aim.length);
        for attempt in 0..steering.plan_tries {
            let candidate = self.candidate(fresh, a, aim.fastest, length);
            if !candidate.stays_within(region.0, region.1) {
                if length <= shortest {
                    break;
                }
                length = (0.5 * length).max(shortest);
                continue;
            }
            let Some(worst) = self.worst_violation(&candidate, near, scratch) else { return Some(candidate.plan) };
            // Slides along what is in the way.
            a = candidate.plan.acceleration + worst.away * (worst.depth * steering.push_factor / lever(&candidate));
            if attempt > 0 {
                length = (steering.retry_length * length).max(shortest);
            }
        }
        let stop = fresh.velocity * -shortest.recip();
        let mut slower = [0.5, 1.0].into_iter().map(|share| self.candidate(fresh, stop * share, aim.fastest, shortest));
        let is_safe = |candidate: &PlanCandidate<V>| {
            candidate.stays_within(region.0, region.1) && self.worst_violation(candidate, near, scratch).is_none()
        };
        slower.find(is_safe).map(|candidate| candidate.plan)
    }

    /// Fastest that an agent goes: no agent is above the largest speed, on which the safety rule counts.
    /// A smaller limit is safe, as each plan is checked. Plans do not end where the limit of a place begins: `longest` has to be
    /// shorter there.
    pub(super) fn max_speed(&self, state: &AgentState<V>) -> f32 {
        let own = state.speed.max(GIVING_WAY_MPS) * self.scenery.steering.largest_speed_ratio;
        own.min(self.scenery.fastest)
    }

    /// A plan within the limits of acceleration and speed.
    #[inline]
    fn candidate(&self, fresh: &MotionPlan<V>, a: V, fastest: f32, length: f32) -> PlanCandidate<V> {
        let a = a.at_most(fresh.limit);
        let a = ((fresh.velocity + a * length).at_most(fastest) - fresh.velocity) * length.recip();
        PlanCandidate::new(MotionPlan {
            end: self.time + f64::from(length),
            acceleration: a.at_most(fresh.limit),
            ..*fresh
        })
    }

    /// The largest violation of a plan.
    fn worst_violation(
        &self,
        candidate: &PlanCandidate<V>,
        near: &[u32],
        scratch: &DecisionScratch<V>,
    ) -> Option<SafetyViolation<V>> {
        let solids = near.iter().filter_map(|&s| candidate.violation_of_solid(&self.scenery.solids[s as usize]));
        let held = self.worst_region_violation(candidate);
        let all = scratch.others.worst_violation(candidate).into_iter().chain(solids).chain(held);
        all.reduce(|a, b| if b.depth > a.depth { b } else { a })
    }

    /// The largest violation of a plan by ground that others hold.
    fn worst_region_violation(&self, candidate: &PlanCandidate<V>) -> Option<SafetyViolation<V>> {
        if self.external_obstacles.is_empty() {
            return None;
        }
        let mut worst: Option<SafetyViolation<V>> = None;
        self.external_obstacles.visit_reserved_near(&candidate.bounds(), |ground| {
            let found = candidate.violation_of_region(ground);
            if let Some(v) = found.filter(|v| worst.is_none_or(|w| v.depth > w.depth)) {
                worst = Some(v);
            }
            true
        });
        worst
    }
}
