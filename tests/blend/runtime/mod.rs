//! Blend spaces at run time: weights, generic time, postures and walkers, against brute force and hand-solved cases.

mod made_up;
mod posture;
mod walkers;
mod warp;
mod weights;
