//! Motion patches: pose groups, blocks, tiles, worlds, planning and inhabitants, against brute force and by hand.

mod blocks;
mod glides;
mod groups;
mod inhabitants;
mod made_up;
mod made_up_world;
mod plan;
mod stitch;
mod tiles;
mod world_file;
