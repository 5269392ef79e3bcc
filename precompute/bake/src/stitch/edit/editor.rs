//! An editable world: results that a change leaves as they are, such as obstacles and joints, are not computed again.

use super::history::{EnvironmentEdit, WorldEditHistory};
use super::make::make_world;
use crate::environment::{Environment, PlacedUnit};
use crate::stitch::library::{Library, refusal_error};
use crate::{stitch::config::StitchConfig, stitch::connect::prepare::Stitcher, stitch::report::StitchReport};
use crate::{stitch::connect::assemble::StitchResult, stitch::place::place_patches::Placer};
use throng_core::patch::{PatchTables, Placement};
use throng_motion::error::{Result, ensure};
use throng_motion::progress::{Progress, Silent};
use throng_world::WorldData;

/// A stitched world with its intermediate results, so that a change is cheap.
///
/// A change stitches the world anew from results that are kept. Joint tables and obstacle masks belong to pairs in one
/// relative placement: a change computes only those of new pairs, and after a small move of a unit samples only the
/// links that it may have affected. An editor may be sent to another thread, so that the display continues meanwhile.
pub struct Editor<'a> {
    pub(in crate::stitch) stitcher: Stitcher<'a>,
    environment: Environment,
    pub(in crate::stitch) made: StitchResult,
    world: WorldData,
    history: WorldEditHistory,
}

impl<'a> Editor<'a> {
    /// Stitches a world.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`].
    pub fn new(
        patches: &PatchTables,
        library: Library<'a>,
        environment: Environment,
        config: &StitchConfig,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let mut stitcher = Stitcher::new(Placer::new(patches, library, config)?);
        let (made, world) = make_world(&mut stitcher, &environment, progress)?;
        Ok(Self { stitcher, environment, made, world, history: WorldEditHistory::default() })
    }

    /// The current world.
    pub fn world(&self) -> &WorldData {
        &self.world
    }

    /// The world, once there are no more changes.
    pub fn into_world(self) -> (WorldData, StitchReport) {
        (self.world, self.made.report)
    }

    /// The current environment.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Report of the last change.
    pub fn report(&self) -> &StitchReport {
        &self.made.report
    }

    /// Adds a unit after all others.
    ///
    /// - `unit`: its number in the bundle's set.
    /// - returns the index of the placed unit.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`]; the world stays as it was.
    pub fn add(&mut self, unit: usize, placement: Placement) -> Result<usize> {
        let index = self.environment.units.len();
        self.edit(EnvironmentEdit::Insert { index, unit: PlacedUnit { unit, placement } })?;
        Ok(index)
    }

    /// Removes a placed unit; those after it move up.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`], or where there is no such place; the world stays as it was.
    pub fn remove(&mut self, index: usize) -> Result<()> {
        self.check_place(index)?;
        self.edit(EnvironmentEdit::Remove { index })
    }

    /// Moves a placed unit.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`], or where there is no such place; the world stays as it was.
    pub fn drag(&mut self, index: usize, placement: Placement) -> Result<()> {
        self.check_place(index)?;
        self.edit(EnvironmentEdit::Move { index, placement })
    }

    /// Undoes the last change.
    ///
    /// - returns false if there is none.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`]; the world stays as it was.
    pub fn undo(&mut self) -> Result<bool> {
        let Some(edit) = self.history.undo.last().cloned() else { return Ok(false) };
        let back = self.apply(edit)?;
        self.history.record_undo(back);
        Ok(true)
    }

    /// Redoes the change undone last, unless others were made since.
    ///
    /// - returns false if there is none.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`]; the world stays as it was.
    pub fn redo(&mut self) -> Result<bool> {
        let Some(edit) = self.history.redo.last().cloned() else { return Ok(false) };
        let back = self.apply(edit)?;
        self.history.record_redo(back);
        Ok(true)
    }

    /// Undoes the last change as if it had never been made: it cannot be redone, and changes that could be redone
    /// before it can be redone again.
    ///
    /// - returns false if there is none.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`]; the world stays as it was.
    pub fn withdraw_last(&mut self) -> Result<bool> {
        let Some(edit) = self.history.undo.last().cloned() else { return Ok(false) };
        self.apply(edit)?;
        self.history.record_withdrawal();
        Ok(true)
    }

    /// Number of changes that can be undone.
    pub fn num_undos(&self) -> usize {
        self.history.undo.len()
    }

    /// Number of changes that can be redone.
    pub fn num_redos(&self) -> usize {
        self.history.redo.len()
    }

    fn edit(&mut self, edit: EnvironmentEdit) -> Result<()> {
        let back = self.apply(edit)?;
        self.history.record_edit(back);
        Ok(())
    }

    /// Changes the world; returns the reverse change.
    fn apply(&mut self, edit: EnvironmentEdit) -> Result<EnvironmentEdit> {
        let mut environment = self.environment.clone();
        let back = edit.apply(&mut environment.units);
        match make_world(&mut self.stitcher, &environment, &Silent) {
            Ok((made, world)) => {
                (self.made, self.world, self.environment) = (made, world, environment);
                Ok(back)
            }
            Err(refused) => {
                self.stitcher.forget_all_but(&self.made.patches);
                Err(refused)
            }
        }
    }

    fn check_place(&self, index: usize) -> Result<()> {
        let num = self.environment.units.len();
        let why = || format!("there is no place {index}, expected one below {num}");
        ensure(index < num, || refusal_error(&self.environment, why(), "Name a unit that is there"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Editors work on threads of their own.
    const _: () = {
        const fn is_send<T: Send>() {}
        is_send::<Editor<'_>>();
    };
}
