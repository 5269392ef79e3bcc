//! Frames of a bundle that may be played.

use std::ops::Range;
use throng_core::{Bundle, format::MotionClass};

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

/// A value of each frame's class, in a bundle's frames; `usual` where a frame has none.
pub(crate) fn of_classes<'a, T: Clone>(
    tables: &'a Bundle,
    usual: T,
    mut of: impl FnMut(&'a MotionClass) -> T,
) -> Vec<T> {
    let mut out = vec![usual; tables.frames().len()];
    for (record, meta) in tables.clips().iter().zip(&tables.meta().clips) {
        for span in &meta.classes {
            let [from, to] = [span.frames.start, span.frames.end].map(|f| (record.first_frame + f) as usize);
            out[from..to].fill(of(&span.class));
        }
    }
    out
}
