//! Damaged input: what every reader does with mutants of good files. They are refused, or what follows goes on with finite
//! numbers; a panic is a fault.
//!
//! The functions of [`readers`] are the bodies of the fuzz targets, too.

mod corpus;
mod mutate;
pub mod readers;
pub mod repair;
mod scenes;
pub mod seeds;
mod snapshots;

pub use corpus::write_corpus;
pub use mutate::Mutator;

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// A mutant that takes longer than this hangs, for whoever waits for it (s).
const HANGS_S: f64 = 30.0;

/// How good files are changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Numbers, words and lines.
    Text,
    /// Words of a binary file.
    Binary,
}

/// A reader of bytes from outside.
#[derive(Clone, Copy)]
pub struct Reader {
    /// Its name, which is that of the fuzz target.
    pub name: &'static str,
    /// How its files are changed.
    pub form: Form,
    /// Good files.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Reads, and uses what was read; true where it was accepted.
    pub read: fn(&[u8]) -> bool,
}

/// Every reader.
pub const READERS: &[Reader] = {
    use Form::{Binary, Text};
    &[
        Reader { name: "bundle", form: Binary, seeds: seeds::bundle, read: readers::bundle },
        Reader { name: "world", form: Binary, seeds: seeds::world, read: readers::world },
        Reader { name: "bvh", form: Text, seeds: seeds::bvh, read: readers::bvh },
        Reader { name: "amc", form: Text, seeds: seeds::amc, read: readers::amc },
        Reader { name: "npz", form: Binary, seeds: seeds::npz, read: readers::npz },
        Reader { name: "gltf_motion", form: Text, seeds: seeds::gltf_motion, read: readers::gltf_motion },
        #[cfg(feature = "fbx")]
        Reader { name: "fbx", form: Text, seeds: seeds::fbx, read: readers::fbx },
        Reader { name: "archive", form: Binary, seeds: seeds::archive, read: readers::archive },
        Reader { name: "config", form: Text, seeds: seeds::config, read: readers::config },
        Reader { name: "scene", form: Text, seeds: seeds::scene, read: readers::scene },
        Reader { name: "world_file", form: Text, seeds: seeds::world_file, read: readers::world_file },
        Reader { name: "units", form: Text, seeds: seeds::units, read: readers::units },
        Reader { name: "environment", form: Text, seeds: seeds::environment, read: readers::environment },
        Reader { name: "gltf_mesh", form: Text, seeds: seeds::gltf_mesh, read: readers::gltf_mesh },
        Reader { name: "character", form: Text, seeds: seeds::character, read: readers::character },
        Reader { name: "sidecar", form: Text, seeds: seeds::sidecar, read: readers::sidecar },
        Reader { name: "profile", form: Text, seeds: seeds::profile, read: readers::profile },
        Reader { name: "task", form: Text, seeds: seeds::task, read: readers::task },
        Reader { name: "obj", form: Text, seeds: seeds::obj, read: readers::obj },
        Reader { name: "limits", form: Text, seeds: seeds::limits, read: readers::limits },
        Reader { name: "recording", form: Binary, seeds: seeds::recording, read: readers::recording },
        Reader { name: "snapshot_policy", form: Binary, seeds: seeds::of_policy, read: readers::snapshot_policy },
        Reader { name: "snapshot_sparring", form: Binary, seeds: seeds::of_sparring, read: readers::snapshot_sparring },
        Reader { name: "snapshot_patches", form: Binary, seeds: seeds::of_patches, read: readers::snapshot_patches },
        Reader { name: "snapshot_paths", form: Binary, seeds: seeds::of_paths, read: readers::snapshot_paths },
        Reader { name: "snapshot_agents", form: Binary, seeds: seeds::of_agents, read: readers::snapshot_agents },
        Reader { name: "snapshot_air", form: Binary, seeds: seeds::of_air, read: readers::snapshot_air },
    ]
};

/// What became of some mutants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tried {
    /// Good files that were refused; there must be none.
    pub bad_seeds: usize,
    /// Mutants that were read.
    pub mutants: u64,
    /// Those that were accepted.
    pub accepted: u64,
    /// Longest time that one took (s).
    pub slowest_s: f64,
    /// Number of each mutant that was too much, and what it said.
    pub faults: Vec<(u64, String)>,
}

impl Reader {
    /// Reads the good files, and as many mutants of them; the same ones for the same seed.
    pub fn try_mutants(&self, mutants: u64, seed: u64) -> Tried {
        let good = (self.seeds)();
        let mut tried = Tried { bad_seeds: good.iter().filter(|g| !(self.read)(g)).count(), ..Tried::default() };
        let mut mutator = Mutator::new(seed);
        for number in 0..mutants {
            let mutant = mutator.mutant(&good, self.form);
            let begin = Instant::now();
            let read = catch_unwind(AssertUnwindSafe(|| (self.read)(&mutant)));
            let seconds = begin.elapsed().as_secs_f64();
            tried.mutants += 1;
            tried.slowest_s = tried.slowest_s.max(seconds);
            match read {
                Ok(accepted) => tried.accepted += u64::from(accepted),
                Err(panic) => tried.faults.push((number, said(&*panic))),
            }
            if seconds > HANGS_S {
                tried.faults.push((number, format!("it took {seconds:.1} s")));
            }
        }
        tried
    }

    /// A mutant by its number, as [`Reader::try_mutants`] makes it.
    pub fn mutant(&self, number: u64, seed: u64) -> Vec<u8> {
        let (good, mut mutator) = ((self.seeds)(), Mutator::new(seed));
        (0..number).for_each(|_| drop(mutator.mutant(&good, self.form)));
        mutator.mutant(&good, self.form)
    }
}

/// The words of a panic.
pub(crate) fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: fn() -> Vec<Vec<u8>> = || vec![b"1 2 3".to_vec()];

    #[test]
    fn a_reader_that_panics_is_found_out_and_its_mutant_is_made_again() {
        let careless = Reader {
            name: "careless",
            form: Form::Text,
            seeds: NONE,
            read: |b| b.is_ascii() && b.len() < 7 || panic!("too long"),
        };
        let tried = careless.try_mutants(200, 3);
        assert!(tried.bad_seeds == 0 && tried.accepted > 0, "{tried:?}");
        let (number, what) = tried.faults.first().expect("some mutants are long");
        assert_eq!(what, "too long");
        assert!(careless.mutant(*number, 3).len() > 6);
        let strict = Reader { name: "strict", read: |_| false, ..careless };
        assert_eq!((strict.try_mutants(5, 3).bad_seeds, strict.try_mutants(5, 3).accepted), (1, 0));
    }
}
