//! Time and memory of pose grouping, and number of groups beside exact complete linkage.
//! `cargo bench --bench cluster`; recordings are used where they are, as for tests.

#[path = "../../benches/common/mod.rs"]
mod common;
#[path = "../src/complete_linkage.rs"]
mod complete_linkage;
#[path = "../../tests/common/mocap.rs"]
mod mocap;

use common::processor_seconds;
use std::time::Instant;
use throng_precompute::annotate::{AnnotateConfig, Sidecars, annotate};
use throng_precompute::cluster::{ClusterConfig, group};
use throng_precompute::features::{Features, FeaturesConfig, extract};
use throng_precompute::import::{ImportConfig, read};
use throng_precompute::progress::Silent;
use throng_precompute::resample::{ResampleConfig, resample};
use throng_precompute::retarget::{RetargetConfig, retarget_clips};
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_precompute::{BuildError, Clip, ClipSet, Warnings, memory, mirror};

/// Number of frames of the playground of Lee, Choi and Lee (2006).
const PLAYGROUND: usize = 51_169;

fn main() -> Result<(), BuildError> {
    // `cargo test` runs benches too: a little motion is enough there.
    if !std::env::args().any(|a| a == "--bench") {
        return measure("walk", &walk(0.3, false)?, 500);
    }
    measure("walk", &first_frames(&walk(29.0, false)?, PLAYGROUND), 10_000)?;
    if let Some(recorded) = recorded()? {
        measure("recordings", &first_frames(&recorded, PLAYGROUND), 10_000)?;
    }
    measure("walk, with mirrored copies", &first_frames(&walk(139.5, true)?, 500_000), 0)
}

/// Prints the figures of a set, beside those of complete linkage of its first frames.
fn measure(name: &str, clips: &ClipSet, exact_frames: usize) -> Result<(), BuildError> {
    let whole = extract(clips, &FeaturesConfig::default())?;
    let first = first_frames(clips, exact_frames);
    let features = extract(&first, &FeaturesConfig::default())?;
    for threshold in [0.2, 0.3, 0.45] {
        let config = ClusterConfig { threshold };
        let (begun, worked) = (Instant::now(), processor_seconds());
        let groups = group(clips, &whole, &config, &Silent, &throng_core::base::SingleRank)?;
        println!(
            "{name}, below {threshold} rad: {} frames in {} groups, widest {:.4} rad, {:.2} s, {:.2} s of processors, \
             peak {:.0} MB",
            clips.num_frames(),
            groups.num_groups(),
            groups.max_diameter,
            begun.elapsed().as_secs_f64(),
            processor_seconds() - worked,
            memory::peak_bytes().map_or(f64::NAN, |b| b as f64 / 1e6)
        );
        if exact_frames > 0 {
            let begun = Instant::now();
            let ours = group(&first, &features, &config, &Silent, &throng_core::base::SingleRank)?.num_groups();
            let (seconds, begun) = (begun.elapsed().as_secs_f64(), Instant::now());
            let exact = complete_linkage::complete_linkage(&first, &features, threshold as f32).len();
            let ratio = seconds / begun.elapsed().as_secs_f64();
            println!(
                "    first {} frames: {ours} groups, {:.4} of exact complete linkage in {ratio:.4} of its time",
                first.num_frames(),
                ours as f64 / exact as f64
            );
        }
    }
    Ok(())
}

fn walk(minutes: f64, mirrored: bool) -> Result<ClipSet, BuildError> {
    let mut clips = synth::make_set(SynthSet::Walk, &SynthConfig { minutes, ..SynthConfig::default() })?;
    if mirrored {
        clips.clips = clips.clips.into_iter().flat_map(|c| [mirror::mirror_clip(&c), c]).collect();
        for pair in clips.clips.chunks_exact_mut(2) {
            pair[0].contacts = pair[1].contacts.iter().map(|c| c.mirrored()).collect();
        }
    }
    Ok(clips)
}

/// The recordings, if there are any, at 30 Hz.
fn recorded() -> Result<Option<ClipSet>, BuildError> {
    let Some(root) = mocap::recording("") else { return Ok(None) };
    let folders = ["cmu-asfamc/01", "cmu-asfamc/02", "cmu-asfamc/03", "snu/single", "snu/session23", "snu/multi"];
    let raw = read(&folders.map(|f| root.join(f)), &ImportConfig::default(), &Silent)?;
    let clips = retarget_clips(&raw.clips, &RetargetConfig::default(), &mut Warnings::default())?;
    let clips = resample(&clips, &ResampleConfig { mirror: false, ..ResampleConfig::default() })?;
    annotate(&clips, &AnnotateConfig::default(), &Sidecars::default()).map(Some)
}

/// The first frames of a set.
fn first_frames(clips: &ClipSet, mut num_frames: usize) -> ClipSet {
    let mut first = Vec::new();
    for clip in &clips.clips {
        let n = clip.num_frames().min(num_frames);
        if n == 0 {
            break;
        }
        num_frames -= n;
        first.push(Clip {
            root_positions: clip.root_positions[..n].to_vec(),
            rotations: clip.rotations[..n * throng_core::NUM_JOINTS].to_vec(),
            contacts: clip.contacts[..n].to_vec(),
            ..clip.clone()
        });
    }
    ClipSet { skeleton: clips.skeleton.clone(), clips: first }
}
