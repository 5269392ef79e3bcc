//! Applies command-line arguments to settings and model.

use super::{Args, BodyChoice, PanelChoice};
use crate::command::{SceneCommand, SceneViewOptions, ViewStage, ViewerCommand};
use crate::document::{OpenDocument, SceneChoice, SceneDocument, UserOutfit};
use crate::{model::Model, settings::ViewerSettings};
use eframe::egui;
use throng_core::base::text::escape_for_terminal;
use throng_precompute::run::{BuildContext, News};
use throng_precompute::{cache::Cache, progress::Progress};
use throng_simulation::scene::engine;

/// Prints the stages of a build, on standard error.
struct StageNamePrinter;

impl Progress for StageNamePrinter {
    fn begin(&self, stage: &'static str, _total: u64, _unit: &'static str) {
        eprintln!("building a bundle: {stage}");
    }

    fn advance(&self, _done: u64) {}

    fn end(&self) {}
}

/// Names that a message lists.
const MAX_NAMES: usize = 8;

impl Args {
    /// Settings with the values of the arguments in place of the stored ones.
    pub fn settings(&self, base: ViewerSettings) -> ViewerSettings {
        let mut s = base;
        s.theme = self.theme.map_or(s.theme, Into::into);
        if let Some(BodyChoice::Made(body)) = self.body {
            s.body = body;
        }
        s.crowd.characters = self.characters.unwrap_or(s.crowd.characters);
        s.crowd.seed = self.seed.unwrap_or(s.crowd.seed);
        s.camera = self.camera.map_or(s.camera, |view| view.camera);
        if !self.panel.is_empty() {
            (s.side_panel, s.bottom_panel) = (None, None);
        }
        for choice in &self.panel {
            let PanelChoice::Open(kind) = *choice else { continue };
            *s.panel_mut(kind.dock()) = Some(kind);
        }
        s
    }

    /// Lets all characters wear the file named by the arguments.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn dress(&self, model: &mut Model) -> Result<(), String> {
        if let Some(BodyChoice::File(path)) = &self.body {
            model.wear(UserOutfit::open(path).map_err(|e| format!("--body: {e}"))?);
        }
        Ok(())
    }

    /// Opens the file at once and shows the part of it that the arguments name. Reports on standard error what has to
    /// be built first.
    ///
    /// # Errors
    /// A message that names what is wrong and the way out.
    pub fn open(&self, ctx: &egui::Context, model: &mut Model) -> Result<(), String> {
        let Some(file) = &self.file else { return Ok(()) };
        let cache = Cache::in_folder(Cache::FOLDER);
        let tell = |news: News| eprintln!("{}", escape_for_terminal(&news.to_string()));
        model.open_now(file, &BuildContext { cache: &cache, progress: &StageNamePrinter, report_news: &tell })?;
        self.show(ctx, model)
    }

    /// Shows the part of the open document that the arguments name.
    ///
    /// # Errors
    /// A message that names what is wrong and the way out.
    pub fn show(&self, ctx: &egui::Context, model: &mut Model) -> Result<(), String> {
        self.change_scene(model)?;
        if let Some(stage) = self.stage {
            self.check_stage(stage, model)?;
            model.apply(ctx, ViewerCommand::Stage(stage));
        }
        if let Some(name) = &self.clip {
            let clip = find_clip(model, name)?;
            model.apply(ctx, ViewerCommand::ShowClip { clip, frame: 0 });
        }
        if let Some(frame) = self.frame {
            show_frame(ctx, model, frame)?;
        }
        if let Some(character) = self.character {
            check_character(model, character)?;
            model.apply(ctx, ViewerCommand::SelectCharacter(Some(character)));
        }
        if let Some(name) = &self.message {
            let message = Some(find_message(model, name)?);
            let options = SceneViewOptions { message, ..model.selection.scene };
            model.apply(ctx, ViewerCommand::Scene(SceneCommand::SetOptions(options)));
        }
        if !self.panel.is_empty() {
            model.settings.side_panel = self.settings(ViewerSettings::default()).side_panel;
        }
        if let Some(view) = self.camera {
            model.apply(ctx, ViewerCommand::Camera(view.camera));
        }
        if self.camera.is_none_or(|view| !view.is_placed) {
            model.apply(ctx, ViewerCommand::FrameAll);
        }
        Ok(())
    }

    /// Gives a scene or a world another number of characters, another seed and another engine.
    fn change_scene(&self, model: &mut Model) -> Result<(), String> {
        let has_agents = |scene: &SceneDocument| scene.scene.groups.iter().any(|g| g.is_of_agents());
        if let Some(name) = self.engine.map(engine::name)
            && !model.document.scene().is_some_and(has_agents)
        {
            let example = "data/scenes/corridor.toml";
            return Err(format!("--engine {name}: engines are for scenes with agents, such as {example}"));
        }
        let Some(old) = model.document.choice() else { return Ok(()) };
        let (characters, seed) = (self.characters.unwrap_or(old.characters), self.seed.unwrap_or(old.seed));
        let choice = SceneChoice { characters, seed, engine: self.engine.unwrap_or(old.engine) };
        if choice == old { Ok(()) } else { model.restart_now(choice) }
    }

    fn check_stage(&self, stage: ViewStage, model: &Model) -> Result<(), String> {
        match (&model.document, stage) {
            (OpenDocument::Bundle(b), ViewStage::Crowd) => {
                b.crowd.as_ref().map(|_| ()).map_err(|e| format!("--stage crowd: {e}"))
            }
            (document, ViewStage::Blend) if document.blend().is_none() => {
                Err("--stage blend: there is no blend space; open a bundle that was built with `blend`".into())
            }
            (OpenDocument::Clip(_), ViewStage::Crowd) => {
                Err("--stage crowd: a motion file holds no crowd; open a bundle, or leave out --stage".into())
            }
            _ => Ok(()),
        }
    }
}

/// Number of the message of this name.
fn find_message(model: &Model, wanted: &str) -> Result<usize, String> {
    let brains = model.document.scene().and_then(|s| s.run.simulation().brains());
    let Some(brains) = brains.filter(|m| m.has_events()) else {
        return Err(format!("--message {wanted}: nothing happens here that is told; open a scene with `[[events]]`"));
    };
    let names: Vec<&str> = brains.event_names().iter().map(String::as_str).collect();
    let found = names.iter().position(|n| *n == wanted);
    found.ok_or_else(|| format!("--message {wanted}: no event has that name; there are {}", some_of(&names)))
}

/// Number of the clip of this name, or of the only clip whose name contains it.
fn find_clip(model: &Model, wanted: &str) -> Result<usize, String> {
    let Some(bundle) = model.document.bundle() else {
        return Err(format!("--clip {wanted}: a motion file is one clip; open a bundle, or leave out --clip"));
    };
    let names: Vec<&str> = bundle.clips().map(|c| c.1.name.as_str()).collect();
    if let Some(exact) = names.iter().position(|n| *n == wanted) {
        return Ok(exact);
    }
    let low = wanted.to_lowercase();
    let like: Vec<usize> = (0..names.len()).filter(|&c| names[c].to_lowercase().contains(&low)).collect();
    match like[..] {
        [only] => Ok(only),
        [] => Err(format!("--clip {wanted}: no clip has that name; there are {}", some_of(&names))),
        _ => {
            let like: Vec<&str> = like.iter().map(|&c| names[c]).collect();
            let (count, some) = (like.len(), some_of(&like));
            Err(format!("--clip {wanted}: {count} clips have that in their names; choose one of: {some}"))
        }
    }
}

/// The first few of many names.
fn some_of(names: &[&str]) -> String {
    let first = names[..names.len().min(MAX_NAMES)].join(", ");
    if names.len() > MAX_NAMES { format!("{first} and {} more", names.len() - MAX_NAMES) } else { first }
}

fn show_frame(ctx: &egui::Context, model: &mut Model, frame: u32) -> Result<(), String> {
    if !model.shows_clip() {
        model.apply(ctx, ViewerCommand::Stage(ViewStage::Clip));
    }
    let num_frames = model.shown_clip().map_or(0, |c| c.0);
    if frame >= num_frames {
        return Err(format!("--frame {frame}: the clip has {num_frames} frames, counted from 0"));
    }
    model.apply(ctx, ViewerCommand::Play(false));
    model.apply(ctx, ViewerCommand::Seek(frame));
    Ok(())
}

fn check_character(model: &Model, wanted: usize) -> Result<(), String> {
    match model.num_characters() {
        0 => Err(format!("--character {wanted}: there is no crowd to select from")),
        n if wanted < n => Ok(()),
        n => {
            Err(format!("--character {wanted}: the crowd has {n} characters, counted from 0; --characters makes more"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::golden_path as golden;
    use crate::settings::PanelKind;
    use throng_crowd::Scheme;
    use throng_precompute::synth::{SynthConfig, SynthSet};

    fn opened(args: &Args) -> Result<Model, String> {
        let mut model = Model::new(args.settings(ViewerSettings::default()));
        model.is_untrusted = args.untrusted;
        args.open(&egui::Context::default(), &mut model).map(|()| model)
    }

    #[test]
    fn arguments_go_over_settings() {
        let args = Args { seed: Some(5), panel: vec![PanelChoice::Open(PanelKind::Statistics)], ..Args::default() };
        let s = args.settings(ViewerSettings::default());
        assert_eq!((s.crowd.seed, s.side_panel), (5, Some(PanelKind::Statistics)));
        assert_eq!(s.theme, ViewerSettings::default().theme);
        let alone = Args { panel: vec![PanelChoice::None], ..Args::default() }.settings(s);
        assert_eq!((alone.side_panel, alone.bottom_panel, alone.crowd.seed), (None, None, 5));
    }

    #[test]
    fn clips_frames_and_characters_are_shown() {
        let first = opened(&Args { file: Some(golden()), ..Args::default() }).expect("the golden bundle");
        let name = first.document.bundle().expect("a bundle").clip_name(0).to_owned();
        let args = Args { file: Some(golden()), clip: Some(name), frame: Some(7), ..Args::default() };
        let model = opened(&args).expect("a clip of it");
        assert!(model.shows_clip() && !model.player.playing);
        assert_eq!((model.selection.clip, model.player.frame), (0, 7.0));
        let args = Args { file: Some(golden()), character: Some(3), ..Args::default() };
        assert_eq!(opened(&args).expect("a crowd").selection.character, Some(3));
    }

    #[test]
    fn absent_things_are_named_with_the_way_out() {
        let file = Some(golden());
        for (args, say) in [
            (Args { file: Some("no.throng".into()), ..Args::default() }, "no.throng"),
            (Args { file: file.clone(), clip: Some("moonwalk".into()), ..Args::default() }, "there are "),
            (Args { file: file.clone(), frame: Some(1_000_000), ..Args::default() }, "frames, counted from 0"),
            (Args { file: file.clone(), engine: Some(Scheme::Occupancy), ..Args::default() }, "scenes with agents"),
            (Args { file: file.clone(), message: Some("sale".into()), ..Args::default() }, "[[events]]"),
            (Args { file, character: Some(100), ..Args::default() }, "has 100 characters"),
        ] {
            let e = opened(&args).err().expect(say);
            assert!(e.contains(say), "{e}");
        }
    }

    #[test]
    fn a_motion_file_has_no_crowd_and_no_clips_to_choose_from() {
        let folder = tempfile::tempdir().expect("a folder");
        let short = SynthConfig { minutes: 0.1, clip_seconds: 10.0, ..SynthConfig::default() };
        let made = throng_precompute::synth::make_set(SynthSet::Walk, &short).expect("a walk");
        let files = throng_precompute::synth::save(&made, folder.path()).expect("files");
        let file = files[0].clone();
        for (args, say) in [
            (Args { file: Some(file.clone()), stage: Some(ViewStage::Crowd), ..Args::default() }, "no crowd"),
            (Args { file: Some(file.clone()), clip: Some("a".into()), ..Args::default() }, "one clip"),
            (Args { file: Some(file.clone()), character: Some(0), ..Args::default() }, "no crowd"),
        ] {
            let e = opened(&args).err().expect(say);
            assert!(e.contains(say), "{e}");
        }
    }
}
