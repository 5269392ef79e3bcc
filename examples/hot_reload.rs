//! Hot reload: a bundle that was built anew takes the place of the old one while walkers go on.
//!
//! ```sh
//! cargo run --release -- build data/locomotion.toml
//! cargo run --release --example hot_reload -- locomotion.throng ahead-neutral
//! ```

use glam::Vec2;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use throng_runtime::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::{AdoptReport, Bundle, CharacterGroup, Inline};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut next = |default: &str| args.next().unwrap_or_else(|| default.into());
    run(next("locomotion.throng").as_ref(), &next("ahead-neutral"))
}

/// Nothing here has a lifetime: bundles are shared, and groups of walkers own the data that they use.
struct Game {
    file: PathBuf,
    changed: SystemTime,
    people: Walkers,
}

impl Game {
    /// Adopts the file if it changed. A bad file leaves everything as it was, and returns the reason.
    fn poll(&mut self) -> Result<Option<AdoptReport>, Box<dyn std::error::Error>> {
        let changed = std::fs::metadata(&self.file)?.modified()?;
        if changed == self.changed {
            return Ok(None);
        }
        self.changed = changed;
        Ok(Some(self.people.adopt(&Bundle::open(&self.file)?)?))
    }
}

/// Lets a walker go on while its bundle is replaced, first by a damaged one.
pub fn run(bundle: &Path, space: &str) -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("watched.throng");
    std::fs::copy(bundle, &file)?;
    let open = Bundle::open(&file)?;
    let people = Walkers::with_capacity(open.blend(space)?, &[], WalkersConfig::default(), 10)?;
    let mut game = Game { changed: SystemTime::UNIX_EPOCH, file, people };
    let id = game.people.spawn(WalkerStart::default())?;
    game.people.order(id, Control::walk(Vec2::new(0.0, 1.0)))?;
    game.people.step(1.0 / 60.0, &Inline)?;

    // A writer replaces a file by renaming: a process that has mapped the old one keeps it.
    let (damaged, new) = (folder.path().join("damaged"), folder.path().join("new"));
    std::fs::write(&damaged, &std::fs::read(bundle)?[..1000])?;
    std::fs::rename(&damaged, &game.file)?;
    println!("damaged: {}", game.poll().expect_err("a short file is refused"));
    game.people.step(1.0 / 60.0, &Inline)?;

    std::fs::copy(bundle, &new)?;
    std::fs::rename(&new, &game.file)?;
    game.changed = SystemTime::UNIX_EPOCH;
    let adopted = game.poll()?.ok_or("the file changed")?;
    println!("{} moved over, joints by {:.3} m at most", adopted.num_characters, adopted.farthest_m);
    game.people.step(1.0 / 60.0, &Inline)?;
    Ok(())
}
