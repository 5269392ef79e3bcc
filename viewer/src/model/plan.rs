//! Carries out the commands about a task of limbs.

use super::Model;
use crate::command::PlanCommand;
use crate::document::{OpenDocument, path_list};

impl Model {
    /// Time of the task that is shown (s).
    pub fn task_time_s(&self) -> f64 {
        let rate_hz = self.document.task().map_or(30.0, |t| t.frames().1);
        f64::from(self.player.frame.round() / rate_hz)
    }

    pub(super) fn apply_to_task(&mut self, command: PlanCommand) {
        let waits = self.is_unhurried;
        let OpenDocument::Task(task) = &mut self.document else { return };
        let options = &mut self.selection.plan;
        match command {
            PlanCommand::SetOptions(wanted) => *options = wanted,
            PlanCommand::Plan => self.plan(false),
            PlanCommand::Cancel => task.cancel(),
            PlanCommand::Show(motion) => task.show(motion),
            PlanCommand::Move(handle, by) => task.move_by(handle, by.as_dvec3()),
            PlanCommand::EndMove if options.replans => self.plan(true),
            PlanCommand::EndMove => {}
            PlanCommand::Save(path) => {
                let saved = task.save(&path).map(|files| path_list(&files));
                self.tell_saved(saved);
            }
            PlanCommand::SaveTask(path) => {
                let saved = task.save_task(&path).map(|()| path.display().to_string());
                // The written file has the shown state: its change is not a new version.
                if saved.is_ok() && path == task.path {
                    self.watch_anew();
                }
                self.tell_saved(saved);
            }
        }
        self.adopt_plan(waits);
    }

    /// Plans with the present options, in the background.
    ///
    /// - `goes_on`: from where the last plans ended.
    pub(super) fn plan(&mut self, goes_on: bool) {
        let options = self.selection.plan;
        if let OpenDocument::Task(task) = &mut self.document {
            task.plan(options.num_motions, options.seed, goes_on);
        }
    }

    /// Takes in motions that were planned meanwhile.
    pub(super) fn adopt_plan(&mut self, waits: bool) {
        let OpenDocument::Task(task) = &mut self.document else { return };
        if let Err(why) = task.adopt_plan(waits) {
            self.complain(format!("Nothing was planned: {why}"));
        }
        self.advance_clip(0.0);
    }
}
