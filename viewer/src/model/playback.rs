//! Advances time, and moves the play head through recordings.

use super::Model;
use crate::command::{ViewStage, ViewerCommand};
use crate::document::{OpenDocument, SceneDocument};
use crate::run::PlayHead;
use glam::Vec3Swizzles;
use std::time::Instant;
use throng_core::{Error, Result};

impl Model {
    /// Play head of the 3-D view; none for a clip, which has [`Model::player`].
    pub fn head(&self) -> Option<&PlayHead> {
        match self.document.blend().filter(|_| self.shows_blend()) {
            Some((_, blend)) => Some(&blend.reel.head),
            None => self.document.head().filter(|_| !self.shows_clip()),
        }
    }

    pub(super) fn head_mut(&mut self) -> Option<&mut PlayHead> {
        if self.shows_clip() {
            return None;
        }
        match self.shows_blend() {
            true => self.document.blend_mut().map(|b| &mut b.1.reel.head),
            false => self.document.head_mut(),
        }
    }

    /// One step forward: a recorded one, or a new one.
    fn step(&mut self) -> Result<()> {
        let (shows_blend, eye) = (self.shows_blend(), self.settings.camera.eye());
        match &mut self.document {
            OpenDocument::World(w) => w.step(),
            OpenDocument::Bundle(b) if shows_blend => b.blend.as_mut().map_or(Ok(()), |run| run.step(&b.bundle)),
            document => document.scene_mut().map_or(Ok(()), |s| {
                s.run.eye = eye.xz();
                s.run.step()
            }),
        }
    }

    /// Shows a recorded step.
    fn seek(&mut self, step: u32) -> Result<()> {
        let shows_blend = self.shows_blend();
        match self.document.scene_mut() {
            Some(scene) if !shows_blend => scene.run.seek(step),
            _ => {
                self.head_mut().into_iter().for_each(|head| head.seek(step));
                Ok(())
            }
        }
    }

    /// True while a world is edited: time stands still, since all its characters will be put back where they are shown.
    fn waits_for_edit(&self) -> bool {
        self.document.world().is_some_and(|w| w.working.is_some())
    }

    /// Advances by wall time; returns the number of steps taken.
    pub(super) fn advance_run(&mut self, wall_s: f32) -> u32 {
        let (begin, mut taken) = (Instant::now(), 0);
        if self.waits_for_edit() {
            return 0;
        }
        if let Some(head) = self.head_mut() {
            head.add_wall_time(wall_s);
        }
        while self.head_mut().is_some_and(|head| head.is_due(taken, begin)) {
            if let Err(why) = self.step() {
                self.stop(&why);
                break;
            }
            taken += 1;
        }
        taken
    }

    /// Plays, stops, and moves the play head.
    pub(super) fn move_time(&mut self, command: &ViewerCommand) {
        if self.shows_clip() {
            return self.move_clip(command);
        }
        let waits = self.waits_for_edit();
        let Some(head) = self.head_mut() else { return };
        let result = match *command {
            ViewerCommand::Play(on) => return head.play(on),
            ViewerCommand::Speed(speed) => return head.set_speed(speed),
            ViewerCommand::Seek(step) if !waits => self.seek(step),
            ViewerCommand::Step(by) if !waits && by > 0 => (0..by).try_for_each(|_| self.step()),
            ViewerCommand::Step(by) if !waits => {
                let to = head.shown_step().saturating_add_signed(by);
                self.seek(to)
            }
            _ => Ok(()),
        };
        if let Err(why) = result {
            self.stop(&why);
        }
    }

    fn move_clip(&mut self, command: &ViewerCommand) {
        let p = &mut self.player;
        match command {
            ViewerCommand::Play(on) => p.playing = *on,
            ViewerCommand::Speed(speed) if speed.is_finite() => p.speed = speed.clamp(0.05, 8.0),
            ViewerCommand::Seek(frame) => p.frame = *frame as f32,
            ViewerCommand::Step(by) => p.frame = p.frame.round() + *by as f32,
            _ => {}
        }
        self.advance_clip(0.0);
    }

    fn stop(&mut self, why: &Error) {
        if let Some(head) = self.head_mut() {
            head.play(false);
        }
        self.complain(format!("The run stopped: {why}"));
    }
}

impl Model {
    /// True where the 3-D view shows a clip, of the database or of a motion file.
    pub fn shows_clip(&self) -> bool {
        match &self.document {
            OpenDocument::Nothing => false,
            OpenDocument::Scene(s) => self.stage == ViewStage::Clip && s.bundle().is_some(),
            OpenDocument::Bundle(b) => self.stage == ViewStage::Clip || (b.crowd.is_err() && b.blend.is_none()),
            OpenDocument::World(_) => self.stage == ViewStage::Clip,
            OpenDocument::Clip(_) | OpenDocument::Task(_) => true,
        }
    }

    /// True where the 3-D view shows a character walking in a blend space.
    pub fn shows_blend(&self) -> bool {
        // A blend is shown in place of a crowd that there is not.
        let is_wanted =
            self.stage == ViewStage::Blend || self.stage == ViewStage::Crowd && self.document.scene().is_none();
        is_wanted && self.document.blend().is_some()
    }

    /// The scene, or the crowd of a bundle, that the 3-D view shows.
    pub fn shown_scene(&self) -> Option<&SceneDocument> {
        self.document.scene().filter(|_| self.shown_stage() == ViewStage::Crowd)
    }

    /// Stage of the 3-D view, whichever was requested.
    pub fn shown_stage(&self) -> ViewStage {
        match () {
            () if self.shows_clip() => ViewStage::Clip,
            () if self.shows_blend() => ViewStage::Blend,
            () => ViewStage::Crowd,
        }
    }

    /// The available stages, in their order.
    pub fn stages(&self) -> Vec<ViewStage> {
        let d = &self.document;
        let all = [
            (ViewStage::Crowd, d.scene().is_some() || d.world().is_some()),
            (ViewStage::Blend, self.document.blend().is_some()),
            (ViewStage::Clip, self.document.bundle().is_some_and(|b| !b.tables().clips().is_empty())),
        ];
        all.into_iter().filter(|s| s.1).map(|s| s.0).collect()
    }

    /// The available stage after the one that is shown; the first one after the last.
    pub fn next_stage(&self) -> ViewStage {
        let (all, shown) = (self.stages(), self.shown_stage());
        let now = all.iter().position(|&s| s == shown).unwrap_or(0);
        all.get((now + 1) % all.len().max(1)).copied().unwrap_or(shown)
    }
}
