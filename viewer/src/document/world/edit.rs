//! Edits: units come, go and are moved, and the world is stitched again around them.

use super::WorldDocument;
use super::orders::{EditorOrder, UnitChange, ended_message, work_name};
use super::worker::{EditJob, EditOutcome, EditResult, StitchedWorld, place_roamers};
use crate::{document::background::Background, run::SceneChoice};
use std::{collections::VecDeque, path::Path, sync::Arc};
use throng_core::patch::Placement;
use throng_precompute::environment::PlacedUnit;
use throng_world::inhabitants::InhabitantGoal;

/// An edit that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct EditSummary {
    /// The edit, as text.
    pub description: String,
    /// Time of stitching (s).
    pub stitch_s: f64,
    /// Time of the whole edit: stitching, preparing the world for walking, and placing the characters (s).
    pub total_s: f64,
    /// Characters that found no place any more.
    pub num_lost: usize,
    /// Characters with orders that can no longer be carried out: they decide for themselves again.
    pub num_released: usize,
}

/// An edit that could not be made; the world is unchanged.
#[derive(Clone, Debug, PartialEq)]
pub struct RefusedEdit {
    /// Why.
    pub reason: String,
    /// The unit with its intended placement, or the unit that was to be removed.
    pub at: Option<PlacedUnit>,
}

/// An edit under way, or characters being placed.
pub struct EditInProgress {
    /// Order that the editor carries out; none where new inhabitants are placed in the unchanged world.
    order: Option<EditorOrder>,
    /// Present activity, as text.
    pub doing: String,
    /// The unit with its new placement, or the unit that is removed.
    pub at: Option<PlacedUnit>,
    /// Orders that come after it.
    next: VecDeque<EditorOrder>,
    pub(super) done: Background<EditResult>,
}

/// Result of an edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EditStatus {
    /// The world has changed; with the place of the unit that was added or moved, if any.
    Changed(Option<usize>),
    /// The world is unchanged and has new inhabitants.
    Begun,
    /// The world is unchanged; [`WorldDocument::refused`] has the reason.
    Refused,
}

impl EditInProgress {
    /// Place of the unit that is moved or removed.
    pub fn place(&self) -> Option<usize> {
        match self.order? {
            EditorOrder::Change(UnitChange::Move { place, .. } | UnitChange::Remove { place }) => Some(place),
            _ => None,
        }
    }
}

impl WorldDocument {
    /// The change that can be undone, in words.
    pub fn to_undo(&self) -> Option<&str> {
        self.made.last()
    }

    /// The change that can be redone, in words.
    pub fn to_redo(&self) -> Option<&str> {
        self.made.next()
    }

    /// Placement of a unit after all pending orders (place < number of places).
    pub fn ordered_placement(&self, place: usize) -> Placement {
        let working = self.working.as_ref();
        let orders = working.into_iter().flat_map(|w| w.order.into_iter().chain(w.next.iter().copied()));
        let moved = orders.filter_map(|o| o.moves()).rfind(|m| m.0 == place);
        moved.map_or(self.placed()[place].placement, |m| m.1)
    }

    /// Starts an edit on its own thread; [`WorldDocument::adopt_edit`] adopts the new world when it is stitched.
    ///
    /// While an edit is under way, or characters are being placed, changes can be queued to be undone and redone, and
    /// the moved unit can be moved further.
    ///
    /// # Errors
    /// A message that names what is under way, for anything else meanwhile: the numbers of places may become others.
    pub fn order(&mut self, order: EditorOrder) -> Result<(), String> {
        let Some(working) = &mut self.working else {
            self.begin(order);
            return Ok(());
        };
        let moved = |o: EditorOrder| o.moves().map(|m| m.0);
        let last = working.next.back().copied().or(working.order);
        let goes_on = moved(order).is_some() && last.and_then(moved) == moved(order);
        match order {
            EditorOrder::Change(_) if !goes_on => {
                return Err(format!("{} is still under way", work_name(working.order)));
            }
            EditorOrder::Change(UnitChange::Move { place, to }) => {
                if let Some(last) = working.next.back_mut() {
                    *last = order;
                } else {
                    working.next.push_back(order);
                }
                working.at = self.geometry.units.get(place).map(|p| PlacedUnit { unit: p.unit, placement: to });
            }
            _ => working.next.push_back(order),
        }
        Ok(())
    }

    /// Starts to place this number of new inhabitants, as far as there is room, on its own thread; compare
    /// [`WorldDocument::order`].
    ///
    /// # Errors
    /// A message that names what is under way, where something is.
    pub fn populate(&mut self, choice: SceneChoice) -> Result<(), String> {
        if let Some(working) = &self.working {
            return Err(format!("the run can restart when {} is done", work_name(working.order)));
        }
        self.refused = None;
        let ground = Arc::clone(&self.walkable);
        let done = Background::start(move || place_roamers(&ground, choice), || {});
        let doing = format!("Finding room for {} characters", choice.characters);
        self.working = Some(EditInProgress { order: None, doing, at: None, next: VecDeque::new(), done });
        Ok(())
    }

    fn begin(&mut self, order: EditorOrder) {
        self.refused = None;
        let doing = match order {
            EditorOrder::Change(change) => Some(format!("Stitching the world around {}", self.name_of(change))),
            EditorOrder::Undo => self.to_undo().map(|last| format!("Undoing: {last}")),
            EditorOrder::Redo => self.to_redo().map(|next| format!("Redoing: {next}")),
        };
        let Some(doing) = doing else { return };
        let (at, seed) = (self.edited_unit(order), self.choice.seed);
        let Some(workshop) = self.workshop.take() else {
            self.refused = Some(RefusedEdit { reason: ended_message(Some(order)).to_owned(), at });
            return;
        };
        let places = (0..self.run.num_characters()).map(|c| self.run.hips(c)).collect();
        let job = EditJob { workshop, order, seed, places };
        let done = Background::start(move || job.carry_out(), || {});
        self.working = Some(EditInProgress { order: Some(order), doing, at, next: VecDeque::new(), done });
    }

    /// Adopts the world stitched since the last call; none if there is no new one.
    ///
    /// - `waits`: blocks until no edit is under way.
    pub fn adopt_edit(&mut self, waits: bool) -> Option<EditStatus> {
        let mut taken = None;
        while let Some(working) = &self.working {
            let lost = || EditResult { workshop: None, result: Err(ended_message(working.order).to_owned()) };
            let Some(done) = working.done.poll(waits, lost) else { break };
            let mut working = self.working.take()?;
            let mut next = std::mem::take(&mut working.next);
            taken = Some(self.finish(working, done));
            while let Some(order) = next.pop_front().filter(|_| self.refused.is_none()) {
                self.begin(order);
                if let Some(begun) = &mut self.working {
                    begun.next = next;
                    break;
                }
            }
        }
        taken
    }

    fn finish(&mut self, working: EditInProgress, done: EditResult) -> EditStatus {
        self.workshop = done.workshop.or(self.workshop.take());
        let name =
            if let Some(EditorOrder::Change(change)) = working.order { Some(self.describe(change)) } else { None };
        let what = match working.order {
            Some(EditorOrder::Undo) => format!("undid: {}", self.to_undo().unwrap_or_default()),
            Some(EditorOrder::Redo) => format!("redid: {}", self.to_redo().unwrap_or_default()),
            _ => name.clone().unwrap_or_default(),
        };
        let counts = self.workshop.as_ref().and_then(|w| w.run(|e| [e.num_undos(), e.num_redos()]));
        if let Some(counts) = counts {
            self.made.follow(counts, name.filter(|_| done.result.is_ok()));
        }
        match done.result {
            Ok(EditOutcome::Stitched(stitched)) => EditStatus::Changed(self.show(*stitched, what)),
            Ok(EditOutcome::Begun(choice, mut run)) => {
                run.reel.head.play_like(&self.run.reel.head);
                (self.run, self.choice) = (*run, choice);
                EditStatus::Begun
            }
            Err(why) => {
                self.refused = Some(RefusedEdit { reason: why, at: working.at });
                EditStatus::Refused
            }
        }
    }

    /// Shows another world; returns the place that came or was moved.
    fn show(&mut self, new: StitchedWorld, description: String) -> Option<usize> {
        let place = changed_place(&self.environment.units, &new.environment.units);
        let num_lost = self.run.num_characters() - new.before.len();
        let mut run = new.run;
        run.reel.head.play_like(&self.run.reel.head);
        let mut num_released = 0;
        for (character, &before) in new.before.iter().enumerate() {
            let Some(goal) = self.run.order_of(before) else { continue };
            // Instances and places have new numbers in the new world.
            let is_kept = !matches!(goal, InhabitantGoal::GoTo { .. } | InhabitantGoal::GoToPlace { .. });
            if !is_kept || run.give_order(character, Some(goal)).is_err() {
                num_released += 1;
            }
        }
        (self.walkable, self.run, self.report) = (Arc::new(new.ground), run, new.report);
        (self.environment, self.geometry) = (new.environment, new.geometry);
        self.revision += 1;
        let (stitch_s, total_s) = (new.stitch_s, new.total_s);
        self.edited = Some(EditSummary { description, stitch_s, total_s, num_lost, num_released });
        place
    }

    /// The unit of an order, with its new placement or before its removal.
    fn edited_unit(&self, order: EditorOrder) -> Option<PlacedUnit> {
        let EditorOrder::Change(change) = order else { return None };
        match change {
            UnitChange::Add { unit, at } => Some(PlacedUnit { unit, placement: at }),
            UnitChange::Remove { place } => self.placed().get(place).cloned(),
            UnitChange::Move { place, to } => Some(PlacedUnit { unit: self.placed().get(place)?.unit, placement: to }),
        }
    }

    fn name_of(&self, change: UnitChange) -> &str {
        let unit = self.edited_unit(EditorOrder::Change(change)).and_then(|p| self.kit.units.units.get(p.unit));
        unit.map_or("a unit", |u| &u.name)
    }

    fn describe(&self, change: UnitChange) -> String {
        let done = match change {
            UnitChange::Add { .. } => "added",
            UnitChange::Remove { .. } => "removed",
            UnitChange::Move { .. } => "moved",
        };
        format!("{done} {}", self.name_of(change))
    }

    /// Writes the present world to its own file: a plain list of places.
    ///
    /// # Errors
    /// A message where it cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        let changed = self.source.with_environment(&self.environment, &self.kit.units);
        changed.save(path).map_err(|e| e.to_string())
    }
}

/// The place of a unit that came or was moved; none if one went.
fn changed_place(before: &[PlacedUnit], after: &[PlacedUnit]) -> Option<usize> {
    let first = before.iter().zip(after).position(|(a, b)| a != b);
    (after.len() >= before.len()).then(|| first.or((after.len() > before.len()).then_some(before.len()))).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_added_or_moved_unit_is_found() {
        let unit = |x: f32| PlacedUnit { unit: 0, placement: Placement::new(x, 0.0, 0.0, 0.0) };
        let units = |xs: &[f32]| xs.iter().map(|&x| unit(x)).collect::<Vec<_>>();
        for (before, after, place) in [
            (&[1.0, 2.0][..], &[1.0, 2.0, 3.0][..], Some(2)),
            (&[1.0, 3.0], &[1.0, 2.0, 3.0], Some(1)),
            (&[1.0, 2.0, 3.0], &[1.0, 5.0, 3.0], Some(1)),
            (&[1.0, 2.0, 3.0], &[1.0, 3.0], None),
            (&[1.0, 2.0], &[1.0, 2.0], None),
        ] {
            assert_eq!(changed_place(&units(before), &units(after)), place, "{before:?} {after:?}");
        }
    }
}
