//! How a crowd finds out who has to act next: the scheme of 001, and what it shares with that of 000.

use super::bound::{Bound, fall_each};
use super::cells::{Cells, nth};
use super::decide::{Cause, Decider, Scratch};
use super::fixed::Fixed;
use super::near::{Row, bits};
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
    /// When the bound of a new plan touches something first, and what.
    #[inline]
    pub fn first_event<V: Space>(
        self,
        at: &Decider<'_, V>,
        fresh: &Plan<V>,
        region: (V, V),
        near: &[u32],
        scratch: &mut Scratch<V>,
    ) -> (Cause, f32) {
        let bound = Bound::from(fresh);
        let first = match self {
            Self::Registration => {
                let region = (Cause::Region, bound.first_exit(region.0, region.1));
                dispatch(Meet { cells: at.cells, bound: &bound, rows: scratch.rows.all_mut(), first: region })
            }
            Self::Occupancy(occupancy) => occupancy.first_meeting(at, fresh),
        };
        at.first_obstacle(&bound, near, first)
    }
}

/// Looks for the first of all around whose bound is touched, if that is before `first`. At an event it is known where
/// everybody is, so that all bounds are taken as made then: that is never late, and they meet later than old ones.
struct Meet<'a, V> {
    cells: &'a Cells<V>,
    bound: &'a Bound<V>,
    rows: &'a mut [Row],
    first: (Cause, f32),
}

impl<V: Space> Meet<'_, V> {
    /// The first meeting with one of a row, if that is before all that is known.
    #[inline]
    fn meet(&mut self, row: usize, i: usize) {
        let row = &self.rows[row];
        let block = self.cells.block(row.block);
        let (radii, growth) = (self.bound.radius + block.radius[i], self.bound.limit + block.limit[i]);
        let (offset, velocity) = (nth(&row.offset, i), nth(&row.velocity, i));
        let contact = self.bound.first_meeting(offset, velocity, radii, growth, self.first.1);
        if contact < self.first.1 {
            self.first = (Cause::Member(block.index[i]), contact);
        }
    }
}

impl<V: Space> Work for Meet<'_, V> {
    type Output = (Cause, f32);

    #[inline(always)]
    fn run<F: Lanes>(mut self) -> Self::Output {
        // Their first tangents alone leave only a few.
        let (mut least, mut nearest) = (self.first.1, None);
        for (n, row) in self.rows.iter_mut().enumerate() {
            let block = self.cells.block(row.block);
            let gap = F::load(&row.distance) - F::load(&block.radius) - F::splat(self.bound.radius);
            let growth = F::load(&block.limit) + F::splat(self.bound.limit);
            let soonest = F::splat(0.999) * fall_each(gap, -F::load(&row.closing), growth);
            soonest.store(&mut row.soonest);
            for i in bits(row.there & soonest.bits_lt(F::splat(least))) {
                if row.soonest[i] < least {
                    (least, nearest) = (row.soonest[i], Some((n, i)));
                }
            }
        }
        let Some((at, nearest)) = nearest else { return self.first };
        self.meet(at, nearest);
        for n in 0..self.rows.len() {
            let row = &self.rows[n];
            for i in bits(row.there & F::load(&row.soonest).bits_lt(F::splat(self.first.1))) {
                if (n, i) != (at, nearest) {
                    self.meet(n, i);
                }
            }
        }
        self.first
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
    fn first_of_all<V: Space>(plans: &[Plan<V>], cells: &Cells<V>, rows: &[Row], first: f32) -> f32 {
        let me = Bound::new(&plans[0], NOW);
        let others = rows.iter().flat_map(|r| bits(r.there).map(|i| cells.block(r.block).plan::<V>(i)));
        let meeting = others.map(|other| {
            let (x, v) = other.at(NOW);
            let (radii, growth) = (me.radius + other.radius, me.limit + other.limit);
            me.first_meeting(x - me.position, v, radii, growth, f32::INFINITY)
        });
        meeting.fold(first, f32::min)
    }

    fn finds_the_first<V: Space>(mut plans: Vec<Plan<V>>, first: f32) -> Result<(), TestCaseError> {
        // Nobody ever overlaps anybody.
        let me = plans[0];
        plans.retain(|p| p.index == 0 || (p.at(NOW).0 - me.at(NOW).0).length() > p.radius + me.radius + 1e-4);
        (0..).zip(&mut plans).for_each(|(index, p)| p.index = index);
        let plans = &plans[..];
        let (cells, mut rows) = rows_around(plans);
        let want = first_of_all(plans, &cells, rows.all(), first);
        let bound = Bound::new(&plans[0], NOW);
        let known = (Cause::Region, first);
        let (cause, got) = dispatch(Meet { cells: &cells, bound: &bound, rows: rows.all_mut(), first: known });
        prop_assert!((got - want).abs() <= 1e-5 * want, "{cause:?} after {got} s, the first is after {want} s");
        prop_assert_eq!(cause == Cause::Region, got == first, "a member is met before what was known");
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
