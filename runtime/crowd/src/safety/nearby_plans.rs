//! The plans that a plan is compared with, eight at a time: violations of the rule of `rule.rs`.

use crate::safety::rule::{MARGIN, PlanCandidate, SafetyViolation};
use crate::space::batch::{Eight, PlanLanes, Sides, VectorLanes, nth_vector, set_bits};
use crate::{NONE, Space, space::plan::MotionPlan};
use throng_base::simd::{LANES, LaneWork, Lanes, dispatch};

/// Plans of eight, each number of all of them side by side.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
struct PlanBlock {
    start: [f64; LANES],
    end: [f64; LANES],
    index: [u32; LANES],
    moving: Eight,
    radius: Eight,
    limit: Eight,
    axes: [AxisLanes; 3],
}

/// Coordinate of eight motions along one axis.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
struct AxisLanes {
    position: Eight,
    velocity: Eight,
    acceleration: Eight,
}

impl PlanBlock {
    /// Plans of all of them.
    #[inline(always)]
    fn plans<V: Space, F: Lanes>(&self) -> PlanLanes<V, F> {
        let [x, y, z] = &self.axes;
        PlanLanes {
            position: VectorLanes::load_each([&x.position, &y.position, &z.position]),
            velocity: VectorLanes::load_each([&x.velocity, &y.velocity, &z.velocity]),
            acceleration: VectorLanes::load_each([&x.acceleration, &y.acceleration, &z.acceleration]),
            moving: F::load(&self.moving),
            limit: F::load(&self.limit),
        }
    }

    /// Writes a plan into a lane.
    #[inline]
    fn put_plan<V: Space>(&mut self, i: usize, plan: &MotionPlan<V>) {
        (self.start[i], self.end[i]) = (plan.start, plan.end);
        let (x, v, a) = (plan.position.coordinates(), plan.velocity.coordinates(), plan.acceleration.coordinates());
        for axis in 0..V::DIMENSIONS {
            let axes = &mut self.axes[axis];
            (axes.position[i], axes.velocity[i], axes.acceleration[i]) = (x[axis], v[axis], a[axis]);
        }
        (self.moving[i], self.radius[i], self.limit[i]) = (plan.moving, plan.radius, plan.limit);
        self.index[i] = plan.index;
    }
}

/// Plans of eight others, as they are at an event.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
struct PlanPack {
    plans: PlanBlock,
    /// Time from the start of each plan to now, and from now to its end (s).
    age: Eight,
    until_end: Eight,
    /// Ends of the stop region now and at the end (m).
    now: [[Eight; 3]; 2],
    end: [[Eight; 3]; 2],
    /// Bound of each plan's swerve, see [`PlanCandidate::curve`].
    curve: Eight,
    /// 1 for a plan whose stop region is on a line, otherwise 0.
    straight: Eight,
    /// Distance that they keep from the centre of the deciding agent (m).
    free: Eight,
}

/// Plans that a plan may be in conflict with.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearbyPlans {
    packs: Vec<PlanPack>,
    len: usize,
}

impl NearbyPlans {
    /// Memory for so many.
    pub fn new(capacity: usize) -> Self {
        Self { packs: Vec::with_capacity(capacity.div_ceil(LANES)), len: 0 }
    }

    /// Removes all plans.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds a plan; see [`NearbyPlans::prepare`].
    #[inline]
    pub fn push<V: Space>(&mut self, plan: &MotionPlan<V>) {
        let (pack, place) = (self.len / LANES, self.len % LANES);
        if pack == self.packs.len() {
            self.packs.push(PlanPack::default());
        }
        self.packs[pack].plans.put_plan(place, plan);
        self.len += 1;
    }

    /// Prepares all plans that were added for comparison with plans that start at a place and time.
    pub fn prepare<V: Space>(&mut self, position: V, time: f64) {
        let used = self.len.div_ceil(LANES);
        dispatch(PreparePlansJob { packs: &mut self.packs[..used], position, time });
        let last = self.len % LANES;
        if last > 0 {
            self.packs[used - 1].free[last..].fill(f32::INFINITY);
        }
    }

    /// Leaves out moving obstacles.
    pub fn leave_out_movers(&mut self) {
        for pack in &mut self.packs[..self.len.div_ceil(LANES)] {
            for i in (0..LANES).filter(|&i| pack.plans.index[i] == NONE) {
                pack.free[i] = f32::INFINITY;
            }
        }
    }

    /// The largest violation of a plan.
    pub fn worst_violation<V: Space>(&self, me: &PlanCandidate<V>) -> Option<SafetyViolation<V>> {
        dispatch(WorstViolationJob { packs: &self.packs[..self.len.div_ceil(LANES)], me })
    }

    /// Numbers of the agents that a plan with such a reach is compared with.
    #[cfg(test)]
    pub fn agents_within(&self, reach: f32) -> Vec<u32> {
        let all = self.packs[..self.len.div_ceil(LANES)].iter();
        all.flat_map(|p| (0..LANES).filter(move |&i| p.free[i] < reach).map(|i| p.plans.index[i])).collect()
    }
}

/// Violation of the rule between a plan and another agent's, if there is one.
pub(crate) fn find_violation<V: Space>(me: &PlanCandidate<V>, other: &MotionPlan<V>) -> Option<SafetyViolation<V>> {
    let mut pack = PlanPack::default();
    pack.plans.put_plan(0, other);
    let (position, time) = (me.plan.position, me.plan.start);
    dispatch(PreparePlansJob { packs: std::slice::from_mut(&mut pack), position, time });
    pack.free[1..].fill(f32::INFINITY);
    dispatch(WorstViolationJob { packs: std::slice::from_ref(&pack), me })
}

/// See [`NearbyPlans::prepare`].
struct PreparePlansJob<'a, V> {
    packs: &'a mut [PlanPack],
    position: V,
    time: f64,
}

impl<V: Space> LaneWork for PreparePlansJob<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        for pack in self.packs {
            let block = &pack.plans;
            let age: Eight = std::array::from_fn(|i| (self.time - block.start[i]) as f32);
            let until: Eight = std::array::from_fn(|i| (block.end[i] - self.time) as f32);
            (pack.age, pack.until_end) = (age, until);
            let plans = block.plans::<V, F>();
            let (age, until) = (F::load(&age), F::load(&until));
            let (now, end) = (plans.stop_region(age), plans.stop_region(age + until));
            // As `PlanCandidate::is_straight` and `PlanCandidate::curve`.
            let rests = F::select_lt(zero, plans.velocity.length_squared(), zero, one);
            let straight = F::select_lt(plans.moving, F::splat(f32::INFINITY), one, rests);
            let sway = plans.acceleration.length_squared();
            let curve = F::select_lt(zero, straight, zero, sway / (F::splat(2.0) * plans.limit));
            // As `safety::reach`.
            let [a, b, c] = [now[1] - now[0], end[0] - now[0], end[1] - now[0]];
            let farthest = a.length_squared().max(b.length_squared()).max(c.length_squared()).sqrt();
            let reach = farthest + F::splat(0.125) * until * until * (F::splat(2.0) * sway.sqrt() + curve);
            let distance = (now[0] - VectorLanes::splat(self.position)).length_squared().sqrt();
            (distance - F::load(&pack.plans.radius) - reach).store(&mut pack.free);
            curve.store(&mut pack.curve);
            straight.store(&mut pack.straight);
            for side in 0..2 {
                now[side].store(&mut pack.now[side]);
                end[side].store(&mut pack.end[side]);
            }
        }
    }
}

/// See [`NearbyPlans::worst_violation`].
struct WorstViolationJob<'a, V> {
    packs: &'a [PlanPack],
    me: &'a PlanCandidate<V>,
}

impl<V: Space> LaneWork for WorstViolationJob<'_, V> {
    type Output = Option<SafetyViolation<V>>;

    #[inline(always)]
    fn run<F: Lanes>(self) -> Option<SafetyViolation<V>> {
        let (me, reach) = (self.me, F::splat(self.me.reach()));
        let mut worst: Option<SafetyViolation<V>> = None;
        for pack in self.packs {
            let near = F::load(&pack.free).bits_lt(reach);
            if near == 0 {
                continue;
            }
            let Some((violation, normal)) = PlanPairLanes::<V, F>::new(me, pack).violation(near) else { continue };
            let violated = near & F::splat(0.0).bits_lt(violation);
            let (violation, normal) = (violation.to_array(), normal.to_arrays());
            for i in set_bits(violated) {
                if worst.is_none_or(|w| violation[i] > w.depth) {
                    worst = Some(SafetyViolation { away: nth_vector(&normal, i), depth: violation[i] });
                }
            }
        }
        worst
    }
}

/// A plan and those of eight others: their stop regions at three times, and how far they may go astray between.
struct PlanPairLanes<V, F> {
    mine: [Sides<V, F>; 3],
    its: [Sides<V, F>; 3],
    /// Sums of the radii, and room for rounding.
    radii: F,
    /// Part of the second derivatives that counts.
    bend: F,
    my_acceleration: VectorLanes<V, F>,
    its_acceleration: VectorLanes<V, F>,
    my_curve: F,
    its_curve: F,
    /// Factors: 0 where a stop region is on a line, otherwise 1.
    my_bends: F,
    its_bends: F,
}

impl<V: Space, F: Lanes> PlanPairLanes<V, F> {
    #[inline(always)]
    fn new(me: &PlanCandidate<V>, pack: &PlanPack) -> Self {
        let (length, until) = (F::splat(me.length), F::load(&pack.until_end));
        let (early, late) = (length.min(until), length.max(until));
        let plans = pack.plans.plans::<V, F>();
        let my_plan = PlanLanes {
            position: VectorLanes::splat(me.plan.position),
            velocity: VectorLanes::splat(me.plan.velocity),
            acceleration: VectorLanes::splat(me.plan.acceleration),
            moving: F::splat(me.plan.moving),
            limit: F::splat(me.plan.limit),
        };
        let my_end = [VectorLanes::splat(me.end.0), VectorLanes::splat(me.end.1)];
        let its_end = [VectorLanes::load(&pack.end[0]), VectorLanes::load(&pack.end[1])];
        // Positions of both at the earlier of the two ends.
        let (mine, its) = (my_plan.stop_region(early), plans.stop_region(F::load(&pack.age) + early));
        let mine = [
            VectorLanes::select_lt(until, length, mine[0], my_end[0]),
            VectorLanes::select_lt(until, length, mine[1], my_end[1]),
        ];
        let its = [
            VectorLanes::select_lt(length, until, its[0], its_end[0]),
            VectorLanes::select_lt(length, until, its[1], its_end[1]),
        ];
        let longest = early.max(late - early);
        Self {
            mine: [[VectorLanes::splat(me.now.0), VectorLanes::splat(me.now.1)], mine, my_end],
            its: [[VectorLanes::load(&pack.now[0]), VectorLanes::load(&pack.now[1])], its, its_end],
            radii: F::splat(me.plan.radius) + F::load(&pack.plans.radius) + F::splat(MARGIN),
            bend: F::splat(0.125) * longest * longest,
            my_acceleration: my_plan.acceleration,
            its_acceleration: plans.acceleration,
            my_curve: F::splat(me.curve),
            its_curve: F::load(&pack.curve),
            my_bends: F::splat(if me.is_straight { 0.0 } else { 1.0 }),
            its_bends: F::splat(1.0) - F::load(&pack.straight),
        }
    }

    /// Missing distance along a normal.
    #[inline(always)]
    fn missing_along(&self, n: VectorLanes<V, F>) -> F {
        let [m0, m1, m2] = [least(&self.mine[0], n), least(&self.mine[1], n), least(&self.mine[2], n)];
        let [o0, o1, o2] = [most(&self.its[0], n), most(&self.its[1], n), most(&self.its[2], n)];
        let (zero, two) = (F::splat(0.0), F::splat(2.0));
        let my_bend = self.bend * (two * n.dot(self.my_acceleration).max(zero) + self.my_curve);
        let its_bend = self.bend * (two * (-n.dot(self.its_acceleration)).max(zero) + self.its_curve);
        let moving = (m0 - o0).min(m1 - o1).min(m2 - o2) - my_bend - its_bend;
        // The sweeps of both over all times; lines need no bend here.
        let my_least = m0.min(m1).min(m2) - my_bend * self.my_bends;
        let its_most = o0.max(o1).max(o2) + its_bend * self.its_bends;
        // Agents that are nearest now and only separate may do so, even if rounding has left a little less room than the
        // margin; else they never could again.
        let its_part = F::select_lt(o0, o1.max(o2), zero, F::splat(MARGIN));
        let spared = F::select_lt(m1.min(m2), m0, zero, its_part);
        self.radii - moving.max(my_least - its_most + spared)
    }

    /// Missing distance to the rule, and the normal along which it is least; none where it is zero for any of `some`.
    ///
    /// The stop regions are apart at all times if a plane with some normal n parts them at all times. Between two of
    /// the times now, min(T_k, T_j) and max(T_k, T_j), their ends move along curves that are at most L^2 / 8 times
    /// their second derivative away from their chords, so that it is enough to look at these three times with some
    /// room: for the centre the second derivative is a; for the other end a (1 + v.a / |v| A) + v (...), of which the
    /// part along a is at most 2 a, and the rest at most |a|^2 / 2A. Two normals are tried: where the line of relative
    /// motion is nearest, and the line of centres. Or the whole sweep of the one is apart from the whole sweep of the
    /// other: so agents that touch may separate.
    #[inline(always)]
    fn violation(&self, some: u8) -> Option<(F, VectorLanes<V, F>)> {
        let zero = F::splat(0.0);
        let first = middle(&self.mine[0]) - middle(&self.its[0]);
        let offset = middle(&self.mine[2]) - middle(&self.its[2]) - first;
        let share = -first.dot(offset) / offset.length_squared().max(F::splat(1e-12));
        let (nearest, distance) = (first + offset * share.max(zero).min(F::splat(1.0))).unit_and_length();
        let violation = F::select_lt(F::splat(1e-3), distance, self.missing_along(nearest), F::splat(f32::INFINITY));
        if some & zero.bits_lt(violation) == 0 {
            return None;
        }
        let centres = (self.mine[0][0] - self.its[0][0]).unit_and_length().0;
        let other = self.missing_along(centres);
        Some((other.min(violation), VectorLanes::select_lt(other, violation, centres, nearest)))
    }
}

/// Smallest extent of stop regions along some directions.
#[inline(always)]
fn least<V: Space, F: Lanes>(sides: &Sides<V, F>, along: VectorLanes<V, F>) -> F {
    along.dot(sides[0]).min(along.dot(sides[1]))
}

/// Largest extent of stop regions along some directions.
#[inline(always)]
fn most<V: Space, F: Lanes>(sides: &Sides<V, F>, along: VectorLanes<V, F>) -> F {
    along.dot(sides[0]).max(along.dot(sides[1]))
}

#[inline(always)]
fn middle<V: Space, F: Lanes>(sides: &Sides<V, F>) -> VectorLanes<V, F> {
    (sides[0] + sides[1]) * F::splat(0.5)
}
