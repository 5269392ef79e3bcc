//! An editable world: edits with undo and redo, and explanations of removals.

pub(in crate::stitch) mod editor;
pub(in crate::stitch) mod explain;
pub(in crate::stitch) mod history;
pub(in crate::stitch) mod make;
