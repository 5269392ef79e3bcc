//! Tasks as files: characters, things, and actions of limbs.

mod ahead;
mod both;
mod check;
mod deeds;
mod entries;
mod file;
mod follow;
mod gaze;
mod grips;
mod held;
mod lean;
mod mesh;
mod obj;
mod run;
mod scenery;
mod stage;
mod step;
#[cfg(test)]
mod tests;
mod visit;
mod walk;
mod written;

pub use ahead::{Ahead, MeshAhead};
pub use entries::{PaceEntry, WalkEntry};
pub use file::{Body, Character, ClipEntry, Start, Task, Thing};
pub use obj::triangles as obj_triangles;
pub use run::{Attachment, Done, Event, Left, NoClips, TaskOutcome, Watch};
pub use scenery::{Handle, Scenery};
pub use stage::{ActorClip, Looked};
pub use walk::{NoWalk, Source, Walked};
