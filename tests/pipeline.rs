//! Clips to poses, end to end: what was recorded is what is sampled, and crowds go where they are sent.

use crate::common;
use crate::common::mocap::recording;
use crate::common::{build, orders, small_config, starts, write_clips};
use glam::Vec3;
use std::path::{Path, PathBuf};
use throng_core::characters::{Characters, CharactersConfig, MotionSet, PolicyOrder, SampleJob};
use throng_core::policy::{MAX_ACTIONS, PATH_POINTS, PolicyTable};
use throng_core::{Bundle, Joint, Mat3x4, NUM_JOINTS, Planar};
use throng_precompute::annotate::{AnnotateConfig, Sidecar, Sidecars, annotate};
use throng_precompute::cache::Cache;
use throng_precompute::clip::ClipSet;
use throng_precompute::config::BuildConfig;
use throng_precompute::import::{ImportConfig, read};
use throng_precompute::pipeline;
use throng_precompute::policy::{AdaptiveConfig, GridConfig, PolicyBehaviourConfig};
use throng_precompute::progress::{Progress, Silent};
use throng_precompute::resample::{ResampleConfig, resample};
use throng_precompute::retarget::{RetargetConfig, retarget_clips};
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_precompute::trial::{self, TrialConfig};
use throng_precompute::{BuildError, Warnings};

/// Frames of the bundle as poses in the world of their clip.
fn sampled(tables: &Bundle) -> Vec<(Planar, Vec<Mat3x4>)> {
    let motion_set = MotionSet::new(tables);
    let frames: Vec<u32> = (0..tables.frames().len() as u32).collect();
    let ratios = vec![0.0; frames.len()];
    let mut matrices = vec![Mat3x4::default(); frames.len() * NUM_JOINTS];
    SampleJob { motion_set: &motion_set, frames: &frames, ratios: &ratios, matrices: &mut matrices }
        .run()
        .expect("a batch of poses");
    let root = |f: usize| {
        let [x, z, heading] = tables.frames()[f].planar;
        Planar::new(x, z, heading)
    };
    matrices.chunks(NUM_JOINTS).enumerate().map(|(f, m)| (root(f), m.to_vec())).collect()
}

#[test]
fn a_bundle_is_the_same_in_whatever_folder_it_is_made() {
    let bundle = |config: fn(&Path) -> BuildConfig| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write_clips(&folder.path().join("clips"), 0.7);
        let out = folder.path().join("a.throng");
        build(&config(folder.path()), &out, &Cache::disabled());
        std::fs::read(&out).expect("what was built can be read")
    };
    let of_folder = |at: &Path| small_config(vec![at.join("clips")]);
    let of_pattern = |at: &Path| small_config(vec![at.join("clips/**/*.bvh"), at.join("clips/*_00.bvh")]);
    for config in [of_folder, of_pattern] {
        let bytes = bundle(config);
        assert!(bytes == bundle(config));
        let text = String::from_utf8_lossy(&bytes);
        assert!(!text.contains("/tmp") && text.contains("walk_00.bvh"));
    }
}

/// Every sampled joint is within `tolerance` of where the clips have it (m).
fn assert_same_motion(tables: &Bundle, set: &ClipSet, tolerance: f32) {
    let poses = sampled(tables);
    assert_eq!((poses.len(), tables.clips().len()), (set.num_frames(), set.clips.len()));
    for (clip, record) in set.clips.iter().zip(tables.clips()) {
        for f in 0..clip.num_frames() {
            let (root, pose) = &poses[record.first_frame as usize + f];
            let wanted = clip.joint_positions(&set.skeleton, f);
            for j in Joint::ALL {
                let at = root.translation() + root.rotation() * pose[j.index()].translation();
                let apart = at.distance(wanted[j.index()]);
                assert!(apart < tolerance, "{} frame {f} {}: {apart} m", clip.name, j.name());
            }
        }
    }
}

#[test]
fn sampled_poses_are_those_of_the_retargeted_clips() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 0.6);
    let mut config = small_config(vec![clips.clone()]);
    config.resample.mirror = true;
    build(&config, &out, &Cache::disabled());
    let tables = Bundle::open(&out).expect("the bundle opens");

    let raw = read(&[clips], &ImportConfig::default(), &Silent).expect("clips");
    let set = retarget_clips(&raw.clips, &RetargetConfig::default(), &mut Warnings::default()).expect("bodies");
    let set = resample(&set, &ResampleConfig { mirror: true, ..ResampleConfig::default() }).unwrap();
    let set = annotate(&set, &AnnotateConfig::default(), &Sidecars::default()).expect("annotated");
    assert_same_motion(&tables, &set, 1e-3);
    let starts = set.frame_starts();
    for (c, clip) in set.clips.iter().enumerate() {
        assert_eq!(tables.meta().clips[c].name, clip.name);
        for f in 0..clip.num_frames() {
            let row = tables.frames()[starts[c] as usize + f];
            let (root, wanted) = (Planar::new(row.planar[0], row.planar[1], row.planar[2]), clip.planar(f));
            let apart = wanted.to_local(root);
            let turned = throng_core::planar::wrap_angle(apart.heading);
            assert!(apart.x.hypot(apart.z) < 1e-4 && turned.abs() < 1e-4, "{} frame {f}: {apart:?}", clip.name);
            assert_eq!(tables.contacts()[starts[c] as usize + f], clip.contacts[f], "{} frame {f}", clip.name);
        }
    }
}

#[test]
fn sampled_poses_are_those_that_were_made() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    let made = synth::write_set(
        SynthSet::Walk,
        &SynthConfig { minutes: 0.6, clip_seconds: 15.0, ..Default::default() },
        &clips,
    );
    let mut config = small_config(vec![clips]);
    config.resample.mirror = false;
    build(&config, &out, &Cache::disabled());
    let tables = Bundle::open(&out).expect("the bundle opens");
    // Through a file, units of its own and the detection of both, and onto the ground.
    assert_same_motion(&tables, &made.expect("clips"), 0.02);
}

#[test]
fn segments_lead_from_state_to_state() {
    let tables = common::tables();
    let (graph, frames) = (tables.graph(), tables.frames());
    let root = |f: u32| {
        let [x, z, heading] = frames[f as usize].planar;
        Planar::new(x, z, heading)
    };
    for (i, s) in graph.segments.iter().enumerate() {
        let last = s.start + s.num_frames;
        assert_eq!(last, graph.states[s.end as usize].frame, "segment {i}");
        let moved = root(s.start).compose(s.displacement()).to_local(root(last));
        assert!(moved.x.hypot(moved.z) < 1e-3 && moved.heading.abs() < 1e-3, "segment {i}: {moved:?}");
        let clip = &tables.clips()[s.clip as usize];
        let excluded = &tables.meta().clips[s.clip as usize].excluded;
        for (why, from, to) in excluded {
            let (from, to) = (clip.first_frame + from, clip.first_frame + to);
            assert!(last < from || s.start >= to, "segment {i} plays frames left out as {why}");
        }
    }
    for state in 0..graph.states.len() as u32 {
        assert!(!graph.segments_of(state).is_empty(), "state {state} is a dead end");
    }
}

/// A crowd reaches its targets on feet that stand; so do `making_way` of those who make way, and none is ever in another.
fn assert_crowd_arrives(bundle: &Path, making_way: f64) {
    let tables = Bundle::open(bundle).expect("the bundle opens");
    let config = TrialConfig { characters: 100, recorded: None, ..TrialConfig::default() };
    let (report, _) = trial::run(&tables, &config).expect("a trial");
    assert!(report.reached_fraction > making_way && report.character_overlaps == 0, "{report:?}");
    assert!(report.foot_slip_p95_mps < 0.15, "{report:?}");
    let motion = CharactersConfig { avoid: None, ..config.motion };
    let config = TrialConfig { seconds: 15.0, motion, ..config };
    let (report, record) = trial::run(&tables, &config).expect("a trial");
    assert!(report.reached_fraction > 0.95, "{report:?}");
    assert!(report.foot_slip_p95_mps < 0.15, "{report:?}");
    // What the report says, counted again: all that arrived have covered the way.
    let arrived = record.arrivals_s.iter().filter(|t| **t <= 15.0).count();
    assert_eq!(arrived as f64 / 100.0, report.reached_fraction);
    for (trail, target) in record.trails.iter().zip(&record.targets) {
        let distance = trail[0].distance(glam::Vec2::new(target.x, target.z));
        assert!((1.9..6.1).contains(&distance), "a target {distance} m away at the start");
    }
}

#[test]
fn a_synthetic_crowd_reaches_its_targets() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    synth::write_set(SynthSet::Walk, &SynthConfig { minutes: 3.0, ..SynthConfig::default() }, &clips).expect("clips");
    let mut config = BuildConfig::new("crowd", vec![clips]);
    config.resample.mirror = true;
    config.policy.compare_samples = 100;
    build(&config, &out, &Cache::disabled());
    assert_crowd_arrives(&out, 0.95);
}

#[test]
fn a_crowd_of_recorded_walkers_reaches_its_targets() {
    let Some(mocap) = recording("") else { return };
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/snu-walk.toml");
    let mut config = BuildConfig::load(&config).expect("the config that comes with the project");
    let of_file = |p: &PathBuf| mocap.join("snu/single").join(p.file_name().expect("a pattern"));
    config.inputs = config.inputs.iter().map(of_file).collect();
    config.policy.compare_samples = 100;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("snu.throng");
    build(&config, &out, &Cache::disabled());
    // In this motion a stop takes 2.5 s and 2.7 m.
    assert_crowd_arrives(&out, 0.9);
}

#[test]
fn an_adaptive_policy_goes_from_the_config_to_queries() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 1.0);
    let mut config = small_config(vec![clips]);
    let fine = GridConfig { rings: Some(9), angles: Some(16), ..config.behaviours[0].grid };
    let adaptive = Some(AdaptiveConfig { share: 0.25, ..AdaptiveConfig::default() });
    let compact = GridConfig { adaptive, ..fine };
    let behaviour =
        |name: &str, grid| PolicyBehaviourConfig { name: name.into(), grid, ..config.behaviours[0].clone() };
    config.behaviours = vec![behaviour("fine", fine), behaviour("compact", compact), behaviour("again", fine)];
    let report = build(&config, &out, &Cache::disabled());
    let figures = report.policies[1].adaptive.as_ref().expect("an adaptive policy");
    assert!(4 * figures.adaptive.bytes <= figures.finest_bytes && report.policies[0].adaptive.is_none());

    let tables = Bundle::open(&out).expect("the bundle opens");
    let [fine, compact, again] = [0, 1, 2].map(|i| &tables.policies()[i]);
    assert!(compact.is_adaptive() && !fine.is_adaptive() && 4 * compact.num_values() <= fine.num_values());
    let values = |p: &PolicyTable| (0..4).map(|s| p.values_of(s).to_vec()).collect::<Vec<_>>();
    assert_eq!(values(fine), values(again), "what follows an adaptive policy is found behind it");
    let mut scores = [[0.0; MAX_ACTIONS]; 2];
    let n = fine.action_scores(1, Vec3::new(1.0, 0.0, 2.0), &mut scores[0]).expect("a sound query");
    compact.action_scores(1, Vec3::new(1.0, 0.0, 2.0), &mut scores[1]).expect("a sound query");
    for (a, b) in scores[0][..n].iter().zip(&scores[1][..n]) {
        assert!((a - b).abs() <= 2.0 * figures.adaptive.max_error as f32, "{a} {b}, {figures:?}");
    }
    // Characters follow it like any other.
    let motion_set = MotionSet::new(&tables);
    let orders: Vec<PolicyOrder> = orders(8).iter().map(|order| PolicyOrder::towards(1, order.target())).collect();
    let mut characters =
        Characters::new(&motion_set, CharactersConfig::default(), &starts(&tables, 8)).expect("characters");
    let far = |characters: &Characters| -> f32 {
        (0..8).map(|c| characters.root(c).translation().distance(orders[c].target())).sum::<f32>()
    };
    let before = far(&characters);
    for _ in 0..300 {
        characters.step(&motion_set, 1.0 / 30.0, &orders).expect("a step");
    }
    assert!(far(&characters) < 0.5 * before, "{} of {before} m", far(&characters));
}

#[test]
fn an_unchanged_build_only_hashes_finds_stops_and_writes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 0.6);
    let cache = Cache::in_folder(folder.path().join("cache"));
    let mut config = small_config(vec![clips.clone()]);
    let stages = |r: &throng_precompute::report::BuildReport| r.stage_s.keys().copied().collect::<Vec<_>>();
    let bytes = || std::fs::read(&out).expect("the bundle can be read");

    let first = build(&config, &out, &cache);
    assert!(first.cached.is_empty());
    assert_eq!(stages(&first), ["clips", "graph", "hash", "import", "policy", "retarget", "stops", "write"]);
    let made = bytes();
    let second = build(&config, &out, &cache);
    assert_eq!((stages(&second), second.cached), (vec!["hash", "stops", "write"], vec!["motion", "graph", "policy"]));
    assert!(bytes() == made, "the second build wrote other bytes");
    assert_eq!((second.states, second.policies.len()), (first.states, 1));

    config.behaviours[0].scale = Some(2.0);
    let other = build(&config, &out, &cache);
    assert_eq!((stages(&other), other.cached), (vec!["hash", "policy", "stops", "write"], vec!["motion", "graph"]));
    assert!(bytes() != made, "another behaviour left the bundle as it was");

    config.graph.branching = 8.0;
    let other = build(&config, &out, &cache);
    let ran = vec!["graph", "hash", "policy", "stops", "write"];
    assert_eq!((stages(&other), other.cached), (ran, vec!["motion"]));

    let clip = clips.join("walk_00.bvh");
    let text = std::fs::read_to_string(&clip).expect("a clip");
    std::fs::write(&clip, text + "\n").expect("a clip");
    let other = build(&config, &out, &cache);
    assert!(other.cached.is_empty(), "a changed clip was not read again: {:?}", other.cached);
}

#[test]
fn the_cache_tells_inputs_apart_that_have_the_same_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("all"), folder.path().join("a.throng"));
    write_clips(&clips.join("walks"), 0.6);
    let cache = Cache::in_folder(folder.path().join("cache"));
    let made = |inputs: Vec<PathBuf>, cache: &Cache| {
        build(&small_config(inputs), &out, cache);
        Bundle::open(&out).expect("the bundle opens").meta().clips.iter().map(|c| c.name.clone()).collect::<Vec<_>>()
    };
    // Clips are named as seen from the folder that was given.
    for inputs in [vec![clips.clone()], vec![clips.join("walks")], vec![clips.join("walks/walk_00.bvh")]] {
        assert_eq!(made(inputs.clone(), &cache), made(inputs, &Cache::disabled()));
    }
}

/// Puts another clip in the place of one when a stage begins.
struct Meddler {
    clip: PathBuf,
    stage: &'static str,
}

impl Progress for Meddler {
    fn begin(&self, _: &'static str, _: u64, _: &'static str) {}
    fn advance(&self, _: u64) {}
    fn end(&self) {}
    fn enter_stage(&self, stage: &'static str) {
        if stage == self.stage {
            let text = std::fs::read_to_string(&self.clip).expect("a clip");
            std::fs::write(&self.clip, text + "\n").expect("a clip");
        }
    }
}

#[test]
fn a_file_that_changes_while_it_is_read_ends_the_build_and_is_not_cached() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 0.6);
    let (clip, cache) = (clips.join("walk_00.bvh"), Cache::in_folder(folder.path().join("cache")));
    let good = std::fs::read(&clip).expect("a clip");
    for stage in ["import", "clips"] {
        let meddler = Meddler { clip: clip.clone(), stage };
        for build in [pipeline::build, pipeline::build_possible] {
            let e = build(&small_config(vec![clips.clone()]), &out, &cache, &meddler).unwrap_err().to_string();
            assert!(e.contains("walk_00.bvh: it has changed while it was read"), "{e}");
            assert!(!out.exists());
            std::fs::write(&clip, &good).expect("a clip");
        }
    }
    let whole = build(&small_config(vec![clips]), &out, &cache);
    assert!(whole.cached.is_empty(), "{:?}", whole.cached);
}

#[cfg(unix)]
#[test]
fn a_name_that_is_no_text_does_not_end_a_build() {
    use std::os::unix::ffi::OsStringExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 0.6);
    let odd = clips.join(std::ffi::OsString::from_vec(b"w\xff.bvh".to_vec()));
    if std::fs::copy(clips.join("walk_00.bvh"), odd).is_err() {
        return eprintln!("skipped: the file system takes names of text alone");
    }
    let cache = Cache::in_folder(folder.path().join("cache"));
    build(&small_config(vec![clips.clone()]), &out, &cache);
    assert!(build(&small_config(vec![clips]), &out, &cache).cached.contains(&"motion"));
}

#[test]
fn a_bundle_takes_the_place_of_no_other_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let clips = folder.path().join("clips");
    write_clips(&clips, 0.6);
    let clip = clips.join("walk_00.bvh");
    let before = std::fs::read(&clip).expect("a clip");
    let e = pipeline::build(&small_config(vec![clips]), &clip, &Cache::disabled(), &Silent).unwrap_err().to_string();
    assert!(e.contains("walk_00.bvh: it is there and is not a bundle"), "{e}");
    assert_eq!(std::fs::read(&clip).expect("a clip"), before);
}

#[test]
fn one_more_performer_costs_the_files_of_that_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 0.6);
    let first = std::fs::read_to_string(clips.join("walk_00.bvh")).expect("a clip");
    let num_files = std::fs::read_dir(&clips).expect("the folder").count();
    let cache = Cache::in_folder(folder.path().join("cache"));
    let config = small_config(vec![clips.clone()]);
    assert_eq!(build(&config, &out, &cache).clips_kept, 0);
    // The same walk by somebody with shorter arms.
    let other = first.replace("OFFSET 29.000000", "OFFSET 27.000000");
    assert!(other != first, "no upper arm of that length");
    std::fs::write(clips.join("other.bvh"), other).expect("a clip");
    let more = build(&config, &out, &cache);
    assert_eq!((more.files_kept, more.clips_kept, more.performers.len()), (num_files, num_files, 2));
    let made = std::fs::read(&out).expect("a bundle");
    build(&config, &out, &Cache::disabled());
    assert!(made == std::fs::read(&out).expect("a bundle"), "the cache changes nothing");
}

#[test]
fn ranges_left_out_in_sidecars_are_left_out_of_the_bundle() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 1.0);
    let cache = Cache::in_folder(folder.path().join("cache"));
    let mut config = small_config(vec![clips.clone()]);
    config.resample.mirror = true;
    let all = build(&config, &out, &cache);
    let sidecar = "unit = \"frames\"\nexclude = [[100, 160]]\n\n[[tags]]\nname = \"begin\"\nstart = 0\nend = 50\n";
    std::fs::write(clips.join("walk_01.toml"), sidecar).expect("a sidecar");
    let inline = Sidecar { exclude: vec![[5.0, 7.0]], ..Default::default() };
    config.clips.insert("walk_02".into(), inline);
    let some = build(&config, &out, &cache);
    assert_eq!(some.excluded_frames.get("sidecar"), Some(&(2 * (60 + 60))), "{:?}", some.excluded_frames);
    assert!(some.frames_in < all.frames_in);

    let tables = Bundle::open(&out).expect("the bundle opens");
    let clip = |name: &str| tables.meta().clips.iter().position(|c| c.name == name).expect("the clip");
    for (name, from, to) in [("walk_01", 100, 160), ("walk_02", 150, 210)] {
        let at = clip(name);
        let excluded = &tables.meta().clips[at].excluded;
        assert!(excluded.contains(&("sidecar".into(), from, to)), "{name}: {excluded:?}");
        let first = tables.clips()[at].first_frame;
        for s in &tables.graph().segments {
            let last = s.start + s.num_frames;
            assert!(last < first + from || s.start >= first + to, "a segment plays frames left out of {name}: {s:?}");
        }
    }
    assert_eq!(tables.meta().clips[clip("walk_01")].tags, [("begin".into(), 0, 50)]);
}

#[test]
fn one_bad_file_is_skipped_and_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 0.6);
    let whole = small_config(vec![clips.clone()]);
    let clean = build(&whole, &out, &Cache::disabled());
    let good = std::fs::read_to_string(clips.join("walk_00.bvh")).expect("a clip");
    std::fs::write(clips.join("broken.bvh"), &good[..good.len() / 2]).expect("a clip");
    let report = build(&whole, &out, &Cache::disabled());
    assert_eq!((report.clips, report.frames_in), (clean.clips, clean.frames_in));
    assert!(matches!(&report.skipped[..], [s] if s.contains("broken.bvh")), "{:?}", report.skipped);

    let before = std::fs::read(&out).expect("the bundle can be read");
    let mut strict = whole;
    strict.import.strict = true;
    let e = pipeline::build(&strict, &out, &Cache::disabled(), &Silent).expect_err("a broken file");
    assert!(matches!(e, BuildError::Import(_)) && e.to_string().contains("broken.bvh:"), "{e}");
    assert!(std::fs::read(&out).expect("the bundle can be read") == before, "a failed build changed the old bundle");
}

#[test]
fn too_little_motion_is_an_error_that_says_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (clips, out) = (folder.path().join("clips"), folder.path().join("a.throng"));
    write_clips(&clips, 0.1);
    let mut config = small_config(vec![clips]);
    let all_but_a_little = Sidecar { exclude: vec![[4.0, f64::INFINITY]], ..Sidecar::default() };
    config.clips = (0..10).map(|i| (format!("walk_0{i}"), all_but_a_little.clone())).collect();
    config.clips.retain(|name, _| config.inputs[0].join(format!("{name}.bvh")).exists());
    let e = pipeline::build(&config, &out, &Cache::disabled(), &Silent).expect_err("too little");
    assert!(e.to_string().contains("less than graph.min_component_s = 10 s"), "{e}");
    assert!(!out.exists(), "a failed build left a bundle");
    let left = std::fs::read_dir(folder.path()).expect("the folder").count();
    assert_eq!(left, 1, "only the clips are there");
}

#[test]
fn a_behaviour_of_ones_own_needs_the_config_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (file, out) = (folder.path().join("own.toml"), folder.path().join("own.throng"));
    // Keep two metres away from the target; nothing beyond five metres matters.
    let text = "[synth]\nset = \"walk\"\nminutes = 2.0\n\n[policy]\ncompare_samples = 50\n\n[[behaviours]]\n\
        name = \"keep-distance\"\noffset = 2.0\nscale = 0.5\nregion = { distance_m = [0.0, 5.0] }\n\
        grid = { rings = 12, angles = 16, radius = 5.0, inner_spacing = 0.3 }\n";
    std::fs::write(&file, text).expect("a config");
    let config = BuildConfig::load(&file).expect("a sound config");
    build(&config, &out, &Cache::disabled());
    let tables = Bundle::open(&out).expect("a bundle");
    let motion_set = MotionSet::new(&tables);
    let n = 40;
    let (starts, mut orders) = (common::starts(&tables, n), Vec::new());
    // Half of them stand too near, half too far.
    for (i, s) in starts.iter().enumerate() {
        let distance = if i % 2 == 0 { 0.3 } else { 4.0 };
        orders.push(PolicyOrder::towards(0, s.root.translation() + glam::Vec3::new(distance, 0.0, 0.0)));
    }
    let mut characters = Characters::new(&motion_set, CharactersConfig::default(), &starts).expect("characters");
    for _ in 0..15 * 30 {
        characters.step(&motion_set, 1.0 / 30.0, &orders).expect("a step");
    }
    let off = |c: usize| (characters.root(c).translation().distance(orders[c].target()) - 2.0).abs();
    let near = (0..n).filter(|&c| off(c) < 0.7).count();
    assert!(near > n * 8 / 10, "{near} of {n} keep their distance");
}

#[test]
fn evasion_knows_where_heads_go() {
    let tables = common::boxing_tables();
    let number = tables.find_policy("evade").expect("a policy that evades");
    let (policy, poses, graph) = (&tables.policies()[number], sampled(&tables), tables.graph());
    let middle_of_head = 0.5 * tables.skeleton().tips[0];
    let head = |frame: u32| {
        let (root, pose) = &poses[frame as usize];
        let m = &pose[Joint::Head.index()].rows;
        let turned = glam::Vec3::from_array(std::array::from_fn(|r| {
            m[r][0] * middle_of_head.x + m[r][1] * middle_of_head.y + m[r][2] * middle_of_head.z + m[r][3]
        }));
        root.translation() + root.rotation() * turned
    };
    assert_eq!(policy.paths().len(), graph.segments.len());
    for (segment, path) in graph.segments.iter().zip(policy.paths()) {
        let start = poses[segment.start as usize].0.inverse();
        for (point, frame) in [(0, segment.start), (PATH_POINTS - 1, segment.start + segment.num_frames)] {
            let wanted = start.translation() + start.rotation() * head(frame);
            let found = glam::Vec3::from_array(path.points[point]);
            assert!(found.distance(wanted) < 2e-3, "frame {frame}: {found} {wanted}");
        }
        assert!((path.duration_s * 30.0 - segment.num_frames as f32).abs() < 1e-3);
    }
    // A blow at a head that stays is worse than one a metre beside it.
    let mut scores = [0.0; MAX_ACTIONS];
    let mut worst = |target| {
        let n = policy.action_scores(0, target, &mut scores).expect("state 0");
        scores[..n].iter().copied().fold(f32::INFINITY, f32::min)
    };
    let at_head = head(graph.states[0].frame) - poses[graph.states[0].frame as usize].0.translation();
    let near = poses[graph.states[0].frame as usize].0.rotation().inverse() * at_head;
    let (hit, missed) = (worst(near.with_y(0.05)), worst(near.with_y(0.05) + glam::Vec3::X));
    assert!(hit < -0.3 && missed > -0.05, "{hit} {missed}");
}
