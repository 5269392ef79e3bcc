//! Pictures of motion as PNG files: figures with bodies, crowds, strips of poses. Plain data in, pixels out.
//!
//! The same input gives the same bytes. Nothing here knows the runtime's characters: callers hand over
//! joint positions, contacts and ground positions.

pub mod camera;
pub mod canvas;
pub mod colour;
pub mod crowd;
pub mod figure;
pub mod sheet;
pub mod strip;
mod trial;

mod furniture;
mod shadow;
mod solid;
mod sprite;
mod text;

pub use camera::Camera;
pub use canvas::Picture;
pub use colour::Colour;
pub use crowd::{Arrival, CrowdCharacter, CrowdView, crowd_overview};
pub use figure::{BodyColours, Figure};
pub use sheet::sheet;
pub use trial::trial_sheet;
pub use strip::{PoseStrip, StripFrame, onion_skin, pose_strip};
