//! Characters as a character group: they come and go, each with an id and an order of its own.

use super::block::{BodyBlock, MotionBlock, SCHEDULED};
use super::{
    CharacterStart, Characters, CharactersConfig, Detail, PoseInstance, check_root, occupied_error,
    segments_into_states,
};
use super::{idle::FACED, motion_set::MotionSet, order::PolicyOrder, snapshot::is_sound};
use crate::body::{
    BlockBefore, BodyEvent, BodyEventKind, BodyEvents, BodyLayers, BodyVolume, HeightField, LimbTouch, MovedBody,
    NO_ROW, TouchConfig,
};
use crate::character_group::{AdoptReport, CharacterGroup, OrderStatus, PosedBodies};
use crate::reserve::{FloorWall, ReservedRegion};
use crate::skeleton::{Joint, NUM_JOINTS};
use crate::{bundle::Bundle, contacts::Contacts, planar::Planar, roster::Roster};
use glam::{Vec2, Vec3};
use throng_base::error::{check_index, check_value, ensure};
use throng_base::{Error, Executor, Hash128, Id, Result, SnapshotKind, limits::STEP_S, simd::LANES};

/// Distance from the target within which a character has arrived (m).
pub const ARRIVED_M: f32 = 0.5;

/// Start of a character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spawn {
    /// Planar root in the world.
    pub root: Planar,
    /// State of the motion graph; none for one in which characters stand, where there is any.
    pub state: Option<u32>,
    /// Height to which its floor is the nearest one, where the ground has several (m).
    pub floor_m: f32,
}

impl Spawn {
    /// Start in a standing state.
    pub fn standing_at(root: Planar) -> Self {
        Self { root, state: None, floor_m: 0.0 }
    }
}

/// Characters that policies move, as a [`CharacterGroup`].
///
/// All memory is allocated in [`PolicyCharacters::with_capacity`] but for loading and adopting. Present
/// characters lie side by side in memory, so that those that left take no time. Random choices depend on the seed, the
/// id and the number of choices alone.
///
/// ```no_run
/// use throng_core::characters::{CharactersConfig, PolicyCharacters, Spawn};
/// use throng_core::{Bundle, CharacterGroup, Inline, Planar, glam::Vec3};
///
/// let bundle = Bundle::open("people.throng")?;
/// let mut people = PolicyCharacters::with_capacity(&bundle, 1000, CharactersConfig::default())?;
/// let id = people.spawn(Spawn::standing_at(Planar::IDENTITY))?;
/// people.order(id, bundle.policy("approach")?.order_towards(Vec3::new(3.0, 0.0, 4.0)))?;
/// people.step(1.0 / 60.0, &Inline)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PolicyCharacters {
    pub(super) bundle: Bundle,
    pub(super) motion_set: MotionSet,
    pub(super) characters: Characters,
    /// A segment that ends in each state.
    pub(super) arrivals: Vec<u32>,
    /// Ids of present characters, in the order of bodies.
    roster: Roster,
    pub(super) orders: Vec<PolicyOrder>,
    /// Order that each obeyed in the last step (number of characters).
    pub(super) obeyed: Vec<PolicyOrder>,
    roots: Vec<Planar>,
    events: BodyEvents,
    /// See [`PolicyCharacters::hold_entrants`].
    pub(super) gathers: bool,
}

impl PolicyCharacters {
    /// Room for so many characters.
    ///
    /// # Errors
    /// [`Error::Value`] for a setting or capacity out of its range, [`Error::Unknown`] for a bundle without a motion graph.
    pub fn with_capacity(bundle: &Bundle, capacity: usize, config: CharactersConfig) -> Result<Self> {
        let motion_set = MotionSet::new(bundle);
        ensure(!motion_set.graph().states.is_empty(), no_graph)?;
        let characters = Characters::with_capacity(&motion_set, config, capacity)?;
        Ok(Self {
            bundle: bundle.clone(),
            arrivals: segments_into_states(&motion_set),
            motion_set,
            roster: Roster::with_capacity(capacity),
            orders: Vec::with_capacity(capacity),
            obeyed: Vec::with_capacity(capacity),
            roots: Vec::with_capacity(capacity),
            events: BodyEvents::with_capacity(capacity, characters.blows.max_blows()),
            gathers: false,
            characters,
        })
    }

    /// Most characters.
    pub fn capacity(&self) -> usize {
        self.roster.capacity()
    }

    /// Motion set that all characters play.
    pub fn motion_set(&self) -> &MotionSet {
        &self.motion_set
    }

    /// Ids of present characters, in the order of bodies.
    pub fn ids(&self) -> &[Id] {
        self.roster.ids()
    }

    /// The order of a character.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn order_of(&self, id: Id) -> Result<&PolicyOrder> {
        Ok(&self.orders[self.roster.row(id)?])
    }

    /// Replaces what the body of a character does beside its motion; the rest of its order stays.
    ///
    /// # Errors
    /// [`Error::Gone`], or what is wrong with the layers.
    pub fn set_layers(&mut self, id: Id, layers: BodyLayers) -> Result<()> {
        let order = self.order_of(id)?.with_layers(layers);
        order.check(Some(id), &self.motion_set)?;
        // The target is as it was.
        self.orders[self.roster.row(id)?] = order;
        Ok(())
    }

    /// Replaces the order of a character but for its layers.
    ///
    /// # Errors
    /// As [`CharacterGroup::order`].
    pub fn order_motion(&mut self, id: Id, order: PolicyOrder) -> Result<()> {
        self.order(id, order.with_layers(self.order_of(id)?.layers()))
    }

    /// Orders a character a manner of motion, see [`PolicyOrder::in_manner`]; the rest of its order stays.
    ///
    /// # Errors
    /// [`Error::Gone`], or [`Error::Unknown`] with the manners there are.
    pub fn set_manner(&mut self, id: Id, name: &str) -> Result<()> {
        ensure(!name.is_empty() && !name.contains('\0'), || self.motion_set.manners.unknown(name))?;
        self.order(id, self.order_of(id)?.in_manner(name))
    }

    /// Orders a character a speed, see [`PolicyOrder::at_speed`]; the rest of its order stays.
    ///
    /// # Errors
    /// [`Error::Gone`], or [`Error::Value`].
    pub fn set_speed(&mut self, id: Id, speed_mps: f32) -> Result<()> {
        self.order(id, self.order_of(id)?.at_speed(speed_mps))
    }

    /// Name of the manner of the motion that a character plays; empty where no motion has one.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn manner(&self, id: Id) -> Result<&str> {
        let (segment, _) = self.characters.segment(self.roster.row(id)?);
        Ok(self.motion_set.manners.name_of(self.motion_set.graph.segments[segment as usize].end))
    }

    /// Planted parts of a character's feet.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn contacts(&self, id: Id) -> Result<Contacts> {
        Ok(self.characters.contacts(self.roster.row(id)?))
    }

    /// The engine beneath: blows, segments and choices by row, in the order of [`PolicyCharacters::ids`].
    pub fn characters(&self) -> &Characters {
        &self.characters
    }

    /// Stops the limbs of characters in rows 2i and 2i + 1 at each other's bodies, see [`Characters::set_partner_touch`].
    ///
    /// # Errors
    /// As [`Characters::set_partner_touch`].
    pub fn set_partner_touch(&mut self, volume: BodyVolume, config: TouchConfig) -> Result<()> {
        self.characters.set_partner_touch(&self.motion_set, volume, config)
    }

    /// Row of a character, in the order of bodies.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn row(&self, id: Id) -> Result<usize> {
        self.roster.row(id)
    }

    /// Moves what all orders are about; behaviours and weights stay.
    ///
    /// - `targets`, `threats`: see [`PolicyOrder::with_target`] and [`PolicyOrder::with_threat`] (number of characters, in the order of
    ///   bodies).
    ///
    /// # Errors
    /// [`Error::Length`], or [`Error::Value`] for what is not finite; nothing has changed then.
    pub fn aim_all(&mut self, targets: &[Vec3], threats: &[Vec3]) -> Result<()> {
        let n = self.orders.len();
        for (what, got) in [("targets", targets.len()), ("threats", threats.len())] {
            ensure(got == n, || Error::Length { what, got, expected: format!("{n}, one for each character") })?;
        }
        let new =
            |(order, (target, threat)): (&PolicyOrder, (&Vec3, &Vec3))| order.with_target(*target).with_threat(*threat);
        let about = || targets.iter().zip(threats);
        for (id, order) in self.roster.ids().iter().zip(self.orders.iter().zip(about()).map(new)) {
            order.check_target(Some(*id))?;
        }
        for (at, about) in about().enumerate() {
            self.give_order(at, new((&self.orders[at], about)));
        }
        Ok(())
    }

    /// Moves a character over the ground as a whole, at the next step; see [`Characters::shift_by`]. One that makes way stays
    /// where that would bring it into another's.
    ///
    /// # Errors
    /// [`Error::Gone`], or [`Error::Value`] for a distance that is not finite.
    pub fn shift_by(&mut self, id: Id, by: Vec2) -> Result<()> {
        let at = self.roster.row(id)?;
        self.characters.shift_aside(&self.motion_set, at, by)
    }

    /// Displaces a part of a character's body, which then comes back; see [`Characters::push`].
    ///
    /// # Errors
    /// [`Error::Gone`], or [`Error::Value`] for a displacement that is not finite.
    pub fn push(&mut self, id: Id, joint: Joint, displacement: Vec3) -> Result<()> {
        let at = self.roster.row(id)?;
        let reaction = self.characters.config.reaction;
        let (_, body, lane) = self.characters.lane_mut(at);
        body.state.push(lane, &reaction, Some(id), joint, displacement)
    }

    /// Changes the ground that all stand on, see [`Characters::set_ground`].
    pub fn set_ground(&mut self, ground: HeightField) {
        self.characters.set_ground(ground);
    }

    /// Sets the walls, see [`Characters::set_walls`].
    pub fn set_walls(&mut self, walls: impl IntoIterator<Item: Into<FloorWall>>) {
        self.characters.set_walls(walls);
    }

    /// Sets the external obstacles, see [`Characters::set_external_obstacles`].
    pub fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        self.characters.set_external_obstacles(others);
    }

    /// Lets all characters that enter from now on stand still until [`PolicyCharacters::release_entrants`], so that many can
    /// enter near each other, in any order.
    pub fn hold_entrants(&mut self) {
        self.gathers = true;
    }

    /// Lets all characters that entered since [`PolicyCharacters::hold_entrants`] begin, with collision avoidance one after
    /// the other: a character without room for the stop from its state is held in the state until there is room.
    pub fn release_entrants(&mut self) {
        self.gathers = false;
        self.characters.reserve_all(&self.motion_set);
    }

    /// Sets viewpoint and distances of the level of detail, see [`Characters::set_detail`].
    ///
    /// # Errors
    /// As [`Characters::set_detail`].
    pub fn set_detail(&mut self, detail: Option<Detail>) -> Result<()> {
        self.characters.set_detail(detail)
    }

    /// Record of every character for GPUs, in the order of bodies; empty unless [`CharactersConfig::instances`].
    pub fn instances(&self) -> &[PoseInstance] {
        self.characters.instances()
    }

    /// Adds all bodies and the ground that they hold, see [`Characters::add_reserved_regions`].
    pub fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
        self.characters.add_reserved_regions(&self.motion_set, out);
    }

    /// Starts a segment from where a character stands, see [`Characters::play`].
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Index`] for a segment that does not exist, or [`Error::Occupied`] as
    /// [`Characters::play`].
    pub fn play_segment(&mut self, id: Id, segment: u32) -> Result<()> {
        check_index("segment", Some(id), segment as usize, self.motion_set.graph().segments.len())?;
        let at = self.roster.row(id)?;
        self.characters.play(&self.motion_set, at, segment).map_err(|e| match e {
            Error::Occupied { by, .. } => Error::Occupied { who: id, by },
            e => e,
        })
    }

    /// State of the motion graph in which characters stand that enter without one.
    pub fn standing_state(&self) -> u32 {
        self.motion_set.graph().states.iter().position(|s| s.standing == 1).unwrap_or(0) as u32
    }

    /// Notes all before a step of so many frames.
    fn note_before(&mut self, frames: f32) {
        self.events.clear(frames);
        let has_tags = !self.motion_set.rows.has_no_tags();
        let Characters { blocks, bodies, .. } = &self.characters;
        for (block, body) in blocks.iter().zip(bodies) {
            let rows = if has_tags { block.frame_rows() } else { [NO_ROW; LANES] };
            self.events.note_before(BlockBefore { contacts: block.contacts, seen: body.state.seen, rows });
        }
    }

    /// Takes the roots of a step, and gathers its events character by character.
    fn note_after(&mut self) {
        let (mut num_blows, rows) = (0, &self.motion_set.rows);
        let has_tags = !rows.has_no_tags();
        let Characters { blocks, bodies, matrices, blows, .. } = &self.characters;
        let (ids, blows, models) = (self.roster.ids(), blows.get(), matrices.as_chunks().0);
        for (b, (roots, (block, body))) in self.roots.chunks_mut(LANES).zip(blocks.iter().zip(bodies)).enumerate() {
            for (lane, root) in roots.iter_mut().enumerate() {
                *root = block.root(lane);
            }
            let (first, swing) = (b * LANES, &body.state.swing);
            let strikes = blows.get(num_blows).is_some_and(|blow| (blow.character as usize) < first + LANES);
            let frames = has_tags.then(|| block.frame_rows());
            for (lane, root) in roots.iter().enumerate() {
                let (at, contacts) = (first + lane, block.contacts[lane]);
                let strikes = blows[num_blows..].iter().take_while(|blow| strikes && blow.character as usize == at);
                for blow in strikes {
                    num_blows += 1;
                    let event = BodyEvent::new(BodyEventKind::Blow, blow.hit);
                    self.events.add(ids[at], BodyEvent { at: blow.point, strength: blow.force, ..event });
                }
                if self.events.has_changed(at, contacts, swing) {
                    let of = MovedBody { body: &self.motion_set.body, root: *root, model: &models[at], swing };
                    self.events.add_contacts(at, ids[at], contacts, &of);
                }
                if let Some(frames) = frames {
                    self.events.add_tags(at, ids[at], rows, frames[lane]);
                }
            }
        }
    }

    fn snapshot_kind(&self) -> SnapshotKind {
        let mut setup = Hash128::default();
        setup.add_bytes(&self.bundle.hash().to_le_bytes());
        // What is only written or measured besides changes no motion.
        let outputs = CharactersConfig { local_transforms: false, instances: false, ..self.characters.config };
        setup.add_bytes(format!("{outputs:?}").as_bytes());
        SnapshotKind { what: "policy characters", tag: *b"PCHR", version: 12, setup: setup.finish() }
    }
}

/// Name by which random choices are drawn, beside the seed and their number.
fn name(id: Id) -> u64 {
    u64::from(id.generation) << 32 | u64::from(id.index)
}

pub(super) fn no_graph() -> Error {
    Error::Unknown { what: "motion graph", name: "of the bundle".into(), known: Vec::new() }
}

impl CharacterGroup for PolicyCharacters {
    type Start = Spawn;
    type Order = PolicyOrder;
    type Event = BodyEvent;

    /// Spawns a character, whose pose is there after the next step.
    ///
    /// # Errors
    /// As [`CharacterGroup::spawn`]; [`Error::Occupied`] where collision avoidance is on and its place is on another's path. A
    /// character without room for the stop from its state is held in the state until there is room for an action.
    fn spawn(&mut self, start: Spawn) -> Result<Id> {
        let id = self.roster.next_id()?;
        let state = start.state.unwrap_or_else(|| self.standing_state());
        check_index("state", Some(id), state as usize, self.motion_set.graph().states.len())?;
        check_root(Some(id), start.root)?;
        let at = self.characters.num_characters();
        check_value("floor_m", Some(id), start.floor_m, start.floor_m.abs() < 1e4, "finite and below 10000 m")?;
        let entry = CharacterStart { root: start.root, state };
        self.characters.add_character(&self.motion_set, entry, &self.arrivals, name(id));
        self.characters.set_floor(at, start.floor_m);
        let reserve = if self.gathers { Characters::reserve_held } else { Characters::reserve_start };
        if !reserve(&mut self.characters, &self.motion_set, at) {
            self.characters.remove_character(at);
            return Err(occupied_error(id));
        }
        self.roster.add_id()?;
        self.orders.push(PolicyOrder::IDLE);
        self.obeyed.push(PolicyOrder::IDLE);
        self.roots.push(start.root);
        Ok(id)
    }

    /// The last one takes its place in [`CharacterGroup::bodies`].
    fn despawn(&mut self, id: Id) -> Result<()> {
        let (at, _) = self.roster.remove_id(id)?;
        self.characters.remove_character(at);
        self.orders.swap_remove(at);
        self.obeyed.swap_remove(at);
        self.roots.swap_remove(at);
        Ok(())
    }

    fn place(&mut self, id: Id, root: Planar) -> Result<()> {
        let at = self.roster.row(id)?;
        check_root(Some(id), root)?;
        let (block, body, _) = self.characters.lane_mut(at);
        let (block, body) = (*block, *body);
        self.characters.put_at(&self.motion_set, at, root);
        if !self.characters.reserve_path(&self.motion_set, at) {
            let (blocks, bodies, _) = self.characters.lane_mut(at);
            (*blocks, *bodies) = (block, body);
            self.characters.reserve_path(&self.motion_set, at);
            return Err(occupied_error(id));
        }
        self.characters.reset_touch(at);
        self.roots[at] = root;
        Ok(())
    }

    fn order(&mut self, id: Id, order: PolicyOrder) -> Result<()> {
        let at = self.roster.row(id)?;
        order.check(Some(id), &self.motion_set)?;
        self.give_order(at, order);
        Ok(())
    }

    fn step(&mut self, dt_s: f32, run: &dyn Executor) -> Result<()> {
        STEP_S.check("dt_s", None, dt_s)?;
        self.answer_orders();
        self.note_before(dt_s * self.motion_set.rate_hz);
        self.characters.run(&self.motion_set, dt_s, &self.orders, run);
        self.orders.iter_mut().for_each(|order| order.age(dt_s));
        self.note_after();
        Ok(())
    }

    /// Going until the place that the first behaviour brings to its target is within [`ARRIVED_M`] of it, or until the character
    /// stands, and faces where it is ordered to.
    fn status(&self, id: Id) -> Result<OrderStatus> {
        let at = self.roster.row(id)?;
        let order = &self.orders[at];
        if order.is_to_stand() {
            let turns = order.turn_left(self.roots[at].heading).abs() > FACED;
            let stands = self.characters.is_at_rest(&self.motion_set, at) && !turns;
            return Ok(if stands { OrderStatus::Arrived } else { OrderStatus::Going { left_m: 0.0 } });
        }
        let Some(policy) = order.policies().first().and_then(|&p| self.motion_set.policy(p as usize)) else {
            return Ok(OrderStatus::Idle);
        };
        let about = order.target_of(policy);
        let target = self.roots[at].inverse_transform_point(Vec2::new(about.x, about.z));
        let left_m = target.distance(Vec2::new(policy.centre().x, policy.centre().z));
        Ok(if left_m <= ARRIVED_M { OrderStatus::Arrived } else { OrderStatus::Going { left_m } })
    }

    fn events(&self) -> &[(Id, BodyEvent)] {
        self.events.get()
    }

    fn bodies(&self) -> PosedBodies<'_> {
        let model = self.characters.model_matrices().as_chunks::<NUM_JOINTS>().0;
        PosedBodies { ids: self.roster.ids(), roots: &self.roots, model }
    }

    fn save(&self, out: &mut Vec<u8>) {
        let (blocks, bodies) = self.characters.saved_blocks();
        let orders = (&self.orders, &self.obeyed);
        self.snapshot_kind().write(&(blocks, bodies, &self.characters.touches, &self.roster, orders), out);
    }

    fn load(&mut self, bytes: &[u8]) -> Result<()> {
        let kind = self.snapshot_kind();
        type Saved = (Vec<MotionBlock>, Vec<BodyBlock>, Vec<LimbTouch>, Roster, [Vec<PolicyOrder>; 2]);
        let (blocks, bodies, touches, roster, [orders, obeyed]): Saved = kind.read_all(bytes)?;
        let refuse = |why: String| Err(Error::Snapshot { what: kind.what, why });
        let n = roster.ids().len();
        let lens = (orders.len(), obeyed.len(), blocks.len(), bodies.len());
        let are_rows = lens == (n, n, n.div_ceil(LANES), n.div_ceil(LANES));
        if !are_rows || !self.characters.is_touch_sound(&touches, n) {
            return refuse(format!("it is damaged: its rows are not those of {n} characters; take a new one"));
        }
        if !self.roster.clone().restore(&roster) {
            let capacity = self.roster.capacity();
            return refuse(format!(
                "its ids are not those of {capacity} places; restore it into as many as it was taken of"
            ));
        }
        for (at, (id, order)) in roster.ids().iter().zip(&orders).enumerate() {
            for order in [order, &obeyed[at]] {
                order.check(Some(*id), &self.motion_set).or_else(|e| refuse(e.to_string()))?;
            }
            // Scheduled clips are for characters that a caller moves.
            let is_scheduled = blocks[at / LANES].segment[at % LANES] == SCHEDULED;
            if is_scheduled || !is_sound(&blocks, &bodies, &self.motion_set, at, name(*id)) {
                return refuse(format!(
                    "character {id} plays what the bundle does not have, or is nowhere; take a new one"
                ));
            }
        }
        if let Some(at) = self.characters.find_path_conflict(&self.motion_set, &blocks, n) {
            return refuse(format!("character {} is in another's way, though they make way", roster.ids()[at]));
        }
        self.roster.restore(&roster);
        self.characters.set_state(&blocks, &bodies, &touches, n);
        self.characters.pose_again(&self.motion_set);
        // The vector keeps its capacity.
        self.orders.clone_from(&orders);
        self.obeyed.clone_from(&obeyed);
        self.roots.clear();
        self.roots.extend((0..n).map(|at| self.characters.root(at)));
        self.events.clear(0.0);
        Ok(())
    }

    /// Moves every character to the state of the new motion graph whose pose is nearest to its own.
    fn adopt(&mut self, new: &Bundle) -> Result<AdoptReport> {
        super::adopt::adopt(self, new)
    }
}

#[cfg(test)]
mod tests;
