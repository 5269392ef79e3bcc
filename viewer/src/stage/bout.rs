//! Targets in a scene: places on the ground, and balls that hang in the air; marks of blows that landed, were blocked or missed.

use super::{StageLayout, StagePalette};
use crate::render::{Rgba, ShapeList};
use crate::run::{BlowMark, BlowResult, STEP_HZ, SceneRun};
use glam::Vec3;
use throng_core::Planar;
use throng_simulation::AnyCharacterGroup;
use throng_simulation::sparring::{StruckPart, StruckTarget};

/// Time that a mark stays (s).
const MARK_S: f32 = 0.6;
/// Most marks that are drawn; larger scenes have some at all times.
const MAX_MARKS: usize = 400;
/// Most characters whose targets are drawn.
const MAX_TARGETS: usize = 2000;
/// Length of the string above a target (m).
const STRING_M: f32 = 0.7;

/// Results of blows, for the key to the marks.
pub const KINDS: [(BlowResult, &str); 5] = [
    (BlowResult::Body(StruckPart::Head), "head or target"),
    (BlowResult::Body(StruckPart::Trunk), "trunk"),
    (BlowResult::Body(StruckPart::Leg), "leg"),
    (BlowResult::Body(StruckPart::Arm), "arm: blocked"),
    (BlowResult::Nothing, "missed: a streak"),
];

/// Colour of a result; none for a miss.
pub fn colour_of(met: BlowResult) -> Option<Rgba> {
    match met {
        BlowResult::Body(StruckPart::Head | StruckPart::Neck) => Some(Rgba::hex(0xff4b3e)),
        BlowResult::Body(StruckPart::Trunk | StruckPart::Pelvis) => Some(Rgba::hex(0xffa42e)),
        BlowResult::Body(StruckPart::Leg) => Some(Rgba::hex(0xc77dff)),
        BlowResult::Body(StruckPart::Arm) => Some(Rgba::hex(0x4aa8ff)),
        BlowResult::Target => Some(Rgba::hex(0xff4b3e)),
        BlowResult::Nothing => None,
    }
}

/// Targets, the selected one's opponent, and marks of blows.
///
/// - `marks_places`: targets on the ground are drawn, too.
pub(super) fn lay_out(
    out: &mut StageLayout,
    run: &SceneRun,
    selected: Option<usize>,
    marks_places: bool,
    palette: &StagePalette,
) {
    let simulation = run.simulation();
    for group in simulation.groups() {
        if let AnyCharacterGroup::Policy(p) = &simulation.character_groups()[group.character_group] {
            let radius = p.practice().config().target.radius_m;
            let all = group.characters.clone().zip(p.practice().targets());
            for (who, target) in all.filter(|t| t.0 < MAX_TARGETS || selected == Some(t.0)) {
                let is_selected = selected == Some(who);
                if target.home.y > 0.0 {
                    hanging(&mut out.shapes, target, radius, is_selected, palette);
                } else if marks_places {
                    mark_place(&mut out.shapes, target.home, simulation.root(who).filter(|_| is_selected), palette);
                }
            }
        }
    }
    if let Some(who) = selected.filter(|&who| who < simulation.num_characters())
        && let (AnyCharacterGroup::Sparring(_), member) = simulation.locate(who)
        && let (Some(own), Some(other)) = (simulation.root(who), simulation.root(who - member + (member ^ 1)))
    {
        let (from, to) = (own.translation(), other.translation());
        out.shapes.line(from.with_y(0.012), to.with_y(0.012), 1.5, palette.target.alpha(0.7));
    }
    for m in run.blow_marks(MARK_S).take(MAX_MARKS) {
        let age = (run.head.shown_step() - m.step) as f32 / STEP_HZ / MARK_S;
        draw_blow_mark(&mut out.shapes, m, age.min(1.0), palette);
    }
}

/// A disc and a ring on the ground; for the selected character also a pole, and a line from where it is.
fn mark_place(shapes: &mut ShapeList, target: Vec3, selected: Option<Planar>, palette: &StagePalette) {
    let (colour, at) = (palette.target, target.with_y(0.008));
    shapes.disc(at, 0.09, colour);
    shapes.ring(at, 0.17, if selected.is_some() { 0.25 } else { 0.20 }, colour);
    if let Some(root) = selected {
        shapes.line(at, at + Vec3::Y * 0.9, 2.5, colour);
        shapes.sphere(at + Vec3::Y * 0.9, 0.06, colour);
        shapes.line(root.translation().with_y(0.01), at.with_y(0.01), 1.0, colour.alpha(0.7));
    }
}

/// A ball on a string, its shadow on the ground, and where it hangs while it swings.
fn hanging(shapes: &mut ShapeList, target: &StruckTarget, radius: f32, is_selected: bool, palette: &StagePalette) {
    let (home, at) = (target.home, target.position());
    let hook = home + Vec3::Y * STRING_M;
    shapes.line(hook, at + (hook - at).normalize() * radius, 1.5, palette.middle.alpha(0.6));
    shapes.sphere(at, radius, palette.target);
    if home.distance(at) > 0.02 {
        shapes.circle(home, radius, 1.0, palette.target.alpha(0.8));
    }
    let below = at.with_y(0.008);
    shapes.disc(below, 0.5 * radius, palette.target.alpha(0.5));
    shapes.ring(below, radius, 1.25 * radius, palette.target.alpha(if is_selected { 0.9 } else { 0.4 }));
}

/// A flash where a blow came to its end, with rays that grow; a blow that met nothing leaves a faint streak.
///
/// - `age`: 0 at the blow, 1 when the mark goes away.
fn draw_blow_mark(shapes: &mut ShapeList, m: &BlowMark, age: f32, palette: &StagePalette) {
    let fade = (1.0 - age).powf(1.5);
    let size = 0.06 + 0.06 * m.force;
    let Some(colour) = colour_of(m.result) else {
        let from = m.point - m.direction * 0.16;
        shapes.line(from, m.point, 2.0, palette.middle.alpha(0.45 * fade));
        return;
    };
    shapes.on_top(true);
    shapes.sphere(m.point, 0.45 * size * (1.0 - 0.5 * age), colour.alpha(0.9 * fade));
    let aside = m.direction.any_orthonormal_vector();
    let other = m.direction.cross(aside);
    let (near, far) = (size * (0.5 + 1.0 * age), size * (0.9 + 2.2 * age));
    const RAYS: usize = 8;
    for i in 0..RAYS {
        let (s, c) = (std::f32::consts::TAU * i as f32 / RAYS as f32).sin_cos();
        // Away from where the blow came from, like a splash.
        let direction = (aside * c + other * s - m.direction * 0.35).normalize();
        shapes.line(m.point + direction * near, m.point + direction * far, 2.5, colour.alpha(fade));
    }
    shapes.on_top(false);
}
