//! Lays out the 3-D scene: poses, colours, cues.

pub mod agents;
mod blend;
mod body;
pub mod bout;
mod clip;
mod cues;
pub mod scene;
pub mod task;
mod variety;
pub mod world;

use crate::render::{CharacterInstance, RecordInstance, Rgba, ShapeList, Solids};
use crate::{document::OpenDocument, model::Model};
use std::sync::Arc;
use throng_core::{Mat3x4, Skeleton};

/// Content of one frame of the 3-D view.
#[derive(Default)]
pub struct StageLayout {
    /// Skeleton of all characters.
    pub skeleton: Skeleton,
    /// Poses of a clip, a blend or a scene.
    poses: Vec<Mat3x4>,
    /// Place and colour of every character.
    pub instances: Vec<CharacterInstance>,
    /// Far characters, drawn from frame rows.
    pub records: Vec<RecordInstance>,
    /// The poses of these rows (rows * NUM_JOINTS).
    pub rows: Option<Arc<[Mat3x4]>>,
    /// Matrices of a mesh of the user's own, where one is worn (instances * its frames).
    pub worn: Vec<Mat3x4>,
    /// Everything that is not a body.
    pub shapes: ShapeList,
    /// Things that stand in a world.
    pub solids: Solids,
    /// Numbers of the characters of the instances, if these are not all characters (number of instances); else empty.
    pub drawn: Vec<usize>,
    /// Poses of bodies that differ from one another, where they do (instances * NUM_JOINTS); else empty.
    varied: Vec<Mat3x4>,
    /// Joints of the characters with varied bodies.
    dressed: Vec<Option<variety::DressedBody>>,
    variety: variety::BodyVariants,
}

/// Colours of the content; those of the view itself are [`SceneColours`].
#[derive(Clone, Copy, Debug)]
struct StagePalette {
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

impl StagePalette {
    fn for_theme(dark: bool) -> Self {
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

impl StageLayout {
    /// Lays out the model.
    pub fn lay_out(&mut self, model: &Model, dark: bool) {
        let palette = StagePalette::for_theme(dark);
        self.instances.clear();
        self.records.clear();
        self.rows = None;
        self.shapes.clear();
        self.poses.clear();
        self.drawn.clear();
        self.solids.instances.clear();
        if let Some(bundle) = model.document.bundle() {
            self.skeleton.clone_from(bundle.tables().skeleton());
        }
        match (&model.document, model.document.bundle(), model.document.scene()) {
            (OpenDocument::Clip(motion), ..) => clip::lay_out_raw(self, model, motion, &palette),
            (OpenDocument::Task(t), ..) => task::lay_out(self, model, t, &palette, dark),
            (_, Some(bundle), _) if model.shows_clip() => clip::lay_out(self, model, bundle, &palette),
            (OpenDocument::World(w), ..) => {
                self.solids.meshes = Arc::clone(&w.meshes);
                world::lay_out(self, model, w, &palette, dark);
            }
            (_, _, Some(s)) if !model.shows_blend() => scene::lay_out(self, model, s, &palette, dark),
            (document, ..) => {
                if let Some((bundle, run)) = document.blend() {
                    blend::lay_out(self, model.settings.overlays, bundle, run, &palette);
                }
            }
        }
        self.vary(model);
        self.wear(model);
    }

    /// Joints in model space (instances * NUM_JOINTS).
    pub fn poses<'a>(&'a self, model: &'a Model) -> &'a [Mat3x4] {
        if !self.varied.is_empty() {
            return &self.varied;
        }
        if let Some(world) = model.shown_world() {
            return &world.run.reel.moment().poses;
        }
        &self.poses
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{ViewStage, ViewerCommand};
    use crate::fixtures::golden_path;
    use crate::fixtures::quietly;
    use crate::run::SceneChoice;
    use crate::settings::ViewerSettings;
    use eframe::egui;
    use throng_core::NUM_JOINTS;

    fn open() -> Model {
        let crowd = SceneChoice { characters: 12, ..SceneChoice::default() };
        let mut model = Model::new(ViewerSettings { crowd, ..ViewerSettings::default() });
        quietly(|with| model.open_now(&golden_path(), with)).unwrap();
        model
    }

    #[test]
    fn every_character_has_a_place_and_a_pose() {
        let (mut model, mut layout) = (open(), StageLayout::default());
        layout.lay_out(&model, true);
        assert_eq!(layout.instances.len(), 12);
        assert_eq!(layout.poses(&model).len(), 12 * NUM_JOINTS);
        model.apply(&egui::Context::default(), ViewerCommand::ShowClip { clip: 0, frame: 40 });
        layout.lay_out(&model, false);
        // One at the play head, and some before and after it.
        assert!(layout.instances.len() > 3, "{}", layout.instances.len());
        assert_eq!(layout.poses(&model).len(), layout.instances.len() * NUM_JOINTS);
    }

    #[test]
    fn the_pose_of_a_clip_is_the_one_at_the_play_head() {
        let (mut model, mut layout) = (open(), StageLayout::default());
        model.apply(&egui::Context::default(), ViewerCommand::ShowClip { clip: 0, frame: 7 });
        model.player.frame = 7.25;
        layout.lay_out(&model, true);
        let bundle = model.document.bundle().unwrap();
        let first = bundle.tables().clips()[0].first_frame;
        let (a, b) = (bundle.planar(first + 7), bundle.planar(first + 8));
        let root = layout.instances[0].root;
        assert!((root.x - (a.x + 0.25 * (b.x - a.x))).abs() < 1e-5);
        let heights = [7, 8].map(|f| bundle.tables().frames()[(first + f) as usize].height);
        let hips = layout.poses(&model)[0].translation().y;
        assert!((hips - (heights[0] + 0.25 * (heights[1] - heights[0]))).abs() < 1e-4);
    }

    #[test]
    fn the_bounds_contain_all_characters() {
        let model = open();
        let (low, high) = model.bounds();
        for c in 0..12 {
            for p in model.document.scene().unwrap().run.simulation().joint_positions(c).unwrap() {
                assert!(p.cmpge(low - 0.3).all() && p.cmple(high + 0.3).all(), "{p}");
            }
        }
    }

    #[test]
    fn cameras_of_the_stages_are_kept_apart() {
        let mut model = open();
        let ctx = egui::Context::default();
        let crowd = model.settings.camera;
        model.apply(&ctx, ViewerCommand::Stage(ViewStage::Clip));
        assert_ne!(model.settings.camera, crowd);
        model.apply(&ctx, ViewerCommand::Stage(ViewStage::Crowd));
        assert_eq!(model.settings.camera, crowd);
    }
}
