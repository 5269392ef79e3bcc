//! What commands do.

use super::Model;
use super::crowd::CrowdCommand;
use super::documents::started;
use super::world::WorldCommand;
use crate::command::{Command, Stage};
use crate::document::{Document, WorldDocument};
use crate::panels::{Dock, PanelKind};
use crate::run::{Blending, Run};
use eframe::egui;
use std::path::Path;
use throng_runtime::world::inhabitants::InhabitantsError;

impl Model {
    /// Carries out a command.
    pub fn apply(&mut self, ctx: &egui::Context, command: Command) {
        match command {
            Command::Open(path) => self.start_reading(ctx, &path),
            Command::Reload => {
                if let Some(path) = self.document.path().map(Path::to_path_buf) {
                    self.start_reading(ctx, &path);
                }
            }
            Command::Dismiss(id) => self.messages.retain(|m| m.id != id),
            Command::Play(_) | Command::Step(_) | Command::Seek(_) | Command::Speed(_) => self.move_time(&command),
            Command::Restart => self.restart(ctx),
            Command::Configure(config) => {
                self.settings.run = config.limited();
                self.restart(ctx);
            }
            Command::ConfigureScene(scene) => {
                if let Document::Bundle(b) = &mut self.document
                    && let Some(file) = &mut b.scene
                {
                    file.scene = *scene;
                }
                self.restart(ctx);
            }
            Command::Input(input) => {
                if let Some((_, run)) = self.document.crowd_mut() {
                    run.input(input);
                    self.weights = run.weights().to_vec();
                }
            }
            Command::Blend(wanted) => self.blend(wanted),
            Command::Walkers { characters, seed } => self.apply_walkers(characters, seed),
            Command::World(command) => self.apply_to_world(command),
            Command::Crowd(command) => self.apply_to_crowd(ctx, command),
            Command::SelectCharacter(c) => {
                let n = self.num_characters();
                self.apply_to_world(WorldCommand::ForgetRefused);
                self.selection.world.place = None;
                (self.selection.world.instance, self.selection.world.link) = (None, None);
                self.selection.character = c.filter(|&c| c < n);
                self.selection.state = None;
                self.watch_selected();
            }
            Command::ShowClip { clip, frame } => self.show_clip(clip, frame),
            Command::SelectState(state) => self.selection.state = state,
            Command::SelectPolicy(policy) => self.selection.policy = policy,
            Command::SelectSlice(slice) => self.selection.slice = slice,
            Command::Stage(stage) => self.set_stage(stage),
            Command::TogglePanel(kind) => self.toggle_panel(kind),
            Command::Camera(camera) => self.settings.camera = camera,
            Command::FrameAll => self.frame_all(),
            Command::Settings(settings) => self.settings = *settings,
        }
    }

    fn move_time(&mut self, command: &Command) {
        let shows_clip = self.shows_clip();
        if self.head().is_some() {
            return self.move_head(command);
        }
        if let Some(world) = self.document.world_mut().filter(|_| !shows_clip) {
            if let Err(e) = move_world_time(world, command) {
                self.complain(format!("The world stopped: {e}"));
            }
            return;
        }
        let result = match self.document.crowd_mut().filter(|_| !shows_clip) {
            Some((bundle, run)) => match command {
                Command::Play(on) => {
                    run.play(*on);
                    Ok(())
                }
                Command::Speed(speed) => {
                    run.set_speed(*speed);
                    Ok(())
                }
                Command::Seek(step) => run.seek(bundle, *step),
                Command::Step(by) if *by > 0 && run.is_live() => (0..*by).try_for_each(|_| run.step(bundle)),
                Command::Step(by) => run.seek(bundle, run.now().saturating_add_signed(*by)),
                _ => Ok(()),
            },
            None => {
                let p = &mut self.player;
                match command {
                    Command::Play(on) => p.playing = *on,
                    Command::Speed(speed) if speed.is_finite() => p.speed = speed.clamp(0.05, 8.0),
                    Command::Seek(frame) => p.frame = *frame as f32,
                    Command::Step(by) => p.frame = p.frame.round() + *by as f32,
                    _ => {}
                }
                self.advance_clip(0.0);
                Ok(())
            }
        };
        if let Err(e) = result {
            self.complain(format!("The run cannot show that moment: {e}"));
        }
    }

    /// Starts the run anew.
    fn restart(&mut self, ctx: &egui::Context) {
        if let Some(choice) = self.document.crowd_scene().map(|c| c.choice()) {
            return self.apply_to_crowd(ctx, CrowdCommand::Begin(choice));
        }
        if let Some(world) = self.document.world() {
            let (characters, seed) = (world.scene().characters, world.scene().seed);
            return self.populate(characters, seed);
        }
        if let Some(scene) = self.document.walkers().map(|w| w.scene()) {
            let (characters, seed) = (scene.characters, scene.seed);
            return self.apply_walkers(characters, seed);
        }
        if self.shows_blend()
            && let Some((bundle, run)) = self.document.blend_mut()
        {
            if let Err(e) = run.restart(bundle) {
                self.complain(e.to_string());
            }
            return;
        }
        let Document::Bundle(b) = &mut self.document else { return };
        let old = b.run.as_ref().map_or((false, 1.0), |r| (r.is_playing(), r.speed()));
        let run = match &b.scene {
            Some(file) => Run::of_scene(&b.bundle, &file.scene),
            None => Run::new(&b.bundle, self.settings.run, &self.weights),
        };
        b.run = started(run, old);
        let n = b.run.as_ref().map_or(0, |r| r.config().characters);
        self.selection.character = self.selection.character.filter(|&c| c < n);
    }

    /// Begins a scene of walkers anew.
    fn apply_walkers(&mut self, characters: usize, seed: u64) {
        if let Some(walkers) = self.document.walkers_mut()
            && let Err(why) = walkers.populate(characters, seed)
        {
            self.complain(why);
        }
        let n = self.num_characters();
        self.selection.character = self.selection.character.filter(|&c| c < n);
    }

    /// Blends something else and shows it.
    fn blend(&mut self, wanted: Blending) {
        let Some((bundle, run)) = self.document.blend_mut() else { return };
        if let Err(e) = run.blend(bundle, wanted) {
            return self.complain(e.to_string());
        }
        self.set_stage(Stage::Blend);
    }

    fn show_clip(&mut self, clip: usize, frame: u32) {
        let is_other = self.selection.clip != clip;
        self.set_stage(Stage::Clip);
        self.selection.clip = clip;
        self.player.frame = frame as f32;
        self.advance_clip(0.0);
        if is_other {
            self.frame_all();
        }
    }

    /// Every stage keeps a camera of its own, and whom it went with.
    pub(super) fn set_stage(&mut self, stage: Stage) {
        let left = self.shown_stage();
        let old = std::mem::replace(&mut self.stage, stage);
        if self.shown_stage() != stage {
            // There is nothing of the kind.
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
        let Some(panel) = kind.panel() else { return };
        let open = match panel.dock {
            Dock::Side => &mut self.settings.side_panel,
            Dock::Bottom => &mut self.settings.bottom_panel,
        };
        *open = if *open == Some(kind) { None } else { Some(kind) };
        if *open == Some(PanelKind::Blend) {
            self.set_stage(Stage::Blend);
        }
    }

    /// Moves the camera so that everything can be seen.
    pub(super) fn frame_all(&mut self) {
        let (low, high) = crate::stage::bounds(self);
        let aspect = if self.aspect > 0.0 { self.aspect } else { 1.5 };
        self.settings.camera.frame_box(low, high, aspect);
        self.followed = crate::stage::followed(self).map(|at| (self.who_is_followed(), at));
    }
}

/// Plays, stops, and moves through what is kept of a world.
fn move_world_time(world: &mut WorldDocument, command: &Command) -> Result<(), InhabitantsError> {
    let now = world.run().now();
    match command {
        // Everybody is put into the changed world from where they are seen.
        Command::Seek(_) | Command::Step(_) if world.working().is_some() => {}
        Command::Play(on) => world.run_mut().play(*on),
        Command::Speed(speed) => world.run_mut().set_speed(*speed),
        Command::Seek(step) => world.run_mut().seek(*step),
        Command::Step(by) if *by > 0 && world.run().is_live() => return (0..*by).try_for_each(|_| world.step()),
        Command::Step(by) => world.run_mut().seek(now.saturating_add_signed(*by)),
        _ => {}
    }
    Ok(())
}
