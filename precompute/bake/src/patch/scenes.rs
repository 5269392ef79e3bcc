//! Clips in the environments they were captured in.

use super::{CaptureSetting, PatchConfig};
use crate::environment::{
    Environment, EnvironmentFile, GeometryTouchConfig, PlacedGeometry, UnitGeometry, UnitMembership, UnitSet,
    annotate_in, geometries,
};
use rayon::prelude::*;
use std::{path::Path, sync::Arc};
use throng_core::Contacts;
use throng_motion::{BuildError, Clip, ClipSet, Result, annotate::ContactConfig, mirror};

/// Most names of clips in a message.
const MAX_LISTED: usize = 12;

/// Environments of a build, with the clips captured in them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceScenes {
    /// The environments, in the order of the config.
    pub scenes: Vec<PlacedGeometry>,
    /// Number of the environment of every clip; `None` for mirrored copies (num_clips).
    pub of_clip: Vec<Option<usize>>,
    /// Geometry of every unit of the set.
    pub geometries: Vec<Arc<UnitGeometry>>,
}

/// Loads the environments of a config.
///
/// # Errors
/// [`BuildError::Io`] and [`BuildError::Config`] as [`EnvironmentFile::load`], [`EnvironmentFile::expand`] and
/// [`geometries`]; for a pattern without matching clips, with the existing ones; for a clip in two environments; for an
/// environment of another unit file.
pub fn scenes(clips: &[Clip], cfg: &PatchConfig, units: &UnitSet) -> Result<SourceScenes> {
    cfg.touch.check().map_err(|e| e.within_key("patches.touch"))?;
    let geometries = match &cfg.units {
        Some(file) => geometries(units).map_err(|e| e.in_file(file))?,
        None => geometries(units)?,
    };
    let mut of_clip = vec![None; clips.len()];
    let mut scenes = Vec::with_capacity(cfg.environments.len());
    for (number, source) in cfg.environments.iter().enumerate() {
        let file = EnvironmentFile::load(&source.file)?;
        check_units(&file, &source.file, cfg)?;
        scenes.push(PlacedGeometry::new(&file.expand(units, &source.file)?, &geometries));
        for pattern in &source.clips {
            let key = format!("patches.environments[{number}].clips");
            for clip in clips_matching(clips, pattern, &key)? {
                if of_clip[clip].replace(number).is_some_and(|n| n != number) {
                    let name = &clips[clip].name;
                    let why = format!("clip `{name}` is in another environment too; leave it out of one of them");
                    return Err(BuildError::key(key, why));
                }
            }
        }
    }
    Ok(SourceScenes { scenes, of_clip, geometries })
}

/// Finds contacts and supports of the clips that were captured in the environments of a config.
///
/// Mirrored copies of such clips get the contacts of their originals, sides exchanged, and their supports.
///
/// # Errors
/// As [`scenes`].
pub fn embed(clips: &mut ClipSet, cfg: &PatchConfig, units: &UnitSet, contact: &ContactConfig) -> Result<SourceScenes> {
    let found = scenes(&clips.clips, cfg, units)?;
    let skeleton = clips.skeleton.clone();
    clips.clips.par_iter_mut().zip(&found.of_clip).for_each(|(clip, scene)| {
        if let Some(s) = scene {
            annotate_in(clip, &skeleton, &found.scenes[*s], contact, &cfg.touch);
        }
    });
    mirror_contacts(&mut clips.clips, &found.of_clip);
    Ok(found)
}

impl SourceScenes {
    /// For every clip in an environment, the environment and which of its units each frame belongs to.
    /// (clips.clips.len())
    ///
    /// - `clips`: with the contacts that [`embed`] found.
    pub fn settings(&self, clips: &ClipSet, touch: &GeometryTouchConfig) -> Vec<Option<CaptureSetting>> {
        let belongs = UnitMembership::new(&clips.skeleton, touch);
        let units_of = |clip: &Clip, scene: &PlacedGeometry, f: usize| {
            let transforms = clip.joint_transforms(&clips.skeleton, f);
            belongs.units_of(&transforms, clip.contacts[f], scene).into_iter().map(|u| u as u32).collect()
        };
        let of_clip = |(clip, scene): (&Clip, &Option<usize>)| {
            let scene = &self.scenes[(*scene)?];
            let environment = Environment { name: scene.name.clone(), units: scene.units.clone() };
            let frames = 0..clip.num_frames();
            Some(CaptureSetting { environment, units_of: frames.map(|f| units_of(clip, scene, f)).collect() })
        };
        clips.clips.par_iter().zip(&self.of_clip).map(of_clip).collect()
    }
}

/// Unit numbers of an environment refer to its own file, which must be the build's.
fn check_units(file: &EnvironmentFile, path: &Path, cfg: &PatchConfig) -> Result<()> {
    let whole = |p: &Path| p.canonicalize().unwrap_or_else(|_| p.to_path_buf());
    match &cfg.units {
        Some(units) if whole(units) != whole(&file.units) => {
            let (theirs, ours) = (file.units.display(), units.display());
            let why = format!("expected the build's own file {ours}, found {theirs}; use one file for both");
            Err(BuildError::key("units", why).in_file(path))
        }
        _ => Ok(()),
    }
}

/// Indices of the clips that match a pattern, except mirrored copies.
///
/// # Errors
/// [`BuildError::Key`] for more than one `*`, and where no clip matches.
fn clips_matching(clips: &[Clip], pattern: &str, key: &str) -> Result<Vec<usize>> {
    let fail = |why: String| Err(BuildError::key(key, why));
    if pattern.matches('*').count() > 1 {
        return fail(format!("expected at most one `*` in a pattern, found `{pattern}`"));
    }
    let fits = |name: &str| match pattern.split_once('*') {
        None => name == pattern,
        Some((head, tail)) => name.len() >= head.len() + tail.len() && name.starts_with(head) && name.ends_with(tail),
    };
    let found: Vec<usize> = (0..clips.len()).filter(|&i| !clips[i].mirrored && fits(&clips[i].name)).collect();
    if found.is_empty() {
        let names: Vec<&str> = clips.iter().filter(|c| !c.mirrored).map(|c| c.name.as_str()).collect();
        let more = names.len().saturating_sub(MAX_LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let listed = names[..names.len().min(MAX_LISTED)].join(", ");
        return fail(format!("no clip matches `{pattern}`; the build has {listed}{more}"));
    }
    Ok(found)
}

fn mirror_contacts(clips: &mut [Clip], of_clip: &[Option<usize>]) {
    for i in 1..clips.len() {
        let (before, rest) = clips.split_at_mut(i);
        let (original, clip) = (&before[i - 1], &mut rest[0]);
        if clip.mirrored && of_clip[i - 1].is_some() && clip.name == format!("{}{}", original.name, mirror::SUFFIX) {
            clip.contacts = original.contacts.iter().copied().map(Contacts::mirrored).collect();
            clip.support = original.support.clone();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::SourceEnvironment;
    use glam::{Quat, Vec3};
    use std::path::PathBuf;
    use throng_core::{NUM_JOINTS, Skeleton};
    use throng_motion::clip::Clip;

    /// A clip that stands at the origin, `up` above the ground.
    fn standing(name: &str, up: f32) -> Clip {
        let frames = 30;
        Clip {
            contacts: vec![Contacts(1); frames],
            ..Clip::new(
                name,
                30.0,
                vec![Skeleton::default().offsets[0] + Vec3::Y * up; frames],
                vec![Quat::IDENTITY; frames * NUM_JOINTS],
            )
        }
    }

    fn clips() -> ClipSet {
        let deck = standing("deck_01", 0.5);
        let copy = mirror::mirror_clip(&deck);
        ClipSet { skeleton: Skeleton::default(), clips: vec![deck, copy, standing("walk", 0.0)] }
    }

    /// Writes a unit file and an environment file; returns the folder and a config that names both.
    fn files(patterns: &[&str]) -> (tempfile::TempDir, PatchConfig, UnitSet) {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let units = "[[units]]\nname = \"deck\"\nshapes = [{ box = { at = [0.0, 0.25, 0.0], size = [2.0, 0.5, 2.0] } \
                     }]\n";
        std::fs::write(path("units.toml"), units).unwrap();
        let place = "units = \"units.toml\"\nplace = [{ unit = \"deck\", at = [0.0, 0.0, 0.0] }]\n";
        std::fs::write(path("yard.toml"), place).unwrap();
        let clips = patterns.iter().map(|p| p.to_string()).collect();
        let cfg = PatchConfig {
            units: Some(path("units.toml")),
            environments: vec![SourceEnvironment { file: path("yard.toml"), clips }],
            ..PatchConfig::default()
        };
        let set = UnitSet::load(&path("units.toml")).unwrap();
        (folder, cfg, set)
    }

    fn run(clips: &mut ClipSet, cfg: &PatchConfig, units: &UnitSet) -> Result<SourceScenes> {
        embed(clips, cfg, units, &ContactConfig::default())
    }

    #[test]
    fn clips_of_an_environment_stand_on_it_and_others_are_left_as_they_were() {
        let (_folder, cfg, units) = files(&["deck_*"]);
        let mut set = clips();
        let scenes = run(&mut set, &cfg, &units).unwrap();
        assert_eq!(scenes.of_clip, [Some(0), None, None]);
        assert_eq!(scenes.scenes[0].name, "yard");
        for clip in &set.clips[..2] {
            assert!(clip.support.iter().all(|s| (s - 0.5).abs() < 1e-4), "{}", clip.name);
            assert!(clip.contacts.iter().all(|c| *c == Contacts(15)), "{}", clip.name);
        }
        assert_eq!(set.clips[2], clips().clips[2]);
    }

    #[test]
    fn patterns_that_match_nothing_list_the_clips() {
        let fault = |patterns: &[&str]| {
            let (_folder, cfg, units) = files(patterns);
            run(&mut clips(), &cfg, &units).unwrap_err().to_string()
        };
        let e = fault(&["ladder*"]);
        assert!(e.ends_with("clips: no clip matches `ladder*`; the build has deck_01, walk"), "{e}");
        assert!(fault(&["*mirror"]).contains("no clip matches"), "mirrored copies do not count");
        assert!(fault(&["*a*"]).contains("expected at most one `*`"));
    }

    #[test]
    fn a_clip_has_one_environment_and_an_environment_the_units_of_the_build() {
        let (folder, mut cfg, units) = files(&["*"]);
        cfg.environments.push(SourceEnvironment { clips: vec!["walk".into()], ..cfg.environments[0].clone() });
        let e = run(&mut clips(), &cfg, &units).unwrap_err().to_string();
        assert!(e.contains("environments[1].clips: clip `walk` is in another environment too"), "{e}");
        let (_folder, mut cfg, units) = files(&["*"]);
        cfg.units = Some(folder.path().join("units.toml"));
        let e = run(&mut clips(), &cfg, &units).unwrap_err().to_string();
        assert!(e.contains("units: expected the build's own file"), "{e}");
        cfg.environments[0].file = PathBuf::from("no-such.toml");
        assert!(run(&mut clips(), &cfg, &units).unwrap_err().to_string().contains("no-such.toml"));
    }
}
