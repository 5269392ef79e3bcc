//! Glitches of recordings, for every view of a clip over time: frames, colours and descriptions.

use crate::{document::RawMotion, model::Model, theme::ThemePalette};
use eframe::egui::Color32;
use std::ops::Range;
use throng_core::format::ClipMeta;
use throng_precompute::clip::ExclusionReason;
use throng_precompute::import::{Glitch, GlitchTreatment};

/// A glitch of a clip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GlitchMark {
    /// Frames of the glitch.
    pub frames: Range<u32>,
    /// Treatment of the glitch.
    pub treated: GlitchTreatment,
    /// Description of the glitch and its treatment.
    pub words: String,
}

/// Glitches of a motion file, in frames of the file.
pub fn raw_glitches(raw: &RawMotion) -> Vec<GlitchMark> {
    let mark = |g: &Glitch| {
        let (kind, treated) = (g.kind.name(), g.treated);
        let frames = g.frames.start as u32..g.frames.end as u32;
        GlitchMark { frames, treated, words: format!("{kind}: {g} ({})", treated.name()) }
    };
    raw.imported.glitches.iter().map(mark).collect()
}

/// Glitches of a clip of a bundle, which only records those that were cut out.
pub fn clip_glitches(meta: &ClipMeta) -> Vec<GlitchMark> {
    let cut = meta.excluded.iter().filter(|e| e.0 == ExclusionReason::Glitch.to_string());
    let mark = |(_, start, end): &(String, u32, u32)| {
        let words = format!("glitch: frames {start} to {} ({})", end.saturating_sub(1), GlitchTreatment::Cut.name());
        GlitchMark { frames: *start..*end, treated: GlitchTreatment::Cut, words }
    };
    cut.map(mark).collect()
}

/// Glitches of the shown clip, in the frames of its player.
pub fn shown_glitches(model: &Model) -> Vec<GlitchMark> {
    if let Some(raw) = model.document.raw_motion() {
        return raw_glitches(raw);
    }
    let clip = model.document.bundle().and_then(|b| b.clips().nth(model.selection.clip));
    clip.map_or_else(Vec::new, |(_, meta)| clip_glitches(meta))
}

/// Colour of a treatment.
pub fn colour(palette: &ThemePalette, treated: GlitchTreatment) -> Color32 {
    match treated {
        GlitchTreatment::Cut => palette.excluded,
        GlitchTreatment::Bridged => palette.good,
        GlitchTreatment::Kept => palette.warning,
    }
}
