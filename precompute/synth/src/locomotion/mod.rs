//! Steady locomotion: gaits at several speeds and turning rates, in several manners, every clip the same from its first
//! frame to its last.
//!
//! `motion_set` lists what there is. An act moves along an even arc (`drive`) with steps (`stride`) laid on it
//! (`falls`). Who always has a foot on the ground is put together from the parts of the walker (`walker`, `still`);
//! a runner bounces (`bounce`) and folds its legs (`swing`, `spline`) in `runner`. A `manner` changes the steps, and
//! `posture` lays it over the body.

mod bounce;
mod drive;
mod falls;
mod manner;
mod motion_set;
mod posture;
mod runner;
mod scene;
mod spline;
mod still;
mod stride;
mod swing;
mod walker;

use super::SynthConfig;
use super::frame;
use motion_set::{Act, Gait};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use scene::Scene;
use throng_core::Skeleton;
use throng_motion::clip::{Clip, ClipSet, Tag};

/// Clips of the whole motion set.
pub const NUM_ACTS: usize = 225;
/// Length of one clip as `throng synth` makes it: two cycles and a half of the slowest walk (s).
pub const CLIP_SECONDS: f64 = 4.0;

/// Makes the `locomotion` set, on the default skeleton, with the true foot contacts: walk, jog and run at four speeds
/// and five turning rates each, standing at ease, turns on the spot, side and back steps, in every manner.
///
/// Every clip lasts `clip_seconds`; as many are made as fill `minutes`, in the order of the motion set, and further takes
/// of it from its beginning when it has come to its end. A clip is steady throughout, begins anywhere in its cycle, and
/// has its gait and its manner as tags.
///
/// - returns clips such as `walk_neutral_v110_gl08`; see [`Act::name`].
pub fn locomotion(cfg: &SynthConfig) -> ClipSet {
    let skeleton = Skeleton::default();
    let acts = Act::all();
    let count = (cfg.minutes * 60.0 / cfg.clip_seconds - 1e-6).ceil().max(1.0) as usize;
    let clip = |k: usize| clip(&acts[k % acts.len()], k, k / acts.len(), cfg, &skeleton);
    let clips = (0..count).into_par_iter().map(clip).collect();
    ClipSet { skeleton, clips }
}

fn clip(act: &Act, number: usize, take: usize, cfg: &SynthConfig, skeleton: &Skeleton) -> Clip {
    // Clips have a generator each, so that any number of threads makes the same.
    let mut rng = Pcg64Mcg::seed_from_u64(cfg.seed.wrapping_add((number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
    let scene = Scene::new(skeleton.clone(), cfg.clip_seconds, cfg.rate_hz, cfg.variation);
    let poses = match act.gait {
        Gait::Jog | Gait::Run => runner::run(act, &scene, &mut rng),
        Gait::Idle => walker::stand(act, &scene, &mut rng),
        Gait::Turn | Gait::Side | Gait::Back | Gait::Walk => walker::step(act, &scene, &mut rng),
    };
    let mut clip = frame::empty_clip(act.name(take), "locomotion", cfg);
    for &i in scene.frames() {
        frame::push(&mut clip, &poses[i], skeleton);
    }
    let whole = 0..clip.num_frames();
    clip.tags = [act.gait.name(), act.manner.name].map(|name| Tag { name: name.into(), range: whole.clone() }).to_vec();
    clip
}

#[cfg(test)]
mod tests;
