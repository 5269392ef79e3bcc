//! What became of blows: marks that stay for a moment.

use super::cast::Cast;
use glam::Vec3;
use throng_precompute::scene::Cast as SceneCast;
use throng_runtime::characters::Blow;
use throng_runtime::sparring::Part;

/// What a blow met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    /// A part of the opponent; arms block it.
    Body(Part),
    /// A target that hangs there.
    Target,
    /// Nothing.
    Nothing,
}

/// A blow and what became of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Step at which it was struck.
    pub step: u32,
    /// The character that struck.
    pub character: usize,
    /// Where, in the world (m).
    pub point: Vec3,
    /// Direction of the blow, of unit length.
    pub direction: Vec3,
    /// Speed over that of the fastest hit of its kind (> 0, <= 1).
    pub force: f32,
    /// What it met.
    pub met: Met,
}

/// Blows of the last step of a scene; none in a crowd without a scene.
pub(super) fn of_step(cast: &Cast, step: u32) -> impl Iterator<Item = Mark> {
    let play = cast.play();
    let blows = play.map_or(&[][..], |p| p.characters().blows());
    blows.iter().map(move |b| {
        let met = play.map_or(Met::Nothing, |p| met(&p.cast, b));
        Mark { step, character: b.character as usize, point: b.point, direction: b.direction, force: b.force, met }
    })
}

fn met(cast: &SceneCast, blow: &Blow) -> Met {
    let is_it = |b: &Blow| (b.character, b.hit) == (blow.character, blow.hit);
    match cast {
        SceneCast::Pairs(pairs) => {
            pairs.landed().iter().find(|l| is_it(&l.blow)).map_or(Met::Nothing, |l| Met::Body(l.part))
        }
        SceneCast::Targets(practice) => {
            practice.hits().iter().find(|h| is_it(&h.blow)).map_or(Met::Nothing, |_| Met::Target)
        }
    }
}
