//! What the layer for C costs: the same people stepped through it and by Rust, in turns.
//! `cargo run --release -p throng-capi --example step_ratio -- BUNDLE`

use glam::Vec3;
use std::ffi::CString;
use std::time::Instant;
use throng_c::*;
use throng_runtime::characters::{AvoidConfig, CharactersConfig, PolicyCharacters, Spawn};
use throng_runtime::{Bundle, CharacterGroup, Inline, Planar};

const PEOPLE: usize = 1000;
const STEPS: usize = 60;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("give a bundle")?;
    let config = CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() };
    let rust_bundle = Bundle::open(&path)?;
    let mut rust = PolicyCharacters::with_capacity(&rust_bundle, PEOPLE, config)?;
    let policy = rust_bundle.policy("approach")?;

    let (mut bundle, mut c) = (ThrongBundle { handle: 0 }, ThrongSimulation { handle: 0 });
    let path = CString::new(path)?;
    // SAFETY: the text ends with a zero, and all that is written is there.
    let number = unsafe {
        said(throng_bundle_open(path.as_ptr(), &mut bundle));
        let mut config = std::mem::MaybeUninit::uninit();
        said(throng_characters_config_init(config.as_mut_ptr(), size_of_val(&config)));
        said(throng_characters_new(bundle, config.as_ptr(), &mut c));
        let mut number = 0;
        said(throng_bundle_policy(bundle, c"approach".as_ptr(), &mut number));
        number
    };
    for k in 0..PEOPLE {
        let (x, z) = (2.0 * (k % 32) as f32, 2.0 * (k / 32) as f32);
        let to = Vec3::new(64.0 - x, 0.0, 64.0 - z);
        let id = rust.spawn(Spawn::standing_at(Planar::new(x, z, 0.0)))?;
        rust.order(id, policy.order_towards(to))?;
        let mut id = ThrongId { index: 0, generation: 0 };
        // SAFETY: the id can be written.
        said(unsafe { throng_characters_spawn(c, x, z, 0.0, &mut id) });
        said(throng_characters_order(c, id, number, to.x, to.y, to.z));
    }
    let mut ratios: Vec<f64> = Vec::new();
    for _ in 0..40 {
        let begin = Instant::now();
        (0..STEPS).for_each(|_| said(throng_simulation_step(c, 1.0 / 60.0)));
        let through_c = begin.elapsed();
        let begin = Instant::now();
        (0..STEPS).try_for_each(|_| rust.step(1.0 / 60.0, &Inline))?;
        ratios.push(through_c.as_secs_f64() / begin.elapsed().as_secs_f64());
    }
    let mut hash = 0;
    // SAFETY: the number can be written.
    said(unsafe { throng_simulation_hash(c, &mut hash) });
    assert_eq!(hash, rust.hash(), "the same people");
    ratios.sort_by(f64::total_cmp);
    let at = |q: f64| ratios[(q * (ratios.len() - 1) as f64) as usize];
    println!(
        "a step through C over one of Rust: median {:.4}, 5th percentile {:.4}, 95th {:.4}",
        at(0.5),
        at(0.05),
        at(0.95)
    );
    Ok(())
}

/// Stops where a call fails.
fn said(status: ThrongStatus) {
    assert!(status == ThrongStatus::Ok, "{status:?}");
}
