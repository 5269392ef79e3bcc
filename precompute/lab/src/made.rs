//! Made motion: the frames of a bundle that nobody has captured, beside those that somebody has.

use crate::quality::{QualityMeter, Track, clip_joints};
use crate::{frames::runs, slip::SlipMeter};
use serde::Serialize;
use throng_core::{Bundle, format::MADE_TAG};

/// How made motion is used, and how it looks beside captured motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct MadeFigures {
    /// Share of made frames in the time in which characters move.
    pub share_of_moving: f64,
    /// 95th percentile of the speed of planted heels and toes in made frames, over that in captured ones.
    pub slip_p95_ratio: f64,
    /// 99.9th percentile of the turn of knees in made frames, over that in captured ones.
    pub knee_rate_p999_ratio: f64,
}

/// True for each frame that was made.
pub fn made_frames(tables: &Bundle) -> Vec<bool> {
    let mut made = vec![false; tables.frames().len()];
    for (clip, meta) in tables.clips().iter().zip(&tables.meta().clips) {
        for (_, from, to) in meta.tags.iter().filter(|t| t.0 == MADE_TAG) {
            let [from, to] = [from, to].map(|f| (clip.first_frame + (*f).min(clip.num_frames)) as usize);
            made[from.min(to)..to].fill(true);
        }
    }
    made
}

impl MadeFigures {
    /// Figures of a bundle's frames; `None` if none are made.
    ///
    /// - `share_of_moving`: measured by who runs it.
    pub fn of_bundle(tables: &Bundle, made: &[bool], share_of_moving: f64) -> Option<Self> {
        if !made.contains(&true) {
            return None;
        }
        let rate = tables.meta().rate_hz as f32;
        let mut slip = [(); 2].map(|()| SlipMeter::new(1, tables.skeleton()));
        let mut knees = [QualityMeter::new(rate, rate), QualityMeter::new(rate, rate)];
        for run in runs(tables) {
            let frames: Vec<u32> = run.collect();
            for part in frames.chunk_by(|a, b| made[*a as usize] == made[*b as usize]) {
                let kind = usize::from(made[part[0] as usize]);
                slip[kind].forget_step();
                let mut positions = Vec::with_capacity(part.len());
                for &f in part {
                    let joints = clip_joints(tables, f);
                    slip[kind].observe_joints(0, 1.0 / rate, tables.contacts()[f as usize], |j| joints[j.index()]);
                    positions.push(joints.map(|j| j.0));
                }
                knees[kind].add(&Track::without_changes(positions));
            }
        }
        let ratio = |[captured, made]: [f64; 2]| made / captured.max(1e-6);
        Some(Self {
            share_of_moving,
            slip_p95_ratio: ratio(slip.map(|s| s.p95_mps())),
            knee_rate_p999_ratio: ratio(knees.map(|k| k.figures().knee_rate_p999_dps)),
        })
    }
}
