//! Frames of a bundle that may be played.

use std::ops::Range;
use throng_core::Bundle;

/// Runs of usable frames, in order: those of each clip between the frames that were excluded.
pub fn runs(tables: &Bundle) -> Vec<Range<u32>> {
    let mut out = Vec::new();
    for (clip, meta) in tables.clips().iter().zip(&tables.meta().clips) {
        let mut from = 0;
        for (_, start, end) in &meta.excluded {
            out.push(from..*start);
            from = from.max(*end);
        }
        out.push(from..clip.num_frames);
        let first = out.len() - meta.excluded.len() - 1;
        for run in &mut out[first..] {
            *run = run.start + clip.first_frame..run.end.min(clip.num_frames) + clip.first_frame;
        }
    }
    out.retain(|r| r.start < r.end);
    out
}
