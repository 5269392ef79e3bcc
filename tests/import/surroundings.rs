//! What real captured motion stood and hung on is inferred from its contacts, and blocks are built from it. Skipped
//! where the recordings are not at hand.

use crate::common::mocap::recording;
use std::path::Path;
use throng_core::{Contacts, Joint, Skeleton};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::environment::{InferredEnvironment, PlacedGeometry, infer_environment};
use throng_precompute::import::{ImportConfig, read};
use throng_precompute::progress::Silent;
use throng_precompute::resample::ResampleConfig;
use throng_precompute::{Clip, ClipSet, Warnings, annotate, pipeline, resample, retarget};

/// Planted feet are nearer than this to what was inferred (m).
const NEAR: f32 = 0.08;

/// The clip as a build has it before it knows of any surroundings.
fn clips(file: &Path) -> ClipSet {
    let raw = read(&[file.to_path_buf()], &ImportConfig { strict: true, ..ImportConfig::default() }, &Silent).unwrap();
    let clips = retarget::retarget_clips(&raw.clips, &Default::default(), &mut Warnings::default()).unwrap();
    let clips = resample::resample(&clips, &ResampleConfig { mirror: false, ..ResampleConfig::default() }).unwrap();
    annotate::annotate(&clips, &Default::default(), &Default::default()).unwrap()
}

/// Share of the feet that were found planted without knowing the surroundings and stand on them.
fn standing_share(clip: &Clip, skeleton: &Skeleton, geometry: &PlacedGeometry) -> f32 {
    let rest = skeleton.rest_positions();
    let feet = [(Contacts::LEFT_TOE, Joint::LeftToe), (Contacts::RIGHT_TOE, Joint::RightToe)];
    let (mut planted, mut near) = (0, 0);
    for f in (0..clip.num_frames()).filter(|&f| clip.is_usable(f)) {
        let joints = clip.joint_positions(skeleton, f);
        for (_, joint) in feet.into_iter().filter(|(c, _)| clip.contacts[f].any(*c)) {
            // The ball of the foot is so high above what it stands on.
            let limit = NEAR + rest[joint.index()].y;
            planted += 1;
            near += i32::from(geometry.nearest(joints[joint.index()], limit).is_some());
        }
    }
    assert!(planted > clip.num_frames() / 2, "{}: {planted} feet are planted", clip.name);
    near as f32 / planted as f32
}

/// Infers what a clip was captured on, builds blocks from it, and returns cells and links of the largest.
fn check(file: &Path) -> (InferredEnvironment, [usize; 2]) {
    let set = clips(file);
    let folder = tempfile::tempdir().unwrap();
    let inferred = infer_environment(&[&set.clips[0]], &set.skeleton, "site").unwrap();
    let geometry = inferred.geometry().unwrap();
    let share = standing_share(&set.clips[0], &set.skeleton, &geometry);
    assert!(share > 0.95, "{}: {share} of the planted feet stand on something\n{}", file.display(), inferred.report);
    let saved = inferred.save(&folder.path().join("site.toml")).unwrap();
    let text = format!(
        "name = 'site'\ninputs = ['{}']\nbehaviours = []\n[resample]\nmirror = false\n[graph]\nenabled = false\n\
         [patches]\nunits = '{}'\n[[patches.environments]]\nfile = '{}'\nclips = ['*']\n",
        file.canonicalize().unwrap().display(),
        saved.units_out.display(),
        saved.environment_out.display()
    );
    let config = BuildConfig::parse(&text, &folder.path().join("site-config.toml")).unwrap();
    let report = pipeline::build(&config, &folder.path().join("site.throng"), &Cache::disabled(), &Silent).unwrap();
    let largest = report.patches.iter().max_by_key(|p| p.links).expect("a block");
    (inferred, [largest.cells, largest.links])
}

#[test]
fn uneven_ground_is_inferred_from_who_walked_on_it() {
    let Some(file) = recording("cmu-asfamc/03/03_01.amc") else { return };
    let (inferred, [cells, links]) = check(&file);
    let r = &inferred.report;
    assert!(r.plates >= 2 && r.bars == 0 && r.residual_rms_m < 0.03 && r.penetrating_share < 0.02, "{r}");
    assert!(cells > 20 && links > 100, "{cells} cells, {links} links");
}

#[test]
fn steps_and_rails_are_inferred_from_who_climbed_them() {
    let Some(file) = recording("cmu-asfamc/01/01_02.amc") else { return };
    let (inferred, [cells, links]) = check(&file);
    let r = &inferred.report;
    assert!(r.plates >= 5 && r.bars >= 1 && r.residual_rms_m < 0.03 && r.penetrating_share < 0.02, "{r}");
    assert!(r.planted_share > 0.9, "{r}");
    assert!(cells > 20 && links > 100, "{cells} cells, {links} links");
}
