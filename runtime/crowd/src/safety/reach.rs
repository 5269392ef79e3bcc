//! Stop regions that a plan may reach: a coarse test that leaves few plans to compare exactly.

use crate::{Space, space::batch::set_bits, space::cells::CellGrid, space::plan::MotionPlan};
use crate::{safety::nearby_plans::NearbyPlans, steering::neighbours::NeighbourRow};
use throng_base::simd::{LaneWork, Lanes, dispatch};

/// Room for rounding (m).
const ROOM: f32 = 0.01;

/// A plan with any acceleration.
pub(crate) struct PlanReach<'a, V> {
    pub cells: &'a CellGrid<V>,
    /// Largest speed of any agent (m/s).
    pub fastest: f32,
    /// Start of the plan.
    pub fresh: &'a MotionPlan<V>,
    /// Largest length of the plan (s).
    pub length: f32,
    /// Largest distance of its stop region's edge from its centre (m).
    pub mine: f32,
}

impl<'a, V: Space> PlanReach<'a, V> {
    /// For a plan of a length at most, made at its start.
    pub fn new(cells: &'a CellGrid<V>, fastest: f32, fresh: &'a MotionPlan<V>, length: f32) -> Self {
        let speed = fresh.velocity.length();
        let fastest = fastest.max(speed);
        let fast = (speed + fresh.limit * length).min(fastest);
        let mine = fast * length + 0.5 * fast * fast / fresh.limit + fresh.radius + ROOM;
        Self { cells, fastest, fresh, length, mine }
    }

    /// Adds the neighbours whose stop regions it may reach, of rows that were found at its start.
    pub fn find_neighbours(&self, rows: &[NeighbourRow], others: &mut NearbyPlans) {
        dispatch(FindReachableJob { reach: self, rows, others });
    }
}

/// Largest extent of a stop region along some direction within a time, for an agent with a part of its velocity along
/// that direction and a limit of acceleration.
///
/// - `stopping`: half the time in which it stops from the largest speed that it can have at the end (s).
#[inline(always)]
fn extent<F: Lanes>(part: F, limit: F, stopping: F, time: F) -> F {
    let (zero, half) = (F::splat(0.0), F::splat(0.5));
    let gain = limit * time;
    (part.max(zero) + half * gain) * time + (part + gain).max(zero) * stopping
}

/// See [`PlanReach::find_neighbours`].
struct FindReachableJob<'a, V> {
    reach: &'a PlanReach<'a, V>,
    rows: &'a [NeighbourRow],
    others: &'a mut NearbyPlans,
}

impl<V: Space> LaneWork for FindReachableJob<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let &PlanReach { cells, fastest, fresh, length, .. } = self.reach;
        let last = (fresh.velocity.length() + fresh.limit * length).min(fastest);
        let (own_limit, own_stopping) = (F::splat(fresh.limit), F::splat(0.5 * last / fresh.limit));
        let (length, half_fastest) = (F::splat(length), F::splat(0.5 * fastest));
        for row in self.rows {
            let limit = F::load(&row.limit);
            let its = extent(-F::load(&row.away), limit, half_fastest / limit, F::load(&row.until_end));
            let room = F::load(&row.gap) - F::splat(ROOM) - its;
            let own = extent(F::load(&row.toward), own_limit, own_stopping, length);
            for i in set_bits(row.present & room.bits_lt(own)) {
                self.others.push(&cells.plan(row.agents[i]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::safety::rule::{PlanCandidate, clearance};
    use crate::steering::neighbours::tests::{NOW, crowd, rows_around};
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;
    use throng_base::simd::ArrayLanes;

    /// Samples the stop regions of the first of some plans, with some acceleration from now on, and of all plans that it is not
    /// compared with: they are apart.
    fn leaves_out_only_who_is_apart<V: Space>(plans: &[MotionPlan<V>], a: V, length: f32) -> Result<(), TestCaseError> {
        let fastest = plans.iter().flat_map(|p| [p.velocity, p.motion_at(p.end).1]).map(V::length).fold(0.0, f32::max);
        let (cells, rows) = rows_around(plans);
        let (position, velocity) = plans[0].motion_at(NOW);
        let fresh = MotionPlan { start: NOW, position, velocity, moving: f32::INFINITY, ..plans[0] };
        let reach = PlanReach::new(&cells, fastest, &fresh, length);
        let mut others = NearbyPlans::default();
        reach.find_neighbours(rows.found_rows(), &mut others);
        others.prepare(position, NOW);
        for share in [0.3, 1.0] {
            // As candidates are made.
            let length = share * length;
            let a = ((velocity + a.at_most(fresh.limit) * length).at_most(fastest) - velocity) * length.recip();
            let me = PlanCandidate::new(MotionPlan {
                end: NOW + f64::from(length),
                acceleration: a.at_most(fresh.limit),
                ..fresh
            });
            let compared = others.agents_within(me.reach());
            for row in rows.found_rows() {
                for i in set_bits(row.present) {
                    let other: MotionPlan<V> = cells.plan(row.agents[i]);
                    if compared.contains(&other.index) {
                        continue;
                    }
                    for i in 0..=40 {
                        let time = NOW + f64::from(i) * 0.015;
                        let still = |p: &MotionPlan<V>| {
                            let (position, velocity) = p.motion_at(time.min(p.end));
                            MotionPlan { position, velocity, ..*p }
                        };
                        let clearance = clearance(&still(&me.plan), &still(&other));
                        prop_assert!(clearance > 0.0, "{} overlaps by {} m at {time}", other.index, -clearance);
                    }
                }
            }
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn skipped_plans_on_the_ground_stay_apart(
            plans in crowd::<Vec2>(), a in [-5.0f32..5.0, -5.0f32..5.0], length in 0.05f32..0.5,
        ) {
            leaves_out_only_who_is_apart(&plans, Vec2::from_array(a), length)?;
        }

        #[test]
        fn skipped_plans_in_the_air_stay_apart(
            plans in crowd::<Vec3>(), a in [-5.0f32..5.0, -5.0f32..5.0, -5.0f32..5.0], length in 0.05f32..0.5,
        ) {
            leaves_out_only_who_is_apart(&plans, Vec3::from_array(a), length)?;
        }

        #[test]
        fn extent_bounds_stop_regions(
            v in [-1.1f32..1.1, -1.1f32..1.1], a in [-5.0f32..5.0, -5.0f32..5.0], length in 0.01f32..0.6, brakes in any::<bool>(),
        ) {
            const FASTEST: f32 = 1.6;
            let (velocity, limit) = (Vec2::from_array(v), 5.0);
            // As candidates are made: no faster at the end than the largest speed.
            let last = (velocity + Vec2::from_array(a).clamp_length_max(limit) * length).clamp_length_max(FASTEST);
            let acceleration = (last - velocity) / length;
            let mut plan = MotionPlan { velocity, acceleration, limit, moving: f32::INFINITY, ..MotionPlan::default() };
            if brakes {
                plan.brake();
            }
            for direction in [Vec2::X, Vec2::from_angle(2.0), Vec2::from_angle(4.0)] {
                let part = velocity.dot(direction);
                let s = ArrayLanes::splat;
                let last = (velocity.length() + limit * length).min(FASTEST);
                let most = extent(s(part), s(limit), s(0.5 * last / limit), s(length)).to_array()[0];
                for i in 0..=50 {
                    let (from, to) = plan.stop_region(length * i as f32 / 50.0);
                    prop_assert!(from.dot(direction).max(to.dot(direction)) <= most + 1e-5, "{from} {to} {direction}: {most}");
                }
            }
        }
    }
}
