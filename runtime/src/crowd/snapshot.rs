//! Keeping the whole state of a crowd, and telling two states apart.

use super::decide::{Cause, Mind};
use super::flow::{Flow, LOOK_S};
use super::plan::Plan;
use super::spline::Spline;
use super::tracing::Trace;
use super::world::HURRY;
use super::{Counts, Crowd, CrowdError, NONE, Route, Space};
use serde::{Deserialize, Serialize};

/// First field of a snapshot; grows by one with every change of what follows.
const VERSION: u32 = 2;

/// All that time changes.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct State<V> {
    version: u32,
    dimensions: u32,
    now: f64,
    counts: Counts,
    free: Vec<u32>,
    minds: Vec<Mind<V>>,
    routes: Vec<Route<V>>,
    own: Vec<u32>,
    /// In the order in which they are put back into the cells.
    plans: Vec<Plan<V>>,
    flow: Flow<V>,
    looks: u64,
    trace: Trace<V>,
}

/// Nobody can have walked farther from where everybody starts. [Unit: m]
const FARTHEST_M: f32 = 1e6;
/// By how much rounding may bring a speed or an acceleration beyond its limit, as a factor. More would not do: nobody is
/// looked for as far away as one who is faster could come from, see [`super::reach`].
const ROUNDING: f32 = 1.0 + 1e-5;
/// Longest that a unit vector may be.
const UNIT: f32 = 1.001;

impl<V: Space> Crowd<V> {
    /// Keeps the whole state. [Size: about 155 bytes a member in 2-D and 180 in 3-D, of which a route of its own with one
    /// subgoal takes 24 or 28; 20 or 28 bytes a square of the flow; and the lists of the scheme, if it keeps any]
    pub fn snapshot(&self) -> Vec<u8> {
        let state = State {
            version: VERSION,
            dimensions: V::DIMENSIONS as u32,
            now: self.now,
            counts: self.counts,
            free: self.free.clone(),
            minds: self.minds.clone(),
            routes: self.world.splines.iter().map(|s| s.route.clone()).collect(),
            own: self.own.clone(),
            plans: self.cells.plans(),
            flow: self.flow.clone(),
            looks: self.looks,
            trace: self.trace.clone(),
        };
        // Writing to memory what can be written cannot fail.
        bincode::serde::encode_to_vec(&state, bincode::config::standard().with_fixed_int_encoding()).unwrap_or_default()
    }

    /// Goes back to a snapshot of a crowd that was made with the same setup. What follows is what followed then, bit by
    /// bit.
    ///
    /// # Errors
    /// [`CrowdError::Snapshot`]; nothing has changed then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), CrowdError> {
        let refused = |message: String| Err(CrowdError::Snapshot { message });
        let config = bincode::config::standard().with_fixed_int_encoding().with_limit::<{ 1 << 32 }>();
        let state: State<V> = match bincode::serde::decode_from_slice(bytes, config) {
            Ok((state, read)) if read == bytes.len() => state,
            Ok((_, read)) => return refused(format!("{} bytes follow its end", bytes.len() - read)),
            Err(e) => return refused(e.to_string()),
        };
        if (state.version, state.dimensions) != (VERSION, V::DIMENSIONS as u32) {
            return refused(format!("version {} in {} dimensions", state.version, state.dimensions));
        }
        if [state.minds.len(), state.own.len()] != [self.minds.len(); 2] {
            return refused(format!("it holds {} members, this crowd {}", state.minds.len(), self.minds.len()));
        }
        let may_flow = state.flow.fits(&self.flow) && state.flow.may_be(HURRY * self.world.speed);
        if !may_flow || !(0.0..=1e9).contains(&state.now) || !self.may_have_seen(&state) {
            return refused("its time or its flow cannot be".to_owned());
        }
        let capacity = state.minds.len();
        let mut is_new = vec![true; capacity];
        for plan in &state.plans {
            let number = plan.index as usize;
            let is_good = state.minds.get(number).is_some_and(|m| self.may_be(m, state.routes.len()));
            if !is_good || !self.may_follow(plan, state.now) || !std::mem::take(&mut is_new[number]) {
                return refused(format!("member {number} has a plan, route, field or cell that cannot be"));
            }
        }
        let mut is_own = vec![false; state.routes.len()];
        for &route in state.own.iter().filter(|&&r| r != NONE) {
            // Two that shared one would send each other elsewhere.
            if is_own.get_mut(route as usize).is_none_or(|own| std::mem::replace(own, true)) {
                return refused(format!("route {route} is of two members, or of none"));
            }
        }
        let num_there = state.minds.iter().filter(|m| m.cell != NONE).count();
        for &number in &state.free {
            if !is_new.get_mut(number as usize).is_some_and(std::mem::take) {
                return refused(format!("number {number} is free and taken"));
            }
        }
        if num_there != state.plans.len() || num_there + state.free.len() != capacity {
            return refused(format!("{num_there} members have {} plans", state.plans.len()));
        }
        let mut of_member = vec![None; capacity];
        state.plans.iter().for_each(|p| of_member[p.index as usize] = Some(p));
        let plan = |m: u32| of_member.get(m as usize).copied().flatten();
        if !state.trace.fits(&self.trace, self.cells.side(), state.now, plan) {
            return refused("it is of another scheme, or damaged".to_owned());
        }
        let splines = state.routes.iter().enumerate().map(|(i, r)| Spline::new(i, r)).collect::<Result<_, _>>();
        match splines {
            Ok(splines) => self.world.splines = splines,
            Err(e) => return refused(e.to_string()),
        }
        (self.now, self.counts, self.minds) = (state.now, state.counts, state.minds);
        (self.flow, self.looks, self.own) = (state.flow, state.looks, state.own);
        self.flow.mark();
        self.free.clear();
        self.free.extend(&state.free);
        self.cells.clear();
        self.queue.clear(self.now);
        for plan in &state.plans {
            self.cells.insert(self.minds[plan.index as usize].cell, plan);
            self.watchdog.forget(plan.index);
            self.queue.set(plan.index, plan.end);
        }
        self.trace = state.trace;
        self.trace.reserve(&self.cells, capacity);
        self.wait_for_all();
        Ok(())
    }

    /// Looks at the flow, and counts, that time allows.
    fn may_have_seen(&self, state: &State<V>) -> bool {
        state.looks as f64 <= state.now / LOOK_S + 1.0
    }

    /// A plan that a member of this crowd may follow now.
    fn may_follow(&self, plan: &Plan<V>, now: f64) -> bool {
        let within = |v: V, most: f32| v.is_finite() && v.length() <= most;
        let fastest = HURRY * self.world.speed;
        within(plan.position, FARTHEST_M)
            && within(plan.velocity, ROUNDING * fastest)
            && plan.limit > 0.0
            && plan.limit < 1e6
            && within(plan.acceleration, ROUNDING * plan.limit)
            && plan.radius > 0.0
            && plan.radius <= self.world.radius
            && plan.moving >= 0.0
            && (0.0..=now).contains(&plan.start)
            && (now..=1e10).contains(&plan.end)
    }

    /// What a member remembers fits this crowd.
    fn may_be(&self, mind: &Mind<V>, num_routes: usize) -> bool {
        let cause = match mind.cause {
            Cause::Member(other) => (other as usize) < self.minds.len(),
            Cause::Region => true,
            Cause::Obstacle(obstacle) => (obstacle as usize) < self.world.obstacles.len(),
        };
        let speed = (0.0..=self.world.speed).contains(&mind.speed);
        let is_there = (mind.cell as usize) < self.cells.num_cells();
        cause
            && speed
            && is_there
            && mind.intent.is_finite()
            && mind.intent.length() <= UNIT
            && (mind.route as usize) < num_routes
            && (mind.field as usize) < self.world.fields.len()
    }

    /// A number that differs, but for one chance in 2^64, where the motion of anybody differs.
    pub fn state_hash(&self) -> u64 {
        let mut hash = Mix(self.now.to_bits());
        for (index, mind) in (0u32..).zip(&self.minds).filter(|(_, m)| m.cell != NONE) {
            let plan = self.cells.plan(index);
            hash.add(u64::from(index) << 32 | u64::from(mind.generation));
            hash.add(plan.start.to_bits());
            hash.add(plan.end.to_bits());
            for v in [plan.position, plan.velocity, plan.acceleration] {
                v.coordinates().iter().for_each(|c| hash.add(u64::from(c.to_bits())));
            }
            hash.add(u64::from(mind.route) << 32 | u64::from(mind.speed.to_bits()));
        }
        hash.0
    }
}

/// Multiplies and shifts as the finaliser of SplitMix64 does.
struct Mix(u64);

impl Mix {
    fn add(&mut self, word: u64) {
        let mut x = (self.0 ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        self.0 = x ^ (x >> 27);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::tests::crossing;
    use glam::{Vec2, Vec3};

    /// What becomes of a snapshot of a crowd that was changed by hand.
    fn restored(change: impl FnOnce(&mut Crowd<Vec2>)) -> Result<(), CrowdError> {
        let mut crowd = Crowd::new(crossing::<Vec2>(20, 1.0)).unwrap();
        crowd.advance(1.0, &mut |_| {}).unwrap();
        change(&mut crowd);
        Crowd::new(crossing::<Vec2>(20, 1.0)).unwrap().restore(&crowd.snapshot())
    }

    fn with_plan(change: impl FnOnce(&mut Plan<Vec2>)) -> Result<(), CrowdError> {
        restored(|crowd| {
            let (cell, mut plan) = (crowd.minds[3].cell, crowd.cells.plan(3));
            change(&mut plan);
            crowd.cells.set(cell, cell, &plan);
        })
    }

    #[test]
    fn who_is_faster_than_anybody_may_be_is_refused() {
        let fastest = HURRY * Crowd::new(crossing::<Vec2>(20, 1.0)).unwrap().world.speed;
        let is_good = |speed: f32| with_plan(|p| p.velocity = Vec2::from_angle(0.7) * speed).is_ok();
        assert!(is_good(fastest) && is_good(fastest * (1.0 + 5e-6)), "rounding is let be");
        assert!(!is_good(fastest * 1.0001) && !is_good(fastest * 1.005) && !is_good(f32::NAN));
        let is_good = |share: f32| with_plan(|p| p.acceleration = Vec2::from_angle(0.7) * (share * p.limit)).is_ok();
        assert!(is_good(1.0) && !is_good(1.0001));
    }

    #[test]
    fn an_intent_that_is_no_unit_vector_is_refused() {
        let is_good = |intent| restored(|crowd| crowd.minds[3].intent = intent).is_ok();
        assert!(is_good(Vec2::ZERO) && is_good(Vec2::from_angle(2.0)));
        assert!(!is_good(Vec2::X * 1.01) && !is_good(Vec2::NAN) && !is_good(Vec2::Y * f32::INFINITY));
    }

    #[test]
    fn a_flow_that_nobody_makes_is_refused() {
        let is_good = |velocity, intent| restored(|crowd| crowd.flow.add(Vec2::ZERO, velocity, intent)).is_ok();
        assert!(is_good(Vec2::X, Vec2::X) && is_good(Vec2::ZERO, Vec2::ZERO));
        assert!(!is_good(Vec2::X * 90.0, Vec2::X) && !is_good(Vec2::X, Vec2::X * 20.0));
        assert!(!is_good(Vec2::NAN, Vec2::X) && !is_good(Vec2::X, Vec2::NEG_Y * f32::INFINITY));
    }

    /// Bytes of each member, and of each square of the flow.
    fn size<V: Space>() -> [usize; 2] {
        let config = bincode::config::standard().with_fixed_int_encoding();
        let len = |num| {
            let crowd = Crowd::new(crossing::<V>(num, 1.0)).unwrap();
            let flow = bincode::serde::encode_to_vec(&crowd.flow, config).unwrap().len();
            [crowd.snapshot().len() - flow, flow, crowd.flow.num_squares()]
        };
        let (few, many) = (len(100), len(300));
        [(many[0] - few[0]) / 200, (many[1] - few[1]) / (many[2] - few[2])]
    }

    #[test]
    fn a_snapshot_is_as_large_as_it_says() {
        assert_eq!(size::<Vec2>(), [151, 20]);
        assert_eq!(size::<Vec3>(), [175, 28]);
    }
}
