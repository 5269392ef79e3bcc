//! Surroundings of characters: unit objects with a shape, and environments that place them (Lee, Choi and Lee 2006,
//! section 4).
//!
//! [`UnitSet::load`] and [`EnvironmentFile::load`] read files, [`EnvironmentFile::expand`] lays units out,
//! [`UnitGeometry`] and [`PlacedGeometry`] measure distances of points, and [`BodySpheres`] tests whether a pose fits.

mod body;
mod check;
mod contacts;
mod file;
mod geometry;
mod infer;
mod mesh;
mod placed;
mod solid;
mod touch;
mod unit;

pub use body::{BodySpheres, NUM_SPHERES, Penetration, PosedSpheres, Sphere};
pub use contacts::annotate_in;
pub use file::{EnvironmentFile, PlacementPattern};
pub use geometry::{NearestUnitPoint, UnitGeometry, geometries};
pub use infer::{InferReport, InferredEnvironment, infer_environment};
pub(crate) use mesh::buffer_files;
pub use placed::{PlacedGeometry, TouchedSurface};
pub use solid::UnitSolid;
pub use touch::{GeometryTouchConfig, UnitMembership};
pub use unit::{TileEdges, UnitObject, UnitRegion, UnitSet, UnitShape};

use serde::{Deserialize, Serialize};
use throng_core::patch::Placement;

/// A unit object with its placement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacedUnit {
    /// Number of the unit in its [`UnitSet`].
    pub unit: usize,
    /// Placement of the unit's frame in the world.
    pub placement: Placement,
}

/// An environment: the list (u1, T1), ..., (um, Tm) of Lee, Choi and Lee (2006), section 4. The ground y = 0 is
/// implied.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Name, for messages.
    pub name: String,
    /// Placed units.
    pub units: Vec<PlacedUnit>,
}
