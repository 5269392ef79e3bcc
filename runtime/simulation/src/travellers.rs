//! Characters with policies on the way to goals: navigation puts a point before them, and their policy goes there.

use crate::agents::{CrowdLayout, Disc};
use crate::boxing::{characters_config, in_own_manner, resting_states, weighted_order};
use crate::compile::CompiledScene;
use crate::motion_kind::{GroupStep, MotionKind, refused_snapshot, saved_bytes};
use crate::scene::{AtEndConfig, Scene};
use crate::{CharacterEvent, SimulationEvent};
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use throng_base::ground::ReservedRegion;
use throng_base::maths;
use throng_base::thresholds::{WAITS_BELOW_MPS, WALK_SPEED_MPS};
use throng_base::{Bytes, Error, Id, Result, SnapshotKind};
use throng_core::characters::{PolicyCharacters, PolicyOrder, Spawn};
use throng_core::stops::BODY_RADIUS_M;
use throng_core::{CharacterGroup, Contacts, Mat3x4, NUM_JOINTS, Planar};
use throng_crowd::{NavigatedBody, Navigation, NavigationAim, NavigationState, Streets};

/// Distance of the target from a character that is on its way: so far that its policy does not slow down at a corner (m).
const TARGET_AHEAD_M: f32 = 2.0;
/// Poses in which a character is tried to be placed at its start.
const POSES_TRIED: usize = 16;
/// Distance from the goal at which a character goes straight there (m).
const GOAL_NEAR_M: f32 = 1.0;

/// Group of characters with policies on the way to goals.
#[derive(Clone, Debug)]
pub struct Travellers {
    scene: Arc<Scene>,
    /// Numbers of their groups in the scene.
    groups: Vec<usize>,
    people: PolicyCharacters,
    navigation: Navigation,
    travels: Vec<TravelState>,
    layout: CrowdLayout<Vec2>,
    /// Targets of the present characters, in the order of their rows (m).
    targets: Vec<Vec3>,
}

/// State of one character on its way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct TravelState {
    is_stuck: bool,
    /// True once it has been at its goal.
    has_arrived: bool,
}

/// Snapshot of travels, around one of the characters.
const TRAVELS: SnapshotKind = SnapshotKind { what: "travellers", tag: *b"TRAV", version: 2, setup: 0 };

impl Travellers {
    /// Creates groups with one bundle, with all characters in place.
    ///
    /// # Errors
    /// As [`CrowdLayout::new`], and [`Error::Text`] for starts in each other.
    pub(crate) fn new(compiled: &CompiledScene, groups: &[usize]) -> Result<Self> {
        let (scene, group) = (&compiled.scene, groups[0]);
        let (bundle, key) = (compiled.bundle(group)?, format!("groups[{group}]"));
        let layout = CrowdLayout::<Vec2>::of_groups(scene, |g| groups.contains(&g))?;
        let orders = groups.iter().map(|&g| weighted_order(compiled, g).map(|(order, _)| order));
        let orders: Vec<PolicyOrder> = orders.collect::<Result<_>>()?;
        let fault = |e: Error| match e {
            Error::Occupied { who, .. } => {
                let why = format!(
                    "character {who} starts where another one or an obstacle is; enlarge `place`, or take a smaller `count`"
                );
                scene.fault(&key, why)
            }
            e => scene.fault(&key, e),
        };
        let num = layout.num_agents();
        let mut people =
            PolicyCharacters::with_capacity(bundle, num, characters_config(compiled, group)).map_err(fault)?;
        let mut streets = match &layout.setup.streets {
            Some(streets) => streets.clone(),
            None => Streets::new(&[], BODY_RADIUS_M)?,
        };
        let is_known = layout.setup.streets.is_some();
        for (d, door) in scene.environment.doors.iter().enumerate().filter(|_| is_known) {
            streets.set_open(layout.first_door + d, door.open)?;
        }
        let mut navigation = Navigation::new(&streets, BODY_RADIUS_M, WALK_SPEED_MPS, num).map_err(fault)?;
        let states = resting_states(bundle);
        let mut rng = Pcg64Mcg::seed_from_u64(scene.seed ^ group as u64);
        people.hold_entrants();
        people.set_walls(&scene.environment.walls_and_closed_doors());
        for ((agent, path), of) in layout.setup.agents.iter().zip(&layout.paths).zip(&layout.groups) {
            let order = orders[groups.iter().position(|g| g == of).unwrap_or_default()];
            let at = agent.position;
            let ahead = path.get(1).map_or(Vec2::Y, |next| *next - at);
            let root = Planar::new(at.x, at.y, maths::atan2(ahead.x, ahead.y));
            // Not every pose has room everywhere.
            let mut spawn =
                || people.spawn(Spawn { root, state: Some(states[rng.random_range(0..states.len())]), floor_m: 0.0 });
            let first = spawn();
            let id = (1..POSES_TRIED).fold(first, |made, _| made.or_else(|_| spawn())).map_err(fault)?;
            let order = in_own_manner(order, &scene.groups[*of], id.index());
            people.order(id, order.with_target(Vec3::new(at.x, 0.0, at.y))).map_err(fault)?;
            let route = agent.route.map(|route| &layout.setup.routes[route]);
            if let Some(route) = route {
                navigation.add_body(route, at).map_err(fault)?;
            }
        }
        people.release_entrants();
        Ok(Self {
            scene: Arc::clone(scene),
            groups: groups.to_vec(),
            people,
            navigation,
            travels: vec![TravelState::default(); num],
            layout,
            targets: Vec::with_capacity(num),
        })
    }

    /// The characters.
    pub fn people(&self) -> &PolicyCharacters {
        &self.people
    }

    /// Starts, paths and goals.
    pub fn layout(&self) -> &CrowdLayout<Vec2> {
        &self.layout
    }

    /// A character's disc on the ground; `None` where it has left (number < num_characters).
    pub fn disc(&self, number: usize) -> Option<Disc> {
        let row = self.row(number)?;
        let (root, book) = (self.people.bodies().roots[row], self.people.characters().reservations());
        let velocity = book.map_or(Vec2::ZERO, |book| book.velocity(row));
        let [centre, velocity] = [Vec2::new(root.x, root.z), velocity].map(|v| Vec3::new(v.x, 0.0, v.y));
        Some(Disc { root, centre, velocity, radius: BODY_RADIUS_M, knows: false })
    }

    /// Point that a character goes to now (m, number < num_characters).
    pub fn aim(&self, number: usize) -> Vec2 {
        self.navigation.aim(number).position
    }

    /// Length of the path that a character has left (m, number < num_characters).
    pub fn remaining_m(&self, number: usize) -> f32 {
        let aim = self.navigation.aim(number);
        let place = self.row(number).map(|row| self.people.bodies().roots[row]);
        place.map_or(0.0, |root| aim.position.distance(Vec2::new(root.x, root.z)) + aim.rest_m)
    }

    /// True for a character that has been at its goal (number < num_characters).
    pub fn has_arrived(&self, number: usize) -> bool {
        self.travels[number].has_arrived
    }

    /// True for a character that makes no progress (number < num_characters).
    pub fn is_stuck(&self, number: usize) -> bool {
        self.travels[number].is_stuck
    }

    /// Row of a character; none where it has left. Ids are numbered as characters, since nobody enters later.
    fn row(&self, number: usize) -> Option<usize> {
        self.people.row(Id::first(number)).ok()
    }

    fn fault(&self, e: Error) -> Error {
        self.scene.fault(&format!("groups[{}]", self.groups[0]), e)
    }
}

/// Target of a character on its way: its goal where that is near, else a point ahead along the velocity that navigation gives, so
/// far that its policy does not slow down before it; its own place where it should wait.
fn target_ahead(place: Vec2, aim: &NavigationAim) -> Vec3 {
    let (left_m, speed) = (place.distance(aim.position) + aim.rest_m, aim.velocity.length());
    let target = if left_m < GOAL_NEAR_M || aim.has_arrived {
        aim.position
    } else if speed < WAITS_BELOW_MPS {
        place
    } else {
        place + aim.velocity * (TARGET_AHEAD_M.min(left_m) / speed)
    };
    Vec3::new(target.x, 0.0, target.y)
}

impl MotionKind for Travellers {
    fn num_characters(&self) -> usize {
        self.travels.len()
    }

    fn step(&mut self, tick: &GroupStep<'_>, events: &mut Vec<SimulationEvent>) -> Result<()> {
        let time_s = tick.until_s - f64::from(tick.dt_s);
        let people = &self.people;
        self.navigation.update(time_s, |number| {
            let row = people.row(Id::first(number)).ok()?;
            let root = people.bodies().roots[row];
            let velocity = people.characters().reservations().map_or(Vec2::ZERO, |book| book.velocity(row));
            Some(NavigatedBody { position: Vec2::new(root.x, root.z), velocity })
        });
        self.targets.clear();
        for (id, root) in self.people.ids().iter().zip(self.people.bodies().roots) {
            let (aim, place) = (self.navigation.aim(id.index()), Vec2::new(root.x, root.z));
            self.targets.push(target_ahead(place, &aim));
            let travel = &mut self.travels[id.index()];
            if aim.has_arrived && !travel.has_arrived {
                events.push(tick.event(id.index(), CharacterEvent::Arrived));
            }
            if aim.is_stuck && !travel.is_stuck {
                events.push(tick.event(id.index(), CharacterEvent::Stuck));
            }
            *travel = TravelState { has_arrived: travel.has_arrived || aim.has_arrived, is_stuck: aim.is_stuck };
        }
        self.people.aim_all(&self.targets, &self.targets).map_err(|e| self.fault(e))?;
        self.people.step(tick.dt_s, tick.run).map_err(|e| self.fault(e))?;
        for number in 0..self.travels.len() {
            let leaves = self.scene.groups[self.layout.groups[number]].at_end == AtEndConfig::Leave;
            if leaves && self.travels[number].has_arrived && self.row(number).is_some() {
                self.people.despawn(Id::first(number))?;
                events.push(tick.event(number, CharacterEvent::Left));
            }
        }
        Ok(())
    }

    fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
        self.people.add_reserved_regions(out);
    }

    fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        self.people.set_external_obstacles(others);
    }

    fn restart_on_free_ground(&mut self) {
        self.people.release_entrants();
    }

    fn save(&self, out: &mut Vec<u8>) {
        let people = saved_bytes(|out| self.people.save(out));
        TRAVELS.write(&(self.navigation.state(), &self.travels, people), out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        let (state, travels, people): (NavigationState, Vec<TravelState>, Bytes) = TRAVELS.read_all(bytes)?;
        if travels.len() != self.travels.len() || !self.navigation.restore(&state) {
            return Err(refused_snapshot(TRAVELS.what, "its travels are on no route"));
        }
        self.people.load(&people.0)?;
        if self.people.ids().iter().any(|id| id.index() >= travels.len() || *id != Id::first(id.index())) {
            return Err(refused_snapshot(TRAVELS.what, "its characters are others"));
        }
        self.travels = travels;
        Ok(())
    }

    fn root(&self, number: usize) -> Option<Planar> {
        Some(self.people.bodies().roots[self.row(number)?])
    }

    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        Some(&self.people.bodies().model[self.row(number)?])
    }

    fn contacts(&self, number: usize) -> Contacts {
        self.row(number).map_or(Contacts::default(), |row| self.people.characters().contacts(row))
    }
}
