//! Motion patches: bundles and worlds, planning and inhabitants, against brute force and by hand.

mod bundle;
mod inhabitants;
mod made_up;
#[path = "../format/patch.rs"]
mod parts;
mod plan;
mod world_file;
