//! Pairs of characters of one bundle.

use super::body::{SparringBody, StruckPart, WorldPose};
use super::config::{NO_THREAT_S, SparringConfig};
use super::landing::{BlowLanding, find_struck_capsule};
use super::snapshot::{self, boxers_group_methods, boxers_methods};
use super::tally::{BlowOutcome, BlowTally};
use super::{pair::OpponentPair, stagger::StepsAway};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::{Error, Executor, Id, Result, SnapshotKind, maths, run_each};
use throng_core::characters::{
    Blow, Characters, MAX_BLOWS, MotionSet, PolicyCharacters, PolicyOrder, SampleJob, Spawn, TravelPoints,
};
use throng_core::{AdoptReport, Bundle, CharacterGroup, Joint, Mat3x4, NUM_JOINTS, OrderStatus, Planar, PosedBodies};

/// Pairs of characters that spar: those in rows 2i and 2i + 1 are opponents.
///
/// A step aims every behaviour at the opponent, moves the characters, tests which blows land on which part of the
/// opponent's body, pushes that part in the direction of the blow, and moves bodies apart that overlap. All memory is
/// allocated in [`Sparring::with_capacity`], but for loading and adopting.
///
/// ```no_run
/// use throng_core::characters::Spawn;
/// use throng_core::{Bundle, CharacterGroup, Inline, Planar, glam::Vec3};
/// use throng_simulation::sparring::{Sparring, SparringConfig};
///
/// let bundle = Bundle::open("boxing.throng")?;
/// let mut bout = Sparring::with_capacity(&bundle, 1, SparringConfig::default())?;
/// let roots = [Planar::IDENTITY, Planar::new(0.0, 0.9, std::f32::consts::PI)];
/// let first = bout.spawn(roots.map(Spawn::standing_at))?;
/// bout.order(first, bundle.policy("throw-punches")?.order_towards(Vec3::ZERO))?;
/// bout.step(1.0 / 60.0, &Inline)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sparring {
    config: SparringConfig,
    body: SparringBody,
    boxers: PolicyCharacters,
    state: SparringState,
    events: Vec<(Id, BlowLanding)>,
    /// Heads of the last step, for each character; they save work and change no result.
    travels: Vec<TravelPoints>,
    /// Time from a choice to its first blow (s).
    pub(super) lead_s: f32,
    steps_away: StepsAway,
}

/// State that the next steps depend on, beside the characters.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SparringState {
    /// Position of the opponent's head, for each character (m).
    pub heads: Vec<Vec3>,
    /// Expected position of that head when a blow that is chosen now lands, for each character (m).
    pub aims: Vec<Vec3>,
    /// Opponent's next blow, for each character: x, seconds, z.
    pub threats: Vec<Vec3>,
    pub pairs: Vec<OpponentPair>,
    pub tallies: Vec<BlowTally>,
    pub seconds: f64,
}

/// Figures of all pairs so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SparringFigures {
    /// Simulated time (s).
    pub seconds: f64,
    /// Blows of all characters.
    pub blows: BlowTally,
    /// Deepest overlap of two opponents' heads, necks, trunks and pelvises now (m).
    pub penetration_m: f32,
    /// Deepest overlap so far (m).
    pub max_penetration_m: f32,
    /// Time during which overlaps were deeper than [`super::SeparationConfig::deep_m`], summed over pairs (s).
    pub deep_s: f32,
}

impl Sparring {
    /// Empty bout with room for so many pairs.
    ///
    /// # Errors
    /// [`Error::Value`] for a setting out of its range, and as [`PolicyCharacters::with_capacity`].
    pub fn with_capacity(bundle: &Bundle, num_pairs: usize, config: SparringConfig) -> Result<Self> {
        config.check()?;
        let n = num_pairs.saturating_mul(2);
        let mut boxers = PolicyCharacters::with_capacity(bundle, n, config.characters)?;
        let state = SparringState {
            heads: Vec::with_capacity(n),
            aims: Vec::with_capacity(n),
            threats: Vec::with_capacity(n),
            pairs: Vec::with_capacity(num_pairs),
            tallies: Vec::with_capacity(n),
            seconds: 0.0,
        };
        let events = Vec::with_capacity(if bundle.hits().is_empty() { 0 } else { n * MAX_BLOWS });
        let lead_s = usual_lead_s(boxers.motion_set());
        let body = SparringBody::new(bundle.skeleton(), &config.body);
        boxers.set_partner_touch(body.volume().clone(), config.touch)?;
        let steps_away = StepsAway::new(boxers.motion_set())?;
        let travels = Vec::with_capacity(n);
        Ok(Self { body, config, boxers, state, events, travels, lead_s, steps_away })
    }

    /// Settings.
    pub fn config(&self) -> &SparringConfig {
        &self.config
    }

    /// The capsules that blows are tested against.
    pub fn body(&self) -> &SparringBody {
        &self.body
    }

    /// Number of pairs.
    pub fn num_pairs(&self) -> usize {
        self.state.pairs.len()
    }

    /// Opponent of a character.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn opponent(&self, id: Id) -> Result<Id> {
        Ok(self.boxers.ids()[self.boxers.row(id)? ^ 1])
    }

    /// Order of a character, with the targets of the last step.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn order_of(&self, id: Id) -> Result<PolicyOrder> {
        Ok(*self.boxers.order_of(id)?)
    }

    /// Position of the opponent's head, for each character (m, row by row).
    pub fn heads(&self) -> &[Vec3] {
        &self.state.heads
    }

    /// Expected position of the opponent's head when a blow that is chosen now lands, as far as the opponent's action is known;
    /// the target of behaviours about a place (m, row by row).
    pub fn aims(&self) -> &[Vec3] {
        &self.state.aims
    }

    /// Opponent's next blow, for each character, the target of behaviours on space-time grids: x and z of the place, y the
    /// seconds until then, or [`NO_THREAT_S`] where no blow is coming (m, s, m, row by row).
    pub fn threats(&self) -> &[Vec3] {
        &self.state.threats
    }

    /// Deepest overlap of a pair's bodies at the last step; 0 where they are apart (m, pair < num_pairs).
    pub fn overlap_m(&self, pair: usize) -> f32 {
        self.state.pairs[pair].overlap_m
    }

    /// Figures so far, of all pairs that are there.
    pub fn figures(&self) -> SparringFigures {
        let mut f = SparringFigures { seconds: self.state.seconds, ..SparringFigures::default() };
        self.state.tallies.iter().for_each(|t| f.blows += *t);
        for p in &self.state.pairs {
            f.penetration_m = f.penetration_m.max(p.overlap_m);
            f.max_penetration_m = f.max_penetration_m.max(p.max_overlap_m);
            f.deep_s += p.deep_s;
        }
        f
    }

    /// Applies blows and separates bodies, after all pairs have been observed.
    fn resolve_blows(&mut self, dt_s: f32) -> Result<()> {
        self.state.seconds += f64::from(dt_s);
        self.events.clear();
        for i in 0..self.boxers.characters().blows().len() {
            let blow = self.boxers.characters().blows()[i];
            let id = self.boxers.ids()[blow.character as usize];
            let landing = self.find_landing(blow);
            self.state.tallies[blow.character as usize].count_blow(match &landing {
                Some(l) if l.is_blocked() => BlowOutcome::Blocked,
                Some(_) => BlowOutcome::Landed,
                None => BlowOutcome::Missed,
            });
            if let Some(landing) = landing {
                let length_m = (blow.speed_mps * self.config.push_m_per_mps).min(FARTHEST_PUSH_M);
                let displacement = blow.direction * length_m;
                self.boxers.push(landing.opponent, landing.joint, displacement)?;
                self.events.push((id, landing));
                self.step_away(&landing)?;
            }
        }
        for (i, pair) in self.state.pairs.iter().enumerate() {
            let heads = [self.state.heads[2 * i + 1], self.state.heads[2 * i]];
            if let Some(by) = self.config.separation.lean_displacement(heads, dt_s) {
                self.boxers.push(self.boxers.ids()[2 * i], Joint::Head, -by)?;
                self.boxers.push(self.boxers.ids()[2 * i + 1], Joint::Head, by)?;
            }
            for (k, by) in pair.parting_displacements(dt_s).into_iter().flatten().enumerate() {
                self.boxers.shift_by(self.boxers.ids()[2 * i + k], by)?;
            }
        }
        Ok(())
    }

    /// Makes a character that is struck hard step away, where the ground is free.
    fn step_away(&mut self, landing: &BlowLanding) -> Result<()> {
        let (blow, config) = (&landing.blow, &self.config.stagger);
        if blow.force < config.force || matches!(landing.part, StruckPart::Pelvis | StruckPart::Arm | StruckPart::Leg) {
            return Ok(());
        }
        let (c, characters) = (self.boxers.row(landing.opponent)?, self.boxers.characters());
        let step = self.steps_away.best_step(config, characters.pose(c), characters.root(c), blow);
        match step.map(|segment| self.boxers.play_segment(landing.opponent, segment)) {
            None | Some(Err(Error::Occupied { .. })) => Ok(()),
            Some(played) => played,
        }
    }

    /// Finds where a blow meets the opponent; `None` where it misses.
    fn find_landing(&self, blow: Blow) -> Option<BlowLanding> {
        let (c, characters) = (blow.character as usize ^ 1, self.characters());
        let pose = WorldPose::new(characters.pose(c), characters.root(c));
        let (capsule, depth_m) = find_struck_capsule(&self.config, &self.body, &pose, &blow)?;
        let (part, joint) = (self.body.part_of(capsule), self.body.joint_of(capsule));
        Some(BlowLanding { blow, opponent: self.boxers.ids()[c], part, joint, depth_m })
    }

    /// Positions of the heads of a pair as it enters (m).
    fn start_heads(&self, pair: [Spawn; 2]) -> Result<[Vec3; 2]> {
        let motion_set = self.boxers.motion_set();
        let state = |start: Spawn| start.state.unwrap_or_else(|| self.boxers.standing_state());
        let frames = pair.map(|start| motion_set.graph().states[state(start) as usize].frame);
        let mut poses = [[Mat3x4::default(); NUM_JOINTS]; 2];
        SampleJob { motion_set, frames: &frames, ratios: &[0.0; 2], matrices: poses.as_flattened_mut() }.run()?;
        Ok([0, 1].map(|k| self.body.head_position(&WorldPose::new(&poses[k], pair[k].root))))
    }

    fn snapshot_kind(&self) -> SnapshotKind {
        SnapshotKind { what: "sparring", tag: *b"SPAR", version: 6, setup: self.config.hash() }
    }
}

boxers_methods!(Sparring);

impl CharacterGroup for Sparring {
    boxers_group_methods!();

    /// A pair enters together.
    type Start = [Spawn; 2];
    /// Behaviours and their weights; their targets are set at every step.
    type Order = PolicyOrder;
    /// A blow that met the opponent, or was blocked.
    type Event = BlowLanding;

    /// Adds a pair and returns the id of the first; [`Sparring::opponent`] gives that of the second.
    fn spawn(&mut self, pair: [Spawn; 2]) -> Result<Id> {
        if self.boxers.ids().len() + 2 > self.boxers.capacity() {
            return Err(Error::Full { capacity: self.boxers.capacity() });
        }
        let first = self.boxers.spawn(pair[0])?;
        if let Err(e) = self.boxers.spawn(pair[1]) {
            self.boxers.despawn(first)?;
            return Err(e);
        }
        let [own, other] = self.start_heads(pair)?;
        self.state.heads.extend([other, own]);
        self.state.aims.extend([other, own]);
        self.state.threats.extend([NO_THREAT; 2]);
        self.state.pairs.push(OpponentPair::default());
        self.state.tallies.extend([BlowTally::default(); 2]);
        Ok(first)
    }

    /// Removes a character and its opponent. The last pair takes their rows in [`CharacterGroup::bodies`].
    fn despawn(&mut self, id: Id) -> Result<()> {
        let first = self.boxers.row(id)? & !1;
        for row in [first + 1, first] {
            self.boxers.despawn(self.boxers.ids()[row])?;
            self.state.heads.swap_remove(row);
            self.state.aims.swap_remove(row);
            self.state.threats.swap_remove(row);
            self.state.tallies.swap_remove(row);
        }
        self.state.pairs.swap_remove(first / 2);
        Ok(())
    }

    /// Moves one of a pair alone: its opponent comes after it.
    fn place(&mut self, id: Id, root: Planar) -> Result<()> {
        let row = self.boxers.row(id)?;
        let old = self.characters().root(row);
        self.boxers.place(id, root)?;
        let turn = maths::rotation_y(root.heading - old.heading);
        for at in [&mut self.state.heads[row ^ 1], &mut self.state.aims[row ^ 1]] {
            *at = maths::rotate(turn, *at - old.translation()) + root.translation();
        }
        Ok(())
    }

    fn order(&mut self, id: Id, order: PolicyOrder) -> Result<()> {
        self.boxers.order(id, order)
    }

    fn step(&mut self, dt_s: f32, run: &dyn Executor) -> Result<()> {
        self.boxers.aim_all(&self.state.aims, &self.state.threats)?;
        self.boxers.step(dt_s, run)?;
        let (s, body, config, lead_s) = (&mut self.state, &self.body, &self.config, self.lead_s);
        let (characters, motion_set) = (self.boxers.characters(), self.boxers.motion_set());
        self.travels.resize(s.heads.len(), TravelPoints::default());
        let places = s.heads.chunks_mut(2 * PART).zip(s.aims.chunks_mut(2 * PART));
        let ahead = s.threats.chunks_mut(2 * PART).zip(self.travels.chunks_mut(2 * PART));
        let parts = s.pairs.chunks_mut(PART).zip(places).zip(ahead);
        // Heads, coming blows and overlap of each pair in the new poses.
        run_each(run, parts.enumerate(), |(part, ((pairs, (heads, aims)), (threats, travels)))| {
            let places = heads.chunks_exact_mut(2).zip(aims.chunks_exact_mut(2));
            let ahead = threats.chunks_exact_mut(2).zip(travels.chunks_exact_mut(2));
            let of_pair = pairs.iter_mut().zip(places).zip(ahead);
            for (i, ((pair, (heads, aims)), (threats, travels))) in of_pair.enumerate() {
                let rows = [0, 1].map(|k| 2 * (part * PART + i) + k);
                let poses = rows.map(|c| WorldPose::new(characters.pose(c), characters.root(c)));
                for (k, opponent) in [1, 0].into_iter().enumerate() {
                    let (character, centre, known) = (rows[opponent], body.head_centre(), &mut travels[k]);
                    heads[k] = body.head_position(&poses[opponent]);
                    let travel = characters.travel_of_point(motion_set, character, Joint::Head, centre, lead_s, known);
                    aims[k] = heads[k] + travel;
                    let next = characters.next_blow(motion_set, character);
                    threats[k] = next.map_or(NO_THREAT, |(b, due_s)| Vec3::new(b.point.x, due_s, b.point.z));
                }
                let contacts = rows.map(|c| characters.contacts(c));
                pair.measure_overlap(body, [&poses[0], &poses[1]], contacts, &config.separation, dt_s);
            }
        });
        self.resolve_blows(dt_s)
    }

    fn adopt(&mut self, new: &Bundle) -> Result<AdoptReport> {
        let adopted = self.boxers.adopt(new)?;
        self.travels.clear();
        self.body = SparringBody::new(new.skeleton(), &self.config.body);
        self.boxers.set_partner_touch(self.body.volume().clone(), self.config.touch)?;
        self.lead_s = usual_lead_s(self.boxers.motion_set());
        self.steps_away = StepsAway::new(self.boxers.motion_set())?;
        Ok(adopted)
    }
}

/// Largest displacement by a blow (m).
const FARTHEST_PUSH_M: f32 = 0.14;

/// Number of pairs in one part of a step.
const PART: usize = 64;

/// Threat of an opponent that has no blow under way.
const NO_THREAT: Vec3 = Vec3::new(0.0, NO_THREAT_S, 0.0);

/// Median time from the start of a segment to its first blow; 0 where there is none (s).
fn usual_lead_s(motion_set: &MotionSet) -> f32 {
    let starts = motion_set.graph().segments.iter().map(|s| s.start);
    let to_first = |(i, start): (usize, u32)| {
        motion_set.hits_of(i as u32).next().map(|hit| motion_set.hits()[hit as usize].frame - start)
    };
    let mut frames: Vec<u32> = starts.enumerate().filter_map(to_first).collect();
    frames.sort_unstable();
    frames.get(frames.len() / 2).map_or(0.0, |&f| f as f32 / motion_set.rate_hz)
}
