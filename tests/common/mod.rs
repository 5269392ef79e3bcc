//! Small real bundles, made the ordinary way: synthetic clips are written as files and built from them.
#![allow(dead_code, reason = "each test program uses its own part of this module")]

pub mod mocap;

use glam::Vec3;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use throng_core::characters::{ActionChoice, CharacterStart, CharactersConfig, PolicyOrder, Spawn};
use throng_core::format::AlignedBytes;
use throng_core::{Bundle, CharacterGroup, Planar, Result};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::graph::MakeMotion;
use throng_precompute::pipeline;
use throng_precompute::policy::GridConfig;
use throng_precompute::progress::Silent;
use throng_precompute::report::BuildReport;
use throng_precompute::synth::{self, SynthConfig, SynthSet};
use throng_simulation::sparring::{Sparring, SparringConfig};

/// Writes synthetic clips of a total length into a folder (min).
pub fn write_clips(folder: &Path, minutes: f64) {
    let config = SynthConfig { minutes, clip_seconds: 15.0, ..SynthConfig::default() };
    synth::write_set(SynthSet::Walk, &config, folder).expect("synthetic clips can be written");
}

/// A build with a target grid so small that it takes no time.
pub fn small_config(inputs: Vec<PathBuf>) -> BuildConfig {
    let mut config = BuildConfig::new("small", inputs);
    config.policy.compare_samples = 100;
    // Tests count on the motion as it is.
    config.graph.make = MakeMotion::None;
    config.behaviours[0].grid = GridConfig::polar(6, 8, 6.0, 0.5, 2.0);
    config
}

/// Builds a config.
pub fn build(config: &BuildConfig, out: &Path, cache: &Cache) -> BuildReport {
    pipeline::build(config, out, cache, &Silent).expect("the config builds")
}

/// The bytes of one small bundle, the same for every test of a binary.
pub fn bundle() -> &'static [u8] {
    static BUNDLE: OnceLock<Vec<u8>> = OnceLock::new();
    BUNDLE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (clips, out) = (folder.path().join("clips"), folder.path().join("small.throng"));
        write_clips(&clips, 1.0);
        build(&small_config(vec![clips]), &out, &Cache::disabled());
        Bundle::open(&out).expect("what was built opens");
        std::fs::read(&out).expect("what was built can be read")
    })
}

/// The small bundle, open.
pub fn tables() -> Bundle {
    Bundle::from_bytes(AlignedBytes::from_slice(bundle())).expect("the small bundle opens")
}

/// The bytes of a small bundle of boxing: an approach, blows at a target and evasion, all on small grids; built once a
/// binary.
pub fn boxing_bytes() -> &'static [u8] {
    static BUNDLE: OnceLock<Vec<u8>> = OnceLock::new();
    BUNDLE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (clips, out) = (folder.path().join("clips"), folder.path().join("boxing.throng"));
        let config = SynthConfig { minutes: 0.5, clip_seconds: 15.0, ..SynthConfig::for_set(SynthSet::Boxing) };
        synth::write_set(SynthSet::Boxing, &config, &clips).expect("synthetic clips can be written");
        let mut config = BuildConfig::parse(BOXING, Path::new("boxing.toml")).expect("a config");
        config.inputs = vec![clips];
        config.policy.compare_samples = 100;
        build(&config, &out, &Cache::disabled());
        std::fs::read(&out).expect("what was built can be read")
    })
}

/// A bundle with one blend space of synthetic locomotion; built once a binary.
pub fn blend_tables() -> Bundle {
    static BUNDLE: OnceLock<Vec<u8>> = OnceLock::new();
    let bytes = BUNDLE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let out = folder.path().join("blend.throng");
        let config = BuildConfig::parse(BLEND, Path::new("blend.toml")).expect("a config");
        build(&config, &out, &Cache::disabled());
        std::fs::read(&out).expect("what was built can be read")
    });
    Bundle::from_bytes(AlignedBytes::from_slice(bytes)).expect("the bundle of a blend opens")
}

const BLEND: &str = r#"
name = "blend"
synth = { set = "locomotion" }
behaviours = []
[resample]
rate_hz = 60.0
mirror = false
[annotate.ends]
still = false
[graph]
enabled = false
[blend.ahead]
axes = [{ kind = "speed" }, { kind = "gyration" }]
examples = [
  { clip = "idle_neutral", still = true },
  { clip = "turn_neutral_*" },
  { clip = "walk_neutral_*" },
  { clip = "jog_neutral_v270_*" },
]
"#;

/// The bundle of boxing, open.
pub fn boxing_tables() -> Bundle {
    Bundle::from_bytes(AlignedBytes::from_slice(boxing_bytes())).expect("the bundle of boxing opens")
}

const BOXING: &str =
    concat!("name = \"boxing\"\ninputs = [\"clips\"]\n", include_str!("../../fuzz/checks/src/soak/boxing.toml"));

/// Pairs of [`boxing_tables`], each boxer weighing all behaviours.
pub fn sparring(tables: &Bundle, n: usize) -> Result<Sparring> {
    let characters =
        CharactersConfig { choice: ActionChoice::LookAhead { temperature: 0.01 }, ..CharactersConfig::default() };
    let mut sparring = Sparring::with_capacity(tables, n, SparringConfig { characters, ..SparringConfig::default() })?;
    for pair in pairs(tables, n) {
        let first = sparring.spawn(pair)?;
        for id in [first, sparring.opponent(first)?] {
            sparring.order(id, PolicyOrder::IDLE.with_policy(0, 1.0).with_policy(1, 2.0).with_policy(2, 1.0))?;
        }
    }
    Ok(sparring)
}

/// Pairs face to face, within reach of each other.
pub fn pairs(tables: &Bundle, n: usize) -> Vec<[Spawn; 2]> {
    let states = tables.graph().states.len();
    let start = |i: usize| {
        let (pair, far) = (i / 2, i % 2 == 1);
        let side = if far { Planar::new(0.0, 0.9, std::f32::consts::PI) } else { Planar::IDENTITY };
        let root = Planar::new(3.0 * pair as f32, 0.0, 0.7 * pair as f32).compose(side);
        Spawn { root, state: Some((i * 37 % states) as u32), floor_m: 0.0 }
    };
    (0..n).map(|pair| [2 * pair, 2 * pair + 1].map(start)).collect()
}

/// Characters on a line, facing all around, in all kinds of states.
pub fn starts(tables: &Bundle, n: usize) -> Vec<CharacterStart> {
    let states = tables.graph().states.len();
    let start = |i: usize| CharacterStart {
        root: Planar::new(1.5 * i as f32, 0.5 * (i % 3) as f32, 0.7 * i as f32),
        state: (i * 37 % states) as u32,
    };
    (0..n).map(start).collect()
}

/// An order for each of [`starts`], to a place some metres away.
pub fn orders(n: usize) -> Vec<PolicyOrder> {
    let target = |i: f32| Vec3::new(1.5 * i + 3.0 * i.sin(), 0.0, 4.0 * i.cos());
    (0..n).map(|i| PolicyOrder::towards(0, target(i as f32))).collect()
}
