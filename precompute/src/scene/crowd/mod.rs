//! Scenes of crowds: members on the ground or in the air who act at their own events (Kim, Kim and Shin 2003, section 2).

mod bodies;
mod config;
mod group;
mod happening;
mod keep;
mod layout;
mod live;
mod message;
mod meter;
mod obstacle;
mod own;
mod place;
mod record;
mod route_maps;
mod row;
mod run;

pub use bodies::{Bodies, BodiesReport, BodyPoses, walk_bodies};
pub use config::{CrowdBodiesConfig, CrowdScene, CrowdSpace, Engine, GateConfig, LanesConfig};
pub use group::{AtEndConfig, GoalConfig, GroupConfig, PlaceConfig};
pub use happening::{HappeningConfig, NearConfig};
pub use layout::Layout;
pub use live::Live;
pub use meter::{Flow, HUMAN_FLOW_PER_M_S, OverlapMeter, ProgressMeter, Sight};
pub use obstacle::{BoxConfig, DiscConfig, MoverConfig, ObstacleConfig, PolygonConfig, WallConfig, WayPoint};
pub use own::{OWN_SCENES, own_scene};
pub use record::{CrowdMoment, CrowdRecord, SeenMember, SeenObstacle, TRAIL_S, in_world, seen_obstacle};
pub use run::{CrowdReport, CrowdRun, run};
