//! Saves the state of inhabitants and goes back to it.

use super::chains::{APART_M, ChainSchedule, MAX_CHAIN};
use super::decide::{CALM_AFTER, MAX_IMPATIENCE, MAX_TRIES};
use super::{InhabitantMemory, Inhabitants, paths::SavedPaths, reservations::UnitReservations};
use crate::{WorldGraph, WorldNode, WorldStep};
use throng_base::{Error, Hash128, Result, SnapshotKind, maths};
use throng_core::Roster;
use throng_core::characters::{CharactersSnapshot, PolicyOrder};

/// Time, number of orders, ids, bodies and their layers, states, chains, paths. Reservations follow from these.
type SavedInhabitants = (
    (f64, u32),
    Roster,
    (CharactersSnapshot, Vec<PolicyOrder>),
    Vec<InhabitantMemory>,
    Vec<Vec<WorldStep>>,
    SavedPaths,
);

/// A character's motion ends this far from its node at most: more is a sign of damage (m).
const ASTRAY_M: f32 = 1.0;
/// Least distance of the hips of two that follow each other in a snapshot (m): below [`APART_M`], as it is compared at other times than
/// when they began.
const APART_RESTORED_M: f32 = 0.8 * APART_M;
/// Times are below this (s).
const LATEST_S: f64 = 1e12;

impl Inhabitants {
    /// Appends all that the next steps depend on.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        let chains = (0..self.states.len()).map(|c| self.chains.steps_of(c)).collect::<Vec<_>>();
        let paths = self.paths.saved_paths(self.states.len());
        let bodies = (self.characters.snapshot(), &self.orders);
        let state = ((self.time_s, self.num_orders), &self.roster, bodies, &self.states, chains, paths);
        self.snapshot_kind().write(&state, out);
    }

    /// Restores what was written, except for events and roots.
    ///
    /// # Errors
    /// [`Error::Snapshot`]; nothing has changed then.
    pub(super) fn read(&mut self, bytes: &[u8]) -> Result<()> {
        let kind = self.snapshot_kind();
        let saved: SavedInhabitants = kind.read_all(bytes)?;
        let refuse = |what| Error::Snapshot { what: kind.what, why: format!("{what}; it is damaged") };
        self.restore(&saved).map_err(refuse)
    }

    fn snapshot_kind(&self) -> SnapshotKind {
        let mut setup = Hash128::default();
        setup.add_bytes(&self.world.hash().to_le_bytes());
        setup.add_bytes(format!("{:?} {}", self.config, self.capacity()).as_bytes());
        SnapshotKind { what: "inhabitants", tag: *b"INHB", version: 13, setup: setup.finish() }
    }

    /// Restores a state of unknown origin, or changes nothing and says what does not fit.
    fn restore(&mut self, saved: &SavedInhabitants) -> Result<(), &'static str> {
        let ((time_s, num_orders), roster, (characters, orders), states, chains, paths) = saved;
        let (world, n) = (self.world.clone(), roster.ids().len());
        let graph = world.graph();
        let (mut bodies, mut held) = (self.characters.clone(), UnitReservations::new(graph));
        let mut new_roster = self.roster.clone();
        let (mut new_chains, mut new_paths) = (self.chains.clone(), self.paths.clone());
        let check = |good: bool, what| if good { Ok(()) } else { Err(what) };
        check((0.0..LATEST_S).contains(time_s), "its time is out of range")?;
        check(new_roster.restore(roster), "its ids do not fit together")?;
        check([states.len(), chains.len(), orders.len()] == [n; 3], "its rows do not fit together")?;
        let are_layers = |order: &PolicyOrder| {
            order.check(None, world.motion_set()).is_ok() && *order == PolicyOrder::IDLE.with_layers(order.layers())
        };
        check(orders.iter().all(are_layers), "a body does what nobody can")?;
        bodies.restore_any(world.motion_set(), characters).map_err(|_| "its motion is not of the bundle")?;
        let is_scheduled = |c| bodies.segment(c).0 == u32::MAX;
        check(bodies.num_characters() == n && (0..n).all(is_scheduled), "its rows do not fit together")?;
        check(states.iter().all(|s| is_sound(graph, s)), "a character is where the world has no place")?;
        let meets = |s: &InhabitantMemory| s.meeting.is_none_or(|m| m.is_sound(graph, s.at, &self.pair_offers));
        check(states.iter().all(meets), "two meet where the world has no place for two")?;
        for (c, (state, chain)) in states.iter().zip(chains).enumerate() {
            let (end, place) = (bodies.scheduled_end(world.motion_set(), c), graph.place(state.at));
            check(maths::hypot(end.x - place.x, end.z - place.z) < ASTRAY_M, "a character's motion leads elsewhere")?;
            let leads = chain.len() <= MAX_CHAIN && are_steps(graph, state.at, chain);
            check(leads, "a character goes where no step leads")?;
            let has_target = paths.0.get(c).is_some_and(|p| p.target.is_some());
            check(state.goal.is_roaming() != has_target, "a goal has no target")?;
            new_chains.set(c, chain);
        }
        let schedule = |c: usize| {
            let (root, frames_left, state) = (bodies.root(c), bodies.frames_left(c), &states[c]);
            ChainSchedule { graph, root, frames_left, through: state.through, at: state.at, chain: &chains[c] }
        };
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| states[a].reserved_s.total_cmp(&states[b].reserved_s));
        for c in order {
            let (mut are_free, own) = (true, schedule(c));
            states[c].visit_needed_instances(graph, &chains[c], |instance| {
                let follows = |other, unit| own.follows(&schedule(other as usize), unit, APART_RESTORED_M);
                are_free &= held.other_holder(graph, instance, c as u32, follows).is_none();
                held.take_units(graph.resources(instance), c as u32);
            });
            check(are_free, "two hold the same unit")?;
        }
        check(new_paths.restore(graph, paths, n), "its paths are not of the world")?;
        held.ground_mut().copy_from_slice(self.reservations.ground_mut());
        (self.time_s, self.num_orders) = (*time_s, *num_orders);
        (self.roster, self.characters, self.reservations) = (new_roster, bodies, held);
        (self.chains, self.paths) = (new_chains, new_paths);
        self.states.clone_from(states);
        self.orders.clone_from(orders);
        self.num_bound.fill(0);
        (0..n).for_each(|c| self.count_bound(graph, c, u32::wrapping_add));
        Ok(())
    }
}

fn is_sound(graph: &WorldGraph, state: &InhabitantMemory) -> bool {
    is_node(graph, state.at)
        && state.through.iter().all(|&i| (i as usize) < graph.num_instances())
        && state.impatience <= MAX_IMPATIENCE
        && state.progress <= CALM_AFTER
        && state.tries.iter().all(|t| *t <= 2 * MAX_TRIES)
        && is_time(state.until_s)
        && is_time(state.reserved_s)
        && state.leaves_s.is_none_or(is_time)
        && state.purpose.is_sound()
        && state.refused_s.is_none_or(is_time)
        && is_time(state.went_on_s)
}

/// True for a time that may be noted: soon after the latest one at most.
pub(super) fn is_time(time_s: f64) -> bool {
    time_s.abs() < 2.0 * LATEST_S
}

/// True for a node that the world has.
pub(super) fn is_node(graph: &WorldGraph, node: WorldNode) -> bool {
    (node.instance as usize) < graph.num_instances()
        && node.cell < graph.num_cells(node.instance)
        && graph.is_node(node)
}

/// True where steps can be taken one after the other from a node (the node exists).
pub(super) fn are_steps(graph: &WorldGraph, from: WorldNode, steps: &[WorldStep]) -> bool {
    if !is_node(graph, from) {
        return false;
    }
    let mut at = from;
    steps.iter().all(|step| {
        let mut can_be_taken = false;
        graph.for_each_step(at, |s| can_be_taken |= s == *step);
        at = step.to;
        can_be_taken && is_node(graph, at)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::World;
    use crate::inhabitants::InhabitantsConfig;
    use crate::made_up_floor::{tables, world};
    use glam::Vec3;
    use throng_core::CharacterGroup;

    #[test]
    fn times_beyond_all_are_refused() {
        let tables = tables();
        let world = World::from_data(&world(&tables, &["##"]), &tables).unwrap();
        let mut people = Inhabitants::new(&world, 1, InhabitantsConfig::default()).unwrap();
        people.spawn(world.nearest_place(Vec3::Y, 1.0).unwrap().node).unwrap();
        let mut refused = |since: f64| {
            people.states[0].refused_s = Some(since);
            let mut kept = Vec::new();
            people.save(&mut kept);
            people.load(&kept).is_err()
        };
        assert!(!refused(0.0) && refused(-1e300) && refused(1e13) && refused(f64::NAN));
    }
}
