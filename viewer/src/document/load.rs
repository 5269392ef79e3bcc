//! Opens files on another thread, and builds missing bundles first.

use super::background::Background;
use super::{
    BundleDocument, FileStamp, OngoingBuild, OpenDocument, RawMotion, SceneDocument, SceneResumePoint, TaskDocument,
    WorldDocument,
};
use crate::bundle::OpenBundle;
use std::path::{Path, PathBuf};
use throng_precompute::run::{BuildContext, News, ensure_motion, is_motion, motion_name};
use throng_precompute::{config::BuildConfig, import, plans, progress::Progress, stitch::WorldSource, verdict};
use throng_simulation::Scene;

/// Extension of a file, in lower case.
fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase())
}

/// Paths in a row.
pub fn path_list(paths: &[PathBuf]) -> String {
    paths.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// True for files that may need a build before they can be shown: motion, scenes and worlds.
pub fn may_be_made(path: &Path) -> bool {
    is_motion(path) || extension(path) == "toml"
}

impl OpenDocument {
    /// Reads a file: motion by its extension (`.bvh` and others), `.toml` as a scene, a world or a task, anything else
    /// as a bundle. For a folder, an archive or several files of motion, first builds the bundle in the cache, as
    /// `throng build` does.
    ///
    /// - `is_untrusted`: nothing is built, and a scene reads only files beside it or below.
    /// - `with`: cache and progress for missing bundles.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn read(paths: &[PathBuf], is_untrusted: bool, with: &BuildContext<'_>) -> Result<Self, String> {
        let path = match paths {
            [path] if !is_motion(path) => path,
            several if several.iter().any(|p| ["toml", "throng"].contains(&&*extension(p))) => {
                return Err(
                    "expected one bundle, one scene, one world or one task, or motion alone; open them one by one"
                        .into(),
                );
            }
            _ if is_untrusted => return Err("--untrusted builds nothing; leave it out for motion of your own".into()),
            motion => {
                let config = BuildConfig::of_motion(motion_name(motion), motion.to_vec());
                let bundle = config.and_then(|config| ensure_motion(&config, Path::new("motion.throng"), with));
                let bundle = bundle.map_err(|e| e.to_string())?;
                return Ok(Self::Bundle(Box::new(BundleDocument::without_run(OpenBundle::open(&bundle)?))));
            }
        };
        Ok(match &*extension(path) {
            "toml" if is_untrusted => {
                let scene = Scene::load_untrusted(path).map_err(|e| e.to_string())?;
                Self::Scene(Box::new(SceneDocument::start(scene, path, with)?))
            }
            _ if import::is_motion(path) => Self::Clip(Box::new(RawMotion::open(path)?)),
            "toml" if WorldSource::is_one(path) => Self::World(Box::new(WorldDocument::open(path, with)?)),
            "toml" if plans::is_task(path) => Self::Task(Box::new(TaskDocument::open(path, with)?)),
            "toml" => Self::Scene(Box::new(SceneDocument::open(path, with)?)),
            _ => Self::Bundle(Box::new(BundleDocument::without_run(OpenBundle::open(path)?))),
        })
    }

    /// Stamp of the files of the document.
    ///
    /// - `before`: stamp of the only file that was asked for, from before it was read.
    pub fn stamp(&self, asked: &[PathBuf], before: Option<FileStamp>) -> Option<FileStamp> {
        // A bundle built from motion is newer than its sources: its stamp is read now.
        let path = self.path()?;
        let own = if asked == [path] { before } else { FileStamp::read(path) };
        FileStamp::combined(own, &self.more_files())
    }
}

/// Result of reading: a document, or why it could not be read.
pub struct LoadedDocument {
    /// Files that were requested.
    pub paths: Vec<PathBuf>,
    /// The version that was read.
    pub stamp: Option<FileStamp>,
    /// The document, or a message.
    pub result: Result<OpenDocument, String>,
    /// The build of missing bundles.
    pub building: OngoingBuild,
}

/// Reading under way.
struct RunningLoad {
    paths: Vec<PathBuf>,
    /// The version that was read, and the document or a message.
    loaded: Background<(Option<FileStamp>, Result<OpenDocument, String>)>,
    building: OngoingBuild,
}

/// Reads requested files on its own thread; a new request stops and replaces the old one.
#[derive(Default)]
pub struct Loader {
    running: Option<RunningLoad>,
}

impl Loader {
    /// Starts to read. `wake` is called when it is done.
    ///
    /// - `from`: state of the scene to resume, if the same scene is read again.
    /// - returns the build, with its log.
    pub fn start(
        &mut self,
        paths: &[PathBuf],
        from: Option<SceneResumePoint>,
        is_untrusted: bool,
        wake: impl FnOnce() + Send + 'static,
    ) -> OngoingBuild {
        self.stop();
        let building = OngoingBuild::default();
        let (log, own) = (building.clone(), paths.to_vec());
        let read = move || {
            let before = if let [path] = &*own { FileStamp::read(path) } else { None };
            let mut result = log.run_with_cache(|with| OpenDocument::read(&own, is_untrusted, with));
            if let (Ok(OpenDocument::Scene(scene)), Some(from)) = (&mut result, from)
                && let Err(why) = scene.resume(&from, || log.is_stopped())
            {
                result = Err(why);
            }
            if let Ok(opened) = &result
                && log.has_begun()
            {
                judge(opened, &log);
            }
            let stamp = result.as_ref().ok().and_then(|opened| opened.stamp(&own, before));
            (stamp, result)
        };
        let loaded = Background::start(read, wake);
        self.running = Some(RunningLoad { paths: paths.to_vec(), loaded, building: building.clone() });
        building
    }

    /// Stops the build of the requested files; [`Loader::poll`] then reports that.
    pub fn stop(&self) {
        self.running.iter().for_each(|r| r.building.stop());
    }

    /// Files being read.
    pub fn paths(&self) -> Option<&[PathBuf]> {
        self.running.as_ref().map(|r| &*r.paths)
    }

    /// Document read since the last call.
    pub fn poll(&mut self) -> Option<LoadedDocument> {
        let RunningLoad { paths, loaded, .. } = self.running.as_ref()?;
        let lost = || (None, Err(format!("{}: reading failed unexpectedly", path_list(paths))));
        let (stamp, result) = loaded.poll(false, lost)?;
        let RunningLoad { paths, building, .. } = self.running.take()?;
        Some(LoadedDocument { paths, stamp, result, building })
    }
}

/// Tries the built bundle with some characters, as `throng build` does.
fn judge(opened: &OpenDocument, building: &OngoingBuild) {
    let Some(bundle) = opened.bundle() else { return };
    building.enter_stage("trial");
    let tried = verdict::try_out(bundle.tables(), &[]);
    building.end();
    let mut log = building.log();
    match tried {
        Ok(tried) => log.verdict = tried.map(|(_, verdict)| verdict),
        Err(e) => log.news.push(News::Warning(e.to_string())),
    }
}
