//! Boxers that each strike at a target of their own.

use super::config::check_within;
use super::snapshot::{self, boxers_group_methods, boxers_methods};
use super::tally::{BlowOutcome, BlowTally};
use super::target::{StruckTarget, TargetConfig};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::{Executor, Hash128, Id, Result, SnapshotKind, error::check_value};
use throng_core::characters::{Blow, Characters, CharactersConfig, MAX_BLOWS, PolicyCharacters, PolicyOrder, Spawn};
use throng_core::{AdoptReport, Bundle, CharacterGroup, OrderStatus, Planar, PosedBodies};

/// Settings of striking at targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PracticeConfig {
    /// Settings of the characters' motion.
    pub characters: CharactersConfig,
    /// Settings of the targets.
    pub target: TargetConfig,
    /// Distance from a target at which a blow hits it (m, 0 to 1).
    pub reach_m: f32,
}

impl Default for PracticeConfig {
    fn default() -> Self {
        Self { characters: CharactersConfig::default(), target: TargetConfig::default(), reach_m: 0.08 }
    }
}

/// Blow that hit a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetHit {
    /// The blow.
    pub blow: Blow,
    /// Depth of the striking point within reach (m, >= 0).
    pub depth_m: f32,
}

/// Figures of all boxers so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PracticeFigures {
    /// Simulated time (s).
    pub seconds: f64,
    /// Blows of all characters.
    pub blows: BlowTally,
}

/// Boxers with a target each, which hangs where the order says; a boxer without an order has no target.
///
/// A step aims every behaviour at the target, moves the characters, tests which blows come near enough, and swings the hit
/// targets out in the direction of the blow. All memory is allocated in [`TargetPractice::with_capacity`], except for
/// loading and adopting.
///
/// ```no_run
/// use throng_core::characters::Spawn;
/// use throng_core::{Bundle, CharacterGroup, Inline, Planar, glam::Vec3};
/// use throng_simulation::sparring::{PracticeConfig, TargetPractice};
///
/// let bundle = Bundle::open("boxing.throng")?;
/// let mut boxers = TargetPractice::with_capacity(&bundle, 1, PracticeConfig::default())?;
/// let id = boxers.spawn(Spawn::standing_at(Planar::IDENTITY))?;
/// boxers.order(id, bundle.policy("throw-punches")?.order_towards(Vec3::new(0.0, 1.5, 0.8)))?;
/// boxers.step(1.0 / 60.0, &Inline)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TargetPractice {
    config: PracticeConfig,
    boxers: PolicyCharacters,
    state: PracticeState,
    events: Vec<(Id, TargetHit)>,
}

/// State that the next steps depend on, beside the characters.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct PracticeState {
    pub targets: Vec<StruckTarget>,
    /// Positions of targets (m).
    pub positions: Vec<Vec3>,
    pub tallies: Vec<BlowTally>,
    pub seconds: f64,
}

impl TargetPractice {
    /// Empty practice with room for so many boxers.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for a setting out of its range, and as [`PolicyCharacters::with_capacity`].
    pub fn with_capacity(bundle: &Bundle, capacity: usize, config: PracticeConfig) -> Result<Self> {
        config.target.check()?;
        check_within("reach_m", config.reach_m, 0.0, 1.0, "between 0 and 1")?;
        let boxers = PolicyCharacters::with_capacity(bundle, capacity, config.characters)?;
        let (targets, positions) = (Vec::with_capacity(capacity), Vec::with_capacity(capacity));
        let state = PracticeState { targets, positions, tallies: Vec::with_capacity(capacity), seconds: 0.0 };
        let events = Vec::with_capacity(if bundle.hits().is_empty() { 0 } else { capacity * MAX_BLOWS });
        Ok(Self { config, boxers, state, events })
    }

    /// Settings.
    pub fn config(&self) -> &PracticeConfig {
        &self.config
    }

    /// The targets, row by row.
    pub fn targets(&self) -> &[StruckTarget] {
        &self.state.targets
    }

    /// Order of a character, around the place where its target hangs.
    ///
    /// # Errors
    /// [`throng_base::Error::Gone`].
    pub fn order_of(&self, id: Id) -> Result<PolicyOrder> {
        Ok(self.boxers.order_of(id)?.with_target(self.state.targets[self.boxers.row(id)?].home))
    }

    /// Figures so far, of all boxers that are there.
    pub fn figures(&self) -> PracticeFigures {
        let mut f = PracticeFigures { seconds: self.state.seconds, ..PracticeFigures::default() };
        self.state.tallies.iter().for_each(|t| f.blows += *t);
        f
    }

    /// Advances all targets, and strikes those that blows reach.
    fn strike_targets(&mut self, dt_s: f32) -> Result<()> {
        let (s, config) = (&mut self.state, &self.config);
        s.seconds += f64::from(dt_s);
        s.targets.iter_mut().for_each(|t| t.step(&config.target, dt_s));
        self.events.clear();
        for &blow in self.boxers.characters().blows() {
            let c = blow.character as usize;
            let id = self.boxers.ids()[c];
            let distance = s.targets[c].position().distance(blow.point);
            let depth_m = config.target.radius_m + config.reach_m - distance;
            let is_hit = depth_m >= 0.0 && !self.boxers.order_of(id)?.policies().is_empty();
            if is_hit {
                s.targets[c].strike(&config.target, blow.direction, blow.speed_mps);
                self.events.push((id, TargetHit { blow, depth_m }));
            }
            s.tallies[c].count_blow(if is_hit { BlowOutcome::Landed } else { BlowOutcome::Missed });
        }
        s.positions.iter_mut().zip(&s.targets).for_each(|(position, target)| *position = target.position());
        Ok(())
    }

    fn snapshot_kind(&self) -> SnapshotKind {
        let setup = Hash128::hash_bytes(format!("{:?}", (self.config.target, self.config.reach_m)).as_bytes());
        SnapshotKind { what: "target practice", tag: *b"PRAC", version: 2, setup }
    }
}

boxers_methods!(TargetPractice);

impl CharacterGroup for TargetPractice {
    boxers_group_methods!();

    type Start = Spawn;
    /// Behaviours and their weights, around the place where the target hangs; the target follows at once.
    type Order = PolicyOrder;
    /// A blow that hit the target.
    type Event = TargetHit;

    fn spawn(&mut self, start: Spawn) -> Result<Id> {
        let id = self.boxers.spawn(start)?;
        self.state.targets.push(StruckTarget::default());
        self.state.positions.push(Vec3::ZERO);
        self.state.tallies.push(BlowTally::default());
        Ok(id)
    }

    /// Removes a boxer. The last one takes its row in [`CharacterGroup::bodies`].
    fn despawn(&mut self, id: Id) -> Result<()> {
        let row = self.boxers.row(id)?;
        self.boxers.despawn(id)?;
        self.state.targets.swap_remove(row);
        self.state.positions.swap_remove(row);
        self.state.tallies.swap_remove(row);
        Ok(())
    }

    fn place(&mut self, id: Id, root: Planar) -> Result<()> {
        self.boxers.place(id, root)
    }

    fn order(&mut self, id: Id, order: PolicyOrder) -> Result<()> {
        let (row, home) = (self.boxers.row(id)?, order.target());
        let largest = if home.is_nan() { f32::NAN } else { home.abs().max_element() };
        check_value("target", Some(id), largest, largest <= 1e5, "finite coordinates up to 1e5 (m)")?;
        self.boxers.order(id, order)?;
        let target = &mut self.state.targets[row];
        target.home = home;
        self.state.positions[row] = target.position();
        Ok(())
    }

    fn step(&mut self, dt_s: f32, run: &dyn Executor) -> Result<()> {
        self.boxers.aim_all(&self.state.positions, &self.state.positions)?;
        self.boxers.step(dt_s, run)?;
        self.strike_targets(dt_s)
    }

    fn adopt(&mut self, new: &Bundle) -> Result<AdoptReport> {
        self.boxers.adopt(new)
    }
}
