//! Results of blows: marks that stay for a moment.

use glam::Vec3;
use throng_runtime::Cast;
use throng_runtime::characters::Blow;
use throng_runtime::simulation::{GroupCast, Simulation};
use throng_runtime::sparring::Part;

/// Result of a blow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// A part of the opponent; arms block it.
    Body(Part),
    /// A target that hangs there.
    Target,
    /// Nothing.
    Nothing,
}

/// A blow and its result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
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
    pub met: Met,
}

/// Blows of the last step of all groups that strike.
pub(super) fn of_step(simulation: &Simulation, step: u32, marks: &mut impl Extend<Mark>) {
    for group in simulation.groups() {
        let (first, cast) = (group.characters.start, &simulation.casts()[group.cast]);
        let blows = match cast {
            GroupCast::Sparring(s) => s.sparring().characters().blows(),
            GroupCast::Policy(p) => p.practice().characters().blows(),
            _ => continue,
        };
        marks.extend(blows.iter().map(|b| {
            let (character, met) = (first + b.character as usize, met(cast, b));
            Mark { step, character, point: b.point, direction: b.direction, force: b.force, met }
        }));
    }
}

fn met(cast: &GroupCast, blow: &Blow) -> Met {
    let is_it = |b: &Blow| (b.character, b.hit) == (blow.character, blow.hit);
    match cast {
        GroupCast::Sparring(s) => {
            let landed = s.sparring().events().iter().find(|(_, l)| is_it(&l.blow));
            landed.map_or(Met::Nothing, |(_, l)| Met::Body(l.part))
        }
        GroupCast::Policy(p) => {
            let hit = p.practice().events().iter().find(|(_, h)| is_it(&h.blow));
            hit.map_or(Met::Nothing, |_| Met::Target)
        }
        _ => Met::Nothing,
    }
}
