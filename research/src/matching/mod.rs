//! Motion matching: the baseline that policies are measured against.
//!
//! Every few frames a character looks for the frame of the whole database that is nearest to its pose and to where it
//! wants to go, and plays on from there. Nothing is worked out beforehand but the features, and every search takes time
//! that grows with the database, where a policy's look-up does not.
//!
//! # Source
//! S. Clavet, "Motion Matching and The Road to Next-Gen Animation", GDC 2016. Features, weights, the wanted trajectory
//! and the two-level search follow D. Holden, "Learned Motion Matching", 2020. Differs: characters are moved by root
//! motion alone, without inertialisation, as that is all that the figures need; fists and hits are features too.

mod boxes;
mod character;
mod database;
mod distance;
mod features;
mod goal;
mod kd_tree;

pub use boxes::BoxSearch;
pub use character::{Character, SEARCH_FRAMES};
pub use database::{Database, HIT_HORIZON_S};
pub use distance::{Nearest, brute_force};
pub use features::{FeatureWeights, Row, WIDTH};
pub use goal::MatchGoal;
pub use kd_tree::KdTree;
