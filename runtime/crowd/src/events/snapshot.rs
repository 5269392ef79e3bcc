//! Keeping the whole state of a crowd, and telling two states apart.

use crate::error::{CrowdError, Result};
use crate::events::decide::{AgentState, Cause};
use crate::scenery::{CrowdScenery, Door};
use crate::{CrowdSetup, EventCounts, NONE, Route, Space, steering::relationships::AgentRelationships};
use crate::{events::engine::Engine, safety::saved_plans, senses::SensingState, space::cells::CellGrid};
use crate::{events::occupancy::Occupancy, routes::passages::PassageTurn, steering::density_grid::DensityGrid};
use crate::{routes::goals::GoalTable, routes::path::RoutePath, routes::streets::Streets, space::plan::MotionPlan};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use throng_base::{Error, Hash128, SnapshotKind, StateHash, error::ensure};

/// Grows by one with every change of what is kept.
const VERSION: u32 = 11;

/// What another scheme than [`crate::Scheme::Registration`] remembers. Builds with `Scheme::Fixed` keep the same of all others.
#[derive(Serialize, Deserialize)]
enum OtherScheme {
    Occupancy(Occupancy),
    #[cfg(feature = "fixed-steps")]
    Fixed(crate::events::fixed::Steps),
}

/// State that changes with time.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct SavedCrowd<V> {
    now: f64,
    counts: EventCounts,
    free: Vec<u32>,
    states: Vec<AgentState<V>>,
    routes: Vec<Route<V>>,
    /// Routes of agents that stay where they are.
    staying: Vec<u32>,
    own_routes: Vec<u32>,
    /// Plans in the order in which they are put back into the cells.
    plans: Vec<MotionPlan<V>>,
    grid: DensityGrid<V>,
    refreshes: u64,
    /// Turns of passages.
    turns: Vec<PassageTurn>,
    /// States of the doors.
    doors: Vec<Door>,
    /// Sensing agents and their states.
    sensing: Vec<(u32, SensingState)>,
    /// Agents with relationships.
    relationships: Vec<(u32, AgentRelationships<V>)>,
    scheme: Option<OtherScheme>,
}

/// Refusal of a snapshot.
fn refused(why: impl ToString) -> CrowdError {
    Error::Snapshot { what: "crowd", why: why.to_string() }.into()
}

/// No agent can have walked farther from the starts (m).
const FARTHEST_M: f32 = 1e6;
/// Factor by which rounding may bring a speed or an acceleration beyond its limit. More would not do: the search for
/// neighbours does not reach as far as a faster agent could come from, see [`crate::safety::reach`].
const ROUNDING: f32 = 1.0 + 1e-5;
/// Number of subgoals for each agent and for each of some routes that were added, beside those of the setup: with
/// streets, each subgoal takes a search over all corners.
const SUBGOALS_EACH: usize = 64;
const MORE_ROUTES: usize = 64;
/// Longest that a unit vector may be.
const UNIT: f32 = 1.001;

impl<V: Space> Engine<V> {
    /// Kind of a snapshot of this crowd.
    fn snapshot_kind(&self) -> SnapshotKind {
        SnapshotKind { what: "crowd", tag: *b"CRWD", version: VERSION, setup: self.setup_hash }
    }

    /// Hash of all that a state is meaningless without: the space, fields, obstacles, streets, config and sizes. The same
    /// with and without the feature `fixed-steps`, unless such steps are taken. A new field of [`CrowdSetup`] that changes motion and is
    /// not saved belongs here; the version stays, as the hash differs.
    pub(crate) fn hash_setup(setup: &CrowdSetup<V>, scenery: &CrowdScenery<V>, cells: &CellGrid<V>) -> u128 {
        let CrowdScenery { fields, obstacles, interests, radius, speed, stopping, .. } = scenery;
        let sizes = [*radius, *speed, *stopping, cells.side, V::DIMENSIONS as f32];
        let capacity = setup.config.capacity.max(setup.agents.len());
        let streets = setup.streets.as_ref().map(Streets::hashed);
        let (interests, key) = ((interests, &setup.senses), setup.config.state_key());
        let all = (fields, obstacles, interests, key, sizes, cells.num_cells, capacity, streets);
        let config = bincode::config::standard().with_fixed_int_encoding();
        // Writing to memory what can be written cannot fail.
        Hash128::hash_bytes(&bincode::serde::encode_to_vec(all, config).unwrap_or_default())
    }

    /// Appends the whole state (about 170 bytes an agent on the ground and 200 in the air, of which a route of its own
    /// with one subgoal takes 24 or 28; 20 or 28 bytes a square of the grid).
    pub fn save(&self, out: &mut Vec<u8>) {
        let saved = SavedCrowd {
            now: self.now,
            counts: self.counts,
            free: self.free.clone(),
            states: self.states.clone(),
            routes: self.scenery.paths.iter().map(|s| s.route.clone()).collect(),
            staying: (0u32..).zip(&self.scenery.paths).filter(|(_, p)| p.stays).map(|(n, _)| n).collect(),
            own_routes: self.own_routes.clone(),
            plans: self.cells.plans(),
            grid: self.grid.clone(),
            refreshes: self.refreshes,
            turns: self.turns.saved().to_vec(),
            doors: self.scenery.doors.clone(),
            sensing: self.sensors.saved(),
            relationships: self.relationships.saved(),
            scheme: self.other_scheme(),
        };
        self.snapshot_kind().write(&saved, out);
    }

    /// Restores a state of a crowd that was made with the same setup. It continues from there as it did then, bit by
    /// bit.
    ///
    /// # Errors
    /// [`Error::Snapshot`]; nothing has changed then.
    pub fn load(&mut self, bytes: &[u8]) -> Result<()> {
        let saved: SavedCrowd<V> = self.snapshot_kind().read_all(bytes)?;
        let before = self.scenery.doors.clone();
        ensure(saved.doors.len() == before.len(), || refused("it has other obstacles"))?;
        // Agents are checked against what stood then.
        self.scenery.set_doors(&saved.doors, &self.cells).map_err(refused)?;
        let loaded = self.load_checked(saved);
        if loaded.is_err() {
            self.scenery.set_doors(&before, &self.cells)?;
        }
        loaded
    }

    fn load_checked(&mut self, saved: SavedCrowd<V>) -> Result<()> {
        self.check_saved(&saved).map_err(refused)?;
        let mut goals = GoalTable::default();
        let mut paths = Vec::with_capacity(saved.routes.len());
        for (number, route) in saved.routes.iter().enumerate() {
            let stays = saved.staying.binary_search(&(number as u32)).is_ok();
            match (stays, route.subgoals.as_slice()) {
                (true, &[at]) if at.is_finite() => paths.push(RoutePath::stay_path(at)),
                (true, _) => return Err(refused(format!("route {number} is of nobody who stays"))),
                (false, _) => {
                    paths.push(self.scenery.prepare_path_with(number, route, &mut goals).map_err(refused)?);
                }
            }
        }
        let mut of_plans = saved.plans.iter().map(|p| &saved.states[p.index as usize]);
        if !of_plans.all(|s| (s.cursor.leg as usize) < paths[s.route as usize].num_legs()) {
            return Err(refused("an agent is on a leg that its route has not"));
        }
        (self.scenery.paths, self.scenery.goals) = (paths, goals);
        self.take_over(saved);
        Ok(())
    }

    /// Replaces the state by a checked one.
    fn take_over(&mut self, saved: SavedCrowd<V>) {
        (self.now, self.counts, self.states) = (saved.now, saved.counts, saved.states);
        (self.grid, self.refreshes, self.own_routes) = (saved.grid, saved.refreshes, saved.own_routes);
        self.turns.restore(&saved.turns);
        for (agent, &own) in (0u32..).zip(&self.own_routes).filter(|(_, own)| **own != NONE) {
            self.scenery.paths[own as usize].owner = agent;
        }
        self.fill_spare();
        self.grid.mark_occupied();
        self.free.clear();
        self.free.extend(&saved.free);
        self.cells.clear();
        self.queue.clear(self.now);
        for plan in &saved.plans {
            self.cells.insert(self.states[plan.index as usize].cell, plan);
            self.watchdog.forget(plan.index);
            self.queue.set(plan.index, self.due_time(plan));
        }
        self.sensors.states.fill(SensingState::default());
        saved.sensing.iter().for_each(|(m, own)| self.sensors.states[*m as usize] = *own);
        self.relink_senses();
        self.relationships.restore_saved(&saved.relationships);
        match saved.scheme {
            Some(OtherScheme::Occupancy(mut occupancy)) => {
                occupancy.relink(&self.cells);
                self.occupancy = Some(occupancy);
            }
            #[cfg(feature = "fixed-steps")]
            Some(OtherScheme::Fixed(steps)) => self.fixed.iter_mut().for_each(|f| f.steps = steps),
            None => (),
        }
        self.wait_for_all();
    }

    /// Reason why a state cannot be one of this crowd.
    fn check_saved(&self, saved: &SavedCrowd<V>) -> Result<(), String> {
        if [saved.states.len(), saved.own_routes.len()] != [self.states.len(); 2] {
            return Err(format!("it holds {} agents, this crowd {}", saved.states.len(), self.states.len()));
        }
        let may_be_grid = saved.grid.has_same_size(&self.grid) && saved.grid.is_possible(self.scenery.fastest);
        if !may_be_grid || !(0.0..=1e9).contains(&saved.now) || !self.may_have_seen(saved) {
            return Err("its time or its grid cannot be".to_owned());
        }
        ensure(self.turns.is_possible(&saved.turns, saved.now), || "its passages are others".to_owned())?;
        let capacity = saved.states.len();
        let mut is_new = vec![true; capacity];
        for plan in &saved.plans {
            let number = plan.index as usize;
            let is_good = saved.states.get(number).is_some_and(|m| {
                self.is_possible(m, saved.routes.len())
                    && (!m.is_woken || !m.goes_on && self.woken_at(plan, saved.now).is_some())
            });
            if !is_good || !self.may_follow(plan, saved.now) || !std::mem::take(&mut is_new[number]) {
                return Err(format!("agent {number} has a plan, route, field or cell that cannot be"));
            }
        }
        self.check_routes(saved)?;
        if !self.sensors.is_possible(&saved.sensing, saved.now, |m| saved.states[m as usize].cell != NONE) {
            return Err("somebody senses what cannot be".to_owned());
        }
        let is_there = |m: u32| saved.states.get(m as usize).is_some_and(|s| s.cell != NONE);
        let may_care = self.relationships.is_possible(&saved.relationships, is_there);
        ensure(may_care, || "somebody cares for what cannot be".to_owned())?;
        let num_there = saved.states.iter().filter(|m| m.cell != NONE).count();
        for &number in &saved.free {
            let was_new = is_new.get_mut(number as usize).is_some_and(std::mem::take);
            ensure(was_new, || format!("number {number} is free and taken"))?;
        }
        if num_there != saved.plans.len() || num_there + saved.free.len() != capacity {
            return Err(format!("{num_there} agents have {} plans", saved.plans.len()));
        }
        self.check_saved_scheme(saved)?;
        self.check_safety(saved)
    }

    /// Checks routes: own routes are used by one agent each, and all subgoals can be searched for.
    fn check_routes(&self, saved: &SavedCrowd<V>) -> Result<(), String> {
        let mut owners = vec![NONE; saved.routes.len()];
        for (agent, &route) in (0u32..).zip(&saved.own_routes).filter(|(_, r)| **r != NONE) {
            // Two that shared one would send each other elsewhere.
            let is_taken = owners.get_mut(route as usize).is_none_or(|own| std::mem::replace(own, agent) != NONE);
            if is_taken || (route as usize) < self.scenery.num_routes {
                return Err(format!("route {route} is of two agents, or of none, or of the setup"));
            }
        }
        let route_of = |p: &MotionPlan<V>| saved.states[p.index as usize].route;
        let is_astray = |p: &&MotionPlan<V>| ![NONE, p.index].contains(&owners[route_of(p) as usize]);
        if let Some(plan) = saved.plans.iter().find(is_astray) {
            return Err(format!("agent {} is on route {}, which is another one's own", plan.index, route_of(plan)));
        }
        let (num, known) = (saved.routes.iter().map(|r| r.subgoals.len()), self.scenery.paths.iter());
        let (num, known): (usize, usize) = (num.sum(), known.map(|p| p.route.subgoals.len()).sum());
        let most = known + SUBGOALS_EACH * (saved.states.len() + MORE_ROUTES);
        if self.scenery.streets.is_some() && num > most {
            return Err(format!("its routes have {num} subgoals, expected {most} at most where agents look for ways"));
        }
        Ok(())
    }

    /// Checks the safety rule, as for a newcomer, for all saved agents: none may overlap another one or an obstacle.
    fn check_safety(&self, saved: &SavedCrowd<V>) -> Result<(), String> {
        #[cfg(feature = "fixed-steps")]
        if self.fixed.is_some() {
            return Ok(());
        }
        let half = V::from_coordinates([self.cells.side; 3]);
        let mut of_cell: HashMap<u32, Vec<&MotionPlan<V>>> = HashMap::new();
        for plan in &saved.plans {
            let (at, cell) = (self.cells.coordinates(plan.position), saved.states[plan.index as usize].cell);
            let centre = self.cells.centre(at);
            if cell != self.cells.number(at)
                || !saved_plans::is_motion(plan)
                || !saved_plans::is_within(plan, centre - half, centre + half)
            {
                return Err(format!("agent {} is in another cell than it says, or leaves it", plan.index));
            }
            let is_clear = |&s: &u32| saved_plans::is_clear_of(plan, &self.scenery.solids[s as usize], saved.now);
            if let Some(&s) = self.scenery.solids_near(cell).iter().find(|s| !is_clear(s)) {
                return Err(format!("agent {} is in obstacle {}", plan.index, self.scenery.owners[s as usize]));
            }
            of_cell.entry(cell).or_default().push(plan);
        }
        for plan in &saved.plans {
            let mut in_the_way = None;
            self.cells.for_each_cell_around(self.cells.coordinates(plan.position), |cell| {
                let others = of_cell.get(&cell).into_iter().flatten().filter(|o| o.index < plan.index);
                in_the_way = others.copied().find(|o| !saved_plans::are_apart(plan, o, saved.now)).or(in_the_way);
            });
            if let Some(other) = in_the_way {
                return Err(format!("agents {} and {} overlap", other.index, plan.index));
            }
        }
        Ok(())
    }

    /// What the engine's scheme remembers; none for [`crate::Scheme::Registration`].
    fn other_scheme(&self) -> Option<OtherScheme> {
        #[cfg(feature = "fixed-steps")]
        if let Some(fixed) = &self.fixed {
            return Some(OtherScheme::Fixed(fixed.steps));
        }
        self.occupancy.clone().map(OtherScheme::Occupancy)
    }

    /// A state is of the scheme that runs here.
    fn check_saved_scheme(&self, saved: &SavedCrowd<V>) -> Result<(), String> {
        let mut of_agent = vec![None; saved.states.len()];
        saved.plans.iter().for_each(|p| of_agent[p.index as usize] = Some(p));
        let plan = |m: u32| of_agent.get(m as usize).copied().flatten();
        // The other schemes wake no agents.
        let is_woken = saved.states.iter().any(|m| m.is_woken);
        let fits = match (&saved.scheme, &self.occupancy) {
            (None, None) => self.is_of_registration(),
            (Some(OtherScheme::Occupancy(kept)), Some(own)) => {
                !is_woken && kept.fits(own, self.cells.side, saved.now, plan)
            }
            #[cfg(feature = "fixed-steps")]
            (Some(OtherScheme::Fixed(kept)), None) => {
                !is_woken && self.fixed.as_ref().is_some_and(|f| kept.fits(&f.steps, saved.now))
            }
            _ => false,
        };
        if fits { Ok(()) } else { Err("it is of another scheme, or damaged".to_owned()) }
    }

    /// Checks that the grid fits the time, and that counts leave room for more.
    fn may_have_seen(&self, saved: &SavedCrowd<V>) -> bool {
        saved.refreshes as f64 <= saved.now / self.scenery.steering.refresh_s + 1.0 && saved.counts.is_below(1 << 62)
    }

    /// Longest plan of an agent that brakes with so much: by then its bound has left the region around its cell, twice as
    /// wide as that, or it was blocked, or a fixed step is over; and some more (s).
    fn longest_plan(&self, limit: f32) -> f64 {
        let leaves = (2.0 * self.cells.side / limit).sqrt();
        f64::from(2.0 * (leaves + 10.0 * self.scenery.interval) + 1.0)
    }

    /// A plan that an agent of this crowd may follow now.
    fn may_follow(&self, plan: &MotionPlan<V>, now: f64) -> bool {
        let within = |v: V, most: f32| v.is_finite() && v.length() <= most;
        let fastest = self.scenery.fastest;
        within(plan.position, FARTHEST_M)
            && within(plan.velocity, ROUNDING * fastest)
            && plan.limit > 0.0
            && plan.limit < 1e6
            && within(plan.acceleration, ROUNDING * plan.limit)
            && plan.radius > 0.0
            && plan.radius <= self.scenery.radius
            && plan.moving >= 0.0
            && fastest * fastest <= 2.0 * plan.limit * self.scenery.stopping * 1.001
            && (0.0..=now).contains(&plan.start)
            && (now..=plan.start + self.longest_plan(plan.limit)).contains(&plan.end)
    }

    /// Checks that an agent's state fits this crowd.
    fn is_possible(&self, state: &AgentState<V>, num_routes: usize) -> bool {
        let cause = match state.cause {
            Cause::Agent(other) => (other as usize) < self.states.len(),
            Cause::Region => true,
            Cause::Obstacle(obstacle) => (obstacle as usize) < self.scenery.obstacles.len(),
        };
        let speed = (0.0..=self.scenery.speed).contains(&state.speed);
        let is_there = (state.cell as usize) < self.cells.num_cells;
        cause
            && speed
            && is_there
            && state.filter.velocity.is_finite()
            && state.filter.variance.is_finite()
            && state.intent.is_finite()
            && state.cursor.aim.is_finite()
            && state.cursor.rest.is_finite()
            && state.cursor.look_at.is_finite()
            && state.intent.length() <= UNIT
            && (state.route as usize) < num_routes
            && (state.field as usize) < self.scenery.fields.len()
    }

    /// A hash of the state (64 bits): equal for equal motion of all.
    pub fn hash(&self) -> u64 {
        let mut hash = StateHash::new(self.now.to_bits());
        for (index, state) in (0u32..).zip(&self.states).filter(|(_, m)| m.cell != NONE) {
            let plan = self.cells.plan(index);
            hash.add_word(u64::from(index) << 32 | u64::from(state.generation));
            hash.add_word(plan.start.to_bits());
            hash.add_word(plan.end.to_bits());
            for v in [plan.position, plan.velocity, plan.acceleration] {
                v.coordinates().iter().for_each(|c| hash.add_word(u64::from(c.to_bits())));
            }
            hash.add_word(u64::from(state.route) << 32 | u64::from(state.speed.to_bits()));
            if state.is_woken || state.goes_on {
                hash.add_word(self.due_time(&plan).to_bits());
            }
        }
        self.relationships.hash(|word| hash.add_word(word));
        let open = self.scenery.doors.iter().enumerate().filter(|(_, d)| **d == Door::Open);
        open.for_each(|(n, _)| hash.add_word(n as u64));
        hash.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::drive::{Drive, crossing};
    use crate::{AgentOrder, AtEnd, Obstacle};
    use glam::{Vec2, Vec3};

    /// Restores a snapshot of a crowd that was changed by hand.
    fn restored(change: impl FnOnce(&mut Engine<Vec2>)) -> Result<()> {
        let mut crowd = Engine::new(crossing::<Vec2>(20, 8.0)).unwrap();
        crowd.advance(1.0, &mut |_| {}).unwrap();
        change(&mut crowd);
        Engine::new(crossing::<Vec2>(20, 8.0)).unwrap().load(&crowd.bytes())
    }

    fn with_plan(change: impl FnOnce(&mut MotionPlan<Vec2>)) -> Result<()> {
        restored(|crowd| {
            let (cell, mut plan) = (crowd.states[3].cell, crowd.cells.plan(3));
            // So short that it stays where it may be.
            (plan.start, plan.end, plan.moving) = (crowd.now, crowd.now + 0.01, f32::INFINITY);
            change(&mut plan);
            crowd.cells.set(cell, cell, &plan);
        })
    }

    #[test]
    fn too_fast_agents_are_refused() {
        let fastest = Engine::new(crossing::<Vec2>(20, 8.0)).unwrap().scenery.fastest;
        let is_good = |speed: f32| with_plan(|p| p.velocity = Vec2::from_angle(0.7) * speed).is_ok();
        assert!(is_good(fastest) && is_good(fastest * (1.0 + 5e-6)), "rounding is let be");
        assert!(!is_good(fastest * 1.0001) && !is_good(fastest * 1.005) && !is_good(f32::NAN));
        let is_good = |share: f32| with_plan(|p| p.acceleration = Vec2::from_angle(0.7) * (share * p.limit)).is_ok();
        assert!(is_good(1.0) && !is_good(1.0001));
    }

    #[test]
    fn intent_that_is_no_unit_vector_is_refused() {
        let is_good = |intent| restored(|crowd| crowd.states[3].intent = intent).is_ok();
        assert!(is_good(Vec2::ZERO) && is_good(Vec2::from_angle(2.0)));
        assert!(!is_good(Vec2::X * 1.01) && !is_good(Vec2::NAN) && !is_good(Vec2::Y * f32::INFINITY));
    }

    #[test]
    fn impossible_density_grid_is_refused() {
        let is_good = |velocity, intent| restored(|crowd| crowd.grid.add(Vec2::ZERO, velocity, intent)).is_ok();
        assert!(is_good(Vec2::X, Vec2::X) && is_good(Vec2::ZERO, Vec2::ZERO));
        assert!(!is_good(Vec2::X * 90.0, Vec2::X) && !is_good(Vec2::X, Vec2::X * 20.0));
        assert!(!is_good(Vec2::NAN, Vec2::X) && !is_good(Vec2::X, Vec2::NEG_Y * f32::INFINITY));
    }

    #[test]
    fn routes_of_others_are_refused() {
        let order = |crowd: &mut Engine<Vec2>, agent: usize, goal: Vec2| {
            let id = crowd.id(agent as u32);
            crowd.order(id, &AgentOrder::along_subgoals(vec![goal, goal + Vec2::X])).unwrap();
        };
        assert!(restored(|crowd| order(crowd, 3, Vec2::Y)).is_ok());
        let why = |change: &dyn Fn(&mut Engine<Vec2>)| restored(change).unwrap_err().to_string();
        let on_it = why(&|crowd| {
            order(crowd, 3, Vec2::Y);
            crowd.states[4].route = crowd.own_routes[3];
        });
        assert!(on_it.contains("agent 4 is on route"), "{on_it}");
        let of_setup = why(&|crowd| crowd.own_routes[3] = 0);
        assert!(of_setup.contains("route 0 is of two agents"), "{of_setup}");
        let mut crowd = Engine::new(crossing::<Vec2>(20, 8.0)).unwrap();
        order(&mut crowd, 3, Vec2::Y);
        let (id, own) = (crowd.id(4), crowd.own_routes[3] as usize);
        for _ in 0..2 {
            let e = crowd.order(id, &AgentOrder::on_route(own)).unwrap_err().to_string();
            assert!(e.contains("another agent's own"), "{e}");
            crowd.load(&crowd.bytes()).unwrap();
        }
    }

    #[test]
    fn more_subgoals_than_can_be_looked_for_are_refused() {
        let mut setup = crossing::<Vec2>(4, 8.0);
        let ball = Obstacle::Ball { centre: Vec3::X * 90.0, radius: 1.0 };
        setup.streets = Some(Streets::new(&[ball], 0.4).unwrap());
        let with = |num: usize| {
            let mut crowd = Engine::new(setup.clone()).unwrap();
            let subgoals = (0..num).map(|k| Vec2::new((k % 2) as f32, 3.0)).collect();
            crowd.add_route(Route { subgoals, arrival_radius: 0.5, at_end: AtEnd::Stay }).unwrap();
            Engine::new(setup.clone()).unwrap().load(&crowd.bytes())
        };
        with(2000).unwrap();
        let e = with(5000).unwrap_err().to_string();
        assert!(e.contains("subgoals, expected"), "{e}");
    }

    #[test]
    fn plans_longer_than_any_are_refused() {
        let until = |more: f64| {
            with_plan(|p| {
                (p.velocity, p.acceleration) = (Vec2::ZERO, Vec2::ZERO);
                p.end = p.start + more;
            })
        };
        assert!(until(2.0).is_ok() && until(60.0).is_err() && until(1e9).is_err());
    }

    #[test]
    fn snapshots_of_other_streets_are_refused() {
        let around = |centre: Vec3, nearest: f32, heights| {
            let mut setup = crossing::<Vec2>(4, 8.0);
            let ball = Obstacle::Ball { centre, radius: 1.0 };
            setup.streets = Some(Streets::with_limits(&[ball], heights, 0.4, nearest).unwrap());
            Engine::new(setup).unwrap()
        };
        let kept = around(Vec3::X * 90.0, 0.2, None).bytes();
        let taken = |centre, nearest, heights| around(centre, nearest, heights).load(&kept).is_ok();
        assert!(taken(Vec3::X * 90.0, 0.2, None));
        assert!(!taken(Vec3::X * 91.0, 0.2, None) && !taken(Vec3::X * 90.0, 0.1, None));
        assert!(!taken(Vec3::X * 90.0, 0.2, Some([0.0, 3.0])));
    }

    /// Bytes of each agent, and of each square of the grid.
    fn size<V: Space>() -> [usize; 2] {
        let config = bincode::config::standard().with_fixed_int_encoding();
        let len = |num| {
            let crowd = Engine::new(crossing::<V>(num, 1.0)).unwrap();
            let grid = bincode::serde::encode_to_vec(&crowd.grid, config).unwrap().len();
            [crowd.bytes().len() - grid, grid, crowd.grid.num_squares()]
        };
        let (few, many) = (len(100), len(300));
        [(many[0] - few[0]) / 200, (many[1] - few[1]) / (many[2] - few[2])]
    }

    #[test]
    fn snapshot_size_is_as_documented() {
        assert_eq!(size::<Vec2>(), [171, 20]);
        assert_eq!(size::<Vec3>(), [199, 28]);
    }
}
