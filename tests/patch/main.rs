//! Motion patches and worlds of them: mathematics against brute force and small cases made up by hand.

mod blocks;
mod glides;
mod groups;
mod made_up;
mod stitch;
mod tiles;
