//! Motion patches: pose groups, worlds, planning and inhabitants, against brute force and by hand.

mod inhabitants;
mod made_up;
mod plan;
mod world_file;
