//! Planning of limb motion in time with everything that moves.
//!
//! A [`problem::Problem`] is built from an application's specification ([`setup::ProblemSpec`]); a [`planner::LimbPlanner`]
//! searches joint angles and time for a path and smooths it. [`correct::correct_clip`] and [`manipulate::reach_target`] apply this to
//! clips, [`recheck::Recheck`] verifies the result.
//!
//! # Source
//! Shapiro, Kallmann and Faloutsos 2007, *Interactive Motion Correction and Object Manipulation*.

pub mod balance;
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
pub mod smooth;
pub mod stiff_mesh;
pub mod task;
#[cfg(test)]
#[path = "../tests/common/problems.rs"]
mod testing;
pub mod track;

/// Refuses something that is written wrong, with the reason.
pub(crate) fn refuse(is_wrong: bool, why: std::fmt::Arguments<'_>) -> Result<(), String> {
    if is_wrong { Err(why.to_string()) } else { Ok(()) }
}
