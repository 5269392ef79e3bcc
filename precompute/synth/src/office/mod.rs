//! People in an office: at the desk, and standing.
//!
//! From intention to pose, in this order: `visit` (with `work`), `stand` (with `gesture`) and `partners` write the
//! events, as steps, stays on the chair (`seat`) and keys of trunk, head and hands (`posture`) in a `script`; `route`
//! plans paths around the furniture of `desk`; `assemble` walks the steps with the walker's own body, moves it by the
//! keys and onto the chair, and `hands` moves the hands to their positions. Without keys the body is the walker's, to
//! the bit, so that its stands and steps are those of the `walk` set.

pub(super) mod assemble;
pub(super) mod desk;
pub(super) mod gesture;
mod hands;
mod partners;
pub(super) mod posture;
mod route;
pub(super) mod script;
mod seat;
pub(super) mod stand;
pub(super) mod visit;
mod work;

use super::SynthConfig;
use desk::{BEFORE_SEAT, SEAT, TOP, is_blocked};
use partners::{PairActivity, pair_scripts};
use posture::{KeyedHandPose, KeyedPosture};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use script::{MotionScript, ScriptStep};
use seat::{ChairStay, SeatedShare};
use stand::{Stander, face_partner, lean_on};
use throng_core::Skeleton;
use throng_motion::clip::ClipSet;
use visit::{DeskVisitor, LAP, SITTING, mirrored_for_side};

/// Share of the set at the desk.
const AT_DESK: f64 = 7.0 / 13.0;
/// Minutes of the set, apart from pairs, for each showing of all activities of two people; there is at least one (min).
const MINUTES_A_PAIR: f64 = 6.0;

/// Makes the `office` set: walking up to a desk from all sides, sitting down, working, chatting there, standing up and
/// walking away; and idling, chatting, disputing and presenting while standing; on the default skeleton, with the true
/// contacts and a tag on everything that happens.
///
/// - returns clips `office_desk_00`, ..., around the desk of `data/environments/office_source.toml`, `office_stand_00`,
///   ..., on empty ground, and `office_pair_00_a` with `office_pair_00_b`, ... of two people who chat, dispute, shake
///   hands, hand something over, or dance, in one room, in addition to `minutes`; all begin and end standing.
pub fn office(cfg: &SynthConfig) -> ClipSet {
    let mut set = ClipSet { skeleton: Skeleton::default(), clips: Vec::new() };
    let mut rng = Pcg64Mcg::seed_from_u64(cfg.seed);
    let (mut visitor, mut stander) = (DeskVisitor::new(), Stander::new());
    let whole = cfg.minutes * 60.0;
    // Adds clips until they last `seconds`, at least one; returns their total length.
    let mut fill = |name: &str, seconds: f64, write: &mut dyn FnMut(f64, &mut Pcg64Mcg) -> MotionScript| {
        let (mut spent, mut number) = (0.0, 0);
        while spent < seconds || number == 0 {
            let wanted = (seconds - spent).min(cfg.clip_seconds * rng.random_range(0.85..1.1));
            let script = write(wanted, &mut rng);
            spent += script.duration();
            let name = format!("{name}_{number:02}");
            set.clips.push(assemble::clip("office", name, &script, &set.skeleton, cfg, &mut rng));
            number += 1;
        }
        spent
    };
    let spent = fill("office_desk", AT_DESK * whole, &mut |wanted, rng| visitor.visits(wanted, cfg.variation, rng));
    fill("office_stand", whole - spent, &mut |wanted, rng| stander.stand(wanted, cfg.variation, rng));
    let times = (cfg.minutes / MINUTES_A_PAIR).round().clamp(1.0, 4.0) as usize;
    for (number, what) in (0..times).flat_map(|_| PairActivity::ALL).enumerate() {
        let scripts = pair_scripts(what, cfg.variation, &mut rng);
        for (script, who) in scripts.iter().zip(["a", "b"]) {
            let name = format!("office_pair_{number:02}_{who}");
            set.clips.push(assemble::clip("office", name, script, &set.skeleton, cfg, &mut rng));
        }
    }
    set
}

#[cfg(test)]
mod tests;
