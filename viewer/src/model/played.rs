//! Time of what is kept on a reel: a scene of walkers or of a crowd, and somebody who walks in a blend space.

use super::Model;
use crate::command::Command;
use crate::document::Document;
use crate::run::Head;
use std::time::Instant;

impl Model {
    /// Play head of what the 3-D view shows, where that is kept on a reel.
    pub fn head(&self) -> Option<&Head> {
        match &self.document {
            _ if self.shows_clip() => None,
            Document::Walkers(w) => Some(&w.run().reel.head),
            Document::CrowdScene(c) => Some(&c.run().reel.head),
            Document::Bundle(b) if self.shows_blend() => b.blend.as_ref().map(|run| &run.reel.head),
            _ => None,
        }
    }

    fn head_mut(&mut self) -> Option<&mut Head> {
        let (shows_clip, shows_blend) = (self.shows_clip(), self.shows_blend());
        match &mut self.document {
            _ if shows_clip => None,
            Document::Walkers(w) => Some(&mut w.run_mut().reel.head),
            Document::CrowdScene(c) => Some(&mut c.run_mut().reel.head),
            Document::Bundle(b) if shows_blend => b.blend.as_mut().map(|run| &mut run.reel.head),
            _ => None,
        }
    }

    /// One step on: one that is kept, or a new one.
    fn step_played(&mut self) -> Result<(), String> {
        match &mut self.document {
            Document::Walkers(w) => w.step(),
            Document::Bundle(b) => match &mut b.blend {
                Some(run) => run.step(&b.bundle).map_err(|e| e.to_string()),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    /// Moves time on by wall time; returns the steps taken.
    pub(super) fn advance_played(&mut self, wall_s: f32) -> u32 {
        let (begin, mut taken) = (Instant::now(), 0);
        if let Some(head) = self.head_mut() {
            head.owe(wall_s);
        }
        while self.head_mut().is_some_and(|head| head.is_due(taken, begin)) {
            if let Err(why) = self.step_played() {
                self.stop(&why);
                break;
            }
            taken += 1;
        }
        taken
    }

    /// Plays, stops, and moves through what is kept.
    pub(super) fn move_head(&mut self, command: &Command) {
        let Some(head) = self.head_mut() else { return };
        let mut steps = 0;
        match command {
            Command::Play(on) => head.play(*on),
            Command::Speed(speed) => head.set_speed(*speed),
            Command::Seek(step) => head.seek(*step),
            Command::Step(by) if *by > 0 => steps = *by,
            Command::Step(by) => head.seek(head.now().saturating_add_signed(*by)),
            _ => {}
        }
        if let Document::CrowdScene(crowd) = &mut self.document {
            // They are taken as time allows.
            if steps > 0 {
                crowd.run_mut().want(steps as u32)
            } else {
                crowd.run_mut().want_no_more()
            }
            return;
        }
        for _ in 0..steps {
            if let Err(why) = self.step_played() {
                return self.stop(&why);
            }
        }
    }

    fn stop(&mut self, why: &str) {
        if let Some(head) = self.head_mut() {
            head.play(false);
        }
        self.complain(format!("The walk stopped: {why}"));
    }
}
