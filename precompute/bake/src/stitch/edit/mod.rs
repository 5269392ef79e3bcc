//! A world that can be changed: edits with undo and redo, and why something was taken out.

pub(in crate::stitch) mod editor;
pub(in crate::stitch) mod history;
pub(in crate::stitch) mod make;
pub(in crate::stitch) mod why;
