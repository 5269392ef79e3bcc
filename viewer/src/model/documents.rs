//! Opens documents, reads them again, and replaces the shown one.

use super::{ClipPlayer, Model, Selection};
use crate::command::{ViewStage, WorldSelection};
use crate::document::{BundleDocument, FileStamp, FileWatch, OpenDocument, SceneDocument, ShownBuild};
use crate::{bundle::OpenBundle, run::BlendRun, settings::PanelKind};
use eframe::egui;
use std::f32::consts::FRAC_PI_2;
use std::path::{Path, PathBuf};
use throng_precompute::run::{BuildContext, is_motion, motion_name};

/// End of a message about a file that could not be read, while the old one stays open.
const STAYS_OPEN: &str = "The open file stays open.";

/// Name of requested files: a file by its name, motion by the bundle that is built from it.
pub fn name_of(paths: &[PathBuf]) -> String {
    match paths {
        [path] if !is_motion(path) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        motion => motion_name(motion),
    }
}

impl Model {
    /// Shows a file that has been read; one that could not be leaves the old one in place.
    pub(super) fn adopt_loaded(&mut self) {
        let Some(loaded) = self.loader.poll() else { return };
        let is_reload = !matches!(self.document, OpenDocument::Nothing) && self.asked == loaded.paths;
        let built = loaded.building.finished(&loaded.paths, loaded.result.as_ref().err().map(String::as_str));
        let is_told = built.is_some();
        self.build = built.map(|b| ShownBuild::Ended(Box::new(b)));
        match loaded.result {
            Ok(opened) => {
                self.watch = Some(FileWatch::starting_at(loaded.stamp));
                let name = name_of(&loaded.paths);
                self.adopt(loaded.paths, opened, is_reload);
                match (is_reload, is_told) {
                    (true, _) => {
                        // Errors about an older version no longer apply.
                        self.messages.retain(|m| !m.is_error || !m.text.ends_with(STAYS_OPEN));
                        self.say(format!("{name} has changed and was reloaded"));
                    }
                    (false, false) => self.say(format!("Opened {name}")),
                    // The report of the build has the message.
                    (false, true) => {}
                }
            }
            // The report of the build has the message.
            Err(_) if is_told => {}
            Err(why) if matches!(self.document, OpenDocument::Nothing) => self.complain(why),
            Err(why) => self.complain(format!("{why}\n{STAYS_OPEN}")),
        }
    }

    /// Shows the document that was read for a request.
    fn adopt(&mut self, paths: Vec<PathBuf>, opened: OpenDocument, is_reload: bool) {
        self.settings.remember(&paths);
        self.asked = paths;
        self.show(opened, is_reload);
    }

    /// Closes the open document.
    pub(super) fn close(&mut self) {
        self.generation += 1;
        (self.document, self.watch, self.selection) = (OpenDocument::Nothing, None, Selection::default());
        self.asked.clear();
    }

    fn show(&mut self, opened: OpenDocument, is_reload: bool) {
        self.generation += 1;
        let old = self.document.head().copied().filter(|_| is_reload);
        self.document = match opened {
            OpenDocument::Bundle(b) => {
                let crowd = SceneDocument::crowd_of(&b.bundle, self.settings.crowd);
                let blend = self.walk_in(&b.bundle, is_reload);
                OpenDocument::Bundle(Box::new(BundleDocument { bundle: b.bundle, crowd, blend }))
            }
            other => other,
        };
        if let Some(head) = self.document.head_mut() {
            head.play(true);
            old.iter().for_each(|old| head.play_like(old));
        }
        let clips = self.document.bundle().map_or(0, |b| b.tables().clips().len());
        let policies = self.document.bundle().map_or(0, |b| b.tables().policies().len());
        if !is_reload {
            self.selection = Selection::default();
            let playing = matches!(self.document, OpenDocument::Clip(_) | OpenDocument::Task(_));
            self.player = ClipPlayer { playing, ..ClipPlayer::default() };
            self.stage = ViewStage::Crowd;
            self.views.clear();
            self.change_side_panel();
            let are_discs = |s: &SceneDocument| !s.surroundings.in_the_air && s.bundle().is_none();
            if self.document.scene().is_some_and(are_discs) {
                // From straight above, +X at the right.
                (self.settings.camera.yaw, self.settings.camera.pitch) = (0.0, FRAC_PI_2);
            }
            self.frame_all();
        }
        // The new bundle may have fewer of everything.
        self.selection.clip = self.selection.clip.min(clips.saturating_sub(1));
        self.selection.policy = self.selection.policy.min(policies.saturating_sub(1));
        self.selection.state = None;
        self.selection.world = WorldSelection { tool: self.selection.world.tool, ..Default::default() };
        self.limit_selected();
        // A newly opened task is planned at once; a task that is read again with its former options.
        self.plan(false);
        self.adopt_plan(self.is_unhurried);
    }

    /// A character walking in a blend space of a bundle; after a reload, as before.
    fn walk_in(&mut self, bundle: &OpenBundle, is_reload: bool) -> Option<BlendRun> {
        let complain = |why: String| self.complain(format!("Its blend spaces cannot be shown: {why}"));
        let mut run = BlendRun::new(bundle)?.map_err(complain).ok()?;
        run.reel.head.play(true);
        if let Some((_, old)) = self.document.blend().filter(|_| is_reload) {
            run.reel.head.play_like(&old.reel.head);
            // Where its space is gone, the first one is shown.
            let blending = *old.blending();
            if bundle.blend(blending.space).is_ok()
                && let Err(e) = run.blend(bundle, blending)
            {
                self.complain(e.to_string());
            }
        }
        Some(run)
    }

    /// Panels about crowds are empty for a motion file: the import report is shown instead, until a bundle is opened.
    fn change_side_panel(&mut self) {
        let side = &mut self.settings.side_panel;
        let is_clip = matches!(self.document, OpenDocument::Clip(_));
        if is_clip && side.is_some_and(|p| p != PanelKind::Report) {
            self.panel_of_bundles = side.replace(PanelKind::Report);
        } else if !is_clip && *side == Some(PanelKind::Report) {
            *side = self.panel_of_bundles.take().or(*side);
        }
        // Crowds, worlds and blends each have a panel of their own.
        let here = match &self.document {
            OpenDocument::World(_) => PanelKind::Patches,
            OpenDocument::Task(_) => PanelKind::Plan,
            OpenDocument::Scene(s) if s.scene.groups.iter().all(|g| g.is_of_agents()) => PanelKind::Crowd,
            OpenDocument::Bundle(b) if b.blend.is_some() && b.crowd.is_err() => PanelKind::Blend,
            _ => PanelKind::Control,
        };
        let own = [PanelKind::Control, PanelKind::Patches, PanelKind::Blend, PanelKind::Crowd, PanelKind::Plan];
        if own.map(Some).contains(side) {
            *side = Some(here);
        }
    }

    /// Takes the present files of the shown document as known, so that only later changes count.
    pub(super) fn watch_anew(&mut self) {
        self.watch = Some(FileWatch::starting_at(self.document.stamp(&[], None)));
    }

    pub(super) fn look_for_changes(&mut self, ctx: &egui::Context) {
        let Some(path) = self.document.path().map(Path::to_path_buf) else { return };
        let more = self.document.more_files();
        if self.loader.paths().is_none() && self.watch.as_mut().is_some_and(|w| w.has_changed(&path, &more)) {
            self.start_reading(ctx, &self.asked.clone());
        }
    }

    /// Starts to read the requested files, and to build missing bundles; [`Model::advance`] adopts the result.
    pub fn start_reading(&mut self, ctx: &egui::Context, paths: &[PathBuf]) {
        let ctx = ctx.clone();
        let from = self.document.scene().filter(|_| self.asked == paths).map(SceneDocument::resume_point);
        let building = self.loader.start(paths, from, self.is_untrusted, move || ctx.request_repaint());
        self.build = Some(ShownBuild::UnderWay { paths: paths.to_vec(), building });
    }

    /// Shows a file at once.
    ///
    /// - `with`: cache and progress for missing bundles.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn open_now(&mut self, path: &Path, with: &BuildContext<'_>) -> Result<(), String> {
        let (paths, before) = (vec![path.to_path_buf()], FileStamp::read(path));
        let opened = OpenDocument::read(&paths, self.is_untrusted, with)?;
        self.watch = Some(FileWatch::starting_at(opened.stamp(&paths, before)));
        self.adopt(paths, opened, false);
        Ok(())
    }
}
