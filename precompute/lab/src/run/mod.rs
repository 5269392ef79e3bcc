//! Runs scenes and measures them: one loop, one report and one record for all kinds of motion.

mod ensure;
mod figures;
mod meter;
mod news;
mod own;
mod record;
mod recording;
mod report;
mod row;
mod scenario;
mod shared;
mod styles;
pub(crate) mod watch;

pub use ensure::{Cached, ensure, ensure_bundle, ensure_motion, ensure_world, is_complete, is_motion, motion_name};
pub use figures::{AgentFigures, BlowFigures, Figures, InhabitedFigures, PathFigures, ThingFigures};
pub use meter::{Flow, HUMAN_FLOW_PER_M_S, OverlapMeter, ProgressMeter, Sight};
pub use news::News;
pub use own::{OWN_SCENES, own_scene};
pub use record::{
    AgentsRecord, CrowdMoment, FightFrame, FightRecord, PathsRecord, Pose, Record, SeenAgent, SeenPeople, SeenPlace,
    TRAIL_S, TrajectoryPoint, WorldRecord, on_its_way, seen_obstacle,
};
pub use recording::Recording;
pub use report::{GroupReport, RunConfig, SceneReport, geometry, run, run_agents, run_recorded};
pub(crate) use report::{Moment, play};
pub use scenario::{ScenarioFigures, measure as measure_scenario};
pub use shared::{RankFigures, SharedFigures, run_shared};
pub use styles::{StyleWalk, curve, walk_styles};
pub use watch::knee_angles;
pub use watch::{AgentsMeter, AgentsNow, Watch};

/// The JSON schema of scene files.
pub fn scene_schema() -> serde_json::Value {
    schemars::schema_for!(throng_runtime::simulation::Scene).to_value()
}
