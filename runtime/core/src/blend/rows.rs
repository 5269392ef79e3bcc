//! Frame rows by which a blend can be shown from afar, where only rows of the bundle are at hand.

use super::{records::ExampleRecord, space::BlendSpace};
use crate::format::ClipRecord;

/// Rows of the examples of a blend space.
#[derive(Clone, Debug)]
pub(crate) struct ExampleRows {
    /// Frames a second (Hz).
    rate_hz: f32,
    /// (examples)
    examples: Vec<ExampleRow>,
}

#[derive(Clone, Copy, Debug)]
struct ExampleRow {
    /// First row of the cycle, and of its second half where that is the mirrored first one.
    first: [u32; 2],
    /// Frames from the first row to the last (> 0).
    length: u32,
    /// The second half is the mirrored first one.
    is_halved: bool,
}

/// A row of the bundle and the ratio to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RowPosition {
    pub row: u32,
    pub ratio: f32,
    /// The row after the next one is of the same cycle, too.
    pub has_next: bool,
}

impl ExampleRows {
    /// Finds the rows of all examples; none where an example is of a clip that the bundle lacks.
    pub fn new(examples: &[ExampleRecord], clips: &[ClipRecord], rate_hz: f32) -> Option<Self> {
        let row = |e: &ExampleRecord| {
            let clip = clips.get(e.clip as usize)?;
            // Frames of the clip after the first one of the cycle, which may end one frame past it.
            let left = clip.num_frames.checked_sub(e.first_frame)?.checked_sub(1)?;
            // A mirrored copy follows its original.
            let partner = if clip.mirrored == 1 { (e.clip as usize).checked_sub(1) } else { Some(e.clip as usize + 1) };
            let partner = partner.and_then(|at| clips.get(at));
            let is_image = |other: &&ClipRecord| other.mirrored != clip.mirrored && other.num_frames == clip.num_frames;
            let image = partner.filter(is_image).unwrap_or(clip);
            let is_mirrored = u32::from(e.flags & ExampleRecord::IS_MIRRORED != 0);
            let [own, other] = if clip.mirrored == is_mirrored { [clip, image] } else { [image, clip] };
            let is_still = e.flags & ExampleRecord::IS_STILL != 0;
            let length = if is_still { left.min(1) } else { left.min(e.num_frames) };
            (length > 0).then(|| ExampleRow {
                first: [own, other].map(|clip| clip.first_frame + e.first_frame),
                length,
                is_halved: !is_still && (e.num_frames as f32) < 0.75 * e.duration_s * rate_hz,
            })
        };
        Some(Self { rate_hz, examples: examples.iter().map(row).collect::<Option<_>>()? })
    }
}

impl BlendSpace {
    /// The two examples that weigh most, as rows, and the share of the second one; none where the bundle is not known.
    ///
    /// A blend of more examples is not quite this. (Weights: the row of [`BlendSpace::weights`].)
    pub(crate) fn heaviest_rows(&self, weights: &[f32], phase: f32) -> Option<([RowPosition; 2], f32)> {
        let rows = self.rows.as_ref()?;
        let mut best = [(0, f32::MIN); 2];
        for (e, &weight) in weights[..rows.examples.len()].iter().enumerate() {
            if weight > best[0].1 {
                best = [(e, weight), best[0]];
            } else if weight > best[1].1 {
                best[1] = (e, weight);
            }
        }
        let second = best[1].1.max(0.0);
        let share = second / (best[0].1.max(0.0) + second).max(1e-6);
        let other = if second > 0.0 { best[1].0 } else { best[0].0 };
        Some(([best[0].0, other].map(|e| self.row_of(rows, e, phase)), share))
    }

    fn row_of(&self, rows: &ExampleRows, example: usize, phase: f32) -> RowPosition {
        let e = rows.examples[example];
        let is_second = e.is_halved && phase >= 0.5;
        let begin = if is_second { self.timing.seconds_of(example, 0.5) } else { 0.0 };
        let frames = (self.timing.seconds_of(example, phase) - begin) * rows.rate_hz;
        let frames = frames.clamp(0.0, e.length as f32);
        let whole = (frames as u32).min(e.length - 1);
        let row = e.first[usize::from(is_second)] + whole;
        RowPosition { row, ratio: frames - whole as f32, has_next: whole + 1 < e.length }
    }
}
