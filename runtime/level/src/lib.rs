//! Levels: the ground that one can walk on, on several floors, with shortest paths over it.
//!
//! A file of a level (`*.level`) has the frame of [`throng_base::frame`] under a name of its own. Its tables are viewed in
//! place: convex polygons with their neighbours, heights, named places, links that are not walked (ladders, lifts), and walls.
//!
//! ```no_run
//! use throng_base::glam::Vec3;
//! use throng_level::{Level, LevelPath};
//!
//! let level = Level::open("station.level")?;
//! let (from, to) = (level.place("entrance")?.at, level.place("platform 2")?.at);
//! let mut path = LevelPath::default();
//! level.path(from, to, &mut path)?;
//! println!("{} m by {} corners", path.length_m(), path.corners().len());
//! # Ok::<(), throng_base::Error>(())
//! ```

mod level;
mod locate;
mod path;
mod records;
mod search;

pub use level::{Level, NamedPlace};
pub use locate::LevelPoint;
pub use path::{LevelPath, LinkPassage};
pub use records::{
    LEVEL_MAGIC, LEVEL_VERSION, LevelData, LevelEdge, LevelHead, LevelLink, LevelPlace, LevelPolygon, LevelVertex,
    LevelWall,
};

/// No polygon, edge or place.
pub const NONE: u32 = u32::MAX;
