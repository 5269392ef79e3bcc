//! The heavy tools under one name: files to clips, clips to tables, tables to figures and pictures.

pub use throng_bake::*;
pub use throng_lab::*;
pub use throng_motion::*;
pub use throng_synth as synth;
