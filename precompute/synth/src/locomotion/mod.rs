//! Steady locomotion: gaits at several speeds and turning rates, in several manners, each clip uniform from its first
//! frame to its last.
//!
//! `motion_set` lists the acts. An act moves along an even arc (`drive`) with steps (`stride`) placed on it (`falls`).
//! Gaits with a foot always on the ground are assembled from the parts of the walker (`walker`); a runner bounces
//! (`runner`) and folds its legs (`swing`). A `manner` changes the steps and the body.

mod drive;
mod falls;
mod manner;
mod motion_set;
mod runner;
mod scene;
mod stride;
mod swing;
mod walker;

use super::{SynthConfig, frame};
use drive::Drive;
use falls::AlternatingFootfalls;
use manner::{MANNERS, Manner, apply_manner};
use motion_set::{GaitKind, LocomotionAct};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use scene::ActTimes;
use stride::Stride;
use throng_core::{Contacts, Skeleton};
use throng_motion::clip::{Clip, ClipSet, ClipTag};

/// Number of clips of the whole motion set.
pub const NUM_ACTS: usize = 225;
/// Default length of a clip in `throng synth`: two and a half cycles of the slowest walk (s).
pub const CLIP_SECONDS: f64 = 4.0;

/// Makes the `locomotion` set, on the default skeleton, with the true foot contacts: walk, jog and run at four speeds
/// and five turning rates each, standing at ease, turns on the spot, side and back steps, in every manner.
///
/// Every clip lasts `clip_seconds`; clips are made in the order of the motion set until they fill `minutes`, with
/// further takes from its beginning after its end. A clip is steady throughout, begins at a random phase, and is tagged
/// with its gait and its manner.
///
/// - returns clips such as `walk_neutral_v110_gl08`; see [`LocomotionAct::name`].
pub fn locomotion(cfg: &SynthConfig) -> ClipSet {
    let skeleton = Skeleton::default();
    let acts = LocomotionAct::all();
    let count = (cfg.minutes * 60.0 / cfg.clip_seconds - 1e-6).ceil().max(1.0) as usize;
    let clip = |k: usize| clip(&acts[k % acts.len()], k, k / acts.len(), cfg, &skeleton);
    let clips = (0..count).into_par_iter().map(clip).collect();
    ClipSet { skeleton, clips }
}

fn clip(act: &LocomotionAct, number: usize, take: usize, cfg: &SynthConfig, skeleton: &Skeleton) -> Clip {
    // Each clip has its own generator, so that the result does not depend on the number of threads.
    let mut rng = Pcg64Mcg::seed_from_u64(cfg.seed.wrapping_add((number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    let scene = ActTimes::new(skeleton.clone(), cfg.clip_seconds, cfg.rate_hz, cfg.variation);
    let poses = match act.gait {
        GaitKind::Jog | GaitKind::Run => runner::poses_of_running(act, &scene, &mut rng),
        GaitKind::Idle => walker::poses_of_standing(act, &scene, &mut rng),
        GaitKind::Turn | GaitKind::Side | GaitKind::Back | GaitKind::Walk => {
            walker::poses_of_stepping(act, &scene, &mut rng)
        }
    };
    let mut clip = frame::empty_clip(act.name(take), "locomotion", cfg);
    scene.frames.iter().for_each(|&i| frame::push_pose(&mut clip, &poses[i], Contacts::NONE, skeleton));
    let whole = 0..clip.num_frames();
    clip.tags =
        [act.gait.name(), act.manner.name].map(|name| ClipTag { name: name.into(), range: whole.clone() }).to_vec();
    clip
}

#[cfg(test)]
mod tests;
