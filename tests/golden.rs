//! Tables of the current version open and say what they always said; tables of other versions are refused by name.
//!
//! `examples/make_golden.rs` makes those of `data/golden/`. Headers of other versions are forged.

use std::path::PathBuf;
use throng_core::characters::{
    ActionChoice, CharacterStart, Characters, CharactersConfig, MotionSet, PolicyOrder, SampleJob,
};
use throng_core::format::{AlignedBytes, FileHeader, FormatError, VERSION};
use throng_core::{Bundle, Joint, Mat3x4, NUM_JOINTS, Planar};

fn golden() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("data/golden/tables_v{VERSION}.throng"))
}

#[test]
fn the_current_version_has_golden_tables_that_open() {
    let path = golden();
    let tables = Bundle::open(&path).expect("tables of the current version");
    assert!(Bundle::open_unverified(&path).is_ok());
    let graph = tables.graph();
    assert_eq!(tables.meta().name, "golden");
    assert_eq!(tables.meta().rate_hz, 20.0);
    assert_eq!(tables.meta().behaviours, ["approach"]);
    assert!(tables.meta().sources.iter().all(|s| s.path.starts_with("walk/")), "made of synthetic clips alone");
    assert_eq!((tables.clips().len(), tables.frames().len()), (CLIPS, FRAMES));
    assert_eq!((graph.states.len(), graph.segments.len(), graph.action_segments.len()), (STATES, SEGMENTS, ACTIONS));
    assert_eq!(tables.policies()[0].grid().num_cells(), 40);
    let (blends, names) = (tables.blends(), &tables.meta().blends);
    assert_eq!((names[0].name.as_str(), names[0].axes.as_slice()), ("walks", &["speed".into(), "gyration".into()][..]));
    let speeds: Vec<f32> = blends.examples.iter().map(|e| e.velocity[1]).collect();
    let near = speeds.len() == BLEND_SPEEDS.len() && speeds.iter().zip(BLEND_SPEEDS).all(|(a, b)| (a - b).abs() < 1e-3);
    assert!(near, "expected {BLEND_SPEEDS:?}, found {speeds:?}");
    assert!(tables.num_bytes() < 350_000, "golden tables stay small");
}

#[test]
fn golden_poses_stand_where_they_always_stood() {
    let tables = Bundle::open(golden()).expect("tables of the current version");
    let motion_set = MotionSet::new(&tables);
    let frames: Vec<u32> = (0..tables.frames().len() as u32 - 1).collect();
    let ratios = vec![0.5; frames.len()];
    let mut matrices = vec![Mat3x4::default(); frames.len() * NUM_JOINTS];
    SampleJob { motion_set: &motion_set, frames: &frames, ratios: &ratios, matrices: &mut matrices }
        .run()
        .expect("a batch of poses");
    let mean = |j: Joint| {
        let sum: glam::DVec3 = matrices.chunks(NUM_JOINTS).map(|p| p[j.index()].translation().as_dvec3()).sum();
        sum / frames.len() as f64
    };
    let found = POSE.map(|(joint, _)| (joint, mean(joint).to_array()));
    let near = |a: [f64; 3], b: [f64; 3]| glam::DVec3::from(a).distance(b.into()) < 1e-4;
    assert!(POSE.iter().zip(&found).all(|(a, b)| near(a.1, b.1)), "expected {POSE:?}, found {found:?}");
}

#[test]
fn a_golden_character_takes_the_way_it_always_took() {
    let tables = Bundle::open(golden()).expect("tables of the current version");
    let motion_set = MotionSet::new(&tables);
    let start = CharacterStart { root: Planar::new(0.0, 0.0, 0.0), state: 0 };
    let config = CharactersConfig { choice: ActionChoice::BestAction, ..CharactersConfig::default() };
    let mut characters = Characters::new(&motion_set, config, &[start]).expect("characters");
    let orders = [PolicyOrder::towards(0, glam::Vec3::new(2.0, 0.0, 3.0))];
    for _ in 0..40 {
        characters.step(&motion_set, 0.05, &orders).expect("a step");
    }
    let root = characters.root(0);
    assert!(root.translation().distance(PLACE_AFTER_2_S.into()) < 1e-2, "{root:?}");
}

#[test]
fn tables_of_other_versions_are_refused_by_name() {
    let bytes = std::fs::read(golden()).expect("tables of the current version");
    for version in (0..VERSION).chain([VERSION + 1, u32::MAX]) {
        let mut header: FileHeader = bytemuck::pod_read_unaligned(&bytes[..64]);
        header.version = version;
        header.header_crc32 = header.checksum();
        let other = [bytemuck::bytes_of(&header), &bytes[64..]].concat();
        let e = Bundle::from_bytes(AlignedBytes::from_slice(&other)).expect_err("another version");
        assert!(matches!(e, FormatError::Version { got, .. } if got == version), "{e}");
        assert!(e.to_string().contains(&format!("format version {version}")) && e.to_string().contains("throng build"));
    }
}

const CLIPS: usize = 4;
const FRAMES: usize = 1168;
const STATES: usize = 96;
const SEGMENTS: usize = 96;
const ACTIONS: usize = 1346;
/// Speeds of the examples of the blend space (m/s).
const BLEND_SPEEDS: [f32; 5] = [0.551, 0.134, 1.175, 0.154, 1.167];
/// Mean place of joints in model space, halfway between frames (m).
const POSE: [(Joint, [f64; 3]); 4] = [
    (Joint::Head, [0.0, 1.567446, 0.039274]),
    (Joint::LeftHand, [0.246328, 0.898884, 0.086923]),
    (Joint::RightHand, [-0.246330, 0.898883, 0.086910]),
    (Joint::LeftToe, [0.097898, 0.034592, 0.085264]),
];
/// Where the character comes in 2 s (m).
const PLACE_AFTER_2_S: [f32; 3] = [0.4612, 0.0, 1.208];
