//! Motion patches: pose groups, blocks, tiles, bundles, worlds, planning and inhabitants, against brute force and by
//! hand.

mod blocks;
mod bundle;
mod glides;
mod groups;
mod inhabitants;
mod made_up;
mod pairs;
mod plan;
mod saved_inhabitants;
mod stitch;
mod tiles;
mod world_file;

use crate::format::patch as parts;
use throng_world::made_up_floor as made_up_world;
