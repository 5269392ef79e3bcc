//! Glitches of recordings, for every view of a clip over time: frames, colours and descriptions.

use crate::document::RawMotion;
use crate::model::Model;
use crate::theme::Palette;
use eframe::egui::Color32;
use std::ops::Range;
use throng_precompute::clip::ExclusionReason;
use throng_precompute::import::{Glitch, Treated};
use throng_runtime::format::ClipMeta;

/// A glitch of a clip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Frames of the glitch.
    pub frames: Range<u32>,
    /// Treatment of the glitch.
    pub treated: Treated,
    /// Description of the glitch and its treatment.
    pub words: String,
}

/// Glitches of a motion file, in frames of the file.
pub fn of_raw(raw: &RawMotion) -> Vec<Mark> {
    let mark = |g: &Glitch| {
        let (kind, treated) = (g.kind.name(), g.treated);
        let frames = g.frames.start as u32..g.frames.end as u32;
        Mark { frames, treated, words: format!("{kind}: {g} ({})", treated.name()) }
    };
    raw.imported.glitches.iter().map(mark).collect()
}

/// Glitches of a clip of a bundle, which only records those that were cut out.
pub fn of_clip(meta: &ClipMeta) -> Vec<Mark> {
    let cut = meta.excluded.iter().filter(|e| e.0 == ExclusionReason::Glitch.to_string());
    let mark = |(_, start, end): &(String, u32, u32)| {
        let words = format!("glitch: frames {start} to {} ({})", end.saturating_sub(1), Treated::Cut.name());
        Mark { frames: *start..*end, treated: Treated::Cut, words }
    };
    cut.map(mark).collect()
}

/// Glitches of the shown clip, in the frames of its player.
pub fn shown(model: &Model) -> Vec<Mark> {
    if let Some(raw) = model.document.raw_motion() {
        return of_raw(raw);
    }
    let clip = model.document.bundle().and_then(|b| b.clips().nth(model.selection.clip));
    clip.map_or_else(Vec::new, |(_, meta)| of_clip(meta))
}

/// Colour of a treatment.
pub fn colour(palette: &Palette, treated: Treated) -> Color32 {
    match treated {
        Treated::Cut => palette.excluded,
        Treated::Bridged => palette.good,
        Treated::Kept => palette.warning,
    }
}
