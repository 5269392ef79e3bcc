//! Characters that move.
mod block;
mod foot_lock;
mod hierarchy;
mod sample;
mod transition;
