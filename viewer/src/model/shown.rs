//! Which part of the open document the 3-D view shows.

use super::Model;
use crate::bundle::OpenBundle;
use crate::command::Stage;
use crate::document::{Document, SceneDocument};
use crate::run::Run;

impl Model {
    /// True where the 3-D view shows a clip, of the database or of a motion file.
    pub fn shows_clip(&self) -> bool {
        match &self.document {
            Document::Nothing => false,
            Document::Scene(s) => self.stage == Stage::Clip && s.bundle().is_some(),
            Document::Bundle(b) => self.stage == Stage::Clip || (b.run.is_err() && b.blend.is_none()),
            Document::World(_) => self.stage == Stage::Clip,
            Document::Clip(_) | Document::Task(_) => true,
        }
    }

    /// True where the 3-D view shows a character walking in a blend space.
    pub fn shows_blend(&self) -> bool {
        match &self.document {
            Document::Bundle(b) => b.blend.is_some() && (self.stage == Stage::Blend || self.has_no_crowd()),
            _ => false,
        }
    }

    /// The scene that the 3-D view shows.
    pub fn shown_scene(&self) -> Option<&SceneDocument> {
        self.document.scene().filter(|_| !self.shows_clip())
    }

    /// True if a crowd was requested and there is none.
    fn has_no_crowd(&self) -> bool {
        self.stage == Stage::Crowd && self.document.crowd().is_none()
    }

    /// Stage of the 3-D view, whichever was requested.
    pub fn shown_stage(&self) -> Stage {
        match () {
            () if self.shows_clip() => Stage::Clip,
            () if self.shows_blend() => Stage::Blend,
            () => Stage::Crowd,
        }
    }

    /// The available stages, in their order.
    pub fn stages(&self) -> Vec<Stage> {
        let d = &self.document;
        let lives = d.scene().is_some() || d.world().is_some();
        let all = [
            (Stage::Crowd, lives || self.document.crowd().is_some()),
            (Stage::Blend, self.document.blend().is_some()),
            (Stage::Clip, self.document.bundle().is_some_and(|b| !b.tables().clips().is_empty())),
        ];
        all.into_iter().filter(|s| s.1).map(|s| s.0).collect()
    }

    /// The bundle and the crowd that the 3-D view shows.
    pub fn shown_crowd(&self) -> Option<(&OpenBundle, &Run)> {
        self.document.crowd().filter(|_| self.shown_stage() == Stage::Crowd)
    }
}
