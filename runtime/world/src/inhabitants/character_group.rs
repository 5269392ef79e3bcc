//! Inhabitants as a character group: they enter, leave, take orders, are saved and loaded.

use super::{InhabitantActivity, InhabitantGoal, InhabitantMemory, Inhabitants, schedule};
use super::{reservations::follow_nobody, targets::check_place};
use crate::{WorldGraph, WorldNode, plan::PlanTarget};
use glam::{Vec2, Vec3};
use throng_base::{Error, Executor, Id, Result, error::check_value, limits::STEP_S};
use throng_core::characters::{PolicyOrder, ScheduledClip};
use throng_core::planar::wrap_angle;
use throng_core::{AdoptReport, Bundle, CharacterGroup, NUM_JOINTS, OrderStatus, Planar, PosedBodies};

/// Largest distance of a character that is moved to the place where it stays (m).
pub const PLACED_WITHIN_M: f32 = 1.5;

/// An event of an inhabitant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InhabitantEvent {
    /// The character has reached its goal.
    Fulfilled,
    /// No path leads to the goal.
    NoPath,
    /// The character begins an action with a partner.
    Began {
        /// Partner.
        with: Id,
    },
    /// The character or its partner got another goal, or left, during their common action.
    BrokenOff,
    /// The character or its partner got another goal, or left, before the action began, or they could not meet.
    GaveUp,
}

impl Inhabitants {
    /// The motion of a character that stands at a node (a rest node).
    fn standing_clip(&self, graph: &WorldGraph, node: WorldNode) -> Option<ScheduledClip> {
        let rest = graph.step_to_rest(node)?;
        schedule::scheduled_clip(&self.world, &rest, None)
    }

    /// Checks that all units of an instance are free.
    fn check_free(&self, graph: &WorldGraph, who: Id, c: u32, instance: u32) -> Result<()> {
        let Some(other) = self.reservations.other_holder(graph, instance, c, follow_nobody) else { return Ok(()) };
        // External obstacles have no id here.
        let by = self.roster.ids().get(other as usize).map(Id::to_string);
        Err(Error::Occupied { who, by: by.unwrap_or_else(|| "somebody who does not live in this world".into()) })
    }

    /// Free place to stay nearest to a point that a character is moved to; of several at one place, the one with the
    /// nearest heading.
    fn place_for(&self, graph: &WorldGraph, id: Id, c: usize, root: Planar) -> Result<WorldNode> {
        let point = Vec3::new(root.x, graph.place(self.states[c].at).y, root.z);
        let away = |node: WorldNode| graph.place(node).translation().distance(point);
        let is_free = |i| self.reservations.are_free(graph, i, c as u32);
        let Some(node) = graph.nearest_rest_of(point, is_free).filter(|n| away(*n) <= PLACED_WITHIN_M) else {
            let nearest = graph.nearest_rest(point);
            let far = nearest.map_or(f32::INFINITY, away);
            let expected = "at most 1.5; name a point nearer to where one can stay";
            check_value("distance to the nearest place to stay (m)", Some(id), far, far <= PLACED_WITHIN_M, expected)?;
            self.check_free(graph, id, c as u32, nearest.map_or(0, |n| n.instance))?;
            return Err(Error::Occupied { who: id, by: "somebody".into() });
        };
        let turned = |n: &WorldNode| wrap_angle(graph.place(*n).heading - root.heading).abs();
        let beside = graph.rest_cells(node.instance).filter(|n| away(*n) <= away(node) + 0.1);
        Ok(beside.min_by(|a, b| turned(a).total_cmp(&turned(b))).unwrap_or(node))
    }

    fn update_roots(&mut self) {
        self.roots.clear();
        self.roots.extend((0..self.states.len()).map(|c| self.characters.root(c)));
    }

    /// Remaining distance: along the path where all of it is known, along a straight line otherwise (m).
    fn distance_left_m(&self, c: usize, target: PlanTarget) -> f32 {
        let graph = self.world.graph();
        let known =
            self.paths.last_plan(c).is_some_and(|p| p.num_stored == p.num_steps) && !self.paths.steps_of(c).is_empty();
        if known {
            return self.chains.steps_of(c).iter().chain(self.paths.steps_of(c)).map(|s| graph.step_length(s)).sum();
        }
        let to = self.place_of(target);
        Vec2::new(self.roots[c].x, self.roots[c].z).distance(Vec2::new(to.x, to.z))
    }
}

impl CharacterGroup for Inhabitants {
    /// A node where one can stay: of [`crate::World::nearest_place`] or [`super::scatter_rest_nodes`].
    type Start = WorldNode;
    type Order = InhabitantGoal;
    type Event = InhabitantEvent;

    /// Spawns a character at rest, which roams until it gets a goal. Its pose is there after the next step.
    ///
    /// # Errors
    /// [`Error::Full`], [`Error::Occupied`] where another character holds a unit that is needed there, [`Error::Index`]
    /// or [`Error::Value`] for a node that does not exist or where no character can stay.
    fn spawn(&mut self, start: WorldNode) -> Result<Id> {
        let (world, next, c) = (self.world.clone(), self.roster.next_id()?, self.states.len());
        let graph = world.graph();
        check_place(graph, Some(next), start)?;
        self.check_free(graph, next, c as u32, start.instance)?;
        let clip = self.standing_clip(graph, start).unwrap_or_default();
        self.characters.enter_scheduled(world.motion_set(), &clip)?;
        let id = self.roster.add_id()?;
        self.num_orders = self.num_orders.wrapping_add(1);
        self.states.push(InhabitantMemory::resting_at(start));
        self.roots.push(clip.root);
        self.orders.push(PolicyOrder::IDLE);
        self.chains.set(c, &[]);
        self.set_target(graph, c, None);
        self.reservations.take_units(graph.resources(start.instance), c as u32);
        Ok(id)
    }

    /// Removes a character and frees its units at once. The last one takes its row in [`CharacterGroup::bodies`].
    fn despawn(&mut self, id: Id) -> Result<()> {
        let c = self.roster.row(id)?;
        self.part_pair(c);
        self.set_target(self.world.clone().graph(), c, None);
        let (at, last) = self.roster.remove_id(id)?;
        self.num_orders = self.num_orders.wrapping_add(1);
        self.reservations.release_all(at as u32);
        if at < last {
            self.reservations.hand_over(last as u32, at as u32);
            self.chains.copy(last, at);
        }
        self.paths.remove_character(at, last);
        self.characters.remove_character(at);
        self.states.swap_remove(at);
        self.roots.swap_remove(at);
        self.orders.swap_remove(at);
        Ok(())
    }

    /// Moves a character to the nearest free place to stay on its floor, within [`PLACED_WITHIN_M`], from where it goes
    /// on with its goal. A common action with a partner is over.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Occupied`], or [`Error::Value`] for a root that is not finite or far from every place.
    fn place(&mut self, id: Id, root: Planar) -> Result<()> {
        let c = self.roster.row(id)?;
        for (what, got) in [("x", root.x), ("z", root.z), ("heading", root.heading)] {
            check_value(what, Some(id), got, got.abs() < 1e6, "a finite number below 1e6")?;
        }
        let world = self.world.clone();
        let graph = world.graph();
        let node = self.place_for(graph, id, c, root)?;
        let was_meeting = self.states[c].meeting.is_some();
        self.part_pair(c);
        self.num_orders = self.num_orders.wrapping_add(1);
        let clip = self.standing_clip(graph, node).unwrap_or_default();
        self.characters.start_scheduled(world.motion_set(), c, &clip)?;
        self.reservations.release_all(c as u32);
        self.reservations.take_units(graph.resources(node.instance), c as u32);
        let state = &mut self.states[c];
        *state = InhabitantMemory { at: node, through: [node.instance; 2], plays_pair: false, ..*state }
            .with_goal(state.goal);
        self.roots[c] = clip.root;
        self.chains.set(c, &[]);
        let target = self.paths.target(c);
        self.set_target(graph, c, target);
        if was_meeting {
            self.finish_goal(c);
        } else if target.is_some() {
            self.paths.request_path(c);
        }
        Ok(())
    }

    /// Sets the goal of a character, which it pursues from the end of its reserved steps on.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::NoPath`] where it is plain that no path leads there, [`Error::Index`] or
    /// [`Error::Value`] for a place, instance or tag that does not exist or where no character can stay.
    fn order(&mut self, id: Id, goal: InhabitantGoal) -> Result<()> {
        let c = self.roster.row(id)?;
        let target = self.target_of(id, c, goal)?;
        self.part_pair(c);
        self.num_orders = self.num_orders.wrapping_add(1);
        self.set_target(self.world.clone().graph(), c, target);
        self.states[c] = self.states[c].with_goal(goal);
        if target.is_some() {
            self.paths.request_path(c);
        }
        Ok(())
    }

    fn step(&mut self, dt_s: f32, run: &dyn Executor) -> Result<()> {
        STEP_S.check("dt_s", None, dt_s)?;
        let world = self.world.clone();
        self.events.clear();
        self.control_all(&world, dt_s)?;
        self.characters.step_on(world.motion_set(), dt_s, &self.orders, run)?;
        self.update_roots();
        Ok(())
    }

    /// [`OrderStatus::Blocked`] for a character that waits for a reserved way or a taken place.
    fn status(&self, id: Id) -> Result<OrderStatus> {
        let c = self.roster.row(id)?;
        let graph = self.world.graph();
        let Some(target) = self.paths.target(c) else { return Ok(OrderStatus::Idle) };
        Ok(match self.states[c].activity {
            InhabitantActivity::Arrived | InhabitantActivity::Performing => OrderStatus::Arrived,
            InhabitantActivity::Unreachable => OrderStatus::NoPath,
            InhabitantActivity::Waiting | InhabitantActivity::Meeting | InhabitantActivity::Blocked => {
                let by = self.occupant_of(graph, c).or_else(|| self.holder_in_way(graph, c));
                // External obstacles have no id here.
                OrderStatus::Blocked { by: by.and_then(|other| self.roster.ids().get(other).copied()) }
            }
            _ => OrderStatus::Going { left_m: self.distance_left_m(c, target) },
        })
    }

    fn events(&self) -> &[(Id, InhabitantEvent)] {
        &self.events
    }

    fn bodies(&self) -> PosedBodies<'_> {
        let model = self.characters.model_matrices().as_chunks::<NUM_JOINTS>().0;
        PosedBodies { ids: self.roster.ids(), roots: &self.roots, model }
    }

    fn save(&self, out: &mut Vec<u8>) {
        self.write(out);
    }

    fn load(&mut self, bytes: &[u8]) -> Result<()> {
        self.read(bytes)?;
        self.events.clear();
        self.update_roots();
        Ok(())
    }

    /// A world belongs to its bundle: there is no other one to go on with.
    ///
    /// # Errors
    /// [`Error::OtherBundle`] for another bundle: open the world that was stitched with it, and spawn again.
    fn adopt(&mut self, new: &Bundle) -> Result<AdoptReport> {
        let (expected, got) = (self.world.bundle_hash(), new.hash());
        match expected == got {
            true => Ok(AdoptReport { num_characters: self.states.len(), farthest_m: 0.0 }),
            false => Err(Error::OtherBundle { expected, got }),
        }
    }
}
