//! Moments of a run that are kept as they were seen, and the play head that goes over them.

use super::STEP_HZ;
use std::time::{Duration, Instant};
use std::{collections::VecDeque, ops::RangeInclusive};

/// Longest time that is spent on the steps of a frame, at least one step apart.
const BUDGET: Duration = Duration::from_millis(50);
/// Steps that are kept at most.
const MAX_STEPS: usize = 60 * STEP_HZ as usize;
/// Memory that the moments of a run may take (bytes).
const MAX_BYTES: usize = 192 << 20;

/// The play head: which of the recorded steps is shown, and how time moves on.
#[derive(Clone, Copy, Debug)]
pub struct PlayHead {
    first: u32,
    last: u32,
    now: u32,
    playing: bool,
    speed: f32,
    /// Simulated time that has passed but has not been stepped (s).
    owed_s: f32,
}

impl Default for PlayHead {
    fn default() -> Self {
        Self { first: 0, last: 0, now: 0, playing: false, speed: 1.0, owed_s: 0.0 }
    }
}

impl PlayHead {
    /// Steps that can be shown.
    pub fn recorded(&self) -> RangeInclusive<u32> {
        self.first..=self.last
    }

    /// The step that is shown.
    pub fn shown_step(&self) -> u32 {
        self.now
    }

    /// True if the shown step is the latest one.
    pub fn is_live(&self) -> bool {
        self.now == self.last
    }

    /// True where time moves on.
    pub fn is_playing(&self) -> bool {
        self.playing
    }

    /// Speed: simulated seconds per second.
    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// Starts or stops time.
    pub fn play(&mut self, playing: bool) {
        self.playing = playing;
        self.owed_s = 0.0;
    }

    /// Shows a step of another range of recorded steps.
    pub(super) fn record(&mut self, recorded: RangeInclusive<u32>, now: u32) {
        (self.first, self.last, self.now) = (*recorded.start(), *recorded.end(), now);
    }

    /// Plays or stops, as fast, as another one does.
    pub fn play_like(&mut self, other: &Self) {
        self.play(other.playing);
        self.speed = other.speed;
    }

    /// Sets how many simulated seconds pass in one (0.05 to 8, clamped).
    pub fn set_speed(&mut self, speed: f32) {
        self.speed = if speed.is_finite() { speed.clamp(0.05, 8.0) } else { 1.0 };
    }

    /// Shows the nearest recorded step.
    pub fn seek(&mut self, step: u32) {
        self.now = step.clamp(self.first, self.last);
        self.owed_s = 0.0;
    }

    /// Shows the next step that is recorded; false where it has not been lived yet.
    pub fn advance_recorded(&mut self) -> bool {
        let is_kept = !self.is_live();
        self.now += u32::from(is_kept);
        is_kept
    }

    /// Takes wall time that has passed while time moves on, a quarter of a second at most.
    pub fn add_wall_time(&mut self, wall_s: f32) {
        if self.playing {
            self.owed_s += wall_s.clamp(0.0, 0.25) * self.speed;
        }
    }

    /// True if another step is due, which then counts as taken. If steps take longer than the time they simulate, the
    /// remaining time is dropped.
    ///
    /// - `taken`: steps of this frame so far.
    /// - `begin`: when the first of them began.
    pub fn is_due(&mut self, taken: u32, begin: Instant) -> bool {
        if self.owed_s < 1.0 / STEP_HZ {
            return false;
        }
        if taken > 0 && begin.elapsed() > BUDGET {
            self.owed_s = 0.0;
            return false;
        }
        self.owed_s -= 1.0 / STEP_HZ;
        true
    }
}

/// Recorded moments of a run: the last minute, or as many as there is memory for.
#[derive(Clone, Debug)]
pub struct Reel<M> {
    /// Which of them is shown.
    pub head: PlayHead,
    moments: VecDeque<M>,
    most: usize,
}

impl<M> Reel<M> {
    /// A reel that begins with a moment.
    ///
    /// - `moment_bytes`: approximate size of a moment (bytes).
    pub fn new(moment_bytes: usize, first: M) -> Self {
        let most = (MAX_BYTES / moment_bytes.max(1)).clamp(2, MAX_STEPS);
        Self { head: PlayHead::default(), moments: VecDeque::from([first]), most }
    }

    /// Adds a moment and shows it.
    pub fn push(&mut self, moment: M) {
        if self.moments.len() == self.most {
            self.head.first += 1;
            self.moments.pop_front();
        }
        self.moments.push_back(moment);
        self.head.last += 1;
        self.head.now = self.head.last;
    }

    /// Replaces the last moment and shows it.
    pub fn replace(&mut self, moment: M) {
        if let Some(last) = self.moments.back_mut() {
            *last = moment;
        }
        self.head.now = self.head.last;
    }

    /// The moment that is shown.
    pub fn moment(&self) -> &M {
        self.moment_at(self.head.now)
    }

    /// The shown moment and those before it, every `every`-th, over at most so many seconds.
    pub fn moments_before(&self, seconds: f32, every: u32) -> impl Iterator<Item = &M> {
        let from = self.head.now.saturating_sub((seconds * STEP_HZ) as u32).max(self.head.first);
        let steps = (from.next_multiple_of(every)..self.head.now).step_by(every as usize);
        steps.chain([self.head.now]).map(|step| self.moment_at(step))
    }

    fn moment_at(&self, step: u32) -> &M {
        &self.moments[((step - self.head.first) as usize).min(self.moments.len() - 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Room for three numbers.
    fn reel() -> Reel<u32> {
        Reel::new(MAX_BYTES / 3, 0)
    }

    #[test]
    fn recorded_moments_are_shown_again_and_old_ones_dropped() {
        let mut reel = reel();
        (1..=5).for_each(|i| reel.push(i));
        assert_eq!((reel.head.recorded(), *reel.moment(), reel.head.is_live()), (3..=5, 5, true));
        reel.head.seek(0);
        assert_eq!((reel.head.shown_step(), *reel.moment(), reel.head.is_live()), (3, 3, false));
        assert!(reel.head.advance_recorded() && reel.head.advance_recorded() && !reel.head.advance_recorded());
        assert_eq!(*reel.moment(), 5);
        reel.head.seek(4);
        reel.replace(50);
        assert_eq!((*reel.moment(), reel.head.shown_step()), (50, 5));
        assert_eq!(reel.moments_before(1.0, 2).copied().collect::<Vec<_>>(), [4, 50]);
    }

    #[test]
    fn as_many_steps_are_due_as_time_has_passed() {
        let mut head = PlayHead::default();
        let due = |head: &mut PlayHead, wall_s: f32| {
            head.add_wall_time(wall_s);
            let (begin, mut taken) = (Instant::now(), 0);
            while head.is_due(taken, begin) {
                taken += 1;
            }
            taken
        };
        assert_eq!(due(&mut head, 0.1), 0);
        head.play(true);
        assert_eq!([due(&mut head, 2.5 / STEP_HZ), due(&mut head, 2.6 / STEP_HZ)], [2, 3]);
        head.set_speed(0.5);
        head.play(true);
        assert_eq!(due(&mut head, 2.1 / STEP_HZ), 1);
        head.set_speed(f32::NAN);
        assert_eq!(head.speed(), 1.0);
    }
}
