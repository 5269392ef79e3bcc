//! Figures of every step.

use glam::Vec3;
use throng_core::{CharacterGroup, characters::Blow};
use throng_precompute::run::{AgentsSummary, policy_characters};
use throng_simulation::sparring::{BlowTally, StruckPart};
use throng_simulation::{AnyCharacterGroup, Simulation};

/// Speed of planted heels and toes over all characters at one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slip {
    /// (m/s)
    pub mean_mps: f32,
    /// 95th percentile (m/s).
    pub p95_mps: f32,
}

/// Results of all blows of a scene so far, and penetration of its pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoutFigures {
    /// Blows of all characters.
    pub blows: BlowTally,
    /// Simulated time (s).
    pub seconds: f64,
    /// Deepest overlap of two opponents at the step; none without opponents (m).
    pub penetration_m: Option<f32>,
    /// The deepest overlap so far (m).
    pub max_penetration_m: f32,
}

impl BoutFigures {
    /// Blows that landed, a minute and character, since earlier figures.
    pub fn hits_per_minute(&self, since: &Self, characters: usize) -> f64 {
        let seconds = self.seconds - since.seconds;
        let hits = self.blows.landed.saturating_sub(since.blows.landed);
        if seconds > 0.0 { f64::from(hits) * 60.0 / seconds / characters.max(1) as f64 } else { 0.0 }
    }

    /// Figures of all groups that strike; none in a scene without any.
    pub fn collect_from(simulation: &Simulation) -> Option<Self> {
        let mut all: Option<Self> = None;
        for group in simulation.character_groups() {
            let own = match group {
                AnyCharacterGroup::Sparring(s) => {
                    let f = s.sparring().figures();
                    let penetration_m = Some(f.penetration_m);
                    Self { blows: f.blows, seconds: f.seconds, penetration_m, max_penetration_m: f.max_penetration_m }
                }
                AnyCharacterGroup::Policy(p) => {
                    let f = p.practice().figures();
                    Self { blows: f.blows, seconds: f.seconds, ..Self::default() }
                }
                _ => continue,
            };
            let sum = all.get_or_insert_default();
            sum.blows += own.blows;
            sum.seconds = own.seconds;
            sum.penetration_m = sum.penetration_m.into_iter().chain(own.penetration_m).reduce(f32::max);
            sum.max_penetration_m = sum.max_penetration_m.max(own.max_penetration_m);
        }
        all
    }
}

/// Figures of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepFigures {
    /// Wall time of the characters' step (s).
    pub wall_s: f64,
    /// Slip of planted feet.
    pub slip: Slip,
    /// Characters that have come to their targets; none in a scene without such targets.
    pub at_target: Option<usize>,
    /// Figures of blows, for characters that strike.
    pub bout: Option<BoutFigures>,
    /// Figures of all agents, if there are any.
    pub agents: Option<AgentsSummary>,
}

/// Result of a blow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlowResult {
    /// A part of the opponent; arms block it.
    Body(StruckPart),
    /// A target that hangs there.
    Target,
    /// Nothing.
    Nothing,
}

/// A blow and its result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlowMark {
    /// Step of the blow.
    pub step: u32,
    /// The character that struck.
    pub character: usize,
    /// Position in the world (m).
    pub point: Vec3,
    /// Direction of the blow, of unit length.
    pub direction: Vec3,
    /// Speed relative to the fastest hit of its kind (> 0, <= 1).
    pub force: f32,
    /// Result of the blow.
    pub result: BlowResult,
}

/// Blows of the last step of all groups that strike.
pub(super) fn record_blows(simulation: &Simulation, step: u32, marks: &mut impl Extend<BlowMark>) {
    for group in simulation.groups() {
        let (first, character_group) = (group.characters.start, &simulation.character_groups()[group.character_group]);
        let Some(boxers) = policy_characters(character_group) else { continue };
        marks.extend(boxers.characters().blows().iter().map(|b| {
            let (character, met) = (first + b.character as usize, blow_result(character_group, b));
            BlowMark { step, character, point: b.point, direction: b.direction, force: b.force, result: met }
        }));
    }
}

fn blow_result(character_group: &AnyCharacterGroup, blow: &Blow) -> BlowResult {
    let is_it = |b: &Blow| (b.character, b.hit) == (blow.character, blow.hit);
    match character_group {
        AnyCharacterGroup::Sparring(s) => {
            let landed = s.sparring().events().iter().find(|(_, l)| is_it(&l.blow));
            landed.map_or(BlowResult::Nothing, |(_, l)| BlowResult::Body(l.part))
        }
        AnyCharacterGroup::Policy(p) => {
            let hit = p.practice().events().iter().find(|(_, h)| is_it(&h.blow));
            hit.map_or(BlowResult::Nothing, |_| BlowResult::Target)
        }
        _ => BlowResult::Nothing,
    }
}
