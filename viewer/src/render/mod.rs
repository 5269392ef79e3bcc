//! The 3-D view: plain data in, pixels out.
//!
//! The caller hands over matrices, roots and shapes ([`SceneFrame`]), then asks for a picture from a [`OrbitCamera`].
//! Nothing in here knows where characters come from.

mod callback;
pub mod camera;
mod characters;
mod colours;
mod cull;
mod device;
mod error;
pub mod mesh;
mod offscreen;
pub mod picking;
mod pipelines;
mod renderer;
mod shape_draws;
mod shapes;
mod solid_draws;
mod solids;
mod worn_draws;
mod worn_mesh;

pub use callback::SceneCallback;
pub use camera::{CameraPreset, OrbitCamera, Ray};
pub use characters::{CharacterInstance, RecordInstance};
pub use colours::{Rgba, SceneColours};
pub use device::{device_descriptor, wait};
pub use error::{RenderError, Result};
pub use mesh::BodyStyle;
pub use offscreen::{read_back, target_texture};
pub use picking::{PickedCharacter, pick};
pub use renderer::{SceneFrame, SceneRenderer};
pub use shapes::ShapeList;
pub use solids::{SolidInstance, SolidMesh, Solids, upright};
pub use worn_draws::WornFrame;
pub use worn_mesh::WornMesh;
