//! Tasks as files: what is around a clip, and what limbs have to do in it.

mod file;
mod obj;
mod run;
#[cfg(test)]
mod tests;

pub use file::Task;
pub use run::{Done, TaskOutcome};
