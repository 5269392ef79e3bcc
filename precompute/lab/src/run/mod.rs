//! Runs scenes and measures them: one loop, one report and one record for all kinds of motion.

mod built_in_scenes;
mod ensure;
mod expect;
mod figures;
mod groups;
mod meter;
mod news;
mod record;
mod recording;
mod report;
mod report_row;
mod scenario;
mod shared;
mod styles;
pub(crate) mod watch;

pub use built_in_scenes::{BUILT_IN_SCENES, built_in_scene};
pub use ensure::{
    BuildContext, blend_scene, ensure_bundle, ensure_motion, ensure_scene, ensure_world, is_complete, is_motion,
    motion_name,
};
pub use expect::{ExpectationReport, check_expectations};
pub use figures::{
    AgentFigures, BlowFigures, FollowedPathFigures, InhabitedFigures, SceneFigures, ThingFigures, TravelFigures,
};
pub use groups::{agent_path, agents_crowd, first_agent, policy_characters};
pub use meter::{AgentSample, GateFlow, HUMAN_FLOW_PER_M_S, ProgressMeter};
pub use news::News;
pub use record::{
    AgentsRecord, CrowdMoment, FightFrame, FightRecord, JointPositions, PathsRecord, PeopleSample, RecordedAgent,
    RecordedPlace, SceneRecord, TRAIL_S, TrajectoryPoint, WorldRecord, obstacle_in_world, position_on_timed_path,
};
pub use recording::RunRecording;
pub use report::{GroupReport, SceneReport, SceneRunConfig, run, run_agents, run_recorded, world_geometry};
pub(crate) use report::{ObservedStep, play_scene};
pub use scenario::{ScenarioFigures, measure_scenario};
pub use shared::{RankFigures, SharedFigures, run_shared};
pub use styles::{StyleWalk, style_path, walk_styles};
pub use watch::knee_angles;
pub use watch::{AgentsMeter, AgentsSummary, SceneWatch};

/// The JSON schema of scene files.
pub fn scene_schema() -> serde_json::Value {
    schemars::schema_for!(throng_simulation::Scene).to_value()
}
