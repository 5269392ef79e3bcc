//! Cost of a build for growing amounts of motion. `cargo bench --bench database -- 5 15 45 ../shared/mocap` bakes so many
//! minutes of motion, repeated and perturbed from files and folders, or else from synthetic sets.
//!
//! Each size is baked by a separate process without a cache, so that processor time and memory are its own.

mod common;

use glam::{Quat, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use throng_core::{Joint, NUM_JOINTS};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::progress::Silent;
use throng_precompute::retarget::{RetargetConfig, retarget_clips};
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_precompute::{Clip, ClipSet, Warnings, export, import, memory, mirror, pipeline};

type Failure = Box<dyn std::error::Error>;

/// Environment variable with the folder of clips that a process is to bake.
const BAKE: &str = "THRONG_BENCH_DATABASE";
/// Stages of the table, in order.
const STAGES: [&str; 7] = ["import", "retarget", "clips", "graph", "policy", "hash", "write"];

fn main() -> Result<(), Failure> {
    if let Some(folder) = std::env::var_os(BAKE) {
        return bake(Path::new(&folder));
    }
    // `cargo test` runs benches too: a little motion is enough there.
    let is_whole = std::env::args().any(|a| a == "--bench");
    let given: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let mut minutes: Vec<f64> = given.iter().filter_map(|a| a.parse().ok()).filter(|m| *m > 0.0).collect();
    let inputs: Vec<PathBuf> = given.iter().filter(|a| a.parse::<f64>().is_err()).map(PathBuf::from).collect();
    if minutes.is_empty() {
        minutes = if is_whole { vec![5.0, 15.0, 45.0] } else { vec![0.5] };
    }
    let most = minutes.iter().copied().fold(0.0, f64::max);
    let base = if inputs.is_empty() { synthetic(most)? } else { recorded(&inputs)? };
    let stages: String = STAGES.iter().map(|s| format!("{s:>9}")).collect();
    println!("  minutes  processor   peak MB  bundle MB   states   actions   wall, s a stage:{stages}");
    for minutes in minutes {
        let folder = tempfile::tempdir()?;
        write_clips(&base, minutes, folder.path())?;
        let status = Command::new(std::env::current_exe()?).env(BAKE, folder.path()).status()?;
        if !status.success() {
            return Err(format!("{minutes} minutes: the build failed").into());
        }
    }
    Ok(())
}

/// Bakes the clips of a folder and prints a row of the table.
fn bake(folder: &Path) -> Result<(), Failure> {
    let config = BuildConfig::new("database", vec![folder.to_path_buf()]);
    let report = pipeline::build(&config, &folder.join("database.throng"), &Cache::disabled(), &Silent)?;
    let stages: BTreeMap<&str, f64> = report.stage_s.clone();
    let times: String = STAGES.iter().map(|s| format!("{:9.2}", stages.get(s).copied().unwrap_or(0.0))).collect();
    println!(
        "{:9.1} {:9.1} s {:9.0} {:10.1} {:8} {:9}                   {times}",
        report.minutes_in,
        common::processor_seconds(),
        memory::peak_bytes().map_or(f64::NAN, |b| b as f64 / 1e6),
        report.bundle_bytes as f64 / 1e6,
        report.states,
        report.actions,
    );
    Ok(())
}

/// Clips of several synthetic sets, one of each in turn; the sets are as long as `throng synth` makes them, or shorter.
fn synthetic(most_minutes: f64) -> Result<ClipSet, Failure> {
    let sets = [SynthSet::Walk, SynthSet::Locomotion, SynthSet::Boxing];
    let mut of_sets = Vec::new();
    for set in sets {
        let usual = SynthConfig::for_set(set);
        of_sets.push(synth::make_set(set, &SynthConfig { minutes: usual.minutes.min(most_minutes), ..usual })?.clips);
    }
    let longest = of_sets.iter().map(Vec::len).max().unwrap_or(0);
    let clips = (0..longest).flat_map(|k| of_sets.iter().filter_map(move |set| set.get(k).cloned())).collect();
    Ok(ClipSet { skeleton: throng_core::Skeleton::default(), clips })
}

/// The clips of files and folders, on the database skeleton.
fn recorded(inputs: &[PathBuf]) -> Result<ClipSet, Failure> {
    let raw = import::read(inputs, &import::ImportConfig::default(), &Silent)?;
    Ok(retarget_clips(&raw.clips, &RetargetConfig::default(), &mut Warnings::default())?)
}

/// Writes files of `minutes` in total: the clips as they are, then perturbed copies, again and again.
fn write_clips(base: &ClipSet, minutes: f64, folder: &Path) -> Result<(), Failure> {
    let mut seconds = 0.0;
    for (number, clip) in base.clips.iter().cycle().enumerate() {
        if seconds >= 60.0 * minutes {
            break;
        }
        let copy = number / base.clips.len();
        let clip = if copy == 0 { clip.clone() } else { perturbed(clip, copy, number as u64) };
        let mut file = BufWriter::new(std::fs::File::create(folder.join(format!("{number:05}.bvh")))?);
        export::bvh::write_clip(&export::to_raw(&clip, &base.skeleton), &mut file)?;
        file.flush()?;
        seconds += clip.num_frames() as f64 / clip.rate_hz;
    }
    Ok(())
}

/// A copy that differs from its original and from all others: played at its own changing pace, turned, every other one
/// mirrored, with joints that sway independently.
fn perturbed(clip: &Clip, copy: usize, seed: u64) -> Clip {
    let mut rng = Pcg64::seed_from_u64(seed);
    let clip = if copy % 2 == 1 { mirror::mirror_clip(clip) } else { clip.clone() };
    let (pace, sway) = (rng.random_range(0.88..1.12), rng.random_range(0.02..0.08));
    let (phase, turn) = (rng.random_range(0.0..TAU), Quat::from_rotation_y(rng.random_range(0.0..TAU) as f32));
    let swings: Vec<[Vec3; 2]> = (0..NUM_JOINTS)
        .map(|j| {
            [(); 2].map(|()| Vec3::from_array([(); 3].map(|()| rng.random_range(-1.0..1.0f32))) * sway_amplitude(j))
        })
        .collect();
    let (mut root_positions, mut rotations) = (Vec::new(), Vec::new());
    let last = clip.num_frames().saturating_sub(1);
    for frame in 0.. {
        // The pace swings by `sway` to either side, every 5 s.
        let time = frame as f64 / clip.rate_hz;
        let at = clip.rate_hz * (pace * time + sway * ((0.2 * TAU * time + phase).sin() - phase.sin()) / (0.2 * TAU));
        let (a, ratio) = (at.max(0.0) as usize, at.max(0.0).fract() as f32);
        if a >= last {
            break;
        }
        root_positions.push(turn * clip.root_positions[a].lerp(clip.root_positions[a + 1], ratio));
        for (j, (p, q)) in clip.frame_rotations(a).iter().zip(clip.frame_rotations(a + 1)).enumerate() {
            let [slow, fast] = [0.9, 2.3].map(|hz: f64| (hz * time + phase + j as f64).sin() as f32);
            let noise = Quat::from_scaled_axis(swings[j][0] * slow + swings[j][1] * fast);
            let by = if j == 0 { turn } else { noise };
            rotations.push(by * p.slerp(*q, ratio));
        }
    }
    Clip::new(clip.name.clone(), clip.rate_hz, root_positions, rotations)
}

/// Amplitude of a joint's sway: small for legs, so that feet stay in place (rad).
fn sway_amplitude(joint: usize) -> f32 {
    match Joint::ALL[joint].name() {
        name if ["thigh", "shin", "foot", "toe"].iter().any(|part| name.ends_with(part)) => 0.004,
        _ => 0.05,
    }
}
