//! Blend spaces: examples, weights, postures and their tables, against brute force and by hand.

mod alike;
mod bundle;
mod captured;
mod examples;
mod halved;
mod made_up;
mod postures;
mod runtime;
mod weights;

use crate::format::patch as parts;
