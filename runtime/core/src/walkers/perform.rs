//! Performances of standing walkers: they turn to a heading, play an activity of the bundle, and go on as blended.
//!
//! The activity's posture is mixed into the blended one by a share, before it is put on the body and on the ground:
//! standing feet stay in place. A spring pulls the share, so that its rate never jumps.

use super::{Control, block::WalkerBlock};
use crate::blend::{Activity, ActivityId, ActivitySample, ActivitySet, AxisRecord, BlendedPosture, MAX_AXES, axis};
use crate::body::{DampedSpring, NO_ROW};
use crate::planar::wrap_angle;
use glam::Vec2;
use serde::{Deserialize, Serialize};
use throng_base::thresholds::{STANDING_MPS, WALKING_MPS};

/// Time in which half of a change from the blend to an activity, or back, is made (s).
const HALF_LIFE_S: f32 = 0.09;
/// Time before its end at which an activity begins to fade (s).
const LEAD_S: f32 = 0.25;
/// Time of a change from one place of an activity to another (s).
const CROSS_S: f32 = 0.35;
/// Share of an activity that is none.
const GONE: f32 = 1e-3;
/// A body that stands has turned: what is left of its turn, and its turning rate (rad, rad/s).
const TURNED: f32 = 0.03;
const TURNING: f32 = 0.15;

/// An activity to perform.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Performance {
    /// Activity to perform, one of [`crate::blend::BlendSpace::activities`].
    pub activity: ActivityId,
    /// Heading to turn to first; `None` is that of the body (rad).
    pub heading: Option<f32>,
}

/// Progress of a performance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerformanceProgress {
    /// The activity.
    pub activity: ActivityId,
    /// Current part of the performance.
    pub part: PerformancePart,
    /// Time within the activity; 0 until it begins (s).
    pub seconds: f32,
}

/// A part of a performance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum PerformancePart {
    /// No performance: the body moves as blended.
    #[default]
    Idle,
    /// Stopping and turning.
    Turn,
    /// Start of the activity up to the looped part, or all of an activity without one.
    Begin,
    /// Looped part, until the activity is to end.
    Loop,
    /// Rest of the activity after the looped part.
    End,
    /// The activity is over and fades.
    Fade,
}

/// The performance of one walker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PerformanceState {
    activity: u32,
    part: PerformancePart,
    /// Heading that the body keeps (rad).
    heading: f32,
    /// Time within the activity, and within what is left behind (s).
    seconds: f32,
    left: f32,
    /// Share of what is left behind, before it is eased.
    cross: f32,
    /// True where the activity ends as soon as possible.
    is_ending: bool,
    /// Share of the activity in the posture.
    share: f32,
    /// Rate of the share (1/s).
    rate: f32,
    next: Option<Performance>,
}

/// Constants of one step, shared by all performances.
pub(crate) struct PerformanceInputs<'a> {
    pub activities: &'a ActivitySet,
    axes: &'a [AxisRecord],
    spring: DampedSpring,
    dt_s: f32,
}

impl<'a> PerformanceInputs<'a> {
    pub fn new(activities: &'a ActivitySet, axes: &'a [AxisRecord], dt_s: f32) -> Self {
        Self { activities, axes, spring: DampedSpring::new(dt_s, HALF_LIFE_S), dt_s }
    }

    /// True where a body neither moves nor turns.
    fn stands_still(&self, speed: f32, turning: f32, parameters: &[f32; MAX_AXES]) -> bool {
        let still = |(p, a): (&f32, &AxisRecord)| match a.kind {
            axis::SPEED | axis::SIDE => p.abs() < STANDING_MPS,
            axis::GYRATION => p.abs() < TURNING,
            _ => true,
        };
        speed < STANDING_MPS && turning.abs() < TURNING && parameters.iter().zip(self.axes).all(still)
    }
}

impl PerformanceState {
    /// Begins, ends or changes the performance.
    ///
    /// - `heading`: of the body (rad).
    pub fn set_performance(&mut self, order: Option<Performance>, heading: f32) {
        self.next = None;
        match (self.part, order) {
            (PerformancePart::Idle | PerformancePart::Turn, Some(p)) => self.begin_performance(p, heading),
            (PerformancePart::Idle | PerformancePart::Fade, None) => {}
            (PerformancePart::Turn, None) => *self = Self::default(),
            (_, order) => (self.next, self.is_ending) = (order, true),
        }
    }

    fn begin_performance(&mut self, p: Performance, heading: f32) {
        let heading = p.heading.unwrap_or(heading);
        *self = Self { activity: p.activity.0, part: PerformancePart::Turn, heading, ..Self::default() };
    }

    /// Progress of the performance; none where there is no performance.
    pub fn performance_progress(&self) -> Option<PerformanceProgress> {
        let is_on = !matches!(self.part, PerformancePart::Idle | PerformancePart::Fade);
        let (activity, part, seconds) = (ActivityId(self.activity), self.part, self.seconds);
        is_on.then_some(PerformanceProgress { activity, part, seconds })
    }

    /// Frame row of the activity that plays; [`NO_ROW`] for none.
    pub fn row(&self, activities: &ActivitySet) -> u32 {
        let playing = activities.get(ActivityId(self.activity)).filter(|_| self.plays_activity());
        playing.map_or(NO_ROW, |a| a.first_frame as u32 + (self.seconds * activities.rows.rate_hz) as u32)
    }

    /// True from the beginning of the activity until it fades.
    fn plays_activity(&self) -> bool {
        matches!(self.part, PerformancePart::Begin | PerformancePart::Loop | PerformancePart::End)
    }

    /// True where there is nothing to do.
    #[inline(always)]
    pub fn is_idle(&self) -> bool {
        self.part == PerformancePart::Idle
    }

    /// Order for steering while a body performs: it stands and keeps its heading.
    pub fn steering_order(&self, control: &Control, stage: &PerformanceInputs<'_>) -> Control {
        if self.performance_progress().is_none() || walks(control) && !self.must_stand_up(stage) {
            return *control;
        }
        Control { velocity: Vec2::ZERO, heading: Some(self.heading), turning_rate: None, ..*control }
    }

    /// True if the body sits, or is about to, and has to stand up first.
    fn must_stand_up(&self, stage: &PerformanceInputs<'_>) -> bool {
        self.part != PerformancePart::Turn
            && stage.activities.get(ActivityId(self.activity)).is_some_and(|a| a.is_seated)
    }

    /// Moves time on, once the body was steered.
    ///
    /// - returns true where the performance has ended.
    pub fn advance(&mut self, stage: &PerformanceInputs<'_>, control: &Control, b: &WalkerBlock, lane: usize) -> bool {
        let Some(activity) = stage.activities.get(ActivityId(self.activity)) else {
            *self = Self::default();
            return false;
        };
        if stage.dt_s == 0.0 {
            return false;
        }
        let was_on = self.performance_progress().is_some();
        match self.part {
            PerformancePart::Turn => {
                let left = wrap_angle(self.heading - b.root[2][lane]);
                let stands = stage.stands_still(b.speed[lane], b.turning[lane], &b.parameters[lane]);
                if walks(control) {
                    *self = Self::default();
                } else if left.abs() < TURNED && stands {
                    self.part = PerformancePart::Begin;
                }
            }
            _ => self.advance_activity(activity, walks(control), stage.dt_s),
        }
        let aim = if self.plays_activity() { 1.0 } else { 0.0 };
        let (off, rate) = stage.spring.pull_towards_zero(self.share - aim, self.rate);
        (self.share, self.rate) = ((aim + off).clamp(0.0, 1.0), rate);
        if self.part == PerformancePart::Fade && self.share < GONE {
            let next = self.next;
            *self = Self::default();
            if let Some(next) = next {
                self.begin_performance(next, b.root[2][lane]);
            }
        }
        was_on && self.performance_progress().is_none()
    }

    /// Moves on within the activity.
    fn advance_activity(&mut self, activity: &Activity, walks: bool, dt_s: f32) {
        let end = activity.duration_s;
        self.seconds = (self.seconds + dt_s).min(end);
        self.left = (self.left + dt_s).min(end);
        self.cross = (self.cross - dt_s / CROSS_S).max(0.0);
        self.is_ending |= walks;
        let leaves = self.is_ending && !activity.is_seated && (walks || activity.looped_s.is_none());
        match (self.part, activity.looped_s) {
            (PerformancePart::Fade, _) => {}
            _ if leaves && self.plays_activity() => self.part = PerformancePart::Fade,
            (PerformancePart::Begin, Some([from, _])) if self.seconds >= from => self.part = PerformancePart::Loop,
            (PerformancePart::Loop, Some([_, to])) if self.is_ending && (self.cross == 0.0 || self.seconds >= to) => {
                if self.seconds < to {
                    self.jump_to(to);
                }
                self.part = PerformancePart::End;
            }
            (PerformancePart::Loop, Some([from, to])) if self.seconds >= to => self.jump_to(from + (self.seconds - to)),
            (PerformancePart::Begin, None) | (PerformancePart::End, _) if self.seconds >= activity.fades_s() => {
                self.part = PerformancePart::Fade
            }
            _ => {}
        }
    }

    /// Continues at another time of the activity; the previous pose fades.
    fn jump_to(&mut self, to: f32) {
        (self.left, self.seconds, self.cross) = (self.seconds, to, 1.0);
    }

    /// Mixes the performance into a blended posture.
    ///
    /// - returns its share.
    pub fn overlay_posture(&self, activities: &ActivitySet, posture: &mut BlendedPosture) -> f32 {
        let Some(activity) = activities.get(ActivityId(self.activity)).filter(|_| self.share > 0.0) else { return 0.0 };
        activities.overlay_sample(&self.sample(activities, activity), self.share, posture);
        self.share
    }

    fn sample(&self, activities: &ActivitySet, activity: &Activity) -> ActivitySample {
        let now = activities.sample_activity(activity, self.seconds);
        if self.cross == 0.0 {
            return now;
        }
        let eased = self.cross * self.cross * (3.0 - 2.0 * self.cross);
        now.mix(&activities.sample_activity(activity, self.left), eased)
    }

    /// Continues the performance with other activities; it is given up where none has its name.
    pub fn adopt(&mut self, old: &ActivitySet, new: &ActivitySet) {
        let now = old.get(ActivityId(self.activity)).and_then(|a| new.find_activity(&a.name).ok());
        match now {
            Some(now) if self.next.is_none() => self.activity = now.0,
            _ => *self = Self::default(),
        }
    }

    /// True where its numbers can be.
    pub fn is_sound(&self, activities: &ActivitySet) -> bool {
        if self.part == PerformancePart::Idle {
            return *self == Self::default();
        }
        let Some(activity) = activities.get(ActivityId(self.activity)) else { return false };
        let times = [self.seconds, self.left].iter().all(|t| (0.0..=activity.duration_s).contains(t));
        let shares = [self.cross, self.share].iter().all(|s| (0.0..=1.0).contains(s));
        let part = activity.looped_s.is_some() || !matches!(self.part, PerformancePart::Loop | PerformancePart::End);
        let next = self.next.is_none_or(|n| n.check(activities).is_ok());
        times && shares && part && next && self.heading.abs() < 1e6 && self.rate.abs() < 1e3
    }
}

impl Activity {
    /// Time at which the activity begins to fade, unless something ends it before (s).
    pub fn fades_s(&self) -> f32 {
        (self.duration_s - LEAD_S).max(0.0)
    }
}

impl Performance {
    /// Checks that there is such an activity, and the heading.
    ///
    /// # Errors
    /// [`throng_base::Error::Index`], [`throng_base::Error::Value`].
    pub(super) fn check(&self, activities: &ActivitySet) -> throng_base::Result<()> {
        throng_base::error::check_index("activity", None, self.activity.0 as usize, activities.activities().len())?;
        super::config::check_moderate("heading", None, self.heading.unwrap_or(0.0))
    }
}

fn walks(control: &Control) -> bool {
    control.velocity.length_squared() > WALKING_MPS * WALKING_MPS
}
