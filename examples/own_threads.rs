//! A step on your own threads: results do not depend on which thread runs which part.
//!
//! ```sh
//! cargo run --release -- build data/locomotion.toml
//! cargo run --release --example own_threads -- locomotion.throng ahead-neutral
//! ```

use glam::Vec2;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use throng_runtime::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::{Bundle, CharacterGroup, Executor, Inline, Planar};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("locomotion.throng").as_ref(), &next("ahead-neutral"))
}

/// A number of threads, each of which runs one part after the other. An engine passes the parts to its job system here.
struct Threads(usize);

impl Executor for Threads {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..self.0.min(num_parts) {
                scope.spawn(|| {
                    while let Some(k) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|k| *k < num_parts) {
                        part(k);
                    }
                });
            }
        });
    }
}

/// Steps two thousand walkers on one thread and on four.
pub fn run(bundle: &Path, space: &str) -> Result<(), Box<dyn std::error::Error>> {
    let bundle = Bundle::open(bundle)?;
    let mut walkers = Walkers::with_capacity(bundle.blend(space)?, &[], WalkersConfig::default(), 2000)?;
    for i in 0..2000 {
        let root = Planar::new((i % 50) as f32, (i / 50) as f32, 0.0);
        let id = walkers.spawn(WalkerStart { root, phase: 0.37 * i as f32, ..WalkerStart::default() })?;
        walkers.order(id, Control::walk(Vec2::new(0.0, 1.0)))?;
    }
    let mut others = walkers.clone();
    for _ in 0..10 {
        walkers.step(1.0 / 60.0, &Inline)?;
        others.step(1.0 / 60.0, &Threads(4))?;
    }
    assert_eq!(walkers.hash(), others.hash());
    println!("one thread and four agree: {:016x}", walkers.hash());
    Ok(())
}
