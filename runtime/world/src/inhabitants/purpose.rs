//! Purpose of roaming characters: one direction for as long as possible, so that they walk on and not in circles.

use super::{Inhabitants, reservations::follow_nobody};
use crate::{WorldGraph, WorldStep};
use serde::{Deserialize, Serialize};
use throng_base::maths;
use throng_core::characters::uniform_random;

/// A direction is kept for so many steps: at least, and so many more at most.
const STEPS: [f32; 2] = [6.0, 18.0];
/// Cosine of the largest angle between a free step and the direction; without a nearer step a character chooses another
/// direction (cosine of 45 degrees).
const AHEAD: f32 = 0.7;
/// Weight of a step that leads back, relative to one straight ahead, and of a step that leads nowhere: an action in one
/// place.
const BACK: f32 = 1e-3;
const NOWHERE: f32 = 0.05;

/// Direction of a roaming character.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Purpose {
    /// x and z, a unit vector; zero before the first one.
    direction: [f32; 2],
    /// Steps until it chooses another direction.
    steps_left: u32,
}

impl Purpose {
    pub fn is_sound(&self) -> bool {
        self.direction.iter().all(|v| v.abs() <= 1.001)
    }

    /// Alignment of a step from a point with the character's direction, from 0 for straight back to 1; none where the
    /// step leads nowhere.
    pub fn alignment(&self, graph: &WorldGraph, from: [f32; 2], step: &WorldStep) -> Option<f32> {
        let half = 0.5 + 0.5 * cosine(self.direction, direction(graph, from, step)?);
        let squared = half * half;
        Some(squared * squared * squared * squared)
    }

    /// Weight of a step from a point in a random choice.
    ///
    /// - `brisk`: time for a metre at [`throng_base::thresholds::WALK_SPEED_MPS`] (frames). Slower steps are taken more seldom, as
    ///   the square of their speed.
    pub fn step_weight(&self, graph: &WorldGraph, from: [f32; 2], step: &WorldStep, brisk: f32) -> f32 {
        let Some(lead) = self.alignment(graph, from, step) else { return NOWHERE };
        let speed = (graph.step_length(step) * brisk / step.num_frames() as f32).min(1.0);
        BACK + (1.0 - BACK) * lead * speed * speed
    }
}

/// Direction over ground from a point to where a step leads, a unit vector; none where it leads nowhere.
fn direction(graph: &WorldGraph, [x, z]: [f32; 2], step: &WorldStep) -> Option<[f32; 2]> {
    let end = graph.place(step.to);
    let along = [end.x - x, end.z - z];
    let length = maths::hypot(along[0], along[1]);
    (length > 0.1).then(|| along.map(|v| v / length))
}

fn cosine(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] * b[0] + a[1] * b[1]).clamp(-1.0, 1.0)
}

impl Inhabitants {
    /// Counts a step of a roaming character, and gives it another direction where nothing leads ahead or after a while.
    pub(super) fn update_purpose(&mut self, graph: &WorldGraph, c: usize) {
        let state = &self.states[c];
        let place = graph.place(state.at);
        let (seed, name, mut draws) = (self.config.characters.seed, self.name(c), state.draws);
        let (mut ahead, mut drawn, mut count) = (-1.0f32, None, 0.0);
        graph.for_each_step(state.at, |step| {
            let Some(direction) = direction(graph, [place.x, place.z], &step) else { return };
            if self.reservations.holder_for_step(graph, &step, c as u32, follow_nobody).is_none() {
                count += 1.0;
                draws = draws.wrapping_add(1);
                if uniform_random(seed, name, draws.into()) * count < 1.0 {
                    drawn = Some(direction);
                }
                ahead = ahead.max(cosine(state.purpose.direction, direction));
            }
        });
        self.states[c].draws = draws;
        let steps_left = self.states[c].purpose.steps_left.saturating_sub(1);
        match drawn {
            Some(direction) if steps_left == 0 || ahead < AHEAD => {
                let steps_left = (STEPS[0] + STEPS[1] * self.draw_random(c)) as u32;
                self.states[c].purpose = Purpose { direction, steps_left };
            }
            _ => self.states[c].purpose.steps_left = steps_left,
        }
    }
}
