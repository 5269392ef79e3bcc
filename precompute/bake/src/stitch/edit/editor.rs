//! A world that can be changed: what stays as it was is not computed again.

use super::history::History;
use super::make::make;
use crate::environment::{Environment, PlacedUnit};
use crate::stitch::config::StitchConfig;
use crate::stitch::connect::made::Made;
use crate::stitch::connect::prepare::Stitcher;
use crate::stitch::library::{Library, refused};
use crate::stitch::place::change::Edit;
use crate::stitch::place::lay::Placer;
use crate::stitch::report::StitchReport;
use throng_core::patch::{Patches, Placement};
use throng_motion::error::BuildError;
use throng_motion::progress::{Progress, Silent};
use throng_world::WorldData;

/// A stitched world and all that was found on the way, so that a change costs little.
///
/// Joint tables and obstacle masks belong to pairs of things that stand to each other in one way: a change makes
/// those of the new pairs only, and looks only at the links that it may have touched where a unit was moved a little.
/// The component is searched for only around what is not as it was. After every change the world is the one that
/// stitching anew would give. It may be sent to another thread, so that what is shown goes on meanwhile.
pub struct Editor<'a> {
    stitcher: Stitcher<'a>,
    environment: Environment,
    made: Made,
    world: WorldData,
    history: History,
}

impl<'a> Editor<'a> {
    /// Stitches a world.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`].
    pub fn new(
        patches: &Patches,
        library: Library<'a>,
        environment: Environment,
        config: &StitchConfig,
        progress: &dyn Progress,
    ) -> Result<Self, BuildError> {
        let mut stitcher = Stitcher::new(Placer::new(patches, library, config)?);
        let mut world = WorldData::default();
        let made = make(&mut stitcher, &environment, None, &mut world, progress)?;
        Ok(Self { stitcher, environment, made, world, history: History::default() })
    }

    /// The world as it is.
    pub fn world(&self) -> &WorldData {
        &self.world
    }

    /// The world, when no more changes are made.
    pub fn into_world(self) -> (WorldData, StitchReport) {
        (self.world, self.made.report)
    }

    /// The environment as it is.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// What came of the last change.
    pub fn report(&self) -> &StitchReport {
        &self.made.report
    }

    /// Places one more unit, after all others.
    ///
    /// - `unit`: its number in the bundle's set.
    /// - returns the number of the place.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`]; the world stays as it was.
    pub fn add(&mut self, unit: usize, placement: Placement) -> Result<usize, BuildError> {
        let index = self.environment.units.len();
        self.edit(Edit::Insert { index, unit: PlacedUnit { unit, placement } })?;
        Ok(index)
    }

    /// Takes a placed unit away; those after it move up.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`], or where there is no such place; the world stays as it was.
    pub fn remove(&mut self, index: usize) -> Result<(), BuildError> {
        self.check_place(index)?;
        self.edit(Edit::Remove { index })
    }

    /// Moves a placed unit.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`], or where there is no such place; the world stays as it was.
    pub fn drag(&mut self, index: usize, placement: Placement) -> Result<(), BuildError> {
        self.check_place(index)?;
        self.edit(Edit::Move { index, placement })
    }

    /// Takes the last change back that was not.
    ///
    /// - returns false where there is none.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`]; the world stays as it was.
    pub fn undo(&mut self) -> Result<bool, BuildError> {
        let Some(edit) = self.history.to_undo() else { return Ok(false) };
        let back = self.apply(edit)?;
        self.history.undone(back);
        Ok(true)
    }

    /// Makes the change again that was taken back last, unless others were made since.
    ///
    /// - returns false where there is none.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`]; the world stays as it was.
    pub fn redo(&mut self) -> Result<bool, BuildError> {
        let Some(edit) = self.history.to_redo() else { return Ok(false) };
        let back = self.apply(edit)?;
        self.history.redone(back);
        Ok(true)
    }

    /// Takes the last change back as if it had never been made: it cannot be made again, and what could be before it
    /// was made can be again.
    ///
    /// - returns false where there is none.
    ///
    /// # Errors
    /// As [`crate::stitch::stitch`]; the world stays as it was.
    pub fn withdraw(&mut self) -> Result<bool, BuildError> {
        let Some(edit) = self.history.to_undo() else { return Ok(false) };
        self.apply(edit)?;
        self.history.withdrawn();
        Ok(true)
    }

    /// Number of changes that can be taken back.
    pub fn num_undos(&self) -> usize {
        self.history.counts()[0]
    }

    /// Number of changes that were taken back and can be made again.
    pub fn num_redos(&self) -> usize {
        self.history.counts()[1]
    }

    fn edit(&mut self, edit: Edit) -> Result<(), BuildError> {
        let back = self.apply(edit)?;
        self.history.done(back);
        Ok(())
    }

    /// Changes the world; returns the change that takes this one back.
    fn apply(&mut self, edit: Edit) -> Result<Edit, BuildError> {
        let mut environment = self.environment.clone();
        let back = edit.apply(&mut environment.units);
        let before = Some((&self.made, &back));
        match make(&mut self.stitcher, &environment, before, &mut self.world, &Silent) {
            Ok(made) => {
                (self.made, self.environment) = (made, environment);
                Ok(back)
            }
            Err(refused) => {
                self.stitcher.forget_all_but(&self.made.laid);
                Err(refused)
            }
        }
    }

    fn check_place(&self, index: usize) -> Result<(), BuildError> {
        if index < self.environment.units.len() {
            return Ok(());
        }
        let why = format!("there is no place {index}, expected one below {}", self.environment.units.len());
        Err(refused(&self.environment, why, "Name a unit that is there"))
    }

    pub(in crate::stitch) fn stitcher(&self) -> &Stitcher<'a> {
        &self.stitcher
    }

    pub(in crate::stitch) fn made(&self) -> &Made {
        &self.made
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
