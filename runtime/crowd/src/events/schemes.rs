//! Schedule of an agent's next event: the scheme of Kim, Kim and Shin (2003b), and the interface of others.

use crate::events::occupancy::Occupancy;
use crate::safety::bound::{Bound, time_until_gone_lanes};
use crate::steering::neighbours::{NeighbourRow, NeighbourRows};
use crate::{Space, events::decide::Cause, space::batch::set_bits, space::cells::CellGrid, space::plan::MotionPlan};
use throng_base::simd::{LaneWork, Lanes, dispatch};

/// Scheme by which an agent at an event computes its next one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SchemeRef<'a> {
    /// Lists of the bounds in each cell (Kim, Kim and Shin 2003a, section 2).
    pub lists: Option<&'a Occupancy>,
}

/// The scheme of Kim, Kim and Shin (2003b), section 2.1: a bound stays in the region around the cell it is registered
/// in, so that it can only meet agents registered in neighbouring cells.
pub(crate) const REGISTRATION: SchemeRef<'static> = SchemeRef { lists: None };

/// First contact of an agent's bound with that of a neighbour. At an event all positions are known, so that all bounds
/// are taken as made then: a contact is never found late, and later than with old bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstContact<V> {
    /// Bound of the agent, made at its event.
    pub bound: Bound<V>,
    /// Cause that ends its plan, and the time until then (s); later contacts do not matter.
    pub first: (Cause, f32),
}

impl<V: Space> FirstContact<V> {
    /// Contact before any neighbours: the time at which the bound of a plan leaves its region, if it has one.
    #[inline]
    pub fn new(fresh: &MotionPlan<V>, region: Option<(V, V)>) -> Self {
        let bound = Bound::from(fresh);
        Self { bound, first: (Cause::Region, region.map_or(f32::INFINITY, |r| bound.first_exit(r.0, r.1))) }
    }

    /// Finds the first contact among the neighbours; few of them are compared exactly.
    pub fn find_among(&mut self, cells: &CellGrid<V>, rows: &NeighbourRows) {
        dispatch(FirstContactJob { meeting: self, cells, rows });
    }

    /// Neighbours of a row that may be met before the first known contact, and the earliest time for that, from first
    /// tangents.
    #[inline(always)]
    fn soonest_in_row<F: Lanes>(&self, row: &NeighbourRow) -> (u8, F) {
        let (gap, rate) = (F::load(&row.gap), F::load(&row.away) - F::load(&row.toward));
        let (growth, first) = (F::splat(self.bound.limit) + F::load(&row.limit), F::splat(self.first.1));
        // The gap is gone at `first`.
        let left = gap + (rate - F::splat(0.5) * growth * first) * first;
        let some = row.present & left.bits_lt(F::splat(0.0));
        if some == 0 {
            return (0, F::splat(f32::INFINITY));
        }
        let soonest = F::splat(0.999) * time_until_gone_lanes(gap, rate, growth);
        (some & soonest.bits_lt(first), soonest)
    }

    /// The first contact with a neighbour, if that is before the first known one.
    #[inline]
    fn compare_with(&mut self, other: &MotionPlan<V>) {
        let (x, v) = other.motion_at(self.bound.start);
        let (radii, growth) = (self.bound.radius + other.radius, self.bound.limit + other.limit);
        let contact = self.bound.first_meeting(x - self.bound.position, v, radii, growth, self.first.1);
        if contact < self.first.1 {
            self.first = (Cause::Agent(other.index), contact);
        }
    }
}

/// See [`FirstContact::find_among`].
struct FirstContactJob<'a, V> {
    meeting: &'a mut FirstContact<V>,
    cells: &'a CellGrid<V>,
    rows: &'a NeighbourRows,
}

impl<V: Space> LaneWork for FirstContactJob<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let Self { meeting, cells, rows } = self;
        let Some((at, nearest)) = rows.nearest else { return };
        // An early contact leaves few neighbours that may be met before.
        meeting.compare_with(&cells.plan(rows.found_rows()[at].agents[nearest]));
        for (n, row) in rows.found_rows().iter().enumerate() {
            let (some, soonest) = meeting.soonest_in_row::<F>(row);
            if some == 0 {
                continue;
            }
            let soonest = soonest.to_array();
            for i in set_bits(some) {
                if soonest[i] < meeting.first.1 && (n, i) != (at, nearest) {
                    meeting.compare_with(&cells.plan(row.agents[i]));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::steering::neighbours::tests::{NOW, crowd, rows_around};
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    /// The first of all meetings, each looked for by itself; or `first`, if that is before all of them.
    fn first_of_all<V: Space>(bound: &Bound<V>, others: &[MotionPlan<V>], first: f32) -> f32 {
        let meeting = others.iter().map(|other| {
            let mut alone = FirstContact { bound: *bound, first: (Cause::Region, f32::INFINITY) };
            alone.compare_with(other);
            alone.first.1
        });
        meeting.fold(first, f32::min)
    }

    fn finds_the_first<V: Space>(mut plans: Vec<MotionPlan<V>>, first: f32) -> Result<(), TestCaseError> {
        // No two agents ever overlap.
        let me = plans[0];
        plans.retain(|p| {
            p.index == 0 || (p.motion_at(NOW).0 - me.motion_at(NOW).0).length() > p.radius + me.radius + 1e-4
        });
        (0..).zip(&mut plans).for_each(|(index, p)| p.index = index);
        let plans = &plans[..];
        let mut meeting = FirstContact { bound: Bound::new(&plans[0], NOW), first: (Cause::Region, first) };
        let (cells, rows) = rows_around(plans);
        meeting.find_among(&cells, &rows);
        let (cause, got) = meeting.first;
        let found = rows.found_rows().iter().flat_map(|r| set_bits(r.present).map(|i| cells.plan(r.agents[i])));
        let found: Vec<MotionPlan<V>> = found.collect();
        let want = first_of_all(&meeting.bound, &found, first);
        prop_assert!((got - want).abs() <= 1e-5 * want, "{cause:?} after {got} s, the first is after {want} s");
        prop_assert_eq!(cause == Cause::Region, got == first, "an agent is met before what was known");
        found.iter().try_for_each(|other| are_apart_until(&meeting.bound, other, got))
    }

    /// Samples two bounds that were made now.
    fn are_apart_until<V: Space>(me: &Bound<V>, other: &MotionPlan<V>, until: f32) -> Result<(), TestCaseError> {
        for i in 0..100 {
            let time = NOW + f64::from(until) * f64::from(i) / 100.0;
            let (x, radius) = me.disc_at(time);
            let (y, its_radius) = Bound::new(other, NOW).disc_at(time);
            let gap = (x - y).length() - radius - its_radius;
            prop_assert!(gap > -1e-4, "{gap} m to {} at {time}, met first after {until} s", other.index);
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn first_contact_on_the_ground_is_first(plans in crowd::<Vec2>(), first in 0.05f32..2.0) {
            finds_the_first(plans, first)?;
        }

        #[test]
        fn first_contact_in_the_air_is_first(plans in crowd::<Vec3>(), first in 0.05f32..2.0) {
            finds_the_first(plans, first)?;
        }
    }
}
