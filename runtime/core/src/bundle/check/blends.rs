//! Blend spaces: ranges tile their sections, numbers are moderate, references are unit, rates positive.

use super::super::{Bundle, tags};
use super::{LONGEST_BONE, check_unique, check_used, refuse};
use crate::blend::{
    BlendRecord, BlendSpace, ChannelRow, ExampleRecord, MAX_AXES, MAX_KNOTS, MAX_WEIGHT, NUM_CHANNELS, PADDED_JOINTS,
    ReferenceRow, axis, channel,
};
use crate::{format::FormatError, skeleton::NUM_JOINTS};
use throng_base::error::ensure;

/// Numbers of examples and channels stay below this.
const FAR: f32 = 1e4;
/// Axes are wider: narrower ones are below what is measured of motion.
const NARROWEST: f32 = 1e-4;
/// Rows of a posture table: what is looked for in them grows with their square.
const MOST_PHASES: u32 = 4096;
/// Log-displacements stay below this; a whole turn is pi (rad / 2).
const FARTHEST_TURN: f32 = 10.0;
/// Hips are nearer to the arc, and hands and ankles to the hips (m).
const FARTHEST_JOINT: f32 = 4.0 * LONGEST_BONE;
/// Largest deviation of the sum of a weight row from 1.
const SUM_TOLERANCE: f32 = 1e-4;
/// Frames more than a cycle ends within: it may end between two frames.
const FRAME: u64 = 1;

/// Every blend space, and nothing left over.
pub fn blends(t: &Bundle) -> Result<(), FormatError> {
    let all = t.blends();
    let mut next = [0u64; 4];
    let lengths = [all.examples.len(), all.weights.len(), all.references.len(), all.channels.len()];
    for (i, b) in all.spaces.iter().enumerate() {
        let error = |fault: &str| FormatError::value(tags::BLENDS, i, format!("{fault}: {b:?}"));
        let axes = || error(&format!("its axes cannot be, or are narrower than {NARROWEST}"));
        let knots = knots(b).ok_or_else(axes)?;
        let (n, phases) = (u64::from(b.num_examples), u64::from(b.num_phases));
        let stride = n.next_multiple_of(8);
        let fits = n > 0 && u64::from(b.weight_stride) == stride && b.extrapolate <= 1;
        let fault = || format!("it has no examples, not 2 to {MOST_PHASES} phases, or its rows have another length");
        ensure(fits && (2..=MOST_PHASES).contains(&b.num_phases), || error(&fault()))?;
        ensure((0.0..MAX_WEIGHT).contains(&b.max_weight_error), || error("its error cannot be"))?;
        let starts = [b.first_example, b.first_weight, b.first_row, b.first_channel_row];
        let sizes = [n, knots.saturating_mul(stride), phases, phases.saturating_mul(n)];
        for (((next, start), size), len) in next.iter_mut().zip(starts).zip(sizes).zip(lengths) {
            let follows = u64::from(start) == *next && next.saturating_add(size) <= len as u64;
            ensure(follows, || error("its examples or rows do not follow those of the space before it"))?;
            *next += size;
        }
        let part = |k: usize| (next[k] - sizes[k]) as usize..next[k] as usize;
        examples(t, b, &all.examples[part(0)])?;
        weights(b, &all.weights[part(1)])?;
        references(b, &all.references[part(2)])?;
        channels(b, &all.channels[part(3)])?;
    }
    let tags = [tags::BLEND_EXAMPLES, tags::BLEND_WEIGHTS, tags::BLEND_REFERENCES, tags::BLEND_CHANNELS];
    let mut sections = tags.into_iter().zip(lengths).zip(next);
    sections.try_for_each(|((tag, len), used)| check_used(tag, len, used, "blend spaces"))?;
    names(t)?;
    (0..all.spaces.len()).try_for_each(|i| BlendSpace::new(all, i).map(drop))
}

/// Number of knots of a space's weight table, or nothing where an axis cannot be.
fn knots(b: &BlendRecord) -> Option<u64> {
    let (used, rest) = b.axes.split_at_checked(b.num_axes as usize).filter(|(used, _)| !used.is_empty())?;
    let moderate = used.iter().all(|a| a.high - a.low > NARROWEST && a.low.abs() < FAR && a.high.abs() < FAR);
    let kinds = used.iter().all(|a| a.kind <= axis::GYRATION && a.num_knots >= 2);
    let unused = rest.iter().all(|a| *a == Default::default());
    let knots = used.iter().fold(1u64, |n, a| n.saturating_mul(u64::from(a.num_knots)));
    (moderate && kinds && unused && knots <= u64::from(MAX_KNOTS)).then_some(knots)
}

/// Every space has a name of its own, and names for its axes and examples.
fn names(t: &Bundle) -> Result<(), FormatError> {
    let (names, records) = (&t.meta().blends, &t.blends().spaces);
    let fault = || format!("META names {} blend spaces, there are {}", names.len(), records.len());
    ensure(names.len() == records.len(), || FormatError::layout(fault()))?;
    for (name, b) in names.iter().zip(records) {
        let fault = || format!("META names other axes or examples of blend space `{}` than there are", name.name);
        let same = name.axes.len() == b.num_axes as usize && name.examples.len() == b.num_examples as usize;
        ensure(same, || FormatError::layout(fault()))?;
    }
    check_unique(names.iter().map(|b| &b.name), "META names two blend spaces")
}

/// Examples lie in their clips, and their numbers are moderate.
fn examples(t: &Bundle, b: &BlendRecord, examples: &[ExampleRecord]) -> Result<(), FormatError> {
    for (i, e) in examples.iter().enumerate() {
        let index = b.first_example as usize + i;
        let error = |fault: &str| FormatError::value(tags::BLEND_EXAMPLES, index, format!("{fault}: {e:?}"));
        let moderate = e.parameters.iter().chain(&e.velocity).chain([&e.gyration]).all(|v| v.abs() < FAR);
        let unused = e.parameters[(b.num_axes as usize).min(MAX_AXES)..].iter().all(|p| *p == 0.0);
        let good = moderate && unused && e.duration_s > 0.0 && e.duration_s < FAR;
        ensure(good, || error("it holds a number that cannot be"))?;
        let known = ExampleRecord::IS_STILL | ExampleRecord::IS_MIRRORED;
        let moves = e.flags & ExampleRecord::IS_STILL == 0;
        let within = e.keytimes.iter().all(|k| (0.0..1.0).contains(k));
        let good = e.flags & !known == 0 && e.reserved == 0 && within && (moves || e.keytimes == [0.0; 3]);
        ensure(good, || error("its flags or keytimes cannot be"))?;
        let clip = t.clips().get(e.clip as usize).ok_or_else(|| error("no such clip"))?;
        let end = u64::from(e.first_frame) + u64::from(e.num_frames);
        let within = e.num_frames > 0 && end <= u64::from(clip.num_frames) + FRAME;
        ensure(within, || error("it leaves its clip"))?;
    }
    Ok(())
}

/// Weights sum to one; those beyond the examples are zero.
fn weights(b: &BlendRecord, weights: &[f32]) -> Result<(), FormatError> {
    let (stride, n) = (b.weight_stride as usize, b.num_examples as usize);
    for (row, w) in weights.chunks_exact(stride).enumerate() {
        let moderate = w.iter().all(|w| w.abs() < MAX_WEIGHT) && w[n..].iter().all(|w| *w == 0.0);
        let scale = w.iter().fold(1.0f32, |s, w| s.max(w.abs()));
        let good = moderate && (w.iter().sum::<f32>() - 1.0).abs() <= SUM_TOLERANCE * scale;
        let fault = || format!("this row's weights do not sum to 1, or one is not below {MAX_WEIGHT}");
        let index = b.first_weight as usize + row * stride;
        ensure(good, || FormatError::value(tags::BLEND_WEIGHTS, index, fault()))?;
    }
    Ok(())
}

/// References are unit, the identity beyond the joints, and on the same side as those of the phase after them.
fn references(b: &BlendRecord, rows: &[ReferenceRow]) -> Result<(), FormatError> {
    let of = |row: &ReferenceRow, j: usize| row.components.map(|c| c[j]);
    let dot = |p: [f32; 4], q: [f32; 4]| (0..4).map(|k| p[k] * q[k]).sum::<f32>();
    for (i, row) in rows.iter().enumerate() {
        let error = |fault| FormatError::value(tags::BLEND_REFERENCES, b.first_row as usize + i, fault);
        let next = &rows[(i + 1) % rows.len()];
        for j in 0..PADDED_JOINTS {
            let q = of(row, j);
            let is_joint = j < NUM_JOINTS || q == [0.0, 0.0, 0.0, 1.0];
            let good = (dot(q, q) - 1.0).abs() < 1e-3 && is_joint;
            ensure(good, || error("it holds a rotation that is not unit, or one of no joint"))?;
            ensure(dot(q, of(next, j)) > 0.0, || error("its rotations do not continue in the next"))?;
        }
    }
    Ok(())
}

/// Channels are moderate, rates positive, contacts shares; what belongs to no joint or channel is zero.
fn channels(b: &BlendRecord, rows: &[ChannelRow]) -> Result<(), FormatError> {
    let is_good = |row: &ChannelRow| {
        let v = &row.values;
        let moderate = v.iter().all(|v| v.abs() < FAR);
        let turns = v[..channel::HIPS].iter().all(|v| v.abs() < FARTHEST_TURN);
        let places = v[channel::HIPS..channel::RATE].iter().all(|v| v.abs() < FARTHEST_JOINT);
        let log = channel::LOG.iter().all(|&at| v[at + NUM_JOINTS..at + PADDED_JOINTS].iter().all(|v| *v == 0.0));
        let end = v[channel::GYRATION + 1..NUM_CHANNELS].iter().all(|v| *v == 0.0);
        let shares = v[channel::LEFT_CONTACT..channel::VELOCITY].iter().all(|v| (0.0..=1.0).contains(v));
        moderate && turns && places && log && end && shares && v[channel::RATE] > 0.0
    };
    let bad = rows.iter().position(|row| !is_good(row)).map(|i| b.first_channel_row as usize + i);
    refuse(tags::BLEND_CHANNELS, bad, "it holds a number that cannot be")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blend::{AxisRecord, Blends};
    use crate::skeleton::Skeleton;
    use bytemuck::Zeroable;

    fn record(high: f32) -> BlendRecord {
        let speed = AxisRecord { kind: axis::SPEED, num_knots: 2, low: 0.0, high };
        let mut b = BlendRecord {
            num_axes: 1,
            num_examples: 2,
            num_phases: 2,
            weight_stride: 8,
            extrapolate: 1,
            ..Zeroable::zeroed()
        };
        b.axes[0] = speed;
        b
    }

    /// Two examples, so far apart.
    fn blends(apart: f32) -> Blends {
        let example = |at: f32| ExampleRecord {
            parameters: [at, 0.0, 0.0, 0.0, 0.0, 0.0],
            duration_s: 1.0,
            ..Zeroable::zeroed()
        };
        let mut row = ChannelRow::zeroed();
        row.values[channel::RATE] = 1.0;
        Blends {
            spaces: vec![record(1.0)].into(),
            examples: vec![example(0.0), example(apart)].into(),
            weights: vec![0.0; 16].into(),
            references: vec![ReferenceRow::zeroed(); 2].into(),
            channels: vec![row; 4].into(),
            names: vec!["a".into()],
            skeleton: Skeleton::default(),
        }
    }

    #[test]
    fn axes_are_so_wide_and_examples_so_far_apart_that_slopes_have_bounds() {
        assert_eq!([1e-40, 1e-6, 1e-3, 2.0].map(|high| knots(&record(high))), [None, None, Some(2), Some(2)]);
        assert!(BlendSpace::new(&blends(1e-3), 0).is_ok());
        let e = BlendSpace::new(&blends(5e-5), 0).unwrap_err().to_string();
        assert!(e.contains("so near to each other"), "{e}");
    }

    #[test]
    fn joints_lie_by_the_body_and_weights_have_bounds() {
        let with = |at: usize, to: f32| {
            let mut row = blends(1.0).channels[0];
            row.values[at] = to;
            channels(&record(1.0), &[row])
        };
        for at in [channel::HIPS, channel::LEFT_ANKLE + 1, channel::RIGHT_HAND + 2] {
            assert!(with(at, 39.0).is_ok() && with(at, -90.0).is_err(), "{at}");
        }
        assert!(with(0, 3.0).is_ok() && with(0, 20.0).is_err() && with(channel::VELOCITY, 20.0).is_ok());
        let of = |w: f32| weights(&record(1.0), &[w, 1.0 - w, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!(of(900.0).is_ok() && of(1100.0).is_err());
    }
}
