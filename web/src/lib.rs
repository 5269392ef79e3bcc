//! The runtime for browsers. A page calls these functions, and reads records and poses straight from memory.
//!
//! Calls return 0, or 1 if they failed; the reason is the text at [`throng_text`]. Pointers are valid until the next call.

mod page;
mod stage;

pub use page::{
    throng_agents, throng_input, throng_open, throng_parents, throng_people, throng_records, throng_rest, throng_rows,
    throng_size, throng_step, throng_target, throng_targets, throng_text,
};
pub use stage::{PageCrowd, PageStage};
