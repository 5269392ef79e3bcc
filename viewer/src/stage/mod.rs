//! Lays out what the 3-D view is to draw: poses, colours, cues.

mod clip;
mod crowd;
mod cues;
mod raw;

use crate::document::Document;
use crate::model::Model;
use crate::render::{CharacterInstance, Rgba, SceneColours, Shapes};
use glam::Vec3;
use throng_runtime::{Mat3x4, Skeleton};

/// What is drawn in one frame.
#[derive(Debug, Default)]
pub struct Layout {
    /// Skeleton of all characters.
    pub skeleton: Skeleton,
    /// Poses of a clip; those of a crowd are its own.
    poses: Vec<Mat3x4>,
    /// Place and colour of every character.
    pub instances: Vec<CharacterInstance>,
    /// Everything that is not a body.
    pub shapes: Shapes,
}

/// Colours of what is laid out; the view's own are [`SceneColours`].
#[derive(Clone, Copy, Debug)]
struct Palette {
    plain: Rgba,
    reached: Rgba,
    on_the_way: Rgba,
    slow: Rgba,
    fast: Rgba,
    selected: Rgba,
    target: Rgba,
    planted: Rgba,
    lifted: Rgba,
    left: Rgba,
    right: Rgba,
    middle: Rgba,
}

impl Palette {
    fn of(dark: bool) -> Self {
        let ink = if dark { Rgba::hex(0xe8eaee) } else { Rgba::hex(0x2b3038) };
        Self {
            plain: Rgba::hex(0xb9c0c9),
            reached: Rgba::hex(0x2fb39b),
            on_the_way: Rgba::hex(0xe8743b),
            slow: Rgba::hex(0x4b7bd1),
            fast: Rgba::hex(0xf2b134),
            selected: if dark { Rgba::hex(0xffd24a) } else { Rgba::hex(0xb45f06) },
            target: Rgba::hex(0xe0457b),
            planted: Rgba::hex(0x35c759),
            lifted: ink.alpha(0.35),
            left: Rgba::hex(0xe0564f),
            right: Rgba::hex(0x4f86e0),
            middle: ink,
        }
    }
}

/// Colours of the 3-D view for a theme.
pub fn scene_colours(dark: bool) -> SceneColours {
    if dark { SceneColours::DARK } else { SceneColours::LIGHT }
}

impl Layout {
    /// Lays out the model anew.
    pub fn lay_out(&mut self, model: &Model, dark: bool) {
        let palette = Palette::of(dark);
        self.instances.clear();
        self.shapes.clear();
        self.poses.clear();
        match &model.document {
            Document::Nothing => {}
            Document::Clip(motion) => raw::lay_out(self, model, motion, &palette),
            Document::Bundle(b) => {
                self.skeleton.clone_from(b.bundle.tables().skeleton());
                match model.document.crowd().filter(|_| !model.shows_clip()) {
                    Some((bundle, run)) => crowd::lay_out(self, model, bundle, run, &palette),
                    None => clip::lay_out(self, model, &b.bundle, &palette),
                }
            }
        }
    }

    /// Joints in model space. [Size: instances * NUM_JOINTS]
    pub fn poses<'a>(&'a self, model: &'a Model) -> &'a [Mat3x4] {
        match model.document.crowd().filter(|_| !model.shows_clip()) {
            Some((_, run)) => run.troupe().model_matrices(),
            None => &self.poses,
        }
    }
}

/// A box around all that is shown. [Unit: m]
pub fn bounds(model: &Model) -> (Vec3, Vec3) {
    let mut points: Vec<Vec3> = Vec::new();
    match &model.document {
        Document::Nothing => {}
        Document::Clip(motion) => points.extend(raw::path(motion)),
        Document::Bundle(b) => match model.document.crowd().filter(|_| !model.shows_clip()) {
            Some((_, run)) => {
                let troupe = run.troupe();
                points.extend((0..troupe.num_characters()).map(|c| troupe.root(c).translation()));
                points.extend(run.targets());
            }
            None => points.extend(clip::path(model, &b.bundle)),
        },
    }
    let Some(&first) = points.first() else { return (Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 1.8, 2.0)) };
    let (low, high) = points.iter().fold((first, first), |(l, h), &p| (l.min(p), h.max(p)));
    (low.with_y(0.0) - Vec3::new(0.6, 0.0, 0.6), high.with_y(1.8) + Vec3::new(0.6, 0.0, 0.6))
}

/// Place of the character that the camera follows. [Unit: m]
pub fn followed(model: &Model) -> Option<Vec3> {
    match &model.document {
        Document::Nothing => None,
        Document::Clip(motion) => raw::place(model, motion),
        Document::Bundle(b) => match model.document.crowd().filter(|_| !model.shows_clip()) {
            Some((_, run)) => Some(run.troupe().root(model.selection.character?).translation()),
            None => clip::place(model, &b.bundle),
        },
    }
}
