//! Frames that are no motion: jumps, flips, freezes, drop-outs. Found by what bodies cannot do, cut out or bridged.
//!
//! A body turns and travels smoothly: a joint that leaves its path for a frame or a few and comes back, one that is elsewhere
//! from one frame to the next, and a body that stops dead while in motion are faults of the recording. Every measure is
//! compared with its surroundings in the clip, so that fast motion is not taken for a fault.

mod find;
mod signal;

use super::roles::RoleMap;
use crate::{clip::FrameRange, error::Warnings, raw::RawClip};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use throng_base::maths;

/// Treatment of glitches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Glitches {
    /// Left out like a range that a sidecar excludes: the database only holds captured motion, but each glitch parts the clip.
    Cut,
    /// A few frames, up to 0.12 s, from which the body comes back are interpolated; all else is cut out: longer ones, jumps,
    /// freezes, and the ends of clips.
    #[default]
    Bridge,
    /// Left as they are, and reported.
    Keep,
}

/// Kind of a glitch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum GlitchKind {
    /// A repetition of the frame before, for a frame or a few in motion, as in takes whose rate was raised, or that lost
    /// frames.
    Repeat,
    /// Leaves the path, and comes back within a few frames.
    Pop,
    /// A change of place from one frame to the next.
    Jump,
    /// A joint turns away and back again within a few frames, or stays turned.
    Flip,
    /// Stillness of the whole body, in the middle of motion.
    Freeze,
    /// A pose that is not part of the motion, at the start or end.
    Apart,
    /// All numbers are zero.
    DropOut,
}

/// A run of frames that is no motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Glitch {
    /// Kind of the fault.
    pub kind: GlitchKind,
    /// The frames of the file, from 0.
    pub frames: FrameRange,
    /// The faulty joints of the file; an empty list stands for all of them.
    pub joints: Vec<usize>,
    /// Finding, as warnings print it.
    pub what: String,
    /// Treatment that it got.
    pub treated: GlitchTreatment,
}

/// Treatment that a glitch got.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum GlitchTreatment {
    /// Left out of all stages that follow.
    Cut,
    /// Interpolated.
    Bridged,
    /// Left as it is.
    Kept,
}

impl GlitchTreatment {
    /// Name in words.
    pub fn name(self) -> &'static str {
        ["cut out", "bridged", "kept"][self as usize]
    }
}

impl GlitchKind {
    /// Name in words.
    pub fn name(self) -> &'static str {
        ["repeat", "pop", "jump", "flip", "frozen", "pose apart", "drop-out"][self as usize]
    }
}

impl fmt::Display for Glitch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (first, last) = (self.frames.start, self.frames.end - 1);
        match first == last {
            true => write!(f, "frame {first}, {}", self.what),
            false => write!(f, "frames {first} to {last}, {}", self.what),
        }
    }
}

/// Longest run of frames that is bridged (s).
const MAX_BRIDGE: f64 = 0.12;

/// Most glitches that a warning lists.
const MAX_LISTED: usize = 8;

/// Share of repeated frames above which the warning names the real rate of the take.
const MANY_REPEATS: f64 = 0.25;

/// Finds the glitches of a clip in metres and treats them as configured. Frames that are cut are bridged, too: a joint that is
/// elsewhere for a frame must not move the ground of the whole clip.
pub fn treat_glitches(clip: &mut RawClip, roles: &RoleMap, how: Glitches, warnings: &mut Warnings) -> Vec<Glitch> {
    let mut all = find::find_glitches(clip, roles);
    if all.is_empty() {
        return all;
    }
    for glitch in &mut all {
        let inside = glitch.frames.start > 0 && glitch.frames.end < clip.num_frames;
        let short = glitch.frames.len() as f64 <= MAX_BRIDGE * clip.rate_hz;
        let back = !matches!(glitch.kind, GlitchKind::Jump | GlitchKind::Freeze);
        let bridged = how == Glitches::Bridge && inside && short && back;
        glitch.treated = match how {
            Glitches::Keep => GlitchTreatment::Kept,
            _ if bridged => GlitchTreatment::Bridged,
            _ => GlitchTreatment::Cut,
        };
    }
    if how != Glitches::Keep {
        all.iter().filter(|g| g.kind != GlitchKind::Jump).for_each(|g| bridge(clip, g));
    }
    let has = |treated| all.iter().any(|g| g.treated == treated);
    let done = match (has(GlitchTreatment::Bridged), has(GlitchTreatment::Cut)) {
        (true, true) => "bridged or cut out",
        (true, false) => GlitchTreatment::Bridged.name(),
        (false, true) => GlitchTreatment::Cut.name(),
        (false, false) => GlitchTreatment::Kept.name(),
    };
    // In a take whose rate was raised, every other frame is a repetition.
    let (repeats, others): (Vec<_>, Vec<_>) = all.iter().partition(|g| g.kind == GlitchKind::Repeat);
    let mut list: Vec<String> = others.iter().take(MAX_LISTED).map(ToString::to_string).collect();
    if others.len() > MAX_LISTED {
        list.push(format!("{} more", others.len() - MAX_LISTED));
    }
    match &repeats[..] {
        [] => {}
        [one] => list.push(one.to_string()),
        [first, ..] => {
            let (file_hz, share) =
                (clip.rate_hz, repeats.len() as f64 / clip.num_frames.saturating_sub(1).max(1) as f64);
            let take = format!(", as if a take of {:.0} Hz in a file of {file_hz:.0} Hz", file_hz * (1.0 - share));
            let take = if share > MANY_REPEATS { take } else { String::new() };
            list.push(format!("{} repeat the one before (frame {} first{take})", repeats.len(), first.frames.start));
        }
    }
    let frames: usize = all.iter().map(|g| g.frames.len()).sum();
    warnings.push(format!(
        "{}: {frames} of {} frames are no motion and are {done} (`import.glitches`): {}.",
        clip.path.display(),
        clip.num_frames,
        list.join("; ")
    ));
    all
}

/// Replaces the faulty joints in a run of frames by the interpolation from the frame before it to the one after; at the ends of
/// the clip the nearest sound frame is held.
pub fn bridge(clip: &mut RawClip, glitch: &Glitch) {
    let (n, frames) = (clip.joints.len(), &glitch.frames);
    let joints = if glitch.joints.is_empty() { (0..n).collect() } else { glitch.joints.clone() };
    let before = frames.start.checked_sub(1);
    let after = Some(frames.end).filter(|&f| f < clip.num_frames);
    let (Some(from), Some(to)) = (before.or(after), after.or(before)) else { return };
    for f in frames.clone() {
        let ratio = (f + 1 - frames.start) as f32 / (frames.len() + 1) as f32;
        for &j in &joints {
            let (a, b, at) = (from * n + j, to * n + j, f * n + j);
            clip.translations[at] = clip.translations[a].lerp(clip.translations[b], ratio);
            let (p, q) = (clip.rotations[a], clip.rotations[b]);
            clip.rotations[at] = maths::slerp_f32(p, q, ratio);
        }
    }
}
