//! Motion patches: pose groups, blocks, tiles, bundles, worlds, planning and inhabitants, against brute force and by
//! hand.

mod blocks;
mod bundle;
mod glides;
mod groups;
mod inhabitants;
mod made_up;
mod pairs;
#[path = "../format/patch.rs"]
mod parts;
mod plan;
mod saved_inhabitants;
mod stitch;
mod tiles;
mod world_file;

use throng_runtime::world::made_up_floor as made_up_world;
