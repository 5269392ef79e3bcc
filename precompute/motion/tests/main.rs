//! Promises of reading and writing motion, one module each.

mod blows;
mod classes;
mod feet;
mod glitches;
#[path = "../../../tests/common/mocap.rs"]
mod mocap;
mod npz;
mod odd;
mod rigs;
mod scenes;
mod takes;
