//! Carries out commands.

use super::Model;
use crate::command::{SceneCommand, ViewStage, ViewerCommand, WorldCommand};
use crate::document::{Background, OpenDocument, SceneChoice, UserOutfit};
use crate::run::{Blending, RunInput};
use crate::settings::PanelKind;
use eframe::egui;

impl Model {
    /// Carries out a command.
    pub fn apply(&mut self, ctx: &egui::Context, command: ViewerCommand) {
        match command {
            ViewerCommand::Open(paths) => self.start_reading(ctx, &paths),
            ViewerCommand::Reload => {
                if !matches!(self.document, OpenDocument::Nothing) {
                    self.start_reading(ctx, &self.asked.clone());
                }
            }
            ViewerCommand::Close => self.close(),
            ViewerCommand::Stop => self.loader.stop(),
            ViewerCommand::DismissBuild => self.build = None,
            ViewerCommand::Forget(paths) => self.settings.forget(&paths),
            ViewerCommand::Dismiss(id) => self.messages.retain(|m| m.id != id),
            ViewerCommand::Play(_) | ViewerCommand::Step(_) | ViewerCommand::Seek(_) | ViewerCommand::Speed(_) => {
                self.move_time(&command)
            }
            ViewerCommand::Restart => self.restart(ctx),
            ViewerCommand::Input(input) => {
                let done = match (&mut self.document, input) {
                    (OpenDocument::World(world), RunInput::Goal { character, goal }) => {
                        world.give_order(character, goal).map_err(|why| format!("Character {character}: {why}"))
                    }
                    (document, input) => {
                        document.scene_mut().map_or(Ok(()), |s| s.run.input(input)).map_err(|e| e.to_string())
                    }
                };
                done.unwrap_or_else(|why| self.complain(why));
            }
            ViewerCommand::Wear(path) => {
                let ctx = ctx.clone();
                self.dressing = Some(Background::start(move || UserOutfit::open(&path), move || ctx.request_repaint()));
            }
            ViewerCommand::Blend(wanted) => self.blend(wanted),
            ViewerCommand::Steer(command) => self.apply_to_steering(command),
            ViewerCommand::World(command) => self.apply_to_world(command),
            ViewerCommand::Plan(command) => self.apply_to_task(command),
            ViewerCommand::Scene(command) => self.apply_to_scene(ctx, command),
            ViewerCommand::SelectCharacter(c) => {
                self.apply_to_world(WorldCommand::SelectPlace(None));
                (self.selection.character, self.selection.state) = (c, None);
                self.limit_selected();
            }
            ViewerCommand::ShowClip { clip, frame } => self.show_clip(clip, frame),
            ViewerCommand::SelectState(state) => self.selection.state = state,
            ViewerCommand::SelectPolicy(policy) => self.selection.policy = policy,
            ViewerCommand::Stage(stage) => self.set_stage(stage),
            ViewerCommand::TogglePanel(kind) => self.toggle_panel(kind),
            ViewerCommand::Camera(camera) => self.settings.camera = camera,
            ViewerCommand::FrameAll => self.frame_all(),
            ViewerCommand::Settings(settings) => self.settings = *settings,
        }
    }

    /// Restarts the run.
    fn restart(&mut self, ctx: &egui::Context) {
        if self.shows_blend()
            && let Some((bundle, run)) = self.document.blend_mut()
        {
            if let Err(e) = run.restart(bundle) {
                self.complain(e.to_string());
            }
        } else if let Some(choice) = self.document.choice() {
            self.apply_to_scene(ctx, SceneCommand::Restart(choice));
        }
    }

    fn apply_to_scene(&mut self, ctx: &egui::Context, command: SceneCommand) {
        let (waits, ctx) = (self.is_unhurried, ctx.clone());
        let wake = move || ctx.request_repaint();
        if let (SceneCommand::Restart(choice), OpenDocument::World(world)) = (&command, &mut self.document) {
            let begun = world.populate(*choice);
            begun.unwrap_or_else(|why| self.complain(why));
            return self.adopt_edit(waits);
        }
        let Some(scene) = self.document.scene_mut() else { return };
        let done = match command {
            SceneCommand::SetOptions(look) => {
                self.selection.scene = look;
                return;
            }
            SceneCommand::Save(path) => {
                let saved = scene.save(&path).map(|()| path.display().to_string());
                return self.tell_saved(saved);
            }
            SceneCommand::Restart(choice) => scene.restart(choice, None, wake),
            SceneCommand::Restore(path) => scene.restore(&path, wake),
        };
        match done {
            Ok(()) => self.adopt_scene(waits),
            Err(why) => self.complain(format!("The scene is unchanged: {why}")),
        }
    }

    /// Restarts a scene or the characters of a world, and blocks until they are ready.
    ///
    /// # Errors
    /// A message where that cannot be; the document is unchanged then.
    pub fn restart_now(&mut self, choice: SceneChoice) -> Result<(), String> {
        if let OpenDocument::World(world) = &mut self.document {
            world.populate(choice)?;
            self.adopt_edit(true);
        }
        let Some(scene) = self.document.scene_mut() else { return Ok(()) };
        scene.restart(choice, None, || {})?;
        scene.adopt_restart(true)?;
        self.limit_selected();
        Ok(())
    }

    /// Clears a selection beyond the number of characters, and keeps the events of the selected one.
    pub(super) fn limit_selected(&mut self) {
        let n = self.num_characters();
        self.selection.character = self.selection.character.filter(|&c| c < n);
        if let Some(scene) = self.document.scene_mut() {
            scene.run.log.watch(self.selection.character);
        }
    }

    /// Takes in a run of a scene that has been made meanwhile.
    pub(super) fn adopt_scene(&mut self, waits: bool) {
        let Some(scene) = self.document.scene_mut() else { return };
        match scene.adopt_restart(waits) {
            Ok(false) => {}
            Ok(true) => {
                if scene.is_crowd {
                    self.settings.crowd = scene.choice;
                }
                self.limit_selected();
            }
            Err(why) => self.complain(format!("The scene is unchanged: {why}")),
        }
    }

    /// Blends something else and shows it.
    pub(super) fn blend(&mut self, wanted: Blending) {
        let Some((bundle, run)) = self.document.blend_mut() else { return };
        if let Err(e) = run.blend(bundle, wanted) {
            return self.complain(e.to_string());
        }
        self.set_stage(ViewStage::Blend);
    }

    fn show_clip(&mut self, clip: usize, frame: u32) {
        let is_other = self.selection.clip != clip;
        self.set_stage(ViewStage::Clip);
        self.selection.clip = clip;
        self.player.frame = frame as f32;
        self.advance_clip(0.0);
        if is_other {
            self.frame_all();
        }
    }

    /// Every stage keeps its own camera, and the character it followed.
    pub(super) fn set_stage(&mut self, stage: ViewStage) {
        let left = self.shown_stage();
        let old = std::mem::replace(&mut self.stage, stage);
        if self.shown_stage() != stage {
            // The document does not have this stage.
            self.stage = old;
        }
        if self.shown_stage() == left {
            return;
        }
        self.views.retain(|v| v.0 != left);
        self.views.push((left, self.settings.camera, self.followed));
        match self.views.iter().find(|v| v.0 == stage) {
            Some(&(_, camera, followed)) => (self.settings.camera, self.followed) = (camera, followed),
            None => self.frame_all(),
        }
    }

    fn toggle_panel(&mut self, kind: PanelKind) {
        let open = self.settings.panel_mut(kind.dock());
        *open = if *open == Some(kind) { None } else { Some(kind) };
        if *open == Some(PanelKind::Blend) {
            self.set_stage(ViewStage::Blend);
        }
    }

    /// Moves the camera so that everything can be seen.
    pub(super) fn frame_all(&mut self) {
        let (low, high) = self.bounds();
        let aspect = if self.aspect > 0.0 { self.aspect } else { 1.5 };
        self.settings.camera.frame_box(low, high, aspect);
        self.followed = self.place_followed().map(|at| (self.followed_key(), at));
    }
}
