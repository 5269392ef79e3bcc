//! Times of the phases of a step.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Instant;

/// Time of each phase of a step, summed over the threads that took part; zero where characters are not timed.
///
/// Ask for it with [`crate::characters::CharactersConfig::timed`]; reading the clock costs a step a few percent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepTimes {
    /// Moving time on, bending paths (s).
    pub advance_s: f64,
    /// Choosing actions, and starting transitions to them (s).
    pub control_s: f64,
    /// Sampling between frames, adding the offsets of transitions, model space (s).
    pub sample_s: f64,
    /// Displacing struck characters (s).
    pub reaction_s: f64,
    /// Holding planted feet (s).
    pub foot_lock_s: f64,
    /// Writing matrices and local transforms (s).
    pub poses_s: f64,
}

impl StepTimes {
    /// Names and times, in the order of a step (s).
    pub fn phases(&self) -> [(&'static str, f64); 6] {
        [
            ("advance", self.advance_s),
            ("control", self.control_s),
            ("sample", self.sample_s),
            ("reaction", self.reaction_s),
            ("foot lock", self.foot_lock_s),
            ("poses", self.poses_s),
        ]
    }

    /// Sum of all phases (s).
    pub fn total_s(&self) -> f64 {
        self.phases().iter().map(|p| p.1).sum()
    }
}

/// A phase of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) enum StepPhase {
    Advance,
    Control,
    Sample,
    Reaction,
    FootLock,
    Poses,
}

/// Adds up the times of a step's phases over all threads.
#[derive(Debug, Default)]
pub(crate) struct PhaseClock([AtomicU64; 6]);

impl PhaseClock {
    pub fn times(&self) -> StepTimes {
        let of = |p: StepPhase| self.0[p as usize].load(Relaxed) as f64 * 1e-9;
        StepTimes {
            advance_s: of(StepPhase::Advance),
            control_s: of(StepPhase::Control),
            sample_s: of(StepPhase::Sample),
            reaction_s: of(StepPhase::Reaction),
            foot_lock_s: of(StepPhase::FootLock),
            poses_s: of(StepPhase::Poses),
        }
    }
}

/// Reads the clock at the end of each phase, where characters are timed.
pub(crate) struct Laps<'a> {
    running: Option<(&'a PhaseClock, Instant)>,
}

impl<'a> Laps<'a> {
    pub fn start(clock: Option<&'a PhaseClock>) -> Self {
        Self { running: clock.map(|c| (c, Instant::now())) }
    }

    /// Adds the time since the last reading to a phase.
    #[inline(always)]
    pub fn end(&mut self, phase: StepPhase) {
        if let Some((clock, since)) = &mut self.running {
            let now = Instant::now();
            clock.0[phase as usize].fetch_add((now - *since).as_nanos() as u64, Relaxed);
            *since = now;
        }
    }
}
