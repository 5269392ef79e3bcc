//! The body: what pose exactly. Eight characters at a time, a step of their bodies is one list for everybody:
//!
//! source -> transition -> clips and lean -> gaze -> reactions -> feet -> reach -> arms -> touch -> write
//!
//! Sources are frame rows and blends. Whoever moves characters chooses source and control, and nothing else.

mod arms;
mod detail;
mod events;
mod feet;
mod foot_lock;
mod gaze;
mod ground;
mod ground_plane;
mod hierarchy;
mod lane_body;
mod lanes;
mod lanewise;
mod lean;
mod limbs;
mod matrix;
mod placement;
mod reach;
pub(crate) mod reaction;
mod sample;
mod springs;
mod step;
mod touch;
mod upper;
mod volume;

pub use arms::ArmLayer;
pub(crate) use detail::unorm;
pub use detail::{Detail, DetailLevel, PoseInstance};
pub(crate) use events::{BlockBefore, BodyEvents, ClipRows, MovedBody, NO_ROW, find_soles};
pub use events::{BodyEvent, BodyEventKind};
pub use feet::FootLockConfig;
pub(crate) use feet::{FeetMotion, FeetTick, FootMotion};
pub(crate) use foot_lock::{Bearing, FootLock, SolePose, is_share};
pub use ground::{GroundPoint, HeightField};
pub(crate) use ground_plane::hips_ground_height;
pub(crate) use hierarchy::{ModelPose, PARENTS, shared, to_model, write_matrices};
pub use lane_body::head_centre;
pub(crate) use lane_body::{ARMS, LEGS, LaneBody};
pub(crate) use lanes::{Lane, Lane3, RANGE_BLOCKS, RANGE_LEN, get_lane, load, planar_of_lane, set_lane, store};
pub(crate) use lanewise::{Lanewise, lanewise_fields};
pub use matrix::{LocalTransform, Mat3x4};
pub(crate) use placement::PlacementLanes;
pub(crate) use reach::reach_hand;
pub use reaction::ReactionConfig;
pub(crate) use sample::{FrameCursor, FramePosition, LanePose, WINDOW, sample_number, sample_pose};
pub(crate) use springs::{DampedSpring, Decay, HALF_LIVES_KEPT};
pub(crate) use step::{BodyState, BodyTick, LayerLanes, PlantFeet, PoseOutput, pose_block};
pub use touch::TouchConfig;
pub(crate) use touch::{BlockTouch, LimbTouch, PartnerTouch};
pub use upper::{BodyLayers, ClipLayer};
pub use volume::{BodyVolume, JointCapsule};
