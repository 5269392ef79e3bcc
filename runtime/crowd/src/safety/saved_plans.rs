//! Check of the safety rule for plans of unknown origin, such as those of a snapshot.
//!
//! A new plan is compared by a rule that is quick and sometimes refuses where there is room (`nearby_plans.rs`). Saved plans
//! were taken at different times, so that the quick rule may refuse a pair that it once allowed. Such pairs are
//! compared step by step, with steps so short that no stop region moves farther than the room there is.

use crate::safety::rule::{MARGIN, PlanCandidate, clearance};
use crate::{Space, safety::nearby_plans::find_violation, space::plan::MotionPlan, space::solid::ConvexSolid};

/// Shortest step, as a displacement of the stop regions (m).
const STEP_M: f32 = 2e-4;
/// Relative error allowed for rounding.
const ROUNDING: f32 = 1e-3;

/// Room that rounding may have cost (m).
fn rounding<V: Space>(plan: &MotionPlan<V>) -> f32 {
    MARGIN + 8.0 * f32::EPSILON * plan.position.length()
}

/// Plan of the agent as if it stood still from a time on, at most from the end of its plan.
fn standing_plan<V: Space>(plan: &MotionPlan<V>, time: f64) -> MotionPlan<V> {
    let (position, velocity) = plan.motion_at(time.min(plan.end));
    MotionPlan { position, velocity, ..*plan }
}

/// The plan from a time on.
fn plan_from<V: Space>(plan: &MotionPlan<V>, time: f64) -> MotionPlan<V> {
    let moving = (plan.moving - (time - plan.start) as f32).max(0.0);
    MotionPlan { start: time, moving, ..standing_plan(plan, time) }
}

/// Largest speed of the ends of its stop region, from a time on (m/s).
fn max_end_speed<V: Space>(plan: &MotionPlan<V>, time: f64) -> f32 {
    // The speed of a parabola is largest at an end; the far end moves at |v| (1 + |a| / A) at most.
    let speed = standing_plan(plan, time).velocity.length().max(standing_plan(plan, plan.end).velocity.length());
    speed * (1.0 + plan.acceleration.length() / plan.limit)
}

/// False where `moving` says that an agent brakes, and it does not.
pub(crate) fn is_motion<V: Space>(plan: &MotionPlan<V>) -> bool {
    if plan.moving == f32::INFINITY {
        return true;
    }
    let mut braking = *plan;
    braking.brake();
    (braking.moving - plan.moving).abs() <= ROUNDING * (1.0 + braking.moving)
        && (braking.acceleration - plan.acceleration).length() <= ROUNDING * plan.limit
}

/// True where the stop region stays within a box along the axes until the plan's end.
pub(crate) fn is_within<V: Space>(plan: &MotionPlan<V>, min: V, max: V) -> bool {
    let room = V::from_coordinates([rounding(plan); 3]);
    let (min, max) = (min - room, max + room);
    if plan.moving < f32::INFINITY {
        // Its sweep lies between these two.
        let (from, to) = plan.stop_region(0.0);
        let free = (from.min(to) - min).min(max - from.max(to)).coordinates();
        return free.iter().take(V::DIMENSIONS).all(|&f| f >= plan.radius);
    }
    PlanCandidate::new(*plan).stays_within(min, max)
}

/// True where two never overlap, from a time on and until both have acted again and come to rest.
pub(crate) fn are_apart<V: Space>(a: &MotionPlan<V>, b: &MotionPlan<V>, now: f64) -> bool {
    if find_violation(&PlanCandidate::new(plan_from(a, now)), b).is_none() {
        return true;
    }
    let (least, pace) = (-rounding(a).max(rounding(b)), max_end_speed(a, now) + max_end_speed(b, now));
    each_step(now, a.end.max(b.end), pace, |time| clearance(&standing_plan(a, time), &standing_plan(b, time)), least)
}

/// True where an agent never is in a solid, from a time on and until it has acted again and come to rest.
pub(crate) fn is_clear_of<V: Space>(plan: &MotionPlan<V>, solid: &ConvexSolid<V>, now: f64) -> bool {
    if PlanCandidate::new(plan_from(plan, now)).violation_of_solid(solid).is_none() {
        return true;
    }
    let least = -rounding(plan);
    let room = |time: f64| {
        let (from, to) = standing_plan(plan, time).stop_region(0.0);
        let (ahead, length) = (to - from).unit_and_length();
        let (mut at, mut least) = (0.0, f32::INFINITY);
        loop {
            let room = solid.direction_and_distance(from + ahead * at).1 - plan.radius;
            least = least.min(room);
            if at >= length || room < -1.0 {
                return least;
            }
            at = (at + room.max(STEP_M)).min(length);
        }
    };
    each_step(now, plan.end, max_end_speed(plan, now), room, least)
}

/// True where there is room at every time; each step ends before the motion can have used the room up.
fn each_step(now: f64, end: f64, pace: f32, room: impl Fn(f64) -> f32, least: f32) -> bool {
    let mut time = now;
    loop {
        let left = room(time);
        if left.is_nan() || left < least {
            return false;
        }
        if time >= end || pace == 0.0 {
            return true;
        }
        time = (time + f64::from(left.max(STEP_M) / pace)).min(end);
    }
}
