//! Checks of activities: distinct names, frames within their clips, looped parts within the frames.

use super::{super::Bundle, check_unique};
use crate::format::{ActivityMeta, FormatError};
use throng_base::error::ensure;

/// Every activity.
pub fn activities(t: &Bundle) -> Result<(), FormatError> {
    let all = &t.meta().activities;
    check_unique(all.iter().map(|a| &a.name), "META has two activities")?;
    all.iter().try_for_each(|a| {
        let fault = || format!("activity `{}` does not lie in its clip: {a:?}", a.name);
        ensure(is_sound(a, t), || FormatError::layout(fault()))
    })
}

fn is_sound(a: &ActivityMeta, t: &Bundle) -> bool {
    let within = |[first, count]: [u32; 2], limit: u32| u64::from(first) + u64::from(count) <= u64::from(limit);
    let Some(clip) = t.clips().get(a.clip as usize) else { return false };
    let looped = a.looped.is_none_or(|l| l[1] > 0 && within(l, a.num_frames - 1));
    let held = a.object_frames.iter().flatten().all(|h| h[1] > 0 && within(*h, a.num_frames));
    held && a.num_frames > 1 && within([a.first_frame, a.num_frames], clip.num_frames) && looped
}
