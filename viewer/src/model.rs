//! State of the viewer: the open document, the selection, and messages to the user.

mod commands;
mod documents;
mod places;
mod plan;
mod playback;
mod steer;
pub mod world;

pub use documents::name_of;
pub use steer::{Lags, UserSteering};

use crate::command::{PlanViewOptions, SceneViewOptions, ViewStage, WorldSelection};
use crate::document::{Background, FileWatch, Loader, OngoingBuild, OpenDocument, ShownBuild, UserOutfit};
use crate::render::{BodyStyle, OrbitCamera};
use crate::settings::{BODIES, PanelKind, ViewerSettings};
use eframe::egui;
use glam::Vec3;
use std::path::PathBuf;

/// Time for which messages stay on the screen; errors stay until they are dismissed (s).
const NEWS_S: f64 = 6.0;

/// Selection of the user.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Selection {
    /// Character of the run.
    pub character: Option<usize>,
    /// State of the motion graph; none follows the character.
    pub state: Option<u32>,
    /// Behaviour.
    pub policy: usize,
    /// Clip of the database.
    pub clip: usize,
    /// Selection in a world.
    pub world: WorldSelection,
    /// View options of a scene.
    pub scene: SceneViewOptions,
    /// View options of a task.
    pub plan: PlanViewOptions,
}

/// The play head of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlayer {
    /// Frame within the clip.
    pub frame: f32,
    /// Time moves on.
    pub playing: bool,
    /// Seconds that pass in one.
    pub speed: f32,
}

impl Default for ClipPlayer {
    fn default() -> Self {
        Self { frame: 0.0, playing: false, speed: 1.0 }
    }
}

/// Subject of the camera: stage, character, clip.
type FollowedKey = (ViewStage, Option<usize>, usize);
/// Subject of the camera, and its position (m).
type FollowedPlace = (FollowedKey, Vec3);

/// A message to the user.
#[derive(Clone, Debug, PartialEq)]
pub struct UserMessage {
    /// Number by which the message is dismissed.
    pub id: u64,
    /// Text of the message.
    pub text: String,
    /// Something went wrong.
    pub is_error: bool,
    /// When it goes away by itself (s of [`egui::InputState::time`]).
    pub until: f64,
}

/// Times of the parts of the last frame on this thread (s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Steps of the crowd.
    pub simulation_s: f64,
    /// Laying out the frame (s).
    pub layout_s: f64,
    /// Handing poses to the graphics device.
    pub upload_s: f64,
    /// Encoding the drawing; in a picture, waiting for it too.
    pub drawing_s: f64,
    /// From one frame to the next.
    pub frame_s: f64,
    /// Steps taken in the frame.
    pub steps: u32,
}

/// All that the viewer knows. Panels borrow it.
#[derive(Default)]
pub struct Model {
    /// The open document.
    pub document: OpenDocument,
    /// Settings stored between runs.
    pub settings: ViewerSettings,
    /// Selection of the user.
    pub selection: Selection,
    /// Stage of the 3-D view.
    pub stage: ViewStage,
    /// The play head of the clip shown.
    pub player: ClipPlayer,
    /// Messages to the user.
    pub messages: Vec<UserMessage>,
    /// Times of the last frame.
    pub times: FrameTimes,
    /// Aspect ratio of the 3-D view, width over height; 0 before it was first shown.
    pub aspect: f32,
    /// Simulates every step in full, however long it takes: for pictures and measurements, which must not depend on
    /// the speed of the machine.
    pub is_unhurried: bool,
    /// Reads only files beside a scene or below, and builds nothing.
    pub is_untrusted: bool,
    /// Number of the shown version; grows with every file that is shown, so that results computed from an older
    /// version are discarded.
    pub generation: u64,
    /// The build under way, or the last one until it is dismissed.
    pub build: Option<ShownBuild>,
    /// A character of the user's own.
    pub outfit: Option<UserOutfit>,
    dressing: Option<Background<Result<UserOutfit, String>>>,
    steering: Option<UserSteering>,
    /// Files of the open document, as requested.
    pub asked: Vec<PathBuf>,
    loader: Loader,
    watch: Option<FileWatch>,
    num_messages: u64,
    /// Side panel that was open before a motion file was.
    panel_of_bundles: Option<PanelKind>,
    /// Subject of the camera in the last frame, and its position.
    followed: Option<FollowedPlace>,
    /// Cameras of the other stages, and their subjects.
    views: Vec<(ViewStage, OrbitCamera, Option<FollowedPlace>)>,
    now_s: f64,
}

impl Model {
    /// Nothing open.
    pub fn new(settings: ViewerSettings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// Files being read.
    pub fn loading(&self) -> Option<&[PathBuf]> {
        self.loader.paths()
    }

    /// The build for the files being read; none while files are only read.
    pub fn building(&self) -> Option<&OngoingBuild> {
        match &self.build {
            Some(ShownBuild::UnderWay { building, .. }) if building.has_begun() => Some(building),
            _ => None,
        }
    }

    /// Frames and rate of the clip shown (frames, Hz).
    pub fn shown_clip(&self) -> Option<(u32, f32)> {
        match &self.document {
            OpenDocument::Clip(c) => Some((c.imported.clip.num_frames as u32, c.imported.clip.rate_hz as f32)),
            OpenDocument::Task(t) => Some(t.frames()),
            document => {
                let bundle = document.bundle()?;
                Some((bundle.tables().clips().get(self.selection.clip)?.num_frames, bundle.rate_hz()))
            }
        }
    }

    /// Row of the frame of the database that is shown as a clip.
    pub fn shown_row(&self) -> Option<u32> {
        let clip = self.document.bundle()?.tables().clips().get(self.selection.clip)?;
        Some(clip.first_frame + (self.player.frame as u32).min(clip.num_frames - 1))
    }

    /// State inspected by panels: the selected one, or the one of the selected character's last choice.
    pub fn inspected_state(&self) -> Option<u32> {
        let followed = || {
            let c = self.document.chooser(self.selection.character?)?;
            Some(c.characters.last_choice(c.number)?.state)
        };
        self.selection.state.or_else(followed)
    }

    /// True where something moves by itself, so that the next frame has to be shown soon.
    pub fn is_playing(&self) -> bool {
        if self.shows_clip() { self.player.playing } else { self.head().is_some_and(|h| h.is_playing()) }
    }

    /// True where something is still to be worked off while time stands still, so that the next frame has to be shown
    /// soon.
    pub fn is_busy(&self) -> bool {
        self.document.world().is_some_and(|w| w.working.is_some())
            || self.document.scene().is_some_and(|s| s.restarting().is_some())
            || self.document.task().is_some_and(|t| t.planning.is_some())
    }

    /// Number of characters of the crowd or the world, or of agents of a scene.
    pub fn num_characters(&self) -> usize {
        match &self.document {
            OpenDocument::World(w) => w.run.num_characters(),
            document => document.scene().map_or(0, |s| s.run.simulation().num_characters()),
        }
    }

    /// The mesh that all characters wear.
    pub fn worn_outfit(&self) -> Option<&UserOutfit> {
        self.outfit.as_ref().filter(|_| self.settings.body == BodyStyle::Own)
    }

    /// Available bodies with their names.
    pub fn bodies(&self) -> Vec<(BodyStyle, String)> {
        let made = BODIES.into_iter().map(|(body, name)| (body, name.to_owned()));
        made.chain(self.outfit.as_ref().map(|o| (BodyStyle::Own, o.name()))).collect()
    }

    /// The body after the one shown, the first one after the last.
    pub fn next_body(&self) -> BodyStyle {
        let all = self.bodies();
        let at = all.iter().position(|b| b.0 == self.settings.body).unwrap_or(0);
        all[(at + 1) % all.len()].0
    }

    /// Lets all characters wear a mesh.
    pub fn wear(&mut self, outfit: UserOutfit) {
        self.outfit = Some(outfit);
        self.settings.body = BodyStyle::Own;
    }

    fn adopt_outfit(&mut self) {
        let lost = || Err("Reading the character failed unexpectedly.".to_owned());
        let Some(read) = self.dressing.as_ref().and_then(|d| d.poll(false, lost)) else { return };
        self.dressing = None;
        match read {
            Ok(outfit) => {
                self.say(format!("Everybody wears {}: {} triangles", outfit.name(), outfit.mesh.num_triangles()));
                self.wear(outfit);
            }
            Err(why) => self.complain(format!("{why}\nBodies stay as they are.")),
        }
    }

    /// Adds a message.
    pub fn say(&mut self, text: impl Into<String>) {
        self.push_message(text.into(), false);
    }

    /// Adds an error message.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.push_message(text.into(), true);
    }

    /// Tells which files were written, or why none was.
    fn tell_saved(&mut self, saved: Result<String, String>) {
        match saved {
            Ok(files) => self.say(format!("Saved {files}")),
            Err(why) => self.complain(why),
        }
    }

    fn push_message(&mut self, text: String, is_error: bool) {
        self.messages.retain(|m| m.text != text);
        self.num_messages += 1;
        let until = if is_error { f64::INFINITY } else { self.now_s + NEWS_S };
        self.messages.push(UserMessage { id: self.num_messages, text, is_error, until });
    }

    /// Advances time and adopts what other threads have read meanwhile.
    pub fn advance(&mut self, ctx: &egui::Context, wall_s: f32) {
        self.now_s = ctx.input(|i| i.time);
        let now = self.now_s;
        self.messages.retain(|m| m.until > now);
        self.adopt_loaded();
        self.adopt_outfit();
        self.look_for_changes(ctx);
        self.adopt_edit(false);
        self.adopt_scene(false);
        self.adopt_plan(false);
        self.times.steps = 0;
        self.steer();
        if self.shows_clip() {
            self.advance_clip(wall_s);
        } else {
            self.times.steps = self.advance_run(wall_s);
        }
        self.update_steered(self.times.steps, wall_s);
        self.follow();
    }

    /// Moves the camera with the selected character: always with the one of a clip or a blend, with one of many or of a
    /// task if that is switched on.
    fn follow(&mut self) {
        let always = (self.shows_clip() && self.document.task().is_none()) || self.shows_blend();
        let place = if always || self.settings.follow { self.place_followed() } else { None };
        let Some(at) = place else {
            self.followed = None;
            return;
        };
        let who = self.followed_key();
        let before = self.followed.replace((who, at)).filter(|f| f.0 == who);
        let target = &mut self.settings.camera.target;
        match before {
            Some((_, before)) => *target += (at - before).with_y(0.0),
            None => *target = at.with_y(target.y),
        }
    }

    /// Subject of the camera.
    fn followed_key(&self) -> FollowedKey {
        (self.shown_stage(), self.selection.character, self.selection.clip)
    }

    fn advance_clip(&mut self, wall_s: f32) {
        let Some((num_frames, rate)) = self.shown_clip() else { return };
        let last = num_frames.saturating_sub(1) as f32;
        let p = &mut self.player;
        if p.playing {
            p.frame += wall_s * rate * p.speed;
            if p.frame > last {
                p.frame = 0.0;
            }
        }
        p.frame = p.frame.clamp(0.0, last);
    }
}
