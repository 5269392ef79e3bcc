//! Hits that are found in captured motion against labels made by eye. Skipped where the recordings are not at hand.

use crate::mocap::recording;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use throng_base::text::TomlSource;
use throng_motion::annotate::{AnnotateConfig, Sidecars, annotate};
use throng_motion::clip::{Clip, HitKind};
use throng_motion::import::{ImportConfig, expand, read_clip};
use throng_motion::resample::{ResampleConfig, resample};
use throng_motion::retarget::{RetargetConfig, retarget_clips};

/// A hit belongs to a label of the same limb that is at most so far away (frames at 30 Hz): slow punches land up to a
/// sixth of a second before the arm is quite straight.
const SAME: usize = 6;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Labels {
    clips: Vec<Labelled>,
}

#[derive(Deserialize)]
struct Labelled {
    file: String,
    #[serde(default)]
    tuned: bool,
    #[serde(default)]
    unsure: BTreeMap<String, Vec<usize>>,
    /// Frames by the joint that strikes.
    #[serde(flatten)]
    blows: BTreeMap<String, Vec<usize>>,
}

/// Labels found and missed, and hits that are none.
#[derive(Default)]
struct Score {
    found: usize,
    missed: usize,
    wrong: usize,
    /// How far hits are from the full extension (frames), and how straight the limb is there (share of its length).
    early: Vec<usize>,
}

impl Score {
    fn add(&mut self, labelled: &Labelled, clip: &Clip) {
        let mut missed: Vec<(&str, usize)> = Vec::new();
        let mut left: Vec<(&str, usize)> = clip.hits.iter().map(|h| (h.joint.name(), h.frame)).collect();
        for (joint, &frame) in labelled.blows.iter().flat_map(|(j, frames)| frames.iter().map(move |f| (j, f))) {
            let near = |h: &(&str, usize)| h.0 == joint && h.1.abs_diff(frame) <= SAME;
            let best = (0..left.len()).filter(|&i| near(&left[i])).min_by_key(|&i| left[i].1.abs_diff(frame));
            match best.map(|i| left.swap_remove(i)) {
                Some(hit) => {
                    self.found += 1;
                    self.early.push(hit.1.abs_diff(frame));
                }
                None => missed.push((joint, frame)),
            }
        }
        left.retain(|(joint, frame)| {
            let unsure = labelled.unsure.get(*joint).into_iter().flatten();
            unsure.clone().all(|f| f.abs_diff(*frame) > SAME + 2)
        });
        if !missed.is_empty() || !left.is_empty() {
            println!("{}: missed {missed:?}, wrong {left:?}", labelled.file);
        }
        self.missed += missed.len();
        self.wrong += left.len();
    }

    fn precision(&self) -> f64 {
        self.found as f64 / (self.found + self.wrong) as f64
    }

    fn recall(&self) -> f64 {
        self.found as f64 / (self.found + self.missed) as f64
    }
}

fn labels() -> Vec<Labelled> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/blows/labels.toml");
    TomlSource::read(&path, "labels").unwrap().parse::<Labels>("").unwrap().clips
}

/// A clip as a build with default settings annotates it.
fn annotated(file: &Path) -> Clip {
    let clip = read_clip(&expand(&[file.to_path_buf()]).unwrap()[0], &ImportConfig::default()).unwrap();
    let retargeted = retarget_clips(&[clip], &RetargetConfig::default(), &mut Default::default()).unwrap();
    let resampled = resample(&retargeted, &ResampleConfig { rate_hz: 30.0, mirror: false }).unwrap();
    annotate(&resampled, &AnnotateConfig::default(), &Sidecars::default()).unwrap().clips.swap_remove(0)
}

#[test]
fn blows_are_found_as_they_are_seen() {
    let Some(root) = recording("") else { return };
    let mut scores = [Score::default(), Score::default()];
    for labelled in labels() {
        let clip = annotated(&root.join(&labelled.file));
        for (joint, kind) in [("hand", HitKind::Punch), ("foot", HitKind::Kick)] {
            assert!(clip.hits.iter().all(|h| !h.joint.name().ends_with(joint) || h.kind == kind), "{}", clip.name);
        }
        scores[usize::from(!labelled.tuned)].add(&labelled, &clip);
    }
    for (name, score) in ["tuned on", "judged on"].into_iter().zip(&mut scores) {
        score.early.sort_unstable();
        println!(
            "clips {name}: {} blows found, {} missed, {} wrong: precision {:.3}, recall {:.3}; full extension {} frames \
             away at the median, {} at most",
            score.found,
            score.missed,
            score.wrong,
            score.precision(),
            score.recall(),
            score.early[score.early.len() / 2],
            score.early[score.early.len() - 1]
        );
        assert!(score.precision() >= 0.95 && score.recall() >= 0.95);
    }
}

#[test]
fn motion_without_fights_has_few_hits() {
    let Some(root) = recording("") else { return };
    let labelled: Vec<PathBuf> = labels().iter().map(|l| root.join(&l.file)).collect();
    let folders = ["snu/single", "snu/multi", "snu/session23", "bandai-1", "cmu-asfamc/01"].map(|f| root.join(f));
    let (mut seconds, mut hits) = (0.0, 0);
    for file in expand(&folders).unwrap().into_iter().filter(|f| !labelled.contains(f)) {
        let clip = annotated(&file);
        seconds += clip.num_frames() as f64 / clip.rate_hz;
        hits += clip.hits.len();
        if !clip.hits.is_empty() {
            let all: Vec<_> = clip.hits.iter().map(|h| (h.frame, h.joint.name())).collect();
            println!("{}: {all:?}", clip.name);
        }
    }
    println!("{hits} hits in {:.0} minutes without fights", seconds / 60.0);
    assert!(seconds > 3600.0 && hits <= 35, "{hits} hits in {seconds:.0} s");
}
