//! `throng export` of what runs: files are read back, and every joint is where the run had it.

use super::{BundleFolder, at, done, failed, folder, refused};
use glam::Vec3;
use std::path::Path;
use std::sync::LazyLock;
use throng_core::{Bundle, Inline, Joint, NUM_JOINTS};
use throng_precompute::import::{ImportConfig, read_clips};
use throng_precompute::trial::{self, TrialConfig};
use throng_simulation::{Scene, Simulation};

/// Walks at several speeds and turns, which blend.
const WALKS: &str = "name = \"walks\"\nsynth = { set = \"locomotion\", minutes = 2.0 }\nbehaviours = []\n\
    [resample]\nrate_hz = 60.0\nmirror = false\n[annotate.ends]\nstill = false\n[graph]\nenabled = false\n\
    [blend.ahead]\naxes = [{ kind = \"speed\" }, { kind = \"gyration\" }]\nexamples = [{ clip = \"walk_neutral_*\" }]\n";
const HEAD: &str = "bundle = \"walks.throng\"\nconfig = \"walks.toml\"\nseconds = 3\n[[groups]]\nmotion = \"blend\"\n\
    spaces = [\"ahead\"]\n";
/// Half a minute of shadow-boxing, small grids.
const FIGHT: &str = "[synth]\nset = \"boxing\"\nminutes = 0.5\n[policy]\ncompare_samples = 50\n[[behaviours]]\n\
    name = \"approach\"\ncentre = \"hits\"\ngrid = { rings = 5, angles = 9, radius = 2.0, inner_spacing = 0.5 }\n\
    [[behaviours]]\nname = \"throw-punches\"\nkind = \"throw_punches\"\ngrid = { rings = 5, angles = 5, heights = 3 }\n";
const BOXERS: &str = "bundle = \"fight.throng\"\nconfig = \"fight.toml\"\nseconds = 3\n[[groups]]\ncount = 2\n\
    [[groups.behaviours]]\nname = \"approach\"\n[[groups.behaviours]]\nname = \"throw-punches\"\n";

/// A folder of scenes; the first run of one builds its bundle.
static SCENES: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let place = folder();
    let write = |name: &str, text: &str| std::fs::write(at(&place, name), text).expect("a file");
    write("walks.toml", WALKS);
    write("fight.toml", FIGHT);
    let paths = "name = \"on paths\"\ncount = 3\npaths = { speeds = [0.8, 1.5], area_m = 20.0 }\n\
                 bodies = { sizes = [0.8, 1.1] }\n";
    let crowd = "name = \"crowd\"\ncount = 4\nplace = { block = { from = [-4.0, -3.0], to = [4.0, 3.0] } }\n\
                 speed_mps = [1.0, 1.4]\ngoal = { shift = { by = [8.0, 0.0] } }\n";
    write("paths.toml", &format!("{HEAD}{paths}"));
    write("crowd.toml", &format!("{HEAD}{crowd}"));
    write("pair.toml", &BOXERS.replace("count", "motion = \"sparring\"\ncount"));
    let target = format!("{BOXERS}[groups.target]\nheight_m = 1.5\n");
    write("target.toml", &target.replace("count", "motion = \"policy\"\ncount"));
    for scene in ["paths.toml", "pair.toml"] {
        done(&["run", &at(&place, scene), "--seconds", "0.1", "--no-cache"]);
    }
    place
});

type Pose = [Vec3; NUM_JOINTS];

/// Where all joints of everybody are at some times, by the runtime alone: times are whole steps of 60 Hz.
fn ran(scene: &str, times: impl Iterator<Item = usize>) -> Vec<Vec<Option<Pose>>> {
    let compiled = Scene::load(at(&SCENES, scene)).expect("a scene").open().expect("its bundle");
    let mut sim = Simulation::new(&compiled).expect("it starts");
    let mut step = 0;
    times
        .map(|wanted| {
            while step < wanted {
                step += 1;
                sim.step_to(step as f64 / 60.0, &Inline).expect("a step");
            }
            (0..sim.num_characters()).map(|who| sim.joint_positions(who)).collect()
        })
        .collect()
}

/// Where joints are in the clips of a file, by frame.
fn read(file: &str) -> Vec<Vec<Pose>> {
    let config = ImportConfig { metres_per_unit: None, loops: false, ..ImportConfig::default() };
    let clips = read_clips(Path::new(file), &config).unwrap_or_else(|e| panic!("{e}"));
    let pose = |clip: &throng_precompute::import::ImportedClip, frame: usize| {
        let world = clip.clip.world(frame);
        Joint::ALL.map(|j| world[clip.roles.get(j).expect("every role")].0)
    };
    clips.iter().map(|c| (0..c.clip.num_frames).map(|f| pose(c, f)).collect()).collect()
}

/// Holds clips against what ran: `who` has the number of each clip.
fn same(read: &[Vec<Pose>], who: &[usize], ran: &[Vec<Option<Pose>>], what: &str) {
    assert_eq!(read.len(), who.len(), "{what}");
    for (clip, &character) in read.iter().zip(who) {
        assert_eq!(clip.len(), ran.len(), "{what}");
        for (frame, (got, all)) in clip.iter().zip(ran).enumerate() {
            let want = all[character].expect("a body");
            let off = got.iter().zip(&want).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            assert!(off < 1e-4, "{what}: character {character} is {off} m off at frame {frame}");
        }
    }
}

#[test]
fn every_joint_of_walkers_crowds_boxers_and_pairs_is_where_the_run_had_it() {
    let out = folder();
    for (scene, who) in [("paths.toml", 0..3), ("crowd.toml", 1..4), ("target.toml", 0..2), ("pair.toml", 0..2)] {
        let who: Vec<usize> = who.collect();
        let numbers = format!("{}..{}", who[0], who[who.len() - 1]);
        // From 0.5 s on, every second step.
        let ran = ran(scene, (0..46).map(|f| 30 + 2 * f));
        let export = |format: &str, file: &str, more: &[&str]| {
            let file = at(&out, file);
            let scene = at(&SCENES, scene);
            let args = ["export", &scene, "--format", format, "--characters", &numbers, "--out", &file];
            let told = done(&[&args[..], &["--from", "0.5", "--to", "2"], more].concat());
            assert!(told.contains("46 frames at 30 Hz"), "{told}");
            file
        };
        same(&read(&export("glb", "a.glb", &[])), &who, &ran, &format!("{scene} as glb"));
        export("bvh", "a.bvh", &["--fps", "30"]);
        for &c in &who {
            same(&read(&at(&out, &format!("a-{c}.bvh"))), &[c], &ran, &format!("{scene} as bvh"));
        }
        let csv = std::fs::read_to_string(export("csv", "a.csv", &[])).expect("a table");
        let mut lines = csv.lines().skip(1);
        for (&c, frame, joint) in who.iter().flat_map(|c| (0..46).flat_map(move |f| Joint::ALL.map(|j| (c, f, j)))) {
            let fields: Vec<&str> = lines.next().expect("a row").split(',').collect();
            assert_eq!((fields[0], fields[2]), (&*c.to_string(), joint.name()));
            let got = Vec3::from_array(std::array::from_fn(|k| fields[3 + k].parse().expect("a number")));
            let want = ran[frame][c].expect("a body")[joint.index()];
            assert!(got.distance(want) < 1e-4, "{scene} as csv: character {c}, frame {frame}");
        }
        let first = std::fs::read(at(&out, "a.glb")).expect("a file");
        export("glb", "a.glb", &[]);
        assert!(std::fs::read(at(&out, "a.glb")).expect("a file") == first, "the same bytes again");
    }
}

#[test]
fn recordings_are_written_as_they_ran_and_no_longer() {
    let out = folder();
    let (scene, record, file) = (at(&SCENES, "crowd.toml"), at(&out, "a.rec"), at(&out, "a.glb"));
    done(&["run", &scene, "--seconds", "2", "--record", &record]);
    done(&["export", &record, "--format", "glb", "--characters", "0,2", "--out", &file]);
    same(&read(&file), &[0, 2], &ran("crowd.toml", (0..61).map(|f| 2 * f)), "a recording");
    let e = failed(&["export", &record, "--format", "glb", "--to", "5", "--out", &file]);
    assert!(e.contains("--to 5: expected 2 s at most") && e.contains("a.rec"), "{e}");
}

#[test]
fn characters_of_a_bundle_are_those_of_its_trial() {
    let (place, out) = (BundleFolder::shared(), folder());
    let file = at(&out, "a.glb");
    done(&["export", &place.bundle(), "--format", "glb", "--characters", "3", "--to", "1", "--out", &file]);
    let config = TrialConfig { recorded: Some(3), seconds: 1.0, ..TrialConfig::default() };
    let bundle = Bundle::open(place.bundle()).expect("a bundle");
    let (_, record) = trial::run(&bundle, &config).expect("a trial");
    let every_second: Vec<_> = record.frames.iter().step_by(2).map(|f| vec![Some(f.positions)]).collect();
    same(&read(&file), &[0], &every_second, "a bundle");
    // Which clips play on them, for programs that draw instances.
    let arrays = at(&out, "a.npz");
    let told = done(&["export", &place.bundle(), "--format", "instances", "--to", "1", "--out", &arrays]);
    assert!(told.contains("1000 character(s), 31 frames at 30 Hz"), "{told}");
    let (clips, times, places) = instances(&std::fs::read(&arrays).expect("a file"));
    // A clip of the figure, laid where it is said, is the character but for transitions and locked feet.
    done(&["export", &place.bundle(), "--format", "glb", "--clips", "--out", &file]);
    let stored = read(&file);
    let mut off = Vec::new();
    for frame in 0..31 {
        let k = 3 * 31 + frame;
        let (clip, at) = (&stored[clips[k] as usize], times[k] * bundle.meta().rate_hz as f32);
        let root = throng_core::Planar::new(places[3 * k], places[3 * k + 1], places[3 * k + 2]);
        let (before, after) = (&clip[at as usize], &clip[(at.ceil() as usize).min(clip.len() - 1)]);
        let want = every_second[frame][0].expect("a body");
        for j in 0..NUM_JOINTS {
            let figure = before[j].lerp(after[j], at.fract());
            off.push((root.rotation() * figure + root.translation()).distance(want[j]));
        }
    }
    let mean = off.iter().sum::<f32>() / off.len() as f32;
    assert!(mean < 0.05, "{mean} m");
    // And its clips, as they are stored: one figure, an animation for each.
    done(&["export", &place.bundle(), "--format", "glb", "--clips", "--out", &file]);
    let clips = read(&file);
    assert_eq!(clips.len(), bundle.clips().len());
    assert!(clips.iter().zip(bundle.clips().iter()).all(|(c, r)| c.len() == r.num_frames as usize));
}

/// Clips, times and places of an instances file: of every character, frame by frame.
fn instances(bytes: &[u8]) -> (Vec<i32>, Vec<f32>, Vec<f32>) {
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(bytes)).expect("an archive");
    let mut array = |name: &str| {
        let file = zip.by_name(name).expect(name);
        let (begin, size) = (file.data_start().expect("a place") as usize, file.size() as usize);
        let header = 10 + u16::from_le_bytes([bytes[begin + 8], bytes[begin + 9]]) as usize;
        bytes[begin + header..begin + size].as_chunks::<4>().0.to_vec()
    };
    let clips = array("clip.npy").into_iter().map(i32::from_le_bytes).collect();
    let mut floats = |name| array(name).into_iter().map(f32::from_le_bytes).collect();
    (clips, floats("time_s.npy"), floats("place.npy"))
}

#[test]
fn times_between_steps_lie_between_their_poses() {
    let out = folder();
    let (scene, file) = (at(&SCENES, "paths.toml"), at(&out, "a.glb"));
    // Every second frame of 24 a second is on a step of 60 a second; the others are half way.
    done(&["export", &scene, "--format", "glb", "--fps", "24", "--to", "1", "--characters", "0", "--out", &file]);
    let (read, ran) = (read(&file), ran("paths.toml", 0..61));
    assert_eq!(read[0].len(), 25);
    for (frame, got) in read[0].iter().enumerate() {
        let at = |step: usize| ran[step][0].expect("a body");
        let (before, after) = (at(5 * frame / 2), at((5 * frame).div_ceil(2)));
        for j in 0..NUM_JOINTS {
            let (want, step) = ((before[j] + after[j]) * 0.5, before[j].distance(after[j]));
            // Limbs go from pose to pose on arcs, not on lines.
            let most = if frame % 2 == 0 { 1e-4 } else { 1e-3 + 0.3 * step };
            assert!(got[j].distance(want) < most, "frame {frame}, joint {j}: {} of {step}", got[j].distance(want));
        }
    }
}

#[test]
fn characters_of_the_users_own_wear_what_runs() {
    let out = folder();
    let (scene, one, worn) = (at(&SCENES, "pair.toml"), at(&out, "one.glb"), at(&out, "worn.glb"));
    // The plain body of one of them is a character too.
    done(&["export", &scene, "--format", "glb", "--characters", "0", "--to", "0.1", "--out", &one]);
    let told = done(&["export", &scene, "--format", "glb", "--onto", &one, "--to", "1", "--out", &worn]);
    assert!(
        told.contains("22 of 22 joints wear the motion: hips=hips") && told.contains("twist joints: none"),
        "{told}"
    );
    // Its soles are laid onto the ground: joints are lifted or lowered by one height, at every frame alike.
    let (read, ran) = (read(&worn), ran("pair.toml", (0..31).map(|f| 2 * f)));
    assert_eq!(read.len(), 2);
    let lift = read[0][0][0].y - ran[0][0].expect("a body")[0].y;
    assert!(lift.abs() < 0.01, "{lift}");
    for (frame, all) in ran.iter().enumerate() {
        for (clip, want) in read.iter().zip(all) {
            let want = want.expect("a body");
            let off = clip[frame].iter().zip(&want).map(|(a, b)| a.distance(*b + Vec3::Y * lift));
            let off = off.fold(0.0, f32::max);
            assert!(off < 1e-3, "a joint is {off} m off at frame {frame}");
        }
    }
}

#[test]
fn what_cannot_be_written_is_said_with_the_way_out() {
    let (place, out) = (BundleFolder::shared(), folder());
    let (scene, file) = (at(&SCENES, "paths.toml"), at(&out, "a.glb"));
    let fails = |args: &[&str], parts: &[&str]| {
        let e = failed(&[&["export"], args].concat());
        assert!(parts.iter().all(|p| e.contains(p)), "{args:?}: {parts:?}: {e}");
    };
    let glb = ["--format", "glb", "--out", &file];
    let with = |args: &[&str], parts: &[&str]| fails(&[&[&*scene], &glb[..], args].concat(), parts);
    with(&["--characters", "1..3"], &["paths.toml", "--characters 1..3: there are 3", "0..2"]);
    with(&["--from", "2", "--to", "1"], &["--from 2 --to 1", "the earlier one first"]);
    with(&["--clips"], &["--clips is for bundles"]);
    with(&["--usd-instances"], &["--format usda"]);
    with(&["--onto", &at(&out, "absent.glb")], &["absent.glb"]);
    with(&["--onto", &place.first_clip()], &[".bvh", "expected a glTF 2.0 document"]);
    fails(&[&at(&out, "absent.throng"), "--format", "usda", "--out", &file], &["absent.throng"]);
    fails(&[&place.bundle(), "--format", "npz", "--clips", "--fps", "60", "--out", &file], &["Leave out --fps"]);
    fails(&[&scene, "--format", "npz"], &["--out"]);
    fails(&[&scene, "--format", "usda", "--onto", &file, "--out", &file], &["--format glb", "Blender"]);
    fails(&[&scene, "--format", "instances", "--out", &file], &["paths.toml", "instances are of bundles"]);
    fails(&[&scene, "--format", "positions-csv", "--to", "1"], &["--to is for glb, usda"]);
    fails(&[&place.first_clip(), "--format", "glb", "--to", "1", "--out", &file], &["--to is for scenes"]);
    fails(&[&scene, "--format", "usda", "--out", &at(&out, "no/a.usda")], &["there is no folder"]);
    let bare = at(&out, "bare.toml");
    let discs = "[[groups]]\nname = \"discs\"\nmotion = \"none\"\ncount = 3\n\
        place = { block = { from = [-5.0, -5.0], to = [5.0, 5.0] } }\ngoal = { stay = {} }\n";
    std::fs::write(&bare, discs).expect("a scene");
    fails(&[&[&*bare], &glb[..]].concat(), &["character 0 has no body", "\"discs\"", "--trajectories"]);
    assert!(!Path::new(&file).exists(), "nothing is left of what failed");
    assert!(refused(&["export", &scene, "--format", "glb", "--characters", "5..2"]).contains("0..99"));
}
