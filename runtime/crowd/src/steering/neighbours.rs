//! The neighbour query: agents registered near an agent, found once in each event, eight at a time.

use crate::space::batch::{Eight, VectorLanes, nth_vector, set_bits};
use crate::space::cells::{CellGrid, PackedPlan};
use crate::{Space, steering::forces::SteeredAgent, steering::sight::SeenNeighbour};
use throng_base::simd::{LANES, LaneWork, Lanes, dispatch};

/// About the time of the first contact: the agent that is nearest then is met early (s).
const SOON_S: f32 = 0.2;

/// Eight neighbours, as an agent finds them at its event.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NeighbourLanes<V, F> {
    /// Offset from the deciding agent (m).
    pub offset: VectorLanes<V, F>,
    /// (m/s)
    pub velocity: VectorLanes<V, F>,
    /// Distance of the centres (m).
    pub distance: F,
    /// Distance less the radii (m).
    pub gap: F,
    /// Speed of the agent that looks toward them, and theirs away from it (m/s).
    pub toward: F,
    pub away: F,
    /// Distance ahead, along the desired direction of the agent (m).
    pub ahead: F,
    /// Radii (m).
    pub radius: F,
    /// Largest accelerations (m/s2).
    pub limit: F,
}

/// Data of eight neighbours or fewer, as in [`NeighbourLanes`], kept for a new plan: more is needed of few of them only, once
/// the length of the plan is known.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct NeighbourRow {
    pub gap: Eight,
    pub toward: Eight,
    pub away: Eight,
    pub limit: Eight,
    /// Time until their plans end (s).
    pub until_end: Eight,
    pub agents: [u32; LANES],
    /// Bit i is set where lane i holds an agent.
    pub present: u8,
}

/// Room for rows, which are written in place.
#[derive(Clone, Debug, Default)]
pub(crate) struct NeighbourRows {
    rows: Vec<NeighbourRow>,
    len: usize,
    /// Row and place of the neighbour with the smallest gap a short time on.
    pub nearest: Option<(usize, usize)>,
    /// Smallest such gap (m).
    least: f32,
}

impl NeighbourRows {
    /// Memory for so many.
    pub fn new(capacity: usize) -> Self {
        Self { rows: vec![NeighbourRow::default(); capacity], ..Self::default() }
    }

    /// Rows that were found.
    #[inline]
    pub fn found_rows(&self) -> &[NeighbourRow] {
        &self.rows[..self.len]
    }

    /// Forgets all of them.
    #[inline]
    fn clear(&mut self) {
        (self.len, self.nearest, self.least) = (0, None, f32::INFINITY);
    }

    /// Adds eight or fewer.
    #[inline(always)]
    fn push<V: Space, F: Lanes>(&mut self, agents: [u32; LANES], there: u8, end: &Eight, found: &NeighbourLanes<V, F>) {
        let soon = found.gap + (found.away - found.toward) * F::splat(SOON_S);
        let nearer = there & soon.bits_lt(F::splat(self.least));
        if nearer != 0 {
            let soon = soon.to_array();
            for i in set_bits(nearer) {
                if soon[i] < self.least {
                    (self.least, self.nearest) = (soon[i], Some((self.len, i)));
                }
            }
        }
        if self.len == self.rows.len() {
            self.rows.push(NeighbourRow::default());
        }
        let row = &mut self.rows[self.len];
        self.len += 1;
        (row.agents, row.present, row.until_end) = (agents, there, *end);
        found.gap.store(&mut row.gap);
        found.toward.store(&mut row.toward);
        found.away.store(&mut row.away);
        found.limit.store(&mut row.limit);
    }
}

/// A query for all agents registered in a cell and its neighbours.
pub(crate) struct NeighbourQuery<'a, V> {
    pub cells: &'a CellGrid<V>,
    /// Coordinates of the cell.
    pub at: [i32; 3],
    pub time: f64,
    /// The agent that looks.
    pub agent: u32,
    pub me: &'a SteeredAgent<V>,
    pub perception: PerceptionLimits,
}

/// Limits of the perception of an agent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PerceptionLimits {
    /// Distance within which it sees others (m).
    pub perception: f32,
    /// Gap within which it feels others (m).
    pub felt: f32,
    /// Time within which contacts matter (s).
    pub horizon: f32,
    /// Added to the radii of others (m).
    pub room: f32,
}

impl<V: Space> NeighbourQuery<'_, V> {
    /// Finds the neighbours within sight that the agent reacts to: those near enough for forces, and those in front that it
    /// may meet if it goes straight at them (see [`crate::steering::sight::DirectionalSight::see_all`]). For a new plan, `rows` are
    /// all others.
    ///
    /// - `room`: see [`CellGrid::agents_around`].
    pub fn find_neighbours(
        &self,
        room: &mut Vec<u32>,
        seen: &mut Vec<SeenNeighbour<V>>,
        rows: Option<&mut NeighbourRows>,
    ) {
        let around = self.cells.agents_around(self.at, room);
        dispatch(NeighbourJob { query: self, around, seen, rows });
    }

    #[inline(always)]
    fn neighbour_lanes<F: Lanes>(&self, kept: [&PackedPlan; LANES]) -> NeighbourLanes<V, F> {
        let age: Eight = kept.map(|k| (self.time - k.start) as f32);
        let (plans, radius) = PackedPlan::load_lanes::<V, F>(kept);
        let (position, velocity) = plans.motions_after(F::load(&age));
        let offset = position - VectorLanes::splat(self.me.position);
        let distance = offset.length_squared().sqrt();
        let per_distance = F::splat(1.0) / distance.max(F::splat(1e-6));
        NeighbourLanes {
            offset,
            velocity,
            distance,
            gap: distance - radius - F::splat(self.me.radius),
            toward: VectorLanes::splat(self.me.velocity).dot(offset) * per_distance,
            away: velocity.dot(offset) * per_distance,
            ahead: VectorLanes::splat(self.me.desired).dot(offset),
            radius,
            limit: plans.limit,
        }
    }

    /// Neighbours that the agent reacts to.
    #[inline(always)]
    fn perceived_lanes<F: Lanes>(&self, f: &NeighbourLanes<V, F>) -> u8 {
        let limits = &self.perception;
        let felt = f.gap.bits_lt(F::splat(limits.felt));
        // Straight at them it comes nearer with its desired speed, less their own speed away from it.
        let reach = F::splat(limits.horizon) * (F::splat(self.me.speed) - f.away);
        let met = (f.gap - F::splat(limits.room)).bits_lt(reach);
        let is_ahead = F::splat(-self.me.radius).bits_lt(f.ahead);
        f.distance.bits_lt(F::splat(limits.perception)) & (felt | met & is_ahead)
    }

    /// Adds some of eight to the neighbours that are seen.
    #[inline(always)]
    fn add_seen<F: Lanes>(&self, f: &NeighbourLanes<V, F>, which: u8, seen: &mut Vec<SeenNeighbour<V>>) {
        let (offset, velocity) = (f.offset.to_arrays(), f.velocity.to_arrays());
        let (distance, radius) = (f.distance.to_array(), f.radius.to_array());
        for i in set_bits(which) {
            seen.push(SeenNeighbour {
                offset: nth_vector(&offset, i),
                velocity: nth_vector(&velocity, i),
                distance: distance[i],
                radii: self.me.radius + radius[i],
                yields: true,
            });
        }
    }
}

/// See [`NeighbourQuery::find_neighbours`].
struct NeighbourJob<'a, V> {
    query: &'a NeighbourQuery<'a, V>,
    around: &'a [u32],
    seen: &'a mut Vec<SeenNeighbour<V>>,
    rows: Option<&'a mut NeighbourRows>,
}

impl<V: Space> LaneWork for NeighbourJob<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let Self { query, around, seen, mut rows } = self;
        if let Some(rows) = &mut rows {
            rows.clear();
        }
        for some in around.chunks(LANES) {
            // Of fewer than eight, the first one fills the free places.
            let agents: [u32; LANES] = std::array::from_fn(|i| some.get(i).copied().unwrap_or(some[0]));
            let own = (0..LANES).fold(0u8, |own, i| own | u8::from(agents[i] == query.agent) << i);
            let there = (0xFFu32 >> (LANES - some.len())) as u8 & !own;
            let kept = agents.map(|m| query.cells.packed_plan(m));
            let found = query.neighbour_lanes::<F>(kept);
            let perceived = there & query.perceived_lanes(&found);
            if perceived != 0 {
                query.add_seen(&found, perceived, seen);
            }
            if let Some(rows) = &mut rows {
                let until: Eight = kept.map(|k| (k.end - query.time) as f32);
                rows.push(agents, there, &until, &found);
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::space::plan::MotionPlan;
    use crate::steering::config::SteeringConfig;
    use crate::steering::sight::DirectionalSight;
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    const PERCEPTION: PerceptionLimits = PerceptionLimits { perception: 2.0, felt: 0.3, horizon: 1.0, room: 0.02 };

    /// Time at which the tests look.
    pub(crate) const NOW: f64 = 10.0;

    /// Agents of different ages, radii and lengths of plans that go about and brake, for tests of code that reads rows.
    pub(crate) fn crowd<V: Space>() -> impl Strategy<Value = Vec<MotionPlan<V>>> {
        let vector = || [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0].prop_map(V::from_coordinates);
        let times = (0.0f64..0.3, 0.01f64..0.5);
        let plan = (vector(), vector(), vector(), times, 0.1f32..0.4, any::<bool>()).prop_map(
            |(position, v, a, (age, until), radius, brakes)| {
                let mut plan = MotionPlan {
                    start: NOW - age,
                    end: NOW + until,
                    position,
                    velocity: v * 0.5,
                    acceleration: (a * 2.5).at_most(5.0),
                    moving: f32::INFINITY,
                    radius,
                    limit: 5.0,
                    ..MotionPlan::default()
                };
                if brakes {
                    plan.brake();
                }
                plan
            },
        );
        proptest::collection::vec(plan, 2..60).prop_map(|mut plans| {
            (0..).zip(&mut plans).for_each(|(index, p)| p.index = index);
            plans
        })
    }

    /// Cells with agents in them.
    fn cells_of<V: Space>(plans: &[MotionPlan<V>]) -> CellGrid<V> {
        let mut cells = CellGrid::new(2.5, V::from_coordinates([9.0; 3]), plans.len());
        for plan in plans {
            cells.insert(cells.number(cells.coordinates(plan.position)), plan);
        }
        cells
    }

    /// Cells with agents in them, and what the first one finds around it.
    pub(crate) fn rows_around<V: Space>(plans: &[MotionPlan<V>]) -> (CellGrid<V>, NeighbourRows) {
        let cells = cells_of(plans);
        let (position, velocity) = plans[0].motion_at(NOW);
        let me = SteeredAgent { position, velocity, radius: plans[0].radius, limit: 5.0, ..SteeredAgent::default() };
        let at = cells.coordinates(plans[0].position);
        let mut rows = NeighbourRows::default();
        let query = NeighbourQuery { cells: &cells, at, time: NOW, agent: 0, me: &me, perception: PERCEPTION };
        query.find_neighbours(&mut Vec::new(), &mut Vec::new(), Some(&mut rows));
        (cells, rows)
    }

    /// All others are found where their plans say, and seen if they matter.
    fn finds_everybody<V: Space>(plans: &[MotionPlan<V>]) -> Result<(), TestCaseError> {
        let cells = cells_of(plans);
        let (position, velocity) = plans[0].motion_at(NOW);
        let desired = V::from_coordinates([0.6, -0.8, 0.0]);
        let me = SteeredAgent {
            position,
            velocity,
            radius: 0.3,
            limit: 5.0,
            desired,
            speed: 1.3,
            ..SteeredAgent::default()
        };
        let at = cells.coordinates(plans[0].position);
        let see = |limits: PerceptionLimits| {
            let query = NeighbourQuery { cells: &cells, at, time: NOW, agent: 0, me: &me, perception: limits };
            let (mut rows, mut seen) = (NeighbourRows::default(), Vec::new());
            query.find_neighbours(&mut Vec::new(), &mut seen, Some(&mut rows));
            (rows, seen)
        };
        let (rows, seen) = see(PerceptionLimits { perception: 1e3, felt: 1e3, ..PERCEPTION });
        let plans = rows.found_rows().iter().flat_map(|r| set_bits(r.present).map(|i| cells.plan(r.agents[i])));
        let found: Vec<MotionPlan<V>> = plans.collect();
        let mut around = Vec::new();
        cells.for_each_cell_around(at, |cell| cells.for_each_in_cell(cell, |p| around.push(p.index)));
        around.sort_unstable();
        let mut indices: Vec<u32> = found.iter().map(|p| p.index).chain([0]).collect();
        indices.sort_unstable();
        prop_assert_eq!(&indices, &around);
        prop_assert_eq!(seen.len(), found.len());
        for (plan, seen) in found.iter().zip(&seen) {
            let (x, v) = plan.motion_at(NOW);
            prop_assert_eq!((seen.offset, seen.velocity), (x - position, v));
            prop_assert_eq!((seen.distance, seen.radii), ((x - position).length(), 0.3 + plan.radius));
        }
        check_that_skipped_neighbours_do_not_matter(&me, &seen, &see(PERCEPTION).1)
    }

    /// A neighbour within sight that is skipped exerts no force, and is met before the horizon in no direction.
    fn check_that_skipped_neighbours_do_not_matter<V: Space>(
        me: &SteeredAgent<V>,
        all: &[SeenNeighbour<V>],
        seen: &[SeenNeighbour<V>],
    ) -> Result<(), TestCaseError> {
        prop_assert!(seen.iter().all(|s| s.distance < PERCEPTION.perception));
        for other in all.iter().filter(|o| o.distance < PERCEPTION.perception) {
            if !seen.iter().any(|s| (s.offset, s.velocity) == (other.offset, other.velocity)) {
                prop_assert!(other.distance - other.radii > PERCEPTION.felt - 1e-5);
                let mut sight =
                    DirectionalSight::looking_along(me.desired, me.speed, PERCEPTION.horizon, &SteeringConfig::DEFAULT);
                sight.see_all(&[*other], -me.radius, 0.01, f32::INFINITY);
                prop_assert!(
                    sight.earliest_contact() > PERCEPTION.horizon,
                    "{other:?} is met after {} s",
                    sight.earliest_contact()
                );
            }
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn finds_everybody_around_on_the_ground(plans in crowd::<Vec2>()) {
            finds_everybody(&plans)?;
        }

        #[test]
        fn finds_everybody_around_in_the_air(plans in crowd::<Vec3>()) {
            finds_everybody(&plans)?;
        }
    }
}
