//! How a crowd finds out who has to act next: the scheme of 001, and what it shares with that of 000.

use super::bound::{Bound, fall_each};
use super::cells::Cells;
use super::decide::{Cause, Decider};
use super::eights::bits;
use super::fixed::Fixed;
use super::near::{Row, Rows};
use super::occupancy::{Occupancy, narrowest};
use super::plan::Plan;
use super::{CrowdConfig, CrowdError, Member, Scheme, Space};
use crate::lanes::{Lanes, Work, dispatch};
use serde::{Deserialize, Serialize};

/// How a member at an event finds out when it acts next.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tracer<'a> {
    /// The scheme of 001 section 2.1: a bound stays in the region around the cell it is registered in, so that it can
    /// only meet those who are registered in cells next to that.
    Registration,
    /// The scheme of 000 section 2: who is in the same cells.
    Occupancy(&'a Occupancy),
}

impl Tracer<'_> {
    /// When the bound of a new plan touches something first, and what; `meeting` is what came of the look around.
    #[inline]
    pub fn first_event<V: Space>(
        self,
        at: &Decider<'_, V>,
        fresh: &Plan<V>,
        meeting: &Meeting<V>,
        near: &[u32],
    ) -> (Cause, f32) {
        let first = match self {
            Self::Registration => meeting.first,
            Self::Occupancy(occupancy) => occupancy.first_meeting(at, fresh),
        };
        at.first_obstacle(&meeting.bound, near, first)
    }
}

/// The first of all around whose bound is touched, as far as they were looked at. At an event it is known where everybody
/// is, so that all bounds are taken as made then: that is never late, and they meet later than old ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting<V> {
    /// That of the member, as made at its event.
    pub bound: Bound<V>,
    /// What ends its plan, and in what time; who is met after that does not matter. [Unit: s]
    pub first: (Cause, f32),
}

impl<V: Space> Meeting<V> {
    /// With nobody yet: when the bound of a plan leaves its region, if it has one.
    #[inline]
    pub fn new(fresh: &Plan<V>, region: Option<(V, V)>) -> Self {
        let bound = Bound::from(fresh);
        Self { bound, first: (Cause::Region, region.map_or(f32::INFINITY, |r| bound.first_exit(r.0, r.1))) }
    }

    /// Finds the first among those who were found: few of them are looked at closely.
    pub fn look(&mut self, cells: &Cells<V>, rows: &Rows) {
        dispatch(Look { meeting: self, cells, rows });
    }

    /// Those of a row who may be met before all that is known, and when that is at the earliest, as their first tangents
    /// say.
    #[inline(always)]
    fn soonest<F: Lanes>(&self, row: &Row) -> (u8, F) {
        let (gap, rate) = (F::load(&row.gap), F::load(&row.away) - F::load(&row.toward));
        let (growth, first) = (F::splat(self.bound.limit) + F::load(&row.limit), F::splat(self.first.1));
        // At `first` there is no gap any more.
        let left = gap + (rate - F::splat(0.5) * growth * first) * first;
        let some = row.there & left.bits_lt(F::splat(0.0));
        if some == 0 {
            return (0, F::splat(f32::INFINITY));
        }
        let soonest = F::splat(0.999) * fall_each(gap, rate, growth);
        (some & soonest.bits_lt(first), soonest)
    }

    /// The first meeting with somebody, if that is before all that is known.
    #[inline]
    fn meet(&mut self, other: &Plan<V>) {
        let (x, v) = other.at(self.bound.start);
        let (radii, growth) = (self.bound.radius + other.radius, self.bound.limit + other.limit);
        let contact = self.bound.first_meeting(x - self.bound.position, v, radii, growth, self.first.1);
        if contact < self.first.1 {
            self.first = (Cause::Member(other.index), contact);
        }
    }
}

/// See [`Meeting::look`].
struct Look<'a, V> {
    meeting: &'a mut Meeting<V>,
    cells: &'a Cells<V>,
    rows: &'a Rows,
}

impl<V: Space> Work for Look<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let Self { meeting, cells, rows } = self;
        let Some((at, nearest)) = rows.nearest() else { return };
        // Whoever is met early leaves few who may be met earlier.
        meeting.meet(&cells.plan(rows.all()[at].members[nearest]));
        for (n, row) in rows.all().iter().enumerate() {
            let (some, soonest) = meeting.soonest::<F>(row);
            if some == 0 {
                continue;
            }
            let soonest = soonest.to_array();
            for i in bits(some) {
                if soonest[i] < meeting.first.1 && (n, i) != (at, nearest) {
                    meeting.meet(&cells.plan(row.members[i]));
                }
            }
        }
    }
}

/// What a scheme remembers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(bound = "V: Space")]
pub(crate) enum Trace<V> {
    /// See [`super::Scheme::Registration`].
    #[default]
    Registration,
    /// See [`super::Scheme::Occupancy`].
    Occupancy(Occupancy),
    /// See [`super::Scheme::Fixed`].
    Fixed(Fixed<V>),
}

impl<V: Space> Trace<V> {
    /// Nothing yet.
    pub fn new(config: &CrowdConfig, cells: &Cells<V>, capacity: usize) -> Self {
        match config.scheme {
            Scheme::Registration => Self::Registration,
            Scheme::Occupancy => Self::Occupancy(Occupancy::new(cells.num_cells(), capacity)),
            Scheme::Fixed => Self::Fixed(Fixed::new(config.step_s, config.halvings, capacity)),
        }
    }

    /// One who comes is within the limits of the scheme.
    ///
    /// # Errors
    /// [`CrowdError::Value`].
    pub fn check(&self, index: usize, m: &Member<V>, side: f32, interval: f32) -> Result<(), CrowdError> {
        if matches!(self, Self::Occupancy(_)) && narrowest(m.radius, m.acceleration, interval) > side {
            let expected = "small enough that a bound is not wider than a cell after the smallest interval";
            return Err(CrowdError::Value {
                what: "member",
                index,
                field: "acceleration",
                got: m.acceleration,
                expected,
            });
        }
        Ok(())
    }

    /// True where what was read is of the same scheme as another one, as large, and right for the plans of its members.
    pub fn fits<'a>(&self, other: &Self, side: f32, now: f64, plan: impl Fn(u32) -> Option<&'a Plan<V>>) -> bool {
        match (self, other) {
            (Self::Registration, Self::Registration) => true,
            (Self::Occupancy(a), Self::Occupancy(b)) => a.fits(b, side, now, plan),
            (Self::Fixed(a), Self::Fixed(b)) => a.fits(b, now),
            _ => false,
        }
    }

    /// What is not read, but made of the rest; and memory.
    pub fn reserve(&mut self, cells: &Cells<V>, capacity: usize) {
        match self {
            Self::Registration => (),
            Self::Occupancy(occupancy) => occupancy.relink(cells),
            Self::Fixed(fixed) => fixed.reserve(capacity),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::near::tests::{NOW, crowd, rows_around};
    use glam::{Vec2, Vec3};
    use proptest::prelude::*;

    /// The first of all meetings, each looked for by itself; or `first`, if that is before all of them.
    fn first_of_all<V: Space>(bound: &Bound<V>, others: &[Plan<V>], first: f32) -> f32 {
        let meeting = others.iter().map(|other| {
            let mut alone = Meeting { bound: *bound, first: (Cause::Region, f32::INFINITY) };
            alone.meet(other);
            alone.first.1
        });
        meeting.fold(first, f32::min)
    }

    fn finds_the_first<V: Space>(mut plans: Vec<Plan<V>>, first: f32) -> Result<(), TestCaseError> {
        // Nobody ever overlaps anybody.
        let me = plans[0];
        plans.retain(|p| p.index == 0 || (p.at(NOW).0 - me.at(NOW).0).length() > p.radius + me.radius + 1e-4);
        (0..).zip(&mut plans).for_each(|(index, p)| p.index = index);
        let plans = &plans[..];
        let mut meeting = Meeting { bound: Bound::new(&plans[0], NOW), first: (Cause::Region, first) };
        let (cells, rows) = rows_around(plans);
        meeting.look(&cells, &rows);
        let (cause, got) = meeting.first;
        let found = rows.all().iter().flat_map(|r| bits(r.there).map(|i| cells.plan(r.members[i])));
        let found: Vec<Plan<V>> = found.collect();
        let want = first_of_all(&meeting.bound, &found, first);
        prop_assert!((got - want).abs() <= 1e-5 * want, "{cause:?} after {got} s, the first is after {want} s");
        prop_assert_eq!(cause == Cause::Region, got == first, "a member is met before what was known");
        found.iter().try_for_each(|other| are_apart_until(&meeting.bound, other, got))
    }

    /// Samples two bounds that were made now.
    fn are_apart_until<V: Space>(me: &Bound<V>, other: &Plan<V>, until: f32) -> Result<(), TestCaseError> {
        for i in 0..100 {
            let time = NOW + f64::from(until) * f64::from(i) / 100.0;
            let (x, radius) = me.at(time);
            let (y, its_radius) = Bound::new(other, NOW).at(time);
            let gap = (x - y).length() - radius - its_radius;
            prop_assert!(gap > -1e-4, "{gap} m to {} at {time}, met first after {until} s", other.index);
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn nobody_on_the_ground_is_met_earlier(plans in crowd::<Vec2>(), first in 0.05f32..2.0) {
            finds_the_first(plans, first)?;
        }

        #[test]
        fn nobody_in_the_air_is_met_earlier(plans in crowd::<Vec3>(), first in 0.05f32..2.0) {
            finds_the_first(plans, first)?;
        }
    }
}
