//! Checks of activities: distinct names, frames within their clips, looped parts within the frames.

use super::super::Bundle;
use crate::format::{ActivityMeta, FormatError};

/// Every activity.
pub fn activities(t: &Bundle) -> Result<(), FormatError> {
    let all = &t.meta().activities;
    let mut names: Vec<&str> = all.iter().map(|a| a.name.as_str()).collect();
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(FormatError::layout(format!("META has two activities `{}`", pair[0])));
    }
    match all.iter().find(|a| !is_sound(a, t)) {
        Some(a) => Err(FormatError::layout(format!("activity `{}` does not lie in its clip: {a:?}", a.name))),
        None => Ok(()),
    }
}

fn is_sound(a: &ActivityMeta, t: &Bundle) -> bool {
    let within = |[first, count]: [u32; 2], limit: u32| u64::from(first) + u64::from(count) <= u64::from(limit);
    let Some(clip) = t.clips().get(a.clip as usize) else { return false };
    let looped = a.looped.is_none_or(|l| l[1] > 0 && within(l, a.num_frames - 1));
    let held = a.object_frames.iter().flatten().all(|h| h[1] > 0 && within(*h, a.num_frames));
    held && a.num_frames > 1 && within([a.first_frame, a.num_frames], clip.num_frames) && looped
}
