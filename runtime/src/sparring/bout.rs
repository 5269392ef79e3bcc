//! Pairs of characters of one troupe.

use super::body::{Body, Posed};
use super::config::{Aim, NO_THREAT_S, SparringConfig};
use super::goals::Goals;
use super::landing::{Landing, meet};
use super::pair::Pair;
use super::tally::{Outcome, Tally};
use crate::pose::Mat3x4;
use crate::skeleton::NUM_JOINTS;
use crate::troupe::{Blow, MAX_BLOWS, Repertoire, SampleJob, Start, Troupe, TroupeError};
use glam::Vec3;

/// Pairs of characters that spar: 2i and 2i + 1 are opponents. All memory is allocated in [`Sparring::new`].
///
/// A step aims every behaviour at the opponent, moves the troupe, tests which blows land on which part of the
/// opponent's body, pushes that part in the direction of the blow, and moves bodies apart that overlap.
#[derive(Clone, Debug)]
pub struct Sparring {
    pub(super) config: SparringConfig,
    body: Body,
    pub(super) troupe: Troupe,
    pub(super) state: State,
    landings: Vec<Landing>,
    num_landings: usize,
}

/// What the next steps depend on, beside the troupe.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct State {
    /// The opponent's head, for each character. [Unit: m]
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
    /// Simulated time. [Unit: s]
    pub seconds: f64,
    /// Blows of all characters.
    pub blows: Tally,
    /// Deepest overlap of two opponents' heads, necks, trunks and pelvises now. [Unit: m]
    pub penetration_m: f32,
    /// The deepest so far. [Unit: m]
    pub max_penetration_m: f32,
    /// Time that pairs were deeper than [`super::SeparationConfig::deep_m`], summed over pairs. [Unit: s]
    pub deep_s: f32,
}

impl Sparring {
    /// Puts characters at their starts. [Size of starts: even]
    ///
    /// # Errors
    /// [`TroupeError::Odd`] for a character without an opponent, [`TroupeError::Index`] for a policy that does not
    /// exist, [`TroupeError::Value`] for a setting out of its range, and as [`Troupe::new`].
    pub fn new(repertoire: &Repertoire<'_>, config: SparringConfig, starts: &[Start]) -> Result<Self, TroupeError> {
        if !starts.len().is_multiple_of(2) {
            return Err(TroupeError::Odd { got: starts.len() });
        }
        config.check(repertoire)?;
        let troupe = Troupe::new(repertoire, config.troupe, starts)?;
        let body = Body::new(repertoire.skeleton(), &config.body);
        let mut heads = start_heads(repertoire, &body, starts)?;
        heads.chunks_exact_mut(2).for_each(|pair| pair.swap(0, 1));
        let n = starts.len();
        let state = State {
            heads,
            threats: vec![Vec3::new(0.0, NO_THREAT_S, 0.0); n],
            pairs: vec![Pair::default(); n / 2],
            tallies: vec![Tally::default(); n],
            seconds: 0.0,
        };
        let room = if repertoire.hits().is_empty() { 0 } else { n * MAX_BLOWS };
        Ok(Self { config, body, troupe, state, landings: vec![Landing::NONE; room], num_landings: 0 })
    }

    /// Moves all pairs on by `dt_s` on this thread. Allocates nothing.
    ///
    /// # Errors
    /// As [`Troupe::step`].
    pub fn step(&mut self, repertoire: &Repertoire<'_>, dt_s: f32) -> Result<(), TroupeError> {
        let goals = goals(&self.config, &self.state);
        self.troupe.step(repertoire, dt_s, goals.get())?;
        let s = &mut self.state;
        let parts = s.pairs.iter_mut().zip(s.heads.chunks_exact_mut(2)).zip(s.threats.chunks_exact_mut(2));
        for (i, ((pair, heads), threats)) in parts.enumerate() {
            observe(
                Observed { index: i, pair, heads, threats },
                &self.troupe,
                repertoire,
                &self.body,
                &self.config,
                dt_s,
            );
        }
        self.resolve(dt_s)
    }

    /// As [`Sparring::step`], on the threads of the current rayon pool. The result is the same, bit by bit.
    ///
    /// # Errors
    /// As [`Troupe::step`].
    #[cfg(feature = "rayon")]
    pub fn par_step(&mut self, repertoire: &Repertoire<'_>, dt_s: f32) -> Result<(), TroupeError> {
        use rayon::prelude::*;
        /// Pairs of one task.
        const TASK: usize = 64;
        let goals = goals(&self.config, &self.state);
        self.troupe.par_step(repertoire, dt_s, goals.get())?;
        let (s, troupe, body, config) = (&mut self.state, &self.troupe, &self.body, &self.config);
        let parts = s.pairs.par_iter_mut().zip(s.heads.par_chunks_exact_mut(2)).zip(s.threats.par_chunks_exact_mut(2));
        parts.with_min_len(TASK).enumerate().for_each(|(i, ((pair, heads), threats))| {
            observe(Observed { index: i, pair, heads, threats }, troupe, repertoire, body, config, dt_s);
        });
        self.resolve(dt_s)
    }

    /// The characters.
    pub fn troupe(&self) -> &Troupe {
        &self.troupe
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

    /// The opponent's head, for each character: what [`Aim::OpponentHead`] is about. [Unit: m]
    pub fn heads(&self) -> &[Vec3] {
        &self.state.heads
    }

    /// The opponent's next blow, for each character: what [`Aim::OpponentThreat`] is about. [Unit: m, s, m]
    pub fn threats(&self) -> &[Vec3] {
        &self.state.threats
    }

    /// What became of a character's blows. [Limit: character < num_characters]
    pub fn tally(&self, character: usize) -> Tally {
        self.state.tallies[character]
    }

    /// Deepest overlap of a pair's bodies at the last step; 0 where they are apart. [Unit: m] [Limit: pair < num_pairs]
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
    fn resolve(&mut self, dt_s: f32) -> Result<(), TroupeError> {
        self.state.seconds += f64::from(dt_s);
        self.num_landings = 0;
        for i in 0..self.troupe.blows().len() {
            let blow = self.troupe.blows()[i];
            let landing = self.land(blow);
            self.state.tallies[blow.character as usize].count(match &landing {
                Some(l) if l.is_blocked() => Outcome::Blocked,
                Some(_) => Outcome::Landed,
                None => Outcome::Missed,
            });
            if let Some(landing) = landing {
                let displacement = blow.direction * (blow.speed_mps * self.config.push_m_per_mps);
                self.troupe.push(landing.opponent as usize, landing.joint, displacement)?;
                self.landings[self.num_landings] = landing;
                self.num_landings += 1;
            }
        }
        for (i, pair) in self.state.pairs.iter().enumerate() {
            if let Some(by) = pair.part(dt_s) {
                self.troupe.shift(2 * i, by[0])?;
                self.troupe.shift(2 * i + 1, by[1])?;
            }
        }
        Ok(())
    }

    /// Where a blow meets the opponent.
    fn land(&self, blow: Blow) -> Option<Landing> {
        let opponent = blow.character ^ 1;
        let c = opponent as usize;
        let pose = Posed::new(self.troupe.pose(c), self.troupe.root(c));
        let (capsule, depth_m) = meet(&self.config, &self.body, &pose, &blow)?;
        let (part, joint) = (self.body.part(capsule), self.body.joint(capsule));
        Some(Landing { blow, opponent, part, joint, depth_m })
    }
}

/// What is written of one pair after a step.
struct Observed<'a> {
    index: usize,
    pair: &'a mut Pair,
    /// [Size: 2]
    heads: &'a mut [Vec3],
    /// [Size: 2]
    threats: &'a mut [Vec3],
}

/// Takes the places of heads, the coming blows and the overlap of a pair from their poses.
fn observe(
    to: Observed<'_>,
    troupe: &Troupe,
    repertoire: &Repertoire<'_>,
    body: &Body,
    config: &SparringConfig,
    dt_s: f32,
) {
    let characters = [2 * to.index, 2 * to.index + 1];
    let poses = characters.map(|c| Posed::new(troupe.pose(c), troupe.root(c)));
    for (k, opponent) in [1, 0].into_iter().enumerate() {
        to.heads[k] = body.head(&poses[opponent]);
        to.threats[k] = match troupe.next_blow(repertoire, characters[opponent]) {
            Some((blow, due_s)) => Vec3::new(blow.point.x, due_s, blow.point.z),
            None => Vec3::new(0.0, NO_THREAT_S, 0.0),
        };
    }
    let contacts = characters.map(|c| troupe.contacts(c));
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

/// Heads of characters as they start. [Unit: m]
fn start_heads(repertoire: &Repertoire<'_>, body: &Body, starts: &[Start]) -> Result<Vec<Vec3>, TroupeError> {
    let frames: Vec<u32> = starts.iter().map(|s| repertoire.graph().states[s.state as usize].frame).collect();
    let mut matrices = vec![Mat3x4::default(); starts.len() * NUM_JOINTS];
    let ratios = vec![0.0; starts.len()];
    SampleJob { repertoire, frames: &frames, ratios: &ratios, matrices: &mut matrices }.run()?;
    let poses = matrices.chunks_exact(NUM_JOINTS).zip(starts);
    Ok(poses.map(|(pose, start)| body.head(&Posed::new(pose, start.root))).collect())
}
