//! Sweeps over all (state, cell) pairs: full ones over every action, and cheap ones over the greedy action only.

use super::{ActionModel, BackupPair, BackupPairs};
use rayon::prelude::*;
use std::ops::Range;
use throng_core::{policy::Reward, simd::vectorize};

/// Row of a segment with a single action, which is backed up with that action; shared ones are backed up once for all.
const PRIVATE: u32 = u32::MAX;

/// Backups of a block of a model's states, and the greedy policy of the last full sweep.
pub(super) struct Sweeper<'a> {
    pairs: BackupPairs,
    model: &'a ActionModel,
    /// Factor that transitions leave of the backups of the block's actions, in order.
    left: Vec<f32>,
    /// States of the block.
    own: Range<usize>,
    /// Row of each segment in `shared`, or [`PRIVATE`].
    shared_rows: Vec<u32>,
    /// Segments of the rows of `shared`.
    shared_segments: Vec<u32>,
    /// Backups of the segments that several actions share (rows * heights * row).
    shared: Vec<f32>,
    /// Greedy pair of every (state of the block, cell), rows in whole lanes.
    greedy: Vec<BackupPair>,
}

/// Scratch memory for one state's backups.
#[derive(Default)]
struct SweepScratch {
    backup: Vec<f32>,
    best: Vec<f32>,
    action: Vec<u32>,
}

impl<'a> Sweeper<'a> {
    /// - `errors`: distance of each action, with its costs.
    pub fn new(pairs: BackupPairs, model: &'a ActionModel, reward: Reward, errors: &[f32], own: Range<usize>) -> Self {
        let mut uses = vec![0u32; model.segments.len()];
        model.segments_of(own.clone()).iter().for_each(|&s| uses[s as usize] += 1);
        let shared_segments: Vec<u32> = (0..uses.len() as u32).filter(|&s| uses[s as usize] > 1).collect();
        let mut shared_rows = vec![PRIVATE; uses.len()];
        shared_segments.iter().zip(0..).for_each(|(&s, row)| shared_rows[s as usize] = row);
        let shape = pairs.shape;
        let per_segment = shape.heights * shape.row();
        let shared = vec![0.0; shared_segments.len() * per_segment];
        let greedy = vec![BackupPair::default(); own.len() * per_segment];
        let errors = &errors[model.actions_of(own.clone())];
        let left = errors.iter().map(|&error| reward.after_transition(error)).collect();
        Self { pairs, model, left, own, shared_rows, shared_segments, shared, greedy }
    }

    /// Number of values, spare columns included.
    pub fn num_values(&self) -> usize {
        self.model.num_states() * self.pairs.shape.value_row()
    }

    /// Number of values of the block, spare columns included.
    pub fn num_own_values(&self) -> usize {
        self.own.len() * self.value_row()
    }

    /// Number of values of one state, spare columns included.
    pub fn value_row(&self) -> usize {
        self.pairs.shape.value_row()
    }

    /// Runs a full sweep: `next`, of the block, becomes the best backup of `values`, of all; stores the greedy policy.
    ///
    /// Returns the largest change. Every state reads only `values`, so that the split over threads does not matter.
    pub fn full(&mut self, values: &[f32], next: &mut [f32]) -> f32 {
        let Self { pairs, model, left, own, shared_rows, shared_segments, shared, greedy } = self;
        let shape = pairs.shape;
        let (row, plane) = (shape.row(), shape.value_plane());
        shared.par_chunks_mut(shape.heights * row).zip(&*shared_segments).for_each(|(out, &segment)| {
            vectorize(
                #[inline(always)]
                || {
                    for (h, out) in out.chunks_exact_mut(row).enumerate() {
                        let at = pairs.end[segment as usize] as usize * shape.value_row() + h * plane;
                        pairs.back_up(segment as usize, h, &values[at..at + plane], out);
                    }
                },
            );
        });
        let first_action = model.action_offsets[own.start] as usize;
        let view = BackupView { pairs, model, left, first_action, shared_rows, shared, values };
        let rows = next.par_chunks_mut(shape.value_row()).zip(greedy.par_chunks_mut(shape.heights * row));
        rows.enumerate()
            .map_init(SweepScratch::default, |scratch, (n, (next, greedy))| {
                vectorize(
                    #[inline(always)]
                    || view.state(own.start + n, next, greedy, scratch),
                )
            })
            .reduce(|| 0.0, f32::max)
    }

    /// Runs a sweep over the greedy actions of the block: `next` becomes their backup of `values`. Returns the largest
    /// change.
    pub fn greedy(&self, values: &[f32], next: &mut [f32]) -> f32 {
        let shape = self.pairs.shape;
        let (row, plane, stride, angles) = (shape.row(), shape.value_plane(), shape.stride(), shape.angles);
        let own = &values[self.own.start * shape.value_row()..self.own.end * shape.value_row()];
        let states = next.par_chunks_mut(shape.value_row()).zip(own.par_chunks(shape.value_row()));
        let states = states.zip(self.greedy.par_chunks(shape.heights * row));
        states
            .map(|((next, old), greedy)| {
                let mut change = 0.0f32;
                let planes = next.chunks_exact_mut(plane).zip(old.chunks_exact(plane)).zip(greedy.chunks_exact(row));
                for ((next, old), greedy) in planes {
                    let rings = next.chunks_exact_mut(stride).zip(old.chunks_exact(stride));
                    for ((next, old), greedy) in rings.zip(greedy.chunks_exact(angles)) {
                        for c in 0..angles {
                            next[c] = greedy[c].back_up(values, stride);
                            change = change.max((next[c] - old[c]).abs());
                        }
                        next[angles] = next[0];
                    }
                }
                change
            })
            .reduce(|| 0.0, f32::max)
    }
}

/// Inputs of the backup of a state.
struct BackupView<'a> {
    pairs: &'a BackupPairs,
    model: &'a ActionModel,
    /// Factor that the transition of each own action leaves of its backup.
    left: &'a [f32],
    /// Number of the first of these actions.
    first_action: usize,
    shared_rows: &'a [u32],
    shared: &'a [f32],
    values: &'a [f32],
}

impl BackupView<'_> {
    /// Backs up one state over all its actions. Returns the largest change.
    #[inline(always)]
    fn state(&self, state: usize, next: &mut [f32], greedy: &mut [BackupPair], scratch: &mut SweepScratch) -> f32 {
        let shape = self.pairs.shape;
        let (row, plane) = (shape.row(), shape.value_plane());
        let segments = self.model.segments_of(state..state + 1);
        let actions = self.model.actions_of(state..state + 1);
        let left = &self.left[actions.start - self.first_action..actions.end - self.first_action];
        scratch.backup.resize(row, 0.0);
        scratch.action.resize(row, 0);
        let old = &self.values[state * shape.value_row()..][..shape.value_row()];
        let mut change = 0.0f32;
        for h in 0..shape.heights {
            scratch.best.clear();
            scratch.best.resize(row, f32::NEG_INFINITY);
            for (a, &segment) in segments.iter().enumerate() {
                let backup = self.backup(segment as usize, h, &mut scratch.backup);
                keep_best(backup, left[a], a as u32, &mut scratch.best, &mut scratch.action);
            }
            for (c, pair) in greedy[h * row..][..row].iter_mut().enumerate() {
                let action = scratch.action[c] as usize;
                *pair = self.pairs.pair(segments[action] as usize, h, c).scaled(left[action]);
            }
            let next = &mut next[h * plane..][..plane];
            shape.store(&scratch.best[..shape.plane()], next);
            let changes = next.iter().zip(&old[h * plane..][..plane]).map(|(n, o)| (n - o).abs());
            change = changes.fold(change, f32::max);
        }
        change
    }

    /// Backups of one segment: looked up if shared, else computed in `scratch`.
    #[inline(always)]
    fn backup<'b>(&'b self, segment: usize, height: usize, scratch: &'b mut [f32]) -> &'b [f32] {
        let shape = self.pairs.shape;
        if self.shared_rows[segment] != PRIVATE {
            let at = self.shared_rows[segment] as usize * shape.heights + height;
            return &self.shared[at * shape.row()..][..shape.row()];
        }
        let at = self.pairs.end[segment] as usize * shape.value_row() + height * shape.value_plane();
        self.pairs.back_up(segment, height, &self.values[at..at + shape.value_plane()], scratch);
        scratch
    }
}

/// Stores an action in the cells with a better backup; on a tie the first stays.
///
/// - `left`: factor that its transition leaves of the backup.
#[inline(always)]
fn keep_best(backup: &[f32], left: f32, action: u32, best: &mut [f32], actions: &mut [u32]) {
    for ((&q, best), noted) in backup.iter().zip(best).zip(actions) {
        let q = left * q;
        let better = q > *best;
        *noted = if better { action } else { *noted };
        *best = if better { q } else { *best };
    }
}
