//! Plans motion of limbs in time with everything that moves.

pub mod body;
pub mod clips;
pub mod collide;
pub mod correct;
pub mod driven;
pub mod ik;
pub mod limits;
pub mod linkage;
pub mod manipulate;
pub mod planner;
pub mod problem;
mod reach;
pub mod recheck;
pub mod rotation;
pub mod search;
pub mod setup;
pub mod shape;
pub mod smooth;
#[cfg(test)]
mod testing;
pub mod track;
