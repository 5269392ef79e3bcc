//! Generic time: the clock that all examples share; it only moves forward (Kim, Kim and Shin 2003a, section 4.2.2).

use super::records::{ChannelRow, ExampleRecord, channel};
use super::space::BlendSpace;
use throng_base::simd::{LANES, LaneWork, Lanes, dispatch};
use throng_base::{Result, error::check_length};

/// Generic time before and after a contact over which its importance rises and falls.
const RAMP: f32 = 0.1;

/// The timing channels, rearranged in rows like those of the weights, as each step reads them.
#[derive(Clone, Debug)]
pub(crate) struct PhaseTiming {
    stride: usize,
    /// Seconds per unit of generic time between a row and the next (num_phases * stride).
    rates: Vec<f32>,
    /// Time from the begin of the cycle to a row (s, num_phases * stride).
    elapsed: Vec<f32>,
    /// The smallest rate of an example between a row and the next (num_phases).
    floors: Vec<f32>,
    /// Importance of each foot's position, 0 to 1: left, right (num_phases * 2 * stride).
    importance: Vec<f32>,
    /// Duration of a cycle, and its displacement in the facing frame (left, ahead) (s, m, 3 * stride).
    cycle: Vec<f32>,
}

impl PhaseTiming {
    /// Extracts the timing from the channels of a space; `None` if a rate is not positive.
    pub fn new(examples: &[ExampleRecord], channels: &[ChannelRow], stride: usize) -> Option<Self> {
        let n = examples.len();
        let rows = channels.chunks_exact(n);
        let num_phases = rows.len();
        let good = |c: &ChannelRow| c.values[channel::RATE].is_finite() && c.values[channel::RATE] > 0.0;
        if !channels.iter().all(good) {
            return None;
        }
        let mut rates = vec![0.0; num_phases * stride];
        let mut floors = vec![f32::INFINITY; num_phases];
        let mut importance = vec![0.0; num_phases * 2 * stride];
        for (k, row) in rows.clone().enumerate() {
            for (e, c) in row.iter().enumerate() {
                rates[k * stride + e] = c.values[channel::RATE];
                floors[k] = floors[k].min(c.values[channel::RATE]);
            }
        }
        for (side, contact) in [channel::LEFT_CONTACT, channel::RIGHT_CONTACT].into_iter().enumerate() {
            for e in 0..n {
                let down: Vec<f32> = rows.clone().map(|row| row[e].values[contact]).collect();
                for k in 0..num_phases {
                    importance[(2 * k + side) * stride + e] = importance_at(&down, k);
                }
            }
        }
        let mut elapsed = vec![0.0; rates.len()];
        for k in 1..num_phases {
            for e in 0..n {
                let before = (k - 1) * stride + e;
                elapsed[k * stride + e] = elapsed[before] + rates[before] / num_phases as f32;
            }
        }
        let mut cycle = vec![0.0; 3 * stride];
        for (e, example) in examples.iter().enumerate() {
            let [x, z] = example.velocity.map(|v| v * example.duration_s);
            [cycle[e], cycle[stride + e], cycle[2 * stride + e]] = [example.duration_s, x, z];
        }
        Some(Self { stride, rates, elapsed, floors, importance, cycle })
    }

    fn num_phases(&self) -> usize {
        self.floors.len()
    }

    /// Seconds per unit of generic time between a row and the next: the blend of the examples' rates, but at least the
    /// smallest of them, so that time moves forward for any weights.
    #[inline(always)]
    fn rate<F: Lanes>(&self, weights: &[f32], row: usize) -> f32 {
        let blended = dot::<F>(weights, &self.rates[row * self.stride..][..self.stride]);
        let floor = self.floors[row];
        // NaN and infinity give the floor too.
        if blended > floor && blended < 1e6 { blended } else { floor }
    }

    /// Generic time `seconds` after `phase`, integrated over rates that are constant from row to row.
    #[inline(always)]
    pub fn advance<F: Lanes>(&self, weights: &[f32], phase: f32, seconds: f32) -> f32 {
        let n = self.num_phases();
        let mut left = if seconds > 0.0 && seconds.is_finite() { f64::from(seconds) } else { 0.0 };
        let mut at = wrap(phase);
        let mut row = ((at * n as f32) as usize).min(n - 1);
        let (mut cycle_s, mut rows_passed) = (0.0, 0);
        loop {
            let rate = f64::from(self.rate::<F>(weights, row));
            let end = (row + 1) as f32 / n as f32;
            let needed = f64::from(end - at) * rate;
            if left < needed {
                let to = (f64::from(at) + left / rate) as f32;
                return wrap(to.min(end).max(at));
            }
            left -= needed;
            at = end;
            row += 1;
            if row == n {
                (row, at) = (0, 0.0);
            }
            // Whole cycles make no difference.
            cycle_s += rate / n as f64;
            rows_passed += 1;
            if rows_passed == n {
                left %= cycle_s;
            }
        }
    }

    /// Time from the begin of an example's cycle to a generic time (s).
    pub fn seconds_of(&self, example: usize, phase: f32) -> f32 {
        let n = self.num_phases();
        let at = wrap(phase) * n as f32;
        let row = (at as usize).min(n - 1);
        let k = row * self.stride + example;
        self.elapsed[k] + self.rates[k] * (at - row as f32) / n as f32
    }

    /// Duration and displacement of a cycle of the blend (s, m).
    #[inline(always)]
    pub fn cycle<F: Lanes>(&self, weights: &[f32]) -> [f32; 3] {
        let mut cycle = [0.0; 3];
        for (i, sum) in cycle.iter_mut().enumerate() {
            *sum = dot::<F>(weights, &self.cycle[i * self.stride..][..self.stride]);
        }
        cycle
    }

    /// Importance of the positions of the left and right foot, 0 to 1.
    #[inline(always)]
    pub fn importance<F: Lanes>(&self, weights: &[f32], [from, to]: [usize; 2], ratio: f32) -> [f32; 2] {
        let mut both = [0.0; 2];
        for (side, importance) in both.iter_mut().enumerate() {
            let a = dot::<F>(weights, &self.importance[(2 * from + side) * self.stride..][..self.stride]);
            let b = dot::<F>(weights, &self.importance[(2 * to + side) * self.stride..][..self.stride]);
            *importance = (a + (b - a) * ratio).clamp(0.0, 1.0);
        }
        both
    }
}

/// The fraction of a number, in 0..1; 0 for numbers that are not finite.
#[inline(always)]
fn wrap(phase: f32) -> f32 {
    let at = phase - phase.floor();
    if at < 1.0 { at } else { 0.0 }
}

/// A contact's importance at a row: 1 within it, falling off smoothly before and after.
fn importance_at(down: &[f32], row: usize) -> f32 {
    let n = down.len();
    let reach = (RAMP * n as f32) as usize;
    let mut most = 0.0f32;
    for d in 0..=reach {
        let x = 1.0 - d as f32 / (RAMP * n as f32).max(1.0);
        let ramp = x * x * (3.0 - 2.0 * x);
        most = most.max(down[(row + d) % n] * ramp).max(down[(row + n - d % n) % n] * ramp);
    }
    most.clamp(0.0, 1.0)
}

/// Dot product of two rows, summed in an order that does not depend on the processor.
#[inline(always)]
pub(crate) fn dot<F: Lanes>(a: &[f32], b: &[f32]) -> f32 {
    let mut sum = F::splat(0.0);
    for (a, b) in a.as_chunks::<LANES>().0.iter().zip(b.as_chunks::<LANES>().0) {
        sum = sum + F::load(a) * F::load(b);
    }
    let s = sum.to_array();
    ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]))
}

impl BlendSpace {
    /// Advances the generic time of each query by incremental time-warping (Kim, Kim and Shin 2003a, section 4.2.2): the
    /// rates of the examples are blended, never their times, so that time moves forward for any weights and any change
    /// of them. If weights extrapolate, a rate is at least that of the fastest example. Allocates nothing.
    ///
    /// - `weights`: a row each, as [`BlendSpace::weights`] gives it (phases.len() * stride).
    /// - `seconds`: time step; negative and NaN count as 0 (s, phases.len()).
    /// - `phases`: generic time; in 0..1 afterwards.
    ///
    /// # Errors
    /// [`Error::Length`](throng_base::Error::Length) if the lengths of the slices do not match.
    pub fn advance(&self, weights: &[f32], seconds: &[f32], phases: &mut [f32]) -> Result<()> {
        check_length("weights", weights.len(), phases.len() * self.stride())?;
        check_length("seconds", seconds.len(), phases.len())?;
        dispatch(AdvancePhasesJob { space: self, weights, seconds, phases });
        Ok(())
    }
}

struct AdvancePhasesJob<'a> {
    space: &'a BlendSpace,
    weights: &'a [f32],
    seconds: &'a [f32],
    phases: &'a mut [f32],
}

impl LaneWork for AdvancePhasesJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        let rows = self.weights.chunks_exact(self.space.stride());
        for ((weights, &seconds), phase) in rows.zip(self.seconds).zip(self.phases) {
            *phase = self.space.timing.advance::<F>(weights, *phase, seconds);
        }
    }
}
