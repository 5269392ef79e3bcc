//! Results of blows: marks that stay for a moment.

use glam::Vec3;
use throng_core::CharacterGroup;
use throng_core::characters::Blow;
use throng_precompute::run::policy_characters;
use throng_simulation::sparring::StruckPart;
use throng_simulation::{AnyCharacterGroup, Simulation};

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
