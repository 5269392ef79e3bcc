//! Boxers who each strike at a target of their own.

use super::config::within;
use super::goals::{self, Goals};
use super::tally::{Outcome, Tally};
use super::target::{StruckTarget, TargetConfig};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::error::{check_index, check_length};
use throng_base::{Hash128, Inline, Result, Run};
use throng_core::characters::{Blow, Characters, CharactersConfig, MAX_BLOWS, MotionSet, Start};

/// A behaviour that all characters weigh, about their target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PracticeGoal {
    /// Number of the policy.
    pub policy: usize,
    /// What its values count in the sum over goals; 0 switches it off.
    pub weight: f32,
}

/// How characters strike at targets.
#[derive(Clone, Debug, PartialEq)]
pub struct PracticeConfig {
    /// How the characters move.
    pub characters: CharactersConfig,
    /// Behaviours (1 to MAX_GOALS).
    pub goals: Vec<PracticeGoal>,
    /// How targets move.
    pub target: TargetConfig,
    /// How near to a target a blow must come to hit it (m, 0 to 1).
    pub reach_m: f32,
}

impl PracticeConfig {
    /// Towards goals, everything else as it is by default.
    pub fn new(goals: Vec<PracticeGoal>) -> Self {
        Self { goals, ..Self::default() }
    }

    /// Content hash, but for weights.
    fn hash(&self) -> u128 {
        let goals: Vec<usize> = self.goals.iter().map(|g| g.policy).collect();
        Hash128::of(format!("{:?}", (self.characters, goals, self.target, self.reach_m)).as_bytes())
    }
}

impl Default for PracticeConfig {
    /// Without goals, which [`PracticeConfig::new`] takes.
    fn default() -> Self {
        let (characters, target) = (CharactersConfig::default(), TargetConfig::default());
        Self { characters, goals: Vec::new(), target, reach_m: 0.08 }
    }
}

/// A blow that hit a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetHit {
    /// The blow.
    pub blow: Blow,
    /// How far the striking point is within reach (m, >= 0).
    pub depth_m: f32,
}

/// What has happened so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PracticeFigures {
    /// Simulated time (s).
    pub seconds: f64,
    /// Blows of all characters.
    pub blows: Tally,
}

/// Boxers with a target each. All memory is allocated in [`TargetPractice::new`].
///
/// A step aims every behaviour at the target, moves the characters, tests which blows come near enough, and lets what is
/// hit swing out in the direction of the blow.
#[derive(Clone, Debug)]
pub struct TargetPractice {
    pub(super) config: PracticeConfig,
    pub(super) characters: Characters,
    pub(super) state: State,
    hits: Vec<TargetHit>,
    pub(super) num_hits: usize,
    /// Content hash of how they strike, but for weights.
    pub(super) setup: u128,
}

/// What the next steps depend on, beside the characters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct State {
    pub targets: Vec<StruckTarget>,
    /// Where targets are (m).
    pub positions: Vec<Vec3>,
    pub tallies: Vec<Tally>,
    pub seconds: f64,
}

impl TargetPractice {
    /// Puts characters at their starts and hangs up their targets.
    ///
    /// - `homes`: where targets hang (m, starts.len()).
    ///
    /// # Errors
    /// [`Error::Length`] where homes do not fit, [`Error::Index`] for a policy that does not
    /// exist, [`Error::Value`] for a number out of its range, and as [`Characters::new`].
    pub fn new(motion_set: &MotionSet, config: PracticeConfig, starts: &[Start], homes: &[Vec3]) -> Result<Self> {
        check_length("homes", homes.len(), starts.len())?;
        goals::check(motion_set, config.goals.iter().map(|g| (g.policy, g.weight)))?;
        config.target.check()?;
        within("reach_m", config.reach_m, 0.0, 1.0, "between 0 and 1")?;
        homes.iter().try_for_each(|&h| check_home(h))?;
        let characters = Characters::new(motion_set, config.characters, starts)?;
        let room = if motion_set.hits().is_empty() { 0 } else { starts.len() * MAX_BLOWS };
        let state = State {
            targets: homes.iter().map(|&home| StruckTarget::new(home)).collect(),
            positions: homes.to_vec(),
            tallies: vec![Tally::default(); starts.len()],
            seconds: 0.0,
        };
        let none = TargetHit { blow: Blow::NONE, depth_m: 0.0 };
        Ok(Self { setup: config.hash(), config, characters, state, hits: vec![none; room], num_hits: 0 })
    }

    /// Moves all boxers and targets on by `dt_s` on this thread. Allocates nothing.
    ///
    /// # Errors
    /// As [`Characters::step`].
    pub fn step(&mut self, motion_set: &MotionSet, dt_s: f32) -> Result<()> {
        self.step_on(motion_set, dt_s, &Inline)
    }

    /// As [`TargetPractice::step`], on threads of the caller's choice. The result is the same, bit by bit.
    ///
    /// # Errors
    /// As [`Characters::step`].
    pub fn step_on(&mut self, motion_set: &MotionSet, dt_s: f32, run: &dyn Run) -> Result<()> {
        self.characters.step_on(motion_set, dt_s, goals_of(&self.config, &self.state).get(), run)?;
        self.strike(dt_s);
        Ok(())
    }

    /// Moves the home of a target; the target follows at once.
    ///
    /// # Errors
    /// [`Error::Index`] for a character that does not exist, [`Error::Value`] for a place that is not
    /// finite; nothing has changed then.
    pub fn set_home(&mut self, character: usize, home: Vec3) -> Result<()> {
        check_index("character", None, character, self.state.targets.len())?;
        check_home(home)?;
        let target = &mut self.state.targets[character];
        target.home = home;
        self.state.positions[character] = target.position();
        Ok(())
    }

    /// The characters.
    pub fn characters(&self) -> &Characters {
        &self.characters
    }

    /// How they strike.
    pub fn config(&self) -> &PracticeConfig {
        &self.config
    }

    /// The targets (number of characters).
    pub fn targets(&self) -> &[StruckTarget] {
        &self.state.targets
    }

    /// Blows of the last step that hit, in the order of characters.
    pub fn hits(&self) -> &[TargetHit] {
        &self.hits[..self.num_hits]
    }

    /// What became of a character's blows (character < num_characters).
    pub fn tally(&self, character: usize) -> Tally {
        self.state.tallies[character]
    }

    /// What has happened so far.
    pub fn figures(&self) -> PracticeFigures {
        let mut f = PracticeFigures { seconds: self.state.seconds, ..PracticeFigures::default() };
        self.state.tallies.iter().for_each(|t| f.blows += *t);
        f
    }

    /// Moves targets on, and strikes those that blows reach.
    fn strike(&mut self, dt_s: f32) {
        let (s, config) = (&mut self.state, &self.config);
        s.seconds += f64::from(dt_s);
        s.targets.iter_mut().for_each(|t| t.step(&config.target, dt_s));
        self.num_hits = 0;
        for blow in self.characters.blows() {
            let c = blow.character as usize;
            let distance = s.targets[c].position().distance(blow.point);
            let depth_m = config.target.radius_m + config.reach_m - distance;
            if depth_m >= 0.0 {
                s.targets[c].strike(&config.target, blow.direction, blow.speed_mps);
                self.hits[self.num_hits] = TargetHit { blow: *blow, depth_m };
                self.num_hits += 1;
            }
            s.tallies[c].count(if depth_m >= 0.0 { Outcome::Landed } else { Outcome::Missed });
        }
        for (position, target) in s.positions.iter_mut().zip(&s.targets) {
            *position = target.position();
        }
    }
}

fn goals_of<'a>(config: &PracticeConfig, state: &'a State) -> Goals<'a> {
    Goals::new(config.goals.iter().map(|g| (g.policy, g.weight, state.positions.as_slice())))
}

fn check_home(home: Vec3) -> Result<()> {
    let largest = if home.is_nan() { f32::NAN } else { home.abs().max_element() };
    within("home", largest, 0.0, 1e5, "finite coordinates below 1e5")
}
