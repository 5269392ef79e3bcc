//! Activities of standing people: greeting, shaking hands, looking at things, buying, chatting, sitting down, waiting
//! in a queue, cheering, taking things and putting them down, one clip each.
//!
//! `acts` writes each as a script of the office (`super::office`), which also poses the body.

mod acts;

use super::{SynthConfig, office::assemble};
use acts::PersonAct;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use throng_core::Skeleton;
use throng_motion::clip::ClipSet;

/// Default length of the list in `throng synth` (min).
pub const MINUTES: f64 = 4.7;

/// Makes the `people` set, on the default skeleton, with the true contacts. Every clip begins and ends standing at ease
/// and has two tags: its activity (`greet`, `handshake`, `look`, `buy`, `chat`, `sit`, `queue`, `cheer`), and `loop`
/// for the part that may loop, if any. For taking (`take`) and putting down a thing (`put`), a third tag names the hand
/// that holds it: `left_hand` or `right_hand`. Clips are made in the order of the list until they fill `minutes`,
/// beginning again after its end.
///
/// - returns clips such as `people_greet_00`; for sitting, on the chair of the office's desk.
pub fn people(cfg: &SynthConfig) -> ClipSet {
    let mut set = ClipSet { skeleton: Skeleton::default(), clips: Vec::new() };
    let mut spent = 0.0;
    for (number, act) in PersonAct::LIST.into_iter().flatten().cycle().enumerate() {
        if spent >= cfg.minutes * 60.0 {
            break;
        }
        let seed = cfg.seed.wrapping_add((number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let script = act.script(cfg.variation, &mut rng);
        let name = format!("people_{}_{number:02}", act.tag());
        let clip = assemble::clip("people", name, &script, &set.skeleton, cfg, &mut rng);
        spent += clip.num_frames() as f64 / clip.rate_hz;
        set.clips.push(clip);
    }
    set
}

#[cfg(test)]
mod tests;
