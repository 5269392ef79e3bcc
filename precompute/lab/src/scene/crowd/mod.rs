//! Scenes of crowds: agents on the ground or in the air who act at their own events (Kim, Kim and Shin 2003a, section
//! 2).

mod bodies;
mod config;
mod group;
mod happening;
mod keep;
mod layout;
mod live;
mod message;
mod obstacle;
mod place;
mod route_maps;

pub use crate::run::{OverlapMeter, ProgressMeter, SeenObstacle, Sight, seen_obstacle};
pub use bodies::Bodies;
pub use config::{CrowdBodiesConfig, CrowdScene, CrowdSpace, Engine, GateConfig, LanesConfig};
pub use group::{AtEndConfig, GoalConfig, GroupConfig, PlaceConfig};
pub use happening::{HappeningConfig, NearConfig};
pub use layout::Layout;
pub use live::Live;
pub use obstacle::{BoxConfig, DiscConfig, MoverConfig, ObstacleConfig, PolygonConfig, WallConfig, WayPoint};
pub use throng_runtime::simulation::agents::in_world;
