//! Pairs of characters of one set.

use super::body::{Body, Posed};
use super::config::{Aim, NO_THREAT_S, SparringConfig};
use super::goals::Goals;
use super::landing::{Landing, meet};
use super::pair::Pair;
use super::tally::{Outcome, Tally};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::{Error, Inline, Result, Run, run_each};
use throng_core::characters::{Blow, Characters, MAX_BLOWS, MotionSet, SampleJob, Start};
use throng_core::pose::Mat3x4;
use throng_core::skeleton::NUM_JOINTS;

/// Pairs of characters that spar: 2i and 2i + 1 are opponents. All memory is allocated in [`Sparring::new`].
///
/// A step aims every behaviour at the opponent, moves the characters, tests which blows land on which part of the
/// opponent's body, pushes that part in the direction of the blow, and moves bodies apart that overlap.
#[derive(Clone, Debug)]
pub struct Sparring {
    pub(super) config: SparringConfig,
    body: Body,
    pub(super) characters: Characters,
    pub(super) state: State,
    pub(super) landings: Vec<Landing>,
    pub(super) num_landings: usize,
    /// Content hash of how they spar, but for weights.
    pub(super) setup: u128,
}

/// What the next steps depend on, beside the characters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct State {
    /// The opponent's head, for each character (m).
    pub heads: Vec<Vec3>,
    /// The opponent's next blow, for each character: x, seconds, z.
    pub threats: Vec<Vec3>,
    pub pairs: Vec<Pair>,
    pub tallies: Vec<Tally>,
    pub seconds: f64,
}

/// What has happened so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SparringFigures {
    /// Simulated time (s).
    pub seconds: f64,
    /// Blows of all characters.
    pub blows: Tally,
    /// Deepest overlap of two opponents' heads, necks, trunks and pelvises now (m).
    pub penetration_m: f32,
    /// The deepest so far (m).
    pub max_penetration_m: f32,
    /// Time that pairs were deeper than [`super::SeparationConfig::deep_m`], summed over pairs (s).
    pub deep_s: f32,
}

impl Sparring {
    /// Puts characters at their starts (an even number).
    ///
    /// # Errors
    /// [`Error::Length`] for a character without an opponent, [`Error::Index`] for a policy that does not
    /// exist, [`Error::Value`] for a setting out of its range, and as [`Characters::new`].
    pub fn new(motion_set: &MotionSet, config: SparringConfig, starts: &[Start]) -> Result<Self> {
        if !starts.len().is_multiple_of(2) {
            return Err(Error::Length { what: "starts", got: starts.len(), expected: "an even number".into() });
        }
        config.check(motion_set)?;
        let characters = Characters::new(motion_set, config.characters, starts)?;
        let body = Body::new(motion_set.skeleton(), &config.body);
        let mut heads = start_heads(motion_set, &body, starts)?;
        heads.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
        let n = starts.len();
        let state = State {
            heads,
            threats: vec![Vec3::new(0.0, NO_THREAT_S, 0.0); n],
            pairs: vec![Pair::default(); n / 2],
            tallies: vec![Tally::default(); n],
            seconds: 0.0,
        };
        let room = if motion_set.hits().is_empty() { 0 } else { n * MAX_BLOWS };
        let landings = vec![Landing::NONE; room];
        Ok(Self { setup: config.hash(), config, body, characters, state, landings, num_landings: 0 })
    }

    /// Moves all pairs on by `dt_s` on this thread. Allocates nothing.
    ///
    /// # Errors
    /// As [`Characters::step`].
    pub fn step(&mut self, motion_set: &MotionSet, dt_s: f32) -> Result<()> {
        self.step_on(motion_set, dt_s, &Inline)
    }

    /// As [`Sparring::step`], on threads of the caller's choice. The result is the same, bit by bit.
    ///
    /// # Errors
    /// As [`Characters::step`].
    pub fn step_on(&mut self, motion_set: &MotionSet, dt_s: f32, run: &dyn Run) -> Result<()> {
        /// Pairs of one part.
        const PART: usize = 64;
        self.characters.step_on(motion_set, dt_s, goals(&self.config, &self.state).get(), run)?;
        let (s, characters, body, config) = (&mut self.state, &self.characters, &self.body, &self.config);
        let parts = s.pairs.chunks_mut(PART).zip(s.heads.chunks_mut(2 * PART)).zip(s.threats.chunks_mut(2 * PART));
        run_each(run, parts.enumerate(), |(part, ((pairs, heads), threats))| {
            let of_pair = pairs.iter_mut().zip(heads.chunks_exact_mut(2)).zip(threats.chunks_exact_mut(2));
            for (i, ((pair, heads), threats)) in of_pair.enumerate() {
                let to = Observed { index: part * PART + i, pair, heads, threats };
                observe(to, characters, motion_set, body, config, dt_s);
            }
        });
        self.resolve(dt_s)
    }

    /// The characters.
    pub fn characters(&self) -> &Characters {
        &self.characters
    }

    /// How they spar.
    pub fn config(&self) -> &SparringConfig {
        &self.config
    }

    /// The capsules that blows are tested against.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Number of pairs.
    pub fn num_pairs(&self) -> usize {
        self.state.pairs.len()
    }

    /// Blows of the last step that met the opponent's body, blocked ones among them, in the order of characters.
    pub fn landed(&self) -> &[Landing] {
        &self.landings[..self.num_landings]
    }

    /// The opponent's head, for each character: what [`Aim::OpponentHead`] is about (m).
    pub fn heads(&self) -> &[Vec3] {
        &self.state.heads
    }

    /// The opponent's next blow, for each character: what [`Aim::OpponentThreat`] is about (m, s, m).
    pub fn threats(&self) -> &[Vec3] {
        &self.state.threats
    }

    /// What became of a character's blows (character < num_characters).
    pub fn tally(&self, character: usize) -> Tally {
        self.state.tallies[character]
    }

    /// Deepest overlap of a pair's bodies at the last step; 0 where they are apart (m, pair < num_pairs).
    pub fn overlap_m(&self, pair: usize) -> f32 {
        self.state.pairs[pair].overlap_m
    }

    /// What has happened so far.
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

    /// Lets blows land and bodies part, after all have been observed.
    fn resolve(&mut self, dt_s: f32) -> Result<()> {
        self.state.seconds += f64::from(dt_s);
        self.num_landings = 0;
        for i in 0..self.characters.blows().len() {
            let blow = self.characters.blows()[i];
            let landing = self.land(blow);
            self.state.tallies[blow.character as usize].count(match &landing {
                Some(l) if l.is_blocked() => Outcome::Blocked,
                Some(_) => Outcome::Landed,
                None => Outcome::Missed,
            });
            if let Some(landing) = landing {
                let displacement = blow.direction * (blow.speed_mps * self.config.push_m_per_mps);
                self.characters.push(landing.opponent as usize, landing.joint, displacement)?;
                self.landings[self.num_landings] = landing;
                self.num_landings += 1;
            }
        }
        for (i, pair) in self.state.pairs.iter().enumerate() {
            if let Some(by) = pair.part(dt_s) {
                self.characters.shift(2 * i, by[0])?;
                self.characters.shift(2 * i + 1, by[1])?;
            }
        }
        Ok(())
    }

    /// Where a blow meets the opponent.
    fn land(&self, blow: Blow) -> Option<Landing> {
        let opponent = blow.character ^ 1;
        let c = opponent as usize;
        let pose = Posed::new(self.characters.pose(c), self.characters.root(c));
        let (capsule, depth_m) = meet(&self.config, &self.body, &pose, &blow)?;
        let (part, joint) = (self.body.part(capsule), self.body.joint(capsule));
        Some(Landing { blow, opponent, part, joint, depth_m })
    }
}

/// What is written of one pair after a step.
struct Observed<'a> {
    index: usize,
    pair: &'a mut Pair,
    /// (2)
    heads: &'a mut [Vec3],
    /// (2)
    threats: &'a mut [Vec3],
}

/// Takes the places of heads, the coming blows and the overlap of a pair from their poses.
fn observe(
    to: Observed<'_>,
    characters: &Characters,
    motion_set: &MotionSet,
    body: &Body,
    config: &SparringConfig,
    dt_s: f32,
) {
    let pair = [2 * to.index, 2 * to.index + 1];
    let poses = pair.map(|c| Posed::new(characters.pose(c), characters.root(c)));
    for (k, opponent) in [1, 0].into_iter().enumerate() {
        to.heads[k] = body.head(&poses[opponent]);
        to.threats[k] = match characters.next_blow(motion_set, pair[opponent]) {
            Some((blow, due_s)) => Vec3::new(blow.point.x, due_s, blow.point.z),
            None => Vec3::new(0.0, NO_THREAT_S, 0.0),
        };
    }
    let contacts = pair.map(|c| characters.contacts(c));
    to.pair.observe(body, [&poses[0], &poses[1]], contacts, &config.separation, dt_s);
}

/// The goals of a step.
fn goals<'a>(config: &SparringConfig, state: &'a State) -> Goals<'a> {
    Goals::new(config.goals.iter().map(|g| {
        let targets = match g.aim {
            Aim::OpponentHead => &state.heads,
            Aim::OpponentThreat => &state.threats,
        };
        (g.policy, g.weight, targets.as_slice())
    }))
}

/// Heads of characters as they start (m).
fn start_heads(motion_set: &MotionSet, body: &Body, starts: &[Start]) -> Result<Vec<Vec3>> {
    let frames: Vec<u32> = starts.iter().map(|s| motion_set.graph().states[s.state as usize].frame).collect();
    let mut matrices = vec![Mat3x4::default(); starts.len() * NUM_JOINTS];
    let ratios = vec![0.0; starts.len()];
    SampleJob { motion_set, frames: &frames, ratios: &ratios, matrices: &mut matrices }.run()?;
    let poses = matrices.chunks_exact(NUM_JOINTS).zip(starts);
    Ok(poses.map(|(pose, start)| body.head(&Posed::new(pose, start.root))).collect())
}
