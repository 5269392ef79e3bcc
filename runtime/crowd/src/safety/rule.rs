//! The safety rule, with the proof that no two agents ever overlap.
//!
//! The *stop region* S(s) of an agent at time s is the sweep of its disc or ball if it brakes with all its force from s
//! on: all points within its radius of the line from x to x + v|v| / 2A. An agent that brakes never leaves the stop
//! region it had when it began to.
//!
//! Plans are made at different times. Let T be the end of an agent's plan, at which it acts at the latest; its plan until then is
//! known to all. Agents keep this invariant: **for each pair (k, j) and all s from now on, S_k(min(s, T_k)) and
//! S_j(min(s, T_j)) have no point in common**, and neither have S_k(min(s, T_k)) and an obstacle that stands. As
//! a disc is a part of its stop region, no two agents overlap before the next event. The invariant outlasts every
//! event:
//!
//! - At T_k, k takes a plan for which it holds (found by [`crate::safety::others`]), or brakes. Braking is always right: then S_k(s) is
//!   within S_k(T_k) for all s from T_k on, and that is disjoint from S_j(min(s, T_j)) for those s, as the invariant of
//!   the old plan says.
//! - Before T_k (another agent's colliding event, or when it is woken) k may take a plan for which the
//!   invariant holds, and otherwise keeps the one it has to its end T_k; then nothing has changed. To brake is *not*
//!   always right here: others may rely on k being gone by then.
//! - A newcomer is refused unless the invariant holds for a plan of braking; an agent that leaves takes its conditions away.
//!
//! By induction over the events, no two agents ever overlap. Nothing is asked of the forces.
//!
//! Only pairs that are registered in cells next to each other are compared. Each agent's stop region stays within its
//! own region R, which reaches half a cell beyond its cell C: regions of cells that are not next to each other are
//! disjoint. Of the pairs in such cells, only those whose stop regions can meet are compared (see `reach.rs`): those of
//! the others cannot, whatever they do with their largest accelerations, as long as no agent is faster than
//! the largest speed. `spawn` refuses faster agents, and `candidate` makes no plan that ends faster; in between, the speed of an
//! agent that keeps its acceleration is never above that at both ends.
//!
//! A region that an external obstacle reserves is treated as a static obstacle: external obstacles keep out of
//! [`PlanCandidate::reserved_region`] in turn, which holds S_k(min(s, T_k)) for all s from now on.
//!
//! Moving obstacles do not yield; they are taken for agents that never brake, over the time of a plan and of braking
//! after it, though not beyond the next point of their path. A trapped agent may still be struck.

use crate::space::plan::{MotionPlan, stopping_point};
use crate::{Space, space::solid::ConvexSolid};
use throng_geometry::{Bounds2d, Capsule2d, share_along};

/// Margin against rounding, whose error is smaller within 500 m of the origin (m).
pub(crate) const MARGIN: f32 = 1e-4;

/// A plan to be compared with others: both ends of its stop region now and at its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlanCandidate<V> {
    pub plan: MotionPlan<V>,
    /// Time until its end (s).
    pub length: f32,
    pub now: Segment<V>,
    pub end: Segment<V>,
    /// Bound on how the end of its stop region swerves from the direction of the acceleration: the part of its second
    /// derivative along the velocity, at most |a|^2 / 2A. None where all is on one line.
    pub curve: f32,
    /// True for an agent that brakes or starts from rest: both ends of its stop region move one way along one line, or
    /// stay.
    pub is_straight: bool,
}

/// Ends of a stop region.
pub(crate) type Segment<V> = (V, V);

/// Violation of the safety rule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SafetyViolation<V> {
    /// Unit vector away from the obstruction.
    pub away: V,
    /// Distance by which the stop region would have to be farther in that direction (m, > 0).
    pub depth: f32,
}

impl<V: Space> PlanCandidate<V> {
    #[inline]
    pub fn new(plan: MotionPlan<V>) -> Self {
        let length = (plan.end - plan.start) as f32;
        let (now, end) = (plan.stop_region(0.0), plan.stop_region(length));
        let is_straight = plan.moving < f32::INFINITY || plan.velocity.length_squared() == 0.0;
        let curve = if is_straight { 0.0 } else { plan.acceleration.length_squared() / (2.0 * plan.limit) };
        Self { length, now, end, curve, is_straight, plan }
    }

    /// Largest distance that it may reach from its present centre, with braking at the end: to its own edge, and a
    /// little more (m).
    #[inline]
    pub fn reach(&self) -> f32 {
        let far = |x: V| (x - self.now.0).length_squared();
        let farthest = far(self.now.1).max(far(self.end.0)).max(far(self.end.1)).sqrt();
        let bends = 2.0 * self.plan.acceleration.length() + self.curve;
        farthest + 0.125 * self.length * self.length * bends + self.plan.radius + MARGIN
    }

    /// True where the stop region stays within a box along the axes.
    #[inline]
    pub fn stays_within(&self, min: V, max: V) -> bool {
        let low = self.now.0.min(self.now.1).min(self.end.0).min(self.end.1);
        let high = self.now.0.max(self.now.1).max(self.end.0).max(self.end.1);
        let p = &self.plan;
        let swerve = self.swerve();
        let room = (low - min).min(max - high).coordinates();
        room.iter().take(V::DIMENSIONS).all(|&r| r >= p.radius + swerve + MARGIN)
    }

    /// Capsule of the ground that it takes until its end and for braking after it.
    pub fn reserved_region(&self) -> Capsule2d {
        let line = Capsule2d { from: self.now.0.on_ground(), to: self.end.1.on_ground(), radius_m: 0.0 };
        let off = line.distance_to(self.now.1.on_ground()).max(line.distance_to(self.end.0.on_ground()));
        Capsule2d { radius_m: self.plan.radius + off + self.swerve() + MARGIN, ..line }
    }

    /// A box around [`PlanCandidate::reserved_region`].
    pub fn bounds(&self) -> Bounds2d {
        self.reserved_region().bounds()
    }

    /// Violation of the rule between a plan and a region that an external obstacle reserves; `None` if there is none. An
    /// agent inside such a region already, because an obstacle that never yields has come, may leave it.
    pub fn violation_of_region(&self, ground: &Capsule2d) -> Option<SafetyViolation<V>> {
        let Capsule2d { from, to, radius_m } = *ground;
        let solid = ConvexSolid::Capsule { from: V::over_ground(from), to: V::over_ground(to), radius: radius_m };
        let (away, distance) = solid.direction_and_distance(self.now.0);
        if distance < self.plan.radius {
            let gained = solid.direction_and_distance(self.end.1).1 - distance;
            return (gained < 0.0).then_some(SafetyViolation { away, depth: -gained });
        }
        self.violation_of_solid(&solid)
    }

    /// Violation of the rule between a plan and a solid that stands; `None` if it holds.
    #[inline]
    pub fn violation_of_solid(&self, solid: &ConvexSolid<V>) -> Option<SafetyViolation<V>> {
        let bend = 0.125 * self.length * self.length;
        let mut best: Option<SafetyViolation<V>> = None;
        for x in [self.end.1, self.now.0] {
            let (n, distance) = solid.direction_and_distance(x);
            if distance <= 0.0 {
                continue;
            }
            let (now, end) = (least(self.now, n), least(self.end, n));
            let apart = now.min(end) - solid.reach(n);
            // An agent that only moves away from it may, see `nearby_plans.rs`.
            let margin = if end >= now { 0.0 } else { MARGIN };
            let room =
                if self.is_straight { 0.0 } else { bend * (2.0 * n.dot(self.plan.acceleration).max(0.0) + self.curve) };
            let violation = self.plan.radius + margin + room - apart;
            if violation <= 0.0 {
                return None;
            }
            if best.is_none_or(|b| violation < b.depth) {
                best = Some(SafetyViolation { away: n, depth: violation });
            }
        }
        best.or(Some(SafetyViolation { away: self.plan.velocity.unit_and_length().0 * -1.0, depth: self.plan.radius }))
    }

    /// Largest distance of the ends of its stop region from the lines between their positions now and at its end (m).
    fn swerve(&self) -> f32 {
        self.length * self.length * (0.25 * self.plan.acceleration.length() + 0.125 * self.curve)
    }
}

/// Smallest extent of a stop region along a direction.
#[inline]
fn least<V: Space>(ends: (V, V), along: V) -> f32 {
    along.dot(ends.0).min(along.dot(ends.1))
}

/// Smallest displacement of the far end of the stop region at the end of a plan by a change of the acceleration by 1
/// m/s2.
#[inline]
pub(crate) fn lever<V: Space>(me: &PlanCandidate<V>) -> f32 {
    let v = me.plan.velocity + me.plan.acceleration * me.length;
    me.length * (0.5 * me.length + 0.5 * v.length() / me.plan.limit)
}

/// Gap between two standing stop regions; below zero where they overlap. For agents that are moved elsewhere.
pub(crate) fn clearance<V: Space>(a: &MotionPlan<V>, b: &MotionPlan<V>) -> f32 {
    let ends = |p: &MotionPlan<V>| (p.position, stopping_point(p.position, p.velocity, p.limit));
    let ((a0, a1), (b0, b1)) = (ends(a), ends(b));
    // The distance of two segments is that of an end of one to the other, or that of their lines between the ends.
    let nearest = |from: V, to: V, x: V| share_along(x, [from, to]);
    let apart = |s: f32, t: f32| (a0 + (a1 - a0) * s - b0 - (b1 - b0) * t).length();
    let mut least = apart(0.0, nearest(b0, b1, a0))
        .min(apart(1.0, nearest(b0, b1, a1)))
        .min(apart(nearest(a0, a1, b0), 0.0))
        .min(apart(nearest(a0, a1, b1), 1.0));
    let (u, v, w) = (a1 - a0, b1 - b0, a0 - b0);
    let steepness = u.length_squared() * v.length_squared() - u.dot(v) * u.dot(v);
    let s = (u.dot(v) * v.dot(w) - v.length_squared() * u.dot(w)) / steepness;
    if steepness > 0.0 && (0.0..=1.0).contains(&s) {
        least = least.min(apart(s, nearest(b0, b1, a0 + u * s)));
    }
    least - a.radius - b.radius
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::safety::nearby_plans::{NearbyPlans, find_violation};
    use glam::{Vec2, Vec3};
    use proptest::collection::vec;
    use proptest::prelude::*;

    fn plan<V: Space>(index: u32) -> impl Strategy<Value = MotionPlan<V>> {
        let vector = || [-2.0f32..2.0, -2.0f32..2.0, -2.0f32..2.0].prop_map(V::from_coordinates);
        (vector(), vector(), vector(), any::<bool>(), 0.02f64..0.4, 0.0f64..0.1, 0.1f32..0.5).prop_map(
            move |(position, v, a, brakes, length, age, radius)| {
                let start = 100.0 - if index == 0 { 0.0 } else { age };
                let mut plan = MotionPlan {
                    start,
                    end: 100.0 + length,
                    position,
                    velocity: v * 0.8,
                    acceleration: (a * 2.5).at_most(5.0),
                    moving: f32::INFINITY,
                    radius,
                    limit: 5.0,
                    index,
                };
                if brakes {
                    plan.brake();
                }
                plan
            },
        )
    }

    /// Samples the invariant: wherever no violation is found, or none is looked for, stop regions are apart at all times.
    fn holds<V: Space>(me: &MotionPlan<V>, other: &MotionPlan<V>) -> Result<(), TestCaseError> {
        if find_violation(&PlanCandidate::new(*me), other).is_some() {
            return Ok(());
        }
        for i in 0..=100 {
            let s = 100.0 + f64::from(i) * 0.0045;
            let still = |p: &MotionPlan<V>| {
                let (position, velocity) = p.motion_at(s.min(p.end));
                MotionPlan { position, velocity, ..*p }
            };
            let clearance = clearance(&still(me), &still(other));
            prop_assert!(clearance > 0.0, "stop regions overlap by {} m after {} s", -clearance, s - 100.0);
        }
        Ok(())
    }

    /// A long plan of an agent that is fast and turns sharply: the end of its stop region swerves farthest.
    fn swerving(index: u32) -> impl Strategy<Value = MotionPlan<Vec2>> {
        let turn = (0.5f32..2.0, 0.0f32..std::f32::consts::TAU, 0.5f32..5.0, -2.5f32..2.5, 0.3f64..1.2);
        turn.prop_map(move |(speed, heading, strength, aside, length)| MotionPlan {
            start: 100.0,
            end: 100.0 + length,
            position: Vec2::ZERO,
            velocity: Vec2::from_angle(heading) * speed,
            acceleration: Vec2::from_angle(heading + aside) * strength,
            moving: f32::INFINITY,
            radius: 0.25,
            limit: 5.0,
            index,
        })
    }

    /// The least distance in a direction from which on something does not violate the rule, up to a tenth of a millimetre (m).
    fn least_distance(violates: impl Fn(f32) -> bool) -> Option<f32> {
        let (mut low, mut high) = (0.0, 12.0);
        if !violates(low) || violates(high) {
            return None;
        }
        while high - low > 1e-4 {
            let middle = 0.5 * (low + high);
            *(if violates(middle) { &mut low } else { &mut high }) = middle;
        }
        Some(high)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        /// As near to each other as the rule allows, stop regions are apart at all times: no term of it can be left out.
        #[test]
        fn swerving_agents_stay_apart_as_near_as_they_may_come(
            me in swerving(0), other in swerving(1), stands in any::<bool>(), direction in 0.0f32..std::f32::consts::TAU,
        ) {
            let other = if stands { MotionPlan { velocity: Vec2::ZERO, acceleration: Vec2::ZERO, ..other } } else { other };
            let candidate = PlanCandidate::new(me);
            let at = |far: f32| MotionPlan { position: Vec2::from_angle(direction) * far, ..other };
            let Some(far) = least_distance(|far| find_violation(&candidate, &at(far)).is_some()) else { return Ok(()) };
            let (other, longest) = (at(far), (me.end - 100.0).max(other.end - 100.0));
            for i in 0..=200 {
                let s = 100.0 + longest * f64::from(i) / 200.0;
                let still = |p: &MotionPlan<Vec2>| {
                    let (position, velocity) = p.motion_at(s.min(p.end));
                    MotionPlan { position, velocity, ..*p }
                };
                let clearance = clearance(&still(&me), &still(&other));
                prop_assert!(clearance > 0.0, "stop regions overlap by {} m after {} s", -clearance, s - 100.0);
            }
        }

        #[test]
        fn swerving_agents_stay_out_of_solids_as_near_as_they_may_come(
            me in swerving(0), direction in 0.0f32..std::f32::consts::TAU,
        ) {
            let candidate = PlanCandidate::new(me);
            let at = |far: f32| {
                let at = Vec2::from_angle(direction) * far;
                ConvexSolid::Capsule { from: at, to: at, radius: 0.1 }
            };
            let Some(far) = least_distance(|far| candidate.violation_of_solid(&at(far)).is_some()) else { return Ok(()) };
            let solid = at(far);
            for i in 0..=200 {
                let (p, q) = me.stop_region(candidate.length * i as f32 / 200.0);
                for j in 0..=20 {
                    let x = p + (q - p) * (j as f32 / 20.0);
                    prop_assert!(solid.direction_and_distance(x).1 >= me.radius, "{x} at {i}");
                }
            }
        }
    }

    /// The largest violation is found for any plans added before.
    fn finds_the_worst<V: Space>(
        me: MotionPlan<V>,
        before: &[MotionPlan<V>],
        others: &[MotionPlan<V>],
    ) -> Result<(), TestCaseError> {
        let me = PlanCandidate::new(me);
        let mut all = NearbyPlans::default();
        for plans in [before, others] {
            all.clear();
            plans.iter().for_each(|p| all.push(p));
            all.prepare(me.plan.position, me.plan.start);
        }
        let one_by_one = others.iter().filter_map(|o| find_violation(&me, o)).map(|l| l.depth).reduce(f32::max);
        prop_assert_eq!(all.worst_violation(&me).map(|l| l.depth), one_by_one);
        all.leave_out_movers();
        prop_assert_eq!(all.worst_violation(&me).map(|l| l.depth), one_by_one, "all are agents");
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        #[test]
        fn the_worst_disc_is_found(me in plan::<Vec2>(0), before in vec(plan(1), 0..20), others in vec(plan(2), 0..20)) {
            finds_the_worst(me, &before, &others)?;
        }

        #[test]
        fn the_worst_ball_is_found(me in plan::<Vec3>(0), before in vec(plan(1), 0..20), others in vec(plan(2), 0..20)) {
            finds_the_worst(me, &before, &others)?;
        }

        #[test]
        fn movers_can_be_left_out(me in plan::<Vec2>(0), others in vec(plan(2), 1..20), mover in plan(crate::NONE)) {
            let me = PlanCandidate::new(me);
            let mut all = NearbyPlans::default();
            others.iter().chain([&mover]).for_each(|p| all.push(p));
            all.prepare(me.plan.position, me.plan.start);
            all.leave_out_movers();
            let agents = others.iter().filter_map(|o| find_violation(&me, o)).map(|l| l.depth).reduce(f32::max);
            prop_assert_eq!(all.worst_violation(&me).map(|l| l.depth), agents);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        /// The region holds the agent until its end, and while it brakes at any time before.
        #[test]
        fn held_ground_holds_the_agent_whenever_it_brakes(me in plan::<Vec2>(0)) {
            let candidate = PlanCandidate::new(me);
            let held = candidate.reserved_region();
            for i in 0..=50 {
                let (x, stop) = me.stop_region(candidate.length * i as f32 / 50.0);
                for share in [0.0, 0.5, 1.0] {
                    let beyond = held.distance_to(x + (stop - x) * share) + me.radius;
                    prop_assert!(beyond <= 0.0, "{beyond} m beyond");
                }
            }
        }

        #[test]
        fn stop_regions_of_discs_stay_apart(me in plan::<Vec2>(0), other in plan::<Vec2>(1)) {
            holds(&me, &other)?;
        }

        #[test]
        fn stop_regions_of_balls_stay_apart(me in plan::<Vec3>(0), other in plan::<Vec3>(1)) {
            holds(&me, &other)?;
        }

        #[test]
        fn stop_regions_stay_out_of_solids(me in plan::<Vec2>(0), from in [-3.0f32..3.0, -3.0f32..3.0], to in [-3.0f32..3.0, -3.0f32..3.0]) {
            let (from, to) = (Vec2::from_array(from), Vec2::from_array(to));
            for solid in [ConvexSolid::Capsule { from, to, radius: 0.1 }, ConvexSolid::Box { min: from.min(to), max: from.max(to) }] {
                if PlanCandidate::new(me).violation_of_solid(&solid).is_some() {
                    continue;
                }
                for i in 0..=100 {
                    let s = (me.end - me.start) as f32 * i as f32 / 100.0;
                    let (p, q) = me.stop_region(s);
                    for j in 0..=10 {
                        let x = p + (q - p) * (j as f32 / 10.0);
                        prop_assert!(solid.direction_and_distance(x).1 >= me.radius, "{x} at {s}");
                    }
                }
            }
        }

        #[test]
        fn stays_within_is_never_wrong(me in plan::<Vec2>(0)) {
            let (min, max) = (Vec2::splat(-2.5), Vec2::splat(2.5));
            if PlanCandidate::new(me).stays_within(min, max) {
                for i in 0..=100 {
                    let (p, q) = me.stop_region((me.end - me.start) as f32 * i as f32 / 100.0);
                    let room = (p.min(q) - min).min(max - p.max(q)).min_element();
                    prop_assert!(room >= me.radius, "{room}");
                }
            }
        }
    }

    #[test]
    fn walking_behind_and_passing_beside_are_safe() {
        let me = MotionPlan {
            start: 100.0,
            end: 100.1,
            velocity: Vec2::new(1.3, 0.0),
            moving: f32::INFINITY,
            radius: 0.3,
            limit: 5.0,
            ..MotionPlan::default()
        };
        let ahead = MotionPlan { position: Vec2::new(0.85, 0.0), ..me };
        let beside = MotionPlan { position: Vec2::new(0.3, 0.61), velocity: Vec2::new(-1.3, 0.0), ..me };
        let against = MotionPlan { position: Vec2::new(0.9, 0.1), velocity: Vec2::new(-1.3, 0.0), ..me };
        let is_free = |p: &MotionPlan<Vec2>| find_violation(&PlanCandidate::new(me), p).is_none();
        assert!(is_free(&ahead) && is_free(&beside) && !is_free(&against));
    }

    #[test]
    fn agents_within_rounding_margin_may_separate() {
        let still = |index, x: f32| MotionPlan {
            start: 99.9,
            end: 100.2,
            position: Vec2::new(x, 0.0),
            radius: 0.3,
            limit: 5.0,
            index,
            ..MotionPlan::default()
        };
        let other = still(1, 0.600_05);
        let wall = ConvexSolid::Capsule { from: Vec2::new(0.300_05, -9.0), to: Vec2::new(0.300_05, 9.0), radius: 0.0 };
        for (a, may) in [(Vec2::NEG_X, true), (Vec2::new(-1.0, 2.0), true), (Vec2::X, false)] {
            let plan = MotionPlan { start: 100.0, moving: f32::INFINITY, acceleration: a, ..still(0, 0.0) };
            let candidate = PlanCandidate::new(plan);
            assert_eq!(find_violation(&candidate, &other).is_none(), may, "{a}");
            assert_eq!(candidate.violation_of_solid(&wall).is_none(), may, "{a}");
        }
    }
}
