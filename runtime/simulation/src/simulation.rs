//! The simulation: one clock, one order of events, one snapshot.

use crate::agents::{Disc, HandlingCounts, SceneAgents};
use crate::boxing::{Bouts, Practice};
use crate::motion_kind::{GroupStep, MotionKind, check_snapshot, saved_bytes};
use crate::scenario::{AgentBrains, BrainChange, Explanation};
use crate::scene::{GroupConfig, GroupMotion, Scene, SpaceConfig};
use crate::{character_groups::AnyCharacterGroup, inhabitant_group::InhabitantGroup};
use crate::{compile::CompiledScene, order::Order, sparring::StruckPart, travellers::Travellers, wander::Wanderers};
use glam::{Quat, Vec2, Vec3};
use std::{ops::Range, time::Instant};
use throng_base::error::{check_index, check_value};
use throng_base::ground::{ExternalObstacles, ReservedRegion};
use throng_base::{Bytes, Error, Executor, Id, Inline, Result, SnapshotKind, StateHash, limits::STEP_S, maths};
use throng_core::{Contacts, Mat3x4, NUM_JOINTS, Planar};

/// Events of one character in one step for which there is memory from the start.
const EVENTS_EACH: usize = 4;
/// Time after which goals that move are looked at again (s), and the distance from which they have moved (m).
const RENEWS_S: f64 = 0.5;
const MOVED_M: f32 = 0.3;

/// Refusals of people who can do less.
const NO_ORDERS: &str = "its people take no orders; agents do, and people of `motion = \"policy\"` with a `goal`";
const NO_BRAIN: &str = "its people have no brains; agents have, where the scene has rules, events or graphs";

/// Simulation of a scene.
///
/// Characters are numbered from 0, group by group of [`Simulation::groups`]; a number is never used again.
///
/// ```no_run
/// use throng_simulation::{Scene, Simulation};
///
/// let mut people = Simulation::new(&Scene::load("street.toml")?.open()?)?;
/// let kept = people.snapshot();
/// people.step(1.0 / 30.0)?;
/// println!("{} of them at {:.2} s", people.roots().flatten().count(), people.time_s());
/// people.restore(&kept)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Simulation {
    scene: CompiledScene,
    character_groups: Vec<AnyCharacterGroup>,
    /// Number of the first character of each character group, and at the end the number of all characters.
    firsts: Vec<usize>,
    groups: Vec<SceneGroup>,
    events: Vec<SimulationEvent>,
    /// Bodies and reserved regions of each character group, and at the end those of moving obstacles; empty where no character group has to
    /// avoid others.
    reserved: Vec<ReservedRegion>,
    /// True for each door that is open.
    open_doors: Vec<bool>,
    /// Order of each character (num_characters).
    orders: Vec<GivenOrder>,
    /// Character group that was last informed of the current reserved regions; nothing has changed since.
    informed_group: Option<usize>,
    time_s: f64,
    /// Computing time of each character group so far, where it is measured (s).
    busy_s: Option<Vec<f64>>,
}

/// Order of a character, and the goal that it has by that; none before the first order.
type GivenOrder = Option<(Order, Option<Vec3>)>;

/// Group of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneGroup {
    /// Name; "group" and its number where the file gives none.
    pub name: String,
    /// Source of the group's motion.
    pub motion: GroupMotion,
    /// Number in the scene file.
    pub number: usize,
    /// Numbers of its characters.
    pub characters: Range<usize>,
    /// Number of the character group that it belongs to.
    pub character_group: usize,
}

/// Event of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationEvent {
    /// Time (s).
    pub time_s: f64,
    /// Number of the character that it concerns.
    pub who: usize,
    /// Kind of the event.
    pub kind: CharacterEvent,
}

/// Thing of a scene, which hands take and put down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneThing<'a> {
    /// Name of the thing.
    pub name: &'a str,
    /// Size along x, y and z (m).
    pub size: Vec3,
    /// Position of the centre (m).
    pub at: Vec3,
    /// Orientation.
    pub turn: Quat,
    /// Number of the character that has it in hand.
    pub keeper: Option<usize>,
}

/// Kind of an event of a character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CharacterEvent {
    /// Its blow hit its target.
    Hit {
        /// Position (m).
        at: Vec3,
    },
    /// Its blow met its opponent.
    Struck {
        /// Number of the opponent.
        opponent: usize,
        /// Struck part of the opponent; an arm has blocked the blow.
        part: StruckPart,
        /// Position (m).
        at: Vec3,
    },
    /// Its goal in a world is reached.
    Fulfilled,
    /// The character is at its goal.
    Arrived,
    /// The character has left at its goal.
    Left,
    /// The character makes no progress.
    Stuck,
    /// A moving obstacle ran into it.
    RunInto {
        /// Number of the obstacle, as the crowd counts them.
        obstacle: usize,
    },
}

impl CharacterEvent {
    /// Rank of events of one character at one time.
    fn rank(&self) -> u8 {
        match self {
            Self::Hit { .. } | Self::Struck { .. } => 0,
            Self::Fulfilled => 1,
            Self::Arrived => 2,
            Self::Stuck => 3,
            Self::RunInto { .. } => 4,
            Self::Left => 5,
        }
    }
}

impl Simulation {
    /// Creates all characters of a scene; poses are valid at once.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] for starts and goals that are impossible, with their keys in the scene file.
    pub fn new(scene: &CompiledScene) -> Result<Self> {
        let mut sim = Self {
            scene: scene.clone(),
            character_groups: Vec::new(),
            firsts: vec![0],
            groups: Vec::new(),
            events: Vec::new(),
            reserved: Vec::new(),
            open_doors: scene.scene().environment.doors.iter().map(|door| door.open).collect(),
            orders: Vec::new(),
            informed_group: None,
            time_s: 0.0,
            busy_s: None,
        };
        let groups = &scene.scene().groups;
        let mut is_in = vec![false; groups.len()];
        for g in 0..groups.len() {
            if is_in[g] {
                continue;
            }
            // Agents share one crowd, inhabitants their world, and those who travel on one bundle the ground.
            let is_with = |&o: &usize| {
                let agents = groups[g].is_of_agents() && groups[o].is_of_agents();
                o == g
                    || agents
                    || scene.travel_together(g, o)
                    || scene.world_number(g).is_some() && scene.world_number(g) == scene.world_number(o)
            };
            let together: Vec<usize> = (g..groups.len()).filter(is_with).collect();
            together.iter().for_each(|&o| is_in[o] = true);
            sim.character_groups.push(make_character_group(scene, &together)?);
            for o in together {
                let first = sim.groups.last().map_or(0, |last| last.characters.end);
                let (characters, character_group) = (first..first + groups[o].count, sim.character_groups.len() - 1);
                let (name, motion) = (groups[o].title(o), groups[o].motion);
                sim.groups.push(SceneGroup { name, motion, number: o, characters, character_group });
            }
            sim.firsts.push(sim.groups.last().map_or(0, |last| last.characters.end));
        }
        let moves_doors = scene.scene().events.iter().any(|e| !e.opens.is_empty() || !e.closes.is_empty());
        if moves_doors && !groups.iter().any(GroupConfig::is_of_agents) {
            // Without agents too, events open and close doors.
            sim.character_groups.push(AnyCharacterGroup::Ground(SceneAgents::new(scene)?));
            sim.firsts.push(sim.num_characters());
        }
        sim.events.reserve(EVENTS_EACH * sim.num_characters());
        sim.orders = vec![None; sim.num_characters()];
        let mut moves_itself = ReservedRegion::default();
        scene.scene().environment.reserve_movers(0.0, &mut moves_itself);
        let has_own_clock =
            matches!(sim.character_groups.as_slice(), [AnyCharacterGroup::Ground(_) | AnyCharacterGroup::Air(_)]);
        if sim.character_groups.len() > 1 || !has_own_clock && !moves_itself.bodies.is_empty() {
            sim.reserved = vec![ReservedRegion::default(); sim.character_groups.len() + 1];
        }
        sim.resolve_start_conflicts()?;
        sim.step_to(0.0, &Inline)?;
        Ok(sim)
    }

    /// Advances the simulation by `dt_s` on this thread (s, 0 to 1). Allocates nothing, except for new routes of agents that
    /// learn of a happening.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for a time out of range, and [`throng_base::Error::Text`] for agents that cannot follow a happening.
    pub fn step(&mut self, dt_s: f64) -> Result<()> {
        self.step_to(self.time_s + dt_s, &Inline)
    }

    /// Advances the simulation as [`Simulation::step`] does, on threads of the caller's choice. The result is equal, bit by bit.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn step_on(&mut self, dt_s: f64, run: &dyn Executor) -> Result<()> {
        self.step_to(self.time_s + dt_s, run)
    }

    /// Advances the simulation to a time, so that clocks that count steps stay exact (s).
    ///
    /// # Errors
    /// As [`Simulation::step`]. Except for a time out of range, some characters have moved then: go on from a snapshot.
    pub fn step_to(&mut self, until_s: f64, run: &dyn Executor) -> Result<()> {
        let dt_s = until_s - self.time_s;
        STEP_S.check("dt_s", None, dt_s)?;
        if (self.time_s / RENEWS_S).floor() < (until_s / RENEWS_S).floor() {
            self.renew_orders();
        }
        self.events.clear();
        self.collect_reserved();
        self.informed_group = None;
        for c in 0..self.character_groups.len() {
            if let Some(agents) = ground_agents(&self.character_groups) {
                self.open_doors.iter_mut().enumerate().for_each(|(d, open)| *open = agents.is_open(d));
            }
            let (character_group, open_doors) = (&mut self.character_groups[c], &*self.open_doors);
            let tick = GroupStep { dt_s: dt_s as f32, until_s, first: self.firsts[c], open_doors, run };
            let begin = self.busy_s.is_some().then(Instant::now);
            inform_of_obstacles(c, character_group, &self.reserved);
            character_group.step(&tick, &mut self.events)?;
            if let Some(held) = self.reserved.get_mut(c) {
                // The regions from before the step stay, since other character groups may still rely on them.
                held.bodies.clear();
                character_group.add_reserved_regions(held);
            }
            if let (Some(busy), Some(begin)) = (&mut self.busy_s, begin) {
                busy[c] += begin.elapsed().as_secs_f64();
            }
        }
        for e in 0..self.events.len() {
            let SimulationEvent { who, kind, .. } = self.events[e];
            if kind == CharacterEvent::Left || self.is_taken_over(who) {
                self.orders[who] = None;
            }
            if let (CharacterEvent::Arrived, Some((Order { heading: Some(heading), .. }, Some(_)))) =
                (kind, self.orders[who])
            {
                let (c, number) = place_of(&self.firsts, who);
                self.character_groups[c].turn_to(number, heading)?;
            }
        }
        // Events of one character at one time are ordered by their rank.
        let key = |e: &SimulationEvent| (e.who, e.kind.rank());
        self.events.sort_unstable_by(|a, b| a.time_s.total_cmp(&b.time_s).then(key(a).cmp(&key(b))));
        self.time_s = until_s;
        Ok(())
    }

    /// Collects the current bodies and reserved regions of all character groups and moving obstacles.
    fn collect_reserved(&mut self) {
        let Some((itself, held)) = self.reserved.split_last_mut() else { return };
        for (held, character_group) in held.iter_mut().zip(&mut self.character_groups) {
            held.bodies.clear();
            held.ground.clear();
            character_group.add_reserved_regions(held);
        }
        itself.bodies.clear();
        itself.ground.clear();
        self.scene.scene().environment.reserve_movers(self.time_s, itself);
    }

    /// Restarts character groups one after the other on ground that none before has reserved, without those that give way to nobody.
    fn resolve_start_conflicts(&mut self) -> Result<()> {
        if self.reserved.is_empty() {
            return Ok(());
        }
        let mut before = Vec::new();
        // Policies can wait for room in any pose, so that they come last.
        for waits in [false, true] {
            for (c, character_group) in self.character_groups.iter_mut().enumerate() {
                let may_wait = matches!(
                    character_group,
                    AnyCharacterGroup::Policy(_) | AnyCharacterGroup::Travel(_) | AnyCharacterGroup::Sparring(_)
                );
                if may_wait != waits
                    || matches!(character_group, AnyCharacterGroup::Paths(_) | AnyCharacterGroup::Air(_))
                {
                    continue;
                }
                character_group.set_external_obstacles(before.iter());
                character_group.restart_on_free_ground();
                let (mut held, mut others) = (ReservedRegion::default(), ExternalObstacles::default());
                character_group.add_reserved_regions(&mut held);
                others.replace_all(before.iter());
                for ground in &held.ground {
                    let mut taken = false;
                    others.visit_reserved_near(&ground.bounds(), |other| {
                        taken = other.intersects(ground);
                        !taken
                    });
                    if taken {
                        let number = self.groups.iter().find(|g| g.character_group == c).map_or(0, |g| g.number);
                        let Vec2 { x, y: z } = ground.from;
                        let why = format!(
                            "somebody starts at {x:.2}, {z:.2}, on ground that one of another group needs; move its \
                             place, or enlarge the spacing"
                        );
                        return Err(self.scene.scene().fault(&format!("groups[{number}]"), why));
                    }
                }
                before.push(held);
            }
        }
        Ok(())
    }

    /// Snapshot of all that the next steps depend on: all characters with their bodies, happenings and the time, with version,
    /// checksum, and content hash of the scene, its bundles and its worlds.
    pub fn snapshot(&self) -> Vec<u8> {
        let groups = self.character_groups.iter().map(|group| saved_bytes(|out| group.save(out)));
        let mut out = Vec::new();
        self.snapshot_kind().write(&(self.time_s, &self.orders, groups.collect::<Vec<_>>()), &mut out);
        out
    }

    /// Restores a snapshot of this scene. All later steps are equal, bit by bit. Poses are valid at once,
    /// though a leg may be a centimetre off until the next step; events come with that step.
    ///
    /// # Errors
    /// [`throng_base::Error::Snapshot`] for bytes that are damaged, or of another scene, bundle or world; nothing has
    /// changed then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        let kind = self.snapshot_kind();
        let (time_s, orders, saved): (f64, Vec<GivenOrder>, Vec<Bytes>) = kind.read_all(bytes)?;
        let is_own = saved.len() == self.character_groups.len() && (0.0..1e9).contains(&time_s);
        check_snapshot(is_own, kind.what, "it has another time or other groups")?;
        let num = self.num_characters();
        let is_sound = |(who, given): (usize, &GivenOrder)| {
            given.is_none_or(|(order, goal)| order.check(who, num).is_ok() && goal.is_none_or(Vec3::is_finite))
        };
        let are_orders = orders.len() == num && orders.iter().enumerate().all(is_sound);
        check_snapshot(are_orders, kind.what, "its orders are impossible")?;
        let before = self.character_groups.clone();
        let mut both = self.character_groups.iter_mut().zip(&saved);
        if let Err(e) = both.try_for_each(|(character_group, bytes)| character_group.load(&bytes.0, time_s)) {
            self.character_groups = before;
            return Err(e);
        }
        (self.time_s, self.orders) = (time_s, orders);
        self.events.clear();
        self.informed_group = None;
        Ok(())
    }

    /// Hash of the state: differs, but for one chance in 2^64, where the motion of any character differs.
    pub fn hash(&self) -> u64 {
        let mut hash = StateHash::new(self.time_s.to_bits());
        self.character_groups.iter().for_each(|character_group| hash.add_word(character_group.hash()));
        hash.get()
    }

    fn snapshot_kind(&self) -> SnapshotKind {
        SnapshotKind { what: "simulation", tag: *b"SIMU", version: 2, setup: self.scene.hash() }
    }

    /// Scene of the simulation.
    pub fn scene(&self) -> &Scene {
        self.scene.scene()
    }

    /// Scene of the simulation, with its bundles and worlds.
    pub fn compiled(&self) -> &CompiledScene {
        &self.scene
    }

    /// Simulated time (s).
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Groups, in the order of their characters' numbers.
    pub fn groups(&self) -> &[SceneGroup] {
        &self.groups
    }

    /// Number of all characters that started.
    pub fn num_characters(&self) -> usize {
        self.groups.last().map_or(0, |g| g.characters.end)
    }

    /// Position and heading of each character; `None` for one that has left (num_characters).
    pub fn roots(&self) -> impl ExactSizeIterator<Item = Option<Planar>> + '_ {
        (0..self.num_characters()).map(|who| self.root(who))
    }

    /// Joints of each character in model space, which the roots place in the world; `None` for one that has left or has no
    /// body (num_characters).
    pub fn poses(&self) -> impl ExactSizeIterator<Item = Option<&[Mat3x4; NUM_JOINTS]>> + '_ {
        (0..self.num_characters()).map(|who| self.pose(who))
    }

    /// Events of the last step, in the order of time and of characters.
    pub fn events(&self) -> &[SimulationEvent] {
        &self.events
    }

    /// Position and heading of a character; `None` where it has left (who < num_characters).
    pub fn root(&self, who: usize) -> Option<Planar> {
        let (character_group, number) = self.locate(who);
        character_group.root(number)
    }

    /// Joints of a character in model space; `None` where it has left or has no body (who < num_characters).
    pub fn pose(&self, who: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        let (character_group, number) = self.locate(who);
        character_group.pose(number)
    }

    /// World positions of a character's joints; `None` where it has left or has no body (m, who < num_characters).
    pub fn joint_positions(&self, who: usize) -> Option<[Vec3; NUM_JOINTS]> {
        let (root, pose) = (self.root(who)?, self.pose(who)?);
        let (turn, by) = (root.rotation(), root.translation());
        Some(std::array::from_fn(|j| maths::rotate(turn, pose[j].translation()) + by))
    }

    /// Planted parts of a character's feet (who < num_characters).
    pub fn contacts(&self, who: usize) -> Contacts {
        let (character_group, number) = self.locate(who);
        character_group.contacts(number)
    }

    /// Bottom of the heel and ball of both feet, where bodies are blended (m, who < num_characters).
    pub fn soles(&self, who: usize) -> Option<[[Vec3; 2]; 2]> {
        let (character_group, number) = self.locate(who);
        character_group.soles(number)
    }

    /// Disc or ball of an agent, or of a character with policies on the way to a goal; `None` for other characters, and for those
    /// that have left (who < num_characters).
    pub fn disc(&self, who: usize) -> Option<Disc> {
        match self.locate(who) {
            (AnyCharacterGroup::Ground(agents), number) => agents.disc(number),
            (AnyCharacterGroup::Air(agents), number) => agents.disc(number),
            (AnyCharacterGroup::Travel(travellers), number) => travellers.disc(number),
            _ => None,
        }
    }

    /// Target of a character, or the expected place of its opponent's head when a blow lands (m, who < num_characters).
    pub fn target(&self, who: usize) -> Option<Vec3> {
        match self.locate(who) {
            (AnyCharacterGroup::Policy(p), number) => Some(p.practice().targets()[number].position()),
            (AnyCharacterGroup::Sparring(s), number) => Some(s.sparring().aims()[number]),
            _ => None,
        }
    }

    /// All character groups: groups of agents share one, and so do groups in the same world.
    pub fn character_groups(&self) -> &[AnyCharacterGroup] {
        &self.character_groups
    }

    /// Mutable character group, to give orders to its characters (number < number of character groups). It is informed of all
    /// current reserved regions, which actions that begin at once avoid.
    pub fn character_group_mut(&mut self, number: usize) -> &mut AnyCharacterGroup {
        if self.informed_group.replace(number) != Some(number) {
            self.collect_reserved();
            inform_of_obstacles(number, &mut self.character_groups[number], &self.reserved);
        }
        &mut self.character_groups[number]
    }

    /// Character group of a character, and its number in there (who < num_characters).
    pub fn locate(&self, who: usize) -> (&AnyCharacterGroup, usize) {
        let (character_group, number) = place_of(&self.firsts, who);
        (&self.character_groups[character_group], number)
    }

    /// Brains of the scene's agents; `None` in a scene that has only goals.
    pub fn brains(&self) -> Option<&AgentBrains> {
        self.character_groups.iter().find_map(|character_group| match character_group {
            AnyCharacterGroup::Ground(agents) => agents.brains(),
            AnyCharacterGroup::Air(agents) => agents.brains(),
            _ => None,
        })
    }

    /// Things of the scene, in its order, with their current positions.
    pub fn things(&self) -> impl Iterator<Item = SceneThing<'_>> + '_ {
        let is_ground = |group: &AnyCharacterGroup| matches!(group, AnyCharacterGroup::Ground(_));
        let first = self.character_groups.iter().position(is_ground).map_or(0, |c| self.firsts[c]);
        let agents = ground_agents(&self.character_groups).into_iter();
        let now = agents.flat_map(move |agents| agents.things().map(move |t| (t, first)));
        now.zip(&self.scene().things).map(|((thing, first), config)| SceneThing {
            name: &config.name,
            size: Vec3::from_array(config.size_m),
            at: thing.0,
            turn: thing.1,
            keeper: thing.2.map(|agent| first + agent),
        })
    }

    /// Counts of what hands have done with things so far.
    pub fn handling_counts(&self) -> HandlingCounts {
        ground_agents(&self.character_groups).map(SceneAgents::handling_counts).unwrap_or_default()
    }

    /// Gives a person an order: an agent, or a captured person on the way to a goal. What it did ends.
    ///
    /// # Errors
    /// [`Error::Index`] and [`Error::Value`] for numbers out of range, [`Error::Gone`] for who is not there, [`Error::NoPath`], and
    /// [`Error::Text`] with the group of people who take no orders; nothing has changed then.
    pub fn order(&mut self, who: usize, order: Order) -> Result<()> {
        order.check(who, self.num_characters())?;
        let whom = order.whom().filter(|whom| self.root(*whom).is_none());
        whom.map_or(Ok(()), |whom| Err(Error::Gone(Id::first(whom))))?;
        let before = self.orders[who].and_then(|(old, _)| old.speed_mps);
        let order = order.speed_mps.or(before).map_or(order, |speed| order.at_speed(speed));
        let goal = self.give_order(who, order)?;
        self.orders[who] = Some((order, goal));
        Ok(())
    }

    /// Lets a person act by an order, and returns its goal.
    fn give_order(&mut self, who: usize, order: Order) -> Result<Option<Vec3>> {
        let (c, number) = place_of(&self.firsts, who);
        self.root(who).ok_or(Error::Gone(Id::first(who)))?;
        let own = self.disc(who).ok_or_else(|| self.refusal(who, NO_ORDERS))?;
        let other = order.whom().and_then(|whom| self.floor_position(whom));
        let (goals, arrival_m) = order.goals(&own, other);
        let mut given = Ok(());
        for goal in goals.into_iter().flatten() {
            given = self.character_groups[c].order(number, Some((goal, arrival_m)), &order);
            if given.is_ok() {
                return Ok(Some(goal));
            }
        }
        if order.is_steered() && matches!(given, Err(Error::NoPath { .. })) {
            // A wall is at hand: it stands at it.
            given = Ok(());
        }
        given.and_then(|()| self.character_groups[c].order(number, None, &order.facing(&own, other))).map(|()| None)
    }

    /// Gives orders again whose goals have moved; who cannot get there any more goes on as before.
    fn renew_orders(&mut self) {
        for who in 0..self.orders.len() {
            if self.is_taken_over(who) {
                self.orders[who] = None;
            }
            let Some((order, before)) = self.orders[who].filter(|(order, _)| order.is_renewed()) else { continue };
            let Some(own) = self.root(who).and(self.disc(who)) else { continue };
            let (goals, _) = order.goals(&own, order.whom().and_then(|whom| self.floor_position(whom)));
            let is_same = match (goals[0], before) {
                (Some(now), Some(before)) => now.distance(before) < MOVED_M,
                (now, before) => now.is_none() && before.is_none(),
            };
            if !is_same && let Ok(goal) = self.give_order(who, order) {
                self.orders[who] = Some((order, goal));
            }
        }
    }

    /// True where a rule has taken the place of an order.
    fn is_taken_over(&self, who: usize) -> bool {
        self.orders[who].is_some() && self.brain_of(who).is_some_and(|(brains, number)| brains.acts(number))
    }

    /// Position of a person on its floor; none where it has left (m).
    fn floor_position(&self, who: usize) -> Option<Vec3> {
        let root = self.root(who)?;
        Some(self.disc(who).map_or(root.translation(), |disc| disc.centre))
    }

    /// Error for a person of whom something is asked that its group cannot do.
    fn refusal(&self, who: usize, why: &str) -> Error {
        let group = self.groups.iter().find(|g| g.characters.contains(&who)).map_or(0, |g| g.number);
        self.scene().fault(&format!("groups[{group}]"), why)
    }

    /// Raises an event of the scene now.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the names of all events.
    pub fn raise_event(&mut self, event: &str) -> Result<()> {
        let is_of_agents =
            |group: &AnyCharacterGroup| matches!(group, AnyCharacterGroup::Ground(_) | AnyCharacterGroup::Air(_));
        match self.character_groups.iter().position(is_of_agents) {
            Some(c) => self.change_brain(self.firsts[c], BrainChange::Event(event)),
            None => Err(Error::Unknown { what: "event", name: event.into(), known: Vec::new() }),
        }
    }

    /// Raises an event for one agent alone, which learns of it.
    ///
    /// # Errors
    /// As [`Simulation::raise_event`]; [`Error::Index`], [`Error::Gone`], and [`Error::Text`] for who has no brain.
    pub fn raise_event_for(&mut self, who: usize, event: &str) -> Result<()> {
        self.change_brain(who, BrainChange::Learn(event))
    }

    /// Sets a value of an agent, within the limits of the scene.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the names of all values; else as [`Simulation::raise_event_for`].
    pub fn set_value(&mut self, who: usize, name: &str, value: f32) -> Result<()> {
        check_value("value", Some(Id::first(who)), value, value.is_finite(), "a finite number")?;
        self.change_brain(who, BrainChange::Value(name, value))
    }

    /// States and values of an agent, what it does and why.
    ///
    /// # Errors
    /// [`Error::Index`], and [`Error::Text`] for who has no brain.
    pub fn explain(&self, who: usize) -> Result<Explanation> {
        check_index("person", None, who, self.num_characters())?;
        let own = self.brain_of(who).ok_or_else(|| self.refusal(who, NO_BRAIN))?;
        Ok(own.0.explain(own.1, self.time_s))
    }

    /// Brains that have that of a character, and its number among them.
    fn brain_of(&self, who: usize) -> Option<(&AgentBrains, usize)> {
        let (group, number) = self.locate(who);
        let brains = match group {
            AnyCharacterGroup::Ground(agents) => agents.brains(),
            AnyCharacterGroup::Air(agents) => agents.brains(),
            _ => None,
        };
        Some((brains?, number))
    }

    fn change_brain(&mut self, who: usize, change: BrainChange<'_>) -> Result<()> {
        check_index("person", None, who, self.num_characters())?;
        let (c, number) = place_of(&self.firsts, who);
        match &mut self.character_groups[c] {
            AnyCharacterGroup::Ground(agents) => agents.change_brain(number, change),
            AnyCharacterGroup::Air(agents) => agents.change_brain(number, change),
            _ => Err(self.refusal(who, NO_BRAIN)),
        }
    }

    /// True once the scene has ended.
    pub fn has_ended(&self) -> bool {
        self.brains().is_some_and(AgentBrains::has_ended)
    }

    /// Starts to measure the computing times of character groups.
    pub fn set_timed(&mut self) {
        self.busy_s = Some(vec![0.0; self.character_groups.len()]);
        for character_group in &mut self.character_groups {
            match character_group {
                AnyCharacterGroup::Ground(agents) => agents.set_timed(),
                AnyCharacterGroup::Air(agents) => agents.set_timed(),
                _ => {}
            }
        }
    }

    /// Computing time of each character group since [`Simulation::set_timed`]; empty before (s).
    pub fn busy_s(&self) -> &[f64] {
        self.busy_s.as_deref().unwrap_or_default()
    }
}

/// Number of the character group of a character, and its number in there.
fn place_of(firsts: &[usize], who: usize) -> (usize, usize) {
    let character_group = firsts.partition_point(|&f| f <= who) - 1;
    (character_group, who - firsts[character_group])
}

/// The agents on the ground, where there are any.
fn ground_agents(groups: &[AnyCharacterGroup]) -> Option<&SceneAgents<Vec2>> {
    groups.iter().find_map(|group| if let AnyCharacterGroup::Ground(agents) = group { Some(agents) } else { None })
}

/// Informs a character group of the bodies and reserved regions of all others, where there are any.
fn inform_of_obstacles(number: usize, character_group: &mut AnyCharacterGroup, held: &[ReservedRegion]) {
    // Agents know moving obstacles, the last element, from their crowd.
    let knows = matches!(character_group, AnyCharacterGroup::Ground(_) | AnyCharacterGroup::Air(_));
    let others = &held[..held.len().saturating_sub(usize::from(knows))];
    if !held.is_empty() {
        let of_others = others.iter().enumerate().filter(|(o, _)| *o != number);
        character_group.set_external_obstacles(of_others.map(|(_, held)| held));
    }
}

/// Creates the character group of groups that are moved together.
fn make_character_group(scene: &CompiledScene, groups: &[usize]) -> Result<AnyCharacterGroup> {
    let group = &scene.scene().groups[groups[0]];
    Ok(match group.motion {
        GroupMotion::Policy if group.goal.is_some() => AnyCharacterGroup::Travel(Travellers::new(scene, groups)?),
        GroupMotion::Policy => AnyCharacterGroup::Policy(Practice::new(scene, groups[0])?),
        GroupMotion::Sparring => AnyCharacterGroup::Sparring(Bouts::new(scene, groups[0])?),
        GroupMotion::Patches => AnyCharacterGroup::Patches(InhabitantGroup::new(scene, groups)?),
        GroupMotion::Blend if group.paths.is_some() => AnyCharacterGroup::Paths(Wanderers::new(scene, groups[0])?),
        GroupMotion::Blend | GroupMotion::None => match scene.scene().environment.space {
            SpaceConfig::Ground => AnyCharacterGroup::Ground(SceneAgents::new(scene)?),
            SpaceConfig::Air => AnyCharacterGroup::Air(SceneAgents::new(scene)?),
        },
    })
}
