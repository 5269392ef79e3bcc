//! Builds missing inputs of a scene: bundles from their configs, worlds from their world files.

use super::{News, report::config_error};
use std::path::{Path, PathBuf};
use throng_bake::cache::{Cache, CacheKey};
use throng_bake::stitch::{self, StitchKit, StitchReport, WorldSource};
use throng_bake::{config::BuildConfig, pipeline};
use throng_core::{Bundle, blend::axis};
use throng_motion::error::{BuildError, ImportError, Result, Warnings};
use throng_motion::progress::Progress;
use throng_simulation::{GroupMotion, Scene};
use throng_world::World;

/// Way out where a bundle is missing.
const WAY_OUT: &str = "build it with `throng build`, or name another with --bundle";

/// Cache, progress and messages for building.
#[derive(Clone, Copy)]
pub struct BuildContext<'a> {
    /// Cache of stage outputs.
    pub cache: &'a Cache,
    /// Receives the progress of stages.
    pub progress: &'a dyn Progress,
    /// Receives messages on what is built, and warnings.
    pub report_news: &'a dyn Fn(News),
}

/// Builds every missing bundle and world of a scene, and every world whose world file has changed.
///
/// # Errors
/// As building or stitching; [`BuildError::Config`] for a missing bundle without a config.
pub fn ensure_scene(scene: &Scene, with: &BuildContext<'_>) -> Result<()> {
    for (g, group) in scene.groups.iter().enumerate().filter(|(_, g)| g.motion != GroupMotion::None) {
        let (Some(bundle), config) = scene.bundle_of(g) else { continue };
        if config.is_none() && !bundle.exists() {
            let key = if group.bundle.is_some() { format!("groups[{g}].bundle") } else { "bundle".into() };
            let why = format!("{}: there is no such bundle; {WAY_OUT}", bundle.display());
            return Err(config_error(scene.fault(&key, why).to_string()));
        }
        ensure_bundle(bundle, config, with)?;
        if let (GroupMotion::Patches, (Some(world), Some(file))) = (group.motion, scene.world_of(g)) {
            let source = WorldSource { bundle: bundle.to_path_buf(), ..WorldSource::load(file)? };
            let tables = Bundle::open(bundle).map_err(|e| BuildError::Format(format!("{}: {e}", bundle.display())))?;
            ensure_world(&source, file, &tables, world, with)?;
        }
    }
    Ok(())
}

/// True if no bundle and no world of a scene is missing.
pub fn is_complete(scene: &Scene) -> bool {
    (0..scene.groups.len()).filter(|&g| scene.groups[g].motion != GroupMotion::None).all(|g| {
        let world = scene.world_of(g).0.filter(|_| scene.groups[g].motion == GroupMotion::Patches);
        scene.bundle_of(g).0.into_iter().chain(world).all(Path::exists)
    })
}

/// Builds a bundle if it is missing.
///
/// # Errors
/// As [`ensure_scene`].
pub fn ensure_bundle(bundle: &Path, config: Option<&Path>, with: &BuildContext<'_>) -> Result<()> {
    if bundle.exists() {
        return Ok(());
    }
    let name = bundle.display();
    let Some(config) = config else { return Err(config_error(format!("{name}: there is no such bundle; {WAY_OUT}"))) };
    (with.report_news)(News::Making(format!("{name} is not there: building it from {}", config.display())));
    let report = BuildConfig::load(config).and_then(|c| pipeline::build(&c, bundle, with.cache, with.progress));
    let report = report.map_err(|e| e.in_file(config)).map_err(|e| {
        config_error(format!("{name} is missing, and building it from {} failed: {e}", config.display()))
    })?;
    News::from_report(&report).for_each(with.report_news);
    Ok(())
}

/// Builds a bundle of everything that the motion of a config allows into the cache, unless it is there.
///
/// - `config`: as [`BuildConfig::of_motion`] gives it.
/// - `otherwise`: file of the bundle if the cache keeps nothing.
/// - returns the bundle.
///
/// # Errors
/// As [`pipeline::build_possible`].
pub fn ensure_motion(config: &BuildConfig, otherwise: &Path, with: &BuildContext<'_>) -> Result<PathBuf> {
    with.progress.enter_stage("hash");
    let kept = pipeline::kept_bundle(config, with.cache)?;
    if let Some(bundle) = kept.iter().find(|b| b.is_file()) {
        match Bundle::open(bundle) {
            Ok(_) => {
                let not_made = with.cache.load::<Vec<(String, String)>>("not_made", not_made_key(bundle)?);
                let news = not_made.into_iter().flatten().map(|(part, why)| News::NotMade(part, why));
                news.for_each(with.report_news);
                return Ok(bundle.clone());
            }
            Err(e) => (with.report_news)(News::Making(format!("{e}"))),
        }
        // A build only replaces bundles, and a damaged file may not look like one.
        _ = std::fs::remove_file(bundle);
    }
    let bundle = kept.clone().unwrap_or_else(|| otherwise.to_path_buf());
    if let Some(folder) = bundle.parent() {
        std::fs::create_dir_all(folder).map_err(|source| BuildError::Io { path: folder.to_path_buf(), source })?;
    }
    (with.report_news)(News::Making(format!("building {}", config.name)));
    let report = pipeline::build_possible(config, &bundle, with.cache, with.progress)?;
    News::from_report(&report).for_each(with.report_news);
    // The next run, which finds the bundle, says it again.
    let not_made: Vec<(String, String)> = report.not_made.iter().map(|n| (n.part.clone(), n.why.clone())).collect();
    with.cache.store("not_made", not_made_key(&bundle)?, &not_made, &mut Warnings::default());
    if pipeline::kept_bundle(config, with.cache)? != kept {
        // The files changed during the build: this bundle does not belong to the hash in its name.
        _ = std::fs::remove_file(&bundle);
        return Err(ImportError::Changed { path: config.inputs.first().cloned().unwrap_or_default() }.into());
    }
    Ok(bundle)
}

/// Scene of people on random paths, for a bundle whose blend spaces are all that it can play.
///
/// # Errors
/// [`BuildError::Config`] if the bundle has no blend space.
pub fn blend_scene(tables: &Bundle, file: &Path) -> Result<Scene> {
    let wrong = |e: throng_core::Error| config_error(e.to_string());
    let names = &tables.blends().names;
    let first = tables.blend(names.first().map_or("", String::as_str)).map_err(wrong)?;
    let range = |kind| first.axis_of(kind).map(|k| first.axes()[k]);
    let (speed, turn) = (range(axis::SPEED), range(axis::GYRATION));
    let speeds = speed.map_or([0.0, 1.0], |a| [a.low.max(0.0), a.high.max(0.1)]);
    let file = file.canonicalize().map_err(|source| BuildError::Io { path: file.to_path_buf(), source })?;
    let text = format!(
        "bundle = {:?}\n[[groups]]\nmotion = 'blend'\ncount = 100\nspaces = {names:?}\n\
         paths = {{ speeds = {speeds:?}, max_gyration = {:?} }}\n",
        file.to_string_lossy(),
        turn.map_or(0.5, |a| a.high.max(0.1)),
    );
    Scene::parse(&text, Path::new(&tables.meta().name)).map_err(wrong)
}

/// Key of the parts that a build could not make.
fn not_made_key(bundle: &Path) -> Result<CacheKey> {
    CacheKey::for_stage("not_made", &[], &bundle.file_name().map(|n| n.to_string_lossy().into_owned()))
}

/// True for a folder or an archive of motion, which is built before it is run or viewed.
pub fn is_motion(path: &Path) -> bool {
    path.is_dir() || (path.is_file() && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("zip")))
}

/// Name of a database of some motion: that of the first folder, archive or file.
pub fn motion_name(inputs: &[PathBuf]) -> String {
    let has_star = |p: &&Path| p.to_string_lossy().contains('*');
    let Some(first) = inputs.first() else { return "motion".into() };
    let first = first.ancestors().find(|p| !has_star(p)).unwrap_or(Path::new("."));
    let real = first.canonicalize().unwrap_or_else(|_| first.to_path_buf());
    let name = if real.is_dir() { real.file_name() } else { real.file_stem() };
    name.map_or_else(|| "motion".into(), |n| n.to_string_lossy().into_owned())
}

/// Stitches a world if it is missing, or was made with another bundle or an older version of its world file.
///
/// - returns the report of stitching, if it was necessary.
///
/// # Errors
/// As [`ensure_scene`]; as [`stitch::check_replaced`] if the file holds the world of another world file.
pub fn ensure_world(
    source: &WorldSource,
    file: &Path,
    tables: &Bundle,
    out: &Path,
    with: &BuildContext<'_>,
) -> Result<Option<StitchReport>> {
    let kit = StitchKit::new(tables, &source.bundle)?;
    let hash = source.hash(&kit.library(tables), file)?;
    if World::open(out, tables).is_ok_and(|world| world.meta().source_hash == hash) {
        return Ok(None);
    }
    stitch::check_replaced(file, out)?;
    (with.report_news)(News::Making(format!("stitching {}", source.name)));
    let (mut world, mut report) = stitch::stitch_source(source, file, tables, &kit, with.progress)?;
    report.world_bytes = stitch::save(&mut world, file, tables.patches(), out)?;
    Ok(Some(report))
}
