//! Which part of the open document the 3-D view shows.

use super::Model;
use crate::command::ViewStage;
use crate::document::{OpenDocument, SceneDocument};

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
