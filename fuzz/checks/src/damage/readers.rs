//! One function for every reader of bytes from outside: it reads them and uses what was read, as applications do.
//!
//! Each returns true where the bytes were accepted, and panics where what was accepted does harm.

use super::{repair, snapshots};
use glam::{DVec3, Quat};
use std::cell::OnceCell;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;
use throng_bake::config::BuildConfig;
use throng_bake::environment::{EnvironmentFile, UnitSet, geometries};
use throng_bake::stitch::WorldSource;
use throng_core::format::AlignedBytes;
use throng_core::{Bundle, NUM_JOINTS, Skeleton};
use throng_geometry::{Segment, TriangleMesh};
use throng_motion::annotate::{AnnotateConfig, Sidecar, Sidecars, annotate};
use throng_motion::export::{ActorPose, TakeWriter};
use throng_motion::import::profile::Profile;
use throng_motion::import::{self, ImportConfig, SourceClip, amc, asf, bvh, gltf, npz};
use throng_motion::progress::Silent;
use throng_motion::resample::{ResampleConfig, resample};
use throng_motion::retarget::{self, RetargetConfig};
use throng_motion::wearer::{SkinnedFigure, Wearer};
use throng_motion::{Clip, ImportError};
use throng_planner::limits::{BodyLimits, PoseSampler, Style};
use throng_planner::linkage::{Limb, LimbPose};
use throng_planner::task::{ActorClip, Task, obj_triangles};
use throng_simulation::{Scene, Simulation};
use throng_world::made_up_floor;

/// Parts the two files of an `amc` input: the ASF skeleton before it, the AMC motion after it.
pub const ASF_AMC_SEAM: &[u8] = b"#--amc--\n";
/// Scenes of more characters, clips of more frames and environments of more units are read and not used.
const FEW: usize = 300;
/// Steps that are made with what was accepted.
const STEPS: usize = 8;

/// A bundle, as it is and with its checksums put right: opened, and stepped in every way that it allows.
pub fn bundle(data: &[u8]) -> bool {
    let open = |bytes: &[u8]| Bundle::from_bytes(AlignedBytes::from_slice(bytes));
    let found = open(data).or_else(|_| open(&repair::bundle(data)));
    found.is_ok_and(|bundle| {
        use_bundle(&bundle);
        true
    })
}

fn use_bundle(bundle: &Bundle) {
    let quoted = |name: &str| toml::Value::from(name).to_string();
    let grid = "place = { grid = { spacing_m = 4.0, distance_m = 1.0 } }";
    let mut groups = Vec::new();
    for name in &bundle.meta().behaviours {
        let name = quoted(name);
        for (motion, temperature) in [("policy", 0.0), ("policy", 0.3), ("sparring", 0.1)] {
            groups.push(format!(
                "motion = \"{motion}\"\ncount = 4\n{grid}\ntemperature = {temperature:?}\nbehaviours = [{{ name = {name} }}]\n"
            ));
        }
    }
    for blend in &bundle.meta().blends {
        groups.push(format!(
            "motion = \"blend\"\ncount = 4\nspaces = [{}]\npaths = {{ speeds = [0.0, 2.0], area_m = 20.0, seconds = [0.3, 1.0] }}\n",
            quoted(&blend.name)
        ));
    }
    for group in groups {
        let text = format!("bundle = \"own.throng\"\n[[groups]]\n{group}");
        let scene = Scene::parse(&text, Path::new("scene.toml"));
        if let Ok(sim) = scene.and_then(|s| s.compile(bundle)).and_then(|s| Simulation::new(&s)) {
            run(sim);
        }
    }
}

/// A world of the made-up floor, as it is and with its checksums put right: opened, and lived in.
pub fn world(data: &[u8]) -> bool {
    static FLOOR: OnceLock<Bundle> = OnceLock::new();
    let floor = FLOOR.get_or_init(made_up_floor::tables);
    [data.to_vec(), repair::world(data)].iter().any(|bytes| {
        let read = throng_world::World::from_bytes(AlignedBytes::from_slice(bytes), floor);
        let Ok(read) = read else { return false };
        live_in(&read, bytes, floor);
        true
    })
}

fn live_in(world: &throng_world::World, bytes: &[u8], floor: &Bundle) {
    if world.graph().num_instances() > FEW {
        return;
    }
    let path = in_folder("damaged.world", |path| {
        let _ = std::fs::write(path, bytes);
    });
    let group = "motion = \"patches\"\ncount = 3\ngoals = [{ share = 1.0, goal = { perform = { tag = \"sit\", \
                 seconds = [0.5, 1.0] } } }, { share = 1.0, goal = { roam = { seconds = [0.5, 2.0] } } }, \
                 { share = 2.0, goal = { visit = {} } }]";
    let world = toml::Value::from(path.to_string_lossy().as_ref());
    let text = format!("bundle = \"own.throng\"\n[[groups]]\nworld = {world}\n{group}\n");
    let scene = Scene::parse(&text, Path::new("scene.toml")).expect("the scene is fixed");
    if let Ok(sim) = scene.compile(floor).and_then(|s| Simulation::new(&s)) {
        run(sim);
    }
}

/// A recording of policy characters, as it is and with its checksum put right: its scene is read, and its beginning run again.
pub fn recording(data: &[u8]) -> bool {
    snapshots::replay(data)
}

/// Steps a simulation as far as it goes.
fn run(mut sim: Simulation) {
    assert_finite(&sim);
    for _ in 0..STEPS {
        if sim.step(0.1).is_err() {
            return;
        }
        assert_finite(&sim);
    }
    let kept = sim.snapshot();
    sim.restore(&kept).expect("what was saved is restored");
}

/// Asserts that all numbers are finite.
pub(super) fn assert_finite(sim: &Simulation) {
    for who in 0..sim.num_characters() {
        if let Some(root) = sim.root(who) {
            assert!([root.x, root.z, root.heading].iter().all(|v| v.is_finite()), "character {who}: {root:?}");
        }
        if let Some(pose) = sim.pose(who) {
            let finite = pose.iter().all(|m| m.rows.as_flattened().iter().all(|v| v.is_finite()));
            assert!(finite, "character {who}: a pose that is not finite");
        }
    }
}

/// A BVH file: read, retargeted, resampled, annotated.
pub fn bvh(data: &[u8]) -> bool {
    bvh::parse(data, Path::new("fuzz.bvh")).is_ok_and(use_clip)
}

/// An ASF skeleton and an AMC motion with [`ASF_AMC_SEAM`] between them: the same.
pub fn amc(data: &[u8]) -> bool {
    let seam = data.windows(ASF_AMC_SEAM.len()).position(|w| w == ASF_AMC_SEAM);
    let (skeleton, motion) = match seam {
        Some(at) => (&data[..at], &data[at + ASF_AMC_SEAM.len()..]),
        None => (data, &b""[..]),
    };
    let Ok(skeleton) = asf::parse(skeleton, Path::new("fuzz.asf")) else { return false };
    amc::parse(motion, Path::new("fuzz.amc"), &skeleton).is_ok_and(use_clip)
}

/// An SMPL file, as it is and as arrays that are put into one: the same.
pub fn npz(data: &[u8]) -> bool {
    let packed = [Some(data.to_vec()), repair::npz(data)];
    packed.iter().flatten().any(|bytes| npz::parse(bytes, Path::new("fuzz.npz")).is_ok_and(use_clip))
}

/// The motion of a glTF file, text or binary: the same for all of its clips; true where all were read.
pub fn gltf_motion(data: &[u8]) -> bool {
    scene_file(gltf::parse(data, Path::new("fuzz.gltf")))
}

/// An FBX file: the same.
#[cfg(feature = "fbx")]
pub fn fbx(data: &[u8]) -> bool {
    scene_file(import::fbx::parse(data, Path::new("fuzz.fbx")))
}

fn scene_file(clips: Result<Vec<SourceClip>, ImportError>) -> bool {
    clips.is_ok_and(|clips| clips.into_iter().take(FEW).all(use_clip))
}

/// An archive of clips: searched, and all that is found in it read; true where something was found.
pub fn archive(data: &[u8]) -> bool {
    let path = in_folder("fuzz.zip", |path| {
        let _ = std::fs::write(path, data);
    });
    let found = import::find_motion_files(std::slice::from_ref(&path)).unwrap_or_default();
    for file in found.iter().take(FEW) {
        drop(import::read_clips(&file.path, &ImportConfig::default()));
    }
    !found.is_empty()
}

fn use_clip(source: SourceClip) -> bool {
    let Ok(clip) = import::interpret(source, &ImportConfig::default(), &[]) else { return false };
    let seconds = clip.clip.num_frames as f64 / clip.clip.rate_hz.max(1e-3);
    if clip.clip.num_frames > FEW || seconds > FEW as f64 {
        return true;
    }
    let clips = retarget::retarget_clips(&[clip], &RetargetConfig::default(), &mut Default::default());
    let clips = clips.and_then(|clips| resample(&clips, &ResampleConfig::default()));
    let clips = clips.and_then(|clips| annotate(&clips, &AnnotateConfig::default(), &Sidecars::default()));
    if let Ok(clips) = clips {
        let finite = clips.clips.iter().flat_map(|c| &c.root_positions).all(|p| p.is_finite());
        assert!(finite, "a root that is not finite");
    }
    true
}

/// A build config; what was read can be written and read again.
pub fn config(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(config) = BuildConfig::parse(text, Path::new("fuzz.toml")) else { return false };
    let written = config.to_toml().expect("what was read can be written");
    BuildConfig::parse(&written, Path::new("written.toml")).expect("what was written can be read");
    true
}

/// A scene; on made-up boxers, it is run where it is small.
pub fn scene(data: &[u8]) -> bool {
    static BOXING: OnceLock<Bundle> = OnceLock::new();
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(scene) = Scene::parse(text, Path::new("fuzz/scene.toml")) else { return false };
    if scene.num_characters() <= FEW {
        let compiled = scene.compile(BOXING.get_or_init(snapshots::boxing));
        if let Ok(sim) = compiled.and_then(|s| Simulation::new(&s)) {
            run(sim);
        }
    }
    true
}

/// A world file, and what is placed in it.
pub fn world_file(data: &[u8]) -> bool {
    let path = in_folder("world.toml", |path| {
        let _ = std::fs::write(path, data);
    });
    let Ok(source) = WorldSource::load(&path) else { return false };
    let _ = source.environment(units_of_seeds(), &path);
    true
}

/// Unit objects, and their geometry.
pub fn units(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(units) = UnitSet::parse(text, Path::new("fuzz/units.toml")) else { return false };
    if units.units.len() <= FEW
        && let Ok(geometries) = geometries(&units)
    {
        for g in &geometries {
            assert!(!g.distance(glam::Vec3::new(0.3, 1.0, -0.2)).is_nan(), "a distance that is no number");
        }
    }
    units.to_toml().expect("what was read can be written");
    true
}

/// An environment file, laid out.
pub fn environment(data: &[u8]) -> bool {
    let path = in_folder("environment.toml", |path| {
        let _ = std::fs::write(path, data);
    });
    let Ok(file) = EnvironmentFile::load(&path) else { return false };
    if let Ok(placed) = file.expand(units_of_seeds(), &path) {
        assert!(placed.units.iter().all(|u| u.placement.translation().is_finite()), "a place that is not finite");
    }
    true
}

fn units_of_seeds() -> &'static UnitSet {
    static UNITS: OnceLock<UnitSet> = OnceLock::new();
    UNITS
        .get_or_init(|| UnitSet::parse(super::seeds::UNITS, Path::new("units.toml")).expect("the units of the project"))
}

/// A glTF file, text or binary: its triangles as the shape of a unit.
pub fn gltf_mesh(data: &[u8]) -> bool {
    let name = if data.starts_with(b"glTF") { "mesh.glb" } else { "mesh.gltf" };
    let path = in_folder(name, |path| {
        let _ = std::fs::write(path, data);
    });
    let text = format!("[[units]]\nname = \"mesh\"\nshapes = [{{ mesh = {{ file = \"{name}\" }} }}]\n");
    let units = UnitSet::parse(&text, &path.with_file_name("units.toml")).expect("a unit with a mesh");
    let Ok(made) = geometries(&units) else { return false };
    assert!(!made[0].distance(glam::Vec3::new(0.3, 1.0, -0.2)).is_nan(), "a distance that is no number");
    true
}

/// A character of glTF: it wears two poses, and what is written of it is a document.
pub fn character(data: &[u8]) -> bool {
    let Ok(wearer) = Wearer::parse(data, Path::new("fuzz.glb"), &ImportConfig::default()) else { return false };
    triangles(data);
    let (folder, skeleton) = (std::env::temp_dir(), Skeleton::default());
    let actors = vec![(0, "one".into(), skeleton.clone())];
    let mut writer = TakeWriter::new(&folder, actors, 30.0).expect("a temporary file");
    for angle in [0.0, 0.7] {
        let mut turns = [Quat::IDENTITY; NUM_JOINTS];
        turns.iter_mut().for_each(|turn| *turn = Quat::from_rotation_x(angle));
        writer.push(0, Some(ActorPose::from_rotations(&skeleton, skeleton.offsets[0], turns))).expect("room");
    }
    let take = writer.into_take().expect("room");
    let outfit = wearer.dress(&take, &folder, &Silent).expect("room");
    let mut bytes = Vec::new();
    outfit.glb(&take).expect("a small file").write(&mut bytes).expect("memory takes all bytes");
    let (document, _) = gltf::document(&bytes).expect("what was written is read");
    assert!(document.animations.len() == 1 && document.skins.len() <= 1000);
    outfit.numbers(|numbers| assert!(numbers.iter().all(|n| n.is_finite()), "a pose that is not finite"));
    true
}

/// The triangles of a character.
fn triangles(data: &[u8]) {
    let path = in_folder("fuzz.glb", |path| {
        let _ = std::fs::write(path, data);
    });
    if let Ok(figure) = SkinnedFigure::open(&path, &ImportConfig::default()) {
        drop((figure.rest_corners(), figure.carriers()));
    }
}

/// A sidecar; what was read can be written and read again.
pub fn sidecar(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(sidecar) = Sidecar::parse(text, "fuzz.toml") else { return false };
    let written = toml::to_string(&sidecar).expect("what was read can be written");
    Sidecar::parse(&written, "written.toml").expect("what was written can be read");
    true
}

/// A skeleton profile.
pub fn profile(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    Profile::parse(text, Path::new("profile.toml")).is_ok()
}

/// A task of limbs: done for somebody who stands, with few samples.
pub fn task(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(mut task) = Task::parse(text, Path::new("fuzz/task.toml")) else { return false };
    if task.characters.len() > 3 || task.num_steps() > STEPS || task.things.len() > FEW {
        return true;
    }
    let skeleton = Skeleton::default();
    let clip = Clip::new("stands", 30.0, vec![skeleton.offsets[0]; 75], vec![Quat::IDENTITY; 75 * NUM_JOINTS]);
    let clips = vec![ActorClip { clip, skeleton }; task.characters.len()];
    task.config.budget.draws = task.config.budget.draws.min(20);
    task.config.budget.seconds = None;
    task.config.plan.smooth.straighten = task.config.plan.smooth.straighten.min(5);
    task.config.margin_most_s = task.config.margin_s;
    if let Ok(outcome) = task.run(&clips, None) {
        let clips = outcome.clips.iter().map(|[_, after]| after);
        assert!(clips.flat_map(|c| &c.rotations).all(|q| q.is_finite()), "a pose that is not finite");
    }
    true
}

/// A mesh as OBJ: asked for distances.
pub fn obj(data: &[u8]) -> bool {
    let Ok(triangles) = obj_triangles(&String::from_utf8_lossy(data)) else { return false };
    let Ok(mesh) = TriangleMesh::new(triangles) else { return false };
    let line = Segment::new(DVec3::ZERO, DVec3::ONE);
    assert!(!mesh.distance(&line, 1e6).is_nan(), "a distance that is none");
    true
}

/// Limits of joints: poses are drawn within them.
pub fn limits(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(limits) = BodyLimits::parse(text, Path::new("limits.toml"), &Skeleton::default()) else { return false };
    if let Some(of_arm) = limits.limb_limits(Limb::LeftArm) {
        let sampler = PoseSampler::new(of_arm, &LimbPose::REST, Style::default(), 10);
        let mut rng = throng_planner::planner::seeded_rng(1);
        let finite = (0..20).all(|i| sampler.draw_pose(&mut rng, i).0.iter().all(|q| q.is_finite()));
        assert!(finite, "a pose that is not finite");
    }
    true
}

/// A snapshot of policy characters.
pub fn snapshot_policy(data: &[u8]) -> bool {
    snapshots::restore("policy", data)
}

/// A snapshot of sparring pairs.
pub fn snapshot_sparring(data: &[u8]) -> bool {
    snapshots::restore("sparring", data)
}

/// A snapshot of people in a world.
pub fn snapshot_patches(data: &[u8]) -> bool {
    snapshots::restore("patches", data)
}

/// A snapshot of walkers on random paths.
pub fn snapshot_paths(data: &[u8]) -> bool {
    snapshots::restore("paths", data)
}

/// A snapshot of agents on the ground, some with bodies.
pub fn snapshot_agents(data: &[u8]) -> bool {
    snapshots::restore("agents", data)
}

/// A snapshot of agents in the air.
pub fn snapshot_air(data: &[u8]) -> bool {
    snapshots::restore("air", data)
}

/// The path of a file in a folder of this thread, after something was done with it.
pub(super) fn in_folder(name: &str, work: impl FnOnce(&Path)) -> PathBuf {
    thread_local! {
        static FOLDER: OnceCell<TempDir> = const { OnceCell::new() };
    }
    FOLDER.with(|folder| {
        let folder = folder.get_or_init(|| TempDir::new().expect("a folder for temporary files"));
        let path = folder.path().join(name);
        work(&path);
        path
    })
}
