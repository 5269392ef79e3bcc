//! All that the viewer knows: what is open, what is shown of it, what was said of it.

pub mod world;

use crate::command::{Command, Stage};
use crate::document::{Bundle, BundleDocument, Document, Loader, Opened, SceneFile, Stamp, Watch, WorldDocument};
use crate::panels::{Dock, PanelKind};
use crate::render::Camera;
use crate::run::Run;
use crate::settings::Settings;
use eframe::egui;
use glam::Vec3;
use std::path::{Path, PathBuf};
use throng_runtime::world::inhabitants::InhabitantsError;

/// Time that news stay on the screen; errors stay until they are taken away. [Unit: s]
const NEWS_S: f64 = 6.0;

/// What is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Selection {
    /// Character of the run.
    pub character: Option<usize>,
    /// State of the motion graph; none follows the character.
    pub state: Option<u32>,
    /// Behaviour.
    pub policy: usize,
    /// Height, or moment, of its grid; the last one where it has not so many.
    pub slice: u32,
    /// Clip of the database.
    pub clip: usize,
    /// What is looked at in a world.
    pub world: world::WorldLook,
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

/// What tells one whom the camera goes with from another: clip or crowd, character, clip.
type Who = (bool, Option<usize>, usize);
/// Whom the camera went with, and where that was. [Unit: m]
type Followed = (Who, Vec3);

/// Something said to the user.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Number by which it is taken away.
    pub id: u64,
    /// What is said.
    pub text: String,
    /// Something went wrong.
    pub is_error: bool,
    /// When it goes away by itself. [Unit: s of [`egui::InputState::time`]]
    pub until: f64,
}

/// Where the time of the last frame went, as far as this thread is concerned. [Unit: s]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Steps of the crowd.
    pub simulation_s: f64,
    /// Laying out what is drawn.
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
#[derive(Debug, Default)]
pub struct Model {
    /// What is open.
    pub document: Document,
    /// What is remembered from run to run.
    pub settings: Settings,
    /// What is looked at.
    pub selection: Selection,
    /// What the 3-D view shows of a bundle.
    pub stage: Stage,
    /// The play head of the clip that is shown.
    pub player: ClipPlayer,
    /// What was said.
    pub messages: Vec<Message>,
    /// Where the time goes.
    pub times: FrameTimes,
    /// Width of the 3-D view over its height; 0 before it was first shown.
    pub aspect: f32,
    /// Grows with every file that is shown, so that what was worked out of an older version is known for what it is.
    pub generation: u64,
    weights: Vec<f32>,
    loader: Loader,
    watch: Option<Watch>,
    num_messages: u64,
    /// Side panel that was open before a motion file was.
    panel_of_bundles: Option<PanelKind>,
    /// Who was followed by the camera in the last frame, and where that was.
    followed: Option<Followed>,
    /// Camera of the stage that is not shown, and whom it went with.
    other_view: Option<(Camera, Option<Followed>)>,
    now_s: f64,
}

impl Model {
    /// Nothing open.
    pub fn new(settings: Settings) -> Self {
        Self { settings, ..Self::default() }
    }

    /// The file that is being read.
    pub fn loading(&self) -> Option<&Path> {
        self.loader.path()
    }

    /// True where the 3-D view shows a clip, of the database or of a motion file.
    pub fn shows_clip(&self) -> bool {
        match &self.document {
            Document::Nothing => false,
            Document::Bundle(b) => self.stage == Stage::Clip || b.run.is_err(),
            Document::World(_) => self.stage == Stage::Clip,
            Document::Clip(_) => true,
        }
    }

    /// Frames and rate of the clip that is shown. [Unit: frames, Hz]
    pub fn shown_clip(&self) -> Option<(u32, f32)> {
        match &self.document {
            Document::Clip(c) => Some((c.imported.clip.num_frames as u32, c.imported.clip.rate_hz as f32)),
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

    /// The state that panels look at: the selected one, or that in which the selected character last chose.
    pub fn looked_at_state(&self) -> Option<u32> {
        let followed = || {
            let (_, run) = self.document.crowd()?;
            Some(run.troupe().last_choice(self.selection.character?)?.state)
        };
        self.selection.state.or_else(followed)
    }

    /// True where something moves by itself, so that the next frame has to be shown soon.
    pub fn is_playing(&self) -> bool {
        if self.shows_clip() {
            return self.player.playing;
        }
        let in_world = self.document.world().is_some_and(|w| w.run().is_playing());
        in_world || self.document.crowd().is_some_and(|c| c.1.is_playing())
    }

    /// Number of characters of the crowd or the world.
    pub fn num_characters(&self) -> usize {
        let in_world = self.document.world().map(|w| w.run().num_characters());
        in_world.or_else(|| Some(self.document.crowd()?.1.config().characters)).unwrap_or(0)
    }

    /// Says something.
    pub fn say(&mut self, text: impl Into<String>) {
        self.push_message(text.into(), false);
    }

    /// Says that something went wrong.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.push_message(text.into(), true);
    }

    fn push_message(&mut self, text: String, is_error: bool) {
        self.messages.retain(|m| m.text != text);
        self.num_messages += 1;
        let until = if is_error { f64::INFINITY } else { self.now_s + NEWS_S };
        self.messages.push(Message { id: self.num_messages, text, is_error, until });
    }

    /// Moves time on and takes in what has been read meanwhile.
    pub fn advance(&mut self, ctx: &egui::Context, wall_s: f32) {
        self.now_s = ctx.input(|i| i.time);
        let now = self.now_s;
        self.messages.retain(|m| m.until > now);
        self.take_in();
        self.look_for_changes(ctx);
        self.times.steps = 0;
        if self.shows_clip() {
            self.advance_clip(wall_s);
        } else if let Some((bundle, run)) = self.document.crowd_mut() {
            match run.advance(bundle, wall_s) {
                Ok(steps) => self.times.steps = steps,
                Err(e) => {
                    run.play(false);
                    self.complain(format!("The run stopped: {e}"));
                }
            }
        } else if let Some(world) = self.document.world_mut() {
            match world.advance(wall_s) {
                Ok(steps) => self.times.steps = steps,
                Err(e) => {
                    world.run_mut().play(false);
                    self.complain(format!("The world stopped: {e}"));
                }
            }
        }
        self.follow();
    }

    /// Lets the camera go with who is looked at: always with a clip's character, with a crowd's where that is wanted.
    fn follow(&mut self) {
        let place = if self.shows_clip() || self.settings.follow { crate::stage::followed(self) } else { None };
        let Some(at) = place else {
            self.followed = None;
            return;
        };
        let who = self.who_is_followed();
        let before = self.followed.replace((who, at)).filter(|f| f.0 == who);
        let target = &mut self.settings.camera.target;
        match before {
            Some((_, before)) => *target += (at - before).with_y(0.0),
            None => *target = at.with_y(target.y),
        }
    }

    /// What tells one who is followed from another.
    fn who_is_followed(&self) -> Who {
        (self.shows_clip(), self.selection.character, self.selection.clip)
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

    /// Shows a file that has been read; one that could not be leaves the old one in place.
    fn take_in(&mut self) {
        let Some(loaded) = self.loader.poll() else { return };
        let is_reload = self.document.path() == Some(loaded.path.as_path());
        match loaded.result {
            Ok(opened) => {
                self.watch = Some(Watch::from(loaded.stamp));
                self.settings.remember(&loaded.path);
                self.show(opened, is_reload);
                let name = loaded.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                self.say(if is_reload {
                    format!("{name} has changed and was read again")
                } else {
                    format!("Opened {name}")
                });
            }
            Err(why) if matches!(self.document, Document::Nothing) => self.complain(why),
            Err(why) => self.complain(format!("{why}\nWhat was open is kept.")),
        }
    }

    fn show(&mut self, opened: Opened, is_reload: bool) {
        self.generation += 1;
        self.document = match opened {
            Opened::Clip(clip) => Document::Clip(clip),
            Opened::Bundle(bundle) => self.with_run(*bundle, None, is_reload),
            Opened::Scene(scene, bundle) => self.with_run(*bundle, Some(*scene), is_reload),
            Opened::World(mut world) => {
                let old = self.document.world().filter(|_| is_reload).map(|w| (w.run().is_playing(), w.run().speed()));
                let (playing, speed) = old.unwrap_or((true, 1.0));
                world.run_mut().play(playing);
                world.run_mut().set_speed(speed);
                Document::World(world)
            }
        };
        if let Some(why) = self.document.scene_fault().map(str::to_owned) {
            self.complain(why);
        }
        let clips = self.document.bundle().map_or(0, |b| b.tables().clips().len());
        let policies = self.document.bundle().map_or(0, |b| b.tables().num_policies());
        if !is_reload {
            self.selection = Selection::default();
            self.player = ClipPlayer { playing: matches!(self.document, Document::Clip(_)), ..ClipPlayer::default() };
            self.stage = Stage::Crowd;
            self.other_view = None;
            self.change_side_panel();
            self.frame_all();
        }
        // The new bundle may have fewer of everything.
        self.selection.clip = self.selection.clip.min(clips.saturating_sub(1));
        self.selection.policy = self.selection.policy.min(policies.saturating_sub(1));
        self.selection.state = None;
        self.selection.world = world::WorldLook { tool: self.selection.world.tool, ..Default::default() };
        let n = self.num_characters();
        self.selection.character = self.selection.character.filter(|&c| c < n);
    }

    /// A bundle with a crowd or its scene.
    fn with_run(&mut self, bundle: Bundle, scene: Option<SceneFile>, is_reload: bool) -> Document {
        if !is_reload {
            // Those of another bundle's behaviours.
            self.weights.clear();
        }
        let run = match &scene {
            Some(file) => Run::of_scene(&bundle, &file.scene),
            None => Run::new(&bundle, self.settings.run, &self.weights),
        };
        let old = self.document.crowd().map(|c| (c.1.is_playing(), c.1.speed())).filter(|_| is_reload);
        let run = started(run, old.unwrap_or((true, 1.0)));
        Document::Bundle(Box::new(BundleDocument { bundle, run, scene }))
    }

    /// Panels about crowds have nothing to say of a motion file: it is shown with its report instead, until a bundle is
    /// open again.
    fn change_side_panel(&mut self) {
        let side = &mut self.settings.side_panel;
        let is_clip = matches!(self.document, Document::Clip(_));
        if is_clip && side.is_some_and(|p| p != PanelKind::Report) {
            self.panel_of_bundles = side.replace(PanelKind::Report);
        } else if !is_clip && *side == Some(PanelKind::Report) {
            *side = self.panel_of_bundles.take().or(*side);
        }
        // What moves a crowd is in one panel, what moves those who live in a world in another.
        let (here, elsewhere) = match self.document {
            Document::World(_) => (PanelKind::Patches, PanelKind::Control),
            _ => (PanelKind::Control, PanelKind::Patches),
        };
        if *side == Some(elsewhere) {
            *side = Some(here);
        }
    }

    fn look_for_changes(&mut self, ctx: &egui::Context) {
        let Some(path) = self.document.path().map(Path::to_path_buf) else { return };
        let files = self.document.files();
        let more = files.get(1).map(PathBuf::as_path);
        if self.loader.path().is_none() && self.watch.as_mut().is_some_and(|w| w.has_changed(&path, more)) {
            self.start_reading(ctx, &path);
        }
    }

    /// Starts to read a file; [`Model::advance`] takes it in when it is there.
    pub fn start_reading(&mut self, ctx: &egui::Context, path: &Path) {
        let ctx = ctx.clone();
        self.loader.start(path, move || ctx.request_repaint());
    }

    /// Shows a file at once.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn open_now(&mut self, path: &Path) -> Result<(), String> {
        let before = Stamp::of(path);
        let opened = Opened::read(path)?;
        self.watch = Some(Watch::from(Stamp::with(before, opened.more_files())));
        self.settings.remember(path);
        self.show(opened, false);
        Ok(())
    }

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
            Command::Restart => self.restart(),
            Command::Configure(config) => {
                self.settings.run = config.limited();
                self.restart();
            }
            Command::ConfigureScene(scene) => {
                if let Document::Bundle(b) = &mut self.document
                    && let Some(file) = &mut b.scene
                {
                    file.scene = *scene;
                }
                self.restart();
            }
            Command::Input(input) => {
                if let Some((_, run)) = self.document.crowd_mut() {
                    run.input(input);
                    self.weights = run.weights().to_vec();
                }
            }
            Command::World(command) => self.apply_to_world(command),
            Command::SelectCharacter(c) => {
                let n = self.num_characters();
                self.selection.world.place = None;
                (self.selection.world.instance, self.selection.world.link) = (None, None);
                self.selection.character = c.filter(|&c| c < n);
                self.selection.state = None;
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
    fn restart(&mut self) {
        if let Some(world) = self.document.world() {
            let (characters, seed) = (world.scene().characters, world.scene().seed);
            return self.populate(characters, seed);
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
    fn set_stage(&mut self, stage: Stage) {
        let has_run = self.document.crowd().is_some() || self.document.world().is_some();
        if !has_run || std::mem::replace(&mut self.stage, stage) == stage {
            return;
        }
        let left = (self.settings.camera, self.followed);
        match self.other_view.replace(left) {
            Some(view) => (self.settings.camera, self.followed) = view,
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
    }

    /// Moves the camera so that everything can be seen.
    fn frame_all(&mut self) {
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
        Command::Play(on) => world.run_mut().play(*on),
        Command::Speed(speed) => world.run_mut().set_speed(*speed),
        Command::Seek(step) => world.run_mut().seek(*step),
        Command::Step(by) if *by > 0 && world.run().is_live() => return (0..*by).try_for_each(|_| world.step()),
        Command::Step(by) => world.run_mut().seek(now.saturating_add_signed(*by)),
        _ => {}
    }
    Ok(())
}

/// A run that plays, or not, at a speed.
fn started(run: Result<Run, String>, (playing, speed): (bool, f32)) -> Result<Run, String> {
    run.map(|mut run| {
        run.play(playing);
        run.set_speed(speed);
        run
    })
}
