//! What commands do to a scene of a crowd.

use super::Model;
use crate::command::CrowdCommand;
use crate::document::{CrowdChoice, Document};
use eframe::egui;
use std::time::{Duration, Instant};

/// Longest time of a frame that is spent on the engine; a step goes on in the next one.
const BUDGET: Duration = Duration::from_millis(20);

impl Model {
    pub(super) fn apply_to_crowd(&mut self, ctx: &egui::Context, command: CrowdCommand) {
        let waits = self.is_unhurried;
        let ctx = ctx.clone();
        let wake = move || ctx.request_repaint();
        let Document::CrowdScene(crowd) = &mut self.document else { return };
        match command {
            CrowdCommand::Look(look) => self.selection.crowd = look,
            CrowdCommand::Begin(choice) => {
                if let Err(why) = crowd.begin(choice, None, wake) {
                    return self.complain(format!("The scene is unchanged: {why}"));
                }
                self.take_in_crowd(waits);
            }
            CrowdCommand::Save(path) => match crowd.save(&path) {
                Ok(()) => self.say(format!("Saved {}", path.display())),
                Err(why) => self.complain(why),
            },
            CrowdCommand::Restore(path) => {
                if let Err(why) = crowd.restore(&path, wake) {
                    return self.complain(why);
                }
                self.take_in_crowd(waits);
            }
        }
    }

    /// Restarts a scene of a crowd, and waits until it is ready.
    ///
    /// # Errors
    /// A message where that cannot be; the scene goes on as it was.
    pub fn begin_crowd_now(&mut self, choice: CrowdChoice) -> Result<(), String> {
        let Document::CrowdScene(crowd) = &mut self.document else { return Ok(()) };
        crowd.begin(choice, None, || {})?;
        crowd.take_in(true)?;
        self.watch_selected();
        Ok(())
    }

    /// Takes in a run that has been made meanwhile.
    fn take_in_crowd(&mut self, waits: bool) {
        let Document::CrowdScene(crowd) = &mut self.document else { return };
        match crowd.take_in(waits) {
            Ok(false) => {}
            Ok(true) => {
                let n = self.num_characters();
                self.selection.character = self.selection.character.filter(|&c| c < n);
                self.watch_selected();
            }
            Err(why) => self.complain(format!("The scene is unchanged: {why}")),
        }
    }

    /// Keeps events and forces of the selected agent.
    pub(super) fn watch_selected(&mut self) {
        let selected = self.selection.character;
        if let Document::CrowdScene(crowd) = &mut self.document {
            crowd.run_mut().watch(selected);
        }
    }

    /// Moves time on in a scene of a crowd, as far as the time budget allows; returns the steps taken.
    pub(super) fn advance_crowd(&mut self, wall_s: f32) -> u32 {
        self.take_in_crowd(false);
        let deadline = (!self.is_unhurried).then(|| Instant::now() + BUDGET);
        let Document::CrowdScene(crowd) = &mut self.document else { return 0 };
        match crowd.run_mut().advance(wall_s, deadline) {
            Ok(steps) => steps,
            Err(why) => {
                crowd.run_mut().reel.head.play(false);
                crowd.run_mut().want_no_more();
                self.complain(format!("The crowd stopped: {why}"));
                0
            }
        }
    }
}
