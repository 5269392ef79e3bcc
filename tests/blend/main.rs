//! Blend spaces: examples, weights, postures and their tables, against brute force and by hand.

mod bundle;
mod captured;
#[path = "../common/mod.rs"]
mod common;
mod examples;
mod halved;
mod made_up;
#[path = "../format/patch.rs"]
mod parts;
mod postures;
mod runtime;
mod weights;
