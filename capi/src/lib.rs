//! The runtime for C and C++: `include/throng.h` is made from this crate.
//!
//! Handles are numbers that this library never reuses. A handle that was freed, is of another kind, or is in use by another
//! thread is refused with a status; nothing is read through it. No callback is ever called, and no panic leaves a call.

mod fault;
mod handles;
mod instances;
mod layout;
mod people;
mod read;
mod scene;
mod stage;
mod tables;
mod work_queue;

pub use fault::{ThrongStatus, throng_last_error};
pub use instances::{
    ThrongDetail, ThrongInstance, throng_bundle_num_rows, throng_bundle_write_rows, throng_characters_instances,
    throng_characters_set_detail,
};
pub use layout::{ThrongLayout, throng_layout_floats};
pub use people::{ThrongOrder, throng_people_order, throng_people_raise, throng_people_set_value};
pub use read::{
    ThrongEvent, ThrongHappened, ThrongRoot, throng_simulation_events, throng_simulation_roots,
    throng_simulation_write_matrices,
};
pub use scene::{
    ThrongCharactersConfig, ThrongId, ThrongLayers, ThrongProgress, throng_characters_config_init,
    throng_characters_despawn, throng_characters_new, throng_characters_order, throng_characters_place,
    throng_characters_progress, throng_characters_set_layers, throng_characters_set_manner,
    throng_characters_set_speed, throng_characters_spawn, throng_characters_stop, throng_characters_turn_to,
    throng_simulation_open, throng_simulation_raise,
};
pub use stage::{
    ThrongSimulation, throng_simulation_announce, throng_simulation_count, throng_simulation_free,
    throng_simulation_hash, throng_simulation_help, throng_simulation_restore, throng_simulation_save,
    throng_simulation_step, throng_simulation_time,
};
pub use tables::{
    THRONG_NUM_JOINTS, ThrongBundle, ThrongJoint, throng_bundle_free, throng_bundle_from_memory, throng_bundle_open,
    throng_bundle_policy, throng_bundle_skeleton, throng_joint_name,
};
