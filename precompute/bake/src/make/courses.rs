//! Courses of made motion: starts, stops, turns, arcs and steps, frame by frame.

use super::gait::{GaitCycle, LEAD};
use super::{smooth, smoother, stance::RestStance, stepping::MadeCourse};
use glam::Vec2;
use std::f32::consts::PI;
use throng_base::{maths, thresholds::FOUR_STEPS_MPS};
use throng_core::Planar;

/// What a body is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MadeMove {
    /// Sets off, into a direction (rad).
    Start(f32),
    /// Comes to stand within two steps.
    Stop,
    /// Turns on the spot, with so many steps (rad).
    Turn(f32, usize),
    /// Goes so many cycles along an arc (rad).
    Arc(f32, usize),
    /// Turns while going, on a planted foot (rad).
    Pivot(f32),
    /// Goes somewhere else without turning: to the left and ahead, with so many steps (m).
    Step(f32, f32, usize),
}

/// Time of a stance before and after a move (s).
pub(super) const STAND_S: f32 = 0.5;
/// Time from the first shift of weight to the first step (s).
const SHIFT_S: f32 = 0.3;
/// Share of the steps of a start over which it gains speed.
const GAIN: f32 = 0.85;
/// Time of a step of who turns round: while going, and on the spot (s).
const QUICK_STEP_S: [f32; 2] = [0.44, 0.37];
/// Times of a stance before a turn on the spot, and from the first shift of weight to its first step (s).
const TURN_BEGINS_S: [f32; 2] = [0.3, 0.2];
/// Share of the gait in the pose of who steps on the spot.
const IN_PLACE: f32 = 0.3;
/// Shares of pace and of the gait's pose that a half turn takes away in its middle.
const PIVOT: [f32; 2] = [0.9, 0.4];
/// Share of a cycle in which an arc begins to turn, and most that shorter and longer arcs turn (rad).
const ARC_EASE: f32 = 0.7;
const MOST_TURNED: [f32; 2] = [0.8, 1.6];
/// Gravity (m/s2).
const GRAVITY_MPS2: f32 = 9.81;
/// Frames after the last event.
const TAIL: usize = LEAD + 2;

impl MadeMove {
    /// Name, as that of a clip.
    pub fn name(&self) -> String {
        match self {
            Self::Start(angle) => format!("start-{:.0}", angle.to_degrees()),
            Self::Stop => "stop".into(),
            Self::Turn(angle, _) => format!("turn-{:.0}", angle.to_degrees()),
            Self::Arc(angle, _) => format!("arc-{:.0}", angle.to_degrees()),
            Self::Pivot(angle) => format!("pivot-{:.0}", angle.to_degrees()),
            Self::Step(x, z, _) => format!("step-{:.0}-{:.0}", 100.0 * x, 100.0 * z),
        }
    }

    /// The gait that it is made of: who turns round takes quick steps.
    pub fn quicken(&self, gait: &GaitCycle) -> GaitCycle {
        match *self {
            Self::Turn(_, steps) => gait.with_quick_steps(steps, QUICK_STEP_S[1]),
            Self::Pivot(angle) => gait.with_quick_steps(pivot_steps(gait, angle), QUICK_STEP_S[0]),
            _ => gait.clone(),
        }
    }

    /// The course; `None` where the gait is too short for it.
    ///
    /// - `gait`: as [`Self::quicken`] returns it.
    pub fn course(&self, gait: &GaitCycle, stance: &RestStance) -> Option<MadeCourse> {
        let rate = gait.clip.rate_hz as f32;
        let (stand, shift) = ((STAND_S * rate) as usize, (SHIFT_S * rate) as usize);
        let step = 0.5 * gait.period as f32;
        let (lift, event) = (stand + shift, gait.event);
        let none = MadeCourse {
            gait_at: Vec::new(),
            stance_at: Vec::new(),
            weight: Vec::new(),
            lean: Vec::new(),
            path: Vec::new(),
            stands: [true; 2],
            captured: [0, usize::MAX],
            num_swings: usize::MAX,
        };
        let ramp = |f: usize, from: f32, over: f32| smoother((f as f32 - from) / over.max(1.0));
        let last = gait.clip.num_frames() - 1;
        let [fast, cycles] = FOUR_STEPS_MPS.map(|fast| if gait.speed_mps() > fast { 2 } else { 1 });
        Some(match *self {
            Self::Start(angle) => {
                // The faster, the more steps it takes.
                let over = gait.period * fast;
                let n = lift + over + TAIL;
                let until = lift + over - 1;
                // A turn takes the time before the first step is long.
                let late = 0.5 * step * angle.abs();
                let heading = |f: usize| angle * ramp(f, stand as f32, shift as f32 + 1.3 * step);
                // Slowly at first, so that hips stay over the foot that stands.
                let gain = (shift as f32 + GAIN * over as f32).min((shift + over - 1) as f32 - late);
                let pace = |f: usize| ramp(f, stand as f32 + late, gain);
                MadeCourse {
                    gait_at: (0..n).map(|f| (event + f.saturating_sub(lift)).min(last)).collect(),
                    stance_at: (0..n).map(|f| stance.frame(f)).collect(),
                    weight: (0..n)
                        .map(|f| ramp(f, lift as f32 - 0.15 * rate, 0.85 * over as f32 + 0.15 * rate))
                        .collect(),
                    path: path(gait, Planar::IDENTITY, n, heading, pace),
                    stands: [true, false],
                    captured: [0, until],
                    ..none
                }
            }
            Self::Stop => {
                let steps = 2 * cycles;
                let over = (steps as f32 + 0.5) * step;
                let n = event + over as usize + stand;
                let rest = event + over as usize;
                MadeCourse {
                    gait_at: (0..n).map(|f| f.min(last)).collect(),
                    stance_at: (0..n).map(|f| stance.frame(f.saturating_sub(rest))).collect(),
                    weight: (0..n).map(|f| 1.0 - ramp(f, event as f32, over - 0.2 * step)).collect(),
                    path: path(gait, gait.course(0), n, |_| 0.0, |f| 1.0 - ramp(f, event as f32, over)),
                    stands: [false, true],
                    captured: [event, usize::MAX],
                    num_swings: steps,
                    ..none
                }
            }
            Self::Arc(angle, cycles) => {
                let over = cycles * gait.period;
                let (until, n) = (event + over - 1, event + over + TAIL);
                let ease = arc_ease(gait, over);
                let at = |f: usize| f.saturating_sub(event).min(over) as f32;
                let heading = |f: usize| angle * arc_share(at(f), over as f32, ease);
                // Who turns leans inwards, so that weight and the push of the feet balance.
                let turns = |f: usize| 0.5 * rate * (heading(f + 1) - heading(f.saturating_sub(1)));
                let lean = |f: usize| maths::atan2(turns(f) * gait.speed_mps(), GRAVITY_MPS2);
                MadeCourse {
                    gait_at: (0..n).map(|f| f.min(last)).collect(),
                    stance_at: vec![0; n],
                    lean: (0..n).map(lean).collect(),
                    weight: vec![1.0; n],
                    path: path(gait, gait.course(0), n, heading, |_| 1.0),
                    stands: [false; 2],
                    captured: [event, until],
                    ..none
                }
            }
            Self::Pivot(angle) => {
                // Slower, and the arms swing less, the farther it turns.
                let depth = angle.abs() / PI;
                let over = pivot_steps(gait, angle) as f32 * step;
                let until = event + over as usize;
                let n = until + TAIL;
                let heading = |f: usize| angle * ramp(f, event as f32, over - 1.0);
                let dip = |f: usize| {
                    let t = ((f as f32 - event as f32) / (over - 1.0)).clamp(0.0, 1.0);
                    16.0 * t * t * (1.0 - t) * (1.0 - t)
                };
                MadeCourse {
                    gait_at: (0..n).map(|f| f.min(last)).collect(),
                    stance_at: vec![0; n],
                    weight: (0..n).map(|f| 1.0 - PIVOT[1] * depth * dip(f)).collect(),
                    path: path(gait, gait.course(0), n, heading, |f| 1.0 - PIVOT[0] * depth * dip(f)),
                    stands: [false; 2],
                    captured: [event, until],
                    ..none
                }
            }
            Self::Turn(angle, steps) => {
                let over = steps as f32 * step;
                let [begins, shift] = TURN_BEGINS_S.map(|s| s * rate);
                let lift = (begins + shift) as usize;
                let heading = |f: usize| angle * ramp(f, begins, over);
                in_place(none, gait, stance, [lift, stand], steps, |f| Planar::new(0.0, 0.0, heading(f)))
            }
            Self::Step(x, z, steps) => {
                let over = steps as f32 * step;
                let share = |f: usize| ramp(f, stand as f32, over + shift as f32);
                in_place(none, gait, stance, [lift, stand], steps, |f| Planar::new(x * share(f), z * share(f), 0.0))
            }
        })
    }
}

impl MadeMove {
    /// Arcs of a gait to both sides, as sharp as a sideways acceleration allows (m/s2).
    pub fn arcs(gait: &GaitCycle, sideways_mps2: f32) -> impl Iterator<Item = Self> {
        let rate = sideways_mps2 / gait.speed_mps() / gait.clip.rate_hz as f32;
        let least = if gait.speed_mps() > FOUR_STEPS_MPS[1] { 2 } else { 1 };
        let cycles = [least, least + 1].into_iter();
        cycles.zip(MOST_TURNED).flat_map(move |(cycles, most)| {
            let over = cycles * gait.period;
            let angle = (rate * (over as f32 - arc_ease(gait, over))).min(most);
            [Self::Arc(angle, cycles), Self::Arc(-angle, cycles)]
        })
    }
}

/// Number of steps of a turn while going: half turns take a step more, and so do runs.
fn pivot_steps(gait: &GaitCycle, angle: f32) -> usize {
    1 + usize::from(angle.abs() > 0.6 * PI) + if gait.speed_mps() > FOUR_STEPS_MPS[1] { 2 } else { 1 }
}

/// Time in which an arc of so many frames begins, and ends, to turn (frames).
fn arc_ease(gait: &GaitCycle, over: usize) -> f32 {
    (ARC_EASE * gait.period as f32).min(0.5 * over as f32)
}

/// Share of an arc's angle after so many frames: it turns ever faster, steadily, and ever slower.
fn arc_share(at: f32, over: f32, ease: f32) -> f32 {
    let eased = |frames: f32| {
        let t = (frames / ease).clamp(0.0, 1.0);
        ease * t * t * t * (1.0 - 0.5 * t)
    };
    let steadily = (at - ease).clamp(0.0, (over - 2.0 * ease).max(0.0));
    (eased(at) + steadily + 0.5 * ease - eased(over - at)) / (over - ease)
}

/// MadeCourse of who steps from stance to stance.
///
/// - `lift`, `stand`: first frame in the air, and frames of the stance.
fn in_place(
    none: MadeCourse,
    gait: &GaitCycle,
    stance: &RestStance,
    [lift, stand]: [usize; 2],
    steps: usize,
    place: impl Fn(usize) -> Planar,
) -> MadeCourse {
    let rate = gait.clip.rate_hz as f32;
    let step = 0.5 * gait.period as f32;
    let over = steps as f32 * step;
    let rest = lift + over as usize + (0.2 * rate) as usize;
    let n = rest + stand;
    let last = gait.clip.num_frames() - 1;
    let up = |f: usize| smooth((f as f32 - lift as f32 + 0.1 * rate) / (0.6 * step));
    let down = |f: usize| smooth((lift as f32 + over + 0.1 * rate - f as f32) / (0.8 * step));
    MadeCourse {
        gait_at: (0..n).map(|f| (gait.event + f.saturating_sub(lift)).min(last)).collect(),
        stance_at: (0..n).map(|f| stance.frame(f)).collect(),
        weight: (0..n).map(|f| IN_PLACE * up(f) * down(f)).collect(),
        path: (0..n).map(place).collect(),
        num_swings: steps,
        ..none
    }
}

/// Path of who travels as a gait does, at a share of its pace.
fn path(
    gait: &GaitCycle,
    begin: Planar,
    num_frames: usize,
    heading: impl Fn(usize) -> f32,
    pace: impl Fn(usize) -> f32,
) -> Vec<Planar> {
    let mut at = begin;
    let travel = Vec2::from_array(gait.travel);
    let place = |f: usize| {
        let here = Planar { heading: begin.heading + heading(f), ..at };
        // Midpoints: from this frame to the next.
        let turn = 0.5 * (heading(f) + heading(f + 1));
        let share = 0.5 * (pace(f) + pace(f + 1));
        let by = Planar::new(0.0, 0.0, begin.heading + turn).transform_point(travel * share);
        (at.x, at.z) = (at.x + by.x, at.z + by.y);
        here
    };
    (0..num_frames).map(place).collect()
}
