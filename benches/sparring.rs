//! Cost of sparring beside moving and posing the same characters. `cargo bench --bench sparring`.
//!
//! Thirty boxers, as in Lee and Lee (2004), section 6, and a thousand: choice, poses, blows, landing, reactions and
//! parting, beside characters that only move and are posed, and a copy of their poses, all in the same run on one
//! thread.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;
use throng_core::characters::{
    ActionChoice, CharacterStart, Characters, CharactersConfig, MotionSet, PolicyOrder, ReactionConfig, Spawn,
};
use throng_core::{Bundle, CharacterGroup, Inline, Planar};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::pipeline;
use throng_precompute::progress::Silent;
use throng_simulation::sparring::{Sparring, SparringConfig};

/// Config of the bundle: the two behaviours of Lee and Lee (2004) on grids of their size, and evasion.
const CONFIG: &str = r#"
name = "bench"
[synth]
set = "boxing"
[annotate.hits.punches]
swing_speed = 4.0
[[behaviours]]
name = "approach"
kind = "approach"
centre = "hits"
grid = { rings = 5, angles = 13, radius = 2.0, inner_spacing = 0.5 }
[[behaviours]]
name = "throw-punches"
kind = "throw_punches"
[[behaviours]]
name = "evade"
kind = "evade"
"#;

/// Duration of a simulated step (s).
const DT: f32 = 1.0 / 60.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `cargo test` runs benches too: a short look is enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    let folder = tempfile::tempdir()?;
    let bundle = folder.path().join("bench.throng");
    build(&bundle, if whole { 4.0 } else { 0.5 })?;
    let tables = Bundle::open(&bundle)?;
    let (sizes, steps): (&[usize], usize) = if whole { (&[30, 1000], 600) } else { (&[4], 3) };
    for &characters in sizes {
        report(&tables, characters, steps)?;
    }
    Ok(())
}

fn report(tables: &Bundle, characters: usize, steps: usize) -> Result<(), Box<dyn std::error::Error>> {
    let choice = ActionChoice::LookAhead { temperature: 0.05 };
    let moving = CharactersConfig { choice, ..CharactersConfig::default() };
    let (motion_set, starts) = (&MotionSet::new(tables), starts(tables, characters));
    let config = SparringConfig { characters: moving, ..SparringConfig::default() };
    let mut sparring = Sparring::with_capacity(tables, starts.len() / 2, config)?;
    let all = (0..3).fold(PolicyOrder::IDLE, |order, policy| order.with_policy(policy, 1.0));
    for pair in starts.as_chunks::<2>().0 {
        let first = sparring.spawn(pair.map(|CharacterStart { root, state }| Spawn {
            root,
            state: Some(state),
            floor_m: 0.0,
        }))?;
        for id in [first, sparring.opponent(first)?] {
            sparring.order(id, all)?;
        }
    }
    // Until all pairs have begun to strike.
    for _ in 0..steps {
        sparring.step(DT, &Inline)?;
    }
    let plain = CharactersConfig { reaction: ReactionConfig { enabled: false, ..moving.reaction }, ..moving };
    let mut alone = Characters::new(motion_set, plain, &starts)?;
    alone.restore(motion_set, &sparring.characters().snapshot())?;
    let places = sparring.heads().iter().zip(sparring.threats());
    let orders: Vec<PolicyOrder> = places.map(|(head, threat)| all.with_target(*head).with_threat(*threat)).collect();
    let mut copy = sparring.characters().model_matrices().to_vec();

    // In turns, so that other load of the machine affects all three alike.
    let mut times = [Vec::new(), Vec::new(), Vec::new()];
    for _ in 0..steps {
        times[0].push(timed(|| sparring.step(DT, &Inline))?);
        times[1].push(timed(|| alone.step(motion_set, DT, &orders))?);
        times[2].push(timed(|| {
            copy.copy_from_slice(black_box(sparring.characters().model_matrices()));
            Ok::<_, std::convert::Infallible>(())
        })?);
    }
    let [whole, moving, copying] = times.map(undisturbed_mean);
    let blows = sparring.figures().blows;
    println!(
        "{characters} boxers, {} blows in {:.0} s, {} met:",
        blows.thrown,
        sparring.figures().seconds,
        blows.landed + blows.blocked
    );
    println!("  sparring {:>9.1} us a step, {:>7.0} steps a second", whole * 1e6, 1.0 / whole);
    println!("  moving   {:>9.1} us a step; sparring takes {:.2} times as long", moving * 1e6, whole / moving);
    println!("  copying  {:>9.1} us;        sparring takes {:.1} times as long", copying * 1e6, whole / copying);
    Ok(())
}

/// Time of some work (s).
fn timed<E>(work: impl FnOnce() -> Result<(), E>) -> Result<f64, E> {
    let begin = Instant::now();
    work()?;
    Ok(begin.elapsed().as_secs_f64())
}

/// Mean of the quarter of the steps that was least disturbed by other load, in groups of steps that each hold their share
/// of choices.
fn undisturbed_mean(times: Vec<f64>) -> f64 {
    let mut groups: Vec<f64> = times.chunks(10).map(|g| g.iter().sum::<f64>() / g.len() as f64).collect();
    groups.sort_by(f64::total_cmp);
    let quarter = &groups[..groups.len().div_ceil(4)];
    quarter.iter().sum::<f64>() / quarter.len() as f64
}

/// Pairs on a square, two metres apart and face to face.
fn starts(tables: &Bundle, characters: usize) -> Vec<CharacterStart> {
    let num_states = tables.graph().states.len();
    let start = |c: usize| {
        let pair = c / 2;
        let middle = Planar::new(4.0 * (pair % 32) as f32, 4.0 * (pair / 32) as f32, pair as f32);
        let side =
            if c.is_multiple_of(2) { Planar::new(0.0, -1.0, 0.0) } else { Planar::new(0.0, 1.0, std::f32::consts::PI) };
        CharacterStart { root: middle.compose(side), state: (c * 37 % num_states) as u32 }
    };
    (0..characters).map(start).collect()
}

fn build(bundle: &Path, minutes: f64) -> Result<(), Box<dyn std::error::Error>> {
    let mut config = BuildConfig::parse(CONFIG, Path::new("bench.toml"))?;
    config.synth.iter_mut().for_each(|s| s.minutes = Some(minutes));
    pipeline::build(&config, bundle, &Cache::disabled(), &Silent)?;
    Ok(())
}
